"""Random bearings over everything the program accepts: each must end well, or say what is wrong.

    python -m tests.stability                   # 500 scenes of 5 ms, ten of 0.5 s, the map of the time step
    python -m tests.stability --surfaces        # of 1 ms, with spalls, waves and unequal rollers

A scene ends in one of these ways:

* complete: every sample finite, every body in its place, energy balanced within 1 % of the exchanged energy;
* refused: the scene can't be used, said before the first step;
* stopped: the run saw its own trouble and said so, with step, time and body;
* FAILED: anything else, a crash, a hang, or a wrong result nobody noticed. `--only N` runs that one again.

The file grows by a line a scene; `--resume` goes on with it.
"""

import sys
import time
from functools import partial
from itertools import count as numbers_from
from pathlib import Path
from tempfile import TemporaryDirectory

import tomli_w
from cyclopts import App

from tests.stability.campaign import REFUSED, TIME_LIMIT, Lines, Row, campaign, ended, report
from tests.stability.random_scenes import LONG_FROM, LONG_MS, RANGES, drawn

app = App(help=__doc__, help_format="markdown")


@app.default
def main(
    *, count: int = 500, long: int = 10, seed: int = 1, duration: float = 5.0, surfaces: bool = False,
    only: int | None = None, seconds: float = 1e9, resume: bool = False, output: Path | None = None,
    step_limit: bool = True,
) -> None:  # fmt: skip
    """Run random scenes and draw the map of the time step's limit.

    Parameters
    ----------
    count: how many scenes
    long: how many scenes of 0.5 s after them, not counting those that are refused
    seed: of the draw; scene `number` of a seed is always the same
    duration: simulated time of a scene, ms
    surfaces: scenes of 1 ms with spalls, waves and unequal rollers, no long ones, no map
    only: run this one scene, print it and its ending
    seconds: start no further scene after this wall time
    resume: keep the lines of the output file and go on after them
    output: CSV file, one line a scene, written as they end; the plot of the map stands beside it
    step_limit: also map energy drift against time step
    """
    draw, until = partial(drawn, surfaces, seed, duration), time.monotonic() + seconds
    if only is not None:
        with TemporaryDirectory() as place:
            print(ended(draw(only, Path(place)), Path(place), only), tomli_w.dumps(draw(only, Path(place))), sep="\n")
        return
    output = output or Path("runs/surfaces.csv" if surfaces else "docs/measurements/stability.csv")
    if not resume:
        output.unlink(missing_ok=True)
    lines = Lines(output)
    if not lines.rows:
        lines.add(*Row._fields)
    rows = list(campaign(draw, range(count), lines, until))
    failed = report(rows, f"random scenes, seed {seed}, {1.0 if surfaces else duration:g} ms each")
    if long and not surfaces:
        slow, rows = TIME_LIMIT * LONG_MS / 5.0, []
        for row in campaign(draw, numbers_from(LONG_FROM), lines, until, limit=slow):
            rows.append(row)
            if sum(row.ending != REFUSED for row in rows) >= long:
                break
        failed |= report(rows, f"random scenes, seed {seed}, {LONG_MS:g} ms each")
    if not surfaces:
        print("drawn from:", ", ".join(f"{key} {low:g} … {high:g}" for key, (low, high) in RANGES.items()))
    if step_limit and not surfaces:
        from tests.stability import step_limit as limit

        print(*limit.measured(output.with_suffix(".png")), sep="\n")
    sys.exit(failed)


if __name__ == "__main__":
    app()
