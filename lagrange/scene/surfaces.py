"""The scene file's [[spall]], [[waviness]], [[unequal_roller]] and [[profile]]: surfaces that are not perfect circles.

Any number of each; spalls, waves, deviations and a measured profile of one surface add up, but spalls must not overlap.
"""

# fmt: off
from collections.abc import Iterator
from math import asin, degrees, pi, radians
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from lagrange.axial.slices import slices_over
from lagrange.errors import exceeds
from lagrange.scene.faults import Angle, DecimalSign, Digest, File, FileName, FileText, Rule, Table, key, only
from lagrange.surface.faults import MeasuredSurface, Spall, UnequalRoller, Waviness, height_table, own_radius, thickness

if TYPE_CHECKING:
    from lagrange.scene.scene import Scene

SURFACES = ("spall", "waviness", "unequal_roller", "profile")  # their arrays in the scene
FROM_LOAD = -0.5 * pi  # rad, of the load's direction from +x
WIDEST = 0.8  # half an opening over the radius of the roller, or of the body it is in
LARGEST_DEVIATION = 0.005  # of a roller's diameter, as much as its preload may be
STEEPEST_WAVE = 0.1  # curvature of a wave over that of the contact: circle and surface still touch in one place
NARROWEST = {"inner_ring": 1e-4, "outer_ring": 1e-4, "roller": 5e-4}  # of the circumference: profiles are tables
DEEPEST_PROFILE = 0.1  # from its highest to its lowest point, of the roller's radius: contacts then stay in one place
COARSEST_PROFILE = 0.1  # of the roller's radius, between two points
STEEPEST_PROFILE = 2.0  # between two points: no stylus follows more, and an edge would lie anywhere between them
Body = Literal["outer_ring", "inner_ring", "roller"]


class SurfaceTable(Table):
    """Deviation of one body's surface."""

    body: Body = key("outer_ring", "body with this surface")
    roller: int | None = key(None, 'number of the roller, counted from 0, if body = "roller"', 0)

    RULES: ClassVar[tuple[Rule, ...]] = (
        (lambda t: t.body == "roller" and t.roller is None, 'body = "roller" needs the number of the roller, e.g. '
            'roller = 0 for the first'),
        only("roller", "body", "roller"),
    )

    @property
    def reference(self) -> float:
        """Where the body's angles are counted from, rad: rings from the load, rollers in their own frame."""
        return 0.0 if self.body == "roller" else FROM_LOAD


class SpallTable(SurfaceTable):
    """A spall: material broken out of a surface."""

    angle_deg: Angle = key(0.0, "angle of its middle at t = 0; rings: from the load (−y); rollers: in their own frame")
    width_mm: float = key(1.0, "width of the spall (of the equivalent sharp-edged gap)", most=1000.0, gt=0.0)
    depth_um: float = key(100.0, "depth below the surface", most=1e5, gt=0.0)
    edge_radius_mm: float = key(0.1, "radius of its edges", 0.0, 100.0)
    length_mm: float | None = key(None, "length along the rollers, with [axial]; default: their whole length",
        most=1000.0, gt=0.0)
    z_mm: float = key(0.0, "offset of its middle along the rollers, with length_mm", -1000.0, 1000.0)

    RULES = (*SurfaceTable.RULES, only("z_mm", "length_mm"))

    def fault(self) -> Spall:
        si, along = self.si(), None
        if si["length"] is not None:
            along = si["z"] - 0.5 * si["length"], si["z"] + 0.5 * si["length"]
        return self.fact(Spall, angle=si["angle"] + self.reference, along=along)


class WavinessTable(SurfaceTable):
    """A wave of a surface: amplitude · cos(order · angle + phase)."""

    body: Body = key("inner_ring", "body with this surface")
    order: int = key(12, "number of waves around the circumference", 1, 10_000)
    amplitude_um: float = key(0.5, "amplitude: half the height from valley to crest", most=1e5, gt=0.0)
    phase_deg: Angle = key(0.0, "phase at angle 0; rings: the load's direction (−y); rollers: their own frame")

    def fault(self) -> Waviness:
        return self.fact(Waviness, phase=radians(self.phase_deg) - self.order * self.reference)


