"""Fields of a run: stored in its file where the scene asks for them, or recovered from it."""

from dataclasses import replace
from math import pi

import h5py
import numpy as np
import pytest
import xarray

from fem.commands.run_fem import run_main
from fem.contacts.points import patch
from fem.elastic.bodies import turned
from fem.kernels.law import ripple_at
from fem.pictures.recover import StoredRun
from fem.result.run_file import GROUP
from fem.result.store import ResultFile
from fem.solver.elements.arrays import frame_of, rolling_motion, rotated
from fem.solver.simulate import make_plan, run
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from lagrange.errors import UsageError
from lagrange.scene.scene import read_scene
from tests.reference.kit import read_instant, sets, unchecked_copy

OPTIONS = ["--mesh-size", "2", "--quiet"]
EVERY = sets("output.fields_every_ms=0.5")


@pytest.fixture(scope="module")
def with_fields(tmp_path_factory):
    path = tmp_path_factory.mktemp("fields") / "fields.nc"
    assert run_main([*OPTIONS, *EVERY, "--duration", "4", "--output", str(path)]) == 0
    return path


def changed(path, folder, change):
    path = unchecked_copy(path, folder / "copy.nc")
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def test_frames_are_at_samples_asked_for_take_the_room_announced_and_change_nothing(with_fields, coarse_run, capsys):
    with h5py.File(with_fields) as file, h5py.File(coarse_run) as plain:
        group = file[GROUP]
        assert group["sample"][:].tolist() == list(range(0, 401, 50))
        assert group["time"][:] == pytest.approx(0.5e-3 * np.arange(9), rel=1e-12)
        assert file["time"][group["sample"][:]] == pytest.approx(group["time"][:], rel=1e-12)
        assert GROUP not in plain
        for name in ("inner_x", "inner_y", "roller_x", "inner_force", "energy_elastic"):
            assert np.array_equal(file[name][:], plain[name][:])
        nodes = 13 * len(group["roller_points"]) + len(group["inner_ring_points"]) + len(group["outer_ring_points"])
    per_frame = (with_fields.stat().st_size - coarse_run.stat().st_size) / 9
    assert per_frame < 40.0 * nodes  # 20 bytes of numbers a node, and the file's own structure on a mesh this small
    with xarray.open_dataset(with_fields, group=GROUP, engine="netcdf4", decode_times=False) as fields:
        assert fields["roller_displacement"].dims == ("time", "roller", "roller_node", "component")
        assert fields["outer_ring_stress"].dims == ("time", "outer_ring_node", "stress_component")
        assert fields["inner_ring_displacement"].attrs["units"] == "m"
    assert run_main(["--mesh-size", "2", "--duration", "4", "--dry-run", *EVERY]) == 0
    assert "9, one every 0.5 ms, 0.151 MB" in capsys.readouterr().out


def test_stored_fields_have_the_runs_elastic_energy_and_recovered_ones_but_for_waves(with_fields, coarse_run):
    run, plain = StoredRun(with_fields), StoredRun(coarse_run)
    for sample in (0, 100, 150, 250, 400):
        stored, recovered = run.instant(sample), plain.instant(sample)
        assert stored.stored and not recovered.stored
        assert stored.elastic_energy == pytest.approx(stored.stored_elastic_energy, rel=1e-6), sample
        assert recovered.elastic_energy == pytest.approx(recovered.stored_elastic_energy, rel=1e-4), sample
        assert recovered.roller_turn == pytest.approx(stored.roller_turn, abs=1e-5)
        for name in ("rollers", "inner_ring", "outer_ring") if sample in (150, 400) else ():
            expected = getattr(stored, name)
            assert getattr(recovered, name) == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


