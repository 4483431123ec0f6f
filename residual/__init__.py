"""The check of Lagrange's equations against a simulated or measured run.

record          `Record`: the arrays all else works on, and their checks
sources         result file -> `Record`
table_source    trajectory table -> `Record`; `resampling` evens out its steps
differentiate   accelerations by central stencils of high order, with their error floor
sampling        whether samples follow a run's vibration; `position_noise`: rounding and noise of a table's positions
budget          error forces of equations (22) and (23) and what they are made of; `cage`: what of it is the cage's
identification  a contact law fitted to the run's own forces; `comparison` ranks it among the named ones
fitted_laws     laws with coupling between contacts, with damping
spectrum        power spectral density, peaks, kinematic lines
quarters        what varies in each quarter of a record: transients
lines           levels of lines and sidebands; `envelope` spectrum of a band; `short_time` spectra
orders          order tracking: spectra over the shaft's angle where its speed changes
vibration       acceleration of sensor, housing or hub (`measured`): levels, fault lines in its envelope
fault_finding   spalls found in trajectories alone: `roller_motion` what it may see, `three_samples` what rollers do
                between them, `sinkage_maps` by each body's angle; `fault_tables`, `fault_figures`
evaluation      the whole check as one call -> `Evaluation`
figures         a saved figure and its curves; `drawing`: all of them, by groups: `motion_figures`,
                `spectrum_figures`, `vibration_figures`, `passage_figures`, `budget_figures`, `cage_figures`,
                `paper_figures` (beside the ranges of `paper`); `panels` places them, `plotting` and `colours` give
                them one look, `tick_labels` plain numbers; `one_roller`: which, and its motion
quasistatic     the Lagrangian model's equilibria at every angle; `meaning`: what the numbers say of that model
headline        the one sentence that a report begins with; `words`: numbers as a person reads them
tables          rows of the report's and the terminal's tables, with `law_tables`, `line_tables`, `vibration_tables`
report          the self-contained HTML page; `player` and `interactive`: data of its parts that move; `picture`:
                render-fem's
against         two runs, or two laws, beside each other, with `against_figures`
parts           what a report is to hold; `exports`: its data as CSV, MAT and WAV; `printing`: on the terminal
store           residual.nc, summary.json (`summary`), the report folder
cli             the command `check-residual`, which `entry` loads

    from residual import evaluate, read_result, write_report
    write_report(evaluate(read_result("runs/paper.nc"), law="harris"), "report")

Names are loaded when first used, so that the command line starts quickly.
"""

from importlib import import_module

_HOME = {
    "Record": "record",
    "InputError": "errors",
    "read_result": "sources",
    "read_table": "table_source",
    "Evaluation": "evaluation",
    "evaluate": "evaluation",
    "write_report": "store",
}

__all__ = [
    "Evaluation",
    "InputError",
    "Record",
    "evaluate",
    "read_result",
    "read_table",
    "write_report",
]


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'residual' has no attribute {name!r}")
    return getattr(import_module(f"residual.{_HOME[name]}"), name)
