"""The tables of a scene, given out as SI objects."""

from dataclasses import replace
from math import radians
from typing import Any, Literal

from pydantic import Field

from lagrange.axial import Axial
from lagrange.bearing import BallBearing, Bearing, Cage, Operation
from lagrange.fits import OperatingClearance, growths, in_operation, operating_clearance
from lagrange.kinematics import kinematics
from lagrange.mounting import Mounting
from lagrange.scene.axial import AxialTable
from lagrange.scene.bearing import BearingTable, BodiesTable, LubricantTable, MaterialTable
from lagrange.scene.cage import CageTable
from lagrange.scene.columns import Columns
from lagrange.scene.faults import Table
from lagrange.scene.fit import FitTable
from lagrange.scene.mounting import SensorTable, SupportTable
from lagrange.scene.operation import OperationTable
from lagrange.scene.run import ContactTable, DampingTable, LagrangeTable, NumericsTable, OutputTable
from lagrange.scene.surfaces import SURFACES, ProfileTable, SpallTable, UnequalRollerTable, WavinessTable
from lagrange.section import section_mounting, section_operation
from lagrange.surface.faults import Fault, Film
from lagrange.surface.film import films

MM = 1e-3
MOST_TABLES = 200  # of one array
MODEL_NAMES = {"fem": "finite elements", "reduced": "reduced model", "lagrange": "Lagrangian model"}


