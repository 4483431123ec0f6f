"""States that a compiled time loop advances: its rows are looked at as they come, read as the result's quantities."""

import time
from abc import abstractmethod
from collections.abc import Collection

import numpy as np

from fem.kernels import columns as row
from fem.kernels.fields import kind_of
from fem.kernels.mounts import DONE
from fem.solver import guards
from fem.solver.simulate import LARGEST_BLOCK, size_of_block
from fem.solver.solver import Block, Plan, RunState, Samples
from lagrange.bearing import Cage
from lagrange.columns import PER_ROLLER, columns_of
from lagrange.errors import UsageError
from lagrange.mounting import ENERGIES, HELD, Mounting, from_outer_ring

LONGEST_UNWATCHED = 100  # steps between two looks at the energy
TURN = 2.0 * np.pi


def row_places(n_rollers: int, parts: Collection[str] = ()) -> dict[str, int | slice]:
    """Where a row of the time loops holds each column: those of `columns`, then those of a scene's parts."""
    places: dict[str, int | slice] = {name: i for i, name in enumerate(row.SCALARS)}
    at, further = row.N_SCALARS, {name: column.dimensions for name, column in columns_of(*parts).items()}
    for name, dimensions in (dict.fromkeys(row.BLOCKS, PER_ROLLER) | further).items():
        size = n_rollers if dimensions == PER_ROLLER else 0
        places[name] = slice(at, at + size) if size else at
        at += size or 1
    return places


def row_width(n_rollers: int, cage: Cage | None, mounting: Mounting = HELD) -> int:
    """Numbers in a sample of the time loops."""
    return _width(row_places(n_rollers, (*mounting.parts, *(() if cage is None else ("cage",)))))


def _width(places):
    return 1 + max(at.stop - 1 if isinstance(at, slice) else at for at in places.values())


class SampleReader:
    """Reads blocks of rows, `plan.looks` a sample, in order; carries what runs on from block to block.

    How the rows are cut into blocks, which is a matter of the wall clock, changes no bit of any quantity.
    """

    def __init__(self, plan):
        self.plan, self.count = plan, 0
        further = [part for part in plan.scene.parts if part not in row.IN_EVERY_ROW]
        self._places = row_places(plan.bearing.n_rollers, further)
        self.width = _width(self._places)  # of a row
        self.angle = np.array(plan.first_angle)  # of the last row
        self.base = np.full(4, np.nan)  # J, of the first row: works, dissipated, moved and stored energy
        self.account = guards.EnergyAccount()

    def read(self, rows: np.ndarray) -> Samples:
        """Quantities of the next rows."""
        values = {name: rows[:, place].copy() for name, place in self._places.items()}  # each is read several times
        x, y = from_outer_ring(values, "roller")
        works = values["work_load"] + values["work_gravity"] + values["work_drive"]
        stored = values["energy_elastic"] + values["energy_contact"]
        moved = values["energy_kinetic"] + sum(values[name] for name in ENERGIES if name in values)
        if self.count == 0:
            self.base[:] = works[0], values["work_dissipated"][0], moved[0], stored[0]
        at_start, gained, wrapped = self.base, moved - self.base[2], np.arctan2(y, x)
        turns, jumped = np.round((self.angle - wrapped[0]) / TURN), np.diff(wrapped, axis=0)
        angle = wrapped + TURN * turns
        for sample, roller in np.argwhere(np.abs(jumped) > np.pi):  # few
            turns[roller] -= np.round(jumped[sample, roller] / TURN)
            angle[sample + 1 :, roller] = wrapped[sample + 1 :, roller] + TURN * turns[roller]
        self.angle[:] = angle[-1]
        values |= {
            "time": (self.count + np.arange(len(rows))) / self.plan.looks * self.plan.interval,
            "roller_rho": np.hypot(x, y), "roller_theta": angle,
            "work_external": works - at_start[0], "work_dissipated": values["work_dissipated"] - at_start[1],
        }  # fmt: skip
        self.count += len(rows)
        imbalance = gained + (stored - at_start[3]) - values["work_external"] + values["work_dissipated"]
        exchanged = np.fmax(stored - self.plan.pressed_energy, np.abs(gained))
        return self.account.samples(values, imbalance, exchanged)


