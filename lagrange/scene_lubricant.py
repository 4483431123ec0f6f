"""The scene file's [lubricant]: a film between rollers and raceways."""

from pydantic import Field

from lagrange.film import Lubricant
from lagrange.scene_faults import Table


class LubricantTable(Table):
    """A film that takes up gap, as thick as Dowson and Higginson's under the largest static load of a raceway."""

    viscosity_Pa_s: float = Field(0.02, ge=1e-5, le=100.0, description="where the oil enters the contacts")
    pressure_viscosity_1_Pa: float = Field(2e-8, ge=1e-10, le=1e-6, description="its growth with pressure")
    traction_coefficient: float = Field(
        0.05, ge=0.0, le=1.0, description="of the film, in place of contact.friction_coefficient"
    )

    def lubricant(self) -> Lubricant:
        """The oil, SI."""
        return Lubricant(
            viscosity=self.viscosity_Pa_s,
            pressure_viscosity=self.pressure_viscosity_1_Pa,
            traction_coefficient=self.traction_coefficient,
        )
