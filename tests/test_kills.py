"""kill -9 at random moments: the file stays readable by plain h5py, and the resumed run is the undisturbed one.

A moment is a number of calls to the system that write, sync or move, so that a machine under load is no other test.
"""

import itertools
import os
import signal

import h5py
import numpy as np
import pytest

from fem.commands.run_fem import run_main
from fem.result.checkpoint import checkpoint_path
from fem.result.run_file import GROUP, stored_samples
from fem.solver import simulate
from lagrange.columns import columns_of

OPTIONS = [
    "--mesh-size", "2", "--quiet", "--duration", "12", "--checkpoint", "0", "--set", "output.fields_every_ms=1",
    "--output",
]  # fmt: skip
BLOCK = 20  # samples between two checkpoints, of 1201
COUNTER = 8  # bytes, which reach a file whole
WRITE = os.write
LONGEST = 3000  # calls until a kill at the most; a block makes some 120


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "whole.nc"
    assert run_main([*OPTIONS, str(path)]) == 0
    with h5py.File(path) as file:
        fields = {f"{GROUP}/{name}": variable[:] for name, variable in file[GROUP].items()}
        return {name: file[name][:] for name in columns_of("")} | fields


def killed_run(path, moment):
    """A leg of the run in a process of its own, which is killed in a call; whether it was before the leg's end."""
    child = os.fork()
    if child == 0:
        try:
            die_in_call(moment)
            os._exit(run_main([*OPTIONS, str(path), *(["--resume"] if checkpoint_path(path).exists() else [])]))
        finally:
            os._exit(70)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)


def die_in_call(moment):
    """Have this process killed in its call of that number; of a longer write a part has been made by then."""
    calls = itertools.count()
    simulate.size_of_block = lambda *_: BLOCK

    def counted(call):
        def made(*arguments, **options):
            if next(calls) == moment:
                if call is WRITE and len(arguments[1]) > COUNTER:
                    call(arguments[0], arguments[1][: len(arguments[1]) // 2])
                os.kill(os.getpid(), signal.SIGKILL)
            return call(*arguments, **options)

        return made

    for name in ("write", "fsync", "replace"):
        setattr(os, name, counted(getattr(os, name)))


def samples_in(path, undisturbed):
    """How many samples a file holds, by plain h5py; all must be those of the undisturbed run."""
    with h5py.File(path, "r") as file:
        count = int(file.attrs["committed_samples"])
        assert file.attrs["status"] in ("running", "complete")
        for name in columns_of(""):
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
    done, before, grown = 0, 0, 0
    while done < kills:
        if not killed_run(path, int(moments.integers(LONGEST))):
            assert samples_in(path, undisturbed) == len(undisturbed["time"])
            path.unlink()
            checkpoint_path(path).unlink()
            before = 0
            continue
        done += 1
        count = samples_in(path, undisturbed) if path.exists() else 0
        grown += count > before
        before = count
    resume = ["--resume"] if checkpoint_path(path).exists() else []
    assert run_main([*OPTIONS, str(path), *resume]) == 0
    assert samples_in(path, undisturbed) == len(undisturbed["time"])
    assert grown >= kills // 2  # kills hit runs that were under way
    assert {entry.name for entry in tmp_path.iterdir()} == {"run.nc", "run.nc.checkpoint"}
