"""What strikes give to elastic waves that the reduced model does not follow, and that never come back from there.

A mode of a body, of frequency ω and surface displacement s, that is faster than a contact's force changes follows it
without a delay; but where the force's rate jumps by Q̇, as a contact closes or opens, the mode is left vibrating with
½ s² Q̇²/ω⁴. Of all such modes together that is ½ Q̇² Σ s²/ω⁴, with Q̇ the contact's stiffness times the speed at which
it closes. Contacts take that from hub, rollers and housing by an impulse as they close; the loss
at an opening is recorded until then: an impulse then would pull.

Equation (2) of docs/reduced.md.
"""

from math import log

from fem.kernels.columns import DISSIPATED, FORCE, INNER, N_SCALARS, OUTER
from fem.kernels.jit import part
from fem.kernels.lanes import any_lane, select, store
from fem.kernels.law import STEEPEST
from fem.kernels.mounts import push_mounted, ring_rates

QUIET, STRUCK, KICKED = 0, 1, 2  # of `Radiation.state`
MOST = 0.1  # of a roller's momentum, that one impulse takes


@part
def note_strikes(radiation, before, now, at, there, dt):
    """Note at which speed eight contacts close (> 0) or open (< 0), m/s; `before`, `now` : m, approaches."""
    closes, opens = there & (before <= 0.0) & (now > 0.0), there & (before > 0.0) & (now <= 0.0)
    speed = (now - before) * (1.0 / dt)
    if any_lane(closes | opens):
        radiation.state[0] = STRUCK
    store(radiation.speed, at, select(closes | opens, speed, 0.0))


@part
def radiate(radiation, step):
    """Take from bodies what contacts that have closed in this step give to waves, or have given as they opened."""
    radiation.work[0] += radiation.work[1]
    radiation.work[1] = 0.0
    if radiation.state[0] != QUIET:
        _radiate(radiation, step.bodies, step.contacts, step.forces, step.drive)


@part(inlined=False)
def _radiate(radiation, bodies, contacts, forces, drive):
    any_kick = False
    for row in range(2):
        law = contacts.inner if row == INNER else contacts.outer
        for j in range(bodies.n):
            radiation.kick[row, j] = 0.0
            speed = radiation.speed[row, j]
            if speed != 0.0:
                radiation.owed[row, j] += given(law, radiation.inertia[row], radiation.settling, bodies.mass, speed)
            if speed > 0.0:
                any_kick = True
                taken = min(radiation.owed[row, j], MOST * bodies.mass * speed * speed)
                radiation.owed[row, j] = max(radiation.owed[row, j] - taken, 0.0)
                impulse = taken / speed
                radiation.kick[row, j] = impulse / drive.dt
                _push(bodies, forces, drive, row, j, impulse)
    radiation.state[0] = KICKED if any_kick else QUIET


@part
def given(law, inertia, settling, mass, speed):
    """Energy, J, that a contact gives to waves as it closes or opens at a speed, m/s.

    k² Σ s²/ω⁴ is taken for a mass of the surface that the roller strikes plastically, so that no strike loses more than
    its energy. k is the law's chord: the spectrum of a force that grows as t^p, p = 1.1, falls as that of a straight
    line with Γ(p + 1) = 1.05 times the chord over 1/ω.
    """
    approach = abs(speed) * settling
    soft = law.A * max(law.B - 0.5 * log(approach / (law.A * law.B)), STEEPEST)  # of the chord
    of_surface = inertia / (soft * soft)
    return 0.5 * speed * speed * of_surface * mass / (mass + of_surface)


@part
def _push(bodies, forces, drive, row, j, impulse):
    x, y = impulse * forces.normal[row, 0, j], impulse * forces.normal[row, 1, j]
    over = 1.0 / bodies.mass if row == INNER else -1.0 / bodies.mass
    bodies.velocity[0, j] += over * x
    bodies.velocity[1, j] += over * y
    if row == INNER:
        push_mounted(bodies.shaft, bodies.hub_velocity, bodies.hub_mass, -x / drive.dt, -y / drive.dt, drive.dt)
    else:
        housing = bodies.housing
        if housing is not None:
            push_mounted(housing, housing.velocity, housing.mass, x / drive.dt, y / drive.dt, drive.dt)


@part
def note_radiated(radiation, step):
    """Add the work of the impulses at the velocities before and after the whole kick: half of each on its side."""
    if radiation.state[0] == KICKED:
        n, before, (past, _) = step.bodies.n, step.before, ring_rates(step.bodies.housing)
        radiation.work[0] += _work(radiation, n, step.forces, before.hub_velocity, before.velocity, past, step.drive.dt)
        change_radiated(radiation, step, step.drive.dt)


@part
def change_radiated(radiation, step, dt):
    """Work of the last kick's impulses in the half step ahead, J, with a step length."""
    if radiation.state[0] == KICKED:
        bodies, (_, ring) = step.bodies, ring_rates(step.bodies.housing)
        radiation.work[1] = _work(radiation, bodies.n, step.forces, bodies.hub_velocity, bodies.velocity, ring, dt)


@part(inlined=False)
def _work(radiation, n, forces, hub, velocity, ring, dt):
    """Work of the impulses in half a step at velocities of hub, rollers and outer ring, J."""
    found = 0.0
    for j in range(n):
        vx, vy = velocity[0, j], velocity[1, j]
        inner = (hub[0] - vx) * forces.normal[INNER, 0, j] + (hub[1] - vy) * forces.normal[INNER, 1, j]
        outer = (vx - ring[0]) * forces.normal[OUTER, 0, j] + (vy - ring[1]) * forces.normal[OUTER, 1, j]
        found += 0.5 * dt * (radiation.kick[INNER, j] * inner + radiation.kick[OUTER, j] * outer)
    return found


@part
def write_radiated(radiation, step, out):
    """Add what waves have been given, J, and the impulses over the step to the forces, N."""
    n = step.bodies.n
    out[DISSIPATED] += radiation.work[0]
    if radiation.state[0] == KICKED:
        for j in range(n):
            for row in range(2):
                out[N_SCALARS + (FORCE + row) * n + j] += radiation.kick[row, j]
