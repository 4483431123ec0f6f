"""Runs of the reduced model: plans of scenes, their samples, runs that restart with shorter steps."""

from dataclasses import replace

import numpy as np

from fem.elastic.continuum import patch_displacement, plane_compliance, ring_sections
from fem.solver.rigid.reduced import ReducedPlan
from fem.solver.simulate import make_plan, run
from fem.solver.solver import Samples
from fem.statics.exact_statics import HALF_WIDTH, ReducedBearing
from lagrange.scene.scene import parse_scene, read_scene
from tests.reference.half_plane import cubic_bspline_patch

CLEARANCE = ("bearing.outer_raceway_diameter_mm=56.04", "operation.radial_load_N=200")
STILL = ("operation.speed_rpm=0", "contact.friction_coefficient=0")


def plan_of(*settings: str, stride: int | None = None) -> ReducedPlan:
    plan = make_plan(read_scene(None, ("model=reduced", *settings)))
    return plan if stride is None else replace(plan, stride=stride)


def samples_of(plan, change=lambda state: None, count: int | None = None) -> dict[str, np.ndarray]:
    """All samples, of a start that `change` has changed; never restarted."""
    state = plan.first_state()
    change(state)
    rows, status, *_ = state.take_steps((plan.n_samples if count is None else count) * plan.looks)
    assert status == 0
    read = state.reader.read(rows)
    return read.values | {"imbalance": read.imbalance, "exchanged": read.exchanged}


RATTLES = {
    "model": "reduced",
    "bearing": {"outer_raceway_diameter_mm": 56.04},
    "operation": {"radial_load_N": 200.0},
    "contact": {"friction_coefficient": 0.0},
    "numerics": {"start": "rest", "load_ramp_ms": 0.0, "duration_ms": 20.0, "time_step_safety": 0.9},
}


def in_longer_steps(settings):
    """A plan with steps half as long again as it would take: 0.68 of the critical one."""
    plan = make_plan(parse_scene(settings, "test"))
    assert (plan.stride, plan.looks) == (3, 1)
    return replace(plan, stride=2)


def ran(plan):
    """Its state at the end, the last pass' samples of the hub's height, and what it was told."""
    state, blocks, told = plan.first_state(), [], []

    def restart(reason):
        told.append((reason, state.void_steps))
        blocks.clear()

    run(plan, blocks.append, state=state, restart=restart)
    return state, Samples.joined(blocks)["inner_y"], told


def couplings(model: ReducedBearing, angle: np.ndarray) -> np.ndarray:
    """Of rollers at any angles, by the series themselves, (2, n, n), m/N."""
    bearing, n = model.bearing, len(angle)
    found = np.zeros((2, n, n))
    for row, ring in enumerate(ring_sections(bearing)):
        width = HALF_WIDTH * bearing.roller_radius
        harmonics = np.arange(int(30.0 * ring.loaded / width))
        series, load = plane_compliance(ring, harmonics), cubic_bspline_patch(harmonics, width, ring.loaded)
        for i in range(n):
            for j in range(i):
                value = patch_displacement(series, load, 1.0, ring.loaded, float(angle[i] - angle[j]))
                found[row, i, j] = found[row, j, i] = value / bearing.roller_length
    return found
