"""Meshes of a bearing's cross-section, shipped, cached or made now; `python -m meshes` re-makes the shipped ones."""

from meshes.bearing import BearingShapes, bearing_shapes, graded_shapes
from meshes.cache import mesh_of
from meshes.export import Quality, quality
from meshes.graded import GradedAnnulus, GradedDisc
from meshes.shapes import Annulus, Disc, Mesh, Shape

__all__ = ["Annulus", "BearingShapes", "Disc", "GradedAnnulus", "GradedDisc", "Mesh", "Quality", "Shape",
           "bearing_shapes", "graded_shapes", "mesh_of", "quality"]  # fmt: skip
