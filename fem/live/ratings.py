"""Answers of rate-bearing that follow a viewer's sliders: of a scene with rigid rings on contact laws, within 50 ms."""

import time
import tomllib

import numpy as np
from pydantic import BaseModel, Field

from fem.live.player import MM, STEEPEST, UM, Control, controls, values_of
from fem.rating.answers import BLOCKS, Case, Options, Rating
from fem.rating.sheet import in_words, missing, sheet
from lagrange.kinematics import roller_angles
from lagrange.rating.sources import Unavailable
from lagrange.scene.scene import Scene, content_of, parse_scene
from lagrange.scene.surfaces import FROM_LOAD

ANGLES = 16  # of the cage in a pitch, 4 where rollers tilt: means are within 3 % of those of rate-bearing's 64 and 16
SLICES = 11  # of rollers that tilt
SLOW = "L10r_elastic", "L10r_pitch", "L10r_by_misalignment", "stiffness_harmonics"  # how names begin
LEFT_OUT = {name for rows in BLOCKS.values() for name, *_ in rows if name.startswith(SLOW) or "_run_" in name}
RATED = ("name", "bearing", "material", "fit", "operation", "damping", "lagrange", "support", "lubricant", "axial")
THRUST, THICKEST = 0.5, 200.0  # ends of sliders: share of the heaviest radial load; mm²/s
BEYOND = (  # the controls of motion
    Control("axial_load_N", "Axial load", "N", "on the shaft, towards its +z end", 0.0, 0.0, 10.0),
    Control("misalignment_mrad", "Misalignment", "mrad", "slope of the shaft; +z end towards the load", -STEEPEST,
            STEEPEST, 0.1),
    Control("viscosity_mm2_s", "Viscosity of the oil", "mm²/s", "in operation; 0: no lubricant", 0.0, THICKEST, 1.0),
)  # fmt: skip
MAIN = (  # above all blocks: of each the first that there is
    ("L10_h", "L10_Mrev"), ("L10r_h", "L10r_Mrev"), ("s0",), ("pressure_over_permitted",),
    ("largest_load_N", "peak_pressure_MPa"), ("kappa",))  # fmt: skip
LOADS = ("radial_load_N", "speed_rpm")
NOT_OF_ALL = ("axial_load_N", "misalignment_mrad")  # not every bearing takes them
ORDER = ("radial_load_N", "axial_load_N", "speed_rpm", "clearance_um", "misalignment_mrad", "viscosity_mm2_s")


class Wanted(BaseModel, extra="forbid", allow_inf_nan=False, frozen=True, strict=True):
    """A bearing and what acts on it; what is left out is the scene's, the clearance of another bearing its own."""

    bearing: str = Field("", max_length=40)  # designation; empty: the scene's bearing
    radial_load_N: float | None = None
    axial_load_N: float | None = None
    speed_rpm: float | None = None
    clearance_um: float | None = None
    misalignment_mrad: float | None = None
    viscosity_mm2_s: float | None = Field(None, ge=0.0, le=1e5)


def sliders(scene: Scene) -> list[Control]:
    """Those of the answers, as long as the scene's own values need."""
    found = {control.key: control for control in (*BEYOND, *controls(scene))}
    thrust = THRUST * found["radial_load_N"].high
    found["axial_load_N"] = found["axial_load_N"]._replace(low=-thrust, high=thrust)
    return [found[key] for key in ORDER]


