"""What a report holds beside the check itself, and its data for other programs: CSV, MAT, WAV, curves of figures."""

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from residual.differentiate import derivative
from residual.evaluation import Evaluation
from residual.fault_finding import FaultSearch
from residual.figures.curves import SavedFigure

Export = Literal["csv", "curves", "mat", "wav"]


@dataclass(frozen=True, kw_only=True)
class Parts:
    """Of a report."""

    tolerance: float | None = None  # N, on the rms of both errors; None: no verdict
    search: FaultSearch | None = None  # for spalls; None: none was made
    figures: bool = True  # most of a report's time
    equations: bool = True  # False: of the run alone, without the error forces of (22) and (23)
    exports: tuple[Export, ...] = ()  # the data in other formats
    other: Evaluation | None = None  # what the run is compared with


# The data of a report for other programs: signals as CSV, MAT and WAV, the curves of figures as CSV.


SOUND = "hub_acceleration.wav"


def accelerations(evaluation: Evaluation) -> tuple[np.ndarray, np.ndarray]:
    """Of the hub in x and y, m/s²: the source's own where it tells them, else from positions."""
    t = evaluation.record
    pairs = ((t.inner_ax, t.inner_x), (t.inner_ay, t.inner_y))
    x, y = (derivative(place, t.interval, order=evaluation.order) if own is None else own for own, place in pairs)
    return x, y


def signals(evaluation: Evaluation) -> dict[str, np.ndarray]:
    """Time series, SI, each (n_times,) or (n_times, n_rollers), by the names of the result file and of residual.nc."""
    t = evaluation.record
    found = {"time": t.time, "inner_x": t.inner_x, "inner_y": t.inner_y}
    found |= dict(zip(("inner_ax", "inner_ay"), accelerations(evaluation), strict=True))
    found |= {"error_x": evaluation.budget.x.error, "error_y": evaluation.budget.y.error}
    return found | {"roller_x": t.roller_x, "roller_y": t.roller_y, "inner_force": evaluation.force}


def write_exports(evaluation: Evaluation, figures: Iterable[SavedFigure], wanted: Iterable[Export], folder: Path):
    """Write what is wanted and no more: `signals.csv`; each figure's curves; `signals.mat`; the hub's sound."""
    if "csv" in wanted:
        _write_signals(signals(evaluation), folder / "signals.csv")
    if "curves" in wanted:
        for figure in figures:
            _write_curves(figure, folder / f"{figure.name}.csv")
    if "mat" in wanted:
        from scipy.io import savemat

        savemat(folder / "signals.mat", signals(evaluation), oned_as="column", do_compression=True)
    if "wav" in wanted:
        from scipy.io import wavfile

        sound = np.column_stack(accelerations(evaluation)).astype(np.float32)
        wavfile.write(folder / SOUND, round(1.0 / evaluation.record.interval), sound)


def _write_signals(found: dict[str, np.ndarray], path: Path) -> None:
    """One column for each signal, `name_<j>` for those of roller j."""
    names, columns = [], []
    for name, values in found.items():
        one = values.ndim == 1
        names += [name] if one else [f"{name}_{j}" for j in range(values.shape[1])]
        columns.append(values[:, None] if one else values)
    np.savetxt(path, np.hstack(columns), "%.12g", ",", header=",".join(names), comments="", encoding="utf-8")


def _write_curves(figure: SavedFigure, path: Path) -> None:
    """Rows of panel, curve, x and y."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("panel", "curve", "x", "y"))
        for curve in figure.curves:
            writer.writerows((curve.panel, curve.name, f"{x:.9g}", f"{y:.9g}") for x, y in curve.points)
