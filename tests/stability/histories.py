"""Random histories of a run: `python -m tests.stability.histories --number 500`.

A history is a scene of a few milliseconds, solved by one of the three models in some legs, each with --resume where
there is a checkpoint. In a leg the run is killed, terminated or interrupted, its disk fills up, its result is removed
or renamed, at a random one of its writes, syncs and renames; or a second process works on the same result; or another
run makes the same caches at the same time. Between legs caches are emptied or damaged, or a bit of result or checkpoint
flips. After each leg the exit code must be the command's own, without a traceback, and every committed sample that of
an undisturbed run, unless a bit was flipped. In the end the result is complete and the same to the last bit; only where
a bit was flipped or the result removed may it have been refused by name before, and made anew.
"""

import csv
import os
import sys
import tempfile
import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from cyclopts import App
from rich.console import Console

from fem.kernels.kernel_folder import cache_folder
from tests.measurements import markdown_table
from tests.stability import forked
from tests.stability.disturbing import AWAY, EVENTS, disturb
from tests.stability.samples import differing, samples_of

MODELS = {
    "lagrange": ["--model", "lagrange", "--duration", "4"],
    "reduced": ["--model", "reduced", "--duration", "2"],
    "fem": ["--mesh-size", "2.1", "--duration", "2"],  # whose meshes are not shipped
}
SHARES = 0.5, 0.3, 0.2
BETWEEN = ("nothing", "nothing", "cold caches", "damaged caches", "flipped checkpoint", "flipped result")
BESIDE = ("nobody", "nobody", "nobody", "second process", "same caches")
EXITS = {0, 1, 2, 130, 143, -9}
MOST_LEGS, LAST_MOMENT = 4, 400
TIME_LIMIT = 120.0  # s of processor time of a leg
COMPLETE, ANEW = "complete", "refused by name, then made anew"

app = App(help=__doc__)


@dataclass
class History:
    """A folder with a result under way, and caches."""

    folder: Path
    caches: Path
    model: str
    whole: dict[str, np.ndarray]  # samples of the undisturbed run
    rng: np.random.Generator
    told: list[str] = field(default_factory=list)  # what befell it
    flipped: bool = False

    @property
    def result(self) -> Path:
        return self.folder / "run.nc"

    @property
    def checkpoint(self) -> Path:
        return self.folder / "run.nc.checkpoint"

    def words(self, resume: bool, result: str = "run.nc") -> list[str]:
        """The command."""
        usual = ["--checkpoint", "0", "--quiet", "--output", result]
        return ["run-fem", *MODELS[self.model], *usual, *(["--resume"] if resume else [])]

    def between(self) -> None:
        """What befalls files while nobody works on them."""
        event = str(self.rng.choice(BETWEEN))
        self.told.append(event)
        files = sorted(path for path in self.caches.rglob("*") if path.is_file() and path.suffix != ".json")
        if event == "cold caches":
            for path in files:
                path.unlink()
        elif event == "damaged caches":
            for path in files:
                path.write_bytes(path.read_bytes()[: int(self.rng.integers(path.stat().st_size + 1))])
        elif event.startswith("flipped"):
            path = self.checkpoint if event == "flipped checkpoint" else self.result
            if path.exists() and path.stat().st_size:
                data = bytearray(path.read_bytes())
                data[int(self.rng.integers(len(data)))] ^= 1 << int(self.rng.integers(8))
                path.write_bytes(data)
                self.flipped = True

    def leg(self) -> str:
        """One leg; what is wrong, or nothing."""
        event = str(self.rng.choice(EVENTS))
        moment = int(np.exp(self.rng.uniform(0.0, np.log(LAST_MOMENT))))
        beside = str(self.rng.choice(BESIDE))
        self.told.append(f"{event} in call {moment}, {beside} beside")
        words = self.words(self.checkpoint.exists())
        befallen = partial(disturb, event, moment, self.result)
        ended: dict[str, forked.Ended] = {}
        others = {
            "nobody": [],
            "second process": [("second", words)],
            "same caches": [("other", self.words(False, "other.nc"))],
        }[beside]

        def run(name: str, command: list[str], before) -> None:
            ended[name] = forked.run(command, self.folder, TIME_LIMIT, before=before)

        threads = [threading.Thread(target=run, args=(name, command, None)) for name, command in others]
        for thread in threads:
            thread.start()
        run("first", words, befallen)
        for thread in threads:
            thread.join()
        away = self.result.with_name(self.result.name + AWAY)
        if away.exists() and not self.result.exists():
            away.rename(self.result)
        faults = [_ending(name, done) for name, done in ended.items()]
        return "; ".join(fault for fault in [*faults, self._harmed()] if fault)

    def _harmed(self) -> str:
        """Whether committed samples are other than the undisturbed run's."""
        if self.flipped or not self.result.exists():
            return ""
        try:
            other = differing(samples_of(self.result), self.whole)
        except (OSError, KeyError) as error:
            return f"the result can't be read: {error}"
        return f"other samples of {', '.join(other)}" if other else ""

    def last_leg(self) -> tuple[str, str]:
        """Bring it to its end undisturbed: how it ended, and what is wrong, or nothing."""
        resume = self.checkpoint.exists()
        done = forked.run(self.words(resume), self.folder, TIME_LIMIT)
        ending = COMPLETE
        if done.code == 2 and resume and str(self.result.name) in done.said:  # the checkpoint's name holds it too
            if not self.flipped and not any("removed" in event for event in self.told):
                return ANEW, f"refused without a reason: {done.said[-300:]}"
            ending = ANEW
            done = forked.run([*self.words(False), "--force"], self.folder, TIME_LIMIT)
        if done.code != 0:
            return ending, f"the last leg ends with {done.code}: {done.said[-300:]}"
        found = samples_of(self.result)
        same = len(found["time"]) == len(self.whole["time"]) and found["status"] == self.whole["status"]
        return ending, "" if same and not differing(found, self.whole) else "another result"


