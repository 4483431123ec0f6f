"""One crossing of a spall, and a measured bearing with one: `python -m tests.accuracy.spalls SECTION`."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product
from math import cos, radians
from typing import Literal, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import brentq
from scipy.signal import decimate

from fem.interface import Scene, simulate
from fem.solver.simulate import make_plan
from fem.statics.exact_statics import exact_contacts, exact_statics
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import softened
from lagrange.kinematics import kinematics, roller_angles
from lagrange.scene.scene import read_scene
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.faults import Spall
from residual.spectrum import kinematic_lines
from residual.vibration import vibration
from tests.accuracy import found
from tests.measurements import markdown_table, program
from tests.reference.continua import EdgeContact
from tests.reference.resolved import FINE, Fineness, Run, crossing

PAPER, OPERATION = Scene().ideal_bearing(), Scene().ideal_operation()
MOTION = kinematics(PAPER, OPERATION.speed)
WIDTHS = 0.5e-3, 1e-3
EDGE_RADIUS = 1e-4
BESIDE = 0.25e-3  # m along the raceway, of the way after the spall, on half-planes before it, too


def spall(width: float, body: str = "outer_ring") -> Spall:
    return Spall(body=body, roller=None, angle=0.0, width=width, depth=1e-4, edge_radius=EDGE_RADIUS)


# A roller passes the load line between a raceway with a spall and a sound one; the hub stays where 2000 N hold it.
# Slowly, so that forces balance at every place; and at 4500 rpm, where the roller's inertia and centrifugal force let
# it fly and strike. Both raceways have Johnson's law, the spalled one besides what the law or the yardstick makes of
# the spall. From the strike on the roller may bounce: peak and impulse are those of all pulses from the first touch
# after the release to a quarter of a millimetre beyond the exit edge.

LAWS = contact_laws("johnson", PAPER)
SPEED = abs(MOTION.roller - MOTION.cage) * PAPER.roller_radius  # m/s, of contacts along both raceways
HUB = -static_equilibrium(PAPER, replace(OPERATION, gravity=0.0), LAWS, roller_mass=0.0).y  # m, down
STRIDE, TICK = 2e-6, 0.1e-6  # m of the slow way; s of the fast one
DEEPEST = 12e-6  # m, approach
Force = Callable[[float, float], float]  # N, at a place, m, and an approach from the sound raceway, m


def forces_at(body: str, half: float, width: float, sound) -> dict[str, Force]:
    """Contacts of a raceway with a spall in its middle, half its opening, m, and the sound raceway's law: by
    half-planes on the bare profile, by the law with its soft edges, by the sinkage alone."""
    is_outer = body == "outer_ring"
    pair, grid = contact_pairs(PAPER)[1 if is_outer else 0], np.linspace(-half - BESIDE, half + BESIDE, 8001)
    surfaces = profiles(replace(PAPER, faults=(spall(width, body),)))
    at = np.repeat(np.arcsin(grid / abs(pair.radii[0]))[:, None], PAPER.n_rollers, axis=1)
    met = (surfaces.outer if is_outer else surfaces.inner)(at, Turns())
    sinkage, compliance = met.sinkage[:, 0], met.compliance[:, 0]
    yardstick = EdgeContact(
        radius=pair.radii[0], roller_radius=PAPER.roller_radius, compliance=pair.line_compliance,
        level=0.5 * sound.level, half_opening=half, edge_radius=EDGE_RADIUS, beside=2.0 * BESIDE,
    )  # fmt: skip
    ratio, sunk = _ratios(yardstick, sound), np.array([max(yardstick.gaps(x).min(), 0.0) for x in grid])

    def bare(place, approach):
        deep = approach - np.interp(place, grid, sunk)
        return float(sound.force(deep) * ratio((abs(place), deep))) if deep > 0.0 else 0.0

    def by_law(place, approach, soft=1.0):
        law = softened(sound, soft * np.interp(place, grid, compliance)) if soft else sound
        return float(law.force(approach - np.interp(place, grid, sinkage)))

    return {"half-planes": bare, "law with soft edges": by_law, "sinkage alone": partial(by_law, soft=0.0)}


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


def slow(other, force: Force, places: np.ndarray) -> np.ndarray:
    """Forces, N, as the roller is moved over the spall: both contacts, the sound one's law `other`, carry the same."""

    def balanced(place):
        deep = brentq(lambda d: force(place, d) - float(other.force(HUB - d)), -1e-7, HUB + 1e-7, xtol=1e-14)
        return force(place, deep)

    return np.array([balanced(place) for place in places])


