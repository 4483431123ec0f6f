"""How a table's columns are called and in which units: the default names, or a mapping file.

[table]
time = "t [ms]"                # header "t [ms]", or "t" whose values are milliseconds
inner_x = "X_hub [um]"
inner_y = "Y_hub [um]"
roller_rho = "rho_{j} [mm]"    # {j}: the roller's number; or roller_x and roller_y
roller_theta = "theta_{j} [deg]"
inner_force = "Q{j} [N]"       # optional, as are inner_ax, inner_ay, outer_force, inner_traction, outer_traction
first_roller = 1               # number of the first roller in the names; default 0
decimal = ","                  # default "."
"""

import difflib
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

from residual.trajectory import InputError

TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9}
LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "in": 0.0254}
ANGLE = {"rad": 1.0, "deg": 0.017453292519943295, "°": 0.017453292519943295}
FORCE = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": 4.4482216152605}
ACCELERATION = {"m/s2": 1.0, "m/s²": 1.0, "m/s^2": 1.0, "mm/s2": 1e-3, "mm/s²": 1e-3, "mm/s^2": 1e-3, "g": 9.80665}

# quantity: (units, name in the table unless mapped)
QUANTITIES = {
    "time": (TIME, "time"),
    "inner_x": (LENGTH, "inner_x"),
    "inner_y": (LENGTH, "inner_y"),
    "roller_x": (LENGTH, "roller_{j}_x"),
    "roller_y": (LENGTH, "roller_{j}_y"),
    "roller_rho": (LENGTH, "roller_{j}_rho"),
    "roller_theta": (ANGLE, "roller_{j}_theta"),
    "inner_ax": (ACCELERATION, "inner_ax"),
    "inner_ay": (ACCELERATION, "inner_ay"),
    "inner_force": (FORCE, "roller_{j}_inner_force"),
    "outer_force": (FORCE, "roller_{j}_outer_force"),
    "inner_traction": (FORCE, "roller_{j}_inner_traction"),
    "outer_traction": (FORCE, "roller_{j}_outer_traction"),
}
SETTINGS = ("first_roller", "decimal")


@dataclass(frozen=True, kw_only=True)
class Columns:
    """Where each quantity stands in a table."""

    source: Path | None = None  # mapping file; None: the default names
    names: dict[str, str] = field(default_factory=lambda: {key: name for key, (_, name) in QUANTITIES.items()})
    first_roller: int = 0
    decimal: str = "."

    def header(self, quantity: str, roller: int | None = None) -> tuple[list[str], float]:
        """Headers a column may have, likeliest first, and the factor to SI."""
        name = self.names[quantity]
        if roller is not None:
            name = name.replace("{j}", str(roller + self.first_roller))
        bare, unit = _split(name)
        return [name, bare] if unit else [name], QUANTITIES[quantity][0][unit] if unit else 1.0


def per_roller(quantity: str) -> bool:
    """Whether a quantity has one column per roller."""
    return "{j}" in QUANTITIES[quantity][1]


def _split(name: str) -> tuple[str, str | None]:
    """Bare name and unit of "name [unit]"."""
    match = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]\s*", name)
    return (match[1], match[2].strip()) if match else (name, None)


def read_columns(path: str | Path) -> Columns:
    """The mapping file's [table].

    Errors
    ------
    InputError: no such file, not TOML, unknown keys or units, a roller's column without its {j}.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        content = tomllib.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: can't be read: {getattr(error, 'strerror', None) or 'not UTF-8 text'}") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    table = content.get("table")
    if not isinstance(table, dict) or set(content) != {"table"}:
        raise InputError(f'{path}: must hold one table [table], e.g. time = "t [ms]"')
    names = {}
    for key, value in table.items():
        if key not in (*QUANTITIES, *SETTINGS):
            near = difflib.get_close_matches(key, [*QUANTITIES, *SETTINGS], n=1)
            raise InputError(f"{path}: table.{key} is unknown" + (f"; did you mean {near[0]}?" if near else ""))
        if key in QUANTITIES:
            names[key] = _checked_name(path, key, value)
    first, decimal = table.get("first_roller", 0), table.get("decimal", ".")
    if isinstance(first, bool) or not isinstance(first, int) or first < 0:
        raise InputError(f"{path}: table.first_roller = {first!r} must be a whole number >= 0")
    if decimal not in (".", ","):
        raise InputError(f'{path}: table.decimal = {decimal!r} must be "." or ","')
    return Columns(source=path, names=Columns().names | names, first_roller=first, decimal=decimal)


def _checked_name(path: Path, key: str, value) -> str:
    """One entry of the mapping."""
    if not isinstance(value, str) or not value.strip():
        raise InputError(f"{path}: table.{key} = {value!r} must be a column's name")
    unit = _split(value)[1]
    units = QUANTITIES[key][0]
    if unit is not None and unit not in units:
        raise InputError(f"{path}: table.{key}: the unit [{unit}] is unknown; known are {', '.join(units)}")
    if per_roller(key) != ("{j}" in value):
        wanted = "needs {j} where the roller's number stands" if per_roller(key) else "has one column, without {j}"
        raise InputError(f"{path}: table.{key} = {value!r}: {wanted}")
    return value
