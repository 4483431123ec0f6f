"""Run time and error of each model for a scene: --dry-run shows them beside the plan."""

from dataclasses import dataclass

import numpy as np

from fem.errors import UsageError
from fem.solver.simulate import SOLVERS, make_plan
from fem.solver.solver import Plan
from fem.statics.contact_balance import NotFound
from fem.statics.exact_statics import LEAST_LOAD, exact_statics
from lagrange.scene.scene import Scene, SceneError


@dataclass(frozen=True, kw_only=True)
class Choice:
    """A model for a scene."""

    model: str  # the scene's name of it
    lacks: str  # what it leaves out, or why it can't take the scene
    seconds: float | None = None  # to expect of the time loop; None: it can't take the scene
    hub_error: float | None = None  # of the hub's static displacement, relative; None: no load, or no exact answer


def model_choices(plan: Plan) -> list[Choice]:
    """Every model for the scene of a plan; finite elements on the scene's mesh."""
    exact = _exact_hub(plan.scene)
    return [_choice(plan, name, exact) for name in SOLVERS]


def suggestion(choices: list[Choice]) -> str | None:
    """What to begin with; None where there is no choice."""
    able = {each.model: each for each in choices if each.seconds is not None}
    if len(able) < 2:
        return None
    if "reduced" not in able:
        return 'model = "fem" for elastic bodies, "lagrange" for a quick look' if "fem" in able else None
    later = ' where elastic waves matter, of which it warns, take "fem"' if "fem" in able else " it warns of shocks"
    return f'begin with model = "reduced";{later}'


def _choice(plan: Plan, name: str, exact: np.ndarray | None) -> Choice:
    try:
        mine = plan if plan.scene.model == name else make_plan(_with_model(plan.scene, name))
        error = None if exact is None else float(np.linalg.norm(mine.static_hub() - exact) / np.linalg.norm(exact))
    except (SceneError, UsageError, RuntimeError) as refused:
        return Choice(model=name, lacks=f"not for this scene: {refused}")
    return Choice(model=name, lacks=mine.lacks, seconds=mine.expected_seconds, hub_error=error)


def _with_model(scene: Scene, name: str) -> Scene:
    return scene.varied({"model": name})


def _exact_hub(scene: Scene) -> np.ndarray | None:
    """Hub of exact elastic bodies under the load alone, (2,), m."""
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    if scene.bearing.type == "ball" or operation.radial_load < LEAST_LOAD:
        return None
    try:
        return exact_statics(bearing, operation.radial_load, operation.first_roller_angle).hub
    except NotFound:
        return None
