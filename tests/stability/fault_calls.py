"""Which of a command's calls may fail: those of its own files, in strace's record of one run of it."""

import os
import re
from collections import defaultdict
from collections.abc import Hashable
from pathlib import Path

CALLS = {
    "open": (("open", "openat", "creat"), "EACCES"),
    "read": (("read", "pread64"), "EIO"),
    "write": (("write", "pwrite64"), "ENOSPC"),
    "sync": (("fsync", "fdatasync"), "EIO"),
    "rename": (("rename", "renameat", "renameat2"), "EACCES"),
    "room": (("fallocate", "ftruncate"), "ENOSPC"),
    "removal": (("unlink", "unlinkat"), "EPERM"),
    "memory": (("mmap",), "ENOMEM"),
}
COUNTED = tuple(name for calls, _ in CALLS.values() for name in calls)
STEPS = CALLS["sync"][0] + CALLS["rename"][0]  # what divides a command's work into stretches
CALL = re.compile(r"^(\d+) +(\w+)\((.*)")  # thread, name, arguments and what it gave
DRAWN = re.compile(r"[0-9a-f]{8,}|[a-z0-9_]{8}(?=\.part)")  # what is another each time in a file's name


def calls_of(log: Path, kind: str, mine: str) -> dict[int, Hashable]:
    """Numbers of the first thread's calls of a kind that concern files below a folder, and what is alike in them.

    Reads and writes are alike that are of the same file and of the same order of length, and between the same two
    syncs or renames of the command. No other call is like another.
    """
    names, first, number, stretch = CALLS[kind][0], None, 0, 0
    found: dict[int, Hashable] = {}
    for line in log.read_text(errors="replace").splitlines():
        match = CALL.match(line)
        if match is None:
            continue
        first = first or match[1]
        if match[1] != first:
            continue
        stretch += match[2] in STEPS
        if match[2] not in names:
            continue
        number += 1
        if _concerns(match[3], kind, mine):
            found[number] = _alike(match, stretch) if kind in ("read", "write") else number
    return found


def _concerns(arguments: str, kind: str, mine: str) -> bool:
    """Whether a call is of the command's own files; of memory, that which the loader of libraries does not ask for."""
    if kind == "memory":
        return "MAP_ANONYMOUS" in arguments and "MAP_FIXED" not in arguments
    arguments = arguments.split("AT_FDCWD", 1)[-1]
    path = re.sub(r"^<[^>]*>", "", arguments)  # the current folder is not what is opened
    named = re.search(r'"([^"]*)"', path) if kind in ("open", "rename", "removal") else None
    place = os.path.join(mine, "work", named[1]) if named else arguments
    return mine in place and "site-packages" not in place


def _alike(match: re.Match[str], stretch: int) -> Hashable:
    file, length = re.search(r"<([^>]*)>", match[3]), re.search(r", (\d+)(, \d+)?\) += ", match[3])
    name = DRAWN.sub("#", file[1]) if file else ""
    return stretch, match[2], name, int(length[1]).bit_length() if length else 0


def ends(calls: dict[int, Hashable]) -> list[int]:
    """The first and the last of calls that are alike."""
    groups = defaultdict(list)
    for number, alike in calls.items():
        groups[alike].append(number)
    return sorted({number for numbers in groups.values() for number in (numbers[0], numbers[-1])})
