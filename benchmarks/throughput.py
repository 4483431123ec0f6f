"""How near the time loop is to the machine's limit: `python -m benchmarks.throughput`.

One thread, its processor time, medians, the paper's scene. Close other programs: they take cache and clock. The
machine's two ceilings: multiply-adds in registers, bytes from every level of cache. The phases of a step, each timed
alone on a bearing's own arrays, and the work they need at least. Memory, and the time from the command to the first
step.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numba import njit

from benchmarks import command_seconds, median_seconds, paper_plan, timed
from benchmarks.table_costs import skip_table
from fem.elastic.reciprocal_mass import LUMPED, SECOND, THIRD
from fem.kernels import columns
from fem.kernels.elements import discs, loop, rings, samples
from fem.kernels.elements.contacts import press_patches
from fem.kernels.elements.friction import friction_contacts, slips_after, slips_before
from fem.kernels.lanes import fma, load, splat, store
from fem.solver.elements.arrays import Arrays
from fem.solver.elements.plan import ElementPlan
from tests.measurements import markdown_table, program

CACHES = {"L1": 32 << 10, "L2": 1 << 20, "L3": 32 << 20}  # bytes, where the system does not tell


@dataclass(frozen=True, kw_only=True)
class Machine:
    """Ceilings of one thread."""

    fma_rate: float  # 1/s, multiply-adds of float64
    read_rate: dict[str, float]  # B/s by level
    update_rate: dict[str, float]  # B/s of a[i] += s·b[i]: two read, one written
    cache_bytes: dict[str, int]

    def floor(self, operations: float, moved: float, working_set: float) -> tuple[float, str]:
        """Seconds that so many multiply-adds and bytes of a set of so many take, and the ceiling that binds."""
        level = next((name for name, room in self.cache_bytes.items() if working_set <= room), "memory")
        return max((operations / self.fma_rate, "arithmetic"), (moved / self.update_rate[level], level))


@njit
def multiply_adds(count, scale, out):
    """Run 16 independent chains of 8 lanes: 128 multiply-adds a turn."""
    one = splat(1.0)
    a, b, c, d = splat(1.0), splat(1.1), splat(1.2), splat(1.3)
    e, f, g, h = splat(1.4), splat(1.5), splat(1.6), splat(1.7)
    i, j, k, m = splat(1.8), splat(1.9), splat(2.0), splat(2.1)
    n, o, p, q = splat(2.2), splat(2.3), splat(2.4), splat(2.5)
    for _ in range(count):
        a, b, c, d = fma(scale, a, one), fma(scale, b, one), fma(scale, c, one), fma(scale, d, one)
        e, f, g, h = fma(scale, e, one), fma(scale, f, one), fma(scale, g, one), fma(scale, h, one)
        i, j, k, m = fma(scale, i, one), fma(scale, j, one), fma(scale, k, one), fma(scale, m, one)
        n, o, p, q = fma(scale, n, one), fma(scale, o, one), fma(scale, p, one), fma(scale, q, one)
    left = ((a + b) + (c + d)) + ((e + f) + (g + h))
    store(out, 0, left + (((i + j) + (k + m)) + ((n + o) + (p + q))))


@njit
def read(count, flat, out):
    """Sum an array, `count` times."""
    a, b, c, d = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
    for _ in range(count):
        for i in range(0, flat.size, 32):
            a, b = a + load(flat, i), b + load(flat, i + 8)
            c, d = c + load(flat, i + 16), d + load(flat, i + 24)
    store(out, 0, (a + b) + (c + d))


@njit
def update(count, target, source, scale):
    """Add scale·source to the target, `count` times."""
    for _ in range(count):
        for i in range(0, target.size, 16):
            store(target, i, fma(scale, load(source, i), load(target, i)))
            store(target, i + 8, fma(scale, load(source, i + 8), load(target, i + 8)))


def cache_sizes() -> dict[str, int]:
    """Data caches of the first processor, bytes."""
    sizes = dict(CACHES)
    for folder in Path("/sys/devices/system/cpu/cpu0/cache").glob("index*"):
        try:
            kind, level = (folder / "type").read_text().strip(), (folder / "level").read_text().strip()
            size = (folder / "size").read_text().strip()
        except OSError:
            continue
        if kind != "Instruction" and f"L{level}" in sizes and size.endswith("K"):
            sizes[f"L{level}"] = int(size[:-1]) << 10
    return sizes


def aligned(size: int) -> np.ndarray:
    """Zeros that start at a cache line."""
    raw = np.zeros(size + 8)
    skip = (-raw.ctypes.data // 8) % 8
    return raw[skip : skip + size]


def measured_machine() -> Machine:
    """Measure the ceilings, streaming through half of each cache, and through four times the last one for memory."""
    out, turns = aligned(8), 2_000_000
    fma_rate = 128.0 * turns / median_seconds(multiply_adds, turns, 0.999, out)
    caches = cache_sizes()
    spans = {name: size // 2 for name, size in caches.items()} | {"memory": min(4 * caches["L3"], 256 << 20)}
    read_rate, update_rate = {}, {}
    for name, span in spans.items():
        size = span // 8 // 64 * 64
        count = max(1, int(4e8) // span)
        flat = aligned(size)
        read_rate[name] = 8.0 * size * count / median_seconds(read, count, flat, out)
        target, source = aligned(size // 2), aligned(size // 2)
        update_rate[name] = 12.0 * size * count / median_seconds(update, count, target, source, 1e-3)
    return Machine(fma_rate=fma_rate, read_rate=read_rate, update_rate=update_rate, cache_bytes=caches)


TARGET_SECONDS = 0.02  # of one measurement
# arithmetic instructions (multiply-add, or add) per node at least
ROLLER_UPDATE = 16  # angular acceleration 2, torque 2, position 2, turn of u and w 8, lead 2
RING_STENCIL = 22  # 18 coefficients of a reflection-symmetric stencil, 4 sums of neighbours
TURN, STILL = 10, 2  # position and, in a turning frame, the turn of u and w
STATE_BYTES = 64  # u and w of a node read and written once


@cache
def _repeated(function: Callable) -> Callable:
    """A compiled loop around a kernel, so that no call from Python is timed."""

    @njit
    def loop(count, *arguments):
        for _ in range(count):
            function(*arguments)

    return loop


@njit
def _normal(groups, rollers, surface, contacts, drive):
    press_patches(groups, rollers, surface, contacts, drive)


@njit
def _slip_and_friction(groups, rollers, surface, contacts, drive, still):
    """Normal forces' impulses on nodes, too: friction gives both at once."""
    lumped = drive.slowing == 0.0
    slips_before(groups, rollers, surface, contacts, still, lumped)
    friction_contacts(groups, rollers, surface, contacts, drive)
    slips_after(groups, rollers, surface, contacts, drive.dt, lumped)


