"""Rollers that tilt, at rest: [axial] in scenes, a tilted contact's table and slices, the whole bearing.

Against half-spaces, the plane series and the method of ISO/TS 16281.
"""

import tracemalloc
from dataclasses import replace
from functools import cache
from math import exp, log, pi
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from scipy.special import i0, i1

from fem.commands.run_fem import run_main
from fem.contacts.tilted import WIDTHS
from fem.elastic import axial_series
from fem.elastic.axial_series import axial_difference, harmonic_compliance
from fem.elastic.continuum import Section, hertz_approach, plane_compliance, ring_sections, roller_section
from fem.interface import simulate
from fem.kernels.jit import kernel
from fem.kernels.tilted_contact import TiltedLaw, force_and_stiffness, in_series
from fem.pictures.axial import axial_pressures, draw_axial
from fem.pictures.output import refuse_foreign
from fem.pictures.recover import StoredRun
from fem.rating.equilibria import TiltedPitch, tilted_pitch
from fem.solver.start import check_narrow
from fem.statics.exact_statics import exact_statics, kept_contacts
from fem.statics.tilted_pressures import scene_slices
from lagrange.axial import slices as slicing
from lagrange.axial.pressure import Ends, peak_table, placed, pressures, pressures_under
from lagrange.axial.table import ContactTable
from lagrange.axial.table import in_series as softened
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import LogarithmicLaw, contact_laws, johnson
from lagrange.errors import UsageError
from lagrange.files.hdf5 import Damaged, hdf5_to_write
from lagrange.kinematics import roller_angles
from lagrange.motion import HubTilt, roller_inertias, sliced_laws
from lagrange.rating.axial_load import rigid_loads
from lagrange.rating.life import Dimensions
from lagrange.rating.sources import Unavailable
from lagrange.scene import Scene, read_scene
from lagrange.scene.faults import SceneError
from lagrange.scene.scene import parse_scene_text
from lagrange.statics import Placement, Statics, tilted_equilibrium
from tests.reference.continua import Pressed, pressed
from tests.reference.kit import LOAD, ON_A_ROLLER, STEEL, operation, paper, sets

PAPER = paper()
INNER, OUTER, _ = contact_pairs(PAPER)
LENGTH = PAPER.roller_length

# [axial] in scenes: profiles by name and from files, and what does not fit


def test_profiles_fall_off_as_their_formulas_say_and_those_of_a_file_are_kept_with_the_run(tmp_path):
    assert Scene().ideal_axial() is None
    scene = Scene(axial={"roller_profile": "crowned", "inner_raceway_profile": "lundberg", "crown_um": 8.0,
                         "lundberg_load_N": 1000.0, "slices": 3})  # fmt: skip
    inner, outer = scene.ideal_axial().drops(scene.perfect_bearing())
    crown = 8e-6 * (2.0 / 3.0) ** 2
    assert outer == pytest.approx([crown, 0.0, crown])
    lundberg = 1000.0 / (np.pi * 115.3846e9 * 0.01) * np.log(1.0 / (1.0 - (2.0 / 3.0) ** 2))
    assert inner == pytest.approx([crown + lundberg, 0.0, crown + lundberg], rel=1e-5)
    (tmp_path / "drops.csv").write_text("z_mm,drop_um\n-5,12\n-2,2\n0,2\n2,2\n5,22\n")
    (tmp_path / "scene.toml").write_text('[axial]\nroller_profile = "drops.csv"\nslices = 5\n')
    scene = read_scene(tmp_path / "scene.toml")
    drops = scene.ideal_axial().drops(scene.perfect_bearing())  # slices at -4, -2, 0, 2, 4 mm; the least drop is 0
    assert 1e6 * drops == pytest.approx(np.array([[20 / 3, 0.0, 0.0, 0.0, 40 / 3]] * 2))
    assert parse_scene_text(scene.to_toml(), "run", scene.files).ideal_axial() == scene.ideal_axial()
    for rows, words in (
        ("-5,12\n-6,2\n5,22\n", "must rise from row to row: after -5 comes -6"),
        ("-5,12\n0,0\n5,1e308\n", r"drop_um = 1e\+308: at most 100000 either way"),
        ("-3,12\n0,0\n3,22\n", "slices of rollers of 10 mm have their middles from"),
    ):
        (tmp_path / "drops.csv").write_text("z_mm,drop_um\n" + rows)
        with pytest.raises(SceneError, match=words):
            read_scene(tmp_path / "scene.toml")


def test_long_rollers_are_straight_in_their_middle_and_those_at_the_limit_have_the_profile_of_short_ones():
    """L = 2.5 D as it is typed, whatever the rounding of metres: the long rollers' formula drops 1.43 times as much."""
    edge = 0.0005 * 8.0 * np.log(1.0 / (1.0 - (18.0 / 20.0) ** 2))
    assert slicing.logarithmic_drop(np.array([0.0, 10.0, 19.0]), 40.0, 8.0) == pytest.approx([0.0, 0.0, edge])
    for diameter in np.round(np.arange(8.0, 14.0, 0.1), 1).tolist():
        sizes = {"roller_diameter_mm": diameter, "inner_raceway_diameter_mm": 60.0, "outside_diameter_mm": 120.0}
        sizes |= {"roller_length_mm": round(2.5 * diameter, 9), "clearance_um": 0.0}
        scene = Scene(bearing=sizes, axial={"slices": 3})
        drop = scene.ideal_axial().drops(scene.perfect_bearing())[0, 0]
        assert drop == pytest.approx(0.35e-6 * diameter * np.log(9.0 / 5.0)), diameter


