"""The installed commands. A signal waits until the command that is being loaded can end in good order."""

import signal

if hasattr(signal, "pthread_sigmask"):  # before all else: `residual.cli` takes the signals that have come
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})


def check_residual() -> None:
    """`check-residual`."""
    from residual.cli import check_residual

    check_residual()


def check_vibration() -> None:
    """`check-vibration`."""
    from residual.check_vibration import app
    from residual.cli import check_residual

    check_residual(app)
