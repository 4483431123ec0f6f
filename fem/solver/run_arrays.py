"""All arrays of a run: which of them it changes, which the model determines, what is looked at before they are used."""

import hashlib
from dataclasses import dataclass

import numpy as np

from fem.kernels.fields import kind_of
from fem.kernels.lanes import WIDTH
from fem.kernels.state import Bodies, Contacts, DiscSurface, Drive, Pair, RingSurface, Scratch


@dataclass(frozen=True, kw_only=True)
class Arrays:
    """All state of a run: what the kernels change in place."""

    bodies: Bodies
    groups: tuple[tuple[Pair, ...], ...]  # pairs of bodies; see `fem.kernels.jit.every`
    contacts: Contacts
    drive: Drive
    scratch: Scratch

    def named(self) -> dict[str, np.ndarray]:
        """Every array that a run changes, once, by where it stands; surfaces and pairs share those of bodies."""
        return {name: array for name, (array, given) in self._all().items() if not given}

    def digest(self) -> str:
        """Of the arrays that the model determines, which no run changes."""
        text = hashlib.sha256()
        for name, (array, given) in self._all().items():
            if given:
                text.update(f"{name} {array.dtype} {array.shape} ".encode() + array.tobytes())
        return text.hexdigest()

    @property
    def nbytes(self) -> int:
        """Of the arrays that a run changes, and of those that each step fills."""
        return sum(getattr(array, "nbytes", 0) for array in (*self.named().values(), *self.scratch))

    def _all(self) -> dict[str, tuple[np.ndarray, bool]]:
        """Every array that outlives a step, and whether the model determines it."""
        found: dict[str, tuple[np.ndarray, bool]] = {}
        for name in ("bodies", "contacts", "drive"):
            _collect(getattr(self, name), name, found)
        return found

    def check(self) -> None:
        """Refuse places in arrays that are outside of them: kernels look there unseen; springs that push when pulled.

        Errors
        ------
        ValueError.
        """
        patches, points, shear = self.contacts.patches, self.contacts.points, self.contacts.friction.shear
        for pair in (pair for group in self.groups for pair in group if hasattr(pair, "row")):
            sides = pair.surface or self.bodies.surface, self.bodies.surface
            for side, surface in enumerate(sides):
                _check_between("patches.start", patches.start[2 * pair.row + side], getattr(surface, "n_nodes", 1) - 1)
                _check_between("patches.place", patches.place[2 * pair.row + side], _last_place(surface))
        if points is not None and points.spread is not None:
            closed, most = points.spread.closed, points.closing.size
            _check_between("closed", closed[..., 0], closed[..., 1])
            _check_between("closed", closed[..., 1], most)
        if shear is not None and np.any(shear.compliance <= 0.0):
            raise ValueError("springs without a compliance")


def _last_place(surface: tuple) -> int:
    """The last place in a surface's arrays where a node may stand, with what is read beside and behind it."""
    if isinstance(surface, RingSurface):
        return surface.u.size - surface.cosines.size - WIDTH
    return surface.u.size - surface.columns - 1 if isinstance(surface, DiscSurface) else 0


def changing_arrays(group: tuple, place: str) -> dict[str, np.ndarray]:
    """Every array of a named tuple, and of those in it, that a run changes, by where it stands."""
    found: dict[str, tuple[np.ndarray, bool]] = {}
    _collect(group, place, found)
    return {name: array for name, (array, given) in found.items() if not given}


def _collect(group: tuple, place: str, found: dict[str, tuple[np.ndarray, bool]]) -> None:
    """By the fields' declarations; an array without one is given if it holds places in arrays, whole numbers."""
    for name, entry in zip(getattr(group, "_fields", range(len(group))), group, strict=True):
        if isinstance(entry, np.ndarray):
            kind = kind_of(group, name) or ("state" if entry.dtype.kind == "f" else "given")
            if kind != "room" and not any(entry is other for other, _ in found.values()):
                found[f"{place}.{name}"] = entry, kind == "given"
        elif isinstance(entry, tuple):
            _collect(entry, f"{place}.{name}", found)


def _check_between(name: str, found: np.ndarray, most: np.ndarray | int) -> None:
    if np.any(found < 0) or np.any(found > most):
        raise ValueError(f"{name} lies outside of its array")
