"""The fast cases of `python -m tests.verification`; the suite itself notices what fails; its own references."""

from math import inf, nan
from unittest.mock import ANY

import numpy as np
import pytest

from tests import measurements
from tests.reference.kit import STEEL
from tests.reference.modes import LARGEST_ROOT, _far_load, disc_modes, static_compliance, thrown_at_flat
from tests.verification import Case, Check, run_case
from tests.verification import __main__ as command


@pytest.mark.parametrize("case", [case for case in command.CASES if case.fast], ids=lambda case: case.name)
def test_case(case):
    outcome = run_case(case)
    assert not outcome.trouble
    assert [check for check in outcome.checks if not check.passed] == []
    assert outcome.passed


def check_of(computed, reference=2.0, tolerance=0.01, **more):
    return Check("length", "m", computed, reference, tolerance, "analytic: a book", **more)


def test_a_check_passes_within_its_tolerance_only():
    assert check_of(2.019).passed and check_of(1.981).passed
    for wrong in (2.021, 1.979, nan, inf, -2.0):
        assert not check_of(wrong).passed
    assert check_of(-2.01, reference=-2.0).error == pytest.approx(-0.005)
    assert check_of(0.05, reference=0.0, scale=-10.0).error == pytest.approx(0.005)
    assert not check_of(0.0, reference=0.0).passed, "nothing to measure the error by"


def good():
    """A case that holds."""
    yield check_of(2.001)


def wrong():
    """A case that does not hold."""
    yield check_of(2.001)
    yield check_of(2.1)


def broken():
    """A case that can't be computed."""
    yield check_of(2.0)
    raise RuntimeError("no equilibrium")


def empty():
    """A case that looks at nothing."""
    return iter(())


def test_what_failed_is_seen_the_exit_code_tells_whether_all_passed_and_a_subjects_table_is_written(
    tmp_path, monkeypatch, capsys
):
    page = tmp_path / "measurements" / "verification.md"
    page.parent.mkdir()
    page.write_text("# Verification\n\n## Impact\n\nkept\n")
    monkeypatch.setattr(measurements, "DOCS", tmp_path)

    def told(*cases, options=()):
        monkeypatch.setattr(command, "CASES", [Case("a subject", case) for case in cases])
        monkeypatch.setattr("sys.argv", ["verification", *options])
        with pytest.raises(SystemExit) as ended:
            measurements.program(command.__doc__, "tests.verification", command.verification)
        return int(ended.value.code), capsys.readouterr().out

    assert told(good) == (0, ANY) and told(empty)[0] == 1
    code, text = told(good, wrong, broken)
    assert code == 1 and "FAILED: wrong, broken" in text and "+5 % FAILS" in text and "no equilibrium" in text
    assert page.read_text() == "# Verification\n\n## Impact\n\nkept\n"
    for later in ("", "\n## Other\n\nkept\n"):  # added at the end; replaced up to the next section
        page.write_text(page.read_text() + (later and f"\n### Part\n\nold\n{later}"))
        assert told(good, wrong, options=["a-subject", "--write"])[0] == 1
        text = page.read_text(encoding="utf-8")
        assert text.startswith("# Verification\n\n## Impact\n\nkept\n\n## A subject\n") and text.endswith(later)
        assert "### Part" not in text
    assert measurements.HEAD.search(text)["command"] == "python -m tests.verification a-subject --write"
    assert "| `good` | length | 2.001 m | 2 m | +0.05 % | 1 % | analytic: a book |" in text
    assert "| `wrong` | length | 2.001 m |" in text and "|  | length | 2.1 m | 2 m | +5 % FAILS |" in text


def test_names_are_cases_or_subjects_each_with_a_description_and_others_are_refused_in_one_line(monkeypatch, capsys):
    for words in (["discmodes"], ["disc-modes", "--write"]):
        monkeypatch.setattr("sys.argv", ["verification", *words])
        with pytest.raises(SystemExit, match="2"):
            next(command.verification(words[0]))
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("unknown case discmodes; cases: disc-modes, ") and second.startswith("--write takes whole")
    assert [case.name for case in command.named(["impact"])] == ["bouncing-bar", "thrown-roller", "ball-impact"]
    assert [case.name for case in command.named(["ring_modes", "disc-modes"])] == ["disc-modes", "ring-modes"]
    assert len({case.name for case in command.CASES}) == len(command.CASES) >= 20
    assert all(len(case.description) > 40 for case in command.CASES)


# the modal solution of the thrown roller


@pytest.mark.parametrize("n", [0, 1, 2, 3, 8])
def test_modes_of_a_disc_add_up_to_its_static_compliance(n):
    roots, compliance = disc_modes(n, STEEL)
    assert np.all(compliance > 0.0)
    share, cut = np.cumsum(compliance)[:-1] / static_compliance(n, STEEL), 0.5 * (roots[1:] + roots[:-1])
    assert share[-1] < 1.0
    # what the modes beyond a cut leave falls as 1/cut
    late = cut > 0.5 * LARGEST_ROOT
    assert np.polyfit(1.0 / cut[late], share[late], 1)[1] == pytest.approx(1.0, abs=0.02)


def test_the_far_loads_displacement_is_the_alternating_sum():
    terms = np.array([(-1) ** n * static_compliance(n, STEEL) for n in range(20_001)])
    wanted = terms.sum() - 0.5 * terms[-1]  # the mean of the last two partial sums
    assert _far_load(STEEL) == pytest.approx(wanted, rel=1e-8)


@pytest.mark.parametrize("speed", [0.1, 1.0])
def test_a_thrown_disc_returns_its_momentum_but_for_its_vibration(speed):
    assert 0.99 < thrown_at_flat(speed, 0.005, 0.01, STEEL).rebound < 1.0
