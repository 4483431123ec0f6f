"""Loading a compiled time loop, and what to tell while it is being compiled."""

import gc
from collections.abc import Callable

from lagrange.messages import said_if_long

PATIENCE = 3.0  # s, to load the time loop; if it takes longer it is being compiled
COMPILING = "compiling the time loop, once for such bodies and contacts: half a minute, or one on a slow processor"


def load_compiled(load: Callable[[], object], tell: Callable[[str], None] | None = None) -> None:
    """Call a kernel for nothing, so that it is compiled or loaded; `tell` gets a sentence if that takes long."""
    collecting = gc.isenabled()
    gc.disable()  # a compiler's many objects are nearly all kept: looking for cycles takes a tenth of its time
    try:
        with said_if_long(PATIENCE, COMPILING, tell):
            load()
    finally:
        if collecting:
            gc.enable()
