"""Readers of runs: the solver's result file (HDF5), and trajectory tables (CSV, TSV, semicolons, MATLAB) of others."""

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from lagrange.axial.slices import contact_slices, read_slices
from lagrange.columns import ENERGIES, FORMAT_VERSION, columns_of, per_roller
from lagrange.contact.laws import contact_laws
from lagrange.errors import InputError
from lagrange.files import hdf5
from lagrange.files.input import read_plain
from lagrange.files.tables import LARGEST_TEXT, TextTable, decoded
from lagrange.kinematics import roller_angles, turned
from lagrange.messages import shown
from lagrange.mounting import ENERGIES as OF_MOUNTING
from lagrange.scene.run import Columns
from lagrange.scene.scene import Scene, SceneError, parse_stored_scene
from lagrange.statics import held_hub
from residual import record as records
from residual.record import COLUMNS, FEWEST_SAMPLES, TIME_JITTER, Record, relative

LARGEST_READ = 4 * 2**30  # bytes of arrays held in memory
MOTION = ("time", "inner_x", "inner_y", "roller_x", "roller_y")
FORCES = ("inner_force", "outer_force", "inner_traction", "outer_traction")  # with kinks: straight lines
OPTIONAL = ("inner_ax", "inner_ay", *FORCES)
KEPT = {*ENERGIES, *OF_MOUNTING, *(each.name for each in fields(Record))}
TURN, SPIN = "roller_turn", "roller_spin"  # rotation of the rollers; its rate, less exact
MOST_STATED_ERRORS, LONGEST_WORDS = 1000, 2000
ATTRIBUTES = ("committed_samples", "format_version", "program", "status", "warnings", "degrees_of_freedom")
SOLVER = "run-fem"  # attribute `program`: of a file that holds all variables
# of tables
LONGEST_QUOTE = 200  # characters of a header in a message
CARTESIAN, POLAR = ("roller_x", "roller_y"), ("roller_rho", "roller_theta")
SPLINE_DEGREE = 7  # of the spline: smoother than the highest order of differentiation needs
LARGEST_GAP = 10.0  # of the median interval: nothing is made up across more
DECIMALS = range(13)  # of time stamps, in s
COARSEST = 0.5  # last place over the interval: a row that is missing then can't pass as rounding
ROUNDED = 0.75  # of their last place: half for rounding, the rest for the fit of a few stamps


def is_result(path: Path) -> bool:
    """Whether a file looks like HDF5 (or bears a result file's name), so that a table is not expected."""
    if path.suffix.lower() in (".nc", ".h5", ".hdf5"):
        return True
    with path.open("rb") as file:
        return file.read(len(hdf5.SIGNATURE)) == hdf5.SIGNATURE


def check_readable(path: Path) -> None:
    """Refuse a file that is plainly no result file or table: missing, empty, unreadable, misnamed."""
    if not path.exists():
        raise InputError(f"{path}: no such file; give the path of a result file or a table, or run run-fem first")
    if not path.is_file():
        raise InputError(f"{path}: not a file; give the path of a result file or a table")
    try:
        start = read_plain(path, len(hdf5.SIGNATURE))
    except OSError as error:
        raise InputError(f"{path}: can't be read: {error.strerror}") from None
    if not start:
        raise InputError(f"{path}: the file is empty; run the simulation again")
    if start != hdf5.SIGNATURE and is_result(path):
        raise InputError(f"{path}: not an HDF5 file; give a result file of run-fem, or a table named .csv")


def read_result(path: str | Path) -> Record:
    """Read a run's result file up to its last committed sample.

    InputError: no such file, not HDF5, damaged (also by its checksums), another program's, another format version,
    variables missing, of the wrong shape, not finite or in another file, irregular time, too few samples, too large.
    """
    path = Path(path)
    check_readable(path)
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            return records.checked(_from_file(path, file))
    except InputError:
        raise
    except SceneError as error:
        raise InputError(str(error)) from None
    except hdf5.Damaged as error:
        raise InputError(f"{path}: damaged, or not a result file of run-fem: {error}") from None
    except (OSError, RuntimeError, LookupError, TypeError, ValueError, ArithmeticError) as error:  # h5py's, of damage
        reason = (str(error).strip("'\"").splitlines() or [type(error).__name__])[0]
        raise InputError(f"{path}: damaged or truncated HDF5 file ({reason}); run the simulation again") from None


