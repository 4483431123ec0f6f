"""The installed commands. A signal waits until the command that is being loaded can end in good order."""

import os
import signal

if hasattr(signal, "pthread_sigmask"):  # before all else; `run_app_main` hears those that have come
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})

# matrices are small: further threads of theirs would only wait, and waiting takes processor time too
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from lagrange.commands import entry

run_fem, run_live = entry("fem.commands.run_fem:run_main"), entry("fem.commands.run_fem:live_main")
render_fem = entry("fem.commands.render_fem:render_main")
run_study = entry("fem.commands.run_study:study_main")
rate_bearing = entry("fem.commands.rate_bearing:rate_main")
