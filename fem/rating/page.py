"""rating.html: one file, to be opened anywhere."""

from pathlib import Path

from fem.rating.answers import Rating
from fem.rating.report import in_words
from lagrange.files.output import write_whole
from lagrange.files.pages import load_matplotlib, render_page
from lagrange.version import VERSION

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
