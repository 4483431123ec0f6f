"""What a table of the scene is made of, and what is wrong with one: all of it at once, in the user's words.

Types and keys come first: pydantic judges them value by value. What values may not be together, the RULES of a table,
is asked afterwards, of sound tables or of what is left of them without the values that can't be used.
"""

import difflib
from collections.abc import Callable, Iterable, Iterator
from copy import deepcopy
from functools import cache
from math import pi
from typing import Annotated, Any, ClassVar, Literal, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic.fields import FieldInfo
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
GONE: dict[tuple[str, ...], tuple[Any, str]] = {("reduced",): ({"modes_up_to_kHz": 0.0}, 'the reduced model no longer '
    'has modes; for elastic waves use model = "fem"'), ("lagrange", "damping_N_s_m"): (None, "contacts are damped by "
    "damping.contact_N_s_m in all models; write it there"), ("axial", "skew"): ("guided", "rollers are always guided "
    "against skew; leave it out"), ("axial", "skew_play_mrad"): (None, "rollers are always guided against skew; leave "
    "it out")}
RPM = 2.0 * pi / 60.0  # rad/s
UNITS: dict[str, tuple[str, float | None]] = {  # endings of keys: the unit, and how much it is in SI; None: it stays
    "GPa": ("GPa", 1e9), "kg_m3": ("kg/m³", 1.0), "rpm": ("rpm", RPM), "N_per_m": ("N/m", 1.0),
    "N_per_mm3": ("N/mm³", 1e9), "N_s_m": ("N s/m", 1.0), "N_m": ("N m", 1.0), "N": ("N", 1.0),
    "N_per_m_n": ("N/mⁿ", 1.0), "N_m_rad": ("N m/rad", 1.0), "mrad": ("mrad", 1e-3), "kg_m2": ("kg m²", 1.0),
    "kg": ("kg", 1.0), "g_mm": ("g mm", 1e-6), "m_s2": ("m/s²", 1.0), "deg": ("°", pi / 180.0), "mm": ("mm", 1e-3),
    "um": ("µm", 1e-6), "us": ("µs", 1e-6), "ms": ("ms", 1e-3), "kHz": ("kHz", 1e3), "Hz": ("Hz", 1.0),
    "s_m": ("s/m", 1.0), "1_s": ("1/s", 1.0), "Pa_s": ("Pa s", 1.0), "1_Pa": ("1/Pa", 1.0), "1_K": ("1/K", 1.0),
    "C": ("°C", None),
}  # fmt: skip

