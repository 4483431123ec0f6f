"""The command `run-live`. Imports little: everything heavy waits until a scene has been read."""

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from fem.commands.start_up import run_app_main, standard_bearing
from lagrange.commands import entry, new_app

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
def _live(
    scene: Annotated[Path | None, Parameter(help="scene file (TOML); default: the paper's bearing")] = None,
    /,
    *,
    bearing: Annotated[str | None, Parameter(help="standard bearing instead of the scene's, e.g. NU206/C3")] = None,
    set: Annotated[list[str] | None, Parameter(help="any scene key: table.key=value; repeatable", negative="")] = None,
) -> int:
    from lagrange.messages import say, telling
    from lagrange.scene.scene import read_scene

    chosen = read_scene(scene, (*standard_bearing(bearing), *(set or ()), "model=reduced"))
    import asyncio

    from fem.live.player import Player
    from fem.live.server import LiveServer

    def announce(address: str) -> None:
        with telling():
            print(f"Live: {address}\nCtrl-C ends it.")

    asyncio.run(LiveServer(Player(chosen, say)).run(announce))
    return 0


live_main = partial(run_app_main, live_app)
run_live = entry(live_main)

if __name__ == "__main__":
    run_live()
