"""Short scenes that between them have every table of a scene in every model that takes it."""

from dataclasses import dataclass
from math import cos, radians


@dataclass(frozen=True)
class Short:
    """A short run of the built-in scene with some keys changed."""

    name: str
    duration_ms: float
    keys: tuple[str, ...] = ()
    resumed: bool = False  # stopped half-way and gone on with
    report: bool = False  # compare the numbers of check-residual too


def _scene(name: str, duration_ms: float, text: str = "", **options: bool) -> Short:
    return Short(name, duration_ms, tuple(text.split()), **options)


FILES = {  # beside each scene
    "speeds.csv": "time_ms,speed_rpm\n0,3000\n1,4500\n20,4600\n",
    "loads.csv": "time_ms,x_N,y_N\n0,0,-2000\n0.5,300,-1500\n20,0,-2500\n",
    "heights.csv": "angle_deg,height_um\n" + "".join(f"{a},{0.5 * cos(radians(9 * a)):.6f}\n" for a in range(360)),
}


SOFT = "material.youngs_modulus_GPa=5"
SCENES = (
    _scene("paper", 4.0, "numerics.mesh_size_mm=2", report=True),
    _scene("fine", 0.5, "numerics.mesh_size_mm=1"),
    _scene("static", 0.0, "numerics.mesh_size_mm=2"),
    _scene("resumed", 1.0, "numerics.mesh_size_mm=2", resumed=True),
    _scene("from-rest", 1.0, "numerics.mesh_size_mm=2 numerics.start=rest numerics.load_ramp_ms=0.2"),
    _scene("frictionless", 1.0, "numerics.mesh_size_mm=2 contact.friction_coefficient=0"),
    _scene("fields", 0.5, "numerics.mesh_size_mm=2 output.fields_every_ms=0.1"),
    _scene("fast", 0.5, "numerics.mesh_size_mm=2 operation.speed_rpm=40000"),
    _scene("backward", 0.5, "numerics.mesh_size_mm=1.5 operation.speed_rpm=-900 operation.gravity_m_s2=0"),
    _scene("still", 0.5, "numerics.mesh_size_mm=2 operation.speed_rpm=0"),
    _scene("preload", 0.5, "numerics.mesh_size_mm=1.5 bearing.outer_raceway_diameter_mm=55.99"),
    _scene(
        "rattling",
        2.0,
        "numerics.mesh_size_mm=2 numerics.start=rest bearing.outer_raceway_diameter_mm=56.2 bearing.rollers=14 "
        "operation.radial_load_N=50",
    ),
    _scene("three-rollers", 0.5, "numerics.mesh_size_mm=2 bearing.rollers=3 cage.kind=none "
           "contact.friction_coefficient=0.2"),
    _scene("many-rollers", 0.5, "numerics.mesh_size_mm=1.2 bearing.rollers=31 bearing.roller_diameter_mm=4 "
           "bearing.outer_raceway_diameter_mm=44 cage.kind=none"),
    _scene("rigid-rollers", 0.5, "numerics.mesh_size_mm=2 bodies.rollers=rigid"),
    _scene("rigid-inner", 0.5, "numerics.mesh_size_mm=2 bodies.inner_ring=rigid"),
    _scene("rigid-rings", 0.5, "numerics.mesh_size_mm=2 bodies.inner_ring=rigid bodies.outer_ring=rigid"),
    _scene("penalty", 0.5, "numerics.mesh_size_mm=2 contact.model=penalty"),
    _scene("faceted", 0.5, "numerics.mesh_size_mm=2 contact.model=faceted contact.penalty_stiffness_N_per_m=1e8"),
    _scene("spread", 0.05, f"{SOFT} numerics.mesh_size_mm=0.5"),
    _scene("resolved", 0.02, f"{SOFT} contact.model=resolved numerics.mesh_size_mm=0.15"),
    _scene("lagrange", 5.0, "model=lagrange", report=True),
    _scene("lagrange-free", 2.0, "model=lagrange lagrange.angles=free lagrange.law=johnson numerics.start=rest"),
    _scene("lagrange-damped", 1.0, "model=lagrange lagrange.damping_N_s_m=200"),
    _scene("lagrange-rattling", 5.0, "model=lagrange numerics.start=rest numerics.load_ramp_ms=0 "
           "bearing.outer_raceway_diameter_mm=56.1 operation.radial_load_N=20"),
    _scene(
        "lagrange-ball-bearing", 2.0, "model=lagrange bearing.type=ball bearing.rollers=9 bearing.roller_length_mm=16"
    ),
)  # fmt: skip

