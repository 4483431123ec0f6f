"""What is wrong with a scene: all of it at once, in the user's words.

Pydantic judges values one by one and gives up on a table, and on all that lies above it, where one is unusable.
Contradictions between the values that can be used are therefore looked for once more here.
"""

import difflib
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from copy import deepcopy
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import ErrorDetails

from lagrange.errors import UsageError

SMALLEST = 1e-15  # of a number that is not 0, in its key's unit
LONGEST_QUOTE = 80  # characters of a value, or a key, in a message
MOST_FAULTS = 15  # named at once: a file that is no scene may have thousands
MOST_EXPLAINED = 200  # looked at for them; to find what was meant takes some milliseconds each
MISSPELT = 0.8  # of difflib's ratio: the same word with a slip
ABSENT = {  # what engineers ask for and the program lacks, by words of a key
    "axial loads": ("axial", "thrust"),
    "temperatures computed from heat ([fit] has given ones)": ("temperature", "thermal", "heat"),
    "applied moments": ("moment",),
    "grease": ("grease",),
    "keys of life and ratings (rate-bearing computes them)": ("life", "l10", "rating", "ratings", "c0"),
    "shapes of cage pockets": ("pocket", "pocket_shape"),
    "hollow rollers": ("hollow", "roller_bore"),
}
# keys of earlier versions: what they were by default, which scenes in their result files spell out, and what to do
GONE: dict[tuple[str, ...], tuple[Any, str]] = {
    ("reduced",): (
        {"modes_up_to_kHz": 0.0},
        'the reduced model no longer has modes; for elastic waves use model = "fem"',
    ),
    ("lagrange", "damping_N_s_m"): (None, "contacts are damped by damping.contact_N_s_m in all models; write it there"),
    ("axial", "skew"): ("guided", "rollers are always guided against skew; leave it out"),
    ("axial", "skew_play_mrad"): (None, "rollers are always guided against skew; leave it out"),
}
# keys of a file beside the scene, and the text that a result file keeps of it
FileName = Annotated[str, Field(min_length=1, max_length=1000)]
Digest = Annotated[
    str | None,
    Field(pattern=r"^[0-9a-f]{64}$", description="SHA-256 of the file's text; another text is refused"),
]
DecimalSign = Annotated[Literal[".", ","] | None, Field(description='decimal sign of the file; default "."')]
FileText = Annotated[SkipJsonSchema[str | None], Field(exclude=True, repr=False)]

Check = Callable[[], Iterator[str]]
Place = tuple[str | int, ...]  # keys from the scene down


class SceneError(UsageError):
    """The scene can't be used; the text names file, key, value and limit, one fault a line."""


class Table(BaseModel):
    """A table of the scene, or the scene itself."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)

    def __init__(self, /, **data: Any):
        """A table from its keys; SceneError: as `read_scene` gives it, all faults at once."""
        try:
            super().__init__(**data)
        except ValidationError as error:
            name = type(self).__name__
            faults = all_faults(error, type(self), {key: plain(value) for key, value in data.items()})
            raise SceneError("\n".join(f"{name}: {fault}" for fault in faults)) from None

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # as BaseModel's: tables inside need no call

    def checks(self) -> tuple[Check, ...]:
        """What may contradict itself in the table; each check gives a sentence for each thing that does."""
        return ()

    def all_checks(self) -> tuple[Check, ...]:
        return self._numbers, *self.checks()

    def _numbers(self) -> Iterator[str]:
        """Numbers so near to 0 that a square or a quotient of them is no number any more."""
        for name in type(self).model_fields:
            value = getattr(self, name, None)
            for number in value if isinstance(value, list) else [value]:
                if isinstance(number, float) and 0.0 < abs(number) < SMALLEST:
                    yield f"{name} = {number:g}: must be 0, or at least {SMALLEST:g} in size"

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table as written, with defaults that depend on it."""
        return data

    @model_validator(mode="before")
    @classmethod
    def _completed(cls, data):
        return cls.completed(data) if isinstance(data, dict) else data

    @model_validator(mode="after")
    def _consistent(self):
        faults = [fault for check in self.all_checks() for fault in check()]
        if faults:
            raise ValueError("\n".join(faults))
        return self


