"""The check of Lagrange's equations against a simulated or measured run.

record, sources                 `Record`, the arrays all else works on: from a result file, from a table
sampling                        soundness of a record: its interval, its positions, its beginning
laws, budget                    laws, fitted ones too; error forces of equations (22) and (23), their terms and ranking
load_zone                       passages through the load zone, static equilibria, pressures along rollers
spectrum                        derivatives and spectra of signals
vibration                       lines over time and the shaft's angle; vibration as bearing engineers read it
fault_finding                   spalls found in trajectories alone
evaluation                      the whole check as one call -> `Evaluation`
findings, formatting            tables and sentences of the numbers
report, figures, store          summary.json, page and terminal; figures; folders that appear whole or not at all

    from residual import evaluate, read_result, write_report
    write_report(evaluate(read_result("runs/paper.nc"), law="harris"), "report")

Names are loaded when first used, so that the command line starts quickly.
"""

from importlib import import_module

_HOME = {
    "Record": "residual.record", "InputError": "lagrange.errors", "read_result": "residual.sources",
    "read_table": "residual.sources", "Evaluation": "residual.evaluation", "evaluate": "residual.evaluation",
    "write_report": "residual.report"}  # fmt: skip

__all__ = ["Evaluation", "InputError", "Record", "evaluate", "read_result", "read_table", "write_report"]


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'residual' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
