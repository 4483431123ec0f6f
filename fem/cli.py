"""The command `run-fem`. Imports little: everything heavy waits until a scene has been read."""

import signal
import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from fem.errors import UsageError

RUNS = Path("runs")
CHECKPOINT_SECONDS = 10.0  # of wall time
OK, FAILED, UNUSABLE, INTERRUPTED, TERMINATED = 0, 1, 2, 130, 143


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("roller-bearing-fem")
    except PackageNotFoundError:
        return "not installed"


def new_app(name: str, text: str) -> App:
    """A command of this package."""
    return App(
        name=name,
        version=_version,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
        help_format="plaintext",
        help=text,
    )


run_app = new_app(
    "run-fem",
    """Simulate a roller bearing by explicit elastic finite-element contact and write one result file.

Without a scene: the bearing of Rubio et al. (2007) at 4500 rpm under 2000 N, for 60 ms. With --model lagrange: rigid
bodies on contact springs, the model that check-residual checks, in a file of the same form.

Example: run-fem my-bearing.toml --mesh-size 2 --duration 10 --set operation.speed_rpm=3000

Exit codes: 0 done; 1 the run failed numerically; 2 unusable input; 130 interrupted; 143 terminated.
""",
)


@run_app.default
def _run(
    scene: Annotated[Path | None, Parameter(help="scene file (TOML); default: the paper's bearing")] = None,
    /,
    *,
    output: Annotated[Path | None, Parameter(help="result file; default: runs/<scene name>.nc")] = None,
    model: Annotated[
        Literal["fem", "lagrange"] | None, Parameter(help="finite elements or Lagrangian model; default: the scene's")
    ] = None,
    mesh_size: Annotated[float | None, Parameter(help="surface node distance, mm")] = None,
    duration: Annotated[float | None, Parameter(help="simulated time, ms; 0: static equilibrium only")] = None,
    set: Annotated[list[str] | None, Parameter(help="any scene key: table.key=value; repeatable", negative="")] = None,
    dry_run: Annotated[bool, Parameter(negative="", help="check, show the plan and run nothing")] = False,
    resume: Annotated[bool, Parameter(negative="", help="go on from the output file's checkpoint")] = False,
    estimate_error: Annotated[
        bool, Parameter(negative="", help="also run a mesh half as fine and state what the results may be off by")
    ] = False,
    quiet: Annotated[bool, Parameter(negative="", help="no progress, no summary")] = False,
) -> int:
    from lagrange.scene import read_scene

    overrides = list(set or [])
    if model is not None:
        overrides.append(f"model={model}")
    if mesh_size is not None:
        overrides.append(f"numerics.mesh_size_mm={mesh_size}")
    if duration is not None:
        overrides.append(f"numerics.duration_ms={duration}")
    chosen = read_scene(scene, tuple(overrides))
    path = output if output is not None else RUNS / f"{chosen.name}.nc"
    if path.is_dir():
        raise UsageError(f"--output {path}: is a folder; name a file in it")
    if chosen.model == "lagrange":
        if resume or estimate_error:
            told = "--resume: the Lagrangian model takes seconds and keeps no checkpoint; start it again"
            raise UsageError(told if resume else "--estimate-error: the Lagrangian model has no mesh; leave it out")
        return _lagrange(chosen, path, dry_run, quiet)
    if dry_run:
        return _dry_run(chosen)
    if not estimate_error:
        return _simulate(chosen, path, quiet, resume)
    from fem.error_estimate import coarser_scene

    coarse, _ = _plan(coarser_scene(chosen), compiled=False)
    code = _simulate(chosen, path, quiet, resume)
    return code if code != OK else _estimate(chosen, coarse, path, quiet)


def _lagrange(scene, path: Path, dry_run: bool, quiet: bool) -> int:
    from fem.lagrange_run import make_plan, print_plan, run_command

    if dry_run:
        print_plan(make_plan(scene))
        return OK
    return run_command(scene, path, quiet)


def _plan(scene, compiled: bool, quiet: bool = False):
    """The plan and the seconds it took; failures here are the scene's, not the run's."""
    import time

    began = time.perf_counter()
    from fem.simulate import make_plan

    try:
        plan = make_plan(scene)
    except RuntimeError as error:
        raise UsageError(str(error)) from None
    if compiled:
        from fem.jit import is_compiled
        from fem.simulate import compile_kernels

        if not (quiet or is_compiled()):
            print("compiling the kernels, once, about half a minute", file=sys.stderr, flush=True)
        compile_kernels(plan)
    return plan, time.perf_counter() - began