def all_faults(error: ValidationError, model: type[Table], data: dict[str, Any]) -> list[str]:
    """Each fault of the tables in a line, none twice; of very many the first, and how many more there are."""
    every = error.errors()
    found = every[:MOST_EXPLAINED]
    of_values = [fault for fault in found if fault["type"] != "value_error" or _is_of_one_value(fault, model)]
    lines = [line for fault in of_values for line in _explain(fault, model)]
    if found == every:  # else values that can't be used are still among those to be judged together
        lines += _contradictions(_usable(model, data, {_meant(fault, model) for fault in of_values}))
    if not lines:  # bodies that can't be made, which no check looks for
        lines = [line for fault in found for line in _explain(fault, model)]
    lines = [printable(line) for line in dict.fromkeys(lines)]
    more = len(lines) + len(every) - len(found) - MOST_FAULTS
    return [*lines[:MOST_FAULTS], f"and {more} more"] if more > 0 else lines


def without_gone(data: dict[str, Any]) -> dict[str, Any]:
    """A scene's tables without keys of earlier versions that say what now holds anyway."""
    for (name, *rest), (default, _) in GONE.items():
        table = data.get(name)
        if rest and isinstance(table, dict) and table.get(rest[0]) == default:
            data = data | {name: {key: value for key, value in table.items() if key != rest[0]}}
        elif not rest and table == default:
            data = {key: value for key, value in data.items() if key != name}
    return data


def plain(value: Any) -> Any:
    """A value of its own, tables in it as nested dictionaries of what they were given."""
    if isinstance(value, Table):
        return value.model_dump(exclude_unset=True)
    return [plain(item) for item in value] if isinstance(value, list) else deepcopy(value)


def printable(text: str) -> str:
    """The text without characters that would move a terminal's cursor or hide."""
    return "".join(c if c.isprintable() else "?" for c in text)


def _explain(fault: ErrorDetails, model: type[Table]) -> list[str]:
    """One pydantic fault, a line for each thing that is wrong."""
    place = ".".join(_quoted(str(part)) for part in fault["loc"])
    if fault["type"] == "extra_forbidden":
        if (gone := GONE.get(tuple(map(str, fault["loc"])))) is not None:
            return [f"{place}: {gone[1]}"]
        known = _keys(_table_at(fault["loc"][:-1], model))
        likely = _likely(fault["loc"], model)
        lacking = None if likely else _absent(str(fault["loc"][-1]))
        if lacking is not None:
            return [f"{place}: not supported: {lacking}; see docs/limits"]
        hint = f"did you mean {' or '.join(likely)}?" if likely else f"known here: {', '.join(known)}"
        return [f"{place}: unknown key; {hint}"]
    value = fault["input"]
    if fault["type"] == "value_error":
        return [_at(place, reason) for reason in str(fault["ctx"]["error"]).split("\n")]
    if fault["type"] == "list_type":
        return [f"{place} = {quoted(value)}: must be an array of tables, [[{place}]]"]
    if fault["type"] == "model_type":
        header = f"[[{fault['loc'][-2]}]]" if isinstance(fault["loc"][-1], int) else f"[{place}]"
        return [f"{place} = {quoted(value)}: must be a table, {header}"]
    reason = fault["msg"].removeprefix("Input ").replace("should", "must", 1)
    if fault["type"] in ("float_type", "int_type") and isinstance(value, str):
        reason += ", without quotes and unit"
    return [f"{place} = {quoted(value)}: {reason}"]


def _at(place: str, reason: str) -> str:
    return f"{place}: {reason}" if place else reason


def _quoted(key: str) -> str:
    """A key as it is, or as TOML would have to quote it."""
    return _short(key if key.isprintable() else repr(key))


def quoted(value: object) -> str:
    """A value of TOML as Python writes it, cut off where it is long."""
    try:
        return _short(repr(value))
    except ValueError:  # Python's own limit on the digits of a whole number
        return "a number of thousands of digits"


def _short(text: str) -> str:
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 3]}..."


def _table_at(place: Place, model: type[Table]) -> type[BaseModel]:
    table: Any = model
    for part in place:
        table = get_args(table)[0] if isinstance(part, int) else _kind(table.model_fields[part].annotation)
    return table


def _kind(annotation: Any) -> Any:
    """What a field holds; of a table that may be absent the table."""
    tables = [kind for kind in get_args(annotation) if _is_table(kind)]
    return tables[0] if tables and type(None) in get_args(annotation) else annotation


def _keys(model: type[BaseModel]) -> list[str]:
    """What a user may write in a table."""
    return [name for name, field in model.model_fields.items() if not field.exclude]


def _absent(key: str, instead: str = "") -> str | None:
    """What the program lacks that a key asks for and the key that is there instead does not; None: nothing."""
    for what, words in ABSENT.items():
        for word in words:
            if f"_{word}_" in f"_{key.lower()}_" and word not in instead:
                return what
    return None


