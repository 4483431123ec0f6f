"""The contact law below the grid: finite elements plus law give the exact approach wherever the contact sits."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from scipy.integrate import quad
from scipy.interpolate import BSpline

from fem.contacts.patch import disc_patch_force, disc_patch_traction, patch, ring_patch_force, ring_patch_traction
from fem.contacts.subgrid import disc_surface_compliance, rigid_surface, ring_surface_compliance, shear_level
from fem.elastic.bodies import disc_body
from fem.elastic.continuum import ring_hertz_approach
from fem.elastic.tangential import disc_stick_approach, ring_stick_approach
from fem.kernels.jit import OPTIONS
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import count_from
from fem.kernels.law import STEEPEST, contact_force, ripple_at, with_seam
from fem.kernels.patches import N_NODES, ONE, weights
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import DiscSurface, Patches, RingSurface
from fem.kernels.surfaces import put_down, read
from lagrange import Material
from meshes import Disc
from tests.reference.bearings import LENGTH, STEEL, disc, model, paper, ring
from tests.reference.compiled import kick_force, next_force, place, stored_energy, weight_slopes
from tests.reference.line_contact import half_width, squeezed_disc_approach
from tests.verification.contact_statics import POSITIONS, law_on_rigid, squeezed

RADIUS = 0.005
CALIBRATED_AT = 5e-5  # half-width b, m, as `fem.contacts.subgrid` does for this roller
FORCES = np.array([100.0, 200.0, 400.0, 628.0, 800.0, 1000.0])
MODULUS = 210e9 / (1.0 - 0.3**2)


@pytest.mark.parametrize("layers", [3, 5, 10])
def test_a_squeezed_disc_has_johnsons_approach_at_every_position(layers):
    body = disc(RADIUS, layers)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    law = law_on_rigid(surface, RADIUS)
    positions = np.array(POSITIONS) * layers / 5.0
    grid = np.array([squeezed(body, surface, position) for position in positions])
    for force in FORCES:
        q = force / LENGTH
        b = half_width(q, RADIUS, MODULUS)
        assert law.pair.half_width(force) == pytest.approx(b, rel=1e-12)
        found = grid * force + law.approach(force)
        # Johnson's formula is the limit b << R; its next term is O(b/R) of a bracket of about 14, 0.05 % at b/R = 0.013
        np.testing.assert_allclose(found, squeezed_disc_approach(q, RADIUS, b, MODULUS), rtol=1e-3)
        # measured spread 1e-4: between its knots the ripple's spline is off by h⁴ of a short wave
        assert np.ptp(found) < 5e-4 * found.mean()
    # without the ripple the same contact is softer at some places than at others
    assert surface.spread > 5e-3


def test_the_calibration_holds_for_other_half_widths():
    body = disc(RADIUS, 5)
    laws = [
        law_on_rigid(disc_surface_compliance(body, LENGTH, b), RADIUS) for b in (CALIBRATED_AT, CALIBRATED_AT / 10.0)
    ]
    # the O(b/R) that is left out, 0.3 b/R of a bracket of about 2
    assert laws[0].B == pytest.approx(laws[1].B, abs=0.01)
    assert laws[0].A == laws[1].A == pytest.approx(2.0 / (np.pi * MODULUS * LENGTH), rel=1e-14)


@pytest.mark.parametrize("held_inside", [True, False])
@pytest.mark.parametrize("scale", [1, 2])
def test_a_held_ring_has_the_exact_approach_at_every_position(held_inside, scale):
    body = (
        ring(0.0125, 0.018, 56 * scale, 3 * scale, True)
        if held_inside
        else ring(0.028, 0.0325, 88 * scale, 2 * scale, False)
    )
    surface = ring_surface_compliance(body, LENGTH, CALIBRATED_AT)
    loaded, held = (0.018, 0.0125) if held_inside else (0.028, 0.0325)
    law = law_on_rigid(surface, loaded)
    force = 500.0
    for position in (0.0, 0.19, 0.5, 7.7, body.n_sectors - 0.4):
        load = ring_patch_force(body, 2.0 * np.pi * position / body.n_sectors)
        grid = np.vdot(load, body.held(load)) + ripple_at(np.mod(position, 1.0), surface.ripple)[0]
        exact = ring_hertz_approach(loaded, held, STEEL, law.pair.half_width(force)) / LENGTH
        # b differs fourfold from the calibration's; O(b/R)
        assert grid * force + law.approach(force) == pytest.approx(exact * force, rel=1e-3)


def missing_shear(surface, radius, force):
    """What the mesh lacks of a contact's tangential compliance, m/N, against a rigid plane."""
    pair = law_on_rigid(surface, radius).pair
    return surface.unit * (shear_level(surface, rigid_surface(1.0), pair) - 0.5 * np.log(force)), pair.half_width(force)


