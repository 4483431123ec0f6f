"""Scenes, short runs, commands and files that tests share."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import pi
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import h5py
import numpy as np
import pytest
import xarray

from fem.contacts.model import Model
from fem.contacts.resolved import ResolvedModel
from fem.contacts.subgrid import SubgridModel
from fem.elastic.bodies import DiscBody, RingBody, disc_body, ring_body
from fem.elastic.continuum import patch_displacement, plane_compliance, ring_sections
from fem.elastic.reciprocal_mass import LUMPED, ReciprocalMass
from fem.kernels.columns import BLOCKS, N_SCALARS
from fem.kernels.elements.loop import advance
from fem.pictures.recover import StoredRun
from fem.solver import simulate
from fem.solver.elements.arrays import Arrays, Start, equilibrium_start, make_arrays, rest_start
from fem.solver.rigid.reduced import ReducedPlan
from fem.solver.simulate import make_plan
from fem.solver.solver import Plan, RunState, Samples
from fem.statics.exact_statics import HALF_WIDTH, ReducedBearing
from lagrange import Bearing, Material, Operation
from lagrange.bearing import BallBearing
from lagrange.columns import columns_of
from lagrange.contact.laws import contact_laws
from lagrange.files.hdf5 import CHECKSUM, SCENE_CHECKSUM, SIGNATURE
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene, SceneError, parse_scene, parse_scene_text, read_scene
from lagrange.surface.faults import Spall, UnequalRoller, Waviness
from meshes import Annulus, Disc
from residual.record import Record
from tests.reference.continua import cubic_bspline_patch
from tests.waiting import GIVE_UP

# ---- Bearings, bodies and loads that tests and verification share, each built once a session; states of the time loop.

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
STEEL_ON_STEEL = {"roller": STEEL, "inner_ring": STEEL, "outer_ring": STEEL}
LENGTH = 0.01  # of the paper's rollers, m
LOAD = 2000.0  # N, the paper's
ON_A_ROLLER = -0.5 * pi  # angle of the first roller: the load's direction
HALF_PITCH = ON_A_ROLLER + pi / 13.0  # the paper's load between two rollers
LARGEST_FORCE = 650.0  # N, about what the paper's load puts on one roller


@cache
def paper(**changes) -> Bearing:
    """The paper's bearing: 13 rollers of 10 mm between 36 and 56 mm."""
    return replace(read_scene().ideal_bearing(), **changes)


def of_steel(n, roller, length, inner, outer, bore, outside) -> Bearing:
    """Radii and length, m."""
    return Bearing(
        n_rollers=n, roller_radius=roller, roller_length=length, inner_raceway_radius=inner,
        outer_raceway_radius=outer, bore_radius=bore, outside_radius=outside, **STEEL_ON_STEEL,
    )  # fmt: skip


SHAPES = {
    "paper": paper(), "clearance": paper(outer_raceway_radius=0.02801), "preload": paper(outer_raceway_radius=0.027995),
    "three rollers": paper(n_rollers=3), "full complement": paper(n_rollers=14),
    "ceramic rollers": paper(roller=Material(youngs_modulus=310e9, poisson_ratio=0.26, density=3200.0)),
    "light-alloy housing": paper(outer_ring=Material(youngs_modulus=70e9, poisson_ratio=0.33, density=2700.0)),
    "large": of_steel(17, 0.012, 0.03, 0.06, 0.08402, 0.045, 0.1),
    "small": of_steel(11, 0.001, 0.003, 0.004, 0.006, 0.003, 0.0075),
    "thin rings": paper(bore_radius=0.0155, outside_radius=0.0305),
    "many rollers": of_steel(31, 0.004, 0.012, 0.045, 0.053, 0.037, 0.06),
}  # fmt: skip


def fair_load(bearing: Bearing) -> float:
    """A load, N, that presses like the paper's 2000 N."""
    return LOAD * bearing.roller_radius * bearing.roller_length / (0.005 * LENGTH)


model, resolved_model = cache(SubgridModel.build), cache(ResolvedModel.build)  # of a bearing and a mesh size, m


@cache
def disc(radius: float, layers: int, material: Material = STEEL) -> DiscBody:
    """A roller of LENGTH with 6·layers surface nodes."""
    return disc_body(Disc(radius=radius, layers=layers), material, LENGTH)


