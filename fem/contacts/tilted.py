"""Tables of tilted contacts of elastic bodies: the plane law of the whole approach in slices that know each other."""

from dataclasses import dataclass, replace
from math import ceil, floor, log10

import numpy as np

from fem.contacts.contact_law import ContactLaw
from fem.elastic.axial_series import slice_compliance
from fem.elastic.cache import kept
from fem.elastic.continuum import hertz_approach, ring_sections, roller_section
from lagrange.axial.slices import Axial, Slices, contact_slices, contact_tables, without_part
from lagrange.axial.table import ContactTable, SpalledTable, TiltedContact, in_series
from lagrange.bearing import Bearing
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import LogarithmicLaw

FEWEST = 3  # slices
WIDTHS = 2.1  # half-widths of a contact that a coupled slice is wide at least; equilibria are not unique below 1.96
ANY_WIDTH = 0.01  # of a roller's radius: across it the width of a contact does not count
ROUND_OFF = 1e-9
SLOPES = 5e-4  # rad: tables are made for multiples, so that they serve other scenes too
NOTHING = 0.0, 0.0
SIDES = "inner", "outer"
TABLE = "first_approach", "approach_step", "first_slope", "slope_step", "coefficients"


def tilted_tables(
    bearing: Bearing, axial: Axial, laws: tuple[ContactLaw, ContactLaw], largest_force: float, largest_slope: float,
    meshed: tuple[float, float] = NOTHING,
) -> tuple[ContactTable | SpalledTable, ContactTable | SpalledTable]:  # fmt: skip
    """Tables of the inner and the outer contact by their plane laws, from the user's cache where they are there.

    largest_force : N, of a contact at rest; largest_slope : rad, of a roller to a ring, either way
    meshed : m/N, what meshes have of both contacts' compliances; tables are of the rest
    """
    sound = replace(bearing, faults=()).full
    force, slope = rounded_range(largest_force, largest_slope)

    def make():
        tables = contact_tables(sound, axial, *_slices(bearing, axial, laws, meshed, (force, slope)))
        sides = list(zip(SIDES, tables, strict=True))
        return {f"{side} {name}": np.asarray(getattr(table, name)) for side, table in sides for name in TABLE}

    key = repr((sound, axial, laws, force, slope, meshed))
    arrays, parts = kept("tilted", key, make), axial.parts(bearing)
    found = [{name: arrays[f"{side} {name}"] for name in TABLE} for side in SIDES]
    tables = [ContactTable(**{name: value if value.ndim else float(value) for name, value in one.items()})
              for one in found]  # fmt: skip

    def make_rest():
        slices = zip(SIDES, tilted_slices(bearing, axial, laws, meshed), tables, strict=True)
        return {side: without_part(own, table).coefficients for side, own, table in slices if own.part is not None}

    if any(part is not None for part in parts):
        rests = kept("tilted", key + repr([part if part is None else part.tolist() for part in parts]), make_rest)
        for k, part in enumerate(parts):
            if part is not None:
                rest = replace(tables[k], coefficients=rests[SIDES[k]])
                tables[k] = SpalledTable(whole=tables[k], rest=rest, share=float(part.mean()))
    return tables[0], tables[1]


def rounded_range(largest_force: float, largest_slope: float) -> tuple[float, float]:
    """Force, N, and slope, rad, up to which a table is made: steps of a digit's half, and of SLOPES."""
    power = 10.0 ** floor(log10(max(largest_force, 1.0)))
    return max(ceil(2.0 * largest_force / power), 1) * 0.5 * power, ceil(largest_slope / SLOPES) * SLOPES


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshedContact:
    """A contact as a whole, with what a mesh has of its compliance: `lagrange.axial.table.TiltedLaw` for statics."""

    table: ContactTable | SpalledTable  # of the rest
    meshed: float  # m/N

    @property
    def last_approach(self) -> float:
        """The largest, m, at which the table is known."""
        whole = self.table.whole if isinstance(self.table, SpalledTable) else self.table
        return whole.last_approach + self.meshed * float(whole.at(whole.last_approach, 0.0).force)

    has_part = property(lambda self: self.table.has_part)

    def at(self, approach, slope, *spalls) -> TiltedContact:
        """See `ContactTable.at` and `SpalledTable.at`."""
        found = in_series(self.table.at, approach, slope, self.meshed, *spalls)
        if not spalls:
            return found
        own = self.table.at(approach - self.meshed * found.force, slope, *spalls)
        return found._replace(edges=own.edges, part_edges=own.part_edges)


