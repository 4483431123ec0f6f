"""What a study varies: a list of values, a range, or a distribution of scipy.stats, under a dotted key of the scene."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan
from sys import float_info
from typing import Any

import numpy as np

from lagrange.errors import UsageError
from lagrange.scene.faults import quoted

Value = float | int | str | bool
MOST_VALUES = 100_000  # of one parameter
RANGE_KEYS = ("from", "to", "count", "scale")
SPECS = "a list, { from = …, to = …, count = … } or a distribution, { normal = [210.0, 5.0] }"
SHORTHAND = {"normal": "norm", "log_normal": "lognorm", "triangular": "triang", "exponential": "expon"}


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One key of the scene and the values that it takes."""

    key: str

    def axis(self, method: str) -> tuple[Value, ...]:
        """Its values, one after the other. UsageError: it has none of a known number."""
        raise UsageError(f'parameters."{self.key}": method = "{method}" needs a list or a range with a count')

    def drawn(self, shares: np.ndarray) -> list[Value]:
        """Its values at shares of its distribution, (n,), 0 … 1."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class Choice(Parameter):
    """Values given one by one; drawn with equal shares."""

    values: tuple[Value, ...]

    def axis(self, method: str) -> tuple[Value, ...]:
        return self.values

    def drawn(self, shares: np.ndarray) -> list[Value]:
        at = np.minimum((shares * len(self.values)).astype(int), len(self.values) - 1)
        return [self.values[i] for i in at]


@dataclass(frozen=True, kw_only=True)
class Range(Parameter):
    """From one value to another, both included, evenly or by equal factors; drawn in between."""

    low: float
    high: float
    count: int | None
    logarithmic: bool
    whole: bool  # values are whole numbers

    def axis(self, method: str) -> tuple[Value, ...]:
        if self.count is None:
            return super().axis(method)
        shares = np.linspace(0.0, 1.0, self.count)
        found = self._at(shares)
        found[0], found[-1] = self.low, self.high  # round-off may leave the scene's range
        if self.whole and not self.logarithmic and all(value == round(value) for value in found):
            return tuple(round(value) for value in found)
        return tuple(float(value) for value in found)

    def drawn(self, shares: np.ndarray) -> list[Value]:
        if self.count is not None:
            raise UsageError(f'parameters."{self.key}": count is only for a grid; give samples for a drawn range')
        if self.whole:  # each whole number has the same share
            return [min(int(self.low + s * (self.high - self.low + 1)), int(self.high)) for s in shares]
        return self._at(shares).tolist()

    def _at(self, shares: np.ndarray) -> np.ndarray:
        if self.logarithmic:
            return self.low * (self.high / self.low) ** shares
        return self.low + (self.high - self.low) * shares


@dataclass(frozen=True, kw_only=True)
class Distribution(Parameter):
    """A continuous distribution of scipy.stats with its arguments in their order: shapes, location, scale."""

    name: str
    arguments: tuple[float, ...]

    def drawn(self, shares: np.ndarray) -> list[Value]:
        return list(self.quantiles(shares))

    def quantiles(self, shares: np.ndarray) -> list[float]:
        with warnings.catch_warnings(action="ignore"):  # of what is no number, which is refused
            return self.frozen().ppf(shares).tolist()

    def frozen(self):
        from scipy import stats

        return getattr(stats, self.name)(*self.arguments)


def is_value(found: Any) -> bool:
    """Whether a value of TOML may be one of a scene."""
    return isinstance(found, str | bool) or _is_number(found)


def _is_number(found: Any) -> bool:
    """Whether a value of TOML, whose whole numbers have no limit, is a number that a float can hold."""
    return isinstance(found, float | int) and not isinstance(found, bool) and abs(found) <= float_info.max


def read_parameter(key: str, spec: Any) -> Parameter:
    """The parameter that a study's file states. UsageError: it is none, or no values follow from it."""
    if isinstance(spec, list):
        return Choice(key=key, values=_values(key, spec))
    if not isinstance(spec, dict):
        raise UsageError(f'parameters."{key}" = {quoted(spec)}: must be {SPECS}')
    if "from" in spec or "to" in spec:
        return _range(key, spec)
    if len(spec) != 1:
        raise UsageError(f'parameters."{key}": must be {SPECS}')
    ((name, arguments),) = spec.items()
    if isinstance(arguments, dict) or key == key.partition(".")[0]:
        raise UsageError(f'parameters.{key}: dotted keys of the scene are quoted, "{key}.{name}" = …')
    return _distribution(key, name, arguments)


