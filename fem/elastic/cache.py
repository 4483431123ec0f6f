"""Results kept on disk between starts: assembled matrices, critical time steps.

An entry is found by a digest of what it depends on: its key, the text of every module it could come from, and the
versions of the libraries that made it. It is made anew where it can't be read or is not what was written.
"""

import hashlib
import io
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

import lagrange
import meshes
from lagrange.files.input import private_folder
from lagrange.files.output import read_sealed, write_sealed
from meshes import cache as mesh_cache

LARGEST = 20e6  # bytes; what is larger takes its time anyway, and would fill the disk


def kept(kind: str, key: str, make: Callable[[], dict[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """The named arrays that `make` makes, from the user's cache where they are there.

    kind : of entry; key : everything the arrays depend on beside the program, as text
    """
    name = f"{kind}-{_digest(key, _program())}.npz"
    found = _read(name)
    if found is None:
        found = {name: np.asarray(array, order="C") for name, array in make().items()}  # as they come back from there
        if sum(array.nbytes for array in found.values()) <= LARGEST:
            archive = io.BytesIO()
            np.savez(archive, **found)
            with suppress(OSError):  # a read-only home costs the next start what this one took
                write_sealed(_folder() / name, archive.getvalue())
    return found


def _folder():
    return private_folder(mesh_cache.cache_folder().with_name("kept"))


def _read(name):
    try:
        data = read_sealed(_folder() / name)
        if data is None:
            return None
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            found = {name: archive[name] for name in archive.files}
            return found if all(isinstance(array, np.ndarray) for array in found.values()) else None
    except Exception:  # an archive can be damaged in more ways than there are errors to name here
        return None


@cache
def _program():
    """Digest of the program's text, as far as results depend on it, and the libraries' versions."""
    elastic = Path(__file__).parent
    siblings = (elastic.with_name(name) for name in ("contacts", "kernels"))
    folders = (elastic, *siblings, *(Path(module.__file__).parent for module in (lagrange, meshes)))
    texts = [path.read_text(encoding="utf-8") for folder in folders for path in sorted(folder.rglob("*.py"))]
    return _digest(*texts, *(version(name) for name in ("numpy", "scipy", "scikit-fem")))


def _digest(*texts):
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()[:24]
