"""The ideal bearing: geometry, materials, masses and operating point; the one description all others use.

Models compute the plane section of one row, at right angles to its lines of contact. With contact angle α, i rows that
share loads evenly, elements of diameter D on the pitch diameter d_m, it has circles of D cos α on d_m, which keep γ = D
cos α/d_m and so the speed of the cage, and raceways whose contacts run as fast as the bearing's. The hub's coordinates
are approaches: a radial displacement u of the shaft closes contacts by u cos α. Contact forces Q are the normal ones of
one row's elements; their radial parts Q cos α carry the load. By virtual work

    section's displacement = u cos α,   force = F/(i cos α),   stiffness, damping, mass = those over i cos²α,

gravity is g cos α, so that weights are forces too. An element has its mass times cos α, so that its centrifugal
force is the component along its contacts. Curvatures of contacts are the bearing's own, (1/D and cos α/R): see
`contact_pairs`.

Left out: the axial force Q sin α and the shift that it causes, so a second bearing, or row, must take it; a flange;
the change of α under load and speed, by which unloaded elements bear all of their centrifugal force at the outer
raceway; gyroscopic moments. Elements turn by 1/cos α too fast about their own axes; their inertia in strikes and
their weight are by cos α too small.

Source: Harris, Rolling Bearing Analysis (4th ed. 2001), chapters 7 (radial loads by cos α) and 8 (γ).
"""

from dataclasses import dataclass, replace
from math import cos, degrees, inf, pi, sin
from typing import Literal, NamedTuple

import numpy as np

from lagrange.load_history import LoadHistory
from lagrange.mounting import HELD, Mounting
from lagrange.surface.faults import Fault


@dataclass(frozen=True, kw_only=True)
class Material:
    """Isotropic linear elastic material. Pa, -, kg/m³.

    Where `rigid`, its body is taken as undeformable: its moduli are infinite, its share of any contact's approach 0.
    `youngs_modulus` stays the material's own.
    """

    youngs_modulus: float
    poisson_ratio: float
    density: float
    rigid: bool = False

    @property
    def elastic(self) -> "Material":
        """The same, not rigid."""
        return replace(self, rigid=False)

    @property
    def plane_strain_modulus(self) -> float:
        """E' = E/(1 − ν²), Pa."""
        return inf if self.rigid else self.youngs_modulus / (1.0 - self.poisson_ratio**2)

    @property
    def lame_lambda(self) -> float:
        """First Lamé constant (three-dimensional, hence plane strain), Pa."""
        E, nu = self.youngs_modulus, self.poisson_ratio
        return inf if self.rigid else E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    @property
    def lame_mu(self) -> float:
        """Shear modulus, Pa."""
        return inf if self.rigid else self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def dilatational_wave_speed(self) -> float:
        """Speed of plane dilatational waves, m/s."""
        return ((self.lame_lambda + 2.0 * self.lame_mu) / self.density) ** 0.5


# Of a solid shaft's radius, the part that meshes take as rigid: hub and loads then are nearest to the whole shaft's
CORE = 0.45


class OwnLaw(NamedTuple):
    """A contact law Q = K δ^n of the user's own; SI."""

    inner_stiffness: float  # K of one contact, N/m^n
    outer_stiffness: float
    exponent: float  # n
    range: str = "given"  # where it comes from, and how far it goes
    misfit: float = 0.0  # largest difference of its forces from those that it is fitted to, relative