def _from_file(path, file):
    attributes = {name: _plain(file.attrs[name]) for name in ATTRIBUTES if name in file.attrs}
    attributes |= {name: _words(attributes[name]) for name in ("status", "warnings") if name in attributes}
    version, n = attributes.get("format_version"), attributes.get("committed_samples")
    if n is None or "scene" not in file.attrs:
        raise InputError(
            f"{path}: not a result file of run-fem: the attributes scene and committed_samples are missing"
        )
    if version != FORMAT_VERSION:
        raise InputError(
            f"{path}: format_version = {version!r}, this program reads {FORMAT_VERSION}; run the scene again"
        )
    scene = parse_stored_scene(hdf5.read_scene_text(file), f"{path}, attribute scene", hdf5.read_scene_files(file))
    centre, axial, rollers, cage = scene.mounting().centre, scene.ideal_axial(), scene.bearing.present, None
    held = [name for name in columns_of("", *scene.parts) if name in KEPT or name in centre]
    needed = held if attributes.get("program") == SOLVER else (*MOTION, *centre[:2])
    if missing := [name for name in needed if not hdf5.has(file, name)]:
        raise InputError(f"{path}: missing {', '.join(missing)}; is it a result file? Run the scene again")
    if not isinstance(n, int) or n < 0:
        raise InputError(f"{path}: committed_samples = {n!r} must be a whole number >= 0; the file is damaged")
    if n < FEWEST_SAMPLES:
        raise InputError(f"{path}: {n} committed samples, at least {FEWEST_SAMPLES} are needed; simulate longer")
    of_cage = COLUMNS if scene.cage is not None and all(hdf5.has(file, name) for name in COLUMNS) else {}
    names = [name for name in dict.fromkeys((*held, TURN, *of_cage)) if hdf5.has(file, name)]
    names += [] if TURN in names or not hdf5.has(file, SPIN) else [SPIN]
    size = 0
    for name in names:  # before anything is read
        shape = hdf5.check_array(file, name, n).shape
        if shape[1:] not in ((), (rollers,)):
            raise InputError(f"{path}: {name} holds {shape[1]} rollers, its scene says {rollers}")
        size += 8 * n * (rollers if len(shape) > 1 else 1)
    if size > LARGEST_READ:
        raise InputError(
            f"{path}: {size / 2**30:.1f} GiB of arrays, at most {LARGEST_READ / 2**30:.0f} are read; "
            "store less often (numerics.output_interval_us)"
        )
    arrays = {name: hdf5.read_numbers(file, name, n) for name in names}
    if (spin := arrays.pop(SPIN, None)) is not None:  # of a run on perfect surfaces: its record looks like any other
        from scipy.integrate import cumulative_trapezoid

        time = arrays["time"]  # rollers have turned from 0 at t = 0
        arrays[TURN] = time[0] * spin[:1] + cumulative_trapezoid(spin, time, axis=0, initial=0.0)
    energies = {name: arrays.pop(name) for name in (*ENERGIES, *OF_MOUNTING) if name in arrays}
    arrays = relative(arrays, centre)
    if of_cage:
        cage = records.CageMotion(**{of: arrays.pop(name) for name, of in of_cage.items()})
    notes = [warning for warning in attributes.get("warnings", "").splitlines() if warning]
    if (status := attributes.setdefault("status", "unknown")) != "complete":
        notes.append(f"the run is not complete (status: {status}); its first {n} samples are used")
    elif file["time"].shape[0] > n:
        notes.append(f"only the first {n} of {file['time'].shape[0]} samples are committed")
    bearing, slices = scene.perfect_bearing(), None
    if axial is not None and scene.model == "lagrange":
        slices = contact_slices(bearing, axial, contact_laws(scene.lagrange.law, bearing))
    elif axial is not None:
        slices = read_slices(file, bearing, axial)
    # as `run-fem --estimate-error` writes it
    columns, kinds = [], {"meaning": "OS", "unit": "OS", "value": "f", "error": "f"}
    for name, kind in kinds.items() if all(hdf5.has(file, f"quantity_{name}") for name in kinds) else ():
        data = hdf5.check_array(file, f"quantity_{name}", 0, kinds=kind, dimensions=(1,))
        if len(data) > MOST_STATED_ERRORS:
            raise hdf5.Damaged(f"quantity_{name} holds {len(data)} values, at most {MOST_STATED_ERRORS} are read")
        columns.append([_plain(value) if kind == "f" else _words(_plain(value)) for value in data[:]])
    return Record(
        name=shown(path.stem), source=path, scene=scene, energies=energies, cage=cage, attributes=attributes,
        stated_errors=tuple(records.StatedError(*row) for row in zip(*columns, strict=True)), slices=slices,
        notes=tuple(notes), **arrays,
        precision=float(max(np.finfo(file[name].dtype).eps for name in ("inner_x", "inner_y"))))  # fmt: skip


