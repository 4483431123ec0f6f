"""The third dimension of a contact: profiles, slices of a tilted roller, the table of a contact's energy, pressures.

Read `slices` first, then `table`.
"""

from lagrange.axial.slices import Axial, contact_tables
from lagrange.axial.table import ContactTable, SpalledTable

__all__ = ["Axial", "ContactTable", "SpalledTable", "contact_tables"]
