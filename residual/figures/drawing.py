"""All figures of a report, in the groups that its page shows them in. Importing this imports matplotlib."""

from dataclasses import replace
from pathlib import Path

import matplotlib

from residual.evaluation import Evaluation
from residual.figures.budget import budget_figures
from residual.figures.motion import against_figures, motion_figures
from residual.figures.passages import fault_figures, passage_figures
from residual.figures.saved import SavedFigure
from residual.figures.spectra import order_figures, spectrum_figures
from residual.figures.style import STYLE
from residual.figures.vibration import cage_figure, vibration_figures
from residual.load_zone import QuasiStatic
from residual.summary import ReportOptions


def draw_figures(
    evaluation: Evaluation, statics: QuasiStatic | None, options: ReportOptions, folder: Path
) -> dict[str, list[SavedFigure]]:
    """Draw all figures for which the run has data into a folder; by groups, in the page's order.

    Parameters
    ----------
    evaluation : Evaluation
    statics : QuasiStatic, the Lagrangian model's equilibria; None: there are none
    options : ReportOptions, of the report
    """
    with matplotlib.rc_context(STYLE):
        drawn = {
            "against": [] if options.other is None else against_figures(evaluation, options.other, folder),
            "motion": [
                *motion_figures(evaluation, options.equations, statics, folder),
                *filter(None, [cage_figure(evaluation, folder)]),
            ],
            "vibration": [
                *vibration_figures(evaluation, folder),
                *order_figures(evaluation, folder),
                *passage_figures(evaluation, folder),
            ],
            "search": [] if options.search is None else fault_figures(options.search, folder),
        }
        if options.equations:
            drawn |= {
                "spectra": spectrum_figures(evaluation, folder),
                "budget": budget_figures(evaluation, folder),
            }
    methods = {group: method_sentence(evaluation, options.other if group == "against" else None) for group in drawn}
    return {
        group: [replace(figure, caption=figure.caption + methods[group]) for figure in found]
        for group, found in drawn.items()
    }


def method_sentence(evaluation: Evaluation, other: Evaluation | None) -> str:
    """Model and damping of the run that figures show, and of what it is compared with; of a table from elsewhere ""."""
    runs = [each.record for each in (evaluation, other) if each is not None]
    methods = dict.fromkeys(f" Run {run.name}: {run.scene.method}." for run in runs if run.attributes)
    return "".join(methods)
