"""Looks at the samples of a run: what no sound one shows, contacts too wide for theory, the error of its energy.

And in a run of the reduced model contacts too wide for the laws, and how far a hub's vibration is off because elastic
rings have no mass there.

A hub of mass M (its ring's with it) vibrates at ω on contacts and rings with the total compliance c. In the
model 1/(M ω²) = c, where c holds the rings' statics, Σ (s + h)²/ω_k² of all modes of one wave around: s the raceway's
displacement in a mode, h the hub's. With their mass

1/(M ω²) = c − Σ (s + h)²/ω_k² + Σ s²/(ω_k² − ω²)

for the inner ring on the hub, and for the outer one, h = 0, likewise. What frequency the model has is what the run
itself shows: the hub's mean squared acceleration over its mean squared velocity.
"""

from math import hypot, inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from fem.solver.solver import Samples
from lagrange import BallBearing, Bearing
from lagrange.contact.hertz import Side, contact_ellipse, contact_pairs
from lagrange.equations import nothing_carries, touching_distances
from lagrange.first_state import Problem
from lagrange.mounting import from_outer_ring
from lagrange.step_size import critical_time_step, fastest_mode
from lagrange.surface.deviation import profiles

if TYPE_CHECKING:
    from fem.statics.contact_balance import Condensed


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
        self.sums = np.zeros(4)  # J: the most exchanged so far; of the last sample error, imbalance, dissipated energy

    def samples(self, values: dict[str, np.ndarray], imbalance: np.ndarray, exchanged: np.ndarray) -> Samples:
        """The next samples, whose imbalance since the start and exchanged energy, (n,), J, are given.

        How samples are cut into blocks changes no bit of them.
        """
        most, error, last, given = self.sums.tolist()
        exchanged = np.fmax.accumulate(np.fmax(exchanged, most))
        found = Samples(values=values, imbalance=imbalance, exchanged=exchanged, error=np.zeros(len(imbalance)))
        dissipated = values["work_dissipated"]
        left = np.exp(-np.fmax(np.diff(dissipated, prepend=given), 0.0) / found.energy_scale).tolist()
        added = np.diff(imbalance, prepend=last).tolist()
        found.error[:] = [error := error * kept + more for kept, more in zip(left, added, strict=True)]
        self.sums[:] = exchanged[-1], error, imbalance[-1], dissipated[-1]
        return found


IMBALANCE_LIMIT = 0.05  # of the exchanged energy; a sound run stays far below 1e-2
DOUBTFUL = 0.005  # of it: a run that ends says so
# Modes that grow balance too: leapfrog's kinetic energy ½ v(t − dt/2)·M·v(t + dt/2) goes to minus the stored one. In a
# mode of frequency ω it is −(ω dt/2)² of it at least, −0.98 at 0.99 of the critical step.
NEGATIVE_LIMIT = 0.98
ASTRAY = 0.05  # of a roller's radius, beyond the raceways: no elastic body deforms so far


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


def place_trouble(bearing: Bearing, time_step: float, samples: Samples, at: int, what: str, hint: str) -> str:
    """What to say of a sample whose bodies are out of place; `hint` : what to do, where something carries."""
    step, (hub_x, hub_y) = round(samples["time"][at] / time_step), from_outer_ring(samples, "inner")
    hint = nothing_carries(bearing, samples["roller_theta"][at], (hub_x[at], hub_y[at])) or hint
    return (
        f"{what} at step {step}, t = {1e3 * samples['time'][at]:.5g} ms: the hub is "
        f"{1e3 * np.hypot(hub_x[at], hub_y[at]):.3g} mm from the centre; {hint}"
    )


def energy_trouble(time_step: float, rolling: float, finer: str, samples: Samples, at: int) -> str:
    """What to say of a sample whose energy doesn't balance, or only grows; `rolling` : of rollers that roll, rad/s."""
    step, imbalance = round(samples["time"][at] / time_step), samples.relative_error()[at]
    fastest = int(np.argmax(np.abs(samples["roller_spin"][at] - rolling)))
    where = f"at step {step}, t = {1e3 * samples['time'][at]:.5g} ms (roller {fastest} deviates most)"
    if abs(imbalance) <= IMBALANCE_LIMIT:
        return f"vibrations grow without end {where}: the time step is too long; lower numerics.time_step_safety"
    return (
        f"energy imbalance {100 * imbalance:.3g} % of the exchanged energy exceeds {100 * IMBALANCE_LIMIT:.0f} % "
        f"{where}; {finer}"
    )


