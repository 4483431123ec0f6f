"""Plans of rigid bodies in one time loop, without a compiler: steps of one length, or of two where spalls are."""

from dataclasses import dataclass, replace
from math import ceil, inf, pi

import numpy as np

from fem.solver.compiling import CompiledPlan
from fem.solver.simulate import LARGEST_BLOCK
from lagrange import Bearing, Kinematics
from lagrange.kinematics import roller_angles
from lagrange.scene.scene import Scene
from lagrange.surface.deviation import profiles

ARRAYS = 30  # per roller and sample of a block, at the most at a time
WAY = 0.02  # of a spall with its edges, that contacts go in a section at most: what is looked at no more often
REACH = 2.0  # sections' ways, from which on a contact is near
WORTH = 0.7  # of the steps of one length, that those of two must come down to
AFTER = 1.3  # times the way near edges: steps stay short while strikes die away
INSTANTS = 400  # of a turn of the cage, by which the share of short steps is found


@dataclass(frozen=True, kw_only=True)
class Sections:
    """Steps of one length each."""

    count: int  # of a row
    near: int  # steps of a section near edges, or while strikes die away
    far: int  # of any other
    share: float  # of sections near edges, about
    margin: float  # m, beyond edges, from which on contacts are near
    strike: float  # J, of a roller that falls into a spall

    mean = property(lambda self: self.share * self.near + (1.0 - self.share) * self.far)  # Steps of a section, about


def sections_of(bearing: Bearing, ideal: Kinematics, row: float, short: float, long: float) -> Sections | None:
    """How rows of a time, s, are cut; None: steps of one length do as well.

    ideal : at the fastest speed
    short, long : s, the longest steps near edges and elsewhere
    """
    arcs, turning = list(spalls_met(bearing)), abs(ideal.cage - ideal.outer_ring)
    speed = turning * bearing.outer_raceway_radius
    if not arcs or speed == 0.0 or short >= long:
        return None
    fall = max(np.abs(np.diff(profile.coefficients)).max() / profile.spacing for _, profile, _, _ in arcs) * speed
    ways = (2.0 * half * radius for _, _, (_, _, half), radius in arcs)
    count = ceil(row / max(WAY * min(ways) / speed, long))
    section = row / count
    steps, margin = [ceil(section / step * (1.0 - 1e-12)) for step in (short, long)], REACH * section * speed
    # share of the time in which a contact is near an edge, of rollers that roll
    time = np.arange(INSTANTS)[:, None] / INSTANTS * (2.0 * pi / turning)
    at = roller_angles(bearing, 0.0) + ideal.cage * time
    contact = {
        "inner_ring": at - ideal.shaft * time, "outer_ring": at - ideal.outer_ring * time,
        "inside": at + pi - ideal.roller * time, "outside": at - ideal.roller * time,
    }  # fmt: skip
    near = np.zeros(INSTANTS, dtype=bool)
    for body, _, (roller, middle, half), radius in arcs:
        met = contact[body] if roller is None else contact[body][:, roller, None]
        away = np.abs(np.mod(met - middle + pi, 2.0 * pi) - pi)
        near |= np.any(away < half + margin / radius, axis=1)
    share, strike = min(1.0, AFTER * float(near.mean())), float(0.5 * bearing.roller_mass * fall**2)
    found = Sections(count=count, near=steps[0], far=steps[1], share=share, margin=margin, strike=strike)
    return found if found.mean <= WORTH * found.near else None


def spalls_met(bearing: Bearing):
    """Body, profile, (roller, middle and half, rad), radius, m, of every spall in every contact that it comes into."""
    if (surfaces := profiles(bearing)) is None:
        return
    bodies = (
        ("inner_ring", surfaces.inner_ring, bearing.inner_raceway_radius),
        ("outer_ring", surfaces.outer_ring, bearing.outer_raceway_radius),
        ("inside", surfaces.rollers_inside, bearing.roller_radius),
        ("outside", surfaces.rollers_outside, bearing.roller_radius),
    )
    for body, profile, radius in bodies:
        for spall in () if profile is None else profile.spalls:
            yield body, profile, spall, radius


@dataclass(frozen=True, kw_only=True)
class RigidPlan(CompiledPlan):
    """A plan for the time loop of rigid bodies: steps of one length, or of two where spalls are.

    It has `bearing`, `operation`, `axial` (None: axes stay parallel) and `first_angle`, (n_rollers,), rad; and
    `reaching(times)`, the same whose tables of contacts that tilt go to so many times the force.
    """

    scene: Scene
    n_samples: int
    stride: int  # steps between samples, the shortest ones
    looks: int = 1  # at the energy per sample
    sections: Sections | None  # of two step lengths; None: of one
    warnings: tuple[str, ...] = ()
    unwatched = inf  # steps between two looks at the most

    def changed(self, **changes):
        """The same but for these."""
        return replace(self, **changes)

    def halved(self, times: int):
        """The same with a step halved so many times, and looks that are frequent enough."""
        finer, looks, stride, cut = 2**times, self.looks, self.stride * 2**times, self.sections
        while stride > looks * self.unwatched and finer > 1:  # and divide the stride all the way
            looks, finer = 2 * looks, finer // 2
        cut = cut and replace(cut, near=finer * cut.near, far=finer * cut.far)
        return self.changed(stride=stride, looks=looks, sections=cut)

    def too_far(self, times: int) -> str | None:
        """Why tables of contacts that tilt can't go to so many times the force, and what to do; None: they can."""
        return None

    time_step = property(lambda self: self.interval / self.stride)

    @property
    def long_step(self) -> float:
        """Away from edges of spalls, s."""
        cut = self.sections
        return self.time_step if cut is None else self.interval / (self.looks * cut.count * cut.far)

    @property
    def steps(self) -> int:
        """Of the run; of two lengths, about."""
        cut = self.sections
        return round((self.stride if cut is None else self.looks * cut.count * cut.mean) * (self.n_samples - 1))

    def step_rows(self, more: str = "") -> dict[str, str]:
        """What --dry-run shows of the steps; `more` : on their length."""
        critical, step, about, most = self.critical_time_step, self.long_step, "", ""
        length = f"{1e6 * step:.3g} µs{more} ({step / critical:.2f} of the critical {1e6 * critical:.3g} µs)"
        if self.sections is not None:
            about, most = "about ", " at most"
            length += f", {1e6 * self.time_step:.3g} µs near edges and until impacts have decayed"
        block = 8e-6 * ARRAYS * (self.bearing.n_rollers + 1) * min(self.n_samples, LARGEST_BLOCK)
        return {
            "time step": length,
            "steps": f"{about}{self.steps} for {1e3 * (self.n_samples - 1) * self.interval:g} ms",
            "samples": f"{self.n_samples}, one every {self.stride} steps{most}",
            "memory of a block of samples": f"{block:.1f} MB",
        }