@pytest.mark.parametrize("layers", [3, 5, 10])
def test_a_disc_that_sticks_has_the_exact_tangential_compliance_at_every_position(layers):
    body = disc(RADIUS, layers)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    for force in (30.0, 628.0):
        below, b = missing_shear(surface, RADIUS, force)
        exact = disc_stick_approach(RADIUS, STEEL, b) / LENGTH
        found = []
        for position in np.array(POSITIONS) * layers / 5.0:
            load = disc_patch_traction(body, 2.0 * np.pi * position / body.shape.surface_nodes)
            found.append(float(load @ body.relaxed(load)) + below)
        # the mesh is softer at some places than at others, which the level, a mean, does not follow
        np.testing.assert_allclose(found, exact, rtol=0.012)
        assert np.mean(found) == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize("held_inside", [True, False])
def test_a_ring_that_sticks_has_the_exact_tangential_compliance_at_every_position(held_inside):
    body = ring(0.0125, 0.018, 56, 3, True) if held_inside else ring(0.028, 0.0325, 88, 2, False)
    loaded, held = (0.018, 0.0125) if held_inside else (0.028, 0.0325)
    below, b = missing_shear(ring_surface_compliance(body, LENGTH, CALIBRATED_AT), loaded, 500.0)
    exact = ring_stick_approach(loaded, held, STEEL, b) / LENGTH
    for position in (0.0, 0.19, 0.5, 7.7, body.n_sectors - 0.4):
        load = ring_patch_traction(body, 2.0 * np.pi * position / body.n_sectors)
        assert np.vdot(load, body.held(load)) + below == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("angle", [0.0, 1.234, -2.5])
def test_a_patchs_traction_has_the_force_and_the_moment_of_one_on_the_circle(angle):
    body, along = disc(RADIUS, 3), np.array([-np.sin(angle), np.cos(angle)])
    load = disc_patch_traction(body, angle).reshape(-1, 2)
    np.testing.assert_allclose(load.sum(axis=0), along, atol=1e-14)
    moment = np.sum(body.points[:, 0] * load[:, 1] - body.points[:, 1] * load[:, 0])
    assert moment == pytest.approx(RADIUS, rel=1e-12)
    hoop = ring(0.0125, 0.018, 56, 3, True)
    load = ring_patch_traction(hoop, angle)
    np.testing.assert_allclose(hoop.cartesian(load).sum(axis=0), along, atol=1e-14)
    assert load[:, 1].sum(axis=1) @ hoop.radii == pytest.approx(0.018, rel=1e-12)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_the_law_scales_with_modulus_and_length(factor):
    body = disc(RADIUS, 3)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    soft = replace(STEEL, youngs_modulus=factor * 210e9)
    other = disc_surface_compliance(
        replace(body, material=soft, stiffness=factor * body.stiffness), LENGTH, CALIBRATED_AT
    )
    assert other.missing == pytest.approx(surface.missing / factor, rel=1e-9)
    assert other.unit == pytest.approx(surface.unit / factor, rel=1e-14)
    assert law_on_rigid(other, RADIUS, soft).pair.half_width_factor * factor == pytest.approx(
        law_on_rigid(surface, RADIUS).pair.half_width_factor, rel=1e-12
    )


