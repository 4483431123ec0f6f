"""Files that users and other files name: read whole, or refused in a few words; folders that nobody else may write."""

import errno
import hashlib
import os
import stat
from contextlib import suppress
from pathlib import Path

LARGEST_FILE = 4 * 2**20  # bytes
ROOM = 2**16  # bytes, of files whose size the system does not know
FOREIGN = {  # first bytes of files that are no text: what they are, and how to make a table of them
    b"PK\x03\x04": "an Excel workbook or an archive; save the sheet as CSV UTF-8",
    b"\xd0\xcf\x11\xe0": "an Excel workbook; save the sheet as CSV UTF-8",
    b"PAR1": 'a Parquet file; pandas.read_parquet(file).to_csv("table.csv", index=False) makes a table of it',
    b"MATLAB": 'a MATLAB file; writetable(T, "table.csv") in MATLAB makes a table of it',
    b"\x1f\x8b": "compressed; unpack it by gunzip",
    b"\xff\xfe": "UTF-16 text; save it as UTF-8",
    b"\xfe\xff": "UTF-16 text; save it as UTF-8",
}


def user_cache(name: str = "") -> Path:
    """The user's cache folder, or one in it; errors as `private_folder`."""
    import platformdirs

    return private_folder(Path(platformdirs.user_cache_dir("roller-bearing-fem")) / name)


def private_folder(path: Path) -> Path:
    """A folder's real path, made where it is missing, below folders that belong to this user or to root alone.

    Others may write a folder above it where each may exchange only what is his own, as in the shared temporary folder.
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
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
        if _is_open(about) and not (folder != real and about.st_mode & stat.S_ISVTX):
            raise PermissionError(errno.EPERM, "others can write there; close it by chmod go-w", str(folder))
    return real


def _check_owner(path, about):
    if hasattr(os, "geteuid") and about.st_uid not in (0, os.geteuid()):
        raise PermissionError(errno.EPERM, "belongs to another user", str(path))


def _is_open(about):
    """Whether others can write a file or folder, on systems that keep rights in modes."""
    return hasattr(os, "geteuid") and bool(about.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


def not_text(data: bytes, at: int) -> str:
    """Why bytes that begin so are not UTF-8, and what to do; `at`: the first that can't be read."""
    what = next((what for start, what in FOREIGN.items() if data.startswith(start)), None)
    return f"not UTF-8 text (byte {at}): {what or 'save it as UTF-8, if it is text in Latin-1 or another code'}"


def read_plain(path: str | Path, most: int = -1, private: bool = False) -> bytes:
    """The first `most` bytes of a plain file, or all.

    OSError: it can't be read, or is no plain file: a pipe would be waited for, a device may never end; of a private one
    also that others own it or can write it. ValueError: its name holds a null character.
    """
    nonblocking = getattr(os, "O_NONBLOCK", 0)
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | nonblocking)) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "a pipe or a device, not a plain file", str(path))
        if private:
            _check_owner(path, about)
            if _is_open(about):
                raise PermissionError(errno.EPERM, "others can write it", str(path))
        return file.read(min(most, max(about.st_size + 1, ROOM)))  # room for all that is asked for is made beforehand


def plain_text(path: str | Path, most: int) -> str:
    """The text of a plain file of at most `most` bytes, UTF-8 with or without a mark.

    ValueError, what is wrong, without the file's name: it can't be read, is too large, or not UTF-8.
    """
    try:
        data = read_plain(path, most + 1)
    except (OSError, ValueError) as error:
        raise ValueError(f"can't be read: {getattr(error, 'strerror', None) or error}") from None
    if len(data) > most:
        raise ValueError(f"larger than {most // 2**20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(not_text(data, error.start)) from None


def digest(text: str) -> str:
    """By which a table's text is known again: its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()
