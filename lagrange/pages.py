"""What pages of the commands share: how a template becomes one file, their look, and uPlot, which draws what can be
looked into.

Stands on the ground floor, as `messages` does: a report is the checker's, a live page the solver's.
"""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from markupsafe import Markup

STYLE = Path(__file__).parents[1] / "page.css"
VENDOR = STYLE.parent / "vendor"


def render_page(template: Path, **values: object) -> str:
    """The text of a page, with uPlot in it: it must open without a network."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(template.parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(
        page_style=as_it_is(STYLE),
        plot_style=as_it_is(VENDOR / "uPlot.min.css"),
        plot_library=as_it_is(VENDOR / "uPlot.iife.min.js"),
        **values,
    )


def as_it_is(path: Path) -> "Markup":
    """A style or script that goes into a page unescaped."""
    from markupsafe import Markup

    return Markup(path.read_text(encoding="utf-8"))
