"""[lubricant]: the film's thickness, and what it does in statics and in scenes."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from lagrange import contact_laws, static_equilibrium
from lagrange.contact.hertz import Pair
from lagrange.scene.scene import parse_scene_text, read_scene
from lagrange.surface.film import Lubricant, film_thickness, films
from tests.reference.refusals import assert_refused

OIL = Lubricant(viscosity=0.01, pressure_viscosity=2.2e-8, traction_coefficient=0.05)
PAPER = read_scene(None, ("lubricant.viscosity_Pa_s=0.02",))


def test_the_formula_gives_its_worked_values():
    """Rollers of 16 mm, raceways of 64 and 96 mm at 524 rad/s, 4800 N, E' = 228 GPa: 0.3925 and 0.4673 µm.

    The formula's own arithmetic, done apart from the program.
    """
    steel = replace(PAPER.ideal_bearing().roller, youngs_modulus=228e9 * (1.0 - 0.3**2), poisson_ratio=0.3)
    rolling = 524.0 * (80.0**2 - 16.0**2) / (4.0 * 80.0) * 1e-3  # m/s, of the contacts over either raceway
    for raceway, micrometres in ((0.032, 0.3925), (-0.048, 0.4673)):
        pair = Pair(kind="test", radii=(raceway, 0.008), materials=(steel, steel), length=0.016)
        assert film_thickness(pair, rolling, 4800.0, OIL) == pytest.approx(1e-6 * micrometres, rel=3e-4)


def test_the_paper_s_bearing_has_films_as_thick_as_its_largest_load_makes_them():
    """At 628.5 N, 0.02 Pa s and 2·10⁻⁸ 1/Pa 0.376 and 0.455 µm; by the power −0.13 a load 2 % off hardly matters."""
    found = {film.body: film.thickness for film in PAPER.ideal_bearing().faults}
    assert found["inner_ring"] == pytest.approx(0.376e-6, rel=0.01)
    assert found["outer_ring"] == pytest.approx(0.455e-6, rel=0.01)


def test_the_films_act_as_preload_in_statics():
    """They take up gap as raceways do that are nearer to each other: same loads, same place of the hub."""
    filmed = PAPER.ideal_bearing()
    inner, outer = (film.thickness for film in filmed.faults)
    nearer = replace(filmed, faults=(), outer_raceway_radius=filmed.outer_raceway_radius - inner - outer)
    operation = PAPER.ideal_operation()
    laws = contact_laws("harris", replace(filmed, faults=()))
    one, other = (static_equilibrium(bearing, operation, laws) for bearing in (filmed, nearer))
    dry = static_equilibrium(replace(filmed, faults=()), operation, laws)
    np.testing.assert_allclose(one.inner_force, other.inner_force, rtol=1e-4, atol=1e-3)
    assert one.y == pytest.approx(other.y, rel=1e-4)
    assert abs(one.y) < abs(dry.y) - 0.3 * (inner + outer)
    assert one.inner_force[0] < dry.inner_force[0] and one.inner_force[3] > 2.0 * dry.inner_force[3]


def test_nothing_that_stands_has_a_film():
    assert films(read_scene().ideal_bearing(), replace(PAPER.ideal_operation(), speed=0.0), OIL) == ()


def test_a_scene_keeps_its_lubricant_and_takes_traction_from_it():
    assert parse_scene_text(PAPER.to_toml(), "again") == PAPER
    assert PAPER.friction_coefficient == 0.05
    assert "lubricant" not in read_scene().to_toml()
    assert read_scene().friction_coefficient == 0.1


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["lubricant.viscosity_Pa_s=0"], ["lubricant.viscosity_Pa_s = 0"]),
        (["model=lagrange", "bearing.type=ball", "lubricant.viscosity_Pa_s=0.02"], ["[lubricant]", "line contacts"]),
        (["contact.model=penalty", "lubricant.viscosity_Pa_s=0.02"], ["[lubricant]", '"penalty"']),
    ],
)
def test_a_lubricant_that_a_model_can_t_have_is_refused_by_name(settings, words):
    assert_refused(settings, *words)


@pytest.mark.parametrize("model", ["fem", "reduced", "lagrange"])
@pytest.mark.parametrize("speed", ["0", "3000"])
def test_rings_that_stand_or_turn_as_one_run_without_a_film(model, speed, tmp_path):
    """No film forms there: all surfaces are perfect, and the result has no columns of others."""
    settings = [
        f"model={model}", f"operation.speed_rpm={speed}", f"operation.outer_ring_speed_rpm={speed}",
        "lubricant.viscosity_Pa_s=0.02", "numerics.mesh_size_mm=2", "numerics.duration_ms=0.05",
    ]  # fmt: skip
    options = [word for setting in settings for word in ("--set", setting)]
    assert run_main(["--quiet", "--output", str(tmp_path / "run.nc"), *options]) == 0
    with h5py.File(tmp_path / "run.nc") as file:
        assert file.attrs["status"] == "complete" and "inner_sinkage" not in file
