"""Slices of a scene with [axial], and the peak pressures of its runs by forces and moments."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from fem.contacts.tilted import rounded_range, tilted_slices
from fem.elastic.cache import kept
from fem.statics.exact_statics import kept_contacts
from lagrange.axial.pressure import PeakTable, peak_table, pressures_under, profile_ends
from lagrange.axial.slices import Slices, contact_slices
from lagrange.contact.hertz import Side, contact_pairs
from lagrange.contact.laws import contact_laws
from lagrange.scene.scene import Scene
from lagrange.surface.passages import surfaces_met

LEAST = 1e-6  # rad: of a run whose axes stay parallel
SIDES: tuple[Side, Side] = ("inner", "outer")
PLACES = "time", "inner_x", "inner_y", "roller_x", "roller_y", "roller_turn"
FAINT = 1e-3  # of the largest force: contacts taken as open
FLAT = 1e-10  # m: a spline's ringing beside spalls, which contacts do not notice


def scene_slices(scene: Scene) -> tuple[Slices, Slices]:
    """Slices of the inner and the outer contact: forces along a roller.

    Of the Lagrangian model its law's; of other models those of elastic bodies, whose laws are as at rest.
    """
    bearing, axial = scene.perfect_bearing(), scene.ideal_axial()
    if scene.model == "lagrange":
        return contact_slices(bearing, axial, contact_laws(scene.lagrange.law, bearing))
    return tilted_slices(bearing, axial, kept_contacts(bearing)[0].laws)


def slice_pressures(
    scene: Scene, side: Side, slices: Slices, column: Callable[[str], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Pressures on the slices of a raceway's contacts at an instant, Pa, (n_rollers, n_slices); 0 of open contacts.

    Beside it slopes of rollers to the raceway, (n_rollers,), rad.

    slices : of `scene_slices`
    column : gives a sample's forces and moments by the result file's names, and PLACES where spalls take part of the
        length

    Errors: those of `pressures_under`.
    """
    bearing, axial, spalled, k = scene.perfect_bearing(), scene.ideal_axial(), scene.ideal_bearing(), SIDES.index(side)
    part, pair, depth = axial.parts(spalled)[k], contact_pairs(bearing)[k], np.zeros(bearing.n_rollers)
    if part is not None:
        met = surfaces_met(spalled, scene.ideal_operation(), {name: np.asarray(column(name))[None] for name in PLACES})
        depth = depth + np.asarray(met[k].part_sinkage).reshape(-1)
    force, moment = column(f"{side}_force"), column(f"{side}_moment")
    return pressures_under(replace(slices, part=part), pair, force, moment, depth, force > FAINT * force.max())


def peak_columns(scene: Scene, samples: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of `lagrange.columns.OF_TILTED` from a run's samples, each (n_times, n_rollers), Pa.

    Tables are kept on disk. Errors: those of `peak_table`. NaN over spalls of part of the length, whose ends are edges.
    """
    bearing, axial = scene.perfect_bearing(), scene.ideal_axial()
    slope = np.abs(samples["roller_tilt"]).max() + np.hypot(samples["inner_slope_x"], samples["inner_slope_y"]).max()
    force = max(samples[f"{side}_force"].max() for side in SIDES)
    within = rounded_range(float(force), max(float(slope), LEAST))

    def make():
        each = zip(scene_slices(scene), contact_pairs(bearing), profile_ends(bearing, axial), strict=False)
        return {"peaks": np.stack([peak_table(*of_contact, *within).peaks for of_contact in each])}

    law = scene.lagrange if scene.model == "lagrange" else None
    peaks = kept("peaks", repr((bearing, axial, law, within)), make)["peaks"]
    arm, spalled, found = float(axial.centres(bearing)[-1]), scene.ideal_bearing(), {}
    takes_part = any(part is not None for part in axial.parts(spalled))
    met = surfaces_met(spalled, scene.ideal_operation(), samples) if takes_part else (None, None)
    for side, of, sunk in zip(SIDES, peaks, met, strict=True):
        force = samples[f"{side}_force"]
        peak = PeakTable(root=within[0] ** 0.5, arm=arm, peaks=of).at(force, samples[f"{side}_moment"])
        over = False if sunk is None else (force > 0.0) & (sunk.part_sinkage > FLAT)
        found[f"{side}_peak_pressure"] = np.where(over, np.nan, peak)
    return found
