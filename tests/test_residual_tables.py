"""Tables from elsewhere: names, units, polar positions, what is missing, uneven sampling."""

import re
from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from fem.commands.run_fem import run_main
from lagrange.errors import InputError
from lagrange.scene.scene import parse_scene_text, read_scene
from residual.cli import main
from residual.evaluation import evaluate
from residual.sources import even_clock, read_table
from tests.reference.synthetic_run import exact_errors, make_run, report_of, write_table

NAMES = {"time": "t [ms]", "inner_x": "X hub [um]", "inner_y": "Y hub [um]", "roller_rho": "rho {j} [mm]",
         "roller_theta": "theta {j} [deg]", "inner_force": "Q{j} [kN]"}  # fmt: skip
MAPPING = "\n".join(["[table]", *(f'{key} = "{name}"' for key, name in NAMES.items()), "first_roller = 1\n"])


@pytest.fixture(scope="module")
def run():
    return make_run(n_times=801)


def foreign_columns(run):
    """Polar, in milliseconds, micrometres, degrees, rollers counted from 1; header -> values."""
    rho = 1e3 * np.hypot(run.roller_x, run.roller_y)
    theta = np.degrees(np.arctan2(run.roller_y, run.roller_x))  # wrapped to ±180°
    table = {"note": 0.0 * run.time, "t [ms]": 1e3 * run.time}
    table |= {"X hub [um]": 1e6 * run.inner_x, "Y hub [um]": 1e6 * run.inner_y}
    for j in range(rho.shape[1]):
        table[f"theta {j + 1} [deg]"], table[f"rho {j + 1} [mm]"] = theta[:, j], rho[:, j]
        table[f"Q{j + 1} [kN]"] = 0.95e-3 * run.law_force[:, j]
    return table


