"""The scene file: TOML in the bearing engineer's units, validated, given out as SI objects.

It stands on the ground floor because both the solver and the checker read it, and neither may know the other.
"""

import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import replace
from itertools import pairwise
from math import pi
from pathlib import Path
from typing import Any, Literal, Self

import tomli_w
from pydantic import Field, PrivateAttr, ValidationError, model_validator

from lagrange.bearing import BallBearing, Bearing, Operation
from lagrange.cage import Cage
from lagrange.catalogue import designations, inner_ring_and_shaft
from lagrange.film import films
from lagrange.mounting import Mounting
from lagrange.raceway_laws import law_names
from lagrange.scene_bearing import BearingTable, BodiesTable, MaterialTable
from lagrange.scene_cage import CageTable, cage_faults
from lagrange.scene_columns import Columns
from lagrange.scene_damping import DampingTable, with_former_name
from lagrange.scene_faults import Check, Table, all_faults, printable
from lagrange.scene_files import content_in_place, content_of
from lagrange.scene_lubricant import LubricantTable
from lagrange.scene_operation import OperationTable
from lagrange.scene_run import (
    ContactTable,
    LagrangeTable,
    NumericsTable,
    OutputTable,
    ReducedTable,
)
from lagrange.scene_support import SensorTable, SupportTable
from lagrange.scene_surfaces import (
    ProfileTable,
    SpallTable,
    UnequalRollerTable,
    WavinessTable,
    profile_faults,
    roller_faults,
    size_faults,
    spall_faults,
)

LONGEST_TEXT = 2**20  # characters of a scene
MOST_FAULTS = 15  # told at once: a file that is no scene may have thousands
MM = 1e-3
FINEST = {"resolved": 2000.0}  # roller diameters over mesh sizes; of all other contact models:
FINEST_OTHERWISE = 400.0
SURFACES = ("spall", "waviness", "unequal_roller", "profile")  # arrays of tables
FILE_KEYS = ("file", "sha256", "content", "speed_table", "load_table")  # of tables that name a file
MOST_TABLES = 200  # of one array


class SceneError(ValueError):
    """The scene can't be used; the text names file, key, value and limit, one fault a line."""


