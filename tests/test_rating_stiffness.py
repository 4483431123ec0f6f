"""The hub's stiffness over a pitch: identities of rotational symmetry, finite differences, springs worked out alone."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares, root

from fem.interface import simulate
from fem.rating.elastic import elastic_pitch
from fem.statics.contact_balance import HubSpring, Loads, balance, closed_forces, first_guess, hub_stiffness
from fem.statics.reduced_bearing import reduced_bearing
from lagrange import contact_laws, kinematics
from lagrange.contact.damping import ContactDamping
from lagrange.kinematics import roller_angles
from lagrange.rating.sources import Unavailable
from lagrange.rating.stiffness import in_series, lagrangian_pitch
from lagrange.scene.scene import read_scene
from lagrange.statics import held_hub
from lagrange.surface.deviation import UNTURNED

PER_MICROMETRE = 1e6


def held_stiffness(bearing, operation, laws, hub, *, angles):
    """The force of contacts and shaft on a hub that is held at a place, (2,), N, and its stiffness, (2, 2), N/m."""
    left, _, stiffness = held_hub(bearing, operation, laws, hub, angles=angles)
    down = operation.radial_load + operation.inner_mass * operation.gravity
    return np.array([-operation.side_load, down]) - left, stiffness


def paper(clearance=0.0, *more):
    """The paper's bearing at rest, weightless, under its 2000 N."""
    scene = read_scene(None, (f"bearing.clearance_um={clearance}", *more))
    return scene.ideal_bearing(), replace(scene.ideal_operation(), speed=0.0, gravity=0.0)


def held_elastic(model, angles, place):
    """Force on a hub that stiff springs hold at a place, N, where it is, m, and its stiffness without them, N/m."""
    contacts, stiff = model.at(angles, UNTURNED), 1e12
    loads = Loads(0.0, spring=HubSpring(stiff, *place))
    start = np.concatenate([place, first_guess(model.bearing, contacts.radial, 0.0)[2:]])
    found, forces = balance(contacts, loads, start)
    forces = closed_forces(forces)
    normal = contacts.radial * found[2:, None] - found[:2]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    force = -forces[: model.bearing.n_rollers] @ normal
    return force, found[:2], hub_stiffness(contacts, found, forces, None)


def springs_alone(bearing, law, angles, place):
    """Force, (2,), and stiffness, (2, 2), of springs of both contacts in series on rigid circles, small angles."""
    radial = np.stack([np.cos(angles), np.sin(angles)])
    n, depth = law.exponent, np.maximum(place @ radial - bearing.radial_clearance, 0.0)
    stiff = law.stiffness / 2.0**n
    slope = np.where(depth > 0.0, n * stiff * np.maximum(depth, 1e-30) ** (n - 1.0), 0.0)
    return radial @ (stiff * depth**n), (slope * radial) @ radial.T


@pytest.mark.parametrize("clearance", [0, 10, 20, 40])
def test_pitch_of_a_hub_under_load(clearance):
    """Against springs alone: mean 1e-3 of the stiffness along the load, at the same angles of the cage."""
    bearing, operation = paper(clearance)
    laws = contact_laws("harris", bearing)
    found = lagrangian_pitch(bearing, operation, laws, samples=32)
    rows = []
    for angles in found.theta:
        place = root(
            lambda at, angles=angles: springs_alone(bearing, laws.inner, angles, 1e-6 * at)[0] + [0.0, 2000.0],
            np.array([0.0, -6.0 - 0.5 * clearance]),
        )
        assert place.success
        rows.append(springs_alone(bearing, laws.inner, angles, 1e-6 * place.x)[1])
    assert found.mean == pytest.approx(np.mean(rows, axis=0), abs=1e-3 * found.mean[1, 1])
    assert np.abs(found.stiffness - rows).max() < 0.01 * found.mean[1, 1]


@pytest.mark.parametrize(
    ("clearance", "along", "across"), [(0, 541.0, 486.2), (10, 513.3, 198.3), (20, 479.4, 127.1), (40, 434.6, 77.7)]
)
def test_pitch_means_of_a_hub_on_the_load_line(clearance, along, across):
    """Values worked out elsewhere for a hub that is kept from moving sideways, with a coarser mean: 0.2 and 0.5 %."""
    bearing, operation = paper(clearance)
    laws, rows = contact_laws("harris", bearing), []
    for turned in 2.0 * np.pi / bearing.n_rollers * np.arange(64) / 64:
        angles = roller_angles(bearing, 0.0) + turned

        def at(depth, angles=angles):
            return held_stiffness(bearing, operation, laws, np.array([0.0, -depth]), angles=angles)

        rows.append(at(brentq(lambda depth: at(depth)[0][1] - 2000.0, 1e-7, 1e-4, xtol=1e-12))[1])
    mean = np.mean(rows, axis=0) / PER_MICROMETRE
    assert mean[1, 1] == pytest.approx(along, rel=2e-3)
    assert mean[0, 0] == pytest.approx(across, rel=5e-3)


