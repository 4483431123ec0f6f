"""Error estimates in a finished result file."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from fem.result.durable import alone_in, move_into_place
from lagrange.hdf5_writing import hdf5_to_write
from lagrange.output_files import new_part, real_path

if TYPE_CHECKING:
    from fem.solver.error_estimate import Estimate

ESTIMATE = {
    "quantity": "name of a quantity of interest",
    "quantity_unit": "unit of its value and error",
    "quantity_meaning": "what it is",
    "quantity_value": "on the run's mesh",
    "quantity_coarse_value": "on the coarser mesh",
    "quantity_error": "estimated discretisation error of the value, not negative",
}


def write_estimates(path: Path, found: "list[Estimate]", coarse_mesh_size: float) -> None:
    """Add error estimates to a finished result file, which is exchanged for one that has them.

    Parameters
    ----------
    coarse_mesh_size : of the coarser run, m

    Errors
    ------
    OSError: no room for a second file; the first stays as it is.
    """
    path = real_path(path)
    part = new_part(path)
    try:
        with alone_in(path.parent):
            shutil.copyfile(path, part)
            with hdf5_to_write(part, "r+") as file:
                _add(file, found, coarse_mesh_size)
            with open(part, "r+b") as file:
                os.fsync(file.fileno())
            move_into_place(part, path)
    finally:
        part.unlink(missing_ok=True)


def _add(file: h5py.File, found: "list[Estimate]", coarse_mesh_size: float) -> None:
    columns = {
        "quantity": [each.quantity.name for each in found],
        "quantity_unit": [each.quantity.unit for each in found],
        "quantity_meaning": [each.quantity.meaning for each in found],
        "quantity_value": [each.quantity.value for each in found],
        "quantity_coarse_value": [each.coarse_value for each in found],
        "quantity_error": [each.error for each in found],
    }
    for name in reversed(ESTIMATE):  # of an earlier estimate
        if name in file:
            del file[name]
    for name, values in columns.items():
        variable = file.create_dataset(name, data=values)
        variable.attrs["long_name"] = ESTIMATE[name]
    file["quantity"].make_scale("quantity")
    for name in ESTIMATE:
        if name != "quantity":
            file[name].dims[0].attach_scale(file["quantity"])
    file.attrs["coarse_mesh_size"] = coarse_mesh_size


def read_columns(path: Path, names: tuple[str, ...], samples: int | None = None) -> dict[str, np.ndarray]:
    """The first so many committed samples of some variables, or all."""
    with h5py.File(path, "r") as file:
        count = int(file.attrs["committed_samples"]) if samples is None else samples
        return {name: file[name][:count] for name in names}


def read_blocks(path: Path, names: tuple[str, ...], rows: int = 1 << 16) -> Iterator[dict[str, np.ndarray]]:
    """All committed samples of some variables, so many at a time."""
    with h5py.File(path, "r") as file:
        count = int(file.attrs["committed_samples"])
        for first in range(0, count, rows):
            yield {name: file[name][first : min(first + rows, count)] for name in names}
