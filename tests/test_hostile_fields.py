"""Result files with foreign or damaged fields: render-fem and --resume refuse them in a sentence."""

import shutil

import h5py
import numpy as np
import pytest

from fem.commands.render_fem import render_main
from fem.commands.run_fem import run_main
from fem.result.run_file import GROUP
from lagrange.files.hdf5 import CHECKSUM

OPTIONS = ["--mesh-size", "2", "--quiet", "--set", "output.fields_every_ms=0.1", "--duration"]


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


FORGERIES = {
    "stresses in another file": (replaced("outer_ring_stress", linked), "link"),
    "checksums in another file": (replaced(CHECKSUM, linked), "link"),
    "more nodes than memory": (replaced("inner_ring_displacement", wide), "inner_ring_displacement"),
    "fewer nodes than the mesh": (replaced("inner_ring_displacement", fewer), "its mesh has"),
    "no checksums": (replaced(CHECKSUM, without), "checksum is missing"),
    "a stress that has been changed": (lambda file, folder: file[GROUP]["roller_stress"].write_direct(
        np.zeros(file[GROUP]["roller_stress"].shape, "f4")), "checksum differs"),
}  # fmt: skip


@pytest.mark.parametrize("forgery", FORGERIES)
def test_forged_fields_are_refused_in_a_sentence(forgery, with_fields, tmp_path, capsys):
    change, words = FORGERIES[forgery]
    path = shutil.copy(with_fields, tmp_path / "run.nc")
    with h5py.File(path, "r+") as file:
        change(file, tmp_path)
    target = tmp_path / "mesh.vtu"
    assert render_main([str(path), "--export", str(target)]) == 2
    said = capsys.readouterr().err
    assert str(path) in said and words in said and said.count("\n") == 1
    assert not target.exists()


@pytest.mark.parametrize("name", ["fewer nodes than the mesh", "more nodes than memory", "stresses in another file"])
def test_forged_fields_are_not_resumed(name, with_fields, tmp_path, capsys):
    path = tmp_path / "run.nc"
    for suffix in ("", ".checkpoint"):
        shutil.copy(f"{with_fields}{suffix}", f"{path}{suffix}")
    with h5py.File(path, "r+") as file:
        FORGERIES[name][0](file, tmp_path)
    before = path.read_bytes()
    assert run_main([*OPTIONS, "0.4", "--output", str(path), "--resume"]) == 2
    said = capsys.readouterr().err
    assert str(path) in said and "Traceback" not in said
    assert path.read_bytes() == before
