"""What run-fem prints of plans, runs and estimates, whichever solver they are of."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from fem.result.layout import bytes_of_a_sample, variables_of
from fem.run_summary import run_summary
from fem.solver.compiling import CompiledPlan
from fem.solver.solver import Plan, RunState
from lagrange import Bearing
from lagrange.kinematics import kinematics, mean_kinematics
from lagrange.messages import engineering, shown
from lagrange.mounting import from_outer_ring
from lagrange.scene.cage import default_cage
from lagrange.scene.operation import RPM
from lagrange.scene.scene import Scene
from lagrange.section import is_plain, section_words

if TYPE_CHECKING:
    from fem.solver.errors import Estimate, MeshTable

LARGE_RESULT = 200.0  # MB, of which a run warns
LEAST_ERROR = 1e-5  # relative; less is the round-off of two solutions


def print_plan(plan: Plan, name: str) -> None:
    """What is decided for a run of that name, and its cost. RunFailed: there is no equilibrium to tell of."""
    from fem.solver.trial import is_compiled, seconds_by_trial  # only a dry run needs what it imports

    console, table, rows = Console(highlight=False), plan.table(), plan.rows()
    seconds = seconds_by_trial(plan)
    if seconds is not None:
        rows["expected time"] = f"about {seconds:.2g} s (measured on a short piece)"
    rows["samples in the result file"] = f"{result_megabytes(plan):.3g} MB"
    if isinstance(plan, CompiledPlan):
        rows["compilation"] = "none, already cached" if is_compiled(plan) else plan.compiling
    console.print(f"Plan of {shown(name)}, {plan.model_name}", style="italic", markup=False)
    if table is not None:
        console.print(table)
    _print_clearance(console, plan.scene)
    for name, value in (_of_the_bearing(plan.scene) | rows).items():
        console.print(f"{name + ':':30s} {value}", soft_wrap=True)
    _print_choices(console, plan, seconds)
    large = size_warning(plan)
    _print_warnings(console, (*plan.notices, *plan.warnings, *(() if large is None else (large,))))


def result_megabytes(plan: Plan) -> float:
    """Size of a plan's samples in the result file, without stored fields."""
    rollers = plan.scene.ideal_bearing().n_rollers
    return 1e-6 * plan.n_samples * bytes_of_a_sample(variables_of(plan.scene), rollers)


def size_warning(plan: Plan) -> str | None:
    """A warning of a large result file; None: it is not large."""
    size, numerics = result_megabytes(plan), plan.scene.numerics
    if size <= LARGE_RESULT:
        return None
    return (
        f"the result file takes {size:.3g} MB; to make it smaller, lower numerics.duration_ms = "
        f"{numerics.duration_ms:g}, or raise numerics.output_interval_us = {numerics.output_interval_us:g} if fast "
        "vibration does not matter"
    )


def print_meshes(name: str, found: "MeshTable") -> None:
    """Statics on meshes, Richardson's values and those of the exact series."""
    console = Console(highlight=False)
    quantities = found.meshes[0].quantities
    table = Table(title=f"Statics of {escape(shown(name))} by mesh", title_justify="left")
    for heading in ("mesh, mm", "nodes", *(quantity.meaning for quantity in quantities)):
        table.add_column(heading, justify="right")
    units = [engineering(quantity.unit) for quantity in quantities]

    def row(values: Iterable[float | None]) -> list[str]:
        pairs = zip(values, units, strict=True)
        return ["" if value is None else f"{factor * value:.6g} {unit}" for value, (factor, unit) in pairs]

    for mesh in found.meshes:
        table.add_row(f"{mesh.size:.3g}", str(mesh.nodes), *row(q.value for q in mesh.quantities))
    table.add_row("Richardson", "", *row(found.extrapolated))
    if any(value is not None for value in found.exact):
        table.add_row("exact series", "", *row(found.exact))
    console.print(table)


def _print_clearance(console: Console, scene: Scene) -> None:
    """How the clearance in operation comes about, where the scene has fits."""
    if (found := scene.operating_clearance()) is None:
        return
    table = Table(title="Diametral clearance", title_justify="left", title_style="")
    for heading in ("part", "µm", ""):
        table.add_column(heading, justify="right" if heading == "µm" else "left")
    for row in found.rows():
        table.add_row(*row)
    console.print(table)


def _of_the_bearing(scene: Scene) -> dict[str, str]:
    """What the scene alone decides and its file does not say."""
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    clearance = round(2e6 * bearing.radial_clearance / bearing.cosine + 1e-9, 3) + 0.0
    rows = {} if scene.fit else {"diametral clearance": f"{clearance:.3f} µm"}
    if not is_plain(bearing):
        rows["plane section"] = section_words(bearing)
    if scene.assumed:
        rows["defaults"] = scene.assumed
    if operation.history is not None:
        rows["largest load"] = f"at most {operation.heaviest:.5g} N"
    if operation.varies_speed:
        inner, outer = operation.ring_speeds_met
        for name, speeds in (("shaft speed", inner), ("outer ring speed", outer)):
            if speeds.any():
                rows[name] = f"{speeds.min() / RPM:.6g} to {speeds.max() / RPM:.6g} rpm"
        at = [np.argmin(inner), np.argmax(inner)] if np.ptp(inner) else [np.argmin(outer), np.argmax(outer)]
        for speed, ring in {(float(inner[k]), float(outer[k])): None for k in at}:
            beside = f", outer ring {ring / RPM:.6g} rpm" if outer.any() else ""
            rows[f"frequencies at {speed / RPM:.6g} rpm{beside}"] = _frequencies(bearing, speed, ring)
    elif operation.fastest:
        rows["frequencies, without slip"] = _frequencies(bearing, *operation.ring_speeds)
    if scene.cage is not None:
        rows["cage"] = scene.cage.words + ("" if scene.is_given("cage") else "; the default")
    elif scene.model != "lagrange" or scene.lagrange.angles == "free":
        why = default_cage(scene)
        rows["cage"] = f"none{f' ({why})' if isinstance(why, str) else ''}: unloaded rollers coast"
    return rows