def test_sizes_and_places_at_their_limits_are_taken_as_they_are_typed(tmp_path):
    """What is refused beyond a limit, or has another formula there, at the limit; sizes that round differently."""
    for k in range(30):
        roller = round(8.0 + 0.1 * k, 1)
        bearing = {"roller_diameter_mm": roller, "roller_length_mm": roller, "inner_raceway_diameter_mm": 36.0}
        bearing |= {"outside_diameter_mm": 80.0, "rollers": 9}
        for clearance in (200.0 * roller, -5.0 * roller):  # µm
            Scene(bearing=bearing | {"clearance_um": round(clearance, 6)})
        bearing["clearance_um"] = 20.0
        deviation = [{"diameter_deviation_um": round(5.0 * roller, 6)}]
        Scene(bearing=bearing, unequal_roller=deviation, model="reduced")
        Scene(bearing=bearing, axial={"ring_width_mm": roller}, numerics={"mesh_size_mm": round(roller / 400.0, 6)})
        part = {"length_mm": round(0.8 * roller, 6), "depth_um": 10.0}  # to the middles of the outermost slices of five
        scene = Scene(bearing=bearing, axial={"slices": 5}, model="reduced", spall=[part | {"z_mm": 0.2 * roller}])
        taken = scene.ideal_axial().parts(scene.ideal_bearing())[1]
        assert taken.tolist() == [False, True, True, True, True], roller
        Scene(bearing=bearing, axial={}, model="reduced", spall=[{"length_mm": roller, "depth_um": 10.0}])
        # a run of one interval
        Scene(numerics={"duration_ms": round(0.01 + 0.0007 * k, 4), "output_interval_us": round(10.0 + 0.7 * k, 1)})
    rows = "".join(f"{60 + 0.001 * k:.3f},1000\n" for k in range(30))
    (tmp_path / "speeds.csv").write_text(f"time_ms,speed_rpm\n0,1000\n{rows}")
    (tmp_path / "scene.toml").write_text('[operation]\nspeed_table = "speeds.csv"\n')
    assert read_scene(tmp_path / "scene.toml").operation.speed_rpm == 1000.0


HALVES = [{"length_mm": 2.0}, {"length_mm": 3.0, "angle_deg": 90.0}]


@pytest.mark.parametrize(("tables", "words"), [
    ({"axial": {"roller_profile": "crowned"}}, "needs crown_um"),
    ({"axial": {"crown_um": 3.0}}, 'only with a profile that is "crowned"'),
    ({"axial": {"ring_width_mm": 8.0}}, "at least bearing.roller_length_mm = 10"),
    ({"axial": {"shaft_tilt_stiffness_N_m_rad": 10.0}}, "give hub_tilt_inertia_kg_m2"),
    ({"operation": {"misalignment_mrad": 1.0}}, "operation.misalignment_mrad = 1: needs an [axial] table"),
    ({"axial": {}, "model": "lagrange", "bearing": {"type": "ball"}}, "[axial]: only for rollers"),
    ({"spall": [{"length_mm": 5.0}]}, "spall.0.length_mm = 5: needs an [axial] table"),
    ({"spall": [{"z_mm": 2.0}]}, "give length_mm too"),
    ({"axial": {}, "model": "reduced", "spall": [{"length_mm": 9.9}]}, "goes over all middles of axial.slices = 21"),
    ({"axial": {}, "model": "reduced", "spall": [{"length_mm": 2.0, "z_mm": 6.0}]}, "goes over no middles"),
    ({"axial": {}, "model": "reduced", "spall": HALVES}, "other slices of contacts with the outer_ring than spall.0"),
])  # fmt: skip
def test_what_does_not_fit_is_named(tables, words):
    with pytest.raises(SceneError) as raised:
        Scene(**tables)
    assert words in str(raised.value)


# The table of a tilted contact's energy: its derivatives, its kernel, the slices that it stands for

LARGEST, STEEPEST = 1900.0, 4e-3  # N, rad
SOFT = 1e-9  # m/N, of an edge


def rms(values):
    return np.sqrt(np.mean(values**2))


def middles(count: int) -> np.ndarray:
    return (np.arange(count) + 0.5 - 0.5 * count) * LENGTH / count


def slices(kind: str, count: int = 21) -> slicing.Slices:
    place = middles(count)
    drop = slicing.Profile(kind=kind, crown=1e-5).drop(place, PAPER)
    return slicing.Slices(law=johnson(PAPER, "inner"), place=place, drop=drop)


def table_of(own: slicing.Slices) -> ContactTable:
    return slicing.tabulated(own, float(own.approach_under(LARGEST, 0.0)), STEEPEST)


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
    assert rms(found.force - exact.force) < 1e-4 * 1900.0 and found.force.min() >= 0.0  # N, of the largest
    assert rms(found.moment - exact.moment) < 1e-4 * 3.0  # N m


