"""Varying compliance: the hub's motion as rollers pass under the load."""

from dataclasses import replace
from math import pi

import numpy as np

from fem.statics.exact_statics import exact_statics
from lagrange import contact_laws, static_equilibrium
from lagrange.kinematics import kinematics
from lagrange.scene.scene import read_scene
from tests.reference.kit import LOAD, ON_A_ROLLER, paper
from tests.verification.case import ANALYTIC, COMPUTED, MODEL, Case, Check
from tests.verification.runs import RunSamples, plan_of, record

SPEED_RPM = 900.0  # slow: a fifth of the paper's, whose dynamics would add 1 %
PERIODS = 2
SAMPLES = 256  # of a period
HALF_PITCH_POINTS = 13


def over_a_pitch(hub_at) -> np.ndarray:
    """Hub positions, (2 (HALF_PITCH_POINTS − 1), 2), m, as the rollers move on by one pitch.

    Parameters
    ----------
    hub_at : function of the first roller's angle, rad; called over half a pitch, the rest is its mirror image
    """
    pitch = 2.0 * pi / paper().n_rollers
    half = np.array([hub_at(ON_A_ROLLER + 0.5 * pitch * share) for share in np.linspace(0.0, 1.0, HALF_PITCH_POINTS)])
    return np.concatenate([half, half[-2:0:-1] * [-1.0, 1.0]])


def line(hub: np.ndarray) -> np.ndarray:
    """Complex amplitude of the ball-pass line in x and y, m, of equidistant positions over one period."""
    return 2.0 * np.fft.rfft(hub, axis=0)[1] / len(hub)


def _period(found: RunSamples, period: float, number: int) -> np.ndarray:
    """Hub positions over one ball-pass period, s, of a run, (SAMPLES, 2), m."""
    at = period * (number + np.arange(SAMPLES) / SAMPLES)
    return np.column_stack([np.interp(at, found["time"], found[name]) for name in ("inner_x", "inner_y")])


def varying_compliance():
    """Two ball-pass periods of the paper's bearing at 900 rpm without gravity, mesh 2 mm: the whole time loop.

    The references stand still at each angle and know no friction, which in the run keeps the rollers apart with
    tractions of up to 0.2 N on the hub, 0.3 nm. Rigid rings with Johnson's law or the paper's differ as models do.
    """
    bearing, still = paper(), replace(read_scene().ideal_operation(), speed=0.0, gravity=0.0)
    ideal = kinematics(bearing, SPEED_RPM * pi / 30.0).frequencies["BPFO"]
    found = record(plan_of(
        numerics__mesh_size_mm=2.0, numerics__output_interval_us=20.0, operation__speed_rpm=SPEED_RPM,
        operation__gravity_m_s2=0.0, numerics__duration_ms=1.01e3 * PERIODS / ideal,
    ))  # fmt: skip
    periods = [_period(found, 1.0 / ideal, number) for number in range(PERIODS)]
    last = periods[-1]
    amplitude = line(last)

    exact = over_a_pitch(lambda angle: exact_statics(bearing, LOAD, angle).hub)
    series = "our own exact series at each angle, at rest (fem.statics.exact_statics)"
    for i, axis in enumerate("xy"):
        yield Check(
            f"amplitude of the ball-pass line, {axis}", "nm", 1e9 * float(abs(amplitude[i])),
            1e9 * float(abs(line(exact)[i])), 5e-3, COMPUTED, series
        )  # fmt: skip
    yield Check(
        "mean of y", "µm", 1e6 * float(last[:, 1].mean()), 1e6 * float(exact[:, 1].mean()), 2e-3, COMPUTED, series
    )

    turned = np.angle(amplitude[0] / line(periods[-2])[0]) / (2.0 * pi)  # of a period, beyond the expected one
    yield Check(
        "frequency of the line", "Hz", ideal * (1.0 + turned), ideal, 1e-3, ANALYTIC,
        "rolling without slip (Harris, chapter 8)"
    )  # fmt: skip

    for law, tolerance in (("johnson", 0.1), ("harris", 0.15)):
        laws = contact_laws(law, bearing)

        def hub_at(angle, laws=laws):
            at = static_equilibrium(bearing, replace(still, first_roller_angle=angle), laws)
            return np.array([at.x, at.y])

        rigid = over_a_pitch(hub_at)
        for i, axis in enumerate("xy"):
            yield Check(
                f"amplitude, {axis}, rigid rings, law of {law.capitalize()}", "nm", 1e9 * float(abs(amplitude[i])),
                1e9 * float(abs(line(rigid)[i])), tolerance, MODEL, "statics of the Lagrange model"
            )  # fmt: skip


CASES = (Case(checks=varying_compliance),)
