"""Comparisons with limits that a user can type: a value that has changed its unit is off by round-off."""

ROUND_OFF = 1e-9  # relative


def exceeds(value, limit):
    """Whether a value is above a limit by more than round-off; any shape."""
    return value - limit > ROUND_OFF * abs(limit)
