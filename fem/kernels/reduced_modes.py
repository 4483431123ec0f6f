"""Vibrations of the reduced model's bodies: modes as oscillators that contact forces drive and contacts feel.

Modes stand in space: one goes round in some 10 µs, in which no body turns by a hundredth of a radian. Where a step of
theirs has no place in a scene they are None and nothing is compiled.
"""

from fem.kernels.course_kernels import with_aside
from fem.kernels.jit import part
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import WIDTH, count_from, select, splat, total


@part
def gather_waves(vibrations):
    """Each ring's displacement by waves around, of its modes' amplitudes; forces on them are 0."""
    if vibrations is None:
        return
    for ring in (vibrations.inner, vibrations.outer):
        for n in range(ring.start.size - 1):
            for twin in range(2):
                found = 0.0
                for k in range(ring.start[n], ring.start[n + 1]):
                    found += ring.shape[k] * ring.amplitude[k, twin]
                ring.wave[twin, n] = found
                store(ring.push, (2 * n + twin) * WIDTH, splat(0.0))


@part
def less_vibration(vibrations, forces, columns, group, inner, outer):
    """Approaches of eight rollers, m, less what their bodies' surfaces give way by; the slopes of that are kept."""
    if vibrations is None:
        return inner, outer
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    given_i, lean_i = _ring_wave(vibrations.inner.wave, ix, iy)
    given_o, lean_o = _ring_wave(vibrations.outer.wave, ox, oy)
    own_i, own_lean_i = _roller_wave(vibrations.roller, columns, group, -ix, -iy)
    own_o, own_lean_o = _roller_wave(vibrations.roller, columns, group, ox, oy)
    store(vibrations.lean, group, lean_i + own_lean_i)
    store(vibrations.lean, columns + group, lean_o + own_lean_o)
    return inner - given_i - own_i, outer - given_o - own_o


@part
def _ring_wave(wave, c, s):
    """Σ a cos nθ + b sin nθ at eight angles by their cosines and sines, and its slope."""
    found, slope, cn, sn = splat(0.0) + wave[0, 0], splat(0.0), c, s
    for n in range(1, wave.shape[1]):
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
def push_modes(vibrations, bodies, forces, drive, group, P_i, P_o, T_i, T_o):
    """Give eight rollers' contact forces to the modes; forces along +θ, N, with what the surfaces' slopes add to them.

    Nine arguments: registers of both contacts.
    """
    if vibrations is None:
        return T_i, T_o
    columns = bodies.columns
    ix, iy = load(forces.normal, group), load(forces.normal, columns + group)
    ox, oy = load(forces.normal, 2 * columns + group), load(forces.normal, 3 * columns + group)
    _push_ring(vibrations.inner, P_i, ix, iy)
    _push_ring(vibrations.outer, P_o, ox, oy)
    _kick_rollers(vibrations.roller, columns, group, drive.dt, (P_i, -ix, -iy, P_o, ox, oy))
    x, y = load(bodies.centre, group), load(bodies.centre, columns + group)
    out = x * ox + y * oy
    away = (x - bodies.hub[0]) * ix + (y - bodies.hub[1]) * iy
    there = count_from(group) < bodies.n
    out, away = select(there, out, 1.0), select(there, away, 1.0)
    lean_i, lean_o = load(vibrations.lean, group), load(vibrations.lean, columns + group)
    return T_i + P_i * lean_i / away, T_o + P_o * lean_o / out


@part
def _push_ring(ring, P, c, s):
    cn, sn = splat(1.0), splat(0.0)
    for n in range(ring.start.size - 1):
        at = 2 * n * WIDTH
        store(ring.push, at, load(ring.push, at) + P * cn)
        store(ring.push, at + WIDTH, load(ring.push, at + WIDTH) + P * sn)
        cn, sn = c * cn - s * sn, s * cn + c * sn


@part
def _kick_rollers(roller, columns, group, dt, pushes):
    """Kick eight rollers' modes by both their contacts: (force, cosine and sine of its angle) twice."""
    P_i, ci, si, P_o, co, so = pushes
    a, b, c, d = P_i, splat(0.0), P_o, splat(0.0)  # force times cosine and sine of n angles
    for n in range(roller.start.size - 1):
        for k in range(roller.start[n], roller.start[n + 1]):
            over = dt / roller.mass[k]
            for twin in range(2):
                at = (2 * k + twin) * columns + group
                push = a + c if twin == 0 else b + d
                rate = load(roller.rate, at)
                store(roller.before, at, rate)
                gained = roller.shape[k] * push - roller.stiffness[k] * load(roller.amplitude, at)
                store(roller.rate, at, rate + over * gained)
        a, b = ci * a - si * b, si * a + ci * b
        c, d = co * c - so * d, so * c + co * d


@part
def kick_rings(vibrations, drive, aside, radial_load):
    """Kick the rings' modes by all forces on them and by the load at the hub, along x and against y."""
    if vibrations is None:
        return
    for ring in (vibrations.inner, vibrations.outer):
        for n in range(ring.start.size - 1):
            for twin in range(2):
                push = total(load(ring.push, (2 * n + twin) * WIDTH))
                for k in range(ring.start[n], ring.start[n + 1]):
                    gained = ring.shape[k] * push - ring.stiffness[k] * ring.amplitude[k, twin]
                    if twin == 1:
                        gained -= ring.carried[k] * radial_load
                    else:
                        gained = with_aside(drive.course, gained, ring.carried[k] * aside)
                    ring.before[k, twin] = ring.rate[k, twin]
                    ring.rate[k, twin] += drive.dt / ring.mass[k] * gained


@part
def drift_modes(vibrations, columns, dt):
    if vibrations is None:
        return
    roller = vibrations.roller
    for at in range(0, roller.shape.size * 2 * columns, WIDTH):
        store(roller.amplitude, at, load(roller.amplitude, at) + dt * load(roller.rate, at))
    for ring in (vibrations.inner, vibrations.outer):
        for k in range(ring.shape.size):
            for twin in range(2):
                ring.amplitude[k, twin] += dt * ring.rate[k, twin]


@part
def carried_by(vibrations, which):
    """What the inner ring's modes add to the hub's place (0), or its velocity before (1) and after (2) a kick."""
    if vibrations is None:
        return 0.0, 0.0
    inner, x, y = vibrations.inner, 0.0, 0.0
    values = inner.amplitude if which == 0 else inner.before if which == 1 else inner.rate
    for k in range(inner.shape.size):
        x += inner.carried[k] * values[k, 0]
        y += inner.carried[k] * values[k, 1]
    return x, y


@part(inlined=False)
def vibration_energies(vibrations, n, columns):
    """Kinetic and elastic energy of all modes, J, as leapfrog conserves them."""
    if vibrations is None:
        return 0.0, 0.0
    kinetic, elastic = 0.0, 0.0
    for ring in (vibrations.inner, vibrations.outer):
        for k in range(ring.shape.size):
            for twin in range(2):
                kinetic += 0.5 * ring.mass[k] * ring.before[k, twin] * ring.rate[k, twin]
                elastic += 0.5 * ring.stiffness[k] * ring.amplitude[k, twin] ** 2
    roller = vibrations.roller
    for k in range(roller.shape.size):
        for twin in range(2):
            for j in range(n):
                kinetic += 0.5 * roller.mass[k] * roller.before[k, twin, j] * roller.rate[k, twin, j]
                elastic += 0.5 * roller.stiffness[k] * roller.amplitude[k, twin, j] ** 2
    return kinetic, elastic
