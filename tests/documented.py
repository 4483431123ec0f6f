"""What the pages show: `python -m tests.documented BIN [PAGE ...]` runs it with the programs of a folder.

Each page gets an empty folder: first the files it shows, then its commands from top to bottom, word for word, by the
shell. A block of text right after a block of commands is what they print; "…" stands for lines, or the part of a line,
left out. Words are compared as they stand, numbers to a unit of the last digit shown. Bits differ between processors: a
page shows fewer digits than are printed where these differ (NUMBA_CPU_NAME=generic tells). Run times are not compared.
In a section with commands each number of a sentence is one of the page's blocks, and each sentence in quotation marks
is printed. Runs with Python alone: an installation can be tried that has nothing beyond the program.
"""

import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from difflib import SequenceMatcher
from pathlib import Path
from urllib.request import urlopen

ROOT = Path(__file__).resolve().parents[1]
PAGES = [  # the longest first, so that two at a time end together
    "docs/recipes.md", "docs/measured.md", "docs/first_bearing.md", "docs/vibration_tutorial.md", "docs/studies.md",
    "README.md", "docs/design_tutorial.md", "docs/stress_tutorial.md", "docs/equations_tutorial.md", "docs/tables.md",
    "docs/spectra.md", "docs/rating.md", "docs/axial_load.md", "docs/clearance.md", "docs/lagrange.md",
]  # fmt: skip
PROGRAMS = ("run-fem", "check-residual", "check-vibration", "render-fem", "run-live", "run-study", "rate-bearing")
RUN = r"^```(?:sh\n|python\nimport h5py)"  # other examples in Python say which package they take
PLACEHOLDER = re.compile(r"\b(NAME|PATH|tcp://host)\b")
SECONDS = 600  # that a command may take, compiling included
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)
INLINE = re.compile(r"`([^`\n]+)`")
LINES = r"(?:(?!```).*\n)*"
OUTPUT = re.compile(rf"^```(sh|python)\n(?P<commands>{LINES})```\n\n```text\n(?P<shown>{LINES})```", re.M)
LEFT_OUT = "…"
NUMBER = re.compile(r"((?<![\w.-])[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+|·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?)")
QUANTITY = re.compile(  # after a key of a scene, or before its unit
    rf"(?:_(?P<key>[A-Za-z]+) ?= ?)?(?P<number>{NUMBER.pattern[1:-1]}) ?(?P<unit>(?:[A-Za-zµ°%][\w/·²³]*)?)"
)
RUN_TIME = re.compile(r"\bin \d[\d.]* (?:s|min|h)\b")
# ISO 281, Johnson 1985
NAMES = r"\b(?:[A-Z]{2,3}|[Ff]igure|Python|[A-Z]\w+(?= (?:19|20)\d\d)) \d[\d.]*(?: to \d[\d.]*)?"
NO_PROSE = re.compile(  # formulas, code, what docs/measurements has, targets of links, headings
    r"\$\$.*?\$\$|\$[^$\n]+\$|`[^`\n]*`|\[[^]\n]*\]\([^)\n]*measurements/[^)\n]*\)|\]\([^)]*\)|^#[^\n]*|" + NAMES,
    re.M | re.S,
)
PLAIN = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")


def blocks(path: Path, kind: str) -> list[str]:
    """The fenced blocks of a kind (sh, text, toml, python)."""
    return [text for found, text in FENCED.findall(path.read_text(encoding="utf-8")) if found == kind]


def files(path: Path) -> dict[str, str]:
    """Blocks of TOML that are whole files: named by the line before them, or by their own `name`."""
    text, found = path.read_text(encoding="utf-8"), {}
    for block in FENCED.finditer(text):
        if block[1] == "toml":
            before = re.search(r"`([\w-]+\.toml)`:\n\n$", text[: block.start()])
            own = tomllib.loads(block[2]).get("name")
            found |= {before[1] if before else f"{own}.toml": block[2]} if before or own else {}
    return found


