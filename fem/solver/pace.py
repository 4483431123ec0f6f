"""How long this machine takes over what plans expect, from its last runs: processors differ threefold.

One small file in the user's cache folder holds, for each processor and model, the last runs' times over what their
plans would have said without it. Times are the processor's: a machine that works for others too would say nothing of
itself.
"""

import json
from contextlib import suppress
from pathlib import Path
from statistics import median

from lagrange.files.input import read_plain, user_cache
from lagrange.files.output import write_whole

KEPT = 5  # runs of each model: their median forgives one that shared its caches
SHORTEST = 0.01  # s, of a time loop that tells of the machine
LARGEST = 100.0  # and its inverse: what lies beyond was no run of this program


def pace_file() -> Path:
    """Where it is kept. OSError: the folder can't be made, or others can write there."""
    return user_cache() / "pace.json"


def pace(model: str) -> float:
    """By what a plan's own expectation is to be multiplied; 1 where no run of the model has been made here."""
    found = _read().get(_key(model), [])
    return median(found) if found else 1.0


def in_words(model: str, seconds: float) -> str:
    """A time to expect, and whether a run of the model has been timed here."""
    text = f"about {seconds:.2g} s"
    return (
        text
        if _read().get(_key(model))
        else (f"{text}, perhaps three times that: no run has been timed on this machine yet")
    )


def remember(model: str, expected: float, took: float) -> None:
    """Keep how long a run took of the processor; `expected` by its plan, times what is remembered so far, s."""
    if took < SHORTEST or not expected > 0.0:
        return
    ratio = took / expected * pace(model)
    if not 1.0 / LARGEST < ratio < LARGEST:
        return
    known, key = _read(), _key(model)
    known[key] = [*known.get(key, []), ratio][-KEPT:]
    with suppress(OSError):  # a cache folder that can't be written is no reason to fail
        write_whole(pace_file(), json.dumps(known).encode())


def _read() -> dict[str, list[float]]:
    """What is kept, as far as it is what `remember` writes."""
    try:
        known = json.loads(read_plain(pace_file()))
        return {
            str(key): [ratio for ratio in map(float, found) if 0.0 < ratio < LARGEST] for key, found in known.items()
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def _key(model: str) -> str:
    from fem.solver.compiling import processor

    return f"{model} on {processor()['processor']}, its own time"