def _words(value):
    return "".join(c if c.isprintable() or c == "\n" else "?" for c in str(value)[:LONGEST_WORDS])


def _plain(value):
    if isinstance(value, np.generic | np.ndarray):
        return _plain(value.item()) if value.size == 1 else value.tolist()
    return value.decode("utf-8", errors="replace") if isinstance(value, bytes) else value


@np.errstate(over="ignore", invalid="ignore")  # what overflows is not finite, and refused as such
def read_table(path: str | Path, scene: Scene, resample: bool = False, kinematic: bool = False) -> Record:
    """Read a trajectory table with one header line, or a MATLAB file (.mat) whose variables are its columns.

    scene : its [table] gives names and units; without one: time, inner_x, inner_y and roller_<j>_x,
        roller_<j>_y or roller_<j>_rho, roller_<j>_theta, j from 0, in SI; accelerations and contact forces where it has
        them
    resample : bring irregular samples to equal steps instead of refusing them
    kinematic : of a table of the hub's orbit alone: rollers roll without slip, in radial balance by the scene's law

    Columns may stand in any order; others are left out. Lines starting with # are comments. The delimiter (comma, tab,
    semicolon or blanks) is taken from the header. A MATLAB file may hold a matrix, roller_x with a column for each
    roller, and fields of a struct in place of variables. Rounded time stamps of an even clock become its times.

    InputError: no such file, not text, columns missing or twice, a number of rollers other than the scene's, a row
    that can't be read, more than fits in memory, and all that `checked` refuses.
    """
    path, centre = Path(path), scene.mounting().centre
    arrays = _columns(path, scene, kinematic)
    if "roller_rho" in arrays:
        rho, theta = arrays.pop("roller_rho"), np.unwrap(arrays.pop("roller_theta"), axis=0)
        arrays["roller_x"], arrays["roller_y"] = rho * np.cos(theta), rho * np.sin(theta)
        for axis, place in zip("xy", centre, strict=False):  # polar coordinates are about the outer ring's centre
            arrays[f"roller_{axis}"] += arrays[place][:, None]
    arrays["time"], *notes = even_clock(arrays["time"]) or (arrays["time"],)
    if resample and uneven(*arrays.values()):
        notes.append(_resample(path, arrays))
    if "inner_force" not in arrays:
        notes.append("the table has no contact forces: the error is not split into terms, and no law can be fitted")
    else:
        if "inner_ax" not in arrays or "inner_ay" not in arrays:
            notes.append("the table has no accelerations of its own: the budget has no differentiation term")
        if "inner_traction" not in arrays:
            notes.append("the table has no tangential forces: the budget has no friction term")
    if "roller_x" not in arrays:
        arrays["roller_x"], arrays["roller_y"] = _kinematic_rollers(path, scene, arrays)
        notes.append(
            "the table has no positions of rollers: they are assumed to roll without slip from "
            f"operation.first_roller_deg, in static balance on {scene.lagrange.law} contacts"
        )
    columns: dict[str, Any] = relative(arrays, centre)  # fields of a record by their names
    return records.checked(Record(name=shown(path.stem), source=path, scene=scene, notes=tuple(notes), **columns))


