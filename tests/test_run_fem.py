"""The command run-fem: what it refuses, what it writes and warns of, how it ends."""

import re
from dataclasses import replace
from math import pi, sqrt, tau
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pytest
import xarray
from scipy.special import elliprd

from fem.commands.run_fem import run_main
from fem.interface import simulate
from fem.kernels.elements.rings import HALO
from fem.quantities import labels, run_summary
from fem.result.store import ResultFile
from fem.runner import result_megabytes, size_warning
from fem.solver.elements.plan import LONGEST_UNWATCHED
from fem.solver.guards import Judge, n_in_place, run_warnings
from fem.solver.limits import of_scene
from fem.solver.row_state import SampleReader
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.columns import columns_of
from lagrange.contact.hertz import contact_ellipse, contact_pairs
from lagrange.equations import THROUGH, farthest_place
from lagrange.errors import RunFailed
from lagrange.kinematics import kinematics
from lagrange.scene.scene import SceneError, parse_scene, read_scene
from residual.cli import main as check_main
from residual.sources import read_result
from tests.reference.kit import PAPER, attributes, command, read_json, sets, whole_run


def plan_of(*settings):
    return make_plan(read_scene(None, ("numerics.mesh_size_mm=2", *settings)))


def line_pressure(force, radius, bearing=PAPER):
    """Hertz's of steel: p0 = sqrt(Q E* / (π R L)) (Johnson, Contact Mechanics, 1985, 4.2), MPa; radius of the other."""
    curvature = 1.0 / bearing.roller_radius + 1.0 / radius
    return 1e-6 * sqrt(force * 210e9 / (2.0 * (1.0 - 0.3**2)) * curvature / (pi * bearing.roller_length))


def test_help_and_dry_runs_write_nothing(here, capsys):
    run_main(["--help"])
    assert "Example: run-fem" in capsys.readouterr().out and run_main(["--dry-run", "--mesh-size", "2"]) == 0
    out = capsys.readouterr().out
    assert all(word in out for word in ("degrees of freedom", "time step", "memory", "result file", "angles"))
    wide = sets("bearing.outside_diameter_mm=2000")  # it compares with no mesh that takes its time
    assert run_main(["--dry-run", "--model", "lagrange", *wide]) == 0
    assert "nodes, too many" in capsys.readouterr().out and not list(here.iterdir())


def test_a_large_result_file_is_announced_with_the_keys_that_make_it_smaller(tmp_path):
    short, long = (plan_of("model=lagrange", f"numerics.duration_ms={duration}") for duration in (20, 2000))
    assert size_warning(short) == ()
    assert {"numerics.duration_ms", "numerics.output_interval_us"} <= set(size_warning(long)[0].split())
    with ResultFile(tmp_path / "run.nc", short, 0.0):
        assert 1e-6 * (tmp_path / "run.nc").stat().st_size == pytest.approx(result_megabytes(short), rel=0.05)


def test_static_runs_print_and_store_the_equilibrium(tmp_path, capsys):
    """Whole bearing on resolved P2 meshes: 3.6140 µm; 628.5, 549.5, 337.2, 62.9 N (independent static solution)."""
    options = ["--duration", "0", "--output", str(path := tmp_path / "static.nc")]
    assert run_main([*options, "--model", "lagrange", *sets("operation.speed_rpm=3000")]) == 0
    assert "Static equilibrium at 3000 rpm, with centrifugal force: hub" in capsys.readouterr().out
    assert run_main([*options, *sets("operation.speed_rpm=0", "operation.gravity_m_s2=0"), "--force"]) == 0
    assert "Static equilibrium at rest: hub" in capsys.readouterr().out
    with h5py.File(path) as file:
        assert file["time"].shape == (1,) and -1e6 * file["inner_y"][0] == pytest.approx(3.6140, rel=1e-3)
        loads = np.sort(file["inner_force"][0])[::-1][:7]
    assert loads == pytest.approx([628.5, 549.5, 549.5, 337.2, 337.2, 62.9, 62.9], rel=3e-3)


