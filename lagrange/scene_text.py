"""TOML text as nested tables, and values put under dotted keys of them, as --set and studies do."""

import tomllib
from itertools import pairwise
from typing import Any

from lagrange.scene_faults import SceneError

LONGEST_TEXT = 2**20  # characters of a scene


def load(text: str, name: str) -> dict[str, Any]:
    """Tables of a TOML text."""
    if len(text) > LONGEST_TEXT:
        raise SceneError(f"{name}: longer than {LONGEST_TEXT} characters; is it a scene file?")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{name}: not valid TOML: {error}") from None
    except RecursionError:
        raise SceneError(f"{name}: not a scene: arrays or tables are nested too deeply") from None
    except ValueError as error:  # Python's own limit on the digits of a whole number
        raise SceneError(f"{name}: not a scene: {str(error).partition(';')[0]}") from None


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


def set_key(data: dict[str, Any], key: str, value: Any, told: str) -> None:
    """Put a value under a dotted key into nested tables; numbers count the tables of an array, as in spall.0.width_mm.

    Parameters
    ----------
    told : how an error names what was asked for

    Errors
    ------
    SceneError: the key leads through a value, to a whole table or past the end of an array.
    """
    parts = [part.strip() for part in key.split(".")]
    if not all(parts):
        raise SceneError(f"{told}: {key!r} must read table.key, e.g. operation.speed_rpm")
    table: Any = data
    for part, after in pairwise(parts):
        table = _entry(table, part, [] if after.isdecimal() else {}, told)
    if isinstance(table, list):
        raise SceneError(f"{told}: {parts[-1]} is a whole table; set one of its keys")
    table[parts[-1]] = value


def _entry(table: dict[str, Any] | list, key: str, empty: dict | list, told: str) -> dict[str, Any] | list:
    """The table, or the array of tables, under a key or a number; made where there is none."""
    if isinstance(table, dict):
        found = table.setdefault(key, empty)
    else:
        if not key.isdecimal() or int(key[:9]) > len(table):
            raise SceneError(f"{told}: {key} is none of {len(table)} tables; numbers go on from 0")
        table.extend([empty] if int(key) == len(table) else [])
        found = table[int(key)]
    if not isinstance(found, dict | list):
        raise SceneError(f"{told}: {key} is a value, not a table")
    return found
