"""The hub's static displacement with the outer ring held around few points of its outside only."""

from dataclasses import dataclass

import numpy as np

from fem.contacts.model import standing
from fem.solver.elements.plan import model_of
from fem.statics.contact_balance import Loads
from fem.statics.equilibrium import equilibrium
from lagrange.scene.scene import Scene, read_scene

MESH = 1e-3  # m
HALF_SUPPORT = 3e-3  # m, along the outside; much less would be a hinge
POSITIONS = 4  # of the rollers over one pitch

SUPPORTS = {  # degrees from the load
    "all around": None,
    "top": (180.0,),
    "bottom": (0.0,),
    "both sides": (90.0, 270.0),
    "top and 120° off": (180.0, 300.0, 60.0),
}
OUTSIDE_MM = (65.0, 62.0, 60.0)  # 4.5 mm behind the raceway, as in this project; 3 mm; 2 mm


@dataclass(frozen=True, kw_only=True)
class Held:
    """Positions of the hub under 2000 N while the rollers pass over one pitch, µm."""

    supports: str
    outside_mm: float
    x: tuple[float, float]
    y: tuple[float, float]
    loaded: tuple[int, int]
    widest: float  # largest displacement of the raceway


def held_cases() -> list[Held]:
    """Solve every ring with every support."""
    return [held(outside, name) for outside in OUTSIDE_MM for name in SUPPORTS]


def held(outside_mm: float, name: str) -> Held:
    """Solve one ring with one of SUPPORTS."""
    model = model_of(scene_held(outside_mm, name))
    scene = read_scene()
    load, pitch = scene.operation.radial_load_N, 2.0 * np.pi / model.bearing.n_rollers
    first = scene.ideal_operation().first_roller_angle
    hubs, counts, widest = [], [], 0.0
    for angle in first + pitch * np.arange(POSITIONS) / POSITIONS:
        found = equilibrium(model, standing(model.bearing, angle), Loads(load))
        hubs.append(1e6 * found.hub)
        counts.append(int(np.count_nonzero(found.inner_force)))
        widest = max(widest, 1e6 * float(np.hypot(*found.outer_ring[model.outer_ring.raceway_row]).max()))
    x, y = np.array(hubs).T
    return Held(
        supports=name, outside_mm=outside_mm, x=(x.min(), x.max()), y=(y.min(), y.max()),
        loaded=(min(counts), max(counts)), widest=widest,
    )  # fmt: skip


def settings_held(outside_mm: float, name: str) -> tuple[str, ...]:
    """What of the paper's scene differs."""
    angles, outside = SUPPORTS[name], f"bearing.outside_diameter_mm={outside_mm}"
    if angles is None:
        return (outside,)
    given = f"support.angles_deg={list(angles)}", f"support.width_mm={2e3 * HALF_SUPPORT:g}"
    return outside, "support.kind=points", *given


def scene_held(outside_mm: float, name: str) -> Scene:
    """The paper's scene with one ring held at one of SUPPORTS."""
    return read_scene(None, (*settings_held(outside_mm, name), f"numerics.mesh_size_mm={1e3 * MESH:g}"))
