"""What a study's numbers say, how much each parameter changes each quantity: on the terminal, and on a page."""

from collections import Counter
from math import isnan
from pathlib import Path

import numpy as np
from xarray import Dataset

from fem.study.folder import NOTHING, Folder, incomplete, table_of
from fem.study.solving import Expected, Points, StudyOptions
from lagrange.files.output import load_matplotlib, render_page, write_whole
from lagrange.messages import Section
from lagrange.scene.keys import name_in_words

MOST_NAMED = 5  # points that have failed, on the terminal
MOST_ROWS = 200  # of a table of points
TELLING = 0.05  # of a quantity's variance: parameters that explain less are not named
TEMPLATE = Path(__file__).parent / "template" / "study.html.j2"


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
        TEMPLATE, name=study.name, verdict=f"Varied: {names}; {state}.", is_drawn=table.is_adjusted, shares=shares,
        ranges=Section(columns=ranges, rows=[_range(table, column) for column in table.quantities]),
        sobol=Section(columns=("quantity", "parameter", "alone", "with others"), rows=[
            (column.meaning, name_in_words(name), f"{first:.3f}", f"{total:.3f}")
            for column, found in sobol for name, first, total in zip(points.design.names, *found, strict=True)
        ]),
        unsampled=unsampled, figures=study_figures(table, sobol),
        points=Section(columns=("point", *(column.label for column in columns)), rows=[
            [str(i), *(column.shown(column.values[i]) for column in columns)] for i in range(min(n, MOST_ROWS))
        ]),
        failed=Section(columns=("point", "status", "reason"), rows=failed[:MOST_ROWS], kind="words"),
        more=n - MOST_ROWS, left_out=len(failed) - MOST_ROWS,
        facts=Section(columns=(), rows=_facts(table, dataset), kind="words"),
        version=dataset.attrs["program_version"], study=study.text, scene=study.scene.to_toml())  # fmt: skip
    write_whole(folder.page, text.encode())


def _range(table, quantity):
    """Name, smallest and largest value, of drawn points mean and deviation, points, shares of variance."""
    known = quantity.values[np.isfinite(quantity.values)]
    functions = (np.min, np.max, *((np.mean, np.std) if table.is_adjusted else ()))
    values = [quantity.shown(float(f(known))) if len(known) else NOTHING for f in functions]
    row = [quantity.label, *values, str(len(known))]
    if len(table.parameters) > 1:  # else it explains all that differs
        shares = [f"{cause.meaning} {100 * x:.0f} %" for cause, x in table.strongest(quantity) if x >= TELLING]
        row.append(", ".join(shares) or NOTHING)
    return row


def _facts(table, dataset):
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
