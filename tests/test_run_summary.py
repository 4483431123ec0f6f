"""What a run says of itself first: hub, loads, load zone, cage, ball passes."""

import json
import re
from math import pi, tau
from pathlib import Path

import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.interface import simulate
from fem.quantities import labels
from fem.run_summary import run_summary
from lagrange import kinematics
from lagrange.scene.scene import read_scene
from residual.cli import main as check_main

N = 13


def samples(speed, slip=0.0, turns=1.0, count=4001):
    """A made-up run: rollers loaded in the lower 120° of the circle, hub on an ellipse."""
    bearing = read_scene().ideal_bearing()
    time = np.linspace(0.0, turns * tau / (kinematics(bearing, speed).cage * (1.0 - slip)), count)
    cage = turns * np.linspace(0.0, tau, count)
    theta = cage[:, None] + tau * np.arange(N) / N
    off = np.abs((theta + 0.5 * pi + pi) % tau - pi)  # from the load
    inner = np.where(off < pi / 3.0, 700.0 * np.cos(1.5 * off), 0.0)
    return {
        "time": time,
        "inner_x": 1e-6 * np.sin(cage),
        "inner_y": 1e-6 * (-3.0 + 0.5 * np.cos(cage)),
        "inner_force": inner,
        "outer_force": inner + 6.0,
        "roller_theta": theta,
    }


def test_a_made_up_run_is_told_as_it_was_made():
    bearing, speed = read_scene().ideal_bearing(), 4500.0 * tau / 60.0
    told = run_summary(bearing, kinematics(bearing, speed), samples(speed, slip=0.02, turns=2.0))
    assert told["hub"] == "mean x 0.0000 µm, y -2.9999 µm; peak to peak 2.0000 and 1.0000 µm"
    assert "700.0 N (" in told["largest loads"] and "706.0 N (" in told["largest loads"]
    # above 1 % of 700 N where cos(1.5 off) is: 119.2°, to a degree of either side
    assert float(told["load zone"].partition("°")[0]) == pytest.approx(119.2, abs=1.5)
    assert told["roller orbit"].endswith("Hz, 2 % slower than pure rolling (no cage: rollers coast)")
    cage = 0.98 * kinematics(bearing, speed).cage / tau
    assert f"(BPFO) {N * cage:.4g} Hz" in told["ball passes"]
    assert f"(BPFI) {N * (75.0 - cage):.4g} Hz" in told["ball passes"]


def test_the_pressure_is_hertz():
    """Johnson, Contact Mechanics (1985), chapter 4: p0 = sqrt(Q E* / (π L R))."""
    bearing, speed = read_scene().ideal_bearing(), 4500.0 * tau / 60.0
    told = run_summary(bearing, kinematics(bearing, speed), samples(speed))["largest loads"]
    modulus = 0.5 * bearing.roller.plane_strain_modulus
    radius = 1.0 / (1.0 / bearing.roller_radius + 1.0 / bearing.inner_raceway_radius)
    pressure = np.sqrt(700.0 * modulus / (pi * bearing.roller_length * radius))
    assert f"700.0 N ({1e-6 * pressure:.0f} MPa)" in told


def test_a_motion_that_reverses_has_no_mean_slip(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("there-and-back.csv").write_text("time_ms,speed_rpm\n0,600\n10,600\n30,-600\n40,-600\n")
    keys = ("model=lagrange", "operation.speed_table=there-and-back.csv", "name=back", "numerics.duration_ms={}")

    def run(duration):
        words = [word for key in keys for word in ("--set", key.format(duration))]
        assert run_main([*words, "--output", f"{duration}.nc"]) == 0
        return capsys.readouterr().out

    told = run(40)
    assert "the motion reverses: no mean slip" in told
    assert "BPFO" not in told and "% of rolling" not in told
    assert "BPFO" in run(10)  # before it turns back
    found = read_scene(None, tuple(key.format(40) for key in keys))
    assert np.isnan(simulate(found).quantities["cage_slip"].value)
    assert np.isnan(labels(found)["BPFO_Hz"]) and np.isnan(labels(found)["speed_rpm"])
    assert check_main(["40.nc"]) == 0  # less than a turn one way: no orders
    assert "% of rolling" not in capsys.readouterr().out
    summary = json.loads(Path("40-residual/summary.json").read_text(encoding="utf-8"))
    assert summary["cage_Hz"] == {"observed": None, "rolling_without_slip": None}


def test_a_plan_gives_each_raceway_its_own_largest_force(capsys):
    """At 20 000 rpm rollers' centrifugal force m R ω² loads the outer raceway alone."""
    keys = ("bearing.designation=NU206", "operation.speed_rpm=20000", "operation.radial_load_N=500", "model=reduced")
    assert run_main(["--dry-run", *(word for key in keys for word in ("--set", key))]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("largest static"))
    (inner, inner_pressure), (outer, outer_pressure) = re.findall(r"([\d.]+) N \((\d+) MPa\)", row)
    bearing = read_scene(None, keys).ideal_bearing()
    cage = kinematics(bearing, 20000.0 * tau / 60.0).cage
    grown = bearing.roller_mass * (bearing.pitch_radius * cage**2 + 9.81)
    assert float(outer) - float(inner) == pytest.approx(grown, abs=0.15)
    for pressure, force, radius in (
        (inner_pressure, float(inner), bearing.inner_raceway_radius),
        (outer_pressure, float(outer), -bearing.outer_raceway_radius),
    ):
        curvature = 1.0 / bearing.roller_radius + 1.0 / radius
        modulus = 0.5 * bearing.roller.plane_strain_modulus
        hertz = np.sqrt(force * modulus * curvature / (pi * bearing.roller_length))
        assert float(pressure) == pytest.approx(1e-6 * hertz, abs=1.0)


def test_a_record_too_short_for_all_angles_names_no_load_zone():
    bearing, speed = read_scene().ideal_bearing(), 4500.0 * tau / 60.0
    assert "load zone" not in run_summary(bearing, kinematics(bearing, speed), samples(speed, turns=0.02))


def test_a_standing_bearing_has_no_cage_speed():
    bearing = read_scene().ideal_bearing()
    told = run_summary(bearing, kinematics(bearing, 0.0), samples(4500.0 * tau / 60.0))
    assert set(told) == {"hub", "largest loads", "load zone"}
