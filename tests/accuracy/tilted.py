"""What rollers that tilt do: finite elements beside the reduced model, spalls and their edges.

`python -m tests.accuracy.tilted`; writes docs/measurements/tilted.md. Takes a minute once loops are compiled.
"""

from dataclasses import replace

import numpy as np
from scipy.signal import butter, hilbert, sosfiltfilt

from fem.solver.simulate import make_plan
from lagrange.axial.slices import alone, contact_slices
from lagrange.axial.table import in_series
from lagrange.contact.hertz import contact_pairs
from lagrange.contact.laws import Softened, contact_laws
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene
from tests.measurements import markdown_table, program
from tests.verification.runs import RunSamples, record

SETTLED = 0.02  # s, from which runs with spalls are looked at
BAND = 5e3, 20e3  # Hz, of the envelope
NEAR = 6.0  # Hz, of BPFO
OVER = 0.15e-3  # m, either side of a spall's middle
HALF = {"spall": [{"width_mm": 1.0, "length_mm": 5.0, "z_mm": 2.5}]}
SPALLS = {"sound": {}, "half the length": HALF, "whole length": {"spall": [{"width_mm": 1.0}]}}
CROSSED = [{"width_mm": 0.5, "angle_deg": 4.0}]
LAWS = {
    "no profile, alone": {"axial.roller_profile": "none", "axial.coupling": False},
    "no profile, coupled": {"axial.roller_profile": "none"},
    "logarithmic, coupled": {"axial.roller_profile": "logarithmic"},
}
DEEPER, LOADED = 1.5, 700.0  # ΔB of an edge; N, without it
COLUMNS = {"hub": "inner_y", "forces": "outer_force", "moments": "outer_moment", "tilts": "roller_tilt"}
SLANTED = {"operation.misalignment_mrad": 1.0, "numerics.duration_ms": 20.0}


def moved(keys: dict) -> RunSamples:
    """A run of the paper's bearing whose rollers have logarithmic profiles."""
    return record(make_plan(Scene().varied({"axial.roller_profile": "logarithmic"} | keys)))


def _percent(share: float) -> str:
    return f"{100.0 * abs(share):.2g} %"


def _more(ratio: float) -> str:
    return f"{100.0 * (ratio - 1.0):+.2f} %".replace("-", "−")


