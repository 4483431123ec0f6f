"""What errors are compared with: the whole load, wherever it points and however it turns, or the contact forces."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from lagrange import contact_laws, static_equilibrium
from lagrange.scene.scene import Scene
from residual.cli import main
from residual.evaluation import evaluate
from residual.fault_finding import roller_motion
from tests.reference.synthetic_run import make_run, recorded

TURNS = 75.0  # Hz, of the shaft
MASS, GRAVITY = 0.078, 9.81
LOADS = {  # lines of [operation], and the rms of the whole load, N
    "down": ("radial_load_N = 2000.0", 2000.0 + MASS * GRAVITY),
    "table": ('load_table = "turning.csv"\ngravity_m_s2 = 0.0', 2000.0),
    "aside": ('load_table = "aside.csv"', np.hypot(2000.0, 20.0 + MASS * GRAVITY)),
    "rotating": ("radial_load_N = 0.0\nrotating_load_N = 2000.0\ngravity_m_s2 = 0.0", 2000.0),
    "unbalance": (
        f"radial_load_N = 0.0\nunbalance_g_mm = {2000.0 / (2 * np.pi * TURNS) ** 2 * 1e6}\ngravity_m_s2 = 0.0",
        2000.0,
    ),
    "weight": ("radial_load_N = 0.0\ninner_ring_and_shaft_kg = 200.0", 200.0 * GRAVITY),
}


def more_carried():
    """What Palmgren's law carries more than Harris', per cent, on the approaches of an equilibrium with the latter."""
    bearing, operation = Scene().ideal_bearing(), Scene().ideal_operation()
    harris, palmgren = (contact_laws(name, bearing).inner for name in ("harris", "palmgren"))
    force = static_equilibrium(bearing, operation, contact_laws("harris", bearing)).inner_force
    down = np.cos(2.0 * np.pi / bearing.n_rollers * np.arange(bearing.n_rollers))  # roller 0 under the load
    return 100.0 * (np.sum(palmgren.force(harris.approach(force)) * down) / np.sum(force * down) - 1.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("loads")
    time = np.linspace(0.0, 20.0, 801)  # ms
    angle = 2e-3 * np.pi * TURNS * time
    turning = np.column_stack([time, 2000.0 * np.cos(angle), 2000.0 * np.sin(angle)])
    np.savetxt(found / "turning.csv", turning, "%.9f", ",", header="time_ms,x_N,y_N", comments="")
    (found / "aside.csv").write_text("time_ms,x_N,y_N\n0,2000,-20\n20,2000,-20\n", encoding="utf-8")
    return found


@pytest.mark.parametrize("name", LOADS)
def test_a_load_is_a_scale_wherever_it_points_and_however_it_turns(folder, name, capsys):
    """Palmgren's law misses the same share of 2000 N from any direction: the bearing is round."""
    lines, load = LOADS[name]
    scene, run, out = folder / f"{name}.toml", folder / f"{name}.nc", folder / name
    text = f'model = "lagrange"\n[operation]\n{lines}\n[numerics]\nduration_ms = 16.0\noutput_interval_us = 5.0\n'
    scene.write_text(text, encoding="utf-8")
    assert run_main([str(scene), "--output", str(run), "--quiet"]) == 0
    assert main([str(run), "--law", "palmgren", "--no-figures", "--output", str(out)]) == 0
    printed, page = capsys.readouterr().out, (out / "report.html").read_text(encoding="utf-8")
    assert "The trajectories are sound" in printed and "of the load" in printed
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["load_N"] == pytest.approx(
        load, rel=1e-5
    )  # a table is joined smoothly
    percent = float(page.partition("law palmgren carries ")[2].partition(" %")[0])
    assert percent == pytest.approx(more_carried(), rel=0.03) and "% more than the load" in page


def test_a_preloaded_bearing_is_judged_by_its_contact_forces(tmp_path):
    run = make_run(n_times=401)
    run = replace(run, scene=run.scene.model_copy(update={"operation": run.scene.operation.model_copy(
        update={"radial_load_N": 0.0})}))  # fmt: skip
    found = evaluate(recorded(tmp_path / "idle.nc", run))
    assert found.record.load == pytest.approx(MASS * GRAVITY)
    assert found.reference == (found.force.max(), "largest contact force")


@pytest.mark.parametrize("rate", [0.0, 50.0])
def test_contacts_are_as_stiff_whatever_the_direction_of_the_load(tmp_path, rate):
    """All turned by an angle, constant or growing: nothing else in the bearing has a direction."""
    motion = roller_motion(recorded(tmp_path / "run.nc", make_run(n_times=401)))
    motion = replace(motion, law=contact_laws("palmgren", motion.bearing).inner.force)
    angle = 1.0 + rate * 1e-5 * np.arange(401)
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = motion.load
    turned = replace(
        motion, inner_angle=motion.inner_angle + angle[:, None], load=(cosine * x - sine * y, sine * x + cosine * y)
    )
    assert turned.scale == pytest.approx(motion.scale, rel=1e-12)
    assert replace(motion, load=(0.0 * x, 0.0 * y)).scale == 1.0
    assert abs(motion.scale - 1.0) > 0.02  # the load matters: the law is scaled to carry it
