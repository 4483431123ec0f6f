"""The scene file's [operation]: how the bearing is run, and what of that changes with time."""

from collections.abc import Iterator
from functools import lru_cache
from math import cos, pi, radians, sin
from typing import Any, Literal

import numpy as np
from pydantic import Field

from lagrange.bearing import Operation
from lagrange.limits import exceeds
from lagrange.load_history import TIME, Shape, joined, points_of, steady, turn_of
from lagrange.mounting import Shaft
from lagrange.scene.faults import Check, DecimalSign, Digest, FileName, FileText, Table

RPM = 2.0 * pi / 60.0
FROM_LOAD = -90.0  # degrees, of the direction of radial_load_N from +x
FASTEST, HEAVIEST = 200_000.0, 1e7  # rpm, N
TABLES = {
    "speed_table": (("speed_rpm",), FASTEST),
    "outer_ring_speed_table": (("speed_rpm",), FASTEST),
    "load_table": (("x_N", "y_N"), HEAVIEST),
}
FIRST_SPEEDS = {"speed_table": "speed_rpm", "outer_ring_speed_table": "outer_ring_speed_rpm"}  # keys in whose place
IN_PLACE_OF = FIRST_SPEEDS | {"load_table": "radial_load_N"}
ENOUGH = 1e-9  # relative: times and speeds that are the same


