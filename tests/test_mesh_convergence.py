"""run-fem --converge: statics on three meshes, Richardson's value beside the exact series."""

import pytest

from fem.commands.run_fem import run_main
from fem.errors import UsageError
from fem.solver.errors import mesh_table
from lagrange.scene.scene import read_scene


@pytest.fixture(scope="module")
def found():
    return mesh_table(read_scene(None, ("numerics.mesh_size_mm=1.5",)))


def test_richardsons_value_is_nearer_to_the_exact_series_than_the_finest_mesh(found):
    hub, exact = found.meshes[-1].quantities[0].value, found.exact[0]
    assert abs(found.extrapolated[0] - exact) < 0.5 * abs(hub - exact)
    assert found.extrapolated[0] == pytest.approx(exact, rel=5e-4)


def test_loads_and_pressures_of_all_meshes_are_those_of_the_series(found):
    assert [mesh.size for mesh in found.meshes] == pytest.approx([3.0, 2.1213, 1.5], abs=1e-4)
    assert found.meshes[0].nodes < found.meshes[1].nodes < found.meshes[2].nodes
    for mesh in found.meshes:
        _, force, pressure = mesh.quantities
        assert force.value == pytest.approx(found.exact[1], rel=1e-3)
        assert pressure.value == pytest.approx(found.exact[2], rel=1e-3)


def test_comparison_contacts_are_refused():
    with pytest.raises(UsageError, match="order of convergence"):
        mesh_table(read_scene(None, ("contact.model=faceted",)))


def test_the_command_shows_meshes_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "110")
    assert run_main(["--converge", "--mesh-size", "2"]) == 0
    told = capsys.readouterr().out
    assert "Richardson" in told and "exact series" in told and "MPa" in told and not list(tmp_path.iterdir())


def test_where_the_scenes_mesh_is_coarse_it_is_the_coarsest():
    table = mesh_table(read_scene(None, ("numerics.mesh_size_mm=2.5",)))
    assert table.meshes[0].size == pytest.approx(2.5)
