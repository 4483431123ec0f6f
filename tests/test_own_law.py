"""A contact law of the scene's own: given, or fitted to a table; in statics, runs, checks and ratings."""

import json
import re

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.rating.case import Case, Options
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.laws import law_names
from lagrange.scene.faults import SceneError
from lagrange.scene.law_table import fitted_law
from lagrange.scene.scene import Scene, parse_scene_text, read_scene
from residual.cli import main as check_main

EXPONENT = 10.0 / 9.0
K = 7.86e4 * 9.6 ** (8.0 / 9.0) * 1e3**EXPONENT  # N/m^n, of a roller of 9.6 mm, as Harris gives it in N and mm
SIZES = {
    "rollers": 14, "roller_diameter_mm": 10.0, "roller_length_mm": 9.6, "inner_raceway_diameter_mm": 54.9947,
    "clearance_um": 40.6, "bore_diameter_mm": 45.0, "outside_diameter_mm": 85.0,
}  # fmt: skip
OWN = {"law": "power", "contact_stiffness_N_per_m_n": [K, K], "contact_exponent": EXPONENT}
STILL = {"radial_load_N": 4450.0, "speed_rpm": 0.0, "gravity_m_s2": 0.0}
FORCES = np.array([10.0, 50.0, 200.0, 500.0, 1000.0, 2000.0, 3000.0])


def table(force=FORCES, noise=0.0, header="force [kN]; approach [um]"):
    approach = 1e6 * (force / K) ** (1.0 / EXPONENT) * (1.0 + noise * (-1.0) ** np.arange(len(force)))
    rows = [f"{1e-3 * q:.10g}; {d:.10g}" for q, d in zip(force, approach, strict=True)]
    return "\n".join(["# of a test rig", header, "0; 0", *rows])


def test_harris_209_bearing_by_its_own_law():
    """Fourteen rollers in 40.6 µm clearance: 32.11 µm, 1959 and 1382 N, 473 and 67 N/µm; Harris' integral has 1915 N.

    Source: the bearing and K of Harris, Rolling Bearing Analysis, its example of the 209 cylindrical roller bearing;
    equilibrium of discrete rollers by an independent solution.
    """
    scene = Scene(bearing=SIZES, lagrange=OWN, operation=STILL)
    bearing = scene.ideal_bearing()
    found = static_equilibrium(bearing, scene.ideal_operation(), contact_laws("power", bearing), roller_mass=0.0)
    assert -1e6 * found.y == pytest.approx(32.11, rel=1e-3)
    loads = np.sort(found.inner_force)[::-1][:5]
    np.testing.assert_allclose(loads, [1959.0, 1382.0, 1382.0, 0.0, 0.0], rtol=1e-3)
    np.testing.assert_allclose(np.diag(1e-6 * found.stiffness), [67.0, 473.0], rtol=3e-3)


def test_raceways_may_differ_and_balls_may_have_it():
    scene = Scene(
        bearing={"type": "ball"}, lagrange={"contact_stiffness_N_per_m_n": [1e10, 2e10], "contact_exponent": 1.5}
    )
    laws = contact_laws(scene.lagrange.law, scene.ideal_bearing())
    assert scene.lagrange.law == "power" and law_names(scene.ideal_bearing()) == ("hertz", "power")
    np.testing.assert_allclose([law.force(1e-6) for law in laws], [10.0, 20.0])
    assert laws.inner.exponent == 1.5


def test_a_table_gives_constants_and_how_near_they_are():
    exact, noisy = fitted_law(table()), fitted_law(table(noise=0.01))
    assert exact.inner_stiffness == exact.outer_stiffness == pytest.approx(K, rel=1e-7)
    assert exact.exponent == pytest.approx(EXPONENT, rel=1e-8) and exact.misfit < 1e-8
    # approaches off by 1 % to and fro are forces off by n times as much, in the mean over the line
    assert noisy.misfit == pytest.approx(0.01 * EXPONENT, rel=0.3)
    assert "from 10 to 3000 N" in noisy.range and re.search(r"1\.\d % rms, 1\.\d % at most", noisy.range)
    same = fitted_law(table(header="force_kN; approach_um"))
    assert same.inner_stiffness == exact.inner_stiffness