def _values(key: str, given: Sequence[Any]) -> tuple[Value, ...]:
    if not 1 <= len(given) <= MOST_VALUES:
        raise UsageError(f'parameters."{key}": holds {len(given)} values; 1 to {MOST_VALUES} are allowed')
    for value in given:
        if not is_value(value):
            raise UsageError(f'parameters."{key}": {quoted(value)} is no value of a scene')
    if len(set(given)) < len(given):
        twice = next(value for i, value in enumerate(given) if value in given[:i])
        raise UsageError(f'parameters."{key}": {quoted(twice)} is there twice')
    return tuple(given)


def _range(key: str, spec: dict[str, Any]) -> Range:
    place = f'parameters."{key}"'
    for name in spec:
        if name not in RANGE_KEYS:
            raise UsageError(f"{place}.{name}: unknown key; known here: {', '.join(RANGE_KEYS)}")
    for name in ("from", "to"):
        value = spec.get(name)
        if not _is_number(value):
            raise UsageError(f"{place}.{name} = {quoted(value)}: must be a number")
    low, high, count, scale = spec["from"], spec["to"], spec.get("count"), spec.get("scale", "linear")
    if not low < high:
        raise UsageError(f"{place}: from = {low:g} must be below to = {high:g}")
    if count is not None and (isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= MOST_VALUES):
        raise UsageError(f"{place}.count = {quoted(count)}: must be a whole number from 2 to {MOST_VALUES}")
    if scale not in ("linear", "log"):
        raise UsageError(f'{place}.scale = {quoted(scale)}: must be "linear" or "log"')
    if scale == "log" and low <= 0.0:
        raise UsageError(f'{place}: scale = "log" needs from = {low:g} above 0')
    whole = isinstance(low, int) and isinstance(high, int)
    return Range(key=key, low=low, high=high, count=count, logarithmic=scale == "log", whole=whole)


def _distribution(key: str, name: str, arguments: Any) -> Distribution:
    from scipy import stats

    place = f'parameters."{key}"'
    if name == "uniform":
        raise UsageError(f"{place}.uniform: write {{ from = …, to = … }}")
    known = getattr(stats, SHORTHAND.get(name, name), None)
    if not isinstance(known, stats.rv_continuous):
        raise UsageError(f"{place}.{name}: no range and no continuous distribution of scipy.stats; must be {SPECS}")
    numbers = arguments if isinstance(arguments, list) else None
    if numbers is None or not all(_is_number(a) for a in numbers):
        raise UsageError(f"{place}.{name} = {quoted(arguments)}: must be a list of numbers: shapes, location, scale")
    found = Distribution(key=key, name=SHORTHAND.get(name, name), arguments=tuple(float(a) for a in numbers))
    try:
        middle = found.quantiles(np.array([0.5]))[0]
    except TypeError:
        shapes = known.shapes or "none"
        raise UsageError(
            f"{place}.{name}: {len(numbers)} arguments; give shapes ({shapes}), then location and scale"
        ) from None
    except (ArithmeticError, ValueError, RuntimeError):  # of a search for what has no closed form
        middle = nan
    if not isfinite(middle):
        raise UsageError(f"{place}.{name} = {quoted(arguments)}: outside the distribution's domain")
    return found
