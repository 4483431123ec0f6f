"""The check of Lagrange's equations against a simulated or measured run.

record, sources, table_source   `Record`, the arrays all else works on: from a result file, from a table
sampling                        soundness of a record: its interval, its positions, its beginning
differentiate, budget           accelerations; error forces of equations (22) and (23), their terms, laws ranked by them
fitted_laws, load_zone          laws fitted to a run; passages through the load zone, static equilibria
spectrum, lines, orders         spectra over time and over the shaft's angle, levels of kinematic lines
vibration                       vibration of sensor, housing or hub as bearing engineers read it
fault_finding                   spalls found in trajectories alone
evaluation                      the whole check as one call -> `Evaluation`
tables, interpretation, formatting      tables and sentences of the numbers
summary, store, report, figures         summary.json, the report's folder, the terminal and the page, the figures

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

__all__ = ["Evaluation", "InputError", "Record", "evaluate", "read_result", "read_table", "write_report"]


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'residual' has no attribute {name!r}")
    return getattr(import_module(f"residual.{_HOME[name]}"), name)