class OperationTable(Table):
    """Speeds and loads of the bearing."""

    speed_rpm: float = Field(
        4500.0, ge=-200_000.0, le=200_000.0, description="speed of the inner ring; positive: counter-clockwise"
    )
    outer_ring_speed_rpm: float = Field(
        0.0,
        ge=-200_000.0,
        le=200_000.0,
        description="speed of the outer ring about its fixed centre; positive: counter-clockwise",
    )
    radial_load_N: float = Field(2000.0, ge=0.0, le=1e7, description="load on the hub, along −y")
    inner_ring_and_shaft_kg: float = Field(
        0.078,
        gt=0.0,
        le=1e6,
        description="mass that moves with the hub, inner ring included; default 0.078, or if the ring is heavier: a "
        "steel ring and shaft of the given sizes",
    )
    gravity_m_s2: float = Field(9.81, ge=0.0, le=1000.0, description="gravity, along −y")
    first_roller_deg: float = Field(
        0.0, ge=-360.0, le=360.0, description="angle of roller 0 from the load (−y), counter-clockwise"
    )
    misalignment_mrad: float | None = Field(
        None,
        ge=-50.0,
        le=50.0,
        description="slope of the shaft in the plane of the load; positive: its +z end leans towards the load; "
        "default 0; with [axial]",
    )
    unbalance_g_mm: float | None = Field(
        None, ge=0.0, le=1e9, description="unbalance of the parts that turn with the inner ring; their mass includes it"
    )
    unbalance_deg: float | None = Field(
        None, ge=-360.0, le=360.0, description="angle of the heavy side at t = 0, from −y, counter-clockwise"
    )
    rotating_load_N: float | None = Field(
        None, ge=0.0, le=HEAVIEST, description="load on the hub that turns with a ring, added to the other loads"
    )
    rotating_load_with: Literal["inner_ring", "outer_ring"] | None = Field(
        None, description="the ring that the load turns with; default inner_ring"
    )
    rotating_load_deg: float | None = Field(
        None, ge=-360.0, le=360.0, description="its direction at t = 0, from −y, counter-clockwise"
    )
    shaft: Literal["rigid", "springs"] | None = Field(
        None,
        description="rigid: the bearing alone carries the shaft (default); springs: springs and dashpots from the "
        "hub to the ground carry it too",
    )
    shaft_stiffness_N_per_m: float | None = Field(
        None, ge=0.0, le=1e12, description="stiffness of the shaft's springs, along x and y; required with them"
    )
    shaft_damping_N_s_m: float | None = Field(
        None, ge=0.0, le=1e9, description="damping of the dashpots parallel to the springs; default 0"
    )
    speed_table: FileName | None = Field(
        None,
        description="CSV file next to the scene with the columns time_ms, speed_rpm (or time_s, speed_rad/s), instead "
        "of speed_rpm",
    )
    speed_table_sha256: Digest = None
    speed_table_decimal: DecimalSign = None
    speed_table_shape: Literal["smooth", "linear"] | None = Field(
        None, description="curve through the points: smooth (default) or straight lines"
    )
    speed_table_content: FileText = None
    outer_ring_speed_table: FileName | None = Field(
        None,
        description="CSV file next to the scene with the columns time_ms, speed_rpm, instead of outer_ring_speed_rpm",
    )
    outer_ring_speed_table_sha256: Digest = None
    outer_ring_speed_table_decimal: DecimalSign = None
    outer_ring_speed_table_shape: Literal["smooth", "linear"] | None = Field(
        None, description="curve through the points: smooth (default) or straight lines"
    )
    outer_ring_speed_table_content: FileText = None
    load_table: FileName | None = Field(
        None,
        description="CSV file next to the scene with the columns time_ms, x_N, y_N (or time_s, x_kN, y_kN), instead "
        "of radial_load_N",
    )
    load_table_sha256: Digest = None
    load_table_decimal: DecimalSign = None
    load_table_shape: Shape | None = Field(
        None,
        description="curve through the points: smooth (default), straight lines, or steps held until the next row",
    )
    load_table_content: FileText = None

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Tables say what the speed is at the start, and the whole load."""
        defaults = {"radial_load_N": 0.0} if data.get("load_table") is not None else {}
        for name, key in FIRST_SPEEDS.items():
            if isinstance(data.get(f"{name}_content"), str):
                try:
                    decimal = data.get(f"{name}_decimal") or "."
                    shape = data.get(f"{name}_shape") or "smooth"
                    defaults[key] = _first_speed(data[f"{name}_content"], decimal, shape)
                except (ValueError, TypeError):  # a decimal sign that is no text
                    pass  # refused by `_tables`
        return defaults | data

    def checks(self) -> tuple[Check, ...]:
        return self._angles, self._shaft, self._tables

    def _shaft(self) -> Iterator[str]:
        if self.shaft == "springs":
            if self.shaft_stiffness_N_per_m is None:
                yield 'shaft = "springs" needs shaft_stiffness_N_per_m, e.g. 1e7'
            return
        for name in ("shaft_stiffness_N_per_m", "shaft_damping_N_s_m"):
            if getattr(self, name) is not None:
                yield f'{name} = {getattr(self, name):g}: only with shaft = "springs"; give that, or leave it out'

    def springs(self) -> Shaft | None:
        """What holds the shaft beside the bearing, in SI; None: nothing."""
        stiffness = self.shaft_stiffness_N_per_m
        if self.shaft != "springs" or stiffness is None:
            return None
        return Shaft(stiffness=stiffness, damping=self.shaft_damping_N_s_m or 0.0)

    def _angles(self) -> Iterator[str]:
        for of, angle in (("unbalance_g_mm", "unbalance_deg"), ("rotating_load_N", "rotating_load_deg")):
            if getattr(self, angle) is not None and getattr(self, of) is None:
                yield f"{angle} = {getattr(self, angle):g}: give {of} too, or leave it out"
        if self.rotating_load_with is not None and self.rotating_load_N is None:
            yield f'rotating_load_with = "{self.rotating_load_with}": give rotating_load_N too, or leave it out'

    def _tables(self) -> Iterator[str]:
        for name in TABLES:
            for key in (f"{name}_sha256", f"{name}_decimal", f"{name}_shape"):
                if getattr(self, key) is not None and getattr(self, name) is None:
                    yield f"{key}: give {name} too, or leave it out"
            try:
                self.points(name)
            except ValueError as error:
                yield f'{name} = "{getattr(self, name)}": {error}'
                return
        if self.load_table is not None and self.radial_load_N > 0.0:
            yield (
                f'radial_load_N = {self.radial_load_N:g}: load_table = "{self.load_table}" is the whole load; leave '
                "out one of them"
            )
        for name, key in FIRST_SPEEDS.items():
            content, given = getattr(self, f"{name}_content"), getattr(self, key)
            if content is None:
                continue
            decimal, shape = getattr(self, f"{name}_decimal") or ".", getattr(self, f"{name}_shape") or "smooth"
            first = _first_speed(content, decimal, shape)
            if abs(first - given) > ENOUGH * max(abs(first), 1.0):
                yield (f'{key} = {given:g}: {name} = "{getattr(self, name)}" starts at {first:g}; leave {key} out')

    def points(self, name: str) -> tuple[np.ndarray, np.ndarray] | None:
        """Times and values of a table, as they stand there; None: there is none, or it is not at hand. ValueError."""
        content = getattr(self, f"{name}_content")
        if content is None:
            return None
        return points_of(content, *TABLES[name], decimal=getattr(self, f"{name}_decimal") or ".")

    def duration_faults(self, duration: float) -> Iterator[str]:
        """Tables that end before the run does, ms."""
        for name in TABLES:
            found = self.points(name)
            if found is not None and exceeds(duration, found[0][-1]):
                yield (
                    f'operation.{name} = "{getattr(self, name)}": it ends at {TIME} = {found[0][-1]:g}, before the run '
                    f"(numerics.duration_ms = {duration:g}); give more rows, or shorten the run"
                )

    @property
    def changes(self) -> str | None:
        """The key of something that changes with time; None: nothing does."""
        named = [name for name in TABLES if getattr(self, name) is not None]
        turning = ("outer_ring_speed_rpm", "unbalance_g_mm", "rotating_load_N")
        return next(iter((*named, *(name for name in turning if getattr(self, name)))), None)

    @property
    def turns_outer_ring(self) -> str | None:
        """The key by which the outer ring turns; None: it stands still."""
        keys = ("outer_ring_speed_table", "outer_ring_speed_rpm")
        return next((key for key in keys if getattr(self, key)), None)

    @property
    def files(self) -> dict[str, str]:
        """Texts of the tables by their digests, as far as they are at hand."""
        found = ((getattr(self, f"{name}_sha256"), getattr(self, f"{name}_content")) for name in TABLES)
        return {digest: content for digest, content in found if content is not None}

    def ideal(self) -> Operation:
        """The operating point in SI, at the start, and how it goes on; angles from +x.

        Errors
        ------
        ValueError: a table is not at hand.
        """
        return _ideal(self)


@lru_cache(maxsize=16)
def _ideal(o: OperationTable) -> Operation:
    found = Operation(
        speed=o.speed_rpm * RPM,
        radial_load=o.radial_load_N,
        inner_mass=o.inner_ring_and_shaft_kg,
        gravity=o.gravity_m_s2,
        first_roller_angle=radians(o.first_roller_deg + FROM_LOAD),
        misalignment=1e-3 * (o.misalignment_mrad or 0.0),
    )
    if o.changes is None:
        return found
    functions = {
        "speed_table": steady(found.speed),
        "outer_ring_speed_table": steady(o.outer_ring_speed_rpm * RPM),
        "load_table": steady(0.0, -found.radial_load),
    }
    for name in TABLES:
        if getattr(o, name) is not None:
            points = o.points(name)
            if points is None:
                raise ValueError(f'operation: {name} = "{getattr(o, name)}" is not at hand')
            unit = RPM if name in FIRST_SPEEDS else 1.0
            functions[name] = joined(1e-3 * points[0], unit * points[1], getattr(o, f"{name}_shape") or "smooth")
    load, rotating, angle = functions["load_table"], o.rotating_load_N or 0.0, (o.rotating_load_deg or 0.0) + FROM_LOAD
    if o.rotating_load_with == "outer_ring" and o.turns_outer_ring is None:  # it stands with that ring
        load.c[-1] += rotating * cos(radians(angle)), rotating * sin(radians(angle))
        rotating = 0.0
    return found.going_on(
        turn=turn_of(functions["speed_table"]),
        outer_turn=None if o.turns_outer_ring is None else turn_of(functions["outer_ring_speed_table"]),
        load=load,
        unbalance=1e-6 * (o.unbalance_g_mm or 0.0),
        unbalance_angle=radians((o.unbalance_deg or 0.0) + FROM_LOAD),
        rotating_load=rotating,
        rotating_load_angle=radians(angle),
        rotating_load_with=o.rotating_load_with or "inner_ring",
    )


@lru_cache(maxsize=16)
def _first_speed(text: str, decimal: str, shape: Shape) -> float:
    """Speed of a table at t = 0, rpm. ValueError."""
    time, values = points_of(text, *TABLES["speed_table"], decimal=decimal)
    return float(joined(time, values, shape)(0.0)[0])
