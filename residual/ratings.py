"""Ratings of the bearing by the run's own loads, as rows of the report; `rate-bearing` has all the others."""

from collections.abc import Callable

import numpy as np

from lagrange.catalogue import dimension_series
from lagrange.rating import sources
from lagrange.rating.capacity import Dimensions, dynamic_capacity, static_capacity
from lagrange.rating.contact_stress import hertz_columns
from lagrange.rating.friction import caged_cylinders, palmgren_torque, skf_torque
from lagrange.rating.life import basic_life, in_hours
from lagrange.rating.run_loads import COLUMNS, RunLoads, run_loads
from lagrange.rating.sources import Source, Unavailable
from residual.evaluation import Evaluation
from residual.formatting import text
from residual.record import Record
from residual.tilt import largest_pressures

OIL_DENSITY = 870.0  # kg/m³, as rate-bearing takes it


def rating_rows(evaluation: Evaluation) -> list[tuple[str, str, str]]:
    """Rows of quantity, value with its unit or why there is none, and source; none of a table from elsewhere."""
    t = evaluation.record
    if t.inner_force is None or t.outer_force is None or "work_dissipated" not in t.energies:
        return []
    columns = vars(t) | dict(t.energies)
    try:
        row = Dimensions.of(t.scene.unmounted_bearing())
        run = run_loads(t.bearing, t.operation, {name: np.asarray(columns[name]) for name in COLUMNS})
    except Unavailable as error:
        return [("ratings", f"none: {error}", "")]
    largest = {f"{side}_force": columns[f"{side}_force"].max() for side in ("inner", "outer")}
    found = []
    for meaning, source, compute in (
        ("basic load ratings C and C0", sources.DYNAMIC,
         lambda: f"{text(dynamic_capacity(row))} and {text(static_capacity(row))} N"),
        ("equivalent load P of the run; its largest load", sources.LOAD,
         lambda: f"{text(run.cycle.load)} N; {text(run.cycle.largest_load)} N"),
        ("static safety factor", sources.STATIC, lambda: text(static_capacity(row) / run.cycle.largest_load)),
        ("basic rating life L10", sources.LIFE,
         lambda: f"{text(in_hours(basic_life(dynamic_capacity(row), run.cycle.load), run.cycle.speed))} h"),
        ("L10r by the run's roller loads", sources.OF_RUN,
         lambda: f"{text(in_hours(run.life(row, t.scene.axial is not None), run.cycle.speed))} h"),
        ("largest Hertz pressure, inner and outer raceway", sources.HERTZ,
         lambda: _pressures(t, largest)),
        ("torque of the run's dissipation", sources.OF_RUN,
         lambda: f"{text(1e3 * run.torque, 3)} N mm, {text(run.dissipated, 3)} W"),
        ("frictional torque by SKF; by Palmgren, ±30 %", sources.BOTH_FRICTIONS, lambda: _torques(evaluation, run)),
    ):  # fmt: skip
        found.append((meaning, _value(compute), _named(source)))
    return found


def _value(compute: Callable[[], str]) -> str:
    try:
        return compute()
    except Unavailable as error:
        return f"none: {error}"


def _named(source: Source) -> str:
    return source.name + (" †" if source.second_hand else "")


def _pressures(record: Record, largest: dict[str, np.ndarray]) -> str:
    if record.scene.axial is None:
        columns = hertz_columns(record.bearing, largest)
        found = tuple(float(columns[f"{side}_peak_pressure"]) for side in ("inner", "outer"))
    else:
        found = largest_pressures(record)
    return " and ".join(text(1e-6 * each) for each in found) + " MPa"


def _torques(evaluation: Evaluation, run: RunLoads) -> str:
    bearing, scene = evaluation.record.bearing, evaluation.record.scene
    lubricant = scene.lubricant
    caged_cylinders(Dimensions.of(scene.unmounted_bearing()))
    if lubricant is None:
        raise Unavailable("no viscosity: the scene has no [lubricant]")
    viscosity = 1e6 * lubricant.viscosity_Pa_s / OIL_DENSITY
    diameters = 2e3 * (bearing.bore_radius or bearing.inner_raceway_radius), 2e3 * bearing.outside_radius
    at = *diameters, run.cycle.load, run.cycle.speed, viscosity, dimension_series(scene.bearing.designation)
    return f"{text(skf_torque(*at).total)}; {text(palmgren_torque(*at).total)} N mm"
