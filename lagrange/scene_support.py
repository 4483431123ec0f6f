"""Tables of the scene that say what the bearing stands in: [support] of the outer ring, [sensor]."""

from collections.abc import Iterator
from typing import Any, Literal

from pydantic import Field

from lagrange.mounting import Housing, Sensor
from lagrange.scene_faults import Check, Table

PEDESTAL = {"mass_kg": 12.638, "stiffness_N_per_m": 15.1e6, "damping_N_s_m": 2210.7}


class SupportTable(Table):
    """What holds the outer ring.

    The defaults of a housing are a pedestal's.

    Source: Sawalhi and Randall, Simulating gear and bearing interactions in the presence of faults, part I (2008).
    """

    kind: Literal["held", "housing"] = Field(
        "held", description="all around by the ground; by a rigid mass on springs and dashpots along x and y"
    )
    mass_kg: float | None = Field(
        None, ge=1e-3, le=1e6, description="of a housing without the outer ring; 12.638 if left out"
    )
    stiffness_N_per_m: float | None = Field(
        None, ge=1e3, le=1e12, description="of a housing's springs, along either axis; 15.1e6 if left out"
    )
    damping_N_s_m: float | None = Field(
        None, ge=0.0, le=1e9, description="of the dashpots beside them; 2210.7 if left out"
    )

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        return PEDESTAL | data if data.get("kind") == "housing" else data

    def checks(self) -> tuple[Check, ...]:
        return (self._housing_alone,)

    def _housing_alone(self) -> Iterator[str]:
        for name in PEDESTAL:
            if self.kind != "housing" and getattr(self, name) is not None:
                yield f'{name} = {getattr(self, name):g}: only with kind = "housing", not "{self.kind}"; leave it out'

    def housing(self) -> Housing | None:
        """The housing in SI."""
        if self.kind != "housing":
            return None
        return Housing(mass=self.mass_kg, stiffness=self.stiffness_N_per_m, damping=self.damping_N_s_m)


class SensorTable(Table):
    """A resonator on the housing, along y: what an accelerometer shows."""

    frequency_Hz: float = Field(15_000.0, ge=1.0, le=1e7, description="of the resonator, undamped")
    damping_ratio: float = Field(0.05, ge=0.0, le=0.99, description="of the resonator")

    def sensor(self) -> Sensor:
        """The sensor in SI."""
        return Sensor(frequency=self.frequency_Hz, damping_ratio=self.damping_ratio)
