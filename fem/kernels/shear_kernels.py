"""Tangential springs of contacts: the compliance of a contact that sticks, which the mesh lacks.

A spring is in series with Carter's creep. Its stretch e follows the places of the surfaces' nodes, as normal forces do,
and the traction at a kick follows from its value there:

    e − e₋ = dt (slip − creep),    T C = e,    C = A (level − ½ ln Q).

The slip is the mean of what the patches before and after the motion make of it, so that what tractions take from the
bodies is what springs store and creep loses. In long steps, which are for bearings that roll, it is that of the patches
before. The creep is the mean of both kicks', implicit in the traction, so that none, however fast, limits the step (of
a contact that slides, whose traction is given, what is left). The springs do, as normal contacts do. With a reciprocal
mass slips must be those of places, too: a spring stretched by momenta and the normal forces would belong to different
masses, and waves that both reach would flutter.

C follows the normal force: as that grows the traction stays, as it falls the stretch does, and neither makes energy.

Source: Hairer, Lubich and Wanner, Acta Numerica 12 (2003) 399, on leapfrog; Elata and Berryman, Mechanics of Materials
24 (1996) 229, on the last.

Equation (7) of docs/method.md.
"""

from fem.kernels.jit import part
from fem.kernels.lane_functions import maximum, minimum
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import WIDTH, absolute, select, splat
from fem.kernels.law import STEEPEST, creep_traction


@part
def follow_slips_after(shear, forces, friction, dt, n):
    """Stretch the springs of closed contacts by half of the slips that a kick leaves, less half of their creep."""
    if shear is not None:
        columns, half = shear.stretch.shape[1], 0.5 * dt
        for row in range(shear.stretch.shape[0]):
            for at in range(row * columns, row * columns + n, WIDTH):
                gained = half * (load(friction.slip_left, at) - load(shear.creep, at))
                store(shear.stretch, at, load(shear.stretch, at) + select(load(forces.force, at) > 0.0, gained, 0.0))


@part
def follow_slips_before(shear, friction, n):
    """The other half of the slips, before the next kick, of contacts that were closed at the last."""
    if shear is not None:
        columns = shear.stretch.shape[1]
        for row in range(shear.stretch.shape[0]):
            for at in range(row * columns, row * columns + n, WIDTH):
                gained = 0.5 * load(shear.since, at) * load(friction.slip, at)
                store(shear.stretch, at, load(shear.stretch, at) + select(load(shear.since, at) > 0.0, gained, 0.0))


@part
def pull(shear, contacts, pair, row, dt, limit, full_slip):
    """Forces, N, of the springs of eight contacts along their slips; `limit`, N, and `full_slip`, m/s, as Carter's."""
    if shear is None:
        return splat(0.0)
    closed = load(contacts.forces.force, row) > 0.0
    compliance = _follow(shear, contacts.forces, pair, row)
    stretched = load(shear.stretch, row)
    force, creep = creep_traction(stretched * (2.0 / dt), limit, full_slip, compliance * (2.0 / dt))
    stretch = compliance * force
    slid = (stretched - stretch) * (1.0 / dt) + 0.5 * load(shear.creep, row)
    store(shear.stretch, row, stretch)
    store(shear.creep, row, select(closed, select(absolute(force) >= limit, slid, creep), 0.0))
    store(shear.since, row, select(closed, splat(dt), 0.0))
    return force


@part
def _follow(shear, forces, pair, row):
    """Compliances by the present normal forces, m/N; stretches follow them, those of open contacts are given up."""
    law, Q = pair.law, load(forces.force, row)
    closed = Q > 0.0
    level = gather(shear.level, pair.row) - load(forces.bracket, row)
    # approach over force is A (bracket − ½ ln Q): saves a logarithm
    soft = select(closed, load(forces.approach, row), 0.0) / select(closed, Q, 1.0) + law.A * level
    soft = maximum(soft, STEEPEST * law.A)
    kept = select(closed, minimum(soft / load(shear.compliance, row), 1.0), 0.0)
    store(shear.compliance, row, soft)
    store(shear.stretch, row, kept * load(shear.stretch, row))
    return soft


@part
def let_go(shear, row):
    """Give up the stretches of eight open contacts."""
    if shear is not None:
        store(shear.stretch, row, splat(0.0))
        store(shear.creep, row, splat(0.0))
        store(shear.since, row, splat(0.0))


@part
def spring_energy(shear, n):
    """What all springs store at the kick just made, J."""
    if shear is None:
        return 0.0
    found = 0.0
    for row in range(shear.stretch.shape[0]):
        for j in range(n):
            stretch = shear.stretch[row, j]
            found += 0.5 * stretch * stretch / shear.compliance[row, j]
    return found