WIDEST_CONTACT = 0.1  # Hertz half-width over the roller's radius; the half-plane errs by about its square
LONGEST_CONTACT = 0.6  # a ball's contact ellipse along its groove over the radius; at C0 of deep-groove bearings 0.55
CONTACT_FORCES = ("inner_force", "outer_force", "roller_roller_force")  # in the order of `contact_pairs`


def largest_forces(samples: Samples) -> np.ndarray:
    """Largest force of any contact of each kind, (3,), N."""
    return np.array([samples[name].max(initial=0.0) for name in CONTACT_FORCES])


MISTRUST = (
    "beyond Hertz's theory and small strains (at most {} mm): forces and deformation there are unreliable; lower "
    "operation.radial_load_N, raise numerics.load_ramp_ms or use a stiffer material"
)


def run_warnings(bearing: Bearing, largest: np.ndarray) -> tuple[str, ...]:
    """Sentences on the largest forces of a run, (3,), N; what holds at rest need not hold in a shock."""
    if isinstance(bearing, BallBearing):
        limits = LONGEST_CONTACT * bearing.element_radius, WIDEST_CONTACT * bearing.element_radius
        sides: tuple[Side, Side] = ("inner", "outer")
        for side, force in zip(sides, largest.tolist(), strict=False):
            axes = contact_ellipse(bearing, side, force)
            if axes[0] > limits[0] or axes[1] > limits[1]:
                found, most = (" by ".join(f"{1e3 * axis:.3g}" for axis in each) for each in (axes, limits))
                return (
                    f"the largest force of the run, {force:.4g} N on the {side} raceway, makes a contact ellipse with "
                    f"semi-axes of {found} mm, {MISTRUST.format(most)}",
                )
        return ()
    pairs = zip(contact_pairs(bearing), largest.tolist(), strict=True)
    half_width, kind, force = max((pair.half_width(force), pair.kind, force) for pair, force in pairs)
    widest = WIDEST_CONTACT * bearing.roller_radius
    if half_width <= widest:
        return ()
    where = "between rollers" if kind == "roller" else f"on the {kind} raceway"
    return (
        f"the largest force of the run, {force:.4g} N {where}, makes a contact of half-width {1e3 * half_width:.3g} "
        f"mm, {MISTRUST.format(f'{1e3 * widest:.3g}')}",
    )


JUDGED = 0.5e-3  # s from the start
SHOCKED = 5.0  # times the largest static force: of 670 sound random starts one reached it, of 25 wrong ones 23
STABLE = 1.4  # ω·step of the stiffest mode met; leapfrog is stable up to 2
ENERGY_TOLERANCE = 1e-2  # where contacts rattle, each impact lasting a few steps; else errors are 1e-6 of it
SURE = 1e-13  # of the kinetic energy: what it rounds to
MET = ("inner_force", "outer_force", "energy_contact", "energy_error", "least_moved", "largest_moved", "dissipated",
       "first_kinetic", "first_force", "soon_force")  # fmt: skip


