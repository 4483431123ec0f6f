"""Arrays of rollers and hubs that tilt in the time loop of rigid bodies, and how far their contacts' tables must go."""

import numpy as np

from fem.kernels.fields import filled
from fem.kernels.lanes import WIDTH
from fem.kernels.tilted_contact import SpalledRest, TiltedLaw
from fem.kernels.tilts import Tilts as TiltArrays
from fem.solver.samples import row_width
from lagrange import Bearing, Operation, kinematics
from lagrange.axial import ContactTable, SpalledTable
from lagrange.axial.facts import Axial
from lagrange.bearing import Cage
from lagrange.tilt import Tilts, hub_axial_inertia, hub_tilt, roller_inertias


def axes_at(
    bearing: Bearing, operation: Operation, axial: Axial, cage: Cage | None, start: Tilts, columns: int
) -> TiltArrays:
    """The axes of rollers and hub at the slopes and rates of a start; `columns` : of rollers in arrays."""
    n, hub = bearing.n_rollers, hub_tilt(operation, axial)
    (across, along), turns = roller_inertias(bearing), (kinematics(bearing, 1.0), kinematics(bearing, 0.0, 1.0))
    tilts = filled(
        TiltArrays,
        {"columns": columns, "lanes": WIDTH},
        slope=np.array([start.slope_x, start.slope_y], dtype=float),
        slope_rate=np.array([start.slope_x_rate, start.slope_y_rate], dtype=float),
        inertia=float(across),
        along=float(along),
        spin=tuple(float(each.roller) for each in turns),
        cage=tuple(float(each.cage) for each in turns),
        hub_over=1.0 / hub.inertia if hub.is_free else 0.0,
        hub_spin=float(hub_axial_inertia(bearing, operation)),
        hub_stiffness=float(hub.stiffness),
        rest=(float(hub.slope_x), float(hub.slope_y)),
        column=row_width(n, cage, operation.mounting),
    )
    tilts.tilt[:n], tilts.rate[:n] = start.tilt, start.tilt_rate
    return tilts


def laws_of(tables: tuple[ContactTable | SpalledTable, ...]) -> tuple[tuple[TiltedLaw, ...], tuple]:
    """Laws of contacts by their tables, of all slices, and without those that spalls take; None: these take none."""
    laws = tuple(TiltedLaw.of(table.whole if isinstance(table, SpalledTable) else table) for table in tables)
    if not any(isinstance(table, SpalledTable) for table in tables):
        return laws, (None,) * len(tables)
    return laws, tuple(map(_rest, tables))  # of all contacts, so that they are of one type


def _rest(table: ContactTable | SpalledTable) -> SpalledRest:
    if not isinstance(table, SpalledTable):
        return SpalledRest(law=TiltedLaw.of(table), of_rest=1.0, of_part=0.0)
    return SpalledRest(law=TiltedLaw.of(table.rest), of_rest=1.0 / (1.0 - table.share), of_part=1.0 / table.share)


LESS = "reduce impacts and tilt of the rollers, or leave [axial] out"  # where tables go no further


def beyond_tables(tilts: TiltArrays | None, tables: tuple[TiltedLaw, ...]) -> str | None:
    """A clause where closed contacts have been further than their tables go; None: they have not, or have none.

    `tables` : of the inner and the outer contact, or none
    """
    if tilts is None or not tables:
        return None
    *approaches, slope = tilts.furthest.max(axis=1)
    for law, approach, side in zip(tables, approaches, ("inner", "outer"), strict=True):
        deepest = law.first_approach + (law.rows + 1.0) / law.per_approach
        if approach > deepest:
            return (
                f"a roller and the {side} raceway approached by {1e6 * approach:.3g} µm, and contacts that tilt are "
                f"tabulated up to {1e6 * deepest:.3g} µm"
            )
        steepest = law.first_slope + (law.columns + 1.0) / law.per_slope
        if slope > steepest:
            return (
                f"a roller and a raceway were misaligned by {1e3 * slope:.3g} mrad, and contacts that tilt are "
                f"tabulated up to {1e3 * steepest:.3g} mrad"
            )
    return None
