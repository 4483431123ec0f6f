"""Ratings by a run's own loads: a known load, lives beside those of statics, the command, the table in the report."""

import json
import re

import numpy as np
import pytest

from fem.commands.rate_bearing import rate_main
from fem.commands.run_fem import run_main
from fem.interface import rating
from lagrange.rating.life import Dimensions, basic_life
from lagrange.rating.reference_life import run_loads
from lagrange.rating.sources import Unavailable
from lagrange.scene.scene import read_scene
from residual.cli import main

SCENE = read_scene(None, ("model=lagrange", "operation.radial_load_N=3000"))


def samples(loads, dissipated):
    """One roller after another carries the whole load of its sample; the hub stands."""
    n = len(loads)
    angle = 2.0 * np.pi * np.arange(13) / 13.0
    force = np.zeros((n, 13))
    force[np.arange(n), np.arange(n) % 13] = loads
    place = {"inner_x": np.full(n, 1e-5), "inner_y": np.zeros(n)}
    rollers = {f"roller_{axis}": np.tile(0.023 * turn(angle), (n, 1)) for axis, turn in (("x", np.cos), ("y", np.sin))}
    time = 1e-3 * np.arange(n)
    energy = {"time": time, "inner_force": force, "outer_force": force, "work_dissipated": dissipated * time}
    return energy | place | rollers


def test_equivalent_load_is_the_mean_of_its_power():
    """Half of the time 1000 N, half 2000 N: P^(10/3) is the mean of the powers (ISO 281)."""
    loads = samples(np.tile([1000.0, 2000.0], 500), 3.0)
    found = run_loads(SCENE.perfect_bearing(), SCENE.ideal_operation(), loads)
    expected = (0.5 * (1000.0 ** (10 / 3) + 2000.0 ** (10 / 3))) ** 0.3
    assert found.cycle.load() == pytest.approx(expected, rel=1e-12)
    assert found.cycle.largest_load == pytest.approx(2000.0)
    assert found.cycle.speed == pytest.approx(4500.0)
    assert found.dissipated == pytest.approx(3.0, rel=1e-9)
    assert found.torque == pytest.approx(3.0 / (2.0 * np.pi * 75.0), rel=1e-9)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "steady.nc"
    settings = ("operation.radial_load_N=3000", "numerics.duration_ms=20", "bearing.clearance_um=10")
    words = [word for setting in settings for word in ("--set", setting)]
    assert run_main(["--model", "lagrange", *words, "--output", str(path), "--quiet"]) == 0
    return path


def test_command_rates_a_run_by_its_own_loads(run, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert rate_main([str(run), "--viscosity", "20", "--quiet"]) == 0
    told = json.loads((tmp_path / "paper-rating.json").read_text(encoding="utf-8"))
    weight = 0.078 * 9.81
    assert told["P_N"] == pytest.approx(3000.0 + weight, rel=2e-4)  # a steady load, carried steadily
    assert told["L10_Mrev"] == pytest.approx(basic_life(told["C_N"], told["P_N"]), rel=1e-12)
    # of the same contacts at rest, whose loads the rollers pass through
    statics = rating(read_scene(None, ("model=lagrange", "operation.radial_load_N=3000", "bearing.clearance_um=10")))
    assert told["L10r_run_Mrev"] == pytest.approx(statics["L10r_pitch_Mrev"], rel=0.03)
    assert 0.0 <= told["dissipated_run_W"] < 0.1 * min(told["power_loss_W"].values())
    assert rate_main([str(run), "--bearing", "NU206"]) == 2
    assert "a run has its own scene and loads" in capsys.readouterr().err
    (tmp_path / "broken.nc").write_bytes(b"nothing")
    assert rate_main([str(tmp_path / "broken.nc")]) == 2


def test_loads_alone_are_no_life_of_rollers_that_tilt():
    found = run_loads(SCENE.perfect_bearing(), SCENE.ideal_operation(), samples(np.full(10, 1000.0), 3.0))
    row = Dimensions.of(SCENE.unmounted_bearing())
    assert found.life(row, tilts=False) > 0.0
    with pytest.raises(Unavailable, match="loads along the rollers"):
        found.life(row, tilts=True)


def test_hub_with_springs_of_shaft_and_housing():
    """Bearing and housing behind each other, the shaft's springs beside them."""
    stiff = read_scene(
        None,
        ("model=lagrange", "operation.shaft=springs", "operation.shaft_stiffness_N_per_m=1e7", "support.kind=housing",
         "support.stiffness_N_per_m=2e8"),
    )  # fmt: skip
    found = rating(stiff)
    bearing = np.array(found["stiffness_N_per_m"])
    expected = np.linalg.inv(np.linalg.inv(bearing) + np.eye(2) / 2e8) + 1e7 * np.eye(2)
    np.testing.assert_allclose(found["hub_stiffness_N_per_m"], expected, rtol=1e-12, atol=1e-3)
    assert found["hub_stiffness_N_per_m"][1][1] < 2.1e8
    alone = rating(SCENE)
    assert alone["hub_stiffness_N_per_m"] is None and alone["L10r_run_Mrev"] is None
    assert "give a result file" in alone.answer("L10r_run_Mrev").reason


def test_report_has_the_ratings_of_the_run(run, tmp_path):
    assert main([str(run), "--output", str(tmp_path / "report"), "--no-figures", "--quiet"]) == 0
    page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    row = r"<tr><td>([^<]+)</td><td>([^<]+)</td><td>[^<]*</td></tr>"
    rows = dict(re.findall(row, page[page.index('id="ratings"') :]))
    assert rows["equivalent load P of the run; its largest load"].startswith("3001 N; ")
    assert rows["basic load ratings C and C0"] == "47260 and 44770 N"  # ISO 281, ISO 76: 47 256 and 44 765 N
    assert "no viscosity" in rows["frictional torque by SKF; by Palmgren, ±30 %"]
