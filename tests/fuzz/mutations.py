"""Inputs for the fuzzers that stay near sound ones.

A scene's values, a table's cells, a file's bytes, an archive's arrays are changed. Each function takes a file's content
and a random.Random, and gives another content. Bytes alone would hardly ever get past the parsers.
"""

import json
from collections.abc import Callable
from random import Random

NUMBERS = (
    "", " ", "nan", "-nan", "inf", "-inf", "1e400", "-1e400", "1e308", "-1e308", "1e15", "1e16", "1e-320", "-0", "0",
    "1", "-1", "0x10", "1_000", "1.", ".5", "1e", "1,5", "1.2.3", "9" * 400, "0." + "0" * 400 + "1", "true", "=1+1",
    "\u0661",
)  # fmt: skip
VALUES = (
    *NUMBERS, "[1, 2]", "[]", "{}", "{a = 1}", "'text'", '"\\u0000"', '"\\u001b[2J"', "'''", "2007-06-18", "12:00:00",
    "[[", "'../x'", "'" + "x" * 200 + "'", '"t [ms]"', '"{j}"', '"a ["', '"fem"', '"lagrange"', '"ball"', '"rest"',
)  # fmt: skip
PLAIN = (None, -1, 0, 2**70, 1e400, -0.5, "", "x" * 50, "\x1b[2J", "../x", [], {}, {"x": {}}, [[]] * 3, True)
INTEGERS = (0, 1, 2**7, 2**8 - 1, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)


def scene(data: bytes, random: Random) -> bytes:
    """Change, move, drop and double values, keys and tables of a TOML text."""
    lines = data.decode("utf-8", errors="replace").split("\n")
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        at = random.randrange(len(lines))
        key, equals, value = lines[at].partition("=")
        kind = random.randrange(8)
        if kind < 3 and equals:
            lines[at] = f"{key}= {_number(value.strip(), random) if kind else random.choice(VALUES)}"
        elif kind == 3:
            lines[at] = _misspelt(key, random) + equals + value
        elif kind == 4:
            lines.insert(random.randrange(len(lines) + 1), lines[at])
        elif kind == 5 and len(lines) > 1:
            lines.pop(at)
        elif kind == 6:
            lines[at] = random.choice(("[", "[[", "", "a.")) + lines[at] + random.choice(("]", "", "'", " = 1"))
        else:
            return damaged("\n".join(lines).encode("utf-8", errors="replace"), random)
    return "\n".join(lines).encode("utf-8", errors="replace")


def table(data: bytes, random: Random) -> bytes:
    """Change, scale, drop and double cells, columns and rows of a table."""
    text = data.decode("utf-8", errors="replace")
    delimiter = "\t" if "\t" in text else ","
    rows, is_damaged = [line.split(delimiter) for line in text.split("\n")], False
    for _ in range(random.choice((1, 1, 2, 4))):
        at = random.randrange(len(rows))
        column = random.randrange(len(rows[0])) if rows[0] else 0
        kind = random.randrange(9)
        if kind < 2 and column < len(rows[at]):
            rows[at][column] = random.choice(NUMBERS) if kind else _number(rows[at][column], random)
        elif kind < 4:
            _scale(rows, column, 10.0 ** random.choice((-320, -30, -9, -6, -3, -1, 1, 3, 6, 9, 15, 30, 300)))
        elif kind == 4 and rows[0]:
            rows[0][column % len(rows[0])] = _misspelt(rows[0][column % len(rows[0])], random)
        elif kind == 5 and len(rows) > 1:
            rows.pop(at)
        elif kind == 6:
            rows.insert(random.randrange(len(rows) + 1), list(rows[at]))
        elif kind == 7:
            rows = [row[:column] + row[column + 1 :] for row in rows]
        else:
            is_damaged = True
            break
    content = "\n".join(delimiter.join(row) for row in rows).encode("utf-8", errors="replace")
    return damaged(content, random) if is_damaged else content


def damaged(data: bytes, random: Random) -> bytes:
    """Change bits, bytes and words, move pieces, cut off the end."""
    content = bytearray(data)
    for _ in range(random.choice((1, 1, 1, 2, 4, 16))):
        if not content:
            break
        at, kind = random.randrange(len(content)), random.randrange(8)
        if kind < 3:
            content[at] ^= 1 << random.randrange(8)
        elif kind == 3:
            content[at] = random.randrange(256)
        elif kind < 6:
            width = random.choice((2, 4, 8))
            content[at : at + width] = (random.choice(INTEGERS) % 2 ** (8 * width)).to_bytes(width, "little")
        elif kind == 6:
            start, length = random.randrange(len(content)), random.randrange(64)
            content[at : at + length] = content[start : start + length]
        elif random.random() < 0.2:
            del content[at:]
    return bytes(content)


def facts(data: bytes, random: Random) -> bytes:
    """Change a value somewhere in the JSON about a study, or bytes of it."""
    try:
        whole = json.loads(data) if random.random() >= 0.3 else None
    except (ValueError, RecursionError):
        whole = None
    if whole is None:
        return damaged(data, random)
    place, key = {"": whole}, ""
    while isinstance(place[key], dict | list) and place[key] and random.random() < 0.8:
        place = place[key]
        key = random.choice(list(place)) if isinstance(place, dict) else random.randrange(len(place))
    place[key] = random.choice(PLAIN) if random.random() < 0.7 else [place[key]] * random.randrange(4)
    return json.dumps(whole if key != "" else place[""]).encode()


MUTATIONS: dict[str, Callable[[bytes, Random], bytes]] = {
    **dict.fromkeys(("scene", "study"), scene), "folder": facts,
    **dict.fromkeys(("heights", "speeds", "loads", "table", "record_text"), table),
    **dict.fromkeys(("record_wav", "record_numpy"), damaged),
}  # fmt: skip


def _number(text: str, random: Random) -> str:
    try:
        value = float(text)
    except ValueError:
        return random.choice(VALUES)
    factor = random.choice((-1.0, 0.0, 0.5, 0.99, 1.01, 2.0, 10.0, 1e3, 1e-3, 1e6, 1e-6, 1e300))
    return str(round(value * factor)) if random.random() < 0.3 and abs(value * factor) < 1e18 else str(value * factor)


def _misspelt(text: str, random: Random) -> str:
    if not text:
        return random.choice(("x", '"\\u001b"', "'"))
    at = random.randrange(len(text))
    return text[:at] + random.choice(("", "x", text[at] * 2, "\x1b", '"')) + text[at + 1 :]


def _scale(rows: list[list[str]], column: int, factor: float) -> None:
    for row in rows[1:]:
        try:
            row[column] = repr(float(row[column]) * factor)
        except (ValueError, IndexError):
            continue
