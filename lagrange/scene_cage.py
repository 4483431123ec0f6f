"""The scene's table [cage]."""

from collections.abc import Iterator

from pydantic import Field

from lagrange.bearing import Bearing
from lagrange.cage import Cage, Guidance, room_between_rollers, thin_ring_inertia
from lagrange.scene_faults import Check, Table

MM = 1e-3


class CageTable(Table):
    """A cage that moves by the forces on it; without the table rollers have none."""

    mass_kg: float = Field(0.02, ge=1e-6, le=1e5, description="of the whole cage")
    inertia_kg_m2: float | None = Field(
        None, ge=1e-12, le=1e6, description="about its centre; left out: of a thin ring of the pitch radius"
    )
    pocket_clearance_mm: float = Field(
        0.2, ge=1e-3, le=100.0, description="of a roller in its pocket along the pitch circle, on both sides together"
    )
    guidance: Guidance = Field(
        "rollers", description="what centres the cage; rollers in round pockets, or a ring, and pockets have flat walls"
    )
    guidance_clearance_mm: float | None = Field(
        None, ge=1e-3, le=100.0, description="difference of diameters between the cage and the ring that guides it"
    )
    stiffness_N_per_m: float = Field(1e8, ge=1e4, le=1e11, description="of each contact of the cage")
    damping_N_s_m: float = Field(1.0, ge=0.0, le=1e6, description="of each closed contact of the cage; never pulls")
    friction_coefficient: float = Field(0.05, ge=0.0, le=1.0, description="in pockets and at the guiding ring")
    drag_torque_N_m: float = Field(0.0, ge=0.0, le=1e6, description="against the cage's rotation, of the lubricant")

    def checks(self) -> tuple[Check, ...]:
        return (self._guided,)

    def _guided(self) -> Iterator[str]:
        given = self.guidance_clearance_mm
        if self.guidance == "rollers" and given is not None:
            yield (
                f'guidance_clearance_mm = {given:g}: only with guidance = "inner_ring" or "outer_ring"; rollers guide '
                "a cage by its pockets; leave it out"
            )
        if self.guidance != "rollers" and given is None:
            yield f'guidance = "{self.guidance}" needs guidance_clearance_mm, e.g. 0.3 (difference of diameters)'

    def cage(self, bearing: Bearing) -> Cage:
        """The cage in SI."""
        inertia, play = self.inertia_kg_m2, self.guidance_clearance_mm
        return Cage(
            mass=self.mass_kg,
            inertia=thin_ring_inertia(bearing, self.mass_kg) if inertia is None else inertia,
            pocket_clearance=MM * self.pocket_clearance_mm,
            guidance=self.guidance,
            guidance_clearance=None if play is None else MM * play,
            stiffness=self.stiffness_N_per_m,
            damping=self.damping_N_s_m,
            friction_coefficient=self.friction_coefficient,
            drag_torque=self.drag_torque_N_m,
        )


def cage_faults(bearing: Bearing, table: CageTable) -> Iterator[str]:
    """Pockets that leave no bars between rollers."""
    room = room_between_rollers(bearing)
    if MM * table.pocket_clearance_mm >= room:
        yield (
            f"cage.pocket_clearance_mm = {table.pocket_clearance_mm:g}: neighbouring rollers are {1e3 * room:.4g} mm "
            "apart, and a bar of the cage has to stand between them; take less, or fewer rollers"
        )
