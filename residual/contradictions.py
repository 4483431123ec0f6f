"""Whether a table is of the bearing, speed and load of its scene: what a wrong scene makes of it is no finding."""

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from lagrange.kinematics import kinematics
from lagrange.scene.operation import RPM
from residual.formatting import share, text
from residual.load_zone import quasi_static

if TYPE_CHECKING:
    from residual.evaluation import Evaluation

FASTER, SLOWER = 0.02, 0.1  # than rolling: rollers slip backwards, and hardly creep forward
ASTRAY = 0.05  # of the load: the contact forces of a table carry what acts in it
BY_LAW = 0.5  # the same of forces by a law, which takes each contact alone
LOADED = 0.01  # of the largest force: a roller with more is loaded
MORE_ROLLERS = 2.0  # than the equilibrium loads, or fewer: vibration


def contradictions(evaluation: "Evaluation") -> tuple[str, ...]:
    """Sentences on what a table from elsewhere has otherwise than its scene; none of a run, which brings its own."""
    if evaluation.record.attributes:
        return ()
    return tuple(filter(None, (_cage(evaluation), _load(evaluation), _loaded(evaluation))))


def _cage(evaluation: "Evaluation") -> str:
    """The cage's speed, and the shaft's that it means."""
    record = evaluation.record
    if record.reverses:
        return ""
    inner, outer = record.mean_speeds
    rolling, found = kinematics(record.bearing, inner, outer).cage, record.cage_speed
    if rolling == 0.0 or -SLOWER <= found / rolling - 1.0 <= FASTER:
        return ""
    turns, scene = (text(speed / (2.0 * pi)) for speed in (found, rolling))
    words = f"its rollers go around at {turns} Hz, where the scene says {scene} Hz without slip"
    per_turn = kinematics(record.bearing, 1.0, 0.0).cage
    if outer == 0.0:
        words += f" ({text(inner / RPM)} rpm; {turns} Hz would take {text(found / per_turn / RPM)} rpm)"
    if 0.0 < found / rolling < 1.0:
        words += "; rollers that slip would do so too"
    return words


def _load(evaluation: "Evaluation") -> str:
    """The load that the contact forces carry."""
    record, load = evaluation.record, evaluation.record.load
    parts = [d.budget.momentum for d in evaluation.directions]
    own = record.inner_force is not None and all(part is not None for part in parts)
    errors = np.array(parts if own else [d.budget.error for d in evaluation.directions])
    if load == 0.0 or evaluation.within_noise:
        return ""
    missing = -float(np.mean(np.sum(errors * np.array(record.whole_load), axis=0))) / load**2
    if abs(missing) <= (ASTRAY if own else BY_LAW):
        return ""
    whose = "its contact forces" if own else f"its approaches by the law {evaluation.law.name}"
    return (
        f"{whose} carry {text((1.0 - missing) * load)} N, {share(1.0 - missing, 1.0)} of the scene's load of "
        f"{text(load)} N"
    )


def _loaded(evaluation: "Evaluation") -> str:
    """How many rollers carry, beside those of the scene's equilibrium."""
    statics = quasi_static(evaluation.record, evaluation.law.name)
    if statics is None or evaluation.within_noise or evaluation.balance_within_noise:
        return ""
    should = np.count_nonzero(statics.force > LOADED * statics.force.max()) / statics.x.size
    count = float(evaluation.loaded_count.mean())
    if abs(count - should) <= MORE_ROLLERS:
        return ""
    return (
        f"{text(count, 2)} of its {evaluation.record.bearing.n_rollers} rollers are loaded on average, where the "
        f"scene's equilibrium loads {text(should, 2)}"
    )