def fast(other, force: Force, half: float, outward: float) -> np.ndarray:
    """The crossing with the roller's inertia, along the raceways at SPEED: pulses after the release.

    When it first touches after the entry edge, s; their peak, N; their impulse, N s. `outward`: 1, or -1 for a spall on
    the inner ring.
    """
    mass, start, swing = PAPER.roller_mass, -half - BESIDE, outward * MOTION.cage**2 * PAPER.pitch_radius

    def rates(time, y):
        pushes = float(other.force(HUB - y[0])) - force(start + SPEED * time, y[0])
        return [y[1], pushes / mass + swing]

    rest = brentq(lambda deep: rates(0.0, [deep, 0.0])[1], 0.0, HUB)
    times = np.arange(0.0, -2.0 * start / SPEED, TICK)
    exact = {"rtol": 1e-7, "atol": [1e-13, 1e-9], "max_step": 5.0 * TICK}
    path = solve_ivp(rates, (0.0, times[-1]), [rest, 0.0], t_eval=times, **exact).y[0]
    pressed = np.array([force(start + SPEED * t, deep) for t, deep in zip(times, path, strict=True)])
    released = int(np.argmax(pressed == 0.0))
    struck = released + int(np.argmax(pressed[released:] > 0.0))
    pulses = pressed[struck:]
    return np.array([times[struck] - BESIDE / SPEED, pulses.max(), np.trapezoid(pulses, dx=TICK)])


def half_planes():
    """The contact law with soft edges against half-planes pressed on the bare profile; two minutes."""
    rows = []
    for body, width in product(("outer_ring", "inner_ring"), WIDTHS):
        half, exact = spall(width).half_opening(PAPER.roller_radius), None
        law, other = (LAWS.outer, LAWS.inner) if body == "outer_ring" else LAWS
        places = np.arange(-half - 0.1e-3, half + 0.1e-3, STRIDE)
        sound = float(brentq(lambda q, a=law, b=other: a.approach(q) + b.approach(q) - HUB, 1.0, 1e4))
        for name, force in forces_at(body, half, width, law).items():
            path = slow(other, force, places)
            strike = fast(other, force, half, 1.0 if body == "outer_ring" else -1.0)
            lost = float(np.sum(sound - path)) * STRIDE / SPEED
            if exact is None:
                exact = path, lost, strike
                cells = [f"{sound:.0f} N before", f"{1e3 * lost:.2f} mN s", f"{1e6 * strike[0]:.1f} µs",
                         f"{strike[1]:.0f} N", f"{1e3 * strike[2]:.2f} mN s"]  # fmt: skip
            else:
                late, (_, peak, impulse) = strike[0] - exact[2][0], 100.0 * (strike / exact[2] - 1.0)
                off = 100.0 * np.abs(path - exact[0]).max() / sound
                cells = [f"{off:.1f} %", f"{100.0 * (lost / exact[1] - 1.0):+.1f} %",
                         f"{1e6 * late:+.1f} µs", f"{peak:+.1f} %", f"{impulse:+.1f} %"]  # fmt: skip
            rows.append([f"{body.replace('_', ' ')}, {1e3 * width:g} mm", name, *cells])
    words = (
        "A roller of the paper's bearing passes a spall with edges of 0.1 mm on the load line, the hub held where "
        "2000 N keep it. The reference is two half-planes that\nmeet wherever the bare profile lets them "
        "(`tests.reference.continua`). First the reference's values, then differences from it."
    )
    heads = ("spall", "contact", "slow: force", "impulse lost", "fast: struck at", "peak", "impulse")
    yield "spalls", "Crossing on half-planes", words, markdown_table(heads, rows)


