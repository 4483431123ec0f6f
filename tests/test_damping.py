"""[damping]: dampers of contacts and bodies, in all models; impacts through them stand in test_lagrange_simulate."""

import numpy as np
import pytest

from fem.kernels.jit import kernel, part
from fem.solver.elements.plan import LUMPED
from fem.solver.simulate import make_plan
from lagrange.contact.damping import UNDAMPED, ContactDamping, damper_force
from lagrange.errors import RunFailed
from lagrange.scene.scene import read_scene
from tests.reference.kit import assert_refused


def test_a_damper_s_coefficient_is_that_of_its_law_and_with_its_spring_it_never_pulls():
    force, stiffness = np.array([100.0, 400.0]), np.array([2e8, 3e8])
    np.testing.assert_allclose(ContactDamping(time=1e-5).coefficient(force, stiffness), [2000.0, 3000.0])
    np.testing.assert_allclose(ContactDamping(hunt_crossley=2.0).coefficient(force, stiffness), [300.0, 1200.0])
    np.testing.assert_array_equal(ContactDamping(constant=7.0).coefficient(force, stiffness), 7.0)
    assert not UNDAMPED.acts
    assert read_scene(None, ("damping.contact_time_us=12",)).damping.contacts == ContactDamping(time=1e-6 * 12.0)
    found = damper_force(np.array([1.0, 1.0, 1.0, 0.0]), np.array([0.5, -0.2, -3.0, 5.0]), 2.0)
    np.testing.assert_array_equal(found, [1.0, -0.4, -1.0, 0.0])


@pytest.mark.parametrize(("settings", "words"), [
    (["damping.contact_N_s_m=1", "damping.contact_time_us=1"], ["contact_N_s_m = 1", "leave all but one out"]),
    (["damping.hunt_crossley_s_m=-1"], ["damping.hunt_crossley_s_m = -1", "0"]),
    (["lagrange.damping_N_s_m=1"], ["lagrange.damping_N_s_m: contacts are damped by damping.contact_N_s_m"]),
    (["model=lagrange", "damping.bodies_1_s=1"], ["damping.bodies_1_s = 1", "'lagrange'", "fem"]),
    (["model=reduced", "damping.bodies_1_s=1"], ["damping.bodies_1_s = 1", "'reduced'"]),
    (["reduced.modes_up_to_kHz=500"], ["reduced: the reduced model no longer has modes", 'model = "fem"']),
    (["axial.skew=free"], ["axial.skew: rollers are always guided"]),
    (["contact.model=penalty", "damping.contact_N_s_m=1"], ["damping.contact_N_s_m = 1", '"penalty"', "subgrid"]),
])  # fmt: skip
def test_damping_that_a_model_can_t_have_is_refused_by_name(settings, words):
    assert_refused(settings, *words)


def test_dampers_of_elastic_bodies_keep_lumped_masses():
    """Their forces are implicit in velocities of nodes that have masses of their own; slowed modes have none."""
    coarse = ("numerics.mesh_size_mm=3", "numerics.duration_ms=1")
    assert make_plan(read_scene(None, coarse)).mass is not LUMPED
    assert make_plan(read_scene(None, (*coarse, "damping.contact_time_us=12.5"))).mass is LUMPED


def test_a_law_that_time_loops_can_not_compile_ends_in_a_sentence(monkeypatch):
    """In place of a thousand lines of numba's."""

    @part
    def law(stiffness):
        return np.quantile(stiffness)

    @kernel
    def loop(stiffness):
        return law(stiffness)

    plan = make_plan(read_scene(None, ("model=lagrange", "numerics.duration_ms=1")))
    monkeypatch.setattr(type(plan), "first_state", lambda plan: loop(1.0))
    with pytest.raises(RunFailed, match=r"does not compile: .*quantile.*test_damping.py") as caught:
        plan.prepare()
    assert len(str(caught.value)) < 400
