"""Every kind of unusable input: exit code 2, the culprit named, no traceback, nothing written."""

import contextlib
import os
import threading
import time

import h5py
import numpy as np
import pytest

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path
from residual.cli import main as check_main
from tests.reference.kit import sets
from tests.reference.synthetic_run import make_run, write_result, write_table

RUN = make_run(n_times=64)
LONG = "x" * 900_000

# Each case is a function that writes into a folder and gives the command, its arguments and what the refusal must say.


def made(name, write, say="", *options, main=check_main, named=True):
    def make(folder):
        write(folder / name)
        arguments = [str(folder / name), *(each.format(folder=folder) for each in options)]
        return main, arguments, [*([name] if named else []), *say.split(" & ")]

    return make


def scene(text, say=""):
    data = text if isinstance(text, bytes) else text.encode()
    return made("scene.toml", lambda path: path.write_bytes(data), say, main=run_main)


def options(*arguments, say, main=run_main):
    return lambda folder: (main, [each.format(folder=folder) for each in arguments], say.split(" & "))


def setting(*settings, say):
    return options(*sets(*settings), say=say)


BAD_SCENES = {
    # names and types
    "a key of many thousand parts": scene("a." * 30_000 + "a = 1", "'a.a.a. & a key of more than 50 parts"),
    "a power law without stiffness": scene(
        '[lagrange]\nlaw = "power"\ncontact_exponent = 1.1\ncontact_stiffness_N_per_m_n = [5e-324, 1e9]',
        "lagrange.contact_stiffness_N_per_m_n.0 = 5e-324 & 1000"),
    "numbers next to 0": scene(
        "[operation]\nunbalance_g_mm = 5e-324\n[[waviness]]\namplitude_um = 1e-300",
        "operation: unbalance_g_mm = 4.94066e-324: must be 0, or at least 1e-15 & waviness.0: amplitude_um = 1e-300"),
    "unknown key": scene("[operation]\nspeed_rmp = 4500", "operation.speed_rmp & did you mean speed_rpm?"),
    "unknown table": scene("[bearings]\nrollers = 3", "bearings & did you mean bearing?"),
    "misspelt key of a spall": scene("[[spall]]\nwidht_mm = 2", "spall.0.widht_mm & did you mean width_mm?"),
    "a table where many may be": scene("[spall]\nwidth_mm = 2", "spall = { & array of tables, [[spall]]"),
    "a spall that is no table": scene("spall = [3]", "spall.0 = 3 & [[spall]]"),
    "override of a spall that is not there": setting("spall.3.width_mm=2", say="spall.3.width_mm=2 & none of 0 tables"),
    "spalls that overlap": scene("[[spall]]\n[[spall]]\nangle_deg = 1.0", "spall.0 and spall.1 overlap"),
    "spall of no roller": scene('[[spall]]\nbody = "roller"\nroller = 13', "spall.0.roller = 13 & from 0 to 12"),
    "a spall with resolved contacts": scene('[[spall]]\n[contact]\nmodel = "resolved"', '[[spall]] & "resolved"'),
    "a spall on a mesh as fine as contacts": setting(
        "spall.0.width_mm=1", "numerics.mesh_size_mm=0.05", say="[[spall]] & points & at least"),
    "key like none": scene("[contact]\nzzz = 1", "contact.zzz & known here:  & friction_coefficient"),
    "misspelt option of the model": scene("[lagrange]\nlow = 3.0", "lagrange.low & law"),
    "misspelt table": scene("[operatoin]\nspeed_rpm = 1.0", "operatoin & did you mean operation?"),
    "misspelt key of a support": scene("[support]\nfit_clearence_um = 1", "did you mean fit_clearance_um?"),
    "half a key's words": scene("[damping]\ncontact = 3.0", "damping.contact & did you mean contact_N_s_m?"),
    "one word of a key": scene('[fit]\nshaft = "k5"', "fit.shaft: unknown key; did you mean shaft_interference_um?"),
    "key that stands elsewhere": scene("[bearing]\ncrown_um = 1", "did you mean axial.crown_um?"),
    "axial load without flanges": scene("operation.axial_load_N = 1", "axial_load_N = 1: the bearing has no flanges"),
    "axial load in motion": setting(
        "bearing.designation=NUP206", "operation.axial_load_N=500",
        say="operation.axial_load_N = 500: at rest and in ratings only (rate-bearing); motion keeps its plane"),
    "motion of a mirrored pair": setting(
        "model=lagrange", "bearing={{type='ball', rows=2, pitch_diameter_mm=46, contact_angle_deg=25, "
        "row_distance_mm=20, arrangement='face_to_face'}}",
        say='bearing.arrangement = "face_to_face": at rest and in ratings only'),
    "slope of a ball bearing in motion": setting(
        "bearing.designation='6205'", "operation.misalignment_mrad=1", say="misalignment_mrad = 1: at rest and in"),
    "hollow rollers": scene("[bearing]\nroller_bore_diameter_mm = 5", "not supported: hollow rollers; see docs/"),
    "temperature": scene("[operation]\ntemperature = 1", "not supported: temperature"),
    "settings of another program": scene("\n".join(f"key_{i} = {i}" for i in range(500)), "key_0 & and 485 more"),
    "numbers in quotes": scene(
        '[operation]\nradial_load_N = "2000 N"\n[bearing]\nrollers = "13"',
        "bearing.rollers = '13': must be a valid integer, without quotes and unit & "
        "operation.radial_load_N = '2000 N': must be a valid number, without quotes and unit"),
    "truth for a number": scene("[bearing]\nrollers = true", "bearing.rollers = True"),
    "date for a number": scene("[operation]\nspeed_rpm = 2007-06-18", "operation.speed_rpm"),
    "list for a number": scene("[operation]\nspeed_rpm = [1, 2]", "operation.speed_rpm = [1, 2]"),
    "table for a number": scene("[numerics.duration_ms]\nx = 1", "numerics.duration_ms & number"),
    "number for a table": scene("bearing = 3", "bearing = 3: must be a table, [bearing]"),
    "list of tables": scene("[[bearing]]\nrollers = 3", "bearing = [{ & must be a table, [bearing]"),
    "number for a name": scene("name = 3", "name = 3 & string"),
    "number for a list": scene("[bearing]\nmissing_rollers = 3", "bearing.missing_rollers = 3: must be a valid list"),
    "list for a profile": scene("[axial]\nroller_profile = [1]", "axial.roller_profile = [1]: must be a valid string"),
    "number for a column": scene("[table]\ntime = 3", "table.time = 3"),
    # numbers that are none, or too large
    "not a number": scene("[operation]\nspeed_rpm = nan", "operation.speed_rpm = nan & finite"),
    "infinite by overflow": scene("[operation]\nradial_load_N = 1e400", "operation.radial_load_N = inf & finite"),
    "more digits than Python reads": scene(f"[bearing]\nrollers = {'9' * 5000}", "digits"),
    "as many digits as it reads": scene(f"[operation]\nspeed_rpm = {'9' * 4000}", "operation.speed_rpm = 999 & ..."),
    "spring alone": scene("[contact]\npenalty_stiffness_N_per_m = 1e9", "penalty_stiffness_N_per_m = 1e+09 & faceted"),
    "unit of no length": scene('[table]\ninner_x = "x [fortnight]"', "table.inner_x & fortnight"),
    "unit with hidden characters": scene('[table]\ntime = "t [ms\ufeff\\u0001]"', "table.time & ms??"),
    "column without a number": scene('[table]\nroller_x = "x"', "table.roller_x & {j}"),
    "column with one too many": scene('[table]\ninner_x = "x{j}"', "table.inner_x & {j}"),
    "name of a column without end": scene(f'[table]\ntime = "t{" " * 5000}"', "table.time & 200"),
    # values that contradict each other
    "too many rollers": scene("[bearing]\nrollers = 15", "rollers = 15 & at most 14"),
    "bore as large as raceway": scene("[bearing]\nbore_diameter_mm = 36.0", "bore_diameter_mm = 36.0 & inner_raceway"),
    "outside below raceway": scene("[bearing]\noutside_diameter_mm = 55", "outside_diameter_mm & outer_raceway"),
    "too much preload": scene("[bearing]\nouter_raceway_diameter_mm = 55", "preload & outer_raceway_diameter_mm"),
    "too much clearance": scene("[bearing]\nouter_raceway_diameter_mm = 59", "clearance & outer_raceway_diameter_mm"),
    "raceways exchanged": scene(
        "[bearing]\ninner_raceway_diameter_mm = 56\nouter_raceway_diameter_mm = 36\noutside_diameter_mm = 70",
        "outer_raceway_diameter_mm = 36"),
    "mass below the ring's": scene("operation.inner_ring_and_shaft_kg = 0.03", "inner_ring_and_shaft_kg & 0.04137"),
    "heavy inner ring": scene("[material.inner_ring]\ndensity_kg_m3 = 30000", "inner_ring_and_shaft_kg = 0.078"),
    "mesh too coarse": scene("[numerics]\nmesh_size_mm = 4", "mesh_size_mm = 4 & at most"),
    "mesh too fine": scene("[numerics]\nmesh_size_mm = 0.014", "mesh_size_mm = 0.014 & at least"),
    "interval longer than the run": scene(
        "[numerics]\nduration_ms = 1\noutput_interval_us = 2000",
        "output_interval_us = 2000 & duration_ms = 1 & at most"),
    "grooves of a roller bearing": scene("bearing.inner_conformity = 0.52", 'inner_conformity & type = "ball"'),
    "grooves too tight": scene('[bearing]\ntype = "ball"\nouter_conformity = 0.5', "outer_conformity = 0.5"),
    "law of balls for rollers": scene('[lagrange]\nlaw = "hertz"', "lagrange.law = 'hertz' & 'roller' & harris"),
    "law of rollers for balls": scene('[bearing]\ntype = "ball"\n[lagrange]\nlaw = "harris"', "lagrange.law & hertz"),
    # files that are no scenes
    "broken TOML": scene("[bearing\nrollers = 3", "TOML & line 1"),
    "unfinished TOML": scene("name = ", "TOML"),
    "decimal comma": scene("operation.radial_load_N = 3,5", "TOML & radial_load_N = 3,5: write a decimal point"),
    "text without quotes": scene("bearing.designation = NU206", "TOML & designation = NU206: put text in quotes"),
    "key twice": scene("[bearing]\nrollers = 12\nrollers = 13", "TOML"),
    "JSON": scene('{"bearing": {"rollers": 13}}', "TOML"),
    "not text": scene(b"\xff\xfe\x00\x01", "UTF-8"),
    "text of another encoding": scene("name = 'Wälzlager'".encode("utf-16"), "UTF-8"),
    "zeros": scene(bytes(100), "TOML"),
    "arrays without end": scene(f"name = {'[' * 100_000}", "nested"),
    "tables without end": scene(f"{'a.' * 5000}b = 1", "a"),
    "a million spaces": scene(" " * 2**21, "larger than 1 MiB"),
    "name that leads elsewhere": scene("name = '../evil'", "name = '../evil' & pattern"),
    "name without letters": scene("name = ''", "name = ''"),
    "name with a line break": scene('name = "a\\nb"', "name = 'a\\nb'"),
    "keys that move the cursor": scene('"\\u001b[2J" = 1', "\\x1b[2J & unknown key"),
    "value that moves the cursor": scene('bearing.rollers = "\\u001b[31m"', "bearing.rollers = "),
    "value of a million letters": scene(f"[bearing]\nrollers = '{LONG}'", "bearing.rollers = 'xxx & ..."),
    "name of a million letters": scene(f'name = "{LONG}"', "name = 'xxx & ..."),
    "key of a million letters": scene(f"[bearing]\n{LONG} = 1", "bearing.xxx & unknown key"),
    "table of a million letters": scene(f'[{LONG}]\n"\\u001b[31m" = 1', "xxx"),
    "number of a million digits": scene(f"[numerics]\nduration_ms = {'9' * 900_000}", "digits"),
}  # fmt: skip