def test_a_light_load_on_a_roller_that_may_tilt_far_takes_no_larger_table_and_coupled_slices_bounded_memory():
    """By steps of approach as fine as under a heavy load, beside slopes that cannot be, it would have 9000 rows.

    Contacts, each with a matrix of its slices, are solved some at a time; at once they took 0.8 GB.
    """
    own, light, steepest = slices("logarithmic"), 20.0, 1e-2  # N, rad
    table = slicing.tabulated(own, float(own.approach_under(light, 0.0)), steepest)
    assert table.coefficients.shape[0] < 700 and table.coefficients.shape[1] == 603
    rng = np.random.default_rng(3)
    slope, force = rng.uniform(-steepest, steepest, 2000), rng.uniform(0.0, light, 2000)
    assert rms(table.at(own.approach_under(force, slope), slope).force - force) < 5e-3 * light
    own, approach = coupled(61, 1e-9), np.linspace(0.0, 5e-6, 6000)
    tracemalloc.start()
    whole = own.forces(approach, 1e-4)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 250e6
    assert whole[4000:4001] == pytest.approx(own.forces(approach[4000:4001], 1e-4), rel=1e-9)


def test_a_straight_roller_vibrates_and_tilts_on_the_springs_of_the_standard():
    """kHz, roller 0 of the paper's bearing under 2000 N: half of ISO/TS 16281's 4.160 µm at each contact.

    Between held rings it tilts at √(L²/(L² + 3 r²)) of its radial frequency, of any law.
    """
    inertias = np.array([PAPER.roller_mass, roller_inertias(PAPER)[0]])
    for law, approach in ((slices("none").law, 4e-6), (contact_laws("iso16281", PAPER).inner, 0.5 * 4.160e-6)):
        found = replace(slices("none", 41), law=law).at(approach, 0.0)
        both = np.sqrt(2.0 * np.array([found.stiffness, found.tilt_stiffness]) / inertias) / (2.0 * np.pi)
        assert both[1] / both[0] == pytest.approx(0.7559, rel=1e-3)
    assert 1e-3 * both == pytest.approx([52.57, 39.74], rel=1e-3)


@pytest.mark.parametrize("kind", ["logarithmic", "crowned"])
def test_peaks_by_force_and_moment_are_those_of_the_slices(kind):
    own, largest, profile, half = slices(kind), 800.0, slicing.Profile(kind=kind, crown=1e-5), 0.5 * LENGTH
    ends = Ends(profile.drop(np.array([-half, half]), PAPER), profile.even_load(PAPER))
    rng = np.random.default_rng(2)
    slope = rng.uniform(-2e-3, 2e-3, 1000)
    opening = own.opening(slope)
    approach = opening + rng.uniform(0.0, 1.0, slope.size) * (own.approach_under(largest, slope) - opening)
    forces, exact = own.forces(approach, slope), pressures(own, INNER, approach, slope).max(axis=1)
    table = peak_table(own, INNER, ends, largest, STEEPEST)
    found = table.at(forces.sum(axis=1), forces @ own.place)
    edges = approach - ends.drop[0] + half * np.abs(slope) > 0.0  # the arc's very end has met the raceway
    assert np.isnan(found[edges]).all() and edges.any() == (kind == "crowned")
    sound = np.isfinite(found)
    assert np.isnan(found[~edges]).mean() < 0.05  # of contacts that hardly miss the edge
    assert rms((found - exact)[sound]) < 1e-3 * exact.max() and np.abs(found - exact)[sound].max() < 0.01 * exact.max()
    assert table.at(np.zeros(2), np.zeros(2)).tolist() == [0.0, 0.0]


def test_the_kernel_and_numpy_read_a_table_alike_whose_forces_are_the_derivatives_of_its_energy(table):
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
    approach, slope = places(table, 300)
    found, d, p = table.at(approach, slope), 1e-10, 1e-7
    plus, minus = table.at(approach + d, slope), table.at(approach - d, slope)
    right, left = table.at(approach, slope + p), table.at(approach, slope - p)
    assert (plus.energy - minus.energy) / (2.0 * d) == pytest.approx(found.force, rel=1e-4, abs=1e-2)
    assert -(right.energy - left.energy) / (2.0 * p) == pytest.approx(found.moment, rel=1e-4, abs=1e-5)
    assert (plus.force - minus.force) / (2.0 * d) == pytest.approx(found.stiffness, rel=1e-2, abs=1e5)
    assert -(right.moment - left.moment) / (2.0 * p) == pytest.approx(found.tilt_stiffness, rel=1e-2, abs=2.0)


def test_tables_over_a_spall_are_those_of_their_slices_coupled_ones_where_all_or_none_have_sunk():
    whole = slices("logarithmic", 20)
    own = replace(whole, part=whole.place > 0.0)
    table, rng = slicing.spalled(own, table_of(whole)), np.random.default_rng(3)
    approach, slope = places(table.whole, 2000)
    sunk, soft = rng.uniform(0.0, 10e-6, 2000) * rng.integers(0, 2, 2000), rng.uniform(0.0, SOFT, (2, 2000))
    found, exact = table.at(approach, slope, sunk, *soft), slicing.alone(own).at(approach, slope, sunk, *soft)
    for k, name in enumerate(("edges", "part_edges")):
        way = 1e-13 * (np.arange(2)[:, None] == k)
        more, less = (table.at(approach, slope, sunk, *(soft + sign * way)).energy for sign in (1.0, -1.0))
        assert -(more - less) / 2e-13 == pytest.approx(getattr(found, name), rel=1e-4, abs=50.0)  # N²
    for name, scale in (("force", 1900.0), ("moment", 3.0), ("part", 1900.0)):
        assert rms(getattr(found, name) - getattr(exact, name)) < 1e-4 * scale
    exact, h = own.at(approach, slope, sunk), 1e-10
    for one, other in zip(slicing.alone(own).at(approach, slope, sunk)[:7], exact[:7], strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-9 * np.abs(other).max())
    more, less = (own.sums(approach, slope, sunk + step).energy for step in (h, -h))
    assert -(more - less) / (2.0 * h) == pytest.approx(exact.part, rel=1e-4, abs=1e-2)
    whole = coupled(10, 2e-9)
    own = replace(whole, part=whole.place > 0.0)
    table, rng = slicing.spalled(own, table_of(whole)), np.random.default_rng(4)
    approach, slope = places(table.whole, 400)
    for sunk, share in (
        (np.zeros(400), 1e-4), (np.full(400, 1e-3), 1e-4),
        (rng.uniform(0.0, 8e-6, 400), 0.02),  # between, where slices of the part and of the rest are coupled
    ):  # fmt: skip
        assert rms(table.at(approach, slope, sunk).force - own.sums(approach, slope, sunk).force) < share * 1900.0