@njit
def _rings_kick(inner, outer):
    rings.kick(*inner)
    rings.kick(*outer)


@njit
def _rings_slow_waves(inner, outer, calming, dt):
    for ring in (inner, outer):
        if calming > 0.0:
            rings.calm(ring.calming, ring.w, ring.calmed, ring.grown, 0.0, ring.first_row, ring.last_row)
        rings.find_velocities(ring.slowed, ring.calmed, ring.w, ring.v, dt, ring.raceway)
        rings.slow_waves(ring.slowed, ring.u, ring.calmed, ring.first_row, ring.last_row, ring.raceway)


@njit
def _rings_kick_and_weight(inner, outer, cosines, sines, weight):
    for k, ring in enumerate((inner, outer)):
        rings.set_rigid(weight[k], 0, cosines[k], sines[k], 0.0, 1e-12)
        table, u, w, _, first, last = ring
        rings.kick(table, u, w, weight[k], first, last)


@njit
def _rings_drift(inner, outer, radii, grown):
    _, u, w, _, first, last = inner
    rings.drift((u, w, w), radii, grown, 1e-12, (1.0, 1e-12), (first, last, -1))
    _, u, w, _, first, last = outer
    rings.drift_still(u, w, 1e-12, first, last)


def _rows(ring) -> tuple:
    """Parts of a ring that the kernels take: passing all of it would take longer than a small ring's kick."""
    return ring.table, ring.u, ring.w, None, ring.first_row, ring.last_row