@cache
def ring(inner: float, outer: float, sectors: int, layers: int, held_inside: bool, material=STEEL) -> RingBody:
    """A ring of LENGTH."""
    shape = Annulus(inner_radius=inner, outer_radius=outer, sectors=sectors, layers=layers)
    return ring_body(shape, material, LENGTH, held_inside)


@cache
def soft(**changes) -> Bearing:
    """The paper's bearing of a plastic (5 GPa): its contacts are 0.3 mm wide on either side."""
    return paper(**dict.fromkeys(STEEL_ON_STEEL, replace(STEEL, youngs_modulus=5e9)), **changes)


def operation(**changes) -> Operation:
    """The paper's operating point."""
    return replace(read_scene().ideal_operation(), **changes)


def start_of(a_model: Model, how: Operation, from_rest: bool = False) -> Start:
    return (rest_start if from_rest else equilibrium_start)(a_model, how)


def arrays(
    a_model: Model, how: Operation, dt: float, friction: float = 0.0, from_rest: bool = False, ramp: float = 0.0,
    mass: ReciprocalMass = LUMPED,
) -> Arrays:  # fmt: skip
    """Arrays of the time loop at t = 0."""
    return make_arrays(a_model, how, start_of(a_model, how, from_rest), dt, friction, ramp, LARGEST_FORCE, mass)


copies = deepcopy  # of arrays; what these share they share in the copy


def loop_arguments(state: Arrays) -> tuple:
    return state.bodies, state.groups, state.contacts, state.drive, state.scratch


def run(state: Arrays, n_samples: int, stride: int) -> np.ndarray:
    """Run on and return the samples, (n_samples, n_columns); the state is left at its end."""
    samples = np.zeros((n_samples, N_SCALARS + len(BLOCKS) * state.bodies.rollers.n))
    assert advance(*loop_arguments(state), 0, stride, samples) == (0, n_samples * stride, -2)
    return samples


def block(samples: np.ndarray, name: str) -> np.ndarray:
    """One quantity of every roller, (n_samples, n_rollers)."""
    n = (samples.shape[1] - N_SCALARS) // len(BLOCKS)
    at = N_SCALARS + BLOCKS.index(name) * n
    return samples[:, at : at + n]


# ---- Ideal bearings, faults and operating points that tests of the Lagrangian model share.

PAPER = Scene().ideal_bearing()
RUNNING = Scene().ideal_operation()
HARRIS = contact_laws("harris", PAPER)
PRELOADED = replace(PAPER, outer_raceway_radius=0.02799)  # every contact stays closed: smooth forces
DOWN = -0.5 * np.pi
STEEL_207 = Material(youngs_modulus=207e9, poisson_ratio=0.3, density=7850.0)
# the 209 deep-groove bearing of Harris' examples: 9 balls of 12.7 mm, grooves of 52 %
DGBB_209 = BallBearing(
    n_rollers=9, roller_radius=6.35e-3, roller_length=19e-3, inner_raceway_radius=26.1455e-3,
    outer_raceway_radius=38.853e-3, bore_radius=22.5e-3, outside_radius=42.5e-3, inner_groove_radius=6.604e-3,
    outer_groove_radius=6.604e-3, **dict.fromkeys(STEEL_ON_STEEL, STEEL_207),
)  # fmt: skip


def spall(body, angle=0.0, width=1e-3, depth=1e-4):
    """Of this width and depth, m, its middle at an angle on a ring or on roller 0."""
    roller = 0 if body == "roller" else None
    return Spall(body=body, roller=roller, angle=angle, width=width, depth=depth, edge_radius=1e-4)


def wavy():
    """Waves on all bodies, and a roller that is too thick."""
    return (
        Waviness(body="inner_ring", roller=None, order=12, amplitude=0.5e-6, phase=0.3),
        Waviness(body="outer_ring", roller=None, order=5, amplitude=0.4e-6, phase=0.0),
        Waviness(body="roller", roller=1, order=4, amplitude=0.3e-6, phase=0.0),
        UnequalRoller(roller=3, diameter_deviation=1e-6),
    )


# ---- Runs from their start to their end, kept in memory, and gone on with; their forces and energies.


