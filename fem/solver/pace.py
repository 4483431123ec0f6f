"""How long this machine takes over what plans expect, from its last runs: processors differ threefold.

One small file in the user's cache folder holds, for each processor and model, the last runs' times over what their
plans would have said without it. Times are the processor's: a machine that works for others too would say nothing of
itself.
"""

import json
from contextlib import suppress
from pathlib import Path
from statistics import median

from numba import config
from numba.core.event import Listener, install_listener

from fem.errors import RunFailed
from fem.solver.simulate import LARGEST_BLOCK
from fem.solver.solver import Plan
from lagrange.files.input import read_plain
from lagrange.files.output import write_whole

KEPT = 5  # runs of each model: their median forgives one that shared its caches
SHORTEST = 0.01  # s, of a time loop that tells of the machine
LARGEST = 100.0  # and its inverse: what lies beyond was no run of this program


def pace_file() -> Path:
    """Where it is kept."""
    import platformdirs

    return Path(platformdirs.user_cache_dir("roller-bearing-fem")) / "pace.json"


def pace(model: str) -> float:
    """By what a plan's own expectation is to be multiplied; 1 where no run of the model has been made here."""
    found = _read().get(_key(model), [])
    return median(found) if found else 1.0


def in_words(model: str, seconds: float) -> str:
    """A time to expect, and whether a run of the model has been timed here."""
    told = f"about {seconds:.2g} s"
    return told if _read().get(_key(model)) else f"{told}, or three times that: no run has been timed here yet"


def remember(model: str, expected: float, took: float) -> None:
    """Keep how long a run took of the processor; `expected` by its plan, times what is remembered so far, s."""
    if took < SHORTEST or not expected > 0.0:
        return
    ratio = took / expected * pace(model)
    if not 1.0 / LARGEST < ratio < LARGEST:
        return
    known, key, path = _read(), _key(model), pace_file()
    known[key] = [*known.get(key, []), ratio][-KEPT:]
    with suppress(OSError):  # a cache folder that can't be written is no reason to fail
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps(known).encode())


def _read() -> dict[str, list[float]]:
    """What is kept, as far as it is what `remember` writes."""
    try:
        known = json.loads(read_plain(pace_file()))
        return {
            str(key): [ratio for ratio in map(float, found) if 0.0 < ratio < LARGEST] for key, found in known.items()
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def _key(model: str) -> str:
    from fem.solver.compiling import processor

    return f"{model} on {processor()['processor']}, its own time"


# How long a run will take, from a short piece of it: what --dry-run tells where the time loop is compiled already.


ENOUGH = 0.1  # s of the processor
LONGEST_SAMPLE = 0.5  # s, of a sample that is tried


class _Needed(RunFailed):
    """A function would have to be compiled."""


class _Refusal(Listener):
    """Stops what begins to compile."""

    def on_start(self, event):
        raise _Needed("a function would have to be compiled")

    def on_end(self, event):
        pass


def is_compiled(plan: Plan) -> bool:
    """Whether the time loop need not be compiled; nothing is."""
    try:
        with install_listener("numba:compile", _Refusal()):
            plan.prepare()
    except _Needed:
        return False
    return True


def seconds_by_trial(plan: Plan) -> float | None:
    """Processor time of the whole time loop, s; None where it would have to be compiled first, or takes no steps.

    Errors
    ------
    The first steps stand for all: contacts that rattle, so that a run begins again with smaller steps, take longer.
    """
    if config.DISABLE_JIT or plan.n_samples < 2 or plan.expected_seconds > LONGEST_SAMPLE * (plan.n_samples - 1):
        return None
    try:
        with install_listener("numba:compile", _Refusal()):
            plan.prepare()
            state = plan.first_state()
            state.advance(1)
            size, warm, before = 1, state.done, state.processor
            while state.done < plan.n_samples and state.processor - before < ENOUGH:
                state.advance(min(size, plan.n_samples - state.done))
                size = min(2 * size, LARGEST_BLOCK)
    except RunFailed:
        return None
    taken = state.done - warm
    return (state.processor - before) / taken * (plan.n_samples - 1) if taken > 0 and state.processor > before else None
