"""The scene file's [[spall]], [[waviness]], [[unequal_roller]] and [[profile]]: surfaces that are not perfect circles.

Any number of each; spalls, waves, deviations and a measured profile of one surface add up, but spalls must not overlap.
"""

# fmt: off
from math import pi, radians
from typing import ClassVar, Literal

from lagrange.scene.faults import Angle, DecimalSign, Digest, File, FileName, FileText, Rule, Table, key, only
from lagrange.surface.faults import MeasuredSurface, Spall, UnequalRoller, Waviness, height_table

SURFACES = ("spall", "waviness", "unequal_roller", "profile")  # their arrays in the scene
FROM_LOAD = -0.5 * pi  # rad, of the load's direction from +x
Body = Literal["outer_ring", "inner_ring", "roller"]


class SurfaceTable(Table):
    """Deviation of one body's surface."""

    body: Body = key("outer_ring", "body with this surface")
    roller: int | None = key(None, 'number of the roller, counted from 0, if body = "roller"', 0)

    RULES: ClassVar[tuple[Rule, ...]] = (
        (lambda t: t.body == "roller" and t.roller is None, 'body = "roller" needs the number of the roller, e.g. '
            'roller = 0 for the first'), only("roller", "body", "roller"))

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
