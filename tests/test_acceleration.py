"""Accelerations for other programs: the filter's band, what would fold into it, rates, formats."""

import numpy as np
import pytest
from scipy.io import wavfile

from fem.commands.render_fem import render_main
from fem.result.run_file import G, accelerations, channels
from lagrange.errors import UsageError
from lagrange.scene.scene import parse_scene
from tests.reference.synthetic_run import make_run, run_variables, write_result


def scene(**output):
    return parse_scene({"output": output} if output else {}, "")


def tone(frequency: float, interval: float = 1e-5, n: int = 20_000) -> np.ndarray:
    return np.cos(2.0 * np.pi * frequency * interval * np.arange(n))


def recorded(values: np.ndarray, **output) -> np.ndarray:
    return accelerations(scene(**output), lambda name: values)["inner_ay"]


@pytest.mark.parametrize("frequency", [10.0, 381.5, 5000.0, 9990.0])
def test_tones_in_the_band_keep_amplitude_and_phase(frequency):
    found = recorded(tone(frequency))
    wanted = np.cos(2.0 * np.pi * frequency * np.arange(found.size) / 25_600)
    middle = slice(200, -200)
    np.testing.assert_allclose(found[middle], wanted[middle], atol=2e-4)


@pytest.mark.parametrize("frequency", [15_700.0, 20_000.0, 25_600.0, 40_000.0, 49_000.0])
def test_what_would_fold_into_the_band_is_gone(frequency):
    """Below −80 dB; plain decimation would show it at full height."""
    found = recorded(tone(frequency))
    assert np.abs(found[200:-200]).max() < 1.3e-4


def test_rates_that_samples_can_not_give_are_refused():
    with pytest.raises(UsageError, match=r"output\.acceleration_Hz = 200000: .*output_interval_us below 5"):
        recorded(tone(10.0), acceleration_Hz=200_000)
    with pytest.raises(UsageError, match="no ratio of small whole numbers"):
        recorded(tone(10.0), acceleration_Hz=31_415)  # 6283/20000 of the samples' rate


def test_a_housing_and_its_sensor_are_channels_too():
    assert channels(scene()) == ("inner_ax", "inner_ay")
    mounted = parse_scene({"support": {"kind": "housing"}, "sensor": {}}, "")
    assert channels(mounted) == ("inner_ax", "inner_ay", "housing_ax", "housing_ay", "sensor_ay")


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A run whose hub circles at 500 Hz."""
    run = make_run(n_times=2001)
    return write_result(tmp_path_factory.mktemp("runs") / "made.nc", run, run_variables(run))


def test_the_command_writes_csv_and_wav(stored, tmp_path, capsys):
    for suffix in ("csv", "wav"):
        assert render_main([str(stored), "--export", str(tmp_path / f"a.{suffix}")]) == 0
    assert "inner_ax, inner_ay at 25600 Hz" in capsys.readouterr().out
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    assert table.dtype.names == ("time_s", "inner_ax_m_s2", "inner_ax_g", "inner_ay_m_s2", "inner_ay_g")
    assert np.diff(table["time_s"]) == pytest.approx(1.0 / 25_600, rel=1e-5)
    middle = slice(100, -100)
    wanted = -((2e3 * np.pi * 0.5) ** 2) * 2e-7 * np.cos(2e3 * np.pi * 0.5 * table["time_s"])
    np.testing.assert_allclose(table["inner_ax_m_s2"][middle], wanted[middle], atol=2e-4 * np.abs(wanted).max())
    np.testing.assert_allclose(table["inner_ax_g"], table["inner_ax_m_s2"] / G, rtol=1e-6, atol=1e-12)
    rate, sound = wavfile.read(tmp_path / "a.wav")
    assert rate == 25_600 and sound.shape == (table.size, 2) and sound.dtype == np.float32
    np.testing.assert_allclose(sound[:, 0], table["inner_ax_m_s2"], rtol=1e-6, atol=1e-7)


def test_what_can_not_be_is_refused_in_a_line(stored, tmp_path, capsys):
    for arguments, words in (
        (["--export", str(tmp_path / "a.wav"), "--time", "3"], "--time"),
        (["--export", str(tmp_path / "nowhere" / "a.wav")], "can't be written"),
        (["--export", str(tmp_path / "a.mp3")], ".csv, .wav or"),
    ):
        assert render_main([str(stored), *arguments]) == 2
        assert words in capsys.readouterr().err
