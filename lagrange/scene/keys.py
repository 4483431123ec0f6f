"""Every key of the scene with what it means, read off the models: for people who write scenes.

A key's meaning, unit, limits and default stand once, in its table's class; the whole scene as a commented file, the
handbook's page and the JSON schema are made from there.
"""

from dataclasses import dataclass
from textwrap import wrap
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

import annotated_types
import tomli_w
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from lagrange.scene.scene import Scene

UNITS = {  # endings of keys
    "GPa": "GPa", "kg_m3": "kg/m³", "rpm": "rpm", "N_per_m": "N/m", "N_s_m": "N s/m", "N_m": "N m", "N": "N",
    "N_per_m_n": "N/mⁿ", "N_m_rad": "N m/rad", "mrad": "mrad",
    "kg_m2": "kg m²", "kg": "kg", "g_mm": "g mm", "m_s2": "m/s²", "deg": "°", "mm": "mm", "um": "µm", "us": "µs",
    "ms": "ms", "kHz": "kHz", "Hz": "Hz", "s_m": "s/m", "1_s": "1/s",
    "Pa_s": "Pa s", "1_Pa": "1/Pa", "1_K": "1/K", "C": "°C",
}  # fmt: skip
WIDTH, COMMENT_AT = 120, 38  # characters
LOWEST = {annotated_types.Ge: "from", annotated_types.Gt: "above"}
HIGHEST = {annotated_types.Le: "to", annotated_types.Lt: "below"}


@dataclass(frozen=True, kw_only=True)
class Key:
    """A key of a table."""

    name: str
    default: Any  # None: it has none
    meaning: str  # empty: nobody has written it
    unit: str
    limits: str  # in words: numbers or choices


@dataclass(frozen=True, kw_only=True)
class KeyTable:
    """A table of the scene; the scene's own keys have no name."""

    name: str
    meaning: str
    many: bool  # [[name]], any number
    given: bool  # whether a scene without it has it all the same
    keys: tuple[Key, ...]


def key_tables(
    model: type[BaseModel] = Scene, name: str = "", many: bool = False, given: bool = True
) -> list[KeyTable]:
    """All tables, in the scene's order; a table's own tables follow it."""
    own, inner = [], []
    for key, field in model.model_fields.items():
        kind, is_many, is_given = _table_kind(field)
        if kind is not None:
            inner += key_tables(kind, f"{name}.{key}".lstrip("."), is_many, given and is_given)
        elif not field.exclude:
            own.append(_key(key, field))
    meaning = (model.__doc__ or "").strip().partition("\n")[0]
    return [KeyTable(name=name, meaning=meaning, many=many, given=given, keys=tuple(own)), *inner]


def _table_kind(field: FieldInfo) -> tuple[type[BaseModel] | None, bool, bool]:
    """The class of a field's tables, whether there may be many, and whether they are there without being written."""
    kinds = [field.annotation]
    while kinds and get_origin(kinds[0]) in (list, tuple, Union, UnionType):
        kinds = [kind for kind in get_args(kinds[0]) if kind not in (type(None), Ellipsis)]
    many = get_origin(field.annotation) in (list, tuple)
    if kinds and isinstance(kinds[0], type) and issubclass(kinds[0], BaseModel):
        return kinds[0], many, not many and field.default is not None
    return None, False, False


def unit_of(name: str) -> str:
    """The unit that a key spells; empty where it spells none."""
    return next((unit for ending, unit in UNITS.items() if name.endswith(f"_{ending}")), "")


def name_in_words(name: str) -> str:
    """A key without the unit that it spells: "radial_load_N" is a radial load."""
    ending = next((ending for ending in UNITS if name.endswith(f"_{ending}")), "")
    return name.removesuffix(f"_{ending}").replace("_", " ")


def _key(name: str, field: FieldInfo) -> Key:
    return Key(
        name=name,
        default=None if field.default is PydanticUndefined else field.default,
        meaning=field.description or "",
        unit=unit_of(name),
        limits=_limits(field),
    )


def _limits(field: FieldInfo) -> str:
    """Choices, or the range of a number."""
    kinds = [field.annotation, *get_args(field.annotation)]
    for kind in kinds:
        if get_origin(kind) is Literal:
            return ", ".join(f'"{choice}"' for choice in get_args(kind))
    words = []
    for signs, slots in ((LOWEST, ("ge", "gt")), (HIGHEST, ("le", "lt"))):
        for limit in field.metadata:
            if type(limit) in signs:
                bound = next(getattr(limit, slot) for slot in slots if hasattr(limit, slot))
                words.append(f"{signs[type(limit)]} {bound:,g}".replace(",", " "))
    return " ".join(words)


def scene_with_every_key() -> str:
    """A TOML file with every key, its default and its meaning; what a scene need not have stands as comments."""
    lines = ["# Every key of a scene, with its default. A scene needs only what differs."]
    for table in key_tables():
        if not table.name:
            lines += [""] if table.keys else []
        else:
            header = f"[[{table.name}]]" if table.many else f"[{table.name}]"
            lines += ["", *_commented(header if table.given else f"# {header}", table.meaning)]
        for key in table.keys:
            lines += _key_lines(key, table.given)
    return "\n".join(lines) + "\n"


def _key_lines(key: Key, given: bool) -> list[str]:
    value = "" if key.default is None else tomli_w.dumps({key.name: key.default}).strip()
    sentence = "; ".join(part for part in (key.meaning, key.limits) if part)
    written = value or f"{key.name} ="
    return _commented(written if given and value else f"# {written}", sentence)


def _commented(text: str, sentence: str) -> list[str]:
    """A line with its comment, which goes on below where it is long."""
    parts = wrap(sentence, WIDTH - COMMENT_AT - 2) or [""]
    first = f"{text:<{COMMENT_AT - 1}} # {parts[0]}" if parts[0] else text
    return [first, *(f"{'':<{COMMENT_AT}}# {part}" for part in parts[1:])]
