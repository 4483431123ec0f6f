"""Pictures of docs/, and the figures that docs/pictures.md states: stress below contacts, times, sizes."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import App, Parameter

from benchmarks import used
from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.pictures.bodies import drawn_bearing, shear_peak
from fem.pictures.look import Request
from fem.pictures.recover import FIRST_ROLLER, INNER_RING, StoredRun
from fem.pictures.stress_below import AT_DEPTH, LARGEST_SHEAR
from fem.pictures.views import draw
from tests import documented
from tests.measurements import DOCS

MESH_SIZES = (2.0, 1.0, 0.5)  # mm
PHASES = (0.0, 1.3, 4.1, 9.2, 13.8)  # degrees of the first roller from the load line
LEAST_FORCE = 100.0  # N, of a contact looked at
INSTANT = "12.5"  # ms
PICTURES = {"bearing.png": [], "close-up.png": ["--view", "close-up"]}
FAULTS = (
    "name=faults", "model=reduced", "numerics.duration_ms=0.4", "numerics.output_interval_us=2", "spall.0.angle_deg=3",
    "spall.1.body=inner_ring", "spall.1.angle_deg=40", "spall.2.body=roller", "spall.2.roller=2",
    "spall.2.angle_deg=-90", "waviness.0.amplitude_um=2", "unequal_roller.0.roller=5",
    "unequal_roller.0.diameter_deviation_um=3",
)  # fmt: skip
FAULT_PICTURES = {
    "faults.png": ["--time", "0.3"],
    "spall.png": ["--time", "0.34", "--view", "close-up", "--roller", "0"],
}
HALF = ("numerics.output_interval_us=5", "numerics.duration_ms=100")
HELD = ("name=held-at-the-top", "support.kind=points", "support.angles_deg=[180]", "numerics.duration_ms=0")
OF_SCENES = {  # a scene, further keys, words of render-fem
    "half_spall.png": ("half", HALF, ["--view", "axial", "--time", "91.82"]),
    "supports.png": (None, HELD, ["--field", "displacement", "--magnification", "80", "--width", "1100"]),
}
OF_PAGES = {  # what the commands of a page write
    "tutorial_design.png": ("design_tutorial.md", "gearbox.png"),
    "tutorial_stress.png": ("stress_tutorial.md", "contact.png"),
    "tutorial_vibration.png": ("vibration_tutorial.md", "compared/envelope.png"),
    "tutorial_equations.png": ("equations_tutorial.md", "table-residual/whole_spectra.png"),
}
# two roller passages, so that the film closes on itself but for the numbers
FILM = ["--start", "10", "--stop", "15.16", "--frames", "30", "--fps", "12", "--width", "480"]


def below_contacts(folder: Path) -> None:
    """Print the largest shear below every contact of the standing bearing, over p₀, and its depth, over b."""
    print("| mesh, mm | body | contacts | shear / p₀ | deviation | depth / b | deviation |")
    print("|---|---|---|---|---|---|---|")
    for mesh_size in MESH_SIZES:
        found = {"inner ring": [], "outer ring": [], "roller": []}
        for degrees in PHASES:
            path = folder / "standing.nc"
            sets = (f"operation.first_roller_deg={degrees}", "operation.speed_rpm=0", "operation.gravity_m_s2=0")
            options = [word for each in sets for word in ("--set", each)]
            options += ["--mesh-size", str(mesh_size), "--duration", "0", "--quiet", "--force", "--output", str(path)]
            assert run_main(options) == 0
            run = StoredRun(path)
            drawn = drawn_bearing(run.instant(0))
            for item in drawn.loads:
                if np.hypot(*item.load.force) * run.model.bearing.roller_length > LEAST_FORCE:
                    peak = shear_peak(drawn, item)
                    body = "roller" if item.body >= FIRST_ROLLER else (
                        "inner ring" if item.body == INNER_RING else "outer ring"
                    )  # fmt: skip
                    found[body].append((peak.shear / peak.pressure, peak.depth / peak.half_width))
        for body, values in found.items():
            shear, depth = np.array(values).T
            print(
                f"| {mesh_size:g} | {body} | {len(values)} | {shear.min():.4f} … {shear.max():.4f} | "
                f"{_worst(shear, LARGEST_SHEAR)} | {depth.min():.3f} … {depth.max():.3f} | {_worst(depth, AT_DEPTH)} |"
            )


def _worst(values: np.ndarray, expected: float) -> str:
    deviation = 100.0 * (values / expected - 1.0)
    return f"{deviation[np.argmax(np.abs(deviation))]:+.1f} %"


def draw_pages(folder: Path) -> None:
    """Pictures of scenes that pages show, and those that their commands write."""
    for file, (name, keys, options) in OF_SCENES.items():
        run, scene = folder / "scene.nc", []
        if name is not None:
            scene = [str(folder / f"{name}.toml")]
            Path(scene[0]).write_text(documented.files(DOCS / "tilted_motion.md")[f"{name}.toml"], encoding="utf-8")
        sets = [word for each in keys for word in ("--set", each)]
        assert run_main([*scene, "--output", str(run), "--quiet", *sets]) == 0
        assert render_main([str(run), "--output", str(DOCS / file), "--force", *options]) == 0
        run.unlink()
    for file, (page, written) in OF_PAGES.items():
        with tempfile.TemporaryDirectory() as name:
            place = Path(name)
            for scene, text in documented.files(DOCS / page).items():
                (place / scene).write_text(text, encoding="utf-8")
            programs = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
            for command in documented.commands(DOCS / page):
                if not (place / written).exists():
                    shell = ["python", "-c"] if command.startswith("import") else ["bash", "-c"]
                    subprocess.run([*shell, command], cwd=place, env=os.environ | programs, check=True)
            shutil.copy(place / written, DOCS / file)


def times(run: Path, folder: Path) -> None:
    """Print wall and processor time, s, of pictures, films and exports of the paper's run, libraries loaded."""
    print("| what | seconds | of CPU | MB |")
    print("|---|---|---|---|")
    stored = StoredRun(run)
    sample = stored.nearest(1e-3 * float(INSTANT))
    once = Request()
    for name, request in (("bearing, first picture", once), ("bearing", once), ("close-up", Request(view="close-up"))):
        one = folder / "one.png"
        _row(name, one, lambda request=request, one=one: draw(StoredRun(run), one, request, sample))
    written = ("film.mp4", "--animation", "120 frames, 960 wide"), ("film.gif", "--animation", "120 frames, 960 wide")
    for name, option, what in (*written, ("run.vtkhdf", "--export", "120 instants")):
        _row(f"{name}, {what}", folder / name, render_main, [str(run), option, str(folder / name), "--quiet"])


