"""Rows of the time loop turned into the result file's quantities."""

import numpy as np

from fem.kernels import sample_kernels as row
from fem.solver.cage_arrays import cage_columns
from fem.solver.guards import EnergyAccount
from fem.solver.solver import Samples
from lagrange.mounting import ENERGIES, from_outer_ring

TURN = 2.0 * np.pi


class SampleReader:
    """Reads blocks of rows, `plan.looks` a sample, in order; carries what runs on from block to block.

    How the rows are cut into blocks, which is a matter of the wall clock, changes no bit of any quantity.
    """

    def __init__(self, plan):
        self._n = plan.model.bearing.n_rollers
        self._further = plan.operation.mounting.columns  # columns of a row behind those of the rollers
        self._pressed = plan.pressed_energy
        self._has_cage = plan.scene.cage is not None
        self._looks = plan.looks
        self._interval = plan.interval
        self._count = 0
        self._angle = plan.start.angle
        self._base = None
        self._account = EnergyAccount()

    def to_keep(self) -> dict[str, np.ndarray]:
        """What runs on, as arrays; `take_back` takes it back."""
        base = (np.nan,) * 4 if self._base is None else self._base
        return {
            "count": np.array(self._count),
            "angle": self._angle,
            "sums": np.array([*base, *self._account.to_keep()]),
        }

    def take_back(self, kept: dict[str, np.ndarray], samples: int) -> None:
        """Go on where another reader of the same plan stopped, after so many samples. ValueError: after others."""
        self._count = int(kept["count"])
        if self._count != samples * self._looks or (samples and np.isnan(kept["sums"]).any()):
            raise ValueError(f"rows of {samples} samples were to be read")
        self._angle = kept["angle"]
        base = tuple(float(value) for value in kept["sums"][:4])
        self._account.take_back(kept["sums"][4:])
        self._base = None if np.isnan(base[0]) else base

    def read(self, rows: np.ndarray) -> Samples:
        """Quantities of the next rows."""
        n = self._n
        end = row.N_SCALARS + n * len(row.BLOCKS)
        blocks = rows[:, row.N_SCALARS : end].reshape(len(rows), len(row.BLOCKS), n)
        at = end + len(self._further)
        block = {name: blocks[:, i] for i, name in enumerate(row.BLOCKS)}
        further = {name: rows[:, end + i] for i, name in enumerate(self._further)}
        x, y = from_outer_ring(block | further, "roller")
        works = rows[:, [row.WORK_LOAD, row.WORK_GRAVITY, row.WORK_DRIVE]].sum(axis=1)
        kinetic, stored = rows[:, row.KINETIC], rows[:, row.ELASTIC] + rows[:, row.CONTACT]
        moved = kinetic + sum(further[name] for name in ENERGIES if name in further)
        if self._base is None:
            self._base = works[0], rows[0, row.DISSIPATED], moved[0], stored[0]
        work, dissipated = works - self._base[0], rows[:, row.DISSIPATED] - self._base[1]
        gained = moved - self._base[2]
        values = {
            "time": (self._count + np.arange(len(rows))) / self._looks * self._interval,
            "inner_x": rows[:, row.HUB_X],
            "inner_y": rows[:, row.HUB_Y],
            "inner_vx": rows[:, row.HUB_VX],
            "inner_vy": rows[:, row.HUB_VY],
            "inner_ax": rows[:, row.HUB_AX],
            "inner_ay": rows[:, row.HUB_AY],
            "roller_x": block["roller_x"],
            "roller_y": block["roller_y"],
            "roller_rho": np.hypot(x, y),
            "roller_theta": self._unwrap(np.arctan2(y, x)),
            "roller_spin": block["roller_spin"],
            "roller_turn": block["roller_turn"],
            "inner_force": block["inner_force"],
            "outer_force": block["outer_force"],
            "inner_traction": block["inner_traction"],
            "outer_traction": block["outer_traction"],
            "roller_roller_force": block["roller_roller_force"],
            "energy_kinetic": kinetic,
            "energy_elastic": rows[:, row.ELASTIC],
            "energy_contact": rows[:, row.CONTACT],
            "work_external": work,
            "work_dissipated": dissipated,
            "inner_damping_force": block["inner_damping_force"],
            "outer_damping_force": block["outer_damping_force"],
            "work_damping_contact": rows[:, row.DAMPED_BY_CONTACTS],
            "work_damping_bodies": rows[:, row.DAMPED_BY_BODIES],
            **further,
        }
        if self._has_cage:
            values |= cage_columns(rows, n, at)
        self._count += len(rows)
        imbalance = gained + (stored - self._base[3]) - work + dissipated
        return self._account.samples(values, imbalance, np.fmax(stored - self._pressed, np.abs(gained)))

    def _unwrap(self, angle: np.ndarray) -> np.ndarray:
        first = np.round((self._angle - angle[:1]) / TURN)
        turns = np.concatenate([first, -np.round(np.diff(angle, axis=0) / TURN)]).cumsum(axis=0)
        unwrapped = angle + TURN * turns
        self._angle = unwrapped[-1]
        return unwrapped
