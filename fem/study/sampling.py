"""The points of a study: values of its parameters, by the method that its file names."""

import csv
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from fem.study.parameters import Value, is_value
from lagrange.errors import UsageError
from lagrange.scene.faults import quoted
from lagrange.scene.files import load
from lagrange.scene.scene import SceneError

if TYPE_CHECKING:
    from fem.study.study_file import Study

MOST_POINTS = 1_000_000
MOST_NUMBERS = 10 * MOST_POINTS  # in all points: some hundred bytes of memory each
POINT = "point"  # the dimension of points that are no grid


@dataclass(frozen=True, kw_only=True)
class Design:
    """The points of a study in a fixed order: on a grid the last parameter changes fastest."""

    keys: tuple[str, ...]  # dotted keys of the scene
    points: list[tuple[Value | None, ...]]  # values by key
    axes: tuple[tuple[Value, ...], ...] | None  # of a grid, by key; None: the points are no grid
    base: int = 0  # points of each of the matrices A, B and AB of Sobol indices; 0: there are none

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters: the last part of each key where that is a name and theirs alone, else the whole key."""
        last = [key.rpartition(".")[2] for key in self.keys]
        return tuple(
            name if last.count(name) == 1 and name != POINT and not name.isdecimal() else key.replace(".", "_")
            for name, key in zip(last, self.keys, strict=True)
        )

    @property
    def dimensions(self) -> tuple[str, ...]:
        return (POINT,) if self.axes is None else self.names

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self.points),) if self.axes is None else tuple(len(axis) for axis in self.axes)

    def changes(self, i: int) -> dict[str, Value]:
        """What point i changes of the scene: keys of cells left empty stay as they are."""
        return {key: value for key, value in zip(self.keys, self.points[i], strict=True) if value is not None}

    @property
    def always(self) -> dict[str, Value]:
        """Keys that every point changes, with their values in the first."""
        given = [all(value is not None for value in column) for column in zip(*self.points, strict=True)]
        return {key: value for key, value in self.changes(0).items() if given[self.keys.index(key)]}

    def describe(self, i: int) -> str:
        """Point i in words."""
        values = ", ".join(f"{key} = {_short(value)}" for key, value in self.changes(i).items())
        return f"point {i} ({values})"


def _short(value: Value) -> str:
    return f"{value:.8g}" if isinstance(value, float) else repr(value)


def design_of(study: "Study") -> Design:
    """The points of a study; the same study gives the same points.

    Errors
    ------
    UsageError: lengths that differ, too many points, a list that is none.
    """
    method, parameters = study.sampling.method, study.parameters
    keys = tuple(parameters)
    if method == "list":
        return _listed(study)
    if method in ("lhs", "sobol"):
        return _drawn(study)
    axes = tuple(parameter.axis(method) for parameter in parameters.values())
    if method == "zip":
        lengths = {key: len(axis) for key, axis in zip(keys, axes, strict=True)}
        if len(set(lengths.values())) > 1:
            counts = ", ".join(f'"{key}" {length}' for key, length in lengths.items())
            raise UsageError(f'parameters: method = "zip" needs as many values of each, here {counts}')
        return Design(keys=keys, points=list(zip(*axes, strict=True)), axes=None)
    count = prod(len(axis) for axis in axes)
    _check_count(count, len(axes), "parameters")
    return Design(keys=keys, points=list(product(*axes)), axes=axes)


def _check_count(count: int, parameters: int, what: str) -> None:
    if count > MOST_POINTS:
        raise UsageError(f"{what}: {count:,} points; at most {MOST_POINTS:,} are allowed")
    if count * parameters > MOST_NUMBERS:
        raise UsageError(
            f"{what}: {count:,} points of {parameters:,} parameters; points times parameters may be {MOST_NUMBERS:,}"
        )


def _drawn(study: "Study") -> Design:
    """Points of a Latin hypercube or of a scrambled Sobol sequence."""
    from scipy.stats import qmc

    sampling, keys = study.sampling, tuple(study.parameters)
    d, n = len(keys), sampling.samples or 0
    _check_count(n * (d + 2) if sampling.indices else n, d, "sampling.samples")
    rng = np.random.default_rng(sampling.seed)
    if sampling.method == "lhs":
        shares = qmc.LatinHypercube(d=d, rng=rng).random(n)
    elif not sampling.indices:
        shares = qmc.Sobol(d=d, rng=rng).random_base2(n.bit_length() - 1)
    else:
        shares = _matrices(qmc.Sobol(d=2 * d, rng=rng).random_base2(n.bit_length() - 1), d)
    columns = [parameter.drawn(shares[:, i]) for i, parameter in enumerate(study.parameters.values())]
    return Design(keys=keys, points=list(zip(*columns, strict=True)), axes=None, base=n if sampling.indices else 0)


def _matrices(shares: np.ndarray, d: int) -> np.ndarray:
    """A, B, and for each parameter A with its column of B, one below the other, ((d + 2) n, d).

    Source: Saltelli et al., Computer Physics Communications 181 (2010), as scipy.stats.sobol_indices takes them.
    """
    A, B = shares[:, :d], shares[:, d:]
    mixed = []
    for i in range(d):
        AB = A.copy()
        AB[:, i] = B[:, i]
        mixed.append(AB)
    return np.concatenate([A, B, *mixed])


def _listed(study: "Study") -> Design:
    """Points of a CSV table whose header names keys of the scene; a value is TOML, or a plain word, or left empty."""
    name, text = study.sampling.file, study.listed or ""
    try:
        rows = [row for row in csv.reader(text.splitlines()) if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise UsageError(f"{name}: a row can't be read: {error}") from None
    if len(rows) < 2:
        raise UsageError(f"{name}: holds no points; a header of scene keys and a row for each point are needed")
    keys = tuple(cell.strip() for cell in rows[0])
    if not all(keys) or len(set(keys)) < len(keys):
        raise UsageError(f"{name}: its header must name a key of the scene in each column, none twice")
    _check_count(len(rows) - 1, len(keys), name or "")
    points = []
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(keys):
            raise UsageError(f"{name}: row {number} has {len(row)} values, its header {len(keys)}")
        points.append(tuple(_value(name or "", number, key, cell.strip()) for key, cell in zip(keys, row, strict=True)))
    return Design(keys=keys, points=points, axes=None)


def _value(name: str, row: int, key: str, cell: str) -> Value | None:
    if not cell:
        return None
    try:
        found = load(f"value = {cell}", "")["value"]
    except SceneError:
        found = cell
    if not is_value(found):
        raise UsageError(f"{name}: row {row}, {key} = {quoted(cell)}: is no value of a scene")
    return found
