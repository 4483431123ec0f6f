"""What processes that libraries begin must not do: Python's own start looks for modules in the current folder first."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

SAFE = "PYTHONSAFEPATH"


@contextmanager
def from_no_current_folder() -> Iterator[None]:
    """Let Python processes that begin meanwhile import nothing from the current folder, whoever has put it there."""
    before = os.environ.get(SAFE)
    os.environ[SAFE] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[SAFE]
        else:
            os.environ[SAFE] = before
