"""From the clearance of the unmounted bearing to the operating one: fits, temperatures, spin, film. SI.

Rings, shaft and housing are tubes in plane stress (Lamé); what widens the inner raceway, or narrows the outer one,
takes clearance. Steps follow one another: fits at 20 °C and at rest, then temperatures, then spin. Each step changes
the interferences, so that the growth of a raceway by its fit is computed anew, and a fit that has opened presses no
more. Equation (1) of docs/clearance.md.
"""

from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np

from lagrange.bearing import Bearing, Material
from lagrange.kinematics import Kinematics

SLOW = 1e-4  # (ωr/c)², c the waves' speed: below, carrying around what has grown adds 2e-5 of it at most


def growths(bearing: Bearing, motion: Kinematics) -> tuple[float, float]:
    """How much the radii of the inner raceway and of free rollers grow as they spin, m."""
    inner = spinning_growth(bearing.inner_raceway_radius, bearing.bore_radius, bearing.inner_ring, motion.shaft)
    return inner, spinning_growth(bearing.roller_radius, 0.0, bearing.roller, motion.roller)


def outer_growth(bearing: Bearing, motion: Kinematics) -> float:
    """The same of the outer raceway, in a ring that is held around its outside, m."""
    return spinning_growth(bearing.outer_raceway_radius, bearing.outside_radius, bearing.outer_ring, motion.outer_ring)


def spinning_growth(radius: float, held_radius: float, material: Material, speed: float) -> float:
    """Radial displacement, m, of a free circle of a body that spins at a speed, rad/s.

    `held_radius`, m: a circle that does not give; 0: a solid disc. What has grown is carried around, too, where that
    matters. Errors: 2e-5 of the growth.

    Source: Timoshenko and Goodier, Theory of Elasticity, section 32, in plane strain: u = a r + b/r − ρω² r³/8(λ+2μ).
    """
    if material.rigid:
        return 0.0
    mu, lame = material.lame_mu, material.lame_lambda
    if material.density * (speed * radius) ** 2 > SLOW * (lame + 2.0 * mu):
        return _carried_growth(radius, held_radius, material, speed)
    cubic = -material.density * speed**2 / (8.0 * (lame + 2.0 * mu))
    # σ_rr = (λ + 2μ) u' + λ u/r, nothing at `radius`
    stress = [2.0 * (lame + mu), -2.0 * mu / radius**2]
    missing = -(3.0 * (lame + 2.0 * mu) + lame) * cubic * radius**2
    a, b = missing / stress[0], 0.0
    if held_radius > 0.0:
        a, b = np.linalg.solve([stress, [held_radius, 1.0 / held_radius]], [missing, -cubic * held_radius**3])
    return float(a * radius + b / radius + cubic * radius**3)


def _carried_growth(radius, held_radius, material, speed):
    """`spinning_growth` with (λ+2μ)(u'' + u'/r − u/r²) = −ρω²(r + u): r + u is a combination of J₁(kr) and Y₁(kr)."""
    from scipy.special import j0, j1, y0, y1  # takes its time to load, and most bodies are slow

    mu, lame = material.lame_mu, material.lame_lambda
    k = abs(speed) * sqrt(material.density / (lame + 2.0 * mu))

    def reaches(r):  # r + u of two solutions, near r and 1/r where k is small
        return np.array([2.0 / k * j1(k * r), -0.5 * pi * k * y1(k * r)])

    def slope(r):
        return np.array([2.0 * j0(k * r), -0.5 * pi * k**2 * y0(k * r)]) - reaches(r) / r

    stress = (lame + 2.0 * mu) * slope(radius) + lame / radius * reaches(radius)
    if held_radius == 0.0:
        weights = np.array([2.0 * (lame + mu) / stress[0], 0.0])
    else:
        weights = np.linalg.solve([stress, reaches(held_radius)], [2.0 * (lame + mu), held_radius])
    return float(weights @ reaches(radius) - radius)


REFERENCE_C = 20.0  # °C, at which sizes are given
STEEL_EXPANSION = 11.5e-6  # 1/K, of bearing steel


