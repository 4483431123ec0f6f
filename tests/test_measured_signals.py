"""Files of all kinds, each read into the same signal or refused in a sentence."""

import io
import sys
import wave

import h5py
import numpy as np
import pytest
from scipy.io import savemat, wavfile

from lagrange.messages import G
from residual.errors import InputError
from residual.measured.signals import read_signal

RATE = 8000.0
TIME = np.arange(2000) / RATE
WAVE = np.round(np.sin(2.0 * np.pi * 130.0 * TIME) + 0.3 * np.cos(2.0 * np.pi * 1900.0 * TIME), 5)  # g


def rows(delimiter=",", decimal=".", head="", columns=(TIME, WAVE), digits="%.6f"):
    """Text of columns."""
    lines = [delimiter.join(digits % x for x in row).replace(".", decimal) for row in zip(*columns, strict=True)]
    return head + "\n".join(lines) + "\n"


def wav(bits):
    """A WAV file of whole numbers, half of full scale."""
    target = io.BytesIO()
    with wave.open(target, "wb") as file:
        file.setnchannels(1), file.setsampwidth(bits // 8), file.setframerate(int(RATE))
        values = np.round(WAVE / 2.0 * (2 ** (bits - 1) - 1)).astype(np.int64)
        data = (values + 128).astype("u1") if bits == 8 else values
        file.writeframes(b"".join(int(v).to_bytes(bits // 8, "little", signed=bits > 8) for v in data))
    return target.getvalue()


def saved(write, *arguments, **keywords):
    target = io.BytesIO()
    write(target, *arguments, **keywords)
    return target.getvalue()


def matlab73(**datasets):
    target = io.BytesIO()
    with h5py.File(target, "w", userblock_size=512) as file:
        for name, values in datasets.items():
            file[name] = values
    return b"MATLAB 7.3 MAT-file".ljust(512) + target.getvalue()[512:]


HEAD = "time_s,acc_g\n"
READ = {  # name: content, options, factor from the file's numbers to m/s²
    "plain.csv": (rows(head=HEAD), {}, G),
    "semicolons.csv": (rows(";", head="Time;acc [g]\n"), {}, G),
    "german.csv": (rows(";", ",", "Zeit [s];Beschleunigung [m/s²]\n"), {}, 1.0),
    "german_latin.csv": (rows(";", ",", "Zeit [s];Beschleunigung [m/s²]\n").encode("cp1252"), {}, 1.0),
    "tabs.txt": (rows("\t", head="time\tacc (g)\n"), {}, G),
    "tabs_decimal_comma.txt": (rows("\t", ",", "time\tacc (g)\n"), {}, G),
    "blanks.dat": (rows("   ", head="# time acc\n"), {"unit": "g"}, G),
    "mark.csv": (b"\xef\xbb\xbf" + rows(head=HEAD).encode(), {}, G),
    "utf16.csv": (rows(head=HEAD).encode("utf-16"), {}, G),
    "crlf.csv": (rows(head=HEAD).replace("\n", "\r\n"), {}, G),
    "units_row.csv": (rows(";", ",", "Time;acc\ns;g\n"), {}, G),
    "milliseconds.csv": (rows(head="time [ms],acc [g]\n", columns=(1e3 * TIME, WAVE)), {}, G),
    "preamble.csv": (rows(head="Logger 3\nSensor: A\n\n" + HEAD), {}, G),
    "rate_in_words.csv": (rows(head="Sampling rate: 8 kHz\nacc [g]\n", columns=(WAVE,)), {}, G),
    "no_header.csv": (rows(), {"unit": "m/s2"}, 1.0),
    "one_column.txt": (rows(columns=(WAVE,)), {"rate": RATE, "unit": "g"}, G),
    "one_column_comma.txt": (rows(decimal=",", columns=(WAVE,)), {"rate": RATE, "unit": "g"}, G),
    "quoted.csv": (rows(head='"time","acc [g]"\n'), {}, G),
    "trailing.csv": (rows(head=HEAD).replace("\n", ",\n"), {}, G),
    "two_channels.csv": (rows(head="time,x [g],y [g]\n", columns=(TIME, 0 * WAVE, WAVE)), {"channel": "y"}, G),
    "both_units.csv": (rows(head="time_s,y_m_s2,y_g\n", columns=(TIME, WAVE, TIME)), {"channel": "y"}, 1.0),
    "number_of_channel.csv": (rows(head="time,x [g],y [g]\n", columns=(TIME, TIME, WAVE)), {"channel": "2"}, G),
    "volts.csv": (rows(head="time,acc [V]\n"), {"sensitivity": "100 mV/g"}, 10.0 * G),
    "8.wav": (wav(8), {"unit": "g"}, 0.5 * G),
    "16.wav": (wav(16), {"unit": "g"}, 0.5 * G),
    "24.wav": (wav(24), {"unit": "g"}, 0.5 * G),
    "32.wav": (wav(32), {"unit": "g"}, 0.5 * G),
    "float.wav": (saved(wavfile.write, int(RATE), WAVE.astype(np.float32)), {"unit": "g"}, G),
    "double_stereo.wav": (
        saved(wavfile.write, int(RATE), np.column_stack([TIME, WAVE])),
        {"unit": "g", "channel": "channel 2"},
        G,
    ),
    "five.mat": (saved(savemat, {"X097_DE_time": WAVE[:, None], "fs": RATE}), {"unit": "g"}, G),
    "struct.mat": (
        saved(savemat, {"bearing": {"sr": 3.0, "gs": WAVE, "rate": RATE, "note": "x"}}),
        {"unit": "g"},
        G,
    ),
    "four.mat": (saved(savemat, {"a": WAVE}, format="4"), {"unit": "g", "rate": RATE}, G),
    "seven.mat": (matlab73(acc=WAVE[None, :], fs=[[RATE]]), {"unit": "g"}, G),
    "seven_struct.mat": (matlab73(**{"run/acc": WAVE[None, :], "run/fs": [[RATE]]}), {"unit": "g"}, G),
    "x.npy": (saved(np.save, WAVE), {"rate": RATE, "unit": "g"}, G),
    "x.npz": (saved(np.savez, acc=WAVE, rate=RATE), {"unit": "g"}, G),
    "whole.npz": (saved(np.savez_compressed, acc=np.round(1000 * WAVE).astype("i2"), fs=8000), {"unit": "mg"}, G),
}


@pytest.mark.parametrize("name", READ)
def test_file_is_read_into_the_signal_that_was_written(name, tmp_path):
    content, options, factor = READ[name]
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    signal = read_signal(path, **options)
    assert signal.rate == pytest.approx(RATE, rel=1e-6)
    assert signal.unit == "m/s²"
    coarse = 0.02 if name == "8.wav" else 1e-3 if name == "whole.npz" else 2e-4
    np.testing.assert_allclose(signal.values, factor * (WAVE - WAVE.mean()), rtol=0.0, atol=coarse * factor)


REFUSED = {  # name: content, options, words of the refusal
    "words.csv": ("a,b\nc,d\n", {}, "no rows of numbers"),
    "empty.csv": ("\n", {}, "empty"),
    "no_rate.txt": (rows(columns=(WAVE,)), {}, "--rate"),
    "other_rate.csv": (rows(head=HEAD), {"rate": 9000.0}, "leave --rate out"),
    "which.csv": (rows(head="time,x,y\n", columns=(TIME, WAVE, WAVE)), {}, "add --channel"),
    "none_such.csv": (rows(head="time,x,y\n", columns=(TIME, WAVE, WAVE)), {"channel": "z"}, "no channel"),
    "broken.csv": (rows(head=HEAD) + "0.3,abc\n", {}, "'abc' is no number"),
    "ragged.csv": (rows(head=HEAD) + "0.3,1,2\n", {}, "3 cells"),
    "far.csv": (rows(head=HEAD, columns=(1e200 * TIME, WAVE), digits="%.6e"), {}, "which no record has"),
    "short.csv": (rows(head=HEAD, columns=(TIME[:500], WAVE[:500])), {}, "at least 1024"),
    "constant.csv": (rows(head=HEAD, columns=(TIME, 0.0 * WAVE)), {}, "constant"),
    "volts.csv": (rows(head=HEAD), {"unit": "V"}, "--sensitivity"),
    "unit.csv": (rows(head=HEAD), {"unit": "furlong"}, "known are g"),
    "book.xlsx": (saved(np.savez, a=1).replace(b".npy", b".xml"), {}, "workbook"),
    "cut.wav": (wav(16)[:30], {}, "WAV"),
    "cut.mat": (saved(savemat, {"a": WAVE})[:200], {}, "MATLAB"),
    "cut73.mat": (matlab73(acc=WAVE)[:700], {}, "7.3"),
    "words.mat": (saved(savemat, {"a": "words"}), {}, "without a signal"),
    "cut.npy": (saved(np.save, WAVE)[:300], {"rate": RATE}, "NPY"),
    "objects.npy": (saved(np.save, np.array([{}], dtype=object)), {"rate": RATE}, "NPY"),
    "a.parquet": (b"PAR1" + bytes(100), {}, "pip install pyarrow"),
    "a.tdms": (b"TDSm" + bytes(100), {}, "pip install nptdms"),
    "a.unv": ("    -1\n    58\nx\n", {}, "pip install pyuff"),
    "random.bin": (bytes(range(256)) * 20, {"rate": RATE}, "not UTF-8 text"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_file_is_refused_in_a_sentence(name, tmp_path, monkeypatch):
    for package in ("pyarrow.parquet", "nptdms", "pyuff"):
        monkeypatch.setitem(sys.modules, package, None)
    content, options, words = REFUSED[name]
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError, match=words.replace("(", r"\(")) as refusal:
        read_signal(path, **options)
    assert "Traceback" not in str(refusal.value)
    assert "\n" not in str(refusal.value)


def told(tmp_path, values, time=TIME):
    """Sentences on a record of these values."""
    path = tmp_path / "record.csv"
    path.write_text(rows(head=HEAD, columns=(time, values)).replace("nan", ""), encoding="utf-8")
    return read_signal(path)


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        read_signal(tmp_path / "none.csv")


def test_good_record_has_no_faults(tmp_path):
    assert told(tmp_path, WAVE).notes == ()


def test_clipping_is_told(tmp_path):
    assert "saturated" in told(tmp_path, np.clip(WAVE, -0.7, 0.7)).notes[0]


def test_drop_outs_are_told(tmp_path):
    values = WAVE.copy()
    values[500:580] = values[500]
    assert "drops out 1 times" in told(tmp_path, values).notes[0]


def test_offset_is_told_and_removed(tmp_path):
    signal = told(tmp_path, WAVE + 5.0)
    assert "was removed" in signal.notes[0]
    assert abs(signal.values.mean()) < 1e-9


def test_longest_piece_between_missing_samples_is_taken(tmp_path):
    values = WAVE.copy()
    values[[100, 101, 1900]] = np.nan
    signal = told(tmp_path, values)
    assert "3 samples without a number" in signal.notes[0]
    np.testing.assert_allclose(signal.values, G * (WAVE[102:1900] - WAVE[102:1900].mean()), atol=1e-4)


def test_gap_in_time_is_told_and_does_not_change_the_rate(tmp_path):
    signal = told(tmp_path, WAVE, np.where(np.arange(2000) < 300, TIME, TIME + 0.1))
    assert "1 gap in time" in signal.notes[0]
    assert signal.values.size == 1700
    assert signal.rate == pytest.approx(RATE, rel=1e-4)


@pytest.mark.parametrize(
    ("line", "rate"),
    [
        ("Sampling rate: 8 kHz", 8000.0),
        ("Abtastrate;8000 Hz", 8000.0),
        ("# fs=8000", 8000.0),
        ("Sampling frequency (Hz),8000", 8000.0),
        ("Sample rate [kHz]: 8", 8000.0),
        ("fs = 8000 Hz, speed 1480 rpm", 8000.0),
    ],
)
def test_rate_before_the_numbers(tmp_path, line, rate):
    path = tmp_path / "record.csv"
    path.write_text(rows(head=f"{line}\nacc [g]\n", columns=(WAVE,)), encoding="utf-8")
    assert read_signal(path).rate == rate


@pytest.mark.parametrize(
    "line", ["Shaft frequency: 25 Hz", "Drehfrequenz: 25 Hz", "Samples: 2000", "cut-off frequency 5 kHz"]
)
def test_other_frequencies_are_no_rate(tmp_path, line):
    path = tmp_path / "record.csv"
    path.write_text(rows(head=f"{line}\nacc [g]\n", columns=(WAVE,)), encoding="utf-8")
    with pytest.raises(InputError, match="neither a rate nor a column of times"):
        read_signal(path)


def test_a_whole_word_of_a_channels_name_goes_before_a_part(tmp_path):
    path = tmp_path / "record.csv"
    path.write_text(rows(head="time_s,band A,band B\n", columns=(TIME, WAVE, 2.0 * WAVE)), encoding="utf-8")
    assert read_signal(path, channel="B").values.std() == pytest.approx(
        2.0 * read_signal(path, channel="A").values.std()
    )


def test_unit_behind_a_columns_name(tmp_path):
    path = tmp_path / "record.csv"
    path.write_text(rows(head="time_s,velocity_mm/s\n", columns=(TIME, WAVE)), encoding="utf-8")
    assert read_signal(path).unit == "m/s"


def test_a_column_of_dates_is_named(tmp_path):
    path = tmp_path / "record.csv"
    path.write_text("timestamp,ax\n" + "2024-03-12T10:00:00.0001,0.5\n" * 50, encoding="utf-8")
    with pytest.raises(InputError, match=r"dates and clock times \(2024-03-12\) are none: leave that column out"):
        read_signal(path)
