"""The options of a report, and the numbers of summary.json, with their units in their names."""

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees
from operator import attrgetter
from typing import Any

import numpy as np

from lagrange.messages import shown
from lagrange.section import load_factor
from residual.budget import LawScore
from residual.evaluation import Evaluation
from residual.fault_finding import SIGMAS, FaultSearch, FoundSpall, SinkageMap
from residual.fitted_laws import CONFIDENCE, Identification, Interval
from residual.interpretation import floor_newtons, reported_angle, unseen
from residual.lines import LineLevel
from residual.record import CageMotion, Record
from residual.sampling import PositionNoise, Stationarity
from residual.spectrum import Level, Peak, Statistics, rms
from residual.tilt import tilt_summary
from residual.vibration import FaultLine, Vibration

PROGRAM = "check-residual"


@dataclass(frozen=True, kw_only=True)
class ReportOptions:
    """Content of a report."""

    tolerance: float | None = None  # N, on the rms of both errors; None: no verdict
    search: FaultSearch | None = None  # for spalls; None: none was made
    figures: bool = True  # most of a report's time
    equations: bool = True  # False: of the run alone, without the error forces of (22) and (23)
    signals: bool = False  # as CSV, too
    other: Evaluation | None = None  # what the run is compared with


def _angles(found: FoundSpall) -> np.ndarray:
    """Interval of a spall's angle, degrees, as scenes give it."""
    return reported_angle(found.place, found.angle) + degrees(found.angle_error) * np.array([-1.0, 1.0])


def _item(name: str, key: int | str) -> Callable[[Any], Any]:
    """How to get an item of an attribute."""
    return lambda found: getattr(found, name)[key]


def _axes(name: str) -> Callable[[Any], dict]:
    """How to get an attribute's pair by x and y."""
    return lambda found: dict(zip("xy", getattr(found, name), strict=True))


def _settled(found: Stationarity) -> float | None:
    return None if found.settled is None else float(found.start[found.settled])


# keys of the numbers of each class: its attribute, or a function of it
KEYS: dict[type, dict[str, str | Callable[[Any], Any]]] = {
    Statistics: {"mean_N": "mean", "rms_N": "rms", "std_N": "std", "max_abs_N": "max_abs"},
    Peak: {
        "frequency_Hz": "frequency", "psd_N2_Hz": "psd", "rms_N": "rms", "line": "line", "also": "also",
        "resolved": "resolved",
    },
    LineLevel: {
        "line": "name", "frequency_Hz": "frequency", "rms_N": "rms", "background_rms_N": "background",
        "band_Hz": attrgetter("low", "high"), "stands_out": "stands_out", "resolved": "resolved",
        "record_needed_s": "record_needed",
    },
    Vibration: {
        "body": "body", "peak_m_s2": "level.peak", "rms_m_s2": "level.rms", "crest_factor": "level.crest",
        "kurtosis": "level.kurtosis",
        "bands": lambda v: [{"band_Hz": list(limits)} | numbers(level) for limits, level in v.bands.items()],
        "velocity_mm_s": lambda v: None if v.velocity is None else 1e3 * v.velocity,
        "envelope_band_Hz": lambda v: None if v.envelope is None else [v.envelope.low, v.envelope.high],
        "envelope_lines": "lines",
    },
    Level: {"rms_m_s2": "rms", "kurtosis": "kurtosis", "crest_factor": "crest"},
    FaultLine: {
        "line": "name", "frequency_Hz": "frequency", "amplitude_m_s2": "amplitude", "floor_m_s2": "floor",
        "ratio": "ratio", "stands_out": "stands_out", "resolved": "resolved", "nearest": "nearest",
        "record_needed_s": "record_needed",
    },
    FoundSpall: {
        "body": "place.body", "roller": "place.roller", "angle_deg": lambda s: reported_angle(s.place, s.angle),
        "angle_interval_deg": _angles, "width_mm": lambda s: 1e3 * s.width,
        "width_interval_mm": lambda s: 1e3 * s.width + 1e3 * s.width_error * np.array([-1.0, 1.0]),
        "interval_sigmas": lambda _: SIGMAS, "stands_out": "stands_out", "explained": "explained",
        "passages": "passages",
    },
    SinkageMap: {"body": "place.body", "roller": "place.roller", "share": "seen", "unseen_deg": unseen},
    PositionNoise: {
        "rounding_step_m": "step", "hub_rms_m": _axes("hub"),
        "roller_rms_m": "roller", "balance_N": _axes("inertia"),
        "error_N": _axes("error"),
    },
    Stationarity: {
        "start_s": "start", **{f"hub_std_{axis}_m": _item("hub", axis) for axis in "xy"},
        **{f"error_rms_{axis}_N": _item("error", axis) for axis in "xy"}, "settled_from_s": _settled,
    },
    LawScore: {
        "law": "name", "error_x": _item("errors", 0), "error_y": _item("errors", 1), "contact_rms_N": "contact_rms",
    },
    Interval: {"value": "value", "low": "low", "high": "high"},
    Identification: {
        "stiffness_N_per_m_to_the_n": "stiffness", "exponent": "exponent", "damping_N_s_per_m": "damping",
        "confidence": lambda _: CONFIDENCE, "contacts": "contacts", "passages": "passages", "scatter_N": "scatter",
    },
}  # fmt: skip


def numbers(found: Any) -> Any:
    """An object's numbers by their keys, as JSON has them; each of a list's or an array's; others as they are."""
    if type(found) in KEYS:
        return {
            key: numbers(attrgetter(of)(found) if isinstance(of, str) else of(found))
            for key, of in KEYS[type(found)].items()
        }
    if isinstance(found, np.ndarray):
        return found.tolist()
    return [numbers(each) for each in found] if isinstance(found, list | tuple) else found


