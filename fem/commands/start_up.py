"""How a command begins and ends: arguments, signals, garbage, libraries and their processes, errors, exit codes."""

import gc
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from enum import Enum
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from fem.errors import RunFailed, UsageError

if TYPE_CHECKING:
    from cyclopts import App

SAFE = "PYTHONSAFEPATH"
BROKEN_PIPE = 1  # the code with which rich leaves where nobody reads its output any more
MOST_THREADS = 4096
SEPARATOR = "\0"  # of joined values: no argument of a process holds it
NO_MEMORY = "failed to map segment"  # the loader's words
NUMBA_SETTINGS = ".numba_config.yaml"  # which numba looks for in the current folder
KNOWN = ("NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_DISABLE_JIT", "NUMBA_BOUNDSCHECK")  # ours, or looked at here
HELD = {signal.SIGINT, signal.SIGTERM}  # end a command in good order


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


def need(package: str, user: str) -> None:
    """Refuse what needs a package that is not there, before any work for it is done.

    Errors
    ------
    UsageError: names the user, the package and the command that installs it.
    """
    if find_spec(package) is None:
        raise UsageError(f"{user}: needs {package}, which is not installed: python -m pip install {package}")


class Terminated(KeyboardInterrupt):
    """SIGTERM outside of a run: undoes what Ctrl-C undoes."""


def hear_termination() -> None:
    """Turn SIGTERM into Terminated from now on; a second one ends the process at once."""

    def handle(number, frame):
        signal.signal(number, signal.SIG_DFL)
        raise Terminated

    signal.signal(signal.SIGTERM, handle)


def hold_signals(hold: bool = True) -> None:
    """Let both wait from now on: a command that is being loaded, or ends, can't answer them in good order."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK if hold else signal.SIG_UNBLOCK, HELD)


def hear_signals() -> None:
    """Take those that have waited, and those to come."""
    hold_signals(False)


@contextmanager
def stop_signals() -> Iterator[list[int]]:
    """Ctrl-C and SIGTERM, listed as they come; a second one ends the process at once."""
    stopped: list[int] = []

    def handle(number, frame):
        stopped.append(number)
        signal.signal(number, signal.SIG_DFL)

    before = {number: signal.signal(number, handle) for number in HELD}
    try:
        yield stopped
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


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


def entry(main: Callable[[], int]) -> Callable[[], None]:
    """The entry point of a command, of which `main` gives the exit code."""

    def command() -> None:
        hear_termination()
        leave(main())

    return command


class Outcome(Enum):
    """How a command ends: exit code, message, and for runs the `status` in the result file."""

    COMPLETE = 0, "", "complete"
    FAILED = 1, "error: failed: {reason}\nsamples up to then are in {path}", "failed: {reason}"
    FAILED_AT_START = 1, "error: {reason}\nnothing was written", None
    UNUSABLE = 2, "error: {reason}", None
    ENDED = 130, "interrupted", None  # where there is no run
    ENDED_BY_TERM = 143, "interrupted", None
    INTERRUPTED = 130, "interrupted at {time:.3f} ms; {left}", "interrupted"
    TERMINATED = 143, "interrupted at {time:.3f} ms; {left}", "interrupted"
    # of a complete run whose error was to be estimated
    ESTIMATE_FAILED = (
        1, "error: the run on the coarser mesh failed: {reason}\n{path} is complete, without an estimate", None,
    )  # fmt: skip
    ESTIMATE_INTERRUPTED = 130, "interrupted; {path} is complete, without an estimate", None
    ESTIMATE_TERMINATED = 143, "interrupted; {path} is complete, without an estimate", None

    def __init__(self, code: int, text: str, status: str | None):
        self.code, self._text, self._status = code, text, status

    def sentence(self, **facts: object) -> str:
        """What to tell the user."""
        return self._text.format(**facts)

    def status(self, reason: object = "") -> str:
        """What the result file says of it."""
        return self._status.format(reason=reason)


def _version() -> str:
    from lagrange.version import VERSION

    return VERSION


def new_app(name: str, text: str) -> "App":
    """A command of this package."""
    from cyclopts import App

    app = App(
        name=name,
        version=_version,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
        help_format="plaintext",
        help=re.sub(r"(?<!\n)\n(?![\n ])", " ", text),  # a paragraph is a line, which the terminal breaks
    )

    @app.command(name="--install-completion", help="install completion of options for this shell: bash, zsh or fish")
    def _install_completion() -> None:
        from cyclopts.completion.detect import ShellDetectionError

        try:
            print(f"written: {app.install_completion()}; it works in new shells")
        except ShellDetectionError:
            raise UsageError("--install-completion: the shell is none of bash, zsh and fish") from None

    return app


def open_streams() -> None:
    """Make both streams ready for any text."""
    for name in ("stdout", "stderr"):  # closed ones' numbers would go to the next file opened, and complaints into that
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif hasattr(stream := getattr(sys, name), "reconfigure"):
            stream.reconfigure(errors="replace")  # of a code page that lacks the minus sign


def run_app_main(app: "App", arguments: list[str] | None = None) -> int:
    """Exit code of a command. A user's mistake gives a few lines on stderr, never a traceback."""
    from cyclopts import CycloptsError

    open_streams()
    try:
        hear_signals()
        _check_environment()
        result = app(_joined(sys.argv[1:] if arguments is None else arguments), exit_on_error=False, print_error=False)
        sys.stdout.flush()
        return result if isinstance(result, int) else Outcome.COMPLETE.code
    except KeyboardInterrupt as error:
        return interrupted(error)
    except CycloptsError as error:
        ended, reason = Outcome.UNUSABLE, error
    except (BrokenPipeError, SystemExit) as error:  # whoever reads what is only printed has had enough
        if isinstance(error, SystemExit) and error.code != BROKEN_PIPE:
            raise
        from lagrange.messages import close_output

        close_output()
        return Outcome.COMPLETE.code
    except OSError as error:
        ended, reason = Outcome.UNUSABLE, f"{error.filename or 'output'}: {error.strerror or error}"
    except RunFailed as error:
        ended, reason = Outcome.FAILED_AT_START, error
    except ImportError as error:
        if NO_MEMORY not in str(error):
            raise
        ended, reason = Outcome.UNUSABLE, "not enough memory to load the program"
    except MemoryError:
        ended = Outcome.UNUSABLE
        reason = "not enough memory; use a coarser numerics.mesh_size_mm or fewer axial.slices"
    except ValueError as error:
        from lagrange.files.hdf5 import Damaged
        from lagrange.rating.sources import Unavailable
        from lagrange.scene.scene import SceneError  # loaded by now, or soon, by whatever reads scenes or results

        if not isinstance(error, UsageError | SceneError | Damaged | Unavailable):
            raise
        ended, reason = Outcome.UNUSABLE, error
    from lagrange.messages import say, telling  # with it come libraries that --help does without

    say(ended.sentence(reason=reason))
    with telling():
        pass
    return ended.code


