"""Rollers that tilt in runs of the finite elements: tables of contacts' energy below the grid, axes, laws with both."""

from dataclasses import replace

import numpy as np

from fem.contacts.model import Model
from fem.contacts.subgrid import SubgridModel
from fem.contacts.tilted import MeshedContact, rounded_range, tilted_tables
from fem.kernels.fields import at_line, filled
from fem.kernels.state import INNER, OUTER, Pair, RingProfile, RollerProfiles
from fem.kernels.tilted_contact import PartProfiles, SpalledRest
from fem.kernels.tilted_patches import Axes, PatchMoments, SlicedLaw, TiltedSurfaces
from fem.solver.elements.arrays import Arrays
from fem.solver.elements.start import Start, Tilting
from fem.solver.parts import axes_at, beyond_tables, laws_of, part_profiles
from fem.solver.rigid import start as rigid_start
from fem.solver.rigid.start import MOVING, narrow_slices
from fem.statics.equilibrium import Equilibrium
from fem.statics.reduced_bearing import kept_contacts, reduced_bearing
from lagrange import Bearing, Operation
from lagrange.axial import Axial
from lagrange.axial.slices import MORE, steepest_slope
from lagrange.bearing import Cage
from lagrange.errors import UsageError
from lagrange.kinematics import kinematics
from lagrange.surface.deviation import profiles
from lagrange.tilt import Tilts, hub_tilt


def tilting_of(model: Model, operation: Operation, axial: Axial, force: float, near: Equilibrium) -> Tilting:
    """Contacts for forces at rest of so many N, near the equilibrium of parallel axes.

    Of a contact's plane compliance A (B − ½ ln Q) its mesh has what the law below the grid leaves, a constant.

    Errors
    ------
    UsageError: a mesh that resolves contacts, by points or nearly by patches.
    """
    bearing = model.bearing
    if not isinstance(model, SubgridModel):
        raise UsageError(_too_fine("resolves the contacts"))
    most = MORE * rounded_range(force, 0.0)[0]
    if most > (least := min(model.inner_law.Q_line, model.outer_law.Q_line)):
        raise UsageError(_too_fine(f"resolves contacts under {least:.4g} N, and tables of rollers go to {most:.4g} N"))
    contacts, _ = kept_contacts(bearing)
    laws, below = (contacts.inner_law, contacts.outer_law), (model.inner_law, model.outer_law)
    inner, outer = (whole.A * (whole.B - law.B) for whole, law in zip(laws, below, strict=True))
    slope = steepest_slope(bearing, axial, operation.misalignment, float(laws[0].approach(MOVING * force)))
    tables = tilted_tables(bearing, axial, laws, force, slope, (inner, outer))
    met = (MeshedContact(table=tables[0], meshed=inner), MeshedContact(table=tables[1], meshed=outer))
    return Tilting(laws=met, hub=hub_tilt(operation, axial), near=near)


def _too_fine(why: str) -> str:
    return f"[axial]: the mesh {why}, where slices have no law of their own; use a larger numerics.mesh_size_mm"


def check_slices_unmeshed(bearing: Bearing, operation: Operation, axial: Axial) -> None:
    """The same before anything is meshed, of an outer ring that is held all around. UsageError."""
    if operation.mounting.points is not None or operation.mounting.bore is not None:
        return
    model = reduced_bearing(bearing, kinematics(bearing, *operation.ring_speeds), gravity=operation.gravity)
    rigid_start.check_slices(model, operation, axial, rigid_start.equilibrium_start(model, operation))


def check_slices(model: Model, axial: Axial, start: Start) -> None:
    """Refuse coupled slices that are too narrow for the forces of a start. UsageError."""
    contacts, _ = kept_contacts(model.bearing)
    laws, axes = (contacts.inner_law, contacts.outer_law), start.equilibrium.axes
    if axes is not None and (reason := narrow_slices(model.bearing, axial, laws, axes)) is not None:
        raise UsageError(reason)


def beyond_axes(arrays: Arrays) -> str | None:
    """`beyond_tables` of a run's arrays."""
    laws = [pair.law for group in arrays.groups for pair in group if isinstance(pair, Pair)]
    sliced = [law for law in laws if isinstance(law, SlicedLaw)]
    return beyond_tables(sliced[0].axes.tilts, tuple(law.table for law in sliced)) if sliced else None


def with_axes(
    arrays: Arrays,
    bearing: Bearing,
    operation: Operation,
    axial: Axial,
    cage: Cage | None,
    tilting: Tilting,
    start: Tilts,
) -> Arrays:
    """Arrays with axes that tilt from a start on."""
    rollers, (laws, rests) = arrays.bodies.rollers, laws_of(tuple(each.table for each in tilting.laws))
    part = None if rests[INNER] is None else part_profiles(bearing, rollers.columns)
    uneven = profiles(bearing) is not None
    absent = {} if uneven else {"edges": None}
    absent |= {} if part is not None else {"sunken": None}
    axes = filled(
        Axes,
        {"columns": rollers.columns},
        tilts=axes_at(bearing, operation, axial, cage, start, rollers.columns),
        tilted=filled(PatchMoments, {"columns": rollers.columns}, **absent),
        n=rollers.n,
    )
    outer = next(pair for group in arrays.groups for pair in group if getattr(pair, "row", None) == OUTER)

    def sliced(pair):
        if not isinstance(pair, Pair) or pair.surface is None:
            return pair
        of_hub = pair.row == INNER
        law = SlicedLaw(
            *pair.law,
            sign=pair.sign,
            table=laws[pair.row],
            axes=axes,
            length=float(bearing.roller_length),
            slope=axes.tilts.slope if of_hub else np.zeros(2),
            on_ring=axes.on_hub if of_hub else np.zeros(2),
            middle=outer.centre,
            back=outer.impulse,
            surfaces=_surfaces(pair, rests[pair.row], part) if uneven else None,
        )
        return pair._replace(law=law, **_without_edges(pair))

    return replace(
        arrays,
        bodies=arrays.bodies._replace(others=(*arrays.bodies.others, axes)),
        groups=tuple(tuple(sliced(pair) for pair in group) for group in arrays.groups),
    )


def _surfaces(raceway: Pair, rest: SpalledRest | None, part: PartProfiles | None) -> TiltedSurfaces:
    """What contacts with a raceway meet; `rest` and `part` where spalls take a part of the length."""
    of_part = None if part is None else (part.ring_profiles[raceway.row], part.roller_profiles[raceway.row])
    return TiltedSurfaces(
        rest=rest,
        whole=(raceway.profile, raceway.roller_profiles),
        part=of_part,
        frame=raceway.frame,
        moment=raceway.moment,
    )


def _without_edges(raceway: Pair) -> dict[str, RingProfile | RollerProfiles]:
    """A raceway's surfaces without edges, which tables take: for patches their compliances would be ripples."""
    found = {"profile": raceway.profile, "roller_profiles": raceway.roller_profiles}
    return {
        name: each._replace(compliance=at_line(np.zeros_like(each.compliance)))
        for name, each in found.items()
        if each is not None
    }