def _columns(path, scene, kinematic):
    """Every quantity that a text has, SI; or MATLAB's variables, fields of a struct and columns of matrices."""
    if path.suffix.lower() == ".mat" and path.is_file():
        from residual.measured.formats import read_channels

        try:
            channels = read_channels(path)
        except OSError as error:
            raise InputError(f"{path}: can't be read: {error.strerror or error}") from None
        except ValueError as error:
            hint = "; of a table write a struct: s = table2struct(T, 'ToScalar', true)"
            raise InputError(f"{path}: {error}{hint if 'a signal' in str(error) else ''}") from None
        named = {}
        for name in channels.longest:  # time, s.time, roller_x[1]
            bare, _, number = name.rpartition(".")[2].partition("[")
            if number and bare in Columns.model_fields and per_roller(bare):
                bare = scene.table.header(bare, int(number.rstrip("]")) - 1)[0][0]
            named[bare] = channels.values[name].astype(float)
        header, values = list(named), list(named.values())
        found = _columns_found(path, header, scene, kinematic)
        numbers = [np.column_stack([values[i] for i in own]) for own, _ in found.values()]
    else:
        check_readable(path)
        try:
            table = TextTable.named(decoded(read_plain(path, LARGEST_TEXT + 1)), scene.table.decimal)
        except ValueError as error:
            raise InputError(f"{path}: neither an HDF5 result file nor a text table: {error}") from None
        try:
            found = _columns_found(path, table.names, scene, kinematic)
        except InputError as error:
            names = [scene.table.header(quantity)[0][0] for quantity in MOTION[:2]]
            raise InputError(f"{error}{table.header_below(names)}") from None
        try:
            wanted = table.numbers([index for own, _ in found.values() for index in own])
        except ValueError as error:
            raise InputError(f"{path}: {error}") from None
        numbers = np.split(wanted, np.cumsum([len(own) for own, _ in found.values()])[:-1], axis=1)
    scaled = {name: factor * of for (name, (_, factor)), of in zip(found.items(), numbers, strict=True)}
    return {name: values if per_roller(name) else values[:, 0] for name, values in scaled.items()}


def _kinematic_rollers(path, scene, arrays):
    """Places, m, (n_times, n_rollers), of rollers that roll without slip, each in radial balance between its contacts.

    InputError: the outer ring moves, or surfaces are no perfect circles.
    """
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    if scene.mounting().centre or bearing.faults or operation.history is not None:
        raise InputError(
            f"{path}: --kinematic-rollers: only for perfect rings at constant speed and load with a held outer ring; "
            "leave [support], faults and tables out of the scene"
        )
    laws, first = contact_laws(scene.lagrange.law, bearing), roller_angles(bearing, operation.first_roller_angle)
    theta = first + arrays["time"][:, None] * turned(bearing, operation, 1.0).cage
    hub = np.column_stack([arrays["inner_x"], arrays["inner_y"]])
    if not np.all(np.abs(hub) < 0.5 * bearing.roller_radius):
        raise InputError(f"{path}: --kinematic-rollers: the hub leaves the bearing, or a position is not a number")
    rho = np.array([held_hub(bearing, operation, laws, at, angles=on)[1] for at, on in zip(hub, theta, strict=True)])
    return rho * np.cos(theta), rho * np.sin(theta)


