"""What a cage does, beside what theory says: `python -m tests.accuracy.cage [--random N]`. Minutes.

Slip, spacing and whirl; tractions of frictionless pockets under drag and where rollers begin to slide; slip of lightly
loaded bearings; with --random so many bearings with cages on coarse meshes, whose energies are judged.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from fem.solver.simulate import make_plan
from lagrange.errors import UsageError
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene, SceneError, parse_scene
from tests.accuracy import found
from tests.measurements import markdown_table, program

FRICTION = 0.1
PRELOADED = {"outer_raceway_diameter_mm": 55.99}
# a heavy cage falls softly into tight pockets, and a heavy hub does not whirl by the friction of rollers that slide
STIFF_POCKETS = {"pocket_clearance_mm": 0.002, "damping_N_s_m": 1000.0, "friction_coefficient": 0.0, "mass_kg": 1.0}
HEAVY_HUB = {"radial_load_N": 0.0, "gravity_m_s2": 0.0, "inner_ring_and_shaft_kg": 1000.0}
LOOSE = {"guidance": "rollers", "mass_kg": 0.02, "pocket_clearance_mm": 0.2, "stiffness_N_per_m": 1e8}  # if not said
LARGE = {
    "rollers": 23, "roller_diameter_mm": 10.0, "inner_raceway_diameter_mm": 70.0, "outer_raceway_diameter_mm": 90.01,
    "bore_diameter_mm": 55.0, "outside_diameter_mm": 105.0,
}  # fmt: skip
LIMIT = 1e-3  # of the exchanged energy and of the dissipated one: more is a run not to be trusted


@dataclass(frozen=True, kw_only=True)
class Run:
    scene: Scene
    values: dict[str, np.ndarray]
    imbalance: float  # over the exchanged and the dissipated energy
    trouble: str | None

    def slip(self, first: float, name: str = "cage") -> float:
        """Of the cage, or of the rollers' mean, after a share of the run."""
        angle = self.values["cage_angle"] if name == "cage" else self.values["roller_theta"].mean(axis=1)
        time, start = self.values["time"], int(first * len(angle))
        speed = (angle[-1] - angle[start]) / (time[-1] - time[start])
        return 1.0 - speed / kinematics(self.scene.ideal_bearing(), self.scene.ideal_operation().speed).cage

    @property
    def spacing(self) -> float:
        """The most that neighbouring rollers' distance along the pitch circle, seen from the cage, is off, m."""
        x, y = (self.values[f"roller_{axis}"] - self.values[f"cage_{axis}"][:, None] for axis in "xy")
        angle, bearing = np.unwrap(np.arctan2(y, x), axis=0), self.scene.ideal_bearing()
        apart = np.diff(np.concatenate([angle, angle[:, :1] + 2.0 * pi], axis=1), axis=1)
        apart = (apart + pi) % (2.0 * pi) - pi
        return float(np.abs(apart - 2.0 * pi / bearing.n_rollers).max()) * bearing.pitch_radius


def run(tables: dict) -> Run:
    scene = parse_scene(tables, "scene")
    ended = found(make_plan(scene))
    passed = ended.samples.exchanged.max() + ended["work_dissipated"].max()
    off = float(np.abs(ended.samples.imbalance).max() / passed)
    return Run(scene=scene, values=ended.samples.values, imbalance=off, trouble=ended.trouble)


def caged(model: str, duration: float, cage: dict, **tables) -> Run:
    numerics = {"duration_ms": duration} | tables.pop("numerics", {})
    return run({"model": model, "cage": LOOSE | cage, "numerics": numerics, **tables})


def random_scene(random: np.random.Generator) -> dict:
    def between(low, high):
        return float(low * (high / low) ** random.random())

    guidance = str(random.choice(["rollers", "inner_ring", "outer_ring"]))
    cage = {
        "mass_kg": between(2e-3, 0.2), "pocket_clearance_mm": between(0.02, 0.6), "guidance": guidance,
        "stiffness_N_per_m": between(1e6, 1e9), "damping_N_s_m": between(0.1, 1e4),
        "friction_coefficient": between(0.01, 0.5), "drag_torque_N_m": between(1e-3, 5.0),
    }  # fmt: skip
    if guidance != "rollers":
        cage["guidance_clearance_mm"] = between(0.02, 0.6)
    operation = {"speed_rpm": between(100.0, 20000.0), "radial_load_N": between(50.0, 5000.0)}
    numerics = {"mesh_size_mm": 2.5, "duration_ms": 5.0}
    clearance = {"outer_raceway_diameter_mm": 56.0 + float(random.choice([-0.01, 0.0, 0.02]))}
    return {"cage": cage, "operation": operation, "numerics": numerics, "bearing": clearance}


