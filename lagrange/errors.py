"""Errors that commands print as plain sentences, with the exit code, and limits that values exceed."""


class UsageError(ValueError):
    """What the user asked for can't be done; the text says why and what to do."""

    code = 2


class RunFailed(RuntimeError):
    """A run went wrong numerically; the text says where and what to do."""

    code = 1


ROUND_OFF = 1e-9  # relative


def exceeds(value, limit):
    """Whether a value is above a limit by more than round-off; any shape."""
    return value - limit > ROUND_OFF * abs(limit)


class InputError(UsageError):
    """The checker can't use its input; the message names the file, the value, the limit and what to do."""