def test_result_file_holds_the_contract_for_any_reader(coarse_run):
    promised = "scene program_version mesh_nodes degrees_of_freedom time_step critical_time_step steps wall_seconds"
    with h5py.File(coarse_run) as file:
        assert file.attrs["status"] == "complete" and {*promised.split(), "setup_seconds"} <= set(file.attrs)
        assert file.attrs["committed_samples"] == 401 == file["time"].shape[0]
        for name, (dimensions, units, _) in columns_of("").items():
            assert file[name].attrs["units"] == units and file[name].attrs["long_name"]
            assert file[name].ndim == len(dimensions) and np.all(np.isfinite(file[name][:]))
        assert file["time"][1] - file["time"][0] == pytest.approx(1e-5, rel=1e-12)
    with xarray.open_dataset(coarse_run, engine="netcdf4") as data:
        assert data["inner_force"].dims == ("time", "roller") and data["inner_y"].attrs["units"] == "m"
    with netCDF4.Dataset(coarse_run) as data:
        assert data.variables["roller_rho"].dimensions == ("time", "roller")


def test_physics_of_the_coarse_run(coarse_run):
    """Cage 29.35 Hz by kinematics; six or seven loaded rollers, largest load 620-650 N."""
    with h5py.File(coarse_run) as file:
        time_, force, angle = file["time"][:], file["inner_force"][:], file["roller_theta"][:]
        stored = file["energy_kinetic"][:] + file["energy_elastic"][:] + file["energy_contact"][:]
        balance = stored - file["work_external"][:] + file["work_dissipated"][:]
        elastic = file["energy_elastic"][:].max()
        assert file["roller_roller_force"][:].max() == 0.0
    loaded = np.count_nonzero(force > 0.0, axis=1)
    assert (loaded.min(), loaded.max()) == (6, 7) and 620.0 < force.max() < 650.0
    assert np.mean(angle[-1] - angle[0]) / (tau * time_[-1]) == pytest.approx(29.35, rel=0.01)
    assert np.ptp(balance) < 1e-4 * elastic  # 1 % is asked for; measured 4e-6


# What a run says of itself first: hub, loads, load zone, cage, ball passes
def samples(speed, slip=0.0, turns=1.0, count=4001):
    """A made-up run: rollers loaded in the lower 120° of the circle, hub on an ellipse."""
    time = np.linspace(0.0, turns * tau / (kinematics(PAPER, speed).cage * (1.0 - slip)), count)
    cage = turns * np.linspace(0.0, tau, count)
    theta = cage[:, None] + tau * np.arange(13) / 13
    off = np.abs((theta + 0.5 * pi + pi) % tau - pi)  # from the load
    inner = np.where(off < pi / 3.0, 700.0 * np.cos(1.5 * off), 0.0)
    return {
        "time": time, "inner_x": 1e-6 * np.sin(cage), "inner_y": 1e-6 * (-3.0 + 0.5 * np.cos(cage)),
        "inner_force": inner, "outer_force": inner + 6.0, "roller_theta": theta,
    }  # fmt: skip


def test_a_made_up_run_is_told_as_it_was_made():
    speed = 4500.0 * tau / 60.0
    motion = kinematics(PAPER, speed)
    told = run_summary(PAPER, motion, samples(speed, slip=0.02, turns=2.0))
    assert told["hub"] == "mean x 0.0000 µm, y -2.9999 µm; peak to peak 2.0000 and 1.0000 µm"
    assert f"700.0 N ({line_pressure(700.0, 18e-3):.0f} MPa)" in told["largest loads"]
    assert "706.0 N (" in told["largest loads"]
    # above 1 % of 700 N where cos(1.5 off) is: 119.2°, to a degree of either side
    assert float(told["load zone"].partition("°")[0]) == pytest.approx(119.2, abs=1.5)
    assert told["roller orbit"].endswith("Hz, 2 % slower than pure rolling (no cage: rollers coast)")
    cage = 0.98 * motion.cage / tau
    assert f"(BPFO) {13 * cage:.4g} Hz" in told["ball passes"]
    assert f"(BPFI) {13 * (75.0 - cage):.4g} Hz" in told["ball passes"]
    assert "load zone" not in run_summary(PAPER, motion, samples(speed, turns=0.02))  # too short for all angles
    assert set(run_summary(PAPER, kinematics(PAPER, 0.0), samples(speed))) == {"hub", "largest loads", "load zone"}


