"""What check-residual prints: a short table and the most telling sentences."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from lagrange.messages import shown
from residual.evaluation import Evaluation
from residual.formatting import hertz
from residual.interpretation import verdict
from residual.run_comparison import difference_rows, headings
from residual.summary import ReportOptions
from residual.tables import error_rows, fit_sentences, peak_name, ranking_rows, ranking_span, watched_rows
from residual.vibration_tables import search_sentences


def print_summary(evaluation: Evaluation, folder: Path, options: ReportOptions, compare_laws: bool) -> None:
    """Print what was found, and where the report is."""
    console = Console(highlight=False)
    if options.equations:
        _print_errors(console, evaluation)
    if options.search is not None:
        for sentence in search_sentences(options.search):
            console.print(sentence, soft_wrap=True, markup=False)
    if compare_laws:
        _print_laws(console, evaluation)
    if options.other is not None:
        _print_differences(console, evaluation, options.other, options.equations)
    console.print(verdict(evaluation, options.tolerance, options.equations), soft_wrap=True)
    console.print(f"Report: {shown(folder / 'report.html')}", soft_wrap=True, markup=False)


def _print_errors(console: Console, evaluation: Evaluation) -> None:
    """Print the error forces, their peaks and what a fitted law is worth."""
    table = Table(title=f"Residual of {shown(evaluation.record.name)}", title_justify="left")
    table.add_column("N")
    for heading in ("mean", "rms", "std", "largest"):
        table.add_column(heading, justify="right")
    for row in error_rows(evaluation):
        table.add_row(*row)
    console.print(table)
    low, high = evaluation.loaded_range
    console.print(f"Loaded rollers: {low} to {high}")
    for direction in evaluation.directions:
        found = [
            f"{hertz(p.frequency)} ({_told(peak_name(p))}{'' if p.resolved else ', not resolved'})"
            for p in direction.peaks[:4]
        ]
        console.print(f"Peaks of error_{direction.name}: {'; '.join(found) or 'none stands out'}", soft_wrap=True)
    for name, rms_x, rms_y, background, resolved in watched_rows(evaluation):
        told = "" if resolved == "yes" else ", not resolved"
        console.print(f"{name}: {rms_x} N rms in x, {rms_y} in y (background {background}){told}", soft_wrap=True)
    for sentence in fit_sentences(evaluation):
        console.print(sentence, soft_wrap=True, markup=False)


def _told(name: str) -> str:
    return "no line" if name == "-" else name


def _print_laws(console: Console, evaluation: Evaluation) -> None:
    """Print the ranking of the contact laws."""
    span = f"{ranking_span(evaluation)}; contact: rms per contact"
    table = Table(title="Error force by contact law, N", title_justify="left", caption=span)
    table.add_column("law", no_wrap=True)
    for heading in ("mean x", "rms x", "mean y", "rms y", "contact"):
        table.add_column(heading, justify="right")
    for row in ranking_rows(evaluation):
        table.add_row(*row)
    console.print(table)


def _print_differences(console: Console, evaluation: Evaluation, other: Evaluation, equations: bool) -> None:
    """Print two checks beside each other."""
    table = Table(title="Beside each other", title_justify="left")
    table.add_column("")
    for heading in map(shown, headings(evaluation, other)):
        table.add_column(heading, justify="right")
    for row in difference_rows(evaluation, other, equations):
        table.add_row(*row)
    console.print(table)