@pytest.mark.parametrize("law", ["harris", "iso16281"])
@pytest.mark.parametrize("clearance", [0.0, 20.0])
def test_mean_at_a_fixed_displacement(law, clearance):
    """Rotational symmetry: kxx = F/δ, kyy = dF/dδ, kxy = 0; without clearance kxx/kyy = 1/n."""
    bearing, operation = paper(clearance)
    laws, fine = contact_laws(law, bearing), 4000
    angles = 2.0 * np.pi * np.arange(fine * bearing.n_rollers) / (fine * bearing.n_rollers)

    def mean(depth):
        """Rollers of a held hub know nothing of each other: those of all angles of the cage at once."""
        force, stiffness = held_stiffness(bearing, operation, laws, np.array([0.0, -depth]), angles=angles)
        return force / fine, stiffness / fine

    depth = 4e-6 + bearing.radial_clearance
    force, stiffness = mean(depth)
    step = 1e-3 * depth
    slope = (mean(depth + step)[0][1] - mean(depth - step)[0][1]) / (2.0 * step)
    assert stiffness[0, 0] == pytest.approx(force[1] / depth, rel=1e-4)
    assert stiffness[1, 1] == pytest.approx(slope, rel=1e-4)
    assert abs(stiffness[0, 1]) < 1e-4 * stiffness[0, 0]
    if clearance == 0.0:
        assert stiffness[0, 0] / stiffness[1, 1] == pytest.approx(1.0 / laws.inner.exponent, rel=1e-3)


def test_mean_at_a_fixed_displacement_with_elastic_rings():
    """The same identities under preload: no contact opens, so that few angles of the cage give the mean."""
    bearing, _ = paper(-12.0)
    model, depth, samples, tolerance = reduced_bearing(bearing, kinematics(bearing, 0.0)), 4e-6, 10, 1e-4
    turned = 2.0 * np.pi / bearing.n_rollers * np.arange(samples) / samples

    def mean(delta):
        rows = [held_elastic(model, roller_angles(bearing, 0.0) + a, np.array([0.0, -delta])) for a in turned]
        return [np.mean([row[i] for row in rows], axis=0) for i in range(3)]

    force, place, stiffness = mean(depth)
    step = 1e-2 * depth
    low, high = mean(depth - step), mean(depth + step)
    slope = (high[0][1] - low[0][1]) / (low[1][1] - high[1][1])
    assert stiffness[0, 0] == pytest.approx(force[1] / -place[1], rel=tolerance)
    assert stiffness[1, 1] == pytest.approx(slope, rel=tolerance)
    assert abs(stiffness[0, 1]) < 1e-4 * stiffness[0, 0]


def test_matrix_against_finite_differences_of_held_elastic_hubs():
    bearing, _ = paper(20.0)
    model = reduced_bearing(bearing, kinematics(bearing, 0.0))
    angles, place, step = roller_angles(bearing, 0.1), np.array([1e-6, -14e-6]), 1e-9
    forces, places = np.zeros((2, 2)), np.zeros((2, 2))
    for axis in range(2):
        ends = [held_elastic(model, angles, place + sign * step * np.eye(2)[axis]) for sign in (1.0, -1.0)]
        forces[:, axis], places[:, axis] = ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]
    exact = held_elastic(model, angles, place)[2]
    assert -forces @ np.linalg.inv(places) == pytest.approx(exact, abs=1e-6 * exact.max())


def test_matrix_against_finite_differences_of_statics():
    bearing, operation = paper(20.0)
    laws, angles, place = contact_laws("harris", bearing), roller_angles(bearing, 0.1), np.array([1e-6, -14e-6])

    def force(at):
        return held_stiffness(bearing, operation, laws, at, angles=angles)[0]

    step = 1e-10
    found = np.stack([-(force(place + d) - force(place - d)) / (2.0 * step) for d in step * np.eye(2)], axis=1)
    exact = held_stiffness(bearing, operation, laws, place, angles=angles)[1]
    assert found == pytest.approx(exact, abs=1e-6 * exact.max())