def test_similar_rollers_have_similar_laws():
    """Twice the size at the same length: the same compliance, half-widths larger by the square root of two."""
    small, large = disc(RADIUS, 4), disc_body(Disc(radius=2.0 * RADIUS, layers=4), STEEL, LENGTH)
    laws = [
        law_on_rigid(disc_surface_compliance(body, LENGTH, 0.01 * body.shape.radius), body.shape.radius)
        for body in (small, large)
    ]
    assert laws[1].A == laws[0].A
    # ln b enters with b²/Q = 2 R A: at the same Q/R the approach over Q is the same
    assert laws[1].B == pytest.approx(laws[0].B + 0.5 * np.log(2.0), abs=1e-9)


def test_poissons_ratio_matters_only_through_the_plane_strain_modulus_in_johnsons_formula():
    material = Material(youngs_modulus=100e9, poisson_ratio=0.2, density=3000.0)
    body = disc(RADIUS, 5, material)
    surface = disc_surface_compliance(body, LENGTH, CALIBRATED_AT)
    law, force = law_on_rigid(surface, RADIUS, material), 300.0
    modulus = 100e9 / (1.0 - 0.04)
    b = half_width(force / LENGTH, RADIUS, modulus)
    wanted = squeezed_disc_approach(force / LENGTH, RADIUS, b, modulus)
    assert squeezed(body, surface, 1.2) * force + law.approach(force) == pytest.approx(wanted, rel=1e-3)


def laws():
    whole = model(paper(), 2e-3)
    return {"inner": whole.inner_law, "outer": whole.outer_law, "roller": whole.roller_law}


every_law = pytest.mark.parametrize("name", ["inner", "outer", "roller"])


@every_law
def test_contact_force_inverts_the_approach(name):
    law = laws()[name]
    for force in np.concatenate([np.geomspace(1e-9, 0.999, 40) * law.Q_line, law.Q_line * np.array([1.0, 1.5, 30.0])]):
        approach = float(law.approach(force))
        for guess in (0.0, force, 0.1 * force, 7.0 * force, 1e9):
            # Newton stops at 1e-14 of Q; dQ/Q = dδ/δ times at most 3 (bracket over bracket − ½)
            assert contact_force(approach, law.A, law.B, law.Q_line, guess) == pytest.approx(force, rel=3e-13)
        assert law.force(approach) == pytest.approx(force, rel=3e-13)


@every_law
def test_the_next_force_inverts_the_approach_and_level_whatever_the_last_was(name):
    """Tiny, usual and wild changes, with the ripple moving too; forces above Q_line and contacts that open or close."""
    law, rng = laws()[name], np.random.default_rng(5)
    forces = np.concatenate([np.geomspace(1e-9, 0.999, 20) * law.Q_line, law.Q_line * np.array([1.0, 1.5, 30.0])])
    for before in forces:
        for change in (0.0, 1e-12, 1e-6, -1e-3, 0.05, -0.3, 1.0, 40.0):
            level_before, level = law.B + 0.05 * rng.uniform(-1.0, 1.0, 2)
            known = stored_approach(law, before, level_before)
            force = before * (1.0 + change)
            approach = stored_approach(law, force, level)
            found = next_force(approach, law.A, level, law.Q_line, before, known, level_before)
            assert found == pytest.approx(force, rel=1e-12)
            for unknown in ((0.0, np.nan), (0.0, -1e-6)):
                found = next_force(approach, law.A, level, law.Q_line, *unknown, level_before)
                assert found == pytest.approx(force, rel=1e-12)
            assert next_force(-1e-9, law.A, level, law.Q_line, before, known, level_before) == 0.0
        assert np.isnan(next_force(np.nan, law.A, law.B, law.Q_line, before, known, level_before))


def stored_approach(law, force, level):
    """δ = A Q (B − ½ ln Q), and the straight line above Q_line, m."""
    q = min(force, law.Q_line)
    bracket = level - 0.5 * np.log(q)
    return law.A * (q * bracket + (force - q) * (bracket - 0.5))


@every_law
def test_contact_never_pulls(name):
    law = laws()[name]
    for approach in (0.0, -1e-20, -1e-6, -1.0):
        assert law.force(approach) == 0.0
    assert stored_energy(0.0, law.A, law.B, law.Q_line) == 0.0


