"""Pages and figures: libraries loaded undisturbed by settings around them, and what the commands' pages share.

Stands on the ground floor: pictures, reports and studies draw by the same library.
"""

import contextlib
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING


def load_matplotlib() -> None:
    """Load matplotlib with its own defaults, and to draw into memory. One that is loaded already stays as it is.

    It looks for `matplotlibrc` in the current folder first, then where MATPLOTLIBRC leads.
    """
    if "matplotlib" in sys.modules:
        return
    variables = {"MATPLOTLIBRC": os.devnull, "MPLBACKEND": "Agg"}
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        with contextlib.chdir(Path(__file__).parent):
            import_module("matplotlib")
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


if TYPE_CHECKING:
    from markupsafe import Markup

STYLE = Path(__file__).parents[1] / "page.css"
VENDOR = STYLE.parent / "vendor"


def render_page(template: Path, **values: object) -> str:
    """The text of a page, with uPlot in it: it must open without a network."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader([template.parent, STYLE.parent]),  # page.j2 has tables and pictures
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
