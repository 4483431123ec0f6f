"""Writers of folders that appear whole or not at all: page, figures and summary.json of a command; a check's arrays."""

import json
import os
import secrets
import shutil
from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange.files.hdf5 import hdf5_to_write, variable
from lagrange.files.input import read_plain
from lagrange.files.output import named, real_path
from lagrange.files.pages import load_matplotlib, render_page
from lagrange.version import VERSION
from residual.errors import InputError
from residual.evaluation import Evaluation
from residual.figures.saved import LARGEST_SVG
from residual.formatting import term_label
from residual.summary import PROGRAM, ReportOptions, summarise

if TYPE_CHECKING:
    from residual.figures.saved import SavedFigure

WHOLE = ReportOptions()


@dataclass(frozen=True)
class Page:
    """A page to be written."""

    name: str  # of its file
    template: Path
    shown: Mapping[str, Any]


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
    from residual.load_zone import quasi_static
    from residual.report import TEMPLATE, page_of

    statics = quasi_static(evaluation.record, evaluation.law.name)

    def draw(fresh: Path) -> "dict[str, list[SavedFigure]]":
        from residual.figures.drawing import draw_figures

        return draw_figures(evaluation, statics, options, fresh)

    def more(fresh: Path) -> None:
        _write_arrays(evaluation, fresh / "residual.nc")
        if options.signals:
            _write_signals(evaluation, fresh / "signals.csv")

    page = Page("report.html", TEMPLATE, page_of(evaluation, options, statics))
    return write_folder(folder, PROGRAM, summarise(evaluation, options), page, draw if options.figures else None, more)


def write_folder(
    folder: str | Path,
    program: str,
    summary: dict[str, Any],
    page: Page,
    draw: "Callable[[Path], dict[str, list[SavedFigure]]] | None" = None,
    more: Callable[[Path], None] = lambda fresh: None,
) -> dict[str, Any]:
    """Write a page, its figures and summary.json into a folder, which appears whole or not at all; gives the summary.

    Parameters
    ----------
    summary : numbers of summary.json, to which program, version and names of all files are added
    page : of its file's name, its template, and what that shows beside figures
    draw : draws into a folder, by matplotlib, figures by groups; None: no figures
    more : writes what else the folder is to hold

    Errors
    ------
    InputError: the folder holds something else. OSError: it can't be written.
    """
    folder = real_path(Path(folder))
    check_replaceable(folder, program)
    folder.parent.mkdir(parents=True, exist_ok=True)
    fresh = folder.with_name(f".{folder.name}-{secrets.token_hex(4)}")  # known before it exists: no signal leaves it
    try:
        fresh.mkdir(mode=0o700)
        if draw is not None:
            load_matplotlib()
        drawn = {} if draw is None else draw(fresh)
        more(fresh)
        figures = {group: [(figure, embedded(figure)) for figure in found] for group, found in drawn.items()}
        html = render_page(page.template, version=VERSION, figures=figures, **page.shown)
        (fresh / page.name).write_text(html, encoding="utf-8")
        files = sorted({path.name for path in fresh.iterdir()} | {"summary.json"})
        summary = {"program": program, "program_version": VERSION} | summary | {"files": files}
        said = json.dumps(summary, indent=1, allow_nan=False, ensure_ascii=False)
        (fresh / "summary.json").write_text(said + "\n", encoding="utf-8")
        umask = os.umask(0)
        os.umask(umask)
        fresh.chmod(0o777 & ~umask)
        _move_into_place(fresh, folder)
    except BaseException as error:
        shutil.rmtree(fresh, ignore_errors=True)
        if isinstance(error, OSError):
            raise named(error, folder, fresh) from None
        raise
    return summary


def embedded(figure: "SavedFigure") -> str:
    """Encode the figure as a data address: vectors unless they are many and take more room than pixels."""
    vectors, pixels = figure.svg.stat().st_size, figure.png.stat().st_size
    small = vectors <= LARGEST_SVG or vectors <= pixels
    path, kind = (figure.svg, "svg+xml") if small else (figure.png, "png")
    return f"data:image/{kind};base64,{b64encode(path.read_bytes()).decode('ascii')}"