def cage(*, random: int = 0):
    """With `random` so many random bearings, and nothing else."""
    if random:
        draws, silent, worst, rows = np.random.default_rng(17), 0, 0.0, []
        for scene in (random_scene(draws) for _ in range(random)):
            of, how = scene["cage"], scene["operation"]
            numbers = f"{how['speed_rpm']:.0f}", f"{how['radial_load_N']:.0f}", f"{of['drag_torque_N_m']:.2g}"
            drawn = [of["guidance"], *numbers]
            try:
                ran = run({"model": "fem", **scene})
            except (SceneError, UsageError) as error:
                rows.append([*drawn, "-", "-", f"refused: {error}"])
            else:
                wrong = ran.trouble is None and not ran.imbalance <= LIMIT
                silent, worst = silent + wrong, max(worst, ran.imbalance)
                ending = ran.trouble or ("SILENTLY WRONG" if wrong else "sound")
                rows.append([*drawn, f"{ran.imbalance:.1e}", f"{100 * ran.slip(0.5):.2g}", ending])
            print(*rows[-1], flush=True)
        heads = ("guidance", "rpm", "load, N", "drag, N m", "imbalance", "cage's slip, %", "outcome")
        words = f"Silently wrong: {silent}; largest imbalance {worst:.1e} of what was exchanged and dissipated."
        heading = f"{random} random bearings with cages, mesh of 2.5 mm, 5 ms (seed 17)"
        yield "parts", heading, markdown_table(heads, rows), words
        return

    rows = []
    for guidance in ({"guidance": "rollers"}, {"guidance": "outer_ring", "guidance_clearance_mm": 0.1}):
        for friction, gravity in ((0.0, 0.0), (0.05, 0.0), (0.0, 9.81), (0.05, 9.81)):
            of = {"pocket_clearance_mm": 0.1, "friction_coefficient": friction, **guidance}
            ran = caged("reduced", 340.0, of, operation={"gravity_m_s2": gravity})
            off = 1e6 * np.hypot(ran.values["cage_x"], ran.values["cage_y"]).max()
            slips = f"{100 * ran.slip(0.0):.4f}", f"{100 * ran.slip(0.0, 'rollers'):.4f}"
            rows.append([guidance["guidance"], f"{friction}", f"{gravity}", *slips, f"{1e6 * ran.spacing:.1f}",
                         f"{off:.1f}"])  # fmt: skip
    heads = ("guidance", "friction", "gravity, m/s2", "cage's slip, %", "rollers' slip, %", "spacing off by, µm",
             "centre, µm")  # fmt: skip
    heading = "Cage without drag: slip of cage and rollers, spacing, its centre (0.1 mm pockets), 340 ms"
    yield "parts", heading, markdown_table(heads, rows)

    scene = {"bearing": PRELOADED, "contact": {"friction_coefficient": FRICTION}, "operation": HEAVY_HUB}
    still = caged("reduced", 1.0, STIFF_POCKETS, **scene)
    bearing = still.scene.ideal_bearing()
    load = float(0.5 * (still.values["inner_force"][0] + still.values["outer_force"][0]).mean())
    limit = 2.0 * FRICTION * load
    torque, rows, sliding = limit * bearing.n_rollers * bearing.pitch_radius, [], []
    for share in (0.25, 0.5, 0.9, 0.98, 1.05, 1.1, 1.2, 1.3):
        values = caged("reduced", 4.0, STIFF_POCKETS | {"drag_torque_N_m": share * torque}, **scene).values
        late = slice(len(values["time"]) // 2, None)
        taken = [values[name][late].mean() / (share * limit) for name in ("inner_traction", "outer_traction")]
        slowing = -np.polyfit(values["time"][late], values["cage_speed"][late], 1)[0]
        sliding += [(share, slowing)] if share > 1.0 else []
        rows.append([f"{share}", *(f"{each:.4f}" for each in taken), f"{slowing:.4g}"])
    slope, offset = np.polyfit(*np.array(sliding).T, 1)
    yield (
        "parts", "Cage with frictionless pockets, preload, no load: tractions under drag",
        f"Q = {load:.1f} N, 2 mu Q = {limit:.2f} N, torque {torque:.3f} N m",
        markdown_table(("F over 2 mu Q", "inner traction over F", "outer", "cage slows down, rad/s2"), rows),
        f"Gross slip begins at {-offset / slope:.4f} of 2 mu Q (straight line through the sliding ones).",
    )  # fmt: skip

    of, rows = {"guidance": "outer_ring", "guidance_clearance_mm": 0.05, "drag_torque_N_m": 0.3}, []
    for load in (50.0, 100.0, 200.0, 500.0, 2000.0):
        operation = {"speed_rpm": 10000.0, "radial_load_N": load, "inner_ring_and_shaft_kg": 0.5}
        ran = caged("reduced", 300.0, of, bearing=LARGE, operation=operation)
        rows.append([f"{load:g}", f"{100 * ran.slip(0.5):.3g}{' ' + ran.trouble if ran.trouble else ''}"])
    heading = "Cage of 23 rollers at 10 000 rpm, drag 0.3 N m: slip over the radial load"
    yield "parts", heading, markdown_table(("load, N", "cage's slip, %"), rows)


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.cage", cage)
