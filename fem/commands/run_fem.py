"""The commands `run-fem` and `run-live`. Little is imported: everything heavy waits until a scene has been read."""

import json
import re
import zlib
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Literal

from fem.commands.start_up import run_app_main, standard_bearing
from fem.solver.simulate import SOLVERS
from lagrange.commands import new_app
from lagrange.errors import UsageError

RUNS = Path("runs")
EXAMPLES = ("paper", "NU206", "spindle", "faults", "table", "all")  # of fem.examples, which imports much for --help
LONGEST_NAME = 120  # characters of a result's name; file systems take 255 bytes with the ending

run_app = new_app(
    "run-fem",
    """Simulate a roller bearing and write one result file.

Without a scene: the bearing of Rubio et al. (2007) at 4500 rpm under 2000 N, for 60 ms. With --model reduced: elastic
bodies without their mass, faster than the bearing turns. With --model lagrange: rigid bodies on contact springs, the
model that check-residual checks. All write files of the same form.

Contacts (--set contact.model=...): subgrid, the default; resolved, on meshes finer than the contact; for comparison,
as on coarse meshes elsewhere: penalty springs, and faceted, polygons instead of circles.

Example: run-fem my-bearing.toml --mesh-size 2 --duration 10 --set operation.speed_rpm=3000

Exit codes: 0 done; 1 the run failed numerically; 2 unusable input; 130 interrupted; 143 terminated.
""",
)


@run_app.default
def _run(
    scene: Path | None = None, /, *, output: Path | None = None, model: Literal[tuple(SOLVERS)] | None = None,
    mesh_size: float | None = None, duration: float | None = None, bearing: str | None = None,
    set: list[str] | None = None, dry_run: bool = False, converge: bool = False, resume: bool = False,
    force: bool = False, estimate_error: bool = False, checkpoint: float | None = None,
    example: Literal[EXAMPLES] | None = None, schema: bool = False, quiet: bool = False,
) -> int:  # fmt: skip
    """
    Args:
        scene: scene file (TOML); default: the paper's bearing
        output: result file; default: runs/<scene name>.nc, with the values of --set in its name
        model: solver; default: the scene's
        mesh_size: distance of surface nodes, mm
        duration: simulated time, ms; 0: static equilibrium only
        bearing: standard bearing instead of the scene's, e.g. NU206/C3
        set: any scene key: table.key=value; repeatable
        dry_run: check the scene and show the plan, without running
        converge: show statics on three meshes with Richardson's extrapolation, without running
        resume: resume from the checkpoint of the output file
        force: replace a complete run of another scene
        estimate_error: also run a mesh half as fine and state the discretisation error of each result
        checkpoint: wall time between checkpoints, s; default: 10, more on slow disks
        example: write a commented scene (all: with every key) here or to --output, without running
        schema: print the scene's JSON schema, for editors
        quiet: show no progress and no summary
    """
    if example is not None:
        from fem.examples import write_example
        from lagrange.messages import shown

        written, *others = write_example(example, output, force)
        for file in (written, *others):
            print(f"wrote {shown(file)}")
        checked = (
            f"check-residual {shown(others[0])} --scene {shown(written)}" if others else f"run-fem {shown(written)}"
        )
        print(f"next: {checked}")
        return 0
    from lagrange.scene import scene as scenes

    if schema:
        print(json.dumps(scenes.Scene.model_json_schema(), indent=1, ensure_ascii=False))
        return 0

    settings, keys = set or [], {"model": model, "numerics.mesh_size_mm": mesh_size, "numerics.duration_ms": duration}
    given = (f"{key}={value}" for key, value in keys.items() if value is not None)
    chosen = scenes.read_scene(scene, (*standard_bearing(bearing), *settings, *given))
    path = output if output is not None else RUNS / f"{result_name(chosen.name, settings)}.nc"
    if path.is_dir():
        raise UsageError(f"--output {path}: is a folder; name a file in it")
    if checkpoint is not None and not checkpoint >= 0.0:
        raise UsageError(f"--checkpoint {checkpoint:g}: must be a number of seconds >= 0")
    from fem.result.checkpoint import refuse_another_run
    from fem.runner import RunOptions, run_scene, show_meshes, show_plan

    if converge:
        show_meshes(chosen, path.stem)
        return 0
    if dry_run:
        return show_plan(chosen, path.stem).code
    if not (force or resume):
        refuse_another_run(path, chosen)
    options = RunOptions(resume=resume, quiet=quiet, estimate_error=estimate_error, checkpoint_seconds=checkpoint)
    return run_scene(chosen, path, options).code


def result_name(scene_name: str, settings: Sequence[str]) -> str:
    """A result's name without its ending: the scene's, and what `--set` has changed.

    The duration and the name itself are left out: --resume finds a run that it makes longer."""
    changes = []
    for setting in settings:
        key, _, value = setting.partition("=")
        parts = [part.strip() for part in key.split(".")]
        if parts[-1] in ("name", "duration_ms"):
            continue
        short = parts if any(part.isdecimal() for part in parts) else parts[-1:]
        changes.append(re.sub(r"[^A-Za-z0-9._+-]+", "_", f"-{'.'.join(short)}-{value.strip()}"))
    whole = scene_name + "".join(changes)
    return whole if len(whole) <= LONGEST_NAME else f"{whole[:LONGEST_NAME]}-{zlib.crc32(whole.encode()):08x}"


live_app = new_app(
    "run-live",
    """Play a bearing in the browser while it is computed, by the reduced model, in slow motion or in real time.

Prints an address to open on this machine; it holds until the command ends. Speed, load, clearance, friction and
spalls can be changed as it runs. No result file is written: the page saves its scene, for run-fem.

Example: run-live my-bearing.toml --set operation.speed_rpm=3000

Exit codes: 1 the run has no start; 2 unusable input; 130 ended by Ctrl-C.
""",
)


@live_app.default
def _live(scene: Path | None = None, /, *, bearing: str | None = None, set: list[str] | None = None) -> int:
    """
    Args:
        scene: scene file (TOML); default: the paper's bearing
        bearing: standard bearing instead of the scene's, e.g. NU206/C3
        set: any scene key: table.key=value; repeatable
    """
    from lagrange.messages import say, telling
    from lagrange.scene.scene import read_scene

    chosen = read_scene(scene, (*standard_bearing(bearing), *(set or ()), "model=reduced"))
    import asyncio

    from fem.live.player import Player
    from fem.live.server import LiveServer

    def announce(address):
        with telling():
            print(f"Live: {address}\nCtrl-C ends it.")

    asyncio.run(LiveServer(Player(chosen, say)).run(announce))
    return 0


run_main, live_main = partial(run_app_main, run_app), partial(run_app_main, live_app)
