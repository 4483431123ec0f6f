"""README and docs: links lead somewhere, scenes are scenes, commands are commands, and print what is shown."""

import importlib.util
import re
import shlex
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

from fem.commands.rate_bearing import rate_app, rate_main
from fem.commands.render_fem import render_app, render_main
from fem.commands.run_fem import live_app, run_app, run_main
from fem.commands.run_study import study_app
from lagrange.scene.keys import key_tables
from lagrange.scene.scene import parse_scene_text
from residual.check_vibration import app as vibration_app
from residual.cli import app as check_app
from residual.cli import main as check_main
from tests import documented
from tests.documented import blocks, same

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
APPS = {
    "run-fem": run_app,
    "check-residual": check_app,
    "check-vibration": vibration_app,
    "render-fem": render_app,
    "run-live": live_app,
    "run-study": study_app,
    "rate-bearing": rate_app,
}
MAINS = {"run-fem": run_main, "check-residual": check_main, "render-fem": render_main, "rate-bearing": rate_main}
MOST_WORDS = 900


def read(path):
    return path.read_text(encoding="utf-8")


def handbook():
    """docs/handbook.py, which mkdocs runs."""
    spec = importlib.util.spec_from_file_location("handbook", ROOT / "docs" / "handbook.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def anchors(path):
    """Of a page's headings, as sites and GitHub make them."""
    headings = re.findall(r"^#+ (.+)$", re.sub(r"^```.*?^```", "", read(path), flags=re.M | re.S), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)
def test_links_lead_somewhere(page):
    made = set(handbook().NAMES)
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", read(page))):
        if target.startswith(("http:", "https:")):
            continue
        name, _, anchor = target.partition("#")
        if page.parent.name == "docs" and name in made:
            continue
        path = (page.parent / name).resolve() if name else page
        assert path.exists(), target
        if page.parent.name == "docs":
            assert path.is_relative_to(ROOT / "docs"), f"{target}: the site has the files of docs/ only"
        if anchor:
            assert anchor in anchors(path), target


def test_the_sites_pages_are_there():
    text = read(ROOT / "mkdocs.yml")
    named = set(re.findall(r"([\w/]+\.md)", text[text.index("nav:\n  - Home") :]))
    made = set(handbook().NAMES)
    assert named and {name for name in named - made if not (ROOT / "docs" / name).is_file()} == set()
    assert made <= named


def test_the_readme_is_short():
    text = re.sub(r"\]\([^)]*\)", "]", read(ROOT / "README.md"))
    assert len(text.split()) <= MOST_WORDS


WITH_SCENES = [page for page in PAGES if page.name != "studies.md" and blocks(page, "toml")]  # studies': see its tests


@pytest.mark.parametrize("page", WITH_SCENES, ids=lambda path: path.name)
def test_the_scenes_shown_are_scenes(page):
    assert {"README.md", "first_bearing.md"} <= {each.name for each in WITH_SCENES}
    for text in blocks(page, "toml"):
        parse_scene_text(text, page.name)


def modules_run():
    """Every `python -m` of ours that a page names, but for placeholders."""
    named = {name for page in PAGES for name in re.findall(r"python -m ((?:benchmarks|tests|fem)[\w.]*)", read(page))}
    return sorted(name for name in named if not name.endswith(".NAME"))


@pytest.mark.parametrize("name", modules_run())
def test_the_programs_that_pages_name_are_there(name):
    assert importlib.util.find_spec(name) is not None


def command_lines():
    """Every command that a page shows, in a block or in the table of recipes."""
    for page in PAGES:
        lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
        if page.name == "recipes.md":
            lines += re.findall(r"`([^`]+)`", read(page))
        for line in lines:
            words = shlex.split(line, comments=True)
            if words and words[0] in APPS and not any(word in words for word in ("|", ">", "&&")):
                yield pytest.param(words, id=f"{page.stem}: {' '.join(words)}"[:70])


@pytest.mark.parametrize("words", list(command_lines()))
def test_the_commands_shown_are_commands(words):
    APPS[words[0]].parse_args(words[1:], exit_on_error=False, print_error=False)


@pytest.mark.parametrize("page", documented.PAGES)
def test_sentences_quote_what_is_printed(page):
    assert list(documented.unfounded(read(ROOT / page))) == []


def test_every_page_that_shows_output_is_compared_with_it():
    showing = {str(page.relative_to(ROOT)) for page in PAGES if documented.OUTPUT.search(read(page))}
    assert {"README.md", "docs/vibration_tutorial.md", "docs/rating.md"} <= showing <= set(documented.PAGES)
    assert not [page.name for page in PAGES if any("$ " in text for text in blocks(page, "text"))]


SHOWN = """## Diagnosis

```sh
check-vibration record.npz
```

```text
Verdict: outer_ring. The outer ring is damaged.
…
BPFO at 232.66 Hz (-1.38 % from its kinematic place): …
60 ms in 0.04 s
```

The verdict is "The outer ring is damaged": a line at 232.7 Hz.
"""
PRINTED = """Verdict: outer_ring. The outer ring is damaged.
Record: 0.5 s
BPFO at 232.66 Hz (-1.38 % from its kinematic place): 4.8 standard deviations
60 ms in 0.91 s
"""


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("232.66", "232.66", 0),
        ("232.66", "232.67", 0),  # a unit of the last digit
        ("232.66", "232.68", 1),
        ("outer_ring. The", "none. The", 1),
        ("-1.38 %", "-1.38 °", 1),
        ("Record: 0.5 s\n", "", 0),
        ("60 ms in 0.91 s\n", "", 1),
        ("0.91 s\n", "0.91 s\nWarning: steel yields\n", 1),
    ],
)
def test_a_changed_verdict_word_or_digit_is_found(old, new, found):
    printed = {"check-vibration record.npz": PRINTED.replace(old, new)}
    assert len(list(documented.differences(SHOWN, printed))) == found


