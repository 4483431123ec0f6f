"""What run-fem --dry-run tells of a plan of finite elements."""

from typing import TYPE_CHECKING

from rich.table import Table

from fem.elastic.outer_support import LooseRing, SupportedRing
from fem.elastic.reciprocal_mass import LUMPED, SECOND, THIRD
from fem.run_summary import largest_loads
from fem.solver.pace import in_words, pace
from fem.solver.run_arrays import Arrays
from fem.statics.equilibrium import static_error
from fem.statics.exact_statics import LEAST_LOAD
from lagrange.scene.scene import Scene
from meshes import Mesh, quality

if TYPE_CHECKING:
    from fem.solver.finite_elements import ElementPlan

# one thread of a 2024 server core; only a guide, `wall_seconds` of a run is the truth
SECONDS_PER_DOF = {LUMPED: 0.9e-9, SECOND: 1.4e-9, THIRD: 1.9e-9}
SECONDS_PER_ROLLER = 0.35e-6
BYTES_PER_NODE = 20  # of a stored frame: displacement and stress in single precision


def mesh_table(plan: "ElementPlan") -> Table:
    """Size and shape of each body's mesh."""
    table = Table()
    for heading in ("mesh", "nodes", "cells", "edges, mm", "angles, deg"):
        table.add_column(heading, justify="left" if heading == "mesh" else "right")
    for name in ("roller", "inner_ring", "outer_ring"):
        body = getattr(plan.model, name)
        q = quality(Mesh(points=body.points, cells=body.cells))
        table.add_row(
            name.replace("_", " ") + (", rigid: only drawn" if body.material.rigid else ""),
            str(q.nodes),
            str(q.cells),
            f"{1e3 * q.smallest_edge:.3f} - {1e3 * q.largest_edge:.3f}",
            f"{q.smallest_angle:.0f} - {q.largest_angle:.0f}",
        )
    return table


def plan_rows(plan: "ElementPlan") -> dict[str, str]:
    """Steps, memory, the time to expect and the mesh's static error."""
    model, start, ring = plan.model, plan.start.equilibrium, plan.model.outer_ring
    rows = {
        "degrees of freedom": f"{plan.degrees_of_freedom}",
        "time step": f"{1e9 * plan.time_step:.2f} ns ({plan.time_step / plan.critical_time_step:.2f} of the critical "
        f"{1e9 * plan.critical_time_step:.2f} ns{', with the fastest waves slowed' if plan.mass.share else ''})",
        "steps": f"{plan.steps} for {1e3 * (plan.n_samples - 1) * plan.interval:g} ms",
        "samples": f"{plan.n_samples}, one each {plan.stride} steps",
        **damping_rows(plan.scene),
        **plan.operation.mounting.rows,
        **({"points that hold the outer ring": ring.words} if isinstance(ring, SupportedRing) else {}),
        **_fields(plan),
        "memory of the arrays": f"{memory_megabytes(plan.arrays()):.1f} MB",
        "expected time": in_words("fem", plan.expected_seconds),
        "largest static forces": largest_loads(
            model.bearing, start.inner_force.max(), start.outer_force.max(), tilts=plan.tilting is not None
        ),
    }
    if plan.operation.radial_load >= LEAST_LOAD and not isinstance(ring, LooseRing):
        error = static_error(model, plan.operation)
        rows["static error of the mesh"] = (
            f"hub displacement {100 * error.hub:.2g} %, loads {100 * error.largest_force:.2g} % (against exact series)"
        )
    return rows


def damping_rows(scene: Scene) -> dict[str, str]:
    """How contacts and bodies are damped, where they are."""
    rows, table = {}, scene.damping
    if table.contacts.acts:
        rows["damping of a contact"] = table.contacts.words
    if table.bodies_1_s > 0.0:
        rows["damping of the bodies"] = f"{table.bodies_1_s:g} 1/s"
    return rows


def expected_seconds(plan: "ElementPlan") -> float:
    """Of the time loop."""
    model = plan.model
    each = SECONDS_PER_DOF[plan.mass] * model.degrees_of_freedom + SECONDS_PER_ROLLER * model.bearing.n_rollers
    return pace("fem") * each * plan.steps


def _fields(plan: "ElementPlan") -> dict[str, str]:
    """How much the stored fields will take, before compression."""
    if not plan.frame_stride:
        return {}
    frames = 1 + (plan.n_samples - 1) // plan.frame_stride
    size = 1e-6 * frames * plan.model.n_nodes * BYTES_PER_NODE
    return {"fields": f"{frames}, one each {1e3 * plan.frame_stride * plan.interval:g} ms, {size:.3g} MB"}


def memory_megabytes(arrays: Arrays) -> float:
    """Size of the time loop's arrays."""
    return 1e-6 * (
        sum(array.nbytes for array in arrays.named().values())
        + sum(getattr(field, "nbytes", 0) for field in arrays.scratch)
    )