@every_law
def test_contact_energy_is_the_integral_of_the_force(name):
    law = laws()[name]
    for top in (0.01 * law.Q_line, 0.5 * law.Q_line, 2.0 * law.Q_line):
        closing = float(law.approach(top))
        corner = min(closing, float(law.approach(law.Q_line)))
        wanted = quad(law.force, 0.0, corner, epsrel=1e-11)[0] + quad(law.force, corner, closing, epsrel=1e-11)[0]
        assert stored_energy(top, law.A, law.B, law.Q_line) == pytest.approx(wanted, rel=1e-8)


@every_law
@pytest.mark.parametrize("ripple", [-0.05, 0.0, 0.05])
def test_the_law_has_one_potential_wherever_the_contact_sits(name, ripple):
    """Also above Q_line, where a heavy impact may come: force is the slope of energy in approach, ½ A Q² that in B."""
    law = laws()[name]
    level = law.B + ripple

    def force(approach, level):
        return contact_force(approach, law.A, level, law.Q_line, 0.0)

    def energy(approach, level):
        return stored_energy(force(approach, level), law.A, level, law.Q_line)

    at_line = law.A * law.Q_line * (level - 0.5 * np.log(law.Q_line))
    assert force(at_line * (1.0 - 1e-12), level) == pytest.approx(force(at_line * (1.0 + 1e-12), level), rel=1e-10)
    for approach in at_line * np.array([0.01, 0.5, 0.99, 1.01, 1.5, 3.0]):
        Q, step = force(approach, level), 1e-4 * approach
        slope = (energy(approach + step, level) - energy(approach - step, level)) / (2.0 * step)
        assert slope == pytest.approx(Q, rel=1e-6)
        in_level = (energy(approach, level + 1e-5) - energy(approach, level - 1e-5)) / 2e-5
        assert in_level == pytest.approx(-0.5 * law.A * Q**2, rel=1e-6)


@every_law
def test_the_straight_line_continues_value_and_slope(name):
    law = laws()[name]
    step = 1e-6 * law.Q_line
    below, at, above = law.approach(law.Q_line + step * np.array([-1.0, 0.0, 1.0]))
    assert law.A * law.Q_line * (law.B - 0.5 * np.log(law.Q_line)) == pytest.approx(float(at), rel=1e-13)
    slope = law.A * STEEPEST
    # one-sided differences: error step · A/(4 Q), 1e-6 of the slope; and the round-off 1e-16/1e-6
    assert (at - below) / step == pytest.approx(slope, rel=1e-5)
    assert (above - at) / step == pytest.approx(slope, rel=1e-8)


@every_law
def test_stiffness_is_the_slope_of_the_force(name):
    law = laws()[name]
    for force in law.Q_line * np.array([1e-6, 1e-3, 0.3, 1.2]):
        step = 1e-5 * float(law.approach(force))
        slope = (law.force(law.approach(force) + step) - law.force(law.approach(force) - step)) / (2.0 * step)
        assert law.stiffness(force) == pytest.approx(slope, rel=1e-8)


def bounce(law, mass, speed, dt, gap, force_of_a_kick):
    """Speed, m/s, at which a point mass thrown at the law comes back."""
    position, velocity = -gap, speed
    before, Q_before, P, owed = np.nan, 0.0, 0.0, 0.0
    while position > -2.0 * gap or velocity > 0.0:
        Q = law.force(position)
        P, owed = force_of_a_kick(before, Q_before, law.B, P, owed, position, Q, law.B, law.A, law.Q_line)
        velocity -= dt / mass * P
        before, Q_before = position, Q
        position += dt * velocity
    return -velocity


def plain(before, Q_before, B_before, P_before, owed, now, Q, B, A, Q_line):
    return Q, 0.0


