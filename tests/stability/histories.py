"""Random histories of a run: `python -m tests.stability.histories --number 500`.

A history is a scene of a few milliseconds, solved by one of the three models in some legs, each with --resume where
there is a checkpoint. In a leg the run is killed, terminated or interrupted, its disk fills up, a call fails, its
result is removed or renamed, at a random one of its writes, syncs and renames; or a second process works on the same
result; or another run makes the same caches at the same time. Between legs caches are emptied or damaged, or a bit of
result or checkpoint flips. After each leg the exit code must be the command's own, without a traceback, and every
committed sample that of an undisturbed run, unless a bit was flipped. In the end the result is complete and the same to
the last bit; only where a bit was flipped or the result removed may it have been refused by name before, and made anew.
"""

import errno
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

import h5py
import numpy as np
from cyclopts import App

from fem.kernels.kernel_folder import cache_folder
from fem.solver import simulate
from tests.measurements import markdown_table
from tests.stability import forked
from tests.stability.campaign import Lines

MODELS = {
    "lagrange": ["--model", "lagrange", "--duration", "4"], "reduced": ["--model", "reduced", "--duration", "2"],
    "fem": ["--mesh-size", "2.1", "--duration", "2"],  # whose meshes are not shipped
}  # fmt: skip
SHARES = 0.5, 0.3, 0.2
BLOCK = 20  # samples between two commits and checkpoints
COUNTER = 8  # bytes, which reach a file whole
SIGNALS = {"kill": signal.SIGKILL, "terminate": signal.SIGTERM, "interrupt": signal.SIGINT}
EVENTS = (*SIGNALS, "full", "fails", "removed", "renamed")
BETWEEN = ("nothing", "nothing", "cold caches", "damaged caches", "flipped checkpoint", "flipped result")
BESIDE = ("nobody", "nobody", "nobody", "second process", "same caches")
EXITS = {0, 1, 2, 130, 143, -9}
MOST_LEGS, LAST_MOMENT = 4, 400
TIME_LIMIT = 120.0  # s of processor time of a leg
COMPLETE, ANEW, FAILED = "complete", "refused by name, then made anew", "FAILED"
Samples = dict[str, np.ndarray]


def samples_of(path: Path) -> Samples:
    """All committed samples of a result, and what it knows of its run; the times of day are no part of them."""
    with h5py.File(path) as file:
        count = int(file.attrs["committed_samples"])
        known = {name: np.asarray(file.attrs[name]) for name in ("status", "committed_samples")}
        return known | {name: value[:count] for name, value in file.items() if isinstance(value, h5py.Dataset)}


def differing(found: Samples, whole: Samples) -> list[str]:
    """Names of the variables whose samples are not the first ones of an undisturbed run's."""
    if found.keys() != whole.keys() or len(found["time"]) > len(whole["time"]):
        return ["another set of variables or samples"]
    names = sorted(found.keys() - {"status", "committed_samples"})
    return [name for name in names if found[name].tobytes() != whole[name][: len(found[name])].tobytes()]


