"""Where compiled kernels are kept: a folder named after the text of all modules beside this one, the user's alone.

Numba's cache looks at the file a function stands in, not at the files of the functions it inlines: after a change to
one kernel it would go on running the old code inside the others. Needs no compiler.

Of the ideal bearing's formulas kernels compile that of dampers, in a module of `lagrange`.
"""

import hashlib
import os
from functools import cache
from pathlib import Path

import platformdirs

from lagrange.contact import damping
from lagrange.files.input import private_folder

notices: list[str] = []  # sentences on what was wrong with folders and files so far


@cache
def version() -> str:
    """Of all kernels: two programs of one version compute the same bits on one machine."""
    checked = os.environ.get("NUMBA_BOUNDSCHECK", "0") not in ("", "0")  # `lanes`
    return digest(Path(__file__).parent) + ("-checked" if checked else "")


@cache
def cache_folder() -> Path | None:
    """Where this version's compiled kernels are kept: in NUMBA_CACHE_DIR or the user's cache folder; None: nowhere."""
    bases = os.environ.get("NUMBA_CACHE_DIR"), platformdirs.user_cache_dir("roller-bearing-fem")
    for folder in (Path(base) / "kernels" / version() for base in bases if base):
        try:
            return private_folder(folder)
        except PermissionError as error:
            notices.append(f"{folder}: compiled kernels there are not used: {error.filename}: {error.strerror}")
        except OSError:
            pass
    return None


def digest(folder: Path) -> str:
    """Of the text of all modules of a folder, and of dampers: any of them may be part of a kernel."""
    text = hashlib.sha256()
    for module in (*sorted(folder.rglob("*.py")), Path(damping.__file__)):
        text.update(module.name.encode() + module.read_bytes())
    return text.hexdigest()[:16]
