"""The reduced model as a solver: rigid bodies, contacts with the compliance of whole elastic bodies.

Elasticity comes from the exact series of rings and rollers, so there is no mesh. Steps are some fifteen times those of
finite elements, which must follow elastic waves, and each takes a small part of one: a run is faster than the bearing.
"""

from dataclasses import dataclass, replace
from math import ceil, pi, sqrt

import numpy as np

from fem.contacts.contact_law import LOAD_MARGIN
from fem.contacts.tilted import rounded_range, too_narrow
from fem.kernels.lanes import WIDTH
from fem.solver import start as starts
from fem.solver.compiling import pace
from fem.solver.limits import check_rollers, check_speed, check_widths, plan_warnings
from fem.solver.parts import cage_seat, critical_with_cage, time_along_a_knot
from fem.solver.rigid.plan import RigidPlan, sections_of
from fem.solver.rigid.state import ReducedState
from fem.solver.row_state import LONGEST_UNWATCHED
from fem.solver.solver import may_strike, sample_count
from fem.statics.exact_statics import ReducedBearing, UnseenWaves, reduced_bearing, tangential_compliance, unseen_waves
from lagrange import Operation
from lagrange.axial.slices import MORE
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import UsageError
from lagrange.kinematics import fastest_kinematics, kinematics, kinematics_met
from lagrange.scene.scene import MODEL_NAMES, Scene
from lagrange.step_size import fastest_in_machine

LEFT = 0.2  # of what a guess was off by, the most that sweeps may leave with its sign turned
STIFFEST = 3.0  # times as stiff as under a LOAD_MARGIN-th of the force; the paper's bearing is 1.2 times


def _softness_below(model, force):
    """Of a roller's two contacts under a force, N; (2, 2), m/N; and the force, which is less where that is beyond
    Hertz and contacts would push one another in."""

    def softness(pressed):
        inner, outer = (float(law.softness(pressed)) for law in model.laws)
        return np.array([[inner, model.across], [model.across, outer]])

    usual = np.linalg.eigvalsh(softness(force / LOAD_MARGIN))[0]
    while np.linalg.eigvalsh(softness(force))[0] < usual / STIFFEST:
        force *= 0.5
    return softness(force), force