@dataclass(frozen=True, kw_only=True)
class Tube:
    """A round body between two diameters, m: 0 inside of a solid one, infinite outside of a very thick one."""

    inside: float
    outside: float
    material: Material

    def __post_init__(self):
        if not 0.0 <= self.inside < self.outside:
            raise ValueError(f"inside {self.inside:.6g} m must lie between 0 and the outside, {self.outside:.6g} m")

    @property
    def spread(self) -> float:
        """(b² + a²)/(b² − a²) of diameters a inside, b outside."""
        share = (self.inside / self.outside) ** 2
        return (1.0 + share) / (1.0 - share)

    @property
    def widening(self) -> float:
        """Of the inside by pressure in it, 1/Pa of its diameter."""
        return (self.spread + self.material.poisson_ratio) / self.material.youngs_modulus

    @property
    def through(self) -> float:
        """Widening of the outside by pressure inside, 1/Pa of its diameter.

        That of the inside by pressure outside is `through` + 2/E, and negative.
        """
        return (self.spread - 1.0) / self.material.youngs_modulus

    def spun(self, diameter: float, speed: float) -> float:
        """Growth of its inside's or outside's diameter, m, as it spins freely at a speed, rad/s.

        ρω² d/16E · [(3 + ν) e² + (1 − ν) d²], e the other diameter; of a thin ring ρω² d³/4E.

        Source: Timoshenko and Goodier, Theory of Elasticity (1970), section 32, rotating disc with a hole.
        """
        nu, other = self.material.poisson_ratio, self.inside if diameter == self.outside else self.outside
        square = (3.0 + nu) * other**2 + (1.0 - nu) * diameter**2
        return self.material.density * speed**2 * diameter * square / (16.0 * self.material.youngs_modulus)


def fit_pressure(inner: Tube, outer: Tube, interference: float) -> float:
    """Between a body and the one pressed on it, Pa, of an interference of diameters, m; 0 where that is not positive.

    Source: Lamé, as in Harris, Rolling Bearing Analysis (4th ed. 2001), chapter 3.
    """
    narrowing = (inner.spread - inner.material.poisson_ratio) / inner.material.youngs_modulus
    return max(interference, 0.0) / outer.inside / (narrowing + outer.widening)


@dataclass(frozen=True, kw_only=True)
class Fit:
    """What the rings sit on and in, and how warm all are. Interferences of diameters, m; temperatures, °C."""

    shaft_interference: float  # at 20 °C and at rest, < 0: loose
    housing_interference: float
    shaft_bore: float  # m, diameter; 0: solid
    housing_outside: float  # m, diameter; may be infinite
    shaft: Material
    housing: Material
    shaft_expansion: float  # 1/K
    ring_expansion: float
    roller_expansion: float
    housing_expansion: float
    shaft_C: float
    inner_ring_C: float
    rollers_C: float
    outer_ring_C: float
    housing_C: float


@dataclass(frozen=True, kw_only=True)
class OperatingClearance:
    """How a diametral clearance comes about: parts add up, negative ones take clearance. m, but for pressures."""

    given: float  # unmounted
    shaft_fit: float
    housing_fit: float
    temperature: float
    speed: float  # as rings and rollers spin, and what that changes of fits
    film: float
    rule_of_thumb: float  # temperature's part by α (T_inner − T_outer)(F + E)/2: rollers between both rings
    thin_ring: float  # speed's part by 2ρR³ω²/E of the inner raceway: a ring that nothing holds
    shaft_interference: float  # in operation; < 0: loose
    housing_interference: float
    shaft_pressure: float  # Pa, of the fit in operation
    housing_pressure: float
    grown: tuple[float, float, float]  # diameters of inner raceway, outer raceway, rollers, in operation

    @property
    def parts(self) -> dict[str, float]:
        """Names and values of what adds up."""
        names = "given", "shaft_fit", "housing_fit", "temperature", "speed", "film"
        return {name: getattr(self, name) + 0.0 for name in names}  # −0 of what a fit does not change

    @property
    def total(self) -> float:
        """In operation, diametral."""
        return sum(self.parts.values())

    def rows(self) -> list[tuple[str, str, str]]:
        """For people: what it is, µm, and what else is known of it."""

        def fit(gap, pressure):
            if pressure > 0.0:
                return f"in operation {_microns(gap):.4g} µm of interference, {1e-6 * pressure:.3g} MPa"
            return f"in operation loose by {_microns(-gap):.4g} µm" if gap < 0.0 else ""

        shaft = fit(self.shaft_interference, self.shaft_pressure)
        housing = fit(self.housing_interference, self.housing_pressure)
        thumb = f"rule of thumb α ΔT (F + E)/2: {_microns(self.rule_of_thumb):+.3f} µm" if self.rule_of_thumb else ""
        thin = f"ring held by nothing, 2ρR³ω²/E: {_microns(self.thin_ring):+.3f} µm" if self.thin_ring else ""
        names = "unmounted", "fit on the shaft", "fit in the housing", "temperatures", "spin", "lubricant's films"
        values = (f"{_microns(value):{'+' if k else ''}.3f}" for k, value in enumerate(self.parts.values()))
        rows = zip(names, values, ("", shaft, housing, thumb, thin, ""), strict=True)
        return [*rows, ("in operation", f"{_microns(self.total):.3f}", "")]


