"""A contact law fitted to a run's own forces: K and n of Q = K δ^n by least squares, with confidence intervals.

Fitted to the closed inner contacts of the record's first part; the rest is held back to judge the law on.

The samples of one roller's passage through the load zone are far from independent, so the intervals take the
passage, not the sample, as the unit of observation. They say how well the data fix the two numbers, not that a
power law is true: what the law can't follow in any passage shows in the scatter, not in the interval.
"""

from dataclasses import dataclass

import numpy as np

from lagrange.laws import PowerLaw
from residual.budget import load_zones
from residual.trajectory import FEWEST_SAMPLES, InputError

FIT_SHARE = 0.5  # of the record
CONFIDENCE = 0.95
LEAST_SPREAD = 0.02  # of ln δ: less depth range than this fixes no exponent
LARGEST_GAIN = 0.5  # of the coupling's fixed point: beyond it the coupling is no correction any more
FIXED_POINT_STEPS = 60  # gain 0.5: round-off


@dataclass(frozen=True, kw_only=True)
class CoupledLaw(PowerLaw):
    """Q_j = K max(δ_j − c (Q_{j−1} + Q_{j+1}), 0)^n: contacts of one ring feel their neighbours through the ring.

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
class Interval:
    """A fitted number and its 95 % confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Identification:
    """A fitted law and how well it is known."""

    law: PowerLaw
    stiffness: Interval  # K, N/m^n
    exponent: Interval  # n
    coupling: Interval | None  # c, m/N
    samples: int  # of the record's first part; the rest is held back
    contacts: int  # closed contacts fitted
    passages: int  # independent passages through the load zone among them
    depth: tuple[float, float]  # m, smallest and largest approach fitted
    scatter: float  # N, rms of run − law per contact fitted


def neighbours(force) -> np.ndarray:
    """Q_{j−1} + Q_{j+1} of every contact, rollers along the last axis."""
    return np.roll(force, 1, axis=-1) + np.roll(force, -1, axis=-1)


