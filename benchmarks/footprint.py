"""What a run needs beside its time loop: memory, and the time from the command to the first step."""

import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.measuring import processor_seconds

PEAK = """
import sys
from pathlib import Path
from fem.solver.simulate import make_plan, run
from lagrange.scene.scene import read_scene
plan = make_plan(read_scene(None, (f"numerics.mesh_size_mm={sys.argv[1]}", "numerics.duration_ms=0.02")))
plan.prepare()
run(plan, lambda samples: None)
peak = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
print(plan.model.degrees_of_freedom, 1024 * int(peak.split()[1]))  # getrusage would know the parent's, too
"""


def peak_bytes(size_mm: float) -> tuple[int, int]:
    """Degrees of freedom of the paper's scene, and the most memory a process takes to set it up and run it, bytes."""
    for _ in range(2):  # the second time nothing is compiled
        done = subprocess.run([sys.executable, "-c", PEAK, str(size_mm)], capture_output=True, text=True, check=True)
    freedom, peak = done.stdout.split()
    return int(freedom), int(peak)


def start_seconds(repeats: int = 7) -> tuple[float, float]:
    """Wall and processor time of a whole `run-fem` of one sample at 1 mm, caches warm, medians, s."""
    walls, processors = [], []
    with tempfile.TemporaryDirectory() as folder:
        run_fem = [sys.executable, "-m", "fem.commands.run_fem"]
        command = [*run_fem, "--quiet", "--duration", "0.01", "--output", f"{folder}/run.nc"]
        for attempt in range(repeats + 1):
            before, began = processor_seconds(resource.RUSAGE_CHILDREN), time.perf_counter()
            subprocess.run(command, check=True, cwd=Path(__file__).parent.parent)
            if attempt:
                walls.append(time.perf_counter() - began)
                processors.append(processor_seconds(resource.RUSAGE_CHILDREN) - before)
    return statistics.median(walls), statistics.median(processors)