def whole_run(plan: Plan, state: RunState | None = None, said: list[str] | None = None) -> Samples:
    """All samples but those that a restart makes void.

    `state` : the run's, where it is looked at afterwards; `said` : a list that gets why it restarted
    """
    blocks: list[Samples] = []
    reasons = [] if said is None else said
    simulate.run(plan, blocks.append, state=state, restart=lambda reason: (reasons.append(reason), blocks.clear()))
    return Samples.joined(blocks)


def rest_of_run(plan: Plan, first: int, rest: int) -> tuple[Samples, Samples]:
    """The samples after the first so many, of the run that was not stopped and of one kept there and gone on with."""
    whole, half, later = (plan.first_state() for _ in range(3))
    whole.advance(first)
    half.advance(first)
    arrays, numbers = half.to_keep()
    later.done = half.done
    later.take_back({name: array.copy() for name, array in arrays.items()}, numbers)
    return whole.advance(rest).samples, later.advance(rest).samples


def assert_same_bits(found: Samples, expected: Samples) -> None:
    """In every column."""
    assert set(found.values) == set(expected.values)
    for name in expected.values:
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)


def within(found, wanted, error, name="") -> None:
    """Numbers agree to an absolute error."""
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=error, err_msg=name)


def budget_terms(found) -> list[dict[str, np.ndarray]]:
    """Terms of the hub's two equations, which add up to their errors."""
    for direction in found.directions:
        within(sum(direction.budget.terms.values()), direction.budget.error, 1e-9 * 2000.0)  # round-off, N
    return [direction.budget.terms for direction in found.directions]


def energy_left(energies: dict[str, np.ndarray]) -> np.ndarray:
    """What the energies and works among a run's columns leave, J; constant where they balance."""
    left = sum(energies[name] for name in energies if name.startswith("energy_"))
    return left - energies["work_external"] + energies["work_dissipated"]


def balance_of(result) -> float:
    """The same, its largest change over what is exchanged and dissipated."""
    left, energies = energy_left(result.energies), result.energies
    passed = np.ptp(energies["energy_kinetic"]) + energies["work_dissipated"][-1]
    return np.abs(left - left[0]).max() / passed


class Caged(NamedTuple):
    """A run with a cage."""

    scene: Scene
    values: dict[str, np.ndarray]
    imbalance: float  # over the exchanged and the dissipated energy

    def slip(self, first: float, name: str = "cage") -> float:
        """Of the cage, or of the rollers' mean, after a share of the run."""
        angle = self.values["cage_angle"] if name == "cage" else self.values["roller_theta"].mean(axis=1)
        time, start = self.values["time"], int(first * len(angle))
        speed = (angle[-1] - angle[start]) / (time[-1] - time[start])
        return 1.0 - speed / kinematics(self.scene.ideal_bearing(), self.scene.ideal_operation().speed).cage

    @property
    def spacing(self) -> float:
        """The most that neighbouring rollers' distance along the pitch circle, seen from the cage, is off, m."""
        x, y = (self.values[f"roller_{axis}"] - self.values[f"cage_{axis}"][:, None] for axis in "xy")
        angle, bearing = np.unwrap(np.arctan2(y, x), axis=0), self.scene.ideal_bearing()
        apart = np.diff(np.concatenate([angle, angle[:, :1] + 2.0 * pi], axis=1), axis=1)
        apart = (apart + pi) % (2.0 * pi) - pi
        return float(np.abs(apart - 2.0 * pi / bearing.n_rollers).max()) * bearing.pitch_radius


def caged(model: str, duration_ms: float, cage: dict, numerics: dict | None = None, **tables) -> Caged:
    """A run with a light, stiff cage guided by the rollers, but for what is said of it."""
    usual = {"guidance": "rollers", "mass_kg": 0.02, "pocket_clearance_mm": 0.2, "stiffness_N_per_m": 1e8}
    timing = {"duration_ms": duration_ms} | (numerics or {})
    scene = parse_scene({"model": model, "cage": usual | cage, "numerics": timing, **tables}, "scene")
    found = whole_run(make_plan(scene))
    passed = found.exchanged.max() + found["work_dissipated"].max()
    return Caged(scene, found.values, float(np.abs(found.imbalance).max() / passed))


