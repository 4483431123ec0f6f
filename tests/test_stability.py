"""Short form of `python -m tests.stability`: random scenes end well or say why not; the critical step is tight."""

import os
import re
import time
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

import h5py
import numpy as np
import pytest
import tomli_w

import fem
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from lagrange.errors import RunFailed
from lagrange.scene.scene import SceneError, parse_scene, read_scene
from lagrange.scene.surfaces import SURFACES
from lagrange.version import VERSION
from tests.reference.kit import unchecked_copy, whole_run
from tests.stability import campaign, forked
from tests.stability.campaign import COMPLETE, FAILED, REFUSED, STOPPED, Lines, Row, ended, judged
from tests.stability.machine import RANGES, drawn, machine_scene, random_scene

SEED = 1
CHEAP = 4e6  # degrees of freedom times steps of 5 ms


@pytest.mark.parametrize("number", [*range(9), *(pytest.param(n, marks=pytest.mark.slow) for n in range(9, 12))])
def test_a_random_scene_ends_well_or_says_why_not(number, tmp_path):
    row = ended(random_scene(SEED, number, duration_ms=1.0, budget=CHEAP), tmp_path)
    assert row.ending != FAILED, row.what


def is_scene(read, *given):
    try:
        return bool(read(*given))
    except SceneError:
        return False


def test_random_scenes_fill_their_ranges_are_the_same_again_and_most_are_no_contradiction():
    scenes = [random_scene(SEED, number, duration_ms=1.0) for number in range(200)]
    assert sum(is_scene(parse_scene, scene, "scene") for scene in scenes) > 150
    rollers, safety, speeds = (
        np.array([scene[table][key] for scene in scenes])
        for table, key in (("bearing", "rollers"), ("numerics", "time_step_safety"), ("operation", "speed_rpm"))
    )
    assert min(rollers) <= 6 and max(rollers) >= 57 and min(safety) < 0.35 and max(safety) > 0.95
    assert min(speeds) < -20_000.0 and 20_000.0 < max(speeds) and max(abs(speeds)) <= RANGES["speed_rpm"][1]
    assert random_scene(3, 7, 1.0) == random_scene(3, 7, 1.0) != random_scene(3, 8, 1.0)


def test_random_machines_have_all_that_stands_around_a_bearing_and_most_are_no_contradiction(tmp_path):
    found, refused, sets = set[str](), 0, 60
    for number in range(sets):
        tables = machine_scene(SEED, number, tmp_path, sets)
        (tmp_path / "scene.toml").write_text(tomli_w.dumps(tables), encoding="utf-8")
        found |= {key for name in ("bearing", "operation", "lagrange") for key in tables.get(name, {})} | tables.keys()
        found |= {f"{table['body']} {name}" for name in SURFACES for table in tables.get(name, ()) if "body" in table}
        refused += not is_scene(read_scene, tmp_path / "scene.toml")
    assert refused < 0.25 * sets
    wanted = "cage support sensor damping fit axial missing_rollers contact_angle_deg contact_exponent law_table type"
    wanted += " outer_ring_speed_rpm outer_ring_speed_table speed_table load_table unbalance_g_mm misalignment_mrad"
    assert {*wanted.split(), "unequal_roller", "profile", "roller spall", "inner_ring spall"} <= found


def endless():
    for _ in count():
        pass


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
def test_a_campaign_gives_a_command_so_much_processor_time_whatever_else_the_machine_does(tmp_path):
    """One that waits, as on a busy machine, comes to its end; one that works on beyond its limit does not."""
    assert forked.run(time.sleep, 1.5, limit=1.0).code == 0
    assert forked.run(endless, limit=1.0).code is None
    unsound = partial(drawn, SEED, True, 1)
    assert [row.ending for row in campaign.campaign(unsound, [11], Lines(None))] == [REFUSED]
    assert forked.run(forked.run_fem, ["--version"], tmp_path, limit=5.0)[:2] == (0, f"{VERSION}\n")


UNSOUND = random_scene(SEED, 0, 1.0)
UNSOUND["bearing"]["rollers"] = 200
FLYING = {  # nothing is stored until the hub meets a roller, 0.1 mm below; then as much as it brings, at once
    "bearing": {"rollers": 5, "outer_raceway_diameter_mm": 56.2},
    "operation": {"speed_rpm": 0.0, "radial_load_N": 100.0, "inner_ring_and_shaft_kg": 0.05},
    "numerics": {"start": "rest", "load_ramp_ms": 0.0, "mesh_size_mm": 2.2, "duration_ms": 1.0,
                 "output_interval_us": 10.0},
}  # fmt: skip


@pytest.mark.parametrize(("scene", "ending", "what"), [
    (UNSOUND, REFUSED, ""), (FLYING, COMPLETE, ""),
    # five rollers without a cage and without friction gather on one side, and the hub falls out
    (random_scene(SEED, 364, duration_ms=4.0), STOPPED, "come apart at step"),
    # seven soft rollers whose contacts are too wide for Hertz: pressure points carry no equilibrium
    (random_scene(SEED, 305, duration_ms=5.0), REFUSED, "half-width 0.513 mm, beyond Hertz's theory (at most 0.414 mm"),
], ids=["unsound", "hub in free flight", "comes apart", "wider than its points"])  # fmt: skip
def test_a_scene_ends_as_it_must(scene, ending, what, tmp_path):
    row = ended(scene, tmp_path)
    assert row.ending == ending and what in row.what, row.what
    assert scene is not FLYING or row.imbalance < 5e-4  # measured 2.5e-4: two steps from touch to 300 N


