"""The hub's static displacement with the outer ring held around few points of its outside only."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import splu

from fem.contacts.model import Model
from fem.contacts.patch import ring_patch_force
from fem.contacts.reduction import standing
from fem.contacts.subgrid import SubgridModel
from fem.elastic.assembly import assemble
from fem.statics.contact_balance import Condensed, Loads, balance, closed_forces, first_guess
from lagrange.scene import read_scene
from meshes import mesh_of

MESH = 1e-3  # m
HALF_SUPPORT = 3e-3  # m, along the outside; much less would be a hinge
POSITIONS = 4  # of the rollers over one pitch

SUPPORTS = {  # degrees from +x
    "all around": None,
    "top": (90.0,),
    "bottom": (270.0,),
    "both sides": (0.0, 180.0),
    "top and 120° off": (90.0, 210.0, 330.0),
}
OUTSIDE_MM = (65.0, 62.0, 60.0)  # 4.5 mm behind the raceway, as in this project; 3 mm; 2 mm


@dataclass(frozen=True, kw_only=True)
class Held:
    """Positions of the hub under 2000 N while the rollers pass over one pitch, µm."""

    supports: str
    outside_mm: float
    x: tuple[float, float]
    y: tuple[float, float]
    loaded: tuple[int, int]
    widest: float  # largest displacement of the raceway


def held_cases() -> list[Held]:
    """Solve every ring with every support."""
    return [held(outside, name) for outside in OUTSIDE_MM for name in SUPPORTS]


def held(outside_mm: float, name: str) -> Held:
    """Solve one ring with one of SUPPORTS."""
    scene = read_scene(None, (f"bearing.outside_diameter_mm={outside_mm}",))
    model = SubgridModel.build(scene.ideal_bearing(), MESH)
    solve = supported(model, SUPPORTS[name])
    load = scene.operation.radial_load_N
    pitch = 2.0 * np.pi / model.bearing.n_rollers
    first = scene.ideal_operation().first_roller_angle
    hubs, counts, widest = [], [], 0.0
    for angle in first + pitch * np.arange(POSITIONS) / POSITIONS:
        hub, forces, moved = _balance(model, standing(model.bearing, angle), load, solve)
        hubs.append(1e6 * hub)
        counts.append(int(np.count_nonzero(forces)))
        widest = max(widest, 1e6 * float(moved))
    x, y = np.array(hubs).T
    return Held(
        supports=name,
        outside_mm=outside_mm,
        x=(x.min(), x.max()),
        y=(y.min(), y.max()),
        loaded=(min(counts), max(counts)),
        widest=widest,
    )


def supported(model: Model, degrees: tuple[float, ...] | None):
    """Make the function from polar nodal forces (n_rows, 2, n_sectors, m) to displacements of the ring held there."""
    ring = model.outer_ring
    if degrees is None:
        return ring.held
    matrix = assemble(mesh_of(ring.shape), ring.material, model.bearing.roller_length).stiffness.tocsc()
    radius = float(ring.radii[ring.held_row])
    apart = np.angle(np.exp(1j * (ring.angles[:, None] - np.radians(degrees)[None, :])))
    near = np.flatnonzero(np.abs(apart).min(axis=1) * radius <= HALF_SUPPORT)
    fixed = 2 * (ring.held_row * ring.n_sectors + near)[:, None] + np.arange(2)
    free = np.setdiff1d(np.arange(matrix.shape[0]), fixed)
    factor = splu(matrix[free][:, free])

    def solve(force):
        count = force.shape[-1]
        moved = np.zeros((matrix.shape[0], count))
        vectors = np.stack([ring.cartesian(force[..., k]).ravel() for k in range(count)], axis=-1)
        moved[free] = factor.solve(np.ascontiguousarray(vectors[free]))
        return np.stack([ring.polar(moved[:, k].reshape(-1, 2)) for k in range(count)], axis=-1)

    return solve


def _balance(model: Model, motion, load: float, solve):
    """Solve for the hub, m, the inner forces, N, and the raceway's largest displacement, m."""
    ring, n = model.outer_ring, model.bearing.n_rollers
    radial = np.column_stack([np.cos(motion.roller_angle), np.sin(motion.roller_angle)])
    patches = model.reduced(motion, 0.0, np.concatenate([np.zeros(2), np.full(n, model.bearing.pitch_radius)]))
    loads = np.stack([ring_patch_force(ring, a) for a in motion.roller_angle], axis=-1)
    response = solve(loads)
    compliance = patches.compliance.copy()
    compliance[n:, n:] += np.einsum("rcki,rckj->ij", loads, response) - np.einsum(
        "rcki,rckj->ij", loads, patches.outer_response
    )
    contacts = Condensed(
        bearing=model.bearing, radial=radial, inner_law=model.inner_law, outer_law=model.outer_law,
        compliance=compliance, closing=patches.closing,
    )  # fmt: skip
    position, forces = balance(contacts, Loads(load, 0.0, 0.0), first_guess(model.bearing, radial, load))
    forces = closed_forces(forces)
    moved = response[ring.raceway_row] @ forces[n:]
    return position[:2], forces[:n], np.hypot(*moved).max()
