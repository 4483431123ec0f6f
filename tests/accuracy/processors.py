"""One run compiled for processors of three kinds: `python -m tests.accuracy.processors` prints a table in Markdown.

Each compiles the time loop anew, about a minute; the processor at hand must know what is asked of it. Results repeat
bit for bit on one processor; sums are fused and grouped differently on another, and contacts make of that what they
make of any round-off.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

from tests.measurements import markdown_table, program

# LLVM's names: the least of all 64-bit processors; with AVX2 and fused products (2013); with AVX-512 (2017)
PROCESSORS = {"x86-64": "SSE2", "x86-64-v3": "AVX2", "x86-64-v4": "AVX-512"}
DURATION, MESH_SIZE = 5.0, 2.0  # ms, mm
COLUMNS = {"inner_x": "hub x", "inner_y": "hub y", "inner_force": "inner loads", "roller_spin": "spins"}


def computed(name: str, folder: Path) -> dict[str, np.ndarray]:
    """The columns of a run compiled for a processor."""
    path = folder / f"{name}.nc"
    words = ["--quiet", "--mesh-size", str(MESH_SIZE), "--duration", str(DURATION), "--output", str(path)]
    environment = os.environ | {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""}
    program = "from fem.commands.run_fem import run_fem; run_fem()"
    subprocess.run([sys.executable, "-c", program, *words], env=environment, check=True)
    with h5py.File(path) as file:
        return {column: file[column][:] for column in COLUMNS}


def compared() -> tuple[str, str]:
    """Runs beside that of the plainest processor."""
    with tempfile.TemporaryDirectory() as folder:
        runs = {name: computed(name, Path(folder)) for name in PROCESSORS}
    plainest, rows = runs[next(iter(PROCESSORS))], []
    for name, run in runs.items():
        apart = {c: np.abs(run[c] - plainest[c]).max() / np.abs(plainest[c]).max() for c in COLUMNS}
        rows.append([f"{PROCESSORS[name]} ({name})", *(f"{value:.1g}" for value in apart.values())])
    words = "5 ms of the paper's bearing, 2 mm, largest differences over the largest value."
    return words, markdown_table(["compiled for", *COLUMNS.values()], rows)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.processors", ("reliability", "Processors", compared))
