"""Tangential springs of contacts: what the mesh can't see of how a contact that sticks gives way.

A spring is in series with Carter's creep: a contact's slip is its creep and how fast the spring is stretched. With the
stretch e at a kick and d₋, d₊ what it gains in the steps before and after,

    T C = e + (d₊ − d₋)/4,    d₊ = dt (slip after the kick − creep),    C = A (level − ½ ln Q),

so T is the mean of the spring's forces half a step before and after: of second order, and no C > 0 limits the step
(Newmark's method with a quarter, of the springs alone; leapfrog moves the rest). What it stores at a kick,

    (e + d₊/2)² / 2C − ½ T d₊,

changes in a step by what tractions do to the spring, exactly. Of a contact that slides, whose traction is given, the
first equation would make e swing from step to step; there the stretch is T C. C follows the normal force: as that
grows the traction stays, as it falls the stretch does, and neither makes energy.

Source: Newmark, ASCE J. Eng. Mech. 85 (1959) 67; Elata and Berryman, Mechanics of Materials 24 (1996) 229, on the last.
"""

from fem.kernels.jit import part, verb
from fem.kernels.lane_functions import larger, smaller
from fem.kernels.lane_memory import gather, load, store
from fem.kernels.lanes import magnitude, select, splat
from fem.kernels.law import STEEPEST
from fem.kernels.state import Shear


@verb
def spring_back(shear, contacts, pair, row, dt):
    """What eight springs add to the slip, m/s, and to the mobility times dt, m/s per N, of their contacts' creep."""
    return 0.0, 0.0


@spring_back.of(Shear)
def _spring_back(shear, contacts, pair, row, dt):
    compliance = _follow(shear, contacts.forces, pair, row)
    return (load(shear.gained, row) - 4.0 * load(shear.stretch, row)) * (1.0 / dt), compliance * (4.0 / dt)


@part
def _follow(shear, forces, pair, row):
    """Compliances by the present normal forces, m/N; stretches follow them, those of open contacts are given up."""
    law, Q = pair.law, load(forces.force, row)
    closed = Q > 0.0
    level = gather(shear.level, pair.row) - load(forces.bracket, row)
    # approach over force is A (bracket − ½ ln Q): saves a logarithm
    soft = select(closed, load(forces.approach, row), 0.0) / select(closed, Q, 1.0) + law.A * level
    soft = larger(soft, STEEPEST * law.A)
    kept = select(closed, smaller(soft / load(shear.compliance, row), 1.0), 0.0)
    store(shear.compliance, row, soft)
    store(shear.stretch, row, kept * load(shear.stretch, row))
    store(shear.gained, row, kept * load(shear.gained, row))
    return soft


@verb
def stretch(shear, row, chosen, traction, limit, creep, slip):
    """Stretch the springs of chosen ones of eight contacts by their tractions; the slips left, m/s.

    `traction`, `limit` : N, against the slip, and where it slides; `creep`, `slip` : m/s, without and with springs
    """
    return creep


@stretch.of(Shear)
def _stretch(shear, row, chosen, traction, limit, creep, slip):
    before, last = load(shear.stretch, row), load(shear.gained, row)
    own, sliding = load(shear.compliance, row) * traction, magnitude(traction) >= limit
    gained = select(sliding, 0.0, 4.0 * (own - before) + last)
    store(shear.stretch, row, select(chosen, select(sliding, own, before + gained), before))
    store(shear.gained, row, select(chosen, gained, last))
    return slip


@verb
def let_go(shear, row):
    """Give up the stretches of eight open contacts."""


@let_go.of(Shear)
def _let_go(shear, row):
    store(shear.stretch, row, splat(0.0))
    store(shear.gained, row, splat(0.0))


@verb
def spring_energy(shear, traction, n):
    """What all springs store at the kick just made, J; `traction` on side 1, N."""
    return 0.0


@spring_energy.of(Shear)
def _spring_energy(shear, traction, n):
    found = 0.0
    for row in range(traction.shape[0]):
        for j in range(n):
            gained = shear.gained[row, j]
            half_way = shear.stretch[row, j] - 0.5 * gained
            found += 0.5 * (half_way * half_way / shear.compliance[row, j] + traction[row, j] * gained)
    return found


@verb
def behind_places(shear, traction, n):
    """Work that slips of momenta lack of those of places, J: in a patch that gives way, ½ softness T²."""
    return 0.0


@behind_places.of(Shear)
def _behind_places(shear, traction, n):
    found = 0.0
    for row in range(traction.shape[0]):
        for j in range(n):
            found += 0.5 * shear.softness[row] * traction[row, j] * traction[row, j]
    return found
