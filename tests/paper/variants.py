"""What could make the paper's numbers, each as a run of its scene; what is read off a run, and off the paper."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.commands.run_fem import run_main
from lagrange.columns import ENERGIES
from residual import Record, evaluate, read_result
from residual.evaluation import Evaluation
from residual.load_zone import chosen_roller
from residual.spectrum import derivative

# ranges read off the paper's figures 6 to 11, not data. Source: Rubio, García Prada, Castejón, Laniado (IFToMM 2007)
INNER_X = -80e-6, 60e-6  # m, figure 6
INNER_Y = -220e-6, -80e-6  # m
ROLLER_RHO = 22.98e-3, 23.08e-3  # m, figure 7
ROLLER_VELOCITY = -0.4, 0.4  # m/s
ROLLER_ACCELERATION = -5e3, 5e3  # m/s²
ERROR_FORCE = -3000.0, 3000.0  # N, figures 8 and 9, around 0 and around the load
PEAK = 22.0  # Hz, figures 10 and 11
SOFT = 8.3e6  # N/m, of each contact: the hub sinks by the paper's 0.15 mm
SKIPPED = 1e-3  # s: left out of every range
COARSE = 20  # samples: 0.2 ms, three hundred in the paper's record
BAND = 300.0  # Hz, of figures 10 and 11


class Variant(NamedTuple):
    name: str
    title: str
    settings: tuple[str, ...] = ()


def _faceted(size_mm: float, *more: str) -> tuple[str, ...]:
    return "contact.model=faceted", f"numerics.mesh_size_mm={size_mm}", *more


def _stiffness(newton_per_metre: str) -> str:
    return f"contact.penalty_stiffness_N_per_m={newton_per_metre}"


_PENALTY, _SOFT = "contact.model=penalty", _stiffness(f"{SOFT}")
_REST = ("numerics.start=rest", "numerics.load_ramp_ms=0.4")
_SMALL_STEPS = "numerics.time_step_safety=0.4"  # rattling facets of 1 mm and more need them for their energy balance
VARIANTS = (
    Variant("ours", "this program's default"),
    Variant("rest", "the same, load ramped up in 0.4 ms", _REST),
    Variant("clearance", "0.28 mm of clearance", ("bearing.outer_raceway_diameter_mm=56.28",)),
    Variant("penalty", "stiff penalty, 1e9 N/m", (_PENALTY,)),
    Variant("soft", "soft penalty, 8.3e6 N/m", (_PENALTY, _SOFT)),
    Variant("soft-rest", "soft penalty, load ramped up in 0.4 ms", (_PENALTY, _SOFT, *_REST)),
    Variant("facets-0.5", "facets of 0.5 mm, 1e9 N/m", _faceted(0.5)),
    Variant("facets-1", "facets of 1 mm, 1e9 N/m", _faceted(1.0, _SMALL_STEPS)),
    Variant("facets-2", "facets of 2 mm, 1e9 N/m", _faceted(2.0, _SMALL_STEPS)),
    Variant("soft-facets-0.5", "facets of 0.5 mm, 8.3e6 N/m", _faceted(0.5, _SOFT)),
    Variant("soft-facets-1", "facets of 1 mm, 1.2e7 N/m", _faceted(1.0, _stiffness("1.2e7"))),
    Variant("less-soft-facets-1", "facets of 1 mm, 2e7 N/m", _faceted(1.0, _stiffness("2e7"))),
)
Range = tuple[float, float]


class Measured(NamedTuple):
    """Ranges of a run, smallest and largest; SI."""

    x: Range
    y: Range
    rho: Range  # of one roller
    velocity: Range
    acceleration: Range
    loaded: tuple[int, int]
    usual: int  # number loaded, median
    harris: tuple[Range, Range]  # left sides of (22), and of (23) with its sign turned, with Harris' law
    fitted: tuple[Range, Range]  # with the law fitted to the run's own forces
    frequency: float  # Hz, the strongest of the hub's y
    peaks: tuple[float, float]  # Hz, the strongest below BAND of the left sides
    cage: float  # Hz
    imbalance: float  # largest error of the energy balance over the largest energy that bodies and contacts store


def record_of(variant: Variant, folder: Path) -> Record:
    path = folder / f"{variant.name}.nc"
    if not path.exists():
        words = [word for setting in variant.settings for word in ("--set", setting)]
        if (code := run_main([*words, "--output", str(path), "--quiet"])) != 0:
            raise RuntimeError(f"{variant.title}: run-fem ended with {code}")
    return read_result(path)


def radial(found: Record, roller: int, order: int) -> np.ndarray:
    """A roller's radial position or one of its derivatives."""
    rho = np.hypot(found.roller_x[:, roller], found.roller_y[:, roller])
    return derivative(rho, found.interval, order) if order else rho


def left_sides(checked: Evaluation) -> tuple[np.ndarray, np.ndarray]:
    """Left sides of (22) and, with its sign turned, of (23), N, as the paper plots them."""
    return checked.x.budget.error, checked.record.operation.radial_load - checked.y.budget.error


def measure(found: Record, every: int = 1) -> Measured:
    """Ranges of a run of which only each so many samples are kept."""
    kept = found.samples(slice(None, None, every))
    first = int(np.searchsorted(kept.time, SKIPPED))
    by_harris, by_fit = (evaluate(kept, law=law, start=SKIPPED) for law in ("harris", "fitted"))
    roller = chosen_roller(by_harris.budget.loaded, 1)
    harris, fitted = left_sides(by_harris), left_sides(by_fit)
    loaded = np.count_nonzero(kept.inner_force[first:] > 0.0, axis=1)
    kinetic, elastic, contact, work, dissipated = (kept.energies[name] for name in ENERGIES)
    balance = kinetic + elastic + contact - work + dissipated
    return Measured(
        _range(kept.inner_x[first:]), _range(kept.inner_y[first:]),
        *(_range(radial(kept, roller, order)[first:]) for order in range(3)),
        (int(loaded.min()), int(loaded.max())), int(np.median(loaded)), tuple(map(_range, harris)),
        tuple(map(_range, fitted)), strongest(kept.inner_y[first:], kept.interval),
        tuple(strongest(side, kept.interval, BAND) for side in harris), abs(kept.cage_speed) / (2.0 * np.pi),
        float(np.abs(balance - balance[0]).max() / (elastic + contact).max()),
    )  # fmt: skip


def strongest(record: np.ndarray, interval: float, below: float = np.inf) -> float:
    """Frequency of a signal's largest line, Hz: Hann window, mean removed."""
    amplitude = np.abs(np.fft.rfft((record - record.mean()) * np.hanning(record.size)))
    frequency = np.fft.rfftfreq(record.size, interval)
    inside = (frequency > 0.0) & (frequency <= below)
    return float(frequency[inside][np.argmax(amplitude[inside])])


def _range(values: np.ndarray) -> Range:
    return float(values.min()), float(values.max())