def summarise(evaluation: Evaluation, options: ReportOptions) -> dict:
    """Content of summary.json: `budget_*` are the terms' rms, `budget_mean_*` add up to the error's mean."""
    t, directions, tolerance, search = evaluation.record, evaluation.directions, options.tolerance, options.search
    noise, (low, high) = numbers(evaluation.position_noise), evaluation.loaded_range
    said = evaluation.diagnosis
    summary = {
        "run": t.name,
        "source": shown(t.source.name),
        "law": evaluation.law.name,
        "samples": int(t.time.size),
        "interval_s": t.interval,
        "start_s": evaluation.start,
        "order": evaluation.order,
        **{f"error_{d.name}": numbers(d.error) for d in directions},
        "frequency_resolution_Hz": evaluation.x.spectrum.resolution,
        "segments": evaluation.x.spectrum.segments,
        "kinematic_lines_Hz": evaluation.lines,
        "cage_Hz": {
            "observed": evaluation.lines.get("FTF"),
            "rolling_without_slip": None if t.reverses else evaluation.ideal_cage,
        },
        **({} if t.cage is None else {"cage": _cage(t, t.cage, evaluation.ideal_cage)}),
        **{f"peaks_{d.name}": numbers(d.peaks) for d in directions},
        **{f"lines_{d.name}": numbers(d.levels) for d in directions},
        **{f"vibration_{d.name}": numbers(d.vibration) for d in directions},
        "diagnosis": {
            "verdict": None if isinstance(said, str) else said.verdict,
            "reasons": [said] if isinstance(said, str) else list(said.reasons),
        },
        "orders": _orders(evaluation),
        **({} if search is None else {"faults": numbers(search.found), "faults_seen": numbers(search.maps)}),
        **({} if search is None else {"faults_left_stand_out": max((m.deepest[1] for m in search.left), default=0.0)}),
        "watched": [{"x": numbers(x), "y": numbers(y)} for x, y in evaluation.watched],
        "loaded_rollers": {"min": low, "max": high},
        "differentiation_floor_N": dict(zip("xy", floor_newtons(evaluation), strict=True)),
        "load_N": t.load,  # of the plane section
        "bearing_load_N": load_factor(t.bearing) * t.load,
        "position_noise": None if noise is None else noise | {"within": evaluation.within_noise},
        "quarters": numbers(evaluation.quarters),
        "tolerance_N": tolerance,
        "verdict": None if tolerance is None else ("fails" if evaluation.fails(tolerance) else "passes"),
        "contradictions": list(evaluation.contradictions),
        "notes": list(evaluation.notes),
        "laws": numbers(evaluation.laws),
        "identification": _identification(evaluation),
        **({} if evaluation.tilt is None else {"tilt": tilt_summary(evaluation.tilt)}),
    }
    for d in directions:
        terms = d.budget.terms
        summary[f"budget_mean_{d.name}"] = {name: float(np.mean(v)) for name, v in terms.items()}
        summary[f"budget_{d.name}"] = {name: rms(v) for name, v in terms.items()}
        if d.balance is not None:
            summary[f"momentum_{d.name}"] = numbers(d.balance)
            summary[f"budget_{d.name}"]["momentum"] = d.balance.rms
        summary[f"away_from_contact_changes_{d.name}"] = numbers(d.away)
    return summary


def _cage(t: Record, cage: CageMotion, rolling: float) -> dict[str, float | None]:
    """Numbers of a cage, Hz where it rolls without slip; null where the shaft reverses, and slip within one turn."""
    speed, ideal = cage.speed(t.interval), 2.0 * np.pi * rolling
    return {
        "speed_Hz": None if t.reverses else speed / (2.0 * np.pi),
        "slip": None if t.reverses or ideal == 0.0 or t.orbits < 1.0 else 1.0 - abs(speed) / ideal,
        "largest_offset_m": float(np.hypot(cage.x, cage.y).max()),
        "whirl_Hz": None if t.reverses else cage.whirl(t.interval) / (2.0 * np.pi),
        "largest_pocket_force_N": float(np.abs(cage.force).max()),
        "largest_guidance_force_N": float(np.hypot(cage.guidance_x, cage.guidance_y).max()),
    }


def _orders(evaluation: Evaluation) -> dict | None:
    """Lines and peaks of the hub's path in orders of the shaft; None where its speed stays."""
    found = {d.name: d.orders for d in evaluation.directions if d.orders is not None}
    if not found:
        return None
    tracking = found["x"].tracking
    return {
        "start_s": float(tracking.time[0]),
        "end_s": float(tracking.time[-1]),
        "resolution": found["x"].path.resolution,
        "lines": tracking.lines,
    } | {
        f"peaks_{name}": [
            {"order": p.frequency, "rms_m": p.rms, "line": p.line, "resolved": p.resolved} for p in orders.peaks
        ]
        for name, orders in found.items()
    }


def _identification(evaluation: Evaluation) -> dict | None:
    """The fit's numbers in SI, and the errors on the part of the record it was not fitted to."""
    found, time = evaluation.identification, evaluation.record.time
    if found is None:
        return None
    held_back = {"start_s": float(time[found.samples]), "samples": int(time.size - found.samples)}
    held_back |= {f"error_{axis}": numbers(error) for axis, error in zip("xy", evaluation.judged, strict=True)}
    return numbers(found) | {"fitted_until_s": float(time[found.samples - 1]), "held_back": held_back}