class Judge:
    """What the samples of a run have met so far, of a problem and a step, s."""

    def __init__(self, problem: Problem, step: float):
        self._problem, self._step = problem, step
        # forces, N: the largest, of the first sample, and within JUDGED of it; energies, J
        self.met = dict.fromkeys(MET, 0.0) | {"least_moved": inf, "largest_moved": -inf}

    def meet(self, samples: Samples) -> None:
        """Take the next samples into account."""
        met, names = self.met, ("energy_kinetic", "energy_shaft", "energy_support")
        moved = np.sum([samples[name] for name in names if samples.get(name) is not None], axis=0)
        forces = np.fmax(samples["inner_force"].max(axis=1), samples["outer_force"].max(axis=1))
        for name in ("inner_force", "outer_force", "energy_contact", "energy_error"):
            values = samples.imbalance if name == "energy_error" else samples[name]
            met[name] = max(met[name], float(np.abs(values).max()))
        met["least_moved"] = min(met["least_moved"], float(moved.min()))
        met["largest_moved"] = max(met["largest_moved"], float(moved.max()))
        met["dissipated"] = float(samples["work_dissipated"][-1])
        if samples["time"][0] == 0.0:
            met["first_kinetic"], met["first_force"] = float(samples["energy_kinetic"][0]), float(forces[0])
        met["soon_force"] = float(forces[samples["time"] <= JUDGED].max(initial=met["soon_force"]))

    @property
    def critical_time_step(self) -> float:
        """Under the largest forces so far, s."""
        return critical_time_step(self._problem, self.met["inner_force"], self.met["outer_force"])

    @property
    def too_fast(self) -> str | None:
        """A sentence where the stiffest mode under the largest forces so far is too fast for the step."""
        omega = fastest_mode(self._problem, self.met["inner_force"], self.met["outer_force"])
        if omega * self._step < STABLE:
            return None
        return (
            f"the forces met make a mode of {omega / (2 * pi):.3g} Hz, too fast for the step of {self._step:.3g} s; "
            f"set time_step = {0.5 * STABLE / omega:.2g} or less"
        )

    @property
    def rattling(self) -> str | None:
        """A sentence where the energy errs by much of what contacts and dampers took and motion gained or lost."""
        met, step = self.met, self._step
        if met["energy_error"] <= SURE * met["first_kinetic"]:
            return None
        moved = met["largest_moved"] - met["least_moved"]
        share = met["energy_error"] / (met["energy_contact"] + moved + met["dissipated"])
        if share <= ENERGY_TOLERANCE:
            return None
        return (
            f"contacts rattle: the step of {step:.3g} s changes the energy by {100 * share:.2g} % of what the contacts "
            f"pass on; set time_step = {step / 4:.2g} or less, or add damping"
        )

    def warnings(self, largest: np.ndarray) -> tuple[str, ...]:
        """Sentences on a start that does not last, and contacts too wide for their laws; `largest` : (3,), N."""
        problem, first, soon = self._problem, self.met["first_force"], self.met["soon_force"]
        bearing, found = problem.bearing, [problem.first_state.warning]
        steady = problem.operation.is_steady and not bearing.faults
        if problem.start == "equilibrium" and steady and soon > SHOCKED * first:  # energy can't show a wrong start
            found.append(
                f"within {1e3 * JUDGED:g} ms of the start a contact carries {soon:.4g} N, "
                f"{soon / first if first else inf:.2g} times the largest static force: the motion does not "
                "start in equilibrium; leave out the beginning (check-residual --start), or add contact damping"
            )
        # a law that is softer than Hertz's lets bodies overlap far
        sides = zip(("inner", "outer"), problem.laws, largest.tolist(), strict=False)
        depth, side = max((float(law.approach(force)), side) for side, law, force in sides)
        most, wide = ASTRAY * bearing.roller_radius, run_warnings(bearing, largest)
        if not wide and depth > most:
            found.append(
                f"the largest force makes bodies overlap by {1e3 * depth:.3g} mm on the {side} raceway, which is no "
                f"small approach (at most {1e3 * most:.3g} mm here): places and forces near such contacts are not to "
                "be trusted; take a stiffer contact law or a lighter load"
            )
        return (*filter(None, found), *wide)


NARROW_CONTACT = 0.03  # half-width over the roller's radius: below, laws err by some thousandths of the approach
LARGEST_LAW_ERROR = 0.005  # of an approach, before a run says so
BY_PRESSURE = 2.0  # times: what the pressure's change adds to `law_error`


def law_warning(contacts: "Condensed", largest: np.ndarray) -> str | None:
    """A sentence where a run's largest forces, (3,), N, make a raceway's law err by more than LARGEST_LAW_ERROR."""
    from fem.statics.exact_statics import law_error  # with much that runs of the Lagrangian model do not need

    bearing, worst = contacts.bearing, (0.0, 0.0, "")
    for law, force in zip((contacts.inner_law, contacts.outer_law), largest.tolist(), strict=False):
        width = law.pair.half_width(force) / bearing.roller_radius
        if NARROW_CONTACT < width < 1.0:
            worst = max(worst, (BY_PRESSURE * abs(law_error(bearing, law, force)), force, law.pair.kind))
    error, force, kind = worst
    if error <= LARGEST_LAW_ERROR:
        return None
    return (
        f"under the largest force of the run, {force:.4g} N, the contact on the {kind} raceway is so wide that its law "
        f"is about {100.0 * error:.1g} % too stiff: forces and hub displacement are off by as much, with few loaded "
        "rollers by twice that; lower operation.radial_load_N or use a stiffer material"
    )


