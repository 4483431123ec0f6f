"""What a table of the scene is made of, and what is wrong with one: all of it at once, in the user's words.

Types and keys come first: pydantic judges them value by value. What values may not be together, the RULES of a table,
is asked afterwards, of sound tables or of what is left of them without the values that can't be used. The scene as
text, nested tables and values under dotted keys, is read here too.
"""

# fmt: off
import difflib
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator
from copy import deepcopy
from functools import cache
from itertools import pairwise
from math import pi
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import ErrorDetails

from lagrange.errors import UsageError
from lagrange.messages import shown

SMALLEST = 1e-15  # of a number that is not 0, in its key's unit
LONGEST_QUOTE = 80  # characters of a value, or a key, in a message
MOST_FAULTS = 15  # named at once: a file that is no scene may have thousands
MOST_EXPLAINED = 200  # looked at for them; to find what was meant takes some milliseconds each
MISSPELT = 0.8  # of difflib's ratio: the same word with a slip
LONGEST_TEXT = 2**20  # characters of a scene
MOST_PARTS = 50  # of a dotted key; the memory to read one grows by their square
_PART = r"""(?:(?<![\w-])[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+"""
_DOTTED = re.compile(rf"(?:{_PART}\.[ \t]*+)++")
ABSENT = {  # what engineers ask for and the program lacks, by words of a key
    "temperatures computed from heat ([fit] has given ones)": ("temperature", "thermal", "heat"),
    "grease": ("grease",),
    "keys of life and ratings (rate-bearing computes them)": ("life", "l10", "rating", "ratings", "c0"),
    "shapes of cage pockets": ("pocket", "pocket_shape"), "hollow rollers": ("hollow", "roller_bore")}
# keys of earlier versions: what they were by default, which scenes in their result files spell out, and what to do
GUIDED = "rollers are always guided against skew; leave it out"
GONE: dict[tuple[str, ...], tuple[Any, str]] = {
    ("reduced",): ({"modes_up_to_kHz": 0.0}, 'the reduced model no longer has modes; for elastic waves use model = '
        '"fem"'),
    ("lagrange", "damping_N_s_m"): (None, "contacts are damped by damping.contact_N_s_m in all models; write it there"),
    ("axial", "skew"): ("guided", GUIDED), ("axial", "skew_play_mrad"): (None, GUIDED)}
RPM = 2.0 * pi / 60.0  # rad/s
UNITS = {"GPa": "GPa", "kg_m3": "kg/m³", "rpm": "rpm", "N_per_m": "N/m", "N_per_mm3": "N/mm³", "N_s_m": "N s/m",
    "N_m": "N m", "N": "N", "N_per_m_n": "N/mⁿ", "N_m_rad": "N m/rad", "mrad": "mrad", "kg_m2": "kg m²", "kg": "kg",
    "g_mm": "g mm", "m_s2": "m/s²", "deg": "°", "mm": "mm", "um": "µm", "us": "µs", "ms": "ms", "kHz": "kHz",
    "Hz": "Hz", "s_m": "s/m", "1_s": "1/s", "Pa_s": "Pa s", "1_Pa": "1/Pa", "1_K": "1/K", "C": "°C"}  # by keys' endings
IN_SI = {"GPa": 1e9, "rpm": RPM, "N_per_mm3": 1e9, "mrad": 1e-3, "g_mm": 1e-6, "deg": pi / 180.0, "mm": 1e-3,
    "um": 1e-6, "us": 1e-6, "ms": 1e-3, "kHz": 1e3}  # that are not SI, how much they are