def write_foreign(path, table, delimiter="\t", decimal="."):
    rows = np.column_stack(list(table.values()))
    lines = [delimiter.join(table)] + [delimiter.join(f"{v:.17g}" for v in row).replace(".", decimal) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def scene_with(run, mapping=MAPPING):
    """The run's scene and a mapping, as `Scene`."""
    return parse_scene_text(run.scene.to_toml() + mapping, "scene.toml")


@pytest.mark.parametrize(("delimiter", "decimal"), [("\t", "."), (";", ","), (",", ".")])
def test_polar_table_in_other_units_gives_the_same_error(run, tmp_path, delimiter, decimal):
    path = write_foreign(tmp_path / "a.tsv", foreign_columns(run), delimiter, decimal)
    trajectory = read_table(path, scene_with(run, MAPPING + f'decimal = "{decimal}"\n'))
    np.testing.assert_allclose(trajectory.roller_x, run.roller_x, atol=1e-15)
    np.testing.assert_allclose(trajectory.inner_force, 0.95 * run.law_force, rtol=1e-12)
    budget = evaluate(trajectory).budget
    for found, exact in zip((budget.x, budget.y), exact_errors(run), strict=True):
        np.testing.assert_allclose(found.error, exact, atol=2e-4)


def test_units_apply_to_headers_that_do_not_carry_them_and_own_names_need_no_mapping(run, tmp_path):
    table = {name.partition(" [")[0]: value for name, value in foreign_columns(run).items()}
    trajectory = read_table(write_foreign(tmp_path / "a.tsv", table), scene_with(run))
    np.testing.assert_allclose(trajectory.time, run.time, atol=1e-15)
    np.testing.assert_allclose(trajectory.inner_y, run.inner_y, atol=1e-18)
    table = {"time": run.time, "inner_x": run.inner_x, "inner_y": run.inner_y}
    for j in range(run.roller_x.shape[1]):
        table[f"roller_{j}_rho"] = np.hypot(run.roller_x[:, j], run.roller_y[:, j])
        table[f"roller_{j}_theta"] = np.arctan2(run.roller_y[:, j], run.roller_x[:, j])
    trajectory = read_table(write_foreign(tmp_path / "a.csv", table, ","), run.scene)
    np.testing.assert_allclose(trajectory.roller_y, run.roller_y, atol=1e-16)
    assert any("no contact forces" in note for note in trajectory.notes)


def test_command_reads_a_foreign_table_and_says_what_it_lacks_and_the_example(run, tmp_path, monkeypatch):
    path = write_foreign(tmp_path / "a.tsv", foreign_columns(run))
    scene = tmp_path / "scene.toml"
    scene.write_text(run.scene.to_toml() + MAPPING, encoding="utf-8")
    summary, page = report_of(path, tmp_path / "out", "--scene", scene, "--law", "fitted", "--no-figures")
    assert set(summary["budget_x"]) == {"contact_law", "load_and_weight", "other_forces", "momentum"}
    assert summary["identification"]["exponent"]["value"] == pytest.approx(10 / 9, rel=1e-6)
    assert "no accelerations" in " ".join(summary["notes"]) and "no friction term" in page
    # the example table vibrates on the contacts of the law
    monkeypatch.chdir(tmp_path)
    assert run_main(["--example", "table"]) == 0
    options = ("--scene", "table.toml", "--line", "200", "--no-figures")
    summary, _ = report_of("table.tsv", tmp_path / "out", *options)
    assert summary["error_y"]["mean_N"] == pytest.approx(-0.19, abs=0.01)
    assert summary["watched"][0]["y"]["rms_N"] == pytest.approx(540e6 * 1e-7 / np.sqrt(2), rel=0.02)


def test_uneven_sampling_is_resampled_where_asked_for_and_an_even_clock_is_taken_for_its_rounded_stamps(run, tmp_path):
    """Of sampling times that wander by up to 30 % of the interval."""
    time = run.time + 0.3 * run.time[1] * np.random.default_rng(3).uniform(-1, 1, run.time.size)
    path = write_table(make_run(time=time), tmp_path / "uneven.csv")
    trajectory = read_table(path, run.scene, resample=True)
    assert np.ptp(np.diff(trajectory.time)) < 1e-12
    assert any("resampled to 801 samples" in note for note in trajectory.notes)
    budget = evaluate(trajectory).budget
    # 10 samples at either end belong to the spline's end conditions
    assert np.std(budget.x.error[10:-10]) == pytest.approx(np.std(exact_errors(run)[0]), rel=0.02)
    # even sampling is left alone but for rounded stamps, and a missing row is no rounding
    path = write_table(run, tmp_path / "a.csv")
    plain, asked = read_table(path, run.scene), read_table(path, run.scene, resample=True)
    np.testing.assert_array_equal(plain.inner_x, asked.inner_x)
    assert plain.notes == asked.notes
    rounded = replace(run, time=np.round(run.time * 0.977, 6))
    assert np.ptp(np.diff(rounded.time)) > 0.9e-6
    trajectory = read_table(write_table(rounded, path), run.scene)
    assert np.ptp(np.diff(trajectory.time)) < 1e-12
    np.testing.assert_allclose(trajectory.time, rounded.time, atol=0.75e-6)
    assert any("rounded to 1e-06 s" in note for note in trajectory.notes)
    for step in (1e-5, 3.3e-5, 2e-6):
        assert even_clock(np.round(step * np.delete(np.arange(801), 400), 6)) is None


HEAD = "time,inner_x,inner_y," + ",".join(f"roller_{j}_{axis}" for j in range(13) for axis in "xy")
ROW = ",".join(["0.5"] * 29)
REMEDIES = {
    "decimal commas": (HEAD.replace(",", ";") + "\n" + ROW.replace(",", ";").replace(".", ","), 'decimal = ","'),
    "commas for both": (HEAD + "\n" + ROW.replace(".", ","), "58 cells under 29 names; where commas are decimal"),
    "lines before": ("Rig 7\nMonday\n" + HEAD + "\n" + ROW, "the header comes after 2 other lines"),
    "units": (HEAD + "\ns" + 28 * ",m" + "\n" + ROW, "a line of units is none of the table's rows"),
    "missing": (HEAD + "\n" + ROW + "\n#N/A" + ROW[3:], "line 3: time = '#N/A' is no number"),
    "xlsx": (b"PK\x03\x04" + bytes(99), "save the sheet as CSV UTF-8"),
    "parquet": (b"PAR1" + bytes(99), "pandas.read_parquet"),
    "mat": (b"MATLAB 5.0 MAT-file" + bytes(99), "writetable"),
    "accelerations": ("time,inner_ax,inner_ay\n0,1,2", "accelerations are not enough"),
    "orbit": ("time,inner_x,inner_y\n0,1,2", "the hub's orbit is not enough"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REMEDIES)
def test_a_table_that_is_not_read_gets_its_remedy(kind, tmp_path, capsys):
    text, remedy = REMEDIES[kind]
    (tmp_path / "a.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    (tmp_path / "s.toml").touch()
    assert main([str(tmp_path / "a.csv"), "--scene", str(tmp_path / "s.toml")]) == 2
    assert remedy in capsys.readouterr().err


def test_blanks_between_columns_and_either_sign_of_micro_are_read(run, tmp_path):
    names = {"t [ms]": "t [ms]", "X hub [um]": "X [\u00b5m]", "Y hub [um]": "Y [\u03bcm]"}
    table = {names.get(name, name.replace(" ", "", 1)): value for name, value in foreign_columns(run).items()}
    mapping = MAPPING.replace(" hub", "").replace("rho {", "rho{").replace("theta {", "theta{")
    table = {name.replace("[", " [").replace("  ", " "): value for name, value in table.items()}
    trajectory = read_table(write_foreign(tmp_path / "a.txt", table, "  "), scene_with(run, mapping))
    np.testing.assert_allclose(trajectory.inner_y, run.inner_y, atol=1e-18)


def test_incomplete_forces_and_surplus_rollers_are_refused_and_a_mapping_survives_the_round_trip(run, tmp_path):
    table, scene = foreign_columns(run), scene_with(run)
    assert parse_scene_text(scene.to_toml(), "again") == scene
    for name in ("Q7 [kN]", "t [ms]", "X hub [um]", "rho 5 [mm]", "theta 13 [deg]"):
        lacking = {k: v for k, v in table.items() if k != name}
        with pytest.raises(InputError, match=rf"missing column {re.escape(name)};.*\[table\]"):
            read_table(write_foreign(tmp_path / "c.tsv", lacking), scene)
    with pytest.raises(InputError, match=r"missing column t \[ms\], X hub \[um\].*its first line: a, b"):
        read_table(write_foreign(tmp_path / "d.csv", {"a": run.time, "b": run.time}, ","), scene)
    with pytest.raises(InputError, match="rollers"):
        read_table(write_foreign(tmp_path / "b.tsv", table | {"rho 14 [mm]": table["rho 1 [mm]"]}), scene)


def test_matlab_file_of_matrices_or_a_struct_gives_the_arrays_of_the_run_by_names_and_units_of_the_scene(run, tmp_path):
    columns = {name: getattr(run, name) for name in ("time", "inner_x", "inner_y", "roller_x", "roller_y")}
    columns["inner_force"] = run.law_force
    savemat(tmp_path / "matrices.mat", columns, oned_as="column", do_compression=True)
    savemat(tmp_path / "struct.mat", {"run1": columns, "comment": "of a rig"})
    with h5py.File(tmp_path / "new.mat", "w", userblock_size=512) as file:  # 7.3: matrices transposed
        for name, values in columns.items():
            file[name] = np.atleast_2d(values.T)
    with (tmp_path / "new.mat").open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(512))
    for name in ("matrices", "struct", "new"):
        found = read_table(tmp_path / f"{name}.mat", run.scene)
        np.testing.assert_allclose(found.roller_x, run.roller_x, rtol=0.0, atol=1e-15, err_msg=name)
        np.testing.assert_allclose(found.inner_y, run.inner_y, rtol=0.0, atol=1e-15, err_msg=name)
        np.testing.assert_array_equal(found.inner_force, run.law_force, err_msg=name)
    table = {f"X{j}": 1e3 * run.roller_x[:, j] for j in range(13)} | {"roller_y": run.roller_y}
    savemat(tmp_path / "a.mat", {"t": run.time, "inner_x": run.inner_x, "inner_y": run.inner_y} | table)
    scene = scene_with(run, '[table]\ntime = "t"\nroller_x = "X{j} [mm]"\n')
    np.testing.assert_allclose(read_table(tmp_path / "a.mat", scene).roller_x, run.roller_x, rtol=0.0, atol=1e-15)


def test_unusable_matlab_file_is_refused(run, tmp_path):
    savemat(tmp_path / "short.mat", {"time": np.arange(50.0), "inner_x": np.zeros(50)})
    savemat(tmp_path / "words.mat", {"words": "none"})
    (tmp_path / "cut.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(500))
    told = {"short": "missing column inner_y, roller_0_x", "words": "table2struct", "cut": "can't be read"}
    for name, words in told.items():
        with pytest.raises(InputError, match=words):
            read_table(tmp_path / f"{name}.mat", run.scene)


def test_orbit_alone_is_checked_with_rollers_that_roll_without_slip(tmp_path, capsys):
    """Of a run of the checker's own model with held angles nothing is left but the rollers' inertia."""
    settings = ("--set", "numerics.duration_ms=4", "--set", "lagrange.angles=kinematic")
    assert run_main(["--model", "lagrange", *settings, "--output", str(tmp_path / "run.nc"), "--quiet"]) == 0
    with h5py.File(tmp_path / "run.nc") as file:
        columns = {name: file[name][:] for name in ("time", "inner_x", "inner_y", "roller_x")}
    rollers = columns.pop("roller_x")
    rows = "\n".join(",".join(f"{v:.17g}" for v in row) for row in np.column_stack(list(columns.values())))
    (tmp_path / "orbit.csv").write_text(f"{','.join(columns)}\n{rows}\n", encoding="utf-8")
    scene = read_scene(None, ("model=lagrange",))
    found = read_table(tmp_path / "orbit.csv", scene, kinematic=True)
    np.testing.assert_allclose(found.roller_x, rollers, rtol=0.0, atol=5e-9)  # of some 4 µm of approach
    assert evaluate(found).y.error.rms < 1e-3 * 2000.0
    (tmp_path / "scene.toml").write_text('model = "lagrange"\n', encoding="utf-8")
    words = [str(tmp_path / "orbit.csv"), "--scene", str(tmp_path / "scene.toml"), "--no-figures", "--quiet"]
    assert main(words) == 2 and "--kinematic-rollers assumes rollers" in capsys.readouterr().err
    assert main([*words, "--kinematic-rollers"]) == 0 and main([str(tmp_path / "run.nc"), "--kinematic-rollers"]) == 2
    assert "--kinematic-rollers: only for tables" in capsys.readouterr().err
    (tmp_path / "scene.toml").write_text("[[spall]]\nwidth_mm = 1.0\n", encoding="utf-8")
    assert main([*words, "--kinematic-rollers"]) == 2 and "only for perfect rings" in capsys.readouterr().err


OTHERS = {
    "": (), "operation.speed_rpm = 3000.0": ("go around at 29.35 Hz, where the scene says 19.57 Hz", "4500 rpm"),
    "operation.speed_rpm = -4500.0": ("go around at 29.35 Hz, where the scene says −29.35 Hz",),
    "operation.radial_load_N = 400.0": ("approaches by the law harris carry", "scene's load of 400.8 N"),
    "bearing = { inner_raceway_diameter_mm = 36.04, outer_raceway_diameter_mm = 56.04 }":
    ("13 of its 13 rollers are loaded",),
}  # fmt: skip


@pytest.mark.parametrize("change", OTHERS)
def test_a_table_of_another_scene_is_told_before_any_verdict(run, tmp_path, capsys, change):
    table, scene, told = write_table(run, tmp_path / "t.csv"), tmp_path / "s.toml", OTHERS[change]
    scene.write_text(change, encoding="utf-8")
    summary, page = report_of(table, tmp_path / "out", "--scene", scene, "--no-figures")
    printed = capsys.readouterr().out
    assert printed.startswith("The table contradicts the scene") == bool(told)
    assert all(words in printed.partition("Residual of")[0] for words in told)
    assert ("The table contradicts the scene" in page.partition("with the contact law harris")[0]) == bool(told)
    assert len(summary["contradictions"]) >= bool(told)


def test_an_error_is_in_per_cent_of_the_load_first_however_large_contact_forces_are(run, tmp_path, capsys):
    table, scene = write_table(run, tmp_path / "t.csv"), tmp_path / "s.toml"
    raceways = "inner_raceway_diameter_mm = 36.4\nouter_raceway_diameter_mm = 56.4"
    scene.write_text(f"[bearing]\n{raceways}\n[operation]\nradial_load_N = 100.0", encoding="utf-8")
    assert main([str(table), "--scene", str(scene), "--no-figures"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r" N in y, [\d.]+ % of the load, [\d.]+ % of the largest contact force, and at most", printed)
