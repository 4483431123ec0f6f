"""Libraries that obey settings of the current folder, of the user's or of variables, loaded so that they find none.

Stands on the ground floor: pictures, reports and studies draw by the same library.
"""

import contextlib
import os
import sys
from importlib import import_module
from pathlib import Path


def load_matplotlib() -> None:
    """Load matplotlib with its own defaults, and to draw into memory. One that is loaded already stays as it is.

    It looks for `matplotlibrc` in the current folder first, then where MATPLOTLIBRC leads.
    """
    if "matplotlib" in sys.modules:
        return
    variables = {"MATPLOTLIBRC": os.devnull, "MPLBACKEND": "Agg"}
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        with contextlib.chdir(Path(__file__).parent):
            import_module("matplotlib")
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
