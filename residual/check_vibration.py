"""The command `check-vibration`. Imports little: everything heavy waits until a record is read."""

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lagrange.commands import entry, new_app, run_app_main
from lagrange.errors import InputError
from residual.measured import Question

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
    record: Path, /, *more: Path, question: Annotated[Question | None, Parameter(name="*")] = None,
    against: Path | None = None, healthy: Path | None = None, output: Path | None = None, no_figures: bool = False,
    quiet: bool = False,
) -> int:  # fmt: skip
    """
    Args:
        record: vibration record, or result file of run-fem
        more: further records of a series, in order of time: shows the trend
        against: compare with another record, a result file, or a scene to simulate
        healthy: a record from when the bearing was healthy: lines that were there do not accuse
        output: folder; default: <record>-vibration next to the record
        no_figures: draw no figures
        quiet: print nothing
    """
    from lagrange.messages import telling
    from residual.measured import checks
    from residual.store import check_replaceable

    if record.is_dir():
        raise InputError(f"{record}: is a folder; give the path of a record")
    folder = output or record.with_name(f"{record.stem}-{'trend' if more else 'vibration'}")
    check_replaceable(folder, app.name[0])
    if against is not None and (more or healthy is not None):
        raise InputError("--against: only with one record, and without --healthy, which is compared with too")
    asked = question or Question()
    found: checks.Check | checks.Trend = (
        checks.trend_of((record, *more), asked, healthy)
        if more
        else checks.check_record(record, against, asked, healthy)
    )
    checks.write_report(found, folder, not no_figures)
    if not quiet:
        with telling():
            checks.print_report(found, folder)
    return 0


main = partial(run_app_main, app)


if __name__ == "__main__":
    entry(main)()
