"""Tables of tilted contacts of elastic bodies: the plane law of the whole approach, in slices."""

from fem.contacts.contact_law import ContactLaw
from lagrange.axial import Axial, ContactTable, contact_tables
from lagrange.bearing import Bearing
from lagrange.contact.raceway_laws import LogarithmicLaw


def plane_law(law: ContactLaw) -> LogarithmicLaw:
    """The law δ = A Q (B − ½ ln Q) as slices take it."""
    return LogarithmicLaw(
        name="series", compliance=0.5 * law.A, level=2.0 * law.B, largest_force=law.Q_line, source="plane series"
    )


def tilted_tables(
    bearing: Bearing, axial: Axial, laws: tuple[ContactLaw, ContactLaw], largest_force: float, largest_slope: float
) -> tuple[ContactTable, ContactTable]:
    """Tables of the inner and the outer contact by their plane laws; see `lagrange.axial.contact_tables`."""
    return contact_tables(bearing, axial, tuple(plane_law(law) for law in laws), largest_force, largest_slope)
