"""Which waves move the hub: selection by the order and the number of rollers (Wardle 1988), under uniform preload.

Statics at many places of the ring, which is the motion of low speed: the hub's path holds the lines of the spectrum.
"""

from dataclasses import replace

import numpy as np
import pytest

from fem.statics.contact_balance import Loads, balance, first_guess
from fem.statics.exact_statics import exact_contacts
from lagrange import static_equilibrium
from lagrange.contact.laws import ContactLaws, PowerLaw, contact_laws
from lagrange.kinematics import kinematics, roller_angles
from lagrange.scene.scene import Scene
from lagrange.surface.deviation import Turns
from lagrange.surface.faults import UnequalRoller, Waviness

PAPER = Scene().ideal_bearing()
PRELOADED = replace(PAPER, outer_raceway_radius=PAPER.outer_raceway_radius - 1e-6)
STANDING = replace(Scene().ideal_operation(), speed=0.0, gravity=0.0, radial_load=0.0)
LINEAR = ContactLaws(*(2 * [PowerLaw(name="linear", stiffness=3e8, exponent=1.0, source="")]))
TURNING = replace(STANDING, speed=1.0)  # rad/s
IDEAL = kinematics(PAPER, 1.0)
A = 1e-8  # m, a fiftieth of the contacts' approach δ; slopes of order n have a part n δ/χ in what follows
TIMES = np.linspace(0.0, 40.0, 9)  # shaft angle, rad


def hub(faults, laws, cage):
    """x + iy of the hub as the cage turns, and ring and rollers with it, rolling, (n_times,), m."""
    bearing = replace(PRELOADED, faults=faults)
    path, near = [], (0.0, 0.0)
    for time in TIMES:
        angles = roller_angles(bearing, 0.1) + cage * time
        turns = Turns.rolling(PAPER, TURNING, time)
        found = static_equilibrium(bearing, STANDING, laws, angles=angles, roller_mass=0.0, start=near, turns=turns)
        near = found.x, found.y
        path.append(complex(*near))
    return np.array(path)


def wave(body, order, roller=None):
    return (Waviness(body=body, roller=roller, order=order, amplitude=A, phase=0.2),)


@pytest.mark.parametrize("law", ["linear", "harris"])
@pytest.mark.parametrize("order", [1, 2, 11, 12, 13, 14, 15, 25, 26, 27])
def test_orders_of_the_inner_ring_that_move_the_hub(order, law):
    """Those next to multiples of the number of rollers, by their amplitude (the rigid linear limit); no others."""
    laws = LINEAR if law == "linear" else contact_laws("harris", PRELOADED)
    moved = np.abs(hub(wave("inner_ring", order), laws, IDEAL.cage))
    if order % 13 in (1, 12):
        np.testing.assert_allclose(moved, A, rtol=2e-3)
    else:
        # a law that is not linear couples the order with itself
        assert moved.max() < (1e-6 if law == "linear" else 3e-3) * A


def test_the_hub_circles_at_the_frequencies_of_the_orders():
    """k BPFI ∓ f_shaft: 12 at BPFI − f_s backwards, 14 at BPFI + f_s forwards, with rad of the shaft as time."""
    bpfi = 13 * (IDEAL.shaft - IDEAL.cage)
    for order, speed in ((12, -(bpfi - IDEAL.shaft)), (14, bpfi + IDEAL.shaft)):
        path = hub(wave("inner_ring", order), LINEAR, IDEAL.cage)
        turned = path * np.exp(-1j * speed * TIMES)
        np.testing.assert_allclose(turned, turned[0], atol=2e-3 * A)


@pytest.mark.parametrize("order", [11, 12, 13, 14])
def test_orders_of_the_outer_ring(order):
    """At BPFO: the rollers carry the wave over to the hub."""
    path = hub(wave("outer_ring", order), LINEAR, IDEAL.cage)
    if order in (12, 14):
        speed = 13 * IDEAL.cage * (1.0 if order == 12 else -1.0)
        turned = path * np.exp(-1j * speed * TIMES)
        np.testing.assert_allclose(np.abs(path), A, rtol=2e-3)
        np.testing.assert_allclose(turned, turned[0], atol=2e-3 * A)
    else:
        assert np.abs(path).max() < 1e-6 * A


@pytest.mark.parametrize("order", [12, 13, 14, 15])
def test_elastic_rings_obey_the_same_selection(order):
    """By symmetry, whatever the law and the rings' stiffness: exact series of elastic bodies."""
    bearing = replace(PRELOADED, faults=wave("inner_ring", order))
    contacts = exact_contacts(bearing, roller_angles(bearing, 0.1))
    place, _ = balance(contacts, Loads(0.0), first_guess(bearing, contacts.radial, 0.0))
    moved = np.hypot(place[0], place[1])
    if order in (12, 14):
        assert 0.5 * A < moved < 1.5 * A
    else:
        assert moved < 2e-3 * A


def test_even_orders_of_a_roller_move_the_hub_at_twice_its_spin():
    """2 BSF ± FTF: 2nd order on one roller squeezes it twice a turn, in the direction that turns with the cage."""
    path = hub(wave("roller", 2, roller=0), LINEAR, IDEAL.cage)
    direction = np.exp(-1j * (IDEAL.cage * TIMES + 0.1))
    along = path * direction
    assert np.abs(along.imag).max() < 1e-3 * A
    # both contacts of the roller give way at the same time, half of the rollers' stiffness around: 4 A/13
    angle = IDEAL.cage * TIMES + 0.1 - IDEAL.roller * TIMES
    np.testing.assert_allclose(along.real, -4.0 / 13.0 * A * np.cos(2.0 * angle + 0.2), atol=2e-3 * A)


def test_an_unequal_roller_moves_the_hub_at_the_cage_frequency():
    """By 2 Δd/Z in the linear rigid limit, 0.154 µm per µm (Yhland 1992), away from the roller."""
    faults = (UnequalRoller(roller=4, diameter_deviation=A),)
    path = hub(faults, LINEAR, IDEAL.cage)
    direction = np.exp(1j * (0.1 + 2 * np.pi * 4 / 13 + IDEAL.cage * TIMES))
    np.testing.assert_allclose(path, -2.0 / 13.0 * A * direction, atol=1e-3 * A)
