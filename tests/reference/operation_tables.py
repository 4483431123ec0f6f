"""Scenes whose speed or load come from tables, and their records as the checker sees them."""

from pathlib import Path
from types import SimpleNamespace

from lagrange.scene.scene import Scene, read_scene
from residual.record import Record

RAMP = "time_ms,speed_rpm\n0,1000\n2,1500\n6,5000\n8,6000\n"
LOADS = "time_ms,x_N,y_N\n0,0,-2000\n2,500,-1500\n4,500,-2500\n10,-300,-2000\n"


def scene_with(
    folder: Path, *settings: str, speeds: str | None = None, loads: str | None = None, more: str = ""
) -> Scene:
    """A scene in a folder with its tables, texts; `settings` as --set takes them, `more` after [operation]."""
    lines = ["[operation]"]
    for key, text in (("speed_table", speeds), ("load_table", loads)):
        if text is not None:
            (folder / f"{key}.csv").write_text(text, encoding="utf-8")
            lines.append(f'{key} = "{key}.csv"')
    path = folder / "scene.toml"
    path.write_text("\n".join([*lines, more]), encoding="utf-8")
    return read_scene(path, settings)


def record_of(scene: Scene, run: SimpleNamespace) -> Record:
    """A Lagrangian run as a record."""
    return Record(
        name="run", source=Path("run"), scene=scene, time=run.time, inner_x=run.inner_x, inner_y=run.inner_y,
        roller_x=run.roller_x, roller_y=run.roller_y, inner_ax=run.inner_ax, inner_ay=run.inner_ay,
        inner_force=run.inner_force, outer_force=run.outer_force, attributes={"program": "run-fem"},
    )  # fmt: skip