def test_a_mass_bounces_off_with_nearly_the_speed_it_came_with():
    """Steps of 1/10 ... 1/80 of the time to the nearest point, beginning anywhere: fourth order and without a jump."""
    law, mass, speed = laws()["inner"], 0.006, 0.1
    counts, lost, usual = np.array([10.0, 20.0, 40.0, 80.0]), [], []
    for count in counts:
        dt = 0.5 * np.pi * np.sqrt(mass / law.stiffness(200.0)) / count
        gaps = speed * dt * (3.0 + np.linspace(0.0, 0.9, 10))
        away = np.array([bounce(law, mass, speed, dt, gap, kick_force) for gap in gaps])
        lost.append(1.0 - away / speed)
        usual.append(1.0 - np.array([bounce(law, mass, speed, dt, gap, plain) for gap in gaps]) / speed)
    lost, usual = np.array(lost), np.array(usual)
    assert np.polyfit(np.log(counts), np.log(lost.mean(axis=1)), 1)[0] == pytest.approx(-4.0, abs=0.2)
    assert np.all(np.abs(lost).max(axis=1) < 0.003 * np.abs(usual).max(axis=1))
    assert lost[0].max() < 5e-6


@pytest.mark.parametrize("dt", [3e-7, 3e-5], ids=["light", "beyond the line"])
@pytest.mark.parametrize("inwards", [True, False], ids=["closing", "opening"])
def test_at_constant_speed_kicks_add_up_to_the_true_impulse(inwards, dt):
    """The half of a kick that looks back and the half of the one before that looks ahead, step by step."""
    law, speed = laws()["inner"], 1.0
    approach = (speed * dt * (np.arange(-4, 8) + 0.31))[:: 1 if inwards else -1]
    force = np.array([law.force(x) for x in approach])
    kicks = []
    for i in range(1, len(approach)):
        last = approach[i - 1], force[i - 1], law.B, force[i - 1], 0.0  # nothing owed, so nothing is given back
        kicks.append(kick_force(*last, approach[i], force[i], law.B, law.A, law.Q_line)[0])
    kicks = np.array(kicks)
    impulse = dt * (0.5 * force[0] + np.sum(kicks) - 0.5 * force[-1])
    assert impulse == pytest.approx(stored_energy(force.max(), law.A, law.B, law.Q_line) / speed, rel=1e-9)
    assert (kicks.min() < 0.0) != inwards  # the first after an opening takes back what the one before gave too much
    assert np.all(kicks[approach[1:] > 0.0] > 0.0)


def test_the_line_lies_far_above_the_papers_loads_at_its_mesh():
    whole = model(paper(), 1e-3)
    assert min(whole.inner_law.Q_line, whole.outer_law.Q_line) > 10.0 * 628.5


def test_hertz_pressure_of_the_papers_inner_contact():
    """Q = 628 N: b = 52.1 µm and p₀ = 768 MPa inside, 65 µm outside (Johnson 1985, section 4.2)."""
    whole = model(paper(), 2e-3)
    assert 1e6 * whole.inner_law.pair.half_width(628.0) == pytest.approx(52.1, abs=0.05)
    assert 1e6 * whole.outer_law.pair.half_width(628.0) == pytest.approx(65.0, abs=0.5)
    assert 1e-6 * whole.inner_law.pair.peak_pressure(628.0) == pytest.approx(768.0, abs=0.5)
    assert whole.inner_law.pair.peak_pressure(0.0) == 0.0


# the patch ------------------------------------------------------------------------------------------------------


FRACTIONS = np.append(np.linspace(0.0, 1.0, 41)[:-1], np.nextafter(1.0, 0.0))


def weights_at(t):
    return np.array(weights(t))


def slopes_at(t):
    return np.array(weight_slopes(t))


def test_weights_are_schoenbergs_quintic_spline():
    spline = BSpline.basis_element(np.arange(7) - 3.0, extrapolate=False)
    for t in FRACTIONS:
        offset = np.arange(N_NODES) - 2 - t
        np.testing.assert_allclose(weights_at(t), np.nan_to_num(spline(offset)), rtol=0.0, atol=1e-15)


def test_weights_sum_to_one_and_have_the_moments_of_a_smooth_kernel():
    first_four = []
    for t in FRACTIONS:
        weight, offset = weights_at(t), np.arange(N_NODES) - 2 - t
        assert weight.min() >= 0.0
        assert weight.sum() == pytest.approx(1.0, abs=3e-16)
        assert weight @ offset == pytest.approx(0.0, abs=5e-16)
        first_four.append([weight @ offset**k for k in range(2, 6)])
    # second ... fifth moment do not depend on where between the nodes the patch sits
    np.testing.assert_allclose(first_four, np.tile([0.5, 0.0, 0.7, 0.0], (len(FRACTIONS), 1)), atol=2e-14)


