"""The scene file's [table]: names and units of the columns of a trajectory table made elsewhere.

[table]
time = "t [ms]"                # header "t [ms]", or header "t" over milliseconds
inner_x = "X_hub [um]"
inner_y = "Y_hub [um]"
roller_rho = "rho_{j} [mm]"    # {j}: the roller's number; or roller_x and roller_y
roller_theta = "theta_{j} [deg]"
inner_force = "Q{j} [N]"       # optional, as are inner_ax, inner_ay, outer_force, inner_traction, outer_traction
housing_y = "Y_ring [um]"      # with [support] kind = "housing", and housing_x; optional housing_ax, housing_ay
outer_ring_y = "Y_outer [um]"  # instead of these where the ring has a fit_clearance_um, and outer_ring_x and so on
first_roller = 1               # number of the first roller in the names; default 0
decimal = ","                  # default "."
"""

import re
from math import pi
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator

from lagrange.messages import G

LONGEST_NAME = 200  # characters
TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9}
LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "in": 0.0254}
ANGLE = {"rad": 1.0, "deg": pi / 180.0, "°": pi / 180.0}
FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605}
ACCELERATION = {"m/s2": 1.0, "m/s²": 1.0, "m/s^2": 1.0, "mm/s2": 1e-3, "mm/s²": 1e-3, "mm/s^2": 1e-3, "g": G}
UNITS = {
    "time": TIME,
    "inner_x": LENGTH, "inner_y": LENGTH,
    "roller_x": LENGTH, "roller_y": LENGTH, "roller_rho": LENGTH, "roller_theta": ANGLE,
    "inner_ax": ACCELERATION, "inner_ay": ACCELERATION,
    "housing_x": LENGTH, "housing_y": LENGTH, "housing_ax": ACCELERATION, "housing_ay": ACCELERATION,
    "outer_ring_x": LENGTH, "outer_ring_y": LENGTH, "outer_ring_ax": ACCELERATION, "outer_ring_ay": ACCELERATION,
    "inner_force": FORCE, "outer_force": FORCE, "inner_traction": FORCE, "outer_traction": FORCE,
}  # fmt: skip


class Columns(BaseModel):
    """Names of a table's columns: "name" (SI) or "name [unit]"."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    time: str = Field("time", description="time")
    inner_x: str = Field("inner_x", description="inner ring's centre, x")
    inner_y: str = Field("inner_y", description="inner ring's centre, y (up)")
    roller_x: str = Field("roller_{j}_x", description="roller's centre, x; {j}: its number")
    roller_y: str = Field("roller_{j}_y", description="roller's centre, y")
    roller_rho: str = Field(
        "roller_{j}_rho", description="roller's distance from the outer ring's centre, instead of x and y"
    )
    roller_theta: str = Field("roller_{j}_theta", description="roller's angle from +x, counter-clockwise")
    inner_ax: str = Field("inner_ax", description="acceleration of the inner ring, x")
    inner_ay: str = Field("inner_ay", description="acceleration of the inner ring, y")
    housing_x: str = Field("housing_x", description="outer ring's centre in a housing, x")
    housing_y: str = Field("housing_y", description="outer ring's centre in a housing, y")
    housing_ax: str = Field("housing_ax", description="acceleration of the housing, x")
    housing_ay: str = Field("housing_ay", description="acceleration of the housing, y")
    outer_ring_x: str = Field("outer_ring_x", description="outer ring's centre, x, if it has a fit")
    outer_ring_y: str = Field("outer_ring_y", description="outer ring's centre, y, if it has a fit")
    outer_ring_ax: str = Field("outer_ring_ax", description="acceleration of the outer ring, x")
    outer_ring_ay: str = Field("outer_ring_ay", description="acceleration of the outer ring, y")
    inner_force: str = Field("roller_{j}_inner_force", description="normal force at the inner raceway")
    outer_force: str = Field("roller_{j}_outer_force", description="normal force at the outer raceway")
    inner_traction: str = Field(
        "roller_{j}_inner_traction", description="tangential force of the inner raceway on the roller, along +θ"
    )
    outer_traction: str = Field(
        "roller_{j}_outer_traction", description="tangential force of the outer raceway on the roller, along +θ"
    )
    first_roller: int = Field(0, ge=0, description="number of the first roller in the names")
    decimal: Literal[".", ","] = Field(".", description="decimal sign of the table")

    @field_validator(*UNITS)
    @classmethod
    def _usable(cls, name: str, info: ValidationInfo) -> str:
        if not name.strip() or len(name) > LONGEST_NAME:
            raise ValueError(f"must be a column's name of at most {LONGEST_NAME} characters")
        quantity = str(info.field_name)  # which a field's validator always has
        unit, units = _split(name)[1], UNITS[quantity]
        if unit is not None and unit not in units:
            raise ValueError(f"the unit [{unit}] is unknown; known are {', '.join(units)}")
        if per_roller(quantity) != ("{j}" in name):
            wanted = "needs {j} in place of the roller's number"
            raise ValueError(wanted if per_roller(quantity) else "has one column, without {j}")
        return name

    def header(self, quantity: str, roller: int | None = None) -> tuple[list[str], float]:
        """Headers a quantity's column may have, likeliest first, and the factor to SI; `roller` counts from 0."""
        name = getattr(self, quantity)
        if roller is not None:
            name = name.replace("{j}", str(roller + self.first_roller))
        bare, unit = _split(name)
        if not unit:
            return [name], 1.0
        factor = UNITS[quantity][unit]
        same = [f"{bare} [{other}]" for other, size in UNITS[quantity].items() if size == factor and other != unit]
        return [name, bare, *same], factor


def per_roller(quantity: str) -> bool:
    """Whether a quantity has one column per roller."""
    return quantity.startswith("roller_") or quantity.endswith(("_force", "_traction", "_moment"))


def _split(name: str) -> tuple[str, str | None]:
    """Bare name and unit of "name [unit]"."""
    match = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]\s*", name)
    return (match[1], match[2].strip()) if match else (name, None)
