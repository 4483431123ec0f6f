"""What a dashpot to the ground makes of a kick: exactly, whatever its strength."""

from math import exp, expm1


def flow(rate: float, mass: float, velocity: complex, acceleration: complex, seconds: float) -> tuple[complex, float]:
    """A mass's velocity after a kick, had its dashpot acted as well, and what that takes, J.

    Parameters
    ----------
    rate : of the dashpot over the mass, 1/s; mass : kg
    velocity : x + iy, m/s, after the kick; acceleration : m/s², by all else, constant in it; seconds : of the kick

    The dashpot takes what its mean force does on leapfrog's way, so that energies balance at any rate.
    """
    if rate == 0.0:
        return velocity, 0.0
    left, before = exp(-rate * seconds), velocity - seconds * acceleration
    slower = left * before - expm1(-rate * seconds) / rate * acceleration
    lost = 0.5 * mass * (slower - velocity).conjugate() * (before + slower)
    return slower, -lost.real
