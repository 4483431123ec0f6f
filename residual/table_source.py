"""Reader of trajectory tables (CSV, TSV, semicolons, MATLAB): other people's data."""

from pathlib import Path
from typing import Any

import numpy as np

from lagrange.contact.laws import contact_laws
from lagrange.files.input import read_plain
from lagrange.files.tables import LARGEST_TEXT, TextTable, decoded
from lagrange.kinematics import roller_angles, turned
from lagrange.messages import shown
from lagrange.scene.run import Columns, per_roller
from lagrange.scene.scene import Scene
from lagrange.statics import held_hub
from residual.errors import InputError
from residual.record import FEWEST_SAMPLES, TIME_JITTER, Record, checked, relative
from residual.sources import OPTIONAL, check_readable

LONGEST_QUOTE = 200  # characters of a header in a message
MOTION = ("time", "inner_x", "inner_y")
CARTESIAN, POLAR = ("roller_x", "roller_y"), ("roller_rho", "roller_theta")
SPLINE_DEGREE = 7  # of the spline: smoother than the highest order of differentiation needs
LARGEST_GAP = 10.0  # of the median interval: nothing is made up across more
FORCES = ("inner_force", "outer_force", "inner_traction", "outer_traction")  # with kinks: straight lines
DECIMALS = range(13)  # of time stamps, in s
COARSEST = 0.5  # last place over the interval: a row that is missing then can't pass as rounding
ROUNDED = 0.75  # of their last place: half for rounding, the rest for the fit of a few stamps


@np.errstate(over="ignore", invalid="ignore")  # what overflows is not finite, and refused as such
def read_table(path: str | Path, scene: Scene, resample: bool = False, kinematic: bool = False) -> Record:
    """Read a trajectory table with one header line, or a MATLAB file (.mat) whose variables are its columns.

    Parameters
    ----------
    scene : its [table] gives names and units; without one: time, inner_x, inner_y and roller_<j>_x,
        roller_<j>_y or roller_<j>_rho, roller_<j>_theta, j from 0, in SI; accelerations and contact forces where it has
        them
    resample : bring irregular samples to equal steps instead of refusing them
    kinematic : of a table of the hub's orbit alone: rollers roll without slip, in radial balance by the scene's law

    Columns may stand in any order; others are left out. Lines starting with # are comments. The delimiter (comma, tab,
    semicolon or blanks) is taken from the header. A MATLAB file may hold a matrix, roller_x with a column for each
    roller, and fields of a struct in place of variables. Rounded time stamps of an even clock become its times.

    Errors
    ------
    InputError: no such file, not text, columns missing or twice, a number of rollers other than the scene's, a row
    that can't be read, more than fits in memory, and all that `checked` refuses.
    """
    path = Path(path)
    if path.suffix.lower() == ".mat" and path.is_file():
        return _record(path, scene, _matlab_columns(path, scene, kinematic), resample)
    check_readable(path)
    return _record(path, scene, _read_columns(path, scene, kinematic), resample)


def _matlab_columns(path: Path, scene: Scene, kinematic: bool) -> dict[str, np.ndarray]:
    """Read every quantity that a MATLAB file has, SI."""
    from residual.measured.formats import read_channels

    try:
        channels = read_channels(path)
    except OSError as error:
        raise InputError(f"{path}: can't be read: {error.strerror or error}") from None
    except ValueError as error:
        hint = "; of a table write a struct: s = table2struct(T, 'ToScalar', true)" if "a signal" in str(error) else ""
        raise InputError(f"{path}: {error}{hint}") from None
    named = {_matlab_name(name, scene.table): channels.values[name].astype(float) for name in channels.longest}
    header, arrays = list(named), {}
    for quantity, (indices, factor) in _columns_found(path, header, scene, kinematic).items():
        values = factor * np.column_stack([named[header[index]] for index in indices])
        arrays[quantity] = values if per_roller(quantity) else values[:, 0]
    return arrays


def _matlab_name(name: str, columns: Columns) -> str:
    """A column's name for a variable, a struct's field (s.time), or a column of a matrix (roller_x[1])."""
    bare, _, number = name.rpartition(".")[2].partition("[")
    if number and bare in Columns.model_fields and per_roller(bare):
        return columns.header(bare, int(number.rstrip("]")) - 1)[0][0]
    return bare


def _read_columns(path: Path, scene: Scene, kinematic: bool) -> dict[str, np.ndarray]:
    """Read every quantity that the table has, SI."""
    columns = scene.table
    try:
        table = TextTable.named(decoded(read_plain(path, LARGEST_TEXT + 1)), columns.decimal)
    except ValueError as error:
        raise InputError(f"{path}: neither an HDF5 result file nor a text table: {error}") from None
    try:
        found = _columns_found(path, table.names, scene, kinematic)
    except InputError as error:
        names = [columns.header(quantity)[0][0] for quantity in MOTION[:2]]
        raise InputError(f"{error}{table.header_below(names)}") from None
    try:
        numbers = table.numbers([index for indices, _ in found.values() for index in indices])
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    arrays, start = {}, 0
    for quantity, (indices, factor) in found.items():
        values = factor * numbers[:, start : start + len(indices)]
        arrays[quantity] = values if per_roller(quantity) else values[:, 0]
        start += len(indices)
    return arrays


