"""The command `run-fem`. Imports little: everything heavy waits until a scene has been read."""

import json
import os
import re
import sys
import zlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, CycloptsError, Parameter

from fem.commands.start_up import Outcome, Terminated, entry, hear_signals, hold_signals, importing
from fem.errors import RunFailed, UsageError
from fem.solver.simulate import SOLVERS

RUNS = Path("runs")
EXAMPLES = ("paper", "NU206", "spindle", "faults", "table", "all")  # of fem.examples, which imports much for --help
BROKEN_PIPE = 1  # the code with which rich leaves where nobody reads its output any more
MOST_THREADS = 4096
SEPARATOR = "\0"  # of joined values: no argument of a process holds it
NO_MEMORY = "failed to map segment"  # the loader's words
NUMBA_SETTINGS = ".numba_config.yaml"  # which numba looks for in the current folder
KNOWN = ("NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_DISABLE_JIT", "NUMBA_BOUNDSCHECK")  # ours, or looked at here
LONGEST_NAME = 120  # characters of a result's name; file systems take 255 bytes with the ending


def _version() -> str:
    from lagrange.version import VERSION

    return VERSION


def new_app(name: str, text: str) -> App:
    """A command of this package."""
    app = App(
        name=name,
        version=_version,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
        help_format="plaintext",
        help=re.sub(r"(?<!\n)\n(?![\n ])", " ", text),  # a paragraph is a line, which the terminal breaks
    )

    @app.command(name="--install-completion", help="complete options in this shell from now on: bash, zsh or fish")
    def _install_completion() -> None:
        from cyclopts.completion.detect import ShellDetectionError

        try:
            print(f"written: {app.install_completion()}; it works in new shells")
        except ShellDetectionError:
            raise UsageError("--install-completion: the shell is none of bash, zsh and fish") from None

    return app


run_app = new_app(
    "run-fem",
    """Simulate a roller bearing by explicit elastic finite-element contact and write one result file.

Without a scene: the bearing of Rubio et al. (2007) at 4500 rpm under 2000 N, for 60 ms. With --model reduced: elastic
bodies without their mass, faster than the bearing turns. With --model lagrange: rigid bodies on contact springs, the
model that check-residual checks. All write files of the same form.

Contacts (--set contact.model=...): subgrid, the default; resolved, on meshes finer than the contact; for comparison,
as on coarse meshes elsewhere: penalty springs, and faceted, polygons instead of circles.

Example: run-fem my-bearing.toml --mesh-size 2 --duration 10 --set operation.speed_rpm=3000

Exit codes: 0 done; 1 the run failed numerically; 2 unusable input; 130 interrupted; 143 terminated.
""",
)


