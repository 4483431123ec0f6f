"""Rings: one sector's stencil run along contiguous sectors, eight per register.

State in polar components in the ring's own frame, about the outer ring's centre: `u` displacement (rigid motion of the
hub included), `w` absolute velocity. Arrays (n_rows, 2, HALO + n_sectors + HALO), n_sectors a multiple of 8. Halos of
`u` repeat the other end, one column on the left, all on the right, so that neither the stencil nor patches need a wrap;
those of `w` do while the stencil is applied to it, and are room at other times, see `surfaces`.

Equation (1) of docs/method.md.
"""

import numpy as np

from fem.kernels.drive import speed_of
from fem.kernels.jit import part
from fem.kernels.lanes import WIDTH, fma, from_left, from_right, gather, load, splat, store, total

HALO = WIDTH  # one register: keeps the rows aligned


def coefficients(stencil: np.ndarray) -> np.ndarray:
    """Stencil (n_rows, 3, 3, 2, 2) as (n_rows, 18): per neighbouring row radial own, pair, cross, then tangential."""
    own, ahead = stencil[:, :, 1], stencil[:, :, 2]
    radial = np.stack([own[..., 0, 0], ahead[..., 0, 0], ahead[..., 0, 1]], axis=-1)
    tangential = np.stack([own[..., 1, 1], ahead[..., 1, 1], ahead[..., 1, 0]], axis=-1)
    return np.ascontiguousarray(np.concatenate([radial.reshape(-1, 9), tangential.reshape(-1, 9)], axis=1))


@part
def _give(r, at, a, b, c, d, e, f):
    """What eight nodes of three rows give to one component of the middle row: at, left and right of themselves.

    `r` : the row's coefficients, of which nine from `at` on; a, b, c : this component below, in and above the row;
    d, e, f : the other one.
    """
    own = r[at] * a + r[at + 3] * b + r[at + 6] * c
    pair = r[at + 1] * a + r[at + 4] * b + r[at + 7] * c
    cross = r[at + 2] * d + r[at + 5] * e + r[at + 8] * f
    return own, pair + cross, pair - cross


@part
def _give_both(r, u, below, row, above, width, k):
    """`_give` of columns k ... k + 7 to the radial and to the tangential component."""
    a, b, c = load(u, below + k), load(u, row + k), load(u, above + k)
    d, e, f = load(u, below + width + k), load(u, row + width + k), load(u, above + width + k)
    return _give(r, 0, a, b, c, d, e, f), _give(r, 9, d, e, f, a, b, c)


@part
def _row_force(table, u, row, out, at, base, added):
    """out = base + table·u for one row of nodes, radial from index `at` on, tangential a line further.

    Every node's part is formed once and handed to its neighbours' columns, instead of reading three columns for each.
    `added` : a line, the index that it begins at, and by what it is multiplied; None, of `base`, too: nothing.
    """
    width = u.shape[2]
    # past the ends coefficients are 0
    below, above = 2 * width * max(row - 1, 0), 2 * width * min(row + 1, u.shape[0] - 1)
    t = table[row]
    half = (t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8])
    r = (*half, t[9], t[10], t[11], t[12], t[13], t[14], t[15], t[16], t[17])  # in registers: `out` might be `table`
    row = 2 * width * row
    before_r, before_t = _give_both(r, u, below, row, above, width, 0)
    radial, tangential = _give_both(r, u, below, row, above, width, HALO)
    for k in range(HALO, width - HALO, WIDTH):
        next_r, next_t = _give_both(r, u, below, row, above, width, k + WIDTH)
        x = radial[0] + (from_left(before_r[2], radial[2]) + from_right(radial[1], next_r[1]))
        y = tangential[0] + (from_left(before_t[2], tangential[2]) + from_right(tangential[1], next_t[1]))
        if added is not None:
            line, from_, times = added
            x, y = fma(times, load(line, from_ + k), x), fma(times, load(line, from_ + width + k), y)
        if base is not None:
            x, y = load(base, at + k) + x, load(base, at + width + k) + y
        store(out, at + k, x)
        store(out, at + width + k, y)
        before_r, radial, before_t, tangential = radial, next_r, tangential, next_t


