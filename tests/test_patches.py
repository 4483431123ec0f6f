"""Patches of nodes that a contact reads and pushes: weights, places, and kernels against matrices."""

import numpy as np
import pytest
from numba import njit
from scipy.interpolate import BSpline

from fem.contacts.points import disc_patch_force, patch, ring_patch_force
from fem.kernels.jit import OPTIONS
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import count_from
from fem.kernels.law import ripple_at, with_seam
from fem.kernels.patches import N_NODES, ONE, weights
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import DiscSurface, Patches, RingSurface
from fem.kernels.surfaces import interpolate_displacement, locate_patch
from tests.reference.bearings import disc, ring
from tests.reference.compiled import place, weight_slopes

RADIUS = 0.005
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
    locate_patch(surface, patches, 1, GROUP)
    found = interpolate_displacement(surface, patches, 1, GROUP, count_from(GROUP))
    for k in range(5):
        store(out, 8 * k, found[k])


def some_patches():
    weight, along, across, traction_x, traction_y, lightness = (np.zeros((2, N_NODES, COLUMNS)) for _ in range(6))
    position, beyond = np.zeros((2, COLUMNS)), np.zeros((2, COLUMNS))
    return Patches(
        normal=np.zeros((1, 2, COLUMNS)), start=np.zeros((2, COLUMNS), dtype=np.int64), position=position,
        beyond=beyond, motion=np.zeros((2, 5, COLUMNS)), place=np.zeros((2, N_NODES, COLUMNS), dtype=np.int64),
        weight=weight, outward=np.zeros((2, 2, COLUMNS)), along=along, across=across, traction_x=traction_x,
        traction_y=traction_y, inverse_mass=lightness, columns=COLUMNS, units=ONE,
    )  # fmt: skip


def readings(surface, at):
    """What contacts read of a surface at angles, (8,): its displacement, sideways, their rates and ripple, (5, 8)."""
    out = np.zeros((5, 8))
    read_group(surface, some_patches(), np.cos(at), np.sin(at), out)
    return out


def test_kernels_and_matrices_use_the_same_roller_patches():
    body = disc(RADIUS, 3)
    u = np.random.default_rng(1).standard_normal((body.n_nodes, 2, COLUMNS))
    ripples = np.random.default_rng(2).standard_normal(3 * 8)
    surface = DiscSurface(
        u=u.ravel(), w=u.ravel(), v=u.ravel(), points=body.points.ravel(), inverse_mass=np.ones(body.n_nodes + 8),
        impulse=np.zeros((2, COLUMNS)), ripple=with_seam(ripples), first=body.first_surface_node,
        n_nodes=body.shape.surface_nodes, columns=COLUMNS, radius=RADIUS,
    )  # fmt: skip

    step = 1e-6
    (out, side, rate, ripple, ripple_rate), ahead, behind = (
        readings(surface, ANGLES + turn) for turn in (0.0, step, -step)
    )
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
        u=padded, w=padded, v=padded, cosines=np.cos(sector), sines=np.sin(sector), ripple=with_seam(ripples),
        row=body.raceway_row, n_nodes=56, node_mass=1.0, radius=0.018,
    )  # fmt: skip

    step = 1e-6
    (out, side, rate, ripple, ripple_rate), ahead, behind = (
        readings(surface, ANGLES + turn) for turn in (0.0, step, -step)
    )
    for j, angle in enumerate(ANGLES):
        along = ring_patch_force(body, angle)
        assert out[j] == pytest.approx(np.vdot(along, u), abs=1e-13)
        turned = np.stack([-along[:, 1], along[:, 0]], axis=1)
        assert side[j] == pytest.approx(np.vdot(turned, u), abs=1e-13)
        position = np.mod(angle * 56.0 / (2.0 * np.pi), 1.0)
        assert ripple[j] == pytest.approx(ripple_at(position, ripples)[0], abs=1e-10)
    np.testing.assert_allclose(rate + side, (ahead[0] - behind[0]) / (2.0 * step), rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(ripple_rate, (ahead[3] - behind[3]) / (2.0 * step), rtol=1e-5, atol=1e-4)
