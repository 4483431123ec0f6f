"""Tables of the scene that say how the run is computed: [contact], [numerics], [output], models' own."""

from collections.abc import Iterator
from typing import Any, Literal

from pydantic import Field

from lagrange.scene_faults import Check, Table

COMPARISONS = ("penalty", "faceted")  # contact models that are only there to be compared with
STIFF_PENALTY = 1e9  # N/m, three times a contact of the paper's bearing; the mesh's nodes are no stiffer


class ContactTable(Table):
    model: Literal["subgrid", "resolved", "penalty", "faceted"] = "subgrid"
    penalty_stiffness_N_per_m: float | None = Field(None, ge=1e5, le=1e12)  # of each contact of a comparison model
    friction_coefficient: float = Field(0.1, ge=0.0, le=1.0)

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        compared = data.get("model") in COMPARISONS
        return {"penalty_stiffness_N_per_m": STIFF_PENALTY} | data if compared else data

    def checks(self) -> tuple[Check, ...]:
        return (self._has_springs,)

    def _has_springs(self) -> Iterator[str]:
        if self.penalty_stiffness_N_per_m is not None and self.model not in COMPARISONS:
            yield (
                f"penalty_stiffness_N_per_m = {self.penalty_stiffness_N_per_m:g}: only for the comparison models "
                f'model = "penalty" and "faceted", not for "{self.model}"; leave it out'
            )


class NumericsTable(Table):
    duration_ms: float = Field(60.0, ge=0.0, le=1e6)
    start: Literal["equilibrium", "rest"] = "equilibrium"
    load_ramp_ms: float = Field(1.0, ge=0.0, le=1e6)
    mesh_size_mm: float = Field(1.0, gt=0.0, le=100.0)
    time_step_safety: float = Field(0.9, ge=0.01, lt=1.0)
    output_interval_us: float = Field(10.0, ge=1e-3, le=1e6)
    threads: int = Field(1, ge=1, le=64)

    def checks(self) -> tuple[Check, ...]:
        return (self._samples,)

    def _samples(self) -> Iterator[str]:
        if 0.0 < 1e3 * self.duration_ms < self.output_interval_us:
            yield (
                f"output_interval_us = {self.output_interval_us:g} is longer than the run (duration_ms = "
                f"{self.duration_ms:g}): nothing but the start would be stored; at most {1e3 * self.duration_ms:g}"
            )


class LagrangeTable(Table):
    """Options of the Lagrangian model: of its own solution and of what trajectories are checked against."""

    law: str = "harris"
    damping_N_s_m: float = Field(0.0, ge=0.0, le=1e6)
    angles: Literal["kinematic", "free"] = "kinematic"


class ReducedTable(Table):
    """Options of the reduced model."""

    modes_up_to_kHz: float = Field(0.0, ge=0.0, le=1e5)


class OutputTable(Table):
    fields_every_ms: float = Field(0.0, ge=0.0, le=1e6)
