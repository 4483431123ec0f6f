"""The checker on surfaces that are not perfect: a fault left out of the equations shows, one in them is gone."""

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from lagrange.scene.scene import parse_scene_text
from residual.evaluation import evaluate
from residual.sources import read_result

SURFACES = {
    "outer ring": "[[spall]]\nangle_deg = 1.5\nwidth_mm = 0.4\n",
    "inner ring": '[[spall]]\nbody = "inner_ring"\nangle_deg = -8\nwidth_mm = 0.4\ndepth_um = 2\n',
    "roller": '[[spall]]\nbody = "roller"\nroller = 0\nangle_deg = 120\nwidth_mm = 0.4\n',
    "waves": "[[waviness]]\norder = 12\n\n[[unequal_roller]]\nroller = 1\n",
}
RUN = 'model = "lagrange"\n[numerics]\nduration_ms = 1.0\noutput_interval_us = 1.0\n'


@pytest.mark.parametrize("name", SURFACES)
def test_the_equations_know_the_surfaces(name, tmp_path):
    """In the solution of the same equations what is left is the differentiation's; on circles the fault is left.

    The outer raceway's sinkage is in the rollers' equations, not in the hub's, which are checked here.
    """
    path, scene = tmp_path / "run.nc", tmp_path / "scene.toml"
    scene.write_text(RUN + SURFACES[name], encoding="utf-8")
    assert run_main([str(scene), "--output", str(path), "--quiet"]) == 0
    record = read_result(path)
    plain = replace(record, scene=parse_scene_text(RUN, "plain"), roller_turn=None)
    known, unknown = evaluate(record), evaluate(plain)
    contact = known.budget.y.terms["contact_law"], unknown.budget.y.terms["contact_law"]
    assert np.abs(contact[0]).max() < 1e-6
    if name == "outer ring":
        np.testing.assert_allclose(contact[1], contact[0], atol=1e-6)
    else:
        assert np.abs(contact[1]).max() > 20.0
    # where a roller is released or strikes the stencils have a kink
    assert np.median(np.abs(known.y.budget.error)) < 0.5


def test_rollers_are_where_their_own_spin_has_brought_them(tmp_path):
    path = tmp_path / "run.nc"
    settings = ("model=lagrange", "numerics.duration_ms=1", "spall.0.body=roller", "spall.0.roller=3")
    assert run_main([*(word for each in settings for word in ("--set", each)), "--output", str(path), "--quiet"]) == 0
    record = read_result(path)
    with h5py.File(path) as file:
        spin = file["roller_spin"][0, 0]
    np.testing.assert_allclose(record.roller_turn, np.repeat(spin * record.time[:, None], 13, axis=1), atol=1e-12)


def test_a_result_file_tells_its_faults(tmp_path):
    path = tmp_path / "run.nc"
    options = ["--duration", "0", "--output", str(path), "--quiet", "--set", "model=lagrange"]
    assert run_main([*options, "--set", "spall.0.width_mm=2", "--set", "unequal_roller.0.roller=3"]) == 0
    with h5py.File(path) as file:
        spall, unequal = json.loads(file.attrs["faults"])
    assert (spall["kind"], spall["body"], spall["width"]) == ("spall", "outer_ring", 2e-3)
    assert (unequal["kind"], unequal["roller"], unequal["diameter_deviation"]) == ("unequal_roller", 3, 1e-6)
    assert run_main([*options, "--force"]) == 0
    with h5py.File(path) as file:
        assert "faults" not in file.attrs
