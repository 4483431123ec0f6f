"""Writer of the report folder, residual.nc, summary.json, figures, report.html, which appears whole or not at all."""

import csv
import json
import os
import secrets
import shutil
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from lagrange.files.hdf5 import hdf5_to_write, variable
from lagrange.files.input import read_plain
from lagrange.files.output import real_path
from lagrange.files.pages import load_matplotlib
from lagrange.version import VERSION
from residual.errors import InputError
from residual.evaluation import Evaluation
from residual.figures.saved import SavedFigure
from residual.formatting import term_label
from residual.summary import PROGRAM, Export, ReportOptions, summarise

OURS = {"residual.nc", "summary.json", "report.html"}
OURS_BY_NAME = (".png", ".svg", ".csv", ".mat", ".wav")
WHOLE = ReportOptions()


def write_report(evaluation: Evaluation, folder: str | Path, options: ReportOptions = WHOLE) -> dict:
    """Write the report folder and return the summary.

    Parameters
    ----------
    options : what the report is to hold

    Errors
    ------
    InputError: the folder holds something that is not an earlier report. OSError: it can't be written. Either
    way an earlier report stays as it was and no part of a new one is left.
    """
    folder = real_path(Path(folder))
    check_replaceable(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    fresh = folder.with_name(f".{folder.name}-{secrets.token_hex(4)}")  # known before it exists: no signal leaves it
    try:
        fresh.mkdir(mode=0o700)
        summary = _fill(evaluation, fresh, options)
        umask = os.umask(0)
        os.umask(umask)
        fresh.chmod(0o777 & ~umask)
        _move_into_place(fresh, folder)
    except BaseException:
        shutil.rmtree(fresh, ignore_errors=True)
        raise
    return summary


def check_replaceable(folder: Path) -> None:
    """Refuse to touch anything but a missing or empty folder, or an earlier report and nothing else."""
    folder = real_path(folder)
    if not folder.exists():
        return
    if not folder.is_dir():
        raise InputError(f"{folder}: is a file, not a folder; choose another --output")
    names = {entry.name for entry in folder.iterdir()}
    if not names:
        return
    try:
        summary = json.loads(read_plain(folder / "summary.json"))
        if summary["program"] != PROGRAM:
            raise ValueError
        ours = set(summary.get("files", ()))
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        raise InputError(
            f"{folder}: not empty and no report of {PROGRAM}; choose another --output or empty it"
        ) from None
    of_earlier = () if ours else OURS_BY_NAME  # versions that did not list what they wrote
    foreign = sorted(n for n in names - OURS - ours if not n.endswith(of_earlier))
    if foreign:
        raise InputError(
            f"{folder}: holds {foreign[0]}, which is not part of a report; move it or choose another --output"
        )


def _move_into_place(fresh: Path, folder: Path) -> None:
    """Swap a finished folder in; the old one goes last."""
    if not folder.exists():
        fresh.rename(folder)
        return
    old = fresh.with_name(fresh.name + "-old")
    folder.rename(old)
    try:
        fresh.rename(folder)
    except BaseException:
        old.rename(folder)
        raise
    shutil.rmtree(old, ignore_errors=True)


def _fill(evaluation: Evaluation, folder: Path, options: ReportOptions) -> dict:
    """Write every file of the report."""
    from residual.load_zone import quasi_static
    from residual.report import render_report

    version = VERSION
    statics = quasi_static(evaluation.record, evaluation.law.name)
    figures = {}
    if options.figures:
        load_matplotlib()
        from residual.figures.drawing import draw_figures

        figures = draw_figures(evaluation, statics, options, folder)
    _write_arrays(evaluation, folder / "residual.nc", version)
    write_exports(evaluation, [figure for group in figures.values() for figure in group], options.exports, folder)
    page = render_report(evaluation, figures, options, version, statics)
    (folder / "report.html").write_text(page, encoding="utf-8")
    summary = summarise(evaluation, options, version) | {
        "files": sorted({path.name for path in folder.iterdir()} | OURS)
    }
    (folder / "summary.json").write_text(
        json.dumps(summary, indent=1, allow_nan=False, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    return summary


def _write_arrays(evaluation: Evaluation, path: Path, version: str) -> None:
    """Write residual.nc: HDF5 with dimension scales, which is NetCDF-4."""
    t, budget = evaluation.record, evaluation.budget
    series = {
        "error_x": (budget.x.error, "left side of equation (22)"),
        "error_y": (budget.y.error, "left side of equation (23), load moved over"),
    }
    for d in evaluation.directions:
        for name, term in d.budget.terms.items():
            series[f"budget_{d.name}_{name}"] = (term, f"{term_label(name)} term of error_{d.name}")
        if d.budget.momentum is not None:
            series[f"momentum_{d.name}"] = (d.budget.momentum, f"error_{d.name} with the run's own contact forces")
    with hdf5_to_write(path, track_order=True) as file:
        variable(file, "time", t.time, ("time",), "s", "time")
        variable(file, "frequency", evaluation.x.spectrum.frequency, ("frequency",), "Hz", "frequency")
        for name, (value, long_name) in series.items():
            variable(file, name, value, ("time",), "N", long_name)
        count = evaluation.loaded_count.astype(np.int32)
        variable(file, "loaded_rollers", count, ("time",), "1", "rollers in the load zone")
        for name, (psd, of) in _densities(evaluation).items():
            variable(file, name, psd, ("frequency",), "N2 Hz-1", f"one-sided PSD of {of}")
        for d in evaluation.directions:
            found = d.vibration.envelope
            if found is not None:
                body = d.vibration.body
                of = f"the envelope of the {body}'s acceleration in {d.name}, {found.low:.4g} to {found.high:.4g} Hz"
                name = f"{body}_envelope_psd_{d.name}"
                variable(file, name, found.spectrum.psd, ("frequency",), "m2 s-4 Hz-1", f"one-sided PSD of {of}")
        if evaluation.x.orders is not None:
            orders = evaluation.x.orders.path.frequency
            variable(file, "shaft_order", orders, ("shaft_order",), "1", "cycles per turn of the shaft")
        for d in evaluation.directions:
            if d.orders is not None:
                of = f"one-sided PSD over orders of the hub's place in {d.name}"
                variable(file, f"hub_order_psd_{d.name}", d.orders.path.psd, ("shaft_order",), "m2", of)
                of = f"one-sided PSD over orders of error_{d.name}"
                variable(file, f"order_psd_{d.name}", d.orders.error.psd, ("shaft_order",), "N2", of)
        file.attrs.update(
            program=PROGRAM, program_version=version, run=t.name, law=evaluation.law.name,
            order=evaluation.order,
            frequency_resolution_Hz=evaluation.x.spectrum.resolution, window="hann", scene=t.scene.to_toml(),
        )  # fmt: skip


def _densities(evaluation: Evaluation) -> dict[str, tuple[np.ndarray, str]]:
    """Power spectral densities, N²/Hz, and what each is of, by the variable's name."""
    found = {}
    for d in evaluation.directions:
        error = f"error_{d.name}"
        found[f"psd_{d.name}"] = d.spectrum.psd, error
        for name, spectrum in d.term_spectra.items():
            found[f"psd_{d.name}_{name}"] = spectrum.psd, f"the {term_label(name)} term of {error}"
        if d.envelope is not None:
            band = f"{d.envelope.low:.4g} to {d.envelope.high:.4g} Hz"
            found[f"envelope_psd_{d.name}"] = d.envelope.spectrum.psd, f"the envelope of {error}, {band}"
    return found


# The data of a report for other programs: signals as CSV, MAT and WAV, the curves of figures as CSV.


SOUND = "hub_acceleration.wav"


def signals(evaluation: Evaluation) -> dict[str, np.ndarray]:
    """Time series, SI, each (n_times,) or (n_times, n_rollers), by the names of the result file and of residual.nc."""
    t = evaluation.record
    found = {"time": t.time, "inner_x": t.inner_x, "inner_y": t.inner_y}
    found |= dict(zip(("inner_ax", "inner_ay"), evaluation.hub_acceleration, strict=True))
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

        sound = np.column_stack(evaluation.hub_acceleration).astype(np.float32)
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