@pytest.mark.parametrize(("old", "new"), [("at 232.7 Hz", "at 232.8 Hz"), ('ring is damaged"', 'ring is sound"')])
def test_a_sentence_that_the_output_does_not_bear_is_found(old, new):
    assert list(documented.unfounded(SHOWN)) == []
    assert len(list(documented.unfounded(SHOWN.replace(old, new)))) == 1


def test_a_page_may_show_fewer_digits_than_are_printed():
    page = SHOWN.replace("232.66 Hz (-1.38", "233 Hz (-1.4")
    printed = {"check-vibration record.npz": PRINTED.replace("232.66", "235.24").replace("-1.38", "-1.52")}
    assert len(list(documented.differences(page, printed))) == 1
    assert "BPFO at 235 Hz (-1.5 % from" in documented.rewritten(page, printed)


def test_a_page_is_made_from_what_is_printed():
    printed = {"check-vibration record.npz": PRINTED.replace("232.66", "235.04").replace("-1.38", "0.37")}
    page = documented.rewritten(SHOWN, printed)
    assert "BPFO at 235.04 Hz (0.37 % from its kinematic place): …\n60 ms in 0.91 s" in page
    assert "a line at 235.0 Hz" in page
    assert [*documented.differences(page, printed), *documented.unfounded(page)] == []


def tutorial():
    return [
        shlex.split(line) for block in blocks(ROOT / "docs" / "first_bearing.md", "sh") for line in block.splitlines()
    ]


@pytest.mark.slow  # the plain installation of `.ci/run` types them as well
@pytest.mark.usefixtures("plain_report")
def test_the_tutorials_commands_run_in_order(tmp_path, monkeypatch, capsys):
    """But for the picture and the spall, which the next test tries."""
    monkeypatch.chdir(tmp_path)
    for name, *arguments in tutorial():
        if name != "render-fem" and "spall" not in " ".join(arguments):
            assert MAINS[name](arguments) == 0
    assert {path.name for path in (tmp_path / "runs").iterdir()} >= {"NU206.nc", "NU206-clearance_um-30.nc"}
    assert (tmp_path / "runs" / "NU206-residual" / "report.html").is_file()


