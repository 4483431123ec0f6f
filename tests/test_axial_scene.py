"""[axial] in scenes: profiles by name and from files, and what does not fit."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.interface import simulate
from fem.pictures.axial import axial_pressures, draw_axial
from fem.pictures.output import refuse_foreign
from fem.pictures.recover import StoredRun
from fem.rating.equilibria import TiltedPitch, tilted_pitch
from fem.solver.start import narrow_slices
from fem.statics.exact_statics import exact_statics, kept_contacts
from fem.statics.tilted_pressures import scene_slices
from lagrange.axial import Axial
from lagrange.axial.pressure import placed
from lagrange.axial.slices import Profile, logarithmic_drop, read_slices, write_slices
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import contact_laws
from lagrange.errors import UsageError
from lagrange.files.hdf5 import Damaged, hdf5_to_write
from lagrange.kinematics import roller_angles
from lagrange.motion import HubTilt, sliced_laws
from lagrange.rating.life import Dimensions
from lagrange.rating.reference_life import rigid_loads
from lagrange.rating.sources import Unavailable
from lagrange.scene import Scene, read_scene
from lagrange.scene.faults import SceneError
from lagrange.scene.scene import parse_scene_text
from lagrange.statics import Placement, TiltedStatics, tilted_equilibrium
from tests.reference.kit import LOAD, ON_A_ROLLER, operation, paper


def test_a_scene_without_the_table_is_a_plane_section():
    assert Scene().ideal_axial() is None
    assert "axial" not in Scene().to_toml()


def test_a_profile_is_read_from_a_file_and_kept_with_the_run(tmp_path):
    (tmp_path / "drops.csv").write_text("z_mm,drop_um\n-5,12\n-2,2\n0,2\n2,2\n5,22\n")
    (tmp_path / "scene.toml").write_text('[axial]\nroller_profile = "drops.csv"\nslices = 5\n')
    scene = read_scene(tmp_path / "scene.toml")
    bearing = scene.perfect_bearing()
    drops = scene.ideal_axial().drops(bearing)  # slices at -4, -2, 0, 2, 4 mm; the least drop is 0
    assert 1e6 * drops == pytest.approx(np.array([[20 / 3, 0.0, 0.0, 0.0, 40 / 3]] * 2))
    again = parse_scene_text(scene.to_toml(), "run", scene.files)
    assert again.ideal_axial() == scene.ideal_axial()


def test_profiles_fall_off_as_their_formulas_say():
    scene = Scene(axial={"roller_profile": "crowned", "inner_raceway_profile": "lundberg", "crown_um": 8.0,
                         "lundberg_load_N": 1000.0, "slices": 3})  # fmt: skip
    inner, outer = scene.ideal_axial().drops(scene.perfect_bearing())
    crown = 8e-6 * (2.0 / 3.0) ** 2
    assert outer == pytest.approx([crown, 0.0, crown])
    lundberg = 1000.0 / (np.pi * 115.3846e9 * 0.01) * np.log(1.0 / (1.0 - (2.0 / 3.0) ** 2))
    assert inner == pytest.approx([crown + lundberg, 0.0, crown + lundberg], rel=1e-5)


def test_long_rollers_are_straight_in_their_middle():
    x = np.array([0.0, 10.0, 19.0])
    edge = 0.0005 * 8.0 * np.log(1.0 / (1.0 - (18.0 / 20.0) ** 2))
    assert logarithmic_drop(x, 40.0, 8.0) == pytest.approx([0.0, 0.0, edge])


def test_rollers_of_just_the_limit_s_length_have_the_profile_of_short_ones():
    """L = 2.5 D as it is typed, whatever the rounding of metres: the long rollers' formula drops 1.43 times as much."""
    for diameter in np.round(np.arange(8.0, 14.0, 0.1), 1).tolist():
        sizes = {"roller_diameter_mm": diameter, "inner_raceway_diameter_mm": 60.0, "outside_diameter_mm": 120.0}
        bearing = sizes | {"roller_length_mm": round(2.5 * diameter, 9), "clearance_um": 0.0}
        scene = Scene(bearing=bearing, axial={"slices": 3})
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
    for k in range(30):  # a run of one interval
        Scene(numerics={"duration_ms": round(0.01 + 0.0007 * k, 4), "output_interval_us": round(10.0 + 0.7 * k, 1)})
    rows = "".join(f"{60 + 0.001 * k:.3f},1000\n" for k in range(30))
    (tmp_path / "speeds.csv").write_text(f"time_ms,speed_rpm\n0,1000\n{rows}")
    (tmp_path / "scene.toml").write_text('[operation]\nspeed_table = "speeds.csv"\n')
    assert read_scene(tmp_path / "scene.toml").operation.speed_rpm == 1000.0