def test_weight_slopes_are_the_derivatives_of_the_weights():
    step = 1e-5  # central difference: step² · W‴/6 = 2e-11, round-off 1e-16/1e-5 = 1e-11
    for t in np.linspace(0.05, 0.95, 19):
        difference = (weights_at(t + step) - weights_at(t - step)) / (2.0 * step)
        np.testing.assert_allclose(slopes_at(t), difference, rtol=0.0, atol=1e-10)
        assert slopes_at(t).sum() == pytest.approx(0.0, abs=3e-16)


def test_nothing_happens_when_a_node_passes():
    end = 1.0
    np.testing.assert_allclose(weights_at(end)[1:], weights_at(0.0)[:-1], atol=1e-16)
    np.testing.assert_allclose(slopes_at(end)[1:], slopes_at(0.0)[:-1], atol=1e-16)
    assert weights_at(end)[0] == weights_at(0.0)[-1] == 0.0


@pytest.mark.parametrize("n", [18, 56])
def test_a_direction_gets_its_place_among_the_nodes(n):
    for position in (0.0, 0.25, n / 2.0, n - 0.5, n - 1e-9):
        angle = 2.0 * np.pi * position / n
        found = place(0.3 * np.cos(angle), 0.3 * np.sin(angle), n)
        assert min(abs(found - position), n - abs(found - position)) < 1e-13 * n
        assert 0.0 <= found < n
    for tiny in (1e-300, 1e-20, 1e-16):  # just below the first node: adding n rounds up to n
        assert 0.0 <= place(1.0, -tiny, n) < n


def test_patches_wrap_round_the_body():
    nodes, weight, offset = patch(18, 2.0 * np.pi * 17.4 / 18.0)
    assert nodes.tolist() == [15, 16, 17, 0, 1, 2]
    assert weight @ offset == pytest.approx(0.0, abs=1e-15)


ANGLES = np.array([0.0, 0.37, 2.0, -0.01, -3.0, np.pi, -1.6, 1.234])  # of eight contacts, read at once
GROUP, COLUMNS = 8, 16


@njit(**OPTIONS)
def read_group(surface, patches, bx, by, out):
    for component, b in enumerate((bx, by)):
        store(patches.outward, (2 + component) * COLUMNS + GROUP, load(b, 0))
    put_down(surface, patches, 1, GROUP)
    found = read(surface, patches, 1, GROUP, count_from(GROUP))
    for k in range(5):
        store(out, 8 * k, found[k])


def some_patches():
    weight, along, across, traction_x, traction_y, lightness = (np.zeros((2, N_NODES, COLUMNS)) for _ in range(6))
    position, beyond = np.zeros((2, COLUMNS)), np.zeros((2, COLUMNS))
    return Patches(
        normal=np.zeros((1, 2, COLUMNS)), start=np.zeros((2, COLUMNS), dtype=np.int64), position=position,
        beyond=beyond, motion=np.zeros((2, 5, COLUMNS)), place=np.zeros((2, N_NODES, COLUMNS), dtype=np.int64),
        weight=weight, outward=np.zeros((2, 2, COLUMNS)), along=along, across=across, traction_x=traction_x,
        traction_y=traction_y, lightness=lightness, columns=COLUMNS, units=ONE,
    )  # fmt: skip


