"""How the Lagrangian model's steps are judged by the samples they give. No compiler."""

from enum import Enum
from math import inf, pi

import numpy as np

from fem.solver.guards import ASTRAY, run_warnings
from fem.solver.solver import Numbers, Samples
from lagrange.first_state import Problem
from lagrange.step_size import critical_time_step, fastest_mode

JUDGED = 0.5e-3  # s from the start
SHOCKED = 5.0  # times the largest static force: of 670 sound random starts one reached it, of 25 wrong ones 23
STABLE = 1.4  # ω·step of the stiffest mode met; leapfrog is stable up to 2
ENERGY_TOLERANCE = 1e-2  # where contacts rattle, each impact lasting a few steps; else errors are 1e-6 of it
SURE = 1e-13  # of the kinetic energy: what it rounds to
MET = ("inner_force", "outer_force", "energy_contact", "energy_error", "least_moved", "largest_moved", "dissipated",
       "first_kinetic")  # fmt: skip


class Verdict(Enum):
    """How a step has resolved a motion from its start to its end, and what to say of it."""

    RESOLVED = ""
    TOO_FAST = (
        "the forces met make a mode of {frequency:.3g} Hz, too fast for the step of {step:.3g} s; "
        "set time_step = {stable_step:.2g} or less"
    )
    RATTLING = (
        "contacts rattle: the step of {step:.3g} s changes the energy by {percent:.2g} % of what the contacts pass on; "
        "set time_step = {quarter_step:.2g} or less, or add damping"
    )


class Judge:
    """What the samples of a run have met so far, of a problem and a step, s."""

    def __init__(self, problem: Problem, step: float):
        self._problem, self._step = problem, step
        self._start = np.zeros(2)  # N, largest force of the first sample and within JUDGED of it
        self._met = dict.fromkeys(MET, 0.0) | {"least_moved": inf, "largest_moved": -inf}

    def meet(self, samples: Samples) -> None:
        """Take the next samples into account."""
        met, names = self._met, ("energy_kinetic", "energy_shaft", "energy_support")
        moved = np.sum([samples[name] for name in names if samples.get(name) is not None], axis=0)
        for name in ("inner_force", "outer_force", "energy_contact"):
            met[name] = max(met[name], float(np.abs(samples[name]).max()))
        met["energy_error"] = max(met["energy_error"], float(np.abs(samples.imbalance).max()))
        met["least_moved"] = min(met["least_moved"], float(moved.min()))
        met["largest_moved"] = max(met["largest_moved"], float(moved.max()))
        met["dissipated"] = float(samples["work_dissipated"][-1])
        forces = np.fmax(samples["inner_force"].max(axis=1), samples["outer_force"].max(axis=1))
        if samples["time"][0] == 0.0:
            met["first_kinetic"] = float(samples["energy_kinetic"][0])
            self._start[0] = forces[0]
        self._start[1] = forces[samples["time"] <= JUDGED].max(initial=self._start[1])

    @property
    def critical_time_step(self) -> float:
        """Under the largest forces so far, s."""
        return critical_time_step(self._problem, *self._largest)

    @property
    def _largest(self) -> tuple[float, float]:
        return self._met["inner_force"], self._met["outer_force"]

    @property
    def _fastest(self) -> float:
        """Angular frequency of the stiffest mode under the largest forces so far, rad/s."""
        return fastest_mode(self._problem, *self._largest)

    @property
    def _energy_share(self) -> float:
        """Largest energy error, of the energy that contacts and dampers took and motion gained or lost."""
        met = self._met
        if met["energy_error"] <= SURE * met["first_kinetic"]:
            return 0.0
        return met["energy_error"] / (
            met["energy_contact"] + (met["largest_moved"] - met["least_moved"]) + met["dissipated"]
        )

    @property
    def verdict(self) -> Verdict:
        """How the step has resolved the motion so far; its last word is at the end."""
        if not self._fastest * self._step < STABLE:
            return Verdict.TOO_FAST
        return Verdict.RESOLVED if self._energy_share <= ENERGY_TOLERANCE else Verdict.RATTLING

    @property
    def sentence(self) -> str:
        """The verdict with its numbers."""
        omega, step = self._fastest, self._step
        return self.verdict.value.format(
            frequency=omega / (2 * pi), step=step, stable_step=0.5 * STABLE / omega, percent=100 * self._energy_share,
            quarter_step=step / 4,
        )  # fmt: skip

    def warnings(self, largest: np.ndarray) -> tuple[str, ...]:
        """Sentences on a start that does not last, and contacts too wide for their laws; `largest` : (3,), N."""
        problem = self._problem
        of_start = problem.first_state.warning
        wide = run_warnings(problem.bearing, largest) or self._deep(largest)
        return (*(() if of_start is None else (of_start,)), *self._shocked, *wide)

    def _deep(self, largest: np.ndarray) -> tuple[str, ...]:
        """A sentence where a law that is softer than Hertz's lets bodies overlap far; `largest` : (3,), N."""
        sides = zip(("inner", "outer"), self._problem.laws, largest.tolist(), strict=False)
        depth, side = max((float(law.approach(force)), side) for side, law, force in sides)
        most = ASTRAY * self._problem.bearing.roller_radius
        if depth <= most:
            return ()
        return (
            f"the largest force makes bodies overlap by {1e3 * depth:.3g} mm on the {side} raceway, which is no small "
            f"approach (at most {1e3 * most:.3g} mm here): places and forces near such contacts are not to be trusted; "
            "take a stiffer contact law or a lighter load",
        )

    @property
    def _shocked(self) -> tuple[str, ...]:
        """A sentence where a steady load's equilibrium does not last: energy can't show a start that is wrong."""
        problem, (first, soon) = self._problem, self._start
        steady = problem.operation.is_steady and not problem.bearing.faults
        if problem.start != "equilibrium" or not steady or soon <= SHOCKED * first:
            return ()
        return (
            f"within {1e3 * JUDGED:g} ms of the start a contact carries {soon:.4g} N, {soon / first:.2g} times the "
            "largest static force: the motion does not begin as the equilibrium moves; leave out the beginning "
            "(check-residual --start), or give the contacts damping",
        )

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        """What a checkpoint keeps."""
        return {"start": self._start}, {"met": dict(self._met)}

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        """Go on from what another judge of the same plan kept."""
        self._start = arrays["start"]
        self._met = {name: float(numbers["met"][name]) for name in MET}
