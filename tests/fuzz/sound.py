"""Small sound inputs for each reader, from which the search and the tests start."""

import io
import tempfile
from pathlib import Path

import numpy as np

DURATION = ["--duration", "0.4"]
FEW_ROLLERS = """[bearing]
rollers = 3
inner_raceway_diameter_mm = 36.0
"""

GRID = """[fixed]
model = "lagrange"
"numerics.duration_ms" = 1.0
[parameters]
"operation.speed_rpm" = [1500, 3000]
"bearing.clearance_um" = { from = 0, to = 40, count = 3 }
[keep]
quantities = ["hub_mean_y", "error_rms_y"]
signals = ["inner_ay"]
signal_rate_kHz = 20.0
"""
DRAWN = """name = "drawn"
[sampling]
method = "sobol"
samples = 4
seed = 3
indices = true
[fixed]
model = "lagrange"
[parameters]
"operation.radial_load_N" = { from = 250.0, to = 8000.0, scale = "log" }
"material.youngs_modulus_GPa" = { normal = [210, 5] }
[limits]
seconds_per_point = 5.0
"""
LISTED = '[sampling]\nmethod = "list"\nfile = "points.csv"\n[fixed]\nmodel = "lagrange"\n'
STUDIES = GRID, DRAWN, DRAWN.replace("sobol", "lhs").replace("indices = true\n", ""), LISTED


def seeds(name: str) -> list[bytes]:
    """Make small sound inputs to start from."""
    from lagrange.scene.scene import Scene

    if name == "scene":
        ball = '[bearing]\ntype = "ball"\n[material.roller]\ndensity_kg_m3 = 3200\n[operation]\nspeed_rpm = -3e3\n'
        mapped = '[table]\ntime = "t [ms]"\nroller_x = "x_{j} [um]"\ndecimal = ","\n'
        faulty = (
            '[[spall]]\nbody = "roller"\nroller = 3\n[[spall]]\nwidth_mm = 2.0\nangle_deg = 90\nedge_radius_mm = 0\n'
        )
        faulty += "[[waviness]]\norder = 14\n[[unequal_roller]]\nroller = 5\n"
        return [text.encode() for text in (Scene().to_toml(), ball, mapped, faulty, "name = 'x'\n")]
    if name == "heights":
        rows = [f"{angle},{0.1 * (angle % 7):.2g}" for angle in range(360)]
        return ["\n".join(["angle_deg,height_um", *rows]).replace(",", mark).encode() for mark in ",\t"]
    if name == "speeds":
        return [
            b"time_ms,speed_rpm\n0,1000\n2,1500\n6,5000\n80,6000\n",
            b"# ramp\nspeed_rpm;time_ms\n-300;-1\n10;900\n",
        ]
    if name == "loads":
        return [
            b"time_ms,x_N,y_N\n0,0,-2000\n2,500,-1500\n4,500,-2500\n100,-300,-2000\n",
            b"y_N\ttime_ms\tx_N\n-1\t0\t9\n-3\t99\t8\n",
        ]
    if name.startswith("record_"):
        return _records(name.removeprefix("record_"))
    if name == "study":
        return [text.encode() for text in STUDIES]
    with tempfile.TemporaryDirectory() as folder:
        if name == "folder":
            return [_study_facts(Path(folder), text) for text in STUDIES[:2]]
        path = Path(folder) / "seed.nc"
        scene = Path(folder) / "few.toml"
        scene.write_text(FEW_ROLLERS)
        _run([str(scene), "--model", "lagrange", *DURATION, "--output", str(path)])
        return [_table(path, ",", True), _table(path, "\t", False)]


def _records(kind: str) -> list[bytes]:
    """A record of 0.26 s in files of a kind."""
    from scipy.io import wavfile

    rate, rng = 8000, np.random.default_rng(1)
    time = np.arange(2100) / rate
    wave = np.sin(820.0 * time) + 0.1 * rng.standard_normal(time.size)

    def written(write, *arguments, **keywords) -> bytes:
        target = io.BytesIO()
        write(target, *arguments, **keywords)
        return target.getvalue()

    if kind == "text":
        rows = [f"{t:.6f},{a:.5f}" for t, a in zip(time, wave, strict=True)]
        plain = "\n".join(["time_s,acc_g", *rows])
        german = "\n".join(row.replace(",", ";").replace(".", ",") for row in rows)
        one = "\n".join(f"{a:.5f}" for a in wave)
        latin = f"Zeit [s];Wert [m/s²]\n{german}".encode("cp1252")
        return [plain.encode(), latin, f"Sampling rate: 8000 Hz\nacc\n{one}".encode("utf-16")]
    if kind == "wav":
        return [written(wavfile.write, rate, values) for values in (wave.astype("f4"), (9e3 * wave).astype("i2"))]
    if kind == "numpy":
        return [written(np.savez, acc=wave, fs=8e3), written(np.savez, time=time, acc=wave)]


def _study_facts(place: Path, text: str) -> bytes:
    """What run-study writes of a study before it solves the first point."""
    from fem.study.folder import Folder
    from fem.study.solving import checked_points
    from fem.study.study_file import design_of, read_study

    (place / "study.toml").write_text(text, encoding="utf-8")
    study = read_study(place / "study.toml")
    Folder(path=place).begin(checked_points(study, design_of(study)))
    return (place / "study.json").read_bytes()


def _run(arguments: list[str]) -> None:
    from fem.commands.run_fem import run_main

    if run_main([*arguments, "--quiet"]) != 0:
        raise RuntimeError("the run that makes the first input failed")


def _table(path: Path, delimiter: str, forces: bool) -> bytes:
    """Write a result file's motion as a table, with or without its accelerations and contact forces."""
    import h5py

    with h5py.File(path) as file:
        columns = {name: file[name][:] for name in ("time", "inner_x", "inner_y")}
        for axis in "xy":
            columns |= {f"roller_{j}_{axis}": column for j, column in enumerate(file[f"roller_{axis}"][:].T)}
        for name in ("inner_force", "outer_force") if forces else ():
            columns |= {f"roller_{j}_{name}": column for j, column in enumerate(file[name][:].T)}
        columns |= {name: file[name][:] for name in ("inner_ax", "inner_ay")} if forces else {}
    text = io.StringIO()
    np.savetxt(text, np.column_stack(list(columns.values())), "%.9g", delimiter,
               header=delimiter.join(columns), comments="")  # fmt: skip
    return text.getvalue().encode()