def disturb(event: str, moment: int, result: Path) -> None:
    """Have an event befall this process in its call of that number, and commit every few samples."""
    calls, away = itertools.count(1), result.with_name(result.name + ".away")
    simulate.size_of_block = lambda *_: BLOCK

    def befall() -> None:  # a result that is not there yet can't be taken away
        if event in SIGNALS:
            os.kill(os.getpid(), SIGNALS[event])
        elif event == "fails":
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        elif event == "full":
            room = result.stat().st_size // 2 if result.exists() else 1000
            resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
        elif event == "removed":
            result.unlink(missing_ok=True)
        elif event == "renamed" and result.exists():
            result.rename(away)

    def counted(call, is_write):
        def made(*arguments, **options):
            if next(calls) == moment:
                if event == "kill" and is_write and len(arguments[1]) > COUNTER:  # a part of it has been made
                    call(arguments[0], arguments[1][: len(arguments[1]) // 2])
                befall()
            return call(*arguments, **options)

        return made

    for name in ("write", "fsync", "replace"):  # by which it brings data to the disk
        setattr(os, name, counted(getattr(os, name), name == "write"))


class History:
    """A folder with a result under way, and caches; `whole`: samples of the undisturbed run."""

    def __init__(self, folder: Path, caches: Path, model: str, whole: Samples, rng: np.random.Generator):
        self.folder, self.caches, self.model, self.whole, self.rng = folder, caches, model, whole, rng
        self.result, self.checkpoint = folder / "run.nc", folder / "run.nc.checkpoint"
        self.befallen: list[str] = []
        self.flipped = False

    def run(self, *words: str, result: str = "run.nc", before=None) -> forked.Ended:
        every = [*MODELS[self.model], "--checkpoint", "0", "--quiet", "--output", result, *words]
        return forked.run(forked.run_fem, every, self.folder, before, limit=TIME_LIMIT)

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
        resume, ended = ["--resume"] if self.checkpoint.exists() else [], dict[str, forked.Ended]()
        others = {"second process": (resume, "run.nc"), "same caches": ([], "other.nc")}

        def other(words: list[str], result: str) -> None:
            ended[beside] = self.run(*words, result=result)

        thread = threading.Thread(target=other, args=others[beside]) if beside in others else None
        if thread is not None:
            thread.start()
        ended["first"] = self.run(*resume, before=partial(disturb, event, moment, self.result))
        if thread is not None:
            thread.join()
        away = self.result.with_name(self.result.name + ".away")
        if away.exists() and not self.result.exists():
            away.rename(self.result)
        faults = []
        for name, (code, said, _) in ended.items():
            if code is None:
                faults.append(f"{name} hangs")
            elif code not in EXITS or "Traceback" in said or (code in (1, 2) and not said.strip()):
                faults.append(f"{name}: exit {code}: {said[-400:] or 'without a word'}")
        if self.result.exists() and not self.flipped:
            try:
                if names := differing(samples_of(self.result), self.whole):
                    faults.append(f"other samples of {', '.join(names)}")
            except (OSError, KeyError) as error:
                faults.append(f"the result can't be read: {error}")
        return "; ".join(faults)

    def last_leg(self) -> tuple[str, str]:
        """Bring it to its end undisturbed: how it ended, and what is wrong, or nothing."""
        resume, ending = self.checkpoint.exists(), COMPLETE
        done = self.run(*(["--resume"] if resume else []))
        if done.code == 2 and resume and self.result.name in done.said:  # the checkpoint's name holds it too
            if not self.flipped and not any("removed" in event for event in self.befallen):
                return ANEW, f"refused without a reason: {done.said[-300:]}"
            ending, done = ANEW, self.run("--force")
        if done.code != 0:
            return ending, f"the last leg ends with {done.code}: {done.said[-300:]}"
        found = samples_of(self.result)
        complete = len(found["time"]) == len(self.whole["time"]) and found["status"] == self.whole["status"]
        return ending, "" if complete and not differing(found, self.whole) else "another result"


def history(seed: int, number: int, place: Path, wholes: dict[str, Samples]) -> tuple[str, ...]:
    """Model, what befell it, how it ended, what is wrong."""
    rng = np.random.default_rng([seed, number])
    model = str(rng.choice(list(MODELS), p=SHARES))
    with tempfile.TemporaryDirectory(dir=place) as folder:
        one, fault = History(Path(folder), place / "cache", model, wholes[model], rng), ""
        for _ in range(int(rng.integers(1, MOST_LEGS + 1))):
            if fault := one.leg():
                return model, "; ".join(one.befallen), FAILED, fault
            one.between()
        ending, fault = one.last_leg()
    return model, "; ".join(one.befallen), FAILED if fault else ending, fault


def prepare(place: Path, models: tuple[str, ...]) -> dict[str, Samples]:
    """Meshes and matrices go into a folder for caches, compiled kernels stay where they are; undisturbed runs."""
    if (kept := cache_folder()) is not None:
        os.environ["NUMBA_CACHE_DIR"] = str(kept.parent.parent)
    os.environ["XDG_CACHE_HOME"] = str(place / "cache")
    for name in models:
        words = [*MODELS[name], "--quiet", "--output", f"{name}.nc"]
        done = forked.run(forked.run_fem, words, place, limit=10.0 * TIME_LIMIT)
        assert done.code == 0, done.said
    return {name: samples_of(place / f"{name}.nc") for name in models}


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
                if rows[-1][4] == FAILED:
                    print(*rows[-1], flush=True)
    counts, endings = Counter((row[2], row[4]) for row in rows), (COMPLETE, ANEW, FAILED)
    table = [[model, *(str(counts[model, ending]) for ending in endings)] for model in MODELS]
    print(markdown_table(["model", *endings], table), f"{len(rows)} histories of seed {seed}", sep="\n")
    sys.exit(any(row[4] == FAILED for row in rows))


if __name__ == "__main__":
    app()
