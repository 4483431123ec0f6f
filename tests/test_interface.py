"""The Python interface: the same bits as the commands, in any thread, without files; what it refuses."""

from concurrent.futures import ThreadPoolExecutor
from math import pi, tau

import h5py
import numpy as np
import pytest

from fem import interface
from fem.commands.run_fem import run_main
from fem.interface import Scene, SceneError, UsageError, open_result, read_scene, simulate
from fem.quantities import OF_RUN, Quantity
from fem.result.store import variables_of
from fem.solver.elements.plan import model_of
from fem.solver.simulate import make_plan

SHORT = {"numerics.duration_ms": 1.0}
SPALL = {"spall.0.body": "outer_ring", "spall.0.width_mm": 2.0}


def lagrangian(**changes):
    return Scene(model="lagrange").varied(SHORT | changes)


@pytest.mark.parametrize("changes", [{"model": "lagrange"} | SPALL, {"model": "fem", "numerics.mesh_size_mm": 2.0}])
def test_a_result_saves_the_file_that_run_fem_writes(changes, tmp_path):
    scene = read_scene().varied(SHORT | changes)
    toml, ours, theirs = tmp_path / "scene.toml", tmp_path / "ours.nc", tmp_path / "theirs.nc"
    toml.write_text(scene.to_toml())
    assert run_main([str(toml), "--quiet", "--output", str(theirs)]) == 0
    result = simulate(scene)
    result.save(ours)
    with h5py.File(ours) as mine, h5py.File(theirs) as command:
        for name in variables_of(scene):
            assert mine[name][:].tobytes() == command[name][:].tobytes() == result[name].tobytes(), name
        assert set(mine) == set(command)
        for name in set(command.attrs) - {"wall_seconds", "setup_seconds"}:
            assert np.array_equal(mine.attrs[name], command.attrs[name]), name
        for name in mine.get("events", ()):
            assert np.array_equal(mine["events"][name][:], command["events"][name][:]), name


def test_a_stored_run_opens_as_the_result_that_simulate_gives(tmp_path):
    result = simulate(read_scene().varied(SHORT | {"model": "lagrange"} | SPALL))
    again = open_result(result.save(tmp_path / "run.nc"))
    assert again.scene == result.scene and again.status == "complete" and again.warnings == result.warnings
    assert set(again.values) == set(result.values)
    for name in (*again.values, "inner_peak_pressure", "outer_half_width"):
        assert again[name].tobytes() == result[name].tobytes(), name
    assert again.quantities == result.quantities and again.events == result.events and again.labels == result.labels
    assert again.residual().y.error.rms == result.residual().y.error.rms
    assert again.save(tmp_path / "copy.nc").read_bytes() == (tmp_path / "run.nc").read_bytes()


def test_what_is_no_stored_run_is_refused(tmp_path):
    for content in (None, b"name = 1", b"\x89HDF\r\n\x1a\n"):
        if content is not None:
            (tmp_path / "run.nc").write_bytes(content)
        with pytest.raises(UsageError, match=r"run\.nc: "):
            open_result(tmp_path / "run.nc")


def test_kinematic_frequencies_of_a_standard_bearing_are_harris():
    found, shaft, ratio = interface.frequencies("NU206", 2900.0), 2900.0 / 60.0, 9.0 / 46.5
    expected = {"FTF": 0.5 * (1.0 - ratio), "BSF": 0.5 / ratio * (1.0 - ratio**2), "BPFO": 6.5 * (1.0 - ratio),
                "BPFI": 6.5 * (1.0 + ratio)}  # fmt: skip
    shares = {name: frequency / shaft for name, frequency in found.items()}
    assert shares == pytest.approx(expected, rel=2e-3)  # the clearance widens the pitch circle
    with pytest.raises(SceneError, match="XY17"):
        interface.frequencies("XY17", 2900.0)


def test_pressures_are_hertzs_of_the_forces_and_quantities_their_largest():
    """The paper's roller: E* = 115 385 MPa, 1/R = 1/18 + 1/5 mm, L = 10 mm (Johnson, 1985, (4.43) to (4.45))."""
    result = simulate(lagrangian())
    force, radius, modulus, length = result["inner_force"], 1.0 / (1.0 / 18e-3 + 1.0 / 5e-3), 210e9 / 0.91 / 2.0, 10e-3
    pressure = np.sqrt(force * modulus / (pi * radius * length))
    np.testing.assert_allclose(result["inner_peak_pressure"], pressure, rtol=1e-12)
    half_width = 2.0 * force / (pi * length * np.maximum(pressure, 1.0))
    np.testing.assert_allclose(result["inner_half_width"], half_width, rtol=1e-12)
    largest = result.quantities["largest_inner_pressure"]
    assert (largest.value, largest.unit) == (pytest.approx(pressure.max(), rel=1e-12), "Pa")
    outer = result.quantities["largest_outer_pressure"].value
    assert outer == pytest.approx(result["outer_peak_pressure"].max(), rel=1e-12) and outer < largest.value
    assert result.quantities["largest_outer_half_width"].value == result["outer_half_width"].max()