BAD_SETTINGS = {
    "no key": setting("speed", say="--set 'speed' & table.key=value"),
    "empty key": setting("=3", say="--set '=3'"),
    "half a key": setting("operation.=3", say="--set 'operation.=3'"),
    "table behind a value": setting("name=x", "name.first=1", say="--set 'name.first=1' & name is a value"),
    "unknown key by option": setting("operation.speed=1", say="operation.speed & did you mean speed_rpm?"),
    "word for a number by option": setting("operation.speed_rpm=fast", say="operation.speed_rpm = 'fast'"),
    "second key in a value": setting("operation.speed_rpm=1\nname='x'", say="operation.speed_rpm"),
    "damping that drives": setting("damping.contact_N_s_m=-1", say="damping.contact_N_s_m & 0"),
    "angles that no model has": setting("lagrange.angles=caged", say="lagrange.angles & kinematic"),
    "comment for a value": setting("operation.speed_rpm=# 3", say="operation.speed_rpm"),
    "mesh size of nan": options("--mesh-size", "nan", say="numerics.mesh_size_mm = nan"),
    "mesh size in words": options("--mesh-size", "fine", say="--mesh-size"),
    "duration of nan": options("--duration", "nan", say="numerics.duration_ms = nan"),
    "duration in words": options("--duration", "long", say="--duration"),
    "negative seconds between checkpoints": options("--checkpoint", "-1", say="--checkpoint -1"),
    "checkpoint of nan": options("--checkpoint", "nan", say="--checkpoint nan"),
    "unknown model by option": options("--model", "spring", say="--model"),
    "misspelt option": options("--mesh-sise", "2", say="--mesh-sise"),
    "two scenes": options("a.toml", "b.toml", say="b.toml"),
    "no such scene": options("gone.toml", say="gone.toml & no such file; run-fem --example"),
    "folder for a scene": options("{folder}", say="can't be read"),
    "folder for a result": options("--output", "{folder}", say="--output & is a folder"),
    "folder that can't be made": options("--output", "/proc/nothing/x.nc", "--mesh-size", "2", say="/proc/nothing"),
    "none to resume": options("--resume", "--mesh-size", "2", "--output", "none.nc", say="none.nc & nothing to resume"),
    "nothing to resume of the Lagrangian model": options(
        "--model", "lagrange", "--resume", "--output", "none.nc", say="none.nc & nothing to resume"),
    "error estimate without a mesh": options("--model", "lagrange", "--estimate-error", say="--estimate-error"),
    # sensible values of a bearing that can't be simulated
    "centrifugal strain": setting(
        "operation.speed_rpm=150000", "material.youngs_modulus_GPa=50", say="operation.speed_rpm & at most"),
    "contacts beyond Hertz": setting("operation.radial_load_N=1e6", say="Hertz & radial_load_N"),
    "mesh coarser than a resolved contact": setting(
        "contact.model=resolved", "numerics.mesh_size_mm=0.2", say="contact.model & mesh_size_mm at most"),
    "needle through the inner ring": setting(
        "bearing.bore_diameter_mm=0.5", "operation.inner_ring_and_shaft_kg=0.1", say="inner ring & edges"),
    "too thin a ring": setting("bearing.outside_diameter_mm=57", say="outer ring & 0.5 mm thick & mesh_size_mm"),
    "more nodes than memory": setting(
        "operation.radial_load_N=1", "numerics.mesh_size_mm=0.03", say="mesh_size_mm = 0.03 & nodes & at most"),
    "balls as plane sections": setting("model=fem", "bearing.type=ball", say='type = "ball" & --model lagrange'),
    "plan of balls as plane sections": options(
        "--dry-run", *sets("model=fem", "bearing.type=ball"), say='type = "ball" & --model lagrange'),
}  # fmt: skip


