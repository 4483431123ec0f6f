"""How often samples must be taken to follow the fastest vibration that moves."""

from math import inf, pi, sqrt

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.faults import Waviness
from lagrange.kinematics import kinematics
from lagrange.raceway_laws import contact_laws
from lagrange.scene_surfaces import own_radius

INTERVALS = (1e-5, 8e-6, 5e-6, 4e-6, 2.5e-6, 2e-6, 1.6e-6, 1.25e-6, 1e-6, 5e-7, 2e-7, 1e-7)  # s; rates of whole kHz
SAMPLES_OF_ROLLERS = 3.0  # a period: more than Nyquist's two, because their stiffness is estimated
SAMPLES_OF_THE_HUB = 5.0  # a period: a stencil of order 6 then reads 4 % of its acceleration too low
CLEARANCE = 1e-9  # of a roller's radius: less is the rounding of diameters


def fitting_interval(bearing: Bearing, operation: Operation, longest: float) -> float:
    """Interval between samples, s, at which neither the hub nor struck rollers vibrate beyond the Nyquist frequency.

    Rollers are struck that come through a clearance or a fault of a surface, and then vibrate between their two
    contacts. In a perfect bearing without clearance they touch as they come into the load zone, and hardly vibrate.

    Parameters
    ----------
    bearing : with its faults, without films
    longest : s, above which a warning of the bearing's faults would follow

    Errors
    ------
    Contacts are taken as stiff as under five times a roller's mean load: frequencies are right within some 20 %. The
    rings' own modes, at 150 kHz and more, are not followed.
    """
    rate = SAMPLES_OF_THE_HUB * hub_frequency(bearing, operation)
    if bearing.faults or bearing.radial_clearance > CLEARANCE * bearing.roller_radius:
        rate = max(rate, SAMPLES_OF_ROLLERS * roller_frequency(bearing, operation))
    fitting = (interval for interval in INTERVALS if interval * rate <= 1.0 and interval <= longest)
    return next(fitting, INTERVALS[-1])


def wave_interval(bearing: Bearing, operation: Operation) -> float:
    """The longest interval between samples, s, that shows contacts pass over waves; infinite without any."""
    ideal = kinematics(bearing, operation.fastest)
    speed = abs(ideal.roller - ideal.cage) * bearing.roller_radius
    waves = [pi * own_radius(bearing, f) / f.order for f in bearing.faults if isinstance(f, Waviness)]
    return min(waves) / speed if waves and speed > 0.0 else inf


def roller_frequency(bearing: Bearing, operation: Operation) -> float:
    """Of a roller between its two contacts where the load is largest, Hz."""
    return sqrt(sum(_stiffness(bearing, operation)) / bearing.roller_mass) / (2.0 * pi)


def hub_frequency(bearing: Bearing, operation: Operation) -> float:
    """Of the inner ring and its shaft on the contacts of the load zone: a half circle, with preload a whole one, Hz."""
    inner, outer = _stiffness(bearing, operation)
    preloaded = bearing.radial_clearance < -CLEARANCE * bearing.roller_radius
    share = 0.5 if preloaded else 0.25  # of all rollers' stiffness, along one direction
    in_series = inner * outer / (inner + outer) if inner + outer > 0.0 else 0.0  # soft laws without any load
    return sqrt(share * bearing.n_rollers * in_series / operation.inner_mass) / (2.0 * pi)


def _stiffness(bearing: Bearing, operation: Operation) -> tuple[float, float]:
    """Of the inner and the outer contact of the roller with the largest load, about five times the mean one, N/m."""
    cage = kinematics(bearing, operation.fastest).cage
    force = 5.0 * (operation.heaviest + operation.inner_mass * operation.gravity) / bearing.n_rollers
    force += bearing.roller_mass * (bearing.pitch_radius * cage**2 + operation.gravity)
    laws = contact_laws("hertz" if isinstance(bearing, BallBearing) else "johnson", bearing)
    inner, outer = (float(law.slope(law.approach(force))) for law in laws)
    return inner, outer
