"""Bearings at rest.

`contact_balance` has hub and rollers on elastic contacts, `equilibrium` those of a meshed model, of many points too;
`exact_statics` is the whole bearing without a mesh, its reference, `reduced_bearing` the same series for dynamics.
"""