def coupled(count: int, strength: float) -> slicing.Slices:
    own = slices("logarithmic", count)
    return replace(own, coupling=strength * np.exp(-np.abs(own.place[:, None] - own.place) / 1e-3))


def test_pressures_follow_from_force_and_moment_over_a_spall_and_at_a_roller_s_end():
    """Beside heavy forces a table's error may be more than all that a light force exerts."""
    whole = slices("logarithmic", 20)
    own = replace(whole, part=whole.place > 0.0)
    approach, slope, sunk = np.array([6e-6, 7e-6, 8e-6]), np.array([0.0, 5e-4, -5e-4]), np.array([0.0, 2e-6, 50e-6])
    sums = own.sums(approach, slope, sunk)
    found = placed(own, sums.force, sums.moment, sunk)
    assert found[0] == pytest.approx(approach, rel=1e-4) and found[1] == pytest.approx(slope, abs=1e-7)
    along = pressures(own, INNER, *found, sunk)
    assert along[2][own.part].max() == 0.0 and along[2][~own.part].max() > 5e8
    assert along[0] == pytest.approx(along[0][::-1])
    own, light = slices("logarithmic"), np.array([3.0, -3.0])
    moments, closed = 1.3 * own.place[-1] * light, np.ones(2, dtype=bool)
    found, _ = pressures_under(own, INNER, np.abs(light), moments, np.zeros(2), closed)
    assert found[0, -1] == found[0].max() == pytest.approx(INNER.peak_pressure(own.count * 3.0), rel=1e-5)
    assert found[1] == pytest.approx(found[0, ::-1])


# Slices against half-spaces: pressures, approaches and moments of tilted and profiled rollers

FILED = np.linspace(-0.5, 0.5, 401) * LENGTH
PROFILES = {"iso": slicing.Profile(kind="logarithmic"), "crown": slicing.Profile(kind="crowned", crown=1e-5),
            "none": slicing.Profile(),
            "lundberg": slicing.Profile(kind="lundberg", load=628.5),
            "filed": slicing.Profile(kind="measured", place=tuple(FILED), depth=tuple(2e-5 * (FILED / FILED[-1]) ** 4)),
            "knee": slicing.Profile(kind="measured", place=(-5e-3, -4e-3, 4e-3, 5e-3), depth=(2e-5, 0.0, 0.0, 2e-5)),
            }  # fmt: skip
DEPTH = 4e-3  # m, that the plane law of a half-space takes; coupled slices do not depend on it
WIDE = {628.5: 1.35e-4, 2000.0: 1.6e-4}  # m, half of the meshed width, by load


@cache
def yardstick(pair, load: float, profile: str, slope: float, along: int = 200) -> Pressed:
    return pressed(pair.relative_radius, LENGTH, pair.modulus, load, lambda z: PROFILES[profile].drop(z, PAPER), slope,
        cells=(56, along), wide=WIDE[load])  # fmt: skip


@pytest.mark.parametrize(("pair", "load", "profile", "mrad", "peak", "place", "approach", "moment", "within"), [
    (INNER, 628.5, "iso", 0.0, 1045, 0.0, 3.500, 0, 0.005), (INNER, 628.5, "iso", 1.0, 1197, -2.81, 2.696, 1222, 0.003),
    (INNER, 628.5, "iso", 2.0, 1419, -3.76, 0.589, 1847, 0.005),
    (INNER, 628.5, "iso", 4.0, 1800, -4.44, -5.576, 2356, 0.005),
    (INNER, 628.5, "crown", 0.0, 1225, 0.0, 4.368, 0, 0.005),
    (INNER, 628.5, "crown", 1.0, 1225, -1.26, 3.743, 786, 0.005),
    (INNER, 2000.0, "iso", 0.0, 1606, 0.0, 8.101, 0, 0.005),
    (INNER, 2000.0, "iso", 1.0, 1792, None, 7.727, 2736, 0.005),
    (INNER, 2000.0, "iso", 2.0, 2100, None, 6.514, 4650, 0.005),
    (OUTER, 628.5, "iso", 0.0, 844, 0.0, 3.396, 0, 0.005), (OUTER, 628.5, "iso", 1.0, 970, None, 2.569, 1238, 0.005),
    (INNER, 628.5, "none", 0.5, None, None, None, 1625, 0.01),  # pressures at straight rollers' ends are singular:
    (INNER, 628.5, "none", 1.0, None, None, None, 2166, 0.01),  # forces and moments alone have a limit
])  # fmt: skip
def test_the_half_space_solver_against_an_independent_one(
    pair, load, profile, mrad, peak, place, approach, moment, within
):
    found = yardstick(pair, load, profile, 1e-3 * mrad)
    assert 1e3 * found.moment == pytest.approx(moment, rel=within, abs=1.0)
    if peak is not None:
        assert 1e-6 * found.peak[0] == pytest.approx(peak, rel=within)
        assert 1e6 * found.approach == pytest.approx(approach, abs=0.002)
    if place is not None:
        assert 1e3 * found.peak[1] == pytest.approx(place, abs=0.06)