@njit
def _hub(inner, scratch):
    rings.row_force(inner.table, inner.u, inner.held, scratch.bore)
    x, y = rings.resultant(scratch.bore, inner.cosines, inner.sines)
    held = 2 * inner.held * inner.cosines.size
    rings.set_rigid(inner.u, held, inner.cosines, inner.sines, 1e-12 * x, 1e-12 * y)


@njit
def _sampled(bodies, groups, contacts, drive, scratch, row):
    samples.remember(bodies, drive, scratch)
    samples.write_sample(bodies, groups, contacts, drive, scratch, row, 0.0, 0.0)


def _seconds(function: Callable, *arguments) -> float:
    """Time of one call of a kernel, s."""
    loop = _repeated(function)
    count = 4
    while True:
        taken = median_seconds(loop, count, *arguments, repeats=1)
        if taken > 0.2 * TARGET_SECONDS:
            break
        count *= 4
    return median_seconds(loop, count, *arguments) / count


def time_phases(plan: ElementPlan) -> dict[str, float]:
    """Time that a step spends in each phase, s, contacts and friction at the static loads."""
    a: Arrays = plan.arrays()
    r = a.bodies.rollers
    row = np.zeros(columns.N_SCALARS + len(columns.BLOCKS) * r.n)
    contacts = (a.groups, r, a.bodies.surface, a.contacts, a.drive)
    out = {
        "contacts": _seconds(_normal, *contacts),
        "impulses and friction": _seconds(_slip_and_friction, *contacts, a.scratch.still),
    }
    a = plan.arrays()
    r, d, i, o, x = a.bodies.rollers, a.bodies.disc, a.bodies.inner, a.bodies.outer, a.scratch
    still, turn = np.zeros(r.columns), np.full(r.columns, 1e-12)
    out["rollers' forces"] = _seconds(discs.kick, d, d.w, r.columns, x.torque)
    out["rings' forces"] = _seconds(_rings_kick, _rows(i), _rows(o))
    slowing, calming, dt = a.drive.slowing, a.drive.calming, a.drive.dt
    waves = (d, np.ones(r.columns), r.columns, slowing, calming, dt, x.torque)
    out["rollers' waves"] = _seconds(discs.slow_waves, *waves) if slowing else 0.0
    out["rings' waves"] = _seconds(_rings_slow_waves, i, o, calming, dt) if slowing else 0.0
    a = plan.arrays()
    r, d, i, o, x = a.bodies.rollers, a.bodies.disc, a.bodies.inner, a.bodies.outer, a.scratch
    turns = discs.Turns(still, np.ones(r.columns), turn, still, still)
    out["rollers' motion"] = _seconds(discs.drift, d, turns, r.columns, 1e-12, x.torque)
    inner, outer = _rows(i), _rows(o)
    out["rings' motion"] = _seconds(_rings_drift, inner, outer, i.radii, i.grown)
    lines = (i.cosines, o.cosines), (i.sines, o.sines), (x.bore, x.line)
    out["gravity"] = _seconds(_rings_kick_and_weight, inner, outer, *lines) - out["rings' forces"]  # added on the way
    out["hub"] = _seconds(_hub, i, x)
    a = plan.arrays()
    sample = _seconds(_sampled, a.bodies, a.groups, a.contacts, a.drive, a.scratch, row)
    out["sampling"] = sample / plan.stride
    return out


def step_seconds(plan: ElementPlan, repeats: int = 3) -> float:
    """Time of one whole step of the running bearing, s, samples included."""
    a = plan.arrays()
    width = columns.N_SCALARS + len(columns.BLOCKS) * a.bodies.rollers.n

    def advance(samples, at=[0]):  # noqa: B006 the state runs on from call to call
        rows = np.zeros((samples, width))
        loop.advance(a.bodies, a.groups, a.contacts, a.drive, a.scratch, at[0], plan.stride, rows)
        at[0] += samples * plan.stride

    advance(1)
    taken = median_seconds(advance, 2, repeats=1) / 2
    samples = max(2, int(10 * TARGET_SECONDS / taken))
    return median_seconds(advance, samples, repeats=repeats) / samples / plan.stride


