"""All figures of a report, in the groups that its page shows them in."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class SavedFigure:
    """A figure that has been written, with its title and caption."""

    name: str
    title: str
    caption: str
    png: Path
    svg: Path


def draw_figures(evaluation, statics, search, folder: Path) -> dict[str, list[SavedFigure]]:
    """Draw what the run has the data for into a folder; by groups, in the page's order.

    Parameters
    ----------
    evaluation : Evaluation
    statics : QuasiStatic, the Lagrangian model's equilibria; None: there are none
    search : FaultSearch, for spalls; None: none was made
    """
    import matplotlib.pyplot as plt

    from residual.budget_figures import budget_figures
    from residual.fault_figures import fault_figures
    from residual.motion_figures import motion_figures
    from residual.paper_figures import paper_figures
    from residual.passage_figures import passage_figures
    from residual.plotting import STYLE
    from residual.spectrum_figures import spectrum_figures
    from residual.vibration_figures import vibration_figures

    with plt.rc_context(STYLE):
        return {
            "motion": motion_figures(evaluation, statics, folder),
            "spectra": spectrum_figures(evaluation, folder),
            "vibration": [*vibration_figures(evaluation, folder), *passage_figures(evaluation, folder)],
            "search": [] if search is None else fault_figures(search, folder),
            "budget": budget_figures(evaluation, folder),
            "paper": paper_figures(evaluation, folder),
        }