def _frequencies(bearing: Bearing, *speeds: float) -> str:
    """Kinematic lines at speeds of the inner and of the outer ring, rad/s, in words."""
    return ", ".join(f"{name} {value:.4g} Hz" for name, value in kinematics(bearing, *speeds).frequencies.items())


def _print_choices(console: Console, plan: Plan, seconds: float | None) -> None:
    """What each model takes for the scene, what it errs by and leaves out; what to begin with.

    `seconds` : that the plan's own takes, as far as it has been tried
    """
    from fem.solver.errors import model_choices, suggestion  # only a dry run needs what these import

    choices = [
        each if seconds is None or each.model != plan.scene.model else replace(each, seconds=seconds)
        for each in model_choices(plan)
    ]
    if (begin := suggestion(choices)) is None:
        return
    table = Table(title="Models for this scene", title_justify="left")
    for heading in ("model", "expected time", "static error of hub", "leaves out"):
        table.add_column(heading, justify="left" if heading in ("model", "leaves out") else "right")
    for each in choices:
        seconds = "-" if each.seconds is None else f"{each.seconds:.2g} s"
        error = _percent(each.hub_error)
        table.add_row(each.model, seconds, error, escape(shown(each.lacks)))
    console.print(table)
    console.print(begin, soft_wrap=True, markup=False)


def _percent(error: float | None) -> str:
    if error is None:
        return "-"
    return f"{100 * error:.2g} %" if error > LEAST_ERROR else f"below {100 * LEAST_ERROR:g} %"


def print_run(state: RunState, samples: dict[str, np.ndarray], path: Path) -> None:
    """Print the bearing's quantities from a run's samples, by the file's names, and the file's place."""
    console, plan, progress = Console(highlight=False), state.plan, state.progress
    if plan.n_samples == 1:
        force = samples["inner_force"][0]
        forces = ", ".join(f"{value:.1f}" for value in sorted(force[force > 0.0], reverse=True))
        x, y = (round(1e6 * place[0], 4) + 0.0 for place in from_outer_ring(samples, "inner"))
        lines = [
            f"Static equilibrium{at_speed(plan.scene)}: hub x {x:.4f} µm, y {y:.4f} µm",
            f"Loaded rollers: {forces or 'none'} N",
        ]
        moved = [body for body in ("outer_ring", "housing") if f"{body}_y" in samples]
        lines[0] += ", from the outer ring's centre" if moved else ""
        for body in moved:
            place = ", ".join(f"{axis} {1e6 * samples[f'{body}_{axis}'][0]:.4f} µm" for axis in "xy")
            lines[0] += f"; {body.replace('_', ' ')} {place}"
    else:
        bearing = plan.scene.ideal_bearing()
        ideal = mean_kinematics(bearing, plan.scene.ideal_operation(), progress.simulated)
        found = run_summary(bearing, ideal, samples, tilts=plan.scene.axial is not None)
        lines = [f"{name + ':':14s} {value}" for name, value in found.items()]
        lines.append(
            f"{1e3 * progress.simulated:g} ms in {progress.wall:.2f} s ({progress.steps} steps), energy imbalance "
            f"{progress.imbalance:+.1e} of the exchanged energy"
        )
    if words := section_words(plan.scene.ideal_bearing()):
        lines.insert(0, f"plane section: {words}")
    if plan.scene.assumed:
        lines.append(f"{'defaults:':14s} {plan.scene.assumed}")
    for line in lines:
        console.print(line, soft_wrap=True)
    _print_warnings(console, state.warnings)  # the plan's stand at the start
    console.print(f"Result: {shown(path)}", soft_wrap=True, markup=False)


def at_speed(scene: Scene) -> str:
    """The speed of an equilibrium in which rollers' centrifugal force acts; "" at rest."""
    inner, outer = (speed / RPM for speed in scene.ideal_operation().ring_speeds)
    if not (inner or outer):
        return " at rest"
    return f" at {inner:g} rpm" + (f", outer ring {outer:g} rpm" if outer else "") + ", with centrifugal force"


def print_estimates(found: "list[Estimate]", title: str) -> None:
    """Every quantity with its estimated error."""
    console = Console(highlight=False)
    table = Table(title=title, title_justify="left")
    for heading in ("quantity", "value", "may be off by", "relative"):
        table.add_column(heading, justify="left" if heading == "quantity" else "right")
    for each in found:
        scale, unit = engineering(each.quantity.unit)
        table.add_row(
            each.quantity.meaning,
            f"{scale * each.quantity.value:.5g} {unit}",
            f"{scale * each.error:.2g} {unit}",
            f"{100 * each.relative:.2g} %" if each.relative < 1.0 else "-",
        )
    console.print(table)


def _print_warnings(console: Console, warnings: tuple[str, ...]) -> None:
    for sentence in warnings:
        console.print(f"Warning: {sentence}", soft_wrap=True, markup=False)
