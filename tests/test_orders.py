"""Order spectra: lines of signals that turn with a shaft whose speed changes."""

import numpy as np
import pytest

from lagrange.kinematics import turned
from residual.evaluation import evaluate
from residual.record import Record
from residual.spectrum import power_spectrum
from residual.vibration import order_spectra, tracking_of
from tests.reference.kit import scene_with

BPFO, FTF = 13 * 9 / 23, 9 / 23  # 5.087 and 0.3913 per turn: geometry of the paper's bearing


def record_of(folder, speeds, duration_ms, interval=1e-4):
    """A bearing that rolls without slip, its hub moved once a roller and once a turn of the cage."""
    scene = scene_with(folder, f"numerics.duration_ms={duration_ms}", speeds=speeds)
    bearing, operation = scene.ideal_bearing(), scene.ideal_operation()
    time = interval * np.arange(round(1e-3 * duration_ms / interval) + 1)
    cage = turned(bearing, operation, time).cage
    theta = cage[:, None] + 2.0 * np.pi * np.arange(13) / 13 - 0.5 * np.pi
    path = 1e-6 * np.cos(13 * cage) + 3e-7 * np.cos(cage + 0.4)
    return Record(
        name="made", source=folder, scene=scene, time=time, inner_x=0.0 * time, inner_y=path - 4e-6,
        roller_x=23e-3 * np.cos(theta), roller_y=23e-3 * np.sin(theta),
    )  # fmt: skip


@pytest.fixture(scope="module")
def ramp(tmp_path_factory):
    folder = tmp_path_factory.mktemp("orders")
    return record_of(folder, "time_ms,speed_rpm\n0,1000\n1000,4000\n1600,6000\n", 1600)


def test_lines_stand_at_their_orders_at_every_instant_and_smear_in_hz(ramp):
    whole = evaluate(ramp, "harris")
    found = whole.y.orders
    assert (found.tracking.lines["BPFO"], found.tracking.lines["FTF"]) == pytest.approx((BPFO, FTF), rel=1e-6)
    named = {peak.line: peak for peak in found.peaks}
    for line, order, amplitude in (("BPFO", BPFO, 1e-6), ("FTF", FTF, 3e-7)):
        assert named[line].frequency == pytest.approx(order, abs=0.02 * found.path.resolution)
        assert named[line].rms == pytest.approx(amplitude / np.sqrt(2.0), rel=1e-3)
    for piece in np.array_split(found.tracking.resampled(ramp.inner_y), 8):  # at any speed
        short = power_spectrum(piece, found.tracking.angles[1] - found.tracking.angles[0])
        for low, high, order in ((3.0, 8.0, BPFO), (0.25, 1.0, FTF)):
            inside = (short.frequency > low) & (short.frequency < high)
            highest = short.frequency[inside][np.argmax(short.psd[inside])]
            assert abs(highest - order) <= 0.51 * short.resolution
    assert whole.lines == {} and any("marked in orders" in note for note in whole.notes)
    by_time, by_angle = power_spectrum(ramp.inner_y, ramp.interval), found.path
    shares = [s.psd.max() * s.resolution / np.var(ramp.inner_y) for s in (by_time, by_angle)]
    assert shares[0] < 0.1 and shares[1] > 0.4  # of the power in one bin


def test_standing_turning_back_and_steady_speeds_are_left_out(tmp_path):
    """Also where the check skips the run's beginning."""
    record = record_of(tmp_path, "time_ms,speed_rpm\n0,-3000\n200,0\n300,0\n400,3000\n1500,6000\n", 1500)
    found = tracking_of(record)
    assert 0.3 < found.time[0] < 0.4 and found.time[-1] == record.time[-1] and np.all(np.diff(found.turn) > 0.0)
    assert evaluate(record, "harris", start=0.1).y.orders.peaks[0].line == "BPFO"
    steady = record_of(tmp_path, "time_ms,speed_rpm\n0,3000\n400,3000\n", 400)  # has no orders but frequencies
    assert tracking_of(steady) is None
    found = evaluate(steady, "harris")
    assert found.y.orders is None and found.lines["BPFO"] == pytest.approx(50 * BPFO, rel=1e-6)


def test_an_envelope_is_told_in_orders_too(tmp_path):
    """Bursts of 6 kHz once a roller."""
    record = record_of(tmp_path, "time_ms,speed_rpm\n0,1000\n800,3000\n", 800, 2e-5)
    passed = turned(record.bearing, record.operation, record.time).cage * 13
    bursts = (1.0 + np.cos(passed)) * np.sin(2.0 * np.pi * 6000.0 * record.time)
    found = order_spectra(tracking_of(record), record.inner_x, record.inner_y, bursts).envelope
    above = found.frequency > 1.0
    assert found.frequency[above][np.argmax(found.psd[above])] == pytest.approx(BPFO, abs=found.resolution)
