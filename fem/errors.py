"""The errors that the commands print as plain sentences."""

from lagrange.errors import RunFailed, UsageError

__all__ = ["RunFailed", "UsageError"]