def _ending(name: str, done: forked.Ended) -> str:
    if done.code is None:
        return f"{name} hangs"
    if done.code not in EXITS or "Traceback" in done.said:
        return f"{name}: exit {done.code}: {done.said[-400:]}"
    return f"{name}: exit {done.code} without a word" if done.code in (1, 2) and not done.said.strip() else ""


def history(seed: int, number: int, place: Path, wholes: dict[str, dict[str, np.ndarray]]) -> tuple[str, ...]:
    """Model, what befell it, how it ended, what is wrong."""
    rng = np.random.default_rng([seed, number])
    model = str(rng.choice(list(MODELS), p=SHARES))
    with tempfile.TemporaryDirectory(dir=place) as folder:
        one = History(Path(folder), place / "cache", model, wholes[model], rng)
        for _ in range(int(rng.integers(1, MOST_LEGS + 1))):
            if fault := one.leg():
                return model, "; ".join(one.told), "FAILED", fault
            one.between()
        ending, fault = one.last_leg()
    return model, "; ".join(one.told), "FAILED" if fault else ending, fault


def prepare(place: Path, models: tuple[str, ...]) -> dict[str, dict[str, np.ndarray]]:
    """Load what the commands load, and run each model undisturbed."""
    kept = cache_folder()
    if kept is not None:  # compiled kernels stay where they are
        os.environ["NUMBA_CACHE_DIR"] = str(kept.parent.parent)
    os.environ["XDG_CACHE_HOME"] = str(place / "cache")
    commands = {name: ["run-fem", *MODELS[name], "--quiet", "--output", f"{name}.nc"] for name in models}
    forked.preload(list(commands.values()), place)
    return {name: samples_of(place / f"{name}.nc") for name in models}


@app.default
def main(*, number: int = 500, seed: int = 1, output: Path | None = None, seconds: float = 1e9) -> None:
    """Let histories happen and print how they ended.

    Parameters
    ----------
    number: how many
    seed: of all
    output: CSV, a line a history; those that stand there are not repeated
    seconds: of wall time, after which no further history begins
    """
    console, until = Console(), time.monotonic() + seconds
    rows: list[list[str]] = []
    if output is not None and output.exists():
        with output.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if row and row[0] == str(seed)]
    done = {int(row[1]) for row in rows}
    with tempfile.TemporaryDirectory() as folder:
        wholes = prepare(Path(folder), tuple(MODELS))
        for each in range(number):
            if each in done or time.monotonic() > until:
                continue
            rows.append([str(seed), str(each), *history(seed, each, Path(folder), wholes)])
            if rows[-1][4] == "FAILED":
                console.print(" ".join(rows[-1]), soft_wrap=True, markup=False)
            if output is not None:
                with output.open("a", newline="", encoding="utf-8") as file:
                    csv.writer(file, lineterminator="\n").writerow(rows[-1])
    counts = Counter((row[2], row[4]) for row in rows)
    endings = (COMPLETE, ANEW, "FAILED")
    table = [[model, *(str(counts[model, ending]) for ending in endings)] for model in MODELS]
    console.print(markdown_table(["model", *endings], table), soft_wrap=True)
    console.print(f"{len(rows)} histories of seed {seed}")
    sys.exit(1 if any(row[4] == "FAILED" for row in rows) else 0)


if __name__ == "__main__":
    app()