def check_replaceable(folder: Path, program: str = PROGRAM) -> None:
    """Refuse to touch anything but a missing or empty folder, or an earlier report of a program and nothing else."""
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
        if summary["program"] != program:
            raise ValueError
        ours = set(summary["files"])
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        raise InputError(
            f"{folder}: not empty and no report of {program}; choose another --output or empty it"
        ) from None
    if foreign := sorted(names - ours):
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


def _write_arrays(evaluation: Evaluation, path: Path) -> None:
    """Write residual.nc: HDF5 with dimension scales, which is NetCDF-4."""
    with hdf5_to_write(path, track_order=True) as file:
        for name, values, dimension, unit, long_name in _variables(evaluation):
            variable(file, name, values, (dimension,), unit, long_name)
        file.attrs.update(
            program=PROGRAM, program_version=VERSION, run=evaluation.record.name, law=evaluation.law.name,
            order=evaluation.order, frequency_resolution_Hz=evaluation.x.spectrum.resolution, window="hann",
            scene=evaluation.record.scene.to_toml(),
        )  # fmt: skip


def _variables(e: Evaluation) -> Iterator[tuple[str, np.ndarray, str, str, str]]:
    """Variables of residual.nc: name, values, dimension, unit, meaning; dimensions before what they are of."""
    psd, density = "one-sided PSD of", "N2 Hz-1"
    yield "time", e.record.time, "time", "s", "time"
    yield "frequency", e.x.spectrum.frequency, "frequency", "Hz", "frequency"
    if e.x.orders is not None:
        turns = f"cycles per turn of the {e.x.orders.tracking.ring}"
        yield "shaft_order", e.x.orders.path.frequency, "shaft_order", "1", turns
    yield "loaded_rollers", e.loaded_count.astype(np.int32), "time", "1", "rollers in the load zone"
    for d, equation in zip(e.directions, ("equation (22)", "equation (23), load moved over"), strict=True):
        error, body = f"error_{d.name}", d.vibration.body
        yield error, d.budget.error, "time", "N", f"left side of {equation}"
        yield f"psd_{d.name}", d.spectrum.psd, "frequency", density, f"{psd} {error}"
        for name, term in d.budget.terms.items():
            of = f"the {term_label(name)} term of {error}"
            yield f"budget_{d.name}_{name}", term, "time", "N", of[4:]
            yield f"psd_{d.name}_{name}", d.term_spectra[name].psd, "frequency", density, f"{psd} {of}"
        if d.budget.momentum is not None:
            of = f"{error} with the run's own contact forces"
            yield f"momentum_{d.name}", d.budget.momentum, "time", "N", of
        for found, name, of, unit in (
            (d.envelope, "", error, density),
            (d.vibration.envelope, f"{body}_", f"the {body}'s acceleration in {d.name}", "m2 s-4 Hz-1"),
        ):
            if found is not None:
                of = f"{psd} the envelope of {of}, {found.low:.4g} to {found.high:.4g} Hz"
                yield f"{name}envelope_psd_{d.name}", found.spectrum.psd, "frequency", unit, of
        if d.orders is not None:
            of = "one-sided PSD over orders of"
            yield f"hub_order_psd_{d.name}", d.orders.path.psd, "shaft_order", "m2", f"{of} the hub's place in {d.name}"
            yield f"order_psd_{d.name}", d.orders.error.psd, "shaft_order", "N2", f"{of} {error}"


def _write_signals(evaluation: Evaluation, path: Path) -> None:
    """Time series, SI, by the names of the result file and of residual.nc; `name_<j>` for those of roller j."""
    t, e = evaluation.record, evaluation
    names = ["time", "inner_x", "inner_y", "inner_ax", "inner_ay", "error_x", "error_y"]
    columns = [t.time, t.inner_x, t.inner_y, *e.hub_acceleration, e.budget.x.error, e.budget.y.error]
    for name, values in (("roller_x", t.roller_x), ("roller_y", t.roller_y), ("inner_force", e.force)):
        names += [f"{name}_{j}" for j in range(values.shape[1])]
        columns += list(values.T)
    np.savetxt(path, np.column_stack(columns), "%.12g", ",", header=",".join(names), comments="", encoding="utf-8")
