"""The whole bearing with tilted rollers at rest: elastic bodies, and the method of ISO/TS 16281."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.rating.equilibria import TiltedPitch, tilted_pitch
from fem.solver.start import narrow_slices
from fem.statics.exact_statics import exact_statics, kept_contacts
from lagrange.axial import Axial
from lagrange.axial.facts import Profile
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import contact_laws
from lagrange.kinematics import roller_angles
from lagrange.rating.life import Dimensions
from lagrange.rating.reference_life import rigid_loads
from lagrange.rating.sources import Unavailable
from lagrange.statics import Placement, TiltedStatics, tilted_equilibrium
from lagrange.tilt import HubTilt, sliced_laws
from tests.reference.bearings import LOAD, ON_A_ROLLER, operation, paper

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
