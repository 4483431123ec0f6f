"""Random histories of a run: `python -m tests.stability.histories --number 500`.

A history is a scene of a few milliseconds, solved by one of the three models in some legs, each with --resume where
there is a checkpoint. In a leg the run is killed, terminated or interrupted, its disk fills up, its result is removed
or renamed, at a random one of its writes, syncs and renames; or a second process works on the same result; or another
run makes the same caches at the same time. Between legs caches are emptied or damaged, or a bit of result or checkpoint
flips. After each leg the exit code must be the command's own, without a traceback, and every committed sample that of
an undisturbed run, unless a bit was flipped. In the end the result is complete and the same to the last bit; only where
a bit was flipped or the result removed may it have been refused by name before, and made anew.
"""

import itertools
import os
import resource
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
from cyclopts import App

from fem.solver import simulate
from tests.measurements import markdown_table
from tests.stability import forked
from tests.stability.campaign import Lines

MODELS = {
    "lagrange": ["--model", "lagrange", "--duration", "4"],
    "reduced": ["--model", "reduced", "--duration", "2"],
    "fem": ["--mesh-size", "2.1", "--duration", "2"],  # whose meshes are not shipped
}
SHARES = 0.5, 0.3, 0.2
BLOCK = 20  # samples between two commits and checkpoints
SIGNALS = {"kill": signal.SIGKILL, "terminate": signal.SIGTERM, "interrupt": signal.SIGINT}
EVENTS = (*SIGNALS, "full", "removed", "renamed")
AWAY = ".away"  # behind the name of a result that was renamed
BETWEEN = ("nothing", "nothing", "cold caches", "damaged caches", "flipped checkpoint", "flipped result")
BESIDE = ("nobody", "nobody", "nobody", "second process", "same caches")
EXITS = {0, 1, 2, 130, 143, -9}
MOST_LEGS, LAST_MOMENT = 4, 400
TIME_LIMIT = 120.0  # s of processor time of a leg
COMPLETE, ANEW = "complete", "refused by name, then made anew"


def disturb(event: str, moment: int, result: Path) -> None:
    """Have an event befall this process in its call of that number, and commit every few samples."""
    calls = itertools.count(1)
    simulate.size_of_block = lambda *_: BLOCK

    def befall() -> None:  # a result that is not there yet can't be taken away
        if event in SIGNALS:
            os.kill(os.getpid(), SIGNALS[event])
        elif event == "full":
            room = result.stat().st_size // 2 if result.exists() else 1000
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
        elif event == "removed":
            result.unlink(missing_ok=True)
        elif event == "renamed" and result.exists():
            result.rename(result.with_name(result.name + AWAY))

    def counted(call):
        def made(*arguments, **options):
            if next(calls) == moment:
                befall()
            return call(*arguments, **options)

        return made

    for name in ("write", "fsync", "replace"):  # by which it brings data to the disk
        setattr(os, name, counted(getattr(os, name)))


