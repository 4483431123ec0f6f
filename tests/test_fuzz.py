"""Every reader of text and of records takes what is sound and refuses the rest in a sentence."""

from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from tests.fuzz import targets
from tests.fuzz.mutations import MUTATIONS
from tests.fuzz.targets import NAMES, Targets

CORPUS = Path(__file__).parent / "fuzz" / "corpus"  # a folder a reader
EXAMPLES = {"scene": 300, "heights": 80, "speeds": 30, "loads": 30, "study": 50, "folder": 100, "table": 150,
            "record_text": 40, "record_wav": 60, "record_numpy": 60}  # fmt: skip
every_reader = pytest.mark.parametrize("name", NAMES)
seeds = cache(targets.seeds)


def drawn(examples):
    """So many, whose numbers don't depend on the text of the test, as with `derandomize`."""
    usual = {"deadline": None, "database": None, "suppress_health_check": list(HealthCheck)}
    return lambda test: seed(1)(settings(max_examples=examples, **usual)(test))


@every_reader
def test_what_the_fuzzer_starts_from_is_taken(name, tmp_path):
    assert all(Targets(tmp_path)(name, data) for data in seeds(name))


@every_reader
def test_changed_files_are_taken_or_refused_in_a_sentence(name, tmp_path):
    target, ends = Targets(tmp_path), set()

    @drawn(EXAMPLES[name])
    @given(st.randoms(use_true_random=False), st.integers(1, 3))
    def check(random, times):
        data = random.choice(seeds(name))
        for _ in range(times):
            data = MUTATIONS[name](data, random)
        ends.add(target(name, data))

    check()
    assert ends == {False, True}  # changes go neither unnoticed nor always as far as a refusal


@every_reader
def test_any_bytes_are_refused_in_a_sentence(name, tmp_path):
    target = Targets(tmp_path)

    @drawn(50)
    @given(st.binary(max_size=300))
    def check(data):
        assert not target(name, data) or name == "scene"  # an empty scene is one

    check()


@pytest.mark.parametrize("path", sorted(CORPUS.rglob("*.*")), ids=lambda path: f"{path.parent.name}/{path.name}")
def test_inputs_that_once_found_something_are_taken_or_refused_in_a_sentence(path, tmp_path):
    Targets(tmp_path)(path.parent.name, path.read_bytes())
