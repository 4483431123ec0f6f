"""Slices of elastic bodies in a result file, from which pressures along its rollers follow by forces and moments."""

from typing import TYPE_CHECKING

import numpy as np

from lagrange.axial.facts import Axial
from lagrange.axial.slices import Slices, contact_slices
from lagrange.bearing import Bearing
from lagrange.contact.laws import LogarithmicLaw
from lagrange.files.hdf5 import Damaged, check_array, has, variable

if TYPE_CHECKING:
    import h5py

COMPLIANCES = {side: f"{side}_slice_compliance" for side in ("inner", "outer")}  # variables of the file
LAW = "law_compliance", "law_level", "law_largest_force"  # their attributes: m/N, 1, N


def write_slices(file: "h5py.File", slices: tuple[Slices, Slices]) -> None:
    """Add compliances and laws of both contacts' slices to a file."""
    variable(file, "slice", slices[0].place, ("slice",), "m", "middle of a slice along the roller")
    for name, side, each in zip(COMPLIANCES.values(), COMPLIANCES, slices, strict=True):
        about = f"approach of a slice by the force of another, {side} contact"
        variable(file, name, each.coupling, ("slice", "slice"), "m/N", about)
        assert isinstance(each.law, LogarithmicLaw)
        for key, value in zip(LAW, (each.law.compliance, each.law.level, each.law.largest_force), strict=True):
            file[name].attrs[key] = value


def read_slices(file: "h5py.File", bearing: Bearing, axial: Axial) -> tuple[Slices, Slices] | None:
    """The slices of a run with [axial]; None: the file holds none.

    Errors
    ------
    Damaged: they are none of such a bearing.
    """
    if not all(has(file, name) for name in COMPLIANCES.values()):
        return None
    laws, couplings, n = [], [], axial.slices
    for name in COMPLIANCES.values():
        data = check_array(file, name, n, dimensions=(2,))
        numbers = np.array([float(data.attrs[key]) for key in LAW])
        coupling = data[:].astype(float) if data.shape == (n, n) else np.empty((0, 0))
        if not (coupling.size and np.isfinite(coupling).all() and np.isfinite(numbers).all() and numbers.min() > 0.0):
            raise Damaged(f"{name} is no compliance of {n} slices")
        values = dict(zip(("compliance", "level", "largest_force"), numbers.tolist(), strict=True))
        laws.append(LogarithmicLaw(name="series", source="plane series", **values))
        couplings.append(coupling)
    return contact_slices(bearing, axial, (laws[0], laws[1]), (couplings[0], couplings[1]))
