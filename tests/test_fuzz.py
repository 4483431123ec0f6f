"""Short form of `python -m tests.fuzz`: every reader takes what is sound and refuses the rest in a sentence."""

import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lagrange.files.hdf5 import refusal_in_child
from tests.fuzz.mutations import MUTATIONS
from tests.fuzz.sound import seeds
from tests.fuzz.targets import NAMES, Targets

ROOT = Path(__file__).parent.parent
CORPUS = ROOT / "tests" / "fuzz" / "corpus"  # a folder a reader
EXAMPLES = {
    "scene": 300,
    "heights": 40,
    "speeds": 20,
    "loads": 20,
    "study": 30,
    "folder": 100,
    "table": 150,
    "result": 30,
    "fields": 15,
    "matrices": 100,
    "checkpoint": 80,
    "record_text": 40,
    "record_wav": 60,
    "record_numpy": 60,
    "record_matlab": 15,
}


@pytest.fixture(scope="module")
def sound():
    return {name: seeds(name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_what_the_fuzzer_starts_from_is_taken(name, sound, tmp_path):
    assert all(getattr(Targets(tmp_path), name)(seed) for seed in sound[name])


@pytest.mark.parametrize("name", NAMES)
def test_changed_files_are_taken_or_refused_in_a_sentence(name, sound, tmp_path, monkeypatch):
    monkeypatch.setattr("residual.sources.READ_SECONDS", 10.0)  # the target lowers it
    target = getattr(Targets(tmp_path), name)
    ends = set()

    @settings(max_examples=EXAMPLES[name], derandomize=True, deadline=None, database=None,
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(st.randoms(use_true_random=False), st.integers(1, 3))
    def check(random, times):
        data = random.choice(sound[name])
        for _ in range(times):
            data = MUTATIONS[name](data, random)
        ends.add(target(data))

    check()
    # changes go neither unnoticed nor always as far as a refusal; of a checkpoint, checksummed, 4 in 100 are harmless
    assert False in ends
    assert True in ends or name == "checkpoint"


@pytest.mark.parametrize("name", NAMES)
def test_any_bytes_are_refused_in_a_sentence(name, tmp_path, monkeypatch):
    monkeypatch.setattr("residual.sources.READ_SECONDS", 10.0)
    target = getattr(Targets(tmp_path), name)

    @settings(max_examples=50, derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(st.binary(max_size=300))
    def check(data):
        assert not target(data) or name == "scene"  # an empty scene is one

    check()


@pytest.mark.parametrize("path", sorted(CORPUS.rglob("*.*")), ids=lambda path: f"{path.parent.name}/{path.name}")
def test_inputs_that_once_found_something_are_taken_or_refused_in_a_sentence(path, tmp_path):
    getattr(Targets(tmp_path), path.parent.name)(path.read_bytes())


def test_memory_and_time_are_bounded_in_the_child():
    """What HDF5 made of inputs the fuzzer found: gigabytes, and loops without end."""

    def greedy():
        np.ones(2**28)  # 2 GiB

    def endless():
        while True:
            pass

    def crashing():
        os.kill(os.getpid(), signal.SIGSEGV)

    def refusing():
        raise ValueError("said by the reader")

    assert "memory" in refusal_in_child(greedy, "a.nc", 5.0, 2**28)
    assert "does not end in 0.2 s" in refusal_in_child(endless, "a.nc", 0.2, 2**28)
    assert "crashes the HDF5 library (SIGSEGV)" in refusal_in_child(crashing, "a.nc", 5.0, 2**28)
    assert refusal_in_child(refusing, "a.nc", 5.0, 2**28) == "said by the reader"
    assert refusal_in_child(lambda: None, "a.nc", 5.0, 2**28) is None
    assert "ends the process (exit code 77)" in refusal_in_child(lambda: os._exit(77), "a.nc", 5.0, 2**28)


def test_a_crash_is_told_where_the_program_around_handles_crashes_itself():
    before = signal.signal(signal.SIGSEGV, lambda *_: os._exit(0))
    try:
        told = refusal_in_child(lambda: os.kill(os.getpid(), signal.SIGSEGV), "a.nc", 5.0, 2**28)
    finally:
        signal.signal(signal.SIGSEGV, before)
    assert "crashes the HDF5 library (SIGSEGV)" in told


def test_a_lower_limit_of_the_user_is_no_reason_to_refuse():
    code = "from lagrange.files.hdf5 import refusal_in_child as r; print(r(lambda: None, 'a.nc', 5.0, 2**40))"
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (2**32, 2**32))  # noqa: E731
    done = subprocess.run([sys.executable, "-c", code], preexec_fn=limit, capture_output=True, text=True, cwd=ROOT)
    assert done.stdout.strip() == "None", done.stderr
