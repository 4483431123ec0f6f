"""How far a run of the reduced model is from finite elements: the same scene's first stretch on its mesh."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fem.errors import UsageError
from fem.quantities import moving_quantities
from fem.solver.error_estimate import NEEDED, Estimate, SecondRun
from fem.solver.finite_elements import make_plan as element_plan
from fem.solver.solver import Plan, Progress

STRETCH_MS = 10.0  # finite elements of 1 mm take a second for it


@dataclass(frozen=True, kw_only=True)
class ReducedEstimate(SecondRun):
    """The same scene's first stretch by finite elements."""

    @property
    def title(self) -> str:
        end = self.coarse.scene.numerics.duration_ms
        return (
            f"The first {end:g} ms against finite elements of {1e3 * self.mesh_size:g} mm; these err as well: see "
            "--model fem --estimate-error"
        )

    def find(
        self,
        samples: dict[str, np.ndarray],
        report: Callable[[Progress], None] = lambda progress: None,
        stop: Callable[[], bool] = lambda: False,
    ) -> list[Estimate]:
        """Run the finite elements and compare, unless stopped; `samples` of the finished run, by the file's names.

        Errors
        ------
        RunFailed: the finite elements went wrong.
        """
        record = self.record(report, stop)
        if record is None:
            return []
        own = {name: samples[name][: len(record["time"])] for name in NEEDED}
        pairs = zip(moving_quantities(own), moving_quantities(record), strict=True)
        return [
            Estimate(quantity=mine, coarse_value=other.value, error=abs(mine.value - other.value))
            for mine, other in pairs
        ]


def reduced_estimate(plan: Plan) -> ReducedEstimate:
    """What to run beside a plan of the reduced model. UsageError: it has one sample; finite elements can't take it."""
    numerics = plan.scene.numerics
    if plan.n_samples < 2:
        raise UsageError(
            "--estimate-error: a standing bearing of the reduced model is the exact series itself; leave it out"
        )
    shorter = numerics.model_copy(update={"duration_ms": min(STRETCH_MS, numerics.duration_ms)})
    return ReducedEstimate(coarse=element_plan(plan.scene.model_copy(update={"model": "fem", "numerics": shorter})))