@pytest.mark.parametrize(
    "tables, words",
    [
        ({"axial": {"roller_profile": "crowned"}}, "needs crown_um"),
        ({"axial": {"crown_um": 3.0}}, 'only with a profile that is "crowned"'),
        ({"axial": {"ring_width_mm": 8.0}}, "at least bearing.roller_length_mm = 10"),
        ({"axial": {"shaft_tilt_stiffness_N_m_rad": 10.0}}, "give hub_tilt_inertia_kg_m2"),
        ({"operation": {"misalignment_mrad": 1.0}}, "operation.misalignment_mrad = 1: needs an [axial] table"),
        ({"axial": {}, "model": "lagrange", "bearing": {"type": "ball"}}, "[axial]: only for rollers"),
        ({"spall": [{"length_mm": 5.0}]}, "spall.0.length_mm = 5: needs an [axial] table"),
        ({"spall": [{"z_mm": 2.0}]}, "give length_mm too"),
        (
            {"axial": {}, "model": "reduced", "spall": [{"length_mm": 9.9}]},
            "goes over all middles of axial.slices = 21",
        ),
        ({"axial": {}, "model": "reduced", "spall": [{"length_mm": 2.0, "z_mm": 6.0}]}, "goes over no middles"),
        (
            {"axial": {}, "model": "reduced", "spall": [{"length_mm": 2.0}, {"length_mm": 3.0, "angle_deg": 90.0}]},
            "takes other slices of contacts with the outer_ring than spall.0",
        ),
    ],
)
def test_what_does_not_fit_is_named(tables, words):
    with pytest.raises(SceneError) as raised:
        Scene(**tables)
    assert words in str(raised.value)


def test_a_table_of_drops_that_is_none_is_refused(tmp_path):
    (tmp_path / "drops.csv").write_text("z_mm,drop_um\n-5,12\n-6,2\n5,22\n")
    (tmp_path / "scene.toml").write_text('[axial]\nroller_profile = "drops.csv"\n')
    with pytest.raises(SceneError, match="must rise from row to row: after -5 comes -6"):
        read_scene(tmp_path / "scene.toml")
    (tmp_path / "drops.csv").write_text("z_mm,drop_um\n-5,12\n0,0\n5,1e308\n")
    with pytest.raises(SceneError, match=r"drop_um = 1e\+308: at most 100000 either way"):
        read_scene(tmp_path / "scene.toml")
    (tmp_path / "drops.csv").write_text("z_mm,drop_um\n-3,12\n0,0\n3,22\n")
    with pytest.raises(SceneError, match="slices of rollers of 10 mm have their middles from"):
        read_scene(tmp_path / "scene.toml")


# Pressures along the rollers of a run, from the forces and moments that its file holds


SCENE = {"model": "reduced", "operation": {"misalignment_mrad": 1.0}, "numerics": {"duration_ms": 0.0}}


@pytest.fixture(scope="module")
def stored(tmp_path_factory) -> StoredRun:
    path = tmp_path_factory.mktemp("tilted") / "run.nc"
    simulate(Scene(**SCENE, axial={"slices": 11})).save(path)
    return StoredRun(path)


@pytest.mark.slow  # a run's time loop is compiled for it
def test_a_file_gives_the_pressures_of_the_statics(stored, tmp_path):
    found = axial_pressures(stored, 0)
    bearing, axial = stored.scene.perfect_bearing(), stored.scene.ideal_axial()
    acting = stored.scene.ideal_operation()
    _, inner, _ = tilted_pitch(bearing, axial, acting, samples=1).pressures()
    assert found.pressure[0].max() == pytest.approx(inner.max(), rel=0.01)
    at = int(found.pressure[0].max(axis=1).argmax())
    assert found.slope[0, at] == pytest.approx(-0.5e-3, abs=5e-5)
    assert found.pressure[0, at] @ found.place > 0.0  # its +z end is pressed
    draw_axial(stored, tmp_path / "axial.png", 0)
    refuse_foreign(tmp_path / "axial.png", force=False)  # the next picture may take its place
    assert (tmp_path / "axial.png").read_bytes().startswith(b"\x89PNG")


