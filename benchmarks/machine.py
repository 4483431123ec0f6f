"""The machine's two ceilings for one thread: multiply-adds in registers, bytes from every level of cache."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba import njit

from benchmarks.measuring import median_seconds
from fem.kernels.lane_memory import load, store
from fem.kernels.lanes import fma, splat

CACHES = {"L1": 32 << 10, "L2": 1 << 20, "L3": 32 << 20}  # bytes, where the system does not tell


@dataclass(frozen=True, kw_only=True)
class Machine:
    """Ceilings of one thread."""

    fma_rate: float  # 1/s, multiply-adds of float64
    read_rate: dict[str, float]  # B/s by level
    update_rate: dict[str, float]  # B/s of a[i] += s·b[i]: two read, one written
    cache_bytes: dict[str, int]

    def level(self, size: float) -> str:
        """The nearest level that holds so many bytes."""
        for name, room in self.cache_bytes.items():
            if size <= room:
                return name
        return "memory"


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


def measure() -> Machine:
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
