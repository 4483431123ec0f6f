"""The installed commands. A signal waits until the command that is being loaded can end in good order."""

from fem.stopping import hold_signals

hold_signals()  # before all else; `fem.cli` hears those that have come


def run_fem() -> None:
    """`run-fem`."""
    from fem.cli import run_fem

    run_fem()


def render_fem() -> None:
    """`render-fem`."""
    from fem.render_cli import render_fem

    render_fem()


def run_live() -> None:
    """`run-live`."""
    from fem.live_cli import run_live

    run_live()


def run_study() -> None:
    """`run-study`."""
    from fem.study_cli import run_study

    run_study()
