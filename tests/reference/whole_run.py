"""A run from its start to its end, kept in memory."""

from fem.solver.simulate import run
from fem.solver.solver import Plan, RunState, Samples


def whole_run(plan: Plan, state: RunState | None = None) -> Samples:
    """All samples but those that a restart makes void; `state` : the run's, where it is looked at afterwards."""
    blocks: list[Samples] = []
    run(plan, blocks.append, state=state, restart=lambda reason: blocks.clear())
    return Samples.joined(blocks)
