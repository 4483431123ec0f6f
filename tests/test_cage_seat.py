"""Where a cage stands at the start."""

import numpy as np
import pytest

from fem.errors import UsageError
from fem.solver.parts import cage_seat
from fem.solver.rigid.reduced import make_plan
from lagrange.bearing import Cage
from lagrange.scene.scene import parse_scene

BEARING = parse_scene({}, "").ideal_bearing()
ANGLE = 2.0 * np.pi / BEARING.n_rollers * np.arange(BEARING.n_rollers)
NOWHERE = np.zeros(2)
SHIFT = np.array([30e-6, -40e-6])  # m, 50 µm long
# rollers that follow a ring shifted so, each along its own radius: they are off on a circle around half the shift
SHIFTED = BEARING.pitch_radius + SHIFT @ [np.cos(ANGLE), np.sin(ANGLE)]
EVEN = np.full(BEARING.n_rollers, BEARING.pitch_radius)
FORCE = 1000.0  # N


def cage(half_clearance, stiffness=1e8, guidance="rollers", play=None):
    return Cage(
        mass=0.02, inertia=1e-5, pocket_clearance=2.0 * half_clearance, guidance=guidance, stiffness=stiffness,
        guidance_clearance=None if play is None else 2.0 * play, damping=1.0, friction_coefficient=0.0, drag_torque=0.0,
    )  # fmt: skip


@pytest.mark.parametrize("half_clearance, wanted", [(60e-6, NOWHERE), (30e-6, 0.5 * SHIFT)])
def test_a_cage_stands_in_the_middle_where_it_fits_and_else_where_rollers_leave_most_room(half_clearance, wanted):
    found = cage_seat(BEARING, cage(half_clearance), ANGLE, SHIFTED, NOWHERE, FORCE)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-8)


def test_a_guided_cage_goes_with_the_inner_ring():
    found = cage_seat(BEARING, cage(100e-6, guidance="inner_ring", play=20e-6), ANGLE, EVEN, SHIFT, FORCE)
    np.testing.assert_allclose(found, SHIFT, rtol=0.0, atol=1e-8)


def test_a_cage_that_rollers_would_wedge_harder_than_raceways_load_them_is_refused_with_what_to_do():
    """On the circle of radius 25 µm they are 10 µm beyond pockets of 15 µm."""
    with pytest.raises(UsageError, match=r"pocket_clearance_mm = 0\.03.*by 10 µm, which takes 1e\+03 N.*clearance"):
        cage_seat(BEARING, cage(15e-6), ANGLE, SHIFTED, NOWHERE, 0.99 * FORCE)
    found = cage_seat(BEARING, cage(15e-6), ANGLE, SHIFTED, NOWHERE, 1.01 * FORCE)
    np.testing.assert_allclose(found, 0.5 * SHIFT, rtol=0.0, atol=1e-8)


def test_a_scene_whose_cage_is_wedged_at_the_start_is_refused_but_may_start_at_rest():
    tables = {
        "model": "reduced", "material": {"outer_ring": {"youngs_modulus_GPa": 10.0}},
        "cage": {"guidance": "rollers", "pocket_clearance_mm": 0.005, "stiffness_N_per_m": 1e9},
        "numerics": {"duration_ms": 1.0},
    }  # fmt: skip
    with pytest.raises(UsageError, match="does not fit"):
        make_plan(parse_scene(tables, ""))
    tables["numerics"]["start"] = "rest"
    np.testing.assert_array_equal(make_plan(parse_scene(tables, "")).seat, NOWHERE)
