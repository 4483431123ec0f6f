"""The third dimension of a contact: profiles, slices of a tilted roller, the table of a contact's energy, pressures.

Read `slices` first, then `table`.
"""
