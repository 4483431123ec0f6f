"""Every reader of text and of records takes what is sound and refuses the rest in a sentence."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

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
    "record_text": 40,
    "record_wav": 60,
    "record_numpy": 60,
}


@pytest.fixture(scope="module")
def sound():
    return {name: seeds(name) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_what_the_fuzzer_starts_from_is_taken(name, sound, tmp_path):
    assert all(getattr(Targets(tmp_path), name)(seed) for seed in sound[name])


@pytest.mark.parametrize("name", NAMES)
def test_changed_files_are_taken_or_refused_in_a_sentence(name, sound, tmp_path):
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
    assert ends == {False, True}  # changes go neither unnoticed nor always as far as a refusal


@pytest.mark.parametrize("name", NAMES)
def test_any_bytes_are_refused_in_a_sentence(name, tmp_path):
    target = getattr(Targets(tmp_path), name)

    @settings(max_examples=50, derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    @given(st.binary(max_size=300))
    def check(data):
        assert not target(data) or name == "scene"  # an empty scene is one

    check()


@pytest.mark.parametrize("path", sorted(CORPUS.rglob("*.*")), ids=lambda path: f"{path.parent.name}/{path.name}")
def test_inputs_that_once_found_something_are_taken_or_refused_in_a_sentence(path, tmp_path):
    getattr(Targets(tmp_path), path.parent.name)(path.read_bytes())