def test_a_pitch_has_the_harmonics_of_its_rollers():
    """kxy swings by ±38 N/µm in the paper's bearing with 20 µm of clearance (springs alone: 38.2), and has no mean."""
    bearing, operation = paper(20.0)
    found = lagrangian_pitch(bearing, operation, contact_laws("harris", bearing))
    assert found.range[1, 0, 1] / PER_MICROMETRE == pytest.approx(38.2, abs=0.2)
    assert abs(found.mean[0, 1]) < 1e-3 * found.mean[1, 1]
    swing = np.ptp(found.stiffness[:, 1, 1])
    assert found.harmonics[0, 1, 1] == pytest.approx(0.5 * swing, rel=0.3)
    assert found.is_stable


def test_elastic_rings_are_stiffer_than_harris_law():
    """Harris' law gives 11 % less force on an approach of the paper's bearing than the elastic contacts do."""
    bearing, operation = paper()
    elastic = elastic_pitch(bearing, operation)
    law = lagrangian_pitch(bearing, operation, contact_laws("harris", bearing))
    assert 1.05 < elastic.mean[1, 1] / law.mean[1, 1] < 1.25


def test_one_roller_does_not_hold_the_hub_sideways():
    bearing, operation = paper(60.0)
    light = replace(operation, radial_load=20.0)
    found = lagrangian_pitch(bearing, light, contact_laws("harris", bearing))
    assert not found.is_stable


@pytest.mark.parametrize("solve", ["law", "elastic"])
def test_dampers_in_proportion_to_stiffness(solve):
    """τ K in every contact: the hub's matrix is τ times its stiffness without what turning normals take from that."""
    bearing, operation = paper()
    damping = ContactDamping(time=1e-5)
    found = (
        lagrangian_pitch(bearing, operation, contact_laws("harris", bearing), damping, samples=8)
        if solve == "law"
        else elastic_pitch(bearing, operation, damping, samples=8)
    )
    ratio = found.damping.mean(axis=0)[1, 1] / (1e-5 * found.mean[1, 1])
    assert ratio == pytest.approx(1.0, rel=2e-3) if solve == "law" else 1.0 < ratio < 2.0


def ringing(folder, step):
    """A run of the reduced model at rest, under 2000 N and from 50 µs on a step more, N; a heavy hub."""
    rows = "".join(f"{0.05 * k:.4g},0,{-2000.0 - step}\n" for k in range(1, 100))
    (folder / "load.csv").write_text(f"time_ms,x_N,y_N\n0,0,-2000\n{rows}", encoding="utf-8")
    text = (
        'model = "reduced"\noperation.load_table = "load.csv"\noperation.speed_rpm = 0.0\n'
        "operation.gravity_m_s2 = 0.0\n"
        "operation.inner_ring_and_shaft_kg = 50.0\ncontact.friction_coefficient = 0.0\nnumerics.duration_ms = 3.0\n"
        "numerics.output_interval_us = 10.0\n"
    )
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    return simulate(read_scene(folder / "scene.toml"))


@pytest.mark.slow  # compiles a loop
def test_hub_that_rings_down_has_the_frequency_of_the_matrix(tmp_path):
    """Of the difference of two runs, as free rollers drift out of the load zone in both."""
    bearing, operation = paper()
    expected = np.sqrt(elastic_pitch(bearing, operation, samples=1).stiffness[0, 1, 1] / 50.0)
    still, struck = (ringing(tmp_path, step) for step in (0.0, 1.0))
    time = still["time"][10:]
    path = 1e9 * (struck["inner_y"] - still["inner_y"])[10:]

    def misfit(parts):
        mean, slope, bend, cosine, sine, ratio = parts
        angle = ratio * expected * time
        return mean + slope * time + 1e3 * bend * time**2 + cosine * np.cos(angle) + sine * np.sin(angle) - path

    found = least_squares(misfit, [path.mean(), 0.0, 0.0, 1.0, 0.0, 1.0])
    assert np.std(found.fun) < 1e-3 * np.ptp(path)
    assert found.x[-1] == pytest.approx(1.0, abs=1e-3)


def test_springs_in_series():
    soft = in_series(np.diag([2.0, 3.0]), np.diag([2.0, 6.0]))
    assert soft == pytest.approx(np.diag([1.0, 2.0]))


def test_elastic_rings_are_refused_to_balls_and_rigid_bodies():
    for more in (("bodies.rollers=rigid",), ("bearing.type=ball",)):
        scene = read_scene(None, ("model=lagrange", *more))
        with pytest.raises(Unavailable):
            elastic_pitch(scene.ideal_bearing(), scene.ideal_operation())
