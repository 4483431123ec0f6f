"""The solver's whole state on disk: a run goes on from it bit for bit.

One file beside the result, written whole and moved into place, after the samples it counts have reached the disk.
Plain arrays and a line of JSON; nothing in it is ever executed.
"""

import json
import os
import zipfile
from pathlib import Path

import numpy as np

from fem.errors import UsageError
from fem.jit import cache_folder
from fem.samples import SampleReader
from fem.simulate import Plan, RunState
from lagrange.scene import Scene, SceneError, parse_scene_text

FORMAT = 1
GROUPS = ("rollers", "inner", "outer", "contacts", "drive")


def checkpoint_path(result: Path) -> Path:
    """Where the state of a result file's run is kept."""
    return result.with_name(result.name + ".checkpoint")


def save_checkpoint(result: Path, plan: Plan, state: RunState) -> None:
    """Write the state after its last sample, atomically."""
    path = checkpoint_path(result)
    arrays = {
        f"{group}.{name}": value
        for group in GROUPS
        for name, value in getattr(state.arrays, group)._asdict().items()
        if isinstance(value, np.ndarray)
    }
    arrays |= {f"reader.{name}": value for name, value in state.reader.carried().items()}
    arrays["meta"] = np.array(
        json.dumps(
            {
                "format": FORMAT,
                "samples": state.done,
                "wall_seconds": state.wall,
                "kernels": cache_folder().name,
                "scene": plan.scene.to_toml(),
            }
        )
    )
    temporary = path.with_name(path.name + ".part")
    try:
        with open(temporary, "wb") as file:
            np.savez(file, **arrays)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def load_checkpoint(result: Path, plan: Plan) -> RunState:
    """The state to go on from.

    Errors
    ------
    UsageError: no checkpoint, a damaged one, another scene or another version of the program (the difference is named).
    """
    path = checkpoint_path(result)
    if not path.is_file():
        raise UsageError(f"{path}: not found; there is nothing to resume, start again without --resume")
    try:
        with np.load(path, allow_pickle=False) as file:
            meta = json.loads(str(file["meta"]))
            _check(path, meta, plan.scene)
            arrays = plan.arrays()
            for group in GROUPS:
                for name, value in getattr(arrays, group)._asdict().items():
                    if isinstance(value, np.ndarray):
                        value[...] = file[f"{group}.{name}"]
            reader = SampleReader(plan)
            reader.carry_on({name: file[f"reader.{name}"] for name in reader.carried()})
            return RunState(arrays=arrays, reader=reader, done=int(meta["samples"]), wall=float(meta["wall_seconds"]))
    except (OSError, KeyError, ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, UsageError):
            raise
        raise UsageError(f"{path}: damaged ({type(error).__name__}); start again without --resume") from None


def _check(path: Path, meta: dict, scene: Scene) -> None:
    """Refuse a state that would not go on as it began. Another duration is welcome."""
    if meta["format"] != FORMAT or meta["kernels"] != cache_folder().name:
        raise UsageError(f"{path}: written by another version of the program; start again without --resume")
    try:
        before = parse_scene_text(meta["scene"], str(path))
    except SceneError:
        raise UsageError(f"{path}: its scene can't be read; start again without --resume") from None
    old, new = (_flat(s.model_dump()) for s in (before, scene))
    changed = [
        f"{key} was {old.get(key)!r}, now {new.get(key)!r}" for key in sorted(old | new) if old.get(key) != new.get(key)
    ]
    changed = [text for text in changed if not text.startswith("numerics.duration_ms")]
    if changed:
        raise UsageError(f"--resume: the scene has changed ({'; '.join(changed)}); give the same scene or start again")


def _flat(tables: dict, prefix: str = "") -> dict:
    flat = {}
    for key, value in tables.items():
        flat |= _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
    return flat
