"""Bearings at rest.

contact_balance   hub and rollers on elastic contacts
equilibrium       of the finite elements with the law below the grid; resolved_statics: of resolved contacts
exact_statics     the whole bearing without a mesh, the yardstick
solve             the one that belongs to a scene, and how far it is from the exact one
quantities        what a researcher reads off a run
"""
