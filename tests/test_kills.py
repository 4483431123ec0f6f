"""kill -9 at random moments: the file stays readable by plain h5py, and the resumed run is the undisturbed one."""

import os
import signal
import time

import h5py
import numpy as np
import pytest

from fem.cli import run_main
from fem.result.checkpoint import checkpoint_path
from fem.result.fields import GROUP, stored_samples
from fem.result.layout import VARIABLES

OPTIONS = [
    "--mesh-size", "2", "--quiet", "--duration", "12", "--checkpoint", "0.05", "--set", "output.fields_every_ms=1",
    "--output",
]  # fmt: skip
LONGEST = 1.2  # s until a kill at the most, to begin with: a little more than a leg takes to its end
LATER, SOONER = 1.2, 0.9  # where that turns out to be too soon for the machine, or too late


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.nc"
    assert run_main([*OPTIONS, str(path)]) == 0
    with h5py.File(path) as file:
        fields = {f"{GROUP}/{name}": variable[:] for name, variable in file[GROUP].items()}
        return {name: file[name][:] for name in VARIABLES} | fields


def killed_run(path, moment):
    """A leg of the run in a process of its own, killed after some seconds; whether it was still alive."""
    child = os.fork()
    if child == 0:
        try:
            os._exit(run_main([*OPTIONS, str(path), *(["--resume"] if checkpoint_path(path).exists() else [])]))
        finally:
            os._exit(70)
    time.sleep(moment)
    os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)


def samples_in(path, undisturbed):
    """How many samples a file holds, by plain h5py; all must be those of the undisturbed run."""
    with h5py.File(path, "r") as file:
        count = int(file.attrs["committed_samples"])
        assert file.attrs["status"] in ("running", "complete")
        for name in VARIABLES:
            assert np.array_equal(file[name][:count], undisturbed[name][:count]), name
        frames = len(stored_samples(file, count))
        assert frames == len(range(0, count, 100))
        for name in ("time", "sample", "roller_displacement", "outer_ring_stress"):
            stored = undisturbed[f"{GROUP}/{name}"]
            assert np.array_equal(file[GROUP][name][:frames], stored[:frames]), name
    return count


@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")
@pytest.mark.parametrize("kills", [5, pytest.param(50, marks=pytest.mark.slow)])
def test_after_a_kill_at_a_random_moment_the_file_is_sound_and_the_run_goes_on_bit_for_bit(
    kills, undisturbed, tmp_path
):
    path, moments = tmp_path / "run.nc", np.random.default_rng(kills)
    done, before, grown, longest = 0, 0, 0, LONGEST
    while done < kills:
        if not killed_run(path, moments.uniform(0.0, longest)):
            longest *= SOONER
            assert samples_in(path, undisturbed) == len(undisturbed["time"])
            path.unlink()
            checkpoint_path(path).unlink()
            before = 0
            continue
        done += 1
        count = samples_in(path, undisturbed) if path.exists() else 0
        grown += count > before
        longest *= LATER if count <= before else 1.0
        before = count
    resume = ["--resume"] if checkpoint_path(path).exists() else []
    assert run_main([*OPTIONS, str(path), *resume]) == 0
    assert samples_in(path, undisturbed) == len(undisturbed["time"])
    assert grown >= kills // 5  # most kills hit a run that was under way
    assert {entry.name for entry in tmp_path.iterdir()} == {"run.nc", "run.nc.checkpoint"}
