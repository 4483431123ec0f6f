"""The version stands in one place, and a result names it and the code that made it."""

import re
import tomllib
from pathlib import Path

import h5py

from fem.commands.run_fem import run_main
from fem.result.store import ATTRIBUTES
from lagrange import version

ROOT = Path(__file__).resolve().parents[1]


def test_package_citation_and_changelog_have_the_programs_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert project["project"]["dynamic"] == ["version"]
    assert project["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "lagrange.version.VERSION"}
    cited = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    changes = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    assert cited[1] == changes[1] == version.VERSION


def test_commands_tell_it(capsys):
    run_main(["--version"])
    assert capsys.readouterr().out.strip() == version.VERSION


def test_a_result_names_version_and_source_and_every_attribute_is_described(coarse_run):
    with h5py.File(coarse_run) as file:
        assert file.attrs["program_version"] == version.VERSION
        assert file.attrs["source"] == version.source_digest()
        assert set(file.attrs) <= set(ATTRIBUTES)


def test_the_digest_is_that_of_the_code(tmp_path, monkeypatch):
    """Another text, or another name of a module, is another program; what is no module does not matter."""
    (tmp_path / "lagrange").mkdir()
    module = tmp_path / "lagrange" / "version.py"
    monkeypatch.setattr(version, "__file__", str(module))
    found = []
    for text, other in (("a = 1", None), ("a = 2", None), ("a = 1", "new.py"), ("a = 1", "notes.txt")):
        module.write_text(text, encoding="utf-8")
        if other:
            (module.parent / other).write_text("", encoding="utf-8")
        found.append(version.source_digest.__wrapped__())
        if other:
            (module.parent / other).unlink()
    assert len(set(found[:3])) == 3 and found[3] == found[0]
