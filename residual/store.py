"""Folders of a command's results that appear whole or not at all: a page, its figures, summary.json."""

import json
import secrets
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from lagrange.errors import InputError
from lagrange.files.input import read_plain
from lagrange.files.output import load_matplotlib, named, real_path, render_page
from lagrange.version import VERSION


class Page(NamedTuple):
    name: str  # of its file
    template: Path
    shown: Mapping[str, Any]


def write_folder(
    folder: str | Path, program: str, summary: dict[str, Any], page: Page,
    draw: Callable[[Path], dict[str, list]] | None = None, more: Callable[[Path], None] = lambda fresh: None,
) -> dict[str, Any]:  # fmt: skip
    """Write a page, its figures and summary.json into a folder, which appears whole or not at all; gives the summary.

    summary : numbers of summary.json, to which program, version and names of all files are added
    draw : draws into a folder, by matplotlib, figures by groups; None: no figures
    more : writes what else the folder is to hold

    InputError: the folder holds something else. OSError: it can't be written. An earlier folder stays as it was then.
    """
    folder = real_path(Path(folder))
    check_replaceable(folder, program)
    folder.parent.mkdir(parents=True, exist_ok=True)
    fresh = folder.with_name(f".{folder.name}-{secrets.token_hex(4)}")  # known before it exists: no signal leaves it
    old = fresh.with_name(fresh.name + "-old")
    try:
        fresh.mkdir()
        if draw is not None:
            load_matplotlib()
        figures = {} if draw is None else draw(fresh)
        more(fresh)
        html = render_page(page.template, version=VERSION, figures=figures, **page.shown)
        (fresh / page.name).write_text(html, encoding="utf-8")
        files = sorted({path.name for path in fresh.iterdir()} | {"summary.json"})
        summary = {"program": program, "program_version": VERSION} | summary | {"files": files}
        said = json.dumps(summary, indent=1, allow_nan=False, ensure_ascii=False)
        (fresh / "summary.json").write_text(said + "\n", encoding="utf-8")
        if folder.exists():  # the old one goes last
            folder.rename(old)
        try:
            fresh.rename(folder)
        except BaseException:
            if old.exists():
                old.rename(folder)
            raise
        shutil.rmtree(old, ignore_errors=True)
    except BaseException as error:
        shutil.rmtree(fresh, ignore_errors=True)
        if isinstance(error, OSError):
            raise named(error, folder, fresh) from None
        raise
    return summary


def check_replaceable(folder: Path, program: str) -> None:
    """Refuse to touch anything but a missing or empty folder, or an earlier report of a program and nothing else."""
    folder = real_path(folder)
    if not folder.exists():
        return
    if not folder.is_dir():
        raise InputError(f"{folder}: is a file, not a folder; choose another --output")
    names = {entry.name for entry in folder.iterdir()}
    if not names:
        return
    try:
        summary = json.loads(read_plain(folder / "summary.json"))
        ours = set(summary["files"]) if summary["program"] == program else None
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        ours = None
    if ours is None:
        raise InputError(f"{folder}: not empty and no report of {program}; choose another --output or empty it")
    if foreign := sorted(names - ours):
        raise InputError(
            f"{folder}: holds {foreign[0]}, which is not part of a report; move it or choose another --output"
        )
