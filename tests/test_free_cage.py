"""A free cage of the Lagrangian model, on the ground and in a housing: what it keeps and what it loses."""

from dataclasses import replace

import numpy as np
import pytest

from lagrange import contact_laws
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.mounting import HELD, Housing, Mounting
from lagrange.scene.scene import parse_scene
from tests.reference.compiled_motion import compiled, simulation

pytestmark = pytest.mark.slow  # compiles loops that no other test has
LIGHT = Housing(mass=0.5, stiffness=2e8, damping=4000.0)
GUIDES = {
    "rollers": {},
    "inner ring": {"guidance": "inner_ring", "guidance_clearance_mm": 0.01},
    "outer ring": {"guidance": "outer_ring", "guidance_clearance_mm": 0.01},
}


def problem(guide, mounting=HELD, damping=0.0, operation=None, **cage):
    """The paper's bearing, eight of its rollers, at rest under its load at once, among pockets that soon touch."""
    tables = {"pocket_clearance_mm": 0.01, "drag_torque_N_m": 0.05, "friction_coefficient": 0.2} | cage
    scene = parse_scene({"cage": GUIDES[guide] | tables}, "scene")
    bearing = replace(scene.ideal_bearing(), n_rollers=8)
    running = replace(scene.ideal_operation(), mounting=mounting, **(operation or {}))
    return Problem(
        bearing=bearing, operation=running, laws=contact_laws("harris", bearing), start="rest", angles="free",
        cage=scene.ideal_cage(), damping=ContactDamping(constant=damping),
    )  # fmt: skip


def momentum(going):
    """Of all that moves, half a step before, N s, x + iy"""
    bodies = going.state.bodies
    moving = (
        (bodies.hub_mass, bodies.hub_velocity), (bodies.housing.mass, bodies.housing.velocity),
        (bodies.cage.cage.mass, bodies.cage.cage.motion[1]), (bodies.mass, bodies.velocity[:, : bodies.n].sum(axis=1)),
    )  # fmt: skip
    return sum(mass * complex(velocity[0], velocity[1]) for mass, velocity in moving)


@pytest.mark.parametrize("guide", GUIDES)
def test_momentum_of_hub_elements_cage_and_housing_is_what_the_load_gives(guide):
    """Springs to the ground are next to nothing: every force but the load has its counterpart, though places are from a
    ring that accelerates."""
    slack = Mounting(housing=Housing(mass=0.5, stiffness=1e-9, damping=0.0))
    what = problem(guide, slack, operation={"gravity": 0.0})
    going = simulation(what)
    start = momentum(going)
    run = going.advance(41)
    pushed = -1j * what.operation.radial_load * 41e-5  # steps go on up to the next sample
    given = np.abs(run.cage.force).max(axis=0)
    assert np.count_nonzero(given > 1.0) > 2, "pockets push"
    assert guide == "rollers" or np.abs(run.cage.guidance_y).max() > 1.0, "and so does the guide"
    assert abs(momentum(going) - start - pushed) < 1e-11 * abs(pushed)


def test_angular_momentum_of_a_free_cage_and_elements_is_conserved():
    """Frictionless, without drag, weight or load, the hub out of reach: pockets alone turn cage and elements."""
    what = problem("rollers", operation={"gravity": 0.0, "radial_load": 0.0}, drag_torque_N_m=0.0,
                   friction_coefficient=0.0)  # fmt: skip
    what = replace(what, bearing=replace(what.bearing, outer_raceway_radius=0.029))
    going = simulation(what)
    bodies = going.state.bodies
    centre, velocity, motion = bodies.centre[:, :8], bodies.velocity[:, :8], bodies.cage.cage.motion
    velocity += 0.5 * np.array([np.cos(2.5 * np.arange(8)), np.sin(2.5 * np.arange(8))])  # m/s, this way and that

    def turning():
        rollers = bodies.mass * np.sum(centre[0] * velocity[1] - centre[1] * velocity[0])
        cage = what.cage.mass * (motion[0, 0] * motion[1, 1] - motion[0, 1] * motion[1, 0])
        return rollers + cage + what.cage.inertia * motion[1, 2]

    before = turning()
    run = going.advance(41)
    assert np.abs(run.cage.force).max() > 10.0 and np.abs(run.inner_force).max() == 0.0
    assert np.abs(run.outer_force).max() == 0.0
    assert turning() == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("guide", GUIDES)
@pytest.mark.parametrize("mounting", [HELD, Mounting(housing=LIGHT)])
def test_the_energy_balances(guide, mounting):
    run = compiled(replace(problem(guide, mounting), start="equilibrium"), 61)
    moved = np.ptp(run.energy_moved) + run.energy_contact.max()
    for name in ("dashpots", "friction", "drag"):
        assert getattr(run.cage, f"work_{name}")[-1] > 1e-7 * moved
    assert np.abs(run.energy_error).max() < 1e-4 * moved


@pytest.mark.parametrize("guide", GUIDES)
def test_a_housing_that_hardly_moves_is_the_ground(guide):
    """Its places go with 1/mass; those of hub and cage, seen from it, as well. A large weight makes the cage fall."""
    free = {"gravity": 2000.0}
    ground = compiled(problem(guide, operation=free), 21)
    assert np.abs(ground.cage.force).max() > 1.0 and (guide == "rollers" or np.abs(ground.cage.guidance_y).max() > 1.0)
    off = []
    for mass in (1e7, 1e8):
        held = Mounting(housing=Housing(mass=mass, stiffness=mass * 1e6, damping=0.0))
        run = compiled(problem(guide, held, operation=free), 21)
        hub, cage = run.inner_y - run.housing_y - ground.inner_y, run.cage.y - run.housing_y - ground.cage.y
        off.append(max(np.abs(hub).max(), np.abs(cage).max()))
    assert 5.0 < off[0] / off[1] < 20.0 and off[1] < 1e-9
