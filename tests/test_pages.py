"""Pages of docs/ that commands write."""

from tests import pages


def test_a_section_is_replaced_and_its_neighbours_stay(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "DOCS", tmp_path)
    page = tmp_path / "page.md"
    page.write_text("# Page\n\nWords.\n\n## One\n\nold\n\n### Part\n\nold too\n\n## Other\n\nkept\n")
    pages.write_section("page.md", "One", "new")
    assert page.read_text() == "# Page\n\nWords.\n\n## One\n\nnew\n\n## Other\n\nkept\n"
    pages.write_section("page.md", "Third", "added")
    assert page.read_text().endswith("## Other\n\nkept\n\n## Third\n\nadded\n")
