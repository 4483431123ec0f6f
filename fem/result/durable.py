"""Files in folders that several runs share; writes that say when they fail."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lagrange.files.output import BINARY

try:
    import fcntl
except ImportError:  # not a POSIX system: files are not locked there
    fcntl = None


@contextmanager
def alone_in(folder: Path, wait: bool = True) -> Iterator[None]:
    """Hold a folder while a file in it is examined and exchanged, so that no other run does the same in between.

    Without effect on file systems that can't lock a folder. BlockingIOError: another holds it, and `wait` is False.
    """
    if fcntl is None:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            raise
        except OSError:
            pass
        yield
    finally:
        os.close(handle)


def is_in_use(path: Path) -> bool:
    """Whether another program has locked a file, as runs and HDF5 do. OSError: it can't be opened for writing."""
    with open(path, "r+b") as file:
        return not _locked(file.fileno(), exclusively=True)


def open_locked(path: Path) -> int:
    """Open a file to write it, where others may read it but see by its lock that it is in use; the handle."""
    handle = os.open(path, os.O_RDWR | BINARY)
    _locked(handle, exclusively=False)
    return handle


def _locked(handle: int, exclusively: bool) -> bool:
    """Lock a file; False where another has locked it. True on file systems without locks."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(handle, (fcntl.LOCK_EX if exclusively else fcntl.LOCK_SH) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def write_at(handle: int, data: bytes, place: int) -> None:
    """Write all of it there. OSError: the disk fails."""
    view = memoryview(data)
    os.lseek(handle, place, os.SEEK_SET)  # pwrite is not on every system
    while view:
        view = view[os.write(handle, view) :]


def claim(handle: int, size: int) -> None:
    """Reserve a file's bytes on the disk, so that writing them later can't fail for want of room.

    Errors
    ------
    OSError: the disk hasn't so many bytes.
    """
    if not hasattr(os, "posix_fallocate"):
        return
    try:
        os.posix_fallocate(handle, 0, size)
    except OSError as error:
        raise OSError(error.errno, f"{error.strerror}: {size / 1e6:.3g} MB are needed") from None
