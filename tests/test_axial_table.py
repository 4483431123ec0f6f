"""The table of a tilted contact's energy: its derivatives, its kernel, the slices that it stands for."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from fem.kernels.jit import kernel
from fem.kernels.tilted_contact import TiltedLaw, force_and_stiffness, in_series
from lagrange.axial import ContactTable
from lagrange.axial.facts import Profile
from lagrange.axial.pressure import Ends, peak_table, placed, pressures, pressures_under
from lagrange.axial.slices import Slices, alone, spalled, tabulated
from lagrange.axial.table import in_series as softened
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import contact_laws, johnson
from lagrange.tilt import roller_inertias
from tests.reference.bearings import paper

PAPER = paper()
LARGEST, STEEPEST = 1900.0, 4e-3  # N, rad
SOFT = 1e-9  # m/N, of an edge


def slices(kind: str, count: int = 21) -> Slices:
    place = (np.arange(count) + 0.5 - 0.5 * count) * PAPER.roller_length / count
    return Slices(law=johnson(PAPER, "inner"), place=place, drop=Profile(kind=kind, crown=1e-5).drop(place, PAPER))


def table_of(own: Slices) -> ContactTable:
    return tabulated(own, float(own.approach_under(LARGEST, 0.0)), STEEPEST)


@pytest.fixture(scope="module")
def table() -> ContactTable:
    return table_of(slices("logarithmic"))


def places(table: ContactTable, count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    return rng.uniform(table.first_approach, table.last_approach, count), rng.uniform(-STEEPEST, STEEPEST, count)


@pytest.mark.parametrize("kind", ["none", "logarithmic"])
def test_a_table_gives_the_forces_and_moments_of_its_slices(kind):
    own = slices(kind)
    table = table_of(own)
    approach, slope = places(table, 4000)
    found, exact = table.at(approach, slope), own.sums(approach, slope)
    assert np.sqrt(np.mean((found.force - exact.force) ** 2)) < 1e-4 * 1900.0  # N, of the largest
    assert np.sqrt(np.mean((found.moment - exact.moment) ** 2)) < 1e-4 * 3.0  # N m
    assert found.force.min() >= 0.0


def test_a_light_load_on_a_roller_that_may_tilt_far_takes_no_larger_table():
    """By steps of approach as fine as under a heavy load, beside slopes that cannot be, it would have 9000 rows."""
    own, light, steepest = slices("logarithmic"), 20.0, 1e-2  # N, rad
    table = tabulated(own, float(own.approach_under(light, 0.0)), steepest)
    assert table.coefficients.shape[0] < 700 and table.coefficients.shape[1] == 603
    rng = np.random.default_rng(3)
    slope, force = rng.uniform(-steepest, steepest, 2000), rng.uniform(0.0, light, 2000)
    found = table.at(own.approach_under(force, slope), slope)
    assert np.sqrt(np.mean((found.force - force) ** 2)) < 5e-3 * light


def test_a_straight_roller_tilts_at_the_frequency_that_its_length_and_radius_give():
    """Between held rings, over its radial one: √(L²/(L² + 3 r²)), of any law."""
    own, (across, _) = slices("none", 41).at(4e-6, 0.0), roller_inertias(PAPER)
    found = np.sqrt(own.tilt_stiffness / across / (own.stiffness / PAPER.roller_mass))
    assert found == pytest.approx(0.7559, rel=1e-3)


def test_a_straight_roller_vibrates_and_tilts_on_the_springs_of_the_standard():
    """kHz, roller 0 of the paper's bearing under 2000 N: half of ISO/TS 16281's 4.160 µm at each contact."""
    own, (across, _) = replace(slices("none", 41), law=contact_laws("iso16281", PAPER).inner), roller_inertias(PAPER)
    found = own.at(0.5 * 4.160e-6, 0.0)
    springs, inertias = np.array([found.stiffness, found.tilt_stiffness]), np.array([PAPER.roller_mass, across])
    assert 1e-3 * np.sqrt(2.0 * springs / inertias) / (2.0 * np.pi) == pytest.approx([52.57, 39.74], rel=1e-3)


@pytest.mark.parametrize("kind", ["logarithmic", "crowned"])
def test_peaks_by_force_and_moment_are_those_of_the_slices(kind):
    own, pair, largest, profile = slices(kind), contact_pairs(PAPER)[0], 800.0, Profile(kind=kind, crown=1e-5)
    half = 0.5 * PAPER.roller_length
    ends = Ends(profile.drop(np.array([-half, half]), PAPER), profile.even_load(PAPER))
    rng = np.random.default_rng(2)
    slope = rng.uniform(-2e-3, 2e-3, 1000)
    opening = own.opening(slope)
    approach = opening + rng.uniform(0.0, 1.0, slope.size) * (own.approach_under(largest, slope) - opening)
    forces, exact = own.forces(approach, slope), pressures(own, pair, approach, slope).max(axis=1)
    table = peak_table(own, pair, ends, largest, STEEPEST)
    found = table.at(forces.sum(axis=1), forces @ own.place)
    edges = approach - ends.drop[0] + half * np.abs(slope) > 0.0  # the arc's very end has met the raceway
    assert np.isnan(found[edges]).all() and edges.any() == (kind == "crowned")
    sound = np.isfinite(found)
    assert np.isnan(found[~edges]).mean() < 0.05  # of contacts that hardly miss the edge
    assert np.sqrt(np.mean((found - exact)[sound] ** 2)) < 1e-3 * exact.max()
    assert np.abs(found - exact)[sound].max() < 0.01 * exact.max()
    assert table.at(np.zeros(2), np.zeros(2)).tolist() == [0.0, 0.0]


def test_the_kernel_and_numpy_read_a_table_alike(table):
    @kernel
    def read_all(law, approach, slope, found):
        for i in range(approach.size):
            found[i, :6] = force_and_stiffness(law, approach[i], slope[i])
            found[i, 6:] = in_series(None, law, approach[i], slope[i], SOFT, 500.0)

    approach, slope = places(table, 500)
    approach[:2], slope[2:4] = (-1.0, 1e-6), (1.1 * STEEPEST, -1.1 * STEEPEST)  # outside too
    found = np.zeros((500, 12))
    read_all(TiltedLaw.of(table), approach, slope, found)
    soft = softened(table.at, approach, slope, SOFT)
    exact = np.column_stack(table.at(approach, slope)[:6] + soft[:6])
    for k, (column, wanted) in enumerate(zip(found.T, exact.T, strict=True)):
        inside = slice(0 if k < 6 else 4, None)
        tolerance = 1e-9 if k < 9 else 1e-6  # in series second derivatives are those before the last step
        scale = np.abs(wanted[inside]).max()
        assert column[inside] == pytest.approx(wanted[inside], rel=tolerance, abs=tolerance * scale)
    closed = soft.force > 0.0
    own = (approach - SOFT * soft.force)[closed]
    assert table.at(own, slope[closed]).force == pytest.approx(soft.force[closed], rel=1e-9)
    assert soft.force.max() < 0.9 * exact[:, 1].max()


def test_force_and_moment_are_the_derivatives_of_the_energy(table):
    approach, slope = places(table, 300)
    found = table.at(approach, slope)
    d, p = 1e-10, 1e-7
    plus, minus = table.at(approach + d, slope), table.at(approach - d, slope)
    right, left = table.at(approach, slope + p), table.at(approach, slope - p)
    assert (plus.energy - minus.energy) / (2.0 * d) == pytest.approx(found.force, rel=1e-4, abs=1e-2)
    assert -(right.energy - left.energy) / (2.0 * p) == pytest.approx(found.moment, rel=1e-4, abs=1e-5)
    assert (plus.force - minus.force) / (2.0 * d) == pytest.approx(found.stiffness, rel=1e-2, abs=1e5)
    assert -(right.moment - left.moment) / (2.0 * p) == pytest.approx(found.tilt_stiffness, rel=1e-2, abs=2.0)


def test_a_table_over_a_spall_is_that_of_its_slices():
    whole = slices("logarithmic", 20)
    own = replace(whole, part=whole.place > 0.0)
    table, rng = spalled(own, table_of(whole)), np.random.default_rng(3)
    approach, slope = places(table.whole, 2000)
    sunk, soft = rng.uniform(0.0, 10e-6, 2000) * rng.integers(0, 2, 2000), rng.uniform(0.0, SOFT, (2, 2000))
    found, exact = table.at(approach, slope, sunk, *soft), alone(own).at(approach, slope, sunk, *soft)
    for k, name in enumerate(("edges", "part_edges")):
        way = 1e-13 * (np.arange(2)[:, None] == k)
        more, less = (table.at(approach, slope, sunk, *(soft + sign * way)).energy for sign in (1.0, -1.0))
        assert -(more - less) / 2e-13 == pytest.approx(getattr(found, name), rel=1e-4, abs=50.0)  # N²
    for name, scale in (("force", 1900.0), ("moment", 3.0), ("part", 1900.0)):
        missed = getattr(found, name) - getattr(exact, name)
        assert np.sqrt(np.mean(missed**2)) < 1e-4 * scale
    exact, h = own.at(approach, slope, sunk), 1e-10
    for one, other in zip(alone(own).at(approach, slope, sunk)[:7], exact[:7], strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9 * np.abs(other).max())
    more, less = (own.sums(approach, slope, sunk + step).energy for step in (h, -h))
    assert -(more - less) / (2.0 * h) == pytest.approx(exact.part, rel=1e-4, abs=1e-2)


def test_coupled_slices_over_a_spall_are_exact_where_all_or_none_have_sunk():
    whole = slices("logarithmic", 10)
    apart = np.abs(whole.place[:, None] - whole.place)
    coupled = replace(whole, coupling=2e-9 * np.exp(-apart / 1e-3))
    own = replace(coupled, part=whole.place > 0.0)
    table, rng = spalled(own, table_of(coupled)), np.random.default_rng(4)
    approach, slope = places(table.whole, 400)
    for sunk in (0.0, 1e-3):
        found, exact = table.at(approach, slope, sunk + 0.0 * slope), own.sums(approach, slope, sunk + 0.0 * slope)
        assert np.sqrt(np.mean((found.force - exact.force) ** 2)) < 1e-4 * 1900.0
    sunk = rng.uniform(0.0, 8e-6, 400)  # between, where slices of the part and of the rest are coupled
    missed = table.at(approach, slope, sunk).force - own.sums(approach, slope, sunk).force
    assert np.sqrt(np.mean(missed**2)) < 0.02 * 1900.0


def test_pressures_over_a_spall_follow_from_force_and_moment():
    whole = slices("logarithmic", 20)
    own, pair = replace(whole, part=whole.place > 0.0), contact_pairs(PAPER)[0]
    approach, slope, sunk = np.array([6e-6, 7e-6, 8e-6]), np.array([0.0, 5e-4, -5e-4]), np.array([0.0, 2e-6, 50e-6])
    sums = own.sums(approach, slope, sunk)
    found = placed(own, sums.force, sums.moment, sunk)
    assert found[0] == pytest.approx(approach, rel=1e-4) and found[1] == pytest.approx(slope, abs=1e-7)
    along = pressures(own, pair, *found, sunk)
    assert along[2][own.part].max() == 0.0 and along[2][~own.part].max() > 5e8
    assert along[0] == pytest.approx(along[0][::-1])


def test_moments_that_a_table_gives_of_light_contacts_are_those_at_a_roller_s_end():
    """Beside heavy forces a table's error may be more than all that a light force exerts."""
    own, pair, light = slices("logarithmic"), contact_pairs(PAPER)[0], np.array([3.0, -3.0])
    arm, closed = own.place[-1], np.ones(2, dtype=bool)
    found, _ = pressures_under(own, pair, np.abs(light), 1.3 * arm * light, np.zeros(2), closed)
    assert found[0, -1] == found[0].max() == pytest.approx(pair.peak_pressure(own.count * 3.0), rel=1e-5)
    assert found[1] == pytest.approx(found[0, ::-1])


def test_coupled_slices_take_bounded_memory():
    """A table's contacts, each with a matrix of its slices, are solved some at a time; at once they took 0.8 GB."""
    place = slices("logarithmic", 61).place
    coupled = replace(slices("logarithmic", 61), coupling=1e-9 * np.exp(-np.abs(place[:, None] - place) / 1e-3))
    tracemalloc.start()
    whole = coupled.forces(np.linspace(0.0, 5e-6, 6000), 1e-4)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 250e6
    assert whole[4000:4001] == pytest.approx(coupled.forces(np.linspace(0.0, 5e-6, 6000)[4000:4001], 1e-4), rel=1e-9)
