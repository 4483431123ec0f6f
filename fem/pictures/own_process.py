"""A command in a process of its own: where system libraries are missing, a renderer ends it instead of raising."""

import multiprocessing
import os
import signal
from collections.abc import Callable
from multiprocessing import resource_tracker

from fem.children import from_no_current_folder
from fem.errors import UsageError
from fem.pictures.rendering_probe import trouble
from fem.stopping import Terminated, hear_signals, hold_signals

ACCESS_VIOLATION = 0xC0000005  # what Windows makes of it
CRASHES = (-signal.SIGSEGV, -signal.SIGABRT, ACCESS_VIOLATION)


def run_apart(command: Callable[[], None]) -> int:
    """Run a function of a module, which ends by `sys.exit`, in a fresh interpreter; its exit code.

    A probe before would draw twice and import all that draws twice. Ctrl-C and SIGTERM are passed
    on; the code is then what the command makes of it.

    Errors
    ------
    UsageError: it crashed, with what cures that.
    """
    process = multiprocessing.get_context("spawn").Process(target=command, daemon=True)
    if hasattr(signal, "pthread_sigmask"):
        resource_tracker.ensure_running()  # it would hear signals meanwhile
    hold_signals()  # the child begins so, and hears them in `run_app_main`
    with from_no_current_folder():
        process.start()
    while process.exitcode is None:
        try:
            hear_signals()
            process.join()
        except KeyboardInterrupt as error:
            os.kill(process.pid, signal.SIGTERM if isinstance(error, Terminated) else signal.SIGINT)
    code = process.exitcode
    if code in CRASHES:
        raise UsageError(trouble("the renderer crashed: OpenGL libraries are missing"))
    return code if code >= 0 else 128 - code
