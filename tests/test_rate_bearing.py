"""rate-bearing: what it prints and writes, what it refuses, coefficients for rotordynamics."""

import json
import subprocess
import sys
from inspect import signature
from pathlib import Path

import numpy as np
import pytest

from fem.commands.rate_bearing import rate_main
from fem.commands.run_fem import run_main
from fem.commands.run_study import study_main
from fem.contacts import contact_law
from fem.interface import rating
from fem.kernels import law
from fem.pictures.recover import StoredRun
from fem.rating.answers import DECLARED, Options
from fem.rating.ross import NAMES, coefficients, read_coefficients, write_coefficients
from lagrange.rating.life import DutyCycle, basic_life
from lagrange.scene.scene import read_scene
from residual.cli import main as check_main
from tests.reference.kit import environment

PROMISED = (
    "C_N C0_N P_N s0 L10_Mrev L10_h a_ISO kappa L10r_Mrev peak_pressure_MPa operating_clearance_um stiffness_N_per_m "
    "stiffness_range_N_per_m tilt_stiffness_N_m_per_rad film_um lambda friction_torque_N_mm power_loss_W warnings"
).split()
OIL = "lubricant.viscosity_Pa_s=0.0174"  # 20 mm²/s at 870 kg/m³


def scene(*overrides):
    return read_scene(None, ('bearing={designation="NU206"}', "operation.radial_load_N=3000", *overrides))


@pytest.fixture(scope="module")
def rated():
    return rating(scene(OIL, "operation.speed_rpm=2900"), Options(roughness=0.1))


