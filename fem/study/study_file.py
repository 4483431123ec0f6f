"""The study's file: TOML, validated; what it varies, and the points that follow. Faults are named as a scene's are."""

import csv
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from math import isfinite, nan, prod
from pathlib import Path
from sys import float_info
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from fem.interface import OF_CHECK
from fem.quantities import OF_RATING, OF_RUN, OF_STATICS
from lagrange.errors import UsageError
from lagrange.files.input import plain_text
from lagrange.scene.faults import Table, likely_of, load, printable, quoted
from lagrange.scene.scene import Scene, SceneError, read_scene

LARGEST_FILE = 2**24  # bytes of a list of points
MOST_NAMES = 1000  # quantities, signals, keys of the scene
MOST_VALUES = 100_000  # of one parameter
MOST_POINTS = 1_000_000
MOST_NUMBERS = 10 * MOST_POINTS  # in all points: some hundred bytes of memory each
QUANTITIES = OF_RUN | OF_STATICS | OF_RATING | OF_CHECK  # unit and meaning by name
USUAL = ("hub_mean_x", "hub_mean_y", "largest_force", "mean_largest_force", "load_zone")
RANGE_KEYS = ("from", "to", "count", "scale")
SPECS = "a list, { from = …, to = …, count = … } or a distribution, { normal = [210.0, 5.0] }"
SHORTHAND = {"normal": "norm", "log_normal": "lognorm", "triangular": "triang", "exponential": "expon"}
POINT = "point"  # the dimension of points that are no grid
Value = float | int | str | bool


class SamplingTable(Table):
    method: Literal["grid", "zip", "lhs", "sobol", "list"] = "grid"
    samples: int | None = Field(None, ge=1, le=1_000_000)
    seed: int = Field(0, ge=0, le=2**63 - 1)
    indices: bool = False
    file: str | None = Field(None, min_length=1)

    @property
    def is_drawn(self) -> bool:  # whether points are drawn from distributions
        return self.method in ("lhs", "sobol")

    def _faults(self):
        method, samples = self.method, self.samples
        if self.is_drawn and samples is None:
            yield f'samples: missing; method = "{method}" needs a number of samples'
        if not self.is_drawn and samples is not None:
            yield f'samples = {samples}: only for "lhs" and "sobol", not for "{method}"; leave it out'
        if self.indices and method != "sobol":
            yield f'indices = true: only for method = "sobol", not for "{method}"; leave it out'
        if method == "sobol" and samples is not None and samples & (samples - 1):
            near = 2 ** samples.bit_length()
            yield f"samples = {samples}: a Sobol sequence is uniform at powers of two; use {near // 2} or {near}"
        if (method == "list") != (self.file is not None):
            yield 'file: a CSV table of points goes with method = "list", and with no other'

    RULES = (_faults,)


class KeepTable(Table):
    quantities: list[str] = Field(list(USUAL), max_length=MOST_NAMES)
    signals: list[str] = Field([], max_length=MOST_NAMES)
    signal_rate_kHz: float | None = Field(None, ge=1e-6, le=1e6)

    def _faults(self):
        for name in self.quantities:
            if name not in QUANTITIES:
                hint = likely_of(name, QUANTITIES)
                meant = f"did you mean {hint}?" if hint else f"known are {', '.join(QUANTITIES)}"
                yield f"quantities: {name!r} is unknown; {meant}"
        for key, names in (("quantities", self.quantities), ("signals", self.signals)):
            for name in sorted({name for name in names if names.count(name) > 1}):
                yield f"{key}: {name!r} is there twice"
        if self.signal_rate_kHz is not None and not self.signals:
            yield f"signal_rate_kHz = {self.signal_rate_kHz:g}: there are no signals; add some or leave it out"

    def one_of(self, interval: float) -> int:
        """One of so many samples, an interval apart, s, is kept: at the rate wanted, or at the next higher one."""
        rate = self.signal_rate_kHz
        return 1 if rate is None else max(1, int(1.0 / (1e3 * rate * interval) + 1e-9))

    RULES = (_faults,)


class LimitsTable(Table):
    seconds_per_point: float = Field(3600.0, gt=0.0, le=1e7)


