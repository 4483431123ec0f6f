"""Vibrations of the reduced model's bodies: oscillators driven by contact forces, which change the approaches.

Modes stand in space: one goes round in some 10 µs, in which no body turns by a hundredth of a radian. Where a step of
theirs has no place in a scene they are None and nothing is compiled.
"""

from fem.kernels.drive import with_side_load
from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store, sums_of_rows
from fem.kernels.lanes import WIDTH, count_from, select, splat, total
from fem.kernels.reduced_state import Vibrations
from fem.kernels.rigid_parts import drift_part, kick_part


@part
def gather_waves(vibrations):
    """Each ring's displacement by waves around, of its modes' amplitudes; forces on them are 0."""
    if vibrations is None:
        return
    for ring in (vibrations.inner, vibrations.outer):
        layers, room = ring.shape.shape
        for twin in range(2):
            for n in range(0, room, WIDTH):
                found = splat(0.0)
                for layer in range(layers):
                    a = load(ring.amplitude, (2 * layer + twin) * room + n)
                    found += load(ring.shape, layer * room + n) * a
                store(ring.wave, twin * room + n, found)
        for at in range(0, 2 * room * WIDTH, WIDTH):
            store(ring.push, at, splat(0.0))


@part
def less_vibration(vibrations, forces, columns, group, inner, outer):
    """Approaches of eight rollers, m, reduced by the modal displacements of the surfaces, whose slopes are kept."""
    if vibrations is None:
        return inner, outer
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    given_i, lean_i = _ring_wave(vibrations.inner, ix, iy)
    given_o, lean_o = _ring_wave(vibrations.outer, ox, oy)
    own_i, own_lean_i = _roller_wave(vibrations.roller, columns, group, -ix, -iy)
    own_o, own_lean_o = _roller_wave(vibrations.roller, columns, group, ox, oy)
    store(vibrations.lean, group, lean_i + own_lean_i)
    store(vibrations.lean, columns + group, lean_o + own_lean_o)
    return inner - given_i - own_i, outer - given_o - own_o


@part
def _ring_wave(ring, c, s):
    """Σ a cos nθ + b sin nθ at eight angles by their cosines and sines, and its slope."""
    wave, found, slope, cn, sn = ring.wave, splat(0.0), splat(0.0), splat(1.0), splat(0.0)
    for n in range(ring.orders):
        a, b = wave[0, n], wave[1, n]
        found += a * cn + b * sn
        slope += (b * cn - a * sn) * (1.0 * n)
        cn, sn = c * cn - s * sn, s * cn + c * sn
    return found, slope


@part
def _roller_wave(roller, columns, group, c, s):
    """The same of eight rollers' own modes."""
    found, slope, cn, sn = splat(0.0), splat(0.0), splat(1.0), splat(0.0)
    for n in range(roller.start.size - 1):
        for k in range(roller.start[n], roller.start[n + 1]):
            a = load(roller.amplitude, 2 * k * columns + group) * roller.shape[k]
            b = load(roller.amplitude, (2 * k + 1) * columns + group) * roller.shape[k]
            found += a * cn + b * sn
            slope += (b * cn - a * sn) * (1.0 * n)
        cn, sn = c * cn - s * sn, s * cn + c * sn
    return found, slope


@part
def push_modes(vibrations, bodies, forces, group, P, T):
    """Give eight rollers' contact forces to the modes; forces along +θ, N, with what the surfaces' slopes add to them.

    P, T : N, of the inner and the outer contact
    """
    if vibrations is None:
        return T
    columns, (P_i, P_o), (T_i, T_o) = bodies.columns, P, T
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    _push_ring(vibrations.inner, P_i, ix, iy)
    _push_ring(vibrations.outer, P_o, ox, oy)
    _kick_rollers(vibrations.roller, columns, group, (P_i, -ix, -iy, P_o, ox, oy))
    x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
    out = x * ox + y * oy
    away = (x - bodies.hub[0]) * ix + (y - bodies.hub[1]) * iy
    there = count_from(group) < bodies.n
    out, away = select(there, out, 1.0), select(there, away, 1.0)
    lean_i, lean_o = load(vibrations.lean, group), load(vibrations.lean, columns + group)
    return T_i + P_i * lean_i / away, T_o + P_o * lean_o / out


