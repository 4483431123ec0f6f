"""What stands in a result's place before a run begins: nothing, a file to be replaced, or one to go on with."""

from collections.abc import Mapping
from pathlib import Path

import h5py

from fem.result.durable import is_in_use
from lagrange.errors import UsageError
from lagrange.files.hdf5 import SIGNATURE, Damaged, check_array, read_scene_text
from lagrange.scene.scene import Scene, SceneError, parse_stored_scene

MOST_CHANGES = 3  # named of another scene


def differences(before: Mapping[str, object], now: Mapping[str, object]) -> list[str]:
    """A phrase for each key whose values differ."""
    return [
        f"{key} was {before.get(key)!r}, now {now.get(key)!r}"
        for key in sorted(before | now)
        if before.get(key) != now.get(key)
    ]


def scene_keys(scene: Scene) -> dict[str, object]:
    """Values of a scene by their dotted keys."""
    return _flat(scene.model_dump())


def _flat(tables: dict, prefix: str = "") -> dict[str, object]:
    flat = {}
    for key, value in tables.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
    return flat


def refuse_foreign(path: Path) -> None:
    """Refuse to replace what can't have been a result file, such as the scene itself.

    Errors
    ------
    UsageError. OSError: a file that can't be read.
    """
    if not path.is_file():
        return
    with open(path, "rb") as file:
        start = file.read(len(SIGNATURE))
    if start not in (b"", SIGNATURE):
        raise UsageError(f"{path}: is no result file (HDF5) and is not replaced; name another with --output")


def refuse_another_run(path: Path, scene: Scene) -> None:
    """Refuse to replace a complete run of another scene; a damaged file and one that holds no run may go.

    Errors
    ------
    UsageError.
    """
    if not path.is_file():
        return
    try:
        with h5py.File(path, "r", locking=False) as file:
            if file.attrs.get("status") != "complete":
                return
            before = parse_stored_scene(read_scene_text(file), str(path))
    except (OSError, RuntimeError, KeyError, TypeError, Damaged, SceneError):
        return
    if changed := differences(scene_keys(before), scene_keys(scene)):
        more = [f"and {len(changed) - MOST_CHANGES} more"] if changed[MOST_CHANGES:] else []
        named = [*changed[:MOST_CHANGES], *more]
        longer = len(changed) == 1 and before.numerics.duration_ms < scene.numerics.duration_ms
        raise UsageError(
            f"{path}: holds a complete run of another scene ({'; '.join(named)}); "
            f"{'--resume extends it, ' if longer else ''}--force replaces it, --output names another file"
        )


def refuse_if_in_use(path: Path) -> None:
    """Refuse to replace what is open elsewhere or no plain file. UsageError. OSError: a file that can't be written."""
    if not path.exists():
        return
    if not path.is_file():
        raise UsageError(f"{path}: is not a plain file; name another with --output")
    if is_in_use(path):
        raise UsageError(f"{path}: is in use, by another run or a program that reads it; name another with --output")


def check_earlier(path: Path, names: tuple[str, ...], samples: int, frames: int) -> None:
    """Refuse to go on with a file that does not hold so many samples of the variables, and frames of fields.

    Errors
    ------
    UsageError.
    """
    if not path.is_file():
        raise UsageError(f"{path}: not found, though its checkpoint is there; start again without --resume")
    try:
        with h5py.File(path, "r", locking=False) as file:
            if int(file.attrs["committed_samples"]) < samples:
                raise Damaged(f"its checkpoint counts {samples} samples, it holds fewer")
            for name in names:
                check_array(file, name, samples)
            if frames:
                from fem.result.fields import stored_samples

                if len(stored_samples(file, samples)) != frames:
                    raise Damaged(f"its checkpoint counts {frames} frames of fields, it holds others")
    except (OSError, RuntimeError, KeyError, TypeError, ValueError) as error:
        raise UsageError(f"{path}: can't be resumed ({error}); start again without --resume") from None
