"""What run-study prints: of a study that is planned, and of one that is done."""

from collections import Counter
from math import isnan

from rich.console import Console
from xarray import Dataset

from fem.study.dataset import incomplete
from fem.study.folder import Folder
from fem.study.running import Expected, StudyOptions, workers_for
from fem.study.solving import Points
from lagrange.messages import shown

MOST_NAMED = 5  # points that have failed


def _megabytes(size: float) -> str:
    return "unknown" if isnan(size) else f"about {1e-6 * size:.0f} MB"


def print_plan(points: Points, pending: list[int], found: Expected | None, options: StudyOptions) -> None:
    """What a study will take; `found` is None where nothing is left to solve."""
    console, design = Console(highlight=False), points.design
    shape = " × ".join(str(size) for size in design.shape)
    rows = {
        "points": f"{len(points)} ({points.study.sampling.method}, {shape}), {len(pending)} to be solved",
        "varied": ", ".join(design.keys),
        "kept": ", ".join((*points.study.keep.quantities, *points.study.keep.signals)) or "nothing",
    }
    if assumed := points.scene(0).assumed:
        rows["defaults"] = assumed
    if found is not None:
        total = found.seconds * len(pending)
        processes = workers_for(options, total)
        where = f"{processes} processes" if processes else "this process"
        rows |= {
            "time per point": f"about {found.seconds:.2g} s of one processor",
            "processor time": f"about {total / 3600.0:.2g} hours ({total:.3g} s)",
            "solved by": where if options.scheduler is None else f"the workers of {options.scheduler}",
            "memory": _megabytes(found.memory * (1 + processes)),
            "disk": f"about {1e-6 * found.disk * len(points):.3g} MB",
        }
    console.print(f"Plan of the study {shown(points.study.name)}", style="italic", markup=False)
    for name, value in rows.items():
        console.print(f"{name + ':':16s} {shown(value)}", soft_wrap=True, markup=False)


def outcome_lines(points: Points, found: Dataset) -> list[str]:
    """How many points there are of each status, and the first that failed, a line each."""
    counts = sorted(Counter(found.status.values.flat).items())
    lines = [f"{len(points)} points: {', '.join(f'{count} {status}' for status, count in counts)}"]
    lines += [f"{points.design.describe(i)}: {status}: {text}" for i, status, text in incomplete(found)]
    more = ["… more are on the page"] if len(lines) > 1 + MOST_NAMED else []
    return [*lines[: 1 + MOST_NAMED], *more]


def print_outcome(points: Points, folder: Folder, found: Dataset) -> None:
    """What came of a study, and where its dataset is."""
    console = Console(highlight=False)
    for line in outcome_lines(points, found):
        console.print(shown(line), soft_wrap=True, markup=False)
    console.print(f"Dataset: {shown(folder.dataset)}", soft_wrap=True, markup=False)
    console.print(f"Page: {shown(folder.page)}", soft_wrap=True, markup=False)
