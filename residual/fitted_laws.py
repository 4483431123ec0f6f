"""Contact laws beyond Q(δ) of one contact, and laws fitted to a run's own forces.

A contact is coupled to its neighbours, or has a damper beside its spring. K and n of Q = K δ^n, and where wanted the
coupling c and the damping d, are fitted by least squares to the closed inner contacts of the record's first part; the
rest is held back to judge the law on.

The samples of one roller's passage through the load zone are far from independent, so the intervals take the
passage, not the sample, as the unit of observation. They say how well the data fix the two numbers, not that a
power law is true: what the law can't follow in any passage shows in the scatter, not in the interval.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from lagrange.contact.damping import ContactDamping, damper_force
from lagrange.contact.laws import PowerLaw
from lagrange.contact.raceway_laws import LogarithmicLaw, contact_laws
from lagrange.surface.edges import softened
from residual.errors import InputError
from residual.load_zone import load_zones
from residual.record import FEWEST_SAMPLES, Record
from residual.spectrum import rms
from residual.tilt import SlicedLaw, has_tilts, sliced

FIXED_POINT_STEPS = 60  # gain 0.5: round-off
FIT_SHARE = 0.5  # of the record
CONFIDENCE = 0.95
LEAST_FORCE = 1e-100  # N: squares of less are nothing
LEAST_SPREAD = 0.02  # of ln δ: less depth range than this fixes no exponent
LARGEST_GAIN = 0.5  # of the coupling's fixed point: beyond it the coupling is no correction any more
Extra = Literal["coupling", "damping"]
ADJECTIVE = {"coupling": "coupled", "damping": "damped"}
# name: what is fitted beside K and n
FITTED: dict[str, tuple[Extra, ...]] = {
    "fitted": (),
    "fitted_coupled": ("coupling",),
    "fitted_damped": ("damping",),
    "fitted_coupled_damped": ("coupling", "damping"),
}
ALIASES = ("tripp",)


@dataclass(frozen=True, kw_only=True)
class CoupledLaw(PowerLaw):
    """Q_j = K max(δ_j − c (Q_{j−1} + Q_{j+1}), 0)^n: contacts of one ring are coupled to their neighbours by it.

    `force` and `slope` take the rollers along the last axis, in their order around the bearing.
    """

    coupling: float  # c, m/N; negative: a neighbour's load adds to this contact's

    def force(self, approach):
        """Contact forces, N, >= 0, (..., n_rollers), by iteration to round-off."""
        force = super().force(approach)
        for _ in range(FIXED_POINT_STEPS):
            previous, force = force, super().force(approach - self.coupling * neighbours(force))
            if np.max(np.abs(force - previous), initial=0.0) <= 1e-12 * np.max(force, initial=0.0):
                break
        return force

    def slope(self, approach):
        """dQ/dδ of a contact, N/m, its neighbours' loads held."""
        return super().slope(approach - self.coupling * neighbours(self.force(approach)))


@dataclass(frozen=True, kw_only=True)
class DampedLaw:
    """Q = max(Q_0(δ) + d δ̇, 0) where δ > 0, else 0: a damper beside a contact's spring."""

    spring: PowerLaw | LogarithmicLaw  # Q_0
    damping: ContactDamping  # d

    @property
    def name(self) -> str:
        return self.spring.name

    @property
    def source(self) -> str:
        return f"{self.spring.source}, damping {self.damping.words}"

    def slope(self, approach):
        """dQ/dδ of a contact, N/m."""
        return self.spring.slope(approach)


Law = PowerLaw | LogarithmicLaw | DampedLaw | SlicedLaw


def law_force(law: Law, approach, closing_speed, compliance=0.0) -> np.ndarray:
    """Contact forces, N, (..., n_rollers), at approaches, m, that grow at a speed, m/s; `compliance` of edges, m/N."""
    spring, damper = spring_and_damper(law, approach, closing_speed, compliance)
    return spring + damper


def spring_and_damper(law: Law, approach, closing_speed, compliance=0.0) -> tuple[np.ndarray, np.ndarray | float]:
    """The same, springs' and dampers' apart."""
    if isinstance(law, SlicedLaw):
        return law.force(approach), law.damper(approach)
    spring = softened(law.spring if isinstance(law, DampedLaw) else law, compliance)
    force = spring.force(approach)
    if not isinstance(law, DampedLaw):
        return force, 0.0
    coefficient = law.damping.coefficient(force, spring.slope(approach))
    return force, damper_force(force, closing_speed, coefficient)


def neighbours(force) -> np.ndarray:
    """Sum Q_{j−1} + Q_{j+1} of the neighbours of every contact, rollers along the last axis."""
    return np.roll(force, 1, axis=-1) + np.roll(force, -1, axis=-1)


