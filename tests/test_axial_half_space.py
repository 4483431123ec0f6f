"""Slices against half-spaces: pressures, approaches and moments of tilted and profiled rollers."""

from functools import cache
from math import log, pi

import numpy as np
import pytest

from fem.contacts.tilted import WIDTHS
from lagrange.axial.facts import Profile
from lagrange.axial.pressure import Ends
from lagrange.axial.slices import Slices
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import LogarithmicLaw
from tests.reference.bearings import paper
from tests.reference.half_space import Pressed, pressed

PAPER = paper()
INNER, OUTER, _ = contact_pairs(PAPER)
LENGTH = PAPER.roller_length
FILED = np.linspace(-0.5, 0.5, 401) * LENGTH
PROFILES = {"iso": Profile(kind="logarithmic"), "crown": Profile(kind="crowned", crown=1e-5), "none": Profile(),
            "lundberg": Profile(kind="lundberg", load=628.5),
            "filed": Profile(kind="measured", place=tuple(FILED), depth=tuple(2e-5 * (FILED / FILED[-1]) ** 4)),
            }  # fmt: skip
DEPTH = 4e-3  # m, that the plane law of a half-space takes; coupled slices do not depend on it
WIDE = {628.5: 1.35e-4, 2000.0: 1.6e-4}  # m, half of the meshed width, by load


@cache
def yardstick(pair, load: float, profile: str, slope: float) -> Pressed:
    shape = PROFILES[profile]
    return pressed(
        pair.relative_radius, LENGTH, pair.modulus, load, lambda z: shape.drop(z, PAPER), slope,
        cells=(56, 200), wide=WIDE[load],
    )  # fmt: skip


@pytest.mark.parametrize(
    "pair, load, profile, mrad, peak, place, approach, moment, within",
    [
        (INNER, 628.5, "iso", 0.0, 1045, 0.0, 3.500, 0, 0.005),
        (INNER, 628.5, "iso", 1.0, 1197, -2.81, 2.696, 1222, 0.003),
        (INNER, 628.5, "iso", 2.0, 1419, -3.76, 0.589, 1847, 0.005),
        (INNER, 628.5, "iso", 4.0, 1800, -4.44, -5.576, 2356, 0.005),
        (INNER, 628.5, "crown", 0.0, 1225, 0.0, 4.368, 0, 0.005),
        (INNER, 628.5, "crown", 1.0, 1225, -1.26, 3.743, 786, 0.005),
        (INNER, 2000.0, "iso", 0.0, 1606, 0.0, 8.101, 0, 0.005),
        (INNER, 2000.0, "iso", 1.0, 1792, None, 7.727, 2736, 0.005),
        (INNER, 2000.0, "iso", 2.0, 2100, None, 6.514, 4650, 0.005),
        (OUTER, 628.5, "iso", 0.0, 844, 0.0, 3.396, 0, 0.005),
        (OUTER, 628.5, "iso", 1.0, 970, None, 2.569, 1238, 0.005),
    ],
)
def test_the_half_space_solver_against_an_independent_one(
    pair, load, profile, mrad, peak, place, approach, moment, within
):
    found = yardstick(pair, load, profile, 1e-3 * mrad)
    assert 1e-6 * found.peak[0] == pytest.approx(peak, rel=within)
    assert 1e6 * found.approach == pytest.approx(approach, abs=0.002)
    assert 1e3 * found.moment == pytest.approx(moment, rel=within, abs=1.0)
    if place is not None:
        assert 1e3 * found.peak[1] == pytest.approx(place, abs=0.06)


@pytest.mark.parametrize("mrad, moment", [(0.5, 1625), (1.0, 2166)])
def test_moments_of_straight_rollers(mrad, moment):
    """Pressures at their ends are singular: forces and moments alone have a limit."""
    assert 1e3 * yardstick(INNER, 628.5, "none", 1e-3 * mrad).moment == pytest.approx(moment, rel=0.01)


def half_space_slices(pair, profile: str, count: int, coupled: bool = True) -> Slices:
    """Slices on two half-spaces: Boussinesq's 1/r between them, mean over both."""
    place = (np.arange(count) + 0.5 - 0.5 * count) * LENGTH / count
    h, m = LENGTH / count, np.abs(np.subtract.outer(np.arange(count), np.arange(count))).astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (m + 1) * np.log(m + 1) - 2.0 * m * np.log(m) + (m - 1) * np.log(np.abs(m - 1))
    own = 2.0 * log(h / DEPTH) - 2.0
    far = np.where(m == 1, 2.0 * log(2.0), far)
    coupling = 2.0 * np.where(m == 0, own, far) / (pi * 2.0 * pair.modulus * h)
    b_squared = pair.half_width_factor
    law = LogarithmicLaw(
        name="half-spaces", compliance=0.5 * pair.line_compliance, level=2.0 * log(4.0 * DEPTH) + 1.0 - log(b_squared),
        largest_force=(h / WIDTHS) ** 2 / b_squared if coupled else 1e5, source="Johnson 1985",
    )  # fmt: skip
    drop = PROFILES[profile].drop(place, PAPER)
    return Slices(law=law, place=place, drop=drop, coupling=coupling if coupled else None)


