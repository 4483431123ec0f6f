"""The processor a run is made for: kernels compiled for another one round in other places."""

import hashlib


def processor() -> dict[str, str]:
    """Its name and what it can do, as the compiler knows them."""
    from llvmlite import binding
    from numba.core import config

    name = config.CPU_NAME or binding.get_host_cpu_name()
    features = config.CPU_FEATURES
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    return {"processor": name, "instructions": hashlib.sha256(features.encode()).hexdigest()[:8]}