# kinds of values; of a file beside the scene its name, and the text that a result file keeps of it
Diameter = Annotated[float, Field(gt=0.0, le=10_000.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Angle = Annotated[float, Field(ge=-360.0, le=360.0)]
FileName = Annotated[str, Field(min_length=1, max_length=1000)]
Digest = Annotated[str | None, Field(pattern=r"^[0-9a-f]{64}$", description="SHA-256 of the file's text; another text "
    "is refused")]
DecimalSign = Annotated[Literal[".", ","] | None, Field(description='decimal sign of the file; default "."')]
FileText = Annotated[SkipJsonSchema[str | None], Field(exclude=True, repr=False)]

Place = tuple[str | int, ...]  # keys from the scene down
# what contradicts itself in a table: a generator of sentences on it, or a condition and the sentence where it holds, a
# template with the table as {t} and what the condition gives as {0}, {1}
Rule = Callable[[Any], Iterator[str]] | tuple[Callable[[Any], Any], str]


class SceneError(UsageError):
    """The scene can't be used; the text names file, key, value and limit, one fault a line."""


def key(default: Any, meaning: str, least: float | None = None, most: float | None = None, **limits: Any) -> Any:
    """A key of a table: its default, what it means, the least and the largest value."""
    return Field(default, description=meaning, ge=least, le=most, **limits)


def only(keys: str, other: str, *values: str | None) -> Rule:
    """Keys, in one text, that are given only together with another key: one of these values of it, or any."""

    def rule(table):
        there, fields = getattr(table, other), type(table).model_fields
        if there in values if values else there is not None:
            return
        words = " or ".join(f'"{value}"' for value in values if value)
        words += "" if there is None else f', not "{there}"'
        why = f"only with {other} = {words}; leave it out" if values else f"give {other} too, or leave it out"
        for name in keys.split():
            if (value := getattr(table, name)) != fields[name].default:
                given = f'"{value}"' if isinstance(value, str) else f"{value:g}" if type(value) is float else value
                yield f"{name} = {given}: {why}"

    return rule


class File(NamedTuple):
    """A key of a table that names a file; the text comes with the scene, see `lagrange.scene.scene`."""

    kind: str  # what such a table is of, in words
    read: Callable[[str, str], Any]  # what a text with this decimal sign says, ValueError
    forms: tuple[str, ...] = ()  # values of the key that name no file


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

    def _fill(self, data, name):
        every, rest, unmade = list[ErrorDetails](), self, list[ValueError]()
        try:
            super().__init__(**data)
        except ValidationError as error:
            every = error.errors()
        found = [_explained(fault, type(self)) for fault in every[:MOST_EXPLAINED]]
        lines = [line for line, _ in found]
        if found:
            rest = _usable(type(self), {k: plain(v) for k, v in data.items()}, {place for _, place in found})
        if len(found) == len(every):  # else values that can't be used are still among those to be judged together
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
        """None is what is not given."""
        return cls.completed({k: v for k, v in data.items() if v is not None}) if isinstance(data, dict) else data

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

    def _numbers(self):
        """Numbers so near to 0 that a square or a quotient of them is no number any more."""
        for name in type(self).model_fields:
            value = getattr(self, name, None)
            for number in value if isinstance(value, list) else [value]:
                if isinstance(number, float) and 0.0 < abs(number) < SMALLEST:
                    yield f"{name} = {number:g}: must be 0, or at least {SMALLEST:g} in size"

    def _files(self):
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
    ending = next((ending for ending in UNITS if name.endswith(f"_{ending}")), "")
    bare = name if ending in ("", "C") else name.removesuffix(f"_{ending}")
    return bare, UNITS.get(ending, ""), IN_SI.get(ending)


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


def _short(text):
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 3]}..."


def _explained(fault, model):
    """One of pydantic's faults in words, and the key whose value it leaves unknown."""
    at, value, kind = fault["loc"], fault["input"], fault["type"]
    parts = map(str, at)
    place = ".".join(_short(part if part.isprintable() else repr(part)) for part in parts)  # or as TOML quotes a key
    if kind == "extra_forbidden":
        likely, lacking = _likely(at, model), _absent(str(at[-1]))
        meant = at if not likely else tuple(likely[0].split(".")) if "." in likely[0] else (*at[:-1], likely[0])
        if (gone := GONE.get(tuple(map(str, at)))) is not None:
            return f"{place}: {gone[1]}", meant
        if lacking is not None and not likely:
            return f"{place}: not supported: {lacking}; see docs/limits", meant
        known = f"known here: {', '.join(keys_of(_table_at(at[:-1], model)))}"
        return f"{place}: unknown key; " + (f"did you mean {' or '.join(likely)}?" if likely else known), meant
    if kind == "missing":
        return f"{place}: is missing", at
    if kind == "value_error":  # of a field's own validator
        return f"{place}: {fault['ctx']['error']}", at
    if kind == "list_type" and table_of(_table_at(at[:-1], model).model_fields[str(at[-1])])[0]:
        reason = f"must be an array of tables, [[{place}]]"
    elif kind == "model_type":
        reason = "must be a table, " + (f"[[{at[-2]}]]" if isinstance(at[-1], int) else f"[{place}]")
    else:
        reason = fault["msg"].removeprefix("Input ").replace("should", "must", 1)
        if kind in ("float_type", "int_type") and isinstance(value, str):
            reason += ", without quotes and unit"
    return f"{place} = {quoted(value)}: {reason}", at


