"""Folders in which nobody but this user and root can put a file: what is kept there is run, or decides results."""

import os
import stat
from contextlib import suppress
from errno import ENOTDIR, EPERM
from pathlib import Path


def user_cache(name: str = "") -> Path:
    """The user's cache folder, or one in it; errors as `private_folder`."""
    import platformdirs

    return private_folder(Path(platformdirs.user_cache_dir("roller-bearing-fem")) / name)


def private_folder(path: Path) -> Path:
    """A folder's real path, made where it is missing, below folders that belong to this user or to root alone.

    Others may write a folder above it where each may exchange only what is his own, as in the shared temporary folder.

    Errors
    ------
    PermissionError, which names the folder: another user owns it, or can write it. OSError: it can't be made.
    """
    path = path.absolute()
    for folder in (*reversed(path.parents), path):
        if os.path.lexists(folder):  # nobody else's link is followed
            _check_owner(folder, folder.lstat())
    real = Path(os.path.realpath(path))
    for folder in (*reversed(real.parents), real):  # from above: what lies below a checked one can't be exchanged
        if not folder.exists():
            with suppress(FileExistsError):
                folder.mkdir(mode=0o700)
        about = folder.lstat()
        _check_owner(folder, about)
        if not stat.S_ISDIR(about.st_mode):
            raise NotADirectoryError(ENOTDIR, os.strerror(ENOTDIR), str(folder))
        if not _closed(about, sticky=folder != real):
            raise PermissionError(EPERM, "others can write there; close it by chmod go-w", str(folder))
    return real


def _check_owner(path: Path, about: os.stat_result) -> None:
    if hasattr(os, "geteuid") and about.st_uid not in (0, os.geteuid()):
        raise PermissionError(EPERM, "belongs to another user", str(path))


def check_private(path: str | Path, about: os.stat_result) -> None:
    """Refuse an open file that others own or can write: PermissionError. `about`: of its handle."""
    _check_owner(Path(path), about)
    if not _closed(about):
        raise PermissionError(EPERM, "others can write it", str(path))


def _closed(about: os.stat_result, sticky: bool = False) -> bool:
    """Whether others can't write a file or folder; `sticky`: or can't exchange what is in it."""
    if not hasattr(os, "geteuid"):  # a system that keeps no rights in modes
        return True
    return not about.st_mode & (stat.S_IWGRP | stat.S_IWOTH) or (sticky and bool(about.st_mode & stat.S_ISVTX))