LARGEST_ERROR = 0.005  # of the hub's displacement: share of the frequency that is off, times share that vibrates
NOTHING = 1e-10  # m, an atom's radius: hubs that are displaced by less are where they should be
COUNT, X, Y, SQUARE, VELOCITY, ACCELERATION = range(6)  # of sums over samples: their number, SI


def add_samples(sums: np.ndarray, samples: Samples) -> None:
    """Add samples to (6,) sums, one after another, so that blocks of any size give the same."""
    x, y, vx, vy, ax, ay = (samples[f"inner_{name}"] for name in ("x", "y", "vx", "vy", "ax", "ay"))
    terms = np.stack([np.ones_like(x), x, y, x**2 + y**2, vx**2 + vy**2, ax**2 + ay**2])
    sums[:] = np.cumsum(np.column_stack([sums, terms]), axis=1)[:, -1]


def frequency_error(bearing: Bearing, hub_mass: float, omega: float, least: float = 0.0) -> float:
    """Share by which a hub of so many kg, its ring with it, vibrates faster than at ω, rad/s, which the model gives it.

    Infinite where the model's is so fast that rings have modes below; 0 where it is no more than `least`. Errors:
    rollers are taken for massless, contacts for closed and of one stiffness.
    """
    from fem.elastic.continuum import ring_sections
    from fem.elastic.vibration import shift_vibrations

    # modes of the inner ring on the hub and of the held outer ring that shift their raceways
    sections, length, hub = ring_sections(bearing), bearing.roller_length, hub_mass - bearing.inner_ring_mass
    solid = bearing.bore_radius == 0.0  # its load and its mass act all over it
    inner, outer = shift_vibrations(sections[0], length, None if solid else hub), shift_vibrations(sections[1], length)
    modes = inner.frequency**2
    static = np.sum((inner.shape + inner.carried) ** 2 / modes) + np.sum((outer.shape / outer.frequency) ** 2)
    soft = 1.0 / (hub_mass * omega**2) - static  # of all else

    def gives_way(square):
        of_inner = soft - 1.0 / (hub_mass * square) + np.sum(inner.shape**2 / (modes - square))
        return of_inner + np.sum(outer.shape**2 / (outer.frequency**2 - square))

    below, above = 1e-6 * omega**2, (1.0 - 1e-9) * min(modes[0], outer.frequency[0] ** 2)
    if not omega**2 < above or gives_way(below) >= 0.0:
        return inf
    enough = (1.0 + least) ** 2 * omega**2
    if enough < above and gives_way(enough) >= 0.0:
        return 0.0
    from scipy.optimize import brentq  # takes its time to load, and few hubs vibrate so

    return sqrt(brentq(gives_way, below, above)) / omega - 1.0


def vibration_warning(bearing: Bearing, hub_mass: float, sums: np.ndarray) -> str | None:
    """A sentence where the hub's vibration is off by more than LARGEST_ERROR of its displacement."""
    count = max(sums[COUNT], 1.0)
    size, still = sqrt(sums[SQUARE] / count), hypot(sums[X], sums[Y]) / count
    vibrates = sqrt(max(size**2 - still**2, 0.0)) / max(size, NOTHING)
    if size < NOTHING or sums[VELOCITY] == 0.0 or vibrates < LARGEST_ERROR:
        return None
    omega = sqrt(sums[ACCELERATION] / sums[VELOCITY])
    error = min(frequency_error(bearing, hub_mass, omega, LARGEST_ERROR / vibrates), 1.0)
    if error * vibrates < LARGEST_ERROR:
        return None
    off = f"{100.0 * error:.2g} % too slow" if error < 1.0 else "far too slow"
    return (
        f"{100.0 * vibrates:.0f} % of the hub's displacement is vibration, at {1e-3 * omega / (2.0 * pi):.2g} kHz: "
        f"{off}, because the rings have no inertia of their own in the reduced model; the hub's mean displacement may "
        f'be off by {100.0 * error * vibrates:.2g} %; if that matters use model = "fem"'
    )
