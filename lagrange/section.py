"""The plane section of one row, at right angles to its lines of contact, for a bearing of any contact angle and rows.

Models compute this section. With contact angle α, i rows that share loads evenly, elements of diameter D on the pitch
diameter d_m, it has circles of D cos α on d_m, which keep γ = D cos α/d_m and so the speed of the cage, and raceways
whose contacts run as fast as the bearing's. The hub's coordinates are approaches: a radial displacement u of the shaft
closes contacts by u cos α. Contact forces Q are the normal ones of one row's elements; their radial parts Q cos α
carry the load. By virtual work

    section's displacement = u cos α,   force = F/(i cos α),   stiffness, damping, mass = those over i cos²α,

gravity is g cos α, so that weights are forces too. An element has its mass times cos α, so that its centrifugal
force is the component along its contacts. Curvatures of contacts are the bearing's own, (1/D and cos α/R): see
`contact_pairs`.

Left out: the axial force Q sin α and the shift that it causes, so a second bearing, or row, must take it; a flange;
the change of α under load and speed, by which unloaded elements bear all of their centrifugal force at the outer
raceway; gyroscopic moments. Elements turn by 1/cos α too fast about their own axes; their inertia in strikes and
their weight are by cos α too small.

Source: Harris, Rolling Bearing Analysis (4th ed. 2001), chapters 7 (radial loads by cos α) and 8 (γ).
"""

from dataclasses import replace

from lagrange.bearing import Bearing, Operation
from lagrange.mounting import Mounting


def is_plain(bearing: Bearing) -> bool:
    """Whether the bearing is its own section: one row at contact angle 0."""
    return bearing.contact_angle == 0.0 and bearing.rows == 1


def load_factor(bearing: Bearing) -> float:
    """A radial load of the bearing over that of its section, i cos α."""
    return bearing.rows * bearing.cosine


def stiffness_factor(bearing: Bearing) -> float:
    """Radial stiffness, damping or mass of the bearing over that of its section, i cos²α."""
    return bearing.rows * bearing.cosine**2


def section_operation(bearing: Bearing, operation: Operation) -> Operation:
    """What acts in the section where `operation` acts on the bearing."""
    if is_plain(bearing):
        return operation
    load, stiffness = load_factor(bearing), stiffness_factor(bearing)
    history = operation.history
    if history is not None:
        history = replace(
            history,
            load=type(history.load)(history.load.c / load, history.load.x),
            unbalance=history.unbalance / load,
            rotating_load=history.rotating_load / load,
        )
    return replace(
        operation, radial_load=operation.radial_load / load, side_load=operation.side_load / load,
        inner_mass=operation.inner_mass / stiffness, gravity=operation.gravity * bearing.cosine,
        mounting=section_mounting(bearing, operation.mounting), history=history,
    )  # fmt: skip


def section_mounting(bearing: Bearing, mounting: Mounting) -> Mounting:
    """Springs, dashpots and housing as the section has them."""
    if is_plain(bearing):
        return mounting
    share, shaft, housing = 1.0 / stiffness_factor(bearing), mounting.shaft, mounting.housing
    if shaft is not None:
        shaft = replace(shaft, stiffness=share * shaft.stiffness, damping=share * shaft.damping)
    if housing is not None:
        housing = replace(
            housing, mass=share * housing.mass, stiffness=share * housing.stiffness, damping=share * housing.damping
        )
    return replace(mounting, shaft=shaft, housing=housing)


def section_words(bearing: Bearing) -> str:
    """What the section is of, for people; empty of a plain one."""
    if is_plain(bearing):
        return ""
    rows = "one row" if bearing.rows == 1 else f"one of {bearing.rows} rows"
    return (
        f"of {rows} at right angles to its contacts, contact angle {bearing.contact_angle_deg:.4g}°: forces are normal "
        f"ones of its elements, the radial load over {load_factor(bearing):.4g}; displacements are radial ones times "
        f"{bearing.cosine:.4g}"
    )
