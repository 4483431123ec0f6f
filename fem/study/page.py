"""What a study's numbers say, how much each parameter changes each quantity: on the terminal, and on a page."""

from collections import Counter
from collections.abc import Sequence
from math import isnan
from pathlib import Path
from typing import NamedTuple

import numpy as np
from xarray import Dataset

from fem.study.folder import Folder, incomplete
from fem.study.solving import COMPLETE, Expected, Points, StudyOptions
from fem.study.study_file import QUANTITIES
from lagrange.files.output import load_matplotlib, render_page, write_whole
from lagrange.messages import Section, engineering
from lagrange.scene.keys import name_in_words, unit_of

BINS = 8  # of a parameter that takes a value of its own in each point
FEWEST = 2  # points
MOST_COLUMNS, MOST_LINES = 4, 12  # panels beside each other, lines in one
MOST_NAMED = 5  # points that have failed, on the terminal
MOST_ROWS = 200  # of a table of points
TELLING = 0.05  # of a quantity's variance: parameters that explain less are not named
NOTHING = "-"  # the word of a cell that a list of points has left empty
TEMPLATE = Path(__file__).parent / "template" / "study.html.j2"
Indices = tuple[np.ndarray, np.ndarray]  # Sobol's, of each parameter alone, and with all that it does with others


class Column(NamedTuple):
    """A parameter or a quantity of all points."""

    name: str  # in the dataset
    unit: str
    meaning: str  # in words
    values: np.ndarray  # (n_points,), float; of words their number among `words`
    words: tuple[str, ...] = ()  # in their order; empty of numbers

    @property
    def label(self) -> str:  # meaning and unit, for an axis
        return self.meaning if self.unit in ("1", "") else f"{self.meaning}, {self.unit}"

    @property
    def levels(self) -> np.ndarray:  # the values that it takes, each once
        return np.unique(self.values[np.isfinite(self.values)])

    def shown(self, value: float) -> str:
        """A value for people, without its unit."""
        if not np.isfinite(value):
            return NOTHING
        return self.words[int(value)] if self.words else f"{value:.4g}".replace("-", "−")


class Effect(NamedTuple):
    """Means of a quantity over the points that share a parameter's value, or lie in the same bin of it."""

    at: np.ndarray  # (n_levels,), the parameter
    mean: np.ndarray  # (n_levels,), the quantity
    share: float  # of the quantity's variance that these means explain, 0 … 1; of drawn points see `Table.is_adjusted`


class Table(NamedTuple):
    """A study's points as columns."""

    points: Points
    parameters: list[Column]  # those that take more than one value
    quantities: list[Column]
    complete: np.ndarray  # (n_points,), bool

    @property
    def is_adjusted(self) -> bool:
        """Whether points are samples of distributions. Shares are then adjusted for the number of groups (R̄²).

        Means over k groups of n drawn points explain (k − 1)/(n − 1) of a variance that has nothing to do with the
        parameter. A grid has no such chance in it: its shares are the variance of the means over that of all points."""
        return self.points.design.axes is None

    @property
    def is_family(self) -> bool:
        """Whether lines over one parameter show every point: a grid of few parameters, or one parameter alone."""
        columns, lines, *_ = [1, 1, *sorted(len(np.unique(column.values)) for column in self.parameters)][-3:]
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
            _, group = np.unique(np.searchsorted(edges, x, side="right"), return_inverse=True)
            levels = np.bincount(group, x) / np.bincount(group)
        count = np.bincount(group)
        mean, n, k = np.bincount(group, y) / count, len(y), len(count)
        share = float(np.sum(count * (mean - y.mean()) ** 2) / np.sum((y - y.mean()) ** 2))
        if self.is_adjusted and n > k:
            share = max(0.0, 1.0 - (1.0 - share) * (n - 1) / (n - k))
        return Effect(levels, mean, share)

    @property
    def telling(self) -> list[Column]:  # quantities that differ between points
        return [column for column in self.quantities if len(column.levels) > 1]

    def strongest(self, quantity: Column) -> list[tuple[Column, float]]:
        """Parameters with the shares of the quantity's variance that they explain, the largest first."""
        effects = [(parameter, self.effect(parameter, quantity)) for parameter in self.parameters]
        shares = [(parameter, effect.share) for parameter, effect in effects if effect is not None]
        return sorted(shares, key=lambda found: -found[1])

    def sobol_indices(self, quantity: Column) -> Indices | None:
        """Of a quantity, (n_parameters,) each; None where the study was not sampled for them, or points are missing.
        Errors: of the order of 1/√base; small ones may come out negative.
        Source: Saltelli et al., Computer Physics Communications 181 (2010), by scipy.stats.sobol_indices."""
        n, d = self.points.design.base, len(self.points.design.keys)
        if not n or not np.isfinite(quantity.values).all() or not np.ptp(quantity.values) > 0.0:
            return None
        from scipy import stats

        f_A, f_B, *f_AB = quantity.values.reshape(d + 2, 1, n)
        found = stats.sobol_indices(func={"f_A": f_A, "f_B": f_B, "f_AB": np.array(f_AB)}, n=n)
        return np.ravel(found.first_order), np.ravel(found.total_order)


