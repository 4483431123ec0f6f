"""A run from a scene to a result file, whichever solver it asks for: checkpoints, signals that end it, how it went."""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fem.commands.progress import progress_display
from fem.commands.start_up import Outcome, stop_signals
from fem.commands.summary import print_estimates, print_plan, print_run, size_warning
from fem.result.checkpoint import (
    checkpoint_path,
    load_checkpoint,
    refuse_no_place,
    refuse_nothing_to_resume,
    save_checkpoint,
)
from fem.result.later_columns import read_columns, write_estimates
from fem.result.store import ResultFile, Stored, WriteFailed, nothing_stored
from fem.run_summary import summary_columns
from fem.solver.compiling import remember
from fem.solver.simulate import make_plan, programs_named, run
from fem.solver.solver import Plan, Progress, RunState
from lagrange.errors import RunFailed, UsageError
from lagrange.files.output import remove_left
from lagrange.messages import said_if_long, say, telling
from lagrange.scene.scene import Scene

if TYPE_CHECKING:
    from fem.solver.errors import ErrorEstimate

CHECKPOINT_SECONDS = 10.0  # of wall time, unless given
CHECKPOINT_SHARE = 0.005  # of the wall time at most, unless given: a slow disk gets checkpoints less often
PATIENCE = 5.0  # s, of planning without a word
PLANNING = "planning: meshes, matrices, static equilibrium and critical step (a million nodes: one minute, 1.2 GB)"
GO_ON = "to continue: the same command with --resume"


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How a scene is to be run."""

    resume: bool = False
    quiet: bool = False
    estimate_error: bool = False
    checkpoint_seconds: float | None = None  # between checkpoints; None: CHECKPOINT_SECONDS, more on slow disks


def show_plan(scene: Scene, name: str) -> Outcome:
    """Plan a scene and print the plan of a run of that name. UsageError: a solver can't take the scene."""
    try:
        print_plan(_planned(scene, say), name)
    except RunFailed as error:
        return _ended(Outcome.FAILED_AT_START, reason=error)
    return Outcome.COMPLETE


def run_scene(scene: Scene, path: Path, options: RunOptions) -> Outcome:
    """Plan a scene, run it into a result file, and estimate its error where that is wished.

    Errors
    ------
    UsageError: a solver can't take the scene or estimate its error; there is no place for a checkpoint, or none to
    resume from; see also `simulate`.
    """
    began = time.perf_counter()
    refuse_no_place(path)
    if options.resume:
        refuse_nothing_to_resume(path)
    if options.estimate_error and scene.model == "fem":
        from fem.solver.errors import coarser_scene

        coarser_scene(scene)
    plan = _planned(scene, None if options.quiet else say)
    estimate = programs_named(plan.error_estimate) if options.estimate_error else None
    plan.prepare(None if options.quiet else say)
    large = size_warning(plan)
    further = () if options.quiet else (*plan.warnings, *(() if large is None else (large,)))
    for sentence in (*plan.notices, *further):
        say(f"warning: {sentence}")
    outcome = simulate(plan, time.perf_counter() - began, path, options)
    if estimate is None or outcome is not Outcome.COMPLETE:
        return outcome
    return _estimate(estimate, path, options.quiet)


def _planned(scene: Scene, tell: Callable[[str], None] | None) -> Plan:
    with said_if_long(PATIENCE, PLANNING, tell):
        return programs_named(lambda: make_plan(scene))