def test_a_motion_that_reverses_has_no_mean_slip(here, capsys):
    Path("there-and-back.csv").write_text("time_ms,speed_rpm\n0,600\n10,600\n30,-600\n40,-600\n")
    keys = ("model=lagrange", "operation.speed_table=there-and-back.csv", "name=back", "numerics.duration_ms={}")

    def told(duration):
        assert run_main([*sets(*(key.format(duration) for key in keys)), "--output", f"{duration}.nc"]) == 0
        return capsys.readouterr().out

    out = told(40)
    assert "the motion reverses: no mean slip" in out and "BPFO" not in out and "% of rolling" not in out
    assert "BPFO" in told(10)  # before it turns back
    found = read_scene(None, tuple(key.format(40) for key in keys))
    assert np.isnan(simulate(found).quantities["cage_slip"].value)
    assert np.isnan(labels(found)["BPFO_Hz"]) and np.isnan(labels(found)["speed_rpm"])
    assert check_main(["40.nc"]) == 0  # less than a turn one way: no orders
    assert "% of rolling" not in capsys.readouterr().out
    assert read_json("40-residual/summary.json")["cage_Hz"] == {"observed": None, "rolling_without_slip": None}


def test_a_plan_gives_each_raceway_its_own_largest_force(capsys):
    """At 20 000 rpm rollers' centrifugal force m R ω² loads the outer raceway alone."""
    keys = ("bearing.designation=NU206", "operation.speed_rpm=20000", "operation.radial_load_N=500", "model=reduced")
    assert run_main(["--dry-run", *sets(*keys)]) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("largest static"))
    (inner, inner_pressure), (outer, outer_pressure) = re.findall(r"([\d.]+) N \((\d+) MPa\)", row)
    bearing, inner, outer = read_scene(None, keys).ideal_bearing(), float(inner), float(outer)
    cage = kinematics(bearing, 20000.0 * tau / 60.0).cage
    grown = bearing.roller_mass * (bearing.pitch_radius * cage**2 + 9.81)
    assert outer - inner == pytest.approx(grown, abs=0.15)
    assert float(inner_pressure) == pytest.approx(line_pressure(inner, bearing.inner_raceway_radius, bearing), abs=1.0)
    assert float(outer_pressure) == pytest.approx(line_pressure(outer, -bearing.outer_raceway_radius, bearing), abs=1.0)


# What a run warns of when it is over: contacts that a shock has pressed wider than at rest
SOFT = """
bearing = { rollers = 31, roller_diameter_mm = 13.2, roller_length_mm = 20.0, inner_raceway_diameter_mm = 140.0, \
outer_raceway_diameter_mm = 166.4, bore_diameter_mm = 110.0, outside_diameter_mm = 196.0 }
material.youngs_modulus_GPa = 3.6
operation = { speed_rpm = 500.0, radial_load_N = 7756.0, inner_ring_and_shaft_kg = 30.0, gravity_m_s2 = 200.0 }
numerics = { start = "rest", load_ramp_ms = 0.0, duration_ms = 6.0, mesh_size_mm = 3.0 }
"""
WORDS = "beyond Hertz's theory and small strains (at most 0.66 mm)"


@pytest.mark.parametrize("model", ["fem", "lagrange"])
def test_contacts_too_wide_in_a_shock_are_told_in_summary_and_result_and_remembered_by_a_resumed_run(model, here):
    """The second leg, whose duration is the first one's, takes no step of its own. From equilibrium nothing is told."""
    Path("soft.toml").write_text(SOFT)
    for words in ([], ["--resume"]):
        done = command("run-fem", "soft.toml", "--model", model, "--output", "soft.nc", *words, folder=here)
        assert done.returncode == 0 and done.stdout.count(WORDS) == 1
        told = attributes("soft.nc")
        assert WORDS in told["warnings"] and told["warnings"].count("beyond Hertz") == 1
        assert told["status"] == "complete"
    if model == "fem":
        calm = sets("numerics.start=equilibrium", "operation.gravity_m_s2=9.81")
        done = command("run-fem", "soft.toml", *calm, "--output", "calm.nc", folder=here)
        assert done.returncode == 0 and "Warning" not in done.stdout and attributes("calm.nc")["warnings"] == ""


