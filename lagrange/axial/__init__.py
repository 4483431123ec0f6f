"""The third dimension of a contact: profiles, slices of a tilted roller, and the table of a contact's energy.

`profile` holds drops along the axis, `slices` the forces of a roller's slices, `table` one contact's energy by approach
and slope, `tabulate` makes tables, `facts` is what a scene says of all of them.
"""

from lagrange.axial.facts import Axial
from lagrange.axial.table import ContactTable, SpalledTable
from lagrange.axial.tabulate import contact_tables

__all__ = ["Axial", "ContactTable", "SpalledTable", "contact_tables"]
