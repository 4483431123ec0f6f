"""The page of a study and the numbers behind it, on points whose results are made up."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray

from fem.study.dataset import write_dataset
from fem.study.effects import sobol_indices, table_of
from fem.study.folder import Folder
from fem.study.page import write_page
from fem.study.sampling import design_of
from fem.study.solving import COMPLETE, FAILED, Solved, checked_points
from fem.study.study_file import read_study

STUDY = """
[sampling]
method = "{method}"
[parameters]
"operation.speed_rpm" = {speed}
"operation.radial_load_N" = {load}
"bearing.roller_length_mm" = {length}
[keep]
quantities = ["largest_force", "hub_mean_y"]
"""
GRID = dict(method="grid", speed="[1, 2, 3]", load="[10, 20]", length="[8.0, 9.0, 10.0, 11.0]")
DRAWN = dict(
    method='sobol"\nsamples = 64\nindices = true\n#"', speed="{ from = -1.0, to = 1.0 }",
    load="{ from = 0.0, to = 1.0 }", length="{ from = 9.0, to = 11.0 }",
)  # fmt: skip


@pytest.fixture
def made_up(tmp_path, monkeypatch):
    """Gives the table of a study whose largest force is a function of speed, load and length."""
    monkeypatch.chdir(tmp_path)

    def make(force, failed=(), **values):
        Path("study.toml").write_text(STUDY.format(**values), encoding="utf-8")
        study = read_study(Path("study.toml"))
        points = checked_points(study, design_of(study))
        folder = Folder(path=Path("out"))
        folder.begin(points)
        for i, digest in enumerate(points.digests):
            quantities = {"largest_force": float(force(*points.design.points[i])), "hub_mean_y": 1e-6}
            status = dict(status=FAILED, text="<b>it broke</b>") if i in failed else dict(status=COMPLETE)
            folder.add(digest, Solved(**status, seconds=0.1, quantities={} if i in failed else quantities))
        write_dataset(points, folder)
        return points, folder

    return make


def shares(points, folder):
    table = table_of(points, write_dataset(points, folder))
    return {each.name: share for each, share in table.strongest(table.quantities[0])}, table


def test_a_quantity_of_one_parameter_is_explained_by_it_alone(made_up):
    found, _ = shares(*made_up(lambda speed, load, length: speed**2, **GRID))
    assert found["speed_rpm"] == pytest.approx(1.0)
    assert found["radial_load_N"] == found["roller_length_mm"] == 0.0


def test_effects_of_a_sum_share_its_variance(made_up):
    """3 s + 0.4 l + h/2 of s = 1, 2, 3, l = 10, 20, h = 8 … 11: variances 9 · 2/3, 0.16 · 25, 0.25 · 1.25.

    In a grid nothing is drawn, so no part of a small share is chance.
    """
    found, _ = shares(*made_up(lambda speed, load, length: 3.0 * speed + 0.4 * load + 0.5 * length, **GRID))
    whole = 6.0 + 4.0 + 0.3125
    assert found["speed_rpm"] == pytest.approx(6.0 / whole, abs=1e-12)
    assert found["radial_load_N"] == pytest.approx(4.0 / whole, abs=1e-12)
    assert found["roller_length_mm"] == pytest.approx(0.3125 / whole, abs=1e-12)


def test_shares_of_drawn_points_are_less_what_chance_explains_and_the_page_says_so(made_up):
    """Eight groups of 320 drawn points explain 7/319 of a variance that knows nothing of the parameter."""
    rng = np.random.default_rng(3)
    points, folder = made_up(lambda *_: rng.normal(), **DRAWN)
    found, _ = shares(points, folder)
    assert max(found.values()) < 0.04
    write_page(points, folder, write_dataset(points, folder))
    assert "chance" in folder.page.read_text(encoding="utf-8")
    points, folder = made_up(lambda speed, load, length: speed, **GRID)
    write_page(points, folder, write_dataset(points, folder))
    assert "chance" not in folder.page.read_text(encoding="utf-8")


def test_sobol_indices_are_those_of_a_function_whose_variance_is_known(made_up):
    """3 x + 2 y + z + 3 x y, each even in -1 … 1: the terms have variances 3, 4/3, 1/3 and 1."""

    def known(speed, load, length):
        x, y, z = speed, 2.0 * load - 1.0, length - 10.0
        return 3.0 * x + 2.0 * y + z + 3.0 * x * y

    points, folder = made_up(known, **DRAWN)
    assert len(points) == 5 * 64
    _, table = shares(points, folder)
    found, whole = sobol_indices(table, table.quantities[0]), 3.0 + 4.0 / 3.0 + 1.0 / 3.0 + 1.0
    assert found.first == pytest.approx(np.array([3.0, 4.0 / 3.0, 1.0 / 3.0]) / whole, abs=64**-0.5)
    assert found.total == pytest.approx(np.array([4.0, 7.0 / 3.0, 1.0 / 3.0]) / whole, abs=64**-0.5)
    assert sobol_indices(table, table.quantities[1]) is None  # it never changes


def cells(page):
    """Rows of all tables, each a list of texts."""
    rows = re.findall(r"<tr>(.*?)</tr>", page.read_text(encoding="utf-8"), re.S)
    return [re.findall(r"<t[dh]>(.*?)</t[dh]>", re.sub("</?span[^>]*>", "", row), re.S) for row in rows]


def test_the_page_of_a_grid_has_a_line_for_each_value_and_a_table_of_points(made_up):
    points, folder = made_up(lambda speed, load, length: speed + load, failed=(5,), **GRID)
    write_page(points, folder, write_dataset(points, folder))
    text = folder.page.read_text()
    assert "Varied: speed, radial load, roller length; 23 of 24 points are complete" in text
    assert "&lt;b&gt;it broke&lt;/b&gt;" in text and "point 5 (operation.speed_rpm = 1" in text
    assert re.findall('<figure id="([^"]*)"', text) == ["lines"]
    rows = cells(folder.page)
    assert ["mean position of the hub, y, µm", "1", "1", "23", "-"] in rows
    assert ["point", "speed, rpm", "radial load, N", "roller length, mm", "largest force on the inner raceway, N",
            "mean position of the hub, y, µm"] in rows  # fmt: skip
    assert ["0", "1", "10", "8", "11", "1"] in rows and ["5", "1", "20", "9", "-", "-"] in rows
    assert "http" not in text.split("<pre>")[0].replace("http://www.w3.org", "")


@pytest.mark.parametrize(("speed", "length"), [("[2]", "[8.0]"), ("[1, 2, 3]", "[8.0]"), ("[1, 2, 3]", "[8.0, 9.0]")])
def test_lines_of_a_grid_go_through_every_point(made_up, speed, length):
    """A mean over loads would be of no bearing."""
    from fem.study import figures

    scene = GRID | dict(speed=speed, load="[250, 500, 1000, 2000]", length=length)
    points, folder = made_up(lambda speed, load, length: speed * load + length, **scene)
    table = table_of(points, write_dataset(points, folder))
    seen = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(figures, "finished", lambda figure, *_: seen.append(figure))
        figures.study_figures(table, [])
    (figure,) = seen
    drawn = np.concatenate([line.get_ydata() for axis in figure.axes for line in axis.lines])
    assert sorted(drawn) == sorted(table.quantities[0].values)


def test_drawn_points_have_clouds_with_means_of_groups(made_up):
    points, folder = made_up(lambda speed, load, length: speed + load, **DRAWN)
    write_page(points, folder, write_dataset(points, folder))
    text = folder.page.read_text()
    assert re.findall('<figure id="([^"]*)"', text) == ["main-effects", "heat-map", "scatter-matrix", "sobol-indices"]
    assert ["largest force on the inner raceway", "radial load"] in [row[:2] for row in cells(folder.page)]


def test_one_parameter_has_no_shares_and_points_that_can_not_tell_are_left_out(made_up):
    points, folder = made_up(lambda speed, *_: 100.0 * speed, **{**GRID, "load": "[10]", "length": "[8.0]"})
    write_page(points, folder, write_dataset(points, folder))
    assert ["largest force on the inner raceway, N", "100", "300", "3"] in cells(folder.page)
    assert "variance" not in folder.page.read_text(encoding="utf-8")
    points, folder = made_up(lambda speed, *_: np.nan if speed < 3.0 else speed, **GRID)
    write_page(points, folder, write_dataset(points, folder))
    assert ["largest force on the inner raceway, N", "3", "3", "8", "-"] in cells(folder.page)


def test_a_study_without_a_complete_point_has_a_page_too(made_up):
    points, folder = made_up(lambda *_: 1.0, failed=range(24), **GRID)
    write_page(points, folder, write_dataset(points, folder))
    assert "0 of 24 points are complete" in folder.page.read_text()
    assert "Too few complete points" in folder.page.read_text()


def test_an_empty_cell_is_no_value_of_its_parameter(tmp_path, monkeypatch):
    """A point without a spall has no width, and its body is a word of its own."""
    monkeypatch.chdir(tmp_path)
    Path("points.csv").write_text(
        "operation.speed_rpm,spall.0.body,spall.0.width_mm\n1000,,\n1000,outer_ring,1.0\n1000,outer_ring,2.0\n"
    )
    Path("study.toml").write_text('[sampling]\nmethod = "list"\nfile = "points.csv"\n')
    study = read_study(Path("study.toml"))
    points = checked_points(study, design_of(study))
    assert not points.scene(0).spall and points.scene(2).spall[0].width_mm == 2.0
    folder = Folder(path=Path("out"))
    folder.begin(points)
    write_dataset(points, folder)
    body, width = table_of(points, write_dataset(points, folder)).parameters
    with xarray.open_dataset(folder.dataset, engine="netcdf4") as dataset:
        assert dataset.body.values.tolist() == ["", "outer_ring", "outer_ring"]
    assert body.words == ("-", "outer_ring") and np.isnan(width.values[0]) and width.values[2] == 2.0
