"""The command run-fem: what it refuses, what it writes and warns of, how it ends."""

import json
import re
from dataclasses import replace
from math import pi, sqrt, tau
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.special import elliprd

from fem.commands.run_fem import run_main
from fem.contacts.critical_step import critical_time_step
from fem.interface import simulate
from fem.kernels.elements.rings import HALO
from fem.quantities import labels, run_summary
from fem.result.store import ResultFile
from fem.runner import result_megabytes, size_warning
from fem.solver.elements.plan import LONGEST_UNWATCHED
from fem.solver.guards import n_in_place, run_warnings
from fem.solver.limits import of_scene
from fem.solver.rigid.lagrangian import Judge
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
from tests.reference.kit import command, whole_run

COARSE = ("numerics.mesh_size_mm=2", "numerics.duration_ms=1")


def test_help_has_an_example(capsys):
    run_main(["--help"])
    assert "Example: run-fem" in capsys.readouterr().out


def test_dry_run_compares_with_no_mesh_that_takes_its_time(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run_main(["--dry-run", "--model", "lagrange", "--set", "bearing.outside_diameter_mm=2000"]) == 0
    assert "nodes, too many" in capsys.readouterr().out


def test_dry_run_shows_the_plan_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run_main(["--dry-run", "--mesh-size", "2"]) == 0
    out = capsys.readouterr().out
    for word in ("degrees of freedom", "time step", "steps", "memory", "result file", "angles"):
        assert word in out
    assert not list(tmp_path.iterdir())


def test_a_large_result_file_is_announced_with_the_keys_that_make_it_smaller(tmp_path):
    """What is announced is what the file takes, but for some tens of kB of its own."""
    short, long = (
        make_plan(read_scene(None, ("model=lagrange", f"numerics.duration_ms={duration}"))) for duration in (20, 2000)
    )
    assert size_warning(short) == ()
    assert {"numerics.duration_ms", "numerics.output_interval_us"} <= set(size_warning(long)[0].split())
    with ResultFile(tmp_path / "run.nc", short, 0.0):
        assert 1e-6 * (tmp_path / "run.nc").stat().st_size == pytest.approx(result_megabytes(short), rel=0.05)


def test_static_run_prints_and_stores_the_equilibrium(tmp_path, capsys):
    """Whole bearing on resolved P2 meshes: 3.6140 µm; 628.5, 549.5, 337.2, 62.9 N (independent static solution)."""
    path = tmp_path / "static.nc"
    settings = ["operation.speed_rpm=0", "operation.gravity_m_s2=0"]
    options = [word for setting in settings for word in ("--set", setting)]
    assert run_main(["--duration", "0", "--output", str(path), *options]) == 0
    assert "Static equilibrium at rest: hub" in capsys.readouterr().out
    with h5py.File(path) as file:
        assert file["time"].shape == (1,)
        assert -1e6 * file["inner_y"][0] == pytest.approx(3.6140, rel=1e-3)
        loads = np.sort(file["inner_force"][0])[::-1][:7]
    assert loads == pytest.approx([628.5, 549.5, 549.5, 337.2, 337.2, 62.9, 62.9], rel=3e-3)


def test_an_equilibrium_says_at_what_speed_it_is(tmp_path, capsys):
    options = ["--duration", "0", "--model", "lagrange", "--output", str(tmp_path / "static.nc")]
    assert run_main([*options, "--set", "operation.speed_rpm=3000"]) == 0
    assert "Static equilibrium at 3000 rpm, with centrifugal force: hub" in capsys.readouterr().out


def test_result_file_holds_the_contract(coarse_run):
    with h5py.File(coarse_run) as file:
        assert file.attrs["status"] == "complete"
        assert file.attrs["committed_samples"] == 401 == file["time"].shape[0]
        for name, (dimensions, units, _) in columns_of("").items():
            assert file[name].attrs["units"] == units and file[name].attrs["long_name"]
            assert file[name].ndim == len(dimensions)
            assert np.all(np.isfinite(file[name][:]))
        promised = "scene program_version mesh_nodes degrees_of_freedom time_step critical_time_step steps wall_seconds"
        assert {*promised.split(), "setup_seconds"} <= set(file.attrs)
        assert file["time"][1] - file["time"][0] == pytest.approx(1e-5, rel=1e-12)


def test_result_file_opens_in_xarray_and_netcdf4(coarse_run):
    xarray = pytest.importorskip("xarray")
    netcdf = pytest.importorskip("netCDF4")
    with xarray.open_dataset(coarse_run, engine="netcdf4") as data:
        assert data["inner_force"].dims == ("time", "roller")
        assert data["inner_y"].attrs["units"] == "m"
    with netcdf.Dataset(coarse_run) as data:
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
    assert (loaded.min(), loaded.max()) == (6, 7)
    assert 620.0 < force.max() < 650.0
    cage = np.mean(angle[-1] - angle[0]) / (2.0 * np.pi * time_[-1])
    assert cage == pytest.approx(29.35, rel=0.01)
    assert np.ptp(balance) < 1e-4 * elastic  # 1 % is asked for; measured 4e-6


def test_halving_the_interval_changes_no_shared_sample(tmp_path):
    """The storage stride must not touch the trajectory when the step divides both intervals."""
    paths = []
    for interval in (10.0, 20.0):
        plan = make_plan(read_scene(None, (*COARSE, f"numerics.output_interval_us={interval}")))
        paths.append((plan, tmp_path / f"{interval}.nc"))
    assert paths[0][0].time_step == pytest.approx(paths[1][0].time_step, rel=0.03)
    fine = replace(paths[1][0], time_step=paths[0][0].time_step, stride=2 * paths[0][0].stride)
    for plan, path in ((paths[0][0], paths[0][1]), (fine, paths[1][1])):
        with ResultFile(path, plan, 0.0) as store:
            progress = run(plan, store.append)
            store.finish("complete", steps=progress.steps, wall_seconds=progress.wall)
    with h5py.File(paths[0][1]) as often, h5py.File(paths[1][1]) as seldom:
        assert np.array_equal(often["inner_y"][::2], seldom["inner_y"][:])
        assert np.array_equal(often["roller_x"][::2], seldom["roller_x"][:])


def test_a_step_beyond_the_limit_stops_the_run_and_keeps_the_good_samples(tmp_path):
    plan = make_plan(read_scene(None, COARSE))
    wild = replace(plan, time_step=1.05 * plan.critical_time_step, stride=10)
    path = tmp_path / "wild.nc"
    with ResultFile(path, wild, 0.0) as store:
        with pytest.raises(RunFailed, match=r"step \d+, t = .* ms"):
            run(wild, store.append)
        store.finish("failed: test")
    with h5py.File(path) as file:
        assert 0 < file.attrs["committed_samples"] < wild.n_samples
        assert np.all(np.isfinite(file["inner_y"][:]))
        assert np.abs(file["inner_y"][:]).max() < 1e-4


# What a run says of itself first: hub, loads, load zone, cage, ball passes


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


# What a run warns of when it is over: contacts that a shock has pressed wider than at rest


SOFT = """
[bearing]
rollers = 31
roller_diameter_mm = 13.2
roller_length_mm = 20.0
inner_raceway_diameter_mm = 140.0
outer_raceway_diameter_mm = 166.4
bore_diameter_mm = 110.0
outside_diameter_mm = 196.0
[material]
youngs_modulus_GPa = 3.6
[operation]
speed_rpm = 500.0
radial_load_N = 7756.0
inner_ring_and_shaft_kg = 30.0
gravity_m_s2 = 200.0
[numerics]
start = "rest"
load_ramp_ms = 0.0
duration_ms = 6.0
mesh_size_mm = 3.0
"""
WORDS = "beyond Hertz's theory and small strains (at most 0.66 mm)"


@pytest.fixture(scope="module")
def soft(tmp_path_factory):
    folder = tmp_path_factory.mktemp("soft")
    (folder / "soft.toml").write_text(SOFT)
    return folder


def test_contacts_too_wide_in_a_shock_are_told_in_the_summary_and_the_result_and_remembered_by_a_resumed_run(soft):
    """The second leg, whose duration is the first one's, takes no step of its own."""
    for words in ([], ["--resume"]):
        done = command("run-fem", "soft.toml", "--output", "soft.nc", *words, folder=soft)
        assert done.returncode == 0 and done.stdout.count(WORDS) == 1
        with h5py.File(soft / "soft.nc") as file:
            assert file.attrs["warnings"].count(WORDS) == 1 and file.attrs["status"] == "complete"


def test_the_same_load_from_equilibrium_is_told_nothing_of(soft):
    arguments = ["--set", "numerics.start=equilibrium", "--set", "operation.gravity_m_s2=9.81", "--output", "calm.nc"]
    done = command("run-fem", "soft.toml", *arguments, folder=soft)
    assert done.returncode == 0 and "Warning" not in done.stdout
    with h5py.File(soft / "calm.nc") as file:
        assert file.attrs["warnings"] == ""


def test_the_lagrangian_model_watches_its_largest_contact_too(soft):
    """Its law knows nothing of widths; the second leg takes no step of its own."""
    path = soft / "springs.nc"
    arguments = [str(soft / "soft.toml"), "--model", "lagrange", "--output", str(path), "--quiet"]
    for words in ([], ["--resume"]):
        assert run_main([*arguments, *words]) == 0
        with h5py.File(path) as file:
            assert WORDS in file.attrs["warnings"] and file.attrs["warnings"].count("beyond Hertz") == 1


@pytest.mark.parametrize("which", range(3))
def test_the_limit_is_a_tenth_of_the_rollers_radius_for_each_kind_of_contact(which):
    """Hertz: b² = 4QR/(πE*L)."""
    bearing = read_scene().ideal_bearing()
    pair = contact_pairs(bearing)[which]
    force = (0.1 * bearing.roller_radius) ** 2 / pair.half_width_factor
    forces = [0.0, 0.0, 0.0]
    for factor, count in ((0.999, 0), (1.001, 1)):
        forces[which] = factor * force
        assert len(run_warnings(bearing, np.array(forces))) == count


def test_balls_are_watched_by_the_ellipse_in_their_groove():
    """Hertz's pressure on the ellipse closes the gap of the curvatures, by potential theory's integrals."""
    bearing = parse_scene({"model": "lagrange", "bearing": {"designation": "6205"}}, "").ideal_bearing()
    force = 2000.0
    a, b = contact_ellipse(bearing, "inner", force)
    compliance = 1.0 / bearing.roller.plane_strain_modulus + 1.0 / bearing.inner_ring.plane_strain_modulus
    pressure = 1.5 * force / (np.pi * a * b)
    ball = 1.0 / bearing.element_radius  # the long axis lies in the groove
    along, across = ball - 1.0 / bearing.inner_groove_radius, ball + 1.0 / bearing.inner_raceway_radius
    for axis, other, of in ((a, b, along), (b, a, across)):  # Johnson, Contact Mechanics, 3.35
        integral = 2.0 / 3.0 * elliprd(0.0, other**2, axis**2)  # ∫ dw/((axis² + w)^(3/2) √((other² + w) w)), 0 to ∞
        assert pressure * a * b * compliance * integral == pytest.approx(of, rel=1e-9)
    limit = (0.6 * bearing.element_radius / a) ** 3 * force
    for factor, count in ((0.999, 0), (1.001, 1)):
        assert len(run_warnings(bearing, np.array([factor * limit, 0.0, 0.0]))) == count


def test_a_soft_law_of_ones_own_is_watched_by_its_overlaps():
    law = {"contact_stiffness_N_per_m_n": [2e6, 3e6], "contact_exponent": 1.0}
    plan = make_plan(parse_scene({"model": "lagrange", "lagrange": law}, ""))
    judge = Judge(plan.problem, plan.time_step)
    limit = 0.05 * plan.problem.bearing.roller_radius * 2e6
    assert judge.warnings(np.array([0.999 * limit, 0.0, 0.0])) == ()
    assert "overlap by 0.25 mm on the inner" in judge.warnings(np.array([1.001 * limit, limit, 0.0]))[0]


def test_the_checker_reads_whatever_a_run_goes_on_with():
    """A hub between four rollers, as far off as rigid bodies may be in one another."""
    table = {"rollers": 4, "roller_diameter_mm": 3.0, "roller_length_mm": 4.4, "inner_raceway_diameter_mm": 3.3}
    table |= {"outer_raceway_diameter_mm": 9.32, "bore_diameter_mm": 2.7, "outside_diameter_mm": 12.9}
    bearing = parse_scene({"model": "lagrange", "bearing": table}, "").ideal_bearing()
    give = THROUGH * bearing.roller_radius
    off = 1.999 * (bearing.radial_clearance + give)
    angle = np.radians([0.0, 90.0, 180.0, 270.0])
    x, y = bearing.pitch_radius * np.cos(angle), bearing.pitch_radius * np.sin(angle) + off
    values = {"inner_x": np.zeros(1), "inner_y": np.array([off]), "roller_x": x[None], "roller_y": y[None]}
    values["roller_rho"] = np.full((1, 4), bearing.pitch_radius)
    samples = Samples(values=values, imbalance=np.zeros(1), exchanged=np.zeros(1), error=np.zeros(1))
    assert n_in_place(bearing, give, samples) == 1
    assert 0.2 * bearing.pitch_radius < off < farthest_place(bearing)


def test_what_kicks_give_beyond_forces_is_what_the_hub_s_balance_misses_and_is_told_where_nothing_else_is():
    """Of rollers that strike: M a − forces, from the run's own samples, is at most what it says."""
    numerics = {"start": "rest", "load_ramp_ms": 0.0, "duration_ms": 1.0, "output_interval_us": 2.0}
    scene = parse_scene({"model": "reduced", "contact": {"friction_coefficient": 0.0}, "numerics": numerics}, "")
    plan = make_plan(scene)
    state = plan.first_state()
    found = whole_run(plan, state)  # it restarts with shorter steps
    x, y = (found[f"roller_{axis}"] - found[f"inner_{axis}"][:, None] for axis in "xy")
    push = found["inner_force"] / np.hypot(x, y)
    operation = plan.operation
    missed = np.hypot(
        operation.inner_mass * found["inner_ax"] + np.sum(push * x, axis=1),
        operation.inner_mass * (found["inner_ay"] + operation.gravity)
        + operation.radial_load
        + np.sum(push * y, axis=1),
    )
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
    tables = {
        "model": "reduced", "bearing": {"outer_raceway_diameter_mm": 55.98},
        "cage": {
            "mass_kg": 0.05025, "guidance": "inner_ring", "guidance_clearance_mm": 0.02738,
            "pocket_clearance_mm": 0.4187, "friction_coefficient": 0.1025, "drag_torque_N_m": 0.6086,
            "damping_N_s_m": 0.2764, "stiffness_N_per_m": 2.849e8,
        },
        "operation": {
            "inner_ring_and_shaft_kg": 2.9256, "speed_rpm": 5963.9, "radial_load_N": 434.8, "rotating_load_N": 196.3,
            "shaft": "springs", "shaft_stiffness_N_per_m": 6.218e6, "shaft_damping_N_s_m": 15.74,
        },
        "support": {
            "kind": "housing", "mass_kg": 3.58, "stiffness_N_per_m": 3.172e7, "damping_N_s_m": 240.7,
        },
        "numerics": {"duration_ms": 5.0, "output_interval_us": 2.0},
    }  # fmt: skip
    scene = parse_scene(tables, "")
    plan = make_plan(scene)
    state = plan.first_state()
    run(plan, lambda block: None, state=state)
    budgets = [direction.budget for direction in simulate(scene).residual().directions]
    missed = np.hypot(*(budget.terms["ring_flexibility"] for budget in budgets)).max()
    most = float(state.forces.beyond[0])
    assert 0.5 * most < missed < most * (1.0 + 1e-2)


# What a plan warns of: pressures that steel does not bear, samples too seldom; told everywhere a user looks


COARSE_WARNINGS = "numerics.mesh_size_mm=2"
ISO_76 = 4e9  # Pa, ISO 76:2006, roller bearings


def hertz_pressure(force):
    """Line contact of roller and inner raceway: p0 = sqrt(Q E* / (π R L)) (Johnson, Contact Mechanics, 1985, 4.2)."""
    modulus = 210e9 / (2.0 * (1.0 - 0.3**2))
    radius = 1.0 / (1.0 / 5e-3 + 1.0 / 18e-3)
    return sqrt(force * modulus / (pi * radius * 10e-3))


def plan_of(*settings):
    return make_plan(read_scene(None, (COARSE_WARNINGS, *settings)))


@pytest.mark.parametrize("load", [40e3, 52e3, 55e3, 70e3])
def test_a_pressure_above_the_static_rating_is_warned_of(load):
    plan = plan_of(f"operation.radial_load_N={load}")
    pressure = hertz_pressure(plan.start.equilibrium.inner_force.max())
    assert abs(pressure - ISO_76) > 0.002 * ISO_76  # the load is not chosen on the edge
    assert bool(plan.warnings) == (pressure > ISO_76)
    if plan.warnings:
        assert f"{1e-6 * pressure:.0f} MPa" in plan.warnings[0]
        assert "ISO 76" in plan.warnings[0] and "4000 MPa" in plan.warnings[0]


def test_the_largest_preload_a_scene_may_have_is_warned_of_in_stiff_bodies_only():
    """Beyond 0.5 % of the roller's diameter the scene refuses it; at 500 GPa that is too much already."""
    preload = ("bearing.outer_raceway_diameter_mm=55.951", "operation.radial_load_N=0")
    assert not plan_of(*preload).warnings
    assert "the preload" in plan_of(*preload, "material.youngs_modulus_GPa=500").warnings[0]


@pytest.mark.parametrize(("interval", "warned"), [(10.0, False), (30.0, False), (50.0, True), (1000.0, True)])
def test_samples_that_can_not_follow_the_hub_are_warned_of(interval, warned):
    """The hub of the paper's bearing swings at about 13.6 kHz on its contacts: 37 µs."""
    plan = plan_of(f"numerics.output_interval_us={interval}")
    assert bool(plan.warnings) == warned
    if warned:
        assert f"numerics.output_interval_us = {interval:g}" in plan.warnings[0]


def test_a_warning_is_told_wherever_a_user_looks(tmp_path, capsys):
    path = tmp_path / "run.nc"
    options = ["--mesh-size", "2", "--duration", "1", "--set", "operation.radial_load_N=60000", "--output", str(path)]
    assert run_main([*options, "--dry-run"]) == 0
    assert "Warning: the largest static force" in capsys.readouterr().out
    assert run_main(options) == 0
    out, error = capsys.readouterr()
    assert (out + error).lower().count("warning: the largest static force") == 1
    with h5py.File(path) as file:
        assert "ISO 76" in file.attrs["warnings"]
    assert any("ISO 76" in note for note in read_result(path).notes)
    assert check_main([str(path), "--output", str(tmp_path / "report")]) == 0
    assert "ISO 76" in capsys.readouterr().err
    summary = json.loads((tmp_path / "report" / "summary.json").read_text(encoding="utf-8"))
    assert any("ISO 76" in note for note in summary["notes"])


@pytest.mark.parametrize(("radius_mm", "warned"), [(0.1, True), (0.2, False), (0.0, True)])
def test_an_edge_that_steel_does_not_bear_is_warned_of(radius_mm, warned):
    """628 N on a rounded edge against the roller: p0 = sqrt(Q E*/(π R L)), 4.9 GPa at 0.1 mm and 3.5 at 0.2."""
    often = "numerics.output_interval_us=1", "damping.contact_time_us=12.5"
    found = plan_of("spall.0.angle_deg=14", f"spall.0.edge_radius_mm={radius_mm}", *often).warnings
    assert bool(found) == warned
    if radius_mm > 0.0 and warned:
        radius = 1.0 / (1.0 / 5e-3 + 1e3 / radius_mm)
        force = plan_of().start.equilibrium.outer_force.max()
        pressure = sqrt(force * 210e9 / (2.0 * (1.0 - 0.3**2)) / (pi * radius * 10e-3))
        assert f"{1e-6 * pressure:.0f} MPa" in found[0]


@pytest.mark.parametrize(("interval", "warned"), [(1.5, False), (10.0, True)])
@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
def test_samples_that_miss_a_strike_are_warned_of(interval, warned, model):
    """After a strike forces peak each 20 µs in runs of all three models: nine samples are 2.2 µs apart."""
    found = plan_of(
        "spall.0.angle_deg=14", "spall.0.edge_radius_mm=0.5", f"numerics.output_interval_us={interval}",
        f"model={model}", "damping.contact_time_us=12.5",
    ).warnings  # fmt: skip
    assert bool(found) == warned
    if warned:
        assert "[[spall]]" in found[0]
        assert float(found[0].split("at most ")[1]) == pytest.approx(2.0, rel=0.15)


def test_samples_that_miss_waves_are_warned_of():
    """Order 200 on the inner ring: a wave of 0.57 mm passes in 110 µs, seen by two samples of 55 µs."""
    waves = "waviness.0.order={}", "waviness.0.amplitude_um=0.01", "numerics.output_interval_us=30"
    assert not plan_of(*(each.format(200) for each in waves)).warnings
    for model in ("fem", "lagrange"):
        (found,) = plan_of(f"model={model}", *(each.format(400) for each in waves)).warnings
        assert "[[waviness]]" in found and "at most 27.4" in found


@pytest.mark.parametrize(
    ("value", "sound", "words"),
    [
        ("bearing.clearance_um=1500", "bearing.clearance_um=90", "clearance, 1500 µm, is 17 %"),
        ("operation.radial_load_N=3", "operation.radial_load_N=0", "radial_load_N = 3 is below a thousandth"),
        ("operation.speed_rpm=60000", "operation.speed_rpm=20000", "n d_m is 2.8e+06"),  # 46.5 mm
    ],
)
def test_values_in_other_units_are_warned_of(value, sound, words):
    """C0 of NU 206 is 36.5 kN by ISO 76, C5 by ISO 5753-1 65 to 90 µm."""
    found = {}
    for setting in (value, sound):
        scene = read_scene(None, ('bearing={designation="NU206"}', setting))
        found[setting] = of_scene(scene, scene.perfect_bearing(), scene.ideal_operation(), 1e-6)
    assert len(found[value]) == 1 and words in found[value][0] and not found[sound]


FAULTS = (
    ("spall.0.body=outer_ring", "spall.0.width_mm=1.2", "spall.0.edge_radius_mm=0.5"),
    ("spall.0.body=roller", "spall.0.roller=3", "spall.0.edge_radius_mm=0.5"),
    ("waviness.0.order=4000", "waviness.0.amplitude_um=1e-5", "operation.speed_rpm=9000"),
)


@pytest.mark.parametrize("faults", FAULTS)
@pytest.mark.parametrize(("bearing", "model"), [("NU204", "lagrange"), ("NU206", "reduced"), ("NU216", "lagrange")])
def test_no_warning_follows_from_the_interval_that_the_program_chooses(bearing, model, faults):
    scene = read_scene(None, (f"bearing.designation={bearing}", f"model={model}", *faults))
    assert scene.numerics.output_interval_us < 5.0
    assert not [sentence for sentence in make_plan(scene).warnings if "output_interval_us" in sentence]


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("model", ["reduced", "lagrange", "fem"])
def test_a_spall_or_a_housing_without_damping_is_told_of_with_the_key(model, damped):
    housing = "mass_kg=12.0,stiffness_N_per_m=15e6,damping_N_s_m=0.0"
    settings = [f"model={model}", "spall.0.edge_radius_mm=0.5", f'support={{kind="housing",{housing}}}']
    settings += ["damping.contact_time_us=2.5"] if damped else []
    told = [sentence for sentence in plan_of(*settings).warnings if "damping.contact_time_us" in sentence]
    assert len(told) == (0 if damped else 1)
    assert damped or ("[[spall]]" in told[0] and "housing" in told[0])
    assert not [sentence for sentence in plan_of(f"model={model}").warnings if "damping" in sentence]


@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_a_default_duration_without_a_passage_gives_the_time_of_a_turn(model):
    """At 1 rpm the cage turns with 0.5 (1 − d/D) of that, by kinematics: 60/(0.5 · 36/46) s a turn."""
    slow = (f"model={model}", "operation.speed_rpm=1")
    (told,) = [sentence for sentence in plan_of(*slow).warnings if "duration_ms" in sentence]
    assert float(re.search(r"one turn takes ([\d.e+]+) ms", told)[1]) == pytest.approx(
        1e3 * 60.0 / (0.5 * 36 / 46), rel=5e-3
    )
    for given in ((*slow, "numerics.duration_ms=1"), (f"model={model}",), (f"model={model}", "operation.speed_rpm=0")):
        assert not [sentence for sentence in plan_of(*given).warnings if "duration_ms" in sentence]


def test_damping_is_not_asked_for_where_it_would_be_refused():
    excited, takes_none = ("support.kind=housing", "support.damping_N_s_m=0"), "contact.model=penalty"
    assert [each for each in plan_of(*excited).warnings if "contact_time_us" in each]
    assert not [each for each in plan_of(*excited, takes_none).warnings if "contact_time_us" in each]
    with pytest.raises(SceneError, match="leave one of them out"):
        read_scene(None, (*excited, takes_none, "damping.contact_time_us=12.5"))


# Runs that go wrong numerically: noticed within 100 steps, good samples kept, the reason told

SELDOM = ("numerics.mesh_size_mm=2", "numerics.duration_ms=60", "numerics.output_interval_us=3000")


@pytest.fixture(scope="module")
def plan():
    """One sample in 3 ms, thousands of steps."""
    plan = make_plan(read_scene(None, SELDOM))
    assert plan.stride > 40 * LONGEST_UNWATCHED and plan.stride / plan.looks <= LONGEST_UNWATCHED
    return plan


def failing_step(plan, state=None):
    with pytest.raises(RunFailed) as failed:
        run(plan, lambda samples: None, state=state)
    return int(re.search(r"at step (\d+), t = ", str(failed.value))[1])


def test_a_step_beyond_the_limit_is_noticed_within_100_steps(plan):
    """The first step whose energy is out by 5 % is found by looking at every step."""
    wild = replace(plan, time_step=1.05 * plan.critical_time_step)
    every_step = replace(wild, stride=1)
    rows, *_ = every_step.first_state().take_steps(4000)
    good = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    samples = SampleReader(every_step).read(rows[: good[0] if good.size else None])
    stored = samples["energy_elastic"] + samples["energy_contact"]
    out = np.abs(samples.imbalance) > 0.05 * np.maximum.accumulate(stored)
    first = int(np.argmax(out))
    assert first > 0
    assert 0 <= failing_step(wild) - first <= 100


@pytest.mark.parametrize("body", ["hub", "roller", "inner ring", "outer ring"])
def test_a_value_that_is_not_a_number_is_noticed_within_100_steps(body, plan):
    state = plan.first_state()
    arrays = state.arrays
    if body == "hub":
        arrays.drive.velocity[0] = np.nan
    elif body == "roller":
        arrays.bodies.disc.w[arrays.bodies.disc.w.size // 2] = np.nan
    else:
        ring = arrays.bodies.inner if body == "inner ring" else arrays.bodies.outer
        ring.w[ring.first_row, 0, HALO + 5] = np.nan
    assert failing_step(plan, state) <= 100


def test_a_failed_run_keeps_its_good_samples_and_says_what_to_do(tmp_path, monkeypatch, capsys):
    path = tmp_path / "run.nc"
    monkeypatch.setattr("fem.solver.elements.plan.critical_time_step", lambda *given: 1.2 * critical_time_step(*given))
    options = ["--mesh-size", "2", "--duration", "5", "--output", str(path), "--checkpoint", "0"]
    assert run_main(options) == 1
    error = capsys.readouterr().err
    assert "error: failed: " in error and str(path) in error and "Traceback" not in error
    assert re.search(r"step \d+, t = \S+ ms", error) and "lower numerics.time_step_safety" in error
    with h5py.File(path) as file:
        count = file["time"].shape[0]
        assert file.attrs["committed_samples"] == count and 0 < count < 501
        assert file.attrs["status"].startswith("failed: ") and "step" in file.attrs["status"]
        assert file.attrs["steps"] == (count - 1) * round(1e-5 / file.attrs["time_step"])
        assert all(np.isfinite(variable[:]).all() for variable in file.values())
        assert np.abs(file["inner_y"][:]).max() < 1e-5


def test_how_samples_are_cut_into_blocks_changes_no_bit_of_them():
    """Blocks are cut by the wall clock; angles wrap and sums run on across them."""
    plan = make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=1", "operation.speed_rpm=60000",
                                       "numerics.output_interval_us=10",
                                       "operation.first_roller_deg=91")))  # fmt: skip
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
        plan = make_plan(
            read_scene(None, (f"model={model}", f"operation.speed_rpm={speed}", "numerics.mesh_size_mm=2"))
        )
        samples = plan.first_state().advance(1).samples
        starts.append((samples["inner_x"][0], samples["inner_y"][0]))
    assert starts[1:] == starts[:1] * 2
    assert starts[0][1] < 0.0
