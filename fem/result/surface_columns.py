"""What a result file holds where surfaces are not perfect: sinkages, events of spalls, files of measured heights.

The first two follow from the samples alone, whichever solver they come from: events are found when a run ends, from all
samples in its file, and so are the same however often it was interrupted and resumed.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict

import h5py
import numpy as np

from lagrange.bearing import Bearing, Operation
from lagrange.kinematics import turned
from lagrange.mounting import from_outer_ring
from lagrange.profile import Turns, profiles
from lagrange.scene import Scene
from lagrange.spall_events import SpallEvent, spall_events
from lagrange.spall_passages import COLUMNS, HOUSING, find_passages, spalls
from lagrange.stored import SCENE_FILE

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


def with_sinkages(
    bearing: Bearing, operation: Operation, samples: Mapping[str, np.ndarray]
) -> Mapping[str, np.ndarray]:
    """Samples with the sinkage under each contact, where surfaces are not perfect."""
    surfaces = profiles(bearing)
    if surfaces is None:
        return samples
    inner_x, inner_y, x, y = from_outer_ring(samples, "inner", "roller")
    turn = turned(bearing, operation, samples["time"][:, None]).shaft
    turns = Turns(inner_ring=turn, rollers=samples["roller_turn"])
    from_hub = np.arctan2(y - inner_y[:, None], x - inner_x[:, None])
    found = {
        "inner_sinkage": surfaces.inner(from_hub, turns).sinkage,
        "outer_sinkage": surfaces.outer(np.arctan2(y, x), turns).sinkage,
    }
    return {**samples, **found}


def write_scene_files(file: h5py.File, scene: Scene) -> None:
    """The text of each file that the scene names, so that the result can be read without them."""
    for number, text in enumerate(scene.files.values()):
        content = np.frombuffer(text.encode(), dtype=np.uint8)
        variable = file.create_dataset(SCENE_FILE.format(number), data=content)
        variable.attrs["units"], variable.attrs["long_name"] = "1", "text of a file that the scene names, UTF-8"


def events_of(bearing: Bearing, operation: Operation, file: h5py.File, count: int) -> list[SpallEvent]:
    """Events of the first `count` samples of an open result file."""
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
