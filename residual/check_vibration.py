"""The command `check-vibration`. Imports little: everything heavy waits until a record is read."""

from functools import partial
from math import radians
from pathlib import Path

from lagrange.commands import entry, new_app, run_app_main
from lagrange.errors import InputError

app = new_app(
    "check-vibration",
    """Diagnose a bearing from a vibration record: damage of outer ring, inner ring or rolling element.

Reads CSV, WAV, MATLAB, NPY, NPZ and result files of run-fem; UFF58, TDMS and Parquet need further packages. Writes a
folder with vibration.html, figures and summary.json.

Example: check-vibration record.csv --bearing NU206 --speed 1480 --speed-tolerance 2%
         check-vibration monday.csv tuesday.csv wednesday.csv --bearing NU206 --speed 1480

Exit codes: 0 done, whatever the verdict; 2 unusable input; 130 interrupted; 143 terminated.
""",
)


@app.default
def _command(
    record: Path, /, *more: Path, rate: float | None = None, channel: str | None = None, unit: str | None = None,
    sensitivity: str | None = None, bearing: str | None = None, scene: Path | None = None, elements: int | None = None,
    element_diameter: float | None = None, pitch_diameter: float | None = None, contact_angle: float = 0.0,
    speed: float | None = None, speed_tolerance: str = "1%", against: Path | None = None, output: Path | None = None,
    no_figures: bool = False, quiet: bool = False,
) -> int:  # fmt: skip
    """
    Args:
        record: vibration record, or result file of run-fem
        more: further records of a series, in order of time: shows the trend
        rate: sampling rate, Hz; default: the record's own
        channel: name, part of a name, or number of the channel
        unit: g, m/s2, mm/s, or V with --sensitivity; default: the file's
        sensitivity: sensitivity of a record in volts: 100mV/g
        bearing: standard bearing: NU206
        scene: scene file (TOML) of the bearing; its speed is the default
        elements: another bearing: number of rolling elements
        element_diameter: diameter of its rolling elements, mm
        pitch_diameter: its pitch diameter, mm
        contact_angle: its contact angle, degrees
        speed: speed of the shaft, rpm
        speed_tolerance: uncertainty of the speed, per cent
        against: compare with another record (e.g. of the healthy bearing), a result file, or a scene to simulate
        output: folder; default: <record>-vibration next to the record
        no_figures: draw no figures
        quiet: print nothing
    """
    from lagrange.messages import telling
    from residual.measured import checks
    from residual.store import check_replaceable

    try:
        tolerance = 1e-2 * float(speed_tolerance.strip().removesuffix("%"))
    except ValueError:
        raise InputError(f"--speed-tolerance {speed_tolerance}: must be a number of per cent, as 2%") from None
    question = checks.Question(
        bearing=bearing, scene=scene, elements=elements, element_diameter=element_diameter,
        pitch_diameter=pitch_diameter, contact_angle=radians(contact_angle), speed=speed, tolerance=tolerance,
        rate=rate, channel=channel, unit=unit, sensitivity=sensitivity)  # fmt: skip
    if record.is_dir():
        raise InputError(f"{record}: is a folder; give the path of a record")
    ending = "trend" if more else "vibration"
    folder = output if output is not None else record.with_name(f"{record.stem}-{ending}")
    check_replaceable(folder, app.name[0])
    if more and against is not None:
        raise InputError("--against: only with one record; a series is compared with itself")
    if more:
        trend = checks.trend_of((record, *more), question)
        checks.write_trend(trend, folder, not no_figures)
    else:
        check = checks.check_record(record, against, question)
        checks.write_check(check, folder, not no_figures)
    if not quiet:
        with telling():
            checks.print_trend(trend, folder) if more else checks.print_check(check, folder)
    return 0


main = partial(run_app_main, app)


if __name__ == "__main__":
    entry(main)()
