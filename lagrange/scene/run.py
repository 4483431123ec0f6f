"""Tables of the scene that say how the bearing is held, how it runs, and how that is computed and read.

[support], [sensor]; [operation], with what of it changes in time; [contact], [damping], [lagrange], [numerics],
[output]; [table], names and units of the columns of a trajectory table made elsewhere (docs/tables.md).
"""

# fmt: off
import re
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from math import cos, pi, radians, sin
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from lagrange.bearing import Operation, OwnLaw
from lagrange.columns import per_roller
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import OWN
from lagrange.errors import exceeds
from lagrange.files.tables import columns
from lagrange.load_history import LoadHistory, joined, points_of, steady, turn_of
from lagrange.load_history import Shape as Curve
from lagrange.messages import G
from lagrange.mounting import Bore, Housing, Points, Shaft
from lagrange.scene.faults import RPM, Angle, DecimalSign, Digest, File, FileName, FileText, Share, Table, key, only

FASTEST, HEAVIEST = 200_000.0, 1e7  # rpm, N
FIRST_SPEEDS = {"speed_table": "speed_rpm", "outer_ring_speed_table": "outer_ring_speed_rpm"}  # keys in whose place
IN_PLACE_OF = FIRST_SPEEDS | {"load_table": "radial_load_N"}
FROM_LOAD = -90.0  # degrees, of the direction of radial_load_N from +x
ENOUGH = 1e-9  # relative: times and speeds that are the same
Speed = Annotated[float, Field(ge=-FASTEST, le=FASTEST)]
Load = Annotated[float, Field(ge=0.0, le=HEAVIEST)]
Coefficient = Annotated[float, Field(ge=0.0, le=1e9)]
SMOOTH = "curve through the points: smooth (default) or straight lines"
SPEEDS = File("speeds", lambda text, decimal: points_of(text, ("speed_rpm",), FASTEST, decimal))
LOADS = File("loads", lambda text, decimal: points_of(text, ("x_N", "y_N"), HEAVIEST, decimal))


