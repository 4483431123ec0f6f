"""Files and options that must be refused: name -> a function that writes them into a folder.

Each gives the command, its arguments and what the refusal must say; those of BAD_CHECKPOINTS take a finished run too.
"""

import os

import h5py
import numpy as np

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path
from residual.cli import main as check_main
from tests.reference.synthetic_run import make_run, write_result, write_table

RUN = make_run(n_times=64)
FINE = "[operation]\nradial_load_N = 1\n[numerics]\nmesh_size_mm = 0.026\n"  # uniform: contacts are far narrower


def result(change, *words, options=()):
    """A result file with one thing wrong."""

    def make(folder):
        path = write_result(folder / "bad.nc", RUN)
        with h5py.File(path, "a") as file:
            change(file)
        return check_main, [str(path), *options], ["bad.nc", *words]

    return make


def replaced(name, value, *words):
    """Exchange one variable; None drops it."""

    def change(file):
        old = file[name][:]
        del file[name]
        if value is not None:
            file[name] = value(old)

    return result(change, *words)


def attribute(name, value, *words):
    """Exchange one attribute; None drops it."""

    def change(file):
        if value is None:
            del file.attrs[name]
        else:
            file.attrs[name] = value

    return result(change, *words)


def poked(name, place, value, *words):
    def change(old):
        old[place] = value
        return old

    return replaced(name, change, *words)


def spoilt(change, *words):
    """A result file whose bytes have been changed."""

    def make(folder):
        path = write_result(folder / "bad.nc", RUN)
        path.write_bytes(change(path.read_bytes()))
        return check_main, [str(path)], ["bad.nc", *words]

    return make


def content(name, data, *words):
    """A file with this content."""

    def make(folder):
        (folder / name).write_bytes(data if isinstance(data, bytes) else data.encode())
        return check_main, [str(folder / name)], [name, *words]

    return make


def table(edit, *words, with_scene=True, scene_text="", options=()):
    """A trajectory table whose lines have been edited."""

    def make(folder):
        path = write_table(RUN, folder / "bad.csv")
        lines = edit(path.read_text().splitlines())
        path.write_bytes(lines if isinstance(lines, bytes) else ("\n".join(lines) + "\n").encode())
        (folder / "scene.toml").write_text(scene_text)
        chosen = ["--scene", str(folder / "scene.toml")] if with_scene else []
        return check_main, [str(path), *chosen, *options], ["bad.csv", *words]

    return make


def row(number, change):
    """Change one row of a table; row 0 is the header."""
    return lambda lines: [*lines[:number], change(lines[number]), *lines[number + 1 :]]


def cell(number, text):
    """Exchange the first cell of a row."""
    return row(number, lambda line: text + line[line.index(",") :])


def sound(*arguments, say):
    """A sound result file with unusable options."""

    def make(folder):
        path = write_result(folder / "made.nc", RUN)
        (folder / "other.toml").write_text("[operation]\nspeed_rpm = 3000.0\n")
        (folder / "photos").mkdir()
        (folder / "photos" / "cat.jpg").write_text("meow")
        return check_main, [str(path), *(a.format(folder=folder) for a in arguments)], say.split(" & ")

    return make


def huge(file):
    for name in ("time", "inner_x", "inner_y", "roller_x", "roller_y"):
        del file[name]
        shape = (10**12,) if not name.startswith("roller") else (10**12, 13)
        file.create_dataset(name, shape=shape, dtype="f8", chunks=True)
    file.attrs["committed_samples"] = 10**12


def promised(file):
    """A variable of sixteen gigabytes of zeros in a few bytes."""
    for name in ("time", "inner_x", "inner_y", "roller_x", "roller_y"):
        del file[name]
        shape = (2 * 10**9,) if not name.startswith("roller") else (2 * 10**9, 13)
        file.create_dataset(name, shape=shape, dtype="f8", chunks=(1024, 13)[: len(shape)], compression="gzip")
    file.attrs["committed_samples"] = 2 * 10**9


