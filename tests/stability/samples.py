"""Samples of a result file compared with those of a run that nothing disturbed."""

from pathlib import Path

import h5py
import numpy as np


def samples_of(path: Path) -> dict[str, np.ndarray]:
    """All committed samples of a result, and what it knows of its run; the times of day are no part of them."""
    with h5py.File(path) as file:
        count = int(file.attrs["committed_samples"])
        known = {name: np.asarray(file.attrs[name]) for name in ("status", "committed_samples")}
        return known | {name: value[:count] for name, value in file.items() if isinstance(value, h5py.Dataset)}


def differing(found: dict[str, np.ndarray], whole: dict[str, np.ndarray]) -> list[str]:
    """Names of the variables whose samples are not the first ones of the whole run's."""
    counts = len(found["time"]), len(whole["time"])
    names = found.keys() & whole.keys() - {"status", "committed_samples"}
    same = found.keys() == whole.keys() and counts[0] <= counts[1]
    other = [name for name in names if found[name].tobytes() != whole[name][: len(found[name])].tobytes()]
    return sorted(other) if same else ["another set of variables or samples"]
