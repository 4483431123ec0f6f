"""Nothing is overwritten silently."""

import h5py
import pytest

from fem.cli import result_name, run_main

SHORT = ["--model", "reduced", "--duration", "0.5", "--quiet"]


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """A complete run in runs/paper.nc."""
    monkeypatch.chdir(tmp_path)
    assert run_main(SHORT) == 0
    return tmp_path / "runs" / "paper.nc"


def test_a_complete_run_of_another_scene_is_replaced_by_force_only(kept, capsys):
    before = kept.read_bytes()
    faster = ["--output", str(kept), "--set", "operation.speed_rpm=5000"]
    assert run_main([*SHORT, *faster]) == 2
    told = capsys.readouterr().err
    assert "operation.speed_rpm was 4500.0, now 5000.0" in told and "--force" in told and "--output" in told
    assert kept.read_bytes() == before
    assert run_main([*SHORT, *faster, "--force"]) == 0
    with h5py.File(kept) as file:
        assert "speed_rpm = 5000.0" in file.attrs["scene"]


def test_the_same_scene_runs_again_into_its_file(kept):
    assert run_main(SHORT) == 0


def test_what_is_incomplete_or_damaged_may_be_replaced(kept):
    other = [*SHORT, "--set", "numerics.output_interval_us=20", "--output", str(kept)]
    with h5py.File(kept, "r+") as file:
        file.attrs.modify("status", "interrupted")
    assert run_main(other) == 0
    kept.write_bytes(kept.read_bytes()[:3000])
    assert run_main(SHORT) == 0


def test_a_setting_changes_the_default_name(kept):
    assert run_main([*SHORT, "--set", "operation.speed_rpm=5000"]) == 0
    assert {path.name for path in kept.parent.glob("*.nc")} == {"paper.nc", "paper-speed_rpm-5000.nc"}


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        ([], "a"),
        (["operation.speed_rpm=3000", "contact.friction_coefficient = 0"], "a-speed_rpm-3000-friction_coefficient-0"),
        (["spall.0.width_mm=2"], "a-spall.0.width_mm-2"),
        (["numerics.duration_ms=90", "name=a"], "a"),
        (['profile.0.file="../x y.csv"'], "a-profile.0.file-_.._x_y.csv_"),
    ],
)
def test_names_say_what_was_set_and_stay_names_of_files(settings, name):
    assert result_name("a", settings) == name


def test_long_names_are_cut_and_stay_apart():
    names = {result_name("a", ["lagrange.law=" + 200 * "x" + end]) for end in "pq"}
    assert len(names) == 2 and all(len(name) < 140 for name in names)
