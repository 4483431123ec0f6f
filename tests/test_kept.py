"""Results kept on disk: made once, and made anew where the file is damaged or the folder can't be written."""

import io
import zipfile

import numpy as np
import pytest

from fem.elastic.cache import LARGEST, kept
from lagrange.files.output import write_sealed


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr("meshes.cache.cache_folder", lambda: tmp_path / "meshes")
    return tmp_path / "kept"


class Maker:
    def __init__(self, size=3):
        self.calls, self.size = 0, size

    def __call__(self):
        self.calls += 1
        return {"a": np.arange(self.size, dtype=float), "b": np.array(2.5)}


def test_is_made_once(folder):
    make = Maker()
    first, second = kept("some", "key", make), kept("some", "key", make)
    assert make.calls == 1 and float(second["b"]) == 2.5
    np.testing.assert_array_equal(first["a"], second["a"])


def test_another_key_or_kind_is_another_entry(folder):
    make = Maker()
    for kind, key in (("some", "key"), ("some", "other"), ("more", "key")):
        kept(kind, key, make)
    assert make.calls == 3


@pytest.mark.parametrize("damage", [b"", b"no archive", None])
def test_a_damaged_entry_is_made_anew(folder, damage):
    make = Maker()
    kept("some", "key", make)
    (path,) = folder.iterdir()
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 255
    path.write_bytes(bytes(data) if damage is None else damage)
    assert kept("some", "key", make)["a"].tolist() == [0.0, 1.0, 2.0]
    assert make.calls == 2
    kept("some", "key", make)
    assert make.calls == 2, "the damaged entry has been replaced"


def test_an_archive_of_anything_but_arrays_is_made_anew(folder):
    make = Maker()
    kept("some", "key", make)
    (path,) = folder.iterdir()
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("a.npy", b"no array")
    write_sealed(path, archive.getvalue())
    assert kept("some", "key", make)["a"].tolist() == [0.0, 1.0, 2.0]


def test_a_folder_that_cannot_be_written_costs_time_only(folder):
    folder.write_text("a file where the folder should be")
    make = Maker()
    assert kept("some", "key", make)["a"].size == 3 and kept("some", "key", make)["a"].size == 3
    assert make.calls == 2


def test_what_is_large_is_not_kept(folder):
    kept("some", "key", Maker(size=int(LARGEST / 8) + 1))
    assert not folder.exists()