# Elastic bodies in motion: a deep spall on the outer ring at the load line; the shaft so heavy that the hub stays, no
# friction, no gravity. The yardstick (`tests.reference.resolved`) has one roller between both rings, all meshed with
# the spall, and finds the pressures of nodes 1.5 to 5 µm apart: no law below a grid, no half-plane, no sinkage. What
# the other rollers' loads do to the raceways under this one, 19 nm, is added to its hub.

RACEWAY = PAPER.outer_raceway_radius
FIRST_DEG = 3.0  # before the load line, where a run of the program begins
SHAFT_KG = 1e3  # which falls by 20 nm until the strike is over
AHEAD = 0.35e-3  # m along the raceway, where the yardstick begins before the spall
STEP = 0.1e-6  # s, of the yardstick; samples of the program are 0.5 µs apart
MODELS = {"finite elements, 1 mm": ("fem", 1.0), "finite elements, 2 mm": ("fem", 2.0), "reduced": ("reduced", 1.0)}
Part = Literal["step", "modes", "mesh", "hole"]
COARSER = replace(FINE, edge=2.0 * FINE.edge, raceway=2.0 * FINE.raceway, roller=2.0 * FINE.roller)
OTHERS = {  # label, arguments of `yardstick`
    "step": ("resolved, step 0.05 µs", {"step": 0.5 * STEP}),
    "modes": ("resolved, modes to 1 MHz", {"fine": replace(FINE, cutoff=1e6)}),
    "mesh": ("resolved, mesh twice as coarse at contacts", {"fine": COARSER}),
    "hole": ("resolved, the spall in the gap alone", {"hollow": False}),
}
HEADS = ["spall", "model", "load before", "struck after", "peak", "impulse"]
RESOLVED = """The paper's bearing under 2000 N at 4500 rpm, a spall 100 µm deep with edges of 0.1 mm on the outer ring
at the load line; the hub stays, no friction, no gravity. The reference (`tests.reference.resolved`)
is a roller between both rings on meshes of quadratic triangles, the spall cut out of the outer ring, nodes
1.5 to 5 µm apart in the contacts, modes up to 700 kHz. *Load*: before the spall. *Struck after*: from where
the force has fallen to half of it until it has risen to half of it again. *Peak* and *impulse*: of all
pulses until 0.25 mm beyond the exit edge."""


class Strike(NamedTuple):
    """What the roller does at the exit edge."""

    before: float  # N, on the sound raceway, 0.15 mm before the spall
    time: float  # s, from where the force has fallen to half of that to where it has risen to half again
    peak: float  # N, from there until 0.25 mm beyond the spall
    impulse: float  # N s, from the release on, until there


def strike(time: np.ndarray, angle: np.ndarray, force: np.ndarray, width: float) -> Strike:
    """Of a crossing of a spall so wide, m: times, s, the roller's angle from the load line, force outside, N."""
    half = spall(width).half_opening(PAPER.roller_radius)
    n = int(np.argmax(angle > (half + BESIDE) / RACEWAY)) or len(angle)
    time, angle, force = (of[:n] for of in (time, angle, force))
    before = float(np.interp(-(half + 0.15e-3) / RACEWAY, angle, force))
    level = force - 0.5 * before
    entry = int(np.argmax((angle > -(half + 0.1e-3) / RACEWAY) & (level < 0.0)))
    risen = entry + int(np.argmax(level[entry:] > 0.0))
    pulses = force[entry + int(np.argmax(force[entry:] <= 0.0)) :]
    fell, rose = (time[k] - (time[k] - time[k - 1]) * level[k] / (level[k] - level[k - 1]) for k in (entry, risen))
    return Strike(before, float(rose - fell), float(pulses.max()), float(np.sum(pulses) * (time[1] - time[0])))


