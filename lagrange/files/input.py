"""Files that users and other files name: read whole, or refused in a few words; tables in them: `tables`."""

import errno
import hashlib
import os
import stat
from pathlib import Path

from lagrange.files.private import check_private

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


def not_text(data: bytes, at: int) -> str:
    """Why bytes that begin so are not UTF-8, and what to do; `at`: the first that can't be read."""
    what = next((what for start, what in FOREIGN.items() if data.startswith(start)), None)
    return f"not UTF-8 text (byte {at}): {what or 'save it as UTF-8, if it is text in Latin-1 or another code'}"


def read_plain(path: str | Path, most: int = -1, private: bool = False) -> bytes:
    """The first `most` bytes of a plain file, or all.

    Errors
    ------
    OSError: it can't be read, or is no plain file: a pipe would be waited for, a device may never end; of a private one
    also that others own it or can write it. ValueError: its name holds a null character.
    """
    with open(path, "rb", opener=_without_waiting) as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            raise OSError(errno.EINVAL, "a pipe or a device, not a plain file", str(path))
        if private:
            check_private(path, about)
        return file.read(min(most, max(about.st_size + 1, ROOM)))  # room for all that is asked for is made beforehand


def plain_text(path: str | Path, most: int) -> str:
    """The text of a plain file of at most `most` bytes, UTF-8 with or without a mark.

    Errors
    ------
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


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


LARGEST_FILE = 4 * 2**20  # bytes


def digest(text: str) -> str:
    """By which a table's text is known again: its SHA-256."""
    return hashlib.sha256(text.encode()).hexdigest()
