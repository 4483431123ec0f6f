"""Fields for other programs, read back by those programs' own readers."""

import numpy as np
import pytest

from fem.commands.render_fem import render_main
from fem.elastic.bodies import von_mises
from fem.pictures.export import fields
from fem.pictures.recover import StoredRun
from meshes.export import FORMATS

SAMPLES = [0, 200, 400]


@pytest.fixture(scope="module")
def run(coarse_run):
    return StoredRun(coarse_run)


@pytest.fixture(scope="module")
def expected(run):
    return [fields(run.instant(sample)) for sample in SAMPLES]


def _cells(run):
    model = run.model
    rings = len(model.inner_ring.cells) + len(model.outer_ring.cells)
    return rings, 13 * len(model.roller.cells)


def test_points_are_where_rigid_motion_takes_them_and_the_hub_is_in_the_middle(run, expected):
    instant = run.instant(400)
    points, data = expected[2]
    ring = len(instant.model.inner_ring.points)
    assert points[:ring].mean(axis=0) == pytest.approx(instant.hub, abs=1e-9)
    last = points[-instant.model.roller.n_nodes :]
    innermost = instant.model.roller.shape.rows[0].nodes  # whose displacement is far below a micrometre
    assert last[:innermost].mean(axis=0) == pytest.approx(instant.centres[12], abs=1e-7)
    assert np.abs(data["displacement"]).max() < 1e-6  # elastic only


def test_the_tensor_and_von_mises_agree(expected):
    _, data = expected[1]
    tensor = data["stress"].reshape(-1, 3, 3).astype(float)
    assert np.array_equal(tensor, np.swapaxes(tensor, 1, 2))
    deviator = tensor - np.trace(tensor, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    assert data["von_mises"] == pytest.approx(np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2))), rel=1e-4, abs=10.0)
    assert data["von_mises"] == pytest.approx(
        von_mises(tensor[:, [0, 1, 0], [0, 1, 1]], 0.3), rel=1e-4, abs=10.0
    )  # fmt: skip


def test_a_vtkhdf_series_reads_back_in_vtk(run, coarse_run, expected, tmp_path, capsys):
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy

    target = tmp_path / "run.vtkhdf"
    assert render_main([str(coarse_run), "--export", str(target), "--frames", "3", "--quiet"]) == 0
    assert str(target) in capsys.readouterr().out
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(target))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    rings, triangles = _cells(run)
    for step, (points, data) in enumerate(expected):
        reader.SetStep(step)
        reader.Update()
        grid = reader.GetOutput()
        assert reader.GetTimeValue() == pytest.approx(run.times[SAMPLES[step]])
        assert grid.GetNumberOfCells() == rings + triangles
        assert grid.GetCellType(0) == 9 and grid.GetCellType(rings) == 5
        assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData())[:, :2], points)
        for name, values in data.items():
            assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetArray(name)), values)
        body = vtk_to_numpy(grid.GetCellData().GetArray("body"))
        assert body[0] == 0 and body[rings - 1] == 1 and body[rings] == 2 and body[-1] == 14
        for cell in (0, rings + triangles - 1):  # corners of a cell lie together
            corners = np.array([grid.GetCell(cell).GetPoints().GetPoint(k)[:2] for k in range(3)])
            assert np.ptp(corners, axis=0).max() < 4e-3


@pytest.mark.parametrize("suffix", FORMATS)
def test_an_instant_reads_back_in_meshio(run, coarse_run, expected, tmp_path, suffix):
    import meshio

    target = tmp_path / f"instant{suffix}"
    assert render_main([str(coarse_run), "--export", str(target), "--time", "2"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == [target.name]
    mesh = meshio.read(target)
    points, data = expected[1]
    assert mesh.points[:, :2] == pytest.approx(points, abs=1e-12)
    rings, triangles = _cells(run)
    assert {block.type: len(block.data) for block in mesh.cells} == {"quad": rings, "triangle": triangles}
    for name in ("displacement", "von_mises"):
        values = mesh.point_data[name].reshape(data[name].shape)
        assert values == pytest.approx(data[name], rel=1e-5, abs=1e-12)