@dataclass(frozen=True, kw_only=True)
class Bearing:
    """Plane section of one row of a roller bearing, see this module's text. Lengths in m.

    The x axis points right, y up; angles are counter-clockwise from +x.
    """

    n_rollers: int  # those that are there
    roller_radius: float
    roller_length: float
    inner_raceway_radius: float
    outer_raceway_radius: float
    bore_radius: float  # 0: a solid shaft is the inner ring
    outside_radius: float
    roller: Material
    inner_ring: Material
    outer_ring: Material
    faults: tuple[Fault, ...] = ()  # of surfaces; () are perfect circles
    own_law: OwnLaw | None = None  # of its contacts, beside the published ones
    contact_angle: float = 0.0  # rad; the section's circles are those of elements' diameters times its cosine
    rows: int = 1  # that share loads evenly
    missing: tuple[int, ...] = ()  # numbers, ascending, of the pockets without a roller

    def __post_init__(self):
        if not 0.0 <= self.bore_radius < self.inner_raceway_radius:
            raise ValueError(
                f"bore radius {self.bore_radius:.4g} m must lie between 0 (a solid shaft) and the inner raceway radius "
                f"{self.inner_raceway_radius:.4g} m"
            )
        if not self.outer_raceway_radius < self.outside_radius:
            raise ValueError(f"outside radius {self.outside_radius:.4g} m must exceed the outer raceway radius "
                f"{self.outer_raceway_radius:.4g} m")  # fmt: skip
        if self.n_rollers < 1 or self.roller_radius <= 0.0 or self.roller_length <= 0.0:
            raise ValueError("number, radius and length of the rollers must be positive")

    @property
    def pockets(self) -> int:
        """Places for rollers, equally spaced: Z."""
        return self.n_rollers + len(self.missing)

    @property
    def pocket(self) -> tuple[int, ...]:
        """Numbers of the rollers' pockets, (n_rollers,)."""
        return tuple(number for number in range(self.pockets) if number not in self.missing)

    @property
    def full(self) -> "Bearing":
        """The same with a roller in each pocket."""
        return replace(self, n_rollers=self.pockets, missing=())

    @property
    def period(self) -> float:
        """Angle of the cage, rad, after which the bearing looks the same."""
        return 2.0 * pi / (1 if self.missing else self.n_rollers)

    @property
    def core_radius(self) -> float:
        """Of what meshes and pictures have as the rigid hub, m: the bore's; of a solid shaft a part of its own."""
        return self.bore_radius or CORE * self.inner_raceway_radius

    @property
    def cosine(self) -> float:
        """Of the contact angle."""
        return cos(self.contact_angle)

    @property
    def contact_angle_deg(self) -> float:
        return degrees(self.contact_angle)

    @property
    def element_radius(self) -> float:
        """Of a rolling element itself, m: `roller_radius` is that of its circle in the section."""
        return self.roller_radius / self.cosine

    @property
    def radial_clearance(self) -> float:
        """Gap left at the outer raceway when a roller touches the inner one of a centred bearing, m; < 0 is preload."""
        return self.outer_raceway_radius - self.inner_raceway_radius - 2.0 * self.roller_radius

    @property
    def pitch_radius(self) -> float:
        """Mean radius of the rollers' centres, m."""
        return 0.5 * (self.inner_raceway_radius + self.outer_raceway_radius)

    @property
    def roller_mass(self) -> float:
        """Mass of one roller, kg."""
        return self.roller.density * pi * self.roller_radius**2 * self.roller_length

    @property
    def inner_ring_mass(self) -> float:
        """Mass of the inner ring alone (bore to raceway), kg."""
        area = pi * (self.inner_raceway_radius**2 - self.bore_radius**2)
        return self.inner_ring.density * area * self.roller_length

    @property
    def outer_ring_mass(self) -> float:
        """Mass of the outer ring alone (raceway to outside), kg."""
        area = pi * (self.outside_radius**2 - self.outer_raceway_radius**2)
        return self.outer_ring.density * area * self.roller_length


@dataclass(frozen=True, kw_only=True)
class BallBearing(Bearing):
    """A deep-groove ball bearing at zero contact angle. Lengths in m.

    The balls are the "rollers" of `Bearing`, raceway radii those of groove bottoms, `roller_length` the rings' width.
    """

    inner_groove_radius: float  # of the groove's cross-section, r_I
    outer_groove_radius: float  # r_O

    def __post_init__(self):
        super().__post_init__()
        for side, groove in (("inner", self.inner_groove_radius), ("outer", self.outer_groove_radius)):
            if not groove > self.element_radius:
                raise ValueError(
                    f"{side} groove radius {groove:.4g} m must exceed the ball radius {self.element_radius:.4g} m; "
                    "usual is 1.02 to 1.08 times it"
                )

    @property
    def roller_mass(self) -> float:
        """Mass of one ball, kg."""
        return self.roller.density * 4.0 / 3.0 * pi * self.roller_radius**3


class RowLoads(NamedTuple):
    """Axial load and moment on rows at rest, and the parts and mounting that carry them. SI."""

    arrangement: Literal["back_to_back", "face_to_face"] | None  # of two mirrored rows; None: all rows are alike
    row_distance: float  # of their middles; 0 without arrangement
    preload: float  # axial force between them without load
    flange_height: float | None  # of both rings, of cylindrical rollers
    axial_load: float  # on the hub, along +z
    moment: float | None  # on the hub about x, > 0 tilts the +z end towards the load; None: the tilt is held
    tilt: float  # where it is held, rad, > 0: the +z end towards the load