def half_space_slices(pair, profile: str, count: int, coupled: bool = True) -> slicing.Slices:
    """Slices on two half-spaces: Boussinesq's 1/r between them, mean over both."""
    h, m = LENGTH / count, np.abs(np.subtract.outer(np.arange(count), np.arange(count))).astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (m + 1) * np.log(m + 1) - 2.0 * m * np.log(m) + (m - 1) * np.log(np.abs(m - 1))
    own = 2.0 * log(h / DEPTH) - 2.0
    far = np.where(m == 1, 2.0 * log(2.0), far)
    coupling = 2.0 * np.where(m == 0, own, far) / (pi * 2.0 * pair.modulus * h)
    b_squared = pair.half_width_factor
    law = LogarithmicLaw(name="half-spaces", compliance=0.5 * pair.line_compliance,
        level=2.0 * log(4.0 * DEPTH) + 1.0 - log(b_squared), largest_force=(h / WIDTHS) ** 2 / b_squared if coupled
        else 1e5, source="Johnson 1985")  # fmt: skip
    drop = PROFILES[profile].drop(middles(count), PAPER)
    return slicing.Slices(law=law, place=middles(count), drop=drop, coupling=coupling if coupled else None)


def under(slices: slicing.Slices, load: float, slope: float) -> tuple[float, float, np.ndarray]:
    low, high = -5e-5, 5e-5
    for _ in range(50):
        middle = 0.5 * (low + high)
        forces = slices.forces(np.array([middle]), np.array([slope]))[0]
        low, high = (middle, high) if forces.sum() < load else (low, middle)
    return middle, -float(forces @ slices.place), forces


@pytest.mark.parametrize(("profile", "load", "mrad", "is_loaded"), [
    ("none", 628.5, 0.0, True), ("crown", 628.5, 0.0, False), ("iso", 2000.0, 2.0, False),
    ("lundberg", 628.5, 0.0, False), ("lundberg", 628.5, 1.0, True), ("lundberg", 2000.0, 0.0, True),
    ("filed", 2000.0, 3.0, False), ("filed", 2000.0, 10.0, True), ("knee", 2000.0, 0.0, True),
])  # fmt: skip
def test_loaded_edges_are_those_under_which_the_half_space_has_no_limit(profile, load, mrad, is_loaded):
    """A Lundberg profile ends with an edge but under its own load; a file's drop does where the contact reaches it.

    A file's knee is one, too, of whose pressure slices have too little.
    """
    shape, slices, half = PROFILES[profile], half_space_slices(INNER, profile, 21), 0.5 * LENGTH
    ends = Ends(shape.drop(np.array([-half, half]), PAPER), shape.even_load(PAPER), INNER, shape.knees)
    _, _, forces = under(slices, load, 1e-3 * mrad)
    assert ends.are_loaded(slices, slices.count * forces) == is_loaded
    coarse, fine = (yardstick(INNER, load, profile, 1e-3 * mrad, along).peak[0] for along in (100, 200))
    assert (fine > 1.07 * coarse) == is_loaded
    if not is_loaded:
        assert INNER.peak_pressure(slices.count * forces.max()) == pytest.approx(fine, rel=0.02)


@pytest.mark.parametrize(("count", "pressure", "moment"), [(21, 0.007, 0.02), (41, 0.007, 0.005)])
def test_coupled_slices_meet_the_half_space(count, pressure, moment):
    for case in (
        (INNER, 628.5, "iso", 0.0), (INNER, 628.5, "iso", 1e-3), (INNER, 628.5, "iso", 2e-3),
        (INNER, 628.5, "crown", 0.0), (INNER, 628.5, "crown", 1e-3), (INNER, 2000.0, "iso", 0.0),
        (INNER, 2000.0, "iso", 1e-3), (OUTER, 628.5, "iso", 0.0), (OUTER, 628.5, "iso", 1e-3),
    ):  # fmt: skip
        pair, load, profile, slope = case
        exact, (approach, held, forces) = yardstick(*case), under(half_space_slices(pair, profile, count), load, slope)
        assert pair.peak_pressure(count * forces.max()) == pytest.approx(exact.peak[0], rel=pressure), case
        assert held == pytest.approx(exact.moment, rel=moment, abs=1e-6), case
        assert 1e6 * approach == pytest.approx(1e6 * exact.approach, abs=0.05), case


