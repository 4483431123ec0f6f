"""How far a run is from exact elasticity: a coarser mesh, three meshes at rest, the other models."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from fem.quantities import Quantity, moving_quantities
from fem.solver.elements.plan import ElementPlan
from fem.solver.limits import mesh_nodes
from fem.solver.simulate import SOLVERS, make_plan, run
from fem.solver.solver import Plan, Progress, Samples
from fem.statics.contact_balance import NotFound
from fem.statics.equilibrium import static_quantities
from fem.statics.exact_statics import LEAST_LOAD, exact_statics
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import UsageError
from lagrange.mounting import HELD
from lagrange.scene.run import COMPARISONS
from lagrange.scene.scene import Scene, SceneError
from meshes.bearing import bearing_shapes

COARSER = 2.0  # mesh size over the scene's
LEAST_COARSER = 1.6  # below, rounding to whole layers of nodes may leave the same mesh
ORDER = 2.0  # of every quantity in the mesh size, the step with it: docs/convergence.md
SAFETY = 1.25  # Roache's factor where the order is known: tests.convergence observes it
NEEDED = ("time", "inner_x", "inner_y", "inner_force", "roller_theta")


class Estimate(NamedTuple):
    """A quantity on the scene's mesh and on the coarser one, and the error of the first."""

    quantity: Quantity
    coarse_value: float
    error: float  # in the quantity's unit, >= 0

    @property
    def relative(self) -> float:
        """Error over value; infinite where the value is 0."""
        return self.error / abs(self.quantity.value) if self.quantity.value else float("inf")


def _refuse_comparisons(scene, option):
    if scene.contact.model in COMPARISONS:
        raise UsageError(
            f"{option}: contact.model = '{scene.contact.model}' is there for comparison only and has no order of "
            "convergence; leave one of them out"
        )


def coarser_scene(scene: Scene) -> Scene:
    """The scene on the mesh to compare with.

    UsageError: the scene's mesh is too coarse for that, or its contact model converges to nothing.
    """
    _refuse_comparisons(scene, "--estimate-error")
    size, coarsest = scene.numerics.mesh_size_mm, pi * scene.bearing.roller_diameter_mm / 10.0
    coarser = min(COARSER * size, coarsest)
    if coarser < LEAST_COARSER * size:
        raise UsageError(
            f"--estimate-error compares with a coarser mesh, and numerics.mesh_size_mm = {size:g} leaves none; at most "
            f"{coarsest / LEAST_COARSER:.3g}"
        )
    return scene.varied({"numerics.mesh_size_mm": coarser})


def estimates(fine: list[Quantity], coarse: list[Quantity], ratio: float | None) -> list[Estimate]:
    """Error of each quantity by Richardson's extrapolation, with Roache's factor of safety; None: the difference.

    Source: Roache, Perspective: a method for uniform reporting of grid refinement studies (J. Fluids Eng. 116, 1994).
    """
    share = 1.0 if ratio is None else SAFETY / (ratio**ORDER - 1.0)
    pairs = zip(fine, coarse, strict=True)
    return [Estimate(quantity=f, coarse_value=c.value, error=share * abs(f.value - c.value)) for f, c in pairs]


@dataclass(frozen=True, kw_only=True)
class ErrorEstimate:
    """Finite elements to be run beside a finished run."""

    title: str
    coarse: ElementPlan
    fine: ElementPlan | None = None  # on the finished run's mesh; None: that was of the reduced model

    mesh_size = property(lambda self: 1e-3 * self.coarse.scene.numerics.mesh_size_mm)  # Of the second run, m

    def find(
        self, samples: dict[str, np.ndarray], report: Callable[[Progress], None] = lambda progress: None,
        stop: Callable[[], bool] = lambda: False,
    ) -> list[Estimate]:  # fmt: skip
        """Run the coarse plan and compare, unless stopped; the finished run's `samples` by names in files, NEEDED.

        RunFailed: the coarse run went wrong. NotFound: no equilibrium at rest.
        """
        fine, coarse, ratio = [], [], None
        if self.fine is not None:
            plans = self.fine, self.coarse
            fine, coarse = (static_quantities(plan.model, plan.operation, plan.resting) for plan in plans)
            spacing, wide = (plan.model.roller.shape.surface_spacing for plan in plans)
            ratio = wide / spacing
        if self.coarse.n_samples > 1:
            blocks: list[Samples] = []
            run(self.coarse, blocks.append, report, stop)
            if stop():
                return []
            record = Samples.joined(blocks).values
            fine += moving_quantities({name: samples[name][: len(record["time"])] for name in NEEDED})
            coarse += moving_quantities(record)
        return estimates(fine, coarse, ratio)


STRETCH_MS = 10.0  # finite elements of 1 mm take a second for it


def error_estimate(plan: Plan) -> ErrorEstimate:
    """What to run beside a plan: a coarser mesh, or finite elements for the reduced model's first stretch.

    UsageError: the model, or the scene's mesh, has none; one sample; finite elements can't take it.
    """
    scene, numerics = plan.scene, plan.scene.numerics
    if scene.model == "fem":
        coarse = make_plan(coarser_scene(scene))
        title = f"Discretisation error, estimated with a mesh of {coarse.scene.numerics.mesh_size_mm:g} mm"
        return ErrorEstimate(title=title, coarse=coarse, fine=plan)
    if scene.model != "reduced":
        raise UsageError(f"--estimate-error: the {plan.model_name} has no mesh; leave it out")
    if plan.n_samples < 2:
        raise UsageError(
            "--estimate-error: a standing bearing of the reduced model is the exact series itself; leave it out"
        )
    end = min(STRETCH_MS, numerics.duration_ms)
    shorter = numerics.model_copy(update={"duration_ms": end})
    title = (
        f"The first {end:g} ms against finite elements of {numerics.mesh_size_mm:g} mm; these err as well: see "
        "--model fem --estimate-error"
    )
    coarse = make_plan(scene.model_copy(update={"model": "fem", "numerics": shorter}))
    return ErrorEstimate(title=title, coarse=coarse)


