"""Balls on surfaces that are not perfect: how deep a sphere sinks in its groove, statics, energy, strikes, search."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from fem.interface import simulate
from lagrange import static_equilibrium
from lagrange.contact.laws import ball_law, contact_laws
from lagrange.first_state import Problem
from lagrange.scene.scene import Scene, SceneError
from lagrange.surface.deviation import Turns, profiles
from lagrange.surface.faults import Spall
from tests.reference.compiled_motion import assert_right
from tests.reference.ideal import DGBB_209, DOWN, RUNNING, wavy

HERTZ = contact_laws("hertz", DGBB_209)
BEARING = {
    "type": "ball", "rollers": 9, "roller_diameter_mm": 12.7, "roller_length_mm": 19.0,
    "inner_raceway_diameter_mm": 52.291, "outer_raceway_diameter_mm": 77.706,
    "bore_diameter_mm": 45.0, "outside_diameter_mm": 85.0,
}  # fmt: skip
SPALLED = {
    "model": "lagrange", "bearing": BEARING, "spall": [{"width_mm": 1.0, "angle_deg": 3.0}],
    "operation": {"speed_rpm": 1800.0, "radial_load_N": 3000.0, "inner_ring_and_shaft_kg": 0.5},
    "damping": {"contact_time_us": 12.5},
}  # fmt: skip


def deep(body, width, angle=DOWN):
    """Sharp edges, and deeper than a ball reaches."""
    return Spall(body=body, roller=None, angle=angle, width=width, depth=1e-3, edge_radius=0.0)


def sunk_sphere(side: str, half_gap: float, beyond: np.ndarray) -> np.ndarray:
    """How far a ball gets past where the sound groove stops it, m, by points of the groove in space beside the gap."""
    r, bearing = DGBB_209.roller_radius, DGBB_209
    across = np.linspace(-0.6, 0.6, 241)[:, None]  # rad, around the groove's cross-section
    if side == "outer":
        raceway, groove = bearing.outer_raceway_radius, bearing.outer_groove_radius
        radius, axial = raceway - groove * (1.0 - np.cos(across)), groove * np.sin(across)
    else:
        raceway, groove = bearing.inner_raceway_radius, bearing.inner_groove_radius
        radius, axial = raceway + groove * (1.0 - np.cos(across)), groove * np.sin(across)
    gap = np.arcsin(half_gap / raceway)
    along = np.concatenate([[-gap], -gap - np.linspace(0, 0.05, 400), gap + np.linspace(0, 0.05, 400)])
    found = []
    for angle in beyond:
        forward = radius * np.cos(along - angle)
        reach = r**2 - (radius**2 + axial**2 - forward**2)
        way = np.sqrt(np.where(reach >= 0.0, reach, np.nan))
        place = np.nanmin(forward - way) if side == "outer" else np.nanmax(forward + way)
        found.append(place - (raceway - r) if side == "outer" else raceway + r - place)
    return np.array(found)


@pytest.mark.parametrize("body", ["outer_ring", "inner_ring"])
@pytest.mark.parametrize("width", [0.5e-3, 1.5e-3])
def test_a_ball_sinks_between_edges_as_its_equator_does(body, width):
    """The sphere's other parallels leave the groove faster than they enter the gap."""
    side = body.split("_")[0]
    raceway = getattr(DGBB_209, f"{side}_raceway_radius")
    beyond = 0.5 * width / raceway * np.array([0.0, 0.3, 0.6, 0.9])
    surfaces = profiles(replace(DGBB_209, faults=(deep(body, width, angle=0.0),)))
    here = getattr(surfaces, side)(beyond[:, None] * np.ones(9), Turns())
    # the spline rounds the kink in the middle, 0.3 % too low
    np.testing.assert_allclose(here.sinkage[:, 0], sunk_sphere(side, 0.5 * width, beyond), rtol=0.006, atol=1e-9)
    assert here.sinkage[0, 0] > 2e-6


def test_statics_with_a_ball_over_a_shallow_spall_are_the_least_of_the_energy():
    depth, load = 4e-6, 3000.0
    fault = Spall(body="outer_ring", roller=None, angle=DOWN, width=2e-3, depth=depth, edge_radius=1e-4)
    still = replace(RUNNING, speed=0.0, gravity=0.0, radial_load=load)
    found = static_equilibrium(replace(DGBB_209, faults=(fault,)), still, HERTZ, roller_mass=0.0)
    inner, outer = (ball_law(DGBB_209, side).stiffness for side in ("inner", "outer"))
    series = (inner ** (-2.0 / 3.0) + outer ** (-2.0 / 3.0)) ** -1.5  # of both contacts of a ball
    turn = 2.0 * np.pi * np.arange(9) / 9
    sunk = np.where(turn == 0.0, depth, 0.0) + DGBB_209.radial_clearance

    def energy(down):
        return np.sum(0.4 * series * np.maximum(down * np.cos(turn) - sunk, 0.0) ** 2.5) - load * down

    hub = float(minimize(lambda s: energy(s[0] * 1e-6), [30.0], method="Nelder-Mead", tol=1e-12).x[0]) * 1e-6
    # approaches here are of first order in the hub's way, 36 µm of 50 mm
    assert -found.y == pytest.approx(hub, rel=5e-4)
    forces = series * np.maximum(hub * np.cos(turn) - sunk, 0.0) ** 1.5
    np.testing.assert_allclose(found.inner_force, forces, rtol=1e-3, atol=0.5)


def test_balls_on_waves_move_as_the_reference_has_them():
    bearing = replace(DGBB_209, faults=wavy())
    assert_right(Problem(bearing=bearing, operation=RUNNING, laws=HERTZ), count=21)


@pytest.mark.slow  # compiles a loop
def test_balls_strike_in_a_spall_at_the_ball_pass_frequency_and_keep_the_energy():
    run = simulate(Scene(**SPALLED, numerics={"duration_ms": 30.0, "output_interval_us": 1.0}))
    pass_frequency = 9 * (1800 / 60) / 2 * (52.291 / (0.5 * (52.291 + 77.706)))
    strikes = np.array([event.time for event in run.events if event.kind == "strike" and event.raceway == "outer"])
    assert len(strikes) == pytest.approx(0.03 * pass_frequency, abs=1.0)
    assert np.diff(strikes).mean() == pytest.approx(1.0 / pass_frequency, rel=1e-3)
    total = run["energy_kinetic"] + run["energy_contact"] + run["work_dissipated"] - run["work_external"]
    assert np.ptp(total) < 1e-4 * np.ptp(run["energy_contact"])


def test_films_of_balls_are_refused_by_name():
    with pytest.raises(SceneError, match=r"\[lubricant\]: films are those of line contacts"):
        Scene(**{**SPALLED, "spall": [], "lubricant": {}})