def test_kernels_and_matrices_use_the_same_roller_patches():
    body = disc(RADIUS, 3)
    u = np.random.default_rng(1).standard_normal((body.n_nodes, 2, COLUMNS))
    ripples = np.random.default_rng(2).standard_normal(3 * 8)
    surface = DiscSurface(
        u=u.ravel(), w=u.ravel(), points=body.points.ravel(), lightness=np.ones(body.n_nodes + 8),
        impulse=np.zeros((2, COLUMNS)), ripple=with_seam(ripples), first=body.first_surface_node,
        n_nodes=body.shape.surface_nodes, columns=COLUMNS, radius=RADIUS,
    )  # fmt: skip

    def read(at):
        out = np.zeros((5, 8))
        read_group(surface, some_patches(), np.cos(at), np.sin(at), out)
        return out

    out, side, rate, ripple, ripple_rate = read(ANGLES)
    step = 1e-6
    ahead, behind = read(ANGLES + step), read(ANGLES - step)
    for j, angle in enumerate(ANGLES):
        mine = u[:, :, GROUP + j].ravel()
        along = disc_patch_force(body, angle)
        assert out[j] == pytest.approx(along @ mine, abs=1e-14)
        across = np.einsum("ab,nb->na", [[0.0, -1.0], [1.0, 0.0]], along.reshape(-1, 2)).ravel()
        assert side[j] == pytest.approx(across @ mine, abs=1e-14)
        position = np.mod(angle * 18.0 / (2.0 * np.pi), 18.0)
        assert ripple[j] == pytest.approx(ripple_at(position, ripples)[0], abs=1e-12)
    # out turns with the direction as well: d(U·b)/ds = dU/ds·b + U·Jb
    np.testing.assert_allclose(rate + side, (ahead[0] - behind[0]) / (2.0 * step), rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(ripple_rate, (ahead[3] - behind[3]) / (2.0 * step), rtol=1e-5, atol=1e-5)


def test_kernels_and_matrices_use_the_same_ring_patches():
    body = ring(0.0125, 0.018, 56, 3, True)
    u = np.random.default_rng(3).standard_normal((body.n_rows, 2, body.n_sectors))
    padded = np.ascontiguousarray(np.concatenate([u[..., -HALO:], u, u[..., :HALO]], axis=-1))
    ripples = np.random.default_rng(4).standard_normal(8)
    sector = 2.0 * np.pi * (np.arange(56 + 2 * HALO) - HALO) / 56
    surface = RingSurface(
        u=padded, w=padded, cosines=np.cos(sector), sines=np.sin(sector), ripple=with_seam(ripples),
        row=body.raceway_row, n_nodes=56, node_mass=1.0, radius=0.018,
    )  # fmt: skip

    def read(at):
        out = np.zeros((5, 8))
        read_group(surface, some_patches(), np.cos(at), np.sin(at), out)
        return out

    out, side, rate, ripple, ripple_rate = read(ANGLES)
    step = 1e-6
    ahead, behind = read(ANGLES + step), read(ANGLES - step)
    for j, angle in enumerate(ANGLES):
        along = ring_patch_force(body, angle)
        assert out[j] == pytest.approx(np.vdot(along, u), abs=1e-13)
        turned = np.stack([-along[:, 1], along[:, 0]], axis=1)
        assert side[j] == pytest.approx(np.vdot(turned, u), abs=1e-13)
        position = np.mod(angle * 56.0 / (2.0 * np.pi), 1.0)
        assert ripple[j] == pytest.approx(ripple_at(position, ripples)[0], abs=1e-10)
    np.testing.assert_allclose(rate + side, (ahead[0] - behind[0]) / (2.0 * step), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(ripple_rate, (ahead[3] - behind[3]) / (2.0 * step), rtol=1e-5, atol=1e-4)


def test_the_ripple_goes_through_its_samples_and_is_smooth():
    surface = disc_surface_compliance(disc(RADIUS, 3), LENGTH, CALIBRATED_AT)
    period = surface.ripple.size / 8.0
    assert period == 3.0
    value = np.array([ripple_at(x, surface.ripple) for x in np.linspace(0.0, 18.0, 18 * 40 + 1)])
    np.testing.assert_allclose(value[: 3 * 40], value[3 * 40 : 6 * 40], atol=1e-9 * np.abs(value).max())
    assert np.abs(value[: 3 * 40 : 5, 0].mean()) < 1e-12 * np.abs(value[:, 0]).max()  # at the knots, zero mean
    step = 1e-6
    for x in (0.3, 1.0, 2.999, 17.9):
        difference = (ripple_at(x + step, surface.ripple)[0] - ripple_at(x - step, surface.ripple)[0]) / (2.0 * step)
        assert ripple_at(x, surface.ripple)[1] == pytest.approx(difference, rel=1e-6, abs=1e-18)
