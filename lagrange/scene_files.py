"""Files that a scene names: their text is put into its tables, from beside the scene or out of a result file.

A scene's own text keeps a file's name and the digest of its text; a result file keeps the text itself.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrange.plain_files import plain_text
from lagrange.text_table import LARGEST_FILE, digest


@dataclass(frozen=True)
class _Named:
    """Where a scene names a file: a table and its keys of name, digest and text."""

    place: str
    table: dict[str, Any]
    name: str
    digest: str
    content: str
    kind: str  # of table that the file is

    @property
    def described(self) -> str:
        return f'{self.place}.{self.name} = "{self.table[self.name]}"'


def content_in_place(data: dict[str, Any], folder: Path) -> None:
    """Put the files of [[profile]] and [operation] into the tables of a scene that lies in a folder.

    Errors
    ------
    ValueError: no such file, unreadable, too large, not text; not the one whose digest the scene gives.
    """
    for named in _named(data):
        text = _text(named, folder / named.table[named.name])
        if named.table.setdefault(named.digest, digest(text)) != digest(text):
            raise ValueError(
                f"{named.described}: its sha256 is {digest(text)}, another than the scene gives; leave that out for "
                "this file"
            )
        named.table[named.content] = text


def content_of(data: dict[str, Any], files: Mapping[str, str] | None) -> None:
    """The same from texts by their digests; None: all stay out.

    Errors
    ------
    ValueError: one is not among them.
    """
    for named in _named(data):
        if files is not None:
            if named.table.get(named.digest) not in files:
                raise ValueError(f"{named.described}: its text is not here")
            named.table[named.content] = files[named.table[named.digest]]


def _named(data: dict[str, Any]) -> Iterator[_Named]:
    """The files that a scene names; tables of other forms are left to the scene's own checks."""
    profiles = data.get("profile")
    for i, table in enumerate(profiles if isinstance(profiles, list) else ()):
        yield from _file(_Named(f"profile.{i}", table, "file", "sha256", "content", "heights"))
    for name, kind in (("speed_table", "speeds"), ("load_table", "loads")):
        operation: Any = data.get("operation")
        yield from _file(_Named("operation", operation, name, f"{name}_sha256", f"{name}_content", kind))


def _file(named: _Named) -> Iterator[_Named]:
    if isinstance(named.table, dict):
        if named.content in named.table:
            raise ValueError(f"{named.place}.{named.content}: unknown key; {named.kind} are read from a file")
        if isinstance(named.table.get(named.name), str) and named.table[named.name]:
            yield named


def _text(named: _Named, path: Path) -> str:
    try:
        return plain_text(path, LARGEST_FILE)
    except ValueError as error:
        missed = "can't be read" in str(error)
        hint = f" (looked for in {path.parent.resolve()})" if missed else f"; is it a table of {named.kind}?"
        raise ValueError(f"{named.described}: {error}{hint}") from None
