"""The command `run-study`. Imports little: everything heavy waits until a study has been read."""

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from fem.commands.start_up import Outcome, count_display, need, run_app_main, stop_signals
from lagrange.commands import new_app
from lagrange.errors import UsageError
from lagrange.messages import say, shown, telling

STUDIES = Path("studies")
MOST_WORKERS = 4096

study_app = new_app(
    "run-study",
    """Run a scene many times with other values and write one dataset and one page.

The study's file says what is varied, how and what is kept: docs/studies.md. Every point is validated before the first
is solved; each is kept in a file of its own, so that --resume goes on where a study was ended, by whatever.

Example: run-study clearance.toml --dry-run
         run-study clearance.toml --workers 4
         run-study clearance.toml --scheduler tcp://10.0.0.1:8786 --resume

Exit codes: 0 done; 1 some points failed, the dataset is there; 2 unusable input; 130 interrupted; 143 terminated.
""",
)


@study_app.default
def _study(
    study: Path | None = None, /, *, output: Path | None = None, dry_run: bool = False, resume: bool = False,
    workers: int | None = None, scheduler: str | None = None, keep_runs: bool = False, collect: Path | None = None,
    export: Annotated[str | None, Parameter(show=False)] = None, quiet: bool = False,
) -> int:  # fmt: skip
    """
    Args:
        study: study file (TOML)
        output: folder; default: studies/<study name>
        dry_run: check every point and show the cost, without running
        resume: resume the study in the folder; finished points are kept
        workers: number of processes (default: automatic; 1: no worker processes)
        scheduler: address of a dask scheduler: tcp://host:8786
        keep_runs: also keep the result file of every point
        collect: write dataset and page of this folder again, without solving
        quiet: show no progress and no summary
    """
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise UsageError(f"--workers {workers}: must be a whole number from 1 to {MOST_WORKERS}")
    if workers is not None and scheduler is not None:
        raise UsageError("--workers, --scheduler: a scheduler has its own workers; leave --workers out")
    if export is not None:
        raise UsageError(
            f"--export {export}: training sets are no longer exported; study.nc holds signals with their labels, of "
            "which four lines of xarray make one: docs/studies.md"
        )
    if scheduler is not None:
        need("distributed", "--scheduler")
    if (study is None) == (collect is None):
        raise UsageError("name a study file, or a study's folder with --collect")
    from fem.study.folder import Folder
    from fem.study.solving import StudyOptions, checked_points, expected
    from fem.study.study_file import design_of, read_study

    if collect is not None:
        if output is not None or dry_run or resume or scheduler is not None or workers is not None or keep_runs:
            raise UsageError("--collect solves nothing: only --quiet goes with it")
        folder = Folder(path=collect)
        return _collect(folder.points(), folder, quiet)
    read = read_study(Path(study or ""))
    design = design_of(read)
    with count_display("points checked", len(design.points), quiet) as count:
        points = checked_points(read, design, count)
    folder = Folder(path=output if output is not None else STUDIES / read.name)
    options = StudyOptions(workers=workers, scheduler=scheduler, resume=resume, keep_runs=keep_runs, quiet=quiet)
    if dry_run:
        from fem.study.page import plan_lines

        pending = folder.pending(points)
        _print(plan_lines(points, pending, expected(points, pending) if pending else None, options))
        return 0
    folder.refuse_foreign(points, resume)
    return _solve(points, folder, options)


def _solve(points, folder, options):
    from fem.study.solving import LOST, Cluster, Processes, Solver, Wanted, expected, scheduler_client, solve_all

    pending, lost = folder.pending(points), {}
    if pending:
        processes = options.processes(expected(points, pending, None if options.quiet else say).seconds * len(pending))
        wanted = Wanted(keep=points.study.keep, seconds=points.study.limits.seconds_per_point, runs=options.keep_runs)
        with (
            stop_signals() as stopped,
            scheduler_client(options.scheduler) if options.scheduler is not None else nullcontext() as client,
            folder.held(points, options.resume),
            count_display("points", len(pending), options.quiet) as count,
        ):

            def stop():
                return bool(stopped)

            def add(i, solved):
                folder.add(points.digests[i], solved)
                if solved.status == LOST:
                    lost[i] = solved
                count()

            solver = Processes(processes, wanted) if processes else Solver(wanted, stop)
            if client is not None:
                solver = Cluster(client, wanted)
            solve_all(solver, ((i, points.scene(i)) for i in pending), add, stop)
        for i, solved in lost.items():
            say(f"warning: {points.design.describe(i)}: {solved.text}; --resume tries it again")
        if stopped:
            left = len(folder.pending(points))
            done = len(pending) - left
            say(f"interrupted; {done} points are in {folder.path}; --resume goes on with the other {left}")
            return Outcome.by(stopped).code
    else:
        with folder.held(points, options.resume):  # the study's text may have changed
            pass
    code = _collect(points, folder, options.quiet)
    return 1 if lost else code


def _collect(points, folder, quiet):  # dataset and page of the points that are done
    from fem.study.folder import MISSING, write_dataset
    from fem.study.page import outcome_lines, write_page
    from fem.study.solving import COMPLETE

    with count_display("points collected", len(points), quiet) as count:
        dataset = write_dataset(points, folder, count)
    write_page(points, folder, dataset)
    is_complete, lines = bool((dataset.status == COMPLETE).all()), outcome_lines(points, dataset)
    if not quiet:
        _print([*lines, f"Dataset: {folder.dataset}", f"Page: {folder.page}"])
    elif not is_complete:
        for line in lines:
            say(line)
    if (dataset.status == MISSING).any() and (other := folder.other_program()):
        say(f"warning: {other}; points that this one can't read are missing; --resume solves all again")
    return 0 if is_complete else 1


def _print(lines):
    with telling():
        for line in lines:
            print(shown(line))


study_main = partial(run_app_main, study_app)
