"""The scene file: TOML in the bearing engineer's units, validated, given out as SI objects.

It stands on the ground floor because both the solver and the checker read it, and neither may know the other.
"""

# fmt: off  # a key, or a rule, goes on below where it is long
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from copy import deepcopy
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

import tomli_w
from pydantic import PrivateAttr

from lagrange.axial import Axial
from lagrange.bearing import BallBearing, Bearing, Cage, Operation
from lagrange.catalogue import bearing_keys, inner_ring_and_shaft, listed
from lagrange.files.input import LARGEST_FILE, digest, plain_text
from lagrange.fits import OperatingClearance, growths, in_operation, operating_clearance
from lagrange.kinematics import kinematics
from lagrange.mounting import Mounting
from lagrange.scene import bearing as bearings
from lagrange.scene import run
from lagrange.scene.checks import COMBINATIONS
from lagrange.scene.faults import (
    File,
    Rule,
    SceneError,
    Table,
    beside,
    key,
    likely_of,
    plain,
    printable,
    quoted,
    table_of,
    without_gone,
)
from lagrange.scene.files import LONGEST_TEXT, apply_override, load, set_key
from lagrange.scene.surfaces import SURFACES, ProfileTable, SpallTable, UnequalRollerTable, WavinessTable
from lagrange.section import section_mounting, section_operation
from lagrange.step_size import fitting_interval, wave_interval
from lagrange.surface.faults import Fault, Film
from lagrange.surface.film import films
from lagrange.surface.passages import strike_interval

MOST_TABLES = 200  # of one array
MODEL_NAMES = {"fem": "finite elements", "reduced": "reduced model", "lagrange": "Lagrangian model"}
MESH_SHARE = 0.1  # of a roller's diameter, between surface nodes where the scene gives no mesh size
FITTING = 6.0, 16.0  # mm, diameters of a standard bearing's rollers that the default mesh size serves
DECIDING = {  # keys whose defaults decide an answer, and what may be given in their place
    "speed_rpm": ("speed_table", "outer_ring_speed_rpm", "outer_ring_speed_table"),
    "radial_load_N": ("load_table", "rotating_load_N", "unbalance_g_mm"),
}


