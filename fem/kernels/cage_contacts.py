"""One contact of a cage, in a pocket or with its guide: its spring, its dashpot, its works."""

from fem.kernels.cage_state import DASHPOTS, FRICTION
from fem.kernels.jit import part
from fem.kernels.law import kick_force


@part
def half_a_work(cage, contacts, j, rates, dt):
    """What a step's dashpot and friction have taken by the velocities at one of its ends."""
    cage.lost[DASHPOTS] -= 0.5 * dt * contacts.given[0, j] * rates[0]
    cage.lost[FRICTION] -= 0.5 * dt * contacts.given[1, j] * rates[1]


@part
def spring_kick(contacts, j, approach, stiffness, dt):
    """What a kick gives of a contact's spring, N: see `law.kick_force`, of which this is the linear law.

    A kick's work is along its own normal, and normals turn: what that differs from the approach's change is residual
    energy too.
    """
    force, last, before = stiffness * max(approach, 0.0), contacts.kick[j], contacts.approach[j]
    kick, residual = kick_force(
        before, contacts.force[j], 0.0, last, contacts.residual[j], approach, force, 0.0, 1.0, 0.0
    )
    if before == before:
        step, coming = approach - before, contacts.rates[0, j]
        residual -= 0.5 * ((dt * contacts.closing[j] - step) * last + (dt * coming - step) * kick)
    contacts.approach[j], contacts.force[j], contacts.kick[j], contacts.residual[j] = approach, force, kick, residual
    return kick


@part
def dashpot(cage, closing, force, mobility_dt):
    """Force of a dashpot, N, that leaves closing − mobility·dt·force of a speed; with the spring's it never pulls."""
    return max(cage.damping * closing / (1.0 + cage.damping * mobility_dt), -force)