def _dry_run(scene) -> int:
    from fem.summary import print_plan

    plan, _ = _plan(scene, compiled=False)
    print_plan(plan)
    return OK


def _simulate(scene, path: Path, quiet: bool, resume: bool) -> int:
    import time

    from fem.checkpoint import load_checkpoint, save_checkpoint
    from fem.progress import progress_display
    from fem.simulate import RunFailed, first_state, run
    from fem.store import ResultFile
    from fem.summary import print_run

    plan, setup_seconds = _plan(scene, compiled=True, quiet=quiet)
    state = load_checkpoint(path, plan) if resume else first_state(plan)
    stopped: list[int] = []
    _on_signals(stopped.append)
    seen, status, code = None, "complete", OK
    saved = time.monotonic()

    def keep() -> None:
        nonlocal saved
        store.commit()
        save_checkpoint(path, plan, state)
        saved = time.monotonic()

    def watch(progress) -> None:
        nonlocal seen
        seen = progress
        show(progress)
        if time.monotonic() - saved > CHECKPOINT_SECONDS:
            keep()

    with ResultFile(path, plan, setup_seconds, state.done if resume else None) as store:
        try:
            with progress_display(plan, quiet) as show:
                seen = run(plan, store.append, watch, lambda: bool(stopped), state, store.keep)
            keep()
            if stopped and seen.samples < plan.n_samples:
                status = "interrupted"
                code = TERMINATED if stopped[0] == signal.SIGTERM else INTERRUPTED
        except RunFailed as error:
            status, code = f"failed: {error}", FAILED
        store.finish(status, seen.steps if seen else 0, seen.wall if seen else 0.0)
    if code == FAILED:
        print(f"error: {status}\nsamples up to then are in {path}", file=sys.stderr)
    elif code != OK:
        print(
            f"{status} at {1e3 * seen.simulated:.3f} ms; samples up to then are in {path}; "
            "the same command with --resume goes on",
            file=sys.stderr,
        )
    elif not quiet:
        print_run(plan, seen, path)
    return code


def _estimate(scene, coarse, path: Path, quiet: bool) -> int:
    from fem.error_estimate import NEEDED, estimate_error
    from fem.progress import progress_display
    from fem.simulate import RunFailed
    from fem.store import read_columns, write_estimates
    from fem.summary import print_estimates

    plan, _ = _plan(scene, compiled=False)
    stopped: list[int] = []
    _on_signals(stopped.append)
    try:
        with progress_display(coarse, quiet) as show:
            found = estimate_error(plan, coarse, read_columns(path, NEEDED), show, lambda: bool(stopped))
    except RunFailed as error:
        print(
            f"error: the run on the coarser mesh failed: {error}\n{path} is complete, without an estimate",
            file=sys.stderr,
        )
        return FAILED
    if stopped:
        print(f"interrupted; {path} is complete, without an estimate", file=sys.stderr)
        return TERMINATED if stopped[0] == signal.SIGTERM else INTERRUPTED
    size = 1e-3 * coarse.scene.numerics.mesh_size_mm
    write_estimates(path, found, size)
    if not quiet:
        print_estimates(found, size)
    return OK


def _on_signals(stop) -> None:
    """Ctrl-C and SIGTERM end the run after the block of samples in work; a second one ends it at once."""

    def handle(number, frame):
        stop(number)
        signal.signal(number, signal.SIG_DFL)

    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGTERM, handle)


def run_app_main(app: App, arguments: list[str] | None) -> int:
    """Exit code of a command. A user's mistake gives a few lines on stderr, never a traceback."""
    try:
        result = app(arguments)
        return result if isinstance(result, int) else OK
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        print(f"error: {error.filename or 'output'}: {error.strerror or error}", file=sys.stderr)
        return UNUSABLE
    except ValueError as error:
        if type(error).__name__ not in ("UsageError", "SceneError"):
            raise
        print(f"error: {error}", file=sys.stderr)
        return UNUSABLE


def run_main(arguments: list[str] | None = None) -> int:
    """`run-fem`, its exit code."""
    return run_app_main(run_app, arguments)


def run_fem() -> None:
    """Entry point."""
    sys.exit(run_main())


if __name__ == "__main__":
    run_fem()