def _microns(value):
    """Of m, rounded; 0 has no sign."""
    return round(1e6 * value, 3) + 0.0


def operating_clearance(bearing: Bearing, fit: Fit, speed: float, roller_growth: float) -> OperatingClearance:
    """The build-up of a bearing of these sizes at 20 °C, without film.

    `speed` : of the inner ring, rad/s; `roller_growth` : m, of a roller's radius as it spins
    """
    sizes = bearing.inner_raceway_radius, bearing.outer_raceway_radius, bearing.roller_radius
    raceway, far, roller = (2.0 * size for size in sizes)
    shaft = Tube(inside=fit.shaft_bore, outside=2.0 * bearing.bore_radius, material=fit.shaft)
    inner = Tube(inside=shaft.outside, outside=raceway, material=bearing.inner_ring.elastic)
    outer = Tube(inside=far, outside=2.0 * bearing.outside_radius, material=bearing.outer_ring.elastic)
    housing = Tube(inside=outer.outside, outside=fit.housing_outside, material=fit.housing)

    inner_ring, outer_ring = fit.inner_ring_C - REFERENCE_C, fit.outer_ring_C - REFERENCE_C
    swell_in, swell_out = fit.ring_expansion * inner_ring, fit.ring_expansion * outer_ring
    cold = np.array([fit.shaft_interference, fit.housing_interference])
    swell_shaft, swell_housing = (e * (warm - REFERENCE_C) for e, warm in (
        (fit.shaft_expansion, fit.shaft_C), (fit.housing_expansion, fit.housing_C)))  # fmt: skip
    warm = np.add(cold, [(swell_shaft - swell_in) * shaft.outside, (swell_out - swell_housing) * housing.inside])
    spinning = np.add(warm, [shaft.spun(shaft.outside, speed) - inner.spun(inner.inside, speed), 0.0])
    pressures = [(fit_pressure(shaft, inner, a), fit_pressure(outer, housing, b)) for a, b in (cold, warm, spinning)]

    # growth of inner raceway, outer raceway, rollers, m: by the fits, then by temperatures, then by spin
    narrower = outer.through + 2.0 / outer.material.youngs_modulus
    grown = np.array([[inner.through * a * raceway, -narrower * b * far, 0.0] for a, b in pressures])
    grown[1:] += [swell_in * raceway, swell_out * far, fit.roller_expansion * (fit.rollers_C - REFERENCE_C) * roller]
    grown[2] += [inner.spun(raceway, speed), 0.0, 2.0 * roller_growth]
    gained = np.array([-1.0, 1.0, -2.0])  # of clearance, by growth
    return OperatingClearance(given=2.0 * bearing.radial_clearance, shaft_fit=-grown[0, 0], housing_fit=grown[0, 1],
        temperature=gained @ (grown[1] - grown[0]), speed=gained @ (grown[2] - grown[1]), film=0.0,
        rule_of_thumb=-fit.ring_expansion * (fit.inner_ring_C - fit.outer_ring_C) * 0.5 * (raceway + far),
        thin_ring=-inner.material.density * speed**2 * raceway**3 / (4.0 * inner.material.youngs_modulus),
        shaft_interference=spinning[0], housing_interference=spinning[1], shaft_pressure=pressures[2][0],
        housing_pressure=pressures[2][1], grown=tuple(grown[2].tolist()))  # fmt: skip


def in_operation(bearing: Bearing, found: OperatingClearance, own: tuple[float, float]) -> Bearing:
    """The bearing with the sizes that it has in operation.

    `own` : m, growth of the radii of inner raceway and rollers that the model itself gives to bodies as they spin
    """
    names, own_growths = ("inner_raceway_radius", "outer_raceway_radius", "roller_radius"), (own[0], 0.0, own[1])
    sizes = zip(names, found.grown, own_growths, strict=True)
    return replace(bearing, **{name: getattr(bearing, name) + 0.5 * grown - own for name, grown, own in sizes})
