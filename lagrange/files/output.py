"""Files that commands write: whole or not at all, in no foreign file's place, through no foreign link or pipe; pages.

A file is made under a drawn name of this program's own beside its place, and then moved there (`replaced`). No name is
foreseeable, so nothing can have been laid in its way; `remove_left` takes away what killed processes have left under
such names. Meshes, assembled matrices and compiled kernels are sealed by a digest: a file that is cut, zeroed or has a
flipped bit is known. Pages and figures: libraries loaded undisturbed by settings, and what the commands' pages share.
"""

import errno
import hashlib
import os
import re
import secrets
import stat
import sys
from collections.abc import Iterator
from contextlib import chdir, contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from lagrange.files.input import read_plain

if TYPE_CHECKING:
    from markupsafe import Markup

BINARY = getattr(os, "O_BINARY", 0)  # Windows would translate line ends in what is read and written
NEW = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | BINARY
STYLE = Path(__file__).parents[1] / "page.css"
VENDOR = STYLE.parent / "vendor"
_SIZE = hashlib.sha256().digest_size


def real_path(path: Path) -> Path:
    """Where a link leads; else the path as it was given. OSError: links that lead round in a circle."""
    real = Path(os.path.realpath(path)) if path.is_symlink() else path
    if real.is_symlink():
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    return real


def refuse_special(path: Path) -> None:
    """Refuse a place where something other than a plain file stands: OSError."""
    with suppress(FileNotFoundError):
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise OSError(errno.EINVAL, "is a folder, a pipe or a device, not a plain file", str(path))


@contextmanager
def replaced(path: str | Path, durable: bool = False) -> Iterator[Path]:
    """An empty new file, to be written and closed, that is moved to `path` at the end, or removed after an error.

    `durable` : it is brought to the disk first. OSError, which names `path`: it can't be made or written, or is there
    and no plain file. What stands there stays.
    """
    path = real_path(Path(path))
    refuse_special(path)
    part = new_part(path)
    try:
        yield part
        if durable:
            with open(part, "r+b") as file:
                os.fsync(file.fileno())
            move_into_place(part, path)
        else:
            os.replace(part, path)
    except OSError as error:
        raise named(error, path, part) from None
    finally:
        part.unlink(missing_ok=True)


def move_into_place(temporary: Path, path: Path) -> None:
    """Give a file that is on the disk its final name; a power cut leaves the old file or the new one.

    Neither of the two may be open: not every system renames such.
    """
    os.replace(temporary, path)
    with suppress(OSError):  # some file systems can't sync a folder
        handle = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def named(error: OSError, path: Path, part: Path) -> OSError:
    """An error as one of `path`, where it names no file or one in or at its `part`."""
    if error.filename is not None and not Path(os.fsdecode(error.filename)).is_relative_to(part):
        return error
    return OSError(error.errno or errno.EIO, error.strerror or f"can't be written: {error}", str(path))


def write_whole(path: str | Path, data: bytes) -> None:
    """Write a file that appears whole or not at all; errors as `replaced`."""
    with replaced(path) as part:
        part.write_bytes(data)


def new_part(path: Path) -> Path:
    """Make an empty file, to be moved to `path` later, under a name that no file has. OSError names `path`."""
    part = path.with_name(f"{_start(path)}{secrets.token_hex(4)}.part")
    try:
        os.close(os.open(part, NEW, 0o666))
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    return part


def remove_left(path: Path) -> None:
    """Remove what killed processes have left of files on their way to `path`, to which nobody writes now."""
    ours = re.compile(re.escape(_start(path)) + r"[0-9a-f]{8}\.part")
    for entry in path.parent.iterdir():
        if ours.fullmatch(entry.name):
            with suppress(OSError):  # another user's, or a folder
                entry.unlink()


def _start(path):
    """What the names of its parts begin with, of one length, so that a name that the disk takes has parts."""
    return f".roller-bearing-{hashlib.sha256(os.fsencode(path.name)).hexdigest()[:8]}-"


def write_sealed(path: Path, data: bytes) -> None:
    """Write a file and its seal, behind the data, and move it into place. OSError: an earlier file stays."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, data + hashlib.sha256(data).digest())


def read_sealed(path: Path, private: bool = False) -> bytes | None:
    """The data of a sealed file; None if it is not what was written. OSError: as `read_plain`."""
    whole = read_plain(path, private=private)
    data, seal = whole[:-_SIZE], whole[-_SIZE:]
    return data if len(seal) == _SIZE and hashlib.sha256(data).digest() == seal else None


def load_matplotlib() -> None:
    """Load matplotlib with its own defaults, and to draw into memory. One that is loaded already stays as it is.

    It looks for `matplotlibrc` in the current folder first, then where MATPLOTLIBRC leads.
    """
    if "matplotlib" in sys.modules:
        return
    before = {name: os.environ.get(name) for name in ("MATPLOTLIBRC", "MPLBACKEND")}
    os.environ.update(MATPLOTLIBRC=os.devnull, MPLBACKEND="Agg")
    try:
        with chdir(Path(__file__).parent):
            import_module("matplotlib")
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            os.environ.update({} if value is None else {name: value})


def render_page(template: Path, **values: object) -> str:
    """The text of a page, with uPlot in it: it must open without a network."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    folders = FileSystemLoader([template.parent, STYLE.parent])  # page.j2 has tables and pictures
    environment = Environment(loader=folders, autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True)  # fmt: skip
    return environment.get_template(template.name).render(
        page_style=as_it_is(STYLE), plot_style=as_it_is(VENDOR / "uPlot.min.css"),
        plot_library=as_it_is(VENDOR / "uPlot.iife.min.js"), **values)  # fmt: skip


def as_it_is(path: Path) -> "Markup":
    """A style or script that goes into a page unescaped."""
    from markupsafe import Markup

    return Markup(path.read_text(encoding="utf-8"))