# kinds of values; of a file beside the scene its name, and the text that a result file keeps of it
Diameter = Annotated[float, Field(gt=0.0, le=10_000.0)]
Modulus = Annotated[float, Field(ge=0.1, le=2000.0)]
PoissonRatio = Annotated[float, Field(ge=0.0, le=0.45)]
Density = Annotated[float, Field(ge=100.0, le=30_000.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Angle = Annotated[float, Field(ge=-360.0, le=360.0)]
FileName = Annotated[str, Field(min_length=1, max_length=1000)]
Digest = Annotated[str | None, Field(pattern=r"^[0-9a-f]{64}$", description="SHA-256 of the file's text; another text "
    "is refused")]
DecimalSign = Annotated[Literal[".", ","] | None, Field(description='decimal sign of the file; default "."')]
FileText = Annotated[SkipJsonSchema[str | None], Field(exclude=True, repr=False)]

Place = tuple[str | int, ...]  # keys from the scene down
# what contradicts itself in a table: a generator of sentences on it, or a condition and the sentence where it holds, a
# template with the table as {t}
Rule = Callable[[Any], Iterator[str]] | tuple[Callable[[Any], Any], str]


class SceneError(UsageError):
    """The scene can't be used; the text names file, key, value and limit, one fault a line."""


def key(default: Any, meaning: str, least: float | None = None, most: float | None = None, **limits: Any) -> Any:
    """A key of a table: its default, what it means, the least and the largest value."""
    return Field(default, description=meaning, ge=least, le=most, **limits)


def only(keys: str, holds: Callable[[Any], Any], why: str) -> Rule:
    """Keys, in one text, that are given only where a condition holds, and what to say of them otherwise."""

    def rule(table: "Table") -> Iterator[str]:
        for name in () if holds(table) else keys.split():
            value = getattr(table, name)
            if value != type(table).model_fields[name].default:
                given = f'"{value}"' if isinstance(value, str) else f"{value:g}" if type(value) is float else value
                yield f"{name} = {given}: {why.format(t=table)}"

    return rule


class File:
    """A key of a table that names a file; the text comes with the scene, see `lagrange.scene.scene`."""

    def __init__(self, kind: str, read: Callable[[str, str], Any], forms: tuple[str, ...] = ()):
        self.kind = kind  # what such a table is of, in words
        self.read = read  # what a text with this decimal sign says, ValueError
        self.forms = forms  # values of the key that name no file


class Table(BaseModel):
    """A table of the scene, or the scene itself."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)
    RULES: ClassVar[tuple[Rule, ...]] = ()
    FILES: ClassVar[dict[str, File]] = {}  # by key

    def __init__(self, /, **data: Any):
        """A table from its keys; SceneError: as `read_scene` gives it, all faults at once."""
        self._fill(data, type(self).__name__)

    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]  # as BaseModel's: tables inside need no call

    @classmethod
    def parsed(cls, data: dict[str, Any], name: str) -> Self:
        """A table from its keys, nested tables from dictionaries; SceneError: all faults, each after a name."""
        table = cls.__new__(cls)
        table._fill(data, name)
        return table

    def _fill(self, data: dict[str, Any], name: str) -> None:
        every: list[ErrorDetails] = []
        try:
            super().__init__(**data)
            rest: Table = self
        except ValidationError as error:
            every, kind = error.errors(), type(self)
        unmade: list[ValueError] = []
        found = every[:MOST_EXPLAINED]
        lines = [_explain(fault, kind) for fault in found]
        if found:
            rest = _usable(kind, {k: plain(v) for k, v in data.items()}, {_meant(fault, kind) for fault in found})
        if found == every:  # else values that can't be used are still among those to be judged together
            lines += _contradictions(rest, "", unmade, whole=not found)
        lines += [str(error) for error in unmade if not lines]  # bodies that can't be made, which no rule looks for
        lines = [printable(line) for line in dict.fromkeys(lines)]
        if (more := len(lines) + len(every) - len(found) - MOST_FAULTS) > 0:
            lines = [*lines[:MOST_FAULTS], f"and {more} more"]
        if lines:
            raise SceneError("\n".join(f"{name}: {line}" for line in lines)) from None

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table as written, with defaults that depend on it."""
        return data

    @model_validator(mode="before")
    @classmethod
    def _completed(cls, data):
        return cls.completed(data) if isinstance(data, dict) else data

    def si(self) -> dict[str, Any]:
        """All values in SI, by keys without the unit that they spell."""
        found = {}
        for name in type(self).model_fields:
            value, (bare, _, factor) = getattr(self, name), unit_of_key(name)
            if factor is not None and value is not None:
                value = [factor * each for each in value] if isinstance(value, list) else factor * value
            found[bare] = value
        return found

    def fact(self, kind: type, **others: Any) -> Any:
        """A dataclass in SI from keys of its fields' names, and from other values."""
        known = kind.__dataclass_fields__  # type: ignore[attr-defined]
        return kind(**{name: value for name, value in self.si().items() if name in known} | others)

    def of_file(self, name: str, end: str) -> Any:
        """Digest ("sha256"), text ("content"), "decimal" or "shape" of a file that a key names; None: not given."""
        there = next((each for each in (beside(name, end), end) if each in type(self).model_fields), None)
        return None if there is None else getattr(self, there)

    def read(self, name: str) -> Any:
        """What the file says that a key names; None: there is none, or it is not at hand. ValueError: of its text."""
        text = self.of_file(name, "content")
        return None if text is None else self.FILES[name].read(text, self.of_file(name, "decimal") or ".")

    @property
    def files(self) -> dict[str, str]:
        """Texts of its files, by their digests, as far as they are at hand."""
        found = {self.of_file(name, "sha256"): self.of_file(name, "content") for name in self.FILES}
        return {digest: text for digest, text in found.items() if digest is not None and text is not None}

    def all_rules(self) -> Iterator[Rule]:
        yield Table._numbers
        if self.FILES:
            yield Table._files
        yield from self.RULES

    def _numbers(self) -> Iterator[str]:
        """Numbers so near to 0 that a square or a quotient of them is no number any more."""
        for name in type(self).model_fields:
            value = getattr(self, name, None)
            for number in value if isinstance(value, list) else [value]:
                if isinstance(number, float) and 0.0 < abs(number) < SMALLEST:
                    yield f"{name} = {number:g}: must be 0, or at least {SMALLEST:g} in size"

    def _files(self) -> Iterator[str]:
        for name in self.FILES:
            for end in ("sha256", "decimal", "shape") if getattr(self, name) is None else ():
                if getattr(self, f"{name}_{end}", None) is not None:
                    yield f"{name}_{end}: give {name} too, or leave it out"
            try:
                self.read(name)
            except ValueError as error:
                yield f'{name} = "{getattr(self, name)}": {error}'


def beside(name: str, end: str) -> str:
    """The key of something of a file, beside the key that names it."""
    return end if name == "file" else f"{name}_{end}"


@cache
def unit_of_key(name: str) -> tuple[str, str, float | None]:
    """A key without the unit that it spells, the unit ("" of none), and its factor to SI; None: the value stays."""
    ending = next((ending for ending in UNITS if name.endswith(f"_{ending}")), None)
    if ending is None:
        return name, "", None
    unit, factor = UNITS[ending]
    return (name if factor is None else name.removesuffix(f"_{ending}")), unit, None if factor == 1.0 else factor


def table_of(field: FieldInfo) -> tuple[type[Table] | None, bool]:
    """The class of a field's tables, None of a value's field, and whether there may be many."""
    kinds = get_args(field.annotation) or (field.annotation,)
    table = next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Table)), None)
    return table, get_origin(field.annotation) is list


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


