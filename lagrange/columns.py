"""Columns of a run's samples, each declared here alone: the result file, its readers and the handbook follow.

A column more is a line here and the kernel, or the formula in `fem.solver.row_state`, that fills it.
"""

from typing import NamedTuple

FORMAT_VERSION = 1  # of result files
PER_TIME, PER_ROLLER = ("time",), ("time", "roller")
ENERGIES = ("energy_kinetic", "energy_elastic", "energy_contact", "work_external", "work_dissipated")  # of the balance

BEYOND = "that surface faults allow beyond perfect circles"


class Column(NamedTuple):
    """A variable of the result file."""

    dimensions: tuple[str, ...]
    unit: str
    meaning: str


# unit and meaning, by the part of a scene without which they are absent, in the order in which the time loops write
# those of a part
COLUMNS: dict[str, dict[str, tuple[str, str]]] = {
    "": {
        "time": ("s", "time"),
        "inner_x": ("m", "hub centre, x"),
        "inner_y": ("m", "hub centre, y (up; the load acts along -y)"),
        "inner_vx": ("m/s", "hub velocity, x"),
        "inner_vy": ("m/s", "hub velocity, y"),
        "inner_ax": ("m/s2", "hub acceleration of the integrator, x"),
        "inner_ay": ("m/s2", "hub acceleration of the integrator, y"),
        "roller_x": ("m", "roller's centre of mass, x"),
        "roller_y": ("m", "roller's centre of mass, y"),
        "roller_rho": ("m", "roller's distance from the outer ring's centre"),
        "roller_theta": ("rad", "roller's angle from +x, counter-clockwise, unwrapped"),
        "roller_spin": ("rad/s", "roller's spin in the fixed frame"),
        "inner_force": ("N", "normal force, inner raceway on roller"),
        "outer_force": ("N", "normal force, outer raceway on roller"),
        "inner_traction": ("N", "tangential force of the inner raceway on the roller, along +theta"),
        "outer_traction": ("N", "tangential force of the outer raceway on the roller, along +theta"),
        "roller_roller_force": ("N", "normal force, roller j on roller j + 1"),
        "energy_kinetic": ("J", "kinetic energy of all bodies"),
        "energy_elastic": ("J", "elastic energy of the meshes"),
        "energy_contact": ("J", "elastic energy of the contacts below the grid"),
        "work_external": ("J", "work of load, gravity and drive since the start"),
        "work_dissipated": ("J", "work dissipated since the start"),
    },
    "housing": {
        "housing_x": ("m", "housing, x; without a fit also the outer ring's centre"),
        "housing_y": ("m", "housing, y"),
        "housing_ax": ("m/s2", "acceleration of the housing, x"),
        "housing_ay": ("m/s2", "acceleration of the housing, y"),
        "energy_support": ("J", "energy of the springs under the housing"),
    },
    "sensor": {"sensor_ay": ("m/s2", "acceleration that the sensor shows, y")},
    "shaft": {"energy_shaft": ("J", "energy of the shaft's springs")},
    "bore": {
        "outer_ring_x": ("m", "outer ring's centre, x: mean of its outside"),
        "outer_ring_y": ("m", "outer ring's centre, y"),
        "outer_ring_ax": ("m/s2", "acceleration of the outer ring, x"),
        "outer_ring_ay": ("m/s2", "acceleration of the outer ring, y"),
        "bore_force_x": ("N", "force of the bore on the outer ring, x"),
        "bore_force_y": ("N", "force of the bore on the outer ring, y"),
        "bore_arc": ("rad", "angle over which the outer ring touches its bore"),
    },
    "surfaces": {  # that are not perfect circles
        "roller_turn": ("rad", "roller's rotation about its axis since t = 0, fixed frame"),
        "inner_sinkage": ("m", f"approach of inner ring and roller {BEYOND}"),
        "outer_sinkage": ("m", f"approach of outer ring and roller {BEYOND}"),
    },
    "cage": {
        "cage_x": ("m", "cage centre, x"),
        "cage_y": ("m", "cage centre, y"),
        "cage_angle": ("rad", "cage's rotation since t = 0"),
        "cage_speed": ("rad/s", "cage's angular speed"),
        "cage_guidance_x": ("N", "force of the guiding ring on the cage, x; 0 where rollers guide it"),
        "cage_guidance_y": ("N", "force of the guiding ring on the cage, y; 0 where rollers guide it"),
        "cage_work_dashpots": ("J", "energy dissipated by the cage's dashpots since the start"),
        "cage_work_friction": ("J", "energy dissipated by the cage's friction since the start"),
        "cage_work_drag": ("J", "work of the cage's drag torque since the start"),
        "cage_force": ("N", "force of the cage on the roller along the pitch circle; positive: forward"),
        "cage_radial_force": ("N", "force of the cage on the roller, outward"),
        "cage_moment": ("N m", "friction torque of the cage on the roller"),
    },
    "damping": {  # of contacts or of bodies
        "inner_damping_force": ("N", "damping part of inner_force"),
        "outer_damping_force": ("N", "damping part of outer_force"),
        "work_damping_contact": ("J", "part of work_dissipated by contact damping"),
        "work_damping_bodies": ("J", "part of work_dissipated by damping of the bodies"),
    },
    "axial": {
        "roller_tilt": ("rad", "roller's tilt: its +z end outwards where > 0"),
        "roller_skew": ("rad", "roller's skew: its +z end backwards, against +theta, where > 0"),
        "inner_moment": ("N m", "moment of inner_force along the axis: force times z"),
        "outer_moment": ("N m", "moment of outer_force along the axis: force times z"),
        "inner_slope_x": ("rad", "slope of the hub's axis along z, x"),
        "inner_slope_y": ("rad", "slope of the hub's axis along z, y"),
    },
    "damping of tilt": {
        "inner_damping_moment": ("N m", "damping part of inner_moment"),
        "outer_damping_moment": ("N m", "damping part of outer_moment"),
    },
}


# of rollers that tilt, from forces and moments: computed where they are asked for, stored nowhere
EDGES = "NaN where an end is loaded whose profile ends with an edge: pressure has no limit there"
OF_TILTED = {
    f"{side}_peak_pressure": Column(PER_ROLLER, "Pa", f"largest pressure along the roller, {side} raceway; {EDGES}")
    for side in ("inner", "outer")
}
# of line contacts by Hertz, from the forces, likewise
DERIVED = {
    "inner_peak_pressure": Column(PER_ROLLER, "Pa", "largest Hertz pressure, inner raceway and roller"),
    "outer_peak_pressure": Column(PER_ROLLER, "Pa", "largest Hertz pressure, outer raceway and roller"),
    "inner_half_width": Column(PER_ROLLER, "m", "half-width of the contact of inner raceway and roller"),
    "outer_half_width": Column(PER_ROLLER, "m", "half-width of the contact of outer raceway and roller"),
}


def columns_of(*parts: str) -> dict[str, Column]:
    """Columns of some parts of a scene, in the order of COLUMNS; of the part "" every run has them."""
    return {name: Column(PER_ROLLER if per_roller(name) else PER_TIME, *about)
            for part in COLUMNS if part in parts for name, about in COLUMNS[part].items()}  # fmt: skip


def per_roller(name: str) -> bool:
    """Whether a quantity has one column per roller: its name says so."""
    return name.startswith("roller_") or name.endswith(("_force", "_traction", "_moment", "_sinkage"))
