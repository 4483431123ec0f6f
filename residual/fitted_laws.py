"""Contact laws of a check: named ones, with dampers beside their springs, and laws fitted to a run's own forces.

K and n of Q = K δ^n, and where wanted a damping d, Q = K δ^n + d δ̇, are fitted by least squares to the closed inner
contacts of the record's first part; the rest is held back to judge the law on.

The samples of one roller's passage through the load zone are far from independent, so the intervals take the
passage, not the sample, as the unit of observation. They say how well the data fix the numbers, not that a
power law is true: what the law can't follow in any passage shows in the scatter, not in the interval.
"""

from dataclasses import dataclass

import numpy as np

from lagrange.contact.damping import ContactDamping, damper_force
from lagrange.contact.laws import LogarithmicLaw, PowerLaw, contact_laws
from lagrange.surface.edges import softened
from residual.errors import InputError
from residual.load_zone import load_zones
from residual.record import FEWEST_SAMPLES, Record
from residual.spectrum import rms
from residual.tilt import SlicedLaw, has_tilts, sliced

FIT_SHARE = 0.5  # of the record
CONFIDENCE = 0.95
LEAST_FORCE = 1e-100  # N: squares of less are nothing
LEAST_SPREAD = 0.02  # of ln δ: less depth range than this fixes no exponent
FITTED = ("fitted", "fitted_damped")
ALIASES = ("tripp",)


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


def spring_and_damper(law: Law, approach, closing_speed, compliance=0.0) -> tuple[np.ndarray, np.ndarray | float]:
    """Forces of springs and of dampers, N, (..., n_rollers); contact forces are their sums.

    Parameters
    ----------
    approach, closing_speed : m, and its growth, m/s
    compliance : of edges, m/N
    """
    if isinstance(law, SlicedLaw):
        return law.force(approach), law.damper(approach)
    spring = softened(law.spring if isinstance(law, DampedLaw) else law, compliance)
    force = spring.force(approach)
    if not isinstance(law, DampedLaw):
        return force, 0.0
    coefficient = law.damping.coefficient(force, spring.slope(approach))
    return force, damper_force(force, closing_speed, coefficient)


@dataclass(frozen=True)
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
    damping: Interval | None  # d, N s/m
    samples: int  # of the record's first part; the rest is held back
    contacts: int  # closed contacts fitted
    passages: int  # independent passages through the load zone among them
    depth: tuple[float, float]  # m, smallest and largest approach fitted
    scatter: float  # N, rms of run − law per contact fitted