def fit_law(approach, force, bridge: int, coupled: bool = False, samples: int | None = None) -> Identification:
    """Least-squares fit of Q = K δ^n to closed contacts.

    Parameters
    ----------
    approach, force : ndarray, (n_times, n_rollers), m and N
    bridge : samples; a contact open no longer than this is still in the same passage
    coupled : fit the coupling between neighbouring contacts too
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
    depth, load, beside = approach[:samples][closed], force[:samples][closed], neighbours(force[:samples])[closed]
    n_parameters, n_passages = 3 if coupled else 2, len(np.unique(passage))
    if n_passages <= n_parameters + 1:
        raise InputError(
            f"{n_passages} passages of rollers through the load zone in the first {samples} samples, at least "
            f"{n_parameters + 2} are needed to fit a law; use a longer run"
        )
    positive = depth > 0.0
    if positive.sum() < FEWEST_SAMPLES or np.std(np.log(depth[positive])) < LEAST_SPREAD:
        raise InputError("the contacts' approaches hardly vary: they fix no exponent; use a run with a load zone")
    unit = float(np.sqrt(np.mean(depth[positive] ** 2))), float(np.sqrt(np.mean(load**2)))
    parameters, jacobian, miss = _least_squares(depth / unit[0], load / unit[1], beside / unit[1], coupled)
    covariance = _clustered_covariance(jacobian, miss, passage)
    return _identified(
        parameters, covariance, unit, samples=samples, contacts=load.size, passages=n_passages,
        depth=(float(depth.min()), float(depth.max())), scatter=float(unit[1] * np.sqrt(np.mean(miss**2))),
    )  # fmt: skip


def passage_numbers(closed: np.ndarray, bridge: int) -> np.ndarray:
    """A number for each passage of a roller through the load zone, (n_times, n_rollers); −1 outside."""
    number = np.full(closed.shape, -1)
    count = 0
    for j in range(closed.shape[1]):
        for first, last in load_zones(closed[:, j], bridge):
            number[first : last + 1, j] = count
            count += 1
    return number


def _model(parameters, depth, beside):
    """Dimensionless force and its derivatives by ln K, n, c: (n,), (n, n_parameters)."""
    coupling = parameters[2] if parameters.size > 2 else 0.0
    left = depth - coupling * beside
    inside = left > 0.0
    logarithm = np.log(np.where(inside, left, 1.0))
    force = np.where(inside, np.exp(parameters[0] + parameters[1] * logarithm), 0.0)
    columns = [force, force * logarithm]
    if parameters.size > 2:
        columns.append(-parameters[1] * force / np.where(inside, left, 1.0) * beside)
    return force, np.column_stack(columns)


def _least_squares(depth, load, beside, coupled: bool):
    """Parameters (ln K, n, c) in units of the data, Jacobian and run − law at the optimum."""
    from scipy.optimize import least_squares

    start = np.array([0.0, 1.1, 0.0] if coupled else [0.0, 1.1])
    found = least_squares(
        lambda p: _model(p, depth, beside)[0] - load, start, jac=lambda p: _model(p, depth, beside)[1],
        xtol=1e-12, ftol=1e-12, gtol=1e-12,
    )  # fmt: skip
    if not found.success or not 0.2 < found.x[1] < 5.0:
        raise InputError(f"the run's forces follow no power law of the approach (exponent {found.x[1]:.3g})")
    return found.x, found.jac, -found.fun


def _clustered_covariance(jacobian, miss, passage) -> np.ndarray:
    """Covariance of the parameters, times Student's t squared, from the passages' scores."""
    from scipy.stats import t as student

    order = np.unique(passage, return_inverse=True)[1]
    n_passages, n_parameters = order.max() + 1, jacobian.shape[1]
    score = np.zeros((n_passages, n_parameters))
    np.add.at(score, order, jacobian * miss[:, None])
    bread = np.linalg.inv(jacobian.T @ jacobian)
    reach = student.ppf(0.5 + 0.5 * CONFIDENCE, n_passages - n_parameters)
    return reach**2 * n_passages / (n_passages - 1) * bread @ (score.T @ score) @ bread


def _identified(parameters, covariance, unit, **facts) -> Identification:
    """Back to SI: ln K = ln K' + ln Q0 − n ln δ0, so K and n are correlated and K's interval is wide."""
    depth_unit, load_unit = unit
    exponent = float(parameters[1])
    log_stiffness = float(parameters[0] + np.log(load_unit) - exponent * np.log(depth_unit))
    weights = np.zeros(parameters.size)
    weights[:2] = 1.0, -np.log(depth_unit)
    reach = float(np.sqrt(weights @ covariance @ weights))
    stiffness = Interval(
        value=float(np.exp(log_stiffness)),
        low=float(np.exp(log_stiffness - reach)),
        high=float(np.exp(log_stiffness + reach)),
    )
    half = np.sqrt(np.diag(covariance))
    about = {"stiffness": stiffness.value, "exponent": exponent, "range": "the depths it was fitted to"}
    if parameters.size == 2:
        law = PowerLaw(name="fitted", source="fitted to the run's own contact forces, Q = K δ^n", **about)
        coupling = None
    else:
        scale = depth_unit / load_unit
        coupling = _symmetric(scale * parameters[2], scale * half[2])
        law = CoupledLaw(
            name="fitted_coupled",
            source="fitted to the run's own contact forces, Q_j = K (δ_j − c (Q_j−1 + Q_j+1))^n",
            coupling=coupling.value, **about,
        )  # fmt: skip
        gain = 2.0 * abs(coupling.value) * float(PowerLaw.slope(law, max(facts["depth"][1], 0.0)))
        if gain > LARGEST_GAIN:
            raise InputError(
                f"the fitted coupling is no small correction (gain {gain:.2g}, at most {LARGEST_GAIN:g}); "
                "use the law fitted"
            )
    return Identification(
        law=law, stiffness=stiffness, exponent=_symmetric(exponent, half[1]), coupling=coupling, **facts
    )


def _symmetric(value: float, reach: float) -> Interval:
    return Interval(value=float(value), low=float(value - reach), high=float(value + reach))