@dataclass(frozen=True, kw_only=True)
class Operation:
    """How the bearing is run. The load acts on the centre of the inner ring."""

    speed: float  # of the inner ring, rad/s, counter-clockwise positive
    radial_load: float  # N, along −y
    inner_mass: float  # inner ring and shaft, m_in + m_R, kg
    gravity: float  # m/s²
    first_roller_angle: float  # of roller 0, rad from +x
    mounting: Mounting = HELD
    side_load: float = 0.0  # N, along +x
    misalignment: float = 0.0  # slope of the shaft in the plane of the load, rad; > 0: its +z end towards the load
    history: LoadHistory | None = None  # how speeds and loads, which are those at t = 0, go on; None: they stay
    outer_speed: float = 0.0  # of the outer ring, which turns about its fixed centre, rad/s

    def at(self, time) -> "Operation":
        """What acts at a time, s, without a history; at times, (n_times,), speed and loads are such arrays."""
        if self.history is None:
            return self
        (x, y), (speed, outer_speed) = self.history.force(time), self.history.ring_speeds(time)
        return replace(self, speed=speed, outer_speed=outer_speed, radial_load=-y, side_load=x, history=None)

    @property
    def ring_speeds(self) -> tuple[float, float]:
        """Of the inner and of the outer ring, rad/s."""
        return self.speed, self.outer_speed

    @property
    def heaviest(self) -> float:
        """The largest load, N, or a bound of it."""
        return self.radial_load if self.history is None else self.history.heaviest

    @property
    def fastest(self) -> float:
        """The highest speed of a ring either way, rad/s."""
        return float(max(np.abs(speeds).max() for speeds in self.ring_speeds_met))

    @property
    def ring_speeds_met(self) -> tuple[np.ndarray, np.ndarray]:
        """Speeds of both rings wherever one is highest or lowest, rad/s, (n,) each."""
        if self.history is None:
            return np.array([self.speed]), np.array([self.outer_speed])
        return self.history.ring_speeds_met

    @property
    def varies_speed(self) -> bool:
        return self.history is not None and self.history.varies_speed

    @property
    def is_steady(self) -> bool:
        """Whether neither speeds nor loads change, in size or direction."""
        return self.history is None or self.history.is_steady


Guidance = Literal["rollers", "inner_ring", "outer_ring"]


@dataclass(frozen=True, kw_only=True)
class Cage:
    """A rigid ring with one pocket for each roller, equally spaced; SI.

    Guided by rollers it has round pockets, which hold them along the radius too. Guided by a ring its pockets have flat
    walls across the pitch circle, and its bore meets the inner ring, or its outside the outer one, at the raceway.
    """

    mass: float
    inertia: float  # kg m², about its centre
    pocket_clearance: float  # m, on both sides of a roller together
    guidance: Guidance
    guidance_clearance: float | None  # m, of diameters; None: rollers guide it
    stiffness: float  # N/m, of every contact of the cage
    damping: float  # N s/m, of every closed contact; never makes one pull
    friction_coefficient: float
    drag_torque: float  # N m, against the cage's rotation


def room_between_rollers(bearing: Bearing) -> float:
    """Between the surfaces of neighbouring rollers on the pitch circle, m; infinite for a single one."""
    if bearing.pockets == 1:
        return inf
    return 2.0 * (bearing.pitch_radius * sin(pi / bearing.pockets) - bearing.roller_radius)


def is_plain(bearing: Bearing) -> bool:
    """Whether the bearing is its own section: one row at contact angle 0."""
    return bearing.contact_angle == 0.0 and bearing.rows == 1


def load_factor(bearing: Bearing) -> float:
    """A radial load of the bearing over that of its section, i cos α."""
    return bearing.rows * bearing.cosine


def stiffness_factor(bearing: Bearing) -> float:
    """Radial stiffness, damping or mass of the bearing over that of its section, i cos²α."""
    return bearing.rows * bearing.cosine**2


def section_operation(bearing: Bearing, operation: Operation) -> Operation:
    """What acts in the section where `operation` acts on the bearing."""
    if is_plain(bearing):
        return operation
    load, stiffness, history = load_factor(bearing), stiffness_factor(bearing), operation.history
    if history is not None:
        of_section = type(history.load)(history.load.c / load, history.load.x)
        unbalance, rotating = history.unbalance / load, history.rotating_load / load
        history = replace(history, load=of_section, unbalance=unbalance, rotating_load=rotating)
    return replace(operation, radial_load=operation.radial_load / load, side_load=operation.side_load / load,
        inner_mass=operation.inner_mass / stiffness, gravity=operation.gravity * bearing.cosine,
        mounting=section_mounting(bearing, operation.mounting), history=history)  # fmt: skip


def section_mounting(bearing: Bearing, mounting: Mounting) -> Mounting:
    """Springs, dashpots and housing as the section has them."""
    share, found = 1.0 / stiffness_factor(bearing), {}
    for name in ("shaft", "housing"):
        if (body := getattr(mounting, name)) is not None:
            found[name] = replace(body, **{key: share * value for key, value in vars(body).items()})
    return replace(mounting, **found)


def section_words(bearing: Bearing) -> str:
    """What the section is of, for people; empty of a plain one."""
    if is_plain(bearing):
        return ""
    rows = "one row" if bearing.rows == 1 else f"one of {bearing.rows} rows"
    return (
        f"of {rows} at right angles to its contacts, contact angle {bearing.contact_angle_deg:.4g}°: forces are normal "
        f"ones of its elements, the radial load over {load_factor(bearing):.4g}; displacements are radial ones times "
        f"{bearing.cosine:.4g}"
    )