def tilted_slices(
    bearing: Bearing, axial: Axial, laws: tuple[ContactLaw, ContactLaw], meshed: tuple[float, float] = NOTHING
) -> tuple[Slices, Slices]:
    """The slices that the tables stand for: forces along a roller by its approach and slope; `meshed` as there."""
    return contact_slices(bearing, axial, *_slices(bearing, axial, laws, meshed))


def _slices(bearing, axial, laws, meshed, within=()):
    """Laws of slices, what a table is made for, and coupling compliances less those of meshes, which know a contact's
    force as a whole."""
    coupled = tuple(all_of - mesh for all_of, mesh in zip(couplings(bearing, axial), meshed, strict=True))
    widest = [law.Q_line for law in laws]  # straight beyond
    if axial.coupling:  # slices that know each other
        width = bearing.roller_length / axial.slices
        widest = [min(law.Q_line, (width / WIDTHS) ** 2 / law.pair.half_width_factor) for law in laws]
    plane = [LogarithmicLaw(name="series", compliance=0.5 * law.A, level=2.0 * law.B, largest_force=force,
                            source="plane series") for law, force in zip(laws, widest, strict=True)]  # fmt: skip
    return tuple(plane), *within, coupled


def too_narrow(bearing: Bearing, axial: Axial, half_width: float) -> str | None:
    """Why coupled slices can't carry a contact of a half-width, m, with the number that can; None: they do."""
    if half_width * WIDTHS <= bearing.roller_length / axial.slices * (1.0 + ROUND_OFF):
        return None
    return (
        f"axial.slices = {axial.slices} are {1e3 * bearing.roller_length / axial.slices:.3g} mm wide, less than "
        f"{WIDTHS:g} half-widths of the contact, {1e3 * half_width:.3g} mm, below which coupled slices have no sure "
        f"equilibrium; use at most {int(bearing.roller_length / (WIDTHS * half_width))}, or axial.coupling = false"
    )


def no_narrower(bearing: Bearing, axial: Axial, forces: tuple[np.ndarray, np.ndarray]) -> Axial:
    """As many coupled slices, or half as many as inner and outer forces, N, allow that are even along the rollers.

    So many have a sure equilibrium where forces are not even, and show how wide contacts are.
    """
    pairs = zip(contact_pairs(bearing), forces, strict=False)
    most = bearing.roller_length / (WIDTHS * max(pair.half_width(max(float(f.max()), 1e-3)) for pair, f in pairs))
    return axial if axial.slices <= most else replace(axial, slices=max(int(most) // 2, FEWEST))


def couplings(bearing: Bearing, axial: Axial) -> tuple[np.ndarray, np.ndarray]:
    """Coupling compliances of the slices, inner and outer contact, (slices, slices) each, m/N.

    The force of a roller's other contact is coupled to it as a whole; by as much as slices differ they squeeze the
    roller one by one. That is all where `axial.coupling` is off.
    """
    length, n, across = bearing.roller_length, axial.slices, 0.0
    if not bearing.roller.rigid:  # of one contact by an even line load on the other: squeezed less one that is pushed
        roller, width = roller_section(bearing), ANY_WIDTH * bearing.roller_radius
        across = hertz_approach(roller.squeezed, width) - hertz_approach(roller, width)
    squeezed = across * n / length * (np.eye(n) - 1.0 / n)
    if not axial.coupling:
        return squeezed, squeezed

    def make():
        roller = slice_compliance(roller_section(bearing).squeezed, length, length, n)
        inner, outer = (slice_compliance(ring, length, axial.ring_width, n) for ring in ring_sections(bearing))
        return {"inner": roller + inner, "outer": roller + outer}

    found = kept("slices", repr((bearing, n, axial.ring_width)), make)
    return found["inner"] + squeezed, found["outer"] + squeezed