def _likely(place: Place, model: type[Table]) -> list[str]:
    """Keys that were probably meant, unless they lack what was asked for."""
    return [key for key in _alike(place, model) if _absent(str(place[-1]), key) is None]


def _alike(place: Place, model: type[Table]) -> list[str]:
    """Keys like one: with it among their words or alike in the table, else of the same name elsewhere, dotted."""
    key, elsewhere, known = str(place[-1]), [], _keys(_table_at(place[:-1], model))
    if within := [each for each in known if f"_{key}_" in f"_{each}_"]:
        return within[:1]
    if near := difflib.get_close_matches(key, known, n=1, cutoff=MISSPELT):
        return near
    for name in model.model_fields:
        kind = (_tables(model) | _arrays(model)).get(name)
        if kind is not None and key in _keys(kind) and key not in _tables(kind):
            elsewhere.append(f"{name}.0.{key}" if name in _arrays(model) else f"{name}.{key}")
    alike = likely_of(key, known)
    return elsewhere or ([] if alike is None else [alike])


def likely_of(name: str, known: Iterable[str]) -> str | None:
    """The known name that was probably meant; None: none is near."""
    return next(iter(difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)), None)


def _meant(fault: ErrorDetails, model: type[Table]) -> Place:
    """The key whose value a fault leaves unknown."""
    place = fault["loc"]
    if fault["type"] != "extra_forbidden":
        return place
    likely = next(iter(_likely(place, model)), None)
    if likely is None:
        return place
    return tuple(likely.split(".")) if "." in likely else (*place[:-1], likely)


def _is_of_one_value(fault: ErrorDetails, model: type[Table]) -> bool:
    """Whether a fault is of one value, not of a table's values together."""
    place = fault["loc"]
    if not place or isinstance(place[-1], int):
        return False
    return place[-1] not in _tables(_table_at(place[:-1], model))


def _tables(model: type[BaseModel]) -> dict[str, type[Table]]:
    """The tables within a table."""
    kinds = {name: _kind(field.annotation) for name, field in model.model_fields.items()}
    return {name: kind for name, kind in kinds.items() if _is_table(kind)}


def _arrays(model: type[BaseModel]) -> dict[str, type[Table]]:
    """The arrays of tables within a table, by the kind of their tables."""
    kinds = {name: field.annotation for name, field in model.model_fields.items()}
    items = {name: get_args(kind)[0] for name, kind in kinds.items() if get_origin(kind) is list}
    return {name: kind for name, kind in items.items() if _is_table(kind)}


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Table)


def _usable(model: type[Table], data: dict[str, Any], unusable: set[Place], place: Place = ()) -> Table:
    """A table without the values that can't be used: who asks for them meets an AttributeError."""
    given = place not in unusable  # a table of an array may be no table
    data, inner, arrays = model.completed(data) if given else {}, _tables(model), _arrays(model)
    depth = len(place) + 1
    inside = {at[:depth] for at in unusable}  # a list of which an item can't be used can't be used
    left_out = [
        name
        for name in model.model_fields
        if not given or (*place, name) in (unusable if name in inner or name in arrays else inside)
    ]
    values = {name: value for name, value in data.items() if name in model.model_fields and name not in inner}
    for name, kind in inner.items():
        absent = name not in data and model.model_fields[name].default is None
        if name not in left_out and not absent:
            values[name] = _usable(kind, data.get(name, {}), unusable, (*place, name))
    for name, kind in arrays.items():
        if name not in left_out:
            items = enumerate(data.get(name, []))
            values[name] = [_usable(kind, item, unusable, (*place, name, i)) for i, item in items]
    table = model.model_construct(**values)
    for name in left_out:
        table.__dict__.pop(name, None)
    return table


def _contradictions(table: Table, place: str = "") -> Iterator[str]:
    """All that can be judged without the values left out."""
    for name in _tables(type(table)):
        if table.__dict__.get(name) is not None:
            yield from _contradictions(getattr(table, name), f"{place}.{name}".lstrip("."))
    for name in _arrays(type(table)):
        for i, item in enumerate(table.__dict__.get(name, [])):
            yield from _contradictions(item, f"{place}.{name}.{i}".lstrip("."))
    for check in table.all_checks():
        # a value left out, or bodies that can't be made of values that are named already
        with suppress(AttributeError, ValueError):
            for fault in check():
                yield _at(place, fault)