class OperationTable(Table):
    """Speeds and loads of the bearing."""

    speed_rpm: Speed = key(4500.0, "speed of the inner ring; positive: counter-clockwise")
    outer_ring_speed_rpm: Speed = key(0.0, "speed of the outer ring about its fixed centre; positive: "
        "counter-clockwise")
    radial_load_N: Load = key(2000.0, "load on the hub, along −y")
    inner_ring_and_shaft_kg: float = key(0.078, "mass that moves with the hub, inner ring included; default 0.078, or "
        "if the ring is heavier: a steel ring and shaft of the given sizes", most=1e6, gt=0.0)
    gravity_m_s2: float = key(9.81, "gravity, along −y", 0.0, 1000.0)
    first_roller_deg: Angle = key(0.0, "angle of roller 0 from the load (−y), counter-clockwise")
    axial_load_N: float | None = key(None, "axial load on the hub, along +z; at rest and in ratings only; default 0",
        -HEAVIEST, HEAVIEST)
    moment_N_m: float | None = key(None, "tilting moment on the hub about x; positive: tilts the +z end towards the "
        "load; in ratings only; default: the tilt is held at misalignment_mrad", -1e6, 1e6)
    misalignment_mrad: float | None = key(None, "slope of the shaft in the plane of the load; positive: its +z end "
        "leans towards the load; default 0; with [axial], or in ratings of balls and of rows with a contact angle",
        -50.0, 50.0)
    unbalance_g_mm: Coefficient | None = key(None, "unbalance of the parts that turn with the inner ring; their mass "
        "includes it")
    unbalance_deg: Angle | None = key(None, "angle of the heavy side at t = 0, from −y, counter-clockwise")
    rotating_load_N: Load | None = key(None, "load on the hub that turns with a ring, added to the other loads")
    rotating_load_with: Literal["inner_ring", "outer_ring"] | None = key(None, "the ring that the load turns with; "
        "default inner_ring")
    rotating_load_deg: Angle | None = key(None, "its direction at t = 0, from −y, counter-clockwise")
    shaft: Literal["rigid", "springs"] | None = key(None, "rigid: the bearing alone carries the shaft (default); "
        "springs: springs and dashpots from the hub to the ground carry it too")
    shaft_stiffness_N_per_m: float | None = key(None, "stiffness of the shaft's springs, along x and y; required with "
        "them", 0.0, 1e12)
    shaft_damping_N_s_m: Coefficient | None = key(None, "damping of the dashpots parallel to the springs; default 0")
    speed_table: FileName | None = key(None, "CSV file next to the scene with the columns time_ms, speed_rpm (or "
        "time_s, speed_rad/s), instead of speed_rpm")
    speed_table_sha256: Digest = None
    speed_table_decimal: DecimalSign = None
    speed_table_shape: Literal["smooth", "linear"] | None = key(None, SMOOTH)
    speed_table_content: FileText = None
    outer_ring_speed_table: FileName | None = key(None, "CSV file next to the scene with the columns time_ms, "
        "speed_rpm, instead of outer_ring_speed_rpm")
    outer_ring_speed_table_sha256: Digest = None
    outer_ring_speed_table_decimal: DecimalSign = None
    outer_ring_speed_table_shape: Literal["smooth", "linear"] | None = key(None, SMOOTH)
    outer_ring_speed_table_content: FileText = None
    load_table: FileName | None = key(None, "CSV file next to the scene with the columns time_ms, x_N, y_N (or time_s, "
        "x_kN, y_kN), instead of radial_load_N")
    load_table_sha256: Digest = None
    load_table_decimal: DecimalSign = None
    load_table_shape: Curve | None = key(None, "curve through the points: smooth (default), straight lines, or steps "
        "held until the next row")
    load_table_content: FileText = None

    FILES: ClassVar = {"speed_table": SPEEDS, "outer_ring_speed_table": SPEEDS, "load_table": LOADS}

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Tables say what the speed is at the start, and the whole load."""
        defaults = {"radial_load_N": 0.0} if data.get("load_table") is not None else {}
        for name, speed in FIRST_SPEEDS.items():
            if isinstance(text := data.get(f"{name}_content"), str):
                with suppress(ValueError, TypeError):  # refused as a file; a decimal sign that is no text
                    defaults[speed] = _first_speed(text, data.get(f"{name}_decimal"), data.get(f"{name}_shape"))
        return defaults | data

    def _first_speeds(self):
        for name, speed in FIRST_SPEEDS.items():
            given, about = getattr(self, speed), [self.of_file(name, end) for end in ("content", "decimal", "shape")]
            first = given if about[0] is None else _first_speed(*about)
            if abs(first - given) > ENOUGH * max(abs(first), 1.0):
                file = getattr(self, name)
                yield f'{speed} = {given:g}: {name} = "{file}" starts at {first:g}; leave {speed} out'

    RULES = (
        (lambda t: None not in (t.moment_N_m, t.misalignment_mrad), "misalignment_mrad = {t.misalignment_mrad:g}: the "
            "tilt follows from moment_N_m = {t.moment_N_m:g}; leave out one of them"),
        only("unbalance_deg", "unbalance_g_mm"), only("rotating_load_deg rotating_load_with", "rotating_load_N"),
        (lambda t: t.shaft == "springs" and t.shaft_stiffness_N_per_m is None, 'shaft = "springs" needs '
            'shaft_stiffness_N_per_m, e.g. 1e7'),
        only("shaft_stiffness_N_per_m shaft_damping_N_s_m", "shaft", "springs"),
        (lambda t: t.load_table is not None and t.radial_load_N > 0.0, 'radial_load_N = {t.radial_load_N:g}: '
            'load_table = "{t.load_table}" is the whole load; leave out one of them'), _first_speeds)

    def springs(self) -> Shaft | None:
        """What holds the shaft beside the bearing, in SI; None: nothing."""
        if self.shaft != "springs" or self.shaft_stiffness_N_per_m is None:
            return None
        return Shaft(stiffness=self.shaft_stiffness_N_per_m, damping=self.shaft_damping_N_s_m or 0.0)

    @property
    def changes(self) -> str | None:
        """The key of something that changes with time; None: nothing does."""
        turning = ("outer_ring_speed_rpm", "unbalance_g_mm", "rotating_load_N")
        return next((name for name in (*self.FILES, *turning) if getattr(self, name)), None)

    @property
    def turns_outer_ring(self) -> str | None:
        """The key by which the outer ring turns; None: it stands still."""
        names = ("outer_ring_speed_table", "outer_ring_speed_rpm")
        return next((name for name in names if getattr(self, name)), None)

    def ideal(self) -> Operation:
        """The operating point in SI, and how it goes on; angles from +x. ValueError: a table is not at hand."""
        return _ideal(self)


@lru_cache(maxsize=16)
def _ideal(o):
    found = o.fact(Operation, inner_mass=o.inner_ring_and_shaft_kg,
        first_roller_angle=radians(o.first_roller_deg + FROM_LOAD), misalignment=1e-3 * (o.misalignment_mrad or 0.0))
    if o.changes is None:
        return found
    functions = {"speed_table": steady(found.speed), "outer_ring_speed_table": steady(RPM * o.outer_ring_speed_rpm),
        "load_table": steady(0.0, -found.radial_load)}
    for name in (name for name in o.FILES if getattr(o, name) is not None):
        points = o.read(name)
        if points is None:
            raise ValueError(f'operation: {name} = "{getattr(o, name)}" is not at hand')
        unit = RPM if name in FIRST_SPEEDS else 1.0
        functions[name] = joined(1e-3 * points[0], unit * points[1], o.of_file(name, "shape") or "smooth")
    load, rotating, angle = functions["load_table"], o.rotating_load_N or 0.0, (o.rotating_load_deg or 0.0) + FROM_LOAD
    if o.rotating_load_with == "outer_ring" and o.turns_outer_ring is None:  # it stands with that ring
        load.c[-1] += rotating * cos(radians(angle)), rotating * sin(radians(angle))
        rotating = 0.0
    history = LoadHistory(turn=turn_of(functions["speed_table"]), outer_turn=None if o.turns_outer_ring is None
        else turn_of(functions["outer_ring_speed_table"]), load=load, unbalance=1e-6 * (o.unbalance_g_mm or 0.0),
        unbalance_angle=radians((o.unbalance_deg or 0.0) + FROM_LOAD), rotating_load=rotating,
        rotating_load_angle=radians(angle), rotating_load_with=o.rotating_load_with or "inner_ring")
    (x, y), speeds = history.force(0.0), history.ring_speeds(0.0)
    return replace(found, speed=float(speeds[0]), outer_speed=float(speeds[1]), radial_load=-float(y),
        side_load=float(x), history=history)


@lru_cache(maxsize=16)
def _first_speed(text, decimal, shape):
    time, values = SPEEDS.read(text, decimal or ".")
    return float(joined(time, values, shape or "smooth")(0.0)[0])


OF_KINDS: dict[str, dict[str, Any]] = {  # keys that each kind needs, with their defaults
    "points": {"angles_deg": [0.0, 120.0, 240.0], "width_mm": 6.0},
    "housing": {"mass_kg": 12.638, "stiffness_N_per_m": 15.1e6, "damping_N_s_m": 2210.7},
    "bore": {"fit_clearance_um": 0.0}}


class SupportTable(Table):
    """Support of the outer ring.

    Source of a housing's defaults, a pedestal's: Sawalhi and Randall, Simulating gear and bearing interactions in the
    presence of faults, part I (2008).
    """

    kind: Literal["held", "points", "housing", "bore"] = key("held", "held: by rigid ground all around; points: on "
        "arcs of the outside; housing: in a rigid mass on springs; bore: in a bore of the ground")
    angles_deg: list[Angle] | None = key(None, "angles of the points from the load (−y); default 0, 120, 240",
        min_length=1, max_length=100)
    width_mm: float | None = key(None, "width of each point along the outside, at least two nodes; default 6", most=1e4,
        gt=0.0)
    mass_kg: float | None = key(None, "mass of the housing without the outer ring; default 12.638", 1e-3, 1e6)
    stiffness_N_per_m: float | None = key(None, "stiffness of the housing's springs, along x and y; default 15.1e6",
        1e3, 1e12)
    damping_N_s_m: Coefficient | None = key(None, "damping of the dashpots parallel to the springs; default 2210.7")
    fit_clearance_um: float | None = key(None, "bore diameter minus outside diameter of the outer ring; negative: "
        "press fit; default 0 with a bore; a housing without it holds the ring all around", -1000.0, 1000.0)
    bore_stiffness_N_per_mm3: float | None = key(None, "pressure per deflection of the bore; default: that of a thick "
        "wall", 1.0, 1e5)

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        kind = data.get("kind")
        return OF_KINDS.get(kind, {}) | data if isinstance(kind, str) else data

    RULES = (
        only("angles_deg width_mm", "kind", "points"),
        only("mass_kg stiffness_N_per_m damping_N_s_m", "kind", "housing"),
        only("fit_clearance_um bore_stiffness_N_per_mm3", "kind", "housing", "bore"),
        (lambda t: t.kind == "housing" and t.fit_clearance_um is None and t.bore_stiffness_N_per_mm3 is not None,
            "bore_stiffness_N_per_mm3 = {t.bore_stiffness_N_per_mm3:g}: only with fit_clearance_um, without which the "
            "ring is held all around; give that too, 0 for a bore as wide as the ring"))

    def parts(self) -> dict[str, Any]:
        """Points, housing and bore in SI, as `Mounting` has them; None: there are none."""
        clearance, stiffness = (self.si()[name] for name in ("fit_clearance", "bore_stiffness"))
        angles = tuple(radians(angle + FROM_LOAD) for angle in self.angles_deg or ())
        return {"points": self.fact(Points, angles=angles) if self.kind == "points" else None,
            "housing": self.fact(Housing) if self.kind == "housing" else None,
            "bore": None if clearance is None else Bore(clearance=clearance, stiffness=stiffness)}


class SensorTable(Table):
    """An accelerometer on the housing, along y: a resonator."""

    frequency_Hz: float = key(15_000.0, "undamped natural frequency of the sensor", 1.0, 1e7)
    damping_ratio: float = key(0.05, "damping ratio of the sensor", 0.0, 0.99)


COMPARISONS = ("penalty", "faceted")  # contact models that are only there to be compared with
STIFF_PENALTY = 1e9  # N/m, three times a contact of the paper's bearing; the mesh's nodes are no stiffer


class ContactTable(Table):
    """How contacts are computed."""

    model: Literal["subgrid", "resolved", "penalty", "faceted"] = key("subgrid", "subgrid: contacts smaller than the "
        "mesh; resolved: on meshes finer than the contacts; penalty, faceted: springs or polygons, for comparison")
    penalty_stiffness_N_per_m: float | None = key(None, "stiffness of each contact of a comparison model; default 1e9",
        1e5, 1e12)
    friction_coefficient: Share = key(0.1, "Coulomb friction coefficient; 0: frictionless (faster)")

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        compared = data.get("model") in COMPARISONS
        return {"penalty_stiffness_N_per_m": STIFF_PENALTY} | data if compared else data

    RULES = (only("penalty_stiffness_N_per_m", "model", *COMPARISONS),)


OF_CONTACTS = "contact_N_s_m", "contact_time_us", "hunt_crossley_s_m"  # damping laws


class DampingTable(Table):
    """Damping, apart from friction. At most one of the three contact laws may be given; none makes a contact pull."""

    contact_N_s_m: float = key(0.0, "damping coefficient of every closed contact", 0.0, 1e6)
    contact_time_us: float = key(0.0, "damping time: the coefficient is this time multiplied by the contact's "
        "stiffness", 0.0, 1000.0)
    hunt_crossley_s_m: float = key(0.0, "Hunt–Crossley coefficient α: F = Q(1 + 3/2 α δ̇)", 0.0, 1000.0)
    bodies_1_s: float = key(0.0, "mass-proportional damping of the deformation of the bodies", 0.0, 1e6)

    RULES = ((lambda t: len(given := [f"{name} = {getattr(t, name):g}" for name in OF_CONTACTS if getattr(t, name)]) > 1
        and " and ".join(given), "{0}: contacts are damped by one law; leave all but one out"),)

    @property
    def acts(self) -> bool:
        return self != DampingTable()

    @property
    def words(self) -> str:
        """What damps, for captions."""
        contacts = f"contact damping {self.contacts.words}" if self.contacts.acts else "no contact damping"
        return contacts if self.bodies_1_s == 0.0 else f"{contacts}, bodies damped by {self.bodies_1_s:.4g} 1/s"

    @property
    def contacts(self) -> ContactDamping:
        """The law of the contacts, SI."""
        return ContactDamping(self.contact_N_s_m, 1e-6 * self.contact_time_us, self.hunt_crossley_s_m)


TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9}
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "in": 0.0254}
ANGLES = {"rad": 1.0, "deg": pi / 180.0, "°": pi / 180.0}
FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605}
ACCELERATIONS = {"m/s2": 1.0, "m/s²": 1.0, "m/s^2": 1.0, "mm/s2": 1e-3, "mm/s²": 1e-3, "mm/s^2": 1e-3, "g": G}


UNITS_OF = {"time": TIMES, "x": LENGTHS, "y": LENGTHS, "rho": LENGTHS, "theta": ANGLES, "ax": ACCELERATIONS,
    "ay": ACCELERATIONS, "force": FORCES, "traction": FORCES}  # of columns, by the last word of what they hold, to SI
LONGEST_NAME = 200  # characters
FEWEST_ROWS = 3  # of a law; with two the fit is exact, and says nothing of itself
EXPONENTS = 1.0, 3.0  # softer than a line contact's, stiffer than a point's: none is beyond


@lru_cache(maxsize=16)
def fitted_law(text: str, decimal: str = ".") -> OwnLaw:
    """The power law Q = K δ^n of both raceways with the least squares of relative differences, ln Q over ln δ.

    The table has columns `force [N], approach [um]`, or other units, as `force [kN]` or `force_kN`. A row without force
    and approach says nothing of K and n. ValueError, a sentence on the text: columns or units missing, rows that can't
    be read, fewer than three rows, values that are not positive, approaches all alike, an exponent outside 1 to 3.
    """
    units = {"force_N": FORCES, "approach_m": LENGTHS}
    rows = columns(text, tuple(units), decimal, units)
    rows = rows[np.any(rows != 0.0, axis=1)]
    if not np.all(np.isfinite(rows) & (rows > 0.0)):
        raise ValueError("force and approach must both be above 0, or both 0, in each row")
    if len(np.unique(rows[:, 1])) < FEWEST_ROWS:
        raise ValueError(f"at least {FEWEST_ROWS} different approaches above 0 are needed for K and an exponent")
    force, approach = np.log(rows).T
    exponent, level = np.polyfit(approach, force, 1)
    if not EXPONENTS[0] <= exponent <= EXPONENTS[1]:
        raise ValueError(f"the exponent of its power law is {exponent:.4g}; between {EXPONENTS[0]:g} and "
            f"{EXPONENTS[1]:g} contacts can be computed: are the columns exchanged, or an approach of no load left in?")
    off = np.abs(np.exp(level + exponent * approach - force) - 1.0)
    return OwnLaw(inner_stiffness=float(np.exp(level)), outer_stiffness=float(np.exp(level)), exponent=float(exponent),
        misfit=float(off.max()), range=f"fitted to {len(rows)} rows from {rows[:, 0].min():.4g} to "
        f"{rows[:, 0].max():.4g} N: forces differ by {100.0 * np.sqrt(np.mean(off**2)):.2g} % rms, "
        f"{100.0 * off.max():.2g} % at most")


class LagrangeTable(Table):
    """Lagrangian model: its own solution, and the equations that check-residual uses."""

    law: str = key("harris", "contact law: harris, palmgren, iso16281, braendlein, johnson, houpert, teutsch_sauer; "
        "balls: hertz; power: Q = K δⁿ with the keys below")
    contact_stiffness_N_per_m_n: list[Annotated[float, Field(ge=1e3, le=1e25)]] | None = key(None,
        "K of an inner and of an outer contact in Q = K δⁿ, SI", min_length=2, max_length=2)
    contact_exponent: float | None = key(None, "exponent n in Q = K δⁿ", *EXPONENTS)
    law_table: FileName | None = key(None, "CSV file next to the scene with the columns force [N], approach [um] of "
        "one contact; K and n are fitted to it")
    law_table_sha256: Digest = None
    law_table_decimal: DecimalSign = None
    law_table_content: FileText = None
    angles: Literal["kinematic", "free"] = key("kinematic", "kinematic: rollers in a cage that rolls without slip; "
        "free: free rollers (run-fem only)")

    FILES: ClassVar = {"law_table": File("forces", fitted_law)}

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The own law is meant where it is given and none is named."""
        given = any(data.get(name) is not None for name in ("contact_stiffness_N_per_m_n", "law_table"))
        return {"law": OWN} | data if given else data

    RULES = (
        (lambda t: t.law_table is not None and (t.contact_stiffness_N_per_m_n or t.contact_exponent),
            'law_table = "{t.law_table}": K and n are fitted to it; leave it out, or contact_stiffness_N_per_m_n and '
            "contact_exponent"),
        (lambda t: (t.contact_stiffness_N_per_m_n is None) != (t.contact_exponent is None),
            "contact_stiffness_N_per_m_n and contact_exponent make one law Q = K δⁿ; give both, or neither"),
        (lambda t: t.law == OWN and t.contact_stiffness_N_per_m_n is None and t.law_table is None,
            'law = "power" needs contact_stiffness_N_per_m_n = [inner, outer] and contact_exponent, or law_table'))

    def own_law(self) -> OwnLaw | None:
        """The scene's own law; None: it has none, or its table is not at hand. ValueError: a table of another kind."""
        stiffness, exponent = self.contact_stiffness_N_per_m_n, self.contact_exponent
        if self.law_table_content is not None or stiffness is None or exponent is None:
            return self.read("law_table")
        return OwnLaw(inner_stiffness=stiffness[0], outer_stiffness=stiffness[1], exponent=exponent)


