"""Accelerations for other programs: the filter's band, what would fold into it, rates, formats."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.io import wavfile

from fem.commands.render_fem import render_main
from fem.result.run_file import G, accelerations, channels
from lagrange.errors import UsageError
from lagrange.scene.scene import parse_scene
from tests.reference.synthetic_run import make_run, run_variables, write_result


def recorded(frequency: float, **output) -> np.ndarray:
    """What is exported of a tone, Hz, at 100 kHz."""
    tone = np.cos(2.0 * np.pi * frequency * 1e-5 * np.arange(20_000))
    return accelerations(parse_scene({"output": output} if output else {}, ""), lambda name: tone)["inner_ay"]


def test_tones_in_the_band_keep_amplitude_and_phase_and_what_would_fold_into_it_is_gone():
    """Below −80 dB; plain decimation would show it at full height."""
    for frequency in (10.0, 381.5, 5000.0, 9990.0):
        found = recorded(frequency)
        wanted = np.cos(2.0 * np.pi * frequency * np.arange(found.size) / 25_600)
        assert_allclose(found[200:-200], wanted[200:-200], atol=2e-4, err_msg=frequency)
    for frequency in (15_700.0, 20_000.0, 25_600.0, 40_000.0, 49_000.0):
        assert np.abs(recorded(frequency)[200:-200]).max() < 1.3e-4, frequency


def test_rates_that_samples_can_not_give_are_refused_and_a_housing_and_its_sensor_are_channels():
    for rate, told in (
        (200_000, r"output\.acceleration_Hz = 200000: .*output_interval_us below 5"),
        (31_415, "no ratio of small whole numbers"),  # 6283/20000 of the samples' rate
    ):
        with pytest.raises(UsageError, match=told):
            recorded(10.0, acceleration_Hz=rate)
    # a housing and its sensor are channels too
    assert channels(parse_scene({}, "")) == ("inner_ax", "inner_ay")
    mounted = parse_scene({"support": {"kind": "housing"}, "sensor": {}}, "")
    assert channels(mounted) == ("inner_ax", "inner_ay", "housing_ax", "housing_ay", "sensor_ay")


def test_the_command_writes_csv_and_wav_and_refuses_in_a_line_what_can_not_be(tmp_path, capsys):
    """Of a run whose hub circles at 500 Hz."""
    run = make_run(n_times=2001)
    stored = str(write_result(tmp_path / "made.nc", run, run_variables(run)))
    for suffix in ("csv", "wav"):
        assert render_main([stored, "--export", str(tmp_path / f"a.{suffix}")]) == 0
    assert "inner_ax, inner_ay at 25600 Hz" in capsys.readouterr().out
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    assert table.dtype.names == ("time_s", "inner_ax_m_s2", "inner_ax_g", "inner_ay_m_s2", "inner_ay_g")
    assert np.diff(table["time_s"]) == pytest.approx(1.0 / 25_600, rel=1e-5)
    middle, found = slice(100, -100), table["inner_ax_m_s2"]
    wanted = -((2e3 * np.pi * 0.5) ** 2) * 2e-7 * np.cos(2e3 * np.pi * 0.5 * table["time_s"])
    assert_allclose(found[middle], wanted[middle], atol=2e-4 * np.abs(wanted).max())
    assert_allclose(table["inner_ax_g"], found / G, rtol=1e-6, atol=1e-12)
    rate, sound = wavfile.read(tmp_path / "a.wav")
    assert rate == 25_600 and sound.shape == (table.size, 2) and sound.dtype == np.float32
    assert_allclose(sound[:, 0], found, rtol=1e-6, atol=1e-7)
    told = {"nowhere/a.wav": "can't be written", "a.mp3": ".csv, .wav or", "b.wav --time 3": "--time"}
    for name, words in told.items():
        assert render_main([stored, "--export", *str(tmp_path / name).split()]) == 2
        assert words in capsys.readouterr().err
