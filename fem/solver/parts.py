"""Parts of a scene as the time loops' named tuples: shaft, housing, load history, surfaces, cage, axes that tilt."""

from collections.abc import Sequence
from math import inf, sqrt
from typing import Any

import numpy as np

import fem.kernels.cage as kernels
from fem.kernels import fields
from fem.kernels.cage import CageContacts, CagePair, GuidingRing, Riders
from fem.kernels.drive import N_NOW, N_OUTER_NOW, LoadHistory, OuterTurn
from fem.kernels.elements.state import Ring
from fem.kernels.fields import at_line, lined_up
from fem.kernels.lanes import WIDTH
from fem.kernels.law import RingProfile, RollerProfiles
from fem.kernels.mounts import Housing, Resonator, Shaft, late_mass
from fem.kernels.tilted_contact import PartProfiles, SpalledRest, TiltedLaw
from fem.kernels.tilts import Tilts as TiltArrays
from fem.solver.row_state import row_places, row_width
from lagrange import Bearing, Kinematics, Operation
from lagrange.axial.slices import Axial
from lagrange.axial.table import ContactTable, SpalledTable
from lagrange.bearing import Cage
from lagrange.errors import UsageError
from lagrange.kinematics import kinematics
from lagrange.motion import Tilts, hub_axial_inertia, hub_tilt, roller_inertias
from lagrange.mounting import Mounting
from lagrange.surface.deviation import profiles


def filled(kind: type, sizes: dict[str, int], *sources: object, **values: Any) -> Any:
    """`fields.filled`: fields that `values` lack are those of the first source with that name; numbers as declared,
    so that no whole number makes another type of a tuple.
    """
    for name, declared in kind.__annotations__.items():
        if name not in values and (source := next((each for each in sources if hasattr(each, name)), None)) is not None:
            values[name] = getattr(source, name)
        if name in values and declared in (float, int):
            values[name] = declared(values[name])
    return fields.filled(kind, sizes, **values)


def springs_on(mounting: Mounting, hub: np.ndarray, velocity: np.ndarray, slowed: np.ndarray, mass: float, n: int):
    """A shaft's springs on a hub with its place and velocity, (2,), m and m/s; `slowed` : (2, 2), m, as `Drive`'s."""
    if mounting.shaft is None:
        return None
    column, before = row_places(n, mounting.parts)["energy_shaft"], velocity.copy()
    moved = {"place": hub, "velocity": velocity, "slowed": slowed, "before": before}
    return filled(Shaft, {}, mounting.shaft, **moved, mass=mass, column=column)


def housing_of(
    mounting: Mounting, carried: float, ring: Ring | None, place: np.ndarray, dt: float, column: int
) -> Housing | None:
    """A housing with a ring of which so much, kg, moves as a whole; None for one without a mesh, or free in its bore.

    `column` : of a sample's row, the first for it
    """
    housing, sensor, sizes = mounting.housing, mounting.sensor, {"width": 0 if ring is None else ring.u.shape[2]}
    if housing is None:
        return None
    mass, resonator = float(housing.mass + carried), None
    if sensor is not None:
        steps = {name: np.ascontiguousarray(sensor.step(t)) for name, t in (("step", dt), ("half_step", 0.5 * dt))}
        resonator = filled(Resonator, {}, sensor, **steps)
    late = late_mass(mass, float(housing.damping), dt)
    known = {"place": place.copy(), "ring": ring, "sensor": resonator, "mass": mass, "late_mass": late}
    return filled(Housing, sizes, housing, **known, column=column)