def raised(values):
    values[-1] += 0.015 * values.max()  # by 1.1 % of the exchanged energy


def moved(distance):
    return lambda values: values[-1:].__imul__(1.0 + distance / 0.023)  # of the pitch radius


@pytest.mark.parametrize(("names", "change", "fault"), [
    (("energy_contact",), raised, "energy imbalance "),
    (("roller_x", "roller_y"), moved(1e-3), "a roller is in the outer ring"),
    (("roller_x", "roller_y"), moved(-1e-3), "a roller is in the inner ring"),
    (("inner_y",), lambda values: values.__isub__(2e-3), "the hub has left the bearing"),
    (("inner_x",), lambda values: values.fill(np.nan), "the checker refuses it: "),
    (("roller_roller_force",), lambda values: values.fill(np.nan), "roller_roller_force is not finite"),
], ids=["energy", "outer ring", "inner ring", "hub", "not finite", "not finite nor checked"])  # fmt: skip
def test_what_a_run_has_not_said_itself_is_found(names, change, fault, coarse_run, tmp_path):
    path = unchecked_copy(coarse_run, tmp_path / "run.nc")
    assert judged(path)[0] == []
    with h5py.File(path, "r+") as file:
        for name in names:
            values = file[name][:]
            change(values)
            file[name][:] = values
    assert any(each.startswith(fault) for each in judged(path)[0]), judged(path)


def test_the_file_of_a_campaign_has_a_line_a_scene(tmp_path):
    rows = [Row(number, "fem", FAILED, "a, b", 1e-3) for number in range(3)]
    for row in rows:
        Lines(tmp_path / "sub" / "out.csv").add(*row)
    lines = Lines(tmp_path / "sub" / "out.csv")
    assert list(map(Row.read, lines.rows)) == rows
    assert list(campaign.campaign(None, range(3), lines)) == rows  # none is run again


def at_ratio(tables, ratio):
    """A plan whose time step is a ratio of the critical one, of 3 ms or a little less."""
    plan = make_plan(parse_scene(tables, "scene"))
    steps, stride = int(3e-3 / plan.critical_time_step), 50
    return replace(plan, time_step=ratio * plan.critical_time_step, stride=stride, n_samples=1 + steps // stride)


COARSE = {"numerics": {"mesh_size_mm": 2.0}}
FEW = COARSE | {
    "bearing": {"rollers": 5, "roller_diameter_mm": 20.0, "roller_length_mm": 20.0, "inner_raceway_diameter_mm": 30.0,
                "outer_raceway_diameter_mm": 69.98, "bore_diameter_mm": 15.0, "outside_diameter_mm": 90.0},
    "operation": {"speed_rpm": -12_000.0, "radial_load_N": 15_000.0, "inner_ring_and_shaft_kg": 0.5},
    "cage": {"kind": "none"}, "contact": {"friction_coefficient": 0.3},
}  # fmt: skip


@pytest.mark.parametrize("tables", [
    pytest.param(COARSE, id="paper"), pytest.param(FEW, id="5 rollers, preload, 15 kN", marks=pytest.mark.slow),
    pytest.param(random_scene(1, 13, 3.0), id="random", marks=pytest.mark.slow),
])  # fmt: skip
def test_the_critical_step_is_below_the_true_limit_by_less_than_15_percent(tables):
    found = whole_run(at_ratio(tables, 1.0))
    assert np.abs(found.imbalance).max() < 1e-2 * (found["energy_elastic"] + found["energy_contact"]).max()
    with pytest.raises(RunFailed):
        whole_run(at_ratio(tables, 1.15))


@pytest.mark.parametrize("ratio", [1.04, 1.05, 1.06])
def test_no_sample_of_a_run_that_blows_up_is_handed_on(ratio):
    """A growing mode balances its energy: the elastic one goes to infinity, the kinetic one to minus infinity."""
    blocks: list[Samples] = []
    with pytest.raises(RunFailed, match="at step"):
        run(at_ratio(COARSE, ratio), blocks.append)
    found = Samples.joined(blocks)
    stored = found["energy_elastic"] + found["energy_contact"]
    assert found["energy_kinetic"].min() > 0.0
    assert stored.max() < 1.05 * stored[0]


def test_sticking_contacts_only_dissipate_where_patches_of_neighbours_overlap():
    """A ring of 40 nodes under 13 rollers, 10 rpm, whose contacts share nodes."""
    scene = "numerics.mesh_size_mm=3 operation.speed_rpm=10 contact.friction_coefficient=0.3 numerics.duration_ms=20"
    found = whole_run(make_plan(read_scene(None, scene.split())))
    assert np.all(np.diff(found["work_dissipated"]) >= 0.0)  # else 251 samples gain, 0.02 µJ at most
    assert np.abs(found["inner_traction"][-500:]).max(axis=1).mean() < 6.0  # N; 4.4, else 9.9


def test_what_the_judge_takes_as_told_is_what_runs_tell():
    source = " ".join(path.read_text(encoding="utf-8") for path in Path(fem.__file__).parent.rglob("*.py"))
    says = re.findall(r" says\(([^)]+)\)", Path(campaign.__file__).read_text(encoding="utf-8"))
    phrases = [phrase for call in says for phrase in re.findall(r'"([^"]+)"', call)]
    assert len(phrases) == 4 and all(phrase in source for phrase in phrases) and "gives the hub up to {" in source
