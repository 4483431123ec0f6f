"""What a result file gains beside the run's columns: error estimates, and facts of imperfect surfaces."""

import json
import shutil
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np

from fem.result.durable import alone_in
from lagrange.bearing import Bearing, Operation
from lagrange.files.hdf5 import SCENE_FILE, hdf5_to_write
from lagrange.files.output import real_path, replaced
from lagrange.scene.scene import Scene
from lagrange.surface.passages import COLUMNS, HOUSING, SpallEvent, find_passages, spall_events, spalls, surfaces_met

if TYPE_CHECKING:
    from fem.solver.errors import Estimate

ESTIMATE = {  # meaning, and value of an `Estimate`
    "quantity": ("name of a quantity of interest", lambda each: each.quantity.name),
    "quantity_unit": ("unit of its value and error", lambda each: each.quantity.unit),
    "quantity_meaning": ("what it is", lambda each: each.quantity.meaning),
    "quantity_value": ("on the run's mesh", lambda each: each.quantity.value),
    "quantity_coarse_value": ("on the coarser mesh", lambda each: each.coarse_value),
    "quantity_error": ("estimated discretisation error of the value, not negative", lambda each: each.error),
}


def write_estimates(path: Path, found: "list[Estimate]", coarse_mesh_size: float) -> None:
    """Add error estimates to a finished result file, which is exchanged for one that has them.

    Parameters
    ----------
    coarse_mesh_size : of the coarser run, m

    Errors
    ------
    OSError: no room for a second file; the first stays as it is.
    """
    path = real_path(path)
    with alone_in(path.parent), replaced(path, durable=True) as part:
        shutil.copyfile(path, part)
        with hdf5_to_write(part, "r+") as file:
            _add(file, found, coarse_mesh_size)


def _add(file: h5py.File, found: "list[Estimate]", coarse_mesh_size: float) -> None:
    for name in reversed(ESTIMATE):  # of an earlier estimate
        if name in file:
            del file[name]
    for name, (meaning, value) in ESTIMATE.items():
        variable = file.create_dataset(name, data=[value(each) for each in found])
        variable.attrs["long_name"] = meaning
    file["quantity"].make_scale("quantity")
    for name in ESTIMATE:
        if name != "quantity":
            file[name].dims[0].attach_scale(file["quantity"])
    file.attrs["coarse_mesh_size"] = coarse_mesh_size


def read_columns(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """All committed samples of some variables."""
    with h5py.File(path, "r") as file:
        count = int(file.attrs["committed_samples"])
        return {name: file[name][:count] for name in names}


EVENTS = "events"
WORDS = h5py.string_dtype()
EVENT_COLUMNS = {  # type, unit and meaning
    "time": ("<f8", "s", "instant"),
    "roller": ("<i8", "1", "roller"),
    "spall": ("<i8", "1", "spall, in the order of the attribute spalls"),
    "raceway": (WORDS, "1", "whose contact passes the spall: inner, outer"),
    "kind": (WORDS, "1", "entry, strike, exit"),
    "force": ("<f8", "N", "normal force of the contact"),
    "sliding_speed": ("<f8", "m/s", "roller's surface over the raceway's, along +theta"),
}


def sinkages(bearing: Bearing, operation: Operation, samples: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of the sinkage under each contact of surfaces that are not perfect."""
    met = zip(("inner", "outer"), surfaces_met(bearing, operation, samples), strict=True)
    return {f"{side}_sinkage": each.sinkage + each.part_sinkage for side, each in met}


def write_scene_files(file: h5py.File, scene: Scene) -> None:
    """The text of each file that the scene names, so that the result can be read without them."""
    for number, text in enumerate(scene.files.values()):
        content = np.frombuffer(text.encode(), dtype=np.uint8)
        variable = file.create_dataset(SCENE_FILE.format(number), data=content)
        variable.attrs["units"], variable.attrs["long_name"] = "1", "text of a file that the scene names, UTF-8"


def events_of(bearing: Bearing, operation: Operation, file: h5py.File, count: int) -> list[SpallEvent]:
    """Events of the first `count` samples of an open result file.

    They follow from the samples alone, whichever solver these come from, and are found when a run ends: they are the
    same however often it was interrupted and resumed.
    """
    names = [name for name in (*COLUMNS, *HOUSING) if name in file]
    return spall_events(
        find_passages(bearing, operation, lambda start, stop: {name: file[name][start:stop] for name in names}, count)
    )


def write_events(file: h5py.File, bearing: Bearing, events: list[SpallEvent]) -> None:
    """The group `events`, one row an event; its attribute `spalls` tells what they are, SI."""
    group = file.create_group(EVENTS)
    group.attrs["spalls"] = json.dumps([asdict(spall) for spall in spalls(bearing)])
    number = group.create_dataset("event", data=np.arange(len(events), dtype="<i8"))
    number.attrs["units"], number.attrs["long_name"] = "1", "event, by time"
    number.make_scale("event")
    for name, (kind, unit, meaning) in EVENT_COLUMNS.items():
        column = group.create_dataset(name, data=[getattr(event, name) for event in events], dtype=kind)
        column.attrs["units"], column.attrs["long_name"] = unit, meaning
        column.dims[0].attach_scale(number)
