"""The finite elements as a solver: discrete model, everything decided before the first step, what --dry-run tells."""

import hashlib
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import import_module
from math import ceil, sqrt

import numpy as np
from rich.table import Table

from fem.contacts import MODELS, ONE_PATCH
from fem.contacts.critical_step import critical_time_step, next_rung
from fem.contacts.model import Model
from fem.elastic.outer_support import BoredRing, LooseRing, SupportedRing, bored_ring, supported_ring
from fem.elastic.reciprocal_mass import LUMPED, SECOND, THIRD, ReciprocalMass
from fem.kernels.elements import loop
from fem.kernels.elements.tilted import SlicedLaw
from fem.solver import limits
from fem.solver import start as starts
from fem.solver.compiling import CompiledPlan, pace
from fem.solver.elements import arrays as elements
from fem.solver.elements.arrays import Arrays, Start
from fem.solver.parts import LESS, beyond_tables, cage_seat, cage_springs, time_along_a_knot
from fem.solver.row_state import LONGEST_UNWATCHED, RowState
from fem.solver.solver import may_strike, sample_count
from fem.statics.contact_balance import NotFound
from fem.statics.equilibrium import Tilting, static_equilibrium, static_error
from fem.statics.exact_statics import LEAST_LOAD, ExpectedForces, kept_contacts, reduced_bearing
from lagrange import Operation
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import kinematics, kinematics_met
from lagrange.scene.scene import MODEL_NAMES, Scene
from meshes import Mesh, quality


def model_of(scene: Scene, expected: ExpectedForces | None = None) -> Model:
    """The discrete model of a scene; `expected`: its forces, where they are needed elsewhere too.

    RuntimeError: gmsh is needed and missing. UsageError: balls, which no plane section describes; the mesh is too
    coarse to resolve the contacts or for a ring, or has too many nodes.
    """
    limits.check_rollers(scene)
    expected = ExpectedForces(scene.ideal_bearing(), scene.ideal_operation()) if expected is None else expected
    bearing, mesh_size = expected.bearing, 1e-3 * scene.numerics.mesh_size_mm
    kind = _contact_model(scene.contact.model, mesh_size, expected)
    limits.check_mesh_size(bearing, mesh_size, kind.shapes)
    limits.check_contact_model(kind, scene, expected)
    limits.check_outer_ring(kind, scene)
    if not kind.has_law:
        largest = expected.largest if kind.is_made_for_a_force else 0.0
        model = kind.build(bearing, mesh_size, largest, scene.contact.penalty_stiffness_N_per_m)
        limits.check_meshes(model)
        return model
    sound = replace(bearing, faults=())
    model, mounting = replace(_built(kind, sound, mesh_size), bearing=bearing), scene.mounting()
    # calibrated held all around: what a mesh lacks at a contact is the same wherever the ring is held
    if mounting.points is not None:
        return replace(model, outer_ring=supported_ring(model.outer_ring, mounting.points))
    if mounting.bore is not None:
        return replace(model, outer_ring=bored_ring(model.outer_ring, mounting.bore, bearing.roller_length))
    return model


@lru_cache(maxsize=1)
def _built(kind, bearing, mesh_size):
    found = kind.build(bearing, mesh_size)
    limits.check_meshes(found)
    return found


def _contact_model(name, mesh_size, expected):
    """The contact model of a scene's name: on a mesh, m, that is fine enough for it."""
    *finer, chosen = MODELS[name]
    pairs = contact_pairs(expected.bearing)[:2]
    # the bound, far above what a roller carries, mostly spares solving the statics
    if finer and all(
        mesh_size < ONE_PATCH * max(pair.half_width(getattr(expected, name)) for pair in pairs)
        for name in ("bound", "largest")
    ):
        chosen = finer[0]
    return getattr(import_module(chosen[0]), chosen[1])


# one thread of a 2024 server core; only a guide, `wall_seconds` of a run is the truth
SECONDS_PER_DOF = {LUMPED: 0.9e-9, SECOND: 1.4e-9, THIRD: 1.9e-9}
SECONDS_PER_ROLLER = 0.35e-6
BYTES_PER_NODE = 20  # of a stored frame: displacement and stress in single precision
LONG = THIRD, SECOND  # which of them is tried first
KNOTS_A_STEP = 0.3  # of a profile's spline: with more, spalls that pass at 40 m/s cost per cents of the energy


class ElementState(RowState):
    """The arrays of all elastic bodies."""

    def begin(self):
        super().begin()
        self.arrays = self.plan.arrays()

    def named_arrays(self):
        return self.arrays.named()

    def digest(self):
        text = hashlib.sha256()
        for name, (array, given) in self.arrays.every().items():
            if given:
                text.update(f"{name} {array.dtype} {array.shape} ".encode() + array.tobytes())
        return text.hexdigest()

    def check(self):
        self.arrays.check()

    def advance(self, most):
        block, pairs = super().advance(most), (pair for group in self.arrays.groups for pair in group)
        laws = [pair.law for pair in pairs if isinstance(getattr(pair, "law", None), SlicedLaw)]
        beyond = beyond_tables(laws[0].axes.tilts, [law.table for law in laws]) if laws else None
        return block if block.trouble or beyond is None else block._replace(trouble=f"{beyond}; {LESS}")

    def frame(self):
        return elements.frame_of(self.plan.model, self.arrays, self.done, self.plan.interval)

    def step_rows(self, first, stride, rows):
        a = self.arrays
        return loop.advance(a.bodies, a.groups, a.contacts, a.drive, a.scratch, first, stride, rows)


