"""From a scene to a finished run, whichever solver it asks for: the registry, and the loop that advances a run."""

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

from lagrange.errors import RunFailed, UsageError

if TYPE_CHECKING:  # the command asks for the names of models long before anything heavy is needed
    from fem.solver.solver import Frame, Plan, Progress, RunState, Samples
    from lagrange.scene.scene import Scene

SOLVERS = {  # a scene's `model`: the module whose `make_plan` takes it
    "fem": "fem.solver.elements.plan",
    "reduced": "fem.solver.rigid.reduced",
    "lagrange": "fem.solver.rigid.lagrangian",
}
BLOCK_SECONDS = 0.2  # wall time between two looks at the samples
LARGEST_BLOCK = 4096  # samples, whatever the clock says


def make_plan(scene: "Scene") -> "Plan":
    """The plan of a scene, by the solver that its `model` names.

    UsageError: the solver can't take it, or a program it needs is missing, gmsh for instance.
    """
    from lagrange.scene.checks import check_motion

    check_motion(scene)
    try:
        return import_module(SOLVERS[scene.model]).make_plan(scene)
    except RunFailed:
        raise
    except RuntimeError as error:
        raise UsageError(str(error)) from None


def run(
    plan: "Plan", write: "Callable[[Samples], None]", report: "Callable[[Progress], None]" = lambda progress: None,
    stop: Callable[[], bool] = lambda: False, state: "RunState | None" = None,
    keep: "Callable[[Frame], None]" = lambda frame: None, restart: Callable[[str], None] = lambda reason: None,
) -> "Progress":  # fmt: skip
    """Advance a plan to its end, or until `stop` says so, handing samples to `write` as they come.

    report : is called after each block
    state : where to go on from, of a plan that is prepared; it is kept up to date after each block, before `report`
    stop : is asked after each block, and within samples that take long; those are then not taken
    keep : gets the fields the scene asks for, each before the sample of its instant
    restart : gets the reason why all that was written is void and the run restarts

    RunFailed: the run went wrong numerically; good samples were written.
    """
    if state is None:
        state = plan.prepare()
    state.stop = stop
    size = 1
    while state.done < plan.n_samples and not stop():
        before, block = state.wall, state.advance(min(size, plan.n_samples - state.done))
        if block.frame is not None:
            keep(block.frame)
        if block.samples is not None:
            write(block.samples)
        if block.trouble is not None:
            raise RunFailed(block.trouble)
        if block.restarts is not None:
            restart(block.restarts)
        report(state.progress)
        if block.samples is not None:
            size = size_of_block(size, len(block.samples), state.wall - before)
    return state.progress


def size_of_block(size: int, found: int, took: float) -> int:
    """Of the next block, after one of some size in which so many samples were found in so many seconds."""
    size = min(64 * size, LARGEST_BLOCK)
    if took > 0.0:  # clocks have stood still
        size = max(1, min(size, int(BLOCK_SECONDS / took * found)))
    return size
