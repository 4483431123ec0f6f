"""A run from a scene to a result file: checkpoints as it goes, signals that end it, how it went."""

import signal
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

from fem.progress import progress_display
from fem.result.checkpoint import checkpoint_path, load_checkpoint, refuse_no_place, save_checkpoint
from fem.result.estimate_columns import read_columns, write_estimates
from fem.result.store import ResultFile, WriteFailed
from fem.solver.error_estimate import NEEDED, estimate_error
from fem.solver.simulate import Plan, RunFailed, RunState, first_state, progress_of, run
from fem.summary import print_estimates, print_run

OK, FAILED, INTERRUPTED, TERMINATED = 0, 1, 130, 143
CHECKPOINT_SECONDS = 10.0  # of wall time, unless told otherwise
CHECKPOINT_SHARE = 0.005  # of the wall time at most, unless told otherwise: a slow disk gets checkpoints less often
GO_ON = "the same command with --resume goes on"


class Checkpoints:
    """Saves the state of a run every so many seconds; None: every CHECKPOINT_SECONDS, less often on slow disks."""

    def __init__(self, path: Path, plan: Plan, state: RunState, store: ResultFile, every: float | None):
        self._path, self._plan, self._state, self._store, self._every = path, plan, state, store, every
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
            save_checkpoint(self._path, self._plan, self._state, self._store.stored)
            return True
        except OSError as error:
            _say(f"warning: {error.filename}: {error.strerror}; no checkpoint was saved, the run goes on")
            return False
        finally:
            self._saved = time.monotonic()
            self._cost = self._saved - began


def simulate(
    plan: Plan, setup_seconds: float, path: Path, *, resume: bool, quiet: bool, every: float | None = None
) -> int:
    """Run a plan into a result file, with a checkpoint each so many seconds (see `Checkpoints`); the exit code.

    Errors
    ------
    UsageError: there is nothing to resume, or not by this plan; the file is in use. OSError: it can't be written.
    """
    refuse_no_place(path)
    state, stored = load_checkpoint(path, plan) if resume else (first_state(plan), None)
    stopped: list[int] = []
    _on_signals(stopped.append)
    with ResultFile(path, plan, setup_seconds, stored) as store, _explained(path, store):
        if not resume:
            checkpoint_path(path).unlink(missing_ok=True)
        checkpoints = Checkpoints(path, plan, state, store, every)
        status, code = "complete", OK
        try:
            with progress_display(plan, quiet) as show:

                def watch(progress) -> None:
                    with suppress(OSError):  # a terminal that has gone is no reason to stop
                        show(progress)
                    checkpoints.save_if_due()

                seen = run(plan, store.append, watch, lambda: bool(stopped), state, store.keep)
            checkpoints.save()
            if stopped and state.done < plan.n_samples:
                status = "interrupted"
                code = TERMINATED if stopped[0] == signal.SIGTERM else INTERRUPTED
        except RunFailed as error:
            status, code, seen = f"failed: {error}", FAILED, progress_of(plan, state)
        store.finish(status, seen.steps, seen.wall)
    if code == FAILED:
        _say(f"error: {status}\nsamples up to then are in {path}")
    elif code != OK:
        _say(f"{status} at {1e3 * seen.simulated:.3f} ms; {_left(path, store)}")
    elif not quiet:
        print_run(plan, seen, path)
    return code


def estimate(plan: Plan, coarse: Plan, path: Path, *, quiet: bool) -> int:
    """Run the coarser plan beside a finished run and write what its result may be off by; the exit code."""
    stopped: list[int] = []
    _on_signals(stopped.append)
    try:
        with progress_display(coarse, quiet) as show:
            found = estimate_error(plan, coarse, read_columns(path, NEEDED), show, lambda: bool(stopped))
    except RunFailed as error:
        _say(f"error: the run on the coarser mesh failed: {error}\n{path} is complete, without an estimate")
        return FAILED
    if stopped:
        _say(f"interrupted; {path} is complete, without an estimate")
        return TERMINATED if stopped[0] == signal.SIGTERM else INTERRUPTED
    size = 1e-3 * coarse.scene.numerics.mesh_size_mm
    write_estimates(path, found, size)
    if not quiet:
        print_estimates(found, size)
    return OK


@contextmanager
def _explained(path: Path, store: ResultFile):
    """Tell what is left when the disk fails."""
    try:
        yield
    except WriteFailed as error:
        raise OSError(error.errno, f"{error.strerror}; {_left(path, store)}", error.filename) from None


def _left(path: Path, store: ResultFile) -> str:
    """What a run that ends early leaves."""
    how = GO_ON if checkpoint_path(path).is_file() else "it can't be resumed, no checkpoint could be saved"
    return f"{store.committed} samples are in {path}; {how}"


def _say(text: str) -> None:
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _on_signals(stop) -> None:
    """Ctrl-C and SIGTERM end the run after the block of samples in work; a second one ends it at once."""

    def handle(number, frame):
        stop(number)
        signal.signal(number, signal.SIG_DFL)

    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGTERM, handle)