class Scene(Table):
    """A whole scene. Defaults are the paper's bearing."""

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

    RULES: ClassVar[tuple[Rule, ...]] = COMBINATIONS
    _written: dict[str, Any] | None = PrivateAttr(None)  # the tables as they were given, before they were completed

    def _fill(self, data: dict[str, Any], name: str) -> None:
        """Keep what was written: a clearance that is varied must not meet the diameter that followed from another."""
        super()._fill(data, name)
        self._written = {each: plain(value) for each, value in data.items()}
        with suppress(ValueError):  # a table of speeds or loads that is not at hand
            self._choose_interval()
        with suppress(ValueError):
            self._choose_cage()

    def _choose_interval(self) -> None:
        """Between samples, where none is given: by the fastest vibration that moves, and so that no warning follows."""
        if "output_interval_us" in self.numerics.model_fields_set:
            return
        bearing, operation = replace(self.perfect_bearing(), faults=self._faults()), self.ideal_operation()
        longest = min(strike_interval(bearing, operation), wave_interval(bearing, operation))
        interval = round(1e6 * fitting_interval(bearing, operation, longest), 3)
        self.__dict__["numerics"] = self.numerics.model_copy(update={"output_interval_us": interval})

    def _choose_cage(self) -> None:
        """Write out the cage that the bearing has: the table's, what it leaves out by default, or no table."""
        found = self.cage or ("" if self.model == "lagrange" else bearings.default_cage(self))
        if isinstance(found, bearings.CageTable) and found.kind != "none":
            moves = self.operation.turns_outer_ring is not None or self.mounting().bore is not None
            self.__dict__["cage"] = found.filled(self.unmounted_bearing(), moves)
        else:
            self.__dict__["cage"] = None

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.__dict__ == other.__dict__

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """See pydantic; what was written is forgotten where a table is exchanged."""
        found = super().model_copy(update=update, deep=deep)
        if update:
            found._written = None
        return found

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        data = without_gone(data)
        bearing, options, operation = data.get("bearing"), data.get("lagrange", {}), data.get("operation", {})
        if not isinstance(bearing, dict):
            return data
        standard, numerics = listed(bearing.get("designation")), data.get("numerics", {})
        known: dict[str, Any] = {} if standard is None else bearing_keys(*standard)
        diameter: Any = bearing.get("roller_diameter_mm")
        if diameter is None and not FITTING[0] <= known.get("roller_diameter_mm", FITTING[0]) <= FITTING[1]:
            diameter = known["roller_diameter_mm"]
        if bearing.get("type", known.get("type")) == "ball":
            data = {"model": "lagrange"} | data  # the one that has balls
            if isinstance(options, dict):
                data = data | {"lagrange": {"law": "hertz"} | run.LagrangeTable.completed(options)}
        elif type(diameter) in (float, int) and 0.5 <= diameter <= 500.0 and isinstance(numerics, dict):
            data = data | {"numerics": {"mesh_size_mm": round(MESH_SHARE * diameter, 6)} | numerics}
        if isinstance(operation, dict):
            if standard is not None:
                data = {"name": standard[0]} | data
            heavy = bearings.heavy_inner_ring_and_shaft
            mass = heavy(bearing) if standard is None else inner_ring_and_shaft(standard[0])
            if mass is not None:
                data = data | {"operation": {"inner_ring_and_shaft_kg": mass} | operation}
        return data

    def varied(self, changes: Mapping[str, Any]) -> "Scene":
        """This scene with other values under dotted keys, as `--set` has them; the whole is validated anew.

            scene.varied({"operation.speed_rpm": 3000.0, "spall.0.body": "outer_ring"})

        Errors
        ------
        SceneError: an unknown key or an impossible value; a file, which only the reader of a scene puts in its place.
        """
        data = self._as_written()
        names = {"sha256", "content"} | {name for _, kind, _ in _kinds() for name in kind.FILES}
        for dotted, value in changes.items():
            if dotted.rpartition(".")[2] in names and not dotted.endswith("_profile"):
                raise SceneError(f"{dotted}: files of a scene can't be varied; write a scene for each file")
            set_key(data, dotted, value, dotted)
        _refuse_beside_tables(data, changes)
        with _refused(self.name):
            content_of(data, self.files)
        return parse_scene(data, self.name)

    @property
    def assumed(self) -> str:
        """Speed and load that a scene of a bearing or an operation leaves to the defaults; empty: it gives both."""
        given = self._as_written()
        operation = given.get("operation", {})
        if "bearing" not in given and not operation:
            return ""
        missing = (name for name, others in DECIDING.items() if operation.keys().isdisjoint((name, *others)))
        return ", ".join(f"operation.{name} = {getattr(self.operation, name):g}" for name in missing)

    def is_given(self, table: str, name: str | None = None) -> bool:
        """Whether a table, or a key of it, was written, and is no default."""
        written = self._as_written()
        return table in written if name is None else name in written.get(table, {})

    def _as_written(self) -> dict[str, Any]:
        """The tables before they were completed, without the texts of the files that they name."""
        data = self._tables() if self._written is None else deepcopy(self._written)
        for _, table, name, _ in _file_keys(data):
            table.pop(beside(name, "content"), None)
        return data

    def to_written_toml(self) -> str:
        """TOML of the scene as it was written, of which `parse_scene_text` makes one that can be varied as this one."""
        return tomli_w.dumps(self._as_written())

    def to_toml(self) -> str:
        """The whole scene as TOML that `read_scene` takes back unchanged, where the files are that it names.

        Defaults are spelt out, but for [damping] and [table], which are left out where they hold nothing else; arrays
        of tables are there where they are not empty.
        """
        tables = self._tables()
        empty = {name for name in SURFACES if not tables[name]}
        empty |= {name for name in ("damping", "table") if getattr(self, name) == type(getattr(self, name))()}
        return tomli_w.dumps({name: table for name, table in tables.items() if name not in empty})

    def _tables(self) -> dict[str, Any]:
        """All tables; that a bearing has no cage is said where it would have one otherwise."""
        tables = self.model_dump(exclude_none=True)
        return tables if self.cage is not None or self.model == "lagrange" else tables | {"cage": {"kind": "none"}}

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

    @property
    def files(self) -> dict[str, str]:
        """Texts of the files that it names, by their digests, as far as they are at hand."""
        found = dict[str, str]()
        for name, _, many in _kinds():
            for table in getattr(self, name) if many else [getattr(self, name)]:
                found |= {} if table is None else table.files
        return found

    def ideal_bearing(self) -> Bearing:
        """The bearing in SI, with the faults of its surfaces and the films on them."""
        return replace(self.perfect_bearing(), faults=self._faults() + self.films())

    def _faults(self) -> tuple[Fault, ...]:
        """Of its surfaces, without films."""
        return tuple(table.fault() for name in SURFACES for table in getattr(self, name))

    def perfect_bearing(self) -> Bearing:
        """The bearing in SI with the sizes that it has in operation, without faults of its surfaces."""
        bearing, found = self.unmounted_bearing(), self.clearance_without_films()
        if found is None:
            return bearing
        return in_operation(bearing, found, (0.0, 0.0) if self.model == "lagrange" else self._growths(bearing))

    def unmounted_bearing(self) -> Bearing:
        """The bearing's section in SI with the sizes of the scene, without faults of its surfaces."""
        b, si, rigid = self.bearing, self.bearing.si(), self.bodies.rigid
        roller = self.material.of("roller", "rollers" in rigid)  # elements have m cos α, see `section`
        shape: dict[str, Any] = dict(n_rollers=b.present, missing=tuple(sorted(b.missing_rollers)),
            contact_angle=radians(b.contact_angle_deg), roller_radius=0.5 * si["roller_diameter"] * b.cosine,
            inner_raceway_radius=0.5 * si["inner_raceway_diameter"], outer_raceway_radius=0.5 * si[
            "outer_raceway_diameter"], bore_radius=0.5 * si["bore_diameter"], outside_radius=0.5 * si[
            "outside_diameter"], roller=replace(roller, density=roller.density / b.cosine ** (2 if b.type ==
            "ball" else 1)), inner_ring=self.material.of("inner_ring", "inner_ring" in rigid),
            outer_ring=self.material.of("outer_ring", "outer_ring" in rigid), own_law=self.lagrange.own_law())
        if b.type == "roller":
            return b.fact(Bearing, **shape)
        if b.inner_conformity is None or b.outer_conformity is None:
            raise ValueError('bearing.type = "ball" without inner_conformity or outer_conformity; leave None out')
        return b.fact(BallBearing, **shape, inner_groove_radius=1e-3 * b.inner_conformity * b.roller_diameter_mm,
            outer_groove_radius=1e-3 * b.outer_conformity * b.roller_diameter_mm)

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
        support, shaft = self.support, self.operation.springs()
        sensor = None if self.sensor is None else self.sensor.sensor()
        if support is None:
            return Mounting(sensor=sensor, shaft=shaft)
        points, housing, bore = support.points(), support.housing(), support.bore()
        return Mounting(points=points, housing=housing, bore=bore, sensor=sensor, shaft=shaft)

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


