"""Fields stored in the result file: the solver's own, where the scene asks for them and nowhere else."""

import shutil
from dataclasses import replace
from math import pi

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.contacts.points import patch
from fem.elastic.bodies import turned
from fem.kernels.law import ripple_at
from fem.pictures.recover import StoredRun, read_instant
from fem.result.run_file import GROUP
from fem.result.store import ResultFile
from fem.solver.elements.arrays import frame_of, rotated
from fem.solver.elements.start import rolling_motion
from fem.solver.simulate import make_plan, run
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from lagrange.errors import UsageError
from lagrange.scene.scene import SceneError, read_scene
from tests.reference.kit import unchecked_copy

EVERY = ["--set", "output.fields_every_ms=0.5"]


@pytest.fixture(scope="module")
def with_fields(tmp_path_factory):
    """The shared coarse run, with fields."""
    path = tmp_path_factory.mktemp("fields") / "fields.nc"
    assert run_main(["--mesh-size", "2", "--duration", "4", "--output", str(path), "--quiet", *EVERY]) == 0
    return path


def changed(path, folder, change, copy=unchecked_copy):
    """A copy of a result file, with a change made in it."""
    path = copy(path, folder / "copy.nc")
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def test_frames_are_at_the_samples_asked_for_take_little_room_and_change_nothing(with_fields, coarse_run):
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


@pytest.mark.parametrize("sample", [0, 150, 400])
def test_stored_displacements_have_the_runs_elastic_energy(with_fields, sample):
    instant = StoredRun(with_fields).instant(sample)
    assert instant.stored
    assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=1e-6)


@pytest.mark.parametrize("sample", [150, 400])
def test_recovered_fields_are_the_stored_ones_but_for_waves(with_fields, coarse_run, sample):
    stored, recovered = StoredRun(with_fields).instant(sample), StoredRun(coarse_run).instant(sample)
    assert not recovered.stored
    assert recovered.roller_turn == pytest.approx(stored.roller_turn, abs=1e-5)
    for name in ("rollers", "inner_ring", "outer_ring"):
        expected = getattr(stored, name)
        assert getattr(recovered, name) == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


def test_stored_stress_is_that_of_the_stored_displacement(with_fields):
    instant = StoredRun(with_fields).instant(250)
    disc, j = instant.model.roller, int(instant.inner_force.argmax())
    local = (disc.stress @ instant.rollers[j].ravel()).reshape(-1, 3)
    with h5py.File(with_fields) as file:
        stored = file[GROUP]["roller_stress"][5, j]
    assert stored == pytest.approx(turned(local, instant.roller_turn[j]), abs=1e-5 * np.abs(local).max())
    assert np.abs(stored).max() > 5e6


def test_displacements_are_in_the_fixed_axes(with_fields):
    """The most loaded roller, near the load line, is shortened along y and bulges along x."""
    with h5py.File(with_fields) as file:
        group = file[GROUP]
        j = int(file["inner_force"][400].argmax())
        turn, points = group["roller_turn"][-1, j], group["roller_points"][:]
        moved = group["roller_displacement"][-1, j]
        angle = np.arctan2(file["roller_y"][400, j], file["roller_x"][400, j])
    c, s = np.cos(turn), np.sin(turn)
    placed = points @ np.array([[c, s], [-s, c]])
    radial, around = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    assert np.sum((placed @ radial) * (moved @ radial)) < 0.0 < np.sum((placed @ around) * (moved @ around))


def test_the_group_opens_in_xarray(with_fields):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    with xarray.open_dataset(with_fields, group=GROUP, engine="netcdf4", decode_times=False) as fields:
        assert fields["roller_displacement"].dims == ("time", "roller", "roller_node", "component")
        assert fields["outer_ring_stress"].dims == ("time", "outer_ring_node", "stress_component")
        assert fields["inner_ring_displacement"].attrs["units"] == "m"


