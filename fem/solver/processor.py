"""The processor a run is made for: kernels compiled for another one round in other places."""

import hashlib
import os


def processor() -> dict[str, str]:
    """Its name and what it can do, as the compiler knows them, or as numba's settings have it."""
    from llvmlite import binding  # without numba, which a run of the Lagrangian model does not need

    name = os.environ.get("NUMBA_CPU_NAME") or binding.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES")
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    return {"processor": name, "instructions": hashlib.sha256(features.encode()).hexdigest()[:8]}
