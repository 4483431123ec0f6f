"""A run's whole state on disk: it goes on from there bit for bit.

One file beside the result, written whole and moved into place, after the samples it counts have reached the disk.
Plain arrays and a line of JSON, which the solver's state gives and takes back; nothing in it is ever executed.
"""

import json
from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from fem.result.store import Stored, variables_of
from fem.solver.solver import Plan, RunState
from lagrange.errors import UsageError
from lagrange.files.hdf5 import Damaged, read_scene_text
from lagrange.files.input import read_plain
from lagrange.files.output import real_path, replaced
from lagrange.scene.scene import Scene, SceneError, parse_scene_text, parse_stored_scene
from lagrange.version import VERSION

FORMAT = 17
FIRST = b"meta.npy"  # in the archive
LONGEST_START = 30 + len(FIRST)  # bytes of an archive up to the end of its first file's name
MOST_CHANGES = 3  # named of another scene


def differences(before: Mapping[str, object], now: Mapping[str, object]) -> list[str]:
    """A phrase for each key, dotted where it is of a table in a table, whose values differ."""
    changed = []
    for key in sorted(before | now):
        old, new = before.get(key), now.get(key)
        if isinstance(old, dict) or isinstance(new, dict):
            tables = (table if isinstance(table, dict) else {} for table in (old, new))
            changed += [f"{key}.{phrase}" for phrase in differences(*tables)]
        elif old != new:
            changed.append(f"{key} was {old!r}, now {new!r}")
    return changed


def refuse_another_run(path: Path, scene: Scene) -> None:
    """UsageError: a complete run of another scene would be replaced; a damaged file and one without a run may go."""
    if not path.is_file():  # a pipe would be waited for
        return
    try:
        with h5py.File(path, "r", locking=False) as file:
            if file.attrs.get("status") != "complete":
                return
            before = parse_stored_scene(read_scene_text(file), str(path))
    except (OSError, RuntimeError, KeyError, TypeError, Damaged, SceneError):
        return
    if changed := differences(before.model_dump(), scene.model_dump()):
        more = [f"and {len(changed) - MOST_CHANGES} more"] if changed[MOST_CHANGES:] else []
        longer = len(changed) == 1 and before.numerics.duration_ms < scene.numerics.duration_ms
        raise UsageError(
            f"{path}: holds a complete run of another scene ({'; '.join([*changed[:MOST_CHANGES], *more])}); "
            f"{'--resume extends it, ' if longer else ''}--force replaces it, --output names another file"
        )


def checkpoint_path(result: Path) -> Path:
    """Where the state of a result file's run is kept."""
    result = real_path(result)
    return result.with_name(result.name + ".checkpoint")


def refuse_no_place(result: Path) -> None:
    """Refuse a result file beside which no checkpoint can stand. UsageError. OSError: its name is too long."""
    path = checkpoint_path(result)
    if path.is_symlink() or (path.exists() and not path.is_file()):
        raise UsageError(f"{path}: is not a plain file, but the checkpoint goes there; name another --output")
    start = read_plain(path, LONGEST_START) if path.exists() else b""  # an empty one may go
    if start and not (start.startswith(b"PK\x03\x04") and start.endswith(FIRST)):
        raise UsageError(
            f"{path}: is no checkpoint of this program and is not replaced; move it, or name another --output"
        )


def refuse_nothing_to_resume(result: Path) -> None:
    """UsageError: there is no checkpoint to go on from."""
    path = checkpoint_path(result)
    if not path.is_file():
        raise UsageError(f"{path}: not found; there is nothing to resume, start again without --resume")


def save_checkpoint(result: Path, state: RunState, stored: Stored) -> None:
    """Write the state after its last sample, atomically; `stored`, those samples, must be on the disk.
    OSError: it can't be written; an earlier checkpoint stays."""
    plan, (arrays, numbers) = state.plan, state.to_keep()
    meta = {
        "format": FORMAT, "versions": {"program": VERSION, **plan.versions()}, "samples": stored.samples,
        "checksums": stored.checksums, "wall_seconds": state.wall, "void_steps": state.void_steps,
        "imbalance": state.imbalance, "numbers": numbers, "scene": plan.scene.to_toml(),
    }  # fmt: skip
    with replaced(checkpoint_path(result), durable=True) as part, open(part, "wb") as file:
        arrays = {name: np.asarray(value, order="C") for name, value in arrays.items()}
        np.savez(file, meta=np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8), **arrays)


def load_checkpoint(result: Path, plan: Plan) -> tuple[RunState, Stored]:
    """The state to go on from, and what the result file must hold.
    UsageError: no checkpoint, a damaged one, another scene or another version of the program (the difference is named),
    or a duration that is behind already."""
    refuse_nothing_to_resume(result)
    path, state = checkpoint_path(result), plan.first_state()
    try:
        with np.load(path) as archive:  # its members' checksums are verified
            meta = json.loads(archive["meta"].tobytes())
            # refuse a state that would not go on as it began; another duration is welcome
            if meta["format"] != FORMAT:
                raise UsageError(f"of format {meta['format']!r}, this program has {FORMAT}; start again")
            try:
                before = parse_scene_text(meta["scene"], "").model_dump()
                before["numerics"]["duration_ms"] = plan.scene.numerics.duration_ms
            except SceneError:
                before = None
            if before and (changed := differences(before, plan.scene.model_dump())):
                raise UsageError(f"the scene has changed ({'; '.join(changed)}); give the same scene or start again")
            now = {"program": VERSION, **plan.versions()}  # all that decides the bits of a run
            if changed := differences({str(key): value for key, value in meta["versions"].items()}, now):
                raise UsageError(
                    "written by another version of the program, or on another processor, whose results differ in the "
                    f"last bits ({'; '.join(changed)}); resume with that one, or start again without --resume"
                )
            if before is None:
                raise UsageError("its scene can't be read; start again without --resume")
            samples, checksums = int(meta["samples"]), meta["checksums"]
            state.done, state.void_steps = samples, int(meta["void_steps"])
            state.wall, state.imbalance = float(meta["wall_seconds"]), float(meta["imbalance"])
            expected, _ = state.to_keep()
            arrays = {name: archive[name] for name in expected}
        if any((arrays[name].dtype, arrays[name].shape) != (a.dtype, a.shape) for name, a in expected.items()):
            raise ValueError("arrays of another plan")
        names = variables_of(plan.scene) if samples else ()
        stored = Stored(samples=samples, checksums={name: int(checksums[name]) for name in names})
        state.take_back(arrays, meta["numbers"])
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None
    except Exception as error:  # an archive can be damaged in more ways than there are errors to name here
        raise UsageError(f"{path}: damaged ({type(error).__name__}); start again without --resume") from None
    if samples > plan.n_samples:
        raise UsageError(
            f"numerics.duration_ms = {plan.scene.numerics.duration_ms:g}: the run has reached "
            f"{1e3 * (samples - 1) * plan.interval:.6g} ms already; --resume needs at least that"
        )
    return state, stored
