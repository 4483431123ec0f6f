"""Bearings, bodies and loads that tests and verification share, each built once a session; states of the time loop."""

from copy import deepcopy
from dataclasses import replace
from functools import cache
from math import pi

import numpy as np

from fem.contacts.model import Model
from fem.contacts.resolved import ResolvedModel
from fem.contacts.subgrid import SubgridModel
from fem.elastic.bodies import DiscBody, RingBody, disc_body, ring_body
from fem.elastic.reciprocal_mass import LUMPED, ReciprocalMass
from fem.kernels.columns import BLOCKS, N_SCALARS
from fem.kernels.elements.loop import advance
from fem.solver.elements.arrays import Arrays, make_arrays
from fem.solver.elements.start import Start, equilibrium_start, rest_start
from lagrange import Bearing, Material, Operation
from lagrange.scene.scene import read_scene
from meshes import Annulus, Disc

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
STEEL_ON_STEEL = {"roller": STEEL, "inner_ring": STEEL, "outer_ring": STEEL}
LENGTH = 0.01  # of the paper's rollers, m
LOAD = 2000.0  # N, the paper's
ON_A_ROLLER = -0.5 * pi  # angle of the first roller: the load's direction
HALF_PITCH = ON_A_ROLLER + pi / 13.0  # the paper's load between two rollers
LARGEST_FORCE = 650.0  # N, about what the paper's load puts on one roller


@cache
def paper(**changes) -> Bearing:
    """The paper's bearing: 13 rollers of 10 mm between 36 and 56 mm."""
    return replace(read_scene().ideal_bearing(), **changes)


SHAPES = {
    "paper": paper(),
    "clearance": paper(outer_raceway_radius=0.02801),
    "preload": paper(outer_raceway_radius=0.027995),
    "three rollers": paper(n_rollers=3),
    "full complement": paper(n_rollers=14),
    "ceramic rollers": paper(roller=Material(youngs_modulus=310e9, poisson_ratio=0.26, density=3200.0)),
    "light-alloy housing": paper(outer_ring=Material(youngs_modulus=70e9, poisson_ratio=0.33, density=2700.0)),
    "large": Bearing(
        n_rollers=17, roller_radius=0.012, roller_length=0.03, inner_raceway_radius=0.06,
        outer_raceway_radius=0.08402, bore_radius=0.045, outside_radius=0.1, **STEEL_ON_STEEL,
    ),
    "small": Bearing(
        n_rollers=11, roller_radius=0.001, roller_length=0.003, inner_raceway_radius=0.004,
        outer_raceway_radius=0.006, bore_radius=0.003, outside_radius=0.0075, **STEEL_ON_STEEL,
    ),
    "thin rings": paper(bore_radius=0.0155, outside_radius=0.0305),
    "many rollers": Bearing(
        n_rollers=31, roller_radius=0.004, roller_length=0.012, inner_raceway_radius=0.045,
        outer_raceway_radius=0.053, bore_radius=0.037, outside_radius=0.06, **STEEL_ON_STEEL,
    ),
}  # fmt: skip


def fair_load(bearing: Bearing) -> float:
    """A load, N, that presses like the paper's 2000 N."""
    return LOAD * bearing.roller_radius * bearing.roller_length / (0.005 * LENGTH)


@cache
def model(bearing: Bearing, mesh_size: float) -> Model:
    return SubgridModel.build(bearing, mesh_size)


@cache
def disc(radius: float, layers: int, material: Material = STEEL) -> DiscBody:
    """A roller of LENGTH with 6·layers surface nodes."""
    return disc_body(Disc(radius=radius, layers=layers), material, LENGTH)


@cache
def ring(
    inner: float, outer: float, sectors: int, layers: int, held_inside: bool, material: Material = STEEL
) -> RingBody:
    """A ring of LENGTH."""
    shape = Annulus(inner_radius=inner, outer_radius=outer, sectors=sectors, layers=layers)
    return ring_body(shape, material, LENGTH, held_inside)


@cache
def soft(**changes) -> Bearing:
    """The paper's bearing of a plastic (5 GPa): its contacts are 0.3 mm wide on either side."""
    plastic = replace(STEEL, youngs_modulus=5e9)
    return paper(roller=plastic, inner_ring=plastic, outer_ring=plastic, **changes)


@cache
def resolved_model(bearing: Bearing, mesh_size: float) -> Model:
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
    mass: ReciprocalMass = LUMPED,
) -> Arrays:
    """Arrays of the time loop at t = 0."""
    return make_arrays(a_model, how, start_of(a_model, how, from_rest), dt, friction, ramp, LARGEST_FORCE, mass)


def copies(state: Arrays) -> Arrays:
    """An independent copy; what arrays its parts share they share in the copy."""
    return deepcopy(state)


def loop_arguments(state: Arrays) -> tuple:
    return state.bodies, state.groups, state.contacts, state.drive, state.scratch


def run(state: Arrays, n_samples: int, stride: int) -> np.ndarray:
    """Run on and return the samples, (n_samples, n_columns); the state is left at its end."""
    samples = np.zeros((n_samples, N_SCALARS + len(BLOCKS) * state.bodies.rollers.n))
    status, step, body = advance(*loop_arguments(state), 0, stride, samples)
    assert (status, step, body) == (0, n_samples * stride, -2)
    return samples


def block(samples: np.ndarray, name: str) -> np.ndarray:
    """One quantity of every roller, (n_samples, n_rollers)."""
    n = (samples.shape[1] - N_SCALARS) // len(BLOCKS)
    at = N_SCALARS + BLOCKS.index(name) * n
    return samples[:, at : at + n]
