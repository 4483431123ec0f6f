"""Two step lengths for bearings with spalls: how long, and for which share of the time. No compiler."""

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

    def finer(self, times: int) -> "Sections":
        """With so many times as many steps."""
        return replace(self, near=times * self.near, far=times * self.far)

    @property
    def mean(self) -> float:
        """Steps of a section, about."""
        return self.share * self.near + (1.0 - self.share) * self.far


def sections_of(bearing: Bearing, ideal: Kinematics, row: float, short: float, long: float) -> Sections | None:
    """How rows of a time, s, are cut; None: steps of one length do as well.

    Parameters
    ----------
    ideal : at the fastest speed
    short, long : s, the longest steps near edges and elsewhere
    """
    arcs, speed = list(spalls_met(bearing)), abs(ideal.cage - ideal.outer_ring) * bearing.outer_raceway_radius
    if not arcs or speed == 0.0 or short >= long:
        return None
    fall = max(np.abs(np.diff(profile.coefficients)).max() / profile.spacing for _, profile, _, _ in arcs) * speed
    ways = (2.0 * half * radius for _, _, (_, _, half), radius in arcs)
    count = ceil(row / max(WAY * min(ways) / speed, long))
    section = row / count
    near, far = ceil(section / short * (1.0 - 1e-12)), ceil(section / long * (1.0 - 1e-12))
    margin = REACH * section * speed
    share = min(1.0, AFTER * _share_near(bearing, ideal, margin))
    strike = float(0.5 * bearing.roller_mass * fall**2)
    found = Sections(count=count, near=near, far=far, share=share, margin=margin, strike=strike)
    return found if found.mean <= WORTH * near else None


def spalls_met(bearing: Bearing):
    """Body, profile, (roller, middle and half, rad), radius, m, of every spall in every contact that it comes into."""
    surfaces = profiles(bearing)
    if surfaces is None:
        return
    bodies = (
        ("inner_ring", surfaces.inner_ring, bearing.inner_raceway_radius),
        ("outer_ring", surfaces.outer_ring, bearing.outer_raceway_radius),
        ("inside", surfaces.rollers_inside, bearing.roller_radius),
        ("outside", surfaces.rollers_outside, bearing.roller_radius),
    )
    for body, profile, radius in bodies:
        if profile is not None:
            for spall in profile.spalls:
                yield body, profile, spall, radius


def _share_near(bearing: Bearing, ideal: Kinematics, margin: float) -> float:
    """Share of the time in which a contact is near an edge, of rollers that roll."""
    time = np.arange(INSTANTS)[:, None] / INSTANTS * (2.0 * pi / abs(ideal.cage - ideal.outer_ring))
    at = roller_angles(bearing, 0.0) + ideal.cage * time
    contact = {
        "inner_ring": at - ideal.shaft * time,
        "outer_ring": at - ideal.outer_ring * time,
        "inside": at + pi - ideal.roller * time,
        "outside": at - ideal.roller * time,
    }
    near = np.zeros(INSTANTS, dtype=bool)
    for body, _, (roller, middle, half), radius in spalls_met(bearing):
        met = contact[body] if roller is None else contact[body][:, roller, None]
        away = np.abs(np.mod(met - middle + pi, 2.0 * pi) - pi)
        near |= np.any(away < half + margin / radius, axis=1)
    return float(near.mean())


def time_along_a_wave(bearing: Bearing, ideal: Kinematics) -> float:
    """Time in which contacts roll over the shortest knot that all but spalls need, s."""
    surfaces, speed = profiles(bearing), abs(ideal.cage - ideal.outer_ring) * bearing.outer_raceway_radius
    return inf if surfaces is None or speed == 0.0 else surfaces.shortest_of_waves / speed


@dataclass(frozen=True, kw_only=True)
class RigidPlan(CompiledPlan):
    """A plan for the time loop of rigid bodies: steps of one length, or of two where spalls are."""

    scene: Scene
    n_samples: int
    stride: int  # steps between samples, the shortest ones
    looks: int = 1  # at the energy per sample
    sections: Sections | None  # of two step lengths; None: of one
    warnings: tuple[str, ...] = ()

    def too_far(self, times: int) -> str | None:
        """Why tables of contacts that tilt can't go to so many times the force, and what to do; None: they can."""
        return None

    @property
    def time_step(self) -> float:
        return self.interval / self.stride

    @property
    def long_step(self) -> float:
        """Away from edges of spalls, s."""
        cut = self.sections
        return self.time_step if cut is None else self.interval / (self.looks * cut.count * cut.far)

    @property
    def steps(self) -> int:
        """Of the run; of two lengths, about."""
        cut = self.sections
        each = self.stride if cut is None else self.looks * cut.count * cut.mean
        return round(each * (self.n_samples - 1))

    def step_rows(self, more: str = "") -> dict[str, str]:
        """What --dry-run shows of the steps; `more` : on their length."""
        critical, duration = self.critical_time_step, f"{1e3 * (self.n_samples - 1) * self.interval:g} ms"
        block = 8e-6 * ARRAYS * (self.scene.ideal_bearing().n_rollers + 1) * min(self.n_samples, LARGEST_BLOCK)
        memory = {"memory of a block of samples": f"{block:.1f} MB"}
        share = f"{self.long_step / critical:.2f} of the critical {1e6 * critical:.3g} µs"
        long = f"{1e6 * self.long_step:.3g} µs{more} ({share})"
        if self.sections is None:
            return {
                "time step": long,
                "steps": f"{self.steps} for {duration}",
                "samples": f"{self.n_samples}, one every {self.stride} steps",
                **memory,
            }
        return {
            "time step": f"{long}, {1e6 * self.time_step:.3g} µs near edges and until impacts have decayed",
            "steps": f"about {self.steps} for {duration}",
            "samples": f"{self.n_samples}, one every {self.stride} steps at most",
            **memory,
        }