def _record(path: Path, scene: Scene, arrays: dict[str, np.ndarray], resample: bool) -> Record:
    """Make the record: Cartesian, evenly sampled, checked, with notes on what the table lacks."""
    notes: list[str] = []
    centre = scene.mounting().centre
    if "roller_rho" in arrays:
        rho, theta = arrays.pop("roller_rho"), np.unwrap(arrays.pop("roller_theta"), axis=0)
        arrays["roller_x"], arrays["roller_y"] = rho * np.cos(theta), rho * np.sin(theta)
        for axis, place in zip("xy", centre, strict=False):  # polar coordinates are about the outer ring's centre
            arrays[f"roller_{axis}"] += arrays[place][:, None]
    if (clock := even_clock(arrays["time"])) is not None:
        arrays["time"] = clock[0]
        notes.append(clock[1])
    if resample:
        arrays, note = evenly_sampled(path, arrays)
        notes += [note] if note else []
    if "inner_force" not in arrays:
        notes.append("the table has no contact forces: the error is not split into terms, and no law can be fitted")
    else:
        if "inner_ax" not in arrays or "inner_ay" not in arrays:
            notes.append("the table has no accelerations of its own: the budget has no differentiation term")
        if "inner_traction" not in arrays:
            notes.append("the table has no tangential forces: the budget has no friction term")
    if "roller_x" not in arrays:
        arrays["roller_x"], arrays["roller_y"] = kinematic_rollers(path, scene, arrays)
        notes.append(
            "the table has no positions of rollers: they are assumed to roll without slip from "
            f"operation.first_roller_deg, in static balance on {scene.lagrange.law} contacts"
        )
    columns: dict[str, Any] = relative(arrays, centre)  # fields of a record by their names
    return checked(Record(name=shown(path.stem), source=path, scene=scene, notes=tuple(notes), **columns))


def kinematic_rollers(path: Path, scene: Scene, arrays: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Places, m, (n_times, n_rollers), of rollers that roll without slip, each in radial balance between its contacts.

    Errors
    ------
    InputError: the outer ring moves, or surfaces are no perfect circles.
    """
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    if scene.mounting().centre or bearing.faults or operation.history is not None:
        raise InputError(
            f"{path}: --kinematic-rollers: only for perfect rings at constant speed and load with a held outer ring; "
            "leave [support], faults and tables out of the scene"
        )
    laws = contact_laws(scene.lagrange.law, bearing)
    first = roller_angles(bearing, operation.first_roller_angle)
    theta = first + np.multiply.outer(arrays["time"], np.ones(first.size)) * turned(bearing, operation, 1.0).cage
    hub = np.column_stack([arrays["inner_x"], arrays["inner_y"]])
    if not np.all(np.abs(hub) < 0.5 * bearing.roller_radius):
        raise InputError(f"{path}: --kinematic-rollers: the hub leaves the bearing, or a position is not a number")
    rho = np.array([held_hub(bearing, operation, laws, at, angles=on)[1] for at, on in zip(hub, theta, strict=True)])
    return rho * np.cos(theta), rho * np.sin(theta)


def _columns_found(path: Path, header: list[str], scene: Scene, kinematic: bool) -> dict[str, tuple[list[int], float]]:
    """Find column numbers and factor to SI of each quantity that the table has."""
    columns, n_rollers = scene.table, scene.bearing.present
    centre = scene.mounting().centre
    polar_only = not _at(path, header, columns, "roller_x", n_rollers)[0] and bool(
        _at(path, header, columns, "roller_rho", n_rollers)[0]
    )
    wanted = [*MOTION, *(() if kinematic else POLAR if polar_only else CARTESIAN), *centre[:2]]
    found, missing = {}, []
    for quantity in (*wanted, *OPTIONAL, *centre[2:]):
        indices, factor, absent = _at(path, header, columns, quantity, n_rollers)
        if quantity in wanted or indices:
            missing += absent
        if indices:
            found[quantity] = indices, factor
    if kinematic and any(_at(path, header, columns, name, n_rollers)[0] for name in (*CARTESIAN, *POLAR)):
        raise InputError(f"{path}: --kinematic-rollers: the table has positions of rollers; leave the option out")
    if not {"time", "inner_x"} & set(found):
        raise InputError(
            f"{path}: neither an HDF5 result file nor a trajectory table: missing column {', '.join(missing[:2])}; "
            f"its first line: {shown(', '.join(header)[:LONGEST_QUOTE]) or 'empty'}; other names and units: [table] in "
            "the scene file"
        )
    roller = POLAR[0] if polar_only else CARTESIAN[0]
    _check_count(path, header, columns, roller, n_rollers)
    if missing:
        more = f" and {len(missing) - 4} more" if len(missing) > 4 else ""
        if "inner_x" not in found and {"inner_ax", "inner_ay"} & set(found):
            more += " (accelerations are not enough: the check needs positions of hub and rollers)"
        elif not {*CARTESIAN, *POLAR} & set(found):
            more += (
                " (the hub's orbit is not enough: contact forces follow from the rollers' positions; "
                "--kinematic-rollers assumes rollers that roll without slip)"
            )
        raise InputError(
            f"{path}: missing column {', '.join(missing[:4])}{more}; where it has another name, [table] in the scene "
            "file tells it"
        )
    return found


def _check_count(path: Path, header, columns: Columns, quantity: str, n_rollers: int) -> None:
    """Refuse a table of fewer or more rollers than the scene has; one that lacks a roller in between lacks a column."""
    there = [any(name in header for name in columns.header(quantity, j)[0]) for j in range(n_rollers + 1)]
    count = there.index(False) if False in there else n_rollers + 1
    if (0 < count < n_rollers and not any(there[count:])) or there[n_rollers]:
        held = f"at least {n_rollers + 1}" if there[n_rollers] else count
        raise InputError(f"{path}: the table holds {held} rollers, the scene says {n_rollers}")


def _at(path: Path, header: list[str], columns: Columns, quantity: str, n_rollers: int):
    """Look for a quantity's columns: numbers of those found, factor to SI, names of those missing."""
    indices, absent, factor = [], [], 1.0
    for roller in range(n_rollers) if per_roller(quantity) else (None,):
        names, factor = columns.header(quantity, roller)
        present = next((name for name in names if name in header), None)
        if present is None:
            absent.append(names[0])
        elif header.count(present) > 1:
            raise InputError(f"{path}: column {present} appears twice")
        else:
            indices.append(header.index(present))
    return indices, factor, absent


def even_clock(time: np.ndarray) -> tuple[np.ndarray, str] | None:
    """Times of an even clock whose stamps were rounded, with a note; None: they are even, or no such clock's."""
    if time.size < FEWEST_SAMPLES or not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0):
        return None
    count = np.arange(time.size)
    mean = (time[-1] - time[0]) / (time.size - 1)
    if np.max(np.abs(np.diff(time) - mean)) <= TIME_JITTER * mean:
        return None
    centred = count - count.mean()
    interval = float(centred @ (time - time.mean()) / (centred @ centred))
    even = time.mean() + interval * centred
    for place in (10.0**-k for k in DECIMALS):
        if np.max(np.abs(time / place - np.round(time / place))) < 1e-3:  # of stamps as floats: 1e-3 of a place
            if place > COARSEST * interval or np.max(np.abs(time - even)) > ROUNDED * place:
                return None
            return even, f"the time stamps are rounded to {place:g} s; an even clock of {interval:.9g} s is taken"
    return None