class SceneTables(Table):
    """The tables of a scene, and what they tell in SI; `lagrange.scene.scene.Scene` checks them together."""

    name: str = Field(
        "paper",
        min_length=1,
        max_length=100,
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$",
        description="name of the scene and of its result files",
    )
    model: Literal["fem", "reduced", "lagrange"] = Field(
        "fem",
        description="finite elements; elastic bodies without inertia of their own; rigid bodies on contact springs",
    )
    bearing: BearingTable = BearingTable()
    material: MaterialTable = MaterialTable()
    fit: FitTable | None = None
    bodies: BodiesTable = BodiesTable()
    operation: OperationTable = OperationTable()
    contact: ContactTable = ContactTable()
    damping: DampingTable = DampingTable()
    lagrange: LagrangeTable = LagrangeTable()
    numerics: NumericsTable = NumericsTable()
    output: OutputTable = OutputTable()
    support: SupportTable | None = None
    sensor: SensorTable | None = None
    cage: CageTable | None = None
    lubricant: LubricantTable | None = None
    axial: AxialTable | None = None
    spall: list[SpallTable] = Field([], max_length=MOST_TABLES)
    waviness: list[WavinessTable] = Field([], max_length=MOST_TABLES)
    unequal_roller: list[UnequalRollerTable] = Field([], max_length=MOST_TABLES)
    profile: list[ProfileTable] = Field([], max_length=MOST_TABLES)
    table: Columns = Columns()

    def ideal_bearing(self) -> Bearing:
        """The bearing in SI, with the faults of its surfaces and the films on them."""
        return replace(self.perfect_bearing(), faults=self._faults() + self.films())

    def _faults(self) -> tuple[Fault, ...]:
        """Of its surfaces, without films."""
        return tuple(table.fault() for name in SURFACES for table in getattr(self, name))

    @property
    def method(self) -> str:
        """Model and damping in words, for the captions of pictures."""
        return f"{MODEL_NAMES[self.model]}, {self.damping.words}"

    @property
    def has_faults(self) -> bool:
        """Whether surfaces are not perfect, but for films."""
        return any(getattr(self, name) for name in SURFACES)

    @property
    def friction_coefficient(self) -> float:
        """Of the contacts, dry or under a film."""
        return self.contact.friction_coefficient if self.lubricant is None else self.lubricant.traction_coefficient

    def perfect_bearing(self) -> Bearing:
        """The bearing in SI with the sizes that it has in operation, without faults of its surfaces."""
        bearing, found = self.unmounted_bearing(), self.clearance_without_films()
        if found is None:
            return bearing
        return in_operation(bearing, found, (0.0, 0.0) if self.model == "lagrange" else self._growths(bearing))

    def operating_clearance(self) -> OperatingClearance | None:
        """How the clearance in operation comes about, films included; None: the scene has no [fit]."""
        found = self.clearance_without_films()
        return None if found is None else replace(found, film=self.film_loss())

    def films(self, operation: Operation | None = None) -> tuple[Film, ...]:
        """Of a lubricant, at an operating point of the section; None: the scene's."""
        if self.lubricant is None:
            return ()
        return films(self.perfect_bearing(), operation or self.ideal_operation(), self.lubricant.lubricant())

    def film_loss(self) -> float:
        """Of clearance, diametral, by the films of a lubricant, m; < 0."""
        return -2.0 * sum(film.thickness for film in self.films()) + 0.0  # not -0.0

    def clearance_without_films(self) -> OperatingClearance | None:
        """The same but for the films, which need the bearing that this makes."""
        if self.fit is None or self.bearing.bore_diameter_mm == 0.0:  # a solid shaft has no fit
            return None
        bearing = self.unmounted_bearing()
        roller = self._growths(bearing)[1]
        return operating_clearance(bearing, self.fit.fit(), self.operation.ideal().speed, roller)

    def _growths(self, bearing: Bearing) -> tuple[float, float]:
        """Of the radii of inner raceway and rollers, m, that elastic models give to bodies as they spin."""
        return growths(bearing, kinematics(bearing, *self.operation.ideal().ring_speeds))

    def unmounted_bearing(self) -> Bearing:
        """The bearing's section in SI with the sizes of the scene, without faults of its surfaces."""
        b, roller = self.bearing, self.material.of("roller")
        density = roller.density / b.cosine ** (2 if b.type == "ball" else 1)  # elements have m cos α, see `section`
        shape: dict[str, Any] = dict(
            n_rollers=b.present,
            missing=tuple(sorted(b.missing_rollers)),
            contact_angle=radians(b.contact_angle_deg),
            rows=b.rows,
            roller_radius=0.5 * MM * b.roller_diameter_mm * b.cosine,
            roller_length=MM * b.roller_length_mm,
            inner_raceway_radius=0.5 * MM * b.inner_raceway_diameter_mm,
            outer_raceway_radius=0.5 * MM * b.outer_raceway_diameter_mm,
            bore_radius=0.5 * MM * b.bore_diameter_mm,
            outside_radius=0.5 * MM * b.outside_diameter_mm,
            roller=replace(roller, density=density, rigid=self.bodies.rollers == "rigid"),
            inner_ring=replace(self.material.of("inner_ring"), rigid=self.bodies.inner_ring == "rigid"),
            outer_ring=replace(self.material.of("outer_ring"), rigid=self.bodies.outer_ring == "rigid"),
            own_law=self.lagrange.own_law(),
        )
        if b.type == "roller":
            return Bearing(**shape)
        if b.inner_conformity is None or b.outer_conformity is None:
            raise ValueError('bearing.type = "ball" without inner_conformity or outer_conformity; leave None out')
        return BallBearing(
            **shape,
            inner_groove_radius=MM * b.inner_conformity * b.roller_diameter_mm,
            outer_groove_radius=MM * b.outer_conformity * b.roller_diameter_mm,
        )

    def ideal_cage(self) -> Cage | None:
        """The cage in SI; None: there is none."""
        return None if self.cage is None else self.cage.cage(self.perfect_bearing())

    @property
    def parts_of_tilt(self) -> tuple[str, ...]:
        """Of `lagrange.columns.COLUMNS` that runs of rollers that tilt have."""
        if self.axial is None:
            return ()
        return "axial", *(("damping of tilt",) if self.damping.contacts.acts else ())

    @property
    def parts(self) -> tuple[str, ...]:
        """Of `lagrange.columns.COLUMNS` that runs have beside those of every run."""
        there = {
            "surfaces": self.ideal_bearing().faults,  # no films where nothing rolls
            "cage": self.cage is not None,
            "damping": self.damping.acts,
        }
        return *self.mounting().parts, *(name for name, is_there in there.items() if is_there), *self.parts_of_tilt

    def ideal_axial(self) -> Axial | None:
        """Profiles, slices and tilt in SI; None: the bearing is a plane section."""
        return None if self.axial is None else self.axial.axial(self.perfect_bearing())

    def ideal_operation(self) -> Operation:
        """The operating point in SI, of the bearing's section."""
        operation = replace(self.operation.ideal(), mounting=self._mounting())
        return section_operation(self.perfect_bearing(), operation)

    def mounting(self) -> Mounting:
        """What the bearing's section stands in, in SI."""
        return section_mounting(self.perfect_bearing(), self._mounting())

    def _mounting(self) -> Mounting:
        return Mounting(
            points=None if self.support is None else self.support.points(),
            housing=None if self.support is None else self.support.housing(),
            bore=None if self.support is None else self.support.bore(),
            sensor=None if self.sensor is None else self.sensor.sensor(),
            shaft=self.operation.springs(),
        )

    @property
    def files(self) -> dict[str, str]:
        """Texts of the files that it names, by their digests, as far as they are at hand."""
        profiles = {table.sha256: table.content for table in self.profile
                    if table.sha256 is not None and table.content is not None}  # fmt: skip
        law = self.lagrange.law_table_sha256, self.lagrange.law_table_content
        laws = {} if law[0] is None or law[1] is None else {law[0]: law[1]}
        axial = {} if self.axial is None else self.axial.files
        return profiles | self.operation.files | laws | axial