def test_a_place_bears_the_force_and_moment_that_it_was_asked_for():
    from lagrange.axial.slices import contact_slices
    from lagrange.contact.laws import contact_laws

    scene = Scene(model="lagrange", axial={"slices": 21})
    bearing = scene.perfect_bearing()
    slices, _ = contact_slices(bearing, scene.ideal_axial(), contact_laws("johnson", bearing))
    approach, slope = placed(slices, 600.0, 1.2)
    sums = slices.sums(np.array([approach]), np.array([slope]))
    assert (sums.force[0], sums.moment[0]) == (pytest.approx(600.0, rel=1e-5), pytest.approx(1.2, rel=1e-4))
    with pytest.raises(ValueError, match="beyond"):
        placed(slices, 600.0, 6.0)


def test_a_file_keeps_the_slices_of_elastic_bodies(tmp_path):
    scene = Scene(model="reduced", axial={"slices": 11})
    bearing, axial, written = scene.perfect_bearing(), scene.ideal_axial(), scene_slices(scene)
    with hdf5_to_write(tmp_path / "run.nc") as file:
        write_slices(file, written)
    with h5py.File(tmp_path / "run.nc", "r+") as file:
        read = read_slices(file, bearing, axial)
        for own, other in zip(written, read, strict=True):
            assert np.array_equal(own.forces(4e-6, 1e-4), other.forces(4e-6, 1e-4))
        file["outer_slice_compliance"][3, 4] = np.nan
        with pytest.raises(Damaged, match="outer_slice_compliance is no compliance of 11 slices"):
            read_slices(file, bearing, axial)


def test_a_plane_run_is_refused():
    with pytest.raises(UsageError, match="no \\[axial\\]"):
        axial_pressures(SimpleNamespace(scene=Scene(), path="plane.nc"), 0)


# The whole bearing with tilted rollers at rest: elastic bodies, and the method of ISO/TS 16281.


PAPER = paper()


def axial(profile: str, slices: int, coupling: bool) -> Axial:
    return Axial(
        roller=Profile(kind=profile, crown=1e-5), inner_raceway=Profile(), outer_raceway=Profile(), slices=slices,
        coupling=coupling, ring_width=0.02,
    )  # fmt: skip


@cache
def stands(profile: str, slices: int, coupling: bool, mrad: float) -> TiltedPitch:
    """At one angle, a roller in the load's direction."""
    acting = operation(speed=0.0, gravity=0.0, radial_load=LOAD, misalignment=1e-3 * mrad)
    return tilted_pitch(PAPER, axial(profile, slices, coupling), acting, samples=1)


def test_straight_rollers_without_tilt_are_those_of_the_plane_series():
    exact = exact_statics(PAPER, LOAD, ON_A_ROLLER)
    found = stands("none", 21, False, 0.0).statics[0]
    assert -1e6 * found.place[1] == pytest.approx(3.6146, rel=2e-4)
    assert found.inner_force[:4] == pytest.approx([628.5, 549.5, 337.2, 62.9], rel=2e-4, abs=0.05)  # N
    assert found.place[1] == pytest.approx(exact.hub[1], rel=2e-4)
    assert found.inner_force == pytest.approx(exact.inner_force, rel=2e-4, abs=0.1)


@pytest.mark.parametrize(
    "coupling, slices, mrad, hub, moment, pressure, within",
    [
        (False, 41, 0.0, 6.568, 0.0, 1064, 0.005),
        (False, 41, 1.0, 6.205, 1914, 1108, 0.005),
        (False, 41, 2.0, 5.156, 3455, 1202, 0.005),
        (True, 31, 0.0, 6.409, 0.0, 1076, 0.01),
        (True, 31, 1.0, 6.029, 1980, 1126, 0.01),
        (True, 31, 2.0, 4.928, 3571, 1236, 0.01),
    ],
)
def test_profiled_rollers_under_a_slope_of_the_shaft(coupling, slices, mrad, hub, moment, pressure, within):
    """Against an independent prototype: µm, N mm, MPa."""
    found = stands("logarithmic", slices, coupling, mrad)
    assert -1e6 * found.statics[0].place[1] == pytest.approx(hub, rel=within)
    assert 1e3 * found.moment == pytest.approx(moment, rel=within, abs=0.1)
    assert 1e-6 * contact_pairs(PAPER)[0].peak_pressure(found.peaks["inner"]) == pytest.approx(pressure, rel=within)