def fit_law(approach, force, bridge: int, closing_speed=None, samples: int | None = None) -> Identification:
    """Fit Q = K δ^n, or with closing speeds Q = K δ^n + d δ̇, to closed contacts by least squares.

    Parameters
    ----------
    approach, force : ndarray, (n_times, n_rollers), m and N
    bridge : samples; a contact open no longer than this is still in the same passage
    closing_speed : δ̇, ndarray, (n_times, n_rollers), m/s; None: no damping is fitted
    samples : fit to the first so many; None: the first half

    Errors
    ------
    InputError: too few samples, passages, or too little range of depth to fix the numbers. The intervals are
    linear (delta method) with a covariance clustered by passage and Student's t; passages loaded at the same time
    still share the ring's vibration, which makes the intervals somewhat too narrow.

    Source: Liang and Zeger, Biometrika 73 (1986) 13-22: covariance of an estimate from clustered observations.
    """
    from scipy.optimize import least_squares

    samples = int(FIT_SHARE * approach.shape[0]) if samples is None else samples
    if samples < FEWEST_SAMPLES:
        raise InputError(f"{samples} samples to fit a law to, at least {FEWEST_SAMPLES} are needed; use a longer run")
    closed = force[:samples] > 0.0
    passage = passage_numbers(closed, bridge)[closed]
    depth, load = approach[:samples][closed], force[:samples][closed]
    speed = np.zeros_like(load) if closing_speed is None else closing_speed[:samples][closed]
    fitted = slice(2 if closing_speed is None else 3)  # of ln K, n and d
    n_passages = len(np.unique(passage))
    if n_passages <= fitted.stop + 1:
        raise InputError(
            f"{n_passages} passages of rollers through the load zone in the first {samples} samples, at least "
            f"{fitted.stop + 2} are needed to fit a law; use a longer run"
        )
    inside = depth > 0.0
    if inside.sum() < FEWEST_SAMPLES or np.std(np.log(depth[inside])) < LEAST_SPREAD:
        raise InputError("the contacts' approaches hardly vary: they fix no exponent; use a run with a load zone")
    units = np.array([rms(depth[inside]), rms(load), rms(speed)])  # in which the parameters are found
    if not units[1] > LEAST_FORCE:
        raise InputError(f"the contact forces, {units[1]:.3g} N rms, are too small to fit a law to")
    if closing_speed is not None and not units[2] > 0.0:
        raise InputError("the run has nothing that fixes a damping: nothing moves")
    logarithm, speed = np.log(np.where(inside, depth / units[0], 1.0)), speed / (units[2] or 1.0)

    def model(parameters):  # dimensionless forces, and their derivatives by ln K, n and d
        spring = np.where(inside, np.exp(parameters[0] + parameters[1] * logarithm), 0.0)
        total = spring + parameters[2] * speed if fitted.stop > 2 else spring
        pushes = inside & (total > 0.0)
        columns = np.column_stack([spring, spring * logarithm, speed])[:, fitted]
        return np.where(pushes, total, 0.0), np.where(pushes[:, None], columns, 0.0)

    found = least_squares(
        lambda p: model(p)[0] - load / units[1], np.array([0.0, 1.1, 0.0])[fitted], jac=lambda p: model(p)[1],
        method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-12,
    )  # fmt: skip
    if not found.success or not 0.2 < found.x[1] < 5.0:
        raise InputError(f"the run's forces follow no power law of the approach (exponent {found.x[1]:.3g})")
    if np.linalg.matrix_rank(found.jac) < fitted.stop:
        raise InputError("the run's forces do not fix all numbers of the law; use a longer run, or a named law")
    covariance = _clustered_covariance(found.jac, -found.fun, passage)
    half, exponent = np.sqrt(np.diag(covariance)), float(found.x[1])
    # ln K = ln K' + ln Q0 − n ln δ0: K and n are correlated, and K's interval is wide
    weights = np.append([1.0, -np.log(units[0])], np.zeros(fitted.stop - 2))
    log_stiffness = found.x[0] + np.log(units[1]) - exponent * np.log(units[0])
    reach = np.sqrt(weights @ covariance @ weights)
    stiffness = Interval(*np.exp([log_stiffness, log_stiffness - reach, log_stiffness + reach]).tolist())
    spring = PowerLaw(
        name=FITTED[fitted.stop - 2], stiffness=stiffness.value, exponent=exponent,
        range="the depths it was fitted to", source="fitted to the run's own contact forces, Q = K δ^n",
    )  # fmt: skip
    law: PowerLaw | DampedLaw = spring
    damping = None
    if closing_speed is not None:
        damping = _interval(units[1] / units[2] * found.x[2], units[1] / units[2] * half[2])
        law = DampedLaw(spring=spring, damping=ContactDamping(constant=damping.value))
    return Identification(
        law=law, stiffness=stiffness, exponent=_interval(exponent, half[1]), damping=damping, samples=samples,
        contacts=load.size, passages=n_passages, depth=(float(depth.min()), float(depth.max())),
        scatter=float(units[1]) * rms(found.fun),
    )  # fmt: skip


def _interval(value: float, reach: float) -> Interval:
    return Interval(float(value), float(value - reach), float(value + reach))


def passage_numbers(closed: np.ndarray, bridge: int) -> np.ndarray:
    """Number each passage of a roller through the load zone, (n_times, n_rollers); −1 outside."""
    number = np.full(closed.shape, -1)
    count = 0
    for j in range(closed.shape[1]):
        for first, last in load_zones(closed[:, j], bridge):
            number[first : last + 1, j] = count
            count += 1
    return number


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


def inner_law(name: str, record: Record) -> Law:
    """Named law of the inner contact, with the scene's damping of contacts."""
    law = contact_laws(name, record.bearing).inner
    if has_tilts(record):
        return sliced(record, law)
    damping = record.scene.damping.contacts
    return DampedLaw(spring=law, damping=damping) if damping.acts else law


def identify(record: Record, approach, closing_speed, bridge: int, name: str) -> Identification:
    """Fit one of FITTED to a run's own forces over the approach, m, and its rate, m/s.

    Errors
    ------
    InputError: the source holds no forces, or they fix no law.
    """
    if has_tilts(record):
        raise InputError(f"{record.source}: laws are not fitted to rollers that tilt; choose a named law")
    if record.inner_force is None:
        raise InputError(
            f"{record.source}: the law {name} is fitted to the run's own contact forces, which this source does not "
            "have; choose a named law"
        )
    try:
        return fit_law(approach, record.inner_force, bridge, None if name == "fitted" else closing_speed)
    except InputError as error:
        raise InputError(f"{record.source}: {error}") from None
