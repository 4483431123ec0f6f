"""The command `run-fem`. Imports little: everything heavy waits until a scene has been read."""

import gc
import os
import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from fem.errors import UsageError

RUNS = Path("runs")
OK, UNUSABLE, INTERRUPTED = 0, 2, 130


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
    checkpoint: Annotated[
        float | None, Parameter(help="seconds of wall time between checkpoints; default: 10, on slow disks more")
    ] = None,
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
    if checkpoint is not None and not checkpoint >= 0.0:
        raise UsageError(f"--checkpoint {checkpoint:g}: must be a number of seconds >= 0")
    if chosen.model == "lagrange":
        if resume or estimate_error:
            told = "--resume: the Lagrangian model takes seconds and keeps no checkpoint; start it again"
            raise UsageError(told if resume else "--estimate-error: the Lagrangian model has no mesh; leave it out")
        return _lagrange(chosen, path, dry_run, quiet)
    if dry_run:
        return _dry_run(chosen)
    if not estimate_error:
        return _simulate(chosen, path, quiet, resume, checkpoint)
    from fem.solver.error_estimate import coarser_scene

    coarse, _ = _plan(coarser_scene(chosen), compiled=False)
    code = _simulate(chosen, path, quiet, resume, checkpoint)
    return code if code != OK else _estimate(chosen, coarse, path, quiet)


def _lagrange(scene, path: Path, dry_run: bool, quiet: bool) -> int:
    from fem.lagrange_run import make_plan, print_plan, run_command

    gc.enable()
    if dry_run:
        print_plan(make_plan(scene))
        return OK
    return run_command(scene, path, quiet)


def _plan(scene, compiled: bool, quiet: bool = False):
    """The plan and the seconds it took; failures here are the scene's, not the run's."""
    import time

    began = time.perf_counter()
    from fem.solver.simulate import make_plan

    try:
        plan = make_plan(scene)
    except RuntimeError as error:
        raise UsageError(str(error)) from None
    if compiled:
        from fem.kernels.jit import is_compiled
        from fem.solver.simulate import compile_kernels

        if not (quiet or is_compiled()):
            print("compiling the kernels, once, about half a minute", file=sys.stderr, flush=True)
        compile_kernels(plan)
    gc.enable()
    return plan, time.perf_counter() - began


def _dry_run(scene) -> int:
    from fem.summary import print_plan

    plan, _ = _plan(scene, compiled=False)
    print_plan(plan)
    return OK


def _simulate(scene, path: Path, quiet: bool, resume: bool, checkpoint: float | None) -> int:
    from fem.runner import simulate

    plan, setup_seconds = _plan(scene, compiled=True, quiet=quiet)
    for sentence in () if quiet else plan.cautions:
        print(f"warning: {sentence}", file=sys.stderr, flush=True)
    return simulate(plan, setup_seconds, path, resume=resume, quiet=quiet, every=checkpoint)


def _estimate(scene, coarse, path: Path, quiet: bool) -> int:
    from fem.runner import estimate

    plan, _ = _plan(scene, compiled=False)
    return estimate(plan, coarse, path, quiet=quiet)


def run_app_main(app: App, arguments: list[str] | None) -> int:
    """Exit code of a command. A user's mistake gives a few lines on stderr, never a traceback."""
    if sys.stderr is None:  # closed; its number would go to the next file opened, and complaints of libraries into that
        sys.stderr = open(os.devnull, "w")
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
    gc.disable()  # until all is imported: imports make much that stays and no garbage to speak of
    try:
        return run_app_main(run_app, arguments)
    finally:
        gc.enable()


def run_fem() -> None:
    """Entry point."""
    code = run_main()
    gc.freeze()  # the process ends: what libraries have made need not be searched for garbage once more
    sys.exit(code)


if __name__ == "__main__":
    run_fem()