def housing_left(result, guide=0.0) -> tuple[np.ndarray, np.ndarray]:
    """What a housing's forces leave of its inertia, and this, N, x + iy; `guide` : a cage's force on its ring, N."""
    housing, angle = result.scene.mounting().housing, result["roller_theta"]
    mass = housing.mass + result.scene.ideal_bearing().outer_ring_mass
    place = result["housing_x"] + 1j * result["housing_y"]
    push = result["outer_force"] - 1j * result.values.get("outer_traction", 0.0)
    push = np.sum(push * np.exp(1j * angle), axis=1) + guide
    push = push - housing.stiffness * place - housing.damping * np.gradient(place, result["time"])
    inertia = mass * (result["housing_ax"] + 1j * result["housing_ay"])
    return push - 1j * mass * result.scene.ideal_operation().gravity - inertia, inertia


# ---- Result files: options of short runs, what is left in a folder, copies whose content a test may change.

EARLIER = SIGNATURE + b"an earlier result"
OPTIONS = ["--mesh-size", "2", "--quiet", "--checkpoint", "0"]
SHORT = [*OPTIONS, "--duration", "2"]


def read_json(path):
    return json.loads(Path(path).read_text(encoding="utf-8"))


def attributes(path):
    """Of a result file, which may still be written."""
    with h5py.File(path, locking=False) as file:
        return dict(file.attrs)


def same_data(left, right):
    """Whether two result files hold the same numbers."""
    with h5py.File(left) as a, h5py.File(right) as b:
        return all(np.array_equal(a[name][:], b[name][:]) for name in columns_of(""))


def read_instant(path, time=None):
    """The sample nearest to a time, s, of a result file; None: the last one."""
    run = StoredRun(path)
    return run.instant(run.nearest(time))


def names_in(folder):
    """Names of what lies in a folder, sorted."""
    return sorted(entry.name for entry in folder.iterdir())


def unchecked_copy(path, target):
    """A copy without checksums."""
    shutil.copy(path, target)
    with h5py.File(target, "r+") as file:
        file.attrs.pop(SCENE_CHECKSUM, None)
        for variable in file.values():
            variable.attrs.pop(CHECKSUM, None)
    return target


# ---- What scenes are refused with; scenes whose speed or load come from tables, and their records.


def refusal(given: dict | str | Sequence[str]) -> str:
    """The sentences with which a scene's tables, its TOML text, or settings as of --set are refused."""
    with pytest.raises(SceneError) as caught:
        if isinstance(given, dict):
            parse_scene(given, "scene.toml")
        elif isinstance(given, str):
            parse_scene_text(given, "scene.toml")
        else:
            read_scene(None, tuple(given))
    return str(caught.value)


def assert_refused(given: dict | str | Sequence[str], *words: str) -> None:
    """A scene is refused with words that name what is wrong."""
    told = refusal(given)
    assert all(word in told for word in words), told


RAMP = "time_ms,speed_rpm\n0,1000\n2,1500\n6,5000\n8,6000\n"
LOADS = "time_ms,x_N,y_N\n0,0,-2000\n2,500,-1500\n4,500,-2500\n10,-300,-2000\n"


def scene_with(folder: Path, *settings: str, speeds: str | None = None, loads: str | None = None, more="") -> Scene:
    """A scene in a folder with its tables, texts; `settings` as --set takes them, `more` after [operation]."""
    lines = ["[operation]"]
    for key, text in (("speed_table", speeds), ("load_table", loads)):
        if text is not None:
            (folder / f"{key}.csv").write_text(text, encoding="utf-8")
            lines.append(f'{key} = "{key}.csv"')
    path = folder / "scene.toml"
    path.write_text("\n".join([*lines, more]), encoding="utf-8")
    return read_scene(path, settings)


def record_of(scene: Scene, run: SimpleNamespace) -> Record:
    """A Lagrangian run as a record."""
    names = ("time", "inner_x", "inner_y", "roller_x", "roller_y", "inner_ax", "inner_ay", "inner_force", "outer_force")
    values = {name: getattr(run, name) for name in names}
    return Record(name="run", source=Path("run"), scene=scene, attributes={"program": "run-fem"}, **values)


# ---- The commands as a user has them: started from any folder, in which nothing of it is imported from there.