def evenly_sampled(path: Path, arrays: dict[str, np.ndarray]) -> tuple[dict[str, np.ndarray], str | None]:
    """Bring arrays to as many equal steps, with a note; unchanged and None where the steps are equal already.

    Errors
    ------
    InputError: time falls or stands, a gap of more than ten intervals, too few samples. Vibration above a quarter of
    the mean sampling rate is not to be trusted afterwards.
    """
    from scipy.interpolate import make_interp_spline

    time = arrays["time"]
    steps = np.diff(time)
    if time.size < FEWEST_SAMPLES or not np.all(np.isfinite(time)):
        return arrays, None  # refused with the other checks
    even = (time[-1] - time[0]) / (time.size - 1)
    if np.any(steps <= 0.0):
        i = int(np.argmax(steps <= 0.0))
        raise InputError(f"{path}: time does not rise after sample {i} ({time[i]:.9g} s); sort it, --resample can't")
    if np.max(np.abs(steps - even)) <= TIME_JITTER * even:
        return arrays, None
    if np.max(steps) > LARGEST_GAP * np.median(steps):
        i = int(np.argmax(steps))
        raise InputError(
            f"{path}: a gap of {steps[i]:.4g} s after sample {i}, {steps[i] / np.median(steps):.3g} intervals long; "
            f"--resample bridges at most {LARGEST_GAP:g}"
        )
    equal = np.linspace(time[0], time[-1], time.size)
    result = {"time": equal}
    for name, value in arrays.items():
        if name in FORCES:
            result[name] = np.column_stack([np.interp(equal, time, column) for column in value.T])
        elif name != "time":
            if not np.all(np.isfinite(value)):
                raise InputError(f"{path}: {name} holds values that are not finite; leave those samples out")
            middle = value.mean(axis=0)
            result[name] = middle + make_interp_spline(time, value - middle, k=SPLINE_DEGREE)(equal)
    return result, (
        f"the sampling was irregular (intervals {steps.min():.4g} to {steps.max():.4g} s) and has been resampled to "
        f"{time.size} samples every {even:.4g} s, motion by a spline of degree {SPLINE_DEGREE}, "
        "forces by straight lines"
    )