def by_program(width: float, model: str, mesh_mm: float) -> tuple[Strike, np.ndarray]:
    """A crossing, and where the hub stays, (2,), m."""
    run = simulate(Scene(
        model=model, contact={"friction_coefficient": 0.0},
        operation={"inner_ring_and_shaft_kg": SHAFT_KG, "gravity_m_s2": 0.0, "first_roller_deg": -FIRST_DEG},
        numerics={"duration_ms": 0.45, "mesh_size_mm": mesh_mm, "output_interval_us": 0.5},
        spall=[{"body": "outer_ring", "width_mm": 1e3 * width, "depth_um": 100.0, "edge_radius_mm": 0.1}],
    ))  # fmt: skip
    angle = np.angle(1j * np.exp(1j * run["roller_theta"][:, 0]))  # from −y
    hub = np.array([run["inner_x"][0], run["inner_y"][0]])
    return strike(run.time, angle, run["outer_force"][:, 0], width), hub


def yardstick(width: float, hub, fine: Fineness = FINE, step=STEP, hollow=True) -> tuple[Strike, float]:
    """The resolved crossing, and by how much its energy changes over the energy stored in contacts before."""
    half, n = spall(width).half_opening(PAPER.roller_radius), PAPER.n_rollers
    first = -0.5 * np.pi - np.radians(FIRST_DEG)
    ahead, beyond = half + AHEAD, half + BESIDE + 0.05e-3
    # the other rollers' loads lift both raceways towards the roller next to the load line
    loads = exact_statics(PAPER, OPERATION.radial_load, first)
    coupling = exact_contacts(PAPER, roller_angles(PAPER, first)).compliance
    lifted = float(coupling[0, 1:n] @ loads.inner_force[1:] + coupling[n, n + 1 :] @ loads.outer_force[1:])
    lowered = hub + np.array([0.0, lifted])
    run = Run(crossing(PAPER, spall(width), lowered, ahead, beyond, MOTION.cage, fine, hollow), step)
    run.settle()
    energy, stored = run.energy.sum(), run.energy[:, 1].sum()
    force, angle = np.empty((2, round((ahead + beyond) / (MOTION.cage * RACEWAY) / step)))
    for k in range(len(force)):
        force[k] = np.hypot(*run.advance()[0])
        angle[k] = np.arctan2(run.centre[0], -run.centre[1])
    seen = strike(step * np.arange(1, len(force) + 1), angle, force, width)
    return seen, (run.energy.sum() - energy) / stored


def row(width: float, name: str, seen: Strike, exact: Strike | None = None) -> list[str]:
    if exact is None:
        cells = [f"{seen.before:.1f} N", f"{1e6 * seen.time:.2f} µs", f"{seen.peak:.0f} N",
                 f"{1e3 * seen.impulse:.2f} mN s"]  # fmt: skip
    else:
        cells = [f"{100.0 * (own / wanted - 1.0):+.1f} %" for own, wanted in zip(seen, exact, strict=True)]
    return [f"{1e3 * width:g} mm", name, *cells]


def resolved():
    """Models of the program against resolved contacts; five minutes."""
    rows = []
    for width in WIDTHS:
        by = {name: by_program(width, *of) for name, of in MODELS.items()}
        exact, _ = yardstick(width, by["finite elements, 1 mm"][1])
        rows += [row(width, "resolved", exact), *(row(width, name, seen, exact) for name, (seen, _) in by.items())]
    yield "spalls", "Crossing on resolved contacts", RESOLVED, markdown_table(HEADS, rows)


def fineness(*parts: Part):
    """That yardstick at 1 mm with another step, other modes, another mesh, without the spall's hole; three minutes."""
    rows, width = [], WIDTHS[-1]
    _, hub = by_program(width, "reduced", 1.0)
    for name, how in (OTHERS[part] for part in parts or OTHERS):
        seen, change = yardstick(width, hub, **how)
        rows.append([*row(width, name, seen), f"{100.0 * change:+.2f} %"])
    yield "spalls", "Fineness of the resolved reference", markdown_table([*HEADS, "energy"], rows)


ROLLERS, DIAMETER, PITCH, CONTACT_ANGLE = 16, 8.4074, 71.501, 15.17  # mm and degrees
RATE = 20_480.0  # of the record, samples per second
FINER = 10  # times that rate a run is sampled at; filtered and thinned out to it as the record was
SPAN = 8.0  # Hz on either side in which a line is looked for


