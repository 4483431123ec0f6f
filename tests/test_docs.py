"""README and docs: links lead somewhere, scenes are scenes, commands are commands, and print what is shown."""

import importlib.util
import re
import shlex
import sys
import tomllib
from types import SimpleNamespace

import h5py
import pytest

from fem.commands import rate_bearing, render_fem, run_fem, run_study
from lagrange.scene.keys import key_tables
from lagrange.scene.scene import parse_scene_text
from residual import check_vibration, cli
from tests import documented
from tests.documented import ROOT, blocks
from tests.measurements import DOCS, MEASUREMENT_PAGES, slug

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted(DOCS.glob("*.md"))]
APPS = {
    "run-fem": run_fem.run_app, "check-residual": cli.app, "check-vibration": check_vibration.app,
    "render-fem": render_fem.render_app, "run-live": run_fem.live_app, "run-study": run_study.study_app,
    "rate-bearing": rate_bearing.rate_app,
}  # fmt: skip
MOST_WORDS = 900
every_page = pytest.mark.parametrize("page", PAGES, ids=lambda path: path.name)


def read(path):
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def handbook():
    """docs/handbook.py, which mkdocs runs."""
    spec = importlib.util.spec_from_file_location("handbook", DOCS / "handbook.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("page", [*PAGES, *MEASUREMENT_PAGES], ids=lambda path: path.name)
def test_links_lead_somewhere(page, handbook):
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", read(page))):
        name, _, anchor = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        if target.startswith(("http:", "https:")) or path in {DOCS / made for made in handbook.NAMES}:
            continue
        assert path.exists(), target
        in_site = not page.is_relative_to(DOCS) or path.is_relative_to(DOCS)
        assert in_site, f"{target}: the site has the files of docs/ only"
        if anchor:
            text = re.sub(r"^```.*?^```", "", read(path), flags=re.M | re.S)
            assert anchor in map(slug, re.findall(r"^#+ (.+)$", text, re.M)), target


def test_the_sites_pages_are_there_and_the_readme_is_short(handbook):
    text = read(ROOT / "mkdocs.yml")
    named, made = set(re.findall(r"([\w/]+\.md)", text[text.index("nav:\n  - Home") :])), set(handbook.NAMES)
    assert named and {name for name in named - made if not (DOCS / name).is_file()} == set()
    assert made <= named
    assert len(re.sub(r"\]\([^)]*\)", "]", read(ROOT / "README.md")).split()) <= MOST_WORDS


@every_page
def test_the_scenes_shown_are_scenes_and_the_programs_named_are_there(page):
    scenes = blocks(page, "toml")
    assert scenes or page.name not in ("README.md", "first_bearing.md")
    for text in scenes if page.name != "studies.md" else ():  # studies': see its tests
        parse_scene_text(text, page.name)
    now = read(page) if page.name != "CHANGELOG.md" else ""  # where programs of former versions are named
    for name in re.findall(r"python -m ((?:benchmarks|tests|fem)[\w.]*)", now):
        assert name.endswith(".NAME") or importlib.util.find_spec(name) is not None, name


def command_lines():
    """Every command that a page shows, in a block or in the table of recipes."""
    for page in PAGES:
        lines = [line for block in blocks(page, "sh") for line in block.splitlines()]
        lines += re.findall(r"`([^`]+)`", read(page)) if page.name == "recipes.md" else []
        for words in (shlex.split(line, comments=True) for line in lines):
            if words and words[0] in APPS and not {"|", ">", "&&"} & set(words):
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


def printed(*changes):
    text = PRINTED
    for old, new in changes:
        text = text.replace(old, new)
    return {"check-vibration record.npz": text}


@pytest.mark.parametrize(("old", "new", "found"), [
    ("232.66", "232.66", 0), ("232.66", "232.67", 0),  # a unit of the last digit
    ("232.66", "232.68", 1), ("outer_ring. The", "none. The", 1), ("-1.38 %", "-1.38 °", 1),
    ("Record: 0.5 s\n", "", 0), ("60 ms in 0.91 s\n", "", 1), ("0.91 s\n", "0.91 s\nWarning: steel yields\n", 1),
])  # fmt: skip
def test_a_changed_verdict_word_or_digit_is_found(old, new, found):
    assert len(list(documented.differences(SHOWN, printed((old, new))))) == found


@pytest.mark.parametrize(("old", "new"), [("at 232.7 Hz", "at 232.8 Hz"), ('ring is damaged"', 'ring is sound"')])
def test_a_sentence_that_the_output_does_not_bear_is_found(old, new):
    assert list(documented.unfounded(SHOWN)) == []
    assert len(list(documented.unfounded(SHOWN.replace(old, new)))) == 1


def test_the_handbook_knows_every_key_attribute_command_and_package(handbook, coarse_run):
    pages = handbook.pages()
    with h5py.File(coarse_run) as file:
        assert set(file.attrs) <= set(handbook.ATTRIBUTES)
    assert tuple(pages) == handbook.NAMES
    for table in key_tables():
        assert not table.name or f"[{table.name}]" in pages["reference/scene.md"]
        assert [key.name for key in table.keys if f"| `{key.name}` |" not in pages["reference/scene.md"]] == []
    for name in tomllib.loads(read(ROOT / "pyproject.toml"))["project"]["scripts"]:
        assert f"## {name}\n\n```text\nUsage: {name}" in pages["reference/commands.md"]
    for variable in ("inner_force", "roller_turn"):
        assert f"| `{variable}` |" in pages["reference/result.md"]


def test_the_front_page_shows_a_command_with_its_output_and_links_the_reference(handbook):
    page, source = SimpleNamespace(file=SimpleNamespace(src_uri="index.md")), read(DOCS / "index.md")
    shown = handbook.on_page_markdown(source, page, None, None)
    assert blocks(ROOT / "README.md", "text")[0] in shown and "\nrun-fem motor.toml" in shown
    assert [name for name in handbook.NAMES if f"]({name})" not in source] == []


def test_keys_of_the_site_do_not_break_inside_a_word_and_code_blocks_stay(handbook):
    page = SimpleNamespace(file=SimpleNamespace(src_uri="reference/scene.md"))
    content = "<p><code>run-fem --set a.b=1</code></p><pre><code>a-b c</code></pre>"
    shown = handbook.on_page_content(content, page, None, None)
    words = [re.sub("<.*?>", "", word) for word in re.findall('<span class="word">.*?</span>', shown)]
    assert words == ["run-fem", "--set", "a.b=1"]
    assert "<pre><code>a-b c</code></pre>" in shown and shown.startswith('<div class="reference">')


@pytest.mark.parametrize("picture", sorted(DOCS.glob("*.png")), ids=lambda path: path.name)
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
    packages = ("lagrange", "meshes", "fem", "residual")
    modules = [path for name in packages for path in sorted((ROOT / name).rglob("*.py"))]
    cited = [found for path in modules for found in re.findall(r"Equation \((\w+)\) of (docs/\w+\.md)", read(path))]
    assert len(cited) > 20
    for number, page in cited:
        assert rf"\tag{{{number}}}" in read(ROOT / page), f"{page} has no equation ({number})"


@pytest.mark.parametrize("page", ["python.md"])
def test_every_example_of_a_page_runs_and_prints_what_its_comments_say(page, tmp_path, monkeypatch):
    """From top to bottom; a comment on the line after a `print` is what that prints."""
    monkeypatch.chdir(tmp_path)
    compared, lines = [], []

    def compare(*values):
        after = lines[sys._getframe(1).f_lineno].strip()
        if after.startswith("# "):
            compared.append(documented.same(after[2:], " ".join(map(str, values))))
            assert compared[-1], (after, values)

    names: dict[str, object] = {"print": compare}
    for number, text in enumerate(blocks(DOCS / page, "python")):
        lines[:] = [*text.splitlines(), "", ""]
        exec(compile(text, f"{page}, example {number}", "exec"), names)
    assert len(compared) >= 3
