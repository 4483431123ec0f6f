"""Measurements of the handbook: pages quote the numbers of their tables, and tables say where they are from."""

import importlib
import re
import shlex

import pytest

from lagrange.columns import FORMAT_VERSION
from lagrange.version import VERSION
from tests import measurements
from tests.documented import PROGRAMS
from tests.measurements import HEAD, MEASURED, MEASUREMENT_PAGES, QUOTE, READER_PAGES, ROOT, quotes

FORMER = r"git show [0-9a-f]{8}:(tests|benchmarks|docs/studies)/[\w/]+\.py"  # a commit's tree that holds the program
TABLE = measurements.markdown_table(
    ("case", "model", "error"), [("steady", "fem", "+0.043 %"), ("", "reduced", "2.4·10⁻⁷ (3)")]
)


@pytest.fixture
def page(tmp_path):
    (tmp_path / "measurements").mkdir()
    (tmp_path / "measurements" / "one.md").write_text(f"# One\n\n## Some runs\n\n{TABLE}\n", encoding="utf-8")
    path = tmp_path / "page.md"
    path.write_text(
        'Errors of [0.04 %](measurements/one.md#some-runs "steady · fem: error") and '
        '[2·10⁻⁷](measurements/one.md#some-runs "steady · reduced: error").\n', encoding="utf-8"
    )  # fmt: skip
    return path


@pytest.mark.parametrize("page", READER_PAGES, ids=lambda path: path.name)
def test_numbers_of_a_page_are_those_of_the_tables(page):
    for quote in quotes(page):
        assert quote.text == quote.right, f"{quote.cell}; python -m tests.measurements brings pages in line"


def test_the_front_page_quotes_this_version_and_says_on_which_processor_it_was_measured():
    page = ROOT / "README.md"
    sections = [each for each in page.read_text(encoding="utf-8").split("\n## ") if QUOTE.search(each)]
    assert len(sections) >= 2 and len(list(quotes(page))) >= 5
    for section in sections:
        assert [found[0] for found in MEASURED.finditer(section)] == [measurements.measured_by(page, section)]
        for head in measurements.heads(page, section):
            assert head["version"] == VERSION, f"{head['command']} measures it again"
            assert "not recorded" not in head["processor"]
    assert sum(len(list(quotes(page))) for page in READER_PAGES) >= 60


def test_a_changed_digit_is_found_on_the_page_and_in_the_table(page):
    assert all(quote.text == quote.right for quote in quotes(page))
    page.write_text(page.read_text().replace("[0.04 %]", "[0.05 %]"))
    wrong = [quote for quote in quotes(page) if quote.text != quote.right]
    assert [(quote.text, quote.right) for quote in wrong] == [("0.05 %", "0.04 %")]
    table = page.parent / "measurements" / "one.md"
    table.write_text(table.read_text().replace("2.4·10", "2.6·10"))
    refreshed = measurements.refreshed(page)
    assert "[0.04 %](" in refreshed and "[3·10⁻⁷](" in refreshed
    for cell in ("steady · fem: mean", "steady · lagrange: error", "transient: error"):
        with pytest.raises(ValueError, match=cell):
            measurements.cell_of(table, "some-runs", cell)


@pytest.mark.parametrize("page", MEASUREMENT_PAGES, ids=lambda path: path.name)
def test_every_table_says_where_it_is_from(page):
    text = page.read_text(encoding="utf-8")
    sections = text.split("\n## ")[1:]
    for section in sections:
        found = HEAD.search(section)
        assert found, f"{page.name}, {section.splitlines()[0]}: no command, date, version, format and processor"
        assert tuple(map(int, found["version"].split("."))) <= tuple(map(int, VERSION.split(".")))
        assert int(found["format"]) <= FORMAT_VERSION
    assert sections or page.stem == "index"


@pytest.mark.parametrize("page", MEASUREMENT_PAGES, ids=lambda path: path.name)
def test_the_commands_that_tables_are_from_are_there(page):
    for found in HEAD.finditer(page.read_text(encoding="utf-8")):
        python, *words = shlex.split(found["command"])
        if found["former"] or python == "git":
            assert found["former"] and re.fullmatch(FORMER, found["command"])
        elif words[:2] == ["-m", "pytest"]:
            assert [name for name in words[2:] if not (ROOT / name).is_file()] == [], found[0]
        elif words[:1] == ["-m"]:
            module = importlib.util.find_spec(words[1])
            assert module, found[0]
            module = importlib.util.find_spec(f"{words[1]}.__main__") if module.submodule_search_locations else module
            text, section = ROOT.joinpath(module.origin).read_text(encoding="utf-8"), (words[2:] or ["--write"])[0]
            if section.startswith("-") or words[1] == "tests.verification":
                continue
            assert section.isupper() or f"def {section.replace('-', '_')}(" in text or f'"{section}"' in text, found[0]
        else:  # a program of ours, a script of a page, or words
            assert python in PROGRAMS or python != "python" or words[0] == "spalls.py", found[0]