def test_slices_that_stand_alone_miss_what_their_neighbours_carry():
    """The table of the pages: by 3 to 9 % of pressures and 8 % of moments at 1 mrad."""
    _, held, forces = under(half_space_slices(INNER, "iso", 41, coupled=False), 628.5, 1e-3)
    peak = INNER.peak_pressure(41 * forces.max())
    assert peak == pytest.approx(1133e6, rel=0.005) and 1e3 * held == pytest.approx(1123, rel=0.005)
    assert 0.04 < 1.0 - peak / yardstick(INNER, 628.5, "iso", 1e-3).peak[0] < 0.06


# Circular bodies under loads that vary along the axis: the plane series, the half-space

ROLLER, (INNER_SERIES, OUTER_SERIES) = roller_section(PAPER).squeezed, ring_sections(PAPER)
SOLID = Section(INNER_SERIES.loaded, 0.0, STEEL)
UNIT = 1.0 / (pi * STEEL.plane_strain_modulus)  # m per N/m


def test_long_and_short_waves_a_solid_shaft_and_slices_have_the_compliance_of_known_bodies():
    """Long waves: the plane series; short ones: K0 of a half-space under a line load cos kz less the plane approach.

    That under Hertz's pressure, at its centre. A solid shaft uniform around: Timoshenko and Goodier, Theory of
    Elasticity, 143; across, of long waves: q/(E I k⁴). Differences of an independent prototype, 1/mm. Slices as a
    half-space has it: own value 2 ln(h/ℓ) − 2 over π E', 2 ln 2 of neighbours.
    """
    k = 0.05  # 1/m: kR = 2.5e-4
    for body, n in ((ROLLER, [2, 4, 6, 20]), (INNER_SERIES, [1, 2, 5, 20]), (OUTER_SERIES, [1, 2, 5, 20])):
        assert harmonic_compliance(body, np.array(n), k) == pytest.approx(plane_compliance(body, np.array(n)), rel=1e-6)
        if body is not ROLLER:
            assert axial_difference(body, k) / UNIT == pytest.approx(0.0, abs=1e-5)
    assert axial_difference(ROLLER, 1.0) == pytest.approx(axial_series.axial_limit(STEEL), rel=1e-4)
    assert axial_series.axial_limit(STEEL) / UNIT == pytest.approx(0.1978, abs=5e-5)
    k, half_width = 24e3, 1e-5
    for body in (ROLLER, INNER_SERIES, OUTER_SERIES, SOLID):
        depth = 0.25 * half_width * exp(0.5 * hertz_approach(body, half_width) / UNIT - 0.5)
        expected = -2.0 * (log(k * depth) + np.euler_gamma)
        assert axial_difference(body, k) / UNIT == pytest.approx(expected, abs=0.005)
    a, nu = SOLID.loaded, STEEL.poisson_ratio
    for x in (0.02, 0.5, 3.0):
        swollen, bent = harmonic_compliance(SOLID, np.array([0, 1]), x / a)
        free = x * x * (i0(x) ** 2 - i1(x) ** 2) - 2.0 * (1.0 - nu) * i1(x) ** 2
        assert swollen == pytest.approx(a * (1.0 - nu) / STEEL.lame_mu * i1(x) ** 2 / free, rel=1e-9)
        if x < 0.1:
            assert bent == pytest.approx(4.0 * a / (STEEL.youngs_modulus * x**4), rel=x * x)
    for k, expected, within in (
        (pi / 10, (-0.3644, -0.4133, -0.2040), 0.0005), (pi / 5, (-1.4303, -1.3453, -0.8674), 0.0005),
        (pi, (-4.6530, -4.5389, -3.9678), 0.003),
    ):  # fmt: skip
        found = [axial_difference(body, 1e3 * k) / UNIT for body in (ROLLER, INNER_SERIES, OUTER_SERIES)]
        assert found == pytest.approx(expected, abs=within), k
    h = LENGTH / 41
    found = axial_series.slice_compliance(INNER_SERIES, LENGTH, 2.0 * LENGTH, 41) * h / UNIT
    assert found == pytest.approx(found.T, abs=1e-9)
    assert found[20, 20] == pytest.approx(2.0 * log(h / 1.7334e-3) - 2.0, abs=0.06)
    assert found[20, 21] == pytest.approx(2.0 * log(2.0), abs=0.06)


# Pressures along the rollers of a run, from the forces and moments that its file holds


@pytest.mark.slow  # a run's time loop is compiled for it
def test_a_file_gives_the_pressures_of_the_statics(tmp_path):
    tables = {"operation": {"misalignment_mrad": 1.0}, "numerics": {"duration_ms": 0.0}, "axial": {"slices": 11}}
    simulate(Scene(model="reduced", **tables)).save(tmp_path / "run.nc")
    stored = StoredRun(tmp_path / "run.nc")
    found, scene = axial_pressures(stored, 0), stored.scene
    pitch = tilted_pitch(scene.perfect_bearing(), scene.ideal_axial(), scene.ideal_operation(), samples=1)
    inner = pressures(pitch.slices[0], contact_pairs(pitch.bearing)[0], *pitch.statics[0].of_side(0))
    assert found.pressure[0].max() == pytest.approx(inner.max(), rel=0.01)
    at = int(found.pressure[0].max(axis=1).argmax())
    assert found.slope[0, at] == pytest.approx(-0.5e-3, abs=5e-5)
    assert found.pressure[0, at] @ found.place > 0.0  # its +z end is pressed
    draw_axial(stored, tmp_path / "axial.png", 0)
    refuse_foreign(tmp_path / "axial.png", force=False)  # the next picture may take its place
    assert (tmp_path / "axial.png").read_bytes().startswith(b"\x89PNG")


