"""All tables of the scene file, and what they are in SI."""

# fmt: off
from dataclasses import replace
from typing import Any, Literal

from lagrange.axial import Axial
from lagrange.bearing import BallBearing, Bearing, Cage, Operation, section_mounting, section_operation
from lagrange.fits import OperatingClearance, growths, in_operation, operating_clearance
from lagrange.kinematics import kinematics
from lagrange.mounting import Mounting, Sensor
from lagrange.scene import bearing as bearings
from lagrange.scene import run
from lagrange.scene.faults import Table, key
from lagrange.scene.surfaces import SURFACES, ProfileTable, SpallTable, UnequalRollerTable, WavinessTable
from lagrange.surface.faults import Fault, Film
from lagrange.surface.film import films

MOST_TABLES = 200  # of one array


class Tables(Table):
    """What a scene holds. Defaults are the paper's bearing."""

    name: str = key("paper", "name of the scene and of its result files", min_length=1, max_length=100, pattern=
        r"^[A-Za-z0-9][A-Za-z0-9._ -]*$")
    model: Literal["fem", "reduced", "lagrange"] = key("fem", "finite elements; elastic bodies without inertia of "
        "their own; rigid bodies on contact springs")
    bearing: bearings.BearingTable = bearings.BearingTable()
    material: bearings.MaterialTable = bearings.MaterialTable()
    fit: bearings.FitTable | None = None
    bodies: bearings.BodiesTable = bearings.BodiesTable()
    operation: run.OperationTable = run.OperationTable()
    contact: run.ContactTable = run.ContactTable()
    damping: run.DampingTable = run.DampingTable()
    lagrange: run.LagrangeTable = run.LagrangeTable()
    numerics: run.NumericsTable = run.NumericsTable()
    output: run.OutputTable = run.OutputTable()
    support: run.SupportTable | None = None
    sensor: run.SensorTable | None = None
    cage: bearings.CageTable | None = None
    lubricant: bearings.LubricantTable | None = None
    axial: bearings.AxialTable | None = None
    spall: list[SpallTable] = key([], "", max_length=MOST_TABLES)
    waviness: list[WavinessTable] = key([], "", max_length=MOST_TABLES)
    unequal_roller: list[UnequalRollerTable] = key([], "", max_length=MOST_TABLES)
    profile: list[ProfileTable] = key([], "", max_length=MOST_TABLES)
    table: run.Columns = run.Columns()

    def default_cage(self) -> bearings.CageTable | str:
        """The cage where there is no table of it; in words why there is none."""
        return bearings.default_cage(self.bearing, self.unmounted_bearing(), self.friction_coefficient)

    @property
    def has_faults(self) -> bool:
        """Whether surfaces are not perfect, but for films."""
        return any(getattr(self, name) for name in SURFACES)

    @property
    def load_ramp(self) -> float:
        """Time over which the load grows from nothing, s."""
        return 1e-3 * self.numerics.load_ramp_ms if self.numerics.start == "rest" else 0.0

    @property
    def friction_coefficient(self) -> float:
        """Of the contacts, dry or under a film."""
        return self.contact.friction_coefficient if self.lubricant is None else self.lubricant.traction_coefficient

    def ideal_bearing(self) -> Bearing:
        """The bearing in SI, with the faults of its surfaces and the films on them."""
        return replace(self.perfect_bearing(), faults=self._faults() + self.films())

    def _faults(self) -> tuple[Fault, ...]:
        return tuple(table.fault() for name in SURFACES for table in getattr(self, name))

    def perfect_bearing(self) -> Bearing:
        """The bearing in SI with the sizes that it has in operation, without faults of its surfaces."""
        bearing, found = self.unmounted_bearing(), self.clearance_without_films()
        if found is None:
            return bearing
        return in_operation(bearing, found, (0.0, 0.0) if self.model == "lagrange" else self._growths(bearing))

    def unmounted_bearing(self) -> Bearing:
        """The bearing's section in SI with the sizes of the scene, without faults of its surfaces."""
        b, si, rigid, balls = self.bearing, self.bearing.si(), self.bodies.rigid, self.bearing.type == "ball"
        roller = self.material.of("roller", "rollers" in rigid)  # elements have m cos α, see `section`
        radii = {f"{name}_radius": 0.5 * si[f"{name}_diameter"]
            for name in ("inner_raceway", "outer_raceway", "bore", "outside")}
        shape: dict[str, Any] = dict(n_rollers=b.present, missing=tuple(sorted(b.missing_rollers)), **radii,
            roller_radius=0.5 * si["roller_diameter"] * b.cosine, own_law=self.lagrange.own_law(),
            roller=replace(roller, density=roller.density / b.cosine ** (2 if balls else 1)),
            inner_ring=self.material.of("inner_ring", "inner_ring" in rigid),
            outer_ring=self.material.of("outer_ring", "outer_ring" in rigid))
        grooves = {f"{side}_groove_radius": 1e-3 * si[f"{side}_conformity"] * b.roller_diameter_mm
            for side in ("inner", "outer") if balls}
        return b.fact(BallBearing if balls else Bearing, **shape, **grooves)

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
        return operating_clearance(bearing, self.fit.fit(), self.operation.ideal().speed, self._growths(bearing)[1])

    def _growths(self, bearing: Bearing) -> tuple[float, float]:
        """Of the radii of inner raceway and rollers, m, that elastic models give to bodies as they spin."""
        return growths(bearing, kinematics(bearing, *self.operation.ideal().ring_speeds))

    def ideal_cage(self) -> Cage | None:
        """The cage in SI; None: there is none."""
        return None if self.cage is None else self.cage.cage(self.perfect_bearing())

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
        return Mounting(**{} if self.support is None else self.support.parts(), shaft=self.operation.springs(),
            sensor=None if self.sensor is None else self.sensor.fact(Sensor))

    @property
    def parts_of_tilt(self) -> tuple[str, ...]:
        """Of `lagrange.columns.COLUMNS` that runs of rollers that tilt have."""
        return ("axial", "damping of tilt")[: 1 + self.damping.contacts.acts] if self.axial is not None else ()

    @property
    def parts(self) -> tuple[str, ...]:
        """Of `lagrange.columns.COLUMNS` that runs have beside those of every run."""
        there = {"surfaces": self.ideal_bearing().faults, "cage": self.cage, "damping": self.damping.acts}
        return *self.mounting().parts, *(name for name, is_there in there.items() if is_there), *self.parts_of_tilt
