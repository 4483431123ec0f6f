"""Plans whose time loop is compiled: loading it, what to tell while that takes long, what its bits depend on."""

import gc
import hashlib
import os
import time
from collections.abc import Callable
from importlib.metadata import version

from fem.kernels import kernel_folder
from fem.solver.pace import in_words, pace, remember
from fem.solver.solver import Plan, RunState
from lagrange.messages import said_if_long


def processor() -> dict[str, str]:
    """Its name and what it can do, as the compiler knows them, or as numba's settings have it."""
    from llvmlite import binding  # without numba, which a run of the Lagrangian model does not need

    name = os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES")
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    return {"processor": name, "instructions": hashlib.sha256(features.encode()).hexdigest()[:8]}


PATIENCE = 3.0  # s, to load the time loop; if it takes longer it is being compiled
COMPILING = "compiling the time loop, once for such bodies and contacts: "


class CompiledPlan(Plan):
    """A plan whose first state has `take_steps(count)`."""

    compiling_seconds = 30.0  # of one core of a server, before what this machine takes is known
    finer = "lower numerics.time_step_safety or numerics.mesh_size_mm"  # what keeps the energy better

    @property
    def pressed_energy(self) -> float:
        """What a press fit stores, J, and no motion can take out again."""
        return 0.0

    @property
    def compiling(self) -> str:
        """How long the compiler will take, in words."""
        key = self._compiling_key
        return in_words(key, self.compiling_seconds * pace(key))

    @property
    def _compiling_key(self) -> str:
        return f"compiling {self.scene.model}"

    def prepare(self, tell: Callable[[str], None] | None = None) -> RunState:
        """Compile the time loop, or load it compiled, without taking a step."""
        from numba.core.event import install_recorder

        collecting, began = gc.isenabled(), time.process_time()
        gc.disable()  # a compiler's many objects are nearly all kept: looking for cycles takes a tenth of its time
        try:
            long = "" if tell is None else COMPILING + self.compiling
            with said_if_long(PATIENCE, long, tell), install_recorder("numba:compile") as new:
                state = self.first_state()
                state.take_steps(0)
        finally:
            if collecting:
                gc.enable()
        took, key = time.process_time() - began, self._compiling_key
        if new.buffer and took > PATIENCE:
            remember(key, self.compiling_seconds * pace(key), took)
        return state

    @property
    def notices(self) -> tuple[str, ...]:
        return tuple(kernel_folder.notices)

    def versions(self) -> dict[str, str]:
        return {"kernels": kernel_folder.version(), "numba": version("numba"), **processor()}
