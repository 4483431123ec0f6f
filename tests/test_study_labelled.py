"""Signals of a study with labels: shards that a plain tar reader reads, Parquet by pyarrow, and their datasheet."""

import io
import json
import sys
import tarfile

import h5py
import numpy as np
import pytest

from fem.commands.run_study import study_main

STUDY = """
[fixed]
model = "lagrange"
"numerics.duration_ms" = 1.0
[sampling]
method = "grid"
[parameters]
"operation.speed_rpm" = [1500, 3000]
"operation.radial_load_N" = [500.0, 1000.0]
[keep]
quantities = ["hub_mean_y"]
signals = ["inner_ay", "inner_peak_pressure"]
signal_rate_kHz = 20.0
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "s.toml").write_text(STUDY, encoding="utf-8")
    options = ["--output", str(folder / "s"), "--workers", "1", "--quiet", "--export", "shards"]
    assert study_main([str(folder / "s.toml"), *options]) == 0
    return folder / "s"


def test_shards_hold_every_point_with_its_labels(study):
    samples = {}
    with tarfile.open(study / "signals-00000.tar") as archive:
        names = [member.name for member in archive]
        for name in names:
            key, _, kind = name.partition(".")
            content = archive.extractfile(name).read()
            samples.setdefault(key, {})[kind] = json.loads(content) if kind == "json" else np.load(io.BytesIO(content))
    assert [name.partition(".")[0] for name in names] == sorted(name.partition(".")[0] for name in names)
    assert list(samples) == ["000000", "000001", "000002", "000003"]
    with h5py.File(study / "study.nc") as file:
        for k, (key, sample) in enumerate(samples.items()):
            i, j = divmod(k, 2)
            assert set(sample) == {"json", "inner_ay.npy", "inner_peak_pressure.npy"}, key
            assert sample["inner_ay.npy"].dtype == np.float32
            np.testing.assert_array_equal(sample["inner_ay.npy"], file["inner_ay"][i, j].astype(np.float32))
            assert sample["inner_peak_pressure.npy"].shape == (sample["inner_ay.npy"].size, 13)
            told = sample["json"]
            assert (told["speed_rpm"], told["radial_load_N"]) == ([1500, 3000][i], [500.0, 1000.0][j])
            assert told["BPFO_Hz"] == file["BPFO_Hz"][i, j]
            assert told["spall_width_mm"] is None and "status" not in told


def test_same_dataset_gives_the_same_bytes(study, capsys):
    before = (study / "signals-00000.tar").read_bytes()
    assert study_main(["--collect", str(study), "--export", "shards"]) == 0
    assert (study / "signals-00000.tar").read_bytes() == before
    assert "signals-00000.tar" in capsys.readouterr().err


def test_datasheet_says_what_the_data_are_and_are_not(study):
    text = (study / "DATASHEET.md").read_text(encoding="utf-8")
    assert "4 complete points of 4, 21 samples each at 20000 Hz, in signals-00000.tar." in text
    assert "| inner_ay | m s-2 |" in text or "| inner_ay | m/s2 |" in text
    assert "| speed_rpm | rpm | scene key operation.speed_rpm | 1500 … 3000 |" in text
    assert "there is no noise" in text and '"operation.speed_rpm" = [1500, 3000]' in text


def test_parquet_has_a_row_for_every_point(study):
    pytest.importorskip("pyarrow")
    from pyarrow import parquet

    assert study_main(["--collect", str(study), "--export", "parquet", "--quiet"]) == 0
    table = parquet.read_table(study / "signals.parquet")
    assert table["speed_rpm"].to_pylist() == [1500, 1500, 3000, 3000]
    assert table.schema.field("speed_rpm").metadata[b"unit"] == b"rpm"
    with h5py.File(study / "study.nc") as file:
        np.testing.assert_array_equal(
            np.array(table["inner_ay"].to_pylist(), dtype=np.float32),
            file["inner_ay"][...].reshape(4, -1).astype(np.float32),
        )
        assert np.array(table["inner_peak_pressure"].to_pylist()).shape == (4, file["time"].size, 13)


def test_what_can_not_be_written_is_refused_before_anything_is_solved(study, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("fem.commands.start_up.find_spec", lambda name: None)
    assert study_main(["--collect", str(study), "--export", "parquet"]) == 2
    assert "needs pyarrow, which is not installed: python -m pip install pyarrow" in capsys.readouterr().err
    (tmp_path / "s.toml").write_text(STUDY.partition("signals")[0], encoding="utf-8")
    assert study_main([str(tmp_path / "s.toml"), "--output", str(tmp_path / "s"), "--export", "shards"]) == 2
    assert "keeps no signals" in capsys.readouterr().err
    assert not (tmp_path / "s").exists()
