"""What viewers may change while a bearing runs, and the scene that follows."""

import tomllib
from dataclasses import dataclass

from pydantic import BaseModel, ConfigDict

from lagrange.scene.files import content_of
from lagrange.scene.scene import Scene, parse_scene

NAME = "these values"  # of what viewers send, in messages
MM_PER_UM = 1e-3
NANOMETRE_DIGITS = 6  # of a diameter in mm
FURTHER = {  # controls of what not every scene has, by key of their table: its name, label, unit, hint
    "contact_N_s_m": ("damping", "Contact damping", "N s/m", "of every closed contact"),
    "contact_time_us": ("damping", "Contact damping", "µs", "times the contact's stiffness"),
    "hunt_crossley_s_m": ("damping", "Contact damping", "s/m", "Hunt and Crossley's α"),
    "mass_kg": ("support", "Housing's mass", "kg", "without the outer ring"),
    "stiffness_N_per_m": ("support", "Housing's stiffness", "N/m", "of its springs to the ground, along either axis"),
    "damping_N_s_m": ("support", "Housing's damping", "N s/m", "of the dashpots beside them"),
    "frequency_Hz": ("sensor", "Sensor's frequency", "Hz", "its own, undamped"),
    "damping_ratio": ("sensor", "Sensor's damping ratio", "", "of critical damping"),
}
PLACES = {"misalignment_mrad": "operation", **{key: table for key, (table, *_) in FURTHER.items()}}  # tables of keys
STEEPEST, SLOPE = 3.0, "slope of the shaft, its +z end towards the load"  # mrad
LONGER = 4.0  # times the scene's own value: the end of such a slider


class Values(BaseModel):
    """What can be changed. Limits are the scene's own."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, strict=True)

    speed_rpm: float
    radial_load_N: float
    clearance_um: float  # diametral
    friction_coefficient: float
    spall_width_mm: float  # of the outer ring's first spall; 0: there is none
    misalignment_mrad: float | None = None  # where rollers tilt; as of all below None: as the scene has it
    contact_N_s_m: float | None = None  # of [damping]
    contact_time_us: float | None = None
    hunt_crossley_s_m: float | None = None
    mass_kg: float | None = None  # of the housing
    stiffness_N_per_m: float | None = None
    damping_N_s_m: float | None = None
    frequency_Hz: float | None = None  # of the sensor
    damping_ratio: float | None = None

    @classmethod
    def of(cls, scene: Scene) -> "Values":
        """Those of a scene."""
        b, at = scene.bearing, _outer_spall(scene)
        clearance = (b.outer_raceway_diameter_mm - b.inner_raceway_diameter_mm) / b.cosine - 2.0 * b.roller_diameter_mm
        return cls(
            speed_rpm=scene.operation.speed_rpm,
            radial_load_N=scene.operation.radial_load_N,
            clearance_um=round(clearance / MM_PER_UM, 3),
            friction_coefficient=scene.contact.friction_coefficient,
            spall_width_mm=0.0 if at is None else scene.spall[at].width_mm,
            misalignment_mrad=None if scene.axial is None else scene.operation.misalignment_mrad,
            **{key: getattr(getattr(scene, table), key, None) for key, (table, *_) in FURTHER.items()},
        )

    def put_into(self, scene: Scene) -> Scene:
        """The scene with these values; what is not changed keeps its digits. SceneError: it is none."""
        data, before = tomllib.loads(scene.to_toml()), Values.of(scene)
        data["operation"]["speed_rpm"] = self.speed_rpm
        data["operation"]["radial_load_N"] = self.radial_load_N
        data["contact"]["friction_coefficient"] = self.friction_coefficient
        for key, table in PLACES.items():
            if getattr(self, key) not in (None, getattr(before, key)):
                data.setdefault(table, {})[key] = getattr(self, key)
        if self.clearance_um != before.clearance_um:
            b = scene.bearing
            apart = 2.0 * b.roller_diameter_mm + MM_PER_UM * self.clearance_um
            diameter = round(b.inner_raceway_diameter_mm + apart * b.cosine, NANOMETRE_DIGITS)
            data["bearing"]["outer_raceway_diameter_mm"] = diameter
        if self.spall_width_mm != before.spall_width_mm:
            spalls, at = data.setdefault("spall", []), _outer_spall(scene)
            if at is None:
                spalls.append({"body": "outer_ring", "width_mm": self.spall_width_mm})
            elif self.spall_width_mm == 0.0:
                del spalls[at]
            else:
                spalls[at]["width_mm"] = self.spall_width_mm
        content_of(data, scene.files)
        return parse_scene(data, NAME)


def _outer_spall(scene: Scene) -> int | None:
    """Place of the first spall of the outer ring."""
    return next((i for i, spall in enumerate(scene.spall) if spall.body == "outer_ring"), None)


@dataclass(frozen=True)
class Slider:
    """One of the page's sliders; what lies beyond its ends can still be typed."""

    key: str  # of `Values`
    label: str
    unit: str
    low: float
    high: float
    step: float
    hint: str


def sliders(scene: Scene) -> tuple[Slider, ...]:
    """Those for a scene, long enough for its own values."""
    values, b = Values.of(scene), scene.bearing
    fastest = 2.0 * abs(values.speed_rpm) or 3000.0
    heaviest = max(5.0 * values.radial_load_N, 50.0 * b.roller_diameter_mm * b.roller_length_mm)
    tightest, widest = -2.0 * b.roller_diameter_mm, 10.0 * b.roller_diameter_mm
    spalled = max(0.3 * b.roller_diameter_mm, values.spall_width_mm)
    rubbing = max(0.3, values.friction_coefficient)
    steepest = max(STEEPEST, abs(values.misalignment_mrad or 0.0))
    slowest = -fastest if values.speed_rpm < 0.0 else 0.0
    low, high = min(tightest, values.clearance_um), max(widest, values.clearance_um)
    return (
        Slider("speed_rpm", "Speed", "rpm", slowest, fastest, 10.0, "of the inner ring and the shaft"),
        Slider("radial_load_N", "Radial load", "N", 0.0, heaviest, 10.0, "on the shaft, downwards"),
        Slider("clearance_um", "Clearance", "µm", low, high, 1.0, "diametral; below 0 it is preload"),
        Slider("friction_coefficient", "Friction", "", 0.0, rubbing, 0.01, "Coulomb's, in every contact"),
        Slider("spall_width_mm", "Spall width", "mm", 0.0, spalled, 0.05, "of the outer raceway; 0: none"),
        *(
            ()
            if values.misalignment_mrad is None
            else (Slider("misalignment_mrad", "Misalignment", "mrad", -steepest, steepest, 0.1, SLOPE),)
        ),
        *(
            Slider(key, label, unit, 0.01 * own, _end(key, own), 0.01 * own, hint)
            for key, (_, label, unit, hint) in FURTHER.items()
            if (own := getattr(values, key))
        ),
    )


def _end(key: str, own: float) -> float:
    return max(own, min(LONGER * own, 0.99)) if key == "damping_ratio" else LONGER * own
