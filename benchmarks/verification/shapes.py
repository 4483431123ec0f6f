"""Bodies and bearings of many shapes, each built once a session, and loads that press them alike."""

from dataclasses import replace
from functools import cache
from math import pi

from fem.contacts import Model, SubgridModel
from fem.elastic.bodies import DiscBody, RingBody, disc_body, ring_body
from lagrange import Bearing, Material
from lagrange.scene import read_scene
from meshes import Annulus, Disc

STEEL = Material(youngs_modulus=210e9, poisson_ratio=0.3, density=7850.0)
STEEL_ON_STEEL = {"roller": STEEL, "inner_ring": STEEL, "outer_ring": STEEL}
LENGTH = 0.01  # of the paper's rollers, m
LOAD = 2000.0  # N, the paper's
ON_A_ROLLER = -0.5 * pi  # angle of the first roller: the load's direction
HALF_PITCH = ON_A_ROLLER + pi / 13.0  # the paper's load between two rollers


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
