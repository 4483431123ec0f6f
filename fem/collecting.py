"""When a command has Python look for garbage: not while it imports, nor at its end."""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

from fem.stopping import hold_signals


@contextmanager
def importing() -> Iterator[None]:
    """Look for no garbage until all is `imported`: imports make much that stays, and hardly any garbage."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def imported() -> None:
    """Look for garbage from now on, but not in what there is: a first search of that takes 0.1 s."""
    gc.freeze()
    gc.enable()


def leave(code: int) -> NoReturn:
    """End the process without searching all that libraries have made once more."""
    hold_signals()
    gc.freeze()
    sys.exit(code)
