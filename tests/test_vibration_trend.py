"""A series of records: growth that is there is found, none where there is none, and unusable records are named."""

import json

import numpy as np
import pytest

from residual.check_vibration import main
from residual.measured.diagnosis import Geometry
from residual.measured.trend import Entry, growth
from tests.reference.synthetic_record import synthetic_record

NU206 = ("--bearing", "NU206", "--speed", "1480", "--unit", "g", "--quiet")
GEOMETRY = Geometry(elements=13, element_diameter=9e-3, pitch_diameter=46.5e-3)


def series(folder, strengths, fault="BPFO"):
    """Records of one bearing whose strikes have so many times the noise's rms."""
    for k, strength in enumerate(strengths):
        truth = synthetic_record(
            np.random.default_rng(40 + k), GEOMETRY, 1480.0 / 60.0, fault if strength else None, strength, duration=1.0
        )
        np.savez(folder / f"day{k}.npz", acc=truth.signal.values, rate=truth.signal.rate)
    return [str(folder / f"day{k}.npz") for k in range(len(strengths))]


def test_growing_damage_is_found_with_the_record_from_which_on_it_accuses(tmp_path):
    paths = series(tmp_path, (0.0, 0.0, 0.1, 0.3, 0.6, 1.0, 2.0))
    (tmp_path / "broken.npz").write_bytes(b"PK\x03\x04nothing")
    assert main([*paths[:3], str(tmp_path / "broken.npz"), *paths[3:], *NU206]) == 0
    folder = tmp_path / "day0-trend"
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert summary["verdict"] == "outer_ring" and set(summary["files"]) == {path.name for path in folder.iterdir()}
    grown = summary["growth"][0]
    assert grown["name"] == "BPFO" and grown["p"] < 0.01 and grown["last_depth"] > 4.0 * grown["first_depth"]
    assert [words.split()[3] for words in summary["sentences"] if " grows" in words] == ["BPFO"]
    verdicts = [each.get("verdict") for each in summary["records"]]
    assert verdicts[3] is None and "can't be read" in summary["records"][3]["reason"]
    since = next(k for k, verdict in enumerate(verdicts) if verdict == "outer_ring")
    assert f"from day{since - 1}.npz on" in summary["sentences"][1]  # the broken one stands before it
    page = (folder / "vibration.html").read_text(encoding="utf-8")
    assert page.index("The outer ring is damaged.") < page.index("<figure") and "not used: " in page


def test_healthy_series_does_not_grow(tmp_path):
    assert main([*series(tmp_path, (0.0,) * 5), *NU206, "--no-figures"]) == 0
    summary = json.loads((tmp_path / "day0-trend" / "summary.json").read_text(encoding="utf-8"))
    assert summary["sentences"][-1] == "No line grows beyond chance over the series."


def test_chance_of_growth_is_that_of_the_ranks():
    """Of n rising values the chance is 1/n!, of any of three lines three times that."""
    entries = [Entry(name="", depths={"BPFO": 0.1 * k, "BPFI": 0.3, "2×BSF": -0.1 * k}) for k in (1, 2, 4, 7, 9, 11)]
    found = {each.name: each for each in growth(entries[:5])}
    assert found["BPFO"].p == pytest.approx(3.0 / 120.0, rel=1e-9) and not found["BPFO"].sure
    assert growth(entries)[0].p == pytest.approx(3.0 / 720.0, rel=1e-9) and growth(entries)[0].sure
    assert found["2×BSF"].tau == pytest.approx(-1.0) and found["2×BSF"].p == 1.0
    assert (found["BPFI"].tau, found["BPFI"].p) == (0.0, 1.0)


def test_short_or_unusable_series_are_refused(tmp_path, capsys):
    paths = series(tmp_path, (0.0, 0.0))
    assert main([*paths, *NU206]) == 2
    assert "a series of 2 usable records; at least 3 are needed" in capsys.readouterr().err
    assert main([*paths, *NU206, "--against", paths[0]]) == 2
    assert "only with one record" in capsys.readouterr().err
