"""How a command begins and ends: arguments, signals, garbage, errors as sentences, exit codes."""

import gc
import os
import re
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import NoReturn

from cyclopts import App, CycloptsError, Parameter

from lagrange.errors import RunFailed, UsageError
from lagrange.messages import close_output, say, telling
from lagrange.version import VERSION

BROKEN_PIPE = 1  # the code with which rich leaves where nobody reads its output any more
NO_MEMORY = "failed to map segment"  # the loader's words
HELD = {signal.SIGINT, signal.SIGTERM}  # end a command in good order
MOST_YOUNG = 200_000  # objects between two searches for garbage: imports make much that stays, and hardly any garbage


class Terminated(KeyboardInterrupt):
    """SIGTERM outside of a run: undoes what Ctrl-C undoes."""


def _terminate(number, frame):
    signal.signal(number, signal.SIG_DFL)  # a second one ends the process at once
    raise Terminated


def hold_signals(hold: bool = True) -> None:
    """Let both wait, or take those that have waited: a command that is being loaded, or ends, can't answer them."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK if hold else signal.SIG_UNBLOCK, HELD)


def leave(code: int) -> NoReturn:
    """End the process without searching all that libraries have made once more, which takes 0.25 s."""
    hold_signals()
    gc.freeze()
    sys.exit(code)


def entry(main: Callable[[], int] | str) -> Callable[[], None]:
    """The entry point of a command, of which `main`, or "module:function", gives the exit code."""

    def command():
        gc.set_threshold(MOST_YOUNG)
        signal.signal(signal.SIGTERM, _terminate)
        leave(main() if callable(main) else getattr(import_module(main.partition(":")[0]), main.partition(":")[2])())

    return command


def new_app(name: str, text: str) -> App:
    app = App(
        name=name, version=VERSION, suppress_keyboard_interrupt=False, result_action="return_value",
        help_format="plaintext", default_parameter=Parameter(negative=""),
        help=re.sub(r"(?<!\n)\n(?![\n ])", " ", text),  # a paragraph is a line, which the terminal breaks
    )  # fmt: skip

    @app.command(name="--install-completion", help="install completion of options for this shell: bash, zsh or fish")
    def _install_completion():
        from cyclopts.completion.detect import ShellDetectionError

        try:
            print(f"written: {app.install_completion()}; it works in new shells")
        except ShellDetectionError:
            raise UsageError("--install-completion: the shell is none of bash, zsh and fish") from None

    return app


def run_app_main(app: App, arguments: list[str] | None = None, before: Callable[[], None] = lambda: None) -> int:
    """Exit code of a command. A user's mistake gives a few lines on stderr, never a traceback.

    `before` : looks whether the program can be used here, UsageError
    """
    for name in ("stdout", "stderr"):  # closed ones' numbers would go to the next file opened, and complaints into that
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif hasattr(stream := getattr(sys, name), "reconfigure"):
            stream.reconfigure(errors="replace")  # of a code page that lacks the minus sign
    try:
        hold_signals(False)
        before()
        result = app(arguments, exit_on_error=False, print_error=False)
        sys.stdout.flush()
        return result if isinstance(result, int) else 0
    except KeyboardInterrupt as error:
        return interrupted(error)
    except (BrokenPipeError, SystemExit) as error:  # whoever reads what is only printed has had enough
        if isinstance(error, SystemExit) and error.code != BROKEN_PIPE:
            raise
        close_output()
        return 0
    except OSError as error:
        code, reason = 2, f"{error.filename or 'output'}: {error.strerror or error}"
    except CycloptsError as error:
        code, reason = 2, str(error)
    except UsageError as error:
        code, reason = error.code, str(error)
    except RunFailed as error:
        code, reason = error.code, f"{error}\nnothing was written"
    except ImportError as error:
        if NO_MEMORY not in str(error):
            raise
        code, reason = 2, "not enough memory to load the program"
    except MemoryError:
        code, reason = 2, "not enough memory; use a shorter run, a coarser numerics.mesh_size_mm or fewer axial.slices"
    say(f"error: {reason}")
    with telling():
        pass
    return code


def interrupted(error: KeyboardInterrupt) -> int:
    """Say that a command has been ended; its code."""
    hold_signals()  # a second one, of a terminal or the parent process, means the same
    with suppress(OSError):
        print("interrupted", file=sys.stderr, flush=True)
    return 143 if isinstance(error, Terminated) else 130