def measured_bearing():
    """The envelope line of a measured bearing with a spall on its outer ring, beside that of a run.

    Rexnord ZA-2115 of the IMS rig: 16 rollers of 8.407 mm, pitch 71.501 mm, angle 15.17°, 2000 rpm, 6000 lb. The record
    has its envelope line at 236.0 Hz, kinematics of the contact angle at 236.40 Hz. The scene has the catalogue's
    sizes: `contact_angle_deg` and `pitch_diameter_mm` make its plane section. Of the 6000 lb, which act on a shaft with
    four bearings, two between two others, each takes 3000 lb. What the rig's papers leave out is assumed: two rows of
    rollers 10 mm long, rings 10 mm thick, 2 kg at the hub, a spall of 0.5 mm, and 20 µm of radial preload. Preload
    takes the place of the cage that the model lacks: without either, rollers lag in the unloaded half, 0.6 % on the
    average of all.

    Source: Lee, Qiu, Yu, Lin, Bearing data set, IMS, University of Cincinnati, NASA Prognostics Data Repository (2007).
    """
    rows, across = [["record", "236.0 Hz", "", "", "0.62, 0.36, 0.24"]], DIAMETER * cos(radians(CONTACT_ANGLE))
    for preload_um, name in ((20.0, "20 µm of radial preload"), (0.0, "no preload")):
        scene = read_scene(None, (
            "model=reduced", f"bearing.rollers={ROLLERS}", f"bearing.roller_diameter_mm={DIAMETER}", "bearing.rows=2",
            f"bearing.pitch_diameter_mm={PITCH}", f"bearing.contact_angle_deg={CONTACT_ANGLE}",
            f"bearing.clearance_um={-2.0 * preload_um!r}", "bearing.roller_length_mm=10",
            f"bearing.bore_diameter_mm={PITCH - across - 20.0!r}",
            f"bearing.outside_diameter_mm={PITCH + across + 20.0!r}", "operation.speed_rpm=2000",
            "operation.radial_load_N=13345", "operation.inner_ring_and_shaft_kg=2", "spall.0.body=outer_ring",
            "spall.0.width_mm=0.5", "numerics.duration_ms=600", f"numerics.output_interval_us={1e6 / (FINER * RATE)!r}",
        ))  # fmt: skip
        run, ideal = found(make_plan(scene)), kinematics(scene.ideal_bearing(), scene.ideal_operation().speed)
        theta, time = run["roller_theta"], run["time"]
        # the report's section, vertical, by the run's own lines
        own = kinematic_lines(replace(ideal, cage=float(np.mean(theta[-1] - theta[0])) / (time[-1] - time[0])))
        measured = vibration(decimate(run["inner_ay"], FINER, ftype="fir"), 1.0 / RATE, own)
        spectrum, places, heights = measured.envelope.spectrum, [], []
        for harmonic in range(1, 5):  # the highest line nearby; between bins by a parabola through three of them
            chosen = np.flatnonzero(np.abs(spectrum.frequency - harmonic * own["BPFO"]) < SPAN)
            k = chosen[np.argmax(spectrum.psd[chosen])]
            low, top, high = np.log(spectrum.psd[k - 1 : k + 2])
            places.append(spectrum.frequency[k] + 0.5 * (low - high) / (low - 2.0 * top + high) * spectrum.resolution)
            heights.append(np.sqrt(spectrum.psd[k]))
        shares, bpfo = np.array(heights[1:]) / heights[0], next(each for each in measured.lines if each.name == "BPFO")
        rows.append([f"simulated, {name}", f"{places[0]:.1f} Hz", f"{bpfo.ratio:.2g}", f"{own['BPFO']:.2f} Hz",
                     ", ".join(f"{share:.2f}" for share in shares)])  # fmt: skip
    heads = ("", "line", "over its floor", "the run's rollers pass at", "2nd, 3rd, 4th over the 1st")
    yield "spalls", "A measured bearing", markdown_table(heads, rows)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.spalls", half_planes, resolved, fineness, measured_bearing)