class UnequalRollerTable(Table):
    """A roller of another size."""

    roller: int = key(0, "number of the roller, counted from 0", 0)
    diameter_deviation_um: float = key(1.0, "its diameter minus that of the others", -1e5, 1e5)

    def fault(self) -> UnequalRoller:
        return self.fact(UnequalRoller)


class ProfileTable(SurfaceTable):
    """Measured heights around a surface."""

    file: FileName = key(..., "CSV file next to the scene with the columns angle_deg, height_um")
    sha256: Digest = None
    angle_deg: Angle = key(0.0, "angle of the table's 0 at t = 0, from the load (−y); rollers: in their own frame")
    decimal: DecimalSign = None
    content: FileText = None

    FILES: ClassVar = {"file": File("heights", height_table)}

    def fault(self) -> MeasuredSurface:
        """ValueError: its file is not at hand, or no table of heights."""
        table = self.read("file")
        if table is None or self.sha256 is None:
            raise ValueError(f'profile: file = "{self.file}" is not at hand')
        return self.fact(MeasuredSurface, angle=radians(self.angle_deg) + self.reference, table=table)


def roller_faults(scene: "Scene") -> Iterator[str]:
    """Rollers that there are none of, or that are given two sizes."""
    n_rollers = scene.bearing.rollers
    for name in SURFACES:
        for i, entry in enumerate(getattr(scene, name)):
            if entry.roller is not None and entry.roller >= n_rollers:
                yield (f"{name}.{i}.roller = {entry.roller}: there is none; bearing.rollers = {n_rollers} are counted "
                    f"from 0 to {n_rollers - 1}")
    sized = [entry.roller for entry in scene.unequal_roller]
    for number in sorted({number for number in sized if sized.count(number) > 1}):
        yield f"unequal_roller: roller = {number} is there {sized.count(number)} times; give it one deviation"


def spall_faults(scene: "Scene") -> Iterator[str]:
    """Spalls that the bodies have no room for, and those that overlap."""
    edges: list[tuple[int, Spall, float]] = []
    bearing = scene.perfect_bearing()
    for i, table in enumerate(scene.spall):
        spall, place = table.fault(), f"spall.{i}"
        own, opening = own_radius(bearing, spall), spall.half_opening(bearing.roller_radius)
        widest = WIDEST * min(own, bearing.roller_radius)
        if exceeds(opening, widest):
            yield (f"{place}.width_mm = {table.width_mm:g} with edge_radius_mm = {table.edge_radius_mm:g} is an "
                f"opening of {2e3 * opening:.4g} mm, too wide for rollers of {2e3 * bearing.roller_radius:g} mm (at "
                f"most {2e3 * widest:.4g})")
            continue
        narrowest, deepest = NARROWEST[spall.body] * 2.0 * pi * own, thickness(bearing, spall.body)
        if spall.width < narrowest:
            yield (f"{place}.width_mm = {table.width_mm:g} is too narrow for a surface of {2e3 * own:g} mm diameter "
                f"(at least {1e3 * narrowest:.3g})")
        if not exceeds(deepest, spall.depth):
            yield f"{place}.depth_um = {table.depth_um:g} goes through the body; below {1e6 * deepest:.4g}"
        half = asin(opening / own)
        for k, other, other_half in edges:
            apart = abs((spall.angle - other.angle + pi) % (2.0 * pi) - pi)
            if (other.body, other.roller) == (spall.body, spall.roller) and apart < half + other_half:
                yield (f"spall.{k} and {place} overlap: their middles are {degrees(apart):.3g} degrees apart on the "
                    f"same surface, at least {degrees(half + other_half):.3g}; make one spall of them")
        edges.append((i, spall, half))


