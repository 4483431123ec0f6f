"""Small bearings and bodies that many tests share, each meshed once per session in a mesh folder of the tests' own."""

import tempfile
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from unittest import mock

import numpy as np

from benchmarks.verification import shapes
from benchmarks.verification.shapes import LENGTH, STEEL, paper
from fem.contacts import Model, ResolvedModel
from fem.elastic.bodies import DiscBody, RingBody
from fem.kernels.sample_kernels import BLOCKS, N_SCALARS
from fem.kernels.time_loop import advance
from fem.solver.arrays import Arrays, make_arrays
from fem.solver.start import Start, equilibrium_start, rest_start
from lagrange import Bearing, Material, Operation
from lagrange.scene import read_scene

__all__ = [
    "LENGTH", "STEEL", "arrays", "block", "copies", "copy_of", "disc", "loop_arguments", "model", "operation",
    "own_folder", "paper", "resolved_model", "ring", "run", "soft", "start_of",
]  # fmt: skip

LARGEST_FORCE = 650.0  # N, about what the paper's load puts on one roller
_FOLDER = tempfile.TemporaryDirectory(prefix="test-meshes-")


def own_folder():
    """Meshes go into a folder of the tests' own."""
    return mock.patch("meshes.cache.cache_folder", lambda: Path(_FOLDER.name))


def disc(radius: float, layers: int, material: Material = STEEL) -> DiscBody:
    with own_folder():
        return shapes.disc(radius, layers, material)


def ring(inner: float, outer: float, sectors: int, layers: int, held_inside: bool) -> RingBody:
    with own_folder():
        return shapes.ring(inner, outer, sectors, layers, held_inside)


def model(bearing: Bearing, mesh_size: float) -> Model:
    with own_folder():
        return shapes.model(bearing, mesh_size)


@lru_cache
def soft(**changes) -> Bearing:
    """The paper's bearing of a plastic (5 GPa): its contacts are 0.3 mm wide on either side."""
    plastic = replace(STEEL, youngs_modulus=5e9)
    return paper(roller=plastic, inner_ring=plastic, outer_ring=plastic, **changes)


@lru_cache
def resolved_model(bearing: Bearing, mesh_size: float) -> Model:
    with own_folder():
        return ResolvedModel.build(bearing, mesh_size)


def operation(**changes) -> Operation:
    """The paper's operating point."""
    return replace(read_scene().ideal_operation(), **changes)


def start_of(a_model: Model, how: Operation, from_rest: bool = False) -> Start:
    return (rest_start if from_rest else equilibrium_start)(a_model, how)


def arrays(
    a_model: Model,
    how: Operation,
    dt: float,
    friction: float = 0.0,
    from_rest: bool = False,
    ramp: float = 0.0,
    threads: int = 1,
) -> Arrays:
    """Arrays at t = 0."""
    return make_arrays(a_model, how, start_of(a_model, how, from_rest), dt, friction, ramp, LARGEST_FORCE, threads)


def copy_of(state):
    """An independent copy of one named tuple of the time loop."""
    return type(state)(*(entry.copy() if isinstance(entry, np.ndarray) else entry for entry in state))


def copies(state: Arrays) -> Arrays:
    return Arrays(**{name: copy_of(getattr(state, name)) for name in state.__dataclass_fields__})


def loop_arguments(state: Arrays) -> tuple:
    return state.rollers, state.inner, state.outer, state.contacts, state.drive, state.scratch


def run(state: Arrays, n_samples: int, stride: int) -> np.ndarray:
    """Samples (n_samples, n_columns) of a run; the state is left at its end."""
    samples = np.zeros((n_samples, N_SCALARS + len(BLOCKS) * state.rollers.n))
    status, step, body = advance(*loop_arguments(state), 0, stride, samples)
    assert (status, step, body) == (0, n_samples * stride, -2)
    return samples


def block(samples: np.ndarray, name: str) -> np.ndarray:
    """One quantity of every roller, (n_samples, n_rollers)."""
    n = (samples.shape[1] - N_SCALARS) // len(BLOCKS)
    at = N_SCALARS + BLOCKS.index(name) * n
    return samples[:, at : at + n]
