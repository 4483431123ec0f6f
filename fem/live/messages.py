"""What player and page tell each other, as JSON.

The page: `Wish`. The player: {"bearing": facts of a run that begins}, {"frame": an instant}, {"refused": a sentence},
{"telling": a sentence, or "" where it holds no more}, {"pace": how fast it plays}.
"""

import json
from math import pi
from typing import Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from fem.errors import UsageError
from fem.live.controls import Values
from fem.live.player import FROM_LOAD, Player
from lagrange.kinematics import OUTER_RING, kinematics
from lagrange.messages import G
from lagrange.mounting import from_outer_ring
from lagrange.scene.surfaces import own_radius
from lagrange.surface.faults import Spall

MM, UM, MPA = 1e-3, 1e-6, 1e6
FASTEST, SLOWEST = 1.0, 2000.0  # seconds of wall time per simulated second; a frame of the slowest holds two samples
LINES = {  # of the spectrum, by `Kinematics.frequencies`
    "shaft": "turns of the shaft",
    OUTER_RING: "turns of the outer ring",
    "FTF": "turns of the set of rollers",
    "BSF": "turns of a roller",
    "BPFO": "rollers passing a place of the outer ring",
    "BPFI": "rollers passing a place of the inner ring",
}


class Pace(BaseModel):
    """How a run is played."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)

    slowness: float = Field(50.0, ge=FASTEST, le=SLOWEST)
    playing: bool = True


class Wish(BaseModel):
    """What a page asks for; what is left out stays as it is."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)

    frame: bool = False  # the next one, when there is one
    step: bool = False  # `playing.STEP` further, where the run is paused
    values: Values | None = None
    pace: Pace | None = None


class Message(NamedTuple):
    """What the player tells, as JSON."""

    kind: str
    text: str


def message(kind: Literal["bearing", "frame", "refused", "telling", "pace"], content: object) -> Message:
    """One of those above."""
    return Message(kind, json.dumps({kind: content}, allow_nan=False, separators=(",", ":")))


def read_wish(text: str | bytes) -> Wish:
    """A page's message. UsageError: it is none."""
    try:
        return Wish.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise UsageError(f"{place}: {first['msg']}".removeprefix(": ")) from None


def bearing_message(player: Player) -> Message:
    """Facts of a run: lengths in mm, angles in rad, from +x; frequencies in Hz."""
    bearing, scene = player.bearing, player.scene
    spalls = [
        {
            "body": fault.body,
            "roller": fault.roller,
            "angle": fault.angle,
            "half": fault.half_opening(bearing.roller_radius) / own_radius(bearing, fault),
        }
        for fault in bearing.faults
        if isinstance(fault, Spall)
    ]
    frequencies = kinematics(bearing, *scene.ideal_operation().ring_speeds).frequencies
    facts = {
        "name": scene.name,
        "values": player.values.model_dump(),
        "given": player.given_values.model_dump(),
        "rollers": bearing.n_rollers,
        "roller": bearing.roller_radius / MM,
        "inner": bearing.inner_raceway_radius / MM,
        "outer": bearing.outer_raceway_radius / MM,
        "bore": bearing.core_radius / MM,
        "outside": bearing.outside_radius / MM,
        "spalls": spalls,
        "lines": [
            {"name": name, "frequency": value, "meaning": LINES[name]}
            for name, value in frequencies.items()
            if value > 0.0
        ],
        "faults": [{"name": name, "frequency": value} for name, value in player.fault_lines.items() if value > 0.0],
        "slices": None if (axial := scene.ideal_axial()) is None else _short(axial.centres(bearing) / MM),
        "length": bearing.roller_length / MM,
        "step": player.plan.time_step / UM,
        "interval": player.plan.interval / UM,
        "start": scene.numerics.start,
        "toml": scene.to_toml(),
    }
    return message("bearing", facts)


def frame_message(player: Player, slowness: float | None) -> Message:
    """An instant: ms, µm, N, MPa, rad, m/s², envelope in g; angles of rollers from the load, counter-clockwise.

    `slowness` : reached.
    """
    now, bearing = player.now, player.bearing
    from_load = np.remainder(now["roller_theta"] - FROM_LOAD + pi, 2.0 * pi) - pi
    frequency, amplitude = player.record.spectrum()
    bin_width, envelope, at_lines = player.record.envelope(player.fault_lines)
    shaft, ring = (speed * now["time"] for speed in player.scene.ideal_operation().ring_speeds)
    pressures = player.pressures()
    frame = {
        "time": float(now["time"]) * 1e3,
        "slowness": slowness,
        "hub": _short(np.array(from_outer_ring(now, "inner")) / UM),
        "shaft": float(np.remainder(shaft, 2.0 * pi)),
        "ring": float(np.remainder(ring, 2.0 * pi)),
        "angle": _short(from_load, 5),
        "rise": _short((now["roller_rho"] - bearing.pitch_radius) / UM),
        "turn": _short(np.remainder(player.turn, 2.0 * pi), 4),
        "inner": _short(now["inner_force"], 2),
        "outer": _short(now["outer_force"], 2),
        "pressures": None if pressures is None else _short(pressures / MPA, 0),
        "orbit": _short(player.record.orbit() / UM, 4),
        "frequency": _short(frequency, 1),
        "amplitude": [[float(f"{value:.4g}") for value in axis] for axis in amplitude],
        "envelope": {
            "bin": bin_width,
            "amplitude": [float(f"{value:.3g}") for value in envelope / G],
            "lines": {name: value / G for name, value in at_lines.items()},
        },
        "record": player.record.length * 1e3,
        "imbalance": player.imbalance,
        "balanced": player.is_balanced,
        "cautions": player.warnings,
    }
    return message("frame", frame)


def _short(values: np.ndarray, digits: int = 3) -> list:
    return np.round(values, digits).tolist()
