"""Plans whose time loop is compiled: loading it, what its bits depend on, how long this machine takes.

Of numba's private parts fem.solver uses these alone: its events of compiling, and the errors of what does not compile.

One small file in the user's cache folder holds, for each processor and model, the last runs' times over what their
plans would have said without it: processors differ threefold. Times are the processor's: a machine that works for
others too would say nothing of itself.
"""

import gc
import hashlib
import json
import os
import re
import time
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from statistics import median

import numpy as np

from fem.kernels import kernel_folder
from fem.quantities import largest_loads
from fem.solver.simulate import LARGEST_BLOCK
from fem.solver.solver import Plan
from lagrange.errors import RunFailed
from lagrange.files.input import read_plain, user_cache
from lagrange.files.output import write_whole
from lagrange.messages import said_if_long


def processor() -> dict[str, str]:
    """Its name and what it can do, as the compiler knows them, or as numba's settings have it."""
    from llvmlite import binding  # without numba, which a run of the Lagrangian model does not need

    name = os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES")
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    return {"processor": name, "instructions": hashlib.sha256(features.encode()).hexdigest()[:8]}


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
    unsure = ", perhaps three times that: no run has been timed on this machine yet"
    return f"about {seconds:.2g} s{'' if _read().get(_key(model)) else unsure}"


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


def _read():
    try:
        known = json.loads(read_plain(pace_file())).items()
        return {str(key): [ratio for ratio in map(float, found) if 0.0 < ratio < LARGEST] for key, found in known}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def _key(model):
    return f"{model} on {processor()['processor']}, its own time"


PATIENCE = 3.0  # s, to load the time loop; if it takes longer it is being compiled
CAUSE = re.compile(r"No implementation|Unknown attribute|Untyped global|Cannot |Invalid use|Unsupported")
COMPILING = "compiling the time loop, once for such bodies and contacts: "


def _cause(error):
    """What numba can't compile, and where, of the thousand lines in which it says so: the innermost ones."""
    lines = [line for line in re.sub(r"\x1b\[\d*m", "", str(error)).splitlines() if line.strip()]
    inner = max(len(line) - len(line.lstrip()) for line in lines if CAUSE.search(line))
    first = next(i for i, line in enumerate(lines) if CAUSE.search(line) and len(line) - len(line.lstrip()) == inner)
    place = next((line.strip().rstrip(":") for line in lines[first:] if line.strip().startswith("File ")), "")
    return f"{lines[first].strip()} ({place})"


class CompiledPlan(Plan):
    """A plan whose first state has `take_steps(count)`."""

    compiling_seconds = 30.0  # of one core of a server, before what this machine takes is known
    finer = "lower numerics.time_step_safety or numerics.mesh_size_mm"  # what keeps the energy better

    pressed_energy = property(lambda self: 0.0)  # What a press fit stores, J, and no motion can take out again

    def time_and_forces(self, inner: np.ndarray, outer: np.ndarray) -> dict[str, str]:
        """What --dry-run shows of the time to expect and the static forces, N, of both raceways' contacts."""
        found = largest_loads(self.bearing, inner.max(), outer.max(), tilts=self.scene.axial is not None)
        return {"expected time": in_words(self.scene.model, self.expected_seconds), "largest static forces": found}

    @property
    def compiling(self) -> str:
        """How long the compiler will take, in words."""
        key = f"compiling {self.scene.model}"
        return in_words(key, self.compiling_seconds * pace(key))

    def prepare(self, tell=None):
        """Compile the time loop, or load it compiled, without taking a step."""
        from fem.kernels.numba_private import TypingError, install_recorder

        collecting, began = gc.isenabled(), time.process_time()
        gc.disable()  # a compiler's many objects are nearly all kept: looking for cycles takes a tenth of its time
        try:
            long = "" if tell is None else COMPILING + self.compiling
            with said_if_long(PATIENCE, long, tell), install_recorder("numba:compile") as new:
                state = self.first_state()
                state.take_steps(0)
        except TypingError as error:
            raise RunFailed(f"the time loop does not compile: {_cause(error)}") from error
        finally:
            if collecting:
                gc.enable()
        took, key = time.process_time() - began, f"compiling {self.scene.model}"
        if new.buffer and took > PATIENCE:
            remember(key, self.compiling_seconds * pace(key), took)
        return state

    notices = property(lambda self: tuple(kernel_folder.notices))

    def versions(self):
        return {"kernels": kernel_folder.version(), "numba": version("numba"), **processor()}


ENOUGH = 0.1  # s of the processor, that a trial takes
LONGEST_SAMPLE = 0.5  # s, of a sample that is tried


class _Needed(RunFailed):
    """A function would have to be compiled."""


@contextmanager
def _nothing_compiled():
    """_Needed: what begins to compile is stopped."""
    from fem.kernels.numba_private import Listener, install_listener

    class Refusal(Listener):
        def on_start(self, event):
            raise _Needed("a function would have to be compiled")

        def on_end(self, event):
            pass

    with install_listener("numba:compile", Refusal()):
        yield


def is_compiled(plan: Plan) -> bool:
    """Whether the time loop need not be compiled; nothing is."""
    try:
        with _nothing_compiled():
            plan.prepare()
    except _Needed:
        return False
    return True


def seconds_by_trial(plan: Plan) -> float | None:
    """Processor time of the whole time loop, s; None where it would have to be compiled first, or takes no steps.

    The first steps stand for all: contacts that rattle, so that a run restarts with smaller steps, take longer.
    """
    from fem.kernels.numba_private import config

    if config.DISABLE_JIT or plan.n_samples < 2 or plan.expected_seconds > LONGEST_SAMPLE * (plan.n_samples - 1):
        return None
    try:
        with _nothing_compiled():
            state = plan.prepare()
            state.advance(1)
            size, warm, before = 1, state.done, state.processor
            while state.done < plan.n_samples and state.processor - before < ENOUGH:
                state.advance(min(size, plan.n_samples - state.done))
                size = min(2 * size, LARGEST_BLOCK)
    except RunFailed:
        return None
    taken = state.done - warm
    return (state.processor - before) / taken * (plan.n_samples - 1) if taken > 0 and state.processor > before else None
