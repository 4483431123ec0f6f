"""What commands print as plain sentences; `code` is the exit code."""


class UsageError(ValueError):
    """What the user asked for can't be done; the text says why and what to do."""

    code = 2


class RunFailed(RuntimeError):
    """A run went wrong numerically; the text says where and what to do."""

    code = 1
