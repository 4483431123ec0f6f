"""What run-fem prints: the plan, the outcome."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from fem.solver.arrays import Arrays
from fem.solver.error_estimate import Estimate
from fem.solver.simulate import Plan, Progress
from fem.statics.static_error import static_error
from fem.wording import run_line, statics_lines
from meshes import Mesh, quality

# one thread of a 2024 server core; only a guide, `wall_seconds` of a run is the truth
SECONDS_PER_DOF = 0.9e-9
SECONDS_PER_ROLLER = 0.35e-6
BYTES_PER_NODE = 20  # of a stored frame: displacement and stress in single precision


def print_plan(plan: Plan) -> None:
    """Meshes, steps, memory and the time to expect."""
    console = Console(highlight=False)
    model, scene = plan.model, plan.scene
    table = Table(title=f"Plan of {scene.name}", title_justify="left")
    for heading in ("mesh", "nodes", "cells", "edges, mm", "angles, deg"):
        table.add_column(heading, justify="left" if heading == "mesh" else "right")
    for name in ("roller", "inner_ring", "outer_ring"):
        body = getattr(model, name)
        q = quality(Mesh(points=body.points, cells=body.cells))
        table.add_row(
            name.replace("_", " ") + (", rigid: only drawn" if body.material.rigid else ""),
            str(q.nodes),
            str(q.cells),
            f"{1e3 * q.smallest_edge:.3f} - {1e3 * q.largest_edge:.3f}",
            f"{q.smallest_angle:.0f} - {q.largest_angle:.0f}",
        )
    console.print(table)
    seconds = plan.steps * (SECONDS_PER_DOF * model.degrees_of_freedom + SECONDS_PER_ROLLER * model.bearing.n_rollers)
    load = float(max(plan.start.equilibrium.inner_force.max(), plan.start.equilibrium.outer_force.max()))
    rows = {
        "degrees of freedom": f"{model.degrees_of_freedom}",
        "time step": f"{1e9 * plan.time_step:.2f} ns ({plan.time_step / plan.critical_time_step:.2f} of the critical "
        f"{1e9 * plan.critical_time_step:.2f} ns)",
        "steps": f"{plan.steps} for {1e3 * (plan.n_samples - 1) * plan.interval:g} ms",
        "samples": f"{plan.n_samples}, one each {plan.stride} steps",
        **_fields(plan),
        "memory of the arrays": f"{memory_megabytes(plan.arrays()):.1f} MB",
        "expected time": f"about {seconds:.2g} s",
        "largest static contact force": f"{load:.1f} N, "
        f"{1e-6 * model.inner_law.pair.peak_pressure(load):.0f} MPa at the inner raceway",
    }
    if plan.operation.radial_load > 0.0:
        error = static_error(model, plan.operation)
        rows["static error of the mesh"] = (
            f"hub displacement {100 * error.hub:.2g} %, loads {100 * error.largest_force:.2g} % (against exact series)"
        )
    for name, value in rows.items():
        console.print(f"{name + ':':30s} {value}", soft_wrap=True)
    _print_cautions(console, plan)


def _fields(plan: Plan) -> dict[str, str]:
    """How much the stored fields will take, before compression."""
    if not plan.frame_stride:
        return {}
    frames = 1 + (plan.n_samples - 1) // plan.frame_stride
    size = 1e-6 * frames * plan.model.n_nodes * BYTES_PER_NODE
    return {"fields": f"{frames}, one each {1e3 * plan.frame_stride * plan.interval:g} ms, {size:.3g} MB"}


def memory_megabytes(arrays: Arrays) -> float:
    """Size of the time loop's arrays."""
    parts = (arrays.rollers, arrays.inner, arrays.outer, arrays.contacts, arrays.drive, arrays.scratch)
    return 1e-6 * sum(getattr(field, "nbytes", 0) for part in parts for field in part)


def print_run(plan: Plan, progress: Progress, path: Path) -> None:
    """One line about the run and where it is."""
    console = Console(highlight=False)
    if plan.n_samples == 1:
        lines = statics_lines(*plan.start.equilibrium.hub, plan.start.equilibrium.inner_force)
    else:
        lines = [run_line(progress.simulated, progress.wall, progress.steps, progress.imbalance, "exchanged")]
    for line in lines:
        console.print(line, soft_wrap=True)
    _print_cautions(console, plan)
    console.print(f"Result: {path}", soft_wrap=True, markup=False)


def print_estimates(found: list[Estimate], coarse_mesh_size: float) -> None:
    """Every quantity with what it may be off by."""
    console = Console(highlight=False)
    table = Table(
        title=f"Discretisation error, estimated with a mesh of {1e3 * coarse_mesh_size:g} mm", title_justify="left"
    )
    for heading in ("quantity", "value", "may be off by", "relative"):
        table.add_column(heading, justify="left" if heading == "quantity" else "right")
    for each in found:
        scale, unit = (1e6, "µm") if each.quantity.unit == "m" else (1.0, each.quantity.unit.replace("1", ""))
        table.add_row(
            each.quantity.meaning,
            f"{scale * each.quantity.value:.5g} {unit}",
            f"{scale * each.error:.2g} {unit}",
            f"{100 * each.relative:.2g} %" if each.relative < 1.0 else "-",
        )
    console.print(table)


def _print_cautions(console: Console, plan: Plan) -> None:
    for sentence in plan.cautions:
        console.print(f"Warning: {sentence}", soft_wrap=True, markup=False)