@dataclass(frozen=True, kw_only=True)
class ElementPlan(CompiledPlan):
    """A discrete model, its start and its time steps."""

    scene: Scene
    model: Model
    operation: Operation
    start: Start
    tilting: Tilting | None  # None: axes stay parallel
    seat: np.ndarray  # (2,), m, of a cage's centre at the start, from the outer ring's
    critical_time_step: float  # s
    time_step: float  # s
    stride: int  # steps between samples
    n_samples: int
    largest_force: float  # N, static, of any contact
    mass: ReciprocalMass  # of nodes
    frame_stride: int  # samples between stored fields; 0: none
    warnings: tuple[str, ...] = ()

    bearing = property(lambda self: self.model.bearing)
    first_angle = property(lambda self: self.start.angle)
    mesh_nodes = property(lambda self: self.model.n_nodes)
    model_name = MODEL_NAMES["fem"]
    lacks = "waves shorter than the mesh"

    interval = property(lambda self: self.stride * self.time_step)  # Between samples, s

    @property
    def looks(self) -> int:
        """At the energy per sample: as few as leave at most LONGEST_UNWATCHED steps between two."""
        fewest = ceil(self.stride / LONGEST_UNWATCHED)
        return next(looks for looks in range(fewest, self.stride + 1) if self.stride % looks == 0)

    steps = property(lambda self: (self.n_samples - 1) * self.stride)

    @property
    def degrees_of_freedom(self):
        axial, n = self.scene.ideal_axial(), self.bearing.n_rollers
        return self.model.degrees_of_freedom + (0 if axial is None else n + 2 * axial.has_free_slope)

    @property
    def pressed_energy(self):
        ring = self.model.outer_ring
        return ring.pressed_energy if isinstance(ring, BoredRing) else 0.0

    @property
    def expected_seconds(self):
        a_step = SECONDS_PER_DOF[self.mass] * self.model.degrees_of_freedom
        a_step += SECONDS_PER_ROLLER * self.bearing.n_rollers
        return pace("fem") * a_step * self.steps

    def table(self):
        """Size and shape of each body's mesh."""
        table = Table()
        for heading in ("mesh", "nodes", "cells", "edges, mm", "angles, deg"):
            table.add_column(heading, justify="left" if heading == "mesh" else "right")
        for name in ("roller", "inner_ring", "outer_ring"):
            body = getattr(self.model, name)
            q = quality(Mesh(points=body.points, cells=body.cells))
            table.add_row(
                name.replace("_", " ") + (", rigid: only drawn" if body.material.rigid else ""), str(q.nodes),
                str(q.cells), f"{1e3 * q.smallest_edge:.3f} - {1e3 * q.largest_edge:.3f}",
                f"{q.smallest_angle:.0f} - {q.largest_angle:.0f}",
            )  # fmt: skip
        return table

    def rows(self):
        """Steps, memory, the time to expect and the mesh's static error."""
        model, start, ring, intervals = self.model, self.start.equilibrium, self.model.outer_ring, self.n_samples - 1
        slowed = ", with the fastest waves slowed" if self.mass.share else ""
        rows = {
            "degrees of freedom": f"{self.degrees_of_freedom}",
            "time step": f"{1e9 * self.time_step:.2f} ns ({self.time_step / self.critical_time_step:.2f} of the "
            f"critical {1e9 * self.critical_time_step:.2f} ns{slowed})",
            "steps": f"{self.steps} for {1e3 * intervals * self.interval:g} ms",
            "samples": f"{self.n_samples}, one every {self.stride} steps",
        }
        damping = self.scene.damping
        if damping.contacts.acts:
            rows["damping of a contact"] = damping.contacts.words
        if damping.bodies_1_s > 0.0:
            rows["damping of the bodies"] = f"{damping.bodies_1_s:g} 1/s"
        rows |= self.operation.mounting.rows
        if isinstance(ring, SupportedRing):
            rows["points that hold the outer ring"] = ring.words
        if self.frame_stride:  # before compression
            frames, every = 1 + intervals // self.frame_stride, 1e3 * self.frame_stride * self.interval
            size = 1e-6 * frames * model.n_nodes * BYTES_PER_NODE
            rows["fields"] = f"{frames}, one every {every:g} ms, {size:.3g} MB"
        rows["memory of the arrays"] = f"{1e-6 * self.arrays().nbytes:.1f} MB"
        rows |= self.time_and_forces(start.inner_force, start.outer_force)
        if self.operation.radial_load >= LEAST_LOAD and not isinstance(ring, LooseRing):
            hub, force = static_error(model, self.operation)
            rows["static error of the mesh"] = (
                f"hub displacement {100 * hub:.2g} %, loads {100 * force:.2g} % (against exact series)"
            )
        return rows

    def arrays(self) -> Arrays:
        """Fresh arrays at the start."""
        scene, start, operation, bearing = self.scene, self.start, self.operation, self.bearing
        how = self.time_step, scene.friction_coefficient, scene.load_ramp, self.largest_force, self.mass
        arrays = elements.make_arrays(self.model, operation, start, *how)
        arrays = elements.with_damping(arrays, self.model, scene.damping)
        axial, cage = scene.ideal_axial(), scene.ideal_cage()
        if axial is not None and self.tilting is not None and start.tilts is not None:
            tables = tuple(law.table for law in self.tilting.laws)
            arrays = elements.with_axes(arrays, bearing, operation, axial, cage, tables, start)
        return arrays if cage is None else elements.with_cage(arrays, bearing, cage, start, self.seat, operation)

    @property
    def resting(self) -> Tilting | None:
        """What balances rollers that tilt in a bearing that stands; None: axes stay parallel."""
        still = replace(self.operation, speed=0.0, outer_speed=0.0, history=None)
        return None if self.tilting is None else self.tilting.at(still, np.zeros(2))

    def static_hub(self):
        return static_equilibrium(self.model, self.operation).hub

    def first_state(self):
        return ElementState(self)