def _kinds() -> Iterator[tuple[str, type[Table], bool]]:
    """Tables of a scene that name files, and whether there may be many."""
    for name, field in Scene.model_fields.items():
        kind, many = table_of(field)
        if kind is not None and kind.FILES:
            yield name, kind, many


def _file_keys(data: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any], str, File]]:
    """Keys of a scene's tables that name files: place, table, key; tables of other forms are left to their checks."""
    for place, kind, many in _kinds():
        given: Any = data.get(place)
        tables = enumerate(given if isinstance(given, list) else ()) if many else [("", given)]
        for number, table in tables:
            for name, file in kind.FILES.items() if isinstance(table, dict) else ():
                yield f"{place}.{number}".rstrip("."), table, name, file


def _named_files(data: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any], str, File]]:
    """The files themselves, with what to call them. ValueError: a text stands where a file is to be named."""
    for place, table, name, file in _file_keys(data):
        if (content := beside(name, "content")) in table:
            raise ValueError(f"{place}.{content}: unknown key; {file.kind} are read from a file")
        if isinstance(given := table.get(name), str) and given and given not in file.forms:
            yield f'{place}.{name} = "{given}"', table, name, file


def content_in_place(data: dict[str, Any], folder: Path) -> None:
    """Put the files of [[profile]], [operation], [lagrange] and [axial] into the tables of a scene in a folder.

    Errors
    ------
    ValueError: no such file, unreadable, too large, not text; not the one whose digest the scene gives.
    """
    for described, table, name, file in _named_files(data):
        path = folder / table[name]
        try:
            text = plain_text(path, LARGEST_FILE)
        except ValueError as error:
            forms = f"; forms are {', '.join(file.forms)}" if file.forms else ""
            hint = f"; is it a table of {file.kind}?"
            if "can't be read" in str(error):
                hint = f" (looked for in {path.parent.resolve()}){forms}"
            raise ValueError(f"{described}: {error}{hint}") from None
        if table.setdefault(beside(name, "sha256"), digest(text)) != digest(text):
            raise ValueError(f"{described}: its sha256 is {digest(text)}, another than the scene gives; leave the "
                "sha256 out for this file")
        table[beside(name, "content")] = text


