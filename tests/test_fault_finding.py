"""Spalls found from trajectories alone: the parts against known geometry, and whole searches of short runs."""

import json
from dataclasses import replace
from math import radians

import numpy as np
import pytest

from fem.solver.simulate import make_plan, run
from lagrange.closing import sinkage
from lagrange.faults import Spall
from lagrange.scene import Scene, read_scene
from residual.cli import main
from residual.errors import InputError
from residual.fault_finding import find_faults
from residual.fault_tables import search_sentences, told_angle, unseen
from residual.passages import Response, edge_sinkage, passages
from residual.record import Record
from residual.roller_motion import Place, roller_motion, stiffness
from residual.sinkage_maps import SinkageMap
from tests.reference.synthetic_run import make_run, write_result

RINGS = {"bore": (28e-3, -1.0), "outside": (18e-3, 1.0)}
OUTER = Place(body="outer_ring", roller=None, radius=28e-3)


def recorded(*settings, noise=0.0, milliseconds=50):
    """Record of a run of the reduced model: trajectories only, by its own integration of the rollers' spins."""
    scene = read_scene(None, ("model=reduced", f"numerics.duration_ms={milliseconds}", *settings))
    blocks = []
    run(make_plan(scene), blocks.append)
    names = ("time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_spin")
    values = {name: np.concatenate([block[name] for block in blocks]) for name in names}
    steps = 0.5 * np.diff(values["time"])[:, None] * (values["roller_spin"][1:] + values.pop("roller_spin")[:-1])
    values["roller_turn"] = np.concatenate([np.zeros((1, steps.shape[1])), steps.cumsum(axis=0)])
    rng = np.random.default_rng(5)
    for name in ("inner_x", "inner_y", "roller_x", "roller_y"):
        values[name] = values[name] + noise * rng.standard_normal(values[name].shape)
    return Record(name="run", source="run.nc", scene=scene, **values)


@pytest.mark.parametrize("meeting", RINGS)
@pytest.mark.parametrize("width", [0.3e-3, 1e-3, 3e-3])
def test_a_roller_sinks_over_an_edge_as_the_closed_profile_says(meeting, width):
    """`lagrange.closing` takes the circle's closing of the profile point by point; the search has a closed form."""
    own, sign = RINGS[meeting]
    spall = Spall(body="outer_ring", roller=None, angle=0.0, width=width, depth=1e-3, edge_radius=1e-4)
    along = np.linspace(0.0, spall.half_opening(5e-3), 50)
    expected = sinkage(spall, 5e-3, own, 5e-3, meeting, along / own)
    found = edge_sinkage(spall.half_opening(5e-3) - along, 5e-3, own, sign)
    np.testing.assert_allclose(found, expected, rtol=0.03, atol=0.01 * expected.max())


def test_a_roller_without_load_leaves_its_circle_over_a_wide_spall_as_it_flies():
    """Straight on from the edge: s²/(2ρ) from the circle, less gravity's 1 %, within 0.02 mm of the way."""
    record = recorded("bearing.outer_raceway_diameter_mm=56.2", milliseconds=2)
    motion = roller_motion(record)
    top = int(np.argmin(np.abs(np.mod(motion.outer_angle[100], 2.0 * np.pi) - 0.5 * np.pi)))
    edge = motion.outer_angle[100, top]
    chosen = passages(motion, OUTER, edge, 1e-3, 1)
    middle = edge + 1.5e-3 / OUTER.radius
    path = Response(motion, chosen, stiffness(motion, "harris")).paths(np.array([[middle, 3e-3, 1e-3]]))[0, 0]
    at = chosen.first[0] + np.arange(path.size)
    beyond = at > 103
    way = motion.rho[100, top] * (motion.outer_angle[at[beyond], top] - edge)
    slope, late = np.polyfit(way, np.sqrt(2.0 * 23e-3 * (path[beyond] - path[at == 100])), 1)
    assert slope == pytest.approx(np.sqrt(1.0 - 9.81 / 782.0), rel=0.01)
    assert abs(late) < 2e-5


@pytest.mark.parametrize(
    ("body", "angle", "settings"),
    [
        ("outer_ring", 20.0, ("spall.0.width_mm=0.6",)),
        ("inner_ring", -75.0, ("spall.0.width_mm=0.6",)),
        ("roller", 140.0, ("spall.0.width_mm=0.8", "spall.0.roller=4")),
    ],
)
def test_a_spall_is_found_in_noise_on_its_own_body(body, angle, settings):
    """Within what docs/fault_finding.md states of random runs: 1° and 10 % of the width."""
    record = recorded(*settings, f"spall.0.body={body}", f"spall.0.angle_deg={angle}", noise=10e-9, milliseconds=60)
    found = find_faults(record).found
    (spall,) = record.bearing.faults
    assert (found.place.body, found.place.roller) == (spall.body, spall.roller)
    assert told_angle(found.place, found.angle) == pytest.approx(angle, abs=1.0)
    assert found.width == pytest.approx(spall.width, rel=0.1)
    assert abs(told_angle(found.place, found.angle) - angle) < 1.5 * np.degrees(found.angle_error)
    assert abs(found.width - spall.width) < 1.5 * found.width_error


