"""Where pictures and exports go: in the place of nothing, of one of their own kind, or by --force of any file."""

import mmap
from pathlib import Path

from lagrange.errors import UsageError
from lagrange.files.output import refuse_special

MARK = "render-fem"  # in files that have room for a remark
FIELDS = b"von_mises", b"max_shear"  # of meshes with fields, in whatever format
MARKS = {
    ".csv": (b"time_s,inner_ax_m_s2",),
    **dict.fromkeys((".png", ".gif", ".mp4", ".wav"), (MARK.encode(),)),
}


def refuse_foreign(target: Path, force: bool) -> None:
    """Refuse to write where a file stands that this program has not written as such an export.

    Errors
    ------
    UsageError. OSError: it can't be read, or is no plain file.
    """
    refuse_special(target)
    if not force and target.exists() and not _is_ours(target):
        raise UsageError(
            f"{target}: is there already and no export of render-fem; --force replaces it, or name another file"
        )


def _is_ours(path: Path) -> bool:
    """Whether a file of this ending holds what ours hold; an empty one may go."""
    if path.stat().st_size == 0:
        return True
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        return all(data.find(mark) >= 0 for mark in MARKS.get(path.suffix.lower(), FIELDS))
