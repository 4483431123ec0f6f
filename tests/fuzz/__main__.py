"""Fuzzing of every reader: python -m benchmarks.fuzz scene|table|result|checkpoint --seconds 600

Each target takes bytes as a file's content and lets pass only what its reader promises: a usable object, or the error
that the commands print as a sentence. Anything else, more than 1 GB of memory or 25 s for one input stops the fuzzer,
which leaves the input. Inputs come from `mutations` and are kept where they reach new branches of our code, of tomllib
or csv: by Atheris, libFuzzer for Python, to be installed by hand (pip install atheris). tests/test_fuzz.py draws inputs
for the same targets without it.
"""

import argparse
import io
import json
import os
import resource
import shutil
import signal
import sys
import tempfile
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from random import Random

from benchmarks.mutations import MUTATIONS

INSTRUMENTED = ("lagrange", "residual", "tomllib", "csv")
READERS = (
    "csv", "tomllib", "lagrange.scene", "residual.sources", "residual.table_source", "residual.evaluation",
    "residual.summary",
)  # fmt: skip
MEMORY_MB = 1024
MOST_LEAKED_MB = 200  # Atheris 3.0 never frees the result of a comparison it has traced, which may be an array
SECONDS_PER_INPUT = 25
FROM_SOUND = 0.4  # share of inputs made from a sound one; most of those kept are refused early
LONGEST_MESSAGE = 10_000  # characters: 21 lines
DURATION = ["--duration", "0.4"]
FEW_ROLLERS = """[bearing]
rollers = 3
inner_raceway_diameter_mm = 36.0
"""


class Targets:
    """The readers, each as a function of a file's content."""

    def __init__(self, folder: Path):
        self._folder = folder
        warnings.simplefilter("error", RuntimeWarning)  # an overflow that nobody looked for

    def scene(self, data: bytes) -> bool:
        """A scene file; what is taken must come back from its own text. Whether it was taken."""
        from lagrange.scene import SceneError, parse_scene_text, read_scene

        path = self._file("fuzzed.toml", data)
        try:
            scene = read_scene(path)
        except SceneError as error:
            return _refused(error)
        assert parse_scene_text(scene.to_toml(), "again") == scene
        return True

    def table(self, data: bytes) -> bool:
        """A trajectory table, and its evaluation where it is taken."""
        from lagrange.scene import parse_scene_text
        from residual.table_source import read_table
        from residual.trajectory import InputError

        path = self._file("fuzzed.csv", data)
        try:
            trajectory = read_table(path, parse_scene_text(FEW_ROLLERS, "few"))
            _evaluated(trajectory)
        except InputError as error:
            return _refused(error)
        return True

    def result(self, data: bytes) -> bool:
        """A result file. First in a child, as always; then here, so that the search sees which way it took."""
        from residual import sources
        from residual.trajectory import InputError

        sources.READ_SECONDS = 0.2  # of an input that sends HDF5 round in circles
        path = self._file("fuzzed.nc", data)
        try:
            sources.read_result(path)
        except InputError as error:
            if "reading it" in str(error):
                return _refused(error)
        try:
            sources._read(path)
        except InputError as error:
            return _refused(error)
        return True

    def checkpoint(self, data: bytes) -> bool:
        """The state of a run."""
        from fem.errors import UsageError
        from fem.result.checkpoint import load_checkpoint

        self._file("fuzzed.nc.checkpoint", data)
        try:
            load_checkpoint(self._folder / "fuzzed.nc", _plan())
        except UsageError as error:
            return _refused(error)
        return True

    def _file(self, name: str, data: bytes) -> Path:
        path = self._folder / name
        path.write_bytes(data)
        return path


NAMES = ("scene", "table", "result", "checkpoint")


def _refused(error: Exception) -> bool:
    """The message must be fit for a terminal."""
    text = str(error)
    assert 0 < len(text) <= LONGEST_MESSAGE and all(c.isprintable() or c == "\n" for c in text), repr(text)
    return False


def _evaluated(trajectory) -> None:
    """What the reader takes can be evaluated, and the numbers be written."""
    from residual.evaluation import evaluate
    from residual.summary import summarise

    json.dumps(summarise(evaluate(trajectory), None, "0"), allow_nan=False)


_PLANS: list = []


def _plan():
    from fem.solver.simulate import make_plan
    from lagrange.scene import read_scene

    if not _PLANS:
        _PLANS.append(make_plan(read_scene(None, ("numerics.mesh_size_mm=2", "numerics.duration_ms=0.4"))))
    return _PLANS[0]