def test_the_command_writes_what_was_promised(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert rate_main(["--bearing", "NU206"]) == 0
    told = json.loads((tmp_path / "NU206-rating.json").read_text(encoding="utf-8"))
    assert set(PROMISED) <= set(told)
    for name, value in told.items():
        assert value is not None or told["reasons"][name]
    assert set(told["sources"]) == {declared[0] for declared in DECLARED}
    assert np.shape(told["stiffness_N_per_m"]) == (2, 2) and np.shape(told["stiffness_range_N_per_m"]) == (2, 2, 2)
    shown = capsys.readouterr().out
    assert "basic dynamic load rating C" in shown and "ISO 281 †" in shown and "wrote NU206-rating.json" in shown


def test_numbers_of_a_worked_example(rated):
    """NU206, 3000 N and the shaft's weight, 2900 1/min, 20 mm²/s."""
    assert rated["C_N"] == pytest.approx(38_412, abs=1)
    assert rated["L10_Mrev"] == pytest.approx(basic_life(rated["C_N"], rated["P_N"]))
    assert rated["L10_h"] == pytest.approx(rated["L10_Mrev"] * 1e6 / (60.0 * 2900.0))
    assert rated["kappa"] == pytest.approx(20.0 / 12.25, rel=1e-3)
    assert rated["friction_torque_N_mm"]["skf"] == pytest.approx(91.7, abs=0.2)
    assert rated["friction_torque_N_mm"]["palmgren"] == pytest.approx(73.5, abs=0.2)
    assert rated["power_loss_W"]["skf"] / rated["temperature_rise_K"]["skf"] == pytest.approx(1.48, abs=0.01)
    assert 0.1 < rated["film_um"] < 1.0 and rated["lambda"] == pytest.approx(rated["film_um"] / 0.1)
    assert rated["hub_um"][1] < 0.0 and len(rated) == len(DECLARED)
    assert 0.3 < rated["L10r_elastic_Mrev"] / rated["L10r_pitch_Mrev"] < 3.0
    assert rated["L10r_pitch_Mrev"] == pytest.approx(rated["L10r_Mrev"], rel=0.1)


@pytest.mark.parametrize(
    ("overrides", "missing", "word"),
    [
        (["operation.radial_load_N=0", "operation.gravity_m_s2=0"], "L10_Mrev", "load"),
        (["operation.radial_load_N=0", "operation.gravity_m_s2=0", OIL], "a_ISO", "load"),
        (["material.roller.youngs_modulus_GPa=310"], "C_N", "steel"),
        (["operation.speed_rpm=0"], "L10_h", "turn"),
        (["model=lagrange", "operation.speed_rpm=0", "operation.unbalance_g_mm=20"], "P_N", "does not turn"),
        ([], "kappa", "viscosity"),
        ([], "tilt_stiffness_N_m_per_rad", "do not tilt"),
        ([], "stiffness_with_housing_N_per_m", "housing"),
        (["bodies.rollers=rigid", "model=lagrange"], "L10r_elastic_Mrev", "rigid"),
    ],
)
def test_what_can_not_be_computed_has_a_reason(overrides, missing, word):
    found = rating(scene(*overrides)).answer(missing)
    assert found.value is None and word in found.reason


@pytest.mark.parametrize(
    ("designation", "dynamic", "static"), [("6205", 14000, 7850), ("6306", 26700, 15000), ("6008", 16800, 11500)]
)
def test_ball_bearings_have_the_makers_ratings_and_the_life_of_balls(designation, dynamic, static):
    found = rating(
        read_scene(None, (f'bearing={{designation="{designation}"}}', "operation.radial_load_N=1500")),
        Options(viscosity=20.0),
    )
    assert found["C_N"] == pytest.approx(dynamic, rel=0.01) and found["C0_N"] == pytest.approx(static, rel=0.01)
    assert found["Cu_N"] == pytest.approx(found["C0_N"] / 22.0)
    assert found["L10_Mrev"] == pytest.approx((found["C_N"] / found["P_N"]) ** 3)
    assert found["Lnm_h"] == pytest.approx(found["a_ISO"] * found["L10_h"])
    assert found["stiffness_N_per_m"][1, 1] > 0.0
    for name in ("L10r_Mrev", "friction_torque_N_mm"):
        assert found[name] is None and "balls" in found.answer(name).reason


def test_rows_and_grooves_of_balls_by_the_standards():
    keys = ('bearing={designation="6205"}', "bearing.contact_angle_deg=40")
    one, two = (rating(read_scene(None, (*keys, f"bearing.rows={rows}"))) for rows in (1, 2))
    assert two["C_N"] == pytest.approx(2.0**0.7 * one["C_N"]) and two["C0_N"] == pytest.approx(2.0 * one["C0_N"])
    flat = rating(read_scene(None, (keys[0], "bearing.rows=2")))
    assert flat["C_N"] == pytest.approx(2.0**0.7 * 0.90 / 0.95 * rating(read_scene(None, keys[:1]))["C_N"])
    wide = rating(read_scene(None, (keys[0], "bearing.inner_conformity=0.54")))
    assert wide["C_N"] is None and "inner groove radius up to 0.52" in wide.answer("C_N").reason


def test_a_housing_in_series_and_a_shaft_beside():
    alone = rating(scene("model=lagrange", "operation.gravity_m_s2=0"))
    beside = rating(
        scene(
            "model=lagrange", "operation.gravity_m_s2=0", "support.kind=housing", "support.stiffness_N_per_m=1e8",
            "operation.shaft=springs", "operation.shaft_stiffness_N_per_m=2e7",
        )
    )  # fmt: skip
    assert 0.0 < beside["P_N"] < alone["P_N"] == 3000.0
    matrix = beside["stiffness_with_housing_N_per_m"]
    assert 1.0 / matrix[1, 1] == pytest.approx(1.0 / beside["stiffness_N_per_m"][1, 1] + 1e-8, rel=1e-3)


def test_a_load_that_turns_is_a_duty_cycle():
    found = rating(scene("operation.rotating_load_N=500", "operation.gravity_m_s2=0", "numerics.duration_ms=80"))
    angle = 2.0 * np.pi * (np.arange(1000) + 0.5) / 1000
    loads = np.hypot(500.0 * np.sin(angle), 3000.0 + 500.0 * np.cos(angle))
    assert found["P_N"] == pytest.approx(np.mean(loads ** (10 / 3)) ** 0.3, rel=1e-3)
    assert found["P0_N"] == pytest.approx(3500.0, rel=1e-3)
    assert any("changes with time" in warning for warning in found.warnings)


def test_duty_cycle_of_a_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = "load_kN;speed [1/min];share [%]\n1,0;600;66,6\n2,0;1200;33,3\n"
    (tmp_path / "cycle.csv").write_text(text, encoding="utf-8")
    assert rate_main(["--bearing", "NU206", "--cycle", "cycle.csv", "--decimal", ","]) == 0
    assert "equivalent dynamic load P  " in (printed := capsys.readouterr().out) and "weight included" not in printed
    told = json.loads((tmp_path / "NU206-rating.json").read_text(encoding="utf-8"))
    cycle = DutyCycle(loads=np.array([1e3, 2e3]), speeds=np.array([600.0, 1200.0]), shares=np.array([2.0, 1.0]))
    assert told["P_N"] == pytest.approx(cycle.load()) and told["P0_N"] == 2000.0
    assert told["speed_rpm"] == pytest.approx(800.0)
    assert any("not of the duty cycle" in warning and "2000 N" in warning for warning in told["warnings"])
    assert 0.3 < told["L10r_elastic_Mrev"] / told["L10r_pitch_Mrev"] < 3.0  # of the same load


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("load_N,speed_rpm\n1,2\n", "share is missing"),
        ("load_N,speed_rpm,share\n-1,2,1\n", "load"),
        ("load_N,speed_rpm,share\n1,0,1\n", "must turn"),
        ("load_N,speed_rpm,share\n5e-324,1,1\n", "load must be 0 or from 1e-12 to 1e+12"),
        ("load_N,speed_rpm,share\n1,1e308,1\n", "speed must be 0 or from 1e-12 to 1e+12"),
        ("load_lbf,speed_rpm,share\n1,1,1\n", "must be one of N, kN"),
        ("load_N;speed_rpm;share\n1,5;1;1\n", "give --decimal , if commas are decimal"),
        ("load_N,speed_rpm,share\n1,x,1\n", "line 2"),
        ("load_N,speed_rpm,share\n1,1,1\n#N/A,2,3\n", "line 3"),
    ],
)
def test_bad_duty_cycles_are_named(text, word, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cycle.csv").write_text(text, encoding="utf-8")
    assert rate_main(["--cycle", "cycle.csv"]) == 2
    told = capsys.readouterr().err
    assert "cycle.csv" in told and word in told and not (tmp_path / "paper-rating.json").exists()


@pytest.mark.parametrize(
    "arguments", [["--viscosity", "-1"], ["--contamination", "2"], ["--reliability", "91"], ["--bearing", "NU999"]]
)
def test_impossible_options_are_refused(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert rate_main(arguments) == 2
    assert "error:" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_warnings_of_a_hub_on_single_rollers_and_of_speed():
    keys = "model=lagrange", "operation.radial_load_N=5", "operation.gravity_m_s2=0", "operation.speed_rpm=30000"
    found = rating(scene(*keys))
    assert any("not positive" in warning for warning in found.warnings)
    assert any("n d_m is 1.4e+06 mm/min" in warning for warning in found.warnings)


class Ross2:
    def BearingElement(self, n, kxx, cxx, frequency=None, **others):
        """As ROSS 2 has it."""


class Ross3:
    def BearingElement(self, n, kxx, cxx, speed=None, frequency=None, **others):
        """As ROSS 3 has it, whose `frequency` is that of the whirl."""


@pytest.mark.parametrize(("ross", "name"), [(Ross2(), "frequency"), (Ross3(), "speed"), (None, "speed")])
def test_coefficients_for_rotordynamics(ross, name, rated, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ross", ross)
    found = coefficients(rated)
    write_coefficients(tmp_path / "ross.csv", found)
    header = (tmp_path / "ross.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    assert header[:2] == ["speed_rad_per_s", "kxx_N_per_m"] and header[-1] == "cyy_N_s_per_m"
    table = read_coefficients(tmp_path / "ross.csv")
    assert list(table) == [name, *NAMES] and len(table[name]) == 7
    matrices = np.stack([table[each] for each in NAMES[:4]], axis=1).reshape(-1, 2, 2)
    assert matrices == pytest.approx(found.stiffness, rel=1e-8, abs=1e-3)
    at = np.interp(rated.case.operation.speed, table[name], table["kyy"])
    assert at == pytest.approx(rated["stiffness_N_per_m"][1, 1], rel=0.01)


def test_the_element_that_ross_builds_has_these_matrices(rated, tmp_path):
    ross = pytest.importorskip("ross")
    found = coefficients(rated)
    write_coefficients(tmp_path / "ross.csv", found)
    element = ross.BearingElement(n=0, **read_coefficients(tmp_path / "ross.csv"))
    for row in (0, 3, 6):
        at = {
            name: float(found.speed[row]) for name in ("speed", "frequency") if name in signature(element.K).parameters
        }
        assert element.K(**at)[:2, :2] == pytest.approx(found.stiffness[row], rel=1e-6, abs=1.0)
        assert element.C(**at)[:2, :2] == pytest.approx(found.damping[row], abs=1e-6)


def test_a_start_loads_no_compiler_and_nothing_that_draws(tmp_path):
    assert contact_law.STEEPEST == law.STEEPEST  # the constant that ratings need of compiled code
    program = (
        "import sys; from fem.commands.rate_bearing import rate_main\n"
        "code = rate_main(['--bearing', 'NU206'])\n"
        "print(code, *(name for name in ('numba', 'matplotlib', 'scipy.optimize', 'h5py') if name in sys.modules))"
    )
    started = [sys.executable, "-c", program]
    done = subprocess.run(started, cwd=tmp_path, env=environment(), capture_output=True, text=True)
    assert done.stdout.splitlines()[-1].split() == ["0"], done.stderr


def test_the_page_shows_what_was_rated(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ["--bearing", "NU206", "--viscosity", "20", "--output", "rated", "--quiet"]
    assert rate_main(options) == 0
    told = json.loads((tmp_path / "rated" / "NU206-rating.json").read_text(encoding="utf-8"))
    page = (tmp_path / "rated" / "rating.html").read_text(encoding="utf-8")
    assert f"{told['C_N']:.0f} N" in page and "second hand" in page
    for name in ("load-zone", "stiffness", "load-deflection", "life", "misalignment", "friction"):
        assert f'id="{name}"' in page


@pytest.mark.parametrize("ring", ["speed_rpm=0", "outer_ring_speed_rpm=4500"])
def test_the_page_of_a_bearing_that_does_not_turn_leaves_out_its_life(ring, tmp_path, monkeypatch):
    """An unbalance makes the load one that changes, of which P is a mean over the turning."""
    monkeypatch.chdir(tmp_path)
    options = ["--set", f"operation.{ring}", "--set", "operation.unbalance_g_mm=10", "--output", "rated", "--quiet"]
    assert rate_main(options) == 0
    page = (tmp_path / "rated" / "rating.html").read_text(encoding="utf-8")
    verdict = page.partition('class="verdict">')[2].partition("</p>")[0]
    assert verdict.startswith("C = ") and "C0 = " in verdict and " P = " not in verdict
    assert "does not turn" in page


def test_titles_name_the_run_that_output_and_set_make(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    spalled = ["--set", "spall.0.width_mm=1", "--set", "name=healthy", "--set", "numerics.duration_ms=0.5"]
    assert run_main(["--model", "lagrange", "--output", "spalled.nc", "--dry-run", *spalled]) == 0
    assert "Plan of spalled, " in capsys.readouterr().out
    assert run_main(["--model", "lagrange", "--output", "spalled.nc", *spalled]) == 0
    assert StoredRun(tmp_path / "spalled.nc").scene.name == "spalled"  # of which pictures have their titles
    assert check_main(["spalled.nc", "--no-figures"]) == 0
    page = (tmp_path / "spalled-residual" / "report.html").read_text(encoding="utf-8")
    assert "spalled" in page.partition("<h1>")[2].partition("</h1>")[0]
    capsys.readouterr()
    assert rate_main(["spalled.nc", "--output", "rated"]) == 0
    assert rate_main(["--set", "operation.speed_rpm=3000", "--output", "rated"]) == 0
    printed = capsys.readouterr().out
    assert "Rating of spalled\n" in printed and "Rating of paper-speed_rpm-3000\n" in printed
    assert "paper-speed_rpm-3000" in (tmp_path / "rated" / "rating.html").read_text(encoding="utf-8")


def test_defaults_that_decide_the_answer_are_printed_in_a_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    study = (
        '[fixed]\nmodel = "lagrange"\n"operation.speed_rpm" = 1500\n[parameters]\n"bearing.clearance_um" = [0, 10]\n'
    )
    Path("study.toml").write_text(study, encoding="utf-8")
    speed, load = "operation.speed_rpm = 4500", "operation.radial_load_N = 2000"
    still = ["--model", "lagrange", "--duration", "0", "--bearing", "NU2212"]
    for command, arguments, told in (
        (rate_main, ["--bearing", "NU2212"], (speed, load)),
        (rate_main, ["--bearing", "NU2212", "--set", "operation.radial_load_N=9000"], (speed,)),
        (run_main, [*still, "--output", "run.nc"], (speed, load)),
        (run_main, [*still, "--dry-run", "--set", "operation.speed_rpm=100"], (load,)),
        (study_main, ["study.toml", "--dry-run"], (load,)),
    ):
        assert command(arguments) == 0
        (line,) = [each for each in capsys.readouterr().out.splitlines() if each.startswith("defaults:")]
        assert line.removeprefix("defaults:").strip() == ", ".join(told)
    both = ["--set", "operation.radial_load_N=9000", "--set", "operation.speed_rpm=100"]
    assert rate_main(["--bearing", "NU2212", *both]) == 0
    assert "defaults:" not in capsys.readouterr().out


def test_what_lives_take_for_granted_is_told_where_it_is_not_so(tmp_path, monkeypatch):
    """An oscillation of ±3°, below 360°/(13 (1 − 10/46)) = 35.4°; two rows; a ring on points."""
    monkeypatch.chdir(tmp_path)
    time = np.linspace(0.0, 100.0, 101)
    speed = np.radians(3.0) * 2.0 * np.pi / 0.05 * np.cos(2.0 * np.pi * time / 50.0) * 30.0 / np.pi  # 1/min
    rows = "".join(f"{t:g},{n:.6g}\n" for t, n in zip(time, speed, strict=True))
    Path("speed.csv").write_text("time_ms,speed_rpm\n" + rows, encoding="utf-8")
    Path("swing.toml").write_text('[operation]\nspeed_table = "speed.csv"\n[numerics]\nduration_ms = 100\n')
    assert rate_main(["swing.toml", "--quiet"]) == 0
    told = json.loads(Path("paper-rating.json").read_text(encoding="utf-8"))
    assert told["L10r_Mrev"] is None and "swing by ±3°" in told["reasons"]["L10r_Mrev"]
    assert any("critical amplitude of ±35.4°" in each for each in told["warnings"]) and told["L10_h"] > 0.0
    points = rating(read_scene(None, ("support.kind=points",)))
    assert points["L10r_Mrev"] is None and "the outer ring bends" in points.answer("L10r_Mrev").reason
    rows = rating(read_scene(None, ("bearing.rows=2",)))
    assert any("b_m = 1.15" in each for each in rows.warnings)


def test_no_axes_and_no_legend_are_drawn_where_there_is_no_equilibrium(rated, monkeypatch):
    from fem.rating import figures

    monkeypatch.setattr(figures, "_contacts", lambda case: [])
    names = {figure.name for figure in figures.rating_figures(rated.case)}
    assert "life" in names and not {"stiffness", "load-deflection"} & names


def test_a_page_of_a_bearing_without_ratings_still_shows_its_stiffness(tmp_path):
    from fem.rating.report import write_page

    write_page(tmp_path / "rating.html", rating(read_scene(None, ("bearing.type=ball", "model=lagrange"))))
    page = (tmp_path / "rating.html").read_text(encoding="utf-8")
    assert 'id="stiffness"' in page and 'id="life"' not in page and "this one has balls" in page