def large_chunks(file):
    del file["inner_x"]
    file.create_dataset("inner_x", shape=(64,), maxshape=(None,), dtype="f8", chunks=(2**28,), compression="gzip")


def outside(kind):
    """A variable that lies in another file of the user's."""

    def change(file):
        del file["inner_x"]
        if kind == "link":
            file["inner_x"] = h5py.ExternalLink("/etc/hostname", "/inner_x")
        elif kind == "soft link":
            file["inner_x"] = h5py.SoftLink("/inner_x")
        elif kind == "storage":
            file.create_dataset("inner_x", shape=(64,), dtype="f8", external=[("/etc/passwd", 0, 512)])
        else:
            layout = h5py.VirtualLayout(shape=(64,), dtype="f8")
            layout[:] = h5py.VirtualSource("/etc/passwd", "inner_x", shape=(64,))
            file.create_virtual_dataset("inner_x", layout)

    return change


BAD_FILES = {
    "no such file": lambda folder: (check_main, [str(folder / "gone.nc")], ["gone.nc", "no such file"]),
    "a folder": lambda folder: (check_main, [str(folder)], [str(folder), "not a file"]),
    "the folder one is in": lambda folder: (check_main, ["."], [".: not a file"]),
    "no name": lambda folder: (check_main, [""], [".: not a file"]),
    "no runs at all": lambda folder: (check_main, [], ["run-fem", "runs"]),
    "empty file": content("bad.nc", "", "empty"),
    "not HDF5": content("bad.nc", "time,inner_x\n", "not an HDF5 file"),
    "HDF5 signature only": content("bad.nc", b"\x89HDF\r\n\x1a\n" + bytes(40), "damaged"),
    "signature and noise": content("bad.nc", b"\x89HDF\r\n\x1a\n" + np.random.default_rng(1).bytes(4000), "damaged"),
    "NetCDF of the classic kind": content("bad.nc", b"CDF\x01" + bytes(100), "not an HDF5 file"),
    "truncated": spoilt(lambda data: data[: len(data) // 2], "damaged"),
    "last byte missing": spoilt(lambda data: data[:-1]),
    "overwritten in the middle": spoilt(lambda data: data[:200] + b"\xa5" * 3800 + data[4000:], "damaged"),
    "no scene": attribute("scene", None, "not a result file"),
    "no counter": attribute("committed_samples", None, "not a result file"),
    "wrong version": attribute("format_version", 99, "format_version = 99"),
    "no version": attribute("format_version", None, "format_version = None"),
    "version as text": attribute("format_version", "one", "format_version = 'one'"),
    "scene not TOML": attribute("scene", "name = [", "scene", "TOML"),
    "scene impossible": attribute("scene", "[operation]\nspeed_rpm = nan\n", "scene", "speed_rpm"),
    "scene of numbers": attribute("scene", np.arange(5), "scene"),
    "scene of other bytes": attribute("scene", np.void(b"\xff\xfe\x00"), "scene"),
    "scene that has been changed": result(lambda file: file.attrs.update(scene_checksum=1), "scene", "checksum"),
    "negative counter": attribute("committed_samples", -3, "committed_samples = -3"),
    "counter as text": attribute("committed_samples", "many", "committed_samples = 'many'"),
    "counter as a list": attribute("committed_samples", [1, 2], "committed_samples"),
    "counter beyond the data": attribute("committed_samples", 100_000, "100000", "truncated"),
    "counter beyond a word": attribute("committed_samples", np.uint64(2**63 + 5), "9223372036854775813"),
    "too few samples": attribute("committed_samples", 10, "10", "32"),
    "nothing committed": attribute("committed_samples", 0, "0 committed samples"),
    "no inner_y": replaced("inner_y", None, "inner_y"),
    "no time": replaced("time", None, "time"),
    "no loads in a file of run-fem": result(
        lambda file: (file.attrs.update(program="run-fem"), file.move("outer_traction", "outer_tractioo")),
        "missing outer_traction",
    ),
    "no variable at all": result(lambda file: [file.pop(name) for name in list(file)], "missing"),
    "NaN": poked("inner_x", 7, np.nan, "inner_x is nan at sample 7"),
    "infinite force": poked("inner_force", (7, 3), np.inf, "inner_force is inf at sample 7, roller 3"),
    "NaN in the energies": poked("energy_kinetic", 7, np.nan, "energy_kinetic"),
    "force of a star": poked("inner_force", (7, 3), 1e300, "inner_force", "1e+15"),
    "time falls": poked("time", 7, 0.0, "time does not rise after sample 6"),
    "time stands": poked("time", 7, 6e-5, "time does not rise"),
    "time backwards": replaced("time", lambda t: t[::-1].copy(), "time does not rise"),
    "time irregular": replaced("time", lambda t: t + np.where(t > 1e-4, 3e-6, 0.0), "sampling interval"),
    "time in no steps": replaced("time", lambda t: 1e-300 * np.arange(t.size), "sampling interval", "seconds"),
    "rollers missing": replaced("roller_x", lambda v: v[:, :-1], "roller_x holds 12 rollers", "13"),
    "roller loads of another bearing": replaced("inner_force", lambda v: v[:, :-1], "inner_force holds 12 rollers"),
    "flat roller array": replaced("roller_y", lambda v: v[:, 0], "roller_y", "shape"),
    "array of three dimensions": replaced("roller_y", lambda v: v[:, :, None], "roller_y", "shape"),
    "text instead of numbers": replaced("inner_x", lambda v: v.astype("S8"), "inner_x", "floating-point"),
    "whole numbers": replaced("inner_x", lambda v: np.zeros(v.size, dtype=int), "inner_x", "floating-point"),
    "complex numbers": replaced("inner_x", lambda v: v + 1j, "inner_x", "floating-point"),
    "group instead of an array": result(
        lambda file: (file.__delitem__("inner_x"), file.create_group("inner_x")), "inner_x"
    ),
    "type instead of an array": result(
        lambda file: (file.__delitem__("inner_x"), file.__setitem__("inner_x", np.dtype("f8"))), "inner_x"
    ),
    "millimetres": replaced("roller_x", lambda v: 1e3 * v, "metres"),
    "hub in millimetres": replaced("inner_y", lambda v: 1e4 * v, "inner_x, inner_y", "metres"),
    "another checksum": result(
        lambda file: file["inner_x"].attrs.update(checksum=[64, 1, -1, 0]), "inner_x", "checksum"
    ),
    "checksum of other samples": result(lambda file: file["inner_x"].attrs.update(checksum=[5, 1, 6, 2]), "inner_x"),
    "checksum in words": result(lambda file: file["inner_x"].attrs.update(checksum="sum"), "checksum"),
    "too big to hold": result(huge),
    "more zeros than memory": result(promised, "time", "only part"),
    "chunks larger than memory": result(large_chunks, "inner_x", "chunks"),
    "link into another file": result(outside("link"), "inner_x", "link"),
    "link to itself": result(outside("soft link"), "inner_x", "link"),
    "numbers of another file": result(outside("storage"), "inner_x", "another file"),
    "pieces of other files": result(outside("pieces"), "inner_x", "another file"),
    "table without scene": table(lambda lines: lines, "--scene", with_scene=False),
    "table without time": table(lambda lines: [line.partition(",")[2] for line in lines], "time"),
    "table without a header": table(lambda lines: lines[1:], "neither"),
    "table with a word": table(cell(5, "zero"), "zero"),
    "table with an empty cell": table(cell(5, ""), "line 6"),
    "table with a short row": table(row(5, lambda line: line.rpartition(",")[0]), "line 6"),
    "table with two points in a number": table(cell(5, "1.2.3"), "1.2.3"),
    "table with commas for points": table(lambda lines: [lines[0]] + [line.replace(".", ",") for line in lines[1:]]),
    "table with a formula": table(cell(5, "=1+1"), "=1+1"),
    "table with a roller less": table(lambda lines: [line.rsplit(",", 2)[0] for line in lines], "12 rollers", "13"),
    "table with a roller more": table(
        lambda lines: [f"{lines[0]},roller_13_x,roller_13_y", *(f"{line},0,0" for line in lines[1:])], "14"
    ),
    "table with a column twice": table(
        lambda lines: [f"{line},{line.split(',')[0]}" for line in lines], "time", "twice"
    ),
    "table with NaN": table(cell(5, "nan"), "time is nan"),
    "table with a number beyond all": table(cell(5, "1e999"), "time is inf"),
    "table of a header only": table(lambda lines: lines[:1], "0 usable samples"),
    "table of one row": table(lambda lines: lines[:2], "1 usable samples"),
    "table unsorted": table(lambda lines: [lines[0], *lines[:0:-1]], "time does not rise"),
    "table unsorted, to be resampled": table(
        lambda lines: [lines[0], *lines[:0:-1]], "time does not rise", options=["--resample"]
    ),
    "table with a gap": table(lambda lines: lines[:20] + lines[40:], "--resample"),
    "table with a gap, to be resampled": table(lambda lines: lines[:20] + lines[40:], "gap", options=["--resample"]),
    "table in millimetres": table(lambda lines: lines, "metres", scene_text='[table]\nroller_x = "roller_{j}_x [mm]"'),
    "table without mapped columns": table(lambda lines: lines, "x_hub", scene_text='[table]\ninner_x = "x_hub"'),
    "table with the wrong decimal sign": table(lambda lines: lines, scene_text='[table]\ndecimal = ","'),
    "table of zeros": table(lambda lines: bytes(1000)),
    "table of one line": table(lambda lines: b"time" * 600_000, "line"),
    "table with a wrong quote": table(row(0, lambda line: '"' + line)),
    "picture": content("cat.png", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), "--scene"),
    "prose": content("notes.csv", "dear diary\n", "--scene"),
    "scene of another run": sound("--scene", "{folder}/other.toml", say="other.toml & differs"),
    "missing scene file": sound("--scene", "nowhere.toml", say="nowhere.toml & no such file"),
    "unknown law": sound("--law", "hooke", say="--law hooke & harris"),
    "law of balls": sound("--law", "hertz", say="--law hertz & harris"),
    "negative start": sound("--start", "-1", say="--start -1"),
    "start beyond the end": sound("--start", "1e6", say="made.nc & starting at 1e+06 ms"),
    "start not a number": sound("--start", "nan", say="--start nan"),
    "negative tolerance": sound("--tolerance", "-1", say="--tolerance -1"),
    "tolerance without end": sound("--tolerance", "inf", say="--tolerance inf"),
    "odd order": sound("--order", "5", say="--order"),
    "misspelt option": sound("--odrer", "4", say="--odrer"),
    "unknown line": sound("--line", "BPXO", say="BPXO"),
    "table's option for a result": sound("--resample", say="--resample & only for tables"),
    "folder of something else": sound("--output", "{folder}/photos", say="photos & not empty"),
    "file in place of the report": sound("--output", "{folder}/other.toml", say="other.toml & is a file"),
}


def picture(*arguments, say, change=lambda file: None):
    """A result file and options of render-fem."""

    def make(folder):
        path = write_result(folder / "made.nc", RUN)
        with h5py.File(path, "a") as file:
            change(file)
        return render_main, [str(path), *(a.format(folder=folder) for a in arguments)], say.split(" & ")

    return make


def resumed(change, *words, settings=()):
    """Option --resume with a sound run whose files have been changed."""

    def make(folder, finished):
        for name in ("run.nc", "run.nc.checkpoint"):
            (folder / name).write_bytes((finished / name).read_bytes())
        change(folder / "run.nc", checkpoint_path(folder / "run.nc"))
        return (
            run_main,
            [*FINISHED, "--output", str(folder / "run.nc"), "--resume", *(settings or DURATION)],
            list(words),
        )

    return make


class Touch:
    """An object that would make a file if it were unpickled."""

    def __reduce__(self):
        return os.mkdir, ("executed",)


def cut(path, share):
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])


