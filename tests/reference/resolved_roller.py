"""A roller squeezed by two Hertz pressures, resolved: quadratic elements, a tenth of a half-width at the contacts."""

import gmsh
import numpy as np
from skfem import (
    Basis,
    ElementTriP1,
    ElementTriP2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshTri,
    asm,
    condense,
    solve,
)
from skfem.helpers import dot

from tests.reference.triangles import mesh_of_section, plane_strain_stiffness


def resolved_disc(radius, material, line_load, half_widths):
    """Stress along the axis of symmetry, from the lower contact to the upper one.

    `half_widths`: of the lower and the upper contact, m; `line_load`, N/m, on both. One half of the disc is meshed.
    Returns y, m, and σ_xx, σ_yy, Pa.
    """
    mesh = _half_disc(radius, half_widths)
    basis = Basis(mesh, ElementVector(ElementTriP2()))
    lam, mu = material.lame_lambda, material.lame_mu

    @LinearForm
    def pressure(v, w):
        x, y = w.x
        arc = radius * np.arctan2(np.abs(x), np.abs(y))
        b = np.where(y < 0.0, half_widths[0], half_widths[1])
        p = 2.0 * line_load / (np.pi * b) * np.sqrt(np.maximum(1.0 - (arc / b) ** 2, 0.0))
        return -p * dot(w.n, v)

    rim = mesh.facets_satisfying(lambda x: np.abs(np.hypot(*x) - radius) < 1e-3 * radius, boundaries_only=True)
    load = asm(pressure, FacetBasis(mesh, ElementVector(ElementTriP2()), facets=rim, intorder=8))
    axis = basis.get_dofs(lambda x: np.abs(x[0]) < 1e-12).all("u^1")
    middle = basis.get_dofs(lambda x: (np.abs(x[0]) < 1e-12) & (np.abs(x[1]) < 1e-12)).all("u^2")
    u = solve(*condense(plane_strain_stiffness(basis, material), load, D=np.concatenate([axis, middle])))

    gradient = basis.interpolate(u).grad
    strain = 0.5 * (gradient + np.swapaxes(gradient, 0, 1))
    linear = basis.with_element(ElementTriP1())
    on_axis = np.flatnonzero(np.abs(mesh.p[0]) < 1e-12)
    on_axis = on_axis[np.argsort(mesh.p[1, on_axis])]
    stress = [2.0 * mu * strain[i, i] + lam * (strain[0, 0] + strain[1, 1]) for i in (0, 1)]
    return mesh.p[1, on_axis], *(linear.project(s)[on_axis] for s in stress)


def _half_disc(radius, half_widths) -> MeshTri:
    """The half x >= 0 of a disc, its nodes closer together towards the contacts at the axis' ends."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        centre = geo.addPoint(0.0, 0.0, 0.0)
        ends = [geo.addPoint(0.0, sign * radius, 0.0) for sign in (-1.0, 1.0)]
        side = geo.addPoint(radius, 0.0, 0.0)
        lines = [
            geo.addCircleArc(ends[0], centre, side), geo.addCircleArc(side, centre, ends[1]),
            geo.addLine(ends[1], centre), geo.addLine(centre, ends[0]),
        ]  # fmt: skip
        geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        field = gmsh.model.mesh.field
        sizes = []
        for end, b in zip(ends, half_widths, strict=True):
            distance = field.add("Distance")
            field.setNumbers(distance, "PointsList", [end])
            sizes.append(field.add("MathEval"))
            field.setString(sizes[-1], "F", f"Max({0.1 * b}, Min(0.15 * F{distance}, {0.1 * radius}))")
        smallest = field.add("Min")
        field.setNumbers(smallest, "FieldsList", sizes)
        field.setAsBackgroundMesh(smallest)
        for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
            gmsh.option.setNumber(f"Mesh.{option}", 0)
        return mesh_of_section()
    finally:
        gmsh.finalize()
