"""Rollers: all columns of one congruent disc at once, eight per register.

State of every roller in its own frame, which turns with it and moves with its centre of mass:
`u` displacement, `w` velocity relative to the centre of mass in the frame's axes. Flat arrays (n_nodes, 2, columns),
columns a multiple of 16; spare columns stay 0.

Equation (1) of docs/method.md.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.jit import part
from fem.kernels.lanes import fma, gather, load, splat, store, total

COLUMNS = 16  # handled together


class Turns(NamedTuple):
    """How rollers turn and move as a whole in a step, each (columns,)."""

    kick: np.ndarray  # rad/s, gained by turning the undeformed body as a whole
    cosine: np.ndarray  # of the frame's turn
    sine: np.ndarray
    shift_x: np.ndarray  # m/s, gained by the centre of mass through nodal forces, in the frame's axes
    shift_y: np.ndarray
    swelling: np.ndarray | None = None  # kg m², filled as sums are: Σ m X·u; None: nobody asks


@part
def _row_product(disc, field, columns, i, block):
    """blocks·field of node i in sixteen columns from `block` on: x of the first eight and of the others, then y."""
    starts, neighbours, blocks = disc.starts, disc.neighbours, disc.blocks
    stride = 2 * columns
    fx0, fx1, fy0, fy1 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    gx0, gx1, gy0, gy1 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)  # sums apart: none waits for another
    for k in range(gather(starts, i), gather(starts, i + 1)):
        at = gather(neighbours, k) * stride + block
        x0, x1 = load(field, at), load(field, at + 8)
        y0, y1 = load(field, at + columns), load(field, at + columns + 8)
        xx, xy = gather(blocks, 4 * k), gather(blocks, 4 * k + 1)
        yx, yy = gather(blocks, 4 * k + 2), gather(blocks, 4 * k + 3)
        fx0, fx1 = fma(xx, x0, fx0), fma(xx, x1, fx1)
        fy0, fy1 = fma(yx, x0, fy0), fma(yx, x1, fy1)
        gx0, gx1 = fma(xy, y0, gx0), fma(xy, y1, gx1)
        gy0, gy1 = fma(yy, y0, gy0), fma(yy, y1, gy1)
    return fx0 + gx0, fx1 + gx1, fy0 + gy0, fy1 + gy1


@part
def _moment(mass, field, at, columns, x, y, so_far):
    """`so_far` and mass times field x (x, y) of eight columns."""
    return fma(mass, load(field, at) * y - load(field, at + columns) * x, so_far)


@part
def _store(field, at, columns, four):
    """Values of one node in sixteen columns."""
    store(field, at, four[0])
    store(field, at + 8, four[1])
    store(field, at + columns, four[2])
    store(field, at + columns + 8, four[3])


@part
def _added(factor, four, field, at, columns):
    """Values of one node in sixteen columns, times a factor, and those of a field."""
    x0, x1 = fma(factor, four[0], load(field, at)), fma(factor, four[1], load(field, at + 8))
    return x0, x1, fma(factor, four[2], load(field, at + columns)), fma(factor, four[3], load(field, at + columns + 8))


@part(inlined=False)
def kick(disc, w, columns, torque):
    """w += dt·internal acceleration; torque of the internal forces.

    disc : `state.Disc`; w : its velocities, or others to be changed instead
    torque : filled with dt·Σ u x f by column, N m s: second order in u, 0 for exact elasticity
    """
    mass, u = disc.mass, disc.u
    for block in range(0, columns, COLUMNS):
        t0, t1 = splat(0.0), splat(0.0)
        for i in range(mass.size):
            four = _row_product(disc, u, columns, i, block)
            at, m = i * (2 * columns) + block, gather(mass, i)
            t0 = _moment(m, u, at, columns, four[0], four[2], t0)
            t1 = _moment(m, u, at + 8, columns, four[1], four[3], t1)
            _store(w, at, columns, _added(1.0, four, w, at, columns))
        store(torque, block, t0)
        store(torque, block + 8, t1)


@part
def _calm(disc, columns, calming, ahead, block):
    """calmed = w + β dt·(blocks·w) in sixteen columns; w lacks `ahead` times the points, 1/s, see `slow_waves`."""
    w, calmed = disc.w, disc.calmed
    for i in range(disc.mass.size):
        at = i * (2 * columns) + block
        _store(calmed, at, columns, _added(calming, _slowing(disc, w, columns, ahead, i, block), w, at, columns))


@part
def _slowing(disc, field, columns, ahead, i, block):
    """blocks·(field + ahead·points) of node i in sixteen columns; `ahead` : of the first eight, and of the others."""
    x0, x1, y0, y1 = _row_product(disc, field, columns, i, block)
    x, y = gather(disc.grown, 2 * i), gather(disc.grown, 2 * i + 1)
    return fma(x, ahead[0], x0), fma(x, ahead[1], x1), fma(y, ahead[0], y0), fma(y, ahead[1], y1)


@part(inlined=False)
def calm(disc, columns, calming):
    """The calmed velocities of discs that do not turn. `calming` : β dt, s"""
    for block in range(0, columns, COLUMNS):
        _calm(disc, columns, calming, (splat(0.0), splat(0.0)), block)


@part
def _slow(disc, columns, slowing, ahead, i, block, moments):
    """u of node i, what it gains over `slowing`, and the moments so far."""
    x0, x1, y0, y1 = _slowing(disc, disc.calmed, columns, ahead, i, block)
    u, at, m = disc.u, i * (2 * columns) + block, gather(disc.mass, i)
    _store(u, at, columns, _added(slowing, (x0, x1, y0, y1), u, at, columns))
    t0 = _moment(-m, disc.w, at, columns, x0, y0, moments[0])
    return x0, x1, y0, y1, (t0, _moment(-m, disc.w, at + 8, columns, x1, y1, moments[1]))


@part(inlined=False)
def slow_waves(disc, cosine, columns, slowing, calming, dt, torque):
    """Take from the nodes' motion what the reciprocal mass does: u += γ dt²·blocks·(w + β dt·blocks·w).

    Turning it must not give. The surface's nodes get their velocities in this step.

    A roller that turns moves in chords, half a step ahead of its frame, where w has a part along its points: what the
    stencil makes of that is taken out.

    cosine : (columns,), of the frame's turn in a step
    slowing, calming : γ dt², s², and β dt, s
    torque : filled with Σ m (u gained/γ dt²) x w by column, N m: what γ dt² of it adds to a roller's angular momentum
    """
    w, v, over = disc.w, disc.v, slowing / dt
    for block in range(0, columns, COLUMNS):
        ahead = (1.0 - load(cosine, block)) * (1.0 / dt), (1.0 - load(cosine, block + 8)) * (1.0 / dt)
        if calming > 0.0:
            _calm(disc, columns, calming, ahead, block)
        moments = splat(0.0), splat(0.0)
        for i in range(disc.first):
            x0, x1, y0, y1, moments = _slow(disc, columns, slowing, ahead, i, block, moments)
        for i in range(disc.first, disc.mass.size):
            x0, x1, y0, y1, moments = _slow(disc, columns, slowing, ahead, i, block, moments)
            at = i * (2 * columns) + block
            _store(v, at, columns, _added(over, (x0, x1, y0, y1), w, at, columns))
        store(torque, block, moments[0])
        store(torque, block + 8, moments[1])


@part(inlined=False)
def strain_power(disc, w, before, columns, n):
    """Σ m before·(blocks·w) of all rollers, n of them, of a field w."""
    found = splat(0.0)
    for block in range(0, n, COLUMNS):
        for i in range(disc.mass.size):
            x0, x1, y0, y1 = _row_product(disc, w, columns, i, block)
            at, m = i * (2 * columns) + block, gather(disc.mass, i)
            first = load(before, at) * x0 + load(before, at + columns) * y0
            found = fma(m, first + load(before, at + 8) * x1 + load(before, at + columns + 8) * y1, found)
    return total(found)


@part(inlined=False)
def drift(disc, turns, columns, dt, moment):
    """Add a rigid turn, take out the mean velocity, move, and turn the frame.

    disc : `state.Disc`
    moment : filled with Σ m X x (X + u) by column, kg m²: inertia times the body's lead of its frame
    """
    points, mass, u, w = disc.points, disc.mass, disc.u, disc.w
    stride = 2 * columns
    for block in range(0, columns, 8):
        c, s = load(turns.cosine, block), load(turns.sine, block)
        ax, ay, k = load(turns.shift_x, block), load(turns.shift_y, block), load(turns.kick, block)
        lead, swelling = splat(0.0), splat(0.0)
        for i in range(mass.size):
            at = i * stride + block
            px, py = gather(points, 2 * i), gather(points, 2 * i + 1)
            wx = load(w, at) - py * k - ax
            wy = load(w, at + columns) + px * k - ay
            x = px + fma(dt, wx, load(u, at))
            y = py + fma(dt, wy, load(u, at + columns))
            ux = c * x + s * y - px
            uy = c * y - s * x - py
            store(u, at, ux)
            store(u, at + columns, uy)
            store(w, at, c * wx + s * wy)
            store(w, at + columns, c * wy - s * wx)
            lead = fma(gather(mass, i), px * uy - py * ux, lead)
            swelling = swelling if turns.swelling is None else fma(gather(mass, i), px * ux + py * uy, swelling)
        store(moment, block, lead)
        if turns.swelling is not None:
            store(turns.swelling, block, swelling)
