"""Exception for input that the checker can't use."""

from lagrange.errors import UsageError


class InputError(UsageError):
    """The run can't be used; the message names the file, the value, the limit and what to do."""
