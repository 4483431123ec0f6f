"""Numbers of a result file that a picture is made of: read guarded each time, and refused where no bearing moves so."""

from pathlib import Path

import h5py
import numpy as np

from fem.errors import UsageError
from fem.result.fields import read_frame, read_values, stored_samples
from lagrange import Bearing
from lagrange.equations import farthest_place
from lagrange.files.hdf5 import Damaged, has, read_numbers, read_scene_files, read_scene_text, refusal_in_child

FORCES = ("inner_force", "outer_force", "roller_roller_force")
PER_TIME = ("inner_x", "inner_y", "energy_elastic", "energy_contact")
OF_CAGE = ("cage_x", "cage_y", "cage_angle")  # where the scene has one
PER_ROLLER = ("roller_x", "roller_y", "roller_spin", "inner_traction", "outer_traction", *FORCES)
PLACES = ("inner_x", "inner_y", "roller_x", "roller_y", "cage_x", "cage_y")
READ_SECONDS, READ_RATE = 10.0, 20e6  # of processor time to read a file: at least, and B/s
READ_MEMORY, READ_COPIES = 2**29, 2  # bytes to read a file: at least, and times its size
FASTEST = 1e5  # m/s, of a roller's surface: as in the time loop
LARGEST = 1e15  # SI: far above any force and energy of a bearing


class StoredValues:
    """The variables of a result file's committed samples, and the instants of which it holds fields.

    Errors
    ------
    UsageError: no such file, not a result file, damaged, nothing in it yet.
    """

    def __init__(self, path: Path):
        self._path = path
        if not path.is_file():
            raise UsageError(f"{path}: no such result file; run run-fem first, or name another")
        size = path.stat().st_size
        seconds, memory = READ_SECONDS + size / READ_RATE, READ_MEMORY + READ_COPIES * size
        refusal = refusal_in_child(lambda: self._read(_survived), str(path), seconds, memory)
        if refusal is not None:
            raise UsageError(refusal)
        self.times, self.scene_text, self.scene_files, self.frames = self._read(_opened)
        self.attributes, self.names = self._read(lambda file: (dict(file.attrs), set(file)))
        self._columns: dict[str, np.ndarray] = {}

    def column(self, name: str) -> np.ndarray:
        """A variable at all samples, places from the housing's; kept: every picture of a film asks for it."""
        if name not in self._columns:
            self._columns[name] = self._read(lambda file: _from_housing(file, name, len(self.times)))
        return self._columns[name]

    def samples(self, name: str) -> np.ndarray:
        """A variable at all samples, as it is stored."""
        return self._read(lambda file: read_numbers(file, name, len(self.times)))

    def frame(self, index: int, model, turns: tuple[float, float]):
        """The fields of one instant, of rings turned so far, rad."""
        return self._read(lambda file: read_frame(file, model, index, turns))

    def check(self, bearing: Bearing, has_cage: bool) -> None:
        """Refuse samples that are not of such a bearing, with a cage or without.

        Errors
        ------
        UsageError: other shapes, numbers that are none or absurd, bodies nowhere near their places, time that falls.
        """
        try:
            self._check(bearing, has_cage)
        except Damaged as error:
            raise UsageError(f"{self._path}: damaged: {error}") from None

    def _check(self, bearing: Bearing, has_cage: bool) -> None:
        count, pitch = len(self.times), bearing.pitch_radius
        farthest = farthest_place(bearing)
        _check_numbers("time", self.times, LARGEST, self.times)
        if np.any(np.diff(self.times) <= 0.0):
            raise Damaged("time does not rise")
        limits = dict.fromkeys((*PER_TIME, *PER_ROLLER), LARGEST)
        limits |= {"roller_spin": FASTEST / bearing.roller_radius, "inner_x": farthest, "inner_y": farthest}
        if has_cage:
            limits |= {"cage_x": pitch, "cage_y": pitch, "cage_angle": LARGEST}  # loose ones go far
        for name, limit in limits.items():
            values, wanted = self.column(name), (count, bearing.n_rollers)[: 2 if name in PER_ROLLER else 1]
            if values.shape != wanted:
                raise Damaged(f"its scene has {bearing.n_rollers} rollers, {name} has shape {values.shape}")
            _check_numbers(name, values, limit, self.times)
        rho = np.hypot(self.column("roller_x"), self.column("roller_y"))
        if np.abs(rho - pitch).max() > farthest:
            raise Damaged(f"a roller is more than {farthest:.4g} m off the pitch circle")

    def _read(self, what):
        """Something of the open file; every way it can be unusable becomes a UsageError."""
        try:
            with h5py.File(self._path, "r", locking=False) as file:
                return what(file)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise UsageError(f"{self._path}: not a result file of run-fem, or damaged: {error}") from None
        except (OSError, RuntimeError) as error:
            raise UsageError(f"{self._path}: can't be read as a result file (HDF5): {error}") from None


def _opened(file) -> tuple[np.ndarray, str, dict[str, str], np.ndarray]:
    """Times, scene, its files and samples with fields of a file all of whose variables are sound."""
    count = int(file.attrs["committed_samples"])
    if count < 1:
        raise Damaged("it holds no sample yet")
    times = read_numbers(file, "time", count)
    for name in (*PER_TIME, *PER_ROLLER, *(name for name in OF_CAGE if has(file, name))):
        read_numbers(file, name, count)
    return times, read_scene_text(file), read_scene_files(file), stored_samples(file, count)


def _from_housing(file, name: str, count: int) -> np.ndarray:
    """A variable, of which what a housing moves is taken off places."""
    values, moved = read_numbers(file, name, count), f"housing_{name[-1]}"
    if name not in PLACES or moved not in file:
        return values
    return (values.T - read_numbers(file, moved, count)).T


def _survived(file) -> None:
    """The child's part: everything that will be read here."""
    *_, frames = _opened(file)
    for index in range(len(frames)):
        read_values(file, None, index)


def _check_numbers(name: str, values: np.ndarray, limit: float, times: np.ndarray) -> None:
    bad = ~(np.abs(values) <= limit)
    if bad.any():
        where = tuple(np.argwhere(bad)[0])
        raise Damaged(f"{name} is {values[where]:g} at {1e3 * times[where[0]]:.6g} ms, at most {limit:.4g} can be")