def scenes(given: Scene, wanted: Wanted) -> tuple[Scene, Scene, Options]:
    """The bearing under the given loads, and under those that are wanted. SceneError."""
    tables = {name: table for name, table in tomllib.loads(given.to_written_toml()).items() if name in RATED}
    oil = tables.pop("lubricant", {})
    if wanted.bearing not in ("", given.bearing.designation):
        of_given = {name: getattr(given.operation, name) for name in LOADS}
        tables = {"bearing": {"designation": wanted.bearing}, "operation": of_given}
    tables["model"] = "lagrange"
    content_of(tables, given.files)
    base = parse_scene(tables, "these values")
    operation, bearing = tables.setdefault("operation", {}), tables.setdefault("bearing", {})
    operation |= wanted.model_dump(include={*LOADS, *NOT_OF_ALL}, exclude_none=True)
    for key in (key for key in NOT_OF_ALL if not operation.get(key)):
        operation.pop(key, None)
    if wanted.clearance_um is not None:
        bearing["clearance_um"] = wanted.clearance_um
        bearing.pop("outer_raceway_diameter_mm", None)
    balls, options = base.bearing.type == "ball", Options(angles=ANGLES)
    viscosity = wanted.viscosity_mm2_s
    if viscosity is None and given.lubricant is not None:
        viscosity = 1e6 * given.lubricant.viscosity_Pa_s / options.oil_density
    if viscosity and balls:  # films are those of line contacts
        options = options._replace(viscosity=viscosity)
    elif viscosity:
        tables["lubricant"] = oil | {"viscosity_Pa_s": 1e-6 * viscosity * options.oil_density}
    cylindrical = not (balls or base.bearing.contact_angle_deg)
    if "axial" in tables or (cylindrical and "misalignment_mrad" in operation):
        tables["axial"] = tables.get("axial", {}) | {"slices": SLICES}
    return base, parse_scene(tables, "these values"), options


def rate(given: Scene, wanted: Wanted) -> dict[str, object]:
    """Answers by block, in words, the section with its elements' loads, ends of sliders. SceneError, UsageError."""
    began = time.perf_counter()
    base, scene, options = scenes(given, wanted)
    rating = Rating(Case(scene, options), LEFT_OUT)
    operation = scene.operation
    values = values_of(scene) | {
        "axial_load_N": operation.axial_load_N or 0.0, "misalignment_mrad": operation.misalignment_mrad or 0.0,
        "viscosity_mm2_s": rating["nu_mm2_s"] or 0.0}  # fmt: skip
    return {
        "name": scene.name, "values": {key: values[key] for key in ORDER},
        "ends": {each.key: [each.low, each.high, each.step] for each in sliders(base)},
        "tiles": [(each.meaning, in_words(each)) for names in MAIN
                  for each in [rating.answers[name] for name in names if rating[name] is not None][:1]],
        "blocks": {block: [_plain(line) for line in lines] for block, lines in sheet(rating).items()},
        "missing": missing(rating), "warnings": rating.warnings, "picture": picture(rating.case),
        "toml": scene.to_toml(), "ms": 1e3 * (time.perf_counter() - began),
    }  # fmt: skip


def _plain(line):
    return line.meaning, line.value, line.source.name + " †" * bool(line.source.second_hand), str(line.source)


def picture(case: Case) -> dict[str, object] | None:
    """The section with roller 0 at its first angle: mm, µm, rad from the load, N; None without equilibrium."""
    bearing = case.bearing
    place = roller_angles(bearing, case.operation.first_roller_angle)
    try:
        if case.in_plane:
            hub, load = case.pitch.place[0] / UM, case.pitch.inner_force[0]
        else:  # of mirrored rows the larger load
            hub, load = case.balance.hub[:2] * MM / UM, np.max([row.loads for row in case.balance.rows], axis=0)
    except Unavailable:
        return None
    return {
        "inner": bearing.inner_raceway_radius / MM, "outer": bearing.outer_raceway_radius / MM,
        "roller": bearing.roller_radius / MM, "bore": bearing.core_radius / MM, "outside": bearing.outside_radius / MM,
        "hub": hub.tolist(), "rise": (0.5 * np.column_stack([np.cos(place), np.sin(place)]) @ hub).tolist(),
        "angle": (place - FROM_LOAD).tolist(), "load": load.tolist(),
    }  # fmt: skip
