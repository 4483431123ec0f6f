"""Pages of the handbook that are made, not written, and its formulas: mkdocs calls the `on_` functions.

Scene keys come from the scene's own classes, the result's variables from their declaration, commands from their --help,
and Python from the packages' docstrings, so that each is described once and a new table or option is here by itself.
"""

import html
import importlib
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
LONGEST_WORD = 40  # characters: a longer one may break on a phone
NAMES = tuple(f"reference/{name}.md" for name in ("scene", "examples", "result", "commands", "packages"))

ATTRIBUTES = {  # of a result file
    "format_version": "version of this layout",
    "program": "program that wrote the file",
    "program_version": "version of the package",
    "source": "digest of the program's own code",
    "scene": "the whole scene as TOML",
    "scene_checksum": "CRC-32 of the scene's text",
    "mesh_nodes": "nodes of the elastic bodies",
    "degrees_of_freedom": "degrees of freedom of the model",
    "time_step": "time step, s",
    "long_step": "s, time step away from edges of spalls, if steps have two lengths",
    "critical_time_step": "s, with all contacts closed",
    "steps": "number of time steps",
    "wall_seconds": "wall time of the time loop, s",
    "setup_seconds": "wall time before the time loop, s",
    "committed_samples": "number of samples that are complete",
    "warnings": "one warning per line; empty if none",
    "status": '"complete", "running", "interrupted", "failed: …"',
    "faults": "surface faults in words, if any",
    "coarse_mesh_size": "mesh size of the second run of --estimate-error, m",
}


def pages() -> dict[str, str]:
    """Markdown by the page's path."""
    makers = scene_page, examples_page, result_page, commands_page, packages_page
    return {name: make() for name, make in zip(NAMES, makers, strict=True)}


def scene_page() -> str:
    """Every key with its default, unit, limits and meaning."""
    from lagrange.scene.keys import key_tables

    parts = [
        "# Scene file",
        "TOML. Every key has a default, the paper's bearing; a scene needs only what differs. Unknown keys and "
        "impossible values are refused by name. On the command line: `--set table.key=value`, of the first spall "
        "`--set spall.0.key=value`. `run-fem --example all` writes this page as a scene.",
    ]
    for table in key_tables():
        if table.name:
            parts.append(f"## `{f'[[{table.name}]]' if table.many else f'[{table.name}]'}`")
            parts.append(table.meaning if table.given else f"{table.meaning} Absent unless written.")
        rows = []
        for key in table.keys:
            default = "" if key.default is None else f"`{_toml(key.default)}`"
            rows.append((f"`{key.name}`", key.meaning, default, key.unit, key.limits))
        if rows:
            parts.append(_table(("key", "meaning", "default", "unit", "limits"), rows))
    return "\n\n".join(parts) + "\n"


def examples_page() -> str:
    """The scenes of --example as they are."""
    from fem.commands.run_fem import EXAMPLES
    from fem.examples import example_text

    parts = ["# Examples", "`run-fem --example NAME` writes one of these. `all` has every key: [scene file](scene.md)."]
    for name in EXAMPLES:
        if name != "all":
            parts.append(f"## {name}\n\n```toml\n{example_text(name)}```")
    return "\n\n".join(parts) + "\n"


def result_page() -> str:
    """Variables and attributes of a result file."""
    from lagrange.columns import COLUMNS, columns_of

    rows = [
        (f"`{name}`", column.meaning, ", ".join(column.dimensions), column.unit, part)
        for part in COLUMNS
        for name, column in columns_of(part).items()
    ]
    return "\n\n".join(
        [
            "# Variables of the result",
            "HDF5 with dimension scales: opens with h5py, netCDF4, xarray and MATLAB, while the run goes too. SI. What "
            "of it may be trusted, and what stands in it on request: [result file, explained](../result_file.md).",
            "## Variables",
            _table(("variable", "meaning", "dimensions", "unit", "only with"), rows),
            "## Attributes",
            _table(("attribute", "meaning"), ((f"`{name}`", text) for name, text in ATTRIBUTES.items())),
        ]
    )


