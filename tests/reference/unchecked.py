"""Copies of result files whose content a test may change."""

import shutil

import h5py

from lagrange.files.hdf5 import CHECKSUM, SCENE_CHECKSUM


def unchecked_copy(path, target):
    """A copy without checksums."""
    shutil.copy(path, target)
    with h5py.File(target, "r+") as file:
        file.attrs.pop(SCENE_CHECKSUM, None)
        for variable in file.values():
            variable.attrs.pop(CHECKSUM, None)
    return target