def _columns_found(path, header, scene, kinematic):
    n_rollers, centre, found, absent = scene.bearing.present, scene.mounting().centre, {}, dict[str, list[str]]()
    for quantity in (*MOTION, *POLAR, *OPTIONAL, *centre):
        if quantity in POLAR and "roller_x" in found:
            continue
        own, absent[quantity] = list[int](), list[str]()
        for roller in range(n_rollers) if per_roller(quantity) else (None,):
            names, factor = scene.table.header(quantity, roller)
            present = next((name for name in names if name in header), None)
            if present is None:
                absent[quantity].append(names[0])
            elif header.count(present) > 1:
                raise InputError(f"{path}: column {present} appears twice")
            else:
                own.append(header.index(present))
        if own:
            found[quantity] = own, factor
    if kinematic and {*CARTESIAN, *POLAR} & found.keys():
        raise InputError(f"{path}: --kinematic-rollers: the table has positions of rollers; leave the option out")
    places, others = (POLAR, CARTESIAN) if "roller_rho" in found else (CARTESIAN, POLAR)
    found = {name: own for name, own in found.items() if name not in others}
    wanted = [*MOTION[:3], *(() if kinematic else places), *centre[:2]]
    missing = [name for quantity in (*wanted, *(q for q in found if q not in wanted)) for name in absent[quantity]]
    if not {"time", "inner_x"} & found.keys():
        raise InputError(
            f"{path}: neither an HDF5 result file nor a trajectory table: missing column {', '.join(missing[:2])}; "
            f"its first line: {shown(', '.join(header)[:LONGEST_QUOTE]) or 'empty'}; other names and units: [table] in "
            "the scene file"
        )
    there = [any(x in header for x in scene.table.header(places[0], j)[0]) for j in range(n_rollers + 1)]
    count = (*there, False).index(False)  # a table that lacks a roller in between lacks a column
    if there[n_rollers] or (0 < count < n_rollers and not any(there[count:])):
        held = f"at least {n_rollers + 1}" if there[n_rollers] else count
        raise InputError(f"{path}: the table holds {held} rollers, the scene says {n_rollers}")
    if missing:
        more = f" and {len(missing) - 4} more" if len(missing) > 4 else ""
        if "inner_x" not in found and {"inner_ax", "inner_ay"} & found.keys():
            more += " (accelerations are not enough: the check needs positions of hub and rollers)"
        elif not {*CARTESIAN, *POLAR} & found.keys():
            more += (
                " (the hub's orbit is not enough: contact forces follow from the rollers' positions; "
                "--kinematic-rollers assumes rollers that roll without slip)"
            )
        raise InputError(
            f"{path}: missing column {', '.join(missing[:4])}{more}; where it has another name, [table] in the scene "
            "file tells it"
        )
    return found


def uneven(time: np.ndarray, *others: np.ndarray) -> bool:
    """Whether steps of time differ, in arrays that the other checks do not refuse."""
    if time.size < FEWEST_SAMPLES or not all(np.isfinite(each).all() for each in (time, *others)):
        return False
    steps, mean = np.diff(time), (time[-1] - time[0]) / (time.size - 1)
    return bool(np.all(steps > 0.0) and np.max(np.abs(steps - mean)) > TIME_JITTER * mean)


def even_clock(time: np.ndarray) -> tuple[np.ndarray, str] | None:
    """Times of an even clock whose stamps were rounded, with a note; None: they are even, or no such clock's."""
    if not uneven(time):
        return None
    centred = np.arange(time.size) - 0.5 * (time.size - 1)
    interval = centred @ (time - time.mean()) / (centred @ centred)
    even = time.mean() + interval * centred
    for place in (10.0**-k for k in DECIMALS):
        if np.max(np.abs(time / place - np.round(time / place))) < 1e-3:  # of stamps as floats: 1e-3 of a place
            if place > COARSEST * interval or np.max(np.abs(time - even)) > ROUNDED * place:
                return None
            return even, f"the time stamps are rounded to {place:g} s; an even clock of {interval:.9g} s is taken"
    return None


def _resample(path, arrays):
    """Bring arrays to as many equal steps; a note.

    InputError: a gap of more than ten intervals. Vibration above a quarter of the mean sampling rate is then unsound.
    """
    from scipy.interpolate import make_interp_spline

    time = arrays["time"]
    steps, equal = np.diff(time), np.linspace(time[0], time[-1], time.size)
    k = np.argmax(steps)
    if steps[k] > LARGEST_GAP * np.median(steps):
        raise InputError(
            f"{path}: a gap of {steps[k]:.4g} s after sample {k}, {steps[k] / np.median(steps):.3g} intervals long; "
            f"--resample bridges at most {LARGEST_GAP:g}"
        )
    for name, value in arrays.items():
        if name in FORCES:
            arrays[name] = np.column_stack([np.interp(equal, time, column) for column in value.T])
        else:
            middle = value.mean(axis=0)
            arrays[name] = middle + make_interp_spline(time, value - middle, k=SPLINE_DEGREE)(equal)
    arrays["time"] = equal
    return (
        f"the sampling was irregular (intervals {steps.min():.4g} to {steps.max():.4g} s) and has been resampled to "
        f"{time.size} samples every {steps.mean():.4g} s, motion by a spline of degree {SPLINE_DEGREE}, "
        "forces by straight lines"
    )