def content_of(data: dict[str, Any], files: Mapping[str, str] | None) -> None:
    """The same from texts by their digests; None: all stay out.

    Errors
    ------
    ValueError: one is not among them.
    """
    for described, table, name, _ in _named_files(data):
        if files is not None:
            text = files.get(table.get(beside(name, "sha256"), ""))
            if text is None:
                raise ValueError(f"{described}: its text is not here")
            table[beside(name, "content")] = text


def read_scene(
    path: str | Path | None = None, overrides: tuple[str, ...] = (), changes: Mapping[str, Any] | None = None
) -> Scene:
    """The scene of a TOML file (None: the paper's), with `table.key=value` overrides and values by key put on top.

    Errors
    ------
    SceneError: unreadable file, bad TOML, unknown key (with the likely one), wrong type, value out of range,
    values that contradict each other; all faults of the file at once.
    """
    name, data = "built-in scene", {}
    if path is not None:
        name, path = str(path), Path(path)
        try:
            text = plain_text(path, LONGEST_TEXT)
        except ValueError as error:
            if path.exists():
                hint = "" if "can't be read" in str(error) else "; is it a scene file?"
                raise SceneError(f"{name}: {error}{hint}") from None
            scenes = {each.stem: each for each in path.parent.glob("*.toml")} if path.parent.is_dir() else {}
            likely = likely_of(path.stem, scenes)
            hint = f"did you mean {scenes[likely]}?" if likely else "run-fem --example NU206 writes one to begin with"
            raise SceneError(f"{name}: no such file; {hint}") from None
        data = load(text, name)
    for override in overrides:
        apply_override(data, override)
    for dotted, value in (changes or {}).items():
        set_key(data, dotted, value, dotted)
    _refuse_beside_tables(data, [*(override.partition("=")[0].strip() for override in overrides), *(changes or {})])
    with _refused(name):
        content_in_place(data, Path() if path is None else Path(path).parent)
    return parse_scene(data, name)


def _refuse_beside_tables(data: dict[str, Any], changed: Iterable[str]) -> None:
    """Refuse a change of a value in whose place a table is. SceneError."""
    operation = data.get("operation")
    for table, name in run.IN_PLACE_OF.items():
        if f"operation.{name}" in changed and isinstance(operation, dict) and operation.get(table) is not None:
            raise SceneError(f"operation.{name} = {quoted(operation.get(name))}: operation.{table} = "
                f"{quoted(operation[table])} is in its place; leave one of them out")


def parse_scene_text(text: str, name: str, files: dict[str, str] | None = None, **usual: Any) -> Scene:
    """A scene from TOML text, e.g. the `scene` attribute of a result file.

    Parameters
    ----------
    files : text of the files that it names, by their digests; None: a scene with profiles can be shown and compared,
        but gives no bearing
    usual : tables where the text has none
    """
    data = load(text, name)
    with _refused(name):
        content_of(data, files)
    return parse_scene(usual | data, name)


def parse_stored_scene(text: str, name: str, files: dict[str, str] | None = None) -> Scene:
    """The scene of a result file, as `parse_scene_text`; one without [cage], of an earlier version, had none."""
    try:
        return parse_scene_text(text, name, files, cage={"kind": "none"})
    except SceneError as error:
        raise SceneError(f"{error}\nif an earlier version wrote the file, run the scene again") from None


@contextmanager
def _refused(name: str) -> Iterator[None]:
    """Name the scene where a file of it can't be used."""
    try:
        yield
    except ValueError as error:
        raise SceneError(f"{name}: {printable(str(error))}") from None


def parse_scene(data: dict[str, Any], name: str) -> Scene:
    """A scene from nested tables. SceneError: all that is wrong with them."""
    return Scene.parsed(data, name)
