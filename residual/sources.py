"""Reader of the solver's result file (HDF5); tables are read in `table_source`."""

from pathlib import Path

import numpy as np

from lagrange.axial.slices import Slices, contact_slices, read_slices
from lagrange.columns import ENERGIES, FORMAT_VERSION, columns_of
from lagrange.contact.laws import contact_laws
from lagrange.files.hdf5 import (
    SIGNATURE,
    Damaged,
    check_array,
    has,
    read_numbers,
    read_scene_files,
    read_scene_text,
)
from lagrange.messages import shown
from lagrange.mounting import ENERGIES as OF_MOUNTING
from lagrange.scene.scene import Scene, SceneError, parse_stored_scene
from residual.errors import InputError
from residual.record import COLUMNS, FEWEST_SAMPLES, CageMotion, Record, StatedError, checked, relative

LARGEST_READ = 4 * 2**30  # bytes of arrays held in memory
MOTION = ("time", "inner_x", "inner_y", "roller_x", "roller_y")
OPTIONAL = ("inner_ax", "inner_ay", "inner_force", "outer_force", "inner_traction", "outer_traction")
DAMPERS = ("inner_damping_force", "outer_damping_force")  # where the scene has any
OF_SUPPORT = "energy_support"  # where the scene has a housing
SHAFT = ("inner_vx", "inner_vy", "energy_shaft")  # where springs and dashpots hold the shaft
TURN = "roller_turn"  # rotation of the rollers
SPIN = "roller_spin"  # its rate, less exact
MOST_STATED_ERRORS, LONGEST_WORDS = 1000, 2000
ATTRIBUTES = (
    "scene", "committed_samples", "format_version", "program", "program_version", "status", "warnings", "mesh_nodes",
    "degrees_of_freedom", "time_step", "critical_time_step", "steps", "wall_seconds", "setup_seconds",
)  # fmt: skip
SOLVER = "run-fem"  # attribute `program`: of a file that holds all variables


def read_result(path: str | Path) -> Record:
    """Read a run's result file up to its last committed sample.

    Errors
    ------
    InputError: no such file, not HDF5, damaged (also by its checksums), another program's, another format
    version, variables missing, of the wrong shape, not finite or in another file, irregular time, too few samples,
    too large.
    """
    path = Path(path)
    check_readable(path)
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            return checked(_from_file(path, file))
    except InputError:
        raise
    except SceneError as error:
        raise InputError(str(error)) from None
    except Damaged as error:
        raise InputError(f"{path}: damaged, or not a result file of run-fem: {error}") from None
    except (OSError, RuntimeError, LookupError, TypeError, ValueError, ArithmeticError) as error:  # h5py's, of damage
        reason = (str(error).strip("'\"").splitlines() or [type(error).__name__])[0]
        raise InputError(f"{path}: damaged or truncated HDF5 file ({reason}); run the simulation again") from None


def _from_file(path: Path, file) -> Record:
    """Read an open result file; the record is not checked yet."""
    attributes = {name: _plain(file.attrs[name]) for name in ATTRIBUTES if name in file.attrs}
    for name in ("status", "warnings", "program_version"):  # they are printed
        if name in attributes:
            attributes[name] = _words(attributes[name])
    if "scene" not in attributes or "committed_samples" not in attributes:
        raise InputError(
            f"{path}: not a result file of run-fem: the attributes scene and committed_samples are missing"
        )
    version = attributes.get("format_version")
    if version != FORMAT_VERSION:
        raise InputError(
            f"{path}: format_version = {version!r}, this program reads {FORMAT_VERSION}; run the scene again"
        )
    scene = parse_stored_scene(read_scene_text(file), f"{path}, attribute scene", read_scene_files(file))
    needed, held = _variables(scene)
    promised = [*needed, *held] if attributes.get("program") == SOLVER else needed
    missing = [name for name in promised if not has(file, name)]
    if missing:
        raise InputError(f"{path}: missing {', '.join(missing)}; is it a result file? Run the scene again")
    n = attributes["committed_samples"]
    if not isinstance(n, int) or n < 0:
        raise InputError(f"{path}: committed_samples = {n!r} must be a whole number >= 0; the file is damaged")
    if n < FEWEST_SAMPLES:
        raise InputError(f"{path}: {n} committed samples, at least {FEWEST_SAMPLES} are needed; simulate longer")
    of_cage = tuple(COLUMNS) if scene.cage is not None and all(has(file, name) for name in COLUMNS) else ()
    names = [name for name in dict.fromkeys([*needed, *held, *DAMPERS, TURN, *of_cage]) if has(file, name)]
    _check_size(path, file, names, n, scene)
    arrays = {name: read_numbers(file, name, n) for name in names}
    if TURN not in arrays and has(file, SPIN):  # of a run on perfect surfaces, so that its record looks like any other
        _check_size(path, file, [SPIN], n, scene)
        arrays[TURN] = _turned(arrays["time"], read_numbers(file, SPIN, n))
    coarsest = max(np.finfo(file[name].dtype).eps for name in ("inner_x", "inner_y"))
    energies = {name: arrays.pop(name) for name in (*ENERGIES, *OF_MOUNTING) if name in arrays}
    arrays = relative(arrays, scene.mounting().centre)
    cage = CageMotion(**{COLUMNS[name]: arrays.pop(name) for name in of_cage}) if of_cage else None
    status = attributes.setdefault("status", "unknown")
    notes = [warning for warning in attributes.get("warnings", "").splitlines() if warning]
    if status != "complete":
        notes.append(f"the run is not complete (status: {status}); its first {n} samples are used")
    elif file["time"].shape[0] > n:
        notes.append(f"only the first {n} of {file['time'].shape[0]} samples are committed")
    return Record(
        name=shown(path.stem), source=path, scene=scene, energies=energies, cage=cage, attributes=attributes,
        stated_errors=_stated_errors(file), notes=tuple(notes), precision=float(coarsest), slices=_slices(file, scene),
        **arrays,
    )  # fmt: skip