def commands(path: Path) -> Iterator[str]:
    """Commands of ours in blocks and in sentences, and examples in Python, each once, from top to bottom."""
    text, end, seen = path.read_text(encoding="utf-8"), 0, set()

    def ours(lines: list[str]) -> Iterator[str]:
        for line in lines:
            line = line.strip()
            program, _, rest = line.partition(" ")  # a program's name alone is a word of a sentence
            if program in PROGRAMS and rest and not PLACEHOLDER.search(line) and line not in seen:
                seen.add(line)
                yield line

    for block in FENCED.finditer(text):
        yield from ours(INLINE.findall(text[end : block.start()]))
        end = block.end()
        if block[1] == "sh":
            yield from ours([line.partition("#")[0] for line in block[2].splitlines()])
        elif re.match(RUN, block[0]):
            yield block[2]
    yield from ours(INLINE.findall(text[end:]))


def run_page(page: str, programs: Path) -> list[str]:
    """Run a page; what went otherwise than it says."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment |= {"PATH": f"{programs}:{os.environ['PATH']}", "PYTHONSAFEPATH": "1", "PYTHONUNBUFFERED": "1"}
    path, faults, printed = ROOT / page, [], {}
    with tempfile.TemporaryDirectory(prefix="documented-") as folder:
        for name, text in files(path).items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        where = {"cwd": folder, "env": environment | {"COLUMNS": "110"}, "text": True, "stderr": subprocess.STDOUT}
        for command in commands(path):
            begun, may_end = time.monotonic(), (0, 1) if "--tolerance" in command else (0,)
            if command.startswith("run-live"):
                (code, told), may_end = _played(command, where), (0, 130)
            else:
                typed = ["python", "-c", command] if command.startswith("import") else ["bash", "-c", command]
                try:
                    done = subprocess.run(typed, stdout=subprocess.PIPE, timeout=SECONDS, **where)
                    code, told = done.returncode, done.stdout
                except subprocess.TimeoutExpired:
                    code, told = None, f"no end within {SECONDS} s"
            first = command.splitlines()[0 if command.startswith("run") or "\n" not in command else -1]
            print(f"{page}: {first}: {code}, {time.monotonic() - begun:.1f} s", flush=True)
            printed[command] = told
            faults += [] if code in may_end else [f"{page}: {command}: exit {code}\n{told[-2000:]}"]
    text = path.read_text(encoding="utf-8")
    return faults or [f"{page}: {fault}" for fault in (*differences(text, printed), *unfounded(text))]


def outputs(text: str, printed: dict[str, str]) -> Iterator[tuple[list[str], list[str]]]:
    """Of each block of output its lines and the lines that its commands print."""
    for block in OUTPUT.finditer(text):
        lines = [line.partition("#")[0].strip() for line in block["commands"].splitlines()]
        told = "".join(printed[line] for line in ([block["commands"]] if block[1] == "python" else lines))
        told = re.sub(r"^compiling .*\n", "", told, flags=re.M)  # where nothing is kept of earlier runs
        yield block["shown"].splitlines(), [line.rstrip() for line in told.strip("\n").splitlines()]


def words(line: str) -> str:
    """A line without run times, with single blanks and rules of one length."""
    return re.sub(r"([━─])+", r"\1", " ".join(RUN_TIME.sub("", line).split()))


def alike(shown: str, printed: str) -> re.Match | None:
    """Whether two lines have the same words; the match's groups are the numbers that are printed."""
    parts = enumerate(NUMBER.split(words(shown)))
    pattern = [NUMBER.pattern if k % 2 else re.escape(part).replace(LEFT_OUT, ".*") for k, part in parts]
    return re.fullmatch("".join(pattern), words(printed))