def tilted():
    wanted, rows = moved(SLANTED | {"model": "reduced"}), []
    for size in (2.0, 1.0):
        found = moved(SLANTED | {"model": "fem", "numerics.mesh_size_mm": size})
        moments, hub = ([each[name] for each in (found, wanted)] for name in ("inner_moment", "inner_y"))
        largest, off = np.abs(moments[1]).max(), moments[0] - moments[1]
        shares = (
            hub[0].mean() / hub[1].mean() - 1.0, (hub[0].std() - hub[1].std()) / hub[1].std(),
            np.abs(off.mean(axis=0)).max() / largest, off.std() / largest, np.abs(off).max() / largest,
        )  # fmt: skip
        rows.append([f"{size:g} mm", *map(_percent, shares)])
    heads = "mesh", "hub, mean", "hub, standard deviation", "moments, mean", "moments, rms", "moments, largest"
    about = "Off the reduced model's; 1 mrad, 20 ms, moments over the largest."
    yield "tilted", "Meshes", about, markdown_table(heads, rows)

    keys = {"model": "reduced", "axial.slices": 20, "numerics.duration_ms": 100.0, "numerics.output_interval_us": 5.0}
    columns = []
    for more in SPALLS.values():
        found = moved(keys | more)
        bearing, operation = found.plan.scene.ideal_bearing(), found.plan.scene.ideal_operation()
        over = np.abs(np.arctan2(found["roller_x"], -found["roller_y"])) * bearing.outer_raceway_radius < OVER
        acceleration = found["inner_ay"][found["time"] > SETTLED]
        interval = float(np.diff(found["time"][:2])[0])
        band = butter(4, BAND, "band", fs=1.0 / interval, output="sos")
        envelope, window = np.abs(hilbert(sosfiltfilt(band, acceleration))), np.hanning(acceleration.size)
        size = 2.0 * np.abs(np.fft.rfft((envelope - envelope.mean()) * window)) / window.sum()
        bpfo = kinematics(bearing, operation.speed).frequencies["BPFO"]
        line = size[np.abs(np.fft.rfftfreq(envelope.size, interval) - bpfo) < NEAR].max()
        columns.append([
            f"{found['outer_force'][over].mean():.0f} N", f"{abs(found['outer_moment'][over].mean()):.2f} N m",
            f"{found['outer_force'].max():.0f} N", f"{1e3 * np.abs(found['roller_tilt']).max():.1f} mrad",
            f"{acceleration.std():.0f} m/s²", f"{line:.3g} m/s²",
        ])  # fmt: skip
    names = (
        "mean force on the outer raceway over its middle", "mean moment there", "largest force on the outer raceway",
        "largest tilt", "acceleration of the hub along the load", "its envelope at BPFO",
    )  # fmt: skip
    about = "2000 N, 4500 rpm, 1 mm wide, 100 ms, undamped; vibration from 20 ms on."
    table = markdown_table(("spall", *SPALLS), zip(names, *columns, strict=True))
    yield "tilted", "Spall of half the length", about, table

    rows = []  # beside the largest forces of the plane section
    for model in ("reduced", "lagrange"):
        fixed = {"model": model, "numerics.duration_ms": 0.6, "numerics.output_interval_us": 0.5, "spall": CROSSED}
        peaks = [record(make_plan(Scene().varied(fixed | keys)))["outer_force"].max() for keys in ({}, *LAWS.values())]
        rows.append([model, f"{peaks[0]:.0f} N", *(_more(peak / peaks[0]) for peak in peaks[1:])])
    about = "2000 N, 4500 rpm, a spall 0.5 mm wide; largest forces."
    yield "tilted", "Strikes on edges", about, markdown_table(("model", "plane section", *LAWS), rows)

    rows = []  # an edge's compliance acts on the sum of forces, over: it acts on each slice that stands alone
    for profile in ("none", "logarithmic"):
        scene = Scene().varied({"axial.slices": 40, "axial.roller_profile": profile})
        bearing, axial = scene.ideal_bearing(), scene.ideal_axial()
        law, soft = contact_laws("johnson", bearing).outer, DEEPER * contact_pairs(bearing)[1].line_compliance
        whole = contact_slices(bearing, axial, (law, law))[1]
        half = replace(whole, part=whole.place > 0.0)
        for slope in (0.0, 1e-3, 2e-3):
            place = whole.approach_under(LOADED, np.array([slope])), np.array([slope])
            hard, yielding = (of.force(whole.approaches(*place)) for of in (law, Softened(law=law, compliance=soft)))
            ratios = (
                in_series(whole.at, *place, soft).force / yielding.mean(),
                alone(half).at(*place, 0.0, 0.0, soft).force / np.where(half.part, yielding, hard).mean(),
            )
            rows.append([profile, f"{1e3 * slope:g} mrad", *(_more(ratio.item()) for ratio in ratios)])
    about = "ΔB = 1.5, 700 N on the sound raceway, slices that stand alone."
    table = markdown_table(("profile", "slope", "whole length", "half the length"), rows)
    yield "tilted", "Uneven pressure at an edge", about, table

    keys, rows = SLANTED | {"axial.slices": 20} | HALF, []
    wanted, found = moved(keys | {"model": "reduced"}), moved(keys | {"model": "fem", "numerics.mesh_size_mm": 2.0})
    for name, column in COLUMNS.items():
        off = (of(found[column]) / of(wanted[column]) - 1.0 for of in (np.mean, np.std, lambda x: np.abs(x).max()))
        rows.append([name, *map(_percent, off)])
    about = "2000 N, 4500 rpm, 1 mm wide, 20 ms, 1 mrad, elements of 2 mm."
    table = markdown_table(("off the reduced model's", "mean", "standard deviation", "largest"), rows)
    yield "tilted", "Spall of half the length on meshes", about, table


if __name__ == "__main__":
    program(__doc__, "tests.accuracy.tilted", tilted)