def test_limits_of_contacts_are_a_tenth_of_the_radius_by_hertz_and_an_overlap_of_own_laws():
    """Hertz: b² = 4QR/(πE*L). Balls by the ellipse in their groove, whose pressure closes the gap of the curvatures."""
    for which, pair in enumerate(contact_pairs(PAPER)):
        for factor, count in ((0.999, 0), (1.001, 1)):
            forces = np.zeros(3)
            forces[which] = factor * (0.1 * PAPER.roller_radius) ** 2 / pair.half_width_factor
            assert len(run_warnings(PAPER, forces)) == count, which
    bearing = parse_scene({"model": "lagrange", "bearing": {"designation": "6205"}}, "").ideal_bearing()
    force = 2000.0
    a, b = contact_ellipse(bearing, "inner", force)
    compliance = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / bearing.inner_ring.plane_strain_modulus
    pressure = 1.5 * force / (pi * a * b)
    ball = 1.0 / bearing.element_radius  # the long axis lies in the groove
    along, across = ball - 1.0 / bearing.inner_groove_radius, ball + 1.0 / bearing.inner_raceway_radius
    for axis, other, gap in ((a, b, along), (b, a, across)):  # Johnson, Contact Mechanics, 3.35
        integral = 2.0 / 3.0 * elliprd(0.0, other**2, axis**2)  # ∫ dw/((axis² + w)^(3/2) √((other² + w) w)), 0 to ∞
        assert pressure * a * b * compliance * integral == pytest.approx(gap, rel=1e-9)
    limit = (0.6 * bearing.element_radius / a) ** 3 * force
    assert [len(run_warnings(bearing, np.array([f * limit, 0.0, 0.0]))) for f in (0.999, 1.001)] == [0, 1]
    law = {"contact_stiffness_N_per_m_n": [2e6, 3e6], "contact_exponent": 1.0}
    plan = make_plan(parse_scene({"model": "lagrange", "lagrange": law}, ""))
    judge, limit = Judge(plan.problem, plan.time_step), 0.05 * plan.problem.bearing.roller_radius * 2e6
    assert judge.warnings(np.array([0.999 * limit, 0.0, 0.0])) == ()
    assert "overlap by 0.25 mm on the inner" in judge.warnings(np.array([1.001 * limit, limit, 0.0]))[0]


def test_the_checker_reads_whatever_a_run_goes_on_with():
    table = {"rollers": 4, "roller_diameter_mm": 3.0, "roller_length_mm": 4.4, "inner_raceway_diameter_mm": 3.3}
    table |= {"outer_raceway_diameter_mm": 9.32, "bore_diameter_mm": 2.7, "outside_diameter_mm": 12.9}
    bearing = parse_scene({"model": "lagrange", "bearing": table}, "").ideal_bearing()
    give = THROUGH * bearing.roller_radius
    off, angle = 1.999 * (bearing.radial_clearance + give), np.radians([0.0, 90.0, 180.0, 270.0])
    x, y = bearing.pitch_radius * np.cos(angle), bearing.pitch_radius * np.sin(angle) + off
    values = {"inner_x": np.zeros(1), "inner_y": np.array([off]), "roller_x": x[None], "roller_y": y[None]}
    values["roller_rho"] = np.full((1, 4), bearing.pitch_radius)
    samples = Samples(values=values, imbalance=np.zeros(1), exchanged=np.zeros(1), error=np.zeros(1))
    assert n_in_place(bearing, give, samples) == 1 and 0.2 * bearing.pitch_radius < off < farthest_place(bearing)


def test_what_kicks_give_beyond_forces_is_what_the_hub_s_balance_misses_and_is_told_where_nothing_else_is():
    """Of rollers that strike: M a − forces, from the run's own samples, is at most what it says."""
    numerics = {"start": "rest", "load_ramp_ms": 0.0, "duration_ms": 1.0, "output_interval_us": 2.0}
    tables = {"model": "reduced", "contact": {"friction_coefficient": 0.0}, "numerics": numerics}
    plan = make_plan(parse_scene(tables, ""))
    state, operation = plan.first_state(), plan.operation
    found = whole_run(plan, state)  # it restarts with shorter steps
    x, y = (found[f"roller_{axis}"] - found[f"inner_{axis}"][:, None] for axis in "xy")
    push = found["inner_force"] / np.hypot(x, y)
    across = operation.inner_mass * found["inner_ax"] + np.sum(push * x, axis=1)
    up = operation.inner_mass * (found["inner_ay"] + operation.gravity) + operation.radial_load
    missed = np.hypot(across, up + np.sum(push * y, axis=1))
    most, largest = float(state.forces.beyond[0]), float(found["inner_force"].max())
    assert 1e-3 * largest < missed.max() <= most * (1.0 + 1e-6)
    assert not any("give the hub" in note for note in state.warnings), "it says that shocks excite waves"
    state.forces.fastest[:] = 0.0
    assert f"up to {most:.3g} N more or less than the contacts' forces" in state.warnings[-1]
    state.largest[:] = 0.0
    assert not any("more or less than the contacts' forces" in note for note in state.warnings)


