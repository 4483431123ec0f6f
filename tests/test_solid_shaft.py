"""A solid shaft as the inner ring: a disc on which its load acts all over, under contact loads."""

import re

import numpy as np
import pytest

from fem.elastic.bodies import disc_body
from fem.elastic.continuum import Section, cross_compliance, plane_compliance, shear_compliance
from fem.interface import rating, statics
from fem.solver.simulate import make_plan
from fem.statics.exact_statics import couplings_at, crossings_at, exact_statics
from lagrange.scene.faults import SceneError
from lagrange.scene.scene import Scene
from meshes.shapes import Disc

NEEDLES = {
    "rollers": 18, "roller_diameter_mm": 3.0, "roller_length_mm": 10.0, "inner_raceway_diameter_mm": 25.0,
    "clearance_um": 20.0, "bore_diameter_mm": 0.0, "outside_diameter_mm": 37.0,
}  # fmt: skip
STILL = {"speed_rpm": 0.0, "radial_load_N": 2000.0, "gravity_m_s2": 0.0}


def scene(**tables):
    return Scene(bearing=NEEDLES, operation=STILL, **tables)


def into_a_meshed_shaft(bearing, layers, sixths):
    """Displacement into the shaft, less its mean motion, by a load and a traction at angle 0, (2, n_angles), m/N."""
    disc = disc_body(
        Disc(radius=bearing.inner_raceway_radius, layers=layers), bearing.inner_ring, bearing.roller_length
    )
    surface = np.arange(disc.first_surface_node, disc.n_nodes)
    outward = disc.points[surface] / bearing.inner_raceway_radius
    force = np.zeros((disc.n_nodes, 2, 2))
    force[surface[0], :, 0], force[surface[0], :, 1] = -outward[0], (-outward[0, 1], outward[0, 0])
    moved = disc.relaxed(force.reshape(-1, 2)).reshape(-1, 2, 2)[surface]
    return -np.einsum("nc,ncf->fn", outward, moved)[:, np.round(layers * sixths).astype(int)]


def test_contacts_on_a_shaft_are_those_of_a_meshed_disc():
    """Displacements by loads and tractions elsewhere on it, of second order in two meshes: 0.1 % of the largest."""
    bearing = scene(model="lagrange").perfect_bearing()
    sixths = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0])  # of 60°
    coarse, fine = (into_a_meshed_shaft(bearing, layers, sixths) for layers in (40.0, 80.0))
    angle = np.pi / 3.0 * sixths
    exact = np.array([couplings_at(bearing, angle)[0, 0], crossings_at(bearing, angle)[0]])
    meshed = (4.0 * fine - coarse) / 3.0
    np.testing.assert_allclose(meshed, exact, atol=1e-3 * np.abs(exact).max())


@pytest.mark.parametrize("compliance", [plane_compliance, shear_compliance, cross_compliance])
def test_only_the_resultant_feels_a_narrow_bore(compliance):
    """From n = 2 on a bore a thousandth as wide changes nothing; n = 1 knows where the resultant goes."""
    steel, n = scene(model="lagrange").perfect_bearing().inner_ring, np.arange(1, 60)
    solid, bored = (compliance(Section(0.0125, held, steel), n) for held in (0.0, 1.25e-5))
    np.testing.assert_allclose(bored[1:], solid[1:], rtol=1e-5)
    assert abs(bored[0] / solid[0] - 1.0) > 0.1


@pytest.mark.parametrize("model", ["reduced", "lagrange"])
def test_models_rest_on_a_solid_shaft(model):
    """Reduced model: the exact series; rigid rings do not know the bore at all."""
    found = statics(scene(model=model))
    if model == "reduced":
        exact = exact_statics(scene(model=model).perfect_bearing(), 2000.0, -0.5 * np.pi)
        np.testing.assert_allclose(found.inner_force, exact.inner_force, rtol=1e-4, atol=0.05)
        assert found.hub[1] == pytest.approx(exact.hub[1], rel=1e-4)
    else:
        bored = statics(Scene(model=model, bearing=NEEDLES | {"bore_diameter_mm": 10.0}, operation=STILL))
        np.testing.assert_array_equal(found.inner_force, bored.inner_force)


@pytest.mark.slow
def test_meshes_with_a_rigid_core_are_as_near_as_they_say():
    whole = scene(model="fem", numerics={"mesh_size_mm": 0.5})
    found = statics(whole)
    exact = exact_statics(whole.perfect_bearing(), 2000.0, -0.5 * np.pi)
    assert found.hub[1] == pytest.approx(exact.hub[1], rel=0.01)
    np.testing.assert_allclose(found.inner_force, exact.inner_force, atol=0.03 * exact.inner_force.max())
    assert any("rigid core" in warning for warning in make_plan(whole).warnings)


def test_a_solid_shaft_is_rated():
    found = rating(Scene(model="reduced", bearing=NEEDLES, operation={"radial_load_N": 2000.0, "speed_rpm": 3000.0}))
    assert found["stiffness_N_per_m"][1, 1] > 0.0 and found["L10r_elastic_Mrev"] > 0.0


REFUSED = {
    "fits": ({"model": "reduced", "fit": {"shaft_interference_um": 5.0}}, "bearing.bore_diameter_mm = 0"),
    "springs": ({"contact": {"model": "penalty"}}, "held at its bore"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case):
    tables, told = REFUSED[case]
    with pytest.raises(SceneError, match=re.escape(told)):
        scene(**tables)
