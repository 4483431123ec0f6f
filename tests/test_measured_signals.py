"""Files of all kinds, each read into the same signal or refused in a sentence."""

import io
import resource
import sys
import time
import wave
from contextlib import nullcontext
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from scipy.io import savemat, wavfile

from lagrange.errors import InputError
from lagrange.messages import G
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


def structs(**signals):
    return np.array(list(signals.items()), dtype=[("Name", object), ("Data", object)])


PADERBORN = {  # of the public set: signals and times in structs of their own, some slower
    "X": structs(HostService=TIME, Mech=np.arange(400.0) ** 0.5),
    "Y": structs(force=np.arange(400.0) ** 0.5, vibration_1=WAVE),
}
HEAD = "time_s,acc_g\n"
GERMAN, IN_G = rows(";", ",", "Zeit [s];Beschleunigung [m/s²]\n"), {"unit": "g"}
PLAIN = {  # in g by their own words
    "plain.csv": rows(head=HEAD), "semicolons.csv": rows(";", head="Time;acc [g]\n"),
    "quoted.csv": rows(head='"time","acc [g]"\n'), "tabs.txt": rows("\t", head="time\tacc (g)\n"),
    "tabs_decimal_comma.txt": rows("\t", ",", "time\tacc (g)\n"), "utf16.csv": rows(head=HEAD).encode("utf-16"),
    "mark.csv": b"\xef\xbb\xbf" + rows(head=HEAD).encode(), "crlf.csv": rows(head=HEAD).replace("\n", "\r\n"),
    "trailing.csv": rows(head=HEAD).replace("\n", ",\n"), "units_row.csv": rows(";", ",", "Time;acc\ns;g\n"),
    "milliseconds.csv": rows(head="time [ms],acc [g]\n", columns=(1e3 * TIME, WAVE)),
    "missing_first.csv": rows(head=HEAD + "#N/A,#N/A\n"), "preamble.csv": rows(head="Logger 3\nSensor: A\n\n" + HEAD),
    "rate_in_words.csv": rows(head="Sampling rate: 8 kHz\nacc [g]\n", columns=(WAVE,)),
}  # fmt: skip
READ = {name: (content, {}, G) for name, content in PLAIN.items()} | {  # content, options, factor to m/s²
    "german.csv": (GERMAN, {}, 1.0), "german_latin.csv": (GERMAN.encode("cp1252"), {}, 1.0),
    "blanks.dat": (rows("   ", head="# time acc\n"), IN_G, G), "no_header.csv": (rows(), {"unit": "m/s2"}, 1.0),
    "millimetres.csv": (rows(), {"unit": "mm/s2"}, 1e-3),
    "one_column.txt": (rows(columns=(WAVE,)), {"rate": RATE, "unit": "g"}, G),
    "one_column_comma.txt": (rows(decimal=",", columns=(WAVE,)), {"rate": RATE, "unit": "g"}, G),
    "two_channels.csv": (rows(head="time,x [g],y [g]\n", columns=(TIME, 0 * WAVE, WAVE)), {"channel": "y"}, G),
    "both_units.csv": (rows(head="time_s,y_m_s2,y_g\n", columns=(TIME, WAVE, TIME)), {"channel": "y"}, 1.0),
    "number_of_channel.csv": (rows(head="time,x [g],y [g]\n", columns=(TIME, TIME, WAVE)), {"channel": "2"}, G),
    "volts.csv": (rows(head="time,acc [V]\n"), {"sensitivity": "100 mV/g"}, 10.0 * G),
    **{f"{bits}.wav": (wav(bits), IN_G, 0.5 * G) for bits in (8, 16, 24, 32)},
    "float.wav": (saved(wavfile.write, int(RATE), WAVE.astype(np.float32)), IN_G, G),
    "double_stereo.wav": (saved(wavfile.write, int(RATE), np.column_stack([TIME, WAVE])),
                          IN_G | {"channel": "channel 2"}, G),
    "five.mat": (saved(savemat, {"X097_DE_time": WAVE[:, None], "fs": RATE}), IN_G, G),
    "struct.mat": (saved(savemat, {"fs": 3.0, "bearing": {"load": 3.0, "gs": WAVE, "rate": RATE, "note": "x"}}),
                   IN_G, G),
    "mfpt.mat": (saved(savemat, {"bearing": {"rate": 25.0, "sr": RATE, "gs": WAVE}}), IN_G, G),
    "step.mat": (saved(savemat, {"b": {"increment": 1.0 / RATE, "values": WAVE, "Name": "acc x"}}),
                 IN_G | {"channel": "acc x"}, G),
    "paderborn.mat": (saved(savemat, {"b": PADERBORN}), IN_G | {"channel": "vibration_1"}, G),
    "four.mat": (saved(savemat, {"a": WAVE}, format="4"), IN_G | {"rate": RATE}, G),
    "seven.mat": (matlab73(acc=WAVE[None, :], fs=[[RATE]]), IN_G, G),
    "seven_struct.mat": (matlab73(**{"run/acc": WAVE[None, :], "run/fs": [[RATE]]}), IN_G, G),
    "x.npy": (saved(np.save, WAVE), {"rate": RATE, "unit": "g"}, G),
    "x.npz": (saved(np.savez, acc=WAVE, rate=RATE), IN_G, G),
    "whole.npz": (saved(np.savez_compressed, acc=np.round(1000 * WAVE).astype("i2"), fs=8000), {"unit": "mg"}, G),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_file_is_read_into_the_signal_that_was_written(name, tmp_path):
    content, options, factor = READ[name]
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    signal = read_signal(path, **options)
    assert signal.rate == pytest.approx(RATE, rel=1e-6) and signal.unit == "m/s²"
    coarse = 0.02 if name == "8.wav" else 1e-3 if name == "whole.npz" else 2e-4
    np.testing.assert_allclose(signal.values, factor * (WAVE - WAVE.mean()), rtol=0.0, atol=coarse * factor)


REFUSED = {  # name: content, options, words of the refusal
    "words.csv": ("a,b\nc,d\n", {}, "no rows of numbers"), "empty.csv": ("\n", {}, "empty"),
    "no_rate.txt": (rows(columns=(WAVE,)), {}, "--rate"),
    "two_rates.mat": (saved(savemat, {"b": {"sr": RATE, "gs": WAVE, "fs": 1e3}}), {}, "states 1000 or 8000 Hz; give"),
    "two_rates.txt": (rows(head="fs = 8000\nSampling rate: 1 kHz\nacc\n", columns=(WAVE,)), {}, "states 1000 or 8000"),
    "two_times.csv": (rows(head="t [s],a,time [s],b\n", columns=(TIME, WAVE, 2.0 * TIME, WAVE)), {"channel": "b"},
                      "2 columns of times with different steps; give --rate"),
    "spectrum.csv": (rows(head="Frequency [Hz],acc [g]\n", columns=(RATE * TIME, WAVE)),
                     {"rate": RATE, "channel": "acc"}, "a spectrum over Frequency"),
    "no_time.csv": (rows(head=HEAD).replace("\n0.", "\n#N/A,0.1\n0.", 3), {}, "line 2 has no time"),
    "thousand_of_many.csv": (rows(";", ",", HEAD.replace(",", ";")) + "0,3;1.234\n", {}, "line 2002: acc_g = '1.234'"),
    "which.csv": (rows(head="time,x,y\n", columns=(TIME, WAVE, WAVE)), {}, "add --channel"),
    "none_such.csv": (rows(head="time,x,y\n", columns=(TIME, WAVE, WAVE)), {"channel": "z"}, "no channel"),
    "broken.csv": (rows(head=HEAD) + "0.3,abc\n", {}, "'abc' is no number"),
    "ragged.csv": (rows(head=HEAD) + "0.3,1,2\n", {}, "3 cells"),
    "far.csv": (rows(head=HEAD, columns=(1e200 * TIME, WAVE), digits="%.6e"), {}, "which no record has"),
    "short.csv": (rows(head=HEAD, columns=(TIME[:500], WAVE[:500])), {}, "at least 1024"),
    "silent.csv": (rows(head=HEAD, columns=(TIME, 1e-300 * WAVE), digits="%.12e"), {}, "constant"),
    "constant.csv": (rows(head=HEAD, columns=(TIME, 0.0 * WAVE)), {}, "constant"),
    "volts.csv": (rows(head=HEAD), {"unit": "V"}, "--sensitivity"),
    "unit.csv": (rows(head=HEAD), {"unit": "furlong"}, "known are g"),
    "book.xlsx": (saved(np.savez, a=1).replace(b".npy", b".xml"), {}, "workbook"), "cut.wav": (wav(16)[:30], {}, "WAV"),
    "cut.mat": (saved(savemat, {"a": WAVE})[:200], {}, "MATLAB"), "cut73.mat": (matlab73(acc=WAVE)[:700], {}, "7.3"),
    "words.mat": (saved(savemat, {"a": "words"}), {}, "without a signal"),
    "cut.npy": (saved(np.save, WAVE)[:300], {"rate": RATE}, "NPY"),
    "objects.npy": (saved(np.save, np.array([{}], dtype=object)), {"rate": RATE}, "NPY"),
    "a.parquet": (b"PAR1" + bytes(100), {}, "pip install pyarrow"),
    "a.tdms": (b"TDSm" + bytes(100), {}, "pip install nptdms"),
    "a.unv": ("    -1\n    58\nx\n", {}, "pip install pyuff"),
    "random.bin": (bytes(range(256)) * 20, {"rate": RATE}, "not UTF-8 text"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_file_is_refused_in_a_sentence(name, tmp_path, monkeypatch):
    for package in ("pyarrow.parquet", "nptdms", "pyuff"):
        monkeypatch.setitem(sys.modules, package, None)
    content, options, words = REFUSED[name]
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError, match=words.replace("(", r"\(")) as refusal:
        read_signal(path, **options)
    assert "Traceback" not in str(refusal.value) and "\n" not in str(refusal.value)


def signal_of(tmp_path, text, **options):
    (tmp_path / "record.csv").write_text(text, encoding="utf-8")
    return read_signal(tmp_path / "record.csv", **options)


def told(tmp_path, values, time=TIME):
    return signal_of(tmp_path, rows(head=HEAD, columns=(time, values)).replace("nan", ""))


def test_faults_of_a_record_are_told_and_its_longest_piece_is_taken(tmp_path):
    dropped = np.where((np.arange(2000) >= 500) & (np.arange(2000) < 580), WAVE[500], WAVE)
    faulty = {"saturated": np.clip(WAVE, -0.7, 0.7), "was removed": WAVE + 5.0, "drops out 1 times": dropped}
    for note, values in {"": WAVE, **faulty}.items():
        signal = told(tmp_path, values)
        assert (note in signal.notes[0] if note else signal.notes == ()) and abs(signal.values.mean()) < 1e-9
    # the longest piece between missing samples is taken, and a gap in time does not change the rate
    values = WAVE.copy()
    values[[100, 101, 1900]] = np.nan
    signal = told(tmp_path, values)
    assert "3 samples without a number" in signal.notes[0]
    np.testing.assert_allclose(signal.values, G * (WAVE[102:1900] - WAVE[102:1900].mean()), atol=1e-4)
    signal = told(tmp_path, WAVE, np.where(np.arange(2000) < 300, TIME, TIME + 0.1))
    assert "1 gap in time" in signal.notes[0] and signal.values.size == 1700
    assert signal.rate == pytest.approx(RATE, rel=1e-4)


@pytest.mark.parametrize("missing", ["", "#N/A", "% an event", "# an event"])
def test_a_line_without_a_number_is_a_missing_sample_but_not_between_rows_with_times(tmp_path, missing):
    lines = rows(columns=(WAVE,)).splitlines()
    lines[500] = missing
    signal = signal_of(tmp_path, "acc [g]\n" + "\n".join(lines), rate=RATE)
    assert signal.values.size == 1499 and "1 sample without a number (the first: line 502)" in signal.notes[0]
    lines[1:-1:3] = [missing] * len(lines[1:-1:3])
    with pytest.raises(InputError, match=r"[23] samples in one piece; .* 667 samples without"):
        signal_of(tmp_path, "acc [g]\n" + "\n".join(lines), rate=RATE)
    signal = signal_of(tmp_path, rows(head=HEAD).replace("\n", "\n\n"))
    assert signal.values.size == 2000 and signal.rate == pytest.approx(RATE) and signal.notes == ()


def test_a_given_rate_decides_with_a_note_and_no_file_marks_of_thousands_and_dates_in_numbers_are_refused(tmp_path):
    signal = signal_of(tmp_path, rows(head=HEAD), rate=9000.0)
    assert signal.rate == 9000.0 and signal.notes == ("The file says 8000 Hz; --rate 9000 Hz was taken.",)
    with pytest.raises(InputError, match="No such file"):
        read_signal(tmp_path / "none.csv")
    values = "\n".join(f"{5000.0 * x:,.0f}" for x in WAVE)
    dates = "timestamp,ax\n" + "2024-03-12T10:00:00.0001,0.5\n" * 50
    thousands = "with a mark of thousands; write numbers without"
    dated = r"dates and clock times \(2024-03-12\) are none: leave that column out"
    for text, words in ((values, thousands), (values.replace(",", "."), thousands), (dates, dated)):
        with pytest.raises(InputError, match=words):
            signal_of(tmp_path, text, rate=RATE)


class Channel(np.ndarray):
    """A channel of a TDMS file as nptdms gives it."""

    group_name = "rig"


def universal(function, step, values=WAVE, axis=0):
    """A data set 58 as pyuff gives it."""
    return {"type": 58, "func_type": function, "abscissa_spacing": 1, "abscissa_inc": step, "data": values,
            "abscissa_spec_data_type": axis, "id1": "acc"}  # fmt: skip


def test_channels_of_other_programs_have_their_own_rates_and_spectra_are_none(tmp_path, monkeypatch):
    """By stand-ins for optional packages."""
    both = slow, fast = WAVE[:1500].view(Channel), WAVE.view(Channel)
    slow.name, fast.name = "slow", "fast"
    slow.properties, fast.properties = {"wf_increment": 1.0 / 500.0}, {"wf_increment": 1.0 / RATE}
    opened = SimpleNamespace(groups=lambda: [SimpleNamespace(channels=lambda: both)])
    tdms = SimpleNamespace(TdmsFile=SimpleNamespace(open=lambda path: nullcontext(opened)))
    monkeypatch.setitem(sys.modules, "nptdms", tdms)
    (tmp_path / "a.tdms").write_bytes(b"TDSm" + bytes(99))
    assert read_signal(tmp_path / "a.tdms").rate == RATE  # the longest, if none is named
    assert read_signal(tmp_path / "a.tdms", channel="slow").rate == 500.0
    sets = [universal(2, 0.5), universal(1, 1e-3), universal(0, 1.0 / RATE, axis=17), universal(0, 0.5, axis=18)]
    pyuff = SimpleNamespace(UFF=lambda path: SimpleNamespace(read_sets=lambda: sets))
    monkeypatch.setitem(sys.modules, "pyuff", pyuff)
    (tmp_path / "a.unv").write_bytes(b"    -1\n    58\n")
    assert read_signal(tmp_path / "a.unv", channel="2 acc").rate == 1000.0
    assert read_signal(tmp_path / "a.unv", channel="3 acc").rate == pytest.approx(RATE)
    with pytest.raises(InputError, match="there are: 1 2 acc, 2 3 acc"):
        read_signal(tmp_path / "a.unv", channel="1 acc")
    del sets[1:3]
    with pytest.raises(InputError, match="2 data sets, none of them over time"):
        read_signal(tmp_path / "a.unv", rate=RATE)
    # as each of a MATLAB file has rate, times and unit of its own struct
    runs = {"a": {"x": WAVE, "fs": RATE, "unit": "g"}, "b": {"x": WAVE, "fs": 1000.0}, "c": {"x": WAVE, "t": TIME}}
    savemat(tmp_path / "runs.mat", runs | {"d": {"x": WAVE, "t": 10.0 * TIME, "units": "mm/s"}})
    found = [read_signal(tmp_path / "runs.mat", channel=f"{name}.x") for name in "abcd"]
    np.testing.assert_allclose([signal.rate for signal in found], [RATE, 1000.0, RATE, 0.1 * RATE])
    assert [signal.unit for signal in found] == ["m/s²", "", "", "m/s"]


COLUMN = rows(columns=(WAVE,))
HOSTILE = {
    "words of a rate": ("freq" * 24_000 + "\n" + COLUMN, "neither a rate"),
    "brackets": ("(" * 90_000 + "\n" + COLUMN, "neither a rate"),
    "line ends": ("    -1\n" + "\n" * 200_000 + COLUMN, "neither a rate"),
    "cells": (("1.5," * 49_999 + "2\n") * 260, "a line of more than 100000 characters"),
    "short cells": (("1," * 49_999 + "2\n") * 260, "no rows of numbers"),
    "lines": (b"1\n" * 50_000_000, "numbers; cut it into parts"),
    "packed": (saved(np.savez_compressed, x=np.zeros(600 << 20, np.int8)), "unpacks to more than 512 MiB"),
    "whole numbers": (saved(np.savez_compressed, x=np.zeros(60 << 20, np.int8)), "at most 33554432 are read"),
}  # fmt: skip


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_record_is_refused_soon_and_in_little_memory(kind, tmp_path):
    content, words = HOSTILE[kind]
    path = tmp_path / "record"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    began, held = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(InputError, match=words):
        read_signal(path)
    assert time.process_time() - began < 10.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - held < 1e6  # kB


STATED = {
    "Sampling rate: 8 kHz": 8000.0, "Abtastrate;8000 Hz": 8000.0, "# fs=8000": 8000.0, "Sample rate [kHz]: 8": 8000.0,
    "Sampling frequency (Hz),8000": 8000.0, "fs = 8000 Hz, speed 1480 rpm": 8000.0, "Sampling rate: 25,600 Hz": 25600.0,
    "Sampling rate: 1,024.5 Hz": 1024.5, "Sampling rate: 48.828 kHz": 48828.0, "Sampling rate: 25,6 kHz": 25600.0,
    "Frequency range: 10 kHz\nSampling rate: 8 kHz": 8000.0,
}  # fmt: skip


def test_rate_before_the_numbers_frequencies_that_are_none_and_names_of_channels(tmp_path):
    """A whole word of a name goes before a part, and a unit may stand behind."""
    for line, rate in STATED.items():
        assert signal_of(tmp_path, rows(head=f"{line}\nacc [g]\n", columns=(WAVE,))).rate == rate, line
    for line in ("Shaft frequency: 25 Hz", "Drehfrequenz: 25 Hz", "Samples: 2000", "cut-off frequency 5 kHz"):
        with pytest.raises(InputError, match="neither a rate nor a column of times"):
            signal_of(tmp_path, rows(head=f"{line}\nacc [g]\n", columns=(WAVE,)))
    text = rows(head="time_s,band A,band B\n", columns=(TIME, WAVE, 2.0 * WAVE))
    a, b = (signal_of(tmp_path, text, channel=name).values.std() for name in "AB")
    assert b == pytest.approx(2.0 * a)
    assert signal_of(tmp_path, rows(head="time_s,velocity_mm/s\n", columns=(TIME, WAVE))).unit == "m/s"
