"""What a dry run says of every model for a scene."""

import pytest

from fem.commands.run_fem import run_main
from fem.solver.errors import Choice, model_choices, suggestion
from fem.solver.simulate import make_plan
from lagrange.scene.scene import read_scene


def choices_of(*settings: str) -> dict[str, Choice]:
    return {each.model: each for each in model_choices(make_plan(read_scene(None, settings)))}


def test_elastic_models_are_near_the_exact_series_and_rigid_bodies_are_not():
    """Harris' law errs by 14 % of the paper's bearing: docs/lagrange.md."""
    found = choices_of("model=reduced", "numerics.mesh_size_mm=2")
    assert found["reduced"].hub_error < 1e-6
    assert found["fem"].hub_error == pytest.approx(1.0e-3, rel=0.2)
    assert found["lagrange"].hub_error == pytest.approx(0.14, abs=0.01)
    assert min(each.seconds for each in found.values()) > 0.0  # what they are is the machine's
    assert suggestion(list(found.values())).startswith('start with "reduced"')


def test_what_a_model_refuses_is_told_with_its_reason():
    found = choices_of("model=lagrange", "bodies.rollers=rigid", "numerics.mesh_size_mm=2")
    assert found["reduced"].seconds is None and "rigid" in found["reduced"].lacks
    assert found["fem"].seconds > 0.0
    assert suggestion(list(found.values())).startswith('model = "fem"')


def test_without_load_no_error_is_named():
    found = choices_of("model=lagrange", "operation.radial_load_N=0", "numerics.mesh_size_mm=2")
    assert {each.hub_error for each in found.values()} == {None}


def test_a_dry_run_shows_the_models(capsys):
    assert run_main(["--dry-run", "--mesh-size", "2"]) == 0
    told = capsys.readouterr().out
    assert "Models for this scene" in told and "start with" in told


def test_balls_leave_no_choice(capsys):
    assert run_main(["--dry-run", "--model", "lagrange", "--set", "bearing.type=ball"]) == 0
    assert "Models for this scene" not in capsys.readouterr().out
