"""One point of a study: a pure function from a scene to numbers, run here or by a worker anywhere."""

import hashlib
import json
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fem.interface import OF_CHECK, check_quantities, simulate, statics
from fem.quantities import OF_RATING, OF_STATICS, Quantity
from fem.recording import Result
from fem.result.layout import readable
from fem.solver.solver import sample_count
from fem.study.sampling import Design
from fem.study.study_file import KeepTable, Study, decimation
from lagrange.columns import PER_ROLLER
from lagrange.errors import RunFailed, UsageError
from lagrange.scene.scene import Scene, SceneError
from lagrange.version import source_digest

FORMAT = 2  # of a point's file
MOST_FAULTS = 10  # named at once
LIBRARIES = ("numpy", "scipy", "numba", "pydantic")


@dataclass(frozen=True, kw_only=True)
class Points:
    """All points of a study: their values, and the digest by which each is known on disk."""

    study: Study
    design: Design
    digests: list[str]
    made_by: str  # `program` that solves them, or has

    def __len__(self) -> int:
        return len(self.digests)

    def scene(self, i: int) -> Scene:
        """The scene of point i, made when asked for: ten thousand of them would take a gigabyte."""
        return self.study.scene.varied(self.design.changes(i))


def checked_points(study: Study, design: Design, count: Callable[[], None] = lambda: None) -> Points:
    """Validate every point; `count` is called after each.

    Errors
    ------
    UsageError: naming points and keys that can't be used, the first few of them.
    """
    digests, faults = [], []
    first: dict[str, object] = {}
    for i in range(len(design.points)):
        try:
            scene = study.scene.varied(design.changes(i))
            _check_signals(scene, study.keep, first)
        except (SceneError, UsageError) as error:
            reason = str(error).replace("\n", "; ").replace(f"{study.scene.name}: ", "")
            faults.append(f"{design.describe(i)}: {reason}")
            if len(faults) == MOST_FAULTS:
                break
            continue
        digests.append(digest_of(scene, study.keep))
        count()
    if faults:
        raise UsageError("\n".join(faults))
    return Points(study=study, design=design, digests=digests, made_by=program())


def _check_signals(scene: Scene, keep: KeepTable, first: dict[str, object]) -> None:
    """Refuse signals that a point does not have, or that do not fit beside those of the first point."""
    moving = [name for name in keep.quantities if not name.startswith(("first_", "static_", "rating_"))]
    if moving and sample_count(scene) < 2:
        raise UsageError(
            "numerics.duration_ms = 0: a run at rest has only the quantities first_…, static_… and rating_…; keep no "
            "others, or run longer"
        )
    if not keep.signals:
        return
    known = readable(scene)
    for name in keep.signals:
        if name not in known or name == "time":
            raise UsageError(f"keep.signals: {name!r} is no signal of this point; it has {', '.join(known)}")
    interval, rate = scene.numerics.output_interval_us, keep.signal_rate_kHz
    one_of = decimation(1e-6 * interval, None if rate is None else 1e3 * rate)
    sizes: dict[str, object] = {
        "numerics.duration_ms": scene.numerics.duration_ms,
        "numerics.output_interval_us": round(one_of * interval, 6),
    }
    if any(known[name].dimensions == PER_ROLLER for name in keep.signals):
        sizes["bearing.rollers"] = scene.bearing.present
    for key, value in sizes.items():
        if first.setdefault(key, value) != value:
            raise UsageError(
                f"{key} = {value}: signals must have the same length in every point; the first one has {first[key]}; "
                "fix it in [fixed]"
            )
    if one_of > 1 and (count := sample_count(scene)) <= one_of:
        raise UsageError(
            f"keep.signal_rate_kHz = {rate:g}: keeps one of {one_of} samples, but the run has {count}; "
            "use a higher rate, or run longer (numerics.duration_ms)"
        )
    stored = 1e3 / interval  # kHz
    if rate is not None and rate > stored * (1.0 + 1e-9):
        raise UsageError(
            f"keep.signal_rate_kHz = {rate:g}: samples are stored at {stored:g} kHz "
            "(numerics.output_interval_us); at most that"
        )


def digest_of(scene: Scene, keep: KeepTable) -> str:
    """Name of a point's file: a digest of scene, kept quantities, the program's text and its libraries' versions."""
    facts = [FORMAT, scene.to_toml(), sorted(scene.files), keep.model_dump(), program()]
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:32]


@cache
def program() -> str:
    """Digest of the program's own code and of its libraries' versions."""
    libraries = [f"{name} {version(name)}" for name in LIBRARIES]
    return hashlib.sha256("\0".join([source_digest(), *libraries]).encode()).hexdigest()[:16]


