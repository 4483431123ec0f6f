"""Files that a scene names: their text is put into its tables, from beside the scene or out of a result file.

A scene's own text keeps a file's name and the digest of its text; a result file keeps the text itself.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from lagrange.height_table import LARGEST_FILE, digest


def content_in_place(data: dict[str, Any], folder: Path) -> None:
    """Put the files of [[profile]] into the tables of a scene that lies in a folder.

    Errors
    ------
    ValueError: no such file, unreadable, too large, not text; not the one whose digest the scene gives.
    """
    for place, table in _tables(data):
        text = _text(f'{place}.file = "{table["file"]}"', folder / table["file"])
        if table.setdefault("sha256", digest(text)) != digest(text):
            raise ValueError(
                f'{place}.file = "{table["file"]}": its sha256 is {digest(text)}, another than the scene gives; leave '
                "that out for this file"
            )
        table["content"] = text


def content_of(data: dict[str, Any], files: Mapping[str, str] | None) -> None:
    """The same from texts by their digests; None: all stay out.

    Errors
    ------
    ValueError: one is not among them.
    """
    for place, table in _tables(data):
        if files is not None:
            if table.get("sha256") not in files:
                raise ValueError(f'{place}.file = "{table["file"]}": its text is not here')
            table["content"] = files[table["sha256"]]


def _tables(data: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The tables that name a file, with their places; others are left to the scene's own checks."""
    tables = data.get("profile")
    for i, table in enumerate(tables if isinstance(tables, list) else ()):
        if isinstance(table, dict):
            if "content" in table:
                raise ValueError(f"profile.{i}.content: unknown key; heights are read from its file")
            if isinstance(table.get("file"), str) and table["file"]:
                yield f"profile.{i}", table


def _text(what: str, path: Path) -> str:
    try:
        with open(path, "rb") as file:
            found = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:  # ValueError: a name with a null character
        reason = getattr(error, "strerror", None) or str(error)
        raise ValueError(f"{what}: can't be read: {reason} (looked for in {path.parent.resolve()})") from None
    if len(found) > LARGEST_FILE:
        raise ValueError(f"{what}: larger than {LARGEST_FILE // 2**20} MiB; is it a table of heights?")
    try:
        return found.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{what}: not UTF-8 text (byte {error.start}); is it a table of heights?") from None
