"""Summary on the terminal: a short table and the most important sentences."""

from collections.abc import Iterable
from pathlib import Path

from rich.console import Console
from rich.table import Table

from lagrange.messages import shown
from residual.evaluation import Evaluation
from residual.formatting import hertz
from residual.interpretation import contradiction_sentence, verdict
from residual.run_comparison import difference_rows, headings, same_run
from residual.summary import ReportOptions
from residual.tables import error_rows, fit_sentences, peak_name, ranking_rows, ranking_span, watched_rows
from residual.vibration_tables import line_differences, search_sentences

ERROR_COLUMNS = ("N", "mean", "rms", "std", "largest")
LAW_COLUMNS = ("law", "mean x", "rms x", "mean y", "rms y", "contact")


def print_summary(evaluation: Evaluation, folder: Path, options: ReportOptions, compare_laws: bool) -> None:
    """Print the findings, and where the report is."""
    console, other = Console(highlight=False), options.other
    if words := contradiction_sentence(evaluation):
        console.print(words, soft_wrap=True, markup=False)
    if options.equations:
        _print_errors(console, evaluation)
    if options.search is not None:
        for sentence in search_sentences(options.search):
            console.print(sentence, soft_wrap=True, markup=False)
    if compare_laws:
        span = f"{ranking_span(evaluation)}; contact: rms per contact"
        _print_table(console, "Error force by contact law, N", LAW_COLUMNS, ranking_rows(evaluation), caption=span)
    if other is not None:
        names = ("", *map(shown, headings(evaluation, other)))
        _print_table(console, "Beside each other", names, difference_rows(evaluation, other, options.equations))
        if not same_run(evaluation, other):
            title = f"Vibration of the {evaluation.y.vibration.body}, lines of its envelope"
            columns = ("", *names[1:3], "difference, dB")
            _print_table(console, title, columns, line_differences(evaluation, other))
    console.print(verdict(evaluation, options.tolerance, options.equations), soft_wrap=True)
    console.print(f"Report: {shown(folder / 'report.html')}", soft_wrap=True, markup=False)


def _print_table(console: Console, title: str, columns: Iterable[str], rows: list[list[str]], caption=None) -> None:
    """Print a table of names at the left and numbers at the right."""
    table = Table(title=title, title_justify="left", caption=caption)
    for i, column in enumerate(columns):
        table.add_column(column, justify="right" if i else "left", no_wrap=column == "law")
    for row in rows:
        table.add_row(*row)
    console.print(table)


def _print_errors(console: Console, evaluation: Evaluation) -> None:
    """Print the error forces, their peaks and what a fitted law is worth."""
    _print_table(console, f"Residual of {shown(evaluation.record.name)}", ERROR_COLUMNS, error_rows(evaluation))
    low, high = evaluation.loaded_range
    console.print(f"Loaded rollers: {low} to {high}")
    for direction in evaluation.directions:
        found = []
        for peak in direction.peaks[:4]:
            name = peak_name(peak)
            label = ("no line" if name == "-" else name) + ("" if peak.resolved else ", not resolved")
            found.append(f"{hertz(peak.frequency)} ({label})")
        console.print(f"Peaks of error_{direction.name}: {'; '.join(found) or 'none stands out'}", soft_wrap=True)
    for name, rms_x, rms_y, background, resolved in watched_rows(evaluation):
        note = "" if resolved == "yes" else ", not resolved"
        console.print(f"{name}: {rms_x} N rms in x, {rms_y} in y (background {background}){note}", soft_wrap=True)
    for sentence in fit_sentences(evaluation):
        console.print(sentence, soft_wrap=True, markup=False)
