"""Pressures along the rollers of a run, from the forces and moments that its file holds."""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from fem.errors import UsageError
from fem.interface import simulate
from fem.pictures.axial import axial_pressures, draw_axial
from fem.pictures.recover import StoredRun
from fem.pictures.render import refuse_foreign
from fem.rating.tilted import tilted_pitch
from fem.statics.tilted_pressures import scene_slices
from lagrange.axial.pressure import placed
from lagrange.axial.slices import read_slices, write_slices
from lagrange.files.hdf5 import Damaged, hdf5_to_write
from lagrange.scene import Scene

SCENE = {"model": "reduced", "operation": {"misalignment_mrad": 1.0}, "numerics": {"duration_ms": 0.0}}


@pytest.fixture(scope="module")
def stored(tmp_path_factory) -> StoredRun:
    path = tmp_path_factory.mktemp("tilted") / "run.nc"
    simulate(Scene(**SCENE, axial={"slices": 11})).save(path)
    return StoredRun(path)


@pytest.mark.slow  # a run's time loop is compiled for it
def test_a_file_gives_the_pressures_of_the_statics(stored, tmp_path):
    found = axial_pressures(stored, 0)
    bearing, axial = stored.scene.perfect_bearing(), stored.scene.ideal_axial()
    acting = stored.scene.ideal_operation()
    _, inner, _ = tilted_pitch(bearing, axial, acting, samples=1).pressures()
    assert found.pressure[0].max() == pytest.approx(inner.max(), rel=0.01)
    at = int(found.pressure[0].max(axis=1).argmax())
    assert found.slope[0, at] == pytest.approx(-0.5e-3, abs=5e-5)
    assert found.pressure[0, at] @ found.place > 0.0  # its +z end is pressed
    draw_axial(stored, tmp_path / "axial.png", 0)
    refuse_foreign(tmp_path / "axial.png", force=False)  # the next picture may take its place
    assert (tmp_path / "axial.png").read_bytes().startswith(b"\x89PNG")


def test_a_place_bears_the_force_and_moment_that_it_was_asked_for():
    from lagrange.axial.slices import contact_slices
    from lagrange.contact.laws import contact_laws

    scene = Scene(model="lagrange", axial={"slices": 21})
    bearing = scene.perfect_bearing()
    slices, _ = contact_slices(bearing, scene.ideal_axial(), contact_laws("johnson", bearing))
    approach, slope = placed(slices, 600.0, 1.2)
    sums = slices.sums(np.array([approach]), np.array([slope]))
    assert (sums.force[0], sums.moment[0]) == (pytest.approx(600.0, rel=1e-5), pytest.approx(1.2, rel=1e-4))
    with pytest.raises(ValueError, match="beyond"):
        placed(slices, 600.0, 6.0)


def test_a_file_keeps_the_slices_of_elastic_bodies(tmp_path):
    scene = Scene(model="reduced", axial={"slices": 11})
    bearing, axial, written = scene.perfect_bearing(), scene.ideal_axial(), scene_slices(scene)
    with hdf5_to_write(tmp_path / "run.nc") as file:
        write_slices(file, written)
    with h5py.File(tmp_path / "run.nc", "r+") as file:
        read = read_slices(file, bearing, axial)
        for own, other in zip(written, read, strict=True):
            assert np.array_equal(own.forces(4e-6, 1e-4), other.forces(4e-6, 1e-4))
        file["outer_slice_compliance"][3, 4] = np.nan
        with pytest.raises(Damaged, match="outer_slice_compliance is no compliance of 11 slices"):
            read_slices(file, bearing, axial)


def test_a_plane_run_is_refused():
    with pytest.raises(UsageError, match="no \\[axial\\]"):
        axial_pressures(SimpleNamespace(scene=Scene(), path="plane.nc"), 0)