def _row(name: str, path: Path, *call) -> None:
    """Print a line of the table about a call and the file, or folder of its name, that it writes."""
    took, spent = used(*call)
    size = sum(file.stat().st_size for file in (path, *path.with_suffix("").glob("*")))
    print(f"| {name} | {took:.1f} | {spent:.1f} | {1e-6 * size:.2g} |", flush=True)


app = App(help=__doc__)


@app.default
def main(*, pictures: Annotated[bool, Parameter(negative="")] = False) -> None:
    """Make the runs and print the tables.

    Parameters
    ----------
    pictures: also re-make the pictures in docs/
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = folder / "paper.nc"
        assert run_main(["--output", str(run), "--quiet"]) == 0
        if pictures:
            for file, words in PICTURES.items():
                assert render_main([str(run), "--time", INSTANT, "--output", str(DOCS / file), *words]) == 0
            faulty = folder / "faults.nc"
            sets = [word for each in FAULTS for word in ("--set", each)]
            assert run_main(["--output", str(faulty), "--quiet", *sets]) == 0
            for file, words in FAULT_PICTURES.items():
                assert render_main([str(faulty), "--output", str(DOCS / file), *words]) == 0
            draw_pages(folder)
            assert render_main([str(run), "--animation", str(DOCS / "bearing.gif"), "--quiet", *FILM]) == 0
        below_contacts(folder)
        times(run, folder)
        fields = folder / "fields.nc"
        assert run_main(["--output", str(fields), "--quiet", "--set", "output.fields_every_ms=0.5"]) == 0
        more = 1e-6 * (fields.stat().st_size - run.stat().st_size)
        print(f"fields every 0.5 ms: {StoredRun(fields).frames.size} frames, {more:.2g} MB more")


if __name__ == "__main__":
    app()
