"""The page of a study: one file, to be opened anywhere."""

from pathlib import Path

import numpy as np
from xarray import Dataset

from fem.study.dataset import incomplete
from fem.study.effects import NOTHING, Column, Indices, Table, sobol_indices, table_of
from fem.study.folder import Folder
from fem.study.solving import Points
from lagrange.files.output import write_whole
from lagrange.files.pages import load_matplotlib, render_page
from lagrange.scene.keys import name_in_words

TEMPLATE = Path(__file__).parent / "template" / "study.html.j2"
MOST_ROWS = 200  # of a table of points
TELLING = 0.05  # of a quantity's variance: parameters that explain less are not named


def write_page(points: Points, folder: Folder, dataset: Dataset) -> None:
    """Write a study's page from its dataset. OSError: it can't be written; an earlier page stays."""
    load_matplotlib()
    from fem.study.figures import study_figures

    table = table_of(points, dataset)
    indices = [(each, found) for each in table.quantities if (found := sobol_indices(table, each)) is not None]
    failed = [(points.design.describe(i), status, text) for i, status, text in incomplete(dataset)]
    columns = [*table.parameters, *table.quantities]
    text = render_page(
        TEMPLATE,
        name=points.study.name,
        verdict=_verdict(table),
        facts=_facts(table, dataset),
        is_drawn=table.is_adjusted,
        shares=len(table.parameters) > 1,
        ranges=[(each, _range(table, each)) for each in table.quantities],
        sobol=_sobol_rows(table, indices),
        unsampled=_unsampled(table, indices),
        figures=study_figures(table, indices),
        columns=columns,
        rows=[[str(i), *(each.shown(each.values[i]) for each in columns)] for i in range(len(points))][:MOST_ROWS],
        more=max(0, len(points) - MOST_ROWS),
        failed=failed[:MOST_ROWS],
        left_out=max(0, len(failed) - MOST_ROWS),
        speed=_speed(dataset),
        version=dataset.attrs["program_version"],
        study=points.study.text,
        scene=points.study.scene.to_toml(),
    )
    write_whole(folder.page, text.encode())


def number(value: float) -> str:
    """A number for people."""
    return f"{value:.4g}" if np.isfinite(value) else NOTHING


def _verdict(table: Table) -> str:
    n, complete = len(table.complete), int(table.complete.sum())
    names = ", ".join(each.meaning for each in table.parameters) or "nothing"
    state = f"all {n} points are complete" if complete == n else f"{complete} of {n} points are complete"
    return f"Varied: {names}; {state}."


def _facts(table: Table, dataset: Dataset) -> list[tuple[str, str]]:
    study, design = table.points.study, table.points.design
    shape = "" if design.axes is None else ", " + " × ".join(str(size) for size in design.shape)
    drawn = study.sampling.method in ("lhs", "sobol")
    return [
        ("Points", f"{len(table.complete)} ({study.sampling.method}{shape})"),
        *([("Seed", str(study.sampling.seed))] if drawn else []),
        ("Model", study.scene.model),
        ("Varied", "; ".join(f"{key}: {_span(table.points, i)}" for i, key in enumerate(design.keys))),
        ("Quantities in the dataset", "; ".join(f"{each.name}: {each.meaning}" for each in table.quantities)),
        ("Signals", ", ".join(study.keep.signals) or "none kept"),
        ("Program", f"{dataset.attrs['program_version']}, text {dataset.attrs['program_digest']}"),
    ]


def _span(points: Points, i: int) -> str:
    values = [point[i] for point in points.design.points]
    numbers = [value for value in values if isinstance(value, float | int) and not isinstance(value, bool)]
    if numbers:
        return f"{number(float(min(numbers)))} to {number(float(max(numbers)))}"
    return ", ".join(dict.fromkeys(str(value) for value in values if value is not None))


def _range(table: Table, quantity: Column) -> list[str]:
    """Smallest and largest value, of drawn points mean and deviation, points, shares of variance."""
    known = quantity.values[np.isfinite(quantity.values)]
    functions = (np.min, np.max, *((np.mean, np.std) if table.is_adjusted else ()))
    values = [quantity.shown(float(f(known))) if len(known) else NOTHING for f in functions]
    row = [*values, str(len(known))]
    if len(table.parameters) > 1:  # else it explains all that differs
        shares = [
            f"{each.meaning} {100 * share:.0f} %" for each, share in table.strongest(quantity) if share >= TELLING
        ]
        row.append(", ".join(shares) or NOTHING)
    return row


def _sobol_rows(table: Table, indices: list[tuple[Column, Indices]]) -> list[tuple[str, ...]]:
    names = [name_in_words(name) for name in table.points.design.names]
    return [
        (quantity.meaning, name, f"{first:.3f}", f"{total:.3f}")
        for quantity, found in indices
        for name, first, total in zip(names, found.first, found.total, strict=True)
    ]


def _unsampled(table: Table, indices: list[tuple[Column, Indices]]) -> str:
    """Why there are no Sobol indices, where a reader may look for them."""
    if indices or table.points.study.sampling.method != "sobol":
        return ""
    if not table.points.design.base:
        return "No Sobol indices: they need their own points; set indices = true in [sampling]."
    return "No Sobol indices: some points are not complete, or nothing varies."


def _speed(dataset: Dataset) -> list[tuple[str, str]]:
    seconds = dataset.seconds.values[np.isfinite(dataset.seconds.values)]
    if not len(seconds):
        return []
    return [
        ("Processor time, all points", f"{number(float(seconds.sum()))} s"),
        (
            "Per point: shortest, median, longest",
            " / ".join(f"{number(float(f(seconds)))} s" for f in (np.min, np.median, np.max)),
        ),
        ("Points per hour and process", number(3600.0 / float(seconds.mean()))),
    ]