class Scene(Table):
    """A whole scene. Defaults are the paper's bearing."""

    name: str = Field(
        "paper",
        min_length=1,
        max_length=100,
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._ -]*$",
        description="of the scene, and of the files that runs write",
    )
    model: Literal["fem", "reduced", "lagrange"] = Field(
        "fem", description="finite elements; elastic bodies without their mass; rigid bodies on contact springs"
    )
    bearing: BearingTable = BearingTable()
    material: MaterialTable = MaterialTable()
    bodies: BodiesTable = BodiesTable()
    operation: OperationTable = OperationTable()
    contact: ContactTable = ContactTable()
    damping: DampingTable = DampingTable()
    lagrange: LagrangeTable = LagrangeTable()
    reduced: ReducedTable = ReducedTable()
    numerics: NumericsTable = NumericsTable()
    output: OutputTable = OutputTable()
    support: SupportTable | None = None
    sensor: SensorTable | None = None
    cage: CageTable | None = None
    lubricant: LubricantTable | None = None
    spall: list[SpallTable] = Field([], max_length=MOST_TABLES)
    waviness: list[WavinessTable] = Field([], max_length=MOST_TABLES)
    unequal_roller: list[UnequalRollerTable] = Field([], max_length=MOST_TABLES)
    profile: list[ProfileTable] = Field([], max_length=MOST_TABLES)
    table: Columns = Columns()

    _written: dict[str, Any] | None = PrivateAttr(None)  # the tables as they were given, before they were completed

    @model_validator(mode="wrap")
    @classmethod
    def _remembered(cls, data: Any, handler: Callable[[Any], Self]) -> Self:
        """Keep what was written: a clearance that is varied must not meet the diameter that followed from another."""
        scene = handler(data)
        if isinstance(data, dict):
            scene._written = {key: _plain(value) for key, value in data.items()}
        return scene

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
        data = with_former_name(data)
        bearing, options, operation = data.get("bearing"), data.get("lagrange", {}), data.get("operation", {})
        if not isinstance(bearing, dict):
            return data
        if bearing.get("type") == "ball" and isinstance(options, dict):
            data = data | {"lagrange": {"law": "hertz"} | options}
        standard = bearing.get("designation")
        if standard in designations() and isinstance(operation, dict):
            mass = {"inner_ring_and_shaft_kg": inner_ring_and_shaft(standard)}
            data = {"name": standard} | data | {"operation": mass | operation}
        return data

    def checks(self) -> tuple[Check, ...]:
        surfaces = self._surface_models, self._rollers_with_faults, self._spalls, self._sizes, self._profiles
        tables = self._rigid_contacts, self._support, self._cage, self._damping, self._courses
        return self._law, self._mass, self._mesh, self._fields, *tables, *surfaces

    def _law(self) -> Iterator[str]:
        known = law_names(self._perfect_bearing())
        if self.lagrange.law not in known:
            yield (
                f"lagrange.law = {self.lagrange.law!r}: unknown for bearing.type = {self.bearing.type!r}; known are "
                f"{', '.join(known)}"
            )

    def _mass(self) -> Iterator[str]:
        ring = self._perfect_bearing().inner_ring_mass
        if self.operation.inner_ring_and_shaft_kg <= ring:
            yield (
                f"operation.inner_ring_and_shaft_kg = {self.operation.inner_ring_and_shaft_kg} must exceed the mass of "
                f"the elastic inner ring, {ring:.4g} kg"
            )

    def _mesh(self) -> Iterator[str]:
        if self.bearing.type == "ball":
            return
        size, roller = self.numerics.mesh_size_mm, self.bearing.roller_diameter_mm
        coarsest = pi * roller / 10.0
        if size > coarsest:
            yield (f"numerics.mesh_size_mm = {size} is too coarse for rollers of {roller} mm (at most {coarsest:.3g})")
        finest = roller / FINEST.get(self.contact.model, FINEST_OTHERWISE)
        if size < finest:
            yield (
                f"numerics.mesh_size_mm = {size} is finer than contact.model = '{self.contact.model}' is made for "
                f"(at least {finest:.3g})"
            )

    def _fields(self) -> Iterator[str]:
        every = self.output.fields_every_ms
        if every > 0.0 and self.model != "fem":
            yield (
                f"output.fields_every_ms = {every}: model = {self.model!r} has no mesh and no fields; leave it out or 0"
            )
        interval = 1e-3 * self.numerics.output_interval_us
        if 0.0 < every < interval * (1.0 - 1e-9):
            yield (
                f"output.fields_every_ms = {every} must not be below numerics.output_interval_us = "
                f"{self.numerics.output_interval_us} ({interval:g} ms); 0 stores none"
            )

    def _rigid_contacts(self) -> Iterator[str]:
        if self.bodies.rigid and self.contact.model != "subgrid":
            yield (
                f'bodies.{self.bodies.rigid[0]} = "rigid": only with contact.model = "subgrid", not with '
                f'"{self.contact.model}", whose points of pressure sit on meshes'
            )

    def _damping(self) -> Iterator[str]:
        if self.damping.bodies_1_s > 0.0 and self.model != "fem":
            yield (
                f"damping.bodies_1_s = {self.damping.bodies_1_s:g}: only for bodies with meshes, which model = "
                f"{self.model!r} has none of; leave it out, or take model = 'fem'"
            )
        if self.damping.bodies_1_s > 0.0 and self.mounting().housing is not None:
            yield (
                f"damping.bodies_1_s = {self.damping.bodies_1_s:g}: not together with a housing that moves, against "
                "which the outer ring's own motion is not known; leave one of them out"
            )
        if not self.damping.contacts.acts:
            return
        if self.model == "fem" and self.contact.model != "subgrid":
            yield (
                f'[damping] of contacts: only with contact.model = "subgrid", not with "{self.contact.model}", whose '
                "points of pressure stand for part of a contact; leave one of them out"
            )
        if self.model == "reduced" and self.reduced.modes_up_to_kHz > 0.0:
            yield (
                f"reduced.modes_up_to_kHz = {self.reduced.modes_up_to_kHz:g}: not together with [damping] of contacts, "
                "which would feed the modes; leave one of them out"
            )

    def _support(self) -> Iterator[str]:
        mounting = self.mounting()
        if (mounting.housing is not None or mounting.points is not None) and self.model != "fem":
            yield (
                f'support.kind = "{self.support.kind}": only with model = "fem", not with "{self.model}", whose outer '
                "ring is held all around by the ground; leave one of them out"
            )
        if mounting.points is not None and self.bodies.outer_ring == "rigid":
            yield 'support.kind = "points": a rigid outer ring is held as well by any; leave one of them out'
        if mounting.points is not None and self.contact.model != "subgrid":
            yield (
                f'support.kind = "points": only with contact.model = "subgrid", not with "{self.contact.model}"; leave '
                "one of them out"
            )
        if self.sensor is not None and mounting.housing is None:
            yield (
                '[sensor]: stands on a housing that moves; add [support] with kind = "housing", or leave the sensor out'
            )

    def _cage(self) -> Iterator[str]:
        if self.cage is not None:
            yield from cage_faults(self._perfect_bearing(), self.cage)
            if self.cage.guidance == "outer_ring" and self.mounting().housing is not None:
                yield (
                    'cage.guidance = "outer_ring": not in a housing that moves; take "rollers" or "inner_ring", or '
                    "leave [support] out"
                )
            if self.cage.guidance == "inner_ring" and self.operation.speed_table is not None:
                yield (
                    f'cage.guidance = "inner_ring": only at a steady speed, not with operation.speed_table = '
                    f'"{self.operation.speed_table}"; take "rollers" or "outer_ring"'
                )

    def _courses(self) -> Iterator[str]:
        yield from self.operation.duration_faults(self.numerics.duration_ms)
        if self.lubricant is not None and self.operation.speed_table is not None:
            yield (
                "[lubricant]: only at a steady speed, not with operation.speed_table = "
                f'"{self.operation.speed_table}": its film is as thick as at one speed; leave one of them out'
            )
        if self.operation.changes and self.model == "fem" and self.contact.model != "subgrid":
            yield (
                f'operation.{self.operation.changes}: only with contact.model = "subgrid", not with '
                f'"{self.contact.model}", which is there to compare contacts; leave one of them out'
            )

    def _surface_models(self) -> Iterator[str]:
        given = [f"[[{name}]]" for name in SURFACES if getattr(self, name)]
        given += [] if self.lubricant is None else ["[lubricant]"]
        if given and self.bearing.type == "ball":
            yield f'{given[0]}: only for rollers, not with bearing.type = "ball"; leave it out'
        if given and self.model == "fem" and self.contact.model != "subgrid":
            yield (
                f'{given[0]}: only with contact.model = "subgrid", not with "{self.contact.model}", whose points of '
                "pressure lie on perfect circles; leave one of them out"
            )

    def _rollers_with_faults(self) -> Iterator[str]:
        yield from roller_faults(self.bearing.rollers, {name: getattr(self, name) for name in SURFACES})

    def _spalls(self) -> Iterator[str]:
        if self.spall:
            yield from spall_faults(self._perfect_bearing(), self.spall)

    def _sizes(self) -> Iterator[str]:
        if self.waviness or self.unequal_roller:
            yield from size_faults(self._perfect_bearing(), self.waviness, self.unequal_roller)

    def _profiles(self) -> Iterator[str]:
        if self.profile:
            yield from profile_faults(self._perfect_bearing(), self.profile)

    def ideal_bearing(self) -> Bearing:
        """The bearing in SI, with the faults of its surfaces and the films on them."""
        faults = tuple(table.fault() for name in SURFACES for table in getattr(self, name))
        perfect = self._perfect_bearing()
        if self.lubricant is not None:
            faults += films(perfect, self.ideal_operation(), self.lubricant.lubricant())
        return replace(perfect, faults=faults)

    @property
    def has_faults(self) -> bool:
        """Whether surfaces are not perfect, but for films."""
        return any(getattr(self, name) for name in SURFACES)

    @property
    def friction_coefficient(self) -> float:
        """Of the contacts, dry or under a film."""
        return self.contact.friction_coefficient if self.lubricant is None else self.lubricant.traction_coefficient

    def _perfect_bearing(self) -> Bearing:
        b = self.bearing
        shape = dict(
            n_rollers=b.rollers,
            roller_radius=0.5 * MM * b.roller_diameter_mm,
            roller_length=MM * b.roller_length_mm,
            inner_raceway_radius=0.5 * MM * b.inner_raceway_diameter_mm,
            outer_raceway_radius=0.5 * MM * b.outer_raceway_diameter_mm,
            bore_radius=0.5 * MM * b.bore_diameter_mm,
            outside_radius=0.5 * MM * b.outside_diameter_mm,
            roller=replace(self.material.of("roller"), rigid=self.bodies.rollers == "rigid"),
            inner_ring=replace(self.material.of("inner_ring"), rigid=self.bodies.inner_ring == "rigid"),
            outer_ring=replace(self.material.of("outer_ring"), rigid=self.bodies.outer_ring == "rigid"),
        )
        if b.type == "roller":
            return Bearing(**shape)
        return BallBearing(
            **shape,
            inner_groove_radius=MM * b.inner_conformity * b.roller_diameter_mm,
            outer_groove_radius=MM * b.outer_conformity * b.roller_diameter_mm,
        )

    def ideal_cage(self) -> Cage | None:
        """The cage in SI; None: there is none."""
        return None if self.cage is None else self.cage.cage(self._perfect_bearing())

    def ideal_operation(self) -> Operation:
        """The operating point in SI."""
        return replace(self.operation.ideal(), mounting=self.mounting())

    def mounting(self) -> Mounting:
        """What the bearing stands in, in SI."""
        return Mounting(
            points=None if self.support is None else self.support.points(),
            housing=None if self.support is None else self.support.housing(),
            sensor=None if self.sensor is None else self.sensor.sensor(),
        )

    @property
    def files(self) -> dict[str, str]:
        """Texts of the files that it names, by their digests, as far as they are at hand."""
        profiles = {table.sha256: table.content for table in self.profile if table.content is not None}
        return profiles | self.operation.files

    def varied(self, changes: Mapping[str, Any]) -> "Scene":
        """This scene with other values under dotted keys, as `--set` has them; the whole is validated anew.

            scene.varied({"operation.speed_rpm": 3000.0, "spall.0.body": "outer_ring"})

        Errors
        ------
        SceneError: an unknown key or an impossible value; a file, which only the reader of a scene puts in its place.
        """
        data = self.model_dump(exclude_none=True) if self._written is None else deepcopy(self._written)
        for table in data.get("profile", []):
            table.pop("content", None)
        for key, value in changes.items():
            if key.rpartition(".")[2] in FILE_KEYS:
                raise SceneError(f"{key}: files of a scene can't be varied; write a scene for each file")
            set_key(data, key, value, key)
        with _refused(self.name):
            content_of(data, self.files)
        return parse_scene(data, self.name)

    def to_toml(self) -> str:
        """The whole scene as TOML that `read_scene` takes back unchanged, where the files are that it names.

        Defaults are spelt out, but for [damping] and [table], which are left out where they hold nothing else; arrays
        of tables are there where they are not empty.
        """
        tables = self.model_dump(exclude_none=True)
        for name in SURFACES:
            if not tables[name]:
                del tables[name]
        for name, empty in (("damping", DampingTable()), ("table", Columns())):
            if getattr(self, name) == empty:
                del tables[name]
        return tomli_w.dumps(tables)


