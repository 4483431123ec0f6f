"""Compiled kernels are kept for one text of all modules they may be made of."""

import shutil
from pathlib import Path

import fem.kernels
from fem.kernels.kernel_folder import cache_folder, digest, version


def test_a_change_of_any_module_makes_kernels_anew(tmp_path):
    """Also of one that defines no kernel of its own: its parts stand in the code of others."""
    folder = tmp_path / "kernels"
    shutil.copytree(Path(fem.kernels.__file__).parent, folder, ignore=shutil.ignore_patterns("__pycache__"))
    before = digest(folder)
    assert cache_folder().name == version() and version().removesuffix("-checked") == before
    found = {before}
    for module in sorted(folder.rglob("*.py")):
        text = module.read_bytes()
        module.write_bytes(text + b"\n# changed")
        found.add(digest(folder))
        module.write_bytes(text)
    assert len(found) == 1 + len(list(folder.rglob("*.py"))) > 20
    (folder / "new.py").write_text("")
    assert digest(folder) not in found
