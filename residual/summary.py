"""The numbers of summary.json, with their units in their names."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from lagrange.messages import shown
from residual.budget import LawScore
from residual.evaluation import Evaluation
from residual.fault_finding import FaultSearch
from residual.fitted_laws import CONFIDENCE, Identification
from residual.lines import LineLevel
from residual.spectrum import Peak, Statistics, rms
from residual.tables import floor_newtons
from residual.vibration import Vibration
from residual.vibration_tables import search_summary

Export = Literal["csv", "curves", "mat", "wav"]


@dataclass(frozen=True, kw_only=True)
class ReportOptions:
    """Of a report."""

    tolerance: float | None = None  # N, on the rms of both errors; None: no verdict
    search: FaultSearch | None = None  # for spalls; None: none was made
    figures: bool = True  # most of a report's time
    equations: bool = True  # False: of the run alone, without the error forces of (22) and (23)
    exports: tuple[Export, ...] = ()  # the data in other formats
    other: Evaluation | None = None  # what the run is compared with


PROGRAM = "check-residual"


def summarise(evaluation: Evaluation, options: ReportOptions, version: str) -> dict:
    """Content of summary.json: `budget_*` are the terms' rms, `budget_mean_*` add up to the error's mean."""
    t, directions, tolerance = evaluation.record, evaluation.directions, options.tolerance
    low, high = evaluation.loaded_range
    floors = floor_newtons(evaluation)
    summary = {
        "program": PROGRAM,
        "program_version": version,
        "run": t.name,
        "source": shown(t.source.name),
        "law": evaluation.law.name,
        "samples": int(t.time.size),
        "interval_s": t.interval,
        "start_s": evaluation.start,
        "order": evaluation.order,
        **_errors((evaluation.x.error, evaluation.y.error)),
        "frequency_resolution_Hz": evaluation.x.spectrum.resolution,
        "segments": evaluation.x.spectrum.segments,
        "kinematic_lines_Hz": evaluation.lines,
        "cage_Hz": {
            "observed": evaluation.lines.get("FTF"),
            "rolling_without_slip": None if evaluation.record.reverses else evaluation.ideal_cage,
        },
        **_caged(evaluation),
        **{f"peaks_{d.name}": [_peak(peak) for peak in d.peaks] for d in directions},
        **{f"lines_{d.name}": [_level(level) for level in d.levels] for d in directions},
        **{f"vibration_{d.name}": _vibration(d.vibration) for d in directions},
        "orders": _orders(evaluation),
        **search_summary(options.search),
        "watched": [{"x": _level(x), "y": _level(y)} for x, y in evaluation.watched],
        "loaded_rollers": {"min": low, "max": high},
        "differentiation_floor_N": {"x": floors[0], "y": floors[1]},
        "load_N": t.load,
        "position_noise": _position_noise(evaluation),
        "quarters": _quarters(evaluation),
        "tolerance_N": tolerance,
        "verdict": None if tolerance is None else ("fails" if evaluation.fails(tolerance) else "passes"),
        "notes": list(evaluation.notes),
    }
    summary["laws"] = [_score(score) for score in evaluation.laws]
    found = evaluation.identification
    summary["identification"] = None if found is None else _identification(found, t.time, evaluation.judged)
    for d in directions:
        terms = d.budget.terms
        summary[f"budget_mean_{d.name}"] = {name: float(np.mean(v)) for name, v in terms.items()}
        summary[f"budget_{d.name}"] = {name: rms(v) for name, v in terms.items()}
        if d.balance is not None:
            summary[f"momentum_{d.name}"] = _statistics(d.balance)
            summary[f"budget_{d.name}"]["momentum"] = d.balance.rms
        summary[f"away_from_contact_changes_{d.name}"] = None if d.away is None else _statistics(d.away)
    return summary


def _caged(evaluation: Evaluation) -> dict:
    """Of a run with a cage; null where there is no such mean."""
    t, cage = evaluation.record, evaluation.record.cage
    if cage is None:
        return {}
    speed, ideal = cage.speed(t.interval), 2.0 * np.pi * evaluation.ideal_cage
    return {
        "cage": {
            "speed_Hz": None if t.reverses else speed / (2.0 * np.pi),
            "slip": None if t.reverses or ideal == 0.0 else 1.0 - abs(speed) / ideal,
            "largest_offset_m": float(np.hypot(cage.x, cage.y).max()),
            "whirl_Hz": None if t.reverses else cage.whirl(t.interval) / (2.0 * np.pi),
            "largest_pocket_force_N": float(np.abs(cage.force).max()),
            "largest_guidance_force_N": float(np.hypot(cage.guidance_x, cage.guidance_y).max()),
        }
    }


def _position_noise(evaluation: Evaluation) -> dict | None:
    """What a table's positions err by and the error forces that this makes; null of a run of run-fem."""
    found = evaluation.position_noise
    if found is None:
        return None
    return {
        "rounding_step_m": found.step,
        "hub_rms_m": dict(zip("xy", found.hub, strict=True)),
        "roller_rms_m": found.roller,
        "balance_N": dict(zip("xy", found.inertia, strict=True)),
        "error_N": dict(zip("xy", found.error, strict=True)),
        "within": evaluation.within_noise,
    }


