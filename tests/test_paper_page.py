"""The pieces of docs/paper.md that are computed, not run: the hub's frequency, ranges."""

import numpy as np
import pytest

from lagrange.scene.scene import read_scene
from tests.paper import __main__ as page
from tests.paper.variants import VARIANTS, strongest


def test_the_papers_sink_and_its_rattle_are_one_frequency():
    assert page.SINKING == pytest.approx(2080.0, abs=5.0)
    assert page.RATTLE == pytest.approx(page.SINKING, rel=0.06)
    assert page.HARRIS_FORCE > 10e3, "N, of one roller, under 2 kN"


def test_every_variant_is_a_scene():
    assert len({variant.name for variant in VARIANTS}) == len(VARIANTS)
    assert all(read_scene(None, variant.settings).operation == read_scene().operation for variant in VARIANTS)


def test_numbers_are_written_plainly():
    numbers = {-2639.9: "−2640", 1.2e7: "1.2e7", 54321.0: "54321", -0.0: "0"}
    assert {number: page.text(number) for number in numbers} == numbers
    assert page.span((-1e-6, 2.5e-6), 1e6) == "−1 … 2.5"


def test_the_strongest_line_is_found_below_a_frequency():
    time = np.arange(6000) * 1e-5
    record = 5.0 + np.sin(2.0 * np.pi * 2000.0 * time) + 0.1 * np.sin(2.0 * np.pi * 100.0 * time)
    assert strongest(record, 1e-5) == pytest.approx(2000.0, abs=1.0)
    assert strongest(record, 1e-5, 300.0) == pytest.approx(100.0, abs=1.0)
