"""What rate-bearing prints, its JSON file, and rating.html: one file, to be opened anywhere."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from fem.rating.answers import Answer, Rating
from lagrange.files.output import write_whole
from lagrange.files.pages import load_matplotlib, render_page
from lagrange.messages import shown
from lagrange.version import VERSION

ON_PAPER = {"N/m": (1e-6, "N/µm")}  # units that engineers read
BULKY = "stiffness_harmonics_N_per_m", "roller_loads_N", "contacts"  # in the file and on the page


def write_json(path: Path, rating: Rating) -> None:
    """The answers, with reasons and sources; OSError."""
    text = json.dumps(rating.to_json(), indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(path, (text + "\n").encode())


def in_words(answer: Answer) -> str:
    """A value with its unit for people, or why there is none."""
    if answer.value is None:
        return f"none: {answer.reason}"
    factor, unit = ON_PAPER.get(answer.unit, (1.0, "" if answer.unit == "1" else answer.unit))
    return f"{_number(answer.value, factor)} {unit}".rstrip()


def _number(value: Any, factor: float) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, dict):
        return ", ".join(f"{name} {_number(each, factor)}" for name, each in value.items())
    if value is None:
        return "none"
    if np.ndim(value) == 0:
        scaled = factor * float(value)
        return f"{scaled:.4g}" if abs(scaled) < 1e4 or abs(scaled) >= 1e7 else f"{scaled:.0f}"
    if np.ndim(value) == 3:
        return " to ".join(_number(each, factor) for each in value)
    if np.shape(value) == (2, 2):
        return "; ".join(", ".join(_number(each, factor) for each in _rounded(row, value)) for row in value)
    return ", ".join(_number(each, factor) for each in _rounded(value, value))


def _rounded(values: Any, all_values: Any) -> np.ndarray:
    """Values with 0 in place of the round-off of what symmetry makes 0."""
    return np.where(np.abs(values) < 1e-9 * np.max(np.abs(all_values)), 0.0, values)


def print_rating(rating: Rating) -> None:
    """A table of what could be computed, what could not with its reason, then warnings."""
    console = Console(highlight=False)
    console.print(f"Rating of {shown(rating.name)}", style="italic", markup=False)
    table, missing = Table(box=None, pad_edge=False, show_header=False), dict[str, list[str]]()
    for answer in rating.answers:
        if answer.value is None:
            missing.setdefault(answer.reason, []).append(answer.name)
        elif answer.name not in BULKY:
            source = answer.source.name + (" †" if answer.source.second_hand else "")
            table.add_row(*(escape(shown(cell)) for cell in (answer.meaning, in_words(answer), source)))
    console.print(table)
    if rating.scene.assumed:
        console.print(f"defaults: {rating.scene.assumed}", soft_wrap=True, markup=False)
    console.print("† some constants taken from secondary sources, see the JSON file", markup=False)
    for reason, names in missing.items():
        console.print(f"not computed: {', '.join(names)}: {shown(reason)}", soft_wrap=True, markup=False)
    for warning in rating.warnings:
        console.print(f"warning: {shown(warning)}", soft_wrap=True, markup=False)


TEMPLATE = Path(__file__).parent / "template" / "rating.html.j2"


def write_page(path: Path, rating: Rating) -> None:
    """Write the page of a rating.

    Errors
    ------
    OSError: it can't be written; an earlier page stays.
    """
    load_matplotlib()
    from fem.rating.figures import rating_figures

    text = render_page(
        TEMPLATE,
        name=rating.name,
        verdict=_verdict(rating),
        warnings=rating.warnings,
        rows=[
            (answer.meaning, in_words(answer), answer.source)
            for answer in rating.answers
            if answer.value is not None and not isinstance(answer.value, dict)
        ],
        parts=[
            (f"{answer.meaning}, {name.replace('_', ' ')}", _part(value, answer.unit), answer.source)
            for answer in rating.answers
            if isinstance(answer.value, dict) and answer.name != "contacts"
            for name, value in answer.value.items()
        ],
        contacts=_contacts(rating["contacts"]),
        stresses=rating.answer("contacts").source,
        missing=[(answer.meaning, answer.reason) for answer in rating.answers if answer.reason],
        figures=rating_figures(rating.case),
        version=VERSION,
        scene=rating.scene.to_toml(),
    )
    write_whole(path, text.encode())


def _part(value: float | None, unit: str) -> str:
    return "not in the scene" if value is None else f"{value:.4g} {unit}"


def _contacts(found: dict[str, dict[str, float]] | None) -> list[tuple[str, ...]]:
    """Rows of the table of contact stress: quantity, value on each raceway."""
    if found is None:
        return []
    rows = []
    for key in next(iter(found.values())):
        name, _, unit = key.rpartition("_")
        words = f"{name.replace('_', ' ').replace('von mises', 'von Mises stress')}, {unit.replace('um', 'µm')}"
        rows.append((words, *(f"{values[key]:.4g}" for values in found.values())))
    return rows


def _verdict(rating: Rating) -> str:
    """The first sentence."""
    if rating["C_N"] is None:
        return f"No load ratings: {rating.answer('C_N').reason}."
    words = [f"C = {1e-3 * rating['C_N']:.1f} kN"]
    if rating["C0_N"] is not None:
        words.append(f"C0 = {1e-3 * rating['C0_N']:.1f} kN")
    if rating["P_N"] is not None:
        words.append(f"P = {rating['P_N']:.0f} N")
    if rating["L10_h"] is not None:
        words.append(f"L10 = {rating['L10_h']:.0f} h")
    elif rating["L10_Mrev"] is not None:
        words.append(f"L10 = {rating['L10_Mrev']:.0f} million revolutions")
    if rating["stiffness_N_per_m"] is not None:
        matrix = 1e-6 * rating["stiffness_N_per_m"]
        words.append(f"stiffness {matrix[1, 1]:.0f} N/µm along the load, {matrix[0, 0]:.0f} N/µm across it")
    return "; ".join(words) + "."
