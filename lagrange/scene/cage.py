"""The table [cage] of the scene, and the cage that a bearing has where the scene leaves it, or keys of it, out.

The default is a calibration: rollers orbit within −0.1 to +0.25 % of rolling, as they do where a film and drag act,
which the model has not. Its plays are not those of a maker's drawing.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal

from pydantic import Field

from lagrange.bearing import Bearing, Cage, Guidance, room_between_rollers, thin_ring_inertia
from lagrange.contact.hertz import contact_pairs
from lagrange.limits import exceeds
from lagrange.scene.bearing import MM, BearingTable
from lagrange.scene.faults import Check, Table

if TYPE_CHECKING:
    from lagrange.scene.tables import SceneTables

PLAY, INNER_GUIDE_PLAY = 1e-3, 0.5e-3  # of the pitch diameter; rollers gain on rolling in proportion to it
MASS = 0.1  # of all rolling elements: a polyamide ring half as high as they are, less its pockets
STIFFNESS = 1e7  # N/m, of a roller on polyamide; stiffer ones only shorten the step
SHARE_OF_LINE = 0.1  # of 1/A: the slope of a line contact, 1/(A ln …), whose logarithm is about 10
FULL_COMPLEMENT = 0.07  # of a roller's diameter: a smaller gap between neighbours has no room for a bar
SIZES = "rollers", "roller_diameter_mm", "inner_raceway_diameter_mm"  # by which a bearing is the paper's


class CageTable(Table):
    """A rigid cage that moves under the forces on it; keys left out are those of the default cage."""

    kind: Literal["rigid", "none"] = Field("rigid", description="rigid, or none: the bearing has no cage")
    mass_kg: float | None = Field(
        None, ge=1e-6, le=1e5, description="mass of the cage; default: a tenth of the rolling elements' mass"
    )
    inertia_kg_m2: float | None = Field(
        None,
        ge=1e-12,
        le=1e6,
        description="moment of inertia about its centre; default: a thin ring of the pitch radius",
    )
    pocket_clearance_mm: float | None = Field(
        None,
        ge=1e-3,
        le=100.0,
        description="clearance of a roller in its pocket along the pitch circle, both sides together; default: 0.001 "
        "of the pitch diameter",
    )
    guidance: Guidance | None = Field(
        None,
        description="what centres the cage: the rollers (round pockets) or a ring (flat pockets); default: the outer "
        "ring, or the inner ring if the outer one turns or has a fit",
    )
    guidance_clearance_mm: float | None = Field(
        None,
        ge=1e-3,
        le=100.0,
        description="diametral clearance between cage and guiding ring; default: 0.001 of the pitch diameter, at the "
        "inner ring half of it or the bearing's clearance",
    )
    stiffness_N_per_m: float | None = Field(
        None,
        ge=1e4,
        le=1e11,
        description="stiffness of each contact of the cage; default: 1e7, or that of a raceway contact if lower",
    )
    damping_N_s_m: float = Field(
        1.0, ge=0.0, le=1e6, description="damping of each closed contact of the cage; never pulls"
    )
    friction_coefficient: float = Field(
        0.05, ge=0.0, le=1.0, description="friction coefficient in pockets and at the guiding ring"
    )
    drag_torque_N_m: float = Field(0.0, ge=0.0, le=1e6, description="drag torque of the lubricant on the cage")

    def checks(self) -> tuple[Check, ...]:
        return (self._guided,)

    def _guided(self) -> Iterator[str]:
        given = self.guidance_clearance_mm
        if self.guidance == "rollers" and given is not None:
            yield (
                f'guidance_clearance_mm = {given:g}: only with guidance = "inner_ring" or "outer_ring"; rollers guide '
                "a cage by its pockets; leave it out"
            )

    def filled(self, bearing: Bearing, outer_ring_moves: bool) -> "CageTable":
        """With the default cage's values for keys that are left out."""
        guidance = self.guidance or ("inner_ring" if outer_ring_moves else "outer_ring")
        pitch, line = 2.0 * bearing.pitch_radius, max(pair.line_compliance for pair in contact_pairs(bearing)[:2])
        defaults = {
            "mass_kg": max(MASS * bearing.n_rollers * bearing.roller_mass, 1e-6),
            "pocket_clearance_mm": min(PLAY * pitch, 0.5 * room_between_rollers(bearing)) / MM,
            "guidance": guidance,
            "stiffness_N_per_m": max(min(STIFFNESS, SHARE_OF_LINE / line), 1e4),
        }
        if guidance == "outer_ring":
            defaults["guidance_clearance_mm"] = PLAY * pitch / MM
        elif guidance == "inner_ring":  # which leaves the middle of the rollers' orbit by half the clearance
            defaults["guidance_clearance_mm"] = max(INNER_GUIDE_PLAY * pitch, 2.0 * bearing.radial_clearance, 1e-6) / MM
        shown = {key: float(f"{each:.3g}") if isinstance(each, float) else each for key, each in defaults.items()}
        return self.model_copy(update={key: each for key, each in shown.items() if getattr(self, key) is None})

    def cage(self, bearing: Bearing) -> Cage:
        """The cage in SI, of a table that is `filled`."""
        inertia, play = self.inertia_kg_m2, self.guidance_clearance_mm
        mass, pocket, guidance, stiffness = (
            self.mass_kg, self.pocket_clearance_mm, self.guidance, self.stiffness_N_per_m,
        )  # fmt: skip
        if mass is None or pocket is None or guidance is None or stiffness is None:
            raise ValueError("the bearing is not known, and so the cage is not")
        return Cage(
            mass=mass,
            inertia=thin_ring_inertia(bearing, mass) if inertia is None else inertia,
            pocket_clearance=MM * pocket,
            guidance=guidance,
            guidance_clearance=None if play is None else MM * play,
            stiffness=stiffness,
            damping=self.damping_N_s_m,
            friction_coefficient=self.friction_coefficient,
            drag_torque=self.drag_torque_N_m,
        )

    @property
    def words(self) -> str:
        """The cage in words, for plans."""
        whose = {"rollers": "guided by rollers", "inner_ring": "guided by the inner ring", None: "",
                 "outer_ring": "guided by the outer ring"}[self.guidance]  # fmt: skip
        play = "" if self.guidance_clearance_mm is None else f" with {self.guidance_clearance_mm:g} mm"
        return (
            f"{1e3 * (self.mass_kg or 0.0):.3g} g, {whose}{play}, pocket clearance {self.pocket_clearance_mm:g} mm, "
            f"{self.stiffness_N_per_m:.3g} N/m"
        )


def default_cage(scene: "SceneTables") -> CageTable | str:
    """The cage of a scene that does not describe one; in words why there is none."""
    bearing = scene.unmounted_bearing()
    if all(getattr(scene.bearing, key) == BearingTable.model_fields[key].default for key in SIZES):
        return "as the paper's bearing"
    if scene.friction_coefficient == 0.0:
        return "raceways without friction would not drive it"
    if room_between_rollers(bearing) < FULL_COMPLEMENT * 2.0 * bearing.roller_radius:
        return "full complement"
    return CageTable()


def cage_faults(bearing: Bearing, table: CageTable) -> Iterator[str]:
    """Pockets that leave no bars between rollers."""
    room, given = room_between_rollers(bearing), table.pocket_clearance_mm
    if given is not None and not exceeds(room, MM * given):
        yield (
            f"cage.pocket_clearance_mm = {given:g}: neighbouring rollers are {1e3 * room:.4g} mm "
            "apart, and a bar of the cage has to stand between them; reduce it, or use fewer rollers"
        )