def test_a_run_its_check_and_its_rating_with_a_table(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "law.csv").write_text(table(), encoding="utf-8")
    keys = "".join(f"{key} = {value}\n" for key, value in SIZES.items())
    text = f'name = "209"\nmodel = "lagrange"\n[bearing]\n{keys}[lagrange]\nlaw_table = "law.csv"\n'
    (tmp_path / "209.toml").write_text(text + "[operation]\nradial_load_N = 4450\n", encoding="utf-8")
    assert run_main(["209.toml", "--dry-run", "--set", "numerics.duration_ms=0.5"]) == 0
    assert "forces differ by" in capsys.readouterr().out
    assert run_main(["209.toml", "--output", "209.nc", "--quiet", "--set", "numerics.duration_ms=0.5"]) == 0
    (tmp_path / "law.csv").unlink()  # the result file holds it
    assert check_main(["209.nc", "--law", "power", "--compare-laws", "--no-figures", "--output", "checked"]) == 0
    summary = json.loads((tmp_path / "checked" / "summary.json").read_text(encoding="utf-8"))
    assert summary["law"] == "power" and summary["error_y"]["rms_N"] < 1.0
    assert "power (in use)" in capsys.readouterr().out
    (tmp_path / "law.csv").write_text(table(), encoding="utf-8")
    rated = Case(read_scene("209.toml", ("operation.gravity_m_s2=0",)), Options())
    assert "power" in rated.contacts
    lowest, _ = rated.pitch.range  # with a roller under the load, where the rollers' own weight adds little
    assert np.diag(lowest) == pytest.approx([67.0e6, 473.0e6], rel=3e-3)


def test_a_law_that_is_not_at_hand_is_no_bearing_s():
    scene = parse_scene_text('lagrange.law_table = "law.csv"', "scene")
    with pytest.raises(ValueError, match="not at hand"):
        contact_laws("power", scene.ideal_bearing())


REFUSED = {
    "which": ({"law": "power"}, None, "needs contact_stiffness_N_per_m_n = "),
    "half of it": ({"contact_stiffness_N_per_m_n": [1e9, 1e9]}, None, "give both, or neither"),
    "of one raceway": ({"contact_stiffness_N_per_m_n": [1e9], "contact_exponent": 1.1}, None, "at least 2 items"),
    "negative": ({"contact_stiffness_N_per_m_n": [1e9, -1.0], "contact_exponent": 1.1}, None, "greater than 0"),
    "softening": ({"contact_stiffness_N_per_m_n": [1e9, 1e9], "contact_exponent": 0.9}, None, "greater than or equal"),
    "twice": ({"contact_stiffness_N_per_m_n": [1e9, 1e9], "contact_exponent": 1.1}, table(), "are fitted to it"),
    "no units": ({}, table(header="force; approach"), "column force: its unit must be one of N, mN, kN, lbf"),
    "one row": ({}, table(FORCES[:1]), "at least 3 different approaches"),
    "exchanged": ({}, table(header="approach [um]; force [kN]"), "are the columns exchanged"),
    "pulling": ({}, table().replace("0.5;", "-0.5;"), "must both be above 0"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case, tmp_path):
    keys, text, told = REFUSED[case]
    overrides = tuple(f"lagrange.{key}={json.dumps(value)}" for key, value in keys.items())
    if text is not None:
        (tmp_path / "law.csv").write_text(text, encoding="utf-8")
        overrides += ('lagrange.law_table="law.csv"',)
    (tmp_path / "scene.toml").write_text("", encoding="utf-8")
    with pytest.raises(SceneError, match=re.escape(told)):
        read_scene(tmp_path / "scene.toml", overrides)
