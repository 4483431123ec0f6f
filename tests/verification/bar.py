"""A bar that falls on a rigid floor: an elastic strip moved by the solver's own assembly, leapfrog and contact law."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh

from fem.contacts.contact_law import ContactLaw
from fem.elastic.assembly import assemble
from fem.kernels import disc_kernels
from fem.kernels.law import contact_force
from fem.kernels.state import Disc
from lagrange import Material
from lagrange.contact.hertz import Pair
from meshes import Mesh
from tests.reference import compiled

# Doyen, Ern and Piperno 2011, section 5: a unit cross-section, any consistent units
LENGTH, MODULUS, DENSITY, GRAVITY, DROP = 10.0, 900.0, 1.0, 10.0, 5.0
ELASTIC = Material(youngs_modulus=MODULUS, poisson_ratio=0.0, density=DENSITY)
FLAT = Pair(kind="flat", radii=(np.inf, np.inf), materials=(ELASTIC, ELASTIC), length=1.0)  # no half-width is asked for
LEVEL = 50.0  # B of the contact law: its logarithm then bends the stiffness by 6 % at most


@dataclass(frozen=True, kw_only=True)
class Fall:
    """History of a fall, one row a step."""

    time: np.ndarray
    height: np.ndarray  # of the centre of mass, its height before the drop taken off
    velocity: np.ndarray  # of the centre of mass, in the middle of the step that ends here
    force: np.ndarray
    energy: np.ndarray  # elastic, kinetic, of the contact and of the weight


def strip(n_elements: int) -> Mesh:
    """Make the mesh, one column of squares, the bar standing on its two lowest nodes."""
    side = LENGTH / n_elements
    height = side * np.arange(n_elements + 1)
    points = np.stack([np.tile([0.0, side], n_elements + 1), np.repeat(height, 2)], axis=1)
    first = 2 * np.arange(n_elements)
    return Mesh(points=points, cells=np.stack([first, first + 1, first + 3, first + 2], axis=1))


def fall(n_elements: int, duration: float, safety: float = 0.9) -> Fall:
    """Drop the bar, unstrained and at rest, and follow it.

    Assembled by `fem.elastic.assembly` in plane strain, one-dimensional because Poisson's ratio is 0; moved by the
    kernels of a free body, whose frame is left standing; the floor pushes with `fem.kernels.law`, as stiff as one
    element.
    """
    mesh = strip(n_elements)
    side = LENGTH / n_elements
    bar = assemble(mesh, ELASTIC, 1.0 / side)
    law = ContactLaw(A=side / (MODULUS * LEVEL), B=LEVEL, Q_line=np.inf, pair=FLAT)
    stiffest = law.stiffness(1e3)
    dt = safety * 2.0 / sqrt(_largest_square(bar, stiffest))
    blocks = bar.stiffness.tobsr((2, 2))
    blocks.sort_indices()
    mass = bar.mass
    rows = np.repeat(np.arange(mass.size), np.diff(blocks.indptr))
    scaled = np.ascontiguousarray(-dt * blocks.data / mass[rows][:, None, None]).ravel()
    columns = disc_kernels.COLUMNS
    u, w = np.zeros((mass.size, 2, columns)), np.zeros((mass.size, 2, columns))
    still, torque = np.zeros(columns), np.zeros(columns)
    nodes = Disc(
        starts=blocks.indptr.astype(np.int64), neighbours=blocks.indices.astype(np.int64), blocks=scaled,
        points=np.ascontiguousarray(mesh.points).ravel(), grown=np.zeros(2 * mass.size),
        mass=mass, first=0, u=u.reshape(-1), w=w.reshape(-1), v=w.reshape(-1), calmed=w.reshape(-1),
    )  # fmt: skip
    turns = disc_kernels.Turns(still, np.ones(columns), still, still, still)
    floor = slice(0, 2)  # the nodes that touch it
    share = mass / mass.sum()
    history = []
    for step in range(int(duration / dt) + 1):
        gap = DROP + u[floor, 1, 0].mean()
        force = contact_force(-gap, law.A, law.B, law.Q_line, 0.0)
        before = w[:, :, 0].copy()
        w[floor, 1, 0] += 0.5 * force / mass[floor] * dt
        w[:, 1, 0] -= GRAVITY * dt
        compiled.kick_disc(nodes, nodes.w, columns, torque)
        after, place = w[:, :, 0], u[:, :, 0].ravel()
        energy = 0.5 * mass @ np.sum(before * after, axis=1) + 0.5 * place @ (bar.stiffness @ place)
        energy += compiled.stored_energy(force, law.A, law.B, law.Q_line) + GRAVITY * (
            mass @ u[:, 1, 0] + DROP * mass.sum()
        )
        history.append([step * dt, share @ u[:, 1, 0], share @ before[:, 1], force, energy])
        compiled.drift_disc(nodes, turns, columns, dt, torque)
    return Fall(**dict(zip(("time", "height", "velocity", "force", "energy"), np.array(history).T, strict=True)))


def _largest_square(bar, contact_stiffness: float) -> float:
    """ω² of the fastest mode of the bar standing on its contact."""
    springs = sparse.csr_matrix(bar.stiffness.shape).tolil()
    springs[np.ix_([1, 3], [1, 3])] = 0.25 * contact_stiffness
    scale = sparse.diags(1.0 / np.sqrt(np.repeat(bar.mass, 2)))
    start = np.random.default_rng(0).standard_normal(bar.stiffness.shape[0])
    return float(eigsh(scale @ (bar.stiffness + springs) @ scale, k=1, v0=start, return_eigenvectors=False)[0])
