"""Damping of bodies in proportion to mass, of what they do beside moving and turning as a whole.

What moving as a whole is: of a ring whose held row goes with hub or housing, moving with these, which take the
reaction; of rollers and of a ring in play, the motion that has the body's momentum and angular momentum.
"""

from fem.kernels.bore import Bore
from fem.kernels.drive import outer_speed_of, speed_of
from fem.kernels.housing_kernels import Housing
from fem.kernels.jit import part, verb
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import WIDTH, splat, total
from fem.kernels.ring_kernels import HALO
from fem.kernels.state import OuterTurn


@part
def damp_bodies(bodies, drive, damping):
    """Take their share from the velocities that bodies have beside moving and turning as a whole; None: nothing.

    Of a velocity v₀ before a kick and v₁ after it, of such motion, a share s = 1 − exp(−a dt) of v₀ is taken. From one
    kick to the next the energy of leapfrog, ½ v₀·M·v₁ + V, thereby loses ½ s v₁·M·(v₀ + v₁). The sum of that is of
    s v₀·M·v₀ over all kicks, less a quarter of the last one's, but for ¼ s (v₁ − v₀)·M·(v₁ − v₀), of third order in dt.
    """
    if damping is not None:
        before = damping.work[0]
        _damp_rollers(bodies.disc, bodies.rollers, damping, drive.dt)
        _damp_inner(bodies.inner, drive, damping)
        _damp_outer(damping.around, bodies.outer, damping, drive.dt)
        damping.work[1] = damping.work[0] - before


@part(inlined=False)
def _damp_rollers(disc, rollers, damping, dt):
    """Places half a step back, where the velocities are, make what turns rigidly turn without any loss."""
    points, mass, u, w, columns, half = disc.points, disc.mass, disc.u, disc.w, rollers.columns, 0.5 * dt
    lost = splat(0.0)
    for j in range(0, rollers.n, WIDTH):
        around, size = splat(0.0), splat(0.0)
        for i in range(mass.size):
            at = 2 * i * columns + j
            vx, vy = load(w, at), load(w, at + columns)
            x = gather(points, 2 * i) + load(u, at) - half * vx
            y = gather(points, 2 * i + 1) + load(u, at + columns) - half * vy
            around += mass[i] * (x * vy - y * vx)
            size += mass[i] * (x * x + y * y)
        spin = around / size
        for i in range(mass.size):
            at = 2 * i * columns + j
            vx, vy = load(w, at), load(w, at + columns)
            x = gather(points, 2 * i) + load(u, at) - half * vx
            y = gather(points, 2 * i + 1) + load(u, at + columns) - half * vy
            own_x, own_y = vx + spin * y, vy - spin * x
            store(w, at, vx - damping.share * own_x)
            store(w, at + columns, vy - damping.share * own_y)
            lost += mass[i] * (own_x * own_x + own_y * own_y)
    damping.work[0] += damping.share * total(lost)


@part(inlined=False)
def _damp_inner(ring, drive, damping):
    c, s, half = drive.frame[1], drive.frame[2], 0.5 * drive.dt
    speed = speed_of(drive.history, drive)
    hub_x, hub_y = drive.hub[0] - half * drive.velocity[0], drive.hub[1] - half * drive.velocity[1]
    x, y = drive.velocity[0] + speed * hub_y, drive.velocity[1] - speed * hub_x
    back_x, back_y = _damp_ring(ring, damping, half, speed, c * x + s * y, c * y - s * x)
    over = 1.0 / drive.mass
    drive.velocity[0] += over * (c * back_x - s * back_y)
    drive.velocity[1] += over * (s * back_x + c * back_y)