class NumericsTable(Table):
    """Duration, start, mesh and steps."""

    duration_ms: float = key(60.0, "simulated time; 0: static equilibrium only", 0.0, 1e6)
    start: Literal["equilibrium", "rest"] = key("equilibrium", "from static equilibrium, rolling; or from rest: "
        "centred, undeformed, the load ramped")
    load_ramp_ms: float = key(1.0, 'time over which the load grows if start = "rest"', 0.0, 1e6)
    mesh_size_mm: float = key(1.0, "distance of surface nodes; default: a tenth of a given roller_diameter_mm",
        most=100.0, gt=0.0)
    time_step_safety: float = key(0.9, "time step over the critical time step", 0.01, lt=1.0)
    output_interval_us: float = key(10.0, "time between two samples; default 10, or less if the hub or impacting "
        "rollers vibrate faster or faults pass", 1e-3, 1e6)

    RULES = ((lambda t: t.duration_ms > 0.0 and exceeds(t.output_interval_us, most := 1e3 * t.duration_ms) and most,
        "output_interval_us = {t.output_interval_us:g} is longer than the run (duration_ms = {t.duration_ms:g}): "
        "nothing but the start would be stored; at most {0:g}"),)


class OutputTable(Table):
    """Fields and accelerations to store."""

    fields_every_ms: float = key(0.0, "interval at which displacement and stress of all nodes are stored; 0: none "
        "(faster)", 0.0, 1e6)
    acceleration_Hz: int = key(25_600, "sampling rate of the accelerations that render-fem --export writes", 1,
        100_000_000)


