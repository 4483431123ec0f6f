"""Every key of the scene with what it means, read off the models: for people who write scenes.

A key's meaning, unit, limits and default stand once, in its table's class; the whole scene as a commented file, the
handbook's page and the JSON schema are made from there.
"""

from textwrap import wrap
from typing import Any, Literal, NamedTuple, get_args, get_origin

import tomli_w

from lagrange.scene.faults import Table, table_of, unit_of_key
from lagrange.scene.scene import Scene

WIDTH, COMMENT_AT = 120, 38  # characters
LIMITS = {"ge": "from", "gt": "above", "le": "to", "lt": "below"}  # in words, by the names that pydantic gives them


class Key(NamedTuple):
    """A key of a table."""

    name: str
    default: Any  # None: it has none
    meaning: str  # empty: nobody has written it
    unit: str
    limits: str  # in words: numbers or choices


class KeyTable(NamedTuple):
    """A table of the scene; the scene's own keys have no name."""

    name: str
    meaning: str
    many: bool  # [[name]], any number
    given: bool  # whether a scene without it has it all the same
    keys: tuple[Key, ...]


def key_tables(model: type[Table] = Scene, name: str = "", many: bool = False, given: bool = True) -> list[KeyTable]:
    """All tables, in the scene's order; a table's own tables follow it."""
    own, inner = [], []
    for key, field in model.model_fields.items():
        kind, is_many = table_of(field)
        if kind is not None:
            there = given and not is_many and field.default is not None
            inner += key_tables(kind, f"{name}.{key}".lstrip("."), is_many, there)
        elif not field.exclude:
            default, meaning = None if field.is_required() else field.default, field.description or ""
            own.append(Key(name=key, default=default, meaning=meaning, unit=unit_of(key), limits=_limits(field)))
    meaning = (model.__doc__ or "").strip().partition("\n")[0]
    return [KeyTable(name=name, meaning=meaning, many=many, given=given, keys=tuple(own)), *inner]


def unit_of(name: str) -> str:
    """The unit that a key spells; empty where it spells none."""
    return unit_of_key(name)[1]


def name_in_words(name: str) -> str:
    """A key without the unit that it spells: "radial_load_N" is a radial load."""
    return unit_of_key(name)[0].replace("_", " ")


def _limits(field):
    kinds = [field.annotation, *get_args(field.annotation)]
    for kind in kinds:
        if get_origin(kind) is Literal:
            return ", ".join(f'"{choice}"' for choice in get_args(kind))
    limits = list(field.metadata)
    for kind in kinds if get_origin(field.annotation) is not list else ():
        limits += [limit for each in getattr(kind, "__metadata__", ()) for limit in each.metadata]
    found = {name: getattr(limit, name) for limit in limits for name in LIMITS if hasattr(limit, name)}
    return " ".join(f"{word} {found[name]:,g}".replace(",", " ") for name, word in LIMITS.items() if name in found)


def scene_with_every_key() -> str:
    """A TOML file with every key, its default and its meaning; what a scene need not have stands as comments."""
    lines = ["# Every key of a scene, with its default. A scene needs only what differs."]
    for table in key_tables():
        lines.append("")
        if table.name:
            header = f"[[{table.name}]]" if table.many else f"[{table.name}]"
            lines += _commented(header if table.given else f"# {header}", table.meaning)
        for key in table.keys:
            value = "" if key.default is None else tomli_w.dumps({key.name: key.default}).strip()
            written = value or f"{key.name} ="
            sentence = "; ".join(part for part in (key.meaning, key.limits) if part)
            lines += _commented(written if table.given and value else f"# {written}", sentence)
    return "\n".join(lines) + "\n"


def _commented(text, sentence):
    """A line with its comment, which goes on below where it is long."""
    first, *others = wrap(sentence, WIDTH - COMMENT_AT - 2) or [""]
    yield f"{text:<{COMMENT_AT - 1}} # {first}" if first else text
    yield from (f"{'':<{COMMENT_AT}}# {part}" for part in others)
