"""Bearings at rest.

contact_balance   hub and rollers on elastic contacts
equilibrium       of the finite elements with the law below the grid; resolved_statics: of resolved contacts
pressure_balance  hub and rollers on contacts of many points that push or stand open
exact_statics     the whole bearing without a mesh, a yardstick
quadratic_statics the whole bearing on refined quadratic elements, another
solve             the one that belongs to a scene, and how far it is from the exact one
quantities        what a researcher reads off a run
"""
