"""Looks at the samples of a run: what no sound one shows, contacts too wide for theory, the error of its energy."""

from typing import TYPE_CHECKING

import numpy as np

from fem.solver.solver import Samples
from lagrange import BallBearing, Bearing
from lagrange.contact.hertz import Side, contact_ellipse, contact_pairs
from lagrange.equations import nothing_carries, touching_distances
from lagrange.mounting import from_outer_ring
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.solver.elements.plan import ElementPlan


class EnergyAccount:
    """State of the energy balance's test, carried from block to block.

    An imbalance counts from the start, so where energy is dissipated it grows without bound, however small each step's
    part is. The state's own error does not: it is dissipated with the rest of the energy. When a run has dissipated as
    much as it exchanges, E, 1/e of an earlier error is left,

        error(t + dt) = error(t) exp(−dD/E) + d(imbalance),

    which is the imbalance itself where nothing is dissipated, and E times the share of the dissipated energy that is
    missing where that share is steady. The criterion is the same for a second and for an hour, and for an error late in
    a long run and at its start.
    """

    def __init__(self):
        self.exchanged = 0.0  # J, the most so far
        self._error, self._imbalance, self._dissipated = 0.0, 0.0, 0.0  # J, of the last sample

    def samples(self, values: dict[str, np.ndarray], imbalance: np.ndarray, exchanged: np.ndarray) -> Samples:
        """The next samples, whose imbalance since the start and exchanged energy, (n,), J, are given.

        How samples are cut into blocks changes no bit of them.
        """
        exchanged = np.fmax.accumulate(np.fmax(exchanged, self.exchanged))
        found = Samples(values=values, imbalance=imbalance, exchanged=exchanged, error=np.zeros(len(imbalance)))
        dissipated = values["work_dissipated"]
        left = np.exp(-np.fmax(np.diff(dissipated, prepend=self._dissipated), 0.0) / found.passed_on)
        added = np.diff(imbalance, prepend=self._imbalance)
        error = self._error
        found.error[:] = [
            error := error * kept + more for kept, more in zip(left.tolist(), added.tolist(), strict=True)
        ]
        self.exchanged, self._error = float(exchanged[-1]), float(found.error[-1])
        self._imbalance, self._dissipated = float(imbalance[-1]), float(dissipated[-1])
        return found

    def to_keep(self) -> list[float]:
        """What runs on; `take_back` takes it back."""
        return [self.exchanged, self._error, self._imbalance, self._dissipated]

    def take_back(self, kept: list[float]) -> None:
        """Go on where another account stood."""
        self.exchanged, self._error, self._imbalance, self._dissipated = map(float, kept)


IMBALANCE_LIMIT = 0.05  # of the exchanged energy; a sound run stays far below 1e-2
DOUBTFUL = 0.005  # of it: a run that ends says so
# Modes that grow balance too: leapfrog's kinetic energy ½ v(t − dt/2)·M·v(t + dt/2) goes to minus the stored one. In a
# mode of frequency ω it is −(ω dt/2)² of it at least, −0.98 at 0.99 of the critical step.
NEGATIVE_LIMIT = 0.98
ASTRAY = 0.05  # of a roller's radius, beyond the raceways: no elastic body deforms so far


def good_rows(rows: np.ndarray) -> int:
    """How many rows from the first are finite and were filled."""
    good = np.all(np.isfinite(rows), axis=1) & np.any(rows != 0.0, axis=1)
    return len(rows) if good.all() else int(np.argmin(good))


def n_balanced(samples: Samples) -> int:
    """How many samples from the first have an energy that balances."""
    stored = samples["energy_elastic"] + samples["energy_contact"]
    growing = (samples["energy_kinetic"] < -NEGATIVE_LIMIT * stored) & (stored > 0.5 * samples.exchanged)
    bad = ~(np.abs(samples.relative_error()) <= IMBALANCE_LIMIT) | growing
    return int(np.argmax(bad)) if bad.any() else len(bad)


def n_in_place(bearing: Bearing, give: float, samples: Samples) -> int:
    """How many samples from the first have rollers between the raceways and the hub between them, up to `give`, m."""
    reach, track = touching_distances(bearing)
    surfaces = profiles(bearing)
    give += 0.0 if surfaces is None else surfaces.deepest
    hub_x, hub_y, x, y = from_outer_ring(samples, "inner", "roller")
    x, y = x - hub_x[:, None], y - hub_y[:, None]
    astray = x * x + y * y < max(reach - give, 0.0) ** 2
    astray |= samples["roller_rho"] > track + give
    astray |= (np.hypot(hub_x, hub_y) > 2.0 * (abs(bearing.radial_clearance) + give))[:, None]
    return int(np.argmax(astray)) // bearing.n_rollers if astray.any() else len(astray)


