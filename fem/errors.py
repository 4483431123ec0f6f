"""The error that the commands print as a plain sentence."""


class UsageError(ValueError):
    """What the user asked for can't be done; the text says why and what to do."""