def history_arrays(
    bearing: Bearing, operation: Operation, growth: Sequence[float] = (0.0, 0.0, 0.0)
) -> LoadHistory | None:
    """None where nothing changes.

    `growth` : m s², of the distances at which a roller touches the inner ring, and the outer one, by the square of the
    shaft's speed; of the outer raceway's radius, by the square of the outer ring's
    """
    found, outer = operation.history, None
    if found is None:
        return None

    def turning(spline):
        work = np.array([0.0, np.nan, 0.0])
        return {"turn_knots": spline.x.copy(), "turn": np.ascontiguousarray(spline.c[::-1].T), "drive_work": work}

    if found.outer_turn is not None:
        outer = filled(
            OuterTurn, {"n_outer_now": N_OUTER_NOW}, **turning(found.outer_turn), frame=np.array([0.0, 1.0, 0.0]),
            radius=bearing.outer_raceway_radius, speed=operation.outer_speed, growth=growth[2],
            carries_load=found.rotating_load_with == "outer_ring",
        )  # fmt: skip
    load = {"load_knots": found.load.x.copy(), "load": np.ascontiguousarray(found.load.c[::-1].swapaxes(0, 1))}
    grown = {"growth": growth[0], "roller_growth": growth[1]}
    return filled(LoadHistory, {"n_now": N_NOW}, found, **turning(found.turn), **load, **grown, outer=outer)


def surfaces_of(bearing: Bearing, columns: int, of_part: bool = False) -> PartProfiles:
    """What inner and outer raceway, and the rollers in their contacts with them, are; None: perfect circles.

    Both raceways have a profile where one has, and so one type and one code.

    `of_part` : what the part of the rollers' length that spalls take meets besides
    """
    surfaces, on_rings, on_rollers = profiles(bearing), (None, None), (None, None)
    if surfaces is None:
        return PartProfiles(on_rings, on_rollers)
    every = list(surfaces)
    if of_part:
        every = [None if profile is None else profile.part for profile in every]
    if any(ring is not None for ring in every[:2]):
        on_rings = tuple(RingProfile(*(at_line(row[0]) for row in _splines(ring))) for ring in every[:2])
    if all(roller is not None for roller in every[2:]):
        first = np.zeros((2, columns), dtype=np.int64)
        for row, profile in zip(first, every[2:], strict=True):
            row[: profile.row.size] = profile.row * profile.coefficients.shape[1]
        pairs = zip(every[2:], first, strict=True)
        on_rollers = tuple(RollerProfiles(*map(at_line, (*_splines(profile), row))) for profile, row in pairs)
    return PartProfiles(on_rings, on_rollers)


def _splines(profile):
    """Sinkage, m, and compliance, m/N, of a profile, or of none: coefficients by row."""
    sinkage = np.zeros((1, WIDTH)) if profile is None else profile.coefficients
    soft = None if profile is None else profile.compliance
    return sinkage, np.zeros_like(sinkage) if soft is None else soft


def time_along_a_knot(bearing: Bearing, ideal: Kinematics, spalls: bool = True) -> float:
    """Time in which contacts roll over the shortest knot of a profile, s; infinite on perfect circles, or standing.

    `spalls` : False: of all but these
    """
    surfaces = profiles(bearing)
    # of contacts along every surface
    speed = float(np.abs(ideal.cage - ideal.outer_ring).max()) * bearing.outer_raceway_radius
    if surfaces is None or speed == 0.0:
        return inf
    return (surfaces.shortest if spalls else surfaces.shortest_of_waves) / speed


FINEST = 1e-4  # µm: a place is found to so much