@part(inlined=False)
def _damp_ring(ring, damping, half, speed, whole_x, whole_y):
    """Damp a ring's nodes but for what turns at a speed, rad/s, and moves at a velocity, m/s, in the ring's frame.

    `half` : s, half a step back, to where the velocities are. Returns the reaction, N s.
    """
    width, lost, back_x, back_y = ring.cosines.size, 0.0, 0.0, 0.0
    for row in range(ring.first_row, ring.last_row):
        part_lost, part_x, part_y = splat(0.0), splat(0.0), splat(0.0)
        at = 2 * row * width
        for k in range(HALO, width - HALO, WIDTH):
            e, f = load(ring.cosines, k), load(ring.sines, k)
            p, q = load(ring.w, at + k), load(ring.w, at + width + k)
            x = ring.radii[row] + load(ring.u, at + k) - half * p
            y = load(ring.u, at + width + k) - half * q
            own_p = p + speed * y - (whole_x * e + whole_y * f)
            own_q = q - speed * x - (whole_y * e - whole_x * f)
            store(ring.w, at + k, p - damping.share * own_p)
            store(ring.w, at + width + k, q - damping.share * own_q)
            part_lost += own_p * own_p + own_q * own_q
            part_x += own_p * e - own_q * f
            part_y += own_p * f + own_q * e
        lost += ring.row_mass[row] * total(part_lost)
        back_x += ring.row_mass[row] * total(part_x)
        back_y += ring.row_mass[row] * total(part_y)
    damping.work[0] += damping.share * lost
    return damping.share * back_x, damping.share * back_y


@verb
def _damp_outer(around, ring, damping, dt):
    """`around` : what carries the outer ring. A ring on the ground has no motion but its own."""
    _damp_held(ring, damping)


@_damp_outer.of(OuterTurn)
def _turning(turning, ring, damping, dt):
    _damp_ring(ring, damping, 0.5 * dt, outer_speed_of(turning), 0.0, 0.0)


@_damp_outer.of(Housing)
def _in_housing(housing, ring, damping, dt):
    velocity, impulse = housing.velocity, housing.impulse
    x, y = _damp_ring(ring, damping, 0.5 * dt, 0.0, velocity[0], velocity[1])
    impulse[0] += x
    impulse[1] += y


@_damp_outer.of(Bore)
def _in_play(bore, ring, damping, dt):
    speed, x, y = _whole_motion(ring, 0.5 * dt)
    _damp_ring(ring, damping, 0.5 * dt, speed, x, y)


@part(inlined=False)
def _whole_motion(ring, half):
    """Speed, rad/s, and velocity at the frame's origin, m/s, by a free ring's momentum and angular momentum."""
    width, mass, size, turning = ring.cosines.size, 0.0, 0.0, 0.0
    place_x, place_y, moved_x, moved_y = 0.0, 0.0, 0.0, 0.0
    for row in range(ring.first_row, ring.last_row):
        part_size, part_turning, at = splat(0.0), splat(0.0), 2 * row * width
        part_x, part_y, part_vx, part_vy = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for k in range(HALO, width - HALO, WIDTH):
            e, f = load(ring.cosines, k), load(ring.sines, k)
            p, q = load(ring.w, at + k), load(ring.w, at + width + k)
            x = ring.radii[row] + load(ring.u, at + k) - half * p
            y = load(ring.u, at + width + k) - half * q
            part_size += x * x + y * y
            part_turning += x * q - y * p
            part_x += x * e - y * f
            part_y += x * f + y * e
            part_vx += p * e - q * f
            part_vy += p * f + q * e
        each = ring.row_mass[row]
        mass += each * ring.n_sectors
        size += each * total(part_size)
        turning += each * total(part_turning)
        place_x += each * total(part_x)
        place_y += each * total(part_y)
        moved_x += each * total(part_vx)
        moved_y += each * total(part_vy)
    over = 1.0 / mass
    turning -= over * (place_x * moved_y - place_y * moved_x)
    speed = turning / (size - over * (place_x * place_x + place_y * place_y))
    return speed, over * (moved_x + speed * place_y), over * (moved_y - speed * place_x)


@part(inlined=False)
def _damp_held(ring, damping):
    width, lost = ring.cosines.size, 0.0
    for row in range(ring.first_row, ring.last_row):
        part_lost = splat(0.0)
        for at in range(2 * row * width, 2 * (row + 1) * width, width):
            for k in range(at + HALO, at + width - HALO, WIDTH):
                p = load(ring.w, k)
                store(ring.w, k, p - damping.share * p)
                part_lost += p * p
        lost += ring.row_mass[row] * total(part_lost)
    damping.work[0] += damping.share * lost
