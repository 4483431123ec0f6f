"""Meshes of a bearing's cross-section.

bearing  which shapes a bearing needs at a mesh size
shapes   Disc, Annulus, Mesh; gmsh makes them
quality  sizes and angles
cache    shipped, cached, or made now; `python -m meshes` re-makes the shipped ones
"""

from meshes.bearing import BearingShapes, bearing_shapes
from meshes.cache import mesh_of
from meshes.quality import Quality, quality
from meshes.shapes import Annulus, Disc, Mesh

__all__ = ["Annulus", "BearingShapes", "Disc", "Mesh", "Quality", "bearing_shapes", "mesh_of", "quality"]