def cage_seat(bearing: Bearing, cage: Cage | None, angle: np.ndarray, found: np.ndarray, force: float) -> np.ndarray:
    """The centre of a cage, (2,), m, from the outer ring's: there, or if it does not fit, where it is least wedged.

    angle : ndarray, (n_rollers,), rad, of the rollers; found : hub and radii in equilibrium, (n_rollers + 2,), m
    force : N, largest of the raceways' contacts

    UsageError: wherever it stands, rollers or its guide wedge it with more than that force.
    """
    middle, hub, rho = np.zeros(2), found[:2], found[2:]
    if cage is None:
        return middle
    outward = np.array([np.cos(angle), np.sin(angle)])
    around = np.array([-outward[1], outward[0]])
    off = (rho - bearing.pitch_radius) * outward  # of pockets' middles, if the cage is in the middle

    def wedged(place):
        """How far its tightest contact is closed, m."""
        if cage.guidance == "rollers":
            return float(np.hypot(*(off - place[:, None])).max()) - 0.5 * cage.pocket_clearance
        from_guide = place - hub if cage.guidance == "inner_ring" else place
        in_guide = float(np.hypot(*from_guide)) - 0.5 * (cage.guidance_clearance or 0.0)
        return max(float(np.abs(place @ around).max()) - 0.5 * cage.pocket_clearance, in_guide)

    if wedged(middle) <= 0.0:
        return middle
    from scipy.optimize import minimize  # which other runs save

    options = {"xatol": FINEST, "fatol": FINEST}
    found = minimize(lambda place: 1e6 * wedged(1e-6 * place), 1e6 * hub, method="Nelder-Mead", options=options)
    left, place = 1e-6 * float(found.fun), 1e-6 * found.x
    if cage.stiffness * left > force:
        clearances = f"cage.pocket_clearance_mm = {1e3 * cage.pocket_clearance:g}"
        if cage.guidance_clearance is not None:
            clearances += f", cage.guidance_clearance_mm = {1e3 * cage.guidance_clearance:g}"
        raise UsageError(
            f"{clearances}: where rollers and rings are in equilibrium the cage does not fit: wherever it stands, a "
            f"contact of it is closed by {1e6 * left:.3g} µm, which takes {cage.stiffness * left:.3g} N, and raceways "
            f"push with {force:.3g} N at most; use more clearance, a lighter load, stiffer rings, or "
            'numerics.start = "rest"'
        )
    return place


def cage_state(bearing: Bearing, cage: Cage, angle: np.ndarray, speed: float, first: int | None = None) -> kernels.Cage:
    """The cage at t = 0, concentric and turning with the rollers, at these angles, rad; `first` of its columns."""
    n, guided = bearing.n_rollers, cage.guidance != "rollers"
    padded = np.concatenate([angle, np.zeros(-n % WIDTH)])
    # of the cage, where it meets that ring
    radii = {"inner_ring": -bearing.inner_raceway_radius, "outer_ring": bearing.outer_raceway_radius, "rollers": 0.0}
    body = filled(
        kernels.Cage, {"columns": padded.size}, cage, bearing,
        motion=np.array([[0.0, 0.0, 0.0], [0.0, 0.0, speed], [0.0, 0.0, speed]]), frame=np.array([1.0, 0.0]),
        cosine=np.cos(padded), sine=np.sin(padded), pockets=filled(CageContacts, {"n": n}),
        guide=filled(CageContacts, {"n": 1}) if guided else None, half_clearance=0.5 * cage.pocket_clearance,
        play=0.5 * (cage.guidance_clearance or 0.0), guide_radius=radii[cage.guidance],
        friction=cage.friction_coefficient, at=row_width(n, None) if first is None else first,
    )  # fmt: skip
    return lined_up(body)


Guide = tuple[np.ndarray, np.ndarray, np.ndarray, float]  # of a ring: place, m, velocity, m/s, impulse, N s, mass, kg


def cage_pair(
    body: kernels.Cage, cage: Cage, riders: Riders, hub: Guide, housing: Guide | None, speed: float
) -> CagePair:
    """A cage, its rollers and the ring that guides it; `speed` of the shaft, rad/s; `housing` None: the ground."""
    guide, ring = {"inner_ring": hub, "outer_ring": housing, "rollers": None}[cage.guidance], None
    if guide is not None:
        turns, moved = guide is hub, dict(zip(("place", "velocity", "impulse", "mass"), guide, strict=True))
        ring = filled(GuidingRing, {}, **moved, speed=np.array([float(speed) if turns else 0.0]), turns=turns)
    return CagePair(cage=body, riders=riders, ring=ring)


def cage_springs(bearing: Bearing, cage: Cage | None, operation: Operation) -> tuple[float, float]:
    """What all contacts of a cage, closed, add to ω² of the bearing's bodies, and the cage's own ω², 1/s².

    A spring k between two bodies is counted as EVENLY k on each, as in `critical_time_step`. The bearing's bodies have
    other springs too; on the cage there is nothing else.
    """
    if cage is None:
        return 0.0, 0.0
    from fem.contacts.critical_step import EVENLY  # and with it scipy.sparse, which runs without a cage save

    spring, n, pitch = EVENLY * cage.stiffness, bearing.n_rollers, bearing.pitch_radius
    guided, housing = cage.guidance != "rollers", operation.mounting.housing
    guiding = {"inner_ring": operation.inner_mass, "outer_ring": inf if housing is None else housing.mass}
    of_bearing = spring / min(bearing.roller_mass, guiding.get(cage.guidance, inf))
    of_cage = spring * (n * (1.0 / cage.mass + pitch**2 / cage.inertia) + (1.0 / cage.mass if guided else 0.0))
    return of_bearing, of_cage