def quoted(value: object) -> str:
    """A value of TOML as Python writes it, cut off where it is long."""
    try:
        return _short(repr(value))
    except ValueError:  # Python's own limit on the digits of a whole number
        return "a number of thousands of digits"


def _short(text: str) -> str:
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 3]}..."


def _explain(fault: ErrorDetails, model: type[Table]) -> str:
    """One of pydantic's faults."""
    parts = map(str, fault["loc"])
    place = ".".join(_short(part if part.isprintable() else repr(part)) for part in parts)  # or as TOML quotes a key
    value, kind = fault["input"], fault["type"]
    if kind == "extra_forbidden":
        if (gone := GONE.get(tuple(map(str, fault["loc"])))) is not None:
            return f"{place}: {gone[1]}"
        likely, lacking = _likely(fault["loc"], model), _absent(str(fault["loc"][-1]))
        if lacking is not None and not likely:
            return f"{place}: not supported: {lacking}; see docs/limits"
        known = ", ".join(keys_of(_table_at(fault["loc"][:-1], model)))
        return f"{place}: unknown key; " + (f"did you mean {' or '.join(likely)}?" if likely else
            f"known here: {known}")
    if kind == "value_error":  # of a field's own validator
        reason = str(fault["ctx"]["error"])
        return f"{place}: {reason}"
    if kind == "list_type" and table_of(_table_at(fault["loc"][:-1], model).model_fields[str(fault["loc"][-1])])[0]:
        reason = f"must be an array of tables, [[{place}]]"
    elif kind == "model_type":
        header = f"[[{fault['loc'][-2]}]]" if isinstance(fault["loc"][-1], int) else f"[{place}]"
        reason = f"must be a table, {header}"
    else:
        reason = fault["msg"].removeprefix("Input ").replace("should", "must", 1)
        if kind in ("float_type", "int_type") and isinstance(value, str):
            reason += ", without quotes and unit"
    return f"{place} = {quoted(value)}: {reason}"