def test_balls_have_no_pressures_of_line_contacts_and_no_finite_elements():
    with pytest.raises(UsageError, match="cylindrical rollers only"):
        simulate(Scene(model="fem", bearing={"type": "ball"}))
    result = simulate(Scene(model="lagrange", bearing={"type": "ball"}).varied(SHORT))
    with pytest.raises(KeyError, match="inner_peak_pressure: no variable of this run"):
        result["inner_peak_pressure"]
    assert np.isnan(result.quantities["largest_inner_pressure"].value)


def test_runs_of_threads_do_not_disturb_each_other():
    scenes = [lagrangian(**{"operation.radial_load_N": load}) for load in (500.0, 1000.0, 1500.0, 2000.0)]
    alone = [simulate(scene)["inner_y"].tobytes() for scene in scenes]
    with ThreadPoolExecutor(len(scenes)) as threads:
        assert list(threads.map(lambda scene: simulate(scene)["inner_y"].tobytes(), scenes)) == alone


def test_a_stopped_run_says_so_keeps_its_samples_and_becomes_an_xarray_with_units():
    seen = []
    result = simulate(lagrangian(), progress=seen.append, stop=lambda: len(seen) == 2)
    assert result.status == "interrupted" and len(result.time) == seen[-1].samples < result.plan.n_samples
    found = result.to_xarray()
    assert found["inner_force"].dims == ("time", "roller") and found["inner_force"].attrs["units"] == "N"
    assert float(found["inner_y"].sel(time=0.0)) == result["inner_y"][0]


def test_labels_name_the_first_spall_and_the_lines_and_quantities_are_those_that_their_tables_name():
    result = simulate(lagrangian(**{"numerics.duration_ms": 2.0}))
    assert result.labels["spall_body"] == "none" and set(result.quantities) == set(OF_RUN)
    found = {each.name: each.value for each in interface.check_quantities(result.residual())}
    assert set(found) == set(interface.OF_CHECK) and found["error_rms_y"] < 0.02
    turned = simulate(lagrangian(**{"numerics.duration_ms": 40.0}))  # the rollers more than once, without a cage
    assert np.isnan(turned.quantities["cage_slip"].value)
    result = simulate(lagrangian(**SPALL))
    assert result.labels["spall_body"] == "outer_ring" and result.labels["spall_width_mm"] == 2.0
    assert result.labels["BPFO_Hz"] == pytest.approx(13 * 75.0 * 18.0 / 46.0)


@pytest.mark.parametrize(("changes", "told"), [
    ({"operation.spede_rpm": 1.0}, "did you mean speed_rpm"), ({"bearing.rollers": 2}, "bearing.rollers = 2"),
    ({"operation": 1.0}, "must be a table"), ({"spall.3.width_mm": 1.0}, "none of 0 tables"),
    ({"profile.0.file": "race.csv"}, "can't be varied"),
])  # fmt: skip
def test_an_unusable_variation_is_refused_by_its_key(changes, told):
    with pytest.raises(SceneError, match=told):
        Scene().varied(changes)


def test_a_scene_that_follows_takes_the_last_one_s_mesh_and_gets_the_same_bits():
    coarse = read_scene().varied({"numerics.mesh_size_mm": 2.0, "numerics.duration_ms": 0.0})
    lighter = coarse.varied({"operation.radial_load_N": 1000.0, "operation.speed_rpm": 3000.0})
    first, after = make_plan(coarse), make_plan(lighter)
    assert after.model.roller is first.model.roller and model_of(coarse.varied(SPALL)).bearing.faults
    make_plan(coarse.varied({"numerics.mesh_size_mm": 2.5}))
    alone = make_plan(lighter)
    assert alone.model.roller is not first.model.roller and alone.critical_time_step == after.critical_time_step
    for name in ("hub", "rho", "inner_force", "outer_force", "inner_ring", "outer_ring", "rollers"):
        mine, other = (getattr(plan.start.equilibrium, name) for plan in (after, alone))
        assert mine.tobytes() == other.tobytes(), name


@pytest.mark.parametrize(("unit", "value", "told"), [
    ("m", -1.537e-5, "what: -15.37 µm"), ("rad/s", tau, "what: 1 Hz"), ("m/s2", 19.6133, "what: 2 g"),
    ("N/m", 2.5e8, "what: 250 N/µm"), ("rad", pi, "what: 180 °"), ("1", 0.25, "what: 0.25"), ("N", 3.0, "what: 3 N"),
])  # fmt: skip
def test_a_quantity_prints_in_words_and_in_the_unit_that_engineers_read(unit, value, told):
    assert str(Quantity("q", unit, "what", value)) == told
