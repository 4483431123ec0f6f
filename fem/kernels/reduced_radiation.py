"""What strikes give to elastic waves that the reduced model does not follow, and that never come back from there.

A mode of a body, of frequency ω and surface displacement s, that is faster than a contact's force changes follows it
without a delay; but where the force's rate jumps by Q̇, as a contact closes or opens, the mode is left vibrating with
½ s² Q̇²/ω⁴. Of all such modes together that is ½ Q̇² Σ s²/ω⁴, with Q̇ the contact's stiffness times the speed at which
it closes. Contacts take that from hub, rollers and housing by an impulse as they close; the loss
at an opening is recorded until then: an impulse then would pull.

Equation (2) of docs/reduced.md.
"""

from math import log

from fem.kernels.jit import part
from fem.kernels.lane_memory import store
from fem.kernels.lanes import any_lane, select
from fem.kernels.law import STEEPEST
from fem.kernels.reduced_housing import push_ring, ring_rates
from fem.kernels.reduced_state import INNER, OUTER, Radiation
from fem.kernels.rigid_parts import change_step, kick_part, note_work, write_part
from fem.kernels.sample_kernels import DISSIPATED, FORCE, N_SCALARS
from fem.kernels.shaft import give_way, mobility

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


@kick_part.of(Radiation)
def _kick(radiation, step, push):
    """Take from bodies what contacts that have closed in this step give to waves, or have given as they opened."""
    radiation.work[0] += radiation.work[1]
    radiation.work[1] = 0.0
    if radiation.state[0] != QUIET:
        _radiate(radiation, step.bodies, step.compliance, step.forces, step.drive)


@part(inlined=False)
def _radiate(radiation, bodies, compliance, forces, drive):
    any_kick = False
    for row in range(2):
        law = compliance.inner if row == INNER else compliance.outer
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
    """Push a roller and a ring apart by an impulse, N s."""
    x, y = impulse * forces.normal[row, 0, j], impulse * forces.normal[row, 1, j]
    over = 1.0 / bodies.mass
    if row == INNER:
        bodies.velocity[0, j] += over * x
        bodies.velocity[1, j] += over * y
        over = mobility(bodies.shaft, bodies.hub_mass, drive.dt) / drive.dt
        bodies.hub_velocity[0] -= over * x
        bodies.hub_velocity[1] -= over * y
        give_way(bodies.shaft, 0, -over * x)
        give_way(bodies.shaft, 1, -over * y)
    else:
        bodies.velocity[0, j] -= over * x
        bodies.velocity[1, j] -= over * y
        push_ring(bodies.housing, x / drive.dt, y / drive.dt, drive.dt)


@note_work.of(Radiation)
def _note(radiation, step):
    if radiation.state[0] == KICKED:
        _note_work(radiation, step.bodies, step.forces, step.before, step.drive)


@part(inlined=False)
def _note_work(radiation, bodies, forces, before, drive):
    """What the impulses take, by the velocities before and after the whole kick: half of each works on its side."""
    past, next_ = ring_rates(bodies.housing)
    for j in range(bodies.n):
        ix, iy = forces.normal[INNER, 0, j], forces.normal[INNER, 1, j]
        ox, oy = forces.normal[OUTER, 0, j], forces.normal[OUTER, 1, j]
        F_i, F_o, half = radiation.kick[INNER, j], radiation.kick[OUTER, j], 0.5 * drive.dt
        vx, vy = before.velocity[0, j], before.velocity[1, j]
        inner = (before.hub_velocity[0] - vx) * ix + (before.hub_velocity[1] - vy) * iy
        outer = (vx - past[0]) * ox + (vy - past[1]) * oy
        radiation.work[0] += half * (F_i * inner + F_o * outer)
        vx, vy = bodies.velocity[0, j], bodies.velocity[1, j]
        inner = (bodies.hub_velocity[0] - vx) * ix + (bodies.hub_velocity[1] - vy) * iy
        outer = (vx - next_[0]) * ox + (vy - next_[1]) * oy
        radiation.work[1] += half * (F_i * inner + F_o * outer)


@part
def _power_ahead(radiation, bodies, forces):
    """What the impulses of the last kick take in the half step ahead, over the step, W."""
    found, next_ = 0.0, ring_rates(bodies.housing)[1]
    if radiation.state[0] == KICKED:
        for j in range(bodies.n):
            vx, vy = bodies.velocity[0, j], bodies.velocity[1, j]
            rate = (bodies.hub_velocity[0] - vx) * forces.normal[INNER, 0, j]
            rate += (bodies.hub_velocity[1] - vy) * forces.normal[INNER, 1, j]
            found += 0.5 * radiation.kick[INNER, j] * rate
            rate = (vx - next_[0]) * forces.normal[OUTER, 0, j] + (vy - next_[1]) * forces.normal[OUTER, 1, j]
            found += 0.5 * radiation.kick[OUTER, j] * rate
    return found


@change_step.of(Radiation)
def _change(radiation, step, change):
    radiation.work[1] = change.drive.dt * _power_ahead(radiation, step.bodies, step.forces)


@write_part.of(Radiation)
def _write(radiation, step, out):
    """Add what waves have been given, J, and the impulses over the step to the forces, N."""
    n = step.bodies.n
    out[DISSIPATED] += radiation.work[0]
    if radiation.state[0] == KICKED:
        for j in range(n):
            for row in range(2):
                out[N_SCALARS + (FORCE + row) * n + j] += radiation.kick[row, j]
