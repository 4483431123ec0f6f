"""Rows and sentences about the vibration of sensor, housing or hub, for the report."""

from collections.abc import Iterable

from lagrange.faults import Fault, Film, MeasuredSurface, Spall, UnequalRoller, Waviness
from lagrange.messages import shown
from lagrange.units import G
from residual.evaluation import Evaluation
from residual.vibration import ENVELOPE_FROM, STANDS_OUT, FaultLine
from residual.words import text


def whose(evaluation: Evaluation) -> str:
    """Whose vibration the report is of, as it stands along y, the load's direction."""
    return evaluation.y.vibration.body


def vibration_headings(evaluation: Evaluation) -> list[str]:
    """Headings of `vibration_rows` beyond the first: body and direction, each in m/s² and in g."""
    return [
        heading
        for d in evaluation.directions
        for heading in (f"{d.vibration.body}, {d.name}, m/s²", f"{d.vibration.body}, {d.name}, g")
    ]


def vibration_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of quantity, and of x and y each m/s² and g; kurtosis and crest factor have no unit."""
    both = [d.vibration for d in evaluation.directions]
    return [
        ["peak", *_levels(v.peak for v in both)],
        ["rms", *_levels(v.rms for v in both)],
        *(
            [f"rms, {text(1e-3 * low)}-{text(1e-3 * high)} kHz", *_levels(v.bands[low, high] for v in both)]
            for low, high in both[0].bands
        ),
        ["crest factor", *(cell for v in both for cell in ("-" if v.crest is None else text(v.crest, 3), ""))],
        ["kurtosis", *(cell for v in both for cell in ("-" if v.kurtosis is None else text(v.kurtosis, 3), ""))],
    ]


def _levels(accelerations: Iterable[float]) -> list[str]:
    """Each in m/s² and in g."""
    return [cell for value in accelerations for cell in (text(value), text(value / G, 3))]


def envelope_rows(evaluation: Evaluation) -> list[list[str]]:
    """Rows of line, Hz, resolved, and in x and y each amplitude in m/s² and in g and its ratio to the floor.

    Lines that stand out are marked.
    """
    x, y = (d.vibration.lines for d in evaluation.directions)
    return [
        [a.name, text(a.frequency), "yes" if a.resolved else "no", *_cells(a), *_cells(b)]
        for a, b in zip(x, y, strict=True)
    ]


def _cells(line: FaultLine) -> list[str]:
    amplitude = text(line.amplitude, 3) + (" *" if line.stands_out else "")
    return [amplitude, text(line.amplitude / G, 2), text(line.ratio, 2)]


def vibration_sentences(evaluation: Evaluation) -> list[str]:
    """Say what the scene's surfaces are, which lines stand out, and how the envelope was taken."""
    faults = tuple(fault for fault in evaluation.record.bearing.faults if not isinstance(fault, Film))
    scene = (
        f"The scene has {_listed([_named(f) for f in faults])}."
        if faults
        else "The scene's surfaces are perfect circles."
    )
    found = evaluation.x.vibration.envelope
    if found is None:
        why = "the bearing stands, or the record is too short or too coarse for one"
        if evaluation.record.varies_speed:
            why = "the speed changes, and lines are told in orders"
        return [f"{scene} No envelope: {why}."]
    if not evaluation.x.vibration.tells_lines:
        return [f"{scene} The record is too short to tell fault lines in the envelope from each other."]
    standing = [
        f"{_listed(names)} in {d.name}"
        for d in evaluation.directions
        if (names := [line.name for line in d.vibration.lines if line.stands_out])
    ]
    lines = f"Lines that stand out of the envelope's floor: {'; '.join(standing)}" if standing else "No line stands out"
    expected = _expected(faults)
    told = [f"Expected of such faults: {', '.join(expected.values())}."] if expected else []
    told += [
        f"{line.name} is not resolved from {line.nearest} in this record: that takes "
        f"{text(1e3 * line.record_needed, 3)} ms."
        for line in evaluation.x.vibration.lines
        if line.name in expected and not line.resolved
    ]
    return [
        " ".join([f"{scene} {lines}.", *told]),
        f"Envelope (Hilbert) of the {whose(evaluation)}'s acceleration within {text(1e-3 * found.low, 3)} to "
        f"{text(1e-3 * found.high, 3)} kHz: from {ENVELOPE_FROM:g} BPFI up to 0.9 of the Nyquist frequency, at most "
        "50 kHz. Amplitudes, not rms. Ratio: to the median at multiples of FTF from the line; * stands out: resolved, "
        f"ratio at least {STANDS_OUT:g} (12 dB). A perfect bearing has a weak line at BPFO too, because passing "
        "rollers change its stiffness.",
    ]


def _expected(faults: tuple[Fault, ...]) -> dict[str, str]:
    """Families of lines that spalls leave in an envelope, by the line that each is about."""
    bodies = {fault.body for fault in faults if isinstance(fault, Spall)}
    lines = {
        "outer_ring": ("BPFO", "BPFO and multiples"),
        "inner_ring": ("BPFI", "BPFI ± shaft"),
        "roller": ("2×BSF", "2×BSF ± FTF"),
    }
    return dict(line for body, line in lines.items() if body in bodies)


def _named(fault: Spall | Waviness | MeasuredSurface | UnequalRoller) -> str:
    """Name a fault with its place and size."""
    place = f"the {fault.body.replace('_', ' ')}" if fault.roller is None else f"roller {fault.roller}"
    if isinstance(fault, Spall):
        return f"a spall {text(1e3 * fault.width)} mm wide on {place}"
    if isinstance(fault, Waviness):
        return f"waves of order {fault.order} and {text(1e6 * fault.amplitude)} µm on {place}"
    if isinstance(fault, MeasuredSurface):
        return f"measured heights ({shown(fault.file)}) on {place}"
    return f"{place} larger by {text(1e6 * fault.diameter_deviation)} µm"


def _listed(names: list[str]) -> str:
    """Join names by commas and "and"."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