def least_work(plan: ElementPlan) -> tuple[dict[str, float], float, float]:
    """Operations of one step by phase, bytes moved, and bytes of state and matrices, at least.

    Contacts, a few hundred nodes, are not counted.
    """
    a, n = plan.arrays(), plan.model.bearing.n_rollers
    disc, stiffness = a.bodies.disc.mass.size * n, a.bodies.disc.blocks.size * n
    rings = [(ring.last_row - ring.first_row) * ring.n_sectors for ring in (a.bodies.inner, a.bodies.outer)]
    slowed = {LUMPED: 0.0, SECOND: 1.0, THIRD: 2.0}[plan.mass]  # the stiffness is applied as often again
    tables = a.bodies.disc.blocks.nbytes + a.bodies.disc.neighbours.nbytes
    operations = {
        "rollers' forces": stiffness,
        "rings' forces": RING_STENCIL * sum(rings),
        "rollers' waves": slowed * stiffness,
        "rings' waves": slowed * RING_STENCIL * sum(rings),
        "rollers' motion": ROLLER_UPDATE * disc,
        "rings' motion": (TURN if plan.operation.speed else STILL) * rings[0] + STILL * rings[1],
    }
    state = STATE_BYTES * (disc + sum(rings))
    return operations, state + tables, 0.5 * state + tables


PEAK = """
import sys
from pathlib import Path
from benchmarks import paper_plan
from fem.solver.simulate import run
plan = paper_plan(f"numerics.mesh_size_mm={sys.argv[1]}", "numerics.duration_ms=0.02")
plan.prepare()
run(plan, lambda samples: None)
peak = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
print(plan.model.degrees_of_freedom, 1024 * int(peak.split()[1]))  # getrusage would know the parent's, too
"""


def peak_bytes(size_mm: float) -> tuple[int, int]:
    """Degrees of freedom of the paper's scene, and the most memory a process takes to set it up and run it, bytes."""
    for _ in range(2):  # the second time nothing is compiled
        done = subprocess.run([sys.executable, "-c", PEAK, str(size_mm)], capture_output=True, text=True, check=True)
    freedom, peak = done.stdout.split()
    return int(freedom), int(peak)


SIZES_MM = (2.0, 1.0, 0.5, 0.25)
FULL_S = 0.06
KERNELS = ("rollers' forces", "rings' forces")


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """Measurements on one mesh."""

    size_mm: float
    plan: ElementPlan
    setup: float  # s
    phases: dict[str, float]  # s per step
    step: float  # s
    work: tuple[dict[str, float], float, float]  # of `least_work`
    state_bytes: int

    @property
    def freedom(self) -> int:
        return self.plan.model.degrees_of_freedom

    @property
    def full(self) -> float:
        """Time for 0.06 s of the bearing, s."""
        return FULL_S / self.plan.time_step * self.step


def measure(size_mm: float) -> Mesh:
    """Time one mesh of the paper's scene."""
    setup, plan = timed(paper_plan, f"numerics.mesh_size_mm={size_mm!r}", clock=time.perf_counter)
    plan.prepare()
    return Mesh(
        size_mm=size_mm, plan=plan, setup=setup, phases=time_phases(plan), step=step_seconds(plan),
        work=least_work(plan), state_bytes=plan.arrays().nbytes,
    )  # fmt: skip


def ceilings(found: Machine) -> str:
    rows = [("multiply-adds in registers", "", f"{1e-9 * found.fma_rate:.1f} G/s", "")]
    for level in found.read_rate:
        size = found.cache_bytes.get(level)
        room = f"{size >> 10} KiB" if size else ""
        rows.append((level, room, *(f"{1e-9 * of[level]:.0f}" for of in (found.read_rate, found.update_rate))))
    return markdown_table(("", "size", "read, GB/s", "read and write, GB/s"), rows)