def test_rollers_that_lift_at_their_ends_under_a_steep_slope_balance_the_load():
    found = stands("crowned", 21, True, 4.0).statics[0]
    angle = roller_angles(PAPER, ON_A_ROLLER)
    assert found.inner_force @ np.sin(angle) == pytest.approx(-LOAD, rel=1e-3)  # along contacts' normals but for 1e-3
    assert found.inner_force == pytest.approx(found.outer_force, abs=1e-2)
    assert 4.0 < found.on_hub[1] < 5.0


def test_a_loaded_edge_has_no_peak_pressure():
    with pytest.raises(Unavailable, match="edge"):
        _ = stands("none", 21, False, 0.0).peaks


def test_a_lundberg_profile_has_a_peak_pressure_under_its_own_load_alone():
    """Under a slope its end is an edge: the peak looked settled, 1215 to 1236 MPa for 15 to 41 slices."""
    relieved = replace(axial("none", 21, True), roller=Profile(kind="lundberg", load=700.0))

    def peak(mrad: float) -> float:
        acting = operation(speed=0.0, gravity=0.0, radial_load=LOAD, misalignment=1e-3 * mrad)
        return tilted_pitch(PAPER, relieved, acting, samples=1).peaks["inner"]

    assert peak(0.0) == pytest.approx(628.5, rel=0.1)
    with pytest.raises(Unavailable, match="edge"):
        peak(1.0)


def test_hub_and_slope_have_the_stiffness_that_a_small_slope_shows():
    found, near = stands("logarithmic", 41, False, 1.0), stands("logarithmic", 41, False, 1.2)
    moved = [found.statics[0].on_hub[1] - near.statics[0].on_hub[1],
             near.statics[0].place[3] - found.statics[0].place[3]]  # fmt: skip
    mean = 0.5 * (found.tilt_stiffness + near.tilt_stiffness)
    assert moved[0] / moved[1] == pytest.approx(mean, rel=0.02)
    whole = 0.5 * (found.stiffness + near.stiffness)  # at constant load the hub goes where both parts cancel
    sideways = near.statics[0].place[1] - found.statics[0].place[1]
    assert sideways / moved[1] == pytest.approx(-whole[1, 3] / whole[1, 1], rel=0.02)
    np.testing.assert_allclose(whole, whole.T, atol=1e-9 * whole.max())


def rigid_rings(profile: str, mrad: float, **free: float) -> TiltedStatics:
    laws = sliced_laws(PAPER, axial(profile, 40, False), contact_laws("iso16281", PAPER))
    acting, hub = (
        operation(speed=0.0, gravity=0.0, radial_load=LOAD),
        HubTilt(slope_x=0.0, slope_y=-1e-3 * mrad, **free),
    )
    start = np.array([0.0, -1e-5]), np.full(PAPER.n_rollers, PAPER.pitch_radius)
    return tilted_equilibrium(PAPER, acting, laws, hub, Placement(roller_angles(PAPER, ON_A_ROLLER)), start)


@pytest.mark.parametrize("profile", ["none", "logarithmic"])
@pytest.mark.parametrize("mrad", [0.0, 1.0, 2.0, 4.0])
def test_rigid_rings_on_slices_are_the_method_of_the_standard(profile, mrad):
    """Its laminae spring with both contacts at once; here a roller finds its own tilt between them."""
    standard = rigid_loads(Dimensions.of(PAPER), LOAD, 0.0, 1e-3 * mrad, profile=profile != "none")
    found = rigid_rings(profile, mrad)
    assert -1e3 * found.place[1] == pytest.approx(standard.displacement, rel=6e-4)
    assert found.inner_force == pytest.approx(standard.of_rollers, rel=1e-3, abs=0.2)
    assert 1e3 * found.on_hub[1] == pytest.approx(standard.moment, rel=1e-3, abs=1e-3)
    half = 0.5 * found.place[3] * np.sin(roller_angles(PAPER, ON_A_ROLLER))
    loaded = found.inner_force > 1.0
    assert 1e3 * found.tilt[loaded] == pytest.approx(1e3 * half[loaded], abs=2e-3)