def seeds(name: str) -> list[bytes]:
    """Sound inputs to start from, small ones."""
    from lagrange.scene import Scene

    if name == "scene":
        ball = '[bearing]\ntype = "ball"\n[material.roller]\ndensity_kg_m3 = 3200\n[operation]\nspeed_rpm = -3e3\n'
        mapped = '[table]\ntime = "t [ms]"\nroller_x = "x_{j} [um]"\ndecimal = ","\n'
        return [Scene().to_toml().encode(), ball.encode(), mapped.encode(), b"name = 'x'\n"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "seed.nc"
        if name == "checkpoint":
            _run(["--mesh-size", "2", *DURATION, "--output", str(path)])
            return [path.with_name("seed.nc.checkpoint").read_bytes()]
        scene = Path(folder) / "few.toml"
        scene.write_text(FEW_ROLLERS)
        _run([str(scene), "--model", "lagrange", *DURATION, "--output", str(path)])
        if name == "table":
            return [_table(path, ","), _table(path, "\t")]
        return [path.read_bytes(), _unchecked(path)]


def _run(arguments: list[str]) -> None:
    from fem.cli import run_main

    if run_main([*arguments, "--quiet"]) != 0:
        raise RuntimeError("the run that makes the first input failed")


def _unchecked(path: Path) -> bytes:
    """A result file without checksums, which would stop most changes."""
    import h5py

    from lagrange.stored import CHECKSUM, SCENE_CHECKSUM

    with h5py.File(path, "r+") as file:
        for variable in file.values():
            variable.attrs.pop(CHECKSUM, None)
        file.attrs.pop(SCENE_CHECKSUM)
    return path.read_bytes()


def _table(path: Path, delimiter: str) -> bytes:
    """A result file's motion as a table."""
    import h5py
    import numpy as np

    with h5py.File(path) as file:
        columns = {name: file[name][:] for name in ("time", "inner_x", "inner_y")}
        for axis in "xy":
            columns |= {f"roller_{j}_{axis}": column for j, column in enumerate(file[f"roller_{axis}"][:].T)}
    text = io.StringIO()
    np.savetxt(text, np.column_stack(list(columns.values())), "%.9g", delimiter,
               header=delimiter.join(columns), comments="")  # fmt: skip
    return text.getvalue().encode()


def guided(name: str, seconds: int, corpus: Path) -> None:
    """Let Atheris search for some seconds of processor time, or look what inputs reach; does not return."""
    import atheris

    _instrument(atheris)
    corpus.mkdir(parents=True, exist_ok=True)
    sound = seeds(name)
    for number, seed in enumerate(sound):
        (corpus / f"seed-{number}").write_bytes(seed)
    folder = Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
    target: Callable[[bytes], bool] = getattr(Targets(folder), name)
    taken, begun_with = [0, 0], _memory_mb()

    def once(data: bytes) -> None:
        taken[target(data)] += 1
        tried = sum(taken)
        over = seconds > 0 and tried % 100 == 0 and _processor_seconds() > seconds
        if over or tried & (tried - 1) == 0:  # powers of two
            spent = f"{_processor_seconds():.0f} s, at most {_peak_mb():.0f} MB"
            print(f"{tried} inputs: {taken[1]} taken, {taken[0]} refused, {spent}", flush=True)
        if over:
            os._exit(0)
        if tried % 100 == 0 and _memory_mb() > begun_with + MOST_LEAKED_MB:
            print(f"{tried} inputs: {taken[1]} taken, {taken[0]} refused; begun anew, for Atheris leaks", flush=True)
            shutil.rmtree(folder)
            signal.setitimer(signal.ITIMER_REAL, 0)  # libFuzzer's, which would outlive it
            os.execv(sys.executable, [sys.executable, "-m", "benchmarks.fuzz", *sys.argv[1:]])

    def mutated(data: bytes, longest: int, seed: int) -> bytes:
        random = Random(seed)
        if random.random() < FROM_SOUND:
            data = random.choice(sound)
        return (atheris.Mutate(data, longest) if random.random() < 0.3 else MUTATIONS[name](data, random))[:longest]

    _bound_memory()
    longest = 2 * max(len(seed) for seed in sound)
    once_more = "-runs=0" if seconds == 0 else "-verbosity=0"
    atheris.Setup(
        [sys.argv[0], f"-rss_limit_mb={MEMORY_MB}", f"-timeout={SECONDS_PER_INPUT}", f"-max_len={longest}",
         f"-artifact_prefix={corpus.parent}/find-{name}-", once_more, str(corpus)],
        once,
        custom_mutator=mutated,
    )  # fmt: skip
    atheris.Fuzz()


def _instrument(atheris) -> None:
    """Load the readers so that their branches are counted; not the kernels, which numba must find as they are."""
    for loaded in [name for name in sys.modules if name.split(".")[0] in INSTRUMENTED]:
        del sys.modules[loaded]
    with atheris.instrument_imports(include=list(INSTRUMENTED)):
        for name in READERS:
            import_module(name)
    import_module("fem.solver.simulate")
    with atheris.instrument_imports(include=["fem.result.checkpoint"]):
        import_module("fem.result.checkpoint")


def _processor_seconds() -> float:
    """Of this process and of the children that read first."""
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def _peak_mb() -> float:
    """Most memory this process or a child has held; Linux counts in kB."""
    return max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 1e3


def _bound_memory() -> None:
    """As in the child that reads first, so that HDF5 meets the same limit here."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + MEMORY_MB * 2**20 // 2
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _memory_mb() -> float:
    """What this process holds now."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("target", choices=NAMES)
    parser.add_argument(
        "--seconds",
        type=int,
        default=600,
        help="of processor time; 0: run what was kept once more and print the branches it reaches (cov)",
    )
    parser.add_argument("--corpus", type=Path, default=Path("fuzz"), help="folder for inputs and finds")
    parser.add_argument("--input", type=Path, help="try one file, e.g. a find, and nothing else")
    given = parser.parse_args()
    if given.input is not None:
        with tempfile.TemporaryDirectory() as folder:
            print("taken" if getattr(Targets(Path(folder)), given.target)(given.input.read_bytes()) else "refused")
        return
    os.environ.setdefault("MPLBACKEND", "Agg")
    guided(given.target, given.seconds, given.corpus / given.target)


if __name__ == "__main__":
    main()
