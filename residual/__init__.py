"""The check of Lagrange's equations against a simulated or measured run.

record, sources, table_source   `Record`, the arrays all else works on: from a result file, from a table
sampling, stationarity          what of a record is sound: its interval, its positions, its beginning
differentiate, budget           accelerations, error forces of equations (22) and (23) and what they are made of
spectrum, orders, lines         spectra over time and over the shaft's angle, levels of kinematic lines
vibration, cage                 the housing's or the hub's vibration as bearing engineers read it; the cage's share
identification, comparison      laws fitted to a run, laws ranked
fault_finding                   spalls found in trajectories alone, by `roller_motion` and `sinkage_maps`
evaluation                      the whole check as one call -> `Evaluation`; `run_comparison`: of two
interpretation, formatting      what the numbers say: sentences, rows of tables
report, figures, page_data      the self-contained HTML page, its figures, what moves in it
store, summary                  the report's folder, summary.json

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