def _strongest_coupling(model, force):
    """Largest eigenvalue, >= 0, of what forces along the rings give, over rollers' own softness under a force, N.

    Of all contacts closed; of fewer it is no larger.
    """
    rings, n = model.rings, model.bearing.pockets
    waves = np.cos(2.0 * pi / n * np.multiply.outer(rings.distance, np.arange(n // 2 + 1)))
    along = rings.along @ waves  # (2, orders), every ring's eigenvalues
    stiff = np.linalg.inv(_softness_below(model, force)[0])
    return max(float(np.linalg.eigvals(stiff[:, :, None].T * along.T[:, None, :]).real.max()), 0.0)


def relaxation_factor(coupling: float) -> float:
    """Relaxation factor of the coupled force increments, by their `_strongest_coupling`.

    1, which leaves −λ³ of the predictor's error and diverges from a third on; or, of strong couplings,
    as much as leaves −LEFT, λ²(1 − share (1 + λ)).
    """
    return 1.0 if coupling**3 <= LEFT else (1.0 + LEFT / coupling**2) / (1.0 + coupling)


def critical_time_step(model: ReducedBearing, force: float, tangential: np.ndarray, operation: Operation) -> float:
    """2/ω_max, s, with all contacts closed under a force, N, that stick: of a roller."""
    bearing, (soft, force) = model.bearing, _softness_below(model, force)
    stiff, pushed = np.linalg.inv(soft), np.array([-1.0, 1.0])
    radial = float(pushed @ stiff @ pushed) + 2.0 / float(model.between.softness(force))
    # of a traction the roller's own surface gives way by 3/m, and the other contact's by −1/m
    rocking = 4.0 / float(tangential.min())
    in_machine = fastest_in_machine(bearing, operation, *np.diag(stiff).tolist())
    return 2.0 / sqrt(max(max(radial, rocking) / bearing.roller_mass, in_machine**2))


SHARE = 0.7  # of the critical step, at a safety of 1: beyond, contacts that open and close gain energy
KNOTS_A_STEP = 0.25  # of a profile's spline
SECONDS_PER_LANES = 0.33e-6  # one thread of a 2024 server core; only a guide


@dataclass(frozen=True, kw_only=True)
class ReducedPlan(RigidPlan):
    """A bearing reduced to its contacts, its start and its time steps."""

    model: ReducedBearing
    operation: Operation
    tangential: np.ndarray  # (3,), m/N, of contacts that stick under the largest static force
    relaxation_factor: float  # of coupled force increments
    waves: UnseenWaves
    strikes: bool  # whether bodies may strike each other: then accounts of energy are kept that others need not
    start: starts.ReducedStart
    tables: starts.Tables | None  # of contacts of rollers that tilt; None: axes stay parallel
    largest_force: float  # N, about, of a contact at rest
    seat: np.ndarray  # (2,), m, of a cage's centre at the start, from the outer ring's
    static_energy: float  # J, of contacts that hold the load at rest
    critical_time_step: float  # s
    bearing = property(lambda self: self.model.bearing)
    axial = property(lambda self: self.scene.ideal_axial())
    first_angle = property(lambda self: self.start.angle)
    unwatched = LONGEST_UNWATCHED
    model_name = MODEL_NAMES["reduced"]
    finer = "lower numerics.time_step_safety"
    lacks = "elastic waves, except the energy that impacts lose to them; warns if that matters"

    @property
    def degrees_of_freedom(self):
        """Two of the hub, three of each roller; tilts and two of a hub's free slope."""
        n, axial = self.bearing.n_rollers, self.axial
        return 2 + 3 * n + (0 if axial is None else n + 2 * axial.has_free_slope)

    @property
    def expected_seconds(self):
        return pace("reduced") * SECONDS_PER_LANES * ceil(self.bearing.n_rollers / WIDTH) * self.steps

    def static_hub(self):
        return starts.standing_hub(self.model, self.operation)

    def reaching(self, times: int) -> "ReducedPlan":
        if self.axial is None or times == 1:
            return self
        force = times * self.largest_force
        tables = starts.tables_of(self.bearing, self.operation, self.axial, self.model.laws, force)
        start = starts.tilted_start(self.model, self.operation, self.axial, tables, self.start)
        return replace(self, tables=tables, start=start)

    def too_far(self, times):
        axial, bearing = self.axial, self.bearing
        if axial is None or not axial.coupling:
            return None
        force = MORE * rounded_range(times * self.largest_force, 0.0)[0]
        return too_narrow(bearing, axial, max(pair.half_width(force) for pair in contact_pairs(bearing)[:2]))

    def first_state(self):
        return ReducedState(self)

    def rows(self):
        freedom = {"degrees of freedom": f"{self.degrees_of_freedom}, elastic bodies without mass"}
        of_start = self.time_and_forces(self.start.inner_force, self.start.outer_force)
        return freedom | self.operation.mounting.rows | self.step_rows() | of_start


def make_plan(scene: Scene) -> ReducedPlan:
    """Reduce a bearing to its contacts, solve the start, find the step.

    UsageError: balls, rigid bodies or a contact model that needs a mesh; no equilibrium under the load.
    """
    check_rollers(scene)
    if scene.bodies.rigid:
        raise UsageError(
            f'bodies.{scene.bodies.rigid[0]} = "rigid": the reduced model has elastic bodies only; leave it out, or '
            'use model = "fem"'
        )
    if scene.contact.model != "subgrid":
        raise UsageError(
            f'contact.model = "{scene.contact.model}" is only for meshes, which the reduced model does not have; leave '
            'it out, or use model = "fem"'
        )
    bearing, operation, numerics = scene.ideal_bearing(), scene.ideal_operation(), scene.numerics
    check_speed(bearing, kinematics_met(bearing, operation))
    model = reduced_bearing(bearing, kinematics(bearing, *operation.ring_speeds), operation.gravity)
    fastest, damping, cage = fastest_kinematics(bearing, operation), scene.damping.contacts, scene.ideal_cage()
    loaded = starts.equilibrium_start(model, operation)
    static = float(loaded.forces.max())
    check_widths(bearing, static)
    load = operation.heaviest + operation.inner_mass * operation.gravity
    largest = max(static, 5.0 * load / bearing.n_rollers, 1.0)
    met, tangential = LOAD_MARGIN * largest, tangential_compliance(bearing, largest)
    critical = critical_with_cage(critical_time_step(model, met, tangential, operation), bearing, cage, operation)
    interval = 1e-6 * numerics.output_interval_us
    longest, housing = SHARE * critical, operation.mounting.housing
    if housing is not None and damping.acts:  # on it these act explicitly, after rollers and hub: half of its motion
        coefficient = float(damping.coefficient(met, 1.0 / float(model.outer_law.softness(met))))
        longest = min(longest, 2.0 * (housing.mass + bearing.outer_ring_mass) / (bearing.n_rollers * coefficient))
    longest, on_waves = (
        min(longest, KNOTS_A_STEP * time_along_a_knot(bearing, fastest, spalls)) * numerics.time_step_safety
        for spalls in (True, False)
    )
    steps = max(1, ceil(interval / longest * (1.0 - 1e-12)))
    start = starts.rest_start(model, operation) if numerics.start == "rest" else loaded
    axial, tables = scene.ideal_axial(), None
    if axial is not None:
        starts.check_slices(model, operation, axial, loaded)
        tables = starts.tables_of(bearing, operation, axial, model.laws, largest)
        start = starts.tilted_start(model, operation, axial, tables, start)
    looks = ceil(steps / LONGEST_UNWATCHED)
    stride, sections = looks * ceil(steps / looks), None
    if damping.acts:  # contacts without dampers vibrate on after a strike
        sections = sections_of(bearing, fastest, interval / looks, longest, on_waves)
    if sections is not None:
        stride = looks * sections.count * sections.near
    stored = model.contacts.inner_law.energy(loaded.inner_force).sum()
    stored += model.contacts.outer_law.energy(loaded.outer_force).sum()
    warnings = plan_warnings(scene, model, operation, loaded, interval, start.warning)
    return ReducedPlan(
        scene=scene, model=model, operation=operation, tangential=tangential,
        relaxation_factor=relaxation_factor(_strongest_coupling(model, met)),
        waves=unseen_waves(bearing, operation.inner_mass),
        strikes=scene.cage is not None or may_strike(scene, bearing, operation), start=start, tables=tables,
        largest_force=largest, seat=cage_seat(bearing, cage, start.angle, start.place, float(start.forces.max())),
        static_energy=float(stored), critical_time_step=critical, stride=stride, looks=looks, sections=sections,
        n_samples=sample_count(scene), warnings=warnings,
    )  # fmt: skip
