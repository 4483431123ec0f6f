"""A result file as it is read: scene, columns by name, frames of fields; refused where it is foreign or damaged."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fem.result.fields import read_frame, stored_samples
from fem.result.layout import variables_of
from lagrange.errors import UsageError
from lagrange.files.hdf5 import Damaged, check_array, has, read_numbers, read_scene_files, read_scene_text
from lagrange.scene.scene import Scene, parse_stored_scene

NEEDED = ("time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_spin", "inner_force", "outer_force")
PLACES = ("inner_x", "inner_y", "roller_x", "roller_y", "cage_x", "cage_y")


class RunFile(Mapping[str, np.ndarray]):
    """Committed samples of a result file by name, in SI, time first; a column is read when it is asked for.

    Errors
    ------
    UsageError: no such file, not a result file, damaged, nothing in it yet; SceneError: its scene can't be used. Of a
    column that is damaged, when it is asked for.
    """

    def __init__(self, path: Path):
        self.path = path
        if not path.is_file():
            raise UsageError(f"{path}: no such result file; run run-fem first, or name another")
        self._columns: dict[str, np.ndarray] = {}
        self._count, text, files, self.attributes = self._read(_opened)
        self.scene: Scene = parse_stored_scene(text, f"{path}: its scene", files)
        self._names, self.frames = self._read(self._check)
        if np.any(np.diff(self["time"]) <= 0.0):
            raise UsageError(f"{path}: damaged: time does not rise")

    def _check(self, file: h5py.File) -> tuple[tuple[str, ...], np.ndarray]:
        """Names of its columns and samples of its frames, once all have the shapes that its scene asks for."""
        variables, rollers = variables_of(self.scene), self.scene.bearing.present
        names = tuple(name for name in variables if name in NEEDED or has(file, name))
        for name in names:
            shape = check_array(file, name, self._count).shape[1:]
            if shape != (rollers,)[: len(variables[name].dimensions) - 1]:
                raise Damaged(f"its scene has {rollers} rollers, {name} has shape {file[name].shape}")
        return names, stored_samples(file, self._count)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._names:
            raise KeyError(name)
        if name not in self._columns:
            self._columns[name] = values = self._read(lambda file: read_numbers(file, name, self._count))
            if len(bad := np.argwhere(~np.isfinite(values))):
                value, time = values[tuple(bad[0])], 1e3 * self["time"][bad[0][0]]
                raise UsageError(f"{self.path}: damaged: {name} is {value:g} at {time:.6g} ms")
        return self._columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def from_housing(self, name: str) -> np.ndarray:
        """A column; places as seen from a housing on springs, where there is one."""
        moved = f"housing_{name[-1]}"
        return (self[name].T - self[moved]).T if name in PLACES and moved in self else self[name]

    def frame(self, index: int, model, turns: tuple[float, float]):
        """The fields of one instant, of rings turned so far, rad."""
        return self._read(lambda file: read_frame(file, model, index, turns))

    def _read(self, what: Callable[[h5py.File], Any]) -> Any:
        """Something of the open file; every way it can be unusable becomes a UsageError."""
        try:
            with h5py.File(self.path, "r", locking=False) as file:
                return what(file)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise UsageError(f"{self.path}: not a result file of run-fem, or damaged: {error}") from None
        except (OSError, RuntimeError) as error:
            raise UsageError(f"{self.path}: can't be read as a result file (HDF5): {error}") from None


def _opened(file: h5py.File) -> tuple[int, str, dict[str, str], dict[str, Any]]:
    count = int(file.attrs["committed_samples"])
    if count < 1:
        raise Damaged("it holds no sample yet")
    return count, read_scene_text(file), read_scene_files(file), dict(file.attrs)