@pytest.mark.parametrize("profile, stiffness", [(False, 4448), (True, 1926)])
def test_the_standards_spring_against_tilt(profile, stiffness):
    """N m/rad at no slope, the load kept."""
    small = 1e-6
    moment = rigid_loads(Dimensions.of(PAPER), LOAD, 0.0, small, profile=profile).moment
    assert 1e-3 * moment / small == pytest.approx(stiffness, rel=1e-3)


def test_a_shaft_on_a_tilt_spring_finds_the_slope_that_balances_it():
    found = rigid_rings("logarithmic", 1.0, inertia=1e-5, stiffness=2000.0)
    assert -1e-3 < found.place[3] < 0.0
    held = rigid_rings("logarithmic", -1e3 * found.place[3])
    assert held.on_hub[1] == pytest.approx(2000.0 * (1e-3 + found.place[3]), rel=1e-3)


def test_slices_narrower_than_their_contacts_are_refused_with_the_number_that_fits():
    acting = operation(speed=0.0, gravity=0.0, radial_load=20_000.0, misalignment=2e-3)
    for slices in (61, 201):
        with pytest.raises(Unavailable, match=rf"axial.slices = {slices} are .* use at most 1\d"):
            tilted_pitch(PAPER, axial("logarithmic", slices, True), acting)
    tilted_pitch(PAPER, axial("logarithmic", 15, True), acting, samples=1)


def test_a_start_whose_tables_give_a_light_contact_too_large_a_moment_is_checked_too():
    contacts, _ = kept_contacts(PAPER)
    force, arm = np.array([30.0, 0.0]), 0.5e-2  # N, m: half the length

    def reason(times):
        loads = {f"{side}_{name}": times * value for side in ("inner", "outer")
                 for name, value in (("force", force), ("moment", 1.3 * arm * force))}  # fmt: skip
        laws = contacts.inner_law, contacts.outer_law
        return narrow_slices(PAPER, axial("logarithmic", 21, True), laws, SimpleNamespace(**loads))

    assert reason(1.0) is None
    assert "axial.slices = 21 are" in reason(100.0)  # all of it on the last slice


def started(path, *settings: str) -> tuple[np.ndarray, np.ndarray]:
    """Hub and force of the raceways on it at the start of a run, m and N."""
    options = [word for setting in settings for word in ("--set", setting)]
    assert run_main(["--quiet", "--duration", "0", "--output", str(path), *options]) == 0
    with h5py.File(path) as file:
        hub = np.array([file[f"inner_{axis}"][0] for axis in "xy"])
        apart = np.array([file[f"roller_{axis}"][0] for axis in "xy"]) - hub[:, None]
        return hub, -(apart / np.hypot(*apart)) @ file["inner_force"][0]


@pytest.mark.parametrize("clearance, load, mrad", [(30, 50, 1), (50, 1000, 4)])
def test_a_bearing_in_clearance_without_weight_and_speed_stands_on_its_loaded_rollers(tmp_path, clearance, load, mrad):
    """Rollers that bear nothing rest between the raceways; rigid rings on slices have the same hub within 5 %."""
    scene = [
        f"bearing.clearance_um={clearance}", f"operation.radial_load_N={load}", "operation.speed_rpm=0",
        f"operation.misalignment_mrad={mrad}", "operation.gravity_m_s2=0", "axial.slices=11",
    ]  # fmt: skip
    hub, force = started(tmp_path / "reduced.nc", "model=reduced", *scene)
    assert force == pytest.approx([0.0, load], abs=1e-4 * load)
    on_slices, _ = started(tmp_path / "slices.nc", "model=lagrange", *scene)
    assert hub[1] == pytest.approx(on_slices[1], rel=0.05)


def test_a_free_slope_that_no_contact_holds_stays_where_it_is(tmp_path):
    """One roller bears all: about the direction of the load nothing holds the shaft's slope."""
    hub, force = started(
        tmp_path / "run.nc", "model=lagrange", "bearing.clearance_um=30", "operation.radial_load_N=20",
        "operation.speed_rpm=1000", "operation.gravity_m_s2=0", "axial.roller_profile=crowned", "axial.crown_um=1",
        "axial.hub_tilt_inertia_kg_m2=1e-4", "axial.slices=15",
    )  # fmt: skip
    assert force == pytest.approx([0.0, 20.0], abs=1e-3)
    assert hub[0] == pytest.approx(0.0, abs=1e-8)
