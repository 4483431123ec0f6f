"""The scene as text: nested tables, values under dotted keys, and the files that it names.

A scene's own text keeps a file's name and the digest of its text; a result file keeps the text itself.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from lagrange.files.input import LARGEST_FILE, digest, plain_text
from lagrange.messages import shown
from lagrange.scene.axial import SHAPES, SURFACES
from lagrange.scene.faults import SceneError, quoted


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
    """Put the files of [[profile]], [operation], [lagrange] and [axial] into the tables of a scene in a folder.

    Errors
    ------
    ValueError: no such file, unreadable, too large, not text; not the one whose digest the scene gives.
    """
    for named in _named(data):
        text = _text(named, folder / named.table[named.name])
        if named.table.setdefault(named.digest, digest(text)) != digest(text):
            raise ValueError(
                f"{named.described}: its sha256 is {digest(text)}, another than the scene gives; leave the sha256 out "
                "for this file"
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
    table: Any
    profiles = data.get("profile")
    for i, table in enumerate(profiles if isinstance(profiles, list) else ()):
        yield from _file(_Named(f"profile.{i}", table, "file", "sha256", "content", "heights"))
    for place, name, kind in (
        ("operation", "speed_table", "speeds"),
        ("operation", "outer_ring_speed_table", "speeds"),
        ("operation", "load_table", "loads"),
        ("lagrange", "law_table", "forces"),
    ):
        table = data.get(place)
        yield from _file(_Named(place, table, name, f"{name}_sha256", f"{name}_content", kind))

    axial: Any = data.get("axial")
    for surface in SURFACES:
        name = f"{surface}_profile"
        if isinstance(axial, dict) and axial.get(name) not in SHAPES:
            yield from _file(_Named("axial", axial, name, f"{name}_sha256", f"{name}_content", "drops"))


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
        forms = f"; forms are {', '.join(SHAPES)}" if named.place == "axial" else ""
        hint = f" (looked for in {path.parent.resolve()}){forms}" if missed else f"; is it a table of {named.kind}?"
        raise ValueError(f"{named.described}: {error}{hint}") from None


LONGEST_TEXT = 2**20  # characters of a scene
MOST_PARTS = 50  # of a dotted key; the memory to read one grows by their square
_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+"""
_DOTTED = re.compile(rf"(?:{_PART}\.[ \t]*+)++")


def load(text: str, name: str) -> dict[str, Any]:
    """Tables of a TOML text."""
    if len(text) > LONGEST_TEXT:
        raise SceneError(f"{name}: longer than {LONGEST_TEXT} characters; is it a scene file?")
    if long := next((key[0] for key in _DOTTED.finditer(text) if key[0].count(".") >= MOST_PARTS), None):
        raise SceneError(f"{name}: {quoted(long)}: a key of more than {MOST_PARTS} parts; is it a scene file?")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{name}: not valid TOML: {error}{_hint(text, str(error))}") from None
    except RecursionError:
        raise SceneError(f"{name}: not a scene: arrays or tables are nested too deeply") from None
    except ValueError as error:  # Python's own limit on the digits of a whole number
        raise SceneError(f"{name}: not a scene: {str(error).partition(';')[0]}") from None


def _hint(text: str, reason: str) -> str:
    """The line at which TOML can't be read, and what is often wrong with such a one; empty where it is not known."""
    number = re.search(r"line (\d+)", reason)
    lines = text.split("\n")
    if number is None or int(number[1]) > len(lines):
        return ""
    line = shown(lines[int(number[1]) - 1].strip())
    value = line.partition("=")[2].strip()
    if re.match(r"[-+]?\d+,\d", value):
        return f": {line}: write a decimal point"
    return f": {line}: put text in quotes" if re.match(r"[A-Za-z]", value) else f": {line}"


def apply_override(data: dict[str, Any], override: str) -> None:
    """Put `table.key=value` into nested tables; the value is TOML, or a plain string."""
    key, equals, text = override.partition("=")
    if not equals or not all(part.strip() for part in key.split(".")):
        raise SceneError(f"--set {override!r}: must read table.key=value, e.g. --set operation.speed_rpm=3000")
    try:
        found = load(f"value = {text}", "")
    except SceneError:
        found = {}
    value = found["value"] if set(found) == {"value"} else text.strip()  # more than one: a string with line breaks
    set_key(data, key, value, f"--set {override!r}")


def set_key(data: dict[str, Any], key: str, value: Any, origin: str) -> None:
    """Put a value under a dotted key into nested tables; numbers count the entries of an array, as in spall.0.width_mm.

    Parameters
    ----------
    origin : name of the request in an error message

    Errors
    ------
    SceneError: the key leads through a value, to a whole table or past the end of an array.
    """
    parts = [part.strip() for part in key.split(".")]
    if not all(parts):
        raise SceneError(f"{origin}: {key!r} must read table.key, e.g. operation.speed_rpm")
    table: Any = data
    for part, after in pairwise(parts):
        table = _entry(table, part, [] if after.isdecimal() else {}, origin)
    if isinstance(table, list):
        _set_item(table, parts[-1], value, origin)
    else:
        table[parts[-1]] = value


def _set_item(values: list, number: str, value: Any, origin: str) -> None:
    """Put a value into a list of values, as in bearing.missing_rollers.0; not into an array of tables."""
    if not number.isdecimal() or int(number[:9]) > len(values):
        raise SceneError(f"{origin}: {number} is none of {len(values)} entries; numbers go on from 0")
    if any(isinstance(each, dict) for each in values):
        raise SceneError(f"{origin}: {number} is a whole table; set one of its keys")
    values[int(number) : int(number) + 1] = [value]


def _entry(table: dict[str, Any] | list, key: str, empty: dict | list, origin: str) -> dict[str, Any] | list:
    """The table, or the array of tables, under a key or a number; made where there is none."""
    if isinstance(table, dict):
        found = table.setdefault(key, empty)
    else:
        if not key.isdecimal() or int(key[:9]) > len(table):
            raise SceneError(f"{origin}: {key} is none of {len(table)} tables; numbers go on from 0")
        table.extend([empty] if int(key) == len(table) else [])
        found = table[int(key)]
    if not isinstance(found, dict | list):
        raise SceneError(f"{origin}: {key} is a value, not a table")
    return found
