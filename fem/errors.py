"""The errors that the commands print as plain sentences."""


class UsageError(ValueError):
    """What the user asked for can't be done; the text says why and what to do."""


class RunFailed(RuntimeError):
    """A run went wrong numerically; the text says where and what to do."""