def test_stored_stress_and_displacement_belong_together_in_the_fixed_axes(with_fields):
    instant = StoredRun(with_fields).instant(250)
    disc, j = instant.model.roller, int(instant.inner_force.argmax())
    local = (disc.stress @ instant.rollers[j].ravel()).reshape(-1, 3)
    with h5py.File(with_fields) as file:
        group = file[GROUP]
        stored = group["roller_stress"][5, j]
        k = int(file["inner_force"][400].argmax())
        placed = rotated(group["roller_points"][:], group["roller_turn"][-1, k])
        moved = group["roller_displacement"][-1, k]
        angle = np.arctan2(file["roller_y"][400, k], file["roller_x"][400, k])
    assert stored == pytest.approx(turned(local, instant.roller_turn[j]), abs=1e-5 * np.abs(local).max())
    assert np.abs(stored).max() > 5e6
    radial, around = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    assert np.sum((placed @ radial) * (moved @ radial)) < 0.0 < np.sum((placed @ around) * (moved @ around))


@pytest.mark.parametrize("stop_at", [50, 63])
def test_a_resumed_run_has_every_frame_once(tmp_path, stop_at):
    keys = ("numerics.mesh_size_mm=2.0", "numerics.duration_ms=1.0", "output.fields_every_ms=0.25")
    plan = make_plan(read_scene(None, keys))
    path, state, short = tmp_path / "run.nc", plan.first_state(), replace(plan, n_samples=stop_at)
    with ResultFile(path, short, 0.0) as store:
        run(short, store.append, state=state, keep=store.keep)
        store.keep(frame_of(plan.model, state.arrays, state.done, plan.interval))
        store.commit()
        stored = store.stored
    with ResultFile(path, plan, 0.0, stored) as store:
        run(plan, store.append, state=state, keep=store.keep)
        store.finish("complete", steps=plan.steps)
    with h5py.File(path) as file:
        assert file[GROUP]["sample"][:].tolist() == [0, 25, 50, 75, 100]
        assert file[GROUP]["roller_displacement"].shape[0] == 5
    for sample in (50, 75):
        instant = StoredRun(path).instant(sample)
        assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=1e-6)


def test_a_file_without_its_frames_is_not_gone_on_with_and_others_beyond_samples_not_read(with_fields, here, capsys):
    path = here / "run.nc"
    options = [*OPTIONS, *EVERY, "--output", str(path), "--duration"]
    assert run_main([*options, "1"]) == 0
    with h5py.File(path, "r+") as file:
        del file[GROUP]
    assert run_main([*options, "2", "--resume"]) == 2
    assert "frames" in capsys.readouterr().err
    path = changed(with_fields, here, lambda file: file[GROUP]["inner_ring_stress"].__setitem__((3, 7, 1), 1.0))
    assert StoredRun(path).instant(100).stored  # another frame than the damaged one
    with pytest.raises(UsageError, match=r"sample 150 .* checksum"):
        StoredRun(path).instant(150)
    path = changed(with_fields, here, lambda file: file.attrs.update(committed_samples=101))
    assert StoredRun(path).frames.tolist() == [0, 50, 100]
    assert read_instant(path).time == pytest.approx(1e-3, rel=1e-12)
    with pytest.raises(UsageError, match="0 to 1 ms"):
        read_instant(path, 2e-3)


def test_fields_are_those_of_the_equilibrium_the_run_started_from_and_surfaces_meet_below_the_grid(tmp_path):
    path = tmp_path / "static.nc"
    assert run_main([*OPTIONS, "--duration", "0", *sets("contact.friction_coefficient=0"), "--output", str(path)]) == 0
    static = read_instant(path)
    motion = rolling_motion(static.model, static.operation, 0.0)
    wanted = equilibrium(static.model, motion, Loads.of(static.operation))
    for field in ("inner_ring", "outer_ring", "rollers"):
        exact = getattr(wanted, field)
        assert np.abs(exact).max() > 1e-8
        # the stored positions place the patches one pass further on: 1e-7 of a spacing
        assert getattr(static, field) == pytest.approx(exact, rel=0.0, abs=1e-6 * np.abs(exact).max()), field
    assert static.elastic_energy == pytest.approx(static.stored_elastic_energy, rel=1e-5)
    model, bearing = static.model, static.model.bearing
    inner, disc = model.inner_ring, model.roller
    for j in np.flatnonzero(static.inner_force > 10.0):
        angle, force = static.inner_angle[j], static.inner_force[j]
        nodes, weight, offset = patch(inner.n_sectors, angle - static.ring_turn)
        u = static.inner_ring[inner.raceway_row][:, nodes]
        out_ring = weight @ (u[0] * np.cos(offset) + u[1] * np.sin(offset))
        sector = np.mod((angle - static.ring_turn) * inner.n_sectors / (2 * pi), inner.n_sectors)
        surface = disc.shape.surface_nodes
        nodes, weight, _ = patch(surface, angle + pi)
        out_roller = -weight @ static.rollers[j][disc.first_surface_node + nodes] @ [np.cos(angle), np.sin(angle)]
        place = np.mod((angle + pi) * surface / (2 * pi), surface)
        ripple = ripple_at(sector, model.inner_surface.ripple)[0] + ripple_at(place, model.roller_surface.ripple)[0]
        apart = np.hypot(*(static.centres[j] - static.hub)) - bearing.inner_raceway_radius - bearing.roller_radius
        expected = model.inner_law.approach(force) + ripple * force
        assert out_ring + out_roller - apart == pytest.approx(expected, rel=1e-6)