@run_app.default
def _run(
    scene: Annotated[Path | None, Parameter(help="scene file (TOML); default: the paper's bearing")] = None,
    /,
    *,
    output: Annotated[
        Path | None, Parameter(help="result file; default: runs/<scene name>.nc, with what --set changes in its name")
    ] = None,
    model: Annotated[Literal[tuple(SOLVERS)] | None, Parameter(help="what solves it; default: the scene's")] = None,
    mesh_size: Annotated[float | None, Parameter(help="surface node distance, mm")] = None,
    duration: Annotated[float | None, Parameter(help="simulated time, ms; 0: static equilibrium only")] = None,
    bearing: Annotated[str | None, Parameter(help="a standard bearing in place of the scene's, as NU206/C3")] = None,
    set: Annotated[list[str] | None, Parameter(help="any scene key: table.key=value; repeatable", negative="")] = None,
    dry_run: Annotated[bool, Parameter(negative="", help="check, show the plan and run nothing")] = False,
    converge: Annotated[
        bool, Parameter(negative="", help="show statics on three meshes with Richardson's value and run nothing")
    ] = False,
    resume: Annotated[bool, Parameter(negative="", help="go on from the output file's checkpoint")] = False,
    force: Annotated[bool, Parameter(negative="", help="replace a complete run of another scene")] = False,
    estimate_error: Annotated[
        bool,
        Parameter(negative="", help="also run a mesh half as fine and state the discretisation error of every result"),
    ] = False,
    checkpoint: Annotated[
        float | None, Parameter(help="seconds of wall time between checkpoints; default: 10, on slow disks more")
    ] = None,
    example: Annotated[
        Literal[EXAMPLES] | None,
        Parameter(help="write a commented scene, or all keys, here or to --output, and run nothing"),
    ] = None,
    schema: Annotated[bool, Parameter(negative="", help="print the scene's JSON schema, for editors")] = False,
    quiet: Annotated[bool, Parameter(negative="", help="no progress, no summary")] = False,
) -> int:
    if example is not None:
        return _write_example(example, output, force)
    from lagrange.scene.scene import Scene, read_scene

    if schema:
        print(json.dumps(Scene.model_json_schema(), indent=1, ensure_ascii=False))
        return Outcome.COMPLETE.code

    settings = settings_of(set)
    keys = {"model": model, "numerics.mesh_size_mm": mesh_size, "numerics.duration_ms": duration}
    standard = () if bearing is None else (f'bearing={{designation="{bearing}"}}',)
    given = (f"{key}={value}" for key, value in keys.items() if value is not None)
    chosen = read_scene(scene, (*standard, *settings, *given))
    path = output if output is not None else RUNS / f"{result_name(chosen.name, settings)}.nc"
    if path.is_dir():
        raise UsageError(f"--output {path}: is a folder; name a file in it")
    if checkpoint is not None and not checkpoint >= 0.0:
        raise UsageError(f"--checkpoint {checkpoint:g}: must be a number of seconds >= 0")
    if converge:
        return _show_meshes(chosen)
    from fem.result.earlier import refuse_another_run
    from fem.runner import RunOptions, run_scene, show_plan

    if dry_run:
        return show_plan(chosen).code
    if not (force or resume):
        refuse_another_run(path, chosen)
    options = RunOptions(resume=resume, quiet=quiet, estimate_error=estimate_error, checkpoint_seconds=checkpoint)
    return run_scene(chosen, path, options).code


def _show_meshes(scene) -> int:
    from fem.commands.summary import print_meshes
    from fem.solver.mesh_convergence import mesh_table
    from lagrange.messages import telling

    found = mesh_table(scene)
    with telling():
        print_meshes(scene.name, found)
    return Outcome.COMPLETE.code


def _write_example(name: str, path: Path | None, force: bool) -> int:
    from fem.examples import write_example
    from lagrange.messages import shown

    scene, *others = write_example(name, path, force)
    for file in (scene, *others):
        print(f"wrote {shown(file)}")
    checked = f"check-residual {shown(others[0])} --scene {shown(scene)}" if others else f"run-fem {shown(scene)}"
    print(f"next: {checked}")
    return Outcome.COMPLETE.code


def result_name(scene_name: str, settings: Sequence[str]) -> str:
    """A result's name without its ending: the scene's, and what `--set` has changed.

    The duration and the name itself are left out: --resume finds a run that it makes longer.
    """
    changes = []
    for setting in settings:
        key, _, value = setting.partition("=")
        parts = [part.strip() for part in key.split(".")]
        if parts[-1] in ("name", "duration_ms"):
            continue
        short = parts if any(part.isdecimal() for part in parts) else parts[-1:]
        changes.append(re.sub(r"[^A-Za-z0-9._+-]+", "_", f"-{'.'.join(short)}-{value.strip()}"))
    whole = scene_name + "".join(changes)
    return whole if len(whole) <= LONGEST_NAME else f"{whole[:LONGEST_NAME]}-{zlib.crc32(whole.encode()):08x}"


def open_streams() -> None:
    """Make both streams ready for any text."""
    for name in ("stdout", "stderr"):  # closed ones' numbers would go to the next file opened, and complaints into that
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif hasattr(stream := getattr(sys, name), "reconfigure"):
            stream.reconfigure(errors="replace")  # of a code page that lacks the minus sign


def run_app_main(app: App, arguments: list[str] | None = None) -> int:
    """Exit code of a command. A user's mistake gives a few lines on stderr, never a traceback."""
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
        ended, reason = Outcome.UNUSABLE, "not enough memory; a coarser numerics.mesh_size_mm takes less"
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


def settings_of(given: list[str] | None) -> list[str]:
    """The values of --set, each for itself."""
    return [setting for joined in given or () for setting in joined.split(SEPARATOR)]


def run_main(arguments: list[str] | None = None) -> int:
    """`run-fem`, its exit code."""
    with importing():
        return run_app_main(run_app, arguments)


run_fem = entry(run_main)

if __name__ == "__main__":
    run_fem()