def _table_at(place, model):
    for part in place:
        if not isinstance(part, int):
            model = table_of(model.model_fields[part])[0] or model
    return model


def keys_of(model: type[Table]) -> list[str]:
    """What a user may write in a table."""
    return [name for name, field in model.model_fields.items() if not field.exclude]


def _absent(name, instead=""):
    """What the program lacks that a key asks for and the key that is there instead does not; None: nothing."""
    for what, words in ABSENT.items():
        if any(f"_{word}_" in f"_{name.lower()}_" and word not in instead for word in words):
            return what
    return None


def _likely(place, model):
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


def _usable(model, data, unusable, place=()):
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
            values[name] = [_usable(kind, item, unusable, (*at, i)) for i, item in enumerate(data.get(name, []))]
        elif name in data or field.default is not None:
            values[name] = _usable(kind, data.get(name, {}), unusable, at)
    table = model.model_construct(**values)
    for name in left_out:
        table.__dict__.pop(name, None)
    return table


def _contradictions(table, place, unmade, whole):
    """All that a table's rules, and those of the tables in it, say; `whole`: none of its values is left out."""
    before = f"{place}: " if place else ""
    for name in type(table).model_fields:
        value = table.__dict__.get(name)
        for at, item in enumerate(value) if isinstance(value, list) else [("", value)]:
            if isinstance(item, Table):
                yield from _contradictions(item, f"{place}.{name}.{at}".strip("."), unmade, whole)
    for rule in (Table._numbers, Table._files, *table.RULES):
        try:
            if callable(rule):
                yield from (before + sentence for sentence in rule(table))
            elif found := rule[0](table):
                yield before + rule[1].format(*(found if isinstance(found, tuple) else (found,)), t=table)
        except AttributeError:  # of a value left out
            if whole:
                raise
        except ValueError as error:  # of bodies that can't be made, for the most part of values that are named already
            unmade.append(error)


def load(text: str, name: str) -> dict[str, Any]:
    """Tables of a TOML text. SceneError."""
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


def _hint(text, reason):
    """The line at which TOML can't be read, and what is often wrong with such a one; empty where it is not known."""
    number, lines = re.search(r"line (\d+)", reason), text.split("\n")
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

    `origin` : name of the request in an error message. SceneError: the key leads through a value, to a whole table or
    past the end of an array.
    """
    parts = [part.strip() for part in key.split(".")]
    if not all(parts):
        raise SceneError(f"{origin}: {key!r} must read table.key, e.g. operation.speed_rpm")
    table: Any = data
    for part, after in pairwise([*parts, ""]):  # a table, or an array of tables, is made where there is none
        is_last = not after
        inner = value if is_last else [] if after.isdecimal() else {}
        if isinstance(table, dict):
            if is_last:
                table[part] = value
            inner = table.setdefault(part, inner)
        else:
            if not part.isdecimal() or int(part[:9]) > len(table):
                what = "entries" if is_last else "tables"  # of a list of values, as in bearing.missing_rollers.0
                raise SceneError(f"{origin}: {part} is none of {len(table)} {what}; numbers go on from 0")
            if is_last and any(isinstance(each, dict) for each in table):
                raise SceneError(f"{origin}: {part} is a whole table; set one of its keys")
            at = slice(int(part), int(part) + 1)
            table[at] = [inner] if is_last else table[at] or [inner]
            inner = table[int(part)]
        if not (is_last or isinstance(inner, dict | list)):
            raise SceneError(f"{origin}: {part} is a value, not a table")
        table = inner
