"""From a scene to its discrete model: which mesh, which contact model."""

from dataclasses import replace
from functools import lru_cache
from importlib import import_module

from fem.contacts import MODELS, ONE_PATCH
from fem.contacts.model import Model
from fem.elastic.outer_support import bored_ring, supported_ring
from fem.solver.limits import check_contact_model, check_mesh_size, check_meshes, check_outer_ring, check_rollers
from fem.statics.exact_statics import ExpectedForces
from lagrange import Bearing
from lagrange.contact.hertz import contact_pairs
from lagrange.scene.scene import Scene


def expected_forces(scene: Scene) -> ExpectedForces:
    """The contact forces to expect of a scene."""
    return ExpectedForces(scene.ideal_bearing(), scene.ideal_operation())


def model_of(scene: Scene, expected: ExpectedForces | None = None) -> Model:
    """The discrete model of a scene; `expected`: its forces, where they are needed elsewhere too.

    Errors
    ------
    RuntimeError: gmsh is needed and missing. UsageError: balls, which no plane section describes; the mesh is too
    coarse to resolve the contacts or for a ring, or has too many nodes.
    """
    check_rollers(scene)
    expected = expected_forces(scene) if expected is None else expected
    bearing, mesh_size = expected.bearing, 1e-3 * scene.numerics.mesh_size_mm
    kind = contact_model(scene.contact.model, mesh_size, expected)
    check_mesh_size(bearing, mesh_size, kind.shapes)
    check_contact_model(kind, scene, expected)
    check_outer_ring(kind, scene)
    if not kind.is_of_mesh_alone:
        model = kind.build(bearing, mesh_size, expected, scene.contact)
        check_meshes(model)
        return model
    sound = replace(bearing, faults=())
    model, mounting = replace(_built(kind, sound, mesh_size), bearing=bearing), scene.mounting()
    # calibrated held all around: what a mesh lacks at a contact is the same wherever the ring is held
    if mounting.points is not None:
        return replace(model, outer_ring=supported_ring(model.outer_ring, mounting.points))
    if mounting.bore is not None:
        return replace(model, outer_ring=bored_ring(model.outer_ring, mounting.bore, bearing.roller_length))
    return model


@lru_cache(maxsize=1)
def _built(kind: type[Model], bearing: Bearing, mesh_size: float) -> Model:
    """The model of a bearing without faults, the last one kept: scenes that follow differ in speed, load or faults."""
    found = kind.build(bearing, mesh_size)
    check_meshes(found)
    return found


def contact_model(name: str, mesh_size: float, expected: ExpectedForces) -> type[Model]:
    """The contact model of a scene's name: on a mesh, m, that is fine enough for it."""
    *finer, usual = MODELS[name]
    pairs = contact_pairs(expected.bearing)[:2]

    def is_fine(force: float) -> bool:
        return mesh_size < ONE_PATCH * max(pair.half_width(force) for pair in pairs)

    # the bound, far above what a roller carries, mostly spares solving the statics
    module, chosen = finer[0] if finer and is_fine(expected.bound) and is_fine(expected.largest) else usual
    return getattr(import_module(module), chosen)
