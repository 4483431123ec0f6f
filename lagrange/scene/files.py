"""The scene as text: nested tables, and values under dotted keys."""

import re
import tomllib
from itertools import pairwise
from typing import Any

from lagrange.messages import shown
from lagrange.scene.faults import SceneError, quoted

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

    def check_number(number: str, what: str) -> None:
        if not number.isdecimal() or int(number[:9]) > len(table):
            raise SceneError(f"{origin}: {number} is none of {len(table)} {what}; numbers go on from 0")

    for part, after in pairwise(parts):  # a table, or an array of tables, is made where there is none
        empty: Any = [] if after.isdecimal() else {}
        if isinstance(table, dict):
            table = table.setdefault(part, empty)
        else:
            check_number(part, "tables")
            table.extend([empty] if int(part) == len(table) else [])
            table = table[int(part)]
        if not isinstance(table, dict | list):
            raise SceneError(f"{origin}: {part} is a value, not a table")
    last = parts[-1]
    if isinstance(table, dict):
        table[last] = value
        return
    check_number(last, "entries")  # of a list of values, as in bearing.missing_rollers.0
    if any(isinstance(each, dict) for each in table):
        raise SceneError(f"{origin}: {last} is a whole table; set one of its keys")
    table[int(last) : int(last) + 1] = [value]
