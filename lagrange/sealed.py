"""Files that appear whole or not at all, sealed by a digest: one that is cut, zeroed or has a flipped bit is known.

Stands on the ground floor, as `stored` does: meshes, assembled matrices and compiled kernels are kept in such files.
"""

import hashlib
from pathlib import Path

from lagrange.output_files import write_whole
from lagrange.plain_files import read_plain

_SIZE = hashlib.sha256().digest_size


def write_sealed(path: Path, data: bytes) -> None:
    """Write a file and its seal, behind the data, beside its place and move it there.

    Errors
    ------
    OSError: it can't be written; an earlier file stays.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, data + hashlib.sha256(data).digest())


def read_sealed(path: Path) -> bytes | None:
    """The data of a sealed file; None if it is not what was written.

    Errors
    ------
    OSError: there is no such file, or it can't be read.
    """
    whole = read_plain(path)
    data, seal = whole[:-_SIZE], whole[-_SIZE:]
    return data if len(seal) == _SIZE and hashlib.sha256(data).digest() == seal else None
