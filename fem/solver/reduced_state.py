"""The reduced model's state: runs that restart, what they warn of, what a checkpoint keeps."""

from typing import TYPE_CHECKING

import numpy as np

from fem.solver.reduced_arrays import bodies_of, contact_forces, contacts_of, drive_of
from fem.solver.rigid_state import RigidState
from fem.solver.solver import ROUND_OFF, Block, Numbers, Samples
from fem.solver.validity import add_samples, law_warning, no_sums, vibration_warning
from lagrange import Bearing

if TYPE_CHECKING:
    from fem.solver.rigid.reduced import ReducedPlan


LIMIT = 1e-3  # of the exchanged energy: what a run's balance may be off by
MOST_TURN = 1e6  # rad, that `lane_functions.cosine_and_sine` takes
MOST_HALVINGS = 6  # of the time step


# of the largest force in one vibration of the bodies: beyond, forces of random bearings were off by up to 6 %, beyond
# a half by up to a factor of 2; below both by 2 % at most
SHOCK, HARD_SHOCK = 0.075, 0.5
BEYOND = 1e-3  # of the largest force on the inner ring: what kicks may give beyond forces before a run says so


class ReducedState(RigidState):
    """Rigid bodies and contacts. A run whose energy will not balance to LIMIT restarts with half the step.

    What opens and closes at once is all that takes such steps: rollers that rattle without friction.
    """

    most_halvings = MOST_HALVINGS

    def arrays_of(self, plan: "ReducedPlan"):
        bodies = bodies_of(plan)
        contacts = contacts_of(plan, bodies.columns)
        return bodies, contacts, contact_forces(plan, bodies.columns, contacts.coupling), drive_of(plan)

    def _begin(self) -> None:
        super()._begin()
        self._worst = 0.0  # J, the largest energy error of samples so far
        self._hub_sums = no_sums()

    def judged(self, block: Block) -> Block:
        samples = block.samples
        lost = block.trouble is not None
        if samples is not None and len(samples):
            lost = lost or self._loses_energy(samples)
            add_samples(self._hub_sums, samples)
        if not (lost and self.may_restart):
            return block
        if self._came_apart and self._halvings and abs(self.imbalance) <= LIMIT:
            return block  # no fault of the steps: with shorter ones, too, and while energy balances
        reason = f"energy does not balance to {LIMIT:g} of what is exchanged"
        if self._came_apart:
            reason = "the bearing comes apart"
        return self.restart(samples, f"{reason} with steps of {1e6 * self.plan.time_step:.3g} µs")

    def _loses_energy(self, samples: Samples) -> bool:
        """Whether the run's energy is, or by its end will be, off by more than LIMIT of what is exchanged.

        Before the end that is taken to grow in proportion to the time, from what the load stores in contacts at rest
        where less has been exchanged: but for one of 444 random bearings, runs that end well stay 14 % below.
        """
        worst = np.fmax(np.maximum.accumulate(np.abs(samples.error)), self._worst)
        self._worst = float(worst[-1])
        if self.done == self.plan.n_samples:
            return self._worst > LIMIT * float(samples.exchanged[-1])
        share = np.arange(self.done - len(samples) + 1, self.done + 1) / self.plan.n_samples
        least = np.fmax(self.plan.static_energy, ROUND_OFF * np.abs(samples["energy_kinetic"]))
        return bool(np.any(worst * share > LIMIT * np.fmax(samples.exchanged, least)))

    @property
    def shock(self) -> float:
        """The most that a force has changed in a vibration of the bodies' own, over the largest force."""
        now = self.drives[0 if self.paces is None else self.paces.now[0]]
        rate = float(self.forces.fastest.max()) / now.dt
        return rate * slowest_vibration(self.plan.model.bearing) / max(float(self._largest.max()), 1e-30)

    @property
    def warnings(self) -> tuple[str, ...]:
        found = super().warnings
        if self.shock < SHOCK:
            return found + self._slow_hub + self._stiff_laws + self._unequal_kicks
        off = "tens of per cent" if self.shock > HARD_SHOCK else "several per cent"
        return (
            *found,
            "impacts excite elastic waves, which the reduced model represents only in part: individual peak forces may "
            f'be off by {off}; for peak forces use model = "fem"',
        )

    @property
    def _slow_hub(self) -> tuple[str, ...]:
        """A sentence where the rings' mass changes the hub's vibration."""
        plan, mounting = self.plan, self.plan.operation.mounting
        if mounting.shaft is not None or mounting.housing is not None:  # then they are not what the hub vibrates by
            return ()
        said = vibration_warning(plan.model.bearing, plan.operation.inner_mass, self._hub_sums)
        return () if said is None else (said,)

    @property
    def _stiff_laws(self) -> tuple[str, ...]:
        """A sentence where contacts became so wide that their laws are too stiff."""
        said = law_warning(self.plan.model.contacts, self._largest)
        return () if said is None else (said,)

    @property
    def _unequal_kicks(self) -> tuple[str, ...]:
        """A sentence on samples whose forces are not what the hub was given, if they are off by more than BEYOND."""
        most, largest = float(self.forces.beyond[0]), float(self._largest[0])
        if most <= BEYOND * largest or largest == 0.0:  # without a force there is nothing to compare with
            return ()
        key = "output_interval_us" if self.plan.stride == 1 else "time_step_safety"  # what makes steps shorter
        return (
            f"when contacts open or close, the energy-conserving step gives the hub up to {most:.3g} N more or less "
            f"than the contacts' forces ({100.0 * most / largest:.2g} % of the largest on the inner ring), and the "
            f"momentum balance is off by as much; lower numerics.{key}",
        )

    def to_keep(self) -> tuple[dict[str, np.ndarray], Numbers]:
        arrays, numbers = super().to_keep()
        return arrays | {"hub_sums": self._hub_sums}, numbers | {"worst": self._worst}

    def take_back(self, arrays: dict[str, np.ndarray], numbers: Numbers) -> None:
        super().take_back(arrays, numbers)
        self._worst, self._hub_sums = float(numbers["worst"]), arrays["hub_sums"]

    @property
    def fixed(self) -> tuple:
        waves = self.forces.radiation
        return super().fixed if waves is None else (*super().fixed, waves.inertia, waves.settling)

    def check(self) -> None:
        bodies, n = self.bodies, self.bodies.n
        from_hub = np.hypot(*(bodies.centre[:, :n] - bodies.hub[:, None]))
        ring = np.zeros(2) if bodies.housing is None else bodies.housing.place
        nearest = min(from_hub.min(), np.hypot(*(bodies.centre[:, :n] - ring[:, None])).min())
        uneven = self.forces.slope is not None  # then kernels look up surfaces by how far bodies have turned
        if nearest < bodies.radius or (uneven and np.abs(bodies.turn).max() > MOST_TURN):
            raise ValueError("rollers outside the bearing, or turned too far")
        if self.forces.radiation is not None and np.any(self.forces.radiation.owed < 0.0):
            raise ValueError("contacts with a negative energy loss to waves")


def slowest_vibration(bearing: Bearing) -> float:
    """Period, s, of the slowest free vibration of a roller, or of a ring through its thickness.

    A disc's ovalling takes 5.1 radii of the dilatational wave's way at a Poisson's ratio of 0.3, by the exact
    frequency equation (its source is in the tests); a layer that is held on one side takes four thicknesses.
    """
    ways = (
        (5.1 * bearing.roller_radius, bearing.roller),
        (4.0 * (bearing.inner_raceway_radius - bearing.bore_radius), bearing.inner_ring),
        (4.0 * (bearing.outside_radius - bearing.outer_raceway_radius), bearing.outer_ring),
    )
    return max(way / material.dilatational_wave_speed for way, material in ways)