class History:
    """A folder with a result under way, and caches; `whole`: samples of the undisturbed run."""

    def __init__(self, folder: Path, caches: Path, model: str, whole: dict[str, np.ndarray], rng: np.random.Generator):
        self.folder, self.caches, self.model, self.whole, self.rng = folder, caches, model, whole, rng
        self.result, self.checkpoint = folder / "run.nc", folder / "run.nc.checkpoint"
        self.befallen: list[str] = []
        self.flipped = False

    def words(self, resume: bool, result: str = "run.nc") -> list[str]:
        usual = ["--checkpoint", "0", "--quiet", "--output", result]
        return ["run-fem", *MODELS[self.model], *usual, *(["--resume"] if resume else [])]

    def between(self) -> None:
        """What befalls files while nobody works on them."""
        event = str(self.rng.choice(BETWEEN))
        self.befallen.append(event)
        for path in sorted(path for path in self.caches.rglob("*") if path.is_file() and path.suffix != ".json"):
            if event == "cold caches":
                path.unlink()
            elif event == "damaged caches":
                path.write_bytes(path.read_bytes()[: int(self.rng.integers(path.stat().st_size + 1))])
        path = {"flipped checkpoint": self.checkpoint, "flipped result": self.result}.get(event)
        if path is not None and path.exists() and path.stat().st_size:
            data = bytearray(path.read_bytes())
            data[int(self.rng.integers(len(data)))] ^= 1 << int(self.rng.integers(8))
            path.write_bytes(data)
            self.flipped = True

    def leg(self) -> str:
        """One leg; what is wrong, or nothing."""
        event = str(self.rng.choice(EVENTS))
        moment = int(np.exp(self.rng.uniform(0.0, np.log(LAST_MOMENT))))
        beside = str(self.rng.choice(BESIDE))
        self.befallen.append(f"{event} in call {moment}, {beside} beside")
        words, ended = self.words(self.checkpoint.exists()), dict[str, forked.Ended]()

        def run(name: str, command: list[str], before) -> None:
            ended[name] = forked.run(command, self.folder, TIME_LIMIT, before=before)

        others = {"second process": ("second", words), "same caches": ("other", self.words(False, "other.nc"))}
        threads = [threading.Thread(target=run, args=(*others[beside], None))] if beside in others else []
        for thread in threads:
            thread.start()
        run("first", words, partial(disturb, event, moment, self.result))
        for thread in threads:
            thread.join()
        away = self.result.with_name(self.result.name + AWAY)
        if away.exists() and not self.result.exists():
            away.rename(self.result)
        faults = []
        for name, done in ended.items():
            if done.code is None:
                faults.append(f"{name} hangs")
            elif done.code not in EXITS or "Traceback" in done.said:
                faults.append(f"{name}: exit {done.code}: {done.said[-400:]}")
            elif done.code in (1, 2) and not done.said.strip():
                faults.append(f"{name}: exit {done.code} without a word")
        if self.result.exists() and not self.flipped:
            try:
                if other := forked.differing(forked.samples_of(self.result), self.whole):
                    faults.append(f"other samples of {', '.join(other)}")
            except (OSError, KeyError) as error:
                faults.append(f"the result can't be read: {error}")
        return "; ".join(faults)

    def last_leg(self) -> tuple[str, str]:
        """Bring it to its end undisturbed: how it ended, and what is wrong, or nothing."""
        resume, ending = self.checkpoint.exists(), COMPLETE
        done = forked.run(self.words(resume), self.folder, TIME_LIMIT)
        if done.code == 2 and resume and self.result.name in done.said:  # the checkpoint's name holds it too
            if not self.flipped and not any("removed" in event for event in self.befallen):
                return ANEW, f"refused without a reason: {done.said[-300:]}"
            ending = ANEW
            done = forked.run([*self.words(False), "--force"], self.folder, TIME_LIMIT)
        if done.code != 0:
            return ending, f"the last leg ends with {done.code}: {done.said[-300:]}"
        return ending, "" if forked.is_same(forked.samples_of(self.result), self.whole) else "another result"


def history(seed: int, number: int, place: Path, wholes: dict[str, dict[str, np.ndarray]]) -> tuple[str, ...]:
    """Model, what befell it, how it ended, what is wrong."""
    rng = np.random.default_rng([seed, number])
    model = str(rng.choice(list(MODELS), p=SHARES))
    with tempfile.TemporaryDirectory(dir=place) as folder:
        one = History(Path(folder), place / "cache", model, wholes[model], rng)
        for _ in range(int(rng.integers(1, MOST_LEGS + 1))):
            if fault := one.leg():
                return model, "; ".join(one.befallen), "FAILED", fault
            one.between()
        ending, fault = one.last_leg()
    return model, "; ".join(one.befallen), "FAILED" if fault else ending, fault


def prepare(place: Path, models: tuple[str, ...]) -> dict[str, dict[str, np.ndarray]]:
    """Load what the commands load, and run each model undisturbed."""
    commands = {name: ["run-fem", *MODELS[name], "--quiet", "--output", f"{name}.nc"] for name in models}
    forked.prepare(list(commands.values()), place, place / "cache")
    return {name: forked.samples_of(place / f"{name}.nc") for name in models}


app = App(help=__doc__)


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
    lines, until = Lines(output), time.monotonic() + seconds
    rows = [row for row in lines.rows if row[0] == str(seed)]
    done = {int(row[1]) for row in rows}
    with tempfile.TemporaryDirectory() as folder:
        wholes = prepare(Path(folder), tuple(MODELS))
        for each in range(number):
            if each not in done and time.monotonic() <= until:
                rows.append([str(seed), str(each), *history(seed, each, Path(folder), wholes)])
                lines.add(*rows[-1])
                if rows[-1][4] == "FAILED":
                    print(*rows[-1], flush=True)
    counts = Counter((row[2], row[4]) for row in rows)
    endings = (COMPLETE, ANEW, "FAILED")
    table = [[model, *(str(counts[model, ending]) for ending in endings)] for model in MODELS]
    print(markdown_table(["model", *endings], table), f"{len(rows)} histories of seed {seed}", sep="\n")
    sys.exit(1 if any(row[4] == "FAILED" for row in rows) else 0)


if __name__ == "__main__":
    app()