COMPLETE, FAILED, STOPPED, LOST = "complete", "failed", "stopped", "lost"


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """What is kept of each point."""

    quantities: tuple[str, ...]
    signals: tuple[str, ...]
    signal_rate: float | None  # Hz; None: every sample
    seconds: float  # the most that a point may take
    runs: bool  # result files too


@dataclass(frozen=True, kw_only=True)
class Solved:
    """What became of a point."""

    status: str  # COMPLETE, FAILED (numerically, or refused), STOPPED (by its time limit), LOST (with its worker)
    text: str = ""  # why it is not complete
    seconds: float = 0.0  # wall time
    quantities: Mapping[str, float] = field(default_factory=dict)
    signals: Mapping[str, np.ndarray] = field(default_factory=dict)  # (n_times, …), decimated
    signal_interval: float = 0.0  # s
    run: bytes | None = None  # the result file


def solve(scene: Scene, wanted: Wanted, stop: Callable[[], bool] = lambda: False) -> Solved | None:
    """Simulate a scene and keep what is wanted; a failure is kept with its reason. None: `stop` said so."""
    began = time.monotonic()

    def over() -> bool:
        return time.monotonic() - began > wanted.seconds

    try:
        if needs_no_run(wanted.quantities, wanted.signals) and not wanted.runs:
            quantities = rated(scene, wanted.quantities)
            return Solved(status=COMPLETE, seconds=time.monotonic() - began, quantities=quantities)
        result = simulate(scene, stop=lambda: stop() or over())
        if result.status != COMPLETE and stop():
            return None
        if result.status != COMPLETE:
            reached = 1e3 * float(result.time[-1]) if len(result.time) else 0.0
            return Solved(
                status=STOPPED,
                text=f"stopped at {reached:.4g} ms: limits.seconds_per_point = {wanted.seconds:g} s were over",
                seconds=time.monotonic() - began,
            )
        interval, signals = _signals(result, wanted)
        return Solved(
            status=COMPLETE,
            seconds=time.monotonic() - began,
            quantities=_quantities(result, wanted.quantities),
            signals=signals,
            signal_interval=interval,
            run=_file(result) if wanted.runs else None,
        )
    except (RunFailed, UsageError, SceneError) as error:
        reason = str(error)
    except MemoryError:
        reason = "not enough memory"
    except Exception as error:  # a study of thousands is not to end by one point; the text says what is wrong
        reason = f"{type(error).__name__}: {error}"
    return Solved(status=FAILED, text=reason, seconds=time.monotonic() - began)


def _quantities(result: Result, names: tuple[str, ...]) -> dict[str, float]:
    found = dict(result.quantities)
    if any(name in OF_CHECK for name in names):
        found |= {each.name: each for each in check_quantities(result.residual())}
    if any(name in OF_STATICS for name in names):
        stiffness = statics(result.scene).stiffness
        found["static_stiffness"] = Quantity("static_stiffness", *OF_STATICS["static_stiffness"], stiffness)
    return {name: float(found[name].value) for name in names if name in found} | rated(result.scene, names)


RATED = {  # answers of rate-bearing, and what turns them into SI
    "rating_life": ("L10r_Mrev", 1e6),
    "rating_peak_pressure": ("peak_pressure_MPa", 1e6),
    "rating_moment": ("tilting_moment_N_m", 1.0),
    "rating_tilt_stiffness": ("tilt_stiffness_N_m_per_rad", 1.0),
}


def needs_no_run(quantities: Collection[str], signals: Collection[str]) -> bool:
    """Whether all that is kept are ratings of the scene."""
    return set(quantities) <= set(OF_RATING) and not signals


def rated(scene: Scene, names: Collection[str]) -> dict[str, float]:
    """Those of OF_RATING; NaN of what can't be rated."""
    from fem.rating.answers import values_of  # other studies start without it

    wanted = {name: RATED[name] for name in names if name in OF_RATING}
    answers = values_of(scene, {answer for answer, _ in wanted.values()})
    return {name: factor * answers[answer] for name, (answer, factor) in wanted.items()}


def _signals(result: Result, wanted: Wanted) -> tuple[float, dict[str, np.ndarray]]:
    """Interval, s, and signals; decimated by a whole number, after a filter without phase."""
    if not wanted.signals:
        return 0.0, {}
    interval = 1e-6 * result.scene.numerics.output_interval_us
    factor = decimation(interval, wanted.signal_rate)
    signals = {name: result[name] for name in wanted.signals}
    if factor > 1:
        from scipy.signal import decimate

        signals = {name: decimate(values, factor, ftype="fir", axis=0) for name, values in signals.items()}
    return factor * interval, {name: np.ascontiguousarray(values) for name, values in signals.items()}


def _file(result: Result) -> bytes:
    with TemporaryDirectory(prefix="run-study-") as folder:
        return result.save(Path(folder) / "run.nc").read_bytes()