def same(shown: str, printed: str) -> bool:
    """Whether two lines have the same words, and numbers within a unit of the last digit that is shown."""
    if (found := alike(shown, printed)) is None:
        return False
    pairs = zip(map(value, NUMBER.findall(words(shown))), map(value, found.groups()), strict=True)
    return all(abs(a - b) <= 1.001 * digit for (a, digit), (b, _) in pairs)


def value(number: str) -> tuple[float, float]:
    """A number and one unit of its last digit."""
    mantissa, _, power = number.replace("·10", "e").translate(PLAIN).partition("e")
    size = 10.0 ** int(power or 0)
    return float(mantissa) * size, size * 10.0 ** -len(mantissa.partition(".")[2])


def rounds(number: str, exact: str) -> bool:
    """Whether a number of a sentence is the size of a printed one, rounded."""
    rounded, digit = value(number)
    return abs(abs(rounded) - abs(value(exact)[0])) <= 0.5001 * digit


def differences(text: str, printed: dict[str, str]) -> Iterator[str]:
    """Lines of a page's outputs that are not printed, in their order, or are missing there."""
    for shown, told in outputs(text, printed):
        at, skips = 0, False
        for line in shown:
            if line == LEFT_OUT:
                skips = True
                continue
            ahead = told[at:] if skips else told[at : at + 1]
            found = next((k for k, each in enumerate(ahead) if same(line, each)), None)
            if found is None:
                near = max(ahead, key=lambda each: SequenceMatcher(None, line, each).ratio(), default=None)
                yield f"shown:   {line}\n  printed: {near}"
                found = ahead.index(near) if near else 0
            at, skips = at + found + 1, False
        if not skips and at < len(told):
            yield f"printed and not shown: {told[at]}"


def unfounded(text: str) -> Iterator[str]:
    """Numbers and quoted words of sentences that stand in no block of the page."""
    shown = "\n".join(block[2] for block in FENCED.finditer(text))
    given = QUANTITY.findall(shown)
    for found in QUANTITY.finditer(prose(text)):
        unit = found["unit"]
        units = {"", unit, unit.replace("µ", "u").replace("/", "_")}
        if not any(rounds(found["number"], number) and {key, after} & units for key, number, after in given):
            yield f"in no block: {found[0]} of {text[max(0, found.start() - 40) : found.end() + 20]!r}"
    for quoted in re.findall(r'"([A-Z][^"`\n]* [^"`\n]*)"', prose(text)):
        if quoted.rstrip(".,") not in shown:
            yield f"in no block: {quoted!r}"


def prose(text: str) -> str:
    """The sentences of sections with commands, at their places in the page."""
    sections = re.split(r"^(?=###? )", text, flags=re.M)
    kept = "".join(each if re.search(RUN, each, re.M) else "¦" * len(each) for each in sections)
    for what in (FENCED, NO_PROSE):
        kept = what.sub(lambda found: "¦" * len(found[0]), kept)
    return kept


def _played(command: str, where: dict) -> tuple[int | None, str]:
    """Exit code and words of a live page that is fetched once and ended by Ctrl-C."""
    live = subprocess.Popen(command.split(), stdout=subprocess.PIPE, **where)
    try:
        for line in live.stdout:
            if line.startswith("Live: "):
                with urlopen(line.split()[1], timeout=20) as page:
                    page.read()
                live.send_signal(signal.SIGINT)
                return live.wait(20), ""
        return live.wait(20), "no address was printed"
    except (OSError, subprocess.TimeoutExpired) as error:
        return None, str(error)
    finally:
        live.kill()


def main() -> int:
    """Run pages, two at a time; 1 where one does not go as it says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=Path, help="folder of the programs, as .venv/bin")
    parser.add_argument("pages", nargs="*", default=PAGES, help="as docs/rating.md; all where none is named")
    given = parser.parse_intermixed_args()
    with ThreadPoolExecutor(2) as pool:
        run = pool.map(lambda page: run_page(page, given.programs.resolve()), given.pages)
        faults = [fault for found in run for fault in found]
    print("\n".join(faults), file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
