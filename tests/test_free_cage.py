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


def momentum(going, what):
    """Of all that moves, N s, x + iy"""
    bearing, memory = what.bearing, going.to_keep()
    hub, ring = memory["hub"][1]
    housing = what.operation.mounting.housing.mass + bearing.outer_ring_mass
    cage = what.cage.mass * (complex(*memory["cage.motion"][1, :2]) + ring)
    elements = bearing.roller_mass * np.sum(memory["elements"][1] + ring)
    return what.operation.inner_mass * (hub + ring) + housing * ring + elements + cage


@pytest.mark.parametrize("guide", GUIDES)
def test_momentum_of_hub_elements_cage_and_housing_is_what_the_load_gives(guide):
    """Springs to the ground are next to nothing: every force but the load has its counterpart, though places are from a
    ring that accelerates."""
    slack = Mounting(housing=Housing(mass=0.5, stiffness=1e-9, damping=0.0))
    what = problem(guide, slack, operation={"gravity": 0.0})
    going = simulation(what)
    start = momentum(going, what)
    run = going.advance(41)
    pushed = -1j * what.operation.radial_load * run.time[-1]
    given = np.abs(run.cage.force).max(axis=0)
    assert np.count_nonzero(given > 1.0) > 2, "pockets push"
    assert guide == "rollers" or np.abs(run.cage.guidance_y).max() > 1.0, "and so does the guide"
    assert abs(momentum(going, what) - start - pushed) < 1e-11 * abs(pushed)


def test_angular_momentum_of_a_free_cage_and_elements_is_conserved():
    """Frictionless, without drag, weight or load, the hub out of reach: pockets alone turn cage and elements."""
    what = problem("rollers", operation={"gravity": 0.0, "radial_load": 0.0}, drag_torque_N_m=0.0,
                   friction_coefficient=0.0)  # fmt: skip
    what = replace(what, bearing=replace(what.bearing, outer_raceway_radius=0.029))
    going = simulation(what)
    memory = going.to_keep()
    memory["elements"][1] += 0.5 * np.exp(2.5j * np.arange(8))  # m/s, this way and that

    def turning():
        motion = memory["cage.motion"]
        place, rate = complex(*motion[0, :2]), complex(*motion[1, :2])
        elements = what.bearing.roller_mass * np.sum(np.conj(memory["elements"][0]) * memory["elements"][1])
        return elements.imag + what.cage.mass * (np.conj(place) * rate).imag + what.cage.inertia * motion[1, 2]

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
