"""A free cage of the Lagrangian model, on the ground and in a housing: its numpy steps, and the compiled ones."""

from dataclasses import replace

import numpy as np
import pytest

from fem.solver.lagrangian_steps import CompiledIntegration
from lagrange import contact_laws
from lagrange.contact.damping import ContactDamping
from lagrange.first_state import Problem
from lagrange.integrate import NumpyIntegration
from lagrange.mounting import HELD, Housing, Mounting, Shaft
from lagrange.scene.scene import parse_scene
from lagrange.simulate import Simulation

INTERVAL = 1e-5
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


def momentum(simulation, what):
    """Of all that moves, N s, x + iy, and of a numpy cage's own motion."""
    bearing, memory = what.bearing, simulation.to_keep()
    hub, ring = memory["hub"][1]
    housing = what.operation.mounting.housing.mass + bearing.outer_ring_mass
    cage = what.cage.mass * complex(*memory["cage.motion"][1, :2])
    elements = bearing.roller_mass * np.sum(memory["elements"][1] + ring)
    return what.operation.inner_mass * (hub + ring) + housing * ring + elements + cage


@pytest.mark.parametrize("guide", GUIDES)
def test_momentum_of_hub_elements_cage_and_housing_is_what_the_load_gives(guide):
    """Springs to the ground are next to nothing: every force but the load has its counterpart, though places are from a
    ring that accelerates."""
    slack = Mounting(housing=Housing(mass=0.5, stiffness=1e-9, damping=0.0))
    what = problem(guide, slack, operation={"gravity": 0.0})
    simulation = Simulation(what, INTERVAL)
    start = momentum(simulation, what)
    run = simulation.advance(41)
    pushed = -1j * what.operation.radial_load * run.time[-1]
    given = np.abs(run.cage.force).max(axis=0)
    assert np.count_nonzero(given > 1.0) > 2, "pockets push"
    assert guide == "rollers" or np.abs(run.cage.guidance_y).max() > 1.0, "and so does the guide"
    assert abs(momentum(simulation, what) - start - pushed) < 1e-11 * abs(pushed)


def test_angular_momentum_of_a_free_cage_and_elements_is_conserved():
    """Frictionless, without drag, weight or load, the hub out of reach: pockets alone turn cage and elements."""
    what = problem("rollers", operation={"gravity": 0.0, "radial_load": 0.0}, drag_torque_N_m=0.0,
                   friction_coefficient=0.0)  # fmt: skip
    what = replace(what, bearing=replace(what.bearing, outer_raceway_radius=0.029))
    simulation = Simulation(what, INTERVAL)
    memory = simulation.to_keep()
    memory["elements"][1] += 0.5 * np.exp(2.5j * np.arange(8))  # m/s, this way and that

    def turning():
        motion = memory["cage.motion"]
        place, rate = complex(*motion[0, :2]), complex(*motion[1, :2])
        elements = what.bearing.roller_mass * np.sum(np.conj(memory["elements"][0]) * memory["elements"][1])
        return elements.imag + what.cage.mass * (np.conj(place) * rate).imag + what.cage.inertia * motion[1, 2]

    before = turning()
    run = simulation.advance(41)
    assert np.abs(run.cage.force).max() > 10.0 and np.abs(run.inner_force).max() == 0.0
    assert np.abs(run.outer_force).max() == 0.0
    assert turning() == pytest.approx(before, rel=1e-12)


@pytest.mark.parametrize("guide", GUIDES)
@pytest.mark.parametrize("mounting", [HELD, Mounting(housing=LIGHT)])
def test_the_energy_of_the_numpy_steps_balances(guide, mounting):
    run = Simulation(replace(problem(guide, mounting), start="equilibrium"), INTERVAL).advance(61)
    moved = np.ptp(run.energy_moved) + run.energy_contact.max()
    for name in ("dashpots", "friction", "drag"):
        assert getattr(run.cage, f"work_{name}")[-1] > 1e-7 * moved
    assert np.abs(run.energy_error).max() < 1e-4 * moved


@pytest.mark.parametrize("guide", GUIDES)
def test_a_housing_that_hardly_moves_is_the_ground(guide):
    """Its places go with 1/mass; those of hub and cage, seen from it, as well. A large weight makes the cage fall."""
    free = {"gravity": 2000.0}
    ground = Simulation(problem(guide, operation=free), INTERVAL).advance(21)
    assert np.abs(ground.cage.force).max() > 1.0 and (guide == "rollers" or np.abs(ground.cage.guidance_y).max() > 1.0)
    off = []
    for mass in (1e7, 1e8):
        held = Mounting(housing=Housing(mass=mass, stiffness=mass * 1e6, damping=0.0))
        run = Simulation(problem(guide, held, operation=free), INTERVAL).advance(21)
        hub, cage = run.inner_y - run.housing_y - ground.inner_y, run.cage.y - run.housing_y - ground.cage.y
        off.append(max(np.abs(hub).max(), np.abs(cage).max()))
    assert 5.0 < off[0] / off[1] < 20.0 and off[1] < 1e-9


def test_compiled_steps_go_on_from_a_start_that_numpy_s_have_kept():
    """As of a run of one sample, which loads no compiler."""
    what = problem("rollers")
    begun, fresh, rest = (
        Simulation(what, INTERVAL, integration=kind)
        for kind in (NumpyIntegration, CompiledIntegration, CompiledIntegration)
    )
    begun.advance(1)
    rest.take_back(begun.to_keep(), 1, 0)
    assert rest.done == 1
    for name, array in fresh.to_keep().items():
        if name.startswith("cage.") or name in ("hub", "elements"):
            assert np.array_equal(rest.to_keep()[name], array, equal_nan=True), name


@pytest.mark.slow  # compiles three loops that no other test has
@pytest.mark.parametrize("guide", GUIDES)
@pytest.mark.parametrize("mounting", [HELD, Mounting(housing=LIGHT, shaft=Shaft(stiffness=1e8, damping=400.0))])
@pytest.mark.parametrize("damping", [0.0, 500.0])
def test_the_compiled_steps_are_the_references(guide, mounting, damping):
    """To round-off and what 60 samples of strikes make of it, far less than half the step changes."""
    what = problem(guide, mounting, damping)
    step = Simulation(what, INTERVAL).time_step
    found, expected, finer = (
        Simulation(what, INTERVAL, length, integration=kind).advance(61)
        for kind, length in ((CompiledIntegration, None), (NumpyIntegration, step), (NumpyIntegration, 0.5 * step))
    )
    for name in ("x", "y", "angle", "force", "guidance_x", "guidance_y", "work_dashpots", "work_friction", "work_drag"):
        ours, theirs, nearer = (getattr(run.cage, name) for run in (found, expected, finer))
        allowed = 1e-2 * np.abs(theirs - nearer).max() + 1e-13 * np.abs(theirs).max()
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=allowed, err_msg=name)
    for name in ("inner_y", "energy_error", "housing_y", "housing_ay", "work_cage"):
        ours, theirs, nearer = (getattr(run, name) for run in (found, expected, finer))
        allowed = 1e-2 * np.abs(theirs - nearer).max() + 1e-13 * max(np.abs(theirs).max(), what.bearing.pitch_radius)
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=allowed, err_msg=name)
