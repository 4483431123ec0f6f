"""Words of the handbook, the help and the messages: the field's terms, and no everyday verbs for numerics."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from lagrange.scene.keys import key_tables
from tests.documented import OUTPUT
from tests.measurements import MEASUREMENT_PAGES, READER_PAGES, ROOT

PACKAGES = ("lagrange", "meshes", "fem", "residual")
PAGES = [*READER_PAGES, ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md", *MEASUREMENT_PAGES]
BANNED = re.compile(
    r"\b(owe[ds]?|owing|pays|paid|told|felt|feels?|lest|aside|(?:gives?|gave) way|gone on with|set right|"
    r"don't tell of|off the middle|less its mean|hangs on|accus\w*|wants of|by a piece of|"
    r"of which it warns|not in this program|as deeply|at hand from a source)\b|\b[Ww]hat\b[^.;:!?|]*?\bby\b"
)
IDENTIFIERS = re.compile(r"(?:^|_)(told|debts?|paid|stuck|put_down)(?:$|_)", re.I)  # parts of names in the code
DIARY = re.compile(r"\b(missed|commits? [0-9a-f]{7}|(?=[0-9a-f]*\d)(?=[0-9a-f]*[a-f])[0-9a-f]{7,40})\b")
LEANS = re.compile(r"(of|by which|over which|in which|from which|likewise)\b")  # what a description begins with
LONGEST_LINE = 160
MOST_LINES = 3000  # of the pages for readers, but for outputs of commands


def prose(page: Path) -> str:
    """A page without its code, its formulas and the targets of its links, in one line."""
    text = re.sub(r"^(```|\$\$).*?^\1", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    return re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`\n]*`", "", text))


def texts_of(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Messages of a module, and docstrings of what is public: line and text."""
    docstrings = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node):
            docstrings.add(id(node.body[0].value))
            if not getattr(node, "name", "").startswith("_"):
                yield node.body[0].lineno, ast.get_docstring(node)
        elif isinstance(node, ast.JoinedStr):
            pieces = (part.value if isinstance(part, ast.Constant) else "0" for part in node.values)
            yield node.lineno, "".join(map(str, pieces))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.lineno, node.value if " " in node.value else ""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_keeps_to_the_fields_words_and_is_no_diary(page):
    text = prose(page)
    assert [found[0] for found in BANNED.finditer(" ".join(text.split()))] == []
    if page in READER_PAGES:
        assert [found[0] for found in DIARY.finditer(text)] == []
        assert [line for line in text.splitlines() if len(line) > LONGEST_LINE and line[0] != "|"] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_messages_help_docstrings_and_names_keep_to_the_fields_words(package):
    """And a description does not lean on the name it stands beside: "speed of the shaft", not "of the shaft"."""
    found = [key.name for table in key_tables() for key in table.keys if LEANS.match(key.meaning)]
    for path in sorted((ROOT / package).rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for line, text in texts_of(tree):
            plain = " ".join(re.sub(r"`[^`]*`", "", text).split())
            found += [f"{path}:{line}: {match[0]}" for match in BANNED.finditer(plain)]
        for node in ast.walk(tree):
            names = (getattr(node, kind, None) for kind in ("id", "attr", "name", "arg"))
            found += [f"{path}: {name}" for name in names if isinstance(name, str) and IDENTIFIERS.search(name)]
            if isinstance(node, ast.keyword) and node.arg in ("description", "help"):
                text = ast.unparse(node.value).lstrip("f").strip("'\"")
                found += [f"{path}:{node.lineno}: {text}"] if LEANS.match(text) else []
    assert found == []


def test_banned_words_are_found():
    for text in ("a contact owes energy", "It tells what a ring gives\nway by.", "what steps err by", "it felt it",
                 "a line accuses a part"):  # fmt: skip
        assert BANNED.search(" ".join(text.split())), text
    assert IDENTIFIERS.search("told_angle") and IDENTIFIERS.search("PAID_BY") and not IDENTIFIERS.search("repaid")
    assert not BANNED.search("What follows is the law. A spring held by the ring gives a force.")
    assert DIARY.search("at commit 5f9d253") and DIARY.search("of d3a7804, before") and not DIARY.search("1234567 N")


INDEX = """
ball bearing | ball pass frequency | basic dynamic load rating | basic static load rating | bore | cage | cage slip |
centrifugal | clearance | coefficient of restitution | Coulomb friction | conformity | contact angle | contact law |
contact stiffness | contamination | convergence | creep | crest factor | critical speed | critical step | curvature
difference | damping | discretisation error | Dowson and Higginson | eccentric | elastohydrodynamic | energy balance |
envelope spectrum | equation of motion | fatigue load limit | film thickness | finite element | Flamant | friction
torque | full slip | groove radius | half plane | half-width | Hertz contact | Hertz pressure | housing | impact |
influence matrix | interference | lamina | Lagrange's equations | leakage | life modification factor | line contact |
load distribution | load rating | load zone | logarithmic decrement | lubricant | lumped mass | material damping |
maximum shear stress | Michell's series | Mindlin | misalignment | natural frequency | normal force | order spectrum |
outer raceway | Palmgren | pitch diameter | plane strain | pocket clearance | point contact | power spectral density |
preload | press fit | pressure-viscosity | prewhitening | radial load | rating life | reliability factor | resonance |
rolling without slip | rotating load | roughness | run-up | sensor | shear stress | sideband | Sjövall | sliding |
spall | squeeze film | starvation | static safety factor | stick | stiffness matrix | Stribeck curve | Stribeck number
| subsurface | tangential compliance | temperature | thick-walled ring | traction coefficient | unbalance | varying
compliance | viscosity ratio | von Mises stress | waviness | whirl
"""  # of Harris, Rolling Bearing Analysis, and Johnson, Contact Mechanics


def test_a_term_of_the_field_leads_to_a_page_and_the_pages_for_readers_are_short():
    """By the site's search, which looks in headings and text."""
    pages = READER_PAGES[1:]
    searched = "\n".join(" ".join(prose(page).split()) for page in pages)
    terms = [term.strip() for term in " ".join(INDEX.split()).split("|")]
    assert [term for term in terms if not re.search(rf"\b{re.escape(term)}(?:s|es)?\b", searched, re.I)] == []
    lines = [line for page in pages for line in OUTPUT.sub("", page.read_text(encoding="utf-8")).splitlines()]
    assert len(lines) <= MOST_LINES