def _resumed(folder, stop_at):
    """A run stopped after some samples and gone on with."""
    plan = make_plan(read_scene(None, ("numerics.mesh_size_mm=2.0", "numerics.duration_ms=1.0",
                                       "output.fields_every_ms=0.25")))  # fmt: skip
    path, state = folder / f"{stop_at}.nc", plan.first_state()
    short = replace(plan, n_samples=stop_at)
    with ResultFile(path, short, 0.0) as store:
        run(short, store.append, state=state, keep=store.keep)
        store.keep(frame_of(plan.model, state.arrays, state.done, plan.interval))  # stopped between frame and sample
        store.commit()
        stored = store.stored
    with ResultFile(path, plan, 0.0, stored) as store:
        run(plan, store.append, state=state, keep=store.keep)
        store.finish("complete", steps=plan.steps)
    return path


@pytest.mark.parametrize("stop_at", [50, 63])
def test_a_resumed_run_has_every_frame_once(tmp_path, stop_at):
    path = _resumed(tmp_path, stop_at)
    with h5py.File(path) as file:
        assert file[GROUP]["sample"][:].tolist() == [0, 25, 50, 75, 100]
        assert file[GROUP]["roller_displacement"].shape[0] == 5
    for sample in (50, 75):
        instant = StoredRun(path).instant(sample)
        assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=1e-6)


def test_a_file_whose_frames_are_gone_is_not_gone_on_with(tmp_path, capsys):
    path = tmp_path / "run.nc"
    options = ["--mesh-size", "2", "--output", str(path), "--quiet", *EVERY, "--duration"]
    assert run_main([*options, "1"]) == 0
    with h5py.File(path, "r+") as file:
        del file[GROUP]
    assert run_main([*options, "2", "--resume"]) == 2
    assert "frames" in capsys.readouterr().err


def test_frames_beyond_the_committed_samples_are_not_trusted(with_fields, tmp_path):
    path = changed(with_fields, tmp_path, lambda file: file.attrs.update(committed_samples=101))
    assert StoredRun(path).stored_samples.tolist() == [0, 50, 100]


def spoilt(file):
    file[GROUP]["inner_ring_stress"][3, 7, 1] *= 1.0 + 1e-6


def linked(file):
    del file[GROUP]["outer_ring_displacement"]
    file[GROUP]["outer_ring_displacement"] = h5py.ExternalLink("/etc/passwd", "/x")


@pytest.mark.parametrize(("damage", "words"), [
    (lambda file: file[GROUP].pop("outer_ring_displacement"), "outer_ring_displacement"),
    (linked, "outer_ring_displacement is a link"), (spoilt, r"sample 150 .* checksum"),
])  # fmt: skip
def test_damaged_fields_are_refused(with_fields, tmp_path, damage, words):
    path = changed(with_fields, tmp_path, damage, shutil.copy)
    if damage is spoilt:
        assert StoredRun(path).instant(100).stored
    with pytest.raises(UsageError, match=words):
        StoredRun(path).instant(150)


def test_fields_more_often_than_samples_are_refused():
    with pytest.raises(SceneError, match=r"output\.fields_every_ms = 0\.005 must not be below .* \(0\.01 ms\)"):
        read_scene(None, ("output.fields_every_ms=0.005",))


def test_the_dry_run_says_what_fields_will_take(capsys):
    assert run_main(["--mesh-size", "2", "--duration", "4", "--dry-run", *EVERY]) == 0
    assert "9, one every 0.5 ms, 0.151 MB" in capsys.readouterr().out


# Fields recovered from a result file: against the equilibrium they came from and the stored energy


@pytest.fixture(scope="module")
def static_run(tmp_path_factory):
    """Static equilibrium of the paper's bearing at 2 mm, turning at 4500 rpm without friction."""
    path = tmp_path_factory.mktemp("static") / "static.nc"
    wanted = ["--mesh-size", "2", "--duration", "0", "--set", "contact.friction_coefficient=0", "--output", str(path)]
    assert run_main([*wanted, "--quiet"]) == 0
    return path


