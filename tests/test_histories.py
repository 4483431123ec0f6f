"""Short form of `python -m tests.stability.histories`: runs that much befalls end complete and the same, or refused."""

import os

import pytest

from tests.stability import histories


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
@pytest.mark.parametrize("number", [2, pytest.param(20, marks=pytest.mark.slow)])
def test_whatever_befalls_a_run_it_ends_with_the_same_bits_or_is_refused_by_name(number, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))  # put back afterwards, as the next one is
    monkeypatch.setenv("NUMBA_CACHE_DIR", os.environ.get("NUMBA_CACHE_DIR", ""))
    models = ("lagrange",) if number == 2 else tuple(histories.MODELS)
    monkeypatch.setattr(histories, "SHARES", (1.0, 0.0, 0.0) if number == 2 else histories.SHARES)
    wholes = histories.prepare(tmp_path, models)
    assert all(whole["status"] == "complete" and len(whole["time"]) > 100 for whole in wholes.values())
    for each in range(number):
        *told, fault = histories.history(number, each, tmp_path, wholes)
        assert not fault, (told, fault)