def _plain(value: Any) -> Any:
    """A table as nested dictionaries, of its own."""
    return value.model_dump(exclude_unset=True) if isinstance(value, Table) else deepcopy(value)


def read_scene(path: str | Path | None = None, overrides: tuple[str, ...] = ()) -> Scene:
    """The scene of a TOML file (None: the paper's), with `table.key=value` overrides put on top.

    Errors
    ------
    SceneError: unreadable file, bad TOML, unknown key (with the likely one), wrong type, value out of range,
    values that contradict each other; all faults of the file at once.
    """
    name, data = "built-in scene", {}
    if path is not None:
        name = str(path)
        try:
            with open(path, "rb") as file:
                data = _load(file.read(LONGEST_TEXT + 1).decode("utf-8-sig"), name)
        except OSError as error:
            raise SceneError(f"{name}: can't be read: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise SceneError(f"{name}: not UTF-8 text (byte {error.start}); is it a scene file?") from None
    for override in overrides:
        _apply(data, override)
    with _refused(name):
        content_in_place(data, Path() if path is None else Path(path).parent)
    return parse_scene(data, name)


def parse_scene_text(text: str, name: str, files: dict[str, str] | None = None) -> Scene:
    """A scene from TOML text, e.g. the `scene` attribute of a result file.

    Parameters
    ----------
    files : text of the files that it names, by their digests; None: a scene with profiles can be shown and compared,
        but gives no bearing
    """
    data = _load(text, name)
    with _refused(name):
        content_of(data, files)
    return parse_scene(data, name)


@contextmanager
def _refused(name: str) -> Iterator[None]:
    """Name the scene where a file of it can't be used."""
    try:
        yield
    except ValueError as error:
        raise SceneError(f"{name}: {printable(str(error))}") from None


def _load(text: str, name: str) -> dict[str, Any]:
    """Tables of a TOML text."""
    if len(text) > LONGEST_TEXT:
        raise SceneError(f"{name}: longer than {LONGEST_TEXT} characters; is it a scene file?")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{name}: not valid TOML: {error}") from None
    except RecursionError:
        raise SceneError(f"{name}: not a scene: arrays or tables are nested too deeply") from None
    except ValueError as error:  # Python's own limit on the digits of a whole number
        raise SceneError(f"{name}: not a scene: {str(error).partition(';')[0]}") from None


def parse_scene(data: dict[str, Any], name: str) -> Scene:
    """A scene from nested tables."""
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        faults = all_faults(error, Scene, data)
        lines = [f"{name}: {fault}" for fault in faults[:MOST_FAULTS]]
        if len(faults) > MOST_FAULTS:
            lines.append(f"{name}: and {len(faults) - MOST_FAULTS} more")
        raise SceneError("\n".join(lines)) from None


def _apply(data: dict[str, Any], override: str) -> None:
    """Put `table.key=value` into nested tables; the value is TOML, or a plain string."""
    key, equals, text = override.partition("=")
    if not equals or not all(part.strip() for part in key.split(".")):
        raise SceneError(f"--set {override!r}: must read table.key=value, e.g. --set operation.speed_rpm=3000")
    try:
        value = _load(f"value = {text}", "")
    except SceneError:
        value = {}
    value = value["value"] if set(value) == {"value"} else text.strip()  # more than one: a string with line breaks
    set_key(data, key, value, f"--set {override!r}")


def set_key(data: dict[str, Any], key: str, value: Any, told: str) -> None:
    """Put a value under a dotted key into nested tables; numbers count the tables of an array, as in spall.0.width_mm.

    Parameters
    ----------
    told : how an error names what was asked for

    Errors
    ------
    SceneError: the key leads through a value, to a whole table or past the end of an array.
    """
    parts = [part.strip() for part in key.split(".")]
    if not all(parts):
        raise SceneError(f"{told}: {key!r} must read table.key, e.g. operation.speed_rpm")
    table: Any = data
    for part, after in pairwise(parts):
        table = _entry(table, part, [] if after.isdecimal() else {}, told)
    if isinstance(table, list):
        raise SceneError(f"{told}: {parts[-1]} is a whole table; set one of its keys")
    table[parts[-1]] = value


def _entry(table: dict[str, Any] | list, key: str, empty: dict | list, told: str) -> dict[str, Any] | list:
    """The table, or the array of tables, under a key or a number; made where there is none."""
    if isinstance(table, dict):
        found = table.setdefault(key, empty)
    else:
        if not key.isdecimal() or int(key[:9]) > len(table):
            raise SceneError(f"{told}: {key} is none of {len(table)} tables; numbers go on from 0")
        table.extend([empty] if int(key) == len(table) else [])
        found = table[int(key)]
    if not isinstance(found, dict | list):
        raise SceneError(f"{told}: {key} is a value, not a table")
    return found
