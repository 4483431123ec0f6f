"""Exception for input that the checker can't use."""


class InputError(ValueError):
    """The run can't be used; the message names the file, the value, the limit and what to do."""