def make_plan(scene: Scene) -> ElementPlan:
    """Mesh, assemble, calibrate, solve the start, find the critical step.

    The time step is the largest below safety · critical that divides the output interval, and the interval between two
    looks at the energy. On surfaces that pass fast it is as short as the way along them asks for. Where nothing strikes
    and contacts leave enough of it, a reciprocal mass makes it longer.

    RuntimeError: gmsh is needed and missing.
    UsageError: the model can't bear the speed or the load.
    """
    numerics, axial, tilting, cage = scene.numerics, scene.ideal_axial(), None, scene.ideal_cage()
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    if axial is not None and operation.mounting.points is None and operation.mounting.bore is None:
        held = reduced_bearing(bearing, kinematics(bearing, *operation.ring_speeds), operation.gravity)
        starts.check_slices(held, operation, axial, starts.equilibrium_start(held, operation))  # before it is meshed
    forces, fastest = ExpectedForces(bearing, operation), kinematics_met(bearing, operation)
    limits.check_speed(bearing, fastest)
    model = model_of(scene, forces)
    try:
        loaded = elements.equilibrium_start(model, operation)
    except NotFound:
        if not model.has_law:  # contacts wider than all pressure points have none: better say so
            limits.check_widths(bearing, forces.largest)
        raise
    limits.check_contacts(model, loaded.equilibrium)
    inner, outer = loaded.equilibrium.inner_force, loaded.equilibrium.outer_force
    expected = max(float(inner.max()), float(outer.max()), 5.0 * operation.heaviest / bearing.n_rollers)
    if axial is not None:
        tilting = elements.tilting_of(model, operation, axial, max(expected, 1.0), loaded.equilibrium)
        loaded = elements.equilibrium_start(model, operation, tilting)
        starts.check_narrow(bearing, axial, kept_contacts(bearing)[0].laws, loaded.equilibrium.axes)
    start = elements.rest_start(model, operation, tilting) if numerics.start == "rest" else loaded
    on_bearing, on_cage = cage_springs(bearing, cage, operation)
    on_hub, sticks = elements.hub_mass(model.inner_ring, operation), scene.contact.friction_coefficient > 0.0
    along, found = KNOTS_A_STEP * time_along_a_knot(bearing, fastest), start.equilibrium

    def steps_with(mass):  # the critical step, and the longest, s
        critical = critical_time_step(model, next_rung(expected), operation.mounting, on_hub, on_bearing, mass, sticks)
        critical = critical if on_cage == 0.0 else min(critical, 2.0 / sqrt(on_cage))
        return critical, min(numerics.time_step_safety * critical, along)

    interval, mass, (critical, longest) = 1e-6 * numerics.output_interval_us, LUMPED, steps_with(LUMPED)
    damped = scene.damping.contacts.acts  # by forces that are implicit in velocities of nodes with lumped masses
    if not may_strike(scene, bearing, operation) and not damped and (model.has_law or not sticks):
        for slowed in LONG:
            further = steps_with(slowed)
            if further[1] > slowed.worth * longest:
                mass, (critical, longest) = slowed, further
                break
    steps = max(1, ceil(interval / longest))
    looks = ceil(steps / LONGEST_UNWATCHED)
    stride = looks * ceil(steps / looks)  # `ElementPlan.looks` shall divide it
    warnings = limits.plan_warnings(scene, model, operation, loaded.equilibrium, interval, start.warning)
    return ElementPlan(
        scene=scene, model=model, operation=operation, start=start, tilting=tilting,
        seat=cage_seat(bearing, cage, start.angle, found.place, float(found.forces.max())), critical_time_step=critical,
        time_step=interval / stride, stride=stride, largest_force=expected, mass=mass,
        warnings=(*warnings, *model.outer_ring.warnings),
        n_samples=sample_count(scene), frame_stride=round(1e-3 * scene.output.fields_every_ms / interval),
    )  # fmt: skip