def table_of(points: Points, dataset: Dataset) -> Table:
    """Columns of a study from its dataset; quantities in the unit that engineers read."""
    design, quantities = points.design, []
    parameters = [
        _column(name, unit_of(key), name_in_words(name), [point[i] for point in design.points])
        for i, (key, name) in enumerate(zip(design.keys, design.names, strict=True))
    ]
    for name in points.study.keep.quantities:
        unit, meaning = QUANTITIES[name]
        factor, engineers = engineering(unit)
        quantities.append(_column(name, engineers or unit, meaning, (factor * dataset[name].values.ravel()).tolist()))
    return Table(
        points=points, parameters=[column for column in parameters if len(column.levels) > 1], quantities=quantities,
        complete=dataset.status.values.ravel() == COMPLETE,
    )  # fmt: skip


def _column(name: str, unit: str, meaning: str, values: Sequence) -> Column:
    wordy = any(isinstance(value, str | bool) for value in values)
    given = [NOTHING if value is None else str(value) for value in values]
    words = tuple(dict.fromkeys(given)) if wordy else ()
    numbers = [words.index(value) for value in given] if words else values  # None becomes NaN
    return Column(name=name, unit=unit, meaning=meaning, values=np.array(numbers, dtype=float), words=words)


def write_page(points: Points, folder: Folder, dataset: Dataset) -> None:
    """Write a study's page from its dataset. OSError: it can't be written; an earlier page stays."""
    load_matplotlib()
    from fem.study.figures import study_figures

    table, study, n = table_of(points, dataset), points.study, len(points)
    complete, shares = int(table.complete.sum()), len(table.parameters) > 1
    names = ", ".join(column.meaning for column in table.parameters) or "nothing"
    state = f"all {n} points are complete" if complete == n else f"{complete} of {n} points are complete"
    sobol = [(column, found) for column in table.quantities if (found := table.sobol_indices(column)) is not None]
    unsampled = ""  # why there are no Sobol indices, where a reader may look for them
    if not sobol and study.sampling.method == "sobol":
        unsampled = "No Sobol indices: some points are not complete, or nothing varies."
        if not points.design.base:
            unsampled = "No Sobol indices: they need their own points; set indices = true in [sampling]."
    failed = [(points.design.describe(i), status, text) for i, status, text in incomplete(dataset)]
    columns = [*table.parameters, *table.quantities]
    statistics = ("mean", "standard deviation") if table.is_adjusted else ()
    ranges = ("quantity", "smallest", "largest", *statistics, "points", *(("share of variance",) if shares else ()))
    text = render_page(
        TEMPLATE,
        name=study.name,
        verdict=f"Varied: {names}; {state}.",
        is_drawn=table.is_adjusted,
        shares=shares,
        ranges=Section(columns=ranges, rows=[_range(table, column) for column in table.quantities]),
        sobol=Section(columns=("quantity", "parameter", "alone", "with others"), rows=[
            (column.meaning, name_in_words(name), f"{first:.3f}", f"{total:.3f}")
            for column, found in sobol for name, first, total in zip(points.design.names, *found, strict=True)
        ]),
        unsampled=unsampled,
        figures=study_figures(table, sobol),
        points=Section(columns=("point", *(column.label for column in columns)), rows=[
            [str(i), *(column.shown(column.values[i]) for column in columns)] for i in range(min(n, MOST_ROWS))
        ]),
        more=n - MOST_ROWS,
        failed=Section(columns=("point", "status", "reason"), rows=failed[:MOST_ROWS], kind="words"),
        left_out=len(failed) - MOST_ROWS,
        facts=Section(columns=(), rows=_facts(table, dataset), kind="words"),
        version=dataset.attrs["program_version"],
        study=study.text,
        scene=study.scene.to_toml(),
    )  # fmt: skip
    write_whole(folder.page, text.encode())