def _table_at(place: Place, model: type[Table]) -> type[Table]:
    for part in place:
        if not isinstance(part, int):
            model = table_of(model.model_fields[part])[0] or model
    return model


def keys_of(model: type[Table]) -> list[str]:
    """What a user may write in a table."""
    return [name for name, field in model.model_fields.items() if not field.exclude]


def _absent(name: str, instead: str = "") -> str | None:
    """What the program lacks that a key asks for and the key that is there instead does not; None: nothing."""
    for what, words in ABSENT.items():
        if any(f"_{word}_" in f"_{name.lower()}_" and word not in instead for word in words):
            return what
    return None


def _likely(place: Place, model: type[Table]) -> list[str]:
    """Keys that were probably meant, unless they lack what was asked for.

    Those with it among their words or alike in the table, else of the same name elsewhere, dotted.
    """
    name, known = str(place[-1]), keys_of(_table_at(place[:-1], model))
    found = [each for each in known if f"_{name}_" in f"_{each}_"][:1]
    found = found or difflib.get_close_matches(name, known, n=1, cutoff=MISSPELT)
    if not found:
        for table, field in model.model_fields.items():
            kind, many = table_of(field)
            if kind is not None and name in keys_of(kind) and table_of(kind.model_fields[name])[0] is None:
                found.append(f"{table}.0.{name}" if many else f"{table}.{name}")
    found = found or difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    return [each for each in found if _absent(name, each) is None]


def likely_of(name: str, known: Iterable[str]) -> str | None:
    """The known name that was probably meant; None: none is near."""
    return next(iter(difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)), None)


def _meant(fault: ErrorDetails, model: type[Table]) -> Place:
    """The key whose value a fault leaves unknown."""
    place, likely = fault["loc"], None
    if fault["type"] == "extra_forbidden":
        likely = next(iter(_likely(place, model)), None)
    if likely is None:
        return place
    return tuple(likely.split(".")) if "." in likely else (*place[:-1], likely)


def _usable(model: type[Table], data: dict[str, Any], unusable: set[Place], place: Place = ()) -> Table:
    """A table without the values that can't be used: who asks for them meets an AttributeError."""
    given = place not in unusable  # a table of an array may be no table
    data, values, left_out = model.completed(data) if given else {}, dict[str, Any](), list[str]()
    inside = {at[: len(place) + 1] for at in unusable}  # a list of which an item can't be used can't be used
    for name, field in model.model_fields.items():
        at, (kind, many) = (*place, name), table_of(field)
        if not given or at in (inside if kind is None else unusable):
            left_out.append(name)
        elif kind is None:
            values |= {name: data[name]} if name in data else {}
        elif many:
            items = enumerate(data.get(name, []))
            values[name] = [_usable(kind, item, unusable, (*at, i)) for i, item in items]
        elif name in data or field.default is not None:
            values[name] = _usable(kind, data.get(name, {}), unusable, at)
    table = model.model_construct(**values)
    for name in left_out:
        table.__dict__.pop(name, None)
    return table


def _contradictions(table: Table, place: str, unmade: list[ValueError], whole: bool) -> Iterator[str]:
    """All that a table's rules, and those of the tables in it, say; `whole`: none of its values is left out."""
    before = f"{place}: " if place else ""
    for name in type(table).model_fields:
        value = table.__dict__.get(name)
        for i, item in enumerate(value) if isinstance(value, list) else [(-1, value)]:
            if isinstance(item, Table):
                at = f"{place}.{name}.{i}" if i >= 0 else f"{place}.{name}"
                yield from _contradictions(item, at.lstrip("."), unmade, whole)
    for rule in table.all_rules():
        try:
            if callable(rule):
                yield from (before + sentence for sentence in rule(table))
            elif rule[0](table):
                yield before + rule[1].format(t=table)
        except AttributeError:  # of a value left out
            if whole:
                raise
        except ValueError as error:  # of bodies that can't be made, for the most part of values that are named already
            unmade.append(error)