@part
def _push_ring(ring, P, c, s):
    cn, sn, sines = P, splat(0.0), ring.push.shape[1] * WIDTH
    for n in range(ring.orders):
        at = n * WIDTH
        store(ring.push, at, load(ring.push, at) + cn)
        store(ring.push, sines + at, load(ring.push, sines + at) + sn)
        cn, sn = c * cn - s * sn, s * cn + c * sn


@part
def _kick_rollers(roller, columns, group, pushes):
    """Kick eight rollers' modes by both their contacts: (force, cosine and sine of its angle) twice."""
    P_i, ci, si, P_o, co, so = pushes
    a, b, c, d = P_i, splat(0.0), P_o, splat(0.0)  # force times cosine and sine of n angles
    for n in range(roller.start.size - 1):
        for k in range(roller.start[n], roller.start[n + 1]):
            over = roller.kick[k]
            for twin in range(2):
                at = (2 * k + twin) * columns + group
                push = a + c if twin == 0 else b + d
                rate = load(roller.rate, at)
                store(roller.before, at, rate)
                gained = roller.shape[k] * push - roller.stiffness[k] * load(roller.amplitude, at)
                store(roller.rate, at, rate + over * gained)
        a, b = ci * a - si * b, si * a + ci * b
        c, d = co * c - so * d, so * c + co * d


@kick_part.of(Vibrations)
def _kick(vibrations, step, push):
    """Kick the rings' modes by all forces on them and by the load at the hub."""
    history, (side_load, radial_load) = step.drive.history, step.before.load
    for ring in (vibrations.inner, vibrations.outer):
        layers, room = ring.shape.shape
        for twin in range(2):
            for n in range(0, room, WIDTH):
                push = sums_of_rows(ring.push, (twin * room + n) * WIDTH)
                for layer in range(layers):
                    of, at = layer * room + n, (2 * layer + twin) * room + n
                    gained = load(ring.shape, of) * push - load(ring.stiffness, of) * load(ring.amplitude, at)
                    if twin == 1:
                        gained -= load(ring.carried, of) * radial_load
                    else:
                        gained = with_side_load(history, gained, load(ring.carried, of) * side_load)
                    rate = load(ring.rate, at)
                    store(ring.before, at, rate)
                    store(ring.rate, at, rate + load(ring.kick, of) * gained)


@drift_part.of(Vibrations)
def _drift(vibrations, step):
    dt = step.drive.dt
    roller, inner, outer = vibrations.roller, vibrations.inner, vibrations.outer
    arrays = (roller.amplitude, roller.rate), (inner.amplitude, inner.rate), (outer.amplitude, outer.rate)
    for amplitude, rate in arrays:
        for at in range(0, amplitude.size, WIDTH):
            store(amplitude, at, load(amplitude, at) + dt * load(rate, at))


@part
def carried_by(vibrations, which):
    """What the inner ring's modes add to the hub's place (0), or its velocity before (1) and after (2) a kick.

    Only those of one wave around do.
    """
    if vibrations is None:
        return 0.0, 0.0
    inner, x, y = vibrations.inner, 0.0, 0.0
    values = inner.amplitude if which == 0 else inner.before if which == 1 else inner.rate
    for layer in range(inner.shape.shape[0]):
        x += inner.carried[layer, 1] * values[layer, 0, 1]
        y += inner.carried[layer, 1] * values[layer, 1, 1]
    return x, y


@part
def vibration_energies(vibrations, columns):
    """Kinetic and elastic energy of all modes, J, as leapfrog conserves them."""
    if vibrations is None:
        return 0.0, 0.0
    kinetic, elastic = splat(0.0), splat(0.0)
    for ring in (vibrations.inner, vibrations.outer):
        layers, room = ring.shape.shape
        for layer in range(layers):
            for n in range(0, room, WIDTH):
                mass, stiffness = load(ring.mass, layer * room + n), load(ring.stiffness, layer * room + n)
                for at in (2 * layer * room + n, (2 * layer + 1) * room + n):
                    kinetic += mass * load(ring.before, at) * load(ring.rate, at)
                    elastic += stiffness * load(ring.amplitude, at) * load(ring.amplitude, at)
    roller = vibrations.roller
    for k in range(roller.shape.size):
        for at in range(2 * k * columns, 2 * (k + 1) * columns, WIDTH):
            kinetic += roller.mass[k] * load(roller.before, at) * load(roller.rate, at)
            elastic += roller.stiffness[k] * load(roller.amplitude, at) * load(roller.amplitude, at)
    return 0.5 * total(kinetic), 0.5 * total(elastic)
