"""What rate-bearing prints, its JSON file, and rating.html: one file, to be opened anywhere."""

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from fem.rating.answers import BULKY, Answer, Rating
from lagrange.files.output import load_matplotlib, render_page, write_whole
from lagrange.messages import Section, shown
from lagrange.version import VERSION

ON_PAPER = {"N/m": (1e-6, "N/µm"), "1": (1.0, "")}  # units that engineers read
VERDICT = (  # of what there is, the first of one kind: answer, factor, words
    ("C_N", 1e-3, "C = {:.1f} kN"), ("C0_N", 1e-3, "C0 = {:.1f} kN"), ("P_N", 1.0, "P = {:.0f} N"),
    ("L10_h", 1.0, "L10 = {:.0f} h"), ("L10_Mrev", 1.0, "L10 = {:.0f} million revolutions"))  # fmt: skip
TEMPLATE = Path(__file__).parent / "template" / "rating.html.j2"


def write_json(path: Path, rating: Rating) -> None:
    """The answers, with reasons and sources; OSError."""
    text = json.dumps(rating.to_json(), indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(path, (text + "\n").encode())


def in_words(answer: Answer) -> str:
    """A value with its unit for people."""
    factor, unit = ON_PAPER.get(answer.unit, (1.0, answer.unit))
    return f"{_number(answer.value, factor)} {unit}".rstrip()


def _number(value: Any, factor: float) -> str:
    if value is None or isinstance(value, str):
        return value or "none"
    if isinstance(value, dict):
        return ", ".join(f"{name} {_number(each, factor)}" for name, each in value.items())
    if np.ndim(value) == 0:
        scaled = factor * float(value)
        return f"{scaled:.4g}" if abs(scaled) < 1e4 or abs(scaled) >= 1e7 else f"{scaled:.0f}"
    if np.ndim(value) == 3:
        return " to ".join(_number(each, factor) for each in value)
    # 0 in place of the round-off of what symmetry makes 0
    rows = np.where(np.abs(value) < 1e-9 * np.max(np.abs(value)), 0.0, value)
    if np.shape(value) == (2, 2):
        return "; ".join(", ".join(_number(each, factor) for each in row) for row in rows)
    return ", ".join(_number(each, factor) for each in rows)


def print_rating(rating: Rating) -> None:
    """A table of what could be computed, what could not with its reason, then warnings."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console(highlight=False)
    table, missing = Table(box=None, pad_edge=False, show_header=False), defaultdict[str, list[str]](list)
    for answer in rating.answers.values():
        if not answer.asked:
            continue
        if answer.value is None:
            missing[answer.reason].append(answer.name)
        elif answer.name not in BULKY:
            source = answer.source.name + (" †" if answer.source.second_hand else "")
            table.add_row(*(escape(shown(cell)) for cell in (answer.meaning, in_words(answer), source)))
    console.print(f"Rating of {shown(rating.name)}", style="italic", markup=False)
    console.print(table)
    lines = [f"defaults: {rating.scene.assumed}"] if rating.scene.assumed else []
    lines += [of["words"] for of in (rating["catalogue"] or {}).values() if of["words"]]
    lines.append("† some constants taken from secondary sources, see the JSON file")
    lines += [f"not computed: {', '.join(names)}: {shown(reason)}" for reason, names in missing.items()]
    for line in (*lines, *(f"warning: {shown(warning)}" for warning in rating.warnings)):
        console.print(line, soft_wrap=True, markup=False)


def write_page(path: Path, rating: Rating) -> None:
    """Write the page of a rating. OSError: it can't be written; an earlier page stays."""
    load_matplotlib()
    from fem.rating.figures import rating_figures

    rows, parts, contacts, found = [], [], [], rating["contacts"] or {}
    for a in rating.answers.values():
        if a.value is not None and not isinstance(a.value, dict):
            rows.append((a.meaning, in_words(a), str(a.source)))
        elif a.value is not None and a.name not in ("contacts", "catalogue"):
            for name, part in a.value.items():
                value = "not in the scene" if part is None else f"{part:.4g} {a.unit}"
                parts.append((f"{a.meaning}, {name.replace('_', ' ')}", value, str(a.source)))
    for key in next(iter(found.values()), ()):
        name, _, unit = key.rpartition("_")
        words = f"{name.replace('_', ' ').replace('von mises', 'von Mises stress')}, {unit.replace('um', 'µm')}"
        contacts.append((words, *(f"{values[key]:.4g}" for values in found.values())))
    missing = [(a.meaning, a.reason) for a in rating.answers.values() if a.reason]
    text = render_page(
        TEMPLATE, name=rating.name, verdict=_verdict(rating), warnings=rating.warnings, version=VERSION,
        numbers=Section(columns=("", "value", "source"), rows=rows + parts, kind="words stacked"),
        contacts=Section(columns=("most loaded contact", "inner raceway", "outer raceway"), rows=contacts),
        stresses=rating.answers["contacts"].source, missing=Section(columns=(), rows=missing, kind="words"),
        figures=rating_figures(rating.case), scene=rating.scene.to_toml())  # fmt: skip
    write_whole(path, text.encode())


def _verdict(rating: Rating) -> str:  # the first sentence
    if rating["C_N"] is None:
        return f"No load ratings: {rating.answers['C_N'].reason}."
    words = {name.partition("_")[0]: text.format(factor * rating[name])
             for name, factor, text in reversed(VERDICT) if rating[name] is not None}  # fmt: skip
    words = {name: words[name] for name in ("C", "C0", "P", "L10") if name in words}
    if rating["stiffness_N_per_m"] is not None:
        matrix = 1e-6 * rating["stiffness_N_per_m"]
        words["k"] = f"stiffness {matrix[1, 1]:.0f} N/µm along the load, {matrix[0, 0]:.0f} N/µm across it"
    return "; ".join(words.values()) + "."