def content(name, data, say, main=check_main):
    return made(name, lambda path: path.write_bytes(data if isinstance(data, bytes) else data.encode()), say, main=main)


def spoilt(change, say="", main=check_main):
    return made("bad.nc", lambda path: write_result(path, RUN).write_bytes(change(path.read_bytes())), say, main=main)


def result(change, say="", main=check_main):
    def write(path):
        with h5py.File(write_result(path, RUN), "a") as file:
            change(file)

    return made("bad.nc", write, say, main=main)


def replaced(name, value, say, main=check_main):
    def change(file):
        old = file.pop(name)[:]
        if value is not None:
            file[name] = value(old)

    return result(change, say, main)


def attribute(name, value, say, main=check_main):
    return result(lambda file: file.attrs.pop(name) if value is None else file.attrs.update({name: value}), say, main)


def poked(name, place, value, say, main=check_main):
    return result(lambda file: file[name].__setitem__(place, value), say, main)


def table(edit, say="", scene_text="", *more, with_scene=True):
    def write(path):
        lines = edit(write_table(RUN, path).read_text().splitlines())
        path.write_bytes(lines if isinstance(lines, bytes) else ("\n".join(lines) + "\n").encode())
        (path.parent / "scene.toml").write_text(scene_text)

    return made("bad.csv", write, say, *(("--scene", "{folder}/scene.toml") if with_scene else ()), *more)


