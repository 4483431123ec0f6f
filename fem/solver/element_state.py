"""The finite elements' state: nodes, contacts and hub as the time loop's arrays."""

from typing import TYPE_CHECKING

import numpy as np

from fem.kernels import time_loop
from fem.solver.frames import frame_of
from fem.solver.row_state import RowState

if TYPE_CHECKING:
    from fem.solver.finite_elements import ElementPlan


class ElementState(RowState):
    """The arrays of all elastic bodies."""

    def __init__(self, plan: "ElementPlan"):
        super().__init__(plan)
        self.arrays = plan.arrays()

    def named_arrays(self) -> dict[str, np.ndarray]:
        return self.arrays.named()

    def digest(self) -> str:
        return self.arrays.digest()

    def check(self) -> None:
        self.arrays.check()

    def frame(self):
        return frame_of(self.plan.model, self.arrays, self.done, self.plan.interval)

    def step_rows(self, first: int, stride: int, rows: np.ndarray) -> tuple[int, int, int]:
        arrays = self.arrays
        return time_loop.advance(
            arrays.bodies, arrays.groups, arrays.contacts, arrays.drive, arrays.scratch, first, stride, rows
        )