class RowState(RunState):
    """Arrays that kernels change in place, and the reader of their rows.

    Its plan has `looks` at the energy per sample, `stride` steps between samples, and what `guards` ask of it.
    """

    def __init__(self, plan: Plan):
        super().__init__(plan)
        self.begin()

    def begin(self) -> None:
        """Stand at the start of the plan."""
        self.reader = SampleReader(self.plan)
        self.largest = np.zeros(3)  # N, so far: see `largest_forces`
        self.energy_error, self.energy_scale = np.zeros(1), np.zeros(1)  # J, the largest, and what it is measured by
        self._out_of_place = False  # whether the last block ended because bodies were out of place

    @abstractmethod
    def named_arrays(self) -> dict[str, np.ndarray]:
        """Every array that a run changes and the next steps need, once, as views."""

    @abstractmethod
    def step_rows(self, first: int, stride: int, rows: np.ndarray) -> tuple[int, int, int]:
        """From step `first` on fill rows, one each `stride` steps: the kernel's status, and step and body where it is
        not DONE."""

    def check(self) -> None:
        """Refuse arrays that kernels can't take. ValueError."""

    def frame(self):
        """The fields at the next sample, which the scene asks for."""
        return None

    @abstractmethod
    def digest(self) -> str:
        """Of all that the steps need and no run changes."""

    def take_steps(self, n_rows: int, before: int = 0) -> tuple[np.ndarray, int, int, int]:
        """Advance the arrays by so many rows: them, the kernel's status, and step and body where it is not DONE.

        `before`: rows since the last sample.
        """
        plan = self.plan
        rows, stride = np.zeros((n_rows, self.reader.width)), plan.stride // plan.looks
        return rows, *self.step_rows(self.done * plan.stride + before * stride, stride, rows)

    def _take_long_sample(self):
        """One sample in parts, between which the run can be stopped: then None, and the arrays are as before."""
        looks, kept = self.plan.looks, {name: array.copy() for name, array in self.named_arrays().items()}
        whole, done, size = np.zeros((looks, self.reader.width)), 0, 1
        while True:
            began = time.perf_counter()
            rows, status, step, body = self.take_steps(min(size, looks - done), done)
            whole[done : done + len(rows)] = rows
            done += len(rows)
            if status != DONE or done == looks:
                return whole[:done], status, step, body
            if self.stop():
                for name, array in self.named_arrays().items():
                    array[...] = kept[name]
                return None
            size = size_of_block(size, len(rows), time.perf_counter() - began)

    def advance(self, most):
        plan, frame = self.plan, None
        most = min(most, LARGEST_BLOCK // plan.looks or 1)
        if plan.frame_stride:  # between two samples the state is that of the one to come
            since = self.done % plan.frame_stride
            most = min(most, plan.frame_stride - since)
            if since == 0:
                frame = self.frame()
        with self.timed():
            taken = self._take_long_sample() if most == 1 < plan.looks else self.take_steps(plan.looks * most)
        if taken is None:
            return Block()
        rows, status, step, body = taken
        samples, trouble, self._out_of_place = None, None, False
        if status != DONE:
            good = np.all(np.isfinite(rows), axis=1) & np.any(rows != 0.0, axis=1)  # finite, and filled
            rows = rows if good.all() else rows[: int(np.argmin(good))]
            trouble = self.velocity_trouble(step, body, len(rows))
        if len(rows):
            looked = self.read(rows)
            count, trouble = self.sound_part(looked, trouble)
            sound = looked.at(slice(count))
            self.largest[:] = np.maximum(self.largest, guards.largest_forces(sound))
            if count:
                self.energy_error[0] = max(self.energy_error[0], np.abs(sound.error).max())
                self.energy_scale[0] = sound.energy_scale[-1]
            samples = sound.at(slice(None, None, plan.looks))
            self.done += len(samples)
        return Block(samples=samples, frame=frame, trouble=trouble)

    def read(self, rows: np.ndarray) -> Samples:
        return self.reader.read(rows)

    def velocity_trouble(self, step: int, body: int, n_good: int) -> str:
        """What to say of a velocity that is no number, of a roller or the hub (below 0), after so many good rows."""
        plan, name = self.plan, "the hub" if body < 0 else f"roller {body}"
        hint = f"{plan.model.failure_hint}lower numerics.time_step_safety or check the load"
        return f"the velocity of {name} is not finite at step {step}, t = {1e3 * step * plan.time_step:.5g} ms; {hint}"

    def sound_part(self, looked: Samples, trouble: str | None) -> tuple[int, str | None]:
        """How many of the next samples are sound, and why no more are; `trouble` : after all of them."""
        plan, bearing = self.plan, self.plan.bearing
        give = guards.ASTRAY * bearing.roller_radius + plan.model.give(plan.operation.heaviest)
        balanced, in_place = guards.n_balanced(looked), guards.n_in_place(bearing, give, looked)
        self.imbalance = float(looked.relative_error()[min(balanced, len(looked) - 1)])
        self._out_of_place = in_place < balanced
        if self._out_of_place:
            hint = "without a cage a few rollers gather on one side: add a [cage], use more rollers or "
            if plan.scene.cage is not None:
                hint = "use a lighter load, more rollers, stiffer pockets of the cage or "
            reason = "the bearing has come apart", f"{hint}contact.friction_coefficient above 0"
            trouble = guards.place_trouble(bearing, plan.time_step, looked, in_place, *reason)
        elif balanced < len(looked):
            trouble = guards.energy_trouble(plan.time_step, plan.start.kinematics.roller, plan.finer, looked, balanced)
        return min(balanced, in_place), trouble

    @property
    def warnings(self):
        found, error, energy_scale = (
            guards.run_warnings(self.plan.bearing, self.largest),
            self.energy_error[0],
            self.energy_scale[0],
        )
        if error > guards.DOUBTFUL * energy_scale:
            found += (
                f"the energy balance is off by up to {100.0 * error / energy_scale:.2g} % of what is exchanged "
                f"({1e3 * energy_scale:.3g} mJ): the motion may be off by as much; {self.plan.finer}",
            )
        return found

    def kept_arrays(self) -> dict[str, np.ndarray]:
        """What a checkpoint keeps, as views: the arrays of the loop and of all that watches them."""
        reader, account = self.reader, self.reader.account.sums
        watched = {"largest": self.largest, "energy_error": self.energy_error, "energy_scale": self.energy_scale}
        return self.named_arrays() | watched | {"angle": reader.angle, "base": reader.base, "account": account}

    def to_keep(self):
        return self.kept_arrays(), {"model": self.digest()}

    def take_back(self, arrays, numbers):
        if numbers["model"] != self.digest():
            raise UsageError(
                "its meshes and matrices are not those computed here; go on where it was written, or start again "
                "without --resume"
            )
        for name, own in self.kept_arrays().items():
            own[...] = arrays[name]
        self.reader.count = self.done * self.plan.looks
        if self.done and np.isnan([*self.reader.base, *self.reader.account.sums]).any():
            raise ValueError(f"nothing of {self.done} samples")
        if np.any(self.largest < 0.0):
            raise ValueError("forces that pull")
        self.check()


def collect_arrays(groups: dict[str, tuple]) -> dict[str, tuple[np.ndarray, bool]]:
    """Every array of named tuples, and of those in them, that outlives a step, once, by where it stands; and whether
    the model determines it.

    By the fields' declarations; an array without one is given if it holds places in arrays, whole numbers.
    """
    found: dict[str, tuple[np.ndarray, bool]] = {}

    def collect(group, place):
        for name, entry in zip(getattr(group, "_fields", range(len(group))), group, strict=True):
            if isinstance(entry, np.ndarray):
                kind = kind_of(group, name) or ("state" if entry.dtype.kind == "f" else "given")
                if kind != "room" and not any(entry is other for other, _ in found.values()):
                    found[f"{place}.{name}"] = entry, kind == "given"
            elif isinstance(entry, tuple):
                collect(entry, f"{place}.{name}")

    for place, group in groups.items():
        collect(group, place)
    return found