class StudyTable(Table):
    """A study as its file has it."""

    name: str | None = Field(None, min_length=1, max_length=100, pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    scene: str | None = Field(None, min_length=1)
    sampling: SamplingTable = SamplingTable()
    fixed: dict[str, Any] = Field({}, max_length=MOST_NAMES)  # by dotted key, before anything is varied
    parameters: dict[str, Any] = Field({}, max_length=MOST_NAMES)
    keep: KeepTable = KeepTable()
    limits: LimitsTable = LimitsTable()


class Parameter(NamedTuple):
    """One key of the scene: a list of values, a range, or a distribution of scipy.stats."""

    key: str
    values: tuple[Value, ...] | None = None  # one after the other; None: of no known number
    quantiles: Callable[[np.ndarray], list[Value]] | None = None  # at shares 0 … 1; None: of a range with a count

    def axis(self, method: str) -> tuple[Value, ...]:
        """Its values, one after the other. UsageError: it has none of a known number."""
        if self.values is None:
            raise UsageError(f'parameters."{self.key}": method = "{method}" needs a list or a range with a count')
        return self.values

    def drawn(self, shares: np.ndarray) -> list[Value]:
        """Its values at shares of its distribution, (n,), 0 … 1. UsageError: a range with a count."""
        if self.quantiles is None:
            raise UsageError(f'parameters."{self.key}": count is only for a grid; give samples for a drawn range')
        return self.quantiles(shares)


class Study(NamedTuple):
    """A study: what is varied, from which scene on, and what is kept of each point."""

    name: str
    scene: Scene
    sampling: SamplingTable
    parameters: Mapping[str, Parameter]  # by dotted key of the scene; empty for method = "list"
    keep: KeepTable
    limits: LimitsTable
    text: str  # the study's own TOML
    listed: str | None = None  # text of the CSV table of points


@dataclass(frozen=True)
class Design:
    """The points of a study in a fixed order: on a grid the last parameter changes fastest."""

    keys: tuple[str, ...]  # dotted keys of the scene
    points: list[tuple[Value | None, ...]]  # values by key
    axes: tuple[tuple[Value, ...], ...] | None = None  # of a grid, by key; None: the points are no grid
    base: int = 0  # points of each of the matrices A, B and AB of Sobol indices; 0: there are none

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters: the last part of each key where that is a name and theirs alone, else the whole key."""
        last = [key.rpartition(".")[2] for key in self.keys]
        return tuple(
            name if last.count(name) == 1 and name != POINT and not name.isdecimal() else key.replace(".", "_")
            for name, key in zip(last, self.keys, strict=True)
        )

    dimensions = property(lambda self: (POINT,) if self.axes is None else self.names)
    shape = property(lambda self: (len(self.points),) if self.axes is None else tuple(map(len, self.axes)))

    def changes(self, i: int) -> dict[str, Value]:
        """What point i changes of the scene: keys of cells left empty stay as they are."""
        return {key: value for key, value in zip(self.keys, self.points[i], strict=True) if value is not None}

    def describe(self, i: int) -> str:
        """Point i in words."""
        words = (f"{k} = {f'{v:.8g}' if isinstance(v, float) else repr(v)}" for k, v in self.changes(i).items())
        return f"point {i} ({', '.join(words)})"


def read_study(path: Path) -> Study:
    """The study of a TOML file; paths in it are from its own folder. Its scene may need keys that all points give.
    UsageError, SceneError: unreadable, not TOML, unknown keys, impossible values; each with its key."""
    text = _text(path)
    table, study = StudyTable.parsed(load(text, str(path)), str(path)), study_of(path, text, None)
    listed = None if table.sampling.file is None else _text(path.parent / table.sampling.file)
    study, base = study._replace(listed=listed), None if table.scene is None else path.parent / table.scene
    try:
        scene = read_scene(base)
    except SceneError:  # it may lack what all points have
        design = design_of(study)
        given = [key for k, key in enumerate(design.keys) if all(point[k] is not None for point in design.points)]
        scene = read_scene(base, changes=table.fixed | {key: design.changes(0)[key] for key in given})
    try:
        return study._replace(scene=scene.varied(table.fixed))
    except SceneError as error:
        raise UsageError(f"{path}: [fixed]: {error}") from None


def study_of(path: Path, text: str, listed: str | None) -> Study:
    """The study of a TOML text, with the built-in scene. UsageError: also of parameters that the method can't take.
    `path` : where the text stands, to be named in errors; `listed` : text of the table of points, for method = "list"
    """
    table = StudyTable.parsed(load(text, str(path)), str(path))
    method = table.sampling.method
    try:
        parameters = {key: read_parameter(key, value) for key, value in table.parameters.items()}
        if method == "list" and parameters:
            raise UsageError('[parameters]: with method = "list" they are the columns of its file; leave them out')
        if method != "list" and not parameters:
            raise UsageError('[parameters]: empty; name a key of the scene and its values, "operation.speed_rpm"')
        for key, parameter in parameters.items():
            _ = parameter.drawn(np.array([0.5])) if table.sampling.is_drawn else parameter.axis(method)
            if key in table.fixed:
                raise UsageError(f'"{key}" stands in [fixed] and in [parameters]; leave it in one of them')
    except UsageError as error:
        raise UsageError(f"{path}: {printable(str(error))}") from None
    return Study(
        name=table.name or path.stem, scene=read_scene(), sampling=table.sampling, parameters=parameters,
        keep=table.keep, limits=table.limits, text=text, listed=listed)  # fmt: skip


def _text(path):
    try:
        return plain_text(path, LARGEST_FILE)
    except ValueError as error:
        raise UsageError(f"{path}: {error}") from None


def _is_number(value):
    """Whether a value of TOML, whose whole numbers have no limit, is a number that a float can hold."""
    return isinstance(value, float | int) and not isinstance(value, bool) and abs(value) <= float_info.max


def _is_value(value):  # of a scene
    return isinstance(value, str | bool) or _is_number(value)


def read_parameter(key: str, spec: Any) -> Parameter:
    """The parameter that a study's file states. UsageError: it is none, or no values follow from it."""
    place = f'parameters."{key}"'
    if isinstance(spec, list):
        return _choice(key, place, spec)
    if not isinstance(spec, dict):
        raise UsageError(f"{place} = {quoted(spec)}: must be {SPECS}")
    if "from" in spec or "to" in spec:
        return _range(key, place, spec)
    if len(spec) != 1:
        raise UsageError(f"{place}: must be {SPECS}")
    ((name, arguments),) = spec.items()
    if isinstance(arguments, dict) or "." not in key:
        raise UsageError(f'parameters.{key}: dotted keys of the scene are quoted, "{key}.{name}" = …')
    return _distribution(key, f"{place}.{name}", name, arguments)


def _choice(key, place, given):  # values given one by one; drawn with equal shares
    n = len(given)
    if not 1 <= n <= MOST_VALUES:
        raise UsageError(f"{place}: holds {n} values; 1 to {MOST_VALUES} are allowed")
    for value in given:
        if not _is_value(value):
            raise UsageError(f"{place}: {quoted(value)} is no value of a scene")
    if len(set(given)) < n:
        twice = next(value for i, value in enumerate(given) if value in given[:i])
        raise UsageError(f"{place}: {quoted(twice)} is there twice")
    return Parameter(key, tuple(given), lambda at: [given[i] for i in np.minimum((at * n).astype(int), n - 1)])


def _range(key, place, spec):
    """From one value to another, both included, evenly or by equal factors; without a count drawn in between."""
    for name in spec:
        if name not in RANGE_KEYS:
            raise UsageError(f"{place}.{name}: unknown key; known here: {', '.join(RANGE_KEYS)}")
    for name in ("from", "to"):
        if not _is_number(spec.get(name)):
            raise UsageError(f"{place}.{name} = {quoted(spec.get(name))}: must be a number")
    low, high, count, scale = spec["from"], spec["to"], spec.get("count"), spec.get("scale", "linear")
    if not low < high:
        raise UsageError(f"{place}: from = {low:g} must be below to = {high:g}")
    if count is not None and (isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= MOST_VALUES):
        raise UsageError(f"{place}.count = {quoted(count)}: must be a whole number from 2 to {MOST_VALUES}")
    if scale not in ("linear", "log"):
        raise UsageError(f'{place}.scale = {quoted(scale)}: must be "linear" or "log"')
    if (is_log := scale == "log") and low <= 0.0:
        raise UsageError(f'{place}: scale = "log" needs from = {low:g} above 0')
    whole = isinstance(low, int) and isinstance(high, int)

    def at(shares):
        return (low * (high / low) ** shares if is_log else low + (high - low) * shares).tolist()

    def drawn(shares):  # each whole number has the same share
        return [min(int(low + s * (high - low + 1)), high) for s in shares] if whole else at(shares)

    if count is None:
        return Parameter(key, quantiles=drawn)
    values = [low, *at(np.linspace(0.0, 1.0, count))[1:-1], high]  # round-off may leave the scene's range
    kind = round if whole and not is_log and all(value == round(value) for value in values) else float
    return Parameter(key, tuple(map(kind, values)))


def _distribution(key, place, name, arguments):
    """A continuous distribution of scipy.stats with its arguments in their order: shapes, location, scale."""
    from scipy import stats

    if name == "uniform":
        raise UsageError(f"{place}: write {{ from = …, to = … }}")
    law = getattr(stats, SHORTHAND.get(name, name), None)
    if not isinstance(law, stats.rv_continuous):
        raise UsageError(f"{place}: no range and no continuous distribution of scipy.stats; must be {SPECS}")
    if not isinstance(arguments, list) or not all(map(_is_number, arguments)):
        raise UsageError(f"{place} = {quoted(arguments)}: must be a list of numbers: shapes, location, scale")

    def quantiles(shares):
        with warnings.catch_warnings(action="ignore"):  # of what is no number, which is refused
            return law(*map(float, arguments)).ppf(shares).tolist()

    try:
        middle = float(quantiles(np.array([0.5]))[0])
    except TypeError:
        wanted = f"give shapes ({law.shapes or 'none'}), then location and scale"
        raise UsageError(f"{place}: {len(arguments)} arguments; {wanted}") from None
    except (ArithmeticError, ValueError, RuntimeError):  # of a search for what has no closed form
        middle = nan
    if not isfinite(middle):
        raise UsageError(f"{place} = {quoted(arguments)}: outside the distribution's domain")
    return Parameter(key, quantiles=quantiles)


def design_of(study: Study) -> Design:
    """The points of a study, always the same. UsageError: lengths that differ, too many points, a list that is none."""
    method, parameters = study.sampling.method, study.parameters
    if method == "list":
        return _listed(study.sampling.file or "", study.listed or "")
    if study.sampling.is_drawn:
        return _drawn(study.sampling, parameters)
    keys, axes = tuple(parameters), tuple(parameter.axis(method) for parameter in parameters.values())
    if method == "zip":
        if len({len(axis) for axis in axes}) > 1:
            counts = ", ".join(f'"{key}" {len(axis)}' for key, axis in zip(keys, axes, strict=True))
            raise UsageError(f'parameters: method = "zip" needs as many values of each, here {counts}')
        return Design(keys=keys, points=list(zip(*axes, strict=True)))
    _check_count(prod(len(axis) for axis in axes), len(axes), "parameters")
    return Design(keys=keys, points=list(product(*axes)), axes=axes)


def _check_count(count, parameters, what):
    if count > MOST_POINTS:
        raise UsageError(f"{what}: {count:,} points; at most {MOST_POINTS:,} are allowed")
    if count * parameters > MOST_NUMBERS:
        raise UsageError(
            f"{what}: {count:,} points of {parameters:,} parameters; points times parameters may be {MOST_NUMBERS:,}"
        )


def _drawn(sampling, parameters):
    """Points of a Latin hypercube or of a scrambled Sobol sequence.
    With indices A, B, and for each parameter A with its column of B, one below the other, ((d + 2) n, d).
    Source: Saltelli et al., Computer Physics Communications 181 (2010), as scipy.stats.sobol_indices takes them."""
    from scipy.stats import qmc

    d, n = len(parameters), sampling.samples or 0
    _check_count(n * (d + 2) if sampling.indices else n, d, "sampling.samples")
    rng = np.random.default_rng(sampling.seed)
    if sampling.method == "lhs":
        shares = qmc.LatinHypercube(d=d, rng=rng).random(n)
    else:
        shares = qmc.Sobol(d=2 * d if sampling.indices else d, rng=rng).random_base2(n.bit_length() - 1)
    if sampling.indices:
        A, B = shares[:, :d], shares[:, d:]
        shares = np.concatenate([A, B, *(np.where(np.arange(d) == i, B, A) for i in range(d))])
    columns = (parameter.drawn(column) for parameter, column in zip(parameters.values(), shares.T, strict=True))
    return Design(tuple(parameters), list(zip(*columns, strict=True)), base=n if sampling.indices else 0)


def _listed(name, text):
    """Points of a CSV table whose header names keys of the scene; a value is TOML, or a plain word, or left empty."""
    try:
        rows = [[cell.strip() for cell in row] for row in csv.reader(text.splitlines())]
    except csv.Error as error:
        raise UsageError(f"{name}: a row can't be read: {error}") from None
    rows = [row for row in rows if any(row)]
    if len(rows) < 2:
        raise UsageError(f"{name}: holds no points; a header of scene keys and a row for each point are needed")
    keys = tuple(rows[0])
    if not all(keys) or len(set(keys)) < len(keys):
        raise UsageError(f"{name}: its header must name a key of the scene in each column, none twice")
    _check_count(len(rows) - 1, len(keys), name)
    points = []
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(keys):
            raise UsageError(f"{name}: row {number} has {len(row)} values, its header {len(keys)}")
        values: list[Value | None] = []
        for key, cell in zip(keys, row, strict=True):
            try:
                value = load(f"value = {cell}", "")["value"] if cell else None
            except SceneError:
                value = cell
            if cell and not _is_value(value):
                raise UsageError(f"{name}: row {number}, {key} = {quoted(cell)}: is no value of a scene")
            values.append(value)
        points.append(tuple(values))
    return Design(keys=keys, points=points)