def _range(table: Table, quantity: Column) -> list[str]:
    """Name, smallest and largest value, of drawn points mean and deviation, points, shares of variance."""
    known = quantity.values[np.isfinite(quantity.values)]
    functions = (np.min, np.max, *((np.mean, np.std) if table.is_adjusted else ()))
    values = [quantity.shown(float(f(known))) if len(known) else NOTHING for f in functions]
    row = [quantity.label, *values, str(len(known))]
    if len(table.parameters) > 1:  # else it explains all that differs
        shares = [f"{cause.meaning} {100 * x:.0f} %" for cause, x in table.strongest(quantity) if x >= TELLING]
        row.append(", ".join(shares) or NOTHING)
    return row


def _facts(table: Table, dataset: Dataset) -> list[tuple[str, str]]:
    study, design = table.points.study, table.points.design
    shape = "" if design.axes is None else ", " + " × ".join(str(size) for size in design.shape)
    varied = []
    for key, values in zip(design.keys, zip(*design.points, strict=True), strict=True):
        numbers = [value for value in values if isinstance(value, float | int) and not isinstance(value, bool)]
        words = dict.fromkeys(str(value) for value in values if value is not None)
        span = f"{min(numbers):.4g} to {max(numbers):.4g}" if numbers else ", ".join(words)
        varied.append(f"{key}: {span}")
    rows = [
        ("Points", f"{len(table.complete)} ({study.sampling.method}{shape})"),
        *([("Seed", str(study.sampling.seed))] if study.sampling.is_drawn else []),
        ("Model", study.scene.model),
        ("Varied", "; ".join(varied)),
        ("Quantities in the dataset", "; ".join(f"{column.name}: {column.meaning}" for column in table.quantities)),
        ("Signals", ", ".join(study.keep.signals) or "none kept"),
        ("Program", f"{dataset.attrs['program_version']}, text {dataset.attrs['program_digest']}"),
    ]
    seconds = dataset.seconds.values[np.isfinite(dataset.seconds.values)]
    if len(seconds):
        spans = " / ".join(f"{f(seconds):.4g} s" for f in (np.min, np.median, np.max))
        rows += [
            ("Processor time, all points", f"{seconds.sum():.4g} s"),
            ("Per point: shortest, median, longest", spans),
            ("Points per hour and process", f"{3600.0 / max(seconds.mean(), 1e-9):.4g}"),
        ]
    return rows


def plan_lines(points: Points, pending: list[int], found: Expected | None, options: StudyOptions) -> list[str]:
    """What a study will take, a line each; `found` is None where nothing is left to solve."""
    design, study = points.design, points.study
    shape = " × ".join(str(size) for size in design.shape)
    rows = {
        "points": f"{len(points)} ({study.sampling.method}, {shape}), {len(pending)} to be solved",
        "varied": ", ".join(design.keys),
        "kept": ", ".join((*study.keep.quantities, *study.keep.signals)) or "nothing",
    }
    if assumed := points.scene(0).assumed:
        rows["defaults"] = assumed
    if found is not None:
        total = found.seconds * len(pending)
        processes = options.processes(total)
        where = f"{processes} processes" if processes else "this process"
        memory = found.memory * (1 + processes)
        rows |= {
            "time per point": f"about {found.seconds:.2g} s of one processor",
            "processor time": f"about {total / 3600.0:.2g} hours ({total:.3g} s)",
            "solved by": where if options.scheduler is None else f"the workers of {options.scheduler}",
            "memory": "unknown" if isnan(memory) else f"about {1e-6 * memory:.0f} MB",
            "disk": f"about {1e-6 * found.disk * len(points):.3g} MB",
        }
    return [f"Plan of the study {study.name}", *(f"{name + ':':16s} {value}" for name, value in rows.items())]


def outcome_lines(points: Points, dataset: Dataset) -> list[str]:
    """How many points there are of each status, and the first that failed, a line each."""
    counts = sorted(Counter(dataset.status.values.flat).items())
    lines = [f"{len(points)} points: {', '.join(f'{count} {status}' for status, count in counts)}"]
    lines += [f"{points.design.describe(i)}: {status}: {text}" for i, status, text in incomplete(dataset)]
    more = ["… more are on the page"] if len(lines) > 1 + MOST_NAMED else []
    return [*lines[: 1 + MOST_NAMED], *more]