def _quarters(evaluation: Evaluation) -> dict | None:
    """What varies in each quarter of the record; null for one too short for it."""
    found = evaluation.quarters
    if found is None:
        return None
    return {
        "start_s": found.start.tolist(),
        **{f"hub_std_{name}_m": values.tolist() for name, values in found.hub.items()},
        **{f"error_rms_{name}_N": values.tolist() for name, values in found.error.items()},
        "settled_from_s": None if found.settled is None else float(found.start[found.settled]),
    }


def _statistics(s: Statistics) -> dict[str, float]:
    return {"mean_N": s.mean, "rms_N": s.rms, "std_N": s.std, "max_abs_N": s.max_abs}


def _errors(errors: tuple[Statistics, Statistics]) -> dict[str, dict[str, float]]:
    return {"error_x": _statistics(errors[0]), "error_y": _statistics(errors[1])}


def _level(level: LineLevel) -> dict:
    return {
        "line": level.name,
        "frequency_Hz": level.frequency,
        "rms_N": level.rms,
        "background_rms_N": level.background,
        "band_Hz": [level.low, level.high],
        "stands_out": level.stands_out,
        "resolved": level.resolved,
        "record_needed_s": level.record_needed,
    }


def _vibration(v: Vibration) -> dict:
    """Levels of a body's acceleration and amplitudes of the fault lines in its envelope."""
    return {
        "body": v.body,
        "peak_m_s2": v.peak,
        "rms_m_s2": v.rms,
        "crest_factor": v.crest,
        "kurtosis": v.kurtosis,
        "bands": [{"band_Hz": list(limits), "rms_m_s2": level} for limits, level in v.bands.items()],
        "envelope_band_Hz": None if v.envelope is None else [v.envelope.low, v.envelope.high],
        "envelope_lines": [
            {
                "line": line.name,
                "frequency_Hz": line.frequency,
                "amplitude_m_s2": line.amplitude,
                "floor_m_s2": line.floor,
                "ratio": line.ratio,
                "stands_out": line.stands_out,
                "resolved": line.resolved,
                "record_needed_s": line.record_needed,
            }
            for line in v.lines
        ],
    }


def _orders(evaluation: Evaluation) -> dict | None:
    """Lines and peaks of the hub's path in orders of the shaft; None where its speed stays."""
    found = {d.name: d.orders for d in evaluation.directions if d.orders is not None}
    if not found:
        return None
    tracking, path = found["x"].tracking, found["x"].path
    return {
        "start_s": float(tracking.time[0]),
        "end_s": float(tracking.time[-1]),
        "resolution": path.resolution,
        "lines": tracking.lines,
        **{
            f"peaks_{name}": [
                {"order": p.frequency, "rms_m": p.rms, "line": p.line, "resolved": p.resolved} for p in orders.peaks
            ]
            for name, orders in found.items()
        },
    }


def _score(score: LawScore) -> dict:
    return {
        "law": score.name,
        **_errors(score.errors),
        "contact_rms_N": score.contact_rms,
    }


def _identification(found: Identification, time: np.ndarray, held_back) -> dict:
    """The fit's numbers in SI, and the errors on the part of the record it was not fitted to."""

    def interval(number):
        return None if number is None else {"value": number.value, "low": number.low, "high": number.high}

    return {
        "stiffness_N_per_m_to_the_n": interval(found.stiffness),
        "exponent": interval(found.exponent),
        "coupling_m_per_N": interval(found.coupling),
        "damping_N_s_per_m": interval(found.damping),
        "confidence": CONFIDENCE,
        "contacts": found.contacts,
        "passages": found.passages,
        "scatter_N": found.scatter,
        "fitted_until_s": float(time[found.samples - 1]),
        "held_back": {
            "start_s": float(time[found.samples]),
            "samples": int(time.size - found.samples),
            **_errors(held_back),
        },
    }


def _peak(p: Peak) -> dict:
    return {
        "frequency_Hz": p.frequency,
        "psd_N2_Hz": p.psd,
        "rms_N": p.rms,
        "line": p.line,
        "also": list(p.also),
        "resolved": p.resolved,
    }
