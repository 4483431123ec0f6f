"""The third dimension of a contact: profiles, slices of a tilted roller, and the table of a contact's energy.

`facts` is what a scene says of it; read `slices` first, then `table`.
"""

from lagrange.axial.facts import Axial
from lagrange.axial.slices import contact_tables
from lagrange.axial.table import ContactTable, SpalledTable

__all__ = ["Axial", "ContactTable", "SpalledTable", "contact_tables"]
