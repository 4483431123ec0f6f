"""Plans whose time loop is compiled: loading it, what to tell while that takes long, what its bits depend on."""

import gc
from collections.abc import Callable
from importlib.metadata import version

from fem.kernels import kernel_folder
from fem.solver.processor import processor
from fem.solver.solver import Plan
from lagrange.messages import said_if_long

PATIENCE = 3.0  # s, to load the time loop; if it takes longer it is being compiled
COMPILING = "compiling the time loop, once for such bodies and contacts: "


class CompiledPlan(Plan):
    """A plan whose first state has `take_steps(count)`."""

    compiling_takes = "half a minute, or one on a slow processor"
    finer = "lower numerics.time_step_safety or numerics.mesh_size_mm"  # what keeps the energy better

    @property
    def pressed_energy(self) -> float:
        """What a press fit stores, J, and no motion can take out again."""
        return 0.0

    def prepare(self, tell: Callable[[str], None] | None = None) -> None:
        """Compile the time loop, or load it compiled, without taking a step."""
        collecting = gc.isenabled()
        gc.disable()  # a compiler's many objects are nearly all kept: looking for cycles takes a tenth of its time
        try:
            with said_if_long(PATIENCE, COMPILING + self.compiling_takes, tell):
                self.first_state().take_steps(0)
        finally:
            if collecting:
                gc.enable()

    @property
    def remarks(self) -> tuple[str, ...]:
        return tuple(kernel_folder.remarks)

    def versions(self) -> dict[str, str]:
        return {"kernels": kernel_folder.version(), "numba": version("numba"), **processor()}
