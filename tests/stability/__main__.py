"""Random bearings over everything the program accepts: each must end well, or say what is wrong.

    python -m tests.stability                       # 200 bearings in machines, all models
    python -m tests.stability --alone --count 500   # bearings alone, finite elements

A scene ends in one of these ways:

* complete: every sample finite, every body in its place, energy balanced within 1 % of the exchanged energy, forces
  and momentum as the checker has them, the start in equilibrium;
* refused: the scene can't be used, said before the first step;
* stopped: the run saw its own trouble and said so, with step, time and body;
* FAILED: anything else, a crash, a hang, or a wrong result nobody noticed. `--only N` runs that one again.
"""

import sys
import time
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import tomli_w
from cyclopts import App

from tests.stability.campaign import Lines, campaign, ended, report
from tests.stability.machine import drawn

app = App(help=__doc__, help_format="markdown")


@app.default
def main(
    *, count: int = 200, seed: int = 1, alone: bool = False, sets: int = 48, only: int | None = None,
    output: Path | None = None, seconds: float = 1e9,
) -> None:  # fmt: skip
    """Run scenes and print how they ended.

    Parameters
    ----------
    count: how many
    seed: of the draw; scene `number` of a seed and a number of sets is always the same
    alone: finite elements of bearings without what stands around them
    sets: of tables, each of which compiles a time loop of its own
    only: run this one scene, print it and its ending
    output: CSV, a line a scene; scenes that it holds are counted, and not run again
    seconds: of wall time, after which no further scene begins
    """
    draw = partial(drawn, seed, alone, sets)
    if only is not None:
        with TemporaryDirectory() as place:
            tables = draw(only, Path(place))
            print(ended(tables, Path(place), only), tomli_w.dumps(tables), sep="\n")
        return
    rows = list(campaign(draw, range(count), Lines(output), time.monotonic() + seconds))
    sys.exit(report(rows, f"random scenes, seed {seed}"))


if __name__ == "__main__":
    app()