@dataclass(frozen=True, kw_only=True)
class Interval:
    """A fitted number and its 95 % confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Identification:
    """A fitted law and how well it is known."""

    law: PowerLaw | DampedLaw
    stiffness: Interval  # K, N/m^n
    exponent: Interval  # n
    coupling: Interval | None = None  # c, m/N
    damping: Interval | None = None  # d, N s/m
    samples: int  # of the record's first part; the rest is held back
    contacts: int  # closed contacts fitted
    passages: int  # independent passages through the load zone among them
    depth: tuple[float, float]  # m, smallest and largest approach fitted
    scatter: float  # N, rms of run − law per contact fitted


def fit_law(
    approach, force, bridge: int, extras: tuple[Extra, ...] = (), closing_speed=None, samples: int | None = None
) -> Identification:
    """Fit Q = K δ^n to closed contacts by least squares.

    Parameters
    ----------
    approach, force : ndarray, (n_times, n_rollers), m and N
    bridge : samples; a contact open no longer than this is still in the same passage
    extras : "coupling" of neighbouring contacts, Q_j = K (δ_j − c (Q_{j−1} + Q_{j+1}))^n; "damping", Q = K δ^n + d δ̇
    closing_speed : δ̇, ndarray, (n_times, n_rollers), m/s; for damping
    samples : fit to the first so many; None: the first half

    Errors
    ------
    InputError: too few samples, passages, or too little range of depth to fix the numbers. The intervals are
    linear (delta method) with a covariance clustered by passage and Student's t; passages loaded at the same time
    still share the ring's vibration, which makes the intervals somewhat too narrow.

    Source: Liang and Zeger, Biometrika 73 (1986) 13-22: covariance of an estimate from clustered observations.
    """
    samples = int(FIT_SHARE * approach.shape[0]) if samples is None else samples
    if samples < FEWEST_SAMPLES:
        raise InputError(f"{samples} samples to fit a law to, at least {FEWEST_SAMPLES} are needed; use a longer run")
    closed = force[:samples] > 0.0
    passage = passage_numbers(closed, bridge)[closed]
    depth, load = approach[:samples][closed], force[:samples][closed]
    n_parameters, n_passages = 2 + len(extras), len(np.unique(passage))
    if n_passages <= n_parameters + 1:
        raise InputError(
            f"{n_passages} passages of rollers through the load zone in the first {samples} samples, at least "
            f"{n_parameters + 2} are needed to fit a law; use a longer run"
        )
    positive = depth > 0.0
    if positive.sum() < FEWEST_SAMPLES or np.std(np.log(depth[positive])) < LEAST_SPREAD:
        raise InputError("the contacts' approaches hardly vary: they fix no exponent; use a run with a load zone")
    causes = {}  # what the extra numbers multiply
    if "coupling" in extras:
        causes["coupling"] = neighbours(force[:samples])[closed]
    if "damping" in extras:
        causes["damping"] = closing_speed[:samples][closed]
    units = {"depth": rms(depth[positive]), "load": rms(load)} | {name: rms(v) for name, v in causes.items()}
    if not units["load"] > LEAST_FORCE:
        raise InputError(f"the contact forces, {units['load']:.3g} N rms, are too small to fit a law to")
    for name in extras:
        if not units[name] > 0.0:
            raise InputError(f"the run has nothing that fixes a {name}: no neighbour is loaded, or nothing moves")
    parameters, jacobian, miss = _least_squares(
        extras, depth / units["depth"], load / units["load"], {name: v / units[name] for name, v in causes.items()}
    )
    if np.linalg.matrix_rank(jacobian) < n_parameters:
        raise InputError("the run's forces do not fix all numbers of the law; use a longer run, or a named law")
    covariance = _clustered_covariance(jacobian, miss, passage)
    deepest = float(depth.max())
    found = _in_si(extras, parameters, covariance, units)
    return Identification(
        law=_law(found, deepest), **found, samples=samples, contacts=load.size, passages=n_passages,
        depth=(float(depth.min()), deepest), scatter=units["load"] * rms(miss),
    )  # fmt: skip


def passage_numbers(closed: np.ndarray, bridge: int) -> np.ndarray:
    """Number each passage of a roller through the load zone, (n_times, n_rollers); −1 outside."""
    number = np.full(closed.shape, -1)
    count = 0
    for j in range(closed.shape[1]):
        for first, last in load_zones(closed[:, j], bridge):
            number[first : last + 1, j] = count
            count += 1
    return number


def _model(parameters, extras, depth, causes):
    """Dimensionless force and its derivatives by ln K, n and the extras: (n,), (n, n_parameters)."""
    extra = dict(zip(extras, parameters[2:], strict=True))
    left = depth - extra["coupling"] * causes["coupling"] if "coupling" in extra else depth
    inside = left > 0.0
    logarithm = np.log(np.where(inside, left, 1.0))
    spring = np.where(inside, np.exp(parameters[0] + parameters[1] * logarithm), 0.0)
    force, columns = spring, [spring, spring * logarithm]
    if "coupling" in extra:
        columns.append(-parameters[1] * spring / np.where(inside, left, 1.0) * causes["coupling"])
    if "damping" in extra:
        force = spring + extra["damping"] * causes["damping"]
        columns.append(causes["damping"])
    pushes = inside & (force > 0.0)
    return np.where(pushes, force, 0.0), np.where(pushes[:, None], np.column_stack(columns), 0.0)


def _least_squares(extras, depth, load, causes):
    """Find the parameters (ln K, n, extras) in units of the data; Jacobian and run − law at the optimum."""
    from scipy.optimize import least_squares

    found = least_squares(
        lambda p: _model(p, extras, depth, causes)[0] - load, np.array([0.0, 1.1] + [0.0] * len(extras)),
        jac=lambda p: _model(p, extras, depth, causes)[1], method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12,
    )  # fmt: skip
    if not found.success or not 0.2 < found.x[1] < 5.0:
        raise InputError(f"the run's forces follow no power law of the approach (exponent {found.x[1]:.3g})")
    return found.x, found.jac, -found.fun


def _clustered_covariance(jacobian, miss, passage) -> np.ndarray:
    """Covariance of the parameters, times Student's t squared, from the passages' scores."""
    from scipy.special import stdtrit  # scipy.stats costs half a second to import

    order = np.unique(passage, return_inverse=True)[1]
    n_passages, n_parameters = order.max() + 1, jacobian.shape[1]
    score = np.zeros((n_passages, n_parameters))
    np.add.at(score, order, jacobian * miss[:, None])
    bread = np.linalg.inv(jacobian.T @ jacobian)
    reach = stdtrit(n_passages - n_parameters, 0.5 + 0.5 * CONFIDENCE)
    return reach**2 * n_passages / (n_passages - 1) * bread @ (score.T @ score) @ bread


def _in_si(extras, parameters, covariance, units) -> dict[str, Interval]:
    """Numbers in SI: ln K = ln K' + ln Q0 − n ln δ0, so K and n are correlated and K's interval is wide."""

    def interval(value: float, reach: float) -> Interval:
        return Interval(value=float(value), low=float(value - reach), high=float(value + reach))

    exponent = float(parameters[1])
    log_stiffness = float(parameters[0] + np.log(units["load"]) - exponent * np.log(units["depth"]))
    weights = np.zeros(parameters.size)
    weights[:2] = 1.0, -np.log(units["depth"])
    reach = float(np.sqrt(weights @ covariance @ weights))
    value, low, high = (float(np.exp(log_stiffness + each)) for each in (0.0, -reach, reach))
    half = np.sqrt(np.diag(covariance))
    found = {"stiffness": Interval(value=value, low=low, high=high), "exponent": interval(exponent, half[1])}
    for i, extra in enumerate(extras, 2):
        scale = units["depth" if extra == "coupling" else "load"] / units[extra]
        found[extra] = interval(scale * parameters[i], scale * half[i])
    return found


def _law(found: dict[str, Interval], deepest: float) -> PowerLaw | DampedLaw:
    """Make the law with the numbers found, if its iteration converges."""
    about: dict[str, Any] = {
        "name": "_".join(["fitted", *(word for extra, word in ADJECTIVE.items() if extra in found)]),
        "stiffness": found["stiffness"].value, "exponent": found["exponent"].value,
        "range": "the depths it was fitted to",
    }  # fmt: skip
    law = PowerLaw(**about, source="fitted to the run's own contact forces, Q = K δ^n")
    if "coupling" in found:
        coupling = found["coupling"].value
        gain = 2.0 * abs(coupling) * float(law.slope(max(deepest, 0.0)))
        if gain > LARGEST_GAIN:
            raise InputError(
                f"the fitted coupling is no small correction (gain {gain:.2g}, at most {LARGEST_GAIN:g}); "
                "use the law fitted"
            )
        source = "fitted to the run's own contact forces, Q_j = K (δ_j − c (Q_j−1 + Q_j+1))^n"
        law = CoupledLaw(**about, source=source, coupling=coupling)
    if "damping" in found:
        return DampedLaw(spring=law, damping=ContactDamping(constant=found["damping"].value))
    return law


def inner_law(name: str, record: Record) -> Law:
    """Named law of the inner contact, with the scene's damping of contacts."""
    law = contact_laws(name, record.bearing).inner
    if has_tilts(record):
        return sliced(record, law)
    damping = record.scene.damping.contacts
    return DampedLaw(spring=law, damping=damping) if damping.acts else law


def identify(record: Record, approach, closing_speed, bridge: int, name: str) -> Identification:
    """Fit the law `name`, a key of FITTED, to a run's own forces over the approach, m, and its rate, m/s.

    Errors
    ------
    InputError: the source holds no forces, or they fix no law.
    """
    if has_tilts(record):
        raise InputError(f"{record.source}: no law is fitted to rollers that tilt; choose a named law")
    if record.inner_force is None:
        raise InputError(
            f"{record.source}: the law {name} is fitted to the run's own contact forces, which this source does "
            "not tell; choose a named law"
        )
    try:
        return fit_law(approach, record.inner_force, bridge, FITTED[name], closing_speed)
    except InputError as error:
        raise InputError(f"{record.source}: {error}") from None
