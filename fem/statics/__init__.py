"""Bearings at rest.

contact_balance   hub and rollers on elastic contacts
pressure_balance  hub and rollers on contacts of many points that push or stand open
equilibrium       of a model, by either of the two
exact_statics     the whole bearing without a mesh, the reference of `equilibrium`
reduced_bearing   the same series as the dynamics of the reduced model take them
vibrating_bearing elastic waves of its bodies, to which impacts lose energy
"""