def test_a_place_bears_the_force_and_moment_that_it_was_asked_for_and_a_file_keeps_the_slices(tmp_path):
    own, _ = slicing.contact_slices(PAPER, Scene(model="lagrange", axial={"slices": 21}).ideal_axial(),
        contact_laws("johnson", PAPER))  # fmt: skip
    approach, slope = placed(own, 600.0, 1.2)
    sums = own.sums(np.array([approach]), np.array([slope]))
    assert (sums.force[0], sums.moment[0]) == (pytest.approx(600.0, rel=1e-5), pytest.approx(1.2, rel=1e-4))
    with pytest.raises(ValueError, match="beyond"):
        placed(own, 600.0, 6.0)
    with pytest.raises(UsageError, match="no \\[axial\\]"):
        axial_pressures(SimpleNamespace(scene=Scene(), path="plane.nc"), 0)
    scene = Scene(model="reduced", axial={"slices": 11})
    bearing, axial, written = scene.perfect_bearing(), scene.ideal_axial(), scene_slices(scene)
    with hdf5_to_write(tmp_path / "run.nc") as file:
        slicing.write_slices(file, written)
    with h5py.File(tmp_path / "run.nc", "r+") as file:
        for own, other in zip(written, slicing.read_slices(file, bearing, axial), strict=True):
            assert np.array_equal(own.forces(4e-6, 1e-4), other.forces(4e-6, 1e-4))
        file["outer_slice_compliance"][3, 4] = np.nan
        with pytest.raises(Damaged, match="outer_slice_compliance is no compliance of 11 slices"):
            slicing.read_slices(file, bearing, axial)


# The whole bearing with tilted rollers at rest: elastic bodies, and the method of ISO/TS 16281


def axial(profile: str, slices: int, coupling: bool) -> slicing.Axial:
    return slicing.Axial(roller=slicing.Profile(kind=profile, crown=1e-5, load=700.0 if profile == "lundberg" else 0.0),
        slices=slices, inner_raceway=slicing.Profile(), outer_raceway=slicing.Profile(), coupling=coupling,
        ring_width=0.02)  # fmt: skip


@cache
def stands(profile: str, slices: int, coupling: bool, mrad: float) -> TiltedPitch:
    acting = operation(speed=0.0, gravity=0.0, radial_load=LOAD, misalignment=1e-3 * mrad)
    return tilted_pitch(PAPER, axial(profile, slices, coupling), acting, samples=1)


def test_straight_rollers_without_tilt_are_those_of_the_plane_series_and_have_no_peak_pressure():
    exact, whole = exact_statics(PAPER, LOAD, ON_A_ROLLER), stands("none", 21, False, 0.0)
    found = whole.statics[0]
    assert -1e6 * found.place[1] == pytest.approx(3.6146, rel=2e-4)
    assert found.inner_force[:4] == pytest.approx([628.5, 549.5, 337.2, 62.9], rel=2e-4, abs=0.05)  # N
    assert found.place[1] == pytest.approx(exact.hub[1], rel=2e-4)
    assert found.inner_force == pytest.approx(exact.inner_force, rel=2e-4, abs=0.1)
    with pytest.raises(Unavailable, match="edge"):
        _ = whole.peaks


@pytest.mark.parametrize(("coupling", "slices", "mrad", "hub", "moment", "pressure", "within"), [
    (False, 41, 0.0, 6.568, 0.0, 1064, 0.005), (False, 41, 1.0, 6.205, 1914, 1108, 0.005),
    (False, 41, 2.0, 5.156, 3455, 1202, 0.005), (True, 31, 0.0, 6.409, 0.0, 1076, 0.01),
    (True, 31, 1.0, 6.029, 1980, 1126, 0.01), (True, 31, 2.0, 4.928, 3571, 1236, 0.01),
])  # fmt: skip
def test_profiled_rollers_under_a_slope_of_the_shaft(coupling, slices, mrad, hub, moment, pressure, within):
    """Against an independent prototype: µm, N mm, MPa."""
    found = stands("logarithmic", slices, coupling, mrad)
    assert -1e6 * found.statics[0].place[1] == pytest.approx(hub, rel=within)
    assert 1e3 * found.moment == pytest.approx(moment, rel=within, abs=0.1)
    assert 1e-6 * INNER.peak_pressure(found.peaks["inner"]) == pytest.approx(pressure, rel=within)


def test_steep_slopes_lift_crowned_rollers_and_load_the_ends_of_lundbergs():
    """Under a slope its end is an edge: the peak looked settled, 1215 to 1236 MPa for 15 to 41 slices."""
    found, angle = stands("crowned", 21, True, 4.0).statics[0], roller_angles(PAPER, ON_A_ROLLER)
    assert found.inner_force @ np.sin(angle) == pytest.approx(-LOAD, rel=1e-3)  # along contacts' normals but for 1e-3
    assert found.inner_force == pytest.approx(found.outer_force, abs=1e-2)
    assert 4.0 < found.on_hub[1] < 5.0
    assert stands("lundberg", 21, True, 0.0).peaks["inner"] == pytest.approx(628.5, rel=0.1)
    with pytest.raises(Unavailable, match="edge"):
        _ = stands("lundberg", 21, True, 1.0).peaks


