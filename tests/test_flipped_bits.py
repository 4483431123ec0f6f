"""Clocks that jump change nothing, and no flipped bit of a file goes unnoticed; histories of runs."""

import itertools
import os

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path, load_checkpoint
from fem.solver.simulate import make_plan
from lagrange.columns import columns_of
from lagrange.errors import InputError, UsageError
from lagrange.scene.scene import read_scene
from residual.sources import MOTION, OPTIONAL, read_result
from tests.reference.kit import OPTIONS, SHORT, same_data
from tests.stability import histories


@pytest.mark.parametrize("clock", ["back and forth", "an hour a look", "stands still"])
def test_clocks_that_jump_change_nothing(clock, whole, tmp_path, monkeypatch):
    numbers, now = np.random.default_rng(3), itertools.count()
    told = {
        "back and forth": lambda: float(numbers.uniform(-1e6, 1e6)), "an hour a look": lambda: 3600.0 * next(now),
        "stands still": lambda: 5.0,
    }[clock]  # fmt: skip
    for name in ("time", "monotonic", "perf_counter"):
        monkeypatch.setattr(f"time.{name}", told)
    path = tmp_path / "run.nc"
    assert run_main([*SHORT, "--output", str(path)]) == 0 and same_data(path, whole)
    assert load_checkpoint(path, make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=2"))))


def ran(path, duration, model="fem"):
    assert run_main([*OPTIONS, "--duration", str(duration), "--model", model, "--output", str(path)]) == 0
    keys = "numerics.mesh_size_mm=2", f"numerics.duration_ms={duration}", f"model={model}"
    return make_plan(read_scene(None, keys))


def refusals(path, places, numbers, read, error, compare):
    """How often a file with one bit of a byte flipped is refused by name; what is read otherwise is compared."""
    good, count = path.read_bytes(), 0
    for place in places:
        spoilt = bytearray(good)
        spoilt[place] ^= 1 << int(numbers.integers(8))
        path.write_bytes(spoilt)
        try:
            found = read()
        except error as refused:
            assert str(path) in str(refused)
            count += 1
        else:
            compare(found)
    return count


@pytest.mark.parametrize("flips", [40, pytest.param(1000, marks=pytest.mark.slow)])
def test_no_flipped_bit_of_a_result_goes_unnoticed(flips, tmp_path):
    path = tmp_path / "run.nc"
    plan, sound, numbers = ran(path, 0.5), read_result(path), np.random.default_rng(7)
    with h5py.File(path) as file:
        blocks = [(file[name].id.get_offset(), file[name].nbytes) for name in columns_of("")]
    places = numbers.choice(np.concatenate([np.arange(start, start + size) for start, size in blocks]), flips)

    def compare(read):
        assert read.scene == sound.scene == plan.scene
        for name in (*MOTION, *OPTIONAL):
            np.testing.assert_array_equal(getattr(read, name), getattr(sound, name))
        assert read.energies.keys() == sound.energies.keys()
        for name in sound.energies:
            np.testing.assert_array_equal(read.energies[name], sound.energies[name])

    assert refusals(path, places, numbers, lambda: read_result(path), InputError, compare) > flips // 5


@pytest.mark.parametrize("model", ["fem", pytest.param("lagrange", marks=pytest.mark.slow)])
def test_no_flipped_bit_of_a_checkpoint_goes_unnoticed(model, tmp_path):
    path, numbers = tmp_path / "run.nc", np.random.default_rng(8)
    plan, kept = ran(path, 0.4, model), checkpoint_path(path)
    sound, stored = load_checkpoint(path, plan)

    def compare(found):
        state, same = found
        assert same == stored and state.progress == sound.progress
        (arrays, rest), (sound_arrays, sound_rest) = state.to_keep(), sound.to_keep()
        assert rest == sound_rest
        assert all(arrays[name].tobytes() == array.tobytes() for name, array in sound_arrays.items())

    places = numbers.integers(0, kept.stat().st_size, 150)
    assert refusals(kept, places, numbers, lambda: load_checkpoint(path, plan), UsageError, compare) > 125


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
