"""The solver's result file (HDF5) -> `Trajectory`; tables are read in `table_source`."""

from pathlib import Path

import numpy as np

from lagrange.scene import Scene, SceneError, parse_scene_text
from residual.trajectory import FEWEST_SAMPLES, Estimate, InputError, Trajectory, checked

FORMAT_VERSION = 1
LARGEST_READ = 4 * 2**30  # bytes of arrays held in memory
MOTION = ("time", "inner_x", "inner_y", "roller_x", "roller_y")
OPTIONAL = ("inner_ax", "inner_ay", "inner_force", "outer_force", "inner_traction", "outer_traction")
ENERGIES = ("energy_kinetic", "energy_elastic", "energy_contact", "work_external", "work_dissipated")


def read_result(path: str | Path) -> Trajectory:
    """A run's result file, up to its last committed sample.

    Errors
    ------
    InputError: no such file, not HDF5, damaged, another program's, another format version, variables missing,
    of the wrong shape or not finite, irregular time, too few samples.
    """
    import h5py

    path = Path(path)
    check_readable(path)
    try:
        with h5py.File(path, "r", locking=False) as file:
            return checked(_from_file(path, file))
    except InputError:
        raise
    except SceneError as error:
        raise InputError(str(error)) from None
    except (OSError, RuntimeError, KeyError, UnicodeDecodeError) as error:
        reason = str(error).strip("'\"").splitlines()[0]
        raise InputError(f"{path}: damaged or truncated HDF5 file ({reason}); run the simulation again") from None


def _from_file(path: Path, file) -> Trajectory:
    """Unchecked trajectory of an open result file."""
    attributes = {key: _plain(value) for key, value in file.attrs.items()}
    if "scene" not in attributes or "committed_samples" not in attributes:
        raise InputError(
            f"{path}: not a result file of run-fem: the attributes scene and committed_samples are missing"
        )
    version = attributes.get("format_version")
    if version != FORMAT_VERSION:
        raise InputError(
            f"{path}: format_version = {version!r}, this program reads {FORMAT_VERSION}; use matching versions"
        )
    scene = parse_scene_text(str(attributes["scene"]), f"{path}, attribute scene")
    missing = [name for name in MOTION if name not in file]
    if missing:
        raise InputError(f"{path}: missing {', '.join(missing)}; is it a result file of run-fem?")
    n = attributes["committed_samples"]
    if not isinstance(n, int) or n < 0:
        raise InputError(f"{path}: committed_samples = {n!r} must be a whole number >= 0; the file is damaged")
    if n < FEWEST_SAMPLES:
        raise InputError(f"{path}: {n} committed samples, at least {FEWEST_SAMPLES} are needed; simulate longer")
    names = [name for name in (*MOTION, *OPTIONAL, *ENERGIES) if name in file]
    _check_datasets(path, file, names, n, scene)
    arrays = {name: file[name][:n].astype(float) for name in names}
    coarsest = max(np.finfo(file[name].dtype).eps for name in ("inner_x", "inner_y"))
    energies = {name: arrays.pop(name) for name in ENERGIES if name in arrays}
    status = str(attributes.get("status", "unknown"))
    notes = []
    if status != "complete":
        notes.append(f"the run is not complete (status: {status}); its first {n} samples are used")
    elif file["time"].shape[0] > n:
        notes.append(f"only the first {n} of {file['time'].shape[0]} samples are committed")
    return Trajectory(
        name=path.stem, source=path, scene=scene, energies=energies, attributes=attributes,
        estimates=_estimates(file), notes=tuple(notes), precision=float(coarsest), **arrays,
    )  # fmt: skip


def _estimates(file) -> tuple[Estimate, ...]:
    """Error estimates, where `run-fem --estimate-error` has left any."""
    names = ("quantity_meaning", "quantity_unit", "quantity_value", "quantity_error")
    if any(name not in file for name in names):
        return ()
    columns = [[_plain(value) for value in file[name][:]] for name in names]
    return tuple(
        Estimate(meaning=meaning, unit=unit, value=value, error=error)
        for meaning, unit, value, error in zip(*columns, strict=True)
    )


def _check_datasets(path: Path, file, names: list[str], n: int, scene: Scene) -> None:
    """Kinds, shapes and sizes, before anything is read."""
    import h5py

    size = 0
    for name in names:
        data = file[name]
        if not isinstance(data, h5py.Dataset) or data.dtype.kind != "f":
            raise InputError(f"{path}: {name} is not an array of floating-point numbers; the file is damaged")
        if data.ndim not in (1, 2) or data.shape[0] < n:
            raise InputError(
                f"{path}: {name} has shape {data.shape} but {n} samples are committed; the file is truncated"
            )
        if data.ndim == 2 and data.shape[1] != scene.bearing.rollers:
            raise InputError(f"{path}: {name} holds {data.shape[1]} rollers, its scene says {scene.bearing.rollers}")
        size += 8 * n * (data.shape[1] if data.ndim == 2 else 1)
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
        return file.read(8) == b"\x89HDF\r\n\x1a\n"


def check_readable(path: Path) -> None:
    """The commonest mistakes, said plainly."""
    if not path.exists():
        raise InputError(f"{path}: no such file; give the path of a result file or a table, or run run-fem first")
    if not path.is_file():
        raise InputError(f"{path}: not a file; give the path of a result file or a table")
    if path.stat().st_size == 0:
        raise InputError(f"{path}: the file is empty; run the simulation again")
    try:
        with path.open("rb") as file:
            start = file.read(8)
    except OSError as error:
        raise InputError(f"{path}: can't be read: {error.strerror}") from None
    if path.suffix.lower() in (".nc", ".h5", ".hdf5") and start != b"\x89HDF\r\n\x1a\n":
        raise InputError(f"{path}: not an HDF5 file; give a result file of run-fem, or a table named .csv")


def _plain(value):
    """An HDF5 attribute as a plain Python value."""
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, np.ndarray):
        return _plain(value.item()) if value.size == 1 else value.tolist()
    return value