def place_trouble(plan: "ElementPlan", samples: Samples, at: int) -> str:
    """What to say of a sample whose bodies are out of place."""
    hint = "without a cage a few rollers gather on one side: add a [cage], use more rollers or "
    if plan.scene.cage is not None:
        hint = "use a lighter load, more rollers, stiffer pockets of the cage or "
    hint = _bare(plan.model.bearing, samples, at) or f"{hint}contact.friction_coefficient above 0"
    return f"the bearing has come apart {_hub_then(plan.time_step, samples, at)}; {hint}"


def through_trouble(bearing: Bearing, time_step: float, samples: Samples, at: int) -> str:
    """What to say of a sample whose rigid bodies are in one another."""
    hint = _bare(bearing, samples, at) or "use a lighter load, more or larger rollers or a stiffer material"
    return f"rigid bodies have gone through one another {_hub_then(time_step, samples, at)}; {hint}"


def _bare(bearing: Bearing, samples: Samples, at: int) -> str | None:
    hub_x, hub_y = from_outer_ring(samples, "inner")
    return nothing_carries(bearing, samples["roller_theta"][at], (hub_x[at], hub_y[at]))


def _hub_then(time_step: float, samples: Samples, at: int) -> str:
    step, (hub_x, hub_y) = round(samples["time"][at] / time_step), from_outer_ring(samples, "inner")
    place = f"{1e3 * np.hypot(hub_x[at], hub_y[at]):.3g} mm from the centre"
    return f"at step {step}, t = {1e3 * samples['time'][at]:.5g} ms: the hub is {place}"


def energy_trouble(plan: "ElementPlan", samples: Samples, at: int) -> str:
    """What to say of a sample whose energy doesn't balance, or only grows."""
    step, imbalance = round(samples["time"][at] / plan.time_step), samples.relative_error()[at]
    fastest = int(np.argmax(np.abs(samples["roller_spin"][at] - plan.start.kinematics.roller)))
    where = f"at step {step}, t = {1e3 * samples['time'][at]:.5g} ms (roller {fastest} deviates most)"
    if abs(imbalance) <= IMBALANCE_LIMIT:
        return f"vibrations grow without end {where}: the time step is too long; lower numerics.time_step_safety"
    return (
        f"energy imbalance {100 * imbalance:.3g} % of the exchanged energy exceeds {100 * IMBALANCE_LIMIT:.0f} % "
        f"{where}; {plan.finer}"
    )


WIDEST_CONTACT = 0.1  # Hertz half-width over the roller's radius; the half-plane errs by about its square
LONGEST_CONTACT = 0.6  # a ball's contact ellipse along its groove over the radius; at C0 of deep-groove bearings 0.55
CONTACT_FORCES = ("inner_force", "outer_force", "roller_roller_force")  # in the order of `contact_pairs`


def largest_forces(samples: Samples) -> np.ndarray:
    """Largest force of any contact of each kind, (3,), N."""
    return np.array([samples[name].max(initial=0.0) for name in CONTACT_FORCES])


def run_warnings(bearing: Bearing, largest: np.ndarray) -> tuple[str, ...]:
    """Sentences on the largest forces of a run, (3,), N; what holds at rest need not hold in a shock."""
    if isinstance(bearing, BallBearing):
        return _ball_warnings(bearing, largest)
    pairs = zip(contact_pairs(bearing), largest.tolist(), strict=True)
    half_width, kind, force = max((pair.half_width(force), pair.kind, force) for pair, force in pairs)
    widest = WIDEST_CONTACT * bearing.roller_radius
    if half_width <= widest:
        return ()
    where = "between rollers" if kind == "roller" else f"on the {kind} raceway"
    return (
        f"the largest force of the run, {force:.4g} N {where}, makes a contact of half-width {1e3 * half_width:.3g} "
        f"mm, beyond Hertz's theory and small strains (at most {1e3 * widest:.3g} mm): {MISTRUST}",
    )


MISTRUST = (
    "forces and deformation there are unreliable; lower operation.radial_load_N, raise numerics.load_ramp_ms or use a "
    "stiffer material"
)


def _ball_warnings(bearing: BallBearing, largest: np.ndarray) -> tuple[str, ...]:
    sides: tuple[Side, Side] = ("inner", "outer")
    for side, force in zip(sides, largest.tolist(), strict=False):
        axes = contact_ellipse(bearing, side, force)
        limits = LONGEST_CONTACT * bearing.element_radius, WIDEST_CONTACT * bearing.element_radius
        if axes[0] > limits[0] or axes[1] > limits[1]:
            found, most = (" by ".join(f"{1e3 * axis:.3g}" for axis in each) for each in (axes, limits))
            where = f"{force:.4g} N on the {side} raceway"
            return (
                f"the largest force of the run, {where}, makes a contact ellipse with semi-axes of {found} mm, beyond "
                f"Hertz's theory and small strains (at most {most} mm): {MISTRUST}",
            )
    return ()