def _variables(scene: Scene) -> tuple[list[str], list[str]]:
    """Names of the variables that a check of the scene's run needs, and of those that the solver's file holds too."""
    mounting = scene.mounting()
    held = [*OPTIONAL, *(name for name in mounting.columns if name.endswith(("_ax", "_ay")))]
    held += [OF_SUPPORT] if mounting.housing is not None else []
    held += SHAFT if mounting.shaft is not None else ()
    held += columns_of(*scene.parts_of_tilt)
    held += [*ENERGIES, *(DAMPERS if scene.damping.acts else ())]
    return [*MOTION, *mounting.centre[:2]], held


def _slices(file, scene: Scene) -> tuple[Slices, Slices] | None:
    """Of contacts of rollers that tilt: as stored, or of the Lagrangian model's law."""
    axial, bearing = scene.ideal_axial(), scene.perfect_bearing()
    if axial is None:
        return None
    if scene.model == "lagrange":
        return contact_slices(bearing, axial, contact_laws(scene.lagrange.law, bearing))
    return read_slices(file, bearing, axial)


def _turned(time: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """How far rollers have turned, rad, by their spins, rad/s; from 0 at t = 0, by the trapezoidal rule."""
    from scipy.integrate import cumulative_trapezoid

    return time[0] * spin[:1] + cumulative_trapezoid(spin, time, axis=0, initial=0.0)


def _stated_errors(file) -> tuple[StatedError, ...]:
    """Read the errors that `run-fem --estimate-error` has stated in the file."""
    names = ("quantity_meaning", "quantity_unit", "quantity_value", "quantity_error")
    if not all(has(file, name) for name in names):
        return ()
    columns = []
    for name in names:
        numbers = name in ("quantity_value", "quantity_error")
        check_array(file, name, 0, kinds="f" if numbers else "OS", dimensions=(1,))
        if len(file[name]) > MOST_STATED_ERRORS:
            raise Damaged(f"{name} holds {len(file[name])} values, at most {MOST_STATED_ERRORS} are read")
        columns.append([_plain(value) if numbers else _words(_plain(value)) for value in file[name][:]])
    return tuple(
        StatedError(meaning=meaning, unit=unit, value=value, error=error)
        for meaning, unit, value, error in zip(*columns, strict=True)
    )


def _words(value: object) -> str:
    """Make text fit to be printed."""
    return "".join(c if c.isprintable() or c == "\n" else "?" for c in str(value)[:LONGEST_WORDS])


def _check_size(path: Path, file, names: list[str], n: int, scene: Scene) -> None:
    """Refuse wrong kinds, shapes and sizes before anything is read."""
    size = 0
    for name in names:
        check_array(file, name, n)
        shape = file[name].shape
        if len(shape) == 2 and shape[1] != scene.bearing.present:
            raise InputError(f"{path}: {name} holds {shape[1]} rollers, its scene says {scene.bearing.present}")
        size += 8 * n * (shape[1] if len(shape) == 2 else 1)
    if size > LARGEST_READ:
        raise InputError(
            f"{path}: {size / 2**30:.1f} GiB of arrays, at most {LARGEST_READ / 2**30:.0f} are read; "
            "store less often (numerics.output_interval_us)"
        )


def is_result(path: Path) -> bool:
    """Whether a file looks like HDF5 (or bears a result file's name), so that a table is not expected."""
    if path.suffix.lower() in (".nc", ".h5", ".hdf5"):
        return True
    with path.open("rb") as file:
        return file.read(len(SIGNATURE)) == SIGNATURE


def check_readable(path: Path) -> None:
    """Refuse a file that is plainly no result file or table: missing, empty, unreadable, misnamed."""
    if not path.exists():
        raise InputError(f"{path}: no such file; give the path of a result file or a table, or run run-fem first")
    if not path.is_file():
        raise InputError(f"{path}: not a file; give the path of a result file or a table")
    if path.stat().st_size == 0:
        raise InputError(f"{path}: the file is empty; run the simulation again")
    try:
        with path.open("rb") as file:
            start = file.read(len(SIGNATURE))
    except OSError as error:
        raise InputError(f"{path}: can't be read: {error.strerror}") from None
    if path.suffix.lower() in (".nc", ".h5", ".hdf5") and start != SIGNATURE:
        raise InputError(f"{path}: not an HDF5 file; give a result file of run-fem, or a table named .csv")


def _plain(value):
    """Convert an HDF5 attribute into a plain Python value."""
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, np.ndarray):
        return _plain(value.item()) if value.size == 1 else value.tolist()
    return value