@part(inlined=False)
def row_force(table, u, row, out):
    """out = table·u for one row of nodes.

    table : (n_rows, 18), see `coefficients`, times any factor; out : (2, n_sectors + 2 HALO)
    """
    _row_force(table, u, row, out, 0, None, None)


@part(inlined=False)
def kick(table, u, w, line, first_row, last_row):
    """w += dt·internal acceleration for rows first_row ... last_row − 1; table holds −dt·M⁻¹K.

    `line` : (2, width), m/s, velocities of one row, added to every row: gravity; None: nothing
    """
    for row in range(first_row, last_row):
        _row_force(table, u, row, w, 2 * row * u.shape[2], w, None if line is None else (line, 0, 1.0))


@part(inlined=False)
def calm(calming, w, calmed, grown, ahead, first_row, last_row):
    """calmed = w + calming·w, ready for the stencil as w is; `calming` holds −β dt²·M⁻¹K.

    `grown` : (n_rows,), m/s, of which `ahead` times is added all around, see `drift`
    """
    width = w.shape[2]
    for row in range(first_row, last_row):
        at, more = 2 * row * width, ahead * grown[row]
        _row_force(calming, w, row, calmed, at, w, None)
        if more != 0.0:
            for k in range(at + HALO, at + width - HALO, WIDTH):
                store(calmed, k, load(calmed, k) + more)
        wrap(calmed, at, width)


@part
def calm_held(ring, mass, line):
    """The same of a ring's held row, which moves with a body of `mass`, kg. `line` : (2, width), room"""
    row_force(ring.calming, ring.w, ring.held, line)
    x, y = resultant(line, ring.cosines, ring.sines)
    width, share = ring.cosines.size, ring.row_mass[ring.held] / mass
    at = 2 * ring.held * width
    set_rigid(ring.calmed, at, ring.cosines, ring.sines, share * x, share * y)
    for k in range(at, at + 2 * width, WIDTH):
        store(ring.calmed, k, load(ring.calmed, k) + load(ring.w, k))


@part(inlined=False)
def slow_waves(slowed, u, calmed, first_row, last_row, raceway):
    """Take from the nodes' motion what the reciprocal mass does; `slowed` holds −γ dt³·M⁻¹K.

    Not from that of the raceway's, which have their velocities.
    """
    for row in range(first_row, last_row):
        if row != raceway:
            _row_force(slowed, calmed, row, u, 2 * row * u.shape[2], u, None)


@part(inlined=False)
def find_velocities(slowed, calmed, w, v, dt, raceway):
    """v, velocities of a raceway's nodes in the step to come; all is ready for the stencil."""
    width, over = w.shape[2], 1.0 / dt
    at = 2 * raceway * width
    _row_force(slowed, calmed, raceway, v, at, None, (w, at, dt))
    for k in range(at, at + 2 * width, WIDTH):
        store(v, k, load(v, k) * over)
    wrap(v, at, width)


@part(inlined=False)
def drift(motion, radii, grown, dt, turn, rows):
    """Move rows of nodes by dt·w, the raceway by dt·v, and turn the frame.

    `motion` : u, w and v; `turn` : cosine and sine; `rows` : the first one, the one after the last, the raceway's
    `grown` : (n_rows,), m/s; what `slow_waves` has made of the motion along chords, half a step ahead of the frame
    """
    (u, w, v), (first_row, last_row, raceway) = motion, rows
    width, ahead = u.shape[2], (1.0 - turn[0]) * (1.0 / dt)
    for row in range(first_row, last_row):
        radius, at = radii[row], 2 * row * width
        reached = radius + ahead * grown[row]
        if row == raceway:
            _drift_row(u, w, v, at, radius, reached, dt, turn)
        else:
            _drift_row(u, w, w, at, radius, reached, dt, turn)
        wrap(u, at, width)