def interrupted(error: KeyboardInterrupt) -> int:
    """Say that a command has been ended, importing nothing, as a library of which half is loaded can't be; its code."""
    hold_signals()  # a second one, of a terminal or the parent process, means the same
    ended = Outcome.ENDED_BY_TERM if isinstance(error, Terminated) else Outcome.ENDED
    with suppress(OSError):
        print(ended.sentence(), file=sys.stderr, flush=True)
    return ended.code


def _check_environment() -> None:
    """Refuse settings of libraries with which they can't even be loaded."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        raise UsageError("NUMBA_DISABLE_JIT is set, and the time loops can't run without being compiled; unset it")
    _check_numba()
    threads = os.environ.get("NUMBA_NUM_THREADS")
    if threads is not None and not (threads.isascii() and threads.isdigit() and 1 <= int(threads[:9]) <= MOST_THREADS):
        raise UsageError(f"NUMBA_NUM_THREADS = {threads}: must be a whole number from 1 to {MOST_THREADS}; or unset it")


def _check_numba() -> None:
    """Refuse values that numba can't read, and have it read none from a file in the current folder."""
    if Path(NUMBA_SETTINGS).exists() or any(name.startswith("NUMBA_") and name not in KNOWN for name in os.environ):
        import contextlib
        import warnings

        try:
            with warnings.catch_warnings(), contextlib.chdir(Path(__file__).parent):
                warnings.filterwarnings("error", message="Environment variable")
                from numba.core import config  # noqa: F401
        except Warning as warning:
            found = re.search(r"'(NUMBA_\w+)'", str(warning))
            name = found[1] if found else "NUMBA_…"
            raise UsageError(f"{name} = {os.environ.get(name)}: numba can't read that value; unset it") from None


def _joined(arguments: list[str]) -> list[str]:
    """The command line with all values of --set in one, as the parser's time grows by the square of their number."""
    values, others, rest = [], [], iter(arguments)
    for word in rest:
        if word == "--":
            others += [word, *rest]
        elif word == "--set" and (value := next(rest, None)) is not None:
            values.append(value)
        elif word.startswith("--set="):
            values.append(word.removeprefix("--set="))
        else:
            others.append(word)
    return ["--set", SEPARATOR.join(values), *others] if len(values) > 1 else list(arguments)


def standard_bearing(designation: str | None) -> tuple[str, ...]:
    """The setting that --bearing stands for."""
    return () if designation is None else (f'bearing={{designation="{designation}"}}',)


def settings_of(given: list[str] | None) -> list[str]:
    """The values of --set, each for itself."""
    return [setting for joined in given or () for setting in joined.split(SEPARATOR)]
