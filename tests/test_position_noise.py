"""Resolution and noise of a table's positions, found in them, and the error forces that they make."""

import json
from dataclasses import replace

import numpy as np
import pytest

from residual.cli import main
from residual.evaluation import evaluate
from residual.interpretation import interpretation, verdict
from residual.table_source import read_table
from tests.reference.synthetic_run import harris_force, make_run, write_table

MASS = 3.0  # kg


@pytest.fixture(scope="module")
def run():
    """Held still at an approach that carries 2000 N within 60 N: a hub that moves less than a micrometre."""
    made = make_run(n_times=2001, amplitude=1e-9)
    operation = made.scene.operation.model_copy(update={"inner_ring_and_shaft_kg": MASS})
    return replace(made, scene=made.scene.model_copy(update={"operation": operation}))


def disturbed(run, change):
    return replace(run, **{name: change(getattr(run, name)) for name in ("inner_x", "inner_y", "roller_x", "roller_y")})


def rounded(places):
    return np.round(places, 6)


def noisy(run, size):
    rng = np.random.default_rng(5)
    return disturbed(run, lambda places: places + size * rng.standard_normal(places.shape))


def checked(run, folder, capsys, law="harris"):
    scene, out = folder / "scene.toml", folder / "out"
    scene.write_text(run.scene.to_toml(), encoding="utf-8")
    table = write_table(run, folder / "table.csv")
    assert main([str(table), "--scene", str(scene), "--law", law, "--no-figures", "--output", str(out)]) == 0
    printed = capsys.readouterr()
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    return printed.out, printed.err.splitlines(), summary, evaluate(read_table(table, run.scene), law)


def test_positions_rounded_to_a_micrometre_blame_no_law(run, tmp_path, capsys):
    out, warnings, summary, found = checked(disturbed(run, rounded), tmp_path, capsys)
    assert "rounding to 1 µm" in warnings[0] and "residuals mean nothing" in warnings[0]
    assert "say nothing about the contact law harris" in out and "is off by" not in out
    assert summary["position_noise"]["rounding_step_m"] == pytest.approx(1e-6)
    assert summary["position_noise"]["within"]
    sentences = " ".join(interpretation(found, None))
    assert "carries" not in sentences and "has the smallest error" not in sentences


def test_white_noise_is_told_from_the_motion_and_its_force_is_that_of_its_second_derivative(run, tmp_path, capsys):
    """Independent: the same noise, put through M d²/dt² of order 6, and the stiffness of the law at the approaches."""
    out, warnings, summary, found = checked(noisy(run, 1e-8), tmp_path, capsys)
    noise = summary["position_noise"]
    assert [*noise["hub_rms_m"].values(), noise["roller_rms_m"]] == pytest.approx([1e-8] * 3, rel=0.1)
    weights = np.array([2, -27, 270, -490, 270, -27, 2]) / 180.0
    inertia = MASS * 1e-8 * np.sqrt(np.sum(weights**2)) / 1e-10
    assert list(noise["balance_N"].values()) == pytest.approx([inertia] * 2, rel=0.1)
    assert [d.error.std for d in found.directions] == pytest.approx(list(noise["error_N"].values()), rel=0.1)
    assert "noise" in warnings[0] and "say nothing about the contact law harris" in out
    with_forces = evaluate(replace(found.record, inner_force=run.law_force))
    assert "the trajectories cannot be checked" in verdict(with_forces).lower()


def test_noise_of_the_approaches_makes_a_laws_force_uncertain(run, tmp_path):
    """By the law itself, typed in again, at the noisy and at the exact approaches."""
    b, pushes, moved = run.scene.ideal_bearing(), [], noisy(run, 1e-8)
    for each in (run, moved):
        x, y = each.roller_x - each.inner_x[:, None], each.roller_y - each.inner_y[:, None]
        away = np.hypot(x, y)
        force = harris_force(b.inner_raceway_radius + b.roller_radius - away)
        pushes.append(np.sum(force * np.stack([x, y]) / away, axis=2))
    found = evaluate(read_table(write_table(moved, tmp_path / "table.csv"), run.scene), "harris")
    assert found.position_noise.law == pytest.approx(np.std(pushes[1] - pushes[0], axis=1), rel=0.1)


def test_exact_positions_are_told_nothing_of_and_a_wrong_law_is_found(run, tmp_path, capsys):
    out, warnings, summary, _ = checked(run, tmp_path, capsys, "johnson")
    assert not any("positions have an error" in line for line in warnings)
    assert "with the contact law johnson" in out
    assert summary["position_noise"]["rounding_step_m"] < 1e-12 and not summary["position_noise"]["within"]


def test_a_mean_beyond_the_noise_is_a_finding_still(run, tmp_path, capsys):
    """Noise of the inertia has no mean: what a law carries too little of the load is seen through it."""
    _, _, _, found = checked(noisy(run, 1e-8), tmp_path, capsys, "johnson")
    assert found.within_noise and "johnson gives" in " ".join(interpretation(found, None))