@pytest.mark.slow
def test_what_a_guide_s_kicks_give_the_hub_beyond_forces_is_told_too():
    """A cage of 50 g strikes the inner ring of a preloaded bearing with 380 N, and rollers hardly notice it."""
    cage = {"mass_kg": 0.05025, "guidance": "inner_ring", "guidance_clearance_mm": 0.02738, "damping_N_s_m": 0.2764,
            "pocket_clearance_mm": 0.4187, "friction_coefficient": 0.1025, "drag_torque_N_m": 0.6086,
            "stiffness_N_per_m": 2.849e8}  # fmt: skip
    operation = {"inner_ring_and_shaft_kg": 2.9256, "speed_rpm": 5963.9, "radial_load_N": 434.8, "shaft": "springs"}
    operation |= {"rotating_load_N": 196.3, "shaft_stiffness_N_per_m": 6.218e6, "shaft_damping_N_s_m": 15.74}
    support = {"kind": "housing", "mass_kg": 3.58, "stiffness_N_per_m": 3.172e7, "damping_N_s_m": 240.7}
    tables = {"cage": cage, "operation": operation, "support": support, "bearing": {"outer_raceway_diameter_mm": 55.98}}
    numerics = {"duration_ms": 5.0, "output_interval_us": 2.0}
    scene = parse_scene({"model": "reduced", "numerics": numerics, **tables}, "")
    plan = make_plan(scene)
    state = plan.first_state()
    run(plan, lambda block: None, state=state)
    budgets = [direction.budget for direction in simulate(scene).residual().directions]
    missed = np.hypot(*(budget.terms["ring_flexibility"] for budget in budgets)).max()
    most = float(state.forces.beyond[0])
    assert 0.5 * most < missed < most * (1.0 + 1e-2)


# What a plan warns of: pressures that steel does not bear, samples too seldom; told everywhere a user looks
def test_pressures_that_steel_does_not_bear_are_warned_of():
    """4000 MPa: ISO 76:2006, rollers. 628 N on a rounded edge against the roller: 4.9 GPa at 0.1 mm, 3.5 at 0.2.

    The largest preload a scene may have, 0.5 % of the roller's diameter, at 500 GPa already.
    """
    for load in (40e3, 52e3, 55e3, 70e3):
        plan = plan_of(f"operation.radial_load_N={load}")
        pressure = line_pressure(plan.start.equilibrium.inner_force.max(), 18e-3)
        assert abs(pressure - 4000.0) > 8.0  # the load is not chosen on the edge
        assert bool(plan.warnings) == (pressure > 4000.0), load
        assert all(words in told for told in plan.warnings for words in (f"{pressure:.0f} MPa", "ISO 76", "4000 MPa"))
    preload = ("bearing.outer_raceway_diameter_mm=55.951", "operation.radial_load_N=0")
    assert not plan_of(*preload).warnings
    assert "the preload" in plan_of(*preload, "material.youngs_modulus_GPa=500").warnings[0]
    force = plan_of().start.equilibrium.outer_force.max()
    edge = "spall.0.angle_deg=14", "numerics.output_interval_us=1", "damping.contact_time_us=12.5"
    for radius, warned in ((0.1, f"{line_pressure(force, 1e-4):.0f} MPa"), (0.2, None), (0.0, "")):
        found = plan_of(*edge, f"spall.0.edge_radius_mm={radius}").warnings
        assert not found if warned is None else warned in found[0], radius


