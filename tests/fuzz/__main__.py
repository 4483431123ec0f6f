"""Search for inputs that a reader neither takes nor refuses in a sentence: python -m tests.fuzz result --seconds 600

Each target takes bytes as a file's content and lets pass only what its reader promises: a usable object, or the error
that the commands print as a sentence. Anything else, more than 1 GB of memory or 25 s of processor time for one input
stops the fuzzer, which leaves the input. Inputs come from `mutations` and are kept where they reach new branches of our
code, of tomllib or csv: by Atheris, libFuzzer for Python, to be installed by hand (pip install atheris).
tests/test_fuzz.py draws inputs for the same targets without it.
"""

import argparse
import os
import resource
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from random import Random

from tests.fuzz.mutations import MUTATIONS
from tests.fuzz.sound import seeds
from tests.fuzz.targets import NAMES, Targets
from tests.waiting import ASLEEP

INSTRUMENTED = ("lagrange", "residual", "fem.study", "fem.elastic.cache", "tomllib", "csv")
OF_RESULTS = "fem.result.checkpoint", "fem.result.fields", "fem.pictures.stored_values"
READERS = (
    "csv", "tomllib", "lagrange.scene.scene", "residual.sources", "residual.table_source", "residual.evaluation",
    "residual.measured.signals", "residual.measured.diagnosis",
    "residual.summary", "fem.study.solving", "fem.study.study_file",
    "fem.study.sampling", "fem.study.folder", "fem.study.folder", "fem.elastic.cache",
)  # fmt: skip
KEPT = Path(__file__).parent / "corpus"  # inputs that once found something
MEMORY_MB = 1024
MOST_LEAKED_MB = 400  # Atheris 3.0 never frees the result of a comparison it has traced, which may be an array
SECONDS_PER_INPUT = 25  # of processor time
FROM_SOUND = 0.4  # share of inputs made from a sound one; most of those kept are refused early


def guided(name: str, seconds: int, corpus: Path) -> None:
    """Let Atheris search for some seconds of processor time, or look what inputs reach; does not return."""
    import atheris

    _instrument(atheris)
    corpus.mkdir(parents=True, exist_ok=True)
    sound = seeds(name)
    for number, seed in enumerate(sound):
        (corpus / f"seed-{number}").write_bytes(seed)
    for known in (KEPT / name).glob("*.*"):
        shutil.copy(known, corpus)
    folder = Path(tempfile.mkdtemp(dir="/dev/shm" if Path("/dev/shm").is_dir() else None))
    target: Callable[[bytes], bool] = getattr(Targets(folder), name)
    taken, begun_with = [0, 0], _memory_mb()

    def once(data: bytes) -> None:
        signal.setitimer(signal.ITIMER_PROF, SECONDS_PER_INPUT)
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
            for timer in (signal.ITIMER_REAL, signal.ITIMER_PROF):  # libFuzzer's and ours would outlive it
                signal.setitimer(timer, 0)
            os.execv(sys.executable, [sys.executable, "-m", "tests.fuzz", *sys.argv[1:]])

    def mutated(data: bytes, longest: int, seed: int) -> bytes:
        random = Random(seed)
        if random.random() < FROM_SOUND:
            data = random.choice(sound)
        return (atheris.Mutate(data, longest) if random.random() < 0.3 else MUTATIONS[name](data, random))[:longest]

    for seed in sound:
        target(seed)  # loads what it needs, which is no part of what inputs take
    _bound_memory()
    signal.signal(signal.SIGPROF, _hung)
    longest = 2 * max(len(seed) for seed in sound)
    once_more = "-runs=0" if seconds == 0 else "-verbosity=0"
    atheris.Setup(
        [sys.argv[0], f"-rss_limit_mb={MEMORY_MB}", f"-timeout={SECONDS_PER_INPUT * ASLEEP:.0f}", f"-max_len={longest}",
         f"-artifact_prefix={corpus.parent}/find-{name}-", once_more, str(corpus)],
        once,
        custom_mutator=mutated,
    )  # fmt: skip
    atheris.Fuzz()


def _instrument(atheris) -> None:
    """Load the readers so that their branches are counted; not the kernels, which numba must find as they are."""
    for loaded in [name for name in sys.modules if f"{name}.".startswith(tuple(f"{part}." for part in INSTRUMENTED))]:
        del sys.modules[loaded]
    with atheris.instrument_imports(include=list(INSTRUMENTED)):
        for name in READERS:
            import_module(name)
    import_module("fem.solver.simulate")
    with atheris.instrument_imports(include=list(OF_RESULTS)):
        for name in OF_RESULTS:
            import_module(name)


def _hung(*_) -> None:
    raise TimeoutError(f"no end after {SECONDS_PER_INPUT} s of processor time")


def _processor_seconds() -> float:
    """Processor time of this process and of the children that read first, s."""
    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def _peak_mb() -> float:
    """Most memory that this process or a child has held, MB; Linux counts in kB."""
    return max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) / 1e3


def _bound_memory() -> None:
    """Limit the memory as in the child that reads first, so that HDF5 meets the same limit here."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + MEMORY_MB * 2**20 // 2
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _memory_mb() -> float:
    """Memory that this process holds now, MB."""
    return int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Read the command line and search, or try one input."""
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
