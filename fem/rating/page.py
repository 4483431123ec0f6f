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
        name=rating.scene.name,
        verdict=_verdict(rating),
        warnings=rating.warnings,
        rows=[
            (answer.meaning, in_words(answer), answer.source)
            for answer in rating.answers
            if answer.value is not None and not isinstance(answer.value, dict)
        ],
        parts=[
            (f"{answer.meaning}, {name}" if name else answer.meaning, value, answer.source)
            for answer in rating.answers
            if isinstance(answer.value, dict)
            for name, value in _parts(answer.value, answer.unit)
        ],
        missing=[(answer.meaning, answer.reason) for answer in rating.answers if answer.reason],
        figures=rating_figures(rating.case),
        version=VERSION,
        scene=rating.scene.to_toml(),
    )
    write_whole(path, text.encode())


def _parts(value: dict, unit: str) -> list[tuple[str, str]]:
    """Names and words of what belongs together, one level of groups deep."""
    found = []
    for name, each in value.items():
        if isinstance(each, dict):
            found += [(f"{name} raceway, {part}", f"{number:.4g}") for part, number in each.items()]
        else:
            found.append((name.replace("_", " "), "not in the scene" if each is None else f"{each:.4g} {unit}"))
    return found


def _verdict(rating: Rating) -> str:
    """The first sentence."""
    if rating["C_N"] is None:
        return f"No load ratings: {rating.answer('C_N').reason}."
    words = [f"C = {1e-3 * rating['C_N']:.1f} kN, C0 = {1e-3 * rating['C0_N']:.1f} kN, P = {rating['P_N']:.0f} N"]
    if rating["L10_h"] is not None:
        words.append(f"L10 = {rating['L10_h']:.0f} h")
    elif rating["L10_Mrev"] is not None:
        words.append(f"L10 = {rating['L10_Mrev']:.0f} million revolutions")
    if rating["stiffness_N_per_m"] is not None:
        matrix = 1e-6 * rating["stiffness_N_per_m"]
        words.append(f"stiffness {matrix[1, 1]:.0f} N/µm along the load, {matrix[0, 0]:.0f} N/µm across it")
    return "; ".join(words) + "."