def under(slices: Slices, load: float, slope: float) -> tuple[float, float, np.ndarray]:
    """Approach, m, moment, N m, and forces of slices under a load, by bisection."""
    low, high = -5e-5, 5e-5
    for _ in range(50):
        middle = 0.5 * (low + high)
        forces = slices.forces(np.array([middle]), np.array([slope]))[0]
        low, high = (middle, high) if forces.sum() < load else (low, middle)
    return middle, -float(forces @ slices.place), forces


CASES = [
    (INNER, 628.5, "iso", 0.0), (INNER, 628.5, "iso", 1e-3), (INNER, 628.5, "iso", 2e-3),
    (INNER, 628.5, "crown", 0.0), (INNER, 628.5, "crown", 1e-3),
    (INNER, 2000.0, "iso", 0.0), (INNER, 2000.0, "iso", 1e-3),
    (OUTER, 628.5, "iso", 0.0), (OUTER, 628.5, "iso", 1e-3),
]  # fmt: skip


@pytest.mark.parametrize(
    "profile, load, mrad, is_loaded",
    [
        ("none", 628.5, 0.0, True), ("crown", 628.5, 0.0, False), ("iso", 2000.0, 2.0, False),
        ("lundberg", 628.5, 0.0, False), ("lundberg", 628.5, 1.0, True), ("lundberg", 2000.0, 0.0, True),
        ("filed", 2000.0, 3.0, False), ("filed", 2000.0, 10.0, True),
    ],
)  # fmt: skip
def test_loaded_edges_are_those_under_which_the_half_space_has_no_limit(profile, load, mrad, is_loaded):
    """A Lundberg profile ends with an edge but under its own load; a file's drop does where the contact reaches it."""
    shape, slices, half = PROFILES[profile], half_space_slices(INNER, profile, 21), 0.5 * LENGTH
    ends = Ends(shape.drop(np.array([-half, half]), PAPER), shape.even_load(PAPER))
    _, _, forces = under(slices, load, 1e-3 * mrad)
    assert ends.are_loaded(slices, slices.count * forces) == is_loaded
    coarse, fine = (
        pressed(
            INNER.relative_radius, LENGTH, INNER.modulus, load, lambda z: shape.drop(z, PAPER), 1e-3 * mrad,
            cells=(56, along), wide=WIDE[load],
        ).peak[0]
        for along in (100, 200)
    )  # fmt: skip
    assert (fine > 1.1 * coarse) == is_loaded
    if not is_loaded:
        assert INNER.peak_pressure(slices.count * forces.max()) == pytest.approx(fine, rel=0.02)


@pytest.mark.parametrize("count, pressure, moment", [(21, 0.007, 0.02), (41, 0.007, 0.005)])
def test_coupled_slices_meet_the_half_space(count, pressure, moment):
    for pair, load, profile, slope in CASES:
        exact, slices = yardstick(pair, load, profile, slope), half_space_slices(pair, profile, count)
        approach, held, forces = under(slices, load, slope)
        assert pair.peak_pressure(count * forces.max()) == pytest.approx(exact.peak[0], rel=pressure)
        assert held == pytest.approx(exact.moment, rel=moment, abs=1e-6)
        assert 1e6 * approach == pytest.approx(1e6 * exact.approach, abs=0.05)


def test_slices_that_stand_alone_miss_what_their_neighbours_carry():
    """The table of the pages: by 3 to 9 % of pressures and 8 % of moments at 1 mrad."""
    exact = yardstick(INNER, 628.5, "iso", 1e-3)
    _, held, forces = under(half_space_slices(INNER, "iso", 41, coupled=False), 628.5, 1e-3)
    assert INNER.peak_pressure(41 * forces.max()) == pytest.approx(1133e6, rel=0.005)
    assert 1e3 * held == pytest.approx(1123, rel=0.005)
    assert 0.04 < 1.0 - INNER.peak_pressure(41 * forces.max()) / exact.peak[0] < 0.06
