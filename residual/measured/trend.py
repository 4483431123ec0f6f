"""A series of records of one bearing: verdicts, levels and depths over the series, and whether they grow."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange.findings import Section
from lagrange.messages import shown
from residual.errors import InputError
from residual.formatting import text
from residual.measured.checks import Judged, Options, Question, check_record
from residual.measured.diagnosis import BODIES, DEEP, HEADLINES, Verdict
from residual.measured.report import PROGRAM
from residual.store import Page, write_folder

if TYPE_CHECKING:
    from residual.figures import Saved

TEMPLATE = Path(__file__).parents[1] / "templates" / "trend.html.j2"
FEWEST = 3  # usable records of a series
GROWS = 0.01  # chance of as clear a rise of one of the three lines without one
DAMAGED = frozenset(BODIES.values())


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A record of a series, or why it can't be used."""

    name: str
    reason: str | None = None
    verdict: Verdict = "none"
    unit: str = ""
    rms: float = np.nan
    kurtosis: float = np.nan
    crest: float = np.nan
    velocity: float | None = None  # m/s rms
    speed: float = np.nan  # rpm, as found
    depths: dict[str, float] | None = None  # by the line of a part
    prominent: str | None = None  # the part's line that stands out; others' depths hold some of that

    @classmethod
    def of(cls, name: str, judged: Judged) -> "Entry":
        found = judged.diagnosis
        return cls(
            name=name, verdict=found.verdict, unit=judged.signal.unit, rms=judged.level.rms,
            kurtosis=judged.level.kurtosis or np.nan, crest=judged.level.crest or np.nan, velocity=judged.velocity,
            speed=60.0 * found.shaft,
            depths={part: found.of(part).depth for part in BODIES},
            prominent=found.findings[0].name if found.findings[0].stands_out else None,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Growth:
    """Rise of a line's depth over a series."""

    name: str
    tau: float  # Kendall's rank correlation of depth and place in the series
    p: float  # chance of as high a τ without a rise, in one of the three lines
    first: float  # depth, median of the first third
    last: float

    @property
    def sure(self) -> bool:
        return self.tau > 0.0 and self.p <= GROWS


@dataclass(frozen=True, kw_only=True)
class Trend:
    """A series as it was given."""

    entries: tuple[Entry, ...]
    growth: tuple[Growth, ...]  # one for each line, highest τ first

    @property
    def used(self) -> list[Entry]:
        return [entry for entry in self.entries if entry.reason is None]

    @property
    def sentences(self) -> list[str]:
        """The last verdict, since when there is one, and what grows."""
        used = self.used
        said = [f"Last record, {used[-1].name}: {HEADLINES[used[-1].verdict]}"]
        if used[-1].verdict in DAMAGED:
            since = next(k for k in range(len(used)) if all(each.verdict == used[-1].verdict for each in used[k:]))
            said.append(f"The same in every record from {used[since].name} on ({since + 1} of {len(used)}).")
        elif earlier := [each.name for each in used if each.verdict in DAMAGED]:
            said.append(f"{len(earlier)} of {len(used)} earlier records show damage, the first is {earlier[0]}.")
        grown = [each for each in self.growth if each.sure and each.name == used[-1].prominent]
        said += [
            f"The depth of {each.name} grows, from {text(each.first, 2)} to {text(each.last, 2)} (Kendall's τ "
            f"{text(each.tau, 2)}, p {text(each.p, 2)})." for each in grown
        ]  # fmt: skip
        if not grown:
            said.append("No line grows beyond chance over the series.")
        lost = len(self.entries) - len(used)
        return said + ([f"{lost} of {len(self.entries)} records can't be used."] if lost else [])


def trend_of(paths: Sequence[Path], question: Question, options: Options) -> Trend:
    """Judge each record of a series, in the order given.

    Errors
    ------
    InputError: fewer than three records can be used.
    """
    entries = []
    for path in paths:
        try:
            entries.append(Entry.of(path.name, check_record(path, None, question, options).record))
        except InputError as error:
            entries.append(Entry(name=path.name, reason=str(error)))
    used = [entry for entry in entries if entry.depths is not None]
    if len(used) < FEWEST:
        reasons = "; ".join(entry.reason for entry in entries if entry.reason is not None)
        raise InputError(f"a series of {len(used)} usable records; at least {FEWEST} are needed" + (
            f" ({reasons})" if reasons else ""))  # fmt: skip
    return Trend(entries=tuple(entries), growth=tuple(growth(used)))


def growth(used: Sequence[Entry]) -> list[Growth]:
    """Rise of each line's depth over usable records, the clearest first."""
    from scipy.stats import kendalltau

    third, found = max(1, len(used) // 3), []
    for name in BODIES:
        depths = np.array([(entry.depths or {})[name] for entry in used])
        tau, p = 0.0, 1.0  # of the same record again and again
        if np.ptp(depths) > 0.0:
            tau, p = kendalltau(np.arange(depths.size), depths, alternative="greater")
        found.append(
            Growth(
                name=name, tau=float(tau), p=min(1.0, len(BODIES) * float(p)),
                first=float(np.median(depths[:third])), last=float(np.median(depths[-third:])),
            )
        )  # fmt: skip
    return sorted(found, key=lambda each: -each.tau)


def record_table(trend: Trend) -> Section:
    """Verdict, levels and depths of each record."""
    rows = []
    for entry in trend.entries:
        if entry.reason is not None or entry.depths is None:
            rows.append([entry.name, f"not used: {entry.reason}", *["-"] * (5 + len(BODIES))])
            continue
        velocity = "-" if entry.velocity is None else text(1e3 * entry.velocity, 3)
        rows.append(
            [entry.name, entry.verdict, text(entry.rms, 3), velocity, text(entry.kurtosis, 3), text(entry.crest, 3),
             text(entry.speed, 5), *(text(depth, 2) for depth in entry.depths.values())]
        )  # fmt: skip
    columns = (
        "record", "verdict", f"rms, {trend.used[0].unit or 'own unit'}", "velocity, mm/s rms", "kurtosis",
        "crest factor", "speed, rpm", *(f"depth of {line}" for line in BODIES),
    )  # fmt: skip
    return Section(columns=columns, rows=rows)


def write_trend(trend: Trend, folder: Path, figures: bool = True) -> dict[str, Any]:
    """Write the page of a series; as `residual.measured.report.write_check`."""

    def draw(fresh: Path) -> "dict[str, list[Saved]]":
        from residual.figures.spectra import trend_figure

        return {"growth": [trend_figure(trend, fresh)]}

    name = f"{trend.entries[0].name} to {trend.entries[-1].name}"
    values = dict(name=name, sentences=trend.sentences, records=record_table(trend), deep=DEEP)
    page = Page("vibration.html", TEMPLATE, values)
    return write_folder(folder, PROGRAM, summarise(trend), page, draw if figures else None)


def summarise(trend: Trend) -> dict[str, Any]:
    """Content of summary.json."""
    return {
        "verdict": trend.used[-1].verdict,
        "sentences": trend.sentences,
        "growth": [
            {"name": each.name, "tau": each.tau, "p": each.p, "first_depth": each.first, "last_depth": each.last}
            for each in trend.growth
        ],
        "records": [
            {"record": shown(entry.name), "reason": entry.reason}
            if entry.depths is None
            else {
                "record": shown(entry.name), "verdict": entry.verdict, "rms": entry.rms,
                "unit": entry.unit or None, "kurtosis": entry.kurtosis, "crest": entry.crest,
                "velocity_mm_s": None if entry.velocity is None else 1e3 * entry.velocity, "speed_rpm": entry.speed,
                "depths": entry.depths,
            }
            for entry in trend.entries
        ],
    }  # fmt: skip


def print_trend(trend: Trend, folder: Path) -> None:
    """Print what the series says, a line for each record, and where the page is."""
    for sentence in trend.sentences:
        print(shown(sentence))
    for row in record_table(trend).rows:
        print(f"  {shown(row[0]):24} {shown(row[1]):16} rms {row[2]:>8}  depths {' '.join(row[7:])}")
    print(f"Page: {shown(folder / 'vibration.html')}")
