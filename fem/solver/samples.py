"""Rows of the time loop turned into the result file's quantities."""

from collections.abc import Collection

import numpy as np

from fem.kernels import sample_kernels as row
from fem.solver.guards import EnergyAccount
from fem.solver.solver import Samples
from lagrange.bearing import Cage
from lagrange.columns import PER_ROLLER, columns_of
from lagrange.mounting import ENERGIES, HELD, Mounting, from_outer_ring

TURN = 2.0 * np.pi


def row_places(n_rollers: int, parts: Collection[str] = ()) -> dict[str, int | slice]:
    """Where a row of the time loops holds each column: those of `sample_kernels`, then those of a scene's parts."""
    further = columns_of(*parts)
    places: dict[str, int | slice] = {name: i for i, name in enumerate(row.SCALARS)}
    at = row.N_SCALARS
    for name in (*row.BLOCKS, *further):
        is_block = name in row.BLOCKS or further[name].dimensions == PER_ROLLER
        places[name] = slice(at, at + n_rollers) if is_block else at
        at += n_rollers if is_block else 1
    return places


def row_width(n_rollers: int, cage: Cage | None, mounting: Mounting = HELD, further: tuple[str, ...] = ()) -> int:
    """Numbers in a sample of the time loops; `further` : parts of a scene beside cage and mounting."""
    parts = *mounting.parts, *(() if cage is None else ("cage",)), *further
    return _width(row_places(n_rollers, parts))


def _width(places: dict[str, int | slice]) -> int:
    return 1 + max(at.stop - 1 if isinstance(at, slice) else at for at in places.values())


class SampleReader:
    """Reads blocks of rows, `plan.looks` a sample, in order; carries what runs on from block to block.

    How the rows are cut into blocks, which is a matter of the wall clock, changes no bit of any quantity.
    """

    def __init__(self, plan):
        further = [part for part in plan.scene.parts if part not in row.IN_EVERY_ROW]
        self._places = row_places(plan.model.bearing.n_rollers, further)
        self.width = _width(self._places)  # of a row
        self._pressed = plan.pressed_energy
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
        values = {name: rows[:, place].copy() for name, place in self._places.items()}  # each is read several times
        x, y = from_outer_ring(values, "roller")
        works = values["work_load"] + values["work_gravity"] + values["work_drive"]
        stored = values["energy_elastic"] + values["energy_contact"]
        moved = values["energy_kinetic"] + sum(values[name] for name in ENERGIES if name in values)
        if self._base is None:
            self._base = works[0], values["work_dissipated"][0], moved[0], stored[0]
        gained = moved - self._base[2]
        values |= {
            "time": (self._count + np.arange(len(rows))) / self._looks * self._interval,
            "roller_rho": np.hypot(x, y),
            "roller_theta": self._unwrap(np.arctan2(y, x)),
            "work_external": works - self._base[0],
            "work_dissipated": values["work_dissipated"] - self._base[1],
        }
        self._count += len(rows)
        imbalance = gained + (stored - self._base[3]) - values["work_external"] + values["work_dissipated"]
        return self._account.samples(values, imbalance, np.fmax(stored - self._pressed, np.abs(gained)))

    def _unwrap(self, angle: np.ndarray) -> np.ndarray:
        turns = np.round((self._angle - angle[0]) / TURN)
        unwrapped = angle + TURN * turns
        moved = np.diff(angle, axis=0)
        for passed in np.flatnonzero(np.abs(moved) > np.pi):  # few
            sample, roller = divmod(passed, angle.shape[1])
            turns[roller] -= np.round(moved[sample, roller] / TURN)
            unwrapped[sample + 1 :, roller] = angle[sample + 1 :, roller] + TURN * turns[roller]
        self._angle = unwrapped[-1]
        return unwrapped
