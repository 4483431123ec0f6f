"""The installed commands. A signal waits until the command that is being loaded can end in good order."""

import os
from collections.abc import Callable
from importlib import import_module

from fem.commands.start_up import hold_signals

# matrices are small: further threads of theirs would only wait, and waiting takes processor time too
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
hold_signals()  # before all else; `run_app_main` hears those that have come


def _command(name: str) -> Callable[[], None]:
    """The entry point of a module of this package that bears its name, loaded when it is called."""

    def command() -> None:
        getattr(import_module(f"fem.commands.{name}"), name)()

    return command


COMMANDS = "run_fem", "render_fem", "run_live", "run_study", "rate_bearing"
run_fem, render_fem, run_live, run_study, rate_bearing = map(_command, COMMANDS)
