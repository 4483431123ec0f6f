"""The installed commands. A signal waits until the command that is being loaded can end in good order."""

import os
import signal

if hasattr(signal, "pthread_sigmask"):  # before all else; `run_app_main` hears those that have come
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # others would only wait, and waiting takes their time too

from lagrange.commands import entry

check_residual = entry("residual.cli:main")
check_vibration = entry("residual.check_vibration:main")
