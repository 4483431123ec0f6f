"""The command `check-residual`. Imports little: everything heavy waits until a run is read."""

from functools import partial
from pathlib import Path
from typing import Literal

from lagrange.commands import entry, new_app, run_app_main
from lagrange.errors import InputError

RUNS = Path("runs")

app = new_app(
    "check-residual",
    """Put a run's trajectories into Lagrange's equations (22) and (23) and report the residual.

Writes a folder with report.html, figures, residual.nc and summary.json.

Example: check-residual runs/paper.nc --law harris --start 5

Exit codes: 0 done; 1 the verdict is "fails" (--tolerance); 2 unusable input; 130 interrupted; 143 terminated.
""",
)


@app.default
def _command(
    run: Path | None = None, /, *, output: Path | None = None, scene: Path | None = None, resample: bool = False,
    kinematic_rollers: bool = False, law: str | None = None, start: float | None = None, line: tuple[str, ...] = (),
    order: Literal[4, 6, 8] = 6, band: str | None = None, tolerance: float | None = None, find_faults: bool = False,
    no_figures: bool = False, no_equations: bool = False, against: str | None = None, export: tuple[str, ...] = (),
    compare_laws: bool = False, quiet: bool = False,
) -> int:  # fmt: skip
    """
    Args:
        run: result file of run-fem, or a CSV or MATLAB table; default: newest runs/*.nc
        output: report folder; default: <run>-residual next to the run
        scene: scene file (TOML); needed for a table, see docs/tables.md
        resample: resample a table to equal time steps
        kinematic_rollers: for a table with only the hub's orbit: rollers roll without slip
        law: contact law: harris, palmgren, iso16281, braendlein, johnson, houpert, teutsch_sauer; hertz (balls); or
            fitted, fitted_damped (to the first half of the run's forces); default: the scene's, harris or hertz
        start: time to skip, ms; default: the load ramp, if any
        line: report this line; repeatable: BPFO, 2xBPFO, BPFO-shaft, or a frequency in Hz
        order: order of the finite differences
        band: band of the envelope spectrum, Hz: 2000-8000; default: 3 BPFI to 50 kHz
        tolerance: largest error force, N rms; exit 1 above it
        find_faults: search for spalls: ring or roller, angle, width
        no_figures: no figures (much faster)
        no_equations: report on the run without the error forces of (22), (23)
        against: compare with another result file, table or contact law
        export: csv: also write the signals as signals.csv
        compare_laws: print the error force of every law, ranked
        quiet: print no summary
    """
    from lagrange.contact.laws import law_names
    from lagrange.messages import say, telling
    from lagrange.scene.scene import read_scene
    from residual import fault_finding, sources
    from residual.evaluation import evaluate
    from residual.laws import ALIASES, FITTED
    from residual.report import PROGRAM, ReportOptions, print_summary, write_report
    from residual.store import check_replaceable

    for kind in export:
        if kind != "csv":
            raise InputError(
                f"--export {kind}: only csv is written; MATLAB reads residual.nc and result files by ncread, "
                "render-fem --export writes the hub's sound, and figures stand in the report as SVG"
            )
    for option, value, unit in (("--start", start, "ms"), ("--tolerance", tolerance, "N")):
        if value is not None and not 0.0 <= value < float("inf"):
            raise InputError(f"{option} {value:g}: must be a number of {unit} >= 0")
    seconds, limits = None if start is None else 1e-3 * start, None
    if band is not None:
        low, _, high = band.partition("-")
        try:
            limits = float(low), float(high)
        except ValueError:
            limits = 0.0, 0.0
        if not 0.0 < limits[0] < limits[1] < float("inf"):
            raise InputError(f"--band {band}: must be two rising frequencies in Hz, as 2000-8000")
    if run is None:
        newest = sorted(RUNS.glob("*.nc"), key=lambda p: p.stat().st_mtime)
        if not newest:
            raise InputError(f"no *.nc in {RUNS.resolve()}; run run-fem first, or name a result file")
        run = newest[-1]

    def read(path):
        """A result file, or a table by its scene; and the names of the laws of its bearing."""
        given = None if scene is None else read_scene(scene)
        if not path.is_file() or sources.is_result(path):
            record = sources.read_result(path)
            for option, asked in (("--kinematic-rollers", kinematic_rollers), ("--resample", resample)):
                if asked:
                    raise InputError(f"{option}: only for tables; {path} is a result file")
            own = record.scene
            if given is not None and (given.bearing, given.operation) != (own.bearing, own.operation):
                raise InputError(
                    f"--scene {scene}: its bearing or operation differs from the scene inside {path}; leave --scene out"
                )
        elif given is None:
            raise InputError(f"{path}: a trajectory table needs its scene: add --scene SCENE.toml")
        else:
            record = sources.read_table(path, given, resample, kinematic_rollers)
        known = [*law_names(record.bearing), *FITTED]
        if law is not None and law not in (*known, *ALIASES):
            raise InputError(f"--law {law}: unknown; known are {', '.join(known)}")
        return record, known

    record, known = read(run)
    folder = output if output is not None else run.with_name(f"{run.stem}-residual")
    check_replaceable(folder, PROGRAM)
    compared, its_law, other = None, law, None
    if against in (*known, *ALIASES):
        compared, its_law = record, against
    elif against is not None:
        if not Path(against).exists():
            raise InputError(f"--against {against}: neither a file nor a contact law; laws are {', '.join(known)}")
        compared, _ = read(Path(against))
    if no_equations and compared is not None and compared.source == record.source:
        raise InputError(
            f"--against {against}: laws differ only in the error forces, which --no-equations leaves out; leave out "
            "one of the two"
        )
    evaluation = evaluate(record, law, seconds, order, line, limits, compare_laws)
    search = fault_finding.find_faults(evaluation.record) if find_faults else None
    for note in evaluation.notes:
        say(f"warning: {run}: {note}")
    if compared is not None:
        other = evaluate(compared, its_law, seconds, order, band=limits)
    options = ReportOptions(
        tolerance=tolerance, search=search, figures=not no_figures, equations=not no_equations, signals=bool(export),
        other=other)  # fmt: skip
    write_report(evaluation, folder, options)
    if not quiet:
        with telling():
            print_summary(evaluation, folder, options, compare_laws)
    return 1 if evaluation.outcome(tolerance) == "fails" else 0


main = partial(run_app_main, app)

if __name__ == "__main__":
    entry(main)()
