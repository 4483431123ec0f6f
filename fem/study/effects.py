"""What a study's numbers say: how much each parameter changes each quantity."""

from dataclasses import dataclass

import numpy as np
from xarray import Dataset

from fem.study.dataset import unit_of_key
from fem.study.solving import COMPLETE, Points
from fem.study.study_file import QUANTITIES
from lagrange.messages import engineering
from lagrange.scene.keys import name_in_words

BINS = 8  # of a parameter that takes a value of its own in each point
FEWEST = 2  # points
MOST_COLUMNS, MOST_LINES = 4, 12  # panels beside each other, lines in one
NOTHING = "-"  # the word of a cell that a list of points has left empty


@dataclass(frozen=True, kw_only=True)
class Column:
    """A parameter or a quantity of all points."""

    name: str  # in the dataset
    unit: str
    meaning: str  # in words
    values: np.ndarray  # (n_points,), float; of words their number among `words`
    words: tuple[str, ...] = ()  # in their order; empty of numbers

    @property
    def label(self) -> str:
        """Meaning and unit, for an axis."""
        return self.meaning if self.unit in ("1", "") else f"{self.meaning}, {self.unit}"

    def shown(self, value: float) -> str:
        """A value for people, without its unit."""
        if not np.isfinite(value):
            return NOTHING
        return self.words[int(value)] if self.words else f"{value:.4g}".replace("-", "−")


@dataclass(frozen=True, kw_only=True)
class Effect:
    """Means of a quantity over the points that share a parameter's value, or lie in the same bin of it."""

    at: np.ndarray  # (n_levels,), the parameter
    mean: np.ndarray  # (n_levels,), the quantity
    share: float  # of the quantity's variance that these means explain, 0 … 1; of drawn points see `Table.is_adjusted`


@dataclass(frozen=True, kw_only=True)
class Table:
    """A study's points as columns."""

    points: Points
    parameters: list[Column]  # those that take more than one value
    quantities: list[Column]
    complete: np.ndarray  # (n_points,), bool

    @property
    def is_adjusted(self) -> bool:
        """Whether points are samples of distributions. Shares are then adjusted for the number of groups (R̄²).

        Means over k groups of n drawn points explain (k − 1)/(n − 1) of a variance that has nothing to do with the
        parameter. A grid has no such chance in it: its shares are the variance of the means over that of all points.
        """
        return self.points.design.axes is None

    @property
    def is_family(self) -> bool:
        """Whether lines over one parameter show every point: a grid of few parameters, or one parameter alone."""
        columns, lines, *_ = [1, 1, *sorted(len(np.unique(each.values)) for each in self.parameters)][-3:]
        is_small = len(self.parameters) <= 3 and columns <= MOST_COLUMNS and lines <= MOST_LINES
        return len(self.parameters) == 1 or (is_small and not self.is_adjusted)

    def effect(self, parameter: Column, quantity: Column) -> Effect | None:
        """The effect of a parameter on a quantity; None where too few points tell of it."""
        known = np.isfinite(quantity.values) & np.isfinite(parameter.values)
        x, y = parameter.values[known], quantity.values[known]
        if len(y) < FEWEST or not np.ptp(y) > 0.0:
            return None
        levels, group = np.unique(x, return_inverse=True)
        if self.is_adjusted and len(levels) > BINS:
            edges = np.quantile(x, np.linspace(0.0, 1.0, BINS + 1)[1:-1])
            group = np.searchsorted(edges, x, side="right")
            levels = np.array([x[group == g].mean() if (group == g).any() else np.nan for g in range(BINS)])
        count = np.bincount(group, minlength=len(levels))
        enough = count > 0
        mean = np.bincount(group, y, minlength=len(levels))[enough] / count[enough]
        share = float(np.sum(count[enough] * (mean - y.mean()) ** 2) / np.sum((y - y.mean()) ** 2))
        n, k = len(y), len(mean)
        if self.is_adjusted and n > k:
            share = max(0.0, 1.0 - (1.0 - share) * (n - 1) / (n - k))
        return Effect(at=levels[enough], mean=mean, share=share)

    @property
    def telling(self) -> list[Column]:
        """Quantities that differ between points."""
        finite = [(each, each.values[np.isfinite(each.values)]) for each in self.quantities]
        return [each for each, known in finite if len(known) > 1 and np.ptp(known) > 0.0]

    def strongest(self, quantity: Column) -> list[tuple[Column, float]]:
        """Parameters with the shares of the quantity's variance that they explain, the largest first."""
        found = [(parameter, self.effect(parameter, quantity)) for parameter in self.parameters]
        shares = [(parameter, effect.share) for parameter, effect in found if effect is not None]
        return sorted(shares, key=lambda each: -each[1])


def table_of(points: Points, dataset: Dataset) -> Table:
    """Columns of a study from its dataset."""
    design = points.design
    parameters = [
        _column(name, unit_of_key(key), name_in_words(name), [point[i] for point in design.points])
        for i, (key, name) in enumerate(zip(design.keys, design.names, strict=True))
    ]
    kept = points.study.keep.quantities
    quantities = [_quantity(name, *QUANTITIES[name], dataset[name].values.ravel()) for name in kept]
    return Table(
        points=points,
        parameters=[each for each in parameters if len(np.unique(each.values[np.isfinite(each.values)])) > 1],
        quantities=quantities,
        complete=dataset.status.values.ravel() == COMPLETE,
    )


def _quantity(name: str, unit: str, meaning: str, values: np.ndarray) -> Column:
    """A quantity in the unit that engineers read."""
    factor, shown = engineering(unit)
    return _column(name, shown or unit, meaning, (factor * values).tolist())


def _column(name: str, unit: str, meaning: str, values: list) -> Column:
    wordy = any(isinstance(value, str | bool) for value in values)
    given = [NOTHING if value is None else str(value) for value in values]
    words = tuple(dict.fromkeys(given)) if wordy else ()
    numbers = [words.index(value) for value in given] if words else values  # None becomes NaN
    return Column(name=name, unit=unit, meaning=meaning, values=np.array(numbers, dtype=float), words=words)


@dataclass(frozen=True, kw_only=True)
class Indices:
    """Sobol indices of a quantity, by parameter."""

    first: np.ndarray  # (n_parameters,), of the parameter alone
    total: np.ndarray  # (n_parameters,), with all that it does together with others


def sobol_indices(table: Table, quantity: Column) -> Indices | None:
    """Sobol indices of a quantity; None where the study was not sampled for them, or not every point is complete.

    Errors
    ------
    Of the order of 1/√base; small ones may come out negative.

    Source: Saltelli et al., Computer Physics Communications 181 (2010), by scipy.stats.sobol_indices.
    """
    n, d = table.points.design.base, len(table.points.design.keys)
    if not n or not np.isfinite(quantity.values).all() or not np.ptp(quantity.values) > 0.0:
        return None
    from scipy import stats

    f_A, f_B, *f_AB = quantity.values.reshape(d + 2, 1, n)
    found = stats.sobol_indices(func={"f_A": f_A, "f_B": f_B, "f_AB": np.array(f_AB)}, n=n)
    return Indices(first=np.ravel(found.first_order), total=np.ravel(found.total_order))
