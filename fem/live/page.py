"""The page: its parts put into one file, and the rules a browser shall keep it to."""

import secrets
from dataclasses import asdict, dataclass
from pathlib import Path

from fem.live.controls import sliders
from fem.live.messages import FASTEST, SLOWEST
from fem.live.record import measured
from fem.result.acceleration import channels
from lagrange.pages import as_it_is, render_page
from lagrange.scene import Scene

PARTS = Path(__file__).parent / "template"
SCRIPTS = ("drawing.js", "charts.js", "live.js")


@dataclass(frozen=True, kw_only=True)
class Page:
    """A page and its content security policy: own scripts and styles, and one connection."""

    text: str
    policy: str


def make_page(scene: Scene, connection: str) -> Page:
    """The page of a scene, which connects to an address (ws://host:port)."""
    mark = secrets.token_urlsafe(16)
    text = render_page(
        PARTS / "live.html.j2",
        name=scene.name,
        mark=mark,
        style=as_it_is(PARTS / "live.css"),
        scripts=[as_it_is(PARTS / name) for name in SCRIPTS],
        measured=[name.partition("_")[0].replace("inner", "hub") for name in measured(channels(scene))],
        sliders=[asdict(slider) for slider in sliders(scene)],
        fastest=FASTEST,
        slowest=SLOWEST,
    )
    rules = (
        "default-src 'none'",
        f"script-src 'nonce-{mark}'",
        f"style-src 'nonce-{mark}'",
        f"connect-src 'self' {connection}",
        "img-src data:",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
    return Page(text=text, policy="; ".join(rules))