def commands_page() -> str:
    """The --help of every command that pyproject.toml declares."""
    parts = [
        "# Commands",
        "Exit codes: 0 done; 1 failed numerically, or a tolerance exceeded; 2 unusable input; 130 interrupted "
        "(143 by SIGTERM).",
    ]
    with open(ROOT / "pyproject.toml", "rb") as file:
        scripts = tomllib.load(file)["project"]["scripts"]
    for name, entry in scripts.items():
        module, _, function = entry.partition(":")
        program = f"import sys; sys.argv[0] = {name!r}; from {module} import {function} as main; main()"
        done = subprocess.run(
            [sys.executable, "-c", program, "--help"], cwd=ROOT, capture_output=True, encoding="utf-8", check=True,
            env=_plain_environment(),
        )  # fmt: skip
        parts.append(f"## {name}\n\n```text\n{done.stdout.strip()}\n```")
    return "\n\n".join(parts) + "\n"


def _plain_environment() -> dict[str, str]:
    return os.environ | {"COLUMNS": "130", "PYTHONUTF8": "1", "PYTHONPATH": os.pathsep.join(sys.path), "NO_COLOR": "1"}


def packages_page() -> str:
    """Docstrings of the packages: their maps of modules."""
    with open(ROOT / "pyproject.toml", "rb") as file:
        packages = tomllib.load(file)["tool"]["setuptools"]["packages"]
    parts = ["# Packages", "Each package's own map. To use the program from Python: [from Python](../python.md)."]
    for name in packages:
        parts.append(f"## {name}\n\n```text\n{(importlib.import_module(name).__doc__ or '').strip()}\n```")
    return "\n\n".join(parts) + "\n"


def _toml(value: object) -> str:
    import tomli_w

    return tomli_w.dumps({"_": value}).strip().partition(" = ")[2]


def _table(headings, rows) -> str:
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |" for cells in lines)


def on_files(files, config):
    """Add the pages to those that mkdocs has found."""
    from mkdocs.structure.files import File

    for path, text in pages().items():
        files.append(File.generated(config, path, content=text))
    return files


def on_page_markdown(markdown, page, config, files):
    """README's bearing with its output on the front page; version and date of CITATION.cff in the page about citing."""
    if page.file.src_uri == "index.md":
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        shown = re.search(r"^```toml\n.*?^```text\n.*?^```$", text, re.M | re.S)[0]
        markdown = markdown.replace("<!-- bearing of README.md -->", shown)
    if page.file.src_uri == "cite.md":
        text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
        for word, key in (("VERSION", "version"), ("DATE", "date-released")):
            markdown = markdown.replace(word, re.search(rf"^{key}: \"?([^\"\n]+)", text, re.M)[1])
    return markdown


def on_page_content(content, page, config, files):
    r"""Formulas as MathML, which browsers draw without a script; `\tag{n}` numbers an equation. Keys do not break."""
    from latex2mathml.converter import convert

    def inline(found: re.Match) -> str:
        return convert(html.unescape(found[1]))

    def block(found: re.Match) -> str:
        formula = html.unescape(found[1])
        number = re.search(r"\\tag\{(\w+)\}", formula)
        text = convert(formula.replace(number[0], "") if number else formula, display="block")
        label = f'<span id="equation-{number[1]}">({number[1]})</span>' if number else ""
        return f'<div class="equation">{text}{label}</div>'

    def unbroken(found: re.Match) -> str:
        words = (
            f'<span class="word">{word}</span>' if len(word) < LONGEST_WORD else word for word in found[1].split(" ")
        )
        return f"<code>{' '.join(words)}</code>"

    content = re.sub(r"(?<!</span>)(?<!<pre>)<code>([^<]+)</code>", unbroken, content)
    if page.file.src_uri in NAMES:
        content = f'<div class="reference">{content}</div>'
    content = re.sub(r'<span class="arithmatex">\\\((.+?)\\\)</span>', inline, content, flags=re.S)
    return re.sub(r'<div class="arithmatex">\s*\\\[(.+?)\\\]\s*</div>', block, content, flags=re.S)
