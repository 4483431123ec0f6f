"""The third dimension of a run: pressure over the unrolled raceways, and the most loaded roller from its side."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from fem.pictures.output import MARK
from fem.pictures.recover import StoredRun
from fem.statics.tilted_pressures import SIDES, scene_slices, slice_pressures
from lagrange.axial.pressure import SHARP, borne, profile_ends
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import UsageError
from lagrange.files.output import replaced
from lagrange.messages import shown

ROOM = 0.8  # of the pitch, that a roller takes up in the picture
INCHES, DOTS = 9.0, 160  # width of the picture, and per inch


class AxialPressures(NamedTuple):
    """Pressures along rollers at an instant; SI."""

    time: float
    place: np.ndarray  # (n_slices,), m, along the axis from the middle
    angle: np.ndarray  # (n_rollers,), rad from the load's direction, counter-clockwise, in (−π, π]
    pressure: np.ndarray  # (2, n_rollers, n_slices), Pa, inner and outer raceway
    drop: np.ndarray  # (2, n_slices), m, of roller and raceway together
    slope: np.ndarray  # (2, n_rollers), rad, of roller and ring to each other
    sharp: np.ndarray  # (2,), whether a loaded edge has no peak pressure


def axial_pressures(stored: StoredRun, sample: int) -> AxialPressures:
    """From stored forces and moments, by the slices of the scene's contacts. UsageError: the scene has no [axial]."""
    scene = stored.scene
    axial, bearing = scene.ideal_axial(), scene.perfect_bearing()
    if axial is None:
        raise UsageError(f"{stored.path}: the scene has no [axial]; --view axial is of rollers that tilt")
    column = lambda name: stored.from_housing(name)[sample]  # noqa: E731
    try:
        slices = scene_slices(scene)
        each = (slice_pressures(scene, *side, column) for side in zip(SIDES, slices, strict=True))
        pressure, slope = map(np.array, zip(*each, strict=True))
    except ValueError as error:
        raise UsageError(f"{stored.path}: {1e3 * stored.times[sample]:.4g} ms: {error}") from None
    contacts = zip(profile_ends(bearing, axial), slices, contact_pairs(bearing), pressure, strict=False)
    sharp = [end.are_loaded(own, borne(pair, at)).any() for end, own, pair, at in contacts]
    angle = np.angle(1j * (column("roller_x") + 1j * column("roller_y")))
    return AxialPressures(
        float(stored.times[sample]), axial.centres(bearing), angle, pressure, axial.drops(bearing), slope,
        np.array(sharp),
    )  # fmt: skip


def draw_axial(stored: StoredRun, target: Path, sample: int) -> None:
    """Write a PNG of the pressures at a sample.
    Both raceways unrolled, and the most loaded roller from its side: pressure along it, and below how far its profile
    and tilt take it from the raceway."""
    import matplotlib.pyplot as plt

    found = axial_pressures(stored, sample)
    figure, axes = plt.subplots(2, 2, figsize=(INCHES, 0.62 * INCHES), width_ratios=(2.2, 1.0), layout="constrained")
    z, half = 1e3 * found.place, 0.5 * ROOM * 360.0 / found.angle.size
    edges = np.append(z - 0.5 * (z[1] - z[0]), z[-1] + 0.5 * (z[1] - z[0]))
    most = int(found.pressure[0].max(axis=1).argmax())
    look = {"vmin": 0.0, "vmax": max(1e-6 * float(found.pressure.max()), 1.0), "cmap": "inferno_r"}
    for side, (raceway, roller), pressure, drop, slope, sharp in zip(
        SIDES, axes, 1e-6 * found.pressure, found.drop, found.slope[:, most], found.sharp, strict=True
    ):
        for middle, of_roller in zip(np.degrees(found.angle), pressure, strict=True):
            shades = np.ma.masked_equal(of_roller[:, None], 0.0)
            coloured = raceway.pcolormesh([middle - half, middle + half], edges, shades, **look)
        raceway.set(xlim=(-180, 180), ylabel="along the axis, mm", title=f"{side} raceway")
        raceway.set_xticks([-180, -90, 0, 90, 180])
        gap, below = 1e6 * (drop + slope * found.place), roller.twinx()
        below.plot(z, gap - gap.min(), color="0.5", linewidth=0.9)
        below.set_ylabel("gap, undeformed, µm", color="0.4")
        below.set_ylim(0.0, 3.0 * max(float(np.ptp(gap)), 1.0))
        roller.fill_between(z, pressure[most], color="C3", alpha=0.6, step="mid")
        roller.set(ylabel="pressure, MPa", ylim=(0.0, None), xlim=(z[0], z[-1]))
        peak = SHARP.partition(",")[0] if sharp else f"{pressure[most].max():.0f} MPa"
        roller.set_title(f"roller {most}: {peak}, {1e3 * slope:.2f} mrad", fontsize=9)
    axes[1, 0].set_xlabel("angle from the load, °")
    axes[1, 1].set_xlabel("along the axis, mm")
    figure.colorbar(coloured, ax=axes[:, 0], label="pressure, MPa", shrink=0.8)
    figure.suptitle(f"{stored.scene.name}, {1e3 * found.time:.4g} ms, {stored.scene.method}", fontsize=10)
    with replaced(target) as file:
        about = {"Software": MARK, "Source": shown(stored.path.name)}
        figure.savefig(file, dpi=DOTS, format="png", metadata=about)
    plt.close(figure)
