"""Statics on three meshes and Richardson's value: what a finer mesh would change, without a run."""

from dataclasses import dataclass
from math import pi, sqrt

from fem.errors import UsageError
from fem.quantities import Quantity
from fem.solver.error_estimate import ORDER
from fem.solver.finite_elements import make_plan
from fem.statics.equilibrium import static_quantities
from fem.statics.exact_statics import exact_statics
from lagrange.contact.hertz import contact_pairs
from lagrange.mounting import HELD
from lagrange.scene.run import COMPARISONS
from lagrange.scene.scene import Scene

COARSER = 2.0, sqrt(2.0), 1.0  # mesh sizes over the finest


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """The bearing at rest on one mesh."""

    size: float  # mm, between surface nodes
    nodes: int
    quantities: tuple[Quantity, ...]


@dataclass(frozen=True, kw_only=True)
class MeshTable:
    """Meshes from coarse to fine."""

    meshes: tuple[Mesh, ...]
    exact: tuple[float | None, ...]  # by the quantities, of the series; None: it has no such solution

    @property
    def extrapolated(self) -> tuple[float, ...]:
        """f = f_fine + (f_fine − f_coarse)/(r² − 1), r the mesh sizes' ratio, by the quantities.

        Source: Roache, Perspective: a method for uniform reporting of grid refinement studies (1994); order 2.
        """
        coarse, fine = self.meshes[0], self.meshes[-1]
        grown = (coarse.size / fine.size) ** ORDER - 1.0
        pairs = zip(coarse.quantities, fine.quantities, strict=True)
        return tuple(f.value + (f.value - c.value) / grown for c, f in pairs)


def mesh_table(scene: Scene) -> MeshTable:
    """Hub, largest roller load and Hertz pressure at rest, on the scene's mesh and two others.

    The scene's mesh is the finest; where meshes twice as coarse are too coarse for the rollers it is the coarsest.

    Errors
    ------
    UsageError: balls, a contact model without an order of convergence, or no equilibrium.
    """
    if scene.contact.model in COMPARISONS:
        raise UsageError(
            f"--converge: contact.model = '{scene.contact.model}' is there for comparison only and has no order of "
            "convergence; leave one of them out"
        )
    if scene.axial is not None:
        raise UsageError("--converge: compares plane sections at rest; leave [axial] out")
    size = scene.numerics.mesh_size_mm
    finest = size if COARSER[0] * size <= 0.1 * pi * scene.bearing.roller_diameter_mm else size / COARSER[0]
    pair = contact_pairs(scene.perfect_bearing())[0]
    meshes = []
    for each in (finest * factor for factor in COARSER):
        plan = make_plan(scene.varied({"model": "fem", "numerics.mesh_size_mm": each}))
        found = {quantity.name: quantity for quantity in static_quantities(plan.model, scene.ideal_operation())}
        force = found["static_largest_force"]
        pressure = Quantity("static_peak_pressure", "Pa", "largest Hertz pressure, inner raceway, at rest",
                            pair.peak_pressure(force.value))  # fmt: skip
        meshes.append(Mesh(size=each, nodes=plan.mesh_nodes, quantities=(found["static_hub_y"], force, pressure)))
    return MeshTable(meshes=tuple(meshes), exact=_exact(scene))


def _exact(scene: Scene) -> tuple[float | None, ...]:
    """By the series, rollers without weight; None where they do not hold."""
    bearing, operation = scene.perfect_bearing(), scene.ideal_operation()
    rigid = any(material.rigid for material in (bearing.roller, bearing.inner_ring, bearing.outer_ring))
    if scene.has_faults or rigid or operation.mounting != HELD or operation.side_load or scene.lubricant is not None:
        return None, None, None
    load = float(operation.radial_load) + operation.inner_mass * operation.gravity
    found = exact_statics(bearing, load, operation.first_roller_angle)
    force = float(found.inner_force.max())
    return float(found.hub[1]), force, contact_pairs(bearing)[0].peak_pressure(force)