@pytest.fixture(scope="module")
def static(static_run):
    return read_instant(static_run)


@pytest.mark.parametrize("field", ["inner_ring", "outer_ring", "rollers"])
def test_fields_are_those_of_the_equilibrium_the_run_started_from(static, field):
    operation = static.operation
    motion, _ = rolling_motion(static.model, operation, 0.0)
    wanted = getattr(equilibrium(static.model, motion, Loads.of(operation)), field)
    assert np.abs(wanted).max() > 1e-8
    # the stored positions place the patches one pass further on: 1e-7 of a spacing
    assert getattr(static, field) == pytest.approx(wanted, rel=0.0, abs=1e-6 * np.abs(wanted).max())


def test_recovered_surfaces_meet_at_the_approach_below_the_grid(static):
    model, bearing = static.model, static.model.bearing
    inner, disc = model.inner_ring, model.roller
    for j in np.flatnonzero(static.inner_force > 10.0):
        angle = static.inner_angle[j]
        normal = np.array([np.cos(angle), np.sin(angle)])
        nodes, weight, offset = patch(inner.n_sectors, angle - static.ring_turn)
        u = static.inner_ring[inner.raceway_row][:, nodes]
        out_ring = weight @ (u[0] * np.cos(offset) + u[1] * np.sin(offset))
        at_ring = ripple_at(np.mod((angle - static.ring_turn) * inner.n_sectors / (2 * pi), inner.n_sectors),
                            model.inner_surface.ripple)[0]  # fmt: skip
        surface = disc.shape.surface_nodes
        nodes, weight, _ = patch(surface, angle + pi)
        out_roller = -weight @ static.rollers[j][disc.first_surface_node + nodes] @ normal
        at_roller = ripple_at(np.mod((angle + pi) * surface / (2 * pi), surface), model.roller_surface.ripple)[0]
        apart = np.hypot(*(static.centres[j] - static.hub)) - bearing.inner_raceway_radius - bearing.roller_radius
        force = static.inner_force[j]
        expected = model.inner_law.approach(force) + (at_ring + at_roller) * force
        assert out_ring + out_roller - apart == pytest.approx(expected, rel=1e-6)


def test_static_energy_is_the_stored_one(static):
    assert static.elastic_energy == pytest.approx(static.stored_elastic_energy, rel=1e-5)


@pytest.mark.parametrize("time", [1e-3, 2.5e-3, None])
def test_energy_of_a_moving_bearing_is_the_stored_one_but_for_waves(coarse_run, time):
    instant = read_instant(coarse_run, time)
    assert instant.elastic_energy == pytest.approx(instant.stored_elastic_energy, rel=1e-4)


def test_the_load_zone_is_the_lower_half_of_a_bearing_without_clearance(coarse_run):
    run = StoredRun(coarse_run)
    start, end = run.load_zone
    zone = np.degrees([start, end])
    # in 4 ms a roller goes 42 degrees, the next one follows at 28
    assert 175.0 < zone[0] < 190.0 and (zone[1] + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=8.0)


def test_the_orbit_is_the_hubs_path_and_a_bearing_nobody_loads_has_no_load_zone(coarse_run, tmp_path):
    with h5py.File(coarse_run) as file:
        expected = np.column_stack([file["inner_x"], file["inner_y"]])
    assert np.array_equal(StoredRun(coarse_run).orbit, expected)
    path = changed(coarse_run, tmp_path, lambda file: file["inner_force"].write_direct(np.zeros((401, 13))))
    assert StoredRun(path).load_zone is None


