"""Commented scenes to begin with, which `run-fem --example` writes: the files beside this one; "all" has every key."""

from importlib import resources
from pathlib import Path

import numpy as np

from lagrange.errors import UsageError
from lagrange.files.output import write_whole
from lagrange.scene.keys import scene_with_every_key


def write_example(name: str, path: Path | None, force: bool = False) -> list[Path]:
    """Write a scene, and the table that it describes if it does; the files written.
    `path` : where the scene goes; None: under its name in the current folder
    UsageError: a file is there already, and not to be replaced. OSError: it can't be written."""
    path = Path(f"{name}.toml") if path is None else path
    files = {path: example_text(name)}
    if name == "table":
        files[path.with_suffix(".tsv")] = rig_table()
    for target in files:
        if (target.exists() or target.is_symlink()) and not force:
            raise UsageError(f"{target}: is there already; --force replaces it, --output names another file")
    path.parent.mkdir(parents=True, exist_ok=True)
    for target, text in files.items():
        write_whole(target, text.encode())
    return list(files)


def example_text(name: str) -> str:
    """The TOML text of an example."""
    if name == "all":
        return scene_with_every_key()
    return resources.files(__name__).joinpath(f"{name}.toml").read_text(encoding="utf-8")


def rig_table() -> str:
    """A table as from a test rig: the paper's bearing with rigid rings, its hub down by 4.11 µm and vibrating.

    Each roller sits where its two contacts share the approach, and the cage turns as rolling without slip demands."""
    rollers, radius, inner, outer = 13, 5.0, 18.0, 28.0  # mm
    speed = 2.0 * np.pi * 4500.0 / 60.0  # rad/s
    time = np.arange(5000) * 2e-5
    x, y = 0.0 * time, -4.11e-3 + 1e-4 * np.cos(2.0 * np.pi * 200.0 * time)  # mm
    cage = 0.5 * speed * inner / (inner + radius)
    table = {"t [ms]": 1e3 * time, "X [um]": 1e3 * x, "Y [um]": 1e3 * y}
    for j in range(rollers):
        theta = -0.5 * np.pi + 2.0 * np.pi * j / rollers + cage * time
        squeezed = np.maximum(x * np.cos(theta) + y * np.sin(theta), 0.0)  # mm, by both contacts
        table[f"rho {j + 1} [mm]"] = outer - radius + 0.5 * squeezed
        table[f"theta {j + 1} [deg]"] = np.degrees(theta)
    rows = np.column_stack(list(table.values()))
    lines = ["\t".join(table), *("\t".join(f"{value:.12g}" for value in row) for row in rows)]
    return "\n".join(lines) + "\n"
