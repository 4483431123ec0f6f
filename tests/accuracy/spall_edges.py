"""One crossing of a spall by the contact law with soft edges, against half-planes pressed on the bare profile.

`python -m tests.accuracy.spall_edges` prints a table; `--write` puts it into docs/measurements/spalls.md.
Two minutes of a processor.

A roller of the paper's bearing passes the load line between a raceway with a spall and a sound one; the hub stays
where 2000 N hold it. Slowly, so that forces balance at every place; and at 4500 rpm, where the roller's inertia and
centrifugal force let it fly and strike. Both raceways have Johnson's law, the spalled one besides what the law or the
yardstick makes of the spall. From the strike on the roller may bounce: peak and impulse are those of all pulses from
the first touch after the release to a quarter of a millimetre beyond the exit edge.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import brentq

from lagrange import contact_laws, static_equilibrium
from lagrange.contact.hertz import contact_pairs
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.edges import softened
from lagrange.surface.faults import Spall
from tests.measurements import markdown_table, program
from tests.reference.continua import EdgeContact

BEARING, OPERATION = Scene().ideal_bearing(), Scene().ideal_operation()
LAWS = contact_laws("johnson", BEARING)
MOTION = kinematics(BEARING, OPERATION.speed)
SPEED = abs(MOTION.roller - MOTION.cage) * BEARING.roller_radius  # m/s, of contacts along both raceways
HUB = -static_equilibrium(BEARING, replace(OPERATION, gravity=0.0), LAWS, roller_mass=0.0).y  # m, down
BESIDE = 0.25e-3  # m, of the way before and after the spall
STEP, TICK = 2e-6, 0.1e-6  # m of the slow way; s of the fast one
DEEPEST = 12e-6  # m, approach
WIDTHS = 0.5e-3, 1e-3
EDGE_RADIUS = 1e-4

Force = Callable[[float, float], float]  # N, at a place, m, and an approach from the sound raceway, m


class Crossing(NamedTuple):
    """A raceway with a deep spall in its middle, and what its contacts with a roller may be."""

    body: str
    half: float  # m, half the opening
    sound: object  # the spalled raceway's own law
    other: object  # the other raceway's law
    laws: dict[str, Force]


def crossing(body: str, width: float) -> Crossing:
    """By half-planes on the bare profile, by the law with its soft edges, by the sinkage alone."""
    is_outer = body == "outer_ring"
    spall = Spall(body=body, roller=None, angle=0.0, width=width, depth=1e-4, edge_radius=EDGE_RADIUS)
    half, pair = spall.half_opening(BEARING.roller_radius), contact_pairs(BEARING)[1 if is_outer else 0]
    sound, other = (LAWS.outer, LAWS.inner) if is_outer else LAWS
    grid = np.linspace(-half - BESIDE, half + BESIDE, 8001)
    surfaces = profiles(replace(BEARING, faults=(spall,)))
    at = np.repeat(np.arcsin(grid / abs(pair.radii[0]))[:, None], BEARING.n_rollers, axis=1)
    met = (surfaces.outer if is_outer else surfaces.inner)(at, Turns())
    sinkage, compliance = met.sinkage[:, 0], met.compliance[:, 0]
    yardstick = EdgeContact(
        radius=pair.radii[0], roller_radius=BEARING.roller_radius, compliance=pair.line_compliance,
        level=0.5 * sound.level, half_opening=half, edge_radius=EDGE_RADIUS, beside=2.0 * BESIDE,
    )  # fmt: skip
    ratio, sunk = _ratios(yardstick, sound), np.array([max(yardstick.gaps(x).min(), 0.0) for x in grid])

    def bare(place, approach):
        deep = approach - np.interp(place, grid, sunk)
        return float(sound.force(deep) * ratio((abs(place), deep))) if deep > 0.0 else 0.0

    def by_law(place, approach, soft=1.0):
        law = softened(sound, soft * np.interp(place, grid, compliance)) if soft else sound
        return float(law.force(approach - np.interp(place, grid, sinkage)))

    laws = {"half-planes": bare, "law with soft edges": by_law, "sinkage alone": partial(by_law, soft=0.0)}
    return Crossing(body, half, sound, other, laws)


def _ratios(yardstick: EdgeContact, sound) -> RegularGridInterpolator:
    """Forces of the yardstick over those of the sound law, by place and approach beyond the sinkage."""
    half = yardstick.half_opening
    middle, edge = np.arange(0.0, 40e-6, 2e-6), half + np.arange(-40e-6, 100e-6, 5e-6)
    place = np.unique(np.concatenate([middle, np.linspace(40e-6, half - 45e-6, 16), edge, [half + BESIDE]]))
    deep = np.concatenate([[0.02e-6], np.geomspace(0.1e-6, DEEPEST, 18)])
    sunk = [max(yardstick.gaps(x).min(), 0.0) for x in place]
    force = [[yardstick.press(x, s + d)[0] for d in deep] for x, s in zip(place, sunk, strict=True)]
    ratio = np.array(force) / sound.force(deep)
    return RegularGridInterpolator((place, deep), ratio, bounds_error=False, fill_value=None)


def slow(spalled: Crossing, force: Force, places: np.ndarray) -> np.ndarray:
    """Forces, N, as the roller is moved over the spall: both contacts carry the same."""

    def balanced(place):
        deep = brentq(lambda d: force(place, d) - float(spalled.other.force(HUB - d)), -1e-7, HUB + 1e-7, xtol=1e-14)
        return force(place, deep)

    return np.array([balanced(place) for place in places])


def fast(spalled: Crossing, force: Force) -> np.ndarray:
    """The crossing with the roller's inertia, along the raceways at SPEED: pulses after the release.

    When it first touches after the entry edge, s; their peak, N; their impulse, N s.
    """
    mass, start = BEARING.roller_mass, -spalled.half - BESIDE
    swing = MOTION.cage**2 * BEARING.pitch_radius * (1.0 if spalled.body == "outer_ring" else -1.0)

    def rates(time, y):
        pushes = float(spalled.other.force(HUB - y[0])) - force(start + SPEED * time, y[0])
        return [y[1], pushes / mass + swing]

    rest = brentq(lambda deep: rates(0.0, [deep, 0.0])[1], 0.0, HUB)
    times = np.arange(0.0, -2.0 * start / SPEED, TICK)
    exact = {"rtol": 1e-7, "atol": [1e-13, 1e-9], "max_step": 5.0 * TICK}
    found = solve_ivp(rates, (0.0, times[-1]), [rest, 0.0], t_eval=times, **exact)
    pressed = np.array([force(start + SPEED * t, deep) for t, deep in zip(times, found.y[0], strict=True)])
    released = int(np.argmax(pressed == 0.0))
    struck = released + int(np.argmax(pressed[released:] > 0.0))
    pulses = pressed[struck:]
    return np.array([times[struck] - BESIDE / SPEED, pulses.max(), np.trapezoid(pulses, dx=TICK)])


def rows(body: str, width: float) -> list[list[str]]:
    """Of one spall: the yardstick's figures, and what the laws differ by."""
    spalled = crossing(body, width)
    places = np.arange(-spalled.half - 0.1e-3, spalled.half + 0.1e-3, STEP)
    sound = float(brentq(lambda q: spalled.sound.approach(q) + spalled.other.approach(q) - HUB, 1.0, 1e4))
    found, exact = [], None
    for name, force in spalled.laws.items():
        path, strike = slow(spalled, force, places), fast(spalled, force)
        lost = float(np.sum(sound - path)) * STEP / SPEED
        if exact is None:
            exact = path, lost, strike
            cells = [f"{sound:.0f} N before", f"{1e3 * lost:.2f} mN s", f"{1e6 * strike[0]:.1f} µs",
                     f"{strike[1]:.0f} N", f"{1e3 * strike[2]:.2f} mN s"]  # fmt: skip
        else:
            late, (_, peak, impulse) = strike[0] - exact[2][0], 100.0 * (strike / exact[2] - 1.0)
            off = 100.0 * np.abs(path - exact[0]).max() / sound
            cells = [f"{off:.1f} %", f"{100.0 * (lost / exact[1] - 1.0):+.1f} %",
                     f"{1e6 * late:+.1f} µs", f"{peak:+.1f} %", f"{impulse:+.1f} %"]  # fmt: skip
        found.append([f"{body.replace('_', ' ')}, {1e3 * width:g} mm", name, *cells])
    return found


def compared() -> tuple[str, str]:
    """Words and the table."""
    heads = ["spall", "contact", "slow: force", "impulse lost", "fast: struck at", "peak", "impulse"]
    table = [row for body in ("outer_ring", "inner_ring") for width in WIDTHS for row in rows(body, width)]
    words = (
        "A roller of the paper's bearing passes a spall with edges of 0.1 mm on the load line, the hub held where "
        "2000 N keep it. The reference is two half-planes that\nmeet wherever the bare profile lets them "
        "(`tests.reference.continua`). First the reference's values, then differences from it."
    )
    return words, markdown_table(heads, table)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.spall_edges", ("spalls", "Crossing on half-planes", compared))