ROOT = Path(__file__).resolve().parents[2]
ENTRIES = {
    **{name: f"from fem.commands.entry import {name.replace('-', '_')} as main"
       for name in ("run-fem", "render-fem", "run-live", "run-study", "rate-bearing")},
    "check-residual": "from residual.entry import check_residual as main",
}  # fmt: skip


def sets(*settings: str) -> list[str]:
    """Words of a command line for settings of the scene."""
    return [word for setting in settings for word in ("--set", setting)]


def started_as(name: str) -> list[str]:
    """The first words of a command line."""
    return [sys.executable, "-P", "-c", f"{ENTRIES[name]}\nmain()"]


def environment(**more: object) -> dict[str, str]:
    """This process's, with the program to be found and more variables."""
    return {**os.environ, "PYTHONPATH": str(ROOT), **{name: str(value) for name, value in more.items()}}


def command(name: str, *arguments: object, folder: Path | None = None, prepare=None, **variables: object):
    """Run a command to its end in a folder; `prepare` is called in its process before it begins."""
    return subprocess.run(
        [*started_as(name), *map(str, arguments)], cwd=folder, env=environment(**variables), preexec_fn=prepare,
        capture_output=True, text=True, timeout=GIVE_UP,
    )  # fmt: skip


# ---- Studies to be tried quickly: a millisecond each of the Lagrangian model.

BASE = '\n[fixed]\nmodel = "lagrange"\n"numerics.duration_ms" = 1.0\n'
TWO_SPEEDS = BASE + '[parameters]\n"operation.speed_rpm" = [1500, 3000]\n[keep]\nquantities = ["hub_mean_y"]\n'
GRID = f"""{BASE}
[sampling]
method = "grid"
[parameters]
"operation.speed_rpm" = [1500.0, 3000.0, 4500.0]
"bearing.outer_raceway_diameter_mm" = {{ from = 56.0, to = 56.02, count = 2 }}
[keep]
quantities = ["hub_mean_y", "largest_force"]
signals = ["inner_ay", "inner_force"]
signal_rate_kHz = 25.0
"""


def many(n):
    return GRID.replace("[1500.0, 3000.0, 4500.0]", f"{{ from = 1000.0, to = 5000.0, count = {n} }}")


def same(one, other):
    """Whether two datasets hold the same bits but for the time that each point took."""
    with xarray.open_dataset(one) as a, xarray.open_dataset(other) as b:
        assert set(a.variables) == set(b.variables)
        a, b = a.load(), b.load()
    for name in set(a.variables) - {"seconds"}:
        mine, theirs = a[name].values, b[name].values
        assert mine.dtype == theirs.dtype and mine.shape == theirs.shape
        assert mine.tobytes() == theirs.tobytes() if mine.dtype.kind != "O" else np.array_equal(mine, theirs), name


# ---- Short runs of the paper's bearing with rollers that tilt.


def scene(model, axial=(), **changes):
    """The paper's bearing for half a millisecond; `axial` : its table's keys, None: a plane section."""
    keys = {} if axial is None else {f"axial.{key}": value for key, value in {"slices": 11, **dict(axial)}.items()}
    fixed = {"model": model, "numerics.duration_ms": 0.5, "numerics.output_interval_us": 10.0}
    return Scene().varied(fixed | keys | {key.replace("__", "."): value for key, value in changes.items()})


def moved(found, said=None):
    """Columns by name of a run of a scene or a plan; `said` : a list that gets why it restarted."""
    return whole_run(make_plan(found) if isinstance(found, Scene) else found, said=said).values


def missed(samples):
    """Largest energy error over the contacts' energy."""
    left = energy_left(samples)
    return np.abs(left - left[0]).max() / samples["energy_contact"].max()


def defects(half):
    """Tables of spalls of part of the length by its keys `half`, of one of all of it, of waves and a larger roller."""
    places = {"body": "inner_ring", "angle_deg": -3.0}, {"body": "roller", "roller": 1, "angle_deg": 20.0}
    places += ({"body": "outer_ring", "angle_deg": 10.0},)
    whole = {"body": "outer_ring", "angle_deg": 40.0, "width_mm": 0.3}
    spalls = [*(place | half for place in places), whole]
    return {"spall": spalls, "waviness": [{"order": 11}], "unequal_roller": [{"roller": 2}]}


