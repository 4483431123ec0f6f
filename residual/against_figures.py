"""Figure of two checks laid over each other."""

from pathlib import Path

import numpy as np

from residual.against import named
from residual.colours import BLUE, RED
from residual.evaluation import Evaluation
from residual.exports import accelerations
from residual.figures import SavedFigure
from residual.panels import panels
from residual.plotting import legend_above, log_panel, save
from residual.quasistatic import angle_from_load
from residual.spectrum import power_spectrum

MOST_POINTS = 6000  # of loads over the angle


def against_figures(evaluation: Evaluation, other: Evaluation, folder: Path) -> list[SavedFigure]:
    """Draw the hub's motion or, for two laws of one run, the errors; loads by angle; spectra."""
    laws = evaluation.record.source == other.record.source
    figure, axes = panels((2, 1, 2), 12.0, shares=(1.0, 1.0, 1.3, 1.0, 1.0))
    for each, name, colour, width in zip(
        (evaluation, other), named(evaluation, other), (BLUE, RED), (1.4, 0.8), strict=True
    ):
        t, style = each.record, {"color": colour, "linewidth": width, "label": name}
        for axis, d, place in zip(axes[:2], each.directions, (t.inner_x, t.inner_y), strict=True):
            axis.plot(1e3 * t.time, d.budget.error if laws else 1e6 * place, **style)
        _draw_loads(axes[2], each, style, laws)
        spectra = (
            [d.spectrum for d in each.directions]
            if laws
            else [power_spectrum(a, t.interval, min(each.lines.values(), default=0.0)) for a in accelerations(each)]
        )
        for axis, spectrum in zip(axes[3:], spectra, strict=True):
            log_panel(axis, spectrum.frequency[1:])
            axis.plot(spectrum.frequency[1:], np.maximum(spectrum.psd[1:], 1e-300), **style)
    of = ("error_x, N", "error_y, N") if laws else ("hub x, µm", "hub y, µm")
    for axis, label in zip((*axes[:2], *axes[3:]), (*of, *_spectra_of(laws)), strict=True):
        axis.set_ylabel(label)
        axis.margins(x=0.0)
    axes[1].set_xlabel("time, ms")
    axes[2].set(xlabel="roller's angle from the load line, degrees", ylabel="inner contact force, N")
    axes[2].set(xlim=(-180.0, 180.0), xticks=np.arange(-180, 181, 45), ylim=(0.0, None))
    axes[4].set_xlabel("frequency, Hz")
    legend_above(axes[0], 2)
    what = "error forces" if laws else "motion of the hub"
    caption = (
        f"The {what} over time, forces of the inner contacts over the rollers' angle, and power spectral densities of "
        f"the {'error forces' if laws else 'acceleration of the hub'}, laid over each other."
    )
    return [save(figure, folder, "against", "Laid over each other", caption)]


def _spectra_of(laws: bool) -> tuple[str, str]:
    return ("PSD of error_x, N²/Hz", "PSD of error_y, N²/Hz") if laws else ("PSD, x, m²/s⁴/Hz", "PSD, y, m²/s⁴/Hz")


def _draw_loads(axis, each: Evaluation, style: dict, laws: bool) -> None:
    """Draw forces over the angle from the load line: of two laws theirs, of two runs their own."""
    force = each.budget.law_force if laws else each.force
    stride = max(1, force.size // MOST_POINTS)
    angle = np.degrees(angle_from_load(np.arctan2(each.record.roller_y, each.record.roller_x)))[::stride]
    axis.plot(angle.ravel(), force[::stride].ravel(), color=style["color"], linestyle="none", marker=".",
              markersize=2.5, rasterized=True, label=style["label"])  # fmt: skip
