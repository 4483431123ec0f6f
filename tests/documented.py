"""What the pages show, as it is to be typed; `python -m tests.documented BIN` runs it with the programs of a folder.

Each page gets an empty folder: first the files it shows, then its commands from top to bottom, word for word, by the
shell. Runs with Python alone, so that an installation can be tried that has nothing beyond the program.
"""

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
from pathlib import Path
from urllib.request import urlopen

ROOT = Path(__file__).resolve().parents[1]
PAGES = (  # the longest first, so that two at a time end together
    "docs/recipes.md",
    "docs/measured.md",
    "docs/first_bearing.md",
    "docs/vibration_tutorial.md",
    "docs/studies.md",
    "README.md",
    "docs/design_tutorial.md",
    "docs/stress_tutorial.md",
    "docs/equations_tutorial.md",
    "docs/tables.md",
    "docs/rating.md",
)
PROGRAMS = ("run-fem", "check-residual", "check-vibration", "render-fem", "run-live", "run-study", "rate-bearing")
PLACEHOLDER = re.compile(r"\b(NAME|PATH)\b")
SECONDS = 150  # that a command may take
FENCED = re.compile(r"^```(\w*)\n(.*?)^```", re.M | re.S)
INLINE = re.compile(r"`([^`\n]+)`")


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
            if before or own:
                found[before[1] if before else f"{own}.toml"] = block[2]
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
        elif block[1] == "text":
            yield from ours([line[2:] for line in block[2].splitlines() if line.startswith("$ ")])
        elif block[1] == "python" and block[2].startswith("import h5py"):  # others say which package they take
            yield block[2]
    yield from ours(INLINE.findall(text[end:]))


def expected(command: str) -> set[int]:
    """Exit codes that a command may end with in an installation without extras."""
    if "--scheduler" in command or "--workers" in command:
        return {2}
    return {0, 1} if "--tolerance" in command else {0}


def run_page(page: str, programs: Path) -> list[str]:
    """Run a page; what went otherwise than it says."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment |= {"PATH": f"{programs}:{os.environ['PATH']}", "PYTHONSAFEPATH": "1"}
    faults = []
    with tempfile.TemporaryDirectory(prefix="documented-") as folder:
        for name, text in files(ROOT / page).items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        for command in commands(ROOT / page):
            begun = time.monotonic()
            where = {"cwd": folder, "env": environment, "text": True}
            if command.startswith("run-live"):
                code, told = _played(command, where)
                fine = code in (0, 130)
            else:
                words = ["python", "-c", command] if command.startswith("import") else ["bash", "-c", command]
                try:
                    done = subprocess.run(words, capture_output=True, timeout=SECONDS, **where)
                    code, told = done.returncode, done.stdout + done.stderr
                except subprocess.TimeoutExpired:
                    code, told = None, f"no end within {SECONDS} s"
                fine = code in expected(command) and (code != 2 or "python -m pip install distributed" in told)
            first = command.splitlines()[0 if command.startswith("run") or "\n" not in command else -1]
            print(f"{page}: {first}: {code}, {time.monotonic() - begun:.1f} s", flush=True)
            if not fine:
                faults.append(f"{page}: {command}: exit {code}\n{told[-2000:]}")
    return faults


def _played(command: str, where: dict) -> tuple[int | None, str]:
    """Exit code and words of a live page that is fetched once and ended by Ctrl-C."""
    where = where | {"env": where["env"] | {"PYTHONUNBUFFERED": "1"}}
    live = subprocess.Popen(command.split(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **where)
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
    """Run all pages, two at a time; 1 where one does not go as it says."""
    programs = Path(sys.argv[1]).resolve()
    with ThreadPoolExecutor(2) as pool:
        faults = [fault for found in pool.map(lambda page: run_page(page, programs), PAGES) for fault in found]
    print("\n".join(faults), file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