@pytest.mark.slow
def test_the_whole_tutorial_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, *arguments in tutorial():
        assert MAINS[name](arguments) == 0


def test_the_handbook_knows_every_key_command_and_package():
    module = handbook()
    pages = module.pages()
    assert tuple(pages) == module.NAMES
    for table in key_tables():
        assert not table.name or f"[{table.name}]" in pages["reference/scene.md"]
        for key in table.keys:
            assert f"| `{key.name}` |" in pages["reference/scene.md"]
    project = tomllib.loads(read(ROOT / "pyproject.toml"))
    for name in project["project"]["scripts"]:
        assert f"## {name}\n\n```text\nUsage: {name}" in pages["reference/commands.md"]
    for variable in ("inner_force", "roller_turn"):
        assert f"| `{variable}` |" in pages["reference/result.md"]


def test_the_front_page_shows_a_command_with_its_output_and_links_the_reference():
    page = SimpleNamespace(file=SimpleNamespace(src_uri="index.md"))
    source = read(ROOT / "docs" / "index.md")
    shown = handbook().on_page_markdown(source, page, None, None)
    assert blocks(ROOT / "README.md", "text")[0] in shown and "\nrun-fem motor.toml" in shown
    assert [name for name in handbook().NAMES if f"]({name})" not in source] == []


def test_keys_of_the_site_do_not_break_inside_a_word_and_code_blocks_stay():
    page = SimpleNamespace(file=SimpleNamespace(src_uri="reference/scene.md"))
    content = "<p><code>run-fem --set a.b=1</code></p><pre><code>a-b c</code></pre>"
    shown = handbook().on_page_content(content, page, None, None)
    assert [re.sub("<.*?>", "", word) for word in re.findall('<span class="word">.*?</span>', shown)] == [
        "run-fem", "--set", "a.b=1"]  # fmt: skip
    assert "<pre><code>a-b c</code></pre>" in shown and shown.startswith('<div class="reference">')


@pytest.mark.parametrize("picture", sorted((ROOT / "docs").glob("*.png")), ids=lambda path: path.name)
def test_pictures_have_their_own_colours(picture):
    """Not a palette's nearest: red arrows were brown, scales had steps and lacked their ends."""
    from PIL import Image

    with Image.open(picture) as image:
        assert image.mode in ("RGB", "RGBA")


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    pytest.importorskip("material")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    build(load_config(str(ROOT / "mkdocs.yml"), strict=True, site_dir=str(tmp_path)))
    assert (tmp_path / "reference" / "scene" / "index.html").is_file()


def test_equations_that_the_code_cites_stand_on_their_pages():
    cited = [
        (found["page"], found["number"])
        for package in ("lagrange", "meshes", "fem", "residual")
        for module in sorted((ROOT / package).rglob("*.py"))
        for found in re.finditer(r"Equation \((?P<number>\w+)\) of (?P<page>docs/\w+\.md)", read(module))
    ]
    assert len(cited) > 20
    for page, number in cited:
        assert rf"\tag{{{number}}}" in read(ROOT / page), f"{page} has no equation ({number})"


# Every example of the pages about Python is run, one page after the other from top to bottom


DOCS = Path(__file__).parent.parent / "docs"


@pytest.mark.parametrize("page", ["python.md"])
def test_every_example_runs_and_prints_what_its_comments_say(page, tmp_path, monkeypatch):
    """A comment on the line after a `print` is what that prints."""
    monkeypatch.chdir(tmp_path)
    compared, lines = 0, []

    def compare(*values):
        nonlocal compared
        after = lines[sys._getframe(1).f_lineno].strip()
        if after.startswith("# "):
            assert same(after[2:], " ".join(map(str, values)))
            compared += 1

    names: dict[str, object] = {"print": compare}
    for number, text in enumerate(blocks(DOCS / page, "python")):
        lines[:] = [*text.splitlines(), "", ""]
        exec(compile(text, f"{page}, example {number}", "exec"), names)
    assert compared >= 3
