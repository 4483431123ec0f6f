"""Scenes and studies, and the files that they name: hostile ones are refused in a sentence, and soon."""

import os
import signal

import pytest

from fem.commands.run_fem import run_main
from fem.commands.run_study import study_main

QUOTE = '"' + ("x" * 900 + "\n") * 300  # a quotation mark that does not close, longer than csv takes
NESTED = "[" * 5000
GIANT = "9" * 400  # more than a float can hold
THOUSANDS = "0x" + "f" * 9000  # whole numbers in hexadecimal have any number of digits
CUT, NO_FILE = "line 2: 1 cells under 2 names", "a pipe or a device, not a plain file"
STUDY = '[sampling]\nmethod = "{}"\n{}\n[fixed]\nmodel = "lagrange"\n[parameters]\n{}\n'
SPEED = '"operation.speed_rpm" = '
GRID = STUDY.format("grid", "", "{}")
LISTED = STUDY.format("list", 'file = "table.csv"', "")
MANY = "\n".join(f'"numerics.key_{i}" = [1]' for i in range(1001))
WIDE = "\n".join(f'"numerics.key_{i}" = {{ from = 1, to = 2 }}' for i in range(11))

SCENES = {  # the scene, the file it names, what must be told
    "heights that are quoted": ('[[profile]]\nfile = "table.csv"\n', "angle_deg,height_um\n" + QUOTE, CUT),
    "speeds that are quoted": ('[operation]\nspeed_table = "table.csv"\n', "time_ms,speed_rpm\n" + QUOTE, CUT),
    "heights in a pipe": ('[[profile]]\nfile = "table.csv"\n', None, NO_FILE),
    "loads in a pipe": ('[operation]\nload_table = "table.csv"\n', None, NO_FILE),
    "heights that never end": ('[[profile]]\nfile = "/dev/zero"\n', None, NO_FILE),
    "thousands of digits": (f"[bearing]\nrollers = {THOUSANDS}\n", None, "rollers = a number of thousands of digits"),
    "10 000 keys": ("\n".join(f"key_{i} = 1" for i in range(10_000)), None, "and 9985 more"),
}  # fmt: skip
STUDIES = {  # the study, its table of points, what must be told
    "a range without end": (GRID.format(f"{SPEED}{{ from = 1, to = {GIANT}, count = 3 }}"), "", ".to = 99"),
    "a mean without end": (GRID.format(f"{SPEED}{{ normal = [{GIANT}, 1] }}"), "", "list of numbers"),
    "a value without end": (GRID.format(f"{SPEED}[{THOUSANDS}]"), "", "thousands of digits is no value"),
    "points of 1001 keys": (GRID.format(MANY), "", "at most 1000"),
    "eleven million numbers": (STUDY.format("lhs", "samples = 1000000", WIDE), "", "points times parameters"),
    "cells that nest": (LISTED, f"operation.speed_rpm\n{NESTED}\n", "operation.speed_rpm = '[[["),
    "cells that are quoted": (LISTED, f"operation.speed_rpm\n{QUOTE}", "table.csv: a row can't be read"),
    "cells without end": (LISTED, f"operation.speed_rpm\n{THOUSANDS}\n", "row 2, operation.speed_rpm = '0xff"),
    "points in a pipe": (LISTED, None, "table.csv: can't be read: a pipe or a device"),
    "a scene in a pipe": ('scene = "table.csv"\n' + GRID.format(f"{SPEED}[1]"), None, "a pipe or a device"),
}  # fmt: skip


@pytest.fixture(autouse=True)
def within_a_minute():
    """Whoever waits for a pipe is woken."""

    def wake(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, wake)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def write(path, text):
    """A file, or a pipe that nobody writes to."""
    if text is None:
        os.mkfifo(path)
    else:
        path.write_text(text, encoding="utf-8")


@pytest.mark.parametrize("kind", [*SCENES, *STUDIES])
def test_a_hostile_file_is_refused_in_a_sentence(kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main, (text, table, words) = (run_main, SCENES[kind]) if kind in SCENES else (study_main, STUDIES[kind])
    write(tmp_path / "given.toml", text)
    write(tmp_path / "table.csv", table)
    assert main(["given.toml", "--dry-run"]) == 2
    out, error = capsys.readouterr()
    assert words in error and len(error) < 20_000 and out == "", error
