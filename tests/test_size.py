"""The program's size has a budget for each folder, which only falls.

`python -m tests.test_size` lowers budgets to what is there.
Lines are those of files; tokens are counted without comments and docstrings, so that long lines and bare functions
gain nothing.
"""

import ast
import re
import sys
import tokenize
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
UNCOUNTED = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
PACKAGES = ("lagrange", "meshes", "fem", "residual")
MEASURES = ("lines", "tokens", "modules", "functions")
BUDGET = {
    "fem/kernels": (8892, 80936, 41, 491),
    "fem/solver": (4323, 37684, 18, 284),
    "fem/contacts": (1316, 11219, 8, 103),
    "fem/elastic": (1502, 12736, 8, 111),
    "fem/statics": (938, 8339, 5, 57),
    "fem": (25396, 227185, 123, 1536),
    "lagrange": (9940, 77597, 51, 652),
    "residual": (7320, 67131, 27, 380),
    "meshes": (529, 3733, 7, 29),
    "tests": (27476, 307028, 101, 1868),
    "benchmarks": (2058, 16975, 13, 109),
}  # fmt: skip


def size(folder: str) -> tuple[int, int, int, int]:
    """Lines, tokens, modules and functions of a folder and those in it."""
    sizes = [_size_of(path) for path in sorted((ROOT / folder).rglob("*.py"))]
    return tuple(map(sum, zip(*sizes, strict=True)))


def _size_of(path: Path) -> tuple[int, int, int, int]:
    text = path.read_text(encoding="utf-8")
    with path.open("rb") as file:
        tokens = sum(t.type not in UNCOUNTED for t in tokenize.tokenize(file.readline)) - 1  # the encoding
    nodes = list(ast.walk(ast.parse(text)))
    homes = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docstrings = sum(isinstance(n, homes) and ast.get_docstring(n) is not None for n in nodes)
    functions = sum(isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef) for n in nodes)
    return len(text.splitlines()), tokens - docstrings, 1, functions


def test_every_folder_keeps_its_budget():
    over = [
        f"{folder}: {is_there} {name}, budget {most}"
        for folder, budget in BUDGET.items()
        for name, is_there, most in zip(MEASURES, size(folder), budget, strict=True)
        if is_there > most
    ]
    assert not over, "; ".join(over)


def test_no_modules_import_each_other():
    """In a circle however long, in functions and for types only too; CycleError names it."""
    paths = [path for package in PACKAGES for path in sorted((ROOT / package).rglob("*.py"))]
    modules = {".".join(p.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): p for p in paths}
    graph = {name: set[str]() for name in modules}
    for name, path in modules.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import | ast.ImportFrom):
                home = getattr(node, "module", None)
                found = {f"{home}.{alias.name}" if home else alias.name for alias in node.names}
                graph[name] |= {each if each in modules else home for each in found} & modules.keys()
    TopologicalSorter(graph).prepare()


def lowered(text: str) -> str:
    """This file with budgets that are above what is there brought down to it."""
    rows = []
    for folder, budget in BUDGET.items():
        row = tuple(map(min, budget, size(folder)))
        rows.append(f'    "{folder}": {row},\n')
    return re.sub(r"(?s)(?<=^BUDGET = \{\n).*?(?=^\})", "".join(rows), text, flags=re.M)


if __name__ == "__main__":
    here = Path(__file__)
    here.write_text(lowered(here.read_text(encoding="utf-8")), encoding="utf-8")
    sys.exit(0)
