"""Tables of the scene that say how the run is computed: [contact], [damping], [numerics], [output], models' own."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from lagrange.bearing import OwnLaw
from lagrange.contact.damping import ContactDamping
from lagrange.contact.laws import OWN
from lagrange.limits import exceeds
from lagrange.scene.faults import Check, DecimalSign, Digest, FileName, FileText, Table
from lagrange.scene.law_table import fitted_law

COMPARISONS = ("penalty", "faceted")  # contact models that are only there to be compared with
STIFF_PENALTY = 1e9  # N/m, three times a contact of the paper's bearing; the mesh's nodes are no stiffer


class ContactTable(Table):
    """How contacts are computed."""

    model: Literal["subgrid", "resolved", "penalty", "faceted"] = Field(
        "subgrid",
        description="subgrid: contacts smaller than the mesh; resolved: on meshes finer than the contacts; penalty, "
        "faceted: springs or polygons, for comparison",
    )
    penalty_stiffness_N_per_m: float | None = Field(
        None, ge=1e5, le=1e12, description="stiffness of each contact of a comparison model; default 1e9"
    )
    friction_coefficient: float = Field(
        0.1, ge=0.0, le=1.0, description="Coulomb friction coefficient; 0: frictionless (faster)"
    )

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        compared = data.get("model") in COMPARISONS
        return {"penalty_stiffness_N_per_m": STIFF_PENALTY} | data if compared else data

    def checks(self) -> tuple[Check, ...]:
        return (self._has_springs,)

    def _has_springs(self) -> Iterator[str]:
        if self.penalty_stiffness_N_per_m is not None and self.model not in COMPARISONS:
            yield (
                f"penalty_stiffness_N_per_m = {self.penalty_stiffness_N_per_m:g}: only for the comparison models "
                f'model = "penalty" and "faceted", not for "{self.model}"; leave it out'
            )


class NumericsTable(Table):
    """Duration, start, mesh and steps."""

    duration_ms: float = Field(60.0, ge=0.0, le=1e6, description="simulated time; 0: static equilibrium only")
    start: Literal["equilibrium", "rest"] = Field(
        "equilibrium",
        description="from static equilibrium, rolling; or from rest: centred, undeformed, the load ramped",
    )
    load_ramp_ms: float = Field(1.0, ge=0.0, le=1e6, description='time over which the load grows if start = "rest"')
    mesh_size_mm: float = Field(
        1.0,
        gt=0.0,
        le=100.0,
        description="distance of surface nodes; default: a tenth of a given roller_diameter_mm",
    )
    time_step_safety: float = Field(0.9, ge=0.01, lt=1.0, description="time step over the critical time step")
    output_interval_us: float = Field(
        10.0,
        ge=1e-3,
        le=1e6,
        description="time between two samples; default 10, or less if the hub or impacting rollers vibrate faster or "
        "faults pass",
    )

    def checks(self) -> tuple[Check, ...]:
        return (self._samples,)

    def _samples(self) -> Iterator[str]:
        if self.duration_ms > 0.0 and exceeds(self.output_interval_us, 1e3 * self.duration_ms):
            yield (
                f"output_interval_us = {self.output_interval_us:g} is longer than the run (duration_ms = "
                f"{self.duration_ms:g}): nothing but the start would be stored; at most {1e3 * self.duration_ms:g}"
            )


class LagrangeTable(Table):
    """Lagrangian model: its own solution, and the equations that check-residual uses."""

    law: str = Field(
        "harris",
        description="contact law: harris, palmgren, iso16281, braendlein, johnson, houpert, teutsch_sauer; balls: "
        "hertz; power: Q = K δⁿ with the keys below",
    )
    contact_stiffness_N_per_m_n: list[Annotated[float, Field(ge=1e3, le=1e25)]] | None = Field(
        None,
        min_length=2,
        max_length=2,
        description="K of an inner and of an outer contact in Q = K δⁿ, SI",
    )
    contact_exponent: float | None = Field(None, ge=1.0, le=3.0, description="exponent n in Q = K δⁿ")
    law_table: FileName | None = Field(
        None,
        description="CSV file next to the scene with the columns force [N], approach [um] of one contact; K and n are "
        "fitted to it",
    )
    law_table_sha256: Digest = None
    law_table_decimal: DecimalSign = None
    law_table_content: FileText = None
    angles: Literal["kinematic", "free"] = Field(
        "kinematic",
        description="kinematic: rollers in a cage that rolls without slip; free: free rollers (run-fem only)",
    )

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The own law is meant where it is given and none is named."""
        given = any(data.get(key) is not None for key in ("contact_stiffness_N_per_m_n", "law_table"))
        return {"law": OWN} | data if given else data

    def checks(self) -> tuple[Check, ...]:
        return (self._own_law,)

    def _own_law(self) -> Iterator[str]:
        stiffness, exponent = self.contact_stiffness_N_per_m_n, self.contact_exponent
        for key in ("law_table_sha256", "law_table_decimal"):
            if getattr(self, key) is not None and self.law_table is None:
                yield f"{key}: give law_table too, or leave it out"
        if self.law_table is not None and (stiffness is not None or exponent is not None):
            yield (
                f'law_table = "{self.law_table}": K and n are fitted to it; leave it out, or '
                "contact_stiffness_N_per_m_n and contact_exponent"
            )
        if (stiffness is None) != (exponent is None):
            yield "contact_stiffness_N_per_m_n and contact_exponent make one law Q = K δⁿ; give both, or neither"
        if self.law == OWN and stiffness is None and self.law_table is None:
            yield (
                'law = "power" needs contact_stiffness_N_per_m_n = [inner, outer] and contact_exponent, or law_table'
            )
        try:
            self.own_law()
        except ValueError as error:
            yield f'law_table = "{self.law_table}": {error}'

    def own_law(self) -> OwnLaw | None:
        """The scene's own law; None: it has none, or its table is not at hand. ValueError: a table of another kind."""
        if self.law_table_content is not None:
            return fitted_law(self.law_table_content, self.law_table_decimal or ".")
        if self.contact_stiffness_N_per_m_n is None or self.contact_exponent is None:
            return None
        inner, outer = self.contact_stiffness_N_per_m_n
        return OwnLaw(inner_stiffness=inner, outer_stiffness=outer, exponent=self.contact_exponent)


