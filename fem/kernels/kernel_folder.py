"""Where compiled kernels are kept: a folder named after the text of all modules beside this one, the user's alone.

Numba's cache looks at the file a function stands in, not at the files of the functions it inlines: after a change to
one kernel it would go on running the old code inside the others. Needs no compiler.

Of the ideal bearing's formulas kernels compile that of dampers, in a module of `lagrange`.
"""

import hashlib
import os
import stat
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

import platformdirs

from lagrange.contact import damping

notices: list[str] = []  # sentences on what was wrong with folders and files so far


@cache
def version() -> str:
    """Of all kernels: two programs of one version compute the same bits on one machine."""
    checked = os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")  # `lane_memory`
    return digest(Path(__file__).parent) + ("-checked" if checked else "")


@cache
def cache_folder() -> Path | None:
    """Where this version's compiled kernels are kept: in NUMBA_CACHE_DIR or the user's cache folder; None: nowhere."""
    bases = os.environ.get("NUMBA_CACHE_DIR"), platformdirs.user_cache_dir("roller-bearing-fem")
    return private_folder(Path(base).absolute() / "kernels" / version() for base in bases if base)


def digest(folder: Path) -> str:
    """Of the text of all modules of a folder, and of dampers: any of them may be part of a kernel."""
    text = hashlib.sha256()
    for module in (*sorted(folder.glob("*.py")), Path(damping.__file__)):
        text.update(module.name.encode() + module.read_bytes())
    return text.hexdigest()[:16]


def private_folder(folders: Iterable[Path]) -> Path | None:
    """The first of some folders that can be made, or is there and is this user's alone."""
    for folder in folders:
        try:
            folder.parent.mkdir(parents=True, exist_ok=True)
            with suppress(FileExistsError):
                folder.mkdir(mode=0o700)
            if is_private(folder.lstat()):
                return folder
        except OSError:
            continue
        notices.append(f"{folder}: the compiled kernels there are not used, because others can write there; remove it")
    return None


def is_private(found: os.stat_result) -> bool:
    """Whether a folder itself, no link, is this user's and can be written by nobody else."""
    if not hasattr(os, "geteuid"):  # a system that keeps no rights in modes
        return True
    others = found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and not others