def test_a_warning_is_told_wherever_a_user_looks(tmp_path, capsys):
    path = tmp_path / "run.nc"
    options = ["--mesh-size", "2", "--duration", "1", *sets("operation.radial_load_N=60000"), "--output", str(path)]
    assert run_main([*options, "--dry-run"]) == 0 and "Warning: the largest static force" in capsys.readouterr().out
    assert run_main(options) == 0
    out, error = capsys.readouterr()
    assert (out + error).lower().count("warning: the largest static force") == 1
    assert "ISO 76" in attributes(path)["warnings"] and any("ISO 76" in note for note in read_result(path).notes)
    assert check_main([str(path), "--output", str(tmp_path / "report")]) == 0 and "ISO 76" in capsys.readouterr().err
    assert any("ISO 76" in note for note in read_json(tmp_path / "report/summary.json")["notes"])


@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
def test_samples_that_miss_strikes_waves_or_the_hub_are_warned_of(model):
    """After a strike forces peak each 20 µs in runs of all three models: nine samples are 2.2 µs apart.

    The hub of the paper's bearing swings at about 13.6 kHz on its contacts: 37 µs. Order 200 on the inner ring: a wave
    of 0.57 mm passes in 110 µs, seen by two samples of 55 µs.
    """
    strike = "spall.0.angle_deg=14", "spall.0.edge_radius_mm=0.5", f"model={model}", "damping.contact_time_us=12.5"
    assert not plan_of(*strike, "numerics.output_interval_us=1.5").warnings
    told = plan_of(*strike, "numerics.output_interval_us=10").warnings[0]
    assert "[[spall]]" in told and float(told.split("at most ")[1]) == pytest.approx(2.0, rel=0.15)
    waves = "waviness.0.order={}", "waviness.0.amplitude_um=0.01", "numerics.output_interval_us=30", f"model={model}"
    assert not plan_of(*(each.format(200) for each in waves)).warnings
    (told,) = plan_of(*(each.format(400) for each in waves)).warnings
    assert "[[waviness]]" in told and "at most 27.4" in told
    for interval, warned in ((10, False), (30, False), (50, True), (1000, True)) if model == "fem" else ():
        found = plan_of(f"numerics.output_interval_us={interval}").warnings
        assert bool(found) == warned and (not warned or f"numerics.output_interval_us = {interval}" in found[0])


@pytest.mark.parametrize(("value", "sound", "words"), [
    ("bearing.clearance_um=1500", "bearing.clearance_um=90", "clearance, 1500 µm, is 17 %"),
    ("operation.radial_load_N=3", "operation.radial_load_N=0", "radial_load_N = 3 is below a thousandth"),
    ("operation.speed_rpm=60000", "operation.speed_rpm=20000", "n d_m is 2.8e+06"),  # 46.5 mm
])  # fmt: skip
def test_values_in_other_units_are_warned_of(value, sound, words):
    """C0 of NU 206 is 36.5 kN by ISO 76, C5 by ISO 5753-1 65 to 90 µm."""
    scenes = [read_scene(None, ("bearing.designation=NU206", setting)) for setting in (value, sound)]
    found, none = (of_scene(each, each.perfect_bearing(), each.ideal_operation(), 1e-6) for each in scenes)
    assert len(found) == 1 and words in found[0] and not none


@pytest.mark.parametrize("faults", [
    ("spall.0.body=outer_ring", "spall.0.width_mm=1.2", "spall.0.edge_radius_mm=0.5"),
    ("spall.0.body=roller", "spall.0.roller=3", "spall.0.edge_radius_mm=0.5"),
    ("waviness.0.order=4000", "waviness.0.amplitude_um=1e-5", "operation.speed_rpm=9000"),
])  # fmt: skip
@pytest.mark.parametrize(("bearing", "model"), [("NU204", "lagrange"), ("NU206", "reduced"), ("NU216", "lagrange")])
def test_no_warning_follows_from_the_interval_that_the_program_chooses(bearing, model, faults):
    scene = read_scene(None, (f"bearing.designation={bearing}", f"model={model}", *faults))
    assert scene.numerics.output_interval_us < 5.0
    assert not [sentence for sentence in make_plan(scene).warnings if "output_interval_us" in sentence]


@pytest.mark.parametrize("model", ["reduced", "lagrange", "fem"])
def test_a_spall_or_a_housing_without_damping_is_told_of_with_the_key(model):

    def asked(*settings):
        return [each for each in plan_of(f"model={model}", *settings).warnings if "damping.contact_time_us" in each]

    housing = 'support={kind="housing",mass_kg=12.0,stiffness_N_per_m=15e6,damping_N_s_m=0.0}'
    (told,) = asked("spall.0.edge_radius_mm=0.5", housing)
    assert "[[spall]]" in told and "housing" in told
    assert asked() == asked("spall.0.edge_radius_mm=0.5", housing, "damping.contact_time_us=2.5") == []
    if model == "fem":
        assert asked(housing) and not asked(housing, "contact.model=penalty")
        with pytest.raises(SceneError, match="leave one of them out"):
            read_scene(None, (housing, "contact.model=penalty", "damping.contact_time_us=12.5"))


