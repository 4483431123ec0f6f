"""Packages that only some uses need, and that an installation without extras lacks."""

from importlib.util import find_spec

from fem.errors import UsageError


def need(package: str, user: str) -> None:
    """Refuse what needs a package that is not there, before any work for it is done.

    Errors
    ------
    UsageError: names the user, the package and the command that installs it.
    """
    if find_spec(package) is None:
        raise UsageError(f"{user}: needs {package}, which is not installed: python -m pip install {package}")
