"""A run from its start to its end, kept in memory."""

from fem.solver.simulate import run
from fem.solver.solver import Plan, RunState, Samples


def whole_run(plan: Plan, state: RunState | None = None, said: list[str] | None = None) -> Samples:
    """All samples but those that a restart makes void.

    `state` : the run's, where it is looked at afterwards; `said` : a list that gets why it restarted
    """
    blocks: list[Samples] = []
    reasons = [] if said is None else said
    run(plan, blocks.append, state=state, restart=lambda reason: (reasons.append(reason), blocks.clear()))
    return Samples.joined(blocks)
