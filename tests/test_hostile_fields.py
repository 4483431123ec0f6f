"""Result files with stored fields that were made to mislead or to harm: render-fem refuses them, and soon."""

import os
import shutil

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.result.fields import FRAME, GROUP, _checksum
from lagrange.files.hdf5 import CHECKSUM, checksum
from tests.stability import forked

OPTIONS = ["--mesh-size", "2", "--quiet", "--set", "output.fields_every_ms=0.1", "--duration"]
SECONDS = 60.0  # of processor time; hardly one is needed

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")


@pytest.fixture(scope="module")
def with_fields(tmp_path_factory):
    path = tmp_path_factory.mktemp("fields") / "run.nc"
    assert run_main([*OPTIONS, "0.2", "--output", str(path)]) == 0
    return path


def replaced(name, make):
    """Another variable of that name in the group of fields."""

    def change(file, folder):
        old = file[GROUP].pop(name)[...] if name in file[GROUP] else None
        make(file[GROUP], name, old, folder)

    return change


def outside(group, name, old, folder):
    os.mkfifo(folder / "pipe")
    group.create_dataset(name, shape=old.shape, dtype=old.dtype, external=[(str(folder / "pipe"), 0, old.nbytes)])


def linked(group, name, old, folder):
    group[name] = h5py.ExternalLink(str(folder / "other.nc"), "/x")


def wide(group, name, old, folder):
    """Six thousand million columns of zeros in a few bytes."""
    shape = (*old.shape[:-2], 6 * 10**9, old.shape[-1])
    group.create_dataset(name, shape=shape, dtype=old.dtype, chunks=(1,) * (len(shape) - 2) + (2**20, 2), compression=9)


def fewer(group, name, old, folder):
    group[name] = old[..., :-1, :]


def without(group, name, old, folder):
    pass


def forged(name, value):
    """A value with sound checksums."""

    def change(file, folder):
        group = file[GROUP]
        group[name][-1] = value
        values = {field: group[field][-1] for field in FRAME if field != CHECKSUM}
        group[CHECKSUM][-1] = _checksum(values)

    return change


def main(name, value):
    """A value of the run itself, with a sound checksum."""

    def change(file, folder):
        values = file[name][...]
        values[-1] = value
        file[name][...] = values
        count = int(file.attrs["committed_samples"])
        file[name].attrs[CHECKSUM] = np.array([count, checksum(values), -1, 0])

    return change


FORGERIES = {
    "stresses in a pipe": (replaced("roller_stress", outside), "another file"),
    "times in a pipe": (replaced("time", outside), "another file"),
    "stresses in another file": (replaced("outer_ring_stress", linked), "link"),
    "checksums in another file": (replaced(CHECKSUM, linked), "link"),
    "more nodes than memory": (replaced("inner_ring_displacement", wide), "inner_ring_displacement"),
    "fewer nodes than the mesh": (replaced("inner_ring_displacement", fewer), "the mesh of the file's scene has"),
    "no checksums": (replaced(CHECKSUM, without), "checksum is missing"),
    "a displacement that is no number": (forged("roller_displacement", np.nan), "no number"),
    "a roller displaced by a kilometre": (forged("roller_displacement", 1e3), "larger than the bearing"),
    "an infinite stress": (forged("inner_ring_stress", np.inf), "no number"),
    "an endless turn": (forged("roller_turn", 1e308), "more than"),
    "a spin beyond all": (main("roller_spin", 1e308), "roller_spin is 1e+308"),
    "a hub in the next room": (main("inner_x", 5.0), "inner_x is 5 at"),
    "a roller in the next room": (main("roller_x", 5.0), "roller"),
    "a force that is no number": (main("inner_force", np.nan), "inner_force is nan"),
    "time that stands": (main("time", 0.0), "time does not rise"),
}


@pytest.mark.parametrize("forgery", FORGERIES)
def test_forged_fields_are_refused_in_a_sentence(forgery, with_fields, tmp_path):
    change, words = FORGERIES[forgery]
    path = shutil.copy(with_fields, tmp_path / "run.nc")
    with h5py.File(path, "r+") as file:
        change(file, tmp_path)
    target = tmp_path / "mesh.vtu"
    done = forked.run(["render-fem", str(path), "--export", str(target)], tmp_path, SECONDS)
    assert done.code == 2, done.said
    assert str(path) in done.said and words in done.said and done.said.count("\n") == 1
    assert not target.exists()


def test_sound_fields_are_drawn_from(with_fields, tmp_path):
    done = forked.run(["render-fem", str(with_fields), "--export", "mesh.vtu"], tmp_path, SECONDS)
    assert done.code == 0, done.said


@pytest.mark.parametrize("name", ["fewer nodes than the mesh", "more nodes than memory", "stresses in another file"])
def test_forged_fields_are_not_resumed(name, with_fields, tmp_path):
    path = tmp_path / "run.nc"
    for suffix in ("", ".checkpoint"):
        shutil.copy(f"{with_fields}{suffix}", f"{path}{suffix}")
    with h5py.File(path, "r+") as file:
        FORGERIES[name][0](file, tmp_path)
    before = path.read_bytes()
    done = forked.run(["run-fem", *OPTIONS, "0.4", "--output", str(path), "--resume"], tmp_path, SECONDS)
    assert done.code == 2 and str(path) in done.said and "Traceback" not in done.said
    assert path.read_bytes() == before
