"""Rings: one sector's stencil run along contiguous sectors.

State in polar components in the ring's own frame, about the outer ring's centre: `u` displacement (rigid motion of the
hub included), `w` absolute velocity. Arrays (n_rows, 2, HALO + n_sectors + HALO); the nearest halo columns repeat the
other end so that the stencil needs no wrap.
"""

import numpy as np
from numba import uint64

from fem.kernels.jit import kernel

HALO = 8  # one register: keeps the rows aligned


def coefficients(stencil: np.ndarray) -> np.ndarray:
    """Stencil (n_rows, 3, 3, 2, 2) as (n_rows, 18): per neighbouring row radial own, pair, cross, then tangential."""
    own, ahead = stencil[:, :, 1], stencil[:, :, 2]
    radial = np.stack([own[..., 0, 0], ahead[..., 0, 0], ahead[..., 0, 1]], axis=-1)
    tangential = np.stack([own[..., 1, 1], ahead[..., 1, 1], ahead[..., 1, 0]], axis=-1)
    return np.ascontiguousarray(np.concatenate([radial.reshape(-1, 9), tangential.reshape(-1, 9)], axis=1))


@kernel(fastmath={"contract", "nsz", "reassoc"})
def row_force(table, u, row, radial, tangential):
    """radial, tangential += table·u for one row of nodes.

    Parameters
    ----------
    table : (n_rows, 18), see `coefficients`, times any factor; radial, tangential : (n_sectors + 2 HALO,)
    """
    n_rows, width = u.shape[0], u.shape[2]
    below, above = max(row - 1, 0), min(row + 1, n_rows - 1)  # their coefficients are 0 past the ends
    a, b, c = u[below, 0], u[row, 0], u[above, 0]
    d, e, f = u[below, 1], u[row, 1], u[above, 1]
    r = table[row]
    r0, r1, r2, r3, r4, r5, r6, r7, r8 = r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]
    t0, t1, t2, t3, t4, t5, t6, t7, t8 = r[9], r[10], r[11], r[12], r[13], r[14], r[15], r[16], r[17]
    one = uint64(1)  # unsigned: a signed index would be checked for wrapping and the loop not vectorised
    for column in range(HALO, width - HALO):
        k = uint64(column)
        i, j = k - one, k + one
        radial[k] += (
            (r0 * a[k] + r1 * (a[i] + a[j]) + r2 * (d[j] - d[i]))
            + (r3 * b[k] + r4 * (b[i] + b[j]) + r5 * (e[j] - e[i]))
            + (r6 * c[k] + r7 * (c[i] + c[j]) + r8 * (f[j] - f[i]))
        )
        tangential[k] += (
            (t0 * d[k] + t1 * (d[i] + d[j]) + t2 * (a[j] - a[i]))
            + (t3 * e[k] + t4 * (e[i] + e[j]) + t5 * (b[j] - b[i]))
            + (t6 * f[k] + t7 * (f[i] + f[j]) + t8 * (c[j] - c[i]))
        )


@kernel
def kick(table, u, w, first_row, last_row):
    """w += dt·internal acceleration for rows first_row ... last_row − 1; table holds −dt·M⁻¹K."""
    for row in range(first_row, last_row):
        row_force(table, u, row, w[row, 0], w[row, 1])


@kernel(fastmath={"contract", "nsz"})
def accelerate(w, line, first_row, last_row):
    """Add the velocities of one row, (2, width), m/s, to every row: gravity."""
    width = w.shape[2]
    radial, tangential = line[0], line[1]
    for row in range(first_row, last_row):
        p, q = w[row, 0], w[row, 1]
        for column in range(HALO, width - HALO):
            k = uint64(column)
            p[k] += radial[k]
            q[k] += tangential[k]


@kernel(fastmath={"contract", "nsz"})
def drift(u, w, radii, dt, cosine, sine, first_row, last_row):
    """Move by dt·w and turn the frame by the given angle."""
    width = u.shape[2]
    for row in range(first_row, last_row):
        radius = radii[row]
        p, q, a, b = w[row, 0], w[row, 1], u[row, 0], u[row, 1]
        for column in range(HALO, width - HALO):
            k = uint64(column)
            x = radius + (a[k] + dt * p[k])
            y = b[k] + dt * q[k]
            a[k] = (cosine * x + sine * y) - radius
            b[k] = cosine * y - sine * x
            x, y = p[k], q[k]
            p[k] = cosine * x + sine * y
            q[k] = cosine * y - sine * x
        wrap(a)
        wrap(b)


@kernel(fastmath={"contract", "nsz"})
def drift_still(u, w, dt, first_row, last_row):
    """Move by dt·w; the frame does not turn."""
    width = u.shape[2]
    for row in range(first_row, last_row):
        for component in range(2):
            p, a = w[row, component], u[row, component]
            for column in range(HALO, width - HALO):
                k = uint64(column)
                a[k] += dt * p[k]
            wrap(a)


@kernel
def wrap(line):
    """Repeat the first and last sector in the halo."""
    last = line.size - HALO
    line[HALO - 1] = line[last - 1]
    line[last] = line[HALO]


@kernel(fastmath={"contract", "nsz"})
def set_rigid(line_r, line_t, cosines, sines, x, y):
    """Displacement of a circle that moves rigidly by (x, y) in the frame's axes."""
    width = line_r.size
    for column in range(HALO, width - HALO):
        k = uint64(column)
        line_r[k] = x * cosines[k] + y * sines[k]
        line_t[k] = y * cosines[k] - x * sines[k]
    wrap(line_r)
    wrap(line_t)


@kernel(fastmath={"contract", "nsz", "reassoc"})
def resultant(radial, tangential, cosines, sines):
    """Sum of polar nodal forces of one row: x, y in the frame's axes."""
    x, y = 0.0, 0.0
    for column in range(HALO, radial.size - HALO):
        k = uint64(column)
        x += radial[k] * cosines[k] - tangential[k] * sines[k]
        y += radial[k] * sines[k] + tangential[k] * cosines[k]
    return x, y
