"""The sheet of a rating in six blocks: on the terminal, as JSON, as rating.html, to be opened or printed anywhere."""

import json
import re
from collections.abc import Iterator, Mapping
from datetime import date
from itertools import groupby, zip_longest
from pathlib import Path
from textwrap import wrap

import numpy as np

from fem.rating.answers import BULKY, Rating
from fem.rating.sheet import MIXED, in_words, missing, number, ratings_in_words, sheet
from lagrange.files.output import load_matplotlib, render_page, write_whole
from lagrange.messages import Section, engineering, shown
from lagrange.version import VERSION

FIGURE_SPACE = "\u2007"  # as wide as a digit
LABEL, WIDTH, WIDE = 28, 78, 100  # characters: of a label, of a block, of a terminal that has two beside each other
NOTES = "means are over a pitch of the rollers; y points against the load, x across it"
SECOND_HAND = f"† constants from secondary sources, which the JSON file names; {NOTES}"
VERDICT = "C_N", "C0_N", "P_N", "L10_h"
TEMPLATE = Path(__file__).parent / "template" / "rating.html.j2"


def write_json(path: Path, found: object) -> None:
    """Answers with reasons and sources; OSError."""
    write_whole(path, (json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode())


def print_rating(rating: Rating) -> None:
    """Six blocks, beside each other where the terminal is wide; what is missing with its reason; warnings."""
    from rich.console import Console
    from rich.table import Table

    console, grid = Console(highlight=False), Table.grid(padding=(0, 3, 0, 0))
    wide = console.is_terminal and console.width >= WIDE
    width = min(WIDTH, (console.width - 3) // 2 if wide else console.width)
    blocks = [(name.capitalize(), _lines(lines, width)) for name, lines in sheet(rating).items()]
    grid.add_row(_column(blocks[:3]), _column(blocks[3:]))
    console.print(f"Rating of {shown(rating.name)}", style="italic", markup=False, soft_wrap=True)
    console.print(grid if wide else _column(blocks), "", sep="\n", soft_wrap=True)
    defaults = [f"defaults: {rating.scene.assumed}"] if rating.scene.assumed else []
    for line in (*defaults, SECOND_HAND, *_notes(rating)):
        console.print(shown(line), soft_wrap=True, markup=False)


def _lines(lines, width):  # of a block
    found, right = [], width - LABEL
    for line in lines:
        labels, values = wrap(line.meaning, LABEL - 1), line.value.split("\n")
        values[-1] += "†" if line.source.second_hand else ""
        if values[0] == MIXED[1] and max(map(len, values)) > right:  # a large matrix below its label
            found += [*labels, *(f"  {row}" for row in values)]
        else:
            values = [part for value in values for part in wrap(shown(value), right)]
            both = zip_longest(labels, values, fillvalue="")
            found += [f"{label:{LABEL}}{value}".rstrip() for label, value in both]
    return found


def _column(blocks):  # a text of rich
    from rich.text import Text

    text = Text()
    for name, lines in blocks:
        text.append(f"{name}\n", "bold").append("\n".join([*lines, "", ""]))
    text.rstrip()
    return text


def _notes(rating):
    lacking = (f"not computed: {meanings}: {reason}" for reason, meanings in missing(rating).items())
    return [*ratings_in_words(rating), *lacking, *(f"warning: {warning}" for warning in rating.warnings)]


def write_page(path: Path, rating: Rating) -> None:
    """Write the page of a rating. OSError: it can't be written; an earlier page stays."""
    load_matplotlib()
    from fem.rating.figures import rating_figures

    blocks, contacts, sections = sheet(rating, bulky=True), rating["contacts"], []
    sources = list(dict.fromkeys(line.source for lines in blocks.values() for line in lines))
    for block, lines in blocks.items():
        small = [line for line in lines if not line.value.startswith(MIXED[1])]
        rows = [(line.meaning, re.sub(r" {2,}", lambda blanks: FIGURE_SPACE * len(blanks[0]), line.value),
                 f"{line.source.name} [{sources.index(line.source) + 1}]") for line in small]  # fmt: skip
        sections.append(Section((), rows, block.capitalize(), kind="words rated"))
        for line in (line for line in lines if line not in small):
            unit, *entries = line.value.split("\n")
            names = *"xyz"[: len(entries) - 2], "tilt x", "tilt y"
            rows = [(name, *row.split()) for name, row in zip(names, entries, strict=True)]
            sections.append(Section((unit, *names), rows))
        if block == "stresses" and contacts:
            inner, outer = contacts["inner"], contacts["outer"]
            rows = [(_stress(key), f"{inner[key]:.4g}", f"{outer[key]:.4g}") for key in inner]
            sections.append(Section(("most loaded contact", "inner", "outer"), rows))
    _write(path, rating.name, [rating], sections=sections, verdict=_verdict(rating),
           warnings=[*ratings_in_words(rating), *rating.warnings],
           missing=Section((), [(meanings, reason) for reason, meanings in missing(rating).items()], kind="words"),
           sources=Section((), [(f"[{k}]", str(each)) for k, each in enumerate(sources, 1)], kind="words sources"),
           figures=rating_figures(rating.case))  # fmt: skip


def _write(path, name, ratings, **values):
    scenes = {rating.name: rating.scene.to_toml() for rating in ratings}
    text = render_page(TEMPLATE, name=name, today=date.today().isoformat(), version=VERSION, scenes=scenes,
                       notes=NOTES, **values)  # fmt: skip
    write_whole(path, text.encode())


def _stress(key):
    name, _, unit = key.rpartition("_")
    return f"{name.replace('_', ' ').replace('von mises', 'von Mises stress')}, {unit.replace('um', 'µm')}"


def _verdict(rating):  # the first sentence
    if rating["C_N"] is None:
        return f"No load ratings: {rating.answers['C_N'].reason}."
    found = (rating.answers[name] for name in VERDICT)
    return "; ".join(f"{each.name.partition('_')[0]} = {in_words(each)}" for each in found if each.value is not None)


# Bearings side by side under the same load


def compared(ratings: Mapping[str, Rating]) -> Iterator[Section]:
    """A table a block with a column each; of matrices their diagonals."""
    columns = [rating.answers for rating in ratings.values()]
    for block, names in groupby(columns[0], lambda name: columns[0][name].block):
        rows = []
        for name in names:
            of = [answers[name] for answers in columns]
            if name not in {"designation", *BULKY} and any(
                each.value is not None and np.ndim(each.value) <= 2 for each in of
            ):
                unit = MIXED[1] if of[0].unit == MIXED[0] else engineering(of[0].unit)[1]
                rows.append((f"{of[0].meaning}, {unit}".rstrip(", "), *map(_cell, of)))
        yield Section(("", *ratings), rows, block.capitalize())


def _cell(answer):
    value, factor = answer.value, engineering(answer.unit)[0]
    if value is None or np.ndim(value) > 2:
        return "–"
    if np.ndim(value) == 2:
        value = np.diag(value) * (np.array([1e-6] * (len(value) - 2) + [1e-3] * 2) if answer.unit == MIXED[0] else 1.0)
    return number(value, factor)


def remarks(ratings: Mapping[str, Rating]) -> Iterator[str]:
    """Ratings that are not the standards', what is missing with its reason, warnings; those of all bearings once."""
    found: dict[str, list[str]] = {}
    for name, rating in ratings.items():
        for text in _notes(rating):
            found.setdefault(text, []).append(name)
    for text, names in found.items():
        yield text if len(names) == len(ratings) else f"{', '.join(names)}: {text}"


def print_comparison(name: str, ratings: Mapping[str, Rating]) -> None:
    """One table, then what is missing and warnings."""
    from rich.console import Console
    from rich.table import Table

    console, table = Console(highlight=False), Table.grid(padding=(0, 2, 0, 0))
    console.width = console.width if console.is_terminal else 110
    console.print(f"Rating of {shown(name)}", style="italic", markup=False, soft_wrap=True)
    table.add_column(no_wrap=True)
    for _ in ratings:
        table.add_column(justify="right")
    for section in compared(ratings):
        table.add_row(section.title, *ratings, style="bold")
        for row in section.rows:
            table.add_row(*map(shown, row))
        table.add_row()
    console.print(table)
    for line in (SECOND_HAND, *remarks(ratings)):
        console.print(shown(line), soft_wrap=True, markup=False)


def write_comparison(path: Path, name: str, ratings: Mapping[str, Rating]) -> None:
    """Its page; OSError."""
    _write(path, name, list(ratings.values()), sections=list(compared(ratings)), verdict="", figures=[],
           warnings=list(remarks(ratings)), missing=Section((), []), sources=Section((), []))  # fmt: skip