def part_faults(scene: "Scene") -> Iterator[str]:
    """Spalls of part of the rollers' length that take no slice, or others than those that the same contacts meet."""
    met: dict[str, tuple[int, list[bool]]] = {}
    bearing, slices = scene.perfect_bearing(), 0 if scene.axial is None else scene.axial.slices
    for i, table in enumerate(scene.spall if slices else ()):
        if not (spall := table.fault()).is_part(bearing):
            continue
        over, place = slices_over(bearing, slices, spall).tolist(), f"spall.{i}.length_mm = {table.length_mm:g}"
        if all(over) or not any(over):
            yield (f"{place} at z_mm = {table.z_mm:g} goes over {'all' if all(over) else 'no'} middles of "
                f"axial.slices = {slices} slices of {1e3 * bearing.roller_length / slices:.3g} mm; " + ("leave "
                "length_mm out" if all(over) else "use more slices, or a longer spall within the rollers"))
            continue
        for raceway in ("inner_ring", "outer_ring") if table.body == "roller" else (table.body,):
            k, other = met.setdefault(raceway, (i, over))
            if over != other:
                yield (f"{place}, z_mm = {table.z_mm:g} takes other slices of contacts with the {raceway} than "
                    f"spall.{k}; give both the same length_mm and z_mm")


def profile_faults(scene: "Scene") -> Iterator[str]:
    """Two profiles of one surface, and those too high, too deep, too coarse or too steep for rollers to follow."""
    seen: dict[tuple[str, int | None], int] = {}
    bearing = scene.perfect_bearing()
    for i, table in enumerate(scene.profile):
        place, before = f'profile.{i}.file = "{table.file}"', seen.setdefault((table.body, table.roller), i)
        if before != i:
            yield f"profile.{before} and profile.{i} are of the same surface; make one table of them"
        heights = table.read("file")
        if heights is None:
            continue
        angle, height, own, roller = heights.angle, heights.height, own_radius(bearing, table), bearing.roller_radius
        highest, range_ = float(height.max()), float(np.ptp(height))
        if exceeds(highest, 2.0 * LARGEST_DEVIATION * roller):
            yield f"{place}: {1e6 * highest:.4g} µm is too high (at most {2e6 * LARGEST_DEVIATION * roller:.4g})"
        if exceeds(range_, DEEPEST_PROFILE * roller):
            yield (f"{place}: heights range over {1e6 * range_:.4g} µm, more than contacts follow (at most "
                f"{1e6 * DEEPEST_PROFILE * roller:.4g}); what lies too deep for a roller to reach may be cut off")
        steps = own * np.diff(np.append(angle, angle[0] + 2.0 * pi))
        rises = np.abs(np.diff(np.append(height, height[0])))
        if steps.max() > COARSEST_PROFILE * roller:
            yield (f"{place}: points {1e3 * steps.max():.3g} mm apart are too coarse (at most "
                f"{1e3 * COARSEST_PROFILE * roller:.3g} for rollers of {2e3 * roller:g} mm)")
        at = int((rises / steps).argmax())
        if rises[at] > STEEPEST_PROFILE * steps[at]:
            yield (f"{place}: after {degrees(angle[at]):.6g} degrees the height changes by {1e6 * rises[at]:.3g} µm on "
                f"{1e6 * steps[at]:.3g} µm, too steep (at most {STEEPEST_PROFILE:g} times it); give points nearer to "
                "each other")


def size_faults(scene: "Scene") -> Iterator[str]:
    """Waves too high or too short for contacts in one place, and rollers too large."""
    bearing = scene.perfect_bearing()
    largest = LARGEST_DEVIATION * 2.0 * bearing.roller_radius
    for i, table in enumerate(scene.waviness):
        wave, place = table.fault(), f"waviness.{i}.amplitude_um = {table.amplitude_um:g}"
        if exceeds(wave.amplitude, largest):
            yield f"{place} is too high (at most {1e6 * largest:.4g})"
        inside, outside = 1.0 / bearing.inner_raceway_radius, -1.0 / bearing.outer_raceway_radius
        curvature = 1.0 / bearing.roller_radius + (inside if wave.body == "inner_ring" else outside)
        highest = STEEPEST_WAVE * curvature * (own_radius(bearing, wave) / wave.order) ** 2
        if wave.amplitude > highest:
            yield (f"{place} of order = {wave.order}: its valleys are too narrow for the rollers to follow (at most "
                f"{1e6 * highest:.3g} at this order)")
    for i, other in enumerate(scene.unequal_roller):
        if exceeds(abs(other.fault().diameter_deviation), largest):
            yield (f"unequal_roller.{i}.diameter_deviation_um = {other.diameter_deviation_um:g} is too large (at most "
                f"{1e6 * largest:.4g} either way)")