def simulate(plan: Plan, setup_seconds: float, path: Path, options: RunOptions) -> Outcome:
    """Run a plan into a result file, with a checkpoint each so many seconds (see `Checkpoints`).

    Errors
    ------
    UsageError: there is nothing to resume, or not by this plan; the file is in use. OSError: it can't be written.
    """
    try:
        state, stored = load_checkpoint(path, plan) if options.resume else (plan.first_state(), None)
    except RunFailed as error:
        return _ended(Outcome.FAILED_AT_START, reason=error)
    with (
        stop_signals() as stopped,
        ResultFile(path, plan, setup_seconds, stored, **state.outcome_attributes) as store,
        _explained(path, store),
    ):
        if not options.resume:
            checkpoint_path(path).unlink(missing_ok=True)
        remove_left(checkpoint_path(path))
        checkpoints = Checkpoints(path, state, store, options.checkpoint_seconds)
        outcome, reason = Outcome.COMPLETE, None

        def restart(reason: str) -> None:
            if not options.quiet:
                say(reason)
            checkpoints.restart()
            store.restart(**state.outcome_attributes)

        try:
            with progress_display(plan, options.quiet) as show:

                def watch(progress: Progress) -> None:
                    with suppress(OSError):  # a terminal that has gone is no reason to stop
                        show(progress)
                    checkpoints.save_if_due()

                run(plan, store.append, watch, lambda: bool(stopped), state, store.keep, restart)
            checkpoints.save()
            if stopped and state.done < plan.n_samples:
                outcome = Outcome.TERMINATED if stopped[0] == signal.SIGTERM else Outcome.INTERRUPTED
        except RunFailed as error:
            outcome, reason = Outcome.FAILED, error
        store.finish(outcome.status(reason), **state.outcome_attributes)
    for sentence in state.notices:
        say(f"warning: {sentence}")
    seen = state.progress
    if outcome is Outcome.COMPLETE and not options.resume:
        remember(plan.scene.model, plan.expected_seconds, state.processor)
    if outcome is Outcome.COMPLETE and not options.quiet:
        with telling():
            names = (*summary_columns(plan.scene), *plan.scene.mounting().places)
            print_run(state, read_columns(path, names), path)
    return _ended(outcome, reason=reason, path=path, time=1e3 * seen.simulated, left=_left(path, store, True))


class Checkpoints:
    """Saves the state of a run every so many seconds; None: every CHECKPOINT_SECONDS, less often on slow disks."""

    def __init__(self, path: Path, state: RunState, store: ResultFile, every: float | None):
        self._path, self._state, self._store, self._every = path, state, store, every
        self._saved, self._cost = time.monotonic(), 0.0

    def save_if_due(self) -> None:
        """Save when it is time."""
        often = max(CHECKPOINT_SECONDS, self._cost / CHECKPOINT_SHARE) if self._every is None else self._every
        if time.monotonic() - self._saved > often:
            self.save()

    def save(self) -> bool:
        """Whether the state is on the disk; if not, the last one that is stays and the run goes on."""
        began = time.monotonic()
        self._store.commit()
        try:
            return self._write(self._store.stored)
        finally:
            self._saved = time.monotonic()
            self._cost = self._saved - began

    def restart(self) -> None:
        """Save the state of a run that restarts, before its file does; what can't be gone on from is removed."""
        if not self._write(nothing_stored(self._state.plan)):
            checkpoint_path(self._path).unlink(missing_ok=True)

    def _write(self, stored: Stored) -> bool:
        try:
            save_checkpoint(self._path, self._state, stored)
            return True
        except OSError as error:
            say(f"warning: {error.filename}: {error.strerror}; no checkpoint was saved, the run goes on")
            return False


def _estimate(estimate: "ErrorEstimate", path: Path, quiet: bool) -> Outcome:
    """Run the coarser plan beside a finished run and write what its result may be off by."""
    from fem.solver.errors import NEEDED

    with stop_signals() as stopped:
        try:
            with progress_display(estimate.coarse, quiet) as show:
                found = estimate.find(read_columns(path, NEEDED), show, lambda: bool(stopped))
        except (RunFailed, UsageError) as error:  # UsageError: of a static equilibrium that is not found
            return _ended(Outcome.ESTIMATE_FAILED, reason=error, path=path)
    if stopped:
        terminated = stopped[0] == signal.SIGTERM
        return _ended(Outcome.ESTIMATE_TERMINATED if terminated else Outcome.ESTIMATE_INTERRUPTED, path=path)
    write_estimates(path, found, estimate.mesh_size)
    if not quiet:
        with telling():
            print_estimates(found, estimate.title)
    return Outcome.COMPLETE


@contextmanager
def _explained(path: Path, store: ResultFile) -> Iterator[None]:
    """Tell what is left when the disk fails."""
    try:
        yield
    except WriteFailed as error:
        raise OSError(
            error.errno, f"{error.strerror}; {_left(path, store, store.is_in_place)}", error.filename
        ) from None


def _left(path: Path, store: ResultFile, in_place: bool) -> str:
    """What a run that ends early leaves."""
    if not in_place:
        return f"{store.committed} samples were in {path}, which has been moved or removed; put it back and {GO_ON}"
    how = GO_ON if checkpoint_path(path).is_file() else "it can't be resumed, no checkpoint could be saved"
    return f"{store.committed} samples are in {path}; {how}"


def _ended(outcome: Outcome, **facts: object) -> Outcome:
    if text := outcome.sentence(**facts):
        say(text)
    return outcome
