"""How the commands end, as processes: exit codes, sentences, never a traceback."""

import importlib
import pkgutil

import pytest

import fem
import lagrange
import meshes
import residual
from fem.cli import new_app, run_app_main
from fem.errors import RunFailed
from tests.reference.commands import command

CROWDED = """
[bearing]
rollers = 17
roller_diameter_mm = 2.81
roller_length_mm = 7.06
inner_raceway_diameter_mm = 12.60282667887376
outer_raceway_diameter_mm = 18.23222086267229
bore_diameter_mm = 8.156759917707166
outside_diameter_mm = 21.567794393343753
[material]
youngs_modulus_GPa = 430.0
[operation]
speed_rpm = 0.0
radial_load_N = 33066.7
inner_ring_and_shaft_kg = 0.0631766447236004
[numerics]
mesh_size_mm = 0.2
"""


@pytest.mark.parametrize("option", ["--quiet", "--dry-run"])
def test_a_scene_without_a_static_equilibrium_is_refused_in_a_sentence(option, tmp_path):
    (tmp_path / "scene.toml").write_text(CROWDED)
    done = command("run-fem", "scene.toml", option, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: static equilibrium not found") and done.stderr.count("\n") == 1


def own_exceptions():
    """Every kind of error that a module of the program defines, once."""
    found = {}
    for package in (fem, lagrange, meshes, residual):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if module.name.endswith("__main__"):
                continue
            for kind in vars(importlib.import_module(module.name)).values():
                if isinstance(kind, type) and issubclass(kind, Exception) and kind.__module__ == module.name:
                    found[f"{kind.__module__}.{kind.__qualname__}"] = kind
    return found


OWN = own_exceptions()


@pytest.mark.parametrize("name", [name for name in OWN if not name.startswith("residual.")])
def test_every_error_of_the_program_and_what_derives_from_it_ends_in_a_sentence(name, capsys):
    for kind in (OWN[name], type("Derived", (OWN[name],), {})):
        app = new_app("some", "")

        @app.default
        def fail(kind=kind):
            raise kind("some reason")

        assert run_app_main(app, []) == (1 if issubclass(kind, RunFailed) else 2)
        told = capsys.readouterr().err
        assert "some reason" in told and told.startswith("error: ") and "Traceback" not in told


def test_the_programs_errors_are_found():
    assert {"fem.errors.UsageError", "fem.statics.contact_balance.NotFound", "lagrange.stored.Damaged"} <= set(OWN)