# every table with each model that takes it: its keys, and models that refuse it
MODELS = {"fem": (0.3, "numerics.mesh_size_mm=2"), "reduced": (2.0, ""), "lagrange": (2.0, "")}
HOUSING = "support.kind=housing support.mass_kg=12 support.stiffness_N_per_m=1.5e7 support.damping_N_s_m=2200"
SPALL = 'spall=[{body="outer_ring",width_mm=1.2,angle_deg=5.0}]'
TABLES: dict[str, tuple[str, tuple[str, ...]]] = {
    "shaft": ("operation.shaft=springs operation.shaft_stiffness_N_per_m=1e7 operation.shaft_damping_N_s_m=50", ()),
    "housing": (HOUSING, ()),
    "sensor": (f"{HOUSING} sensor.frequency_Hz=15000 sensor.damping_ratio=0.05", ()),
    "points": ("support.kind=points", ("reduced", "lagrange")),
    "bore": ("support.kind=bore support.fit_clearance_um=10", ("reduced", "lagrange")),
    "fitted-housing": (f"{HOUSING} support.fit_clearance_um=10", ("reduced", "lagrange")),
    "cage": ("cage.mass_kg=0.02 lagrange.angles=free", ()),
    "guided-cage": (
        "cage.mass_kg=0.02 cage.guidance=inner_ring cage.guidance_clearance_mm=0.3 cage.drag_torque_N_m=0.001 "
        "lagrange.angles=free",
        (),
    ),
    "spall": (SPALL, ()),
    "damped-spall": (f"{SPALL} damping.contact_time_us=12.5", ()),
    "inner-spall": ('spall=[{body="inner_ring",width_mm=0.8,angle_deg=4.0}] damping.contact_N_s_m=500', ()),
    "roller-spall": ('spall=[{body="roller",roller=0,width_mm=0.8,angle_deg=0.0}] damping.contact_N_s_m=500', ()),
    "waviness": ('waviness=[{body="inner_ring",order=12,amplitude_um=0.5}]', ()),
    "unequal-roller": ("unequal_roller=[{roller=1,diameter_deviation_um=2.0}]", ()),
    "profile": ('profile=[{body="outer_ring",file="heights.csv"}]', ()),
    "lubricant": ("lubricant.viscosity_Pa_s=0.02", ()),
    "speed-history": ("operation.speed_table=speeds.csv", ()),
    "load-history": ("operation.load_table=loads.csv", ()),
    "unbalance": ("operation.unbalance_g_mm=50 operation.rotating_load_N=300", ()),
    "hunt-crossley": ("damping.hunt_crossley_s_m=0.5", ()),
    "body-damping": ("damping.bodies_1_s=500", ("reduced", "lagrange")),
    "balls": ("bearing.type=ball bearing.rollers=9 bearing.roller_length_mm=16 " + HOUSING, ("fem", "reduced")),
    "tilted": ("axial.roller_profile=logarithmic operation.misalignment_mrad=1", ()),
    "materials": ("material.roller.youngs_modulus_GPa=310 material.roller.density_kg_m3=3250", ()),
}
RESUMED = "cage", "damped-spall", "tilted"
SCENES += tuple(
    _scene(f"{model}-{table}", duration, f"model={model} {choices} {keys}", resumed=table in RESUMED)
    for table, (keys, refusing) in TABLES.items()
    for model, (duration, choices) in MODELS.items()
    if model not in refusing
)
