"""What the loop of rigid bodies asks of every part: a body beside hub and rollers, or what acts on these.

A part is a named tuple of arrays. `@verb.of(Part)` in its module gives the code for each of these questions that
concerns it; `parts_of` says in which order parts act. The loop names none of them.
"""

from typing import NamedTuple

import numpy as np

from fem.kernels.jit import every, part, verb

TWELFTH = 1.0 / 12.0  # of dt²·acceleration: how far ahead forces are taken, see `reduced_kick`


class Step(NamedTuple):
    """A step of leapfrog, from velocities half of it behind to those half of it ahead; tuples of `reduced_state`."""

    bodies: tuple  # `RigidBodies`
    compliance: tuple  # of contacts: `Compliance`, `Isolated` or `Tilted`
    forces: tuple  # `ReducedForces`
    before: tuple  # `Before`
    drive: tuple  # `ReducedDrive`
    time: float  # s, of the kick


class Change(NamedTuple):
    """The change from one step length to another: see `reduced_paces`."""

    drive: tuple  # with the new step
    shift: float  # s², of an acceleration by which places change
    back: float  # of what a kick has given, by which velocities change
    step: np.ndarray  # (2, 3), a sensor's with the new step: see `housing_kernels.Resonator`
    half_step: np.ndarray  # (2, 3)


@part
def parts_of(bodies, forces):
    """All parts of a scene, None where it lacks one, in the order in which they act."""
    return (
        bodies.shaft,
        bodies.housing,
        bodies.cage,
        bodies.tilts,
        forces.radiation,
        bodies.prescribed,
        forces.dampers,
    )


@verb
def begin(part, step):
    """Begin a step, before forces are found."""


@verb
def accelerate(part, step, push):
    """Add what has a potential to the accelerations of `before`, m/s².

    push : N, of the raceways' contacts on hub and outer ring: x, y, x, y
    """


@verb
def kick_part(part, step, push):
    """Make the part's kick, and kick the bodies that it acts on; `push`: as above, what contacts have given, N."""


@verb
def note_work(part, step):
    """Count works that take the velocities before and after the whole kick."""


@verb
def write_part(part, step, out):
    """Add the part's columns and energies to a sample."""


@verb
def change_step(part, step, change):
    """Change velocities, places and works of a kick that `step.drive` has made to those of another step length."""


@verb
def drift_part(part, step):
    """Move on by a step."""


begin_all, accelerate_all, kick_all, note_all = every(begin), every(accelerate), every(kick_part), every(note_work)
write_all, change_all, drift_all = every(write_part), every(change_step), every(drift_part)


@part
def rescale_kick(before, after, k, back):
    """Change the velocities before and after a kick to those of another step length."""
    gained = after[k] - before[k]
    before[k] += back * gained
    after[k] -= back * gained
