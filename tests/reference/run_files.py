"""Runs whose files tests disturb: options of short ones, and what is left in a folder."""

import h5py
import numpy as np

from lagrange.columns import columns_of
from lagrange.files.hdf5 import SIGNATURE

EARLIER = SIGNATURE + b"an earlier result"
OPTIONS = ["--mesh-size", "2", "--quiet", "--checkpoint", "0"]
SHORT = [*OPTIONS, "--duration", "2"]


def same_data(left, right):
    """Whether two result files hold the same numbers."""
    with h5py.File(left) as a, h5py.File(right) as b:
        return all(np.array_equal(a[name][:], b[name][:]) for name in columns_of(""))


def names_in(folder):
    """Names of what lies in a folder, sorted."""
    return sorted(entry.name for entry in folder.iterdir())
