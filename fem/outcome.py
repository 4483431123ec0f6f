"""How a command ends: every outcome with its exit code and its sentence, in one place."""

from enum import Enum


class Outcome(Enum):
    """Exit code, what the user is told, and for runs the `status` in the result file."""

    COMPLETE = 0, "", "complete"
    FAILED = 1, "error: failed: {reason}\nsamples up to then are in {path}", "failed: {reason}"
    FAILED_AT_START = 1, "error: {reason}\nnothing was written", None
    UNUSABLE = 2, "error: {reason}", None
    ENDED = 130, "interrupted", None  # where there is no run
    ENDED_BY_TERM = 143, "interrupted", None
    INTERRUPTED = 130, "interrupted at {time:.3f} ms; {left}", "interrupted"
    TERMINATED = 143, "interrupted at {time:.3f} ms; {left}", "interrupted"
    # of a complete run whose error was to be estimated
    ESTIMATE_FAILED = (
        1, "error: the run on the coarser mesh failed: {reason}\n{path} is complete, without an estimate", None,
    )  # fmt: skip
    ESTIMATE_INTERRUPTED = 130, "interrupted; {path} is complete, without an estimate", None
    ESTIMATE_TERMINATED = 143, "interrupted; {path} is complete, without an estimate", None

    def __init__(self, code: int, sentence: str, status: str | None):
        self.code, self._sentence, self._status = code, sentence, status

    def told(self, **facts: object) -> str:
        """What to tell the user."""
        return self._sentence.format(**facts)

    def status(self, reason: object = "") -> str:
        """What the result file says of it."""
        return self._status.format(reason=reason)
