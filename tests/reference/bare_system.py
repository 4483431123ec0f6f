"""A process that starts as on a system other than Linux: what that lacks is taken away before the program is imported.

Run with -c this module's `PROGRAM`, then the entry point. Files opened as text without an encoding are read and written
in Windows' code page, and so is what is printed.
"""

import os
import subprocess
import sys
from pathlib import Path

from tests.reference.kit import ENTRIES, environment

LACKING = ("fork", "forkpty", "pwrite", "pread", "posix_fallocate", "geteuid", "sched_getaffinity", "sysconf", "mkfifo")
MODULES = ("fcntl", "resource", "pwd", "grp", "termios")
CODE_PAGE = "cp1252"
PROGRAM = f"""
import builtins, io, os, sys
for name in {LACKING!r}:
    if hasattr(os, name):
        delattr(os, name)
sys.modules |= dict.fromkeys({MODULES!r})
plain, rename = io.open, os.replace
def in_code_page(file, mode="r", buffering=-1, encoding=None, *rest, **more):
    if "b" not in mode and encoding in (None, "locale"):
        encoding = {CODE_PAGE!r}
    return plain(file, mode, buffering, encoding, *rest, **more)
builtins.open = io.open = in_code_page
def of_closed_files(old, new, **more):
    links = [os.path.realpath(f"/proc/self/fd/{{number}}") for number in os.listdir("/proc/self/fd")]
    for path in (old, new):
        if os.path.realpath(path) in links:
            raise PermissionError(13, "The process cannot access the file because it is being used", str(path))
    rename(old, new, **more)
os.replace = os.rename = of_closed_files
"""


def bare(name: str, *arguments: object, folder: Path) -> subprocess.CompletedProcess:
    """Run a command there to its end."""
    words = [sys.executable, "-P", "-c", f"{PROGRAM}\n{ENTRIES[name]}\nmain()", *map(str, arguments)]
    bare_environment = environment(PYTHONIOENCODING=CODE_PAGE, PYTHONUTF8="0")
    return subprocess.run(words, cwd=folder, env=bare_environment, capture_output=True, timeout=300.0)


def can_be_made_bare() -> bool:
    """Whether open files can be listed here, as Linux lists them."""
    return os.path.isdir("/proc/self/fd")