def test_load_zone_orbit_and_times(coarse_run, tmp_path):
    with h5py.File(coarse_run) as file:
        path = np.column_stack([file["inner_x"], file["inner_y"]])
    run = StoredRun(coarse_run)
    assert np.array_equal(run.orbit, path)
    zone = np.degrees(run.load_zone)  # in 4 ms a roller goes 42 degrees, the next one follows at 28
    assert 175.0 < zone[0] < 190.0 and (zone[1] + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=8.0)
    path = changed(coarse_run, tmp_path, lambda file: file["inner_force"].write_direct(np.zeros((401, 13))))
    assert StoredRun(path).load_zone is None  # nothing loads it
    for time, sample in ((1.0032e-3, 1.00e-3), (1.0068e-3, 1.01e-3), (None, 4e-3)):
        assert read_instant(coarse_run, time).time == pytest.approx(sample, rel=1e-12)


def test_tractions_enter_the_fields(coarse_run, tmp_path):

    def pull(file):
        file["inner_traction"][-1] = 0.1 * file["inner_force"][-1]
        file["outer_traction"][-1] = -0.1 * file["inner_force"][-1]

    plain, sheared = read_instant(coarse_run), read_instant(changed(coarse_run, tmp_path, pull))
    j, inner = int(plain.inner_force.argmax()), plain.model.inner_ring
    angle = plain.inner_angle[j]
    difference = rotated(sheared.rollers[j] - plain.rollers[j], plain.roller_turn[j])
    radial = rotated(plain.model.roller.points, plain.roller_turn[j]) @ np.array([np.cos(angle), np.sin(angle)])
    along = difference @ np.array([-np.sin(angle), np.cos(angle)])
    assert along[np.argmin(radial)] > 0.0 > along[np.argmax(radial)]
    sector = round((angle - plain.ring_turn) / (2 * pi) * inner.n_sectors)  # the inner ring is dragged the other way
    assert (sheared.inner_ring - plain.inner_ring)[inner.raceway_row, 1, sector % inner.n_sectors] < 0.0


def test_rollers_pressed_together_are_squeezed_along_their_line_of_centres(coarse_run, tmp_path):
    def press(file):
        for name in ("inner_force", "outer_force", "inner_traction", "outer_traction", "roller_spin"):
            file[name][-1] = 0.0
        file["roller_roller_force"][-1] = 200.0 * np.isin(np.arange(13), (5, 6))  # 5 on 6 on 7

    instant = read_instant(changed(coarse_run, tmp_path, press))
    line = instant.centres[7] - instant.centres[5]
    line /= np.hypot(*line)
    along = rotated(instant.model.roller.points, instant.roller_turn[6]) @ line
    ends = rotated(instant.rollers[6], instant.roller_turn[6]) @ line
    assert ends[np.argmax(along)] < 0.0 < ends[np.argmin(along)]
    assert np.abs(instant.rollers[0]).max() < 1e-3 * np.abs(instant.rollers[6]).max()