class Columns(Table):
    """Names of a table's columns: "name" (SI) or "name [unit]"."""

    time: str = key("time", "time")
    inner_x: str = key("inner_x", "inner ring's centre, x")
    inner_y: str = key("inner_y", "inner ring's centre, y (up)")
    roller_x: str = key("roller_{j}_x", "roller's centre, x; {j}: its number")
    roller_y: str = key("roller_{j}_y", "roller's centre, y")
    roller_rho: str = key("roller_{j}_rho", "roller's distance from the outer ring's centre, instead of x and y")
    roller_theta: str = key("roller_{j}_theta", "roller's angle from +x, counter-clockwise")
    inner_ax: str = key("inner_ax", "acceleration of the inner ring, x")
    inner_ay: str = key("inner_ay", "acceleration of the inner ring, y")
    housing_x: str = key("housing_x", "outer ring's centre in a housing, x")
    housing_y: str = key("housing_y", "outer ring's centre in a housing, y")
    housing_ax: str = key("housing_ax", "acceleration of the housing, x")
    housing_ay: str = key("housing_ay", "acceleration of the housing, y")
    outer_ring_x: str = key("outer_ring_x", "outer ring's centre, x, if it has a fit")
    outer_ring_y: str = key("outer_ring_y", "outer ring's centre, y, if it has a fit")
    outer_ring_ax: str = key("outer_ring_ax", "acceleration of the outer ring, x")
    outer_ring_ay: str = key("outer_ring_ay", "acceleration of the outer ring, y")
    inner_force: str = key("roller_{j}_inner_force", "normal force at the inner raceway")
    outer_force: str = key("roller_{j}_outer_force", "normal force at the outer raceway")
    inner_traction: str = key("roller_{j}_inner_traction", "tangential force of the inner raceway on the roller, "
        "along +θ")
    outer_traction: str = key("roller_{j}_outer_traction", "tangential force of the outer raceway on the roller, "
        "along +θ")
    first_roller: int = key(0, "number of the first roller in the names", 0)
    decimal: Literal[".", ","] = key(".", "decimal sign of the table")

    @field_validator("*")
    @classmethod
    def _usable(cls, name: Any, info: ValidationInfo) -> Any:
        quantity = str(info.field_name)  # which a field's validator always has
        if not (units := cls.units_of(quantity)):
            return name
        if not name.strip() or len(name) > LONGEST_NAME:
            raise ValueError(f"must be a column's name of at most {LONGEST_NAME} characters")
        if (unit := _split(name)[1]) is not None and unit not in units:
            raise ValueError(f"the unit [{unit}] is unknown; known are {', '.join(units)}")
        if (wanted := per_roller(quantity)) != ("{j}" in name):
            raise ValueError("needs {j} in place of the roller's number" if wanted else "has one column, without {j}")
        return name

    @staticmethod
    def units_of(quantity: str) -> dict[str, float]:
        """Units that a column may have, and their factors to SI; none of what is no column."""
        return UNITS_OF.get(quantity.rpartition("_")[2], {})

    def header(self, quantity: str, roller: int | None = None) -> tuple[list[str], float]:
        """Headers a quantity's column may have, likeliest first, and the factor to SI; `roller` counts from 0."""
        name = getattr(self, quantity)
        if roller is not None:
            name = name.replace("{j}", str(roller + self.first_roller))
        bare, unit = _split(name)
        if not unit:
            return [name], 1.0
        units = self.units_of(quantity)
        same = [f"{bare} [{other}]" for other, size in units.items() if size == units[unit] and other != unit]
        return [name, bare, *same], units[unit]


def _split(name):
    match = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]\s*", name)
    return (match[1], match[2].strip()) if match else (name, None)