def phase_table(meshes: list[Mesh], found: Machine) -> str:
    """Time of a step, µs (ns per degree of freedom)."""
    floors = [found.floor(sum(m.work[0].values()), *m.work[1:]) for m in meshes]
    times = {name: [m.phases[name] for m in meshes] for name in meshes[0].phases}
    times |= {"sum of the phases": [sum(m.phases.values()) for m in meshes]}
    times |= {"whole step, measured": [m.step for m in meshes], "floor": [floor for floor, _ in floors]}
    rows = [
        [name, *(f"{1e6 * v:.2f} ({1e9 * v / m.freedom:.3f})" for v, m in zip(values, meshes, strict=True))]
        for name, values in times.items()
    ]
    rows.append(["ceiling that binds", *(name for _, name in floors)])
    rows.append(["whole step over floor", *(f"{m.step / f[0]:.1f}" for m, f in zip(meshes, floors, strict=True))])
    for name in KERNELS:
        shares = (m.work[0][name] / m.phases[name] for m in meshes)
        cells = (f"{100 * share / found.fma_rate:.0f} %" for share in shares)
        rows.append([f"{name}: share of the arithmetic ceiling", *cells])
    return markdown_table(("phase", *(f"{mesh.size_mm:g} mm" for mesh in meshes)), rows)


def size_table(meshes: list[Mesh]) -> str:
    headings = ("mesh, mm", "degrees of freedom", "step, ns", "ns/DOF/step", "0.06 s take, s", "set-up, s", "B/DOF")
    rows = (
        (f"{m.size_mm:g}", f"{m.freedom}", f"{1e9 * m.plan.time_step:.1f}", f"{1e9 * m.step / m.freedom:.2f}",
         f"{m.full:.2f}", f"{m.setup:.1f}", f"{m.state_bytes / m.freedom:.0f}")
        for m in meshes
    )  # fmt: skip
    return markdown_table(headings, rows)


def main(*, sizes: tuple[float, ...] = SIZES_MM, pairs: int = 7, skips: bool = True):
    """Measure ceilings, phases, growth and what is skipped.

    Parameters
    ----------
    sizes: surface node distances, mm
    pairs: of runs per line of the skip table
    skips: measure the skip table
    """
    print(f"one thread of {os.cpu_count()}")
    found = measured_machine()
    yield "performance", "Ceilings of the machine", ceilings(found)
    meshes = [measure(size) for size in sizes]
    yield "performance", "Time of a step", phase_table(meshes, found)
    rows = []
    if len(meshes) > 1:
        fine = [m for m in meshes if m.size_mm <= 1.0]
        every = "time grows as DOF to the power, all meshes (explicit limit in 2D: 1.5)"
        for name, some in ((every, meshes), ("from 1 mm down", fine)):
            if some is meshes or 1 < len(fine) < len(meshes):
                power = np.polyfit(np.log([m.freedom for m in some]), np.log([m.full for m in some]), 1)[0]
                rows.append((name, f"{power:.2f}"))
        few, many = (peak_bytes(size) for size in (max(sizes), min(sizes)))
        each = (many[1] - few[1]) / (many[0] - few[0])
        rows.append((f"peak memory of a process at {max(sizes):g} mm, MB", f"{few[1] / 1e6:.0f}"))
        rows.append(("memory per degree of freedom more, B", f"{each:.0f}"))
    with tempfile.TemporaryDirectory() as folder:
        wall, processor = command_seconds("fem", "--quiet", "--duration", "0.01", "--output", f"{folder}/run.nc")
    rows.append(("a whole run of one sample at 1 mm, caches warm, s", f"{wall:.2f}"))
    rows.append(("the same, processor time, s", f"{processor:.2f}"))
    growth = markdown_table(("quantity", "found"), rows)
    yield "performance", "Growth with the mesh", size_table(meshes), growth
    if skips:
        yield "performance", "Cost of physics", skip_table(1.0, pairs)


if __name__ == "__main__":
    program(__doc__, "benchmarks.throughput", main)
