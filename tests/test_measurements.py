"""Measurements of the handbook: pages quote the numbers of their tables, and tables say where they are from."""

import pytest

from lagrange.columns import FORMAT_VERSION
from lagrange.version import VERSION
from tests import measurements
from tests.measurements import (
    HEAD,
    MEASURED,
    QUOTE,
    cell_of,
    heads,
    markdown_table,
    marked,
    measured_by,
    measurement_pages,
    quotes,
    reader_pages,
    refreshed,
)

TABLE = markdown_table(("case", "model", "error"), [("steady", "fem", "+0.043 %"), ("", "reduced", "2.4·10⁻⁷ (3)")])


@pytest.fixture
def page(tmp_path):
    """A page that quotes two cells of a table."""
    (tmp_path / "measurements").mkdir()
    (tmp_path / "measurements" / "one.md").write_text(f"# One\n\n## Some runs\n\n{TABLE}\n", encoding="utf-8")
    path = tmp_path / "page.md"
    path.write_text(
        'Errors of [0.04 %](measurements/one.md#some-runs "steady · fem: error") and '
        '[2·10⁻⁷](measurements/one.md#some-runs "steady · reduced: error").\n',
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize("page", reader_pages(), ids=lambda path: path.name)
def test_numbers_of_a_page_are_those_of_the_tables(page):
    for quote in quotes(page):
        assert quote.text == quote.right, f"{quote.cell}; python -m tests.measurements brings pages in line"


def front_page():
    """Sections of README that quote measurements."""
    text = (measurements.ROOT / "README.md").read_text(encoding="utf-8")
    return [each for each in text.split("\n## ") if QUOTE.search(each)]


def test_the_front_page_says_which_version_on_which_processor_was_measured():
    page = measurements.ROOT / "README.md"
    assert len(front_page()) >= 2
    for section in front_page():
        assert [found[0] for found in MEASURED.finditer(section)] == [measured_by(page, section)]


def test_the_front_page_quotes_measurements_of_this_version():
    page = measurements.ROOT / "README.md"
    for section in front_page():
        for head in heads(page, section):
            assert head["version"] == VERSION, f"{head['command']} measures it again"
            assert "not recorded" not in head["processor"]


def test_the_pages_quote_measurements():
    quoted = {page.name: len(list(quotes(page))) for page in reader_pages()}
    assert quoted["README.md"] >= 5 and sum(quoted.values()) >= 60


def test_a_changed_digit_is_found_on_the_page_and_in_the_table(page):
    assert all(quote.text == quote.right for quote in quotes(page))
    page.write_text(page.read_text().replace("[0.04 %]", "[0.05 %]"))
    wrong = [quote for quote in quotes(page) if quote.text != quote.right]
    assert [(quote.text, quote.right) for quote in wrong] == [("0.05 %", "0.04 %")]
    table = page.parent / "measurements" / "one.md"
    table.write_text(table.read_text().replace("2.4·10", "2.6·10"))
    assert "[0.04 %](" in refreshed(page) and "[3·10⁻⁷](" in refreshed(page)


@pytest.mark.parametrize("cell", ["steady · fem: mean", "steady · lagrange: error", "transient: error"])
def test_a_cell_that_is_gone_is_named(page, cell):
    with pytest.raises(ValueError, match=cell):
        cell_of(page.parent / "measurements" / "one.md", "some-runs", cell)


@pytest.mark.parametrize("page", measurement_pages(), ids=lambda path: path.name)
def test_every_table_says_where_it_is_from_and_whether_it_is_old(page):
    text = page.read_text(encoding="utf-8")
    sections = text.split("\n## ")[1:]
    for section in sections:
        found = HEAD.search(section)
        assert found, f"{page.name}, {section.splitlines()[0]}: no command, date, version, format and processor"
        assert tuple(map(int, found["version"].split("."))) <= tuple(map(int, VERSION.split(".")))
        assert int(found["format"]) <= FORMAT_VERSION
    assert sections or page.stem == "index"
    assert marked(page) == text, "older than the result format; python -m tests.measurements marks it"


def test_a_table_older_than_the_result_format_is_marked(tmp_path, monkeypatch):
    monkeypatch.setattr(measurements, "DOCS", tmp_path)
    path = tmp_path / "measurements" / "one.md"
    path.parent.mkdir()
    path.write_text("# One\n")
    measurements.publish("one", "Runs", "python -m some.command", TABLE, write=True)
    assert marked(path) == path.read_text(encoding="utf-8")
    monkeypatch.setattr(measurements, "FORMAT_VERSION", FORMAT_VERSION + 1)
    assert f"Older than result format {FORMAT_VERSION + 1}.*" in marked(path)


def test_a_section_is_replaced_and_its_neighbours_stay(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Page\n\nWords.\n\n## One\n\nold\n\n### Part\n\nold too\n\n## Other\n\nkept\n")
    measurements.write_section(page, "One", "new")
    assert page.read_text() == "# Page\n\nWords.\n\n## One\n\nnew\n\n## Other\n\nkept\n"
    measurements.write_section(page, "Third", "added")
    assert page.read_text().endswith("## Other\n\nkept\n\n## Third\n\nadded\n")
