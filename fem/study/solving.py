"""One point of a study: a pure function from a scene to numbers, run here or by a worker anywhere."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from fem.checking import OF_CHECK, check_quantities
from fem.errors import RunFailed, UsageError
from fem.interface import simulate, statics
from fem.quantities import OF_STATICS, Quantity
from fem.recording import Result
from fem.study.study_file import decimation
from lagrange.scene import Scene, SceneError

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
    """Simulate a scene and keep what is wanted; whatever goes wrong with it is told. None: `stop` said so."""
    began = time.monotonic()

    def over() -> bool:
        return time.monotonic() - began > wanted.seconds

    try:
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
    return {name: float(found[name].value) for name in names}


def _signals(result: Result, wanted: Wanted) -> tuple[float, dict[str, np.ndarray]]:
    """Interval, s, and signals; decimated by a whole number, after a filter without phase."""
    if not wanted.signals:
        return 0.0, {}
    interval = result.plan.interval
    factor = decimation(interval, wanted.signal_rate)
    signals = {name: result[name] for name in wanted.signals}
    if factor > 1:
        from scipy.signal import decimate

        signals = {name: decimate(values, factor, ftype="fir", axis=0) for name, values in signals.items()}
    return factor * interval, {name: np.ascontiguousarray(values) for name, values in signals.items()}


def _file(result: Result) -> bytes:
    with TemporaryDirectory(prefix="run-study-") as folder:
        return result.save(Path(folder) / "run.nc").read_bytes()