@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_a_default_duration_without_a_passage_gives_the_time_of_a_turn(model):
    """At 1 rpm the cage turns with 0.5 (1 − d/D) of that, by kinematics: 60/(0.5 · 36/46) s a turn."""

    def told(*settings):
        return [sentence for sentence in plan_of(f"model={model}", *settings).warnings if "duration_ms" in sentence]

    (slow,) = told("operation.speed_rpm=1")
    turn = float(re.search(r"one turn takes ([\d.e+]+) ms", slow)[1])
    assert turn == pytest.approx(1e3 * 60.0 / (0.5 * 36 / 46), rel=5e-3)
    assert told("operation.speed_rpm=1", "numerics.duration_ms=1") == told() == told("operation.speed_rpm=0") == []


# Runs that go wrong numerically: noticed within 100 steps, good samples kept, the reason told
def failing_step(plan, state=None):
    with pytest.raises(RunFailed) as failed:
        run(plan, lambda samples: None, state=state)
    return int(re.search(r"at step (\d+), t = ", str(failed.value))[1])


def test_a_step_beyond_the_limit_and_a_value_that_is_not_a_number_are_noticed_within_100_steps():
    """One sample in 3 ms, thousands of steps. The first whose energy is out by 5 % is found by looking at every one."""
    plan = plan_of("numerics.duration_ms=60", "numerics.output_interval_us=3000")
    assert plan.stride > 40 * LONGEST_UNWATCHED and plan.stride / plan.looks <= LONGEST_UNWATCHED
    wild = replace(plan, time_step=1.05 * plan.critical_time_step)
    every_step = replace(wild, stride=1)
    rows, *_ = every_step.first_state().take_steps(4000)
    good = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    samples = SampleReader(every_step).read(rows[: good[0] if good.size else None])
    stored = samples["energy_elastic"] + samples["energy_contact"]
    first = int(np.argmax(np.abs(samples.imbalance) > 0.05 * np.maximum.accumulate(stored)))
    assert first > 0 and 0 <= failing_step(wild) - first <= 100
    for body in ("drive", "disc", "inner", "outer"):
        state = plan.first_state()
        bodies = state.arrays.bodies
        if body == "drive":
            state.arrays.drive.velocity[0] = np.nan
        elif body == "disc":
            bodies.disc.w[bodies.disc.w.size // 2] = np.nan
        else:
            ring = getattr(bodies, body)
            ring.w[ring.first_row, 0, HALO + 5] = np.nan
        assert failing_step(plan, state) <= 100, body


def test_how_samples_are_cut_into_blocks_changes_no_bit_of_them():
    plan = plan_of("numerics.duration_ms=1", "operation.speed_rpm=60000", "numerics.output_interval_us=10",
                   "operation.first_roller_deg=91")  # fmt: skip
    rows, *_ = plan.first_state().take_steps(plan.looks * 101)
    whole = SampleReader(plan).read(rows)
    assert np.ptp(whole["roller_theta"][:, 0]) > 2.0  # over ±π on the way
    for cuts in ([1, 5, 37, 90], list(range(1, 101))):
        reader = SampleReader(plan)
        parts = [reader.read(part) for part in np.split(rows, plan.looks * np.array(cuts))]
        for name in whole.values:
            assert np.array_equal(np.concatenate([part[name] for part in parts]), whole[name]), name


@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
def test_a_speed_next_to_nothing_is_planned_as_standstill(model):
    """No time is long enough to look ahead of a shaft that takes longer than the universe has lasted for a turn."""
    starts = []
    for speed in ("0.0", "1e-15", "-1e-15"):
        samples = plan_of(f"model={model}", f"operation.speed_rpm={speed}").first_state().advance(1).samples
        starts.append((samples["inner_x"][0], samples["inner_y"][0]))
    assert starts[1:] == starts[:1] * 2 and starts[0][1] < 0.0