def critical_with_cage(critical: float, bearing: Bearing, cage: Cage | None, operation: Operation) -> float:
    """Critical step of leapfrog, s, of a bearing, s, with all its cage's contacts closed too."""
    of_bearing, of_cage = cage_springs(bearing, cage, operation)
    return critical if cage is None else 2.0 / sqrt(max(4.0 / critical**2 + of_bearing, of_cage))


def axes_at(
    bearing: Bearing, operation: Operation, axial: Axial, cage: Cage | None, start: Tilts, columns: int
) -> TiltArrays:
    """The axes of rollers and hub at the slopes and rates of a start; `columns` : of rollers in arrays."""
    n, hub = bearing.n_rollers, hub_tilt(operation, axial)
    (across, along), turns = roller_inertias(bearing), (kinematics(bearing, 1.0), kinematics(bearing, 0.0, 1.0))
    tilts = filled(
        TiltArrays, {"columns": columns, "lanes": WIDTH}, slope=np.array([start.slope_x, start.slope_y], dtype=float),
        slope_rate=np.array([start.slope_x_rate, start.slope_y_rate], dtype=float), inertia=across, along=along,
        spin=tuple(float(each.roller) for each in turns), cage=tuple(float(each.cage) for each in turns),
        hub_over=1.0 / hub.inertia if hub.is_free else 0.0, hub_spin=hub_axial_inertia(bearing, operation),
        hub_stiffness=hub.stiffness, rest=(float(hub.slope_x), float(hub.slope_y)),
        column=row_width(n, cage, operation.mounting),
    )  # fmt: skip
    tilts.tilt[:n], tilts.rate[:n] = start.tilt, start.tilt_rate
    return tilts


def laws_of(tables: tuple[ContactTable | SpalledTable, ...]) -> tuple[tuple[TiltedLaw, ...], tuple]:
    """Laws of contacts by their tables, of all slices, and without those that spalls take; None: these take none."""
    laws = tuple(TiltedLaw.of(table.whole if isinstance(table, SpalledTable) else table) for table in tables)
    if not any(isinstance(table, SpalledTable) for table in tables):
        return laws, (None,) * len(tables)
    rests = (
        SpalledRest(law=TiltedLaw.of(table.rest), of_rest=1.0 / (1.0 - table.share), of_part=1.0 / table.share)
        if isinstance(table, SpalledTable)
        else SpalledRest(law=TiltedLaw.of(table), of_rest=1.0, of_part=0.0)
        for table in tables
    )
    return laws, tuple(rests)  # of all contacts, so that they are of one type


LESS = "reduce impacts and tilt of the rollers, or leave [axial] out"  # where tables go no further


def beyond_tables(tilts: TiltArrays | None, tables: tuple[TiltedLaw, ...]) -> str | None:
    """A clause where closed contacts have been further than their tables go; None: they have not, or have none.

    `tables` : of the inner and the outer contact, or none
    """
    if tilts is None or not tables:
        return None
    *approaches, slope = tilts.furthest.max(axis=1)
    for law, approach, side in zip(tables, approaches, ("inner", "outer"), strict=True):
        deepest = law.first_approach + (law.rows + 1.0) / law.per_approach
        steepest = law.first_slope + (law.columns + 1.0) / law.per_slope
        most = "and contacts that tilt are tabulated up to"
        if approach > deepest:
            what = f"a roller and the {side} raceway approached by"
            return f"{what} {1e6 * approach:.3g} µm, {most} {1e6 * deepest:.3g} µm"
        if slope > steepest:
            return f"a roller and a raceway were misaligned by {1e3 * slope:.3g} mrad, {most} {1e3 * steepest:.3g} mrad"
    return None
