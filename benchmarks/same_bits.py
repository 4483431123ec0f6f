"""Whether another revision of the program gives the same bits, and takes the same time.

BASE is checked out beside this tree. Both run the same short scenes, each as a command of its own; every variable of
the result files is compared byte by byte, their attributes but for times and versions, and the reports' numbers. With
--speed whole runs are timed in turns, with --cold a first start with no kernel compiled. With --numbers both judge the
base's result files of some scenes: the numbers of check-residual, of its search for spalls and of rate-bearing agree
to 1e-12.

Code that is arranged in another way has other products fused with sums by the compiler, and its results differ by
round-off. --unfused turns that off in both trees: what then differs has been computed in another way.
"""

import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from math import cos, radians
from pathlib import Path
from typing import Annotated

import h5py
import numpy as np
from cyclopts import App, Parameter

from benchmarks import in_turns, used
from tests.measurements import ROOT, markdown_table

# attributes that may differ; a scene's text gains keys as the program does
UNLIKE = {"wall_seconds", "setup_seconds", "program_version", "source", "scene", "scene_checksum"}
UNLIKE_IN_REPORT = {"run", "wall_seconds", "program_version"}
FUSED = '_FUSED = ("contract",)'  # in a module of fem.kernels
SAME_NUMBER = 1e-12  # relative
JUDGED = (
    "paper reduced-sensor reduced-guided-cage reduced-damped-spall reduced-roller-spall reduced-speed-history "
    "reduced-tilted lagrange-tilted lagrange-balls fem-inner-spall"
)
MOST_TOLD, LONGEST_TOLD = 12, 160  # differences of a scene, characters of each
SPEED_MS = 60.0  # of the paper's bearing


@dataclass(frozen=True)
class Short:
    """A short run of the built-in scene with some keys changed."""

    name: str
    duration_ms: float
    keys: tuple[str, ...] = ()
    resumed: bool = False  # stopped half-way and gone on with
    report: bool = False  # compare the numbers of check-residual too


def _scene(name: str, duration_ms: float, text: str = "", **options: bool) -> Short:
    return Short(name, duration_ms, tuple(text.split()), **options)


FILES = {  # beside each scene
    "speeds.csv": "time_ms,speed_rpm\n0,3000\n1,4500\n20,4600\n",
    "loads.csv": "time_ms,x_N,y_N\n0,0,-2000\n0.5,300,-1500\n20,0,-2500\n",
    "heights.csv": "angle_deg,height_um\n" + "".join(f"{a},{0.5 * cos(radians(9 * a)):.6f}\n" for a in range(360)),
}


