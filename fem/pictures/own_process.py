"""A command in a process of its own: where system libraries are missing, a renderer ends it instead of raising."""

import multiprocessing
import signal
from collections.abc import Callable

from fem.children import from_no_current_folder
from fem.errors import UsageError
from fem.pictures.rendering_probe import trouble
from fem.stopping import Terminated

ACCESS_VIOLATION = 0xC0000005  # what Windows makes of it
CRASHES = (-signal.SIGSEGV, -signal.SIGABRT, ACCESS_VIOLATION)


def run_apart(command: Callable[[], None]) -> int:
    """Run a function of a module, which ends by `sys.exit`, in a fresh interpreter; its exit code.

    A probe before would draw twice and import all that draws twice. Ctrl-C reaches both processes, SIGTERM is passed
    on; the code is then what the command makes of it.

    Errors
    ------
    UsageError: it crashed, with what cures that.
    """
    process = multiprocessing.get_context("spawn").Process(target=command, daemon=True)
    with from_no_current_folder():
        process.start()
    while process.exitcode is None:
        try:
            process.join()
        except Terminated:
            process.terminate()
        except KeyboardInterrupt:
            continue
    code = process.exitcode
    if code in CRASHES:
        raise UsageError(trouble("the renderer crashed: OpenGL libraries are missing"))
    return code if code >= 0 else 128 - code