def set_counter(path, value):
    with h5py.File(path, "r+") as file:
        file.attrs["committed_samples"] = value


FINISHED, DURATION = ["--mesh-size", "2", "--quiet"], ["--duration", "0.2"]
BAD_PICTURES = {
    "picture of no file": lambda folder: (render_main, [str(folder / "gone.nc")], ["gone.nc", "no such"]),
    "picture without runs": lambda folder: (render_main, [], ["run-fem", "runs"]),
    "picture of a later time": picture("--time", "100", say="made.nc & no sample at 100 ms"),
    "picture of no time": picture("--time", "nan", say="made.nc & no sample"),
    "picture too wide": picture("--width", "100000", say="--width 100000 & 8000"),
    "picture without width": picture("--width", "0", say="--width 0 & 200"),
    "picture magnified backwards": picture("--magnification", "-1", say="--magnification -1"),
    "picture over the run": picture("--output", "{folder}/made.nc", say="--output & must end in .png"),
    "picture into a folder": picture("--output", "{folder}", say="--output & is a folder"),
    "picture of another scene": picture(
        say="made.nc & 9 rollers", change=lambda file: file.attrs.update(scene="[bearing]\nrollers = 9\n")
    ),
    "picture of a link": picture(say="made.nc & inner_x & link", change=outside("link")),
    "picture of a hostile mesh": picture(say="mesh_size_mm & nodes", change=lambda file: file.attrs.update(scene=FINE)),
}

