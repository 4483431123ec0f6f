"""The one place of the solver's side that knows the checker: for runs from Python, and for studies.

It hands over a result file and takes numbers back. Nothing that makes a result file imports it.
"""

from math import nan
from pathlib import Path
from typing import TYPE_CHECKING

from fem.quantities import Quantity

if TYPE_CHECKING:
    from residual import Evaluation

MOMENTS = {"mean": "mean", "rms": "rms", "std": "standard deviation"}
LINES = ("FTF", "shaft", "BSF", "BPFO", "BPFI")
MEASURED = "the sensor, without one of the housing, without either of the hub"
OF_CHECK = {  # unit and meaning of what a check tells of a run
    **{f"error_{m}_{axis}": ("N", f"{word} of error_{axis}") for axis in "xy" for m, word in MOMENTS.items()},
    **{f"{n.lower()}_{axis}": ("N", f"rms of error_{axis} around its line {n}") for axis in "xy" for n in LINES},
    "sensor_rms": ("m/s2", f"rms of the acceleration along y of {MEASURED}"),
    "sensor_crest": ("1", "crest factor of that acceleration"),
    "sensor_kurtosis": ("1", "kurtosis of that acceleration; 3 of normal noise"),
    "sensor_bpfo": ("m/s2", "amplitude of BPFO in that acceleration's envelope"),
    "sensor_bpfi": ("m/s2", "amplitude of BPFI in that acceleration's envelope"),
}


def evaluated(path: Path, law: str | None = None, start: float | None = None, order: int = 6) -> "Evaluation":
    """The check of a result file; arguments and errors as `residual.evaluate`."""
    from residual import evaluate, read_result

    return evaluate(read_result(path), law, start, order)


def check_quantities(evaluation: "Evaluation") -> list[Quantity]:
    """All of OF_CHECK; NaN for lines that a bearing at rest or a short record does not have."""
    found = {}
    for direction in evaluation.directions:
        levels = {level.name: level.rms for level in direction.levels}
        for moment in MOMENTS:
            found[f"error_{moment}_{direction.name}"] = float(getattr(direction.error, moment))
        for line in LINES:
            found[f"{line.lower()}_{direction.name}"] = float(levels.get(line, nan))
    measured = evaluation.y.vibration
    amplitudes = {line.name: line.amplitude for line in measured.lines}
    found |= {
        "sensor_rms": measured.rms,
        "sensor_crest": nan if measured.crest is None else measured.crest,
        "sensor_kurtosis": nan if measured.kurtosis is None else measured.kurtosis,
        "sensor_bpfo": amplitudes.get("BPFO", nan),
        "sensor_bpfi": amplitudes.get("BPFI", nan),
    }
    return [Quantity(name, *about, found[name]) for name, about in OF_CHECK.items()]
