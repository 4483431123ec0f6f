"""The installed commands. A signal waits until the command that is being loaded can end in good order."""

from fem.commands.start_up import hold_signals

hold_signals()  # before all else; `fem.commands.run_fem` hears those that have come


def run_fem() -> None:
    """`run-fem`."""
    from fem.commands.run_fem import run_fem

    run_fem()


def render_fem() -> None:
    """`render-fem`."""
    from fem.commands.render_fem import render_fem

    render_fem()


def run_live() -> None:
    """`run-live`."""
    from fem.commands.run_live import run_live

    run_live()


def run_study() -> None:
    """`run-study`."""
    from fem.commands.run_study import run_study

    run_study()