BAD_CHECKPOINTS = {
    "resumed without a result": resumed(lambda run, state: run.unlink(), "run.nc", "not found"),
    "resumed without a checkpoint": resumed(
        lambda run, state: state.unlink(), "run.nc.checkpoint", "nothing to resume"
    ),
    "resumed from an empty checkpoint": resumed(
        lambda run, state: state.write_bytes(b""), "run.nc.checkpoint", "damaged"
    ),
    "resumed from half a checkpoint": resumed(lambda run, state: cut(state, 0.5), "run.nc.checkpoint", "damaged"),
    "resumed from a checkpoint with a gap": resumed(
        lambda run, state: state.write_bytes(state.read_bytes()[:200] + bytes(200) + state.read_bytes()[400:]),
        "run.nc.checkpoint",
        "damaged",
    ),
    "resumed from nonsense": resumed(
        lambda run, state: state.write_bytes(b"nonsense"), "run.nc.checkpoint", "is no checkpoint"
    ),
    "resumed from a result for a checkpoint": resumed(
        lambda run, state: state.write_bytes(run.read_bytes()), "run.nc.checkpoint", "is no checkpoint"
    ),
    "resumed from code": resumed(
        lambda run, state: np.savez(open(state, "wb"), meta=np.array([Touch()])), "run.nc.checkpoint", "damaged"
    ),
    "resumed on half a result": resumed(lambda run, state: cut(run, 0.5), "run.nc", "can't be resumed"),
    "resumed on text": resumed(lambda run, state: run.write_text("dear diary"), "run.nc", "can't be resumed"),
    "resumed on fewer samples": resumed(lambda run, state: set_counter(run, 3), "run.nc", "fewer"),
    "resumed at another speed": resumed(
        lambda run, state: None,
        "run.nc.checkpoint",
        "operation.speed_rpm was 4500.0, now 4000.0",
        settings=[*DURATION, "--set", "operation.speed_rpm=4000"],
    ),
    "resumed with a shorter duration": resumed(
        lambda run, state: None, "numerics.duration_ms = 0.1", "0.2 ms", settings=["--duration", "0.1"]
    ),
}