class OutputTable(Table):
    """Fields and accelerations to store."""

    fields_every_ms: float = Field(
        0.0,
        ge=0.0,
        le=1e6,
        description="interval at which displacement and stress of all nodes are stored; 0: none (faster)",
    )
    acceleration_Hz: int = Field(
        25_600, ge=1, le=100_000_000, description="sampling rate of the accelerations that render-fem --export writes"
    )


CONTACT_LAWS = ("contact_N_s_m", "contact_time_us", "hunt_crossley_s_m")


class DampingTable(Table):
    """Damping, apart from friction. At most one of the three contact laws may be given; none makes a contact pull."""

    contact_N_s_m: float = Field(0.0, ge=0.0, le=1e6, description="damping coefficient of every closed contact")
    contact_time_us: float = Field(
        0.0,
        ge=0.0,
        le=1000.0,
        description="damping time: the coefficient is this time multiplied by the contact's stiffness",
    )
    hunt_crossley_s_m: float = Field(
        0.0,
        ge=0.0,
        le=1000.0,
        description="Hunt–Crossley coefficient α: F = Q(1 + 3/2 α δ̇)",
    )
    bodies_1_s: float = Field(
        0.0, ge=0.0, le=1e6, description="mass-proportional damping of the deformation of the bodies"
    )

    def checks(self) -> tuple[Check, ...]:
        return (self._one_law,)

    def _one_law(self) -> Iterator[str]:
        given = [f"{name} = {getattr(self, name):g}" for name in CONTACT_LAWS if getattr(self, name) > 0.0]
        if len(given) > 1:
            yield f"{' and '.join(given)}: contacts are damped by one law; leave all but one out"

    @property
    def acts(self) -> bool:
        return self != DampingTable()

    @property
    def words(self) -> str:
        """What damps, for captions."""
        contacts = f"contact damping {self.contacts.words}" if self.contacts.acts else "no contact damping"
        return contacts if self.bodies_1_s == 0.0 else f"{contacts}, bodies damped by {self.bodies_1_s:.4g} 1/s"

    @property
    def contacts(self) -> ContactDamping:
        """The law of the contacts, SI."""
        return ContactDamping(
            constant=self.contact_N_s_m, time=1e-6 * self.contact_time_us, hunt_crossley=self.hunt_crossley_s_m
        )