MESHES = 2.0, sqrt(2.0), 1.0  # mesh sizes over the finest


class Mesh(NamedTuple):
    """The bearing at rest on one mesh."""

    size: float  # mm, between surface nodes
    nodes: int
    quantities: tuple[Quantity, ...]


class MeshTable(NamedTuple):
    """Meshes from coarse to fine."""

    meshes: tuple[Mesh, ...]
    exact: tuple[float | None, ...]  # by the quantities, of the series, rollers without weight; None: they do not hold

    @property
    def extrapolated(self) -> tuple[float, ...]:
        """f = f_fine + (f_fine − f_coarse)/(r² − 1), r the mesh sizes' ratio, by the quantities.

        Source: Roache, Perspective: a method for uniform reporting of grid refinement studies (1994); order 2.
        """
        coarse, fine = self.meshes[0], self.meshes[-1]
        grown, pairs = (coarse.size / fine.size) ** ORDER - 1.0, zip(coarse.quantities, fine.quantities, strict=True)
        return tuple(f.value + (f.value - c.value) / grown for c, f in pairs)


def mesh_table(scene: Scene) -> MeshTable:
    """Hub, largest roller load and Hertz pressure at rest, on the scene's mesh and two others.

    The scene's mesh is the finest; where meshes twice as coarse are too coarse for the rollers it is the coarsest.

    UsageError: balls, a contact model without an order of convergence, or no equilibrium.
    """
    _refuse_comparisons(scene, "--converge")
    if scene.axial is not None:
        raise UsageError("--converge: compares plane sections at rest; leave [axial] out")
    size = scene.numerics.mesh_size_mm
    finest = size if MESHES[0] * size <= 0.1 * pi * scene.bearing.roller_diameter_mm else size / MESHES[0]
    bearing, operation, meshes = scene.perfect_bearing(), scene.ideal_operation(), []
    pair = contact_pairs(bearing)[0]
    for each in (finest * factor for factor in MESHES):
        plan = make_plan(scene.varied({"model": "fem", "numerics.mesh_size_mm": each}))
        found = {quantity.name: quantity for quantity in static_quantities(plan.model, operation)}
        force = found["static_largest_force"]
        pressure = Quantity("static_peak_pressure", "Pa", "largest Hertz pressure, inner raceway, at rest",
                            pair.peak_pressure(force.value))  # fmt: skip
        meshes.append(Mesh(size=each, nodes=plan.mesh_nodes, quantities=(found["static_hub_y"], force, pressure)))
    rigid = any(material.rigid for material in (bearing.roller, bearing.inner_ring, bearing.outer_ring))
    if scene.has_faults or rigid or operation.mounting != HELD or operation.side_load or scene.lubricant is not None:
        return MeshTable(meshes=tuple(meshes), exact=(None, None, None))
    load = float(operation.radial_load) + operation.inner_mass * operation.gravity
    still = exact_statics(bearing, load, operation.first_roller_angle)
    exact = float(still.hub[1]), float(still.inner_force.max()), pair.peak_pressure(float(still.inner_force.max()))
    return MeshTable(meshes=tuple(meshes), exact=exact)


MOST_COMPARED = 100_000  # nodes of meshes that are made only to compare models with: some seconds


class Choice(NamedTuple):
    """A model for a scene."""

    model: str  # the scene's name of it
    lacks: str  # what it leaves out, or why it can't take the scene
    seconds: float | None = None  # to expect of the time loop; None: it can't take the scene
    hub_error: float | None = None  # of the hub's static displacement, relative; None: no load, or no exact answer


def model_choices(plan: Plan) -> list[Choice]:
    """Every model for the scene of a plan; finite elements on the scene's mesh."""
    scene, exact, found = plan.scene, None, []
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    if scene.bearing.type != "ball" and operation.radial_load >= LEAST_LOAD:
        with suppress(NotFound):
            exact = exact_statics(bearing, operation.radial_load, operation.first_roller_angle).hub
    for name in SOLVERS:
        try:
            other = scene if scene.model == name else scene.varied({"model": name})
            size = 1e-3 * scene.numerics.mesh_size_mm
            nodes = 0 if other is scene or name != "fem" else mesh_nodes(bearing, size, bearing_shapes)
            if nodes > MOST_COMPARED:
                raise UsageError(f"{nodes:,} nodes, too many only to compare with; --model fem plans it")
            mine = plan if other is scene else make_plan(other)
            error = None if exact is None else float(np.linalg.norm(mine.static_hub() - exact) / np.linalg.norm(exact))
            found.append(Choice(model=name, lacks=mine.lacks, seconds=mine.expected_seconds, hub_error=error))
        except (SceneError, UsageError, RuntimeError) as refused:
            found.append(Choice(model=name, lacks=f"not for this scene: {refused}"))
    return found


def suggestion(choices: list[Choice]) -> str | None:
    """What to begin with; None where there is no choice."""
    able = {each.model: each for each in choices if each.seconds is not None}
    if len(able) < 2:
        return None
    if "reduced" not in able:
        return 'model = "fem" for elastic bodies, "lagrange" for a quick look' if "fem" in able else None
    later = '; if it warns about elastic waves, use "fem"' if "fem" in able else "; it warns about elastic waves"
    return f'start with "reduced"{later}'
