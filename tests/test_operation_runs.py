"""Runs of every solver under speed and load that change: energy, budget, resume, orbits, orders."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.runner import RunOptions, run_scene
from fem.solver.simulate import make_plan
from fem.statics.contact_balance import Loads, balance, first_guess
from fem.statics.exact_statics import exact_contacts
from lagrange import contact_laws
from lagrange.first_state import Problem
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import read_scene
from residual.evaluation import evaluate
from residual.sources import read_result
from tests.reference.compiled import assert_right
from tests.reference.kit import LOADS, RAMP, assert_same_bits, budget_terms, rest_of_run, scene_with, whole_run

MODELS = ("lagrange", "reduced", "fem")
SMOOTH = "time_ms,speed_rpm\n0,3000\n1,3200\n3,4500\n4,4700\n"  # in which rollers do not slip
TURNING = ("operation.unbalance_g_mm=20", "operation.unbalance_deg=20", "operation.rotating_load_N=100")
COARSE = ("numerics.mesh_size_mm=2", "numerics.duration_ms=3")

pytestmark = pytest.mark.slow  # each compiles loops of its own


def everything(folder, model, *more):
    return scene_with(folder, f"model={model}", *TURNING, *COARSE, *more, speeds=SMOOTH, loads=LOADS)


@pytest.mark.parametrize("model", MODELS)
def test_energy_balances_and_the_budget_adds_up(model, tmp_path):
    scene, path = everything(tmp_path, model), tmp_path / "run.nc"
    assert run_scene(scene, path, RunOptions(quiet=True)).code == 0
    found = evaluate(read_result(path), "harris")
    with h5py.File(path) as file:
        work, kinetic = file["work_external"][:], file["energy_kinetic"][:]
        stored = kinetic + file["energy_elastic"][:] + file["energy_contact"][:] + file["work_dissipated"][:]
        exchanged = np.maximum(np.abs(kinetic - kinetic[0]).max(), (file["energy_contact"][:]).max())
    assert np.ptp(work) > 1e-3  # J
    assert np.abs(stored - stored[0] - (work - work[0])).max() < 2e-3 * exchanged
    terms = budget_terms(found)
    acting = found.record.acting
    for each, load in zip(terms, (acting.side_load, acting.radial_load), strict=True):
        assert abs(each["ring_flexibility"] @ load) < 0.01 * (load @ load)  # nothing of the load is missing


@pytest.mark.parametrize("model", MODELS)
def test_a_resumed_run_has_the_same_bits(model, tmp_path):
    plan = make_plan(everything(tmp_path, model))
    assert_same_bits(*reversed(rest_of_run(plan, 37, 50)))


@pytest.mark.parametrize("choices", [{}, {"angles": "free"}, {"start": "rest", "load_ramp": 5e-4}])
def test_compiled_steps_make_the_references_motion(choices, tmp_path):
    scene = scene_with(tmp_path, *TURNING, "numerics.duration_ms=8", speeds=RAMP, loads=LOADS)
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    assert_right(Problem(bearing=bearing, operation=operation, laws=contact_laws("harris", bearing), **choices), 61)


@pytest.mark.parametrize("model", ["reduced", "fem"])
def test_an_unbalance_drives_a_circle(model):
    """F/(k − M ω²), k by exact statics of elastic bodies in a preloaded bearing, where it is the same all around."""
    scene = read_scene(None, (
        f"model={model}", "bearing.outer_raceway_diameter_mm=55.98", "operation.radial_load_N=0",
        "operation.gravity_m_s2=0", "operation.speed_rpm=20000", "operation.inner_ring_and_shaft_kg=20",
        "operation.unbalance_g_mm=40", "numerics.mesh_size_mm=1", "numerics.duration_ms=9",
        "numerics.output_interval_us=20",
    ))  # fmt: skip
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    force = 40e-6 * operation.speed**2
    contacts = exact_contacts(bearing, roller_angles(bearing, operation.first_roller_angle))
    grown = make_plan(scene.varied({"model": "reduced"})).model.contacts.closing
    contacts = replace(contacts, closing=grown)
    hub = []
    for push in (-force, force):
        loads = Loads(0.0, 0.0, operation.speed * 9 / 22.995, push)
        hub.append(balance(contacts, loads, first_guess(bearing, contacts.radial, 0.0, push))[0][0])
    stiffness, inertia = 2.0 * force / (hub[1] - hub[0]), 20.0 * operation.speed**2
    assert 0.04 < inertia / stiffness < 0.2
    found = whole_run(make_plan(scene))
    time, x, y = (found[name] for name in ("time", "inner_x", "inner_y"))
    window = np.sin(np.pi * time / time[-1]) ** 2
    place = (x + 1j * y) * window / window.sum()
    ahead, back = (np.sum(place * np.exp(sign * 1j * operation.speed * time)) for sign in (-1, 1))
    assert abs(ahead) == pytest.approx(force / (stiffness - inertia), rel=5e-3)
    assert abs(back) < 5e-3 * abs(ahead)


def test_a_spalled_bearing_running_up_shows_its_lines_in_orders(tmp_path):
    """From 1000 to 5000 rpm: BPFO 5.087 in the envelope, it and FTF 0.3913 in the path, at every instant."""
    speeds = "time_ms,speed_rpm\n0,1000\n300,1500\n700,4000\n1000,5000\n"
    more = '[[spall]]\nbody = "outer_ring"\n[[unequal_roller]]\ndiameter_deviation_um = 2.0\n'
    more += "[damping]\ncontact_N_s_m = 200.0"
    settings = "model=lagrange", "numerics.duration_ms=1000", "numerics.output_interval_us=20"
    scene = scene_with(tmp_path, *settings, speeds=speeds, more=more)
    path = tmp_path / "run.nc"
    assert run_scene(scene, path, RunOptions(quiet=True)).code == 0
    found = evaluate(read_result(path), "harris").y.orders
    assert (found.tracking.lines["BPFO"], found.tracking.lines["FTF"]) == pytest.approx((5.0870, 0.39130), abs=1e-4)
    named = {peak.line: peak.frequency for peak in found.peaks}
    assert (named["BPFO"], named["FTF"]) == pytest.approx((5.0870, 0.39130), abs=2e-3)
    above = (found.envelope.frequency > 3.0) & (found.envelope.frequency < 7.5)
    assert found.envelope.frequency[above][np.argmax(found.envelope.psd[above])] == pytest.approx(5.087, abs=0.03)
    short = found.short_time
    for low, high, order in ((4.9, 5.28, 5.087), (0.25, 0.6, 0.3913)):
        inside = (short.frequency > low) & (short.frequency < high)
        highest = short.frequency[inside][np.argmax(short.psd[inside], axis=0)]
        assert np.abs(highest - order).max() <= 0.51 * short.frequency[1]


def test_a_dry_run_tells_the_range_of_speeds(tmp_path, capsys):
    scene_with(tmp_path, "numerics.duration_ms=8", speeds=RAMP)
    scene = tmp_path / "scene.toml"
    assert run_main([str(scene), "--model", "lagrange", "--duration", "8", "--dry-run"]) == 0
    told = capsys.readouterr().out
    assert "1000 to 6000 rpm" in told and "frequencies at 1000 rpm" in told and "BPFO 508.7 Hz" in told


def test_the_report_tells_orders(tmp_path):
    from residual.cli import main

    scene = scene_with(
        tmp_path, "model=lagrange", "numerics.duration_ms=200", "numerics.output_interval_us=20",
        speeds="time_ms,speed_rpm\n0,3000\n200,9000\n",
    )  # fmt: skip
    assert run_scene(scene, tmp_path / "run.nc", RunOptions(quiet=True)).code == 0
    assert main([str(tmp_path / "run.nc"), "--output", str(tmp_path / "report")]) == 0
    orders = json.loads((tmp_path / "report" / "summary.json").read_text(encoding="utf-8"))["orders"]
    assert "BPFO" in [peak["line"] for peak in orders["peaks_y"]]
    assert orders["lines"]["FTF"] == pytest.approx(0.3913, abs=1e-4)
    assert (tmp_path / "report" / "orders.png").exists()
