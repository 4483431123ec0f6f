"""How far a run is from the continuum: the same scene on a mesh half as fine, extrapolated."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np

from fem.errors import UsageError
from fem.quantities import Quantity, moving_quantities
from fem.solver.finite_elements import ElementPlan, make_plan
from fem.solver.finite_elements import make_plan as element_plan
from fem.solver.simulate import run
from fem.solver.solver import Plan, Progress, Samples
from fem.statics.equilibrium import static_quantities
from lagrange.scene.run import COMPARISONS
from lagrange.scene.scene import Scene

COARSER = 2.0  # mesh size over the scene's
LEAST_COARSER = 1.6  # below, rounding to whole layers of nodes may leave the same mesh
ORDER = 2.0  # of every quantity in the mesh size, the step with it: docs/convergence.md
SAFETY = 1.25  # Roache's factor where the order is known: tests.accuracy.convergence observes it
NEEDED = ("time", "inner_x", "inner_y", "inner_force", "roller_theta")


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A quantity on the scene's mesh and on the coarser one, and the error of the first."""

    quantity: Quantity
    coarse_value: float
    error: float  # in the quantity's unit, >= 0

    @property
    def relative(self) -> float:
        """Error over value; infinite where the value is 0."""
        return self.error / abs(self.quantity.value) if self.quantity.value else float("inf")


def coarser_scene(scene: Scene) -> Scene:
    """The scene on the mesh to compare with.

    Errors
    ------
    UsageError: the scene's mesh is too coarse for that, or its contact model converges to nothing.
    """
    if scene.contact.model in COMPARISONS:
        raise UsageError(
            f"--estimate-error: contact.model = '{scene.contact.model}' is there for comparison only and has no order "
            "of convergence; leave one of them out"
        )
    size = scene.numerics.mesh_size_mm
    coarsest = pi * scene.bearing.roller_diameter_mm / 10.0
    coarser = min(COARSER * size, coarsest)
    if coarser < LEAST_COARSER * size:
        raise UsageError(
            f"--estimate-error compares with a coarser mesh, and numerics.mesh_size_mm = {size:g} leaves none; at most "
            f"{coarsest / LEAST_COARSER:.3g}"
        )
    return scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"mesh_size_mm": coarser})})


def estimates(fine: list[Quantity], coarse: list[Quantity], ratio: float) -> list[Estimate]:
    """Error of each quantity by Richardson's extrapolation, with Roache's factor of safety.

    Source: Roache, Perspective: a method for uniform reporting of grid refinement studies (J. Fluids Eng. 116, 1994).
    """
    found = []
    for mine, other in zip(fine, coarse, strict=True):
        error = SAFETY * abs(mine.value - other.value) / (ratio**ORDER - 1.0)
        found.append(Estimate(quantity=mine, coarse_value=other.value, error=error))
    return found


@dataclass(frozen=True, kw_only=True)
class SecondRun:
    """Finite elements to be run beside a finished run."""

    coarse: ElementPlan

    @property
    def mesh_size(self) -> float:
        """Of the second run, m."""
        return 1e-3 * self.coarse.scene.numerics.mesh_size_mm

    def record(self, report: Callable[[Progress], None], stop: Callable[[], bool]) -> dict[str, np.ndarray] | None:
        """Samples of the second run by the result file's names; None if it was stopped.

        Errors
        ------
        RunFailed.
        """
        blocks = []
        run(self.coarse, blocks.append, report, stop)
        return None if stop() else Samples.joined(blocks).values


@dataclass(frozen=True, kw_only=True)
class ErrorEstimate(SecondRun):
    """A plan and the same scene on a coarser mesh."""

    fine: ElementPlan

    @property
    def title(self) -> str:
        return f"Discretisation error, estimated with a mesh of {1e3 * self.mesh_size:g} mm"

    def find(
        self,
        samples: dict[str, np.ndarray],
        report: Callable[[Progress], None] = lambda progress: None,
        stop: Callable[[], bool] = lambda: False,
    ) -> list[Estimate]:
        """Run the coarse plan and compare, unless it is stopped; `samples` of the finished run, by the result file's
        names (NEEDED).

        Errors
        ------
        RunFailed: the coarse run went wrong. NotFound: no equilibrium at rest.
        """
        plans = self.fine, self.coarse
        fine, coarse = (static_quantities(plan.model, plan.operation, plan.resting) for plan in plans)
        if self.fine.n_samples > 1:
            record = self.record(report, stop)
            if record is None:
                return []
            fine += moving_quantities(samples)
            coarse += moving_quantities(record)
        spacing, wide = (plan.model.roller.shape.surface_spacing for plan in plans)
        return estimates(fine, coarse, wide / spacing)


def error_estimate(plan: ElementPlan) -> ErrorEstimate:
    """What to run beside a plan. UsageError: see `coarser_scene`."""
    return ErrorEstimate(fine=plan, coarse=make_plan(coarser_scene(plan.scene)))


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