# ---- Runs of the reduced model: plans of scenes, their samples, runs that restart with shorter steps.

CLEARANCE = ("bearing.outer_raceway_diameter_mm=56.04", "operation.radial_load_N=200")
STILL = ("operation.speed_rpm=0", "contact.friction_coefficient=0")


def plan_of(*settings: str, stride: int | None = None) -> ReducedPlan:
    plan = make_plan(read_scene(None, ("model=reduced", *settings)))
    return plan if stride is None else replace(plan, stride=stride)


def samples_of(plan, change=lambda state: None, count: int | None = None) -> dict[str, np.ndarray]:
    """All samples, of a start that `change` has changed; never restarted."""
    state = plan.first_state()
    change(state)
    rows, status, *_ = state.take_steps((plan.n_samples if count is None else count) * plan.looks)
    assert status == 0
    read = state.reader.read(rows)
    return read.values | {"imbalance": read.imbalance, "exchanged": read.exchanged}


RATTLES = {
    "model": "reduced", "bearing": {"outer_raceway_diameter_mm": 56.04}, "operation": {"radial_load_N": 200.0},
    "contact": {"friction_coefficient": 0.0},
    "numerics": {"start": "rest", "load_ramp_ms": 0.0, "duration_ms": 20.0, "time_step_safety": 0.9},
}  # fmt: skip


def ran(plan):
    """Its state at the end, the last pass' samples of the hub's height, and what it was told."""
    state, blocks, told = plan.first_state(), [], []

    def restart(reason):
        told.append((reason, state.void_steps))
        blocks.clear()

    simulate.run(plan, blocks.append, state=state, restart=restart)
    return state, Samples.joined(blocks)["inner_y"], told


def couplings(model: ReducedBearing, angle: np.ndarray) -> np.ndarray:
    """Of rollers at any angles, by the series themselves, (2, n, n), m/N."""
    bearing, n = model.bearing, len(angle)
    found, width = np.zeros((2, n, n)), HALF_WIDTH * bearing.roller_radius
    for row, ring in enumerate(ring_sections(bearing)):
        harmonics = np.arange(int(30.0 * ring.loaded / width))
        series, load = plane_compliance(ring, harmonics), cubic_bspline_patch(harmonics, width, ring.loaded)
        for i in range(n):
            for j in range(i):
                value = patch_displacement(series, load, 1.0, ring.loaded, float(angle[i] - angle[j]))
                found[row, i, j] = found[row, j, i] = value / bearing.roller_length
    return found


# ---- A pedestal, and how it rings down.

PEDESTAL = {"kind": "housing"}  # its defaults: 12.638 kg, 15.1e6 N/m, 2210.7 N s/m


def ring_down(values: np.ndarray, dt: float) -> tuple[float, float]:
    """Undamped frequency, Hz, and damping ratio of a decaying oscillation, by its crossings of 0 and its peaks."""
    at = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    crossings = (at + values[at] / (values[at] - values[at + 1])) * dt
    damped = (len(crossings) - 1) / (crossings[-1] - crossings[0])
    peaks = [values[a:b].max() for a, b in pairwise(at)]
    decrement = np.log(peaks[0] / peaks[-1]) / (len(peaks) - 1)
    zeta = decrement / np.hypot(2.0 * np.pi, decrement)
    return damped / np.sqrt(1.0 - zeta**2), zeta


# ---- Static equilibrium of the paper's bearing, resolved, computed independently of this project. Every body on its
# own locally refined mesh of quadratic elements (six of them across the contact half-width), self-consistent Hertz
# pressures; frictionless, weightless, standing; rigid bore (25 mm) and rigid outside diameter (65 mm); 2000 N.
# Converged to 0.02 %. Angle of the first roller, rad; hub displacement along the load, µm; loads of the seven most
# loaded rollers, N.
RESOLVED = {
    "on a roller": (ON_A_ROLLER, 3.6140, (628.5, 549.5, 549.5, 337.2, 337.2, 62.9, 62.9)),
    "between rollers": (HALF_PITCH, 3.6012, (606.0, 606.0, 454.8, 454.8, 200.8, 200.8, 0.0)),
}
