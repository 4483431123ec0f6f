"""The scene file's [fit]: what the rings sit on and in, and how warm it is; with it clearances are unmounted ones."""

from collections.abc import Iterator
from math import inf

from pydantic import Field

from lagrange.bearing import Material
from lagrange.fits import REFERENCE_C, STEEL_EXPANSION, Fit, OperatingClearance
from lagrange.limits import exceeds
from lagrange.scene.bearing import MM, BearingTable
from lagrange.scene.faults import Table

UM = 1e-6
LARGEST_INTERFERENCE = 2e-3  # of the diameter: steel yields at about that strain
COLDEST, HOTTEST = -200.0, 500.0
AT_HAND = "temperature in operation; default: that of the ring"
STEEL_DENSITY = 7850.0


class FitTable(Table):
    """Operating clearance from that of the unmounted bearing: fits, temperatures, spin, film."""

    shaft_interference_um: float = Field(
        0.0, ge=-10_000.0, le=10_000.0,
        description="shaft minus bore diameter at 20 °C, less the smoothing of the surfaces; negative: loose",
    )  # fmt: skip
    housing_interference_um: float = Field(
        0.0,
        ge=-10_000.0,
        le=10_000.0,
        description="outside diameter of the outer ring minus housing bore at 20 °C; negative: loose",
    )
    shaft_bore_mm: float = Field(0.0, ge=0.0, le=10_000.0, description="bore of a hollow shaft; 0: solid")
    housing_outside_diameter_mm: float = Field(
        0.0,
        ge=0.0,
        le=100_000.0,
        description="outside diameter of the housing, taken as a ring; 0: so thick that it is stiff",
    )
    shaft_youngs_modulus_GPa: float = Field(210.0, ge=0.1, le=2000.0, description="Young's modulus of the shaft")
    shaft_poisson_ratio: float = Field(0.3, ge=0.0, le=0.45, description="Poisson's ratio of the shaft")
    shaft_density_kg_m3: float = Field(
        STEEL_DENSITY, ge=100.0, le=30_000.0, description="density of the shaft, for its spin"
    )
    housing_youngs_modulus_GPa: float = Field(
        210.0, ge=0.1, le=2000.0, description="Young's modulus of the housing; aluminium 70"
    )
    housing_poisson_ratio: float = Field(
        0.3, ge=0.0, le=0.45, description="Poisson's ratio of the housing; aluminium 0.33"
    )
    inner_ring_C: float = Field(REFERENCE_C, ge=COLDEST, le=HOTTEST, description="temperature in operation")
    outer_ring_C: float = Field(REFERENCE_C, ge=COLDEST, le=HOTTEST, description="temperature in operation")
    rollers_C: float | None = Field(
        None, ge=COLDEST, le=HOTTEST, description="temperature in operation; default: mean of both rings'"
    )
    shaft_C: float | None = Field(None, ge=COLDEST, le=HOTTEST, description=AT_HAND)
    housing_C: float | None = Field(None, ge=COLDEST, le=HOTTEST, description=AT_HAND)
    ring_expansion_1_K: float = Field(
        STEEL_EXPANSION, ge=0.0, le=1e-4, description="thermal expansion of the rings; default bearing steel"
    )
    roller_expansion_1_K: float = Field(
        STEEL_EXPANSION, ge=0.0, le=1e-4, description="thermal expansion of the rollers; silicon nitride 3.2e-6"
    )
    shaft_expansion_1_K: float = Field(STEEL_EXPANSION, ge=0.0, le=1e-4, description="thermal expansion of the shaft")
    housing_expansion_1_K: float = Field(
        STEEL_EXPANSION, ge=0.0, le=1e-4, description="thermal expansion of the housing; aluminium 23.8e-6"
    )

    def fit(self) -> Fit:
        """The fits in SI."""
        outside, middle = self.housing_outside_diameter_mm, 0.5 * (self.inner_ring_C + self.outer_ring_C)
        return Fit(
            shaft_interference=UM * self.shaft_interference_um,
            housing_interference=UM * self.housing_interference_um,
            shaft_bore=MM * self.shaft_bore_mm,
            housing_outside=MM * outside if outside > 0.0 else inf,
            shaft=Material(
                youngs_modulus=1e9 * self.shaft_youngs_modulus_GPa,
                poisson_ratio=self.shaft_poisson_ratio,
                density=self.shaft_density_kg_m3,
            ),
            housing=Material(
                youngs_modulus=1e9 * self.housing_youngs_modulus_GPa,
                poisson_ratio=self.housing_poisson_ratio,
                density=STEEL_DENSITY,  # it stands still
            ),
            shaft_expansion=self.shaft_expansion_1_K,
            ring_expansion=self.ring_expansion_1_K,
            roller_expansion=self.roller_expansion_1_K,
            housing_expansion=self.housing_expansion_1_K,
            shaft_C=self.inner_ring_C if self.shaft_C is None else self.shaft_C,
            inner_ring_C=self.inner_ring_C,
            rollers_C=middle if self.rollers_C is None else self.rollers_C,
            outer_ring_C=self.outer_ring_C,
            housing_C=self.outer_ring_C if self.housing_C is None else self.housing_C,
        )

    @property
    def of_housing(self) -> str | None:
        """A key of the housing as the scene writes it; None: there is none."""
        given = next((key for key in type(self).model_fields if key.startswith("housing_") and self._gives(key)), None)
        return None if given is None else f"fit.{given} = {getattr(self, given):g}"

    def _gives(self, key: str) -> bool:
        return getattr(self, key) != type(self).model_fields[key].default


def fit_faults(bearing: BearingTable, fit: FitTable) -> Iterator[str]:
    """Sizes that don't go with the bearing's, and interferences that no ring bears."""
    bore, outside = bearing.bore_diameter_mm, bearing.outside_diameter_mm
    if fit.shaft_bore_mm >= bore > 0.0:
        yield f"fit.shaft_bore_mm = {fit.shaft_bore_mm:g} must be below bearing.bore_diameter_mm = {bore:g}; 0: solid"
    if 0.0 < fit.housing_outside_diameter_mm <= outside:
        yield (
            f"fit.housing_outside_diameter_mm = {fit.housing_outside_diameter_mm:g} must be above "
            f"bearing.outside_diameter_mm = {outside:g}; 0: so thick that it is stiff"
        )
    for name, diameter in (("shaft", bore), ("housing", outside)):
        given, most = getattr(fit, f"{name}_interference_um"), 1e3 * LARGEST_INTERFERENCE * diameter
        if exceeds(abs(given), most) and most > 0.0:
            yield (
                f"fit.{name}_interference_um = {given:g}: more than {LARGEST_INTERFERENCE:g} of the diameter, "
                f"{diameter:g} mm; between {-most:g} and {most:g}"
            )


def interference_faults(bearing: BearingTable, found: OperatingClearance) -> Iterator[str]:
    """Fits that temperatures make too tight."""
    for name, diameter in (("shaft", bearing.bore_diameter_mm), ("housing", bearing.outside_diameter_mm)):
        pressed = 1e6 * getattr(found, f"{name}_interference")
        if exceeds(pressed, 1e3 * LARGEST_INTERFERENCE * diameter):
            yield (
                f"fit: {pressed:.4g} µm of interference in operation, more than {LARGEST_INTERFERENCE:g} of the "
                f"diameter, {diameter:g} mm; check fit.{name}_interference_um, temperatures and expansions"
            )