def test_stiffness_is_what_a_small_slope_shows_and_springs_hold_a_tilted_shaft():
    """The standard's at no slope, the load kept: N m/rad. A shaft on one finds the slope that balances it."""
    found, near = stands("logarithmic", 41, False, 1.0), stands("logarithmic", 41, False, 1.2)
    (one,), (other,) = found.statics, near.statics
    steeper = other.place[3] - one.place[3]
    mean = 0.5 * (found.tilt_stiffness + near.tilt_stiffness)
    assert (one.on_hub[1] - other.on_hub[1]) / steeper == pytest.approx(mean, rel=0.02)
    whole = 0.5 * (found.stiffness + near.stiffness)  # at constant load the hub goes where both parts cancel
    assert (other.place[1] - one.place[1]) / steeper == pytest.approx(-whole[1, 3] / whole[1, 1], rel=0.02)
    np.testing.assert_allclose(whole, whole.T, atol=1e-9 * whole.max())
    for profile, stiffness in ((False, 4448), (True, 1926)):
        moment = rigid_loads(Dimensions.of(PAPER), LOAD, 0.0, 1e-6, profile=profile).moment
        assert 1e-3 * moment / 1e-6 == pytest.approx(stiffness, rel=1e-3)
    found = rigid_rings("logarithmic", 1.0, inertia=1e-5, stiffness=2000.0)
    assert -1e-3 < found.place[3] < 0.0
    held = rigid_rings("logarithmic", -1e3 * found.place[3])
    assert held.on_hub[1] == pytest.approx(2000.0 * (1e-3 + found.place[3]), rel=1e-3)


def rigid_rings(profile: str, mrad: float, **free: float) -> Statics:
    laws = sliced_laws(PAPER, axial(profile, 40, False), contact_laws("iso16281", PAPER))
    acting = operation(speed=0.0, gravity=0.0, radial_load=LOAD)
    hub = HubTilt(slope_x=0.0, slope_y=-1e-3 * mrad, **free)
    start = np.array([0.0, -1e-5]), np.full(PAPER.n_rollers, PAPER.pitch_radius)
    return tilted_equilibrium(PAPER, acting, laws, hub, Placement(roller_angles(PAPER, ON_A_ROLLER)), start)


def test_slices_narrower_than_their_contacts_are_refused_with_the_number_that_fits():
    """A start whose tables give a light contact too large a moment, all of it on the last slice, is checked too."""
    acting = operation(speed=0.0, gravity=0.0, radial_load=20_000.0, misalignment=2e-3)
    for count in (61, 201):
        with pytest.raises(Unavailable, match=rf"axial.slices = {count} are .* use at most 1\d"):
            tilted_pitch(PAPER, axial("logarithmic", count, True), acting)
    tilted_pitch(PAPER, axial("logarithmic", 15, True), acting, samples=1)
    contacts, _ = kept_contacts(PAPER)
    force, arm = np.array([30.0, 0.0]), 0.5e-2  # N, m: half the length

    def check(times):
        loads = {f"{side}_{name}": times * value for side in ("inner", "outer")
                 for name, value in (("force", force), ("moment", 1.3 * arm * force))}  # fmt: skip
        check_narrow(PAPER, axial("logarithmic", 21, True), contacts.laws, SimpleNamespace(**loads))

    check(1.0)
    with pytest.raises(UsageError, match=r"axial\.slices = 21 are"):
        check(100.0)


def started(path, *settings: str) -> tuple[np.ndarray, np.ndarray]:
    assert run_main(["--quiet", "--duration", "0", "--output", str(path), "--force", *sets(*settings)]) == 0
    with h5py.File(path) as file:
        hub = np.array([file[f"inner_{axis}"][0] for axis in "xy"])
        apart = np.array([file[f"roller_{axis}"][0] for axis in "xy"]) - hub[:, None]
        return hub, -(apart / np.hypot(*apart)) @ file["inner_force"][0]


@pytest.mark.parametrize(("clearance", "load", "mrad"), [(30, 50, 1), (50, 1000, 4)])
def test_a_bearing_in_clearance_without_weight_and_speed_stands_on_its_loaded_rollers(tmp_path, clearance, load, mrad):
    """Rollers that bear nothing rest between the raceways; rigid rings on slices have the same hub within 5 %."""
    scene = [f"bearing.clearance_um={clearance}", f"operation.radial_load_N={load}", "operation.speed_rpm=0",
        f"operation.misalignment_mrad={mrad}", "operation.gravity_m_s2=0", "axial.slices=11"]  # fmt: skip
    hub, force = started(tmp_path / "run.nc", "model=reduced", *scene)
    assert force == pytest.approx([0.0, load], abs=1e-4 * load)
    assert hub[1] == pytest.approx(started(tmp_path / "run.nc", "model=lagrange", *scene)[0][1], rel=0.05)


def test_a_free_slope_that_no_contact_holds_stays_where_it_is(tmp_path):
    hub, force = started(tmp_path / "run.nc", "model=lagrange", "bearing.clearance_um=30", "operation.radial_load_N=20",
        "operation.speed_rpm=1000", "operation.gravity_m_s2=0", "axial.roller_profile=crowned", "axial.crown_um=1",
        "axial.hub_tilt_inertia_kg_m2=1e-4", "axial.slices=15")  # fmt: skip
    assert force == pytest.approx([0.0, 20.0], abs=1e-3) and hub[0] == pytest.approx(0.0, abs=1e-8)
