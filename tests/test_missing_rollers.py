"""Rollers that are missing from their pockets: loads, couplings of elastic rings, kinematics, runs, ratings."""

import json
import re

import h5py
import numpy as np
import pytest
from scipy.optimize import brentq

from fem.commands.rate_bearing import rate_main
from fem.commands.run_fem import run_main
from fem.interface import simulate, statics
from fem.rating.answers import Case, Options
from fem.statics.exact_statics import couplings_at, crossings_at, exact_statics, neighbours_of, reduced_bearing
from fem.study.study_file import read_parameter
from lagrange import contact_laws
from lagrange.kinematics import kinematics, roller_angles
from lagrange.rating.life import Dimensions
from lagrange.rating.sources import Unavailable
from lagrange.scene.faults import SceneError
from lagrange.scene.scene import Scene, parse_scene_text, read_scene
from residual.cli import main as check_main
from residual.measured.diagnosis import Geometry

STILL = {"speed_rpm": 0.0, "gravity_m_s2": 0.0}


def scene(missing, model="lagrange", law="harris", operation=STILL, **tables):
    bearing = {"clearance_um": 10.0, "missing_rollers": missing}
    return Scene(model=model, bearing=bearing, operation=operation, lagrange={"law": law}, **tables)


def test_the_roller_under_the_load_is_missing():
    """The paper's bearing, 10 µm clearance, both contacts by ISO 16281's spring: 945.0 and 287.4 N, −12.417 µm.

    Source: an independent solution.
    """
    found = statics(scene([0], law="iso16281"))
    loads = np.sort(found.inner_force)[::-1]
    np.testing.assert_allclose(loads[:5], [945.0, 945.0, 287.4, 287.4, 0.0], rtol=1e-3)
    assert 1e6 * found.hub[1] == pytest.approx(-12.417, rel=1e-3)
    assert len(loads) == 12 and np.min(np.abs(found.roller_theta + 0.5 * np.pi)) > 0.4


def test_by_hand_with_harris_law():
    whole = scene([0, 2])
    bearing, found = whole.perfect_bearing(), statics(whole)
    law, psi = contact_laws("harris", bearing).inner, 2.0 * np.pi * np.array(bearing.pocket) / 13.0

    def carried(hub):
        loads = law.force(0.5 * np.maximum(hub @ [np.sin(psi), np.cos(psi)] - 5e-6, 0.0))
        return loads, loads @ np.sin(psi), loads @ np.cos(psi)

    def down(across):
        return brentq(lambda y: carried(np.array([across, y]))[2] - 2000.0, 1e-9, 1e-3)

    across = brentq(lambda x: carried(np.array([x, down(x)]))[1], -2e-5, 2e-5)
    np.testing.assert_allclose(found.hub, [across, -down(across)], rtol=1e-3, atol=2e-9)
    np.testing.assert_allclose(found.inner_force, carried(np.array([across, down(across)]))[0], rtol=2e-3, atol=0.2)


def test_kinematics_are_those_of_the_pockets():
    bearing, full = scene([0, 4]).perfect_bearing(), scene([]).perfect_bearing()
    assert bearing.full == full and bearing.n_rollers == 11 and bearing.pockets == 13
    assert kinematics(bearing, 100.0) == kinematics(full, 100.0) and Geometry.of(bearing) == Geometry.of(full)
    np.testing.assert_array_equal(roller_angles(bearing, 0.3), np.delete(roller_angles(full, 0.3), [0, 4]))
    again = parse_scene_text(scene([4, 0]).to_toml(), "again").perfect_bearing()
    assert again == bearing


@pytest.mark.parametrize("missing", [[1, 2, 3, 9], pytest.param([0, 1, 2, 3, 4, 5], marks=pytest.mark.slow)])
def test_neighbours_on_elastic_rings_are_as_far_as_their_pockets(missing):
    """Compliances between rollers, and by tractions, are the series' at the rollers' own angles."""
    bearing = scene(missing, "reduced").perfect_bearing()
    rings = reduced_bearing(bearing, kinematics(bearing, 0.0)).rings
    found, at = neighbours_of(bearing, rings)
    angle, n = roller_angles(bearing, 0.0), bearing.n_rollers
    away = np.mod(angle[(np.arange(n) + found.distance[:, None]) % n] - angle + np.pi, 2.0 * np.pi) - np.pi
    met = at >= 0
    pushed, pulled = couplings_at(bearing, np.abs(away[met]))[:, 0], crossings_at(bearing, np.abs(away[met]))
    np.testing.assert_allclose(rings.along[:, at[met]], pushed, atol=1e-9 * np.abs(pushed).max())
    np.testing.assert_allclose(rings.crossed[:, at[met]], np.sign(away[met]) * pulled, atol=1e-9 * np.abs(pulled).max())
    assert np.all(np.abs(away[~met]) > np.abs(rings.distance).max() * 2.0 * np.pi / 13.0)


