"""Compiled steps of the Lagrangian model; see `lagrange.stepping`."""

import numpy as np

from fem.kernels.cage import CagePair, GuidingRing, Riders
from fem.kernels.fields import lined_up
from fem.kernels.lagrangian_loop import advance_lagrangian
from fem.kernels.lagrangian_state import (
    Clock,
    Dampers,
    IdealBearing,
    IdealHousing,
    IdealMotion,
    PowerConstants,
    Rows,
    ShaftSprings,
    Surfaces,
)
from fem.kernels.lanes import WIDTH
from fem.kernels.state import Law
from fem.solver.cage_arrays import cage_state
from fem.solver.part_arrays import course_arrays, raceway_profiles
from fem.solver.run_arrays import changing_arrays
from lagrange.bearing import Cage
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import PowerLaw
from lagrange.contact.raceway_laws import LogarithmicLaw
from lagrange.equations import touching_distances
from lagrange.step_size import Steps
from lagrange.stepping import MOTION, Integration, Packed


class CompiledIntegration(Integration):
    """Steps by a kernel."""

    def __init__(self, system, start: Packed, interval: float, steps: Steps, damping: ContactDamping):
        super().__init__(system, start, interval, steps, damping)
        columns = -(-system.n // WIDTH) * WIDTH
        axes = 1 if system.holds_angles else 2
        self._motion = lined_up(
            IdealMotion(
                hub=np.zeros((3, 2)),
                elements=np.zeros((3, axes, columns)),
                works=np.zeros(5),
                force=np.zeros((2, columns)),
                housing=_housing(system, [self._section / count for count in steps.counts]),
            )
        )
        self._bearing = lined_up(_bearing(system, columns))
        self._leaps = system.problem.is_damped
        self._dampers = lined_up(_dampers(damping, axes, columns)) if damping.acts else None
        cage = system.problem.free_cage
        if cage is not None:
            pair = _cage(system, cage, self._motion, self._bearing)
            self._motion = self._motion._replace(cage=pair)
            self.memory |= changing_arrays(pair.cage, "cage")

    def _fill(
        self, done: int, z: np.ndarray, q: np.ndarray, works: np.ndarray, sensor: np.ndarray, cage: np.ndarray
    ) -> int:
        motion, n = self._motion, self._system.n
        hub, elements, sums, of_housing = (self.memory[name] for name in MOTION)
        axes, housing = motion.elements.shape[1], motion.housing
        if housing is None:
            motion.hub[:] = _parts(hub, 2)
        else:
            motion.hub[:], housing.motion[:] = _parts(hub[:, 0], 2), _parts(hub[:, 1], 2)
            housing.sensor[:], housing.shift[:] = of_housing[:2], of_housing[2:]
        motion.elements[:, :, :n] = np.moveaxis(_parts(elements, axes), 2, 1)
        motion.works[:] = sums
        counts = self._steps.counts
        kicks, drifts = self._scheme
        clock = Clock(
            lengths=np.array([self._section / count for count in counts]),
            counts=np.array(counts),
            sections=self._steps.sections,
            near=self._near(done, z.shape[1]).astype(np.intp),
            done=done,
            kicks=None if self._leaps else np.array(kicks),
            drifts=None if self._leaps else np.array(drifts),
        )
        rows = Rows(
            hub=np.empty((z.shape[1], 2, 2)),
            elements=np.empty((z.shape[1], *motion.elements[:2].shape)),
            works=np.empty((z.shape[1], 4)),
            cage=cage,
            housing=np.zeros((z.shape[1], 2, 2)),
            sensor=np.zeros((z.shape[1], 2)),
        )
        there = advance_lagrangian(motion, self._bearing, self._dampers, clock, rows)
        if housing is None:
            z[:, :there], hub[:] = _whole(rows.hub[:there]).T, _whole(motion.hub)
        else:
            z[:, :there] = np.stack([_whole(rows.hub[:there]), _whole(rows.housing[:there])], axis=-1).swapaxes(0, 1)
            hub[:] = np.stack([_whole(motion.hub), _whole(housing.motion)], axis=-1)
            of_housing[:2], of_housing[2:] = housing.sensor, housing.shift
            sensor[:there] = rows.sensor[:there]
        q[:, :there] = np.moveaxis(_whole(np.moveaxis(rows.elements[:there, :, :, :n], 2, 3)), 0, 1)
        works[:, :there] = rows.works[:there].T
        elements[:] = _whole(np.moveaxis(motion.elements[:, :, :n], 1, 2))
        sums[:] = motion.works
        return there


def _parts(values: np.ndarray, axes: int) -> np.ndarray:
    """Numbers, complex where there are two axes, along these: one dimension more, the last."""
    return np.stack((values.real, values.imag)[:axes], axis=-1)


def _whole(parts: np.ndarray) -> np.ndarray:
    """The numbers again."""
    return parts[..., 0] if parts.shape[-1] == 1 else np.ascontiguousarray(parts).view(complex)[..., 0]


def _bearing(system, columns: int) -> IdealBearing:
    problem, ideal = system.problem, system.ideal
    bearing, operation, shaft = problem.bearing, problem.operation, problem.operation.mounting.shaft
    reach, track = touching_distances(bearing)
    inner, outer = raceway_profiles(bearing, columns)
    surfaces = first = None
    if bearing.faults:
        surfaces = Surfaces(
            rings=(inner["profile"], outer["profile"]),
            rollers=(inner["roller_profiles"], outer["roller_profiles"]),
            near=np.ones(1, dtype=np.intp),
        )
    if system.holds_angles:
        angle = np.zeros(columns)
        angle[: system.n] = system.angles
        first = np.array([np.cos(angle), np.sin(angle)])
    return IdealBearing(
        laws=tuple(_constants(law) for law in problem.laws),
        surfaces=surfaces,
        first=first,
        reach=float(reach),
        track=float(track),
        mass=float(bearing.roller_mass),
        hub_mass=float(operation.inner_mass),
        gravity=float(operation.gravity),
        radial_load=float(operation.radial_load),
        ramp=float(problem.load_ramp),
        turning=float(ideal.cage) if system.holds_angles else 0.0,
        shaft=float(ideal.shaft),
        spin=float(ideal.roller),
        n=bearing.n_rollers,
        columns=columns,
        course=course_arrays(bearing, operation, held=system.holds_angles),
        springs=None if shaft is None else ShaftSprings(float(shaft.stiffness), float(shaft.damping)),
    )


def _cage(system, cage: Cage, motion: IdealMotion, bearing: IdealBearing) -> CagePair:
    """A free cage; its riders and its guide are the motion's own arrays."""
    columns, ideal = bearing.columns, system.problem.bearing
    riders = Riders(
        centre=motion.elements[0],
        velocity=motion.elements[1],
        spin=np.zeros(columns),
        node_impulse=np.zeros((2, columns)),
        body_impulse=np.zeros((2, columns)),
        turn_kick=np.zeros(columns),
        n=bearing.n,
        mass=bearing.mass,
        inertia=np.inf,  # their spin is prescribed
        radius=float(ideal.roller_radius),
        swelling=None,
    )
    body = cage_state(ideal, cage, system.angles, float(system.ideal.cage))
    return CagePair(cage=body, riders=riders, ring=_guiding(cage, motion, bearing))


def _guiding(cage: Cage, motion: IdealMotion, bearing: IdealBearing) -> GuidingRing | None:
    """The ring that guides a cage, if it moves: the hub, or the outer ring in a housing, where it is the origin."""
    inner = cage.guidance == "inner_ring"
    if not inner and (cage.guidance == "rollers" or motion.housing is None):
        return None
    return GuidingRing(
        place=motion.hub[0] if inner else np.zeros(2),
        velocity=motion.hub[1] if inner else np.zeros(2),
        impulse=np.zeros(2),
        rubbed=np.zeros(3),
        mass=bearing.hub_mass if inner else motion.housing.mass,
        speed=np.array([bearing.shaft if inner else 0.0]),
        turns=inner,
    )


def _housing(system, steps: list[float]) -> IdealHousing | None:
    """The housing and a sensor on it, None where the ground holds the outer ring; `steps`, s: far from faults, near."""
    mounting = system.problem.operation.mounting
    if mounting.housing is None:
        return None
    sensors = [np.zeros((2, 3)) if mounting.sensor is None else mounting.sensor.step(step) for step in steps]
    return IdealHousing(
        motion=np.zeros((3, 2)),
        sensor=np.zeros(2),
        sensor_step=np.array(sensors),
        shift=np.zeros(2),
        lever=np.zeros(2),
        damped=np.zeros(2),
        turned=np.array([1.0, 0.0]),
        mass=float(system.ring_mass),
        stiffness=float(mounting.housing.stiffness),
        damping=float(mounting.housing.damping),
    )


def _constants(law) -> PowerConstants | Law:
    """A law as kernels take it."""
    if isinstance(law, PowerLaw):
        return PowerConstants(stiffness=float(law.stiffness), exponent=float(law.exponent))
    if isinstance(law, LogarithmicLaw):  # S Q (B − ln Q) is 2S Q (½B − ½ ln Q); widths play no part
        A, B = float(2.0 * law.compliance), float(0.5 * law.level)
        return Law(A=A, B=B, Q_line=float(law.largest_force), half_width_factor=0.0, curvature=0.0)
    raise TypeError(f"{type(law).__name__}: no compiled form of such a law; see `lagrangian_forces.spring_force`")


def _dampers(damping: ContactDamping, axes: int, columns: int) -> Dampers:
    return Dampers(
        constant=float(damping.constant),
        time=float(damping.time),
        hunt_crossley=float(damping.hunt_crossley),
        coefficient=np.zeros((2, columns)),
        axes=np.zeros((2, columns)),
        normal=np.zeros((2, 2, columns)),
        closing=np.zeros((2, columns)),
        hub=np.zeros(2),
        elements=np.zeros((axes, columns)),
    )
