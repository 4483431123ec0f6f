"""`@kernel`: numba, compiled once per version of the code.

Numba's cache looks at the file a function stands in, not at the files of the functions it inlines: after a change to
one kernel it would go on running the old code inside the others. The cache folder is therefore named after the text of
all modules that hold kernels.
"""

import hashlib
import os
from functools import cache
from pathlib import Path

import platformdirs
from numba import config, njit


@cache
def cache_folder() -> Path:
    """Where this version's compiled kernels are kept: in NUMBA_CACHE_DIR, or the user's cache folder."""
    text = hashlib.sha256()
    for module in sorted(Path(__file__).parent.glob("*.py")):
        source = module.read_bytes()
        if module.name == "jit.py" or b"import kernel" in source or b"numba.extending" in source:
            text.update(module.name.encode() + source)
    base = os.environ.get("NUMBA_CACHE_DIR") or platformdirs.user_cache_dir("roller-bearing-fem")
    return Path(base) / "kernels" / text.hexdigest()[:16]


def is_compiled() -> bool:
    """Whether an earlier start has left compiled kernels of this version."""
    return any(cache_folder().rglob("*.nbc"))


def kernel(function=None, **options):
    """Compile a function of arrays and scalars; division follows IEEE 754 and raises nothing.

    Without numba's run-time memory: nothing is allocated (what would allocate does not compile), and arrays that the
    caller holds anyway are not counted, which would take a tenth of the time loop
    (https://github.com/numba/numba/issues/2350).
    """
    if function is None:
        return lambda wrapped: kernel(wrapped, **options)
    before, config.CACHE_DIR = config.CACHE_DIR, str(cache_folder())
    try:
        return njit(cache=True, error_model="numpy", _nrt=False, **options)(function)
    finally:
        config.CACHE_DIR = before