SOFT = "material.youngs_modulus_GPa=5"
BALLS = "bearing.type=ball bearing.rollers=9 bearing.roller_length_mm=16"
SCENES = (
    _scene("paper", 4.0, "numerics.mesh_size_mm=2", report=True),
    _scene("fine", 0.5, "numerics.mesh_size_mm=1"),
    _scene("static", 0.0, "numerics.mesh_size_mm=2"),
    _scene("resumed", 1.0, "numerics.mesh_size_mm=2", resumed=True),
    _scene("from-rest", 1.0, "numerics.mesh_size_mm=2 numerics.start=rest numerics.load_ramp_ms=0.2"),
    _scene("frictionless", 1.0, "numerics.mesh_size_mm=2 contact.friction_coefficient=0"),
    _scene("fields", 0.5, "numerics.mesh_size_mm=2 output.fields_every_ms=0.1"),
    _scene("fast", 0.5, "numerics.mesh_size_mm=2 operation.speed_rpm=40000"),
    _scene("backward", 0.5, "numerics.mesh_size_mm=1.5 operation.speed_rpm=-900 operation.gravity_m_s2=0"),
    _scene("still", 0.5, "numerics.mesh_size_mm=2 operation.speed_rpm=0"),
    _scene("preload", 0.5, "numerics.mesh_size_mm=1.5 bearing.outer_raceway_diameter_mm=55.99"),
    _scene("rattling", 2.0, "numerics.mesh_size_mm=2 numerics.start=rest bearing.outer_raceway_diameter_mm=56.2 "
           "bearing.rollers=14 operation.radial_load_N=50"),
    _scene("three-rollers", 0.5, "numerics.mesh_size_mm=2 bearing.rollers=3 cage.kind=none "
           "contact.friction_coefficient=0.2"),
    _scene("many-rollers", 0.5, "numerics.mesh_size_mm=1.2 bearing.rollers=31 bearing.roller_diameter_mm=4 "
           "bearing.outer_raceway_diameter_mm=44 cage.kind=none"),
    _scene("rigid-rollers", 0.5, "numerics.mesh_size_mm=2 bodies.rollers=rigid"),
    _scene("rigid-inner", 0.5, "numerics.mesh_size_mm=2 bodies.inner_ring=rigid"),
    _scene("rigid-rings", 0.5, "numerics.mesh_size_mm=2 bodies.inner_ring=rigid bodies.outer_ring=rigid"),
    _scene("penalty", 0.5, "numerics.mesh_size_mm=2 contact.model=penalty"),
    _scene("faceted", 0.5, "numerics.mesh_size_mm=2 contact.model=faceted contact.penalty_stiffness_N_per_m=1e8"),
    _scene("spread", 0.05, f"{SOFT} numerics.mesh_size_mm=0.5"),
    _scene("resolved", 0.02, f"{SOFT} contact.model=resolved numerics.mesh_size_mm=0.15"),
    _scene("lagrange", 5.0, "model=lagrange", report=True),
    _scene("lagrange-free", 2.0, "model=lagrange lagrange.angles=free lagrange.law=johnson numerics.start=rest"),
    _scene("lagrange-damped", 1.0, "model=lagrange damping.contact_N_s_m=200"),
    _scene("lagrange-rattling", 5.0, "model=lagrange numerics.start=rest numerics.load_ramp_ms=0 "
           "bearing.outer_raceway_diameter_mm=56.1 operation.radial_load_N=20"),
    _scene("lagrange-ball-bearing", 2.0, f"model=lagrange {BALLS}"),
)  # fmt: skip

# every table with each model that takes it: its keys, and models that refuse it
MODELS = {"fem": (0.3, "numerics.mesh_size_mm=2"), "reduced": (2.0, ""), "lagrange": (2.0, "")}
HOUSING = "support.kind=housing support.mass_kg=12 support.stiffness_N_per_m=1.5e7 support.damping_N_s_m=2200"
SPALL = 'spall=[{body="outer_ring",width_mm=1.2,angle_deg=5.0}]'
CAGE = "cage.mass_kg=0.02 lagrange.angles=free"
TABLES: dict[str, tuple[str, tuple[str, ...]]] = {
    "shaft": ("operation.shaft=springs operation.shaft_stiffness_N_per_m=1e7 operation.shaft_damping_N_s_m=50", ()),
    "housing": (HOUSING, ()),
    "sensor": (f"{HOUSING} sensor.frequency_Hz=15000 sensor.damping_ratio=0.05", ()),
    "points": ("support.kind=points", ("reduced", "lagrange")),
    "bore": ("support.kind=bore support.fit_clearance_um=10", ("reduced", "lagrange")),
    "fitted-housing": (f"{HOUSING} support.fit_clearance_um=10", ("reduced", "lagrange")),
    "cage": (CAGE, ()),
    "guided-cage": (f"{CAGE} cage.guidance=inner_ring cage.guidance_clearance_mm=0.3 cage.drag_torque_N_m=0.001", ()),
    "spall": (SPALL, ()),
    "damped-spall": (f"{SPALL} damping.contact_time_us=12.5", ()),
    "inner-spall": ('spall=[{body="inner_ring",width_mm=0.8,angle_deg=4.0}] damping.contact_N_s_m=500', ()),
    "roller-spall": ('spall=[{body="roller",roller=0,width_mm=0.8,angle_deg=0.0}] damping.contact_N_s_m=500', ()),
    "waviness": ('waviness=[{body="inner_ring",order=12,amplitude_um=0.5}]', ()),
    "unequal-roller": ("unequal_roller=[{roller=1,diameter_deviation_um=2.0}]", ()),
    "profile": ('profile=[{body="outer_ring",file="heights.csv"}]', ()),
    "lubricant": ("lubricant.viscosity_Pa_s=0.02", ()),
    "speed-history": ("operation.speed_table=speeds.csv", ()),
    "load-history": ("operation.load_table=loads.csv", ()),
    "unbalance": ("operation.unbalance_g_mm=50 operation.rotating_load_N=300", ()),
    "hunt-crossley": ("damping.hunt_crossley_s_m=0.5", ()),
    "body-damping": ("damping.bodies_1_s=500", ("reduced", "lagrange")),
    "balls": (f"{BALLS} {HOUSING}", ("fem", "reduced")),
    "tilted": ("axial.roller_profile=logarithmic operation.misalignment_mrad=1", ()),
    "materials": ("material.roller.youngs_modulus_GPa=310 material.roller.density_kg_m3=3250", ()),
}
RESUMED = "cage", "damped-spall", "tilted"
SCENES += tuple(
    _scene(f"{model}-{table}", duration, f"model={model} {choices} {keys}", resumed=table in RESUMED)
    for table, (keys, refusing) in TABLES.items()
    for model, (duration, choices) in MODELS.items()
    if model not in refusing
)


