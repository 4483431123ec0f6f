"""Bearings at rest.

`contact_balance` has hub and rollers on elastic contacts, `equilibrium` those of a meshed model, of many points too;
`exact_statics` is the whole bearing by series without a mesh, their reference, reduced to its contacts for dynamics.
"""
