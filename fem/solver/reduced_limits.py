"""How long the reduced model's steps may be, and how its coupled forces are iterated: from contacts' compliances."""

from math import inf, pi, sqrt

import numpy as np

from fem.contacts.contact_law import LOAD_MARGIN
from fem.statics.reduced_bearing import ReducedBearing
from lagrange import Operation
from lagrange.contact.damping import ContactDamping
from lagrange.step_size import fastest_in_machine

LEFT = 0.2  # of what a guess was off by, the most that sweeps may leave with its sign turned
STIFFEST = 3.0  # times as stiff as under a LOAD_MARGIN-th of the force; the paper's bearing is 1.2 times


def time_of_dampers(model: ReducedBearing, force: float, operation: Operation, damping: ContactDamping) -> float:
    """The longest step, s, in which contacts' dampers, under forces of so many N, take half of a housing's motion.

    Damping forces act on the housing explicitly, after rollers and hub; infinite where the ring stands still.
    """
    housing, bearing = operation.mounting.housing, model.bearing
    if housing is None or not damping.acts:
        return inf
    coefficient = float(damping.coefficient(force, 1.0 / float(model.outer_law.softness(force))))
    return 2.0 * (housing.mass + bearing.outer_ring_mass) / (bearing.n_rollers * coefficient)


def _softness(model: ReducedBearing, force: float) -> np.ndarray:
    """Of a roller's two contacts under a force, N; (2, 2), m/N."""
    inner, outer = (float(law.softness(force)) for law in (model.inner_law, model.outer_law))
    return np.array([[inner, model.across], [model.across, outer]])


def _softness_below(model: ReducedBearing, force: float) -> tuple[np.ndarray, float]:
    """The same, and the force, which is less where that is beyond Hertz and contacts would push one another in."""
    soft = _softness(model, force)
    usual = np.linalg.eigvalsh(_softness(model, force / LOAD_MARGIN))[0]
    while np.linalg.eigvalsh(soft)[0] < usual / STIFFEST:
        force *= 0.5
        soft = _softness(model, force)
    return soft, force


def strongest_coupling(model: ReducedBearing, force: float) -> float:
    """Largest eigenvalue, >= 0, of what forces along the rings give, over rollers' own softness under a force, N.

    Of all contacts closed; of fewer it is no larger.
    """
    rings, n = model.rings, model.bearing.pockets
    waves = np.cos(2.0 * pi / n * np.multiply.outer(rings.distance, np.arange(n // 2 + 1)))
    along = rings.along @ waves  # (2, orders), every ring's eigenvalues
    stiff = np.linalg.inv(_softness_below(model, force)[0])
    return max(float(np.linalg.eigvals(stiff[:, :, None].T * along.T[:, None, :]).real.max()), 0.0)


def relaxation_factor(coupling: float) -> float:
    """Relaxation factor of the coupled force increments, by their `strongest_coupling`.

    1, which leaves −λ³ of the predictor's error and diverges from a third on; or, of strong couplings,
    as much as leaves −LEFT, λ²(1 − share (1 + λ)).
    """
    return 1.0 if coupling**3 <= LEFT else (1.0 + LEFT / coupling**2) / (1.0 + coupling)


def critical_time_step(model: ReducedBearing, force: float, tangential: np.ndarray, operation: Operation) -> float:
    """2/ω_max, s, with all contacts closed under a force, N, that stick: of a roller."""
    bearing, (soft, force) = model.bearing, _softness_below(model, force)
    stiff = np.linalg.inv(soft)
    pushed = np.array([-1.0, 1.0])
    radial = float(pushed @ stiff @ pushed) + 2.0 / float(model.between.softness(force))
    # of a traction the roller's own surface gives way by 3/m, and the other contact's by −1/m
    rocking = 4.0 / float(tangential.min())
    in_machine = fastest_in_machine(bearing, operation, *np.diag(stiff).tolist())
    return 2.0 / sqrt(max(max(radial, rocking) / bearing.roller_mass, in_machine**2))