class Tree:
    """A checkout whose commands are run; meshes are kept apart from every other's, compiled kernels are not."""

    def __init__(self, folder: Path, room: Path):
        self.folder, self.room = folder, room
        room.mkdir()
        for name, text in FILES.items():
            (room / name).write_text(text)
        kernels = os.environ.get("NUMBA_CACHE_DIR") or Path.home() / ".cache" / "roller-bearing-fem"
        own = {"PYTHONPATH": folder, "XDG_CACHE_HOME": room / "cache", "NUMBA_CACHE_DIR": kernels}
        self.environment = os.environ | {name: str(value) for name, value in own.items()}

    def command(self, module: str, *arguments: str, **environment: str) -> None:
        """Run a command of the tree.

        Errors
        ------
        RuntimeError: it failed, with what it said.
        """
        command, environment = [sys.executable, "-m", module, *arguments], self.environment | environment
        done = subprocess.run(command, cwd=self.room, env=environment, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{self.folder}: {module} {' '.join(arguments)}\n{done.stderr.strip()}")

    def run(self, scene: Short) -> Path:
        """The result file of a scene."""
        path = self.room / f"{scene.name}.nc"
        keys = [word for key in scene.keys for word in ("--set", key)]
        ends = (0.5 * scene.duration_ms, scene.duration_ms) if scene.resumed else (scene.duration_ms,)
        for part, end in enumerate(ends):
            more = ("--resume",) if part else ()
            self.command("fem", "--output", str(path), "--quiet", "--duration", repr(end), *keys, *more)
        return path

    def report(self, path: Path, *options: str) -> dict:
        """Numbers of a run's report."""
        folder = self.room / path.stem
        self.command("residual.cli", str(path), "--output", str(folder), *options)
        return json.loads((folder / "summary.json").read_text())

    def judged(self, path: Path) -> dict:
        """Numbers of a stored run: its report with a search for spalls, its rating."""
        folder = self.room / f"{path.stem}-rated"
        self.command("fem.commands.rate_bearing", str(path), "--output", str(folder), "--quiet")
        rating = json.loads(next(folder.glob("*-rating.json")).read_text())
        return {"report": self.report(path, "--find-faults"), "rating": rating}


def differences(one: Path, other: Path) -> Iterator[str]:
    """What two result files differ in: variables byte by byte, attributes."""
    with h5py.File(one, "r") as a, h5py.File(other, "r") as b:
        for name in sorted((set(a.attrs) | set(b.attrs)) - UNLIKE):
            if not np.array_equal(a.attrs.get(name), b.attrs.get(name)):
                yield f"attribute {name}: {a.attrs.get(name)!r} was {b.attrs.get(name)!r}"
        names: set[str] = set()
        for file in (a, b):
            file.visititems(lambda name, item: names.add(name) if isinstance(item, h5py.Dataset) else None)
        for name in sorted(names):
            if name not in a or name not in b:
                yield f"{name}: only in {'the base' if name not in a else 'this tree'}"
                continue
            x, y = a[name][()], b[name][()]
            if x.shape != y.shape or (x.tolist() != y.tolist() if x.dtype.kind == "O" else x.tobytes() != y.tobytes()):
                yield f"{name}: {_size(x, y)}"


def _size(x: np.ndarray, y: np.ndarray) -> str:
    if x.shape != y.shape:
        return f"shape {x.shape} was {y.shape}"
    if x.dtype.kind != "f":
        return "differs"
    gap, where = np.abs(x - y), np.flatnonzero(np.asarray(x != y).ravel())
    largest = float(np.nanmax(np.abs(y))) or 1.0
    most = np.nanmax(gap) / largest
    return f"{where.size} of {x.size} differ, first at {where[:1]}, at most {most:.1e} of the largest"


def _unlike(one, other, place: str = "", allowed: float = 0.0) -> Iterator[str]:
    """Numbers of two reports that are not the same."""
    if isinstance(one, dict) and isinstance(other, dict):
        for key in sorted((set(one) | set(other)) - UNLIKE_IN_REPORT):
            yield from _unlike(one.get(key), other.get(key), f"{place}.{key}".lstrip("."), allowed)
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for i, pair in enumerate(zip(one, other, strict=True)):
            yield from _unlike(*pair, f"{place}[{i}]", allowed)
    elif json.dumps(one) != json.dumps(other):
        if isinstance(one, float) and isinstance(other, float) and abs(one - other) <= allowed * abs(other):
            return
        yield f"report: {place} = {one!r} was {other!r}"


def compare(scene: Short, mine: Tree, base: Tree, numbers: bool) -> list[str]:
    """Everything in which a scene's results differ, or the numbers of both trees' judgements of the base's result."""
    if numbers:
        path = base.run(scene)
        return list(_unlike(mine.judged(path), base.judged(path), allowed=SAME_NUMBER))
    one, other = mine.run(scene), base.run(scene)
    found = list(differences(one, other))
    if scene.report:
        found += _unlike(mine.report(one), base.report(other))
    return found


@contextmanager
def checked_out(revision: str, unfused: bool) -> Iterator[tuple[Tree, Tree]]:
    """This tree and a revision's, which goes when done."""
    git = ["git", "-C", str(ROOT)]
    with tempfile.TemporaryDirectory(prefix="same-bits-") as room:
        folder, here = Path(room) / "base", ROOT
        subprocess.run([*git, "worktree", "add", "--quiet", "--detach", str(folder), revision], check=True)
        try:
            if unfused:
                here, strange = Path(room) / "here", shutil.ignore_patterns("__pycache__")
                for package in ("lagrange", "meshes", "fem", "residual"):
                    shutil.copytree(ROOT / package, here / package, ignore=strange)
                for tree in (here, folder):
                    _unfuse(tree)
            yield Tree(here, Path(room) / "mine"), Tree(folder, Path(room) / "of-base")
        finally:
            subprocess.run([*git, "worktree", "remove", "--force", str(folder)], check=True)


def _unfuse(tree: Path) -> None:
    """Have a tree's lanes multiply and add one after the other."""
    kernels = tree / "fem" / "kernels"
    found = [path for path in kernels.glob("*.py") if FUSED in path.read_text()]
    if not found:
        raise RuntimeError(f"{kernels}: no module has {FUSED!r} to turn off")
    for path in found:
        path.write_text(path.read_text().replace(FUSED, "_FUSED = ()"))


def _taken(tree: Tree, *arguments: str, **environment: str) -> tuple[float, float]:
    """Wall and processor time of one run-fem, s."""
    command = "fem", "--quiet", "--force", "--output", str(tree.room / "speed.nc"), *arguments
    return used(tree.command, *command, **environment)


def _speed(mine: Tree, base: Tree, sizes: list[float], pairs: int) -> str:
    headings = "mesh, mm", "this tree, s", "base, s", "ratio of wall times", "of processor times", "of fastest runs"
    rows = []
    for size in sizes:
        options = ("--mesh-size", repr(size), "--duration", repr(SPEED_MS))
        for tree in (mine, base):  # compiled, meshed
            _taken(tree, "--mesh-size", repr(size), "--duration", "0.01")
        calls = {tree: partial(_taken, tree, *options) for tree in (mine, base)}
        taken = [(*found[mine], *found[base]) for found in in_turns(calls, pairs)]
        wall, spent, base_wall, base_spent = np.array(taken).T
        ratios = [f"{statistics.median(r):.3f} ({min(r):.3f} … {max(r):.3f})"
                  for r in (wall / base_wall, spent / base_spent)]  # fmt: skip
        # the least of each is free of other programs and of the processor's slower paces
        ratios.append(f"{min(spent) / min(base_spent):.3f}")
        rows.append((f"{size:g}", f"{statistics.median(wall):.2f}", f"{statistics.median(base_wall):.2f}", *ratios))
    return f"Whole runs of {SPEED_MS:g} ms, {pairs} pairs in turns, one thread\n\n{markdown_table(headings, rows)}"


def _cold(mine: Tree, base: Tree) -> str:
    """Processor time of a first start, whose kernels are all to be compiled."""
    seconds = []
    for tree in (mine, base):
        _taken(tree, "--duration", "0")  # meshes
        with tempfile.TemporaryDirectory() as empty:
            seconds.append(_taken(tree, "--duration", "0.01", NUMBA_CACHE_DIR=empty)[1])
    took, base_took = seconds
    return f"first start, processor time: {took:.1f} s, base {base_took:.1f} s, ratio {took / base_took:.2f}"


app = App(name="same_bits", help=__doc__, help_format="plaintext", result_action="return_value")


@app.default
def main(
    base: Annotated[str, Parameter(help="git revision to compare with")],
    /,
    *,
    scenes: Annotated[str | None, Parameter(help="names of scenes, by commas; default: all")] = None,
    unfused: Annotated[bool, Parameter(negative="", help="no product fused with a sum, in both trees")] = False,
    workers: Annotated[int, Parameter(help="scenes run at the same time")] = 1,
    speed: Annotated[list[float] | None, Parameter(help="mesh sizes to time, mm; repeatable", negative="")] = None,
    pairs: Annotated[int, Parameter(help="timed runs of each tree")] = 10,
    cold: Annotated[bool, Parameter(negative="", help="time a first start instead")] = False,
    numbers: Annotated[bool, Parameter(negative="", help="compare what is said of stored runs instead")] = False,
) -> int:
    """Compare this tree with a revision; 1 where any scene differs."""
    every = set(JUDGED.split()) if numbers else {scene.name for scene in SCENES}
    wanted = set(scenes.split(",")) if scenes else every
    if unknown := wanted - {scene.name for scene in SCENES}:
        print(f"unknown scenes: {', '.join(sorted(unknown))}; known: {', '.join(s.name for s in SCENES)}")
        return 2
    with checked_out(base, unfused) as (mine, old):
        if speed:
            print(_speed(mine, old, speed, pairs))
        if cold:
            print(_cold(mine, old))
        if speed or cold:
            return 0
        chosen = [scene for scene in SCENES if scene.name in wanted]
        unlike = 0
        with ThreadPoolExecutor(workers) as pool:
            compared = pool.map(lambda scene: compare(scene, mine, old, numbers), chosen)
            for scene, found in zip(chosen, compared, strict=True):
                unlike += bool(found)
                print(f"{scene.name:20s} {'same' if not found else 'DIFFERS'}")
                for what in found[:MOST_TOLD]:
                    print(f"    {what[:LONGEST_TOLD]}")
                if len(found) > MOST_TOLD:
                    print(f"    and {len(found) - MOST_TOLD} more")
    print(f"{len(chosen) - unlike} of {len(chosen)} scenes the same")
    return 1 if unlike else 0


if __name__ == "__main__":
    sys.exit(app())