def row(number, change):
    return lambda lines: [*lines[:number], change(lines[number]), *lines[number + 1 :]]


def cell(number, text):
    return row(number, lambda line: text + line[line.index(",") :])


def sound(*arguments, say, main=check_main):
    def make(folder):
        write_result(folder / "made.nc", RUN)
        (folder / "other.toml").write_text("[operation]\nspeed_rpm = 3000.0\n")
        (folder / "photos").mkdir()
        (folder / "photos" / "cat.jpg").write_text("meow")
        return options("{folder}/made.nc", *arguments, say=say, main=main)(folder)

    return make


def large(count, compression=None):
    def change(file):
        for name in ("time", "inner_x", "inner_y", "roller_x", "roller_y"):
            del file[name]
            shape = (count, 13)[: 2 if name.startswith("roller") else 1]
            chunks = True if compression is None else (1024, 13)[: len(shape)]
            file.create_dataset(name, shape, "f8", chunks=chunks, compression=compression)
        file.attrs["committed_samples"] = count

    return change


def instead(make):
    def change(file):
        del file["inner_x"]
        make(file)

    return change


def pieces(file):
    layout = h5py.VirtualLayout(shape=(64,), dtype="f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "inner_x", shape=(64,))
    file.create_virtual_dataset("inner_x", layout)


LINK = instead(lambda file: file.__setitem__("inner_x", h5py.ExternalLink("/etc/hostname", "/inner_x")))
BAD_FILES = {
    "no such file": options("{folder}/gone.nc", say="gone.nc & no such file", main=check_main),
    "a folder": options("{folder}", say="not a file", main=check_main),
    "the folder one is in": options(".", say=".: not a file", main=check_main),
    "no name": options("", say=".: not a file", main=check_main),
    "no runs at all": options(say="run-fem & runs", main=check_main),
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
    "scene not TOML": attribute("scene", "name = [", "scene & TOML"),
    "scene impossible": attribute("scene", "[operation]\nspeed_rpm = nan\n", "scene & speed_rpm"),
    "scene of numbers": attribute("scene", np.arange(5), "scene"),
    "scene of other bytes": attribute("scene", np.void(b"\xff\xfe\x00"), "scene"),
    "scene that has been changed": attribute("scene_checksum", 1, "scene & checksum"),
    "negative counter": attribute("committed_samples", -3, "committed_samples = -3"),
    "counter as text": attribute("committed_samples", "many", "committed_samples = 'many'"),
    "counter as a list": attribute("committed_samples", [1, 2], "committed_samples"),
    "counter beyond the data": attribute("committed_samples", 100_000, "100000 & truncated"),
    "counter beyond a word": attribute("committed_samples", np.uint64(2**63 + 5), "9223372036854775813"),
    "too few samples": attribute("committed_samples", 10, "10 & 32"),
    "nothing committed": attribute("committed_samples", 0, "0 committed samples"),
    "no inner_y": replaced("inner_y", None, "inner_y"),
    "no time": replaced("time", None, "time"),
    "no loads in a file of run-fem": result(
        lambda file: (file.attrs.update(program="run-fem"), file.move("outer_traction", "outer_tractioo")),
        "missing outer_traction"),
    "no variable at all": result(lambda file: [file.pop(name) for name in list(file)], "missing"),
    "NaN": poked("inner_x", 7, np.nan, "inner_x is nan at sample 7"),
    "infinite force": poked("inner_force", (7, 3), np.inf, "inner_force is inf at sample 7, roller 3"),
    "NaN in the energies": poked("energy_kinetic", 7, np.nan, "energy_kinetic"),
    "force of a star": poked("inner_force", (7, 3), 1e300, "inner_force & 1e+15"),
    "time falls": poked("time", 7, 0.0, "time does not rise after sample 6"),
    "time stands": poked("time", 7, 6e-5, "time does not rise"),
    "time backwards": replaced("time", lambda t: t[::-1].copy(), "time does not rise"),
    "time irregular": replaced("time", lambda t: t + np.where(t > 1e-4, 3e-6, 0.0), "sampling interval"),
    "time in no steps": replaced("time", lambda t: 1e-300 * np.arange(t.size), "sampling interval & seconds"),
    "rollers missing": replaced("roller_x", lambda v: v[:, :-1], "roller_x holds 12 rollers & 13"),
    "roller loads of another bearing": replaced("inner_force", lambda v: v[:, :-1], "inner_force holds 12 rollers"),
    "flat roller array": replaced("roller_y", lambda v: v[:, 0], "roller_y & shape"),
    "array of three dimensions": replaced("roller_y", lambda v: v[:, :, None], "roller_y & shape"),
    "text instead of numbers": replaced("inner_x", lambda v: v.astype("S8"), "inner_x & floating-point"),
    "whole numbers": replaced("inner_x", lambda v: np.zeros(v.size, dtype=int), "inner_x & floating-point"),
    "complex numbers": replaced("inner_x", lambda v: v + 1j, "inner_x & floating-point"),
    "group instead of an array": result(instead(lambda file: file.create_group("inner_x")), "inner_x"),
    "type for an array": result(instead(lambda file: file.__setitem__("inner_x", np.dtype("f8"))), "inner_x"),
    "millimetres": replaced("roller_x", lambda v: 1e3 * v, "metres"),
    "hub in millimetres": replaced("inner_y", lambda v: 1e4 * v, "inner_x, inner_y & metres"),
    "another checksum": result(lambda file: file["inner_x"].attrs.update(checksum=[64, 1, -1, 0]), "inner_x & checks"),
    "checksum of other samples": result(lambda file: file["inner_x"].attrs.update(checksum=[5, 1, 6, 2]), "inner_x"),
    "checksum in words": result(lambda file: file["inner_x"].attrs.update(checksum="sum"), "checksum"),
    "too big to hold": result(large(10**12)),
    "more zeros than memory": result(large(2 * 10**9, "gzip"), "time & only part"),
    "chunks larger than memory": result(instead(lambda file: file.create_dataset(
        "inner_x", (64,), "f8", maxshape=(None,), chunks=(2**28,), compression="gzip")), "inner_x & chunks"),
    "link into another file": result(LINK, "inner_x & link"),
    "link to itself": result(instead(lambda file: file.__setitem__("inner_x", h5py.SoftLink("/inner_x"))),
                             "inner_x & link"),
    "numbers of another file": result(instead(lambda file: file.create_dataset(
        "inner_x", (64,), "f8", external=[("/etc/passwd", 0, 512)])), "inner_x & another file"),
    "pieces of other files": result(instead(pieces), "inner_x & another file"),
    "table without scene": table(list, "--scene", with_scene=False),
    "table without time": table(lambda lines: [line.partition(",")[2] for line in lines], "time"),
    "table without a header": table(lambda lines: lines[1:], "neither"),
    "table with a word": table(cell(5, "zero"), "zero"),
    "table with an empty cell": table(cell(5, ""), "line 6"),
    "table with a short row": table(row(5, lambda line: line.rpartition(",")[0]), "line 6"),
    "table with two points in a number": table(cell(5, "1.2.3"), "1.2.3"),
    "table with commas for points": table(lambda lines: [lines[0]] + [line.replace(".", ",") for line in lines[1:]]),
    "table with a formula": table(cell(5, "=1+1"), "=1+1"),
    "table with a roller less": table(lambda lines: [line.rsplit(",", 2)[0] for line in lines], "12 rollers & 13"),
    "table with a roller more": table(
        lambda lines: [f"{lines[0]},roller_13_x,roller_13_y", *(f"{line},0,0" for line in lines[1:])], "14"),
    "table with one twice": table(lambda lines: [f"{line},{line.split(',')[0]}" for line in lines], "time & twice"),
    "table with NaN": table(cell(5, "nan"), "time is nan"),
    "table with a number beyond all": table(cell(5, "1e999"), "time is inf"),
    "table of a header only": table(lambda lines: lines[:1], "0 usable samples"),
    "table of one row": table(lambda lines: lines[:2], "1 usable samples"),
    "table unsorted": table(lambda lines: [lines[0], *lines[:0:-1]], "time does not rise"),
    "unsorted to resample": table(lambda lines: [lines[0], *lines[:0:-1]], "time does not rise", "", "--resample"),
    "table with a gap": table(lambda lines: lines[:20] + lines[40:], "--resample"),
    "table with a gap, to be resampled": table(lambda lines: lines[:20] + lines[40:], "gap", "", "--resample"),
    "table in millimetres": table(list, "metres", '[table]\nroller_x = "roller_{j}_x [mm]"'),
    "table without mapped columns": table(list, "x_hub", '[table]\ninner_x = "x_hub"'),
    "table with the wrong decimal sign": table(list, "", '[table]\ndecimal = ","'),
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
}  # fmt: skip

FINE = "[operation]\nradial_load_N = 1\n[numerics]\nmesh_size_mm = 0.026\n"  # uniform: contacts are far narrower


def picture(*arguments, say):
    return sound(*arguments, say=say, main=render_main)


BAD_PICTURES = {
    "picture of no file": options("{folder}/gone.nc", say="gone.nc & no such", main=render_main),
    "picture of a folder": options("{folder}", say="no such result file", main=render_main),
    "picture without runs": options(say="run-fem & runs", main=render_main),
    "picture of text": content("bad.nc", "time,inner_x\n0,0\n", "can't be read as a result file", render_main),
    "picture of half": spoilt(lambda data: data[: len(data) // 4], "can't be read as a result file", render_main),
    "picture of another program's file": attribute("scene", None, "not a result file", render_main),
    "picture of no sample": attribute("committed_samples", 0, "holds no sample yet", render_main),
    "picture beyond the data": attribute("committed_samples", 10**6, "1000000 samples are committed", render_main),
    "picture without forces": replaced("outer_force", None, "outer_force", render_main),
    "picture of NaN": poked("inner_force", ..., np.nan, "is nan at 0 ms", render_main),
    "picture of a scene that is none": attribute(
        "scene", "[bearing]\nrollres = 9\n", "bad.nc: its scene: bearing.rollres: unkn", render_main),
    "picture of another scene": attribute("scene", "[bearing]\nrollers = 9\n", "9 rollers", render_main),
    "picture of a hostile mesh": made("bad.nc", lambda path: write_result(path, RUN, scene=FINE),
                                      "mesh_size_mm & nodes", main=render_main, named=False),
    "picture of a link": result(LINK, "inner_x & link", render_main),
    "picture of a later time": picture("--time", "100", say="no sample at 100 ms"),
    "picture of an earlier time": picture("--time", "-1", say="it holds 0 to 0.63 ms"),
    "picture of no time": picture("--time", "nan", say="no sample"),
    "picture too wide": picture("--width", "100000", say="--width 100000 & 8000"),
    "picture without width": picture("--width", "0", say="--width 0 & 200"),
    "picture magnified backwards": picture("--magnification", "-1", say="--magnification -1"),
    "picture over the run": picture("--output", "{folder}/made.nc", say="--output & must end in .png"),
    "picture into a folder": picture("--output", "{folder}", say="--output & is a folder"),
}  # fmt: skip

FINISHED, DURATION = ["--mesh-size", "2", "--quiet"], ["--duration", "0.2"]


def resumed(change, say, *settings):
    def make(folder, finished):
        for name in ("run.nc", "run.nc.checkpoint"):
            (folder / name).write_bytes((finished / name).read_bytes())
        change(folder / "run.nc", checkpoint_path(folder / "run.nc"))
        arguments = [*FINISHED, "--output", str(folder / "run.nc"), "--resume", *(settings or DURATION)]
        return run_main, arguments, say.split(" & ")

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


STATE = "run.nc.checkpoint"
BAD_CHECKPOINTS = {
    "resumed without a result": resumed(lambda run, state: run.unlink(), "run.nc & not found"),
    "resumed without a checkpoint": resumed(lambda run, state: state.unlink(), f"{STATE} & nothing to resume"),
    "resumed from an empty checkpoint": resumed(lambda run, state: state.write_bytes(b""), f"{STATE} & damaged"),
    "resumed from half a checkpoint": resumed(lambda run, state: cut(state, 0.5), f"{STATE} & damaged"),
    "resumed from a checkpoint with a gap": resumed(
        lambda run, state: state.write_bytes(state.read_bytes()[:200] + bytes(200) + state.read_bytes()[400:]),
        f"{STATE} & damaged"),
    "resumed from words": resumed(lambda run, state: state.write_bytes(b"nonsense"), f"{STATE} & is no checkpoint"),
    "resumed from a result for a checkpoint": resumed(
        lambda run, state: state.write_bytes(run.read_bytes()), f"{STATE} & is no checkpoint"),
    "resumed from code": resumed(
        lambda run, state: np.savez(open(state, "wb"), meta=np.array([Touch()])), f"{STATE} & damaged"),
    "resumed on half a result": resumed(lambda run, state: cut(run, 0.5), "run.nc & can't be resumed"),
    "resumed on text": resumed(lambda run, state: run.write_text("dear diary"), "run.nc & can't be resumed"),
    "resumed on fewer samples": resumed(lambda run, state: set_counter(run, 3), "run.nc & fewer"),
    "resumed at another speed": resumed(
        lambda run, state: None, f"{STATE} & operation.speed_rpm was 4500.0, now 4000.0",
        *DURATION, "--set", "operation.speed_rpm=4000"),
    "resumed with a shorter duration": resumed(
        lambda run, state: None, "numerics.duration_ms = 0.1 & 0.2 ms", "--duration", "0.1"),
}  # fmt: skip

KINDS = {"scene": BAD_SCENES, "settings": BAD_SETTINGS, "file": BAD_FILES, "picture": BAD_PICTURES,
         "checkpoint": BAD_CHECKPOINTS}  # fmt: skip


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished")
    assert run_main([*FINISHED, *DURATION, "--output", str(folder / "run.nc")]) == 0
    return folder


def contents(folder):
    return {path: path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))}


@pytest.mark.parametrize(("kind", "name"), [(kind, name) for kind, cases in KINDS.items() for name in cases])
def test_unusable_input_exits_2_names_the_culprit_and_leaves_nothing(kind, name, here, capfd, request):
    given = (here, request.getfixturevalue("finished")) if kind == "checkpoint" else (here,)
    command, arguments, words = KINDS[kind][name](*given)
    before = contents(here)
    try:
        code = command(arguments)
    except SystemExit as stop:  # the option parser's own way out
        code = stop.code
    out, error = capfd.readouterr()
    assert code == 2
    assert all(word in error for word in words), error
    assert "Traceback" not in error and "Warning" not in error and out == ""
    assert len(error) < 5000 and all(c.isprintable() or c == "\n" for c in error)
    assert contents(here) == before


AT_ONCE = {
    "values": (
        "[bearing]\nrollers = 'x'\n[operation]\nspeed_rmp = 1\n[contact]\nfriction_coefficient = 9\n",
        ("bearing.rollers", "operation.speed_rmp", "contact.friction_coefficient")),
    "values of one table that contradict each other": (
        "[bearing]\nrollers = 20\nbore_diameter_mm = 40\noutside_diameter_mm = 50\n[numerics]\nduration_ms = -1\n",
        ("rollers = 20", "bore_diameter_mm = 40", "outside_diameter_mm = 50", "numerics.duration_ms")),
    "values of several tables": (
        "[operation]\ninner_ring_and_shaft_kg = 0.01\n[numerics]\nmesh_size_mm = 9\n[lagrange]\nlaw = 'hooke'\n",
        ("inner_ring_and_shaft_kg = 0.01", "mesh_size_mm = 9", "lagrange.law = 'hooke'")),
    "contradictions beside values and keys that can't be used": (
        "[bearing]\nbore_diameter_mm = 40\nrolers = 12\nroller_diameter_mm = 11\nroller_length_mm = -1\n"
        "[operation]\ninner_ring_and_shaft_kg = 0.01\n[numerics]\noutput_interval_us = nan\nmesh_size_mm = 9\n",
        ("bore_diameter_mm = 40", "rolers", "more preload", "roller_length_mm = -1", "interval_us", "mesh_size_mm")),
    "contradictions beside a table that is none": (
        "bearing = 3\n[numerics]\nduration_ms = 0.001\nmesh_size = 1\n", ("bearing = 3", "duration_ms", "mesh_size")),
}  # fmt: skip


@pytest.mark.parametrize(("text", "named"), AT_ONCE.values(), ids=AT_ONCE.keys())
def test_all_faults_of_a_scene_come_at_once(text, named, tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    assert run_main([str(path)]) == 2
    error = capsys.readouterr().err
    assert error.count("scene.toml: ") == len(named) and all(word in error for word in named)


def test_a_file_that_a_link_leads_to_is_not_even_opened(tmp_path):
    """A pipe can be opened for writing as soon as someone has opened it for reading."""
    pipe, opened = tmp_path / "pipe", []
    os.mkfifo(pipe)
    path = write_result(tmp_path / "bad.nc", RUN)
    with h5py.File(path, "a") as file:
        del file["inner_x"]
        file["inner_x"] = h5py.ExternalLink(str(pipe), "/inner_x")
    over = threading.Event()

    def watch():
        while not over.is_set():
            with contextlib.suppress(OSError):
                os.close(os.open(pipe, os.O_WRONLY | os.O_NONBLOCK))
                opened.append(True)
            time.sleep(0.001)

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        assert check_main([str(path)]) == render_main([str(path)]) == 2
    finally:
        over.set()
        watcher.join()
    assert not opened