@pytest.mark.parametrize(
    "settings",
    [
        (),
        ("waviness.0.order=16", "waviness.0.amplitude_um=0.8"),
        ("waviness.0.body=roller", "waviness.0.roller=2", "waviness.0.order=5", "unequal_roller.0.roller=7"),
    ],
    ids=["perfect", "wavy ring", "wavy and unequal rollers"],
)
def test_surfaces_without_a_spall_have_none(settings):
    search = find_faults(recorded(*settings, noise=10e-9, milliseconds=40))
    assert search.found is None
    assert "No spall found" in search_sentences(search)[0]


def test_the_search_sees_neither_the_scenes_surfaces_nor_forces():
    """What it finds is the same to the last digit with the scene's tables and forces as without and with wrong ones."""
    told = recorded("spall.0.width_mm=0.5", "spall.0.angle_deg=10", milliseconds=30)
    plain = read_scene(None, ("model=reduced", "numerics.duration_ms=30"))
    wrong = read_scene(None, ("model=reduced", "numerics.duration_ms=30", "spall.0.body=inner_ring"))
    forces = np.full_like(told.roller_x, 1e3)
    searches = [
        find_faults(record)
        for record in (
            told,
            replace(told, scene=plain),
            replace(told, scene=wrong, inner_force=forces, outer_force=forces, attributes={"faults": "[]"}),
        )
    ]
    first = searches[0].found
    for search in searches[1:]:
        np.testing.assert_array_equal(search.found.spall, first.spall)
        assert (search.found.angle_error, search.found.width_error) == (first.angle_error, first.width_error)
    assert roller_motion(told).bearing == roller_motion(replace(told, scene=plain)).bearing


def test_rollers_of_a_table_turn_as_they_roll_on_the_outer_raceway():
    record = recorded(milliseconds=10)
    rolled = roller_motion(replace(record, roller_turn=None)).roller_turn
    np.testing.assert_allclose(rolled, record.roller_turn, atol=2e-3)


def test_only_the_deepest_place_of_a_map_that_stands_out_of_the_rest_does():
    angle = 2.0 * np.pi * (np.arange(3000) + 0.5) / 3000
    waves = SinkageMap(place=OUTER, height=1e-6 * np.cos(40 * angle), rested=False)
    assert waves.deepest[1] == pytest.approx(1.0, rel=0.01)
    height = waves.height.copy()
    height[1200:1210] = 8e-6
    where, ratio = replace(waves, height=height).deepest
    assert ratio == pytest.approx(8.0, rel=0.01) and where == pytest.approx(angle[1200], abs=0.01)


def test_arcs_that_were_not_seen_are_told_as_scenes_count_angles():
    """Of a ring from the load's direction: NaN from +x to +y is 90° to 180°; across ±180° it is cut in two."""
    height = np.zeros(360)
    height[:90] = np.nan
    assert unseen(SinkageMap(place=OUTER, height=height, rested=False)) == [(90.0, 180.0)]
    across = np.roll(height, 45)
    arcs = unseen(SinkageMap(place=OUTER, height=across, rested=False))
    assert arcs == [(-180.0, -135.0), (135.0, 180.0)]
    roller = Place(body="roller", roller=3, radius=5e-3)
    assert unseen(SinkageMap(place=roller, height=height, rested=False)) == [(0.0, 90.0)]
    assert told_angle(OUTER, radians(-90.0)) == pytest.approx(0.0)


def test_a_standing_bearing_and_one_sampled_too_coarsely_are_refused():
    record = recorded(milliseconds=5)
    standing = record.scene.model_copy(
        update={"operation": record.scene.operation.model_copy(update={"speed_rpm": 0.0})}
    )
    with pytest.raises(InputError, match="the bearing stands"):
        find_faults(replace(record, scene=standing))
    coarse = replace(record.samples(slice(None, None, 10)), roller_turn=None)
    with pytest.raises(InputError, match=r"mm from sample to sample.*store more often"):
        find_faults(coarse)


@pytest.mark.usefixtures("plain_report")
def test_the_command_prints_and_writes_what_it_found(tmp_path, capsys):
    """A made-up run whose rollers jump by 5 µm at one place of the outer ring, up and down again."""
    made = make_run(n_times=4001, scene=Scene())
    angle = np.arctan2(made.roller_y, made.roller_x)
    deeper = 5e-6 * np.exp(-(((angle + 1.2) * 28e-3 / 0.3e-3) ** 2))
    run_ = replace(
        made, roller_x=made.roller_x + deeper * np.cos(angle), roller_y=made.roller_y + deeper * np.sin(angle)
    )
    path = write_result(tmp_path / "run.nc", run_)
    assert main([str(path), "--find-faults"]) == 0
    assert "Found a spall on the outer ring" in capsys.readouterr().out
    folder = tmp_path / "run-residual"
    spall = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["fault_search"]["spall"]
    assert (spall["body"], spall["roller"]) == ("outer_ring", None)
    assert spall["angle_deg"] == pytest.approx(90.0 - np.degrees(1.2), abs=1.0)
    assert '<h2 id="spalls">' in (folder / "report.html").read_text(encoding="utf-8")
    assert (folder / "fault_search.png").stat().st_size > 10_000
    assert main([str(path), "--quiet"]) == 0
    assert json.loads((folder / "summary.json").read_text(encoding="utf-8"))["fault_search"] is None