@part
def _drift_row(u, w, moved, at, radius, reached, dt, turn):
    width, (cosine, sine) = u.shape[2], turn
    for k in range(at + HALO, at + width - HALO, WIDTH):
        x = reached + fma(dt, load(moved, k), load(u, k))
        y = fma(dt, load(moved, k + width), load(u, k + width))
        p, q = load(w, k), load(w, k + width)
        store(u, k, (cosine * x + sine * y) - radius)
        store(u, k + width, cosine * y - sine * x)
        store(w, k, cosine * p + sine * q)
        store(w, k + width, cosine * q - sine * p)


@part(inlined=False)
def drift_still(u, w, dt, first_row, last_row):
    """Move by dt·w; the frame does not turn."""
    width = u.shape[2]
    for at in range(2 * first_row * width, 2 * last_row * width, 2 * width):
        for k in range(at, at + 2 * width, WIDTH):
            store(u, k, fma(dt, load(w, k), load(u, k)))
        wrap(u, at, width)


@part(inlined=False)
def drift_slowed(slowed, motion, calmed, dt, rows):
    """Move by dt·w as `slow_waves` does; the raceway moves by dt·v; the frame does not turn. See `drift`."""
    (u, w, v), (first_row, last_row, raceway) = motion, rows
    width = u.shape[2]
    for row in range(first_row, last_row):
        at = 2 * row * width
        if row == raceway:
            for k in range(at, at + 2 * width, WIDTH):
                store(u, k, fma(dt, load(v, k), load(u, k)))
        else:
            _row_force(slowed, calmed, row, u, at, u, (w, at, dt))
        wrap(u, at, width)


@part(inlined=False)
def wrap(u, at, width):
    """Repeat the first eight sectors and the last one of both lines of `width` from index `at` on in their halos."""
    for component in range(2):
        line = at + component * width
        last = line + width - HALO
        store(u, line + HALO - 1, gather(u, last - 1))
        store(u, last, load(u, line + HALO))


@part(inlined=False)
def wrap_all(w):
    """Repeat every line's ends in its halos, for the stencil to be applied to velocities."""
    for at in range(0, w.size, 2 * w.shape[2]):
        wrap(w, at, w.shape[2])


@part(inlined=False)
def unwrap(w, row):
    """Clear the right halo of a row of velocities again: the raceway's, where patches that reach over the end push."""
    width = w.shape[2]
    for at in range(2 * row * width, 2 * (row + 1) * width, width):
        store(w, at + width - HALO, splat(0.0))


@part(inlined=False)
def set_rigid(out, at, cosines, sines, x, y):
    """Displacement of a circle that moves rigidly by (x, y) in the frame's axes.

    Radial from index `at` of `out` on, tangential cosines.size further, both with their halo.
    """
    width = cosines.size
    for k in range(HALO, width - HALO, WIDTH):
        c, s = load(cosines, k), load(sines, k)
        store(out, at + k, x * c + y * s)
        store(out, at + width + k, y * c - x * s)
    wrap(out, at, width)


@part(inlined=False)
def resultant(line, cosines, sines):
    """Sum of polar nodal forces of one row, (2, n_sectors + 2 HALO): x, y in the frame's axes."""
    width = cosines.size
    x, y = splat(0.0), splat(0.0)
    for k in range(HALO, width - HALO, WIDTH):
        c, s, radial, tangential = load(cosines, k), load(sines, k), load(line, k), load(line, width + k)
        x += radial * c - tangential * s
        y += radial * s + tangential * c
    return total(x), total(y)


@part
def set_held_row(inner, drive, half):
    """Give the inner ring's held row the hub's velocity, `half` a step after a kick (−1: before it): along a chord."""
    c, s, vx, vy = drive.frame[1], drive.frame[2], drive.velocity[0], drive.velocity[1]
    width, speed = inner.cosines.size, speed_of(drive)
    at = 2 * inner.held * width
    set_rigid(inner.w, at, inner.cosines, inner.sines, c * vx + s * vy, c * vy - s * vx)
    ahead, rim = 0.5 * half * drive.dt * speed, speed * inner.radii[inner.held]
    inward, around = ahead * rim, (1.0 - 0.5 * ahead * ahead) * rim
    for k in range(at, at + width, WIDTH):
        store(inner.w, k, load(inner.w, k) - inward)
        store(inner.w, k + width, load(inner.w, k + width) + around)
