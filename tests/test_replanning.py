"""What planning keeps in memory: a plan made after others is, bit for bit, the one that is made first."""

import json
from collections.abc import Iterator

import numpy as np
import pytest

from fem.contacts.critical_step import critical_time_step, next_rung
from fem.solver.elements import plan as elements
from fem.solver.simulate import make_plan
from fem.statics import reduced_bearing
from lagrange.scene.scene import Scene, read_scene
from lagrange.surface import deviation as profile
from lagrange.surface import edges

SPALLED = {"spall.0.body": "roller", "spall.0.roller": 2, "spall.0.width_mm": 1.3, "spall.0.angle_deg": 12.0}
BEFORE = (
    {"operation.radial_load_N": 700.0, "operation.speed_rpm": 900.0, "operation.first_roller_deg": 7.0},
    {"spall.0.body": "outer_ring", "spall.0.width_mm": 0.7, "operation.radial_load_N": 2400.0},
)


def start_of(scene: Scene) -> Iterator[np.ndarray]:
    """All numbers that a run begins with."""
    plan = make_plan(scene)
    arrays, numbers = plan.first_state().to_keep()
    text = json.dumps([plan.time_step, plan.critical_time_step, numbers])
    yield np.frombuffer(text.encode(), dtype=np.uint8)
    yield from arrays.values()


def forget() -> None:
    """Empty what planning keeps, as in a process that has just begun."""
    for kept in (elements._built, reduced_bearing._kept_series, profile.profiles, edges._table):
        kept.cache_clear()


@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
@pytest.mark.parametrize("changes", [{"operation.radial_load_N": 1350.0}, SPALLED], ids=["load", "spall"])
def test_a_plan_after_others_is_a_fresh_one_bit_for_bit(model, changes):
    base = read_scene(None, (f"model={model}", "numerics.mesh_size_mm=2", "numerics.duration_ms=0.1"))
    scene = base.varied(changes)
    forget()
    fresh = list(start_of(scene))
    forget()
    for before in BEFORE:
        list(start_of(base.varied(before)))
    again = list(start_of(scene))
    assert len(fresh) == len(again)
    for one, other in zip(fresh, again, strict=True):
        assert one.tobytes() == other.tobytes()


def test_forces_of_one_octave_share_few_critical_steps_on_the_safe_side():
    forces = np.geomspace(300.0, 600.0, 50, endpoint=False)
    rungs = np.array([next_rung(force) for force in forces])
    assert np.all(rungs >= forces) and np.all(rungs < 1.1 * forces)
    assert len(set(rungs.tolist())) <= 9
    model = elements.model_of(read_scene(None, ("numerics.mesh_size_mm=2",)))
    exact, shared = critical_time_step(model, 330.0), critical_time_step(model, next_rung(330.0))
    assert 0.99 * exact < shared <= exact
