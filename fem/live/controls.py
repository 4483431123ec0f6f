"""What a viewer may change while a bearing runs, and the scene that follows."""

import tomllib
from dataclasses import dataclass

from lagrange.scene.files import content_of
from lagrange.scene.scene import Scene, parse_scene

OWN = {  # controls of what not every scene has, by key of its table: table, label, unit, hint
    "contact_N_s_m": ("damping", "Contact damping", "N s/m", "every closed contact"),
    "contact_time_us": ("damping", "Contact damping", "µs", "multiplies the contact's stiffness"),
    "hunt_crossley_s_m": ("damping", "Contact damping", "s/m", "Hunt–Crossley coefficient α"),
    "mass_kg": ("support", "Housing's mass", "kg", "without the outer ring"),
    "stiffness_N_per_m": ("support", "Housing's stiffness", "N/m", "springs to the ground, x and y"),
    "damping_N_s_m": ("support", "Housing's damping", "N s/m", "dashpots parallel to the springs"),
    "frequency_Hz": ("sensor", "Sensor's frequency", "Hz", "undamped"),
    "damping_ratio": ("sensor", "Sensor's damping ratio", "", "of critical damping"),
}
TABLES = {"friction_coefficient": "contact"} | {key: table for key, (table, *_) in OWN.items()}  # else [operation]
SPALLED = {"outer_ring": "Spall, outer raceway", "inner_ring": "Spall, inner raceway", "roller": "Spall of a roller"}
SPALL_KEYS = {"mm": "width_mm", "deg": "angle_deg"}
STEEPEST = 3.0  # mrad
LONGER = 4.0  # times the scene's own value: the end of such a slider


@dataclass(frozen=True)
class Control:
    """A slider and a box; values beyond the slider's ends can be typed."""

    key: str  # of `values_of`
    label: str
    unit: str
    hint: str
    low: float
    high: float
    step: float
    needs: str = ""  # another control: while that is 0, this one has no effect


def values_of(scene: Scene) -> dict[str, float]:
    """Values of all controls that the scene has."""
    b = scene.bearing
    clearance = (b.outer_raceway_diameter_mm - b.inner_raceway_diameter_mm) / b.cosine - 2.0 * b.roller_diameter_mm
    found = {
        "speed_rpm": scene.operation.speed_rpm,
        "radial_load_N": scene.operation.radial_load_N,
        "clearance_um": round(1e3 * clearance, 3),
        "friction_coefficient": scene.contact.friction_coefficient,
    }
    spalls = {spall.body: spall for spall in reversed(scene.spall)}  # the first of each body
    for body in SPALLED:
        if body != "roller" or not b.missing_rollers:  # of which a scene can have one
            found[f"{body}_spall_mm"] = spalls[body].width_mm if body in spalls else 0.0
    found["outer_ring_spall_deg"] = spalls["outer_ring"].angle_deg if "outer_ring" in spalls else 0.0
    if scene.axial is not None:
        found["misalignment_mrad"] = scene.operation.misalignment_mrad or 0.0
    own = {key: getattr(getattr(scene, table), key, None) for key, (table, *_) in OWN.items()}
    return found | {key: value for key, value in own.items() if value is not None}


def changed(scene: Scene, values: dict[str, float]) -> Scene:
    """The scene with other values; what is not changed keeps its digits. SceneError: there is no such scene."""
    data, before = tomllib.loads(scene.to_toml()), values_of(scene)
    for key, value in values.items():
        if value == before[key]:
            continue
        if key == "clearance_um":
            del data["bearing"]["outer_raceway_diameter_mm"]
            data["bearing"][key] = value
        elif "_spall_" in key:
            _change_spall(data.setdefault("spall", []), *key.split("_spall_"), value)
        else:
            data.setdefault(TABLES.get(key, "operation"), {})[key] = value
    content_of(data, scene.files)
    return parse_scene(data, "these values")


def _change_spall(spalls: list[dict], body: str, part: str, value: float) -> None:
    first = next((spall for spall in spalls if spall["body"] == body), None)
    if first is not None and (part == "deg" or value):
        first[SPALL_KEYS[part]] = value
    elif first is not None:
        spalls.remove(first)
    elif part == "mm":
        spalls.append({"body": body, "width_mm": value, **({"roller": 0} if body == "roller" else {})})


def controls(scene: Scene) -> tuple[Control, ...]:
    """Those of a scene, long enough for its own values."""
    values, b = values_of(scene), scene.bearing
    speed, load, play = values["speed_rpm"], values["radial_load_N"], values["clearance_um"]
    fastest = 2.0 * abs(speed) or 3000.0
    heaviest = max(5.0 * load, 50.0 * b.roller_diameter_mm * b.roller_length_mm)
    tightest, widest = min(-2.0 * b.roller_diameter_mm, play), max(10.0 * b.roller_diameter_mm, play)
    friction = max(0.3, values["friction_coefficient"])
    found = [
        Control("speed_rpm", "Speed", "rpm", "inner ring", min(0.0, -fastest * (speed < 0.0)), fastest, 10.0),
        Control("radial_load_N", "Radial load", "N", "on the shaft, downwards", 0.0, heaviest, 10.0),
        Control("clearance_um", "Clearance", "µm", "diametral; below 0: preload", tightest, widest, 1.0),
        Control("friction_coefficient", "Friction", "", "Coulomb coefficient, every contact", 0.0, friction, 0.01),
    ]
    if "misalignment_mrad" in values:
        steepest = max(STEEPEST, abs(values["misalignment_mrad"]))
        hint = "slope of the shaft; +z end towards the load"
        found.append(Control("misalignment_mrad", "Misalignment", "mrad", hint, -steepest, steepest, 0.1))
    for key, (_, label, unit, hint) in OWN.items():
        if own := values.get(key):
            end = max(own, min(LONGER * own, 0.99)) if key == "damping_ratio" else LONGER * own
            found.append(Control(key, label, unit, hint, 0.01 * own, end, 0.01 * own))
    for body, label in SPALLED.items():
        if (own := values.get(key := f"{body}_spall_mm")) is not None:
            found.append(Control(key, label, "mm", "width; 0: none", 0.0, max(0.3 * b.roller_diameter_mm, own), 0.05))
        if body == "outer_ring":
            at = "Angle of that spall", "°", "from the load, counter-clockwise", -180.0, 180.0, 1.0
            found.append(Control("outer_ring_spall_deg", *at, needs=key))
    return tuple(found)