def test_elastic_rings_by_exact_series():
    whole = scene([0, 5], "reduced")
    bearing = whole.perfect_bearing()
    first = Case(whole, Options()).elastic
    exact = exact_statics(bearing, 2000.0, -0.5 * np.pi)
    np.testing.assert_allclose(first.inner_force[0], exact.inner_force, rtol=1e-4, atol=0.02)
    np.testing.assert_allclose(first.place[0], exact.hub, rtol=1e-4, atol=1e-10)
    assert first.turned[-1] > 1.9 * np.pi  # means are over a turn of the cage


def test_ratings_are_those_of_complete_bearings():
    with pytest.raises(Unavailable, match="rollers of this one are missing"):
        Dimensions.of(scene([3]).perfect_bearing())


def test_a_run_numbers_its_rollers_and_is_sound(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    keys = ("bearing.missing_rollers=[4, 0]", "bearing.clearance_um=10", "numerics.duration_ms=1", "cage.mass_kg=0.02")
    arguments = [word for key in keys for word in ("--set", key)]
    assert run_main(["--model", "lagrange", "--output", "run.nc", "--quiet", *arguments]) == 0
    with h5py.File("run.nc") as file:
        np.testing.assert_array_equal(file["roller"], [1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12])
    assert check_main(["run.nc", "--no-figures", "--quiet", "--output", "checked"]) == 0
    summary = json.loads((tmp_path / "checked" / "summary.json").read_text(encoding="utf-8"))
    assert summary["error_y"]["rms_N"] < 0.5 and summary["loaded_rollers"]["max"] <= 5


@pytest.mark.slow
def test_models_agree_while_pockets_pass_the_load():
    """2 ms, in which an empty pocket leaves the load zone: hub and loads of both elastic models, and energy."""
    turning = {"speed_rpm": 4500.0}
    tables = {"operation": turning, "numerics": {"duration_ms": 2.0}}
    reduced, fem = (simulate(scene([0, 4], model, **tables)) for model in ("reduced", "fem"))
    np.testing.assert_allclose(reduced["inner_y"], fem["inner_y"], atol=0.01e-6)
    np.testing.assert_allclose(reduced["inner_force"], fem["inner_force"], atol=2.0)
    names = "energy_kinetic", "energy_elastic", "energy_contact", "work_dissipated"
    balance = sum(reduced[name] for name in names) - reduced["work_external"]
    assert np.ptp(balance) < 1e-6 * float(np.max(reduced["energy_contact"]))


HALF = "bearing.missing_rollers=[10, 11, 12, 0, 1, 2, 3]"


@pytest.mark.parametrize(
    ("model", "more"),
    [("lagrange", ()), ("reduced", ()), ("fem", ("numerics.mesh_size_mm=2",)), ("lagrange", ("axial.slices=5",))],
)  # fmt: skip
def test_nothing_carries_the_hub_where_rollers_are_missing_over_half_a_turn(model, more, tmp_path, capsys):
    arguments = ["--model", model, "--duration", "0", "--output", str(tmp_path / "run.nc")]
    settings = [word for key in (HALF, *more) for word in ("--set", key)]
    assert run_main([*arguments, *settings]) in (1, 2)
    error = capsys.readouterr().err
    assert "nothing carries the hub" in error and "missing over 222 degrees" in error
    assert "radial_load" not in error and "law" not in error
    assert run_main([*arguments, *settings, "--set", "operation.first_roller_deg=180"]) == 0


def test_a_rating_and_a_run_say_what_the_hub_fell_into(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = ["--set", HALF, "--set", "operation.first_roller_deg=180", "--quiet"]
    assert run_main(["--model", "lagrange", "--duration", "30", "--output", "run.nc", *settings]) == 1
    assert "nothing carries the hub" in capsys.readouterr().err
    assert rate_main(settings) == 0
    rated = json.loads(next(tmp_path.glob("*-rating.json")).read_text(encoding="utf-8"))
    assert "nothing carries the hub" in rated["reasons"]["stiffness_N_per_m"]


def test_it_may_be_varied_and_set():
    assert scene([]).varied({"bearing.missing_rollers.0": 3}).bearing.missing_rollers == [3]
    assert scene([1]).varied({"bearing.missing_rollers": [2, 5]}).perfect_bearing().missing == (2, 5)
    assert read_scene(None, ("bearing.missing_rollers=[7]",)).bearing.present == 12
    assert read_parameter("bearing.missing_rollers.0", [0, 1, 2]).axis("grid") == (0, 1, 2)


REFUSED = {
    "none such": ({"bearing": {"missing_rollers": [13]}}, "there is no roller 13"),
    "twice": ({"bearing": {"missing_rollers": [1, 1]}}, "a number is there twice"),
    "nearly all": ({"bearing": {"missing_rollers": list(range(11))}}, "leaves 2 rollers; at least 3"),
    "unequal": ({"unequal_roller": [{"roller": 2}]}, "not together with bearing.missing_rollers"),
    "a roller's spall": ({"spall": [{"body": "roller", "roller": 2}]}, "not together with bearing.missing_rollers"),
    "a number": ({"bearing": {"missing_rollers": 3}}, "missing_rollers = 3"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    tables, told = REFUSED[case]
    with pytest.raises(SceneError, match=re.escape(told)):
        Scene(**({"bearing": {"missing_rollers": [1]}} | tables))
