"""The film between rollers and raceways under their largest loads, and λ. SI."""

from dataclasses import dataclass

from lagrange.bearing import Bearing
from lagrange.contact.raceway_laws import contact_pairs
from lagrange.kinematics import kinematics
from lagrange.rating.sources import Unavailable
from lagrange.surface.film import Lubricant, film_thickness


@dataclass(frozen=True, kw_only=True)
class Films:
    """Least thickness at each raceway, m."""

    inner: float
    outer: float

    @property
    def thinner(self) -> float:
        return min(self.inner, self.outer)


def films(bearing: Bearing, speed: float, lubricant: Lubricant, inner_load: float, outer_load: float) -> Films:
    """Of the most loaded rollers, loads in N, at a speed of one ring against the other, rad/s.

    Errors
    ------
    Unavailable: nothing rolls.
    """
    ideal = kinematics(bearing, speed)
    rolling = (ideal.roller - ideal.cage) * bearing.roller_radius
    if rolling == 0.0 or not min(inner_load, outer_load) > 0.0:
        raise Unavailable("the bearing does not turn or carries no load: no film forms")
    inner, outer, _ = contact_pairs(bearing)
    return Films(
        inner=film_thickness(inner, rolling, inner_load, lubricant),
        outer=film_thickness(outer, rolling, outer_load, lubricant),
    )