def test_tractions_enter_the_fields(coarse_run, tmp_path):
    """Equal and opposite tractions on a roller shear it by what Coulomb's largest would: far from nothing."""

    def pull(file):
        file["inner_traction"][-1] = 0.1 * file["inner_force"][-1]
        file["outer_traction"][-1] = -0.1 * file["inner_force"][-1]

    plain, sheared = read_instant(coarse_run), read_instant(changed(coarse_run, tmp_path, pull))
    j = int(plain.inner_force.argmax())
    difference = rotated(sheared.rollers[j] - plain.rollers[j], plain.roller_turn[j])
    along = np.array([-np.sin(plain.inner_angle[j]), np.cos(plain.inner_angle[j])])
    points = rotated(plain.model.roller.points, plain.roller_turn[j])
    radial = points @ np.array([np.cos(plain.inner_angle[j]), np.sin(plain.inner_angle[j])])
    inner_end, outer_end = np.argmin(radial), np.argmax(radial)
    assert difference[inner_end] @ along > 0.0 > difference[outer_end] @ along
    # the inner ring is dragged the other way
    sector = round((plain.inner_angle[j] - plain.ring_turn) / (2 * pi) * plain.model.inner_ring.n_sectors)
    row = plain.model.inner_ring.raceway_row
    assert (sheared.inner_ring - plain.inner_ring)[row, 1, sector % plain.model.inner_ring.n_sectors] < 0.0


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


def test_time_means_the_nearest_sample(coarse_run):
    assert read_instant(coarse_run, 1.0032e-3).time == pytest.approx(1.00e-3, rel=1e-12)
    assert read_instant(coarse_run, 1.0068e-3).time == pytest.approx(1.01e-3, rel=1e-12)
    assert read_instant(coarse_run).time == pytest.approx(4e-3, rel=1e-12)


def test_uncommitted_samples_are_not_read(coarse_run, tmp_path):
    path = changed(coarse_run, tmp_path, lambda file: file.attrs.update(committed_samples=101))
    assert read_instant(path).time == pytest.approx(1e-3, rel=1e-12)
    with pytest.raises(UsageError, match="0 to 1 ms"):
        read_instant(path, 2e-3)


@pytest.mark.parametrize("time", [-1e-3, 4.1e-3, float("nan")])
def test_a_time_outside_names_the_range(coarse_run, time):
    with pytest.raises(UsageError, match=r"coarse\.nc: no sample at .* it holds 0 to 4 ms"):
        read_instant(coarse_run, time)


def test_unusable_files_are_named(coarse_run, tmp_path):
    def unusable(path, words):
        with pytest.raises(UsageError, match=words) as caught:
            read_instant(path)
        assert str(path) in str(caught.value)

    unusable(tmp_path / "nothing.nc", "no such result file")
    unusable(tmp_path, "no such result file")
    text = tmp_path / "text.nc"
    text.write_text("time,inner_x\n0,0\n")
    unusable(text, "can't be read as a result file")
    truncated = tmp_path / "truncated.nc"
    truncated.write_bytes(coarse_run.read_bytes()[:20_000])
    unusable(truncated, "can't be read as a result file")
    with h5py.File(tmp_path / "other.nc", "w") as file:
        file["time"] = [0.0]
    unusable(tmp_path / "other.nc", "not a result file of run-fem")


@pytest.mark.parametrize(("damage", "words"), [
    (lambda file: file.attrs.update(committed_samples=0), "holds no sample yet"),
    (lambda file: file.attrs.update(committed_samples=10**6), "1000000 samples are committed"),
    (lambda file: file.pop("outer_force"), "outer_force"),
    (lambda file: file["inner_force"].write_direct(np.full(file["inner_force"].shape, np.nan)), "is nan at 0 ms"),
    (lambda file: file.attrs.update(scene="[bearing]\nrollers = 9\n"), "9 rollers"),
    (lambda file: file.attrs.update(scene="[bearing]\nrollres = 9\n"), r"copy\.nc: its scene: bearing\.rollres: unkn"),
])  # fmt: skip
def test_damaged_files_are_refused(coarse_run, tmp_path, damage, words):
    with pytest.raises((UsageError, SceneError), match=words):
        read_instant(changed(coarse_run, tmp_path, damage))
