"""How long a run will take, from a short piece of it: what --dry-run tells where the time loop is compiled already."""

from numba import config
from numba.core.event import Listener, install_listener

from fem.solver.simulate import LARGEST_BLOCK
from fem.solver.solver import Plan
from lagrange.errors import RunFailed

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
    The first steps stand for all: contacts that rattle, so that a run restarts with smaller steps, take longer.
    """
    if config.DISABLE_JIT or plan.n_samples < 2 or plan.expected_seconds > LONGEST_SAMPLE * (plan.n_samples - 1):
        return None
    try:
        with install_listener("numba:compile", _Refusal()):
            state = plan.prepare()
            state.advance(1)
            size, warm, before = 1, state.done, state.processor
            while state.done < plan.n_samples and state.processor - before < ENOUGH:
                state.advance(min(size, plan.n_samples - state.done))
                size = min(2 * size, LARGEST_BLOCK)
    except RunFailed:
        return None
    taken = state.done - warm
    return (state.processor - before) / taken * (plan.n_samples - 1) if taken > 0 and state.processor > before else None
