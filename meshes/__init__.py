"""Meshes of a bearing's cross-section.

bearing  which shapes a bearing needs at a mesh size
shapes   Disc, Annulus, Mesh; gmsh makes them
graded   the same, fine at the surface that rolls and coarse elsewhere
refined  triangles as fine as a contact where it presses
quality  sizes and angles
cache    shipped, cached, or made now; `python -m meshes` re-makes the shipped ones
"""

from meshes.bearing import BearingShapes, bearing_shapes, graded_shapes
from meshes.cache import mesh_of
from meshes.export import Quality, quality
from meshes.graded import GradedAnnulus, GradedDisc
from meshes.refined import RefinedDisc, RefinedSector, Spot, refined_mesh
from meshes.shapes import Annulus, Disc, Mesh, Shape

__all__ = [
    "Annulus",
    "BearingShapes",
    "Disc",
    "GradedAnnulus",
    "GradedDisc",
    "Mesh",
    "Quality",
    "RefinedDisc",
    "RefinedSector",
    "Shape",
    "Spot",
    "bearing_shapes",
    "graded_shapes",
    "mesh_of",
    "quality",
    "refined_mesh",
]
