"""Tables of the scene that say what the bearing stands in: [support] of the outer ring, [sensor]."""

from collections.abc import Iterator
from math import radians
from typing import Any, Literal

from pydantic import Field

from lagrange.mounting import Bore, Housing, Points, Sensor
from lagrange.scene.faults import Check, Table

THREE_POINTS = {"angles_deg": [0.0, 120.0, 240.0], "width_mm": 6.0}
PEDESTAL = {"mass_kg": 12.638, "stiffness_N_per_m": 15.1e6, "damping_N_s_m": 2210.7}
FIT = {"fit_clearance_um": 0.0}

OF_KINDS: dict[str, dict[str, Any]] = {
    "points": THREE_POINTS,
    "housing": PEDESTAL,
    "bore": FIT,
}  # keys that each kind needs, with their defaults
ALSO = {"housing": ("fit_clearance_um", "bore_stiffness_N_per_mm3"), "bore": ("bore_stiffness_N_per_mm3",)}  # may have
UM = 1e-6
PER_MM3 = 1e9


class SupportTable(Table):
    """Support of the outer ring.

    The defaults of a housing are those of a pedestal.

    Source: Sawalhi and Randall, Simulating gear and bearing interactions in the presence of faults, part I (2008).
    """

    kind: Literal["held", "points", "housing", "bore"] = Field(
        "held",
        description="held: by rigid ground all around; points: on arcs of the outside; housing: in a rigid mass on "
        "springs; bore: in a bore of the ground",
    )
    angles_deg: list[float] | None = Field(
        None, min_length=1, max_length=100, description="angles of the points from the load (−y); default 0, 120, 240"
    )
    width_mm: float | None = Field(
        None, gt=0.0, le=1e4, description="width of each point along the outside, at least two nodes; default 6"
    )
    mass_kg: float | None = Field(
        None, ge=1e-3, le=1e6, description="mass of the housing without the outer ring; default 12.638"
    )
    stiffness_N_per_m: float | None = Field(
        None, ge=1e3, le=1e12, description="stiffness of the housing's springs, along x and y; default 15.1e6"
    )
    damping_N_s_m: float | None = Field(
        None, ge=0.0, le=1e9, description="damping of the dashpots parallel to the springs; default 2210.7"
    )
    fit_clearance_um: float | None = Field(
        None,
        ge=-1000.0,
        le=1000.0,
        description="bore diameter minus outside diameter of the outer ring; negative: press fit; default 0 with a "
        "bore; a housing without it holds the ring all around",
    )
    bore_stiffness_N_per_mm3: float | None = Field(
        None, ge=1.0, le=1e5, description="pressure per deflection of the bore; default: that of a thick wall"
    )

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        kind = data.get("kind")
        return OF_KINDS.get(kind, {}) | data if isinstance(kind, str) else data

    def checks(self) -> tuple[Check, ...]:
        return self._of_other_kinds, self._of_a_fit, self._angles

    def _of_other_kinds(self) -> Iterator[str]:
        takers: dict[str, list[str]] = {}
        for kind, keys in OF_KINDS.items():
            for name in (*keys, *ALSO.get(kind, ())):
                takers.setdefault(name, []).append(f'"{kind}"')
        for name, kinds in takers.items():
            value = getattr(self, name)
            if value is not None and f'"{self.kind}"' not in kinds:
                yield f'{name} = {value}: only with kind = {" or ".join(kinds)}, not "{self.kind}"; leave it out'

    def _of_a_fit(self) -> Iterator[str]:
        if self.kind == "housing" and self.bore_stiffness_N_per_mm3 is not None and self.fit_clearance_um is None:
            yield (
                f"bore_stiffness_N_per_mm3 = {self.bore_stiffness_N_per_mm3}: only with fit_clearance_um, without "
                "which the ring is held all around; give that too, 0 for a bore as wide as the ring"
            )

    def _angles(self) -> Iterator[str]:
        for angle in self.angles_deg or ():
            if not -360.0 <= angle <= 360.0:
                yield f"angles_deg = {self.angles_deg}: {angle:g} is not between -360 and 360"

    def points(self) -> Points | None:
        """The points in SI."""
        if self.kind != "points":
            return None
        if self.angles_deg is None or self.width_mm is None:
            raise ValueError('kind = "points" without angles_deg or width_mm; leave None out')
        angles = tuple(radians(angle - 90.0) for angle in self.angles_deg)
        return Points(angles=angles, width=1e-3 * self.width_mm)

    def housing(self) -> Housing | None:
        """The housing in SI."""
        if self.kind != "housing":
            return None
        if self.mass_kg is None or self.stiffness_N_per_m is None or self.damping_N_s_m is None:
            raise ValueError('kind = "housing" without a mass, a stiffness or a damping; leave None out')
        return Housing(mass=self.mass_kg, stiffness=self.stiffness_N_per_m, damping=self.damping_N_s_m)

    def bore(self) -> Bore | None:
        """The bore in SI."""
        if self.fit_clearance_um is None:
            return None
        stiffness = self.bore_stiffness_N_per_mm3
        return Bore(clearance=UM * self.fit_clearance_um, stiffness=None if stiffness is None else PER_MM3 * stiffness)


class SensorTable(Table):
    """An accelerometer on the housing, along y: a resonator."""

    frequency_Hz: float = Field(15_000.0, ge=1.0, le=1e7, description="undamped natural frequency of the sensor")
    damping_ratio: float = Field(0.05, ge=0.0, le=0.99, description="damping ratio of the sensor")

    def sensor(self) -> Sensor:
        """The sensor in SI."""
        return Sensor(frequency=self.frequency_Hz, damping_ratio=self.damping_ratio)
