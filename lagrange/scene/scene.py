"""The scene file: TOML in the bearing engineer's units, validated, given out as SI objects to solver and checker."""

# fmt: off
from collections.abc import Mapping
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

import tomli_w
from pydantic import PrivateAttr

from lagrange.axial.slices import Axial
from lagrange.bearing import BallBearing, Bearing, Cage, Operation, RowLoads, section_mounting, section_operation
from lagrange.catalogue import bearing_keys, inner_ring_and_shaft, listed
from lagrange.files.input import LARGEST_FILE, digest, plain_text
from lagrange.fits import OperatingClearance, growths, in_operation, operating_clearance
from lagrange.kinematics import kinematics
from lagrange.mounting import Mounting, Sensor
from lagrange.rating.life import Basic
from lagrange.scene import bearing as bearings
from lagrange.scene import faults, run
from lagrange.scene.checks import COMBINATIONS
from lagrange.scene.faults import SceneError, Table, apply_override, beside, key, load, plain, quoted, set_key, table_of
from lagrange.scene.surfaces import SURFACES, ProfileTable, SpallTable, UnequalRollerTable, WavinessTable
from lagrange.step_size import fitting_interval, wave_interval
from lagrange.surface.faults import Film
from lagrange.surface.film import films
from lagrange.surface.passages import strike_interval

MODEL_NAMES = {"fem": "finite elements", "reduced": "reduced model", "lagrange": "Lagrangian model"}
MOST_TABLES = 200  # of one array
MESH_SHARE = 0.1  # of a roller's diameter, between surface nodes where the scene gives no mesh size
FITTING = 6.0, 16.0  # mm, diameters of a standard bearing's rollers that the default mesh size serves
DECIDING = {  # keys whose defaults decide an answer, and what may be given in their place
    "speed_rpm": ("speed_table", "outer_ring_speed_rpm", "outer_ring_speed_table"),
    "radial_load_N": ("load_table", "rotating_load_N", "unbalance_g_mm")}


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

    RULES: ClassVar[tuple[faults.Rule, ...]] = COMBINATIONS
    _written: dict[str, Any] | None = PrivateAttr(None)  # the tables as they were given, before they were completed

    def _fill(self, data, name):
        """Keep what was written: a clearance that is varied must not meet the diameter that followed from another."""
        super()._fill(data, name)
        self._written = {each: plain(value) for each, value in data.items()}
        with suppress(ValueError):  # a table of speeds or loads that is not at hand
            if "output_interval_us" not in self.numerics.model_fields_set:
                # by the fastest vibration that moves, and so that no warning follows
                bearing, operation = replace(self.perfect_bearing(), faults=self._faults()), self.ideal_operation()
                longest = min(strike_interval(bearing, operation), wave_interval(bearing, operation))
                interval = round(1e6 * fitting_interval(bearing, operation, longest), 3)
                self.__dict__["numerics"] = self.numerics.model_copy(update={"output_interval_us": interval})
        with suppress(ValueError):  # the cage that the bearing has: the table's, what it leaves out by default, or none
            cage = self.cage or (None if self.model == "lagrange" else self.default_cage())
            moves = self.operation.turns_outer_ring is not None or self.mounting().bore is not None
            self.__dict__["cage"] = (cage.filled(self.unmounted_bearing(), moves)
                if isinstance(cage, bearings.CageTable) and cage.kind != "none" else None)

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
        data = faults.without_gone(data)
        options, operation, numerics = (data.get(name, {}) for name in ("lagrange", "operation", "numerics"))
        if not isinstance(bearing := data.get("bearing"), dict):
            return data
        standard = listed(bearing.get("designation"))
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
            mass = bearings.heavy_inner_ring_and_shaft(bearing)
            if standard is not None:
                data, mass = {"name": standard[0]} | data, inner_ring_and_shaft(standard[0])
            if mass is not None:
                data = data | {"operation": {"inner_ring_and_shaft_kg": mass} | operation}
        return data

    def varied(self, changes: Mapping[str, Any]) -> "Scene":
        """This scene with other values under dotted keys, as `--set` has them; the whole is validated anew.

            scene.varied({"operation.speed_rpm": 3000.0, "spall.0.body": "outer_ring"})

        SceneError: an unknown key or an impossible value; a file, which only the reader of a scene puts in its place.
        """
        data = self._as_written()
        names = {"sha256", "content"} | {name for kind, _ in FILED.values() for name in kind.FILES}
        for dotted in changes:
            if dotted.rpartition(".")[2] in names and not dotted.endswith("_profile"):
                raise SceneError(f"{dotted}: files of a scene can't be varied; write a scene for each file")
        _change(data, changes)
        content_of(data, self.files, self.name)
        return parse_scene(data, self.name)

    @property
    def assumed(self) -> str:
        """Speed and load that a scene of a bearing or an operation leaves to the defaults; empty: it gives both."""
        operation = self._as_written().get("operation", {})
        if not self.is_given("bearing") and not operation:
            return ""
        missing = (name for name, others in DECIDING.items() if operation.keys().isdisjoint((name, *others)))
        return ", ".join(f"operation.{name} = {getattr(self.operation, name):g}" for name in missing)

    def is_given(self, table: str, name: str | None = None) -> bool:
        """Whether a table, or a key of it, was written, and is no default."""
        written = self._as_written()
        return table in written if name is None else name in written.get(table, {})

    def _as_written(self):
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

        Defaults are spelt out, but for [damping] and [table] that hold nothing else; empty arrays are left out.
        """
        tables = self._tables()
        empty = {name for name in SURFACES if not tables[name]}
        empty |= {name for name in ("damping", "table") if getattr(self, name) == type(getattr(self, name))()}
        return tomli_w.dumps({name: table for name, table in tables.items() if name not in empty})

    def _tables(self):
        """All tables; that a bearing has no cage is said where it would have one otherwise."""
        tables = self.model_dump(exclude_none=True)
        return tables if self.cage is not None or self.model == "lagrange" else tables | {"cage": {"kind": "none"}}

    @property
    def method(self) -> str:
        """Model and damping in words, for the captions of pictures."""
        return f"{MODEL_NAMES[self.model]}, {self.damping.words}"

    @property
    def files(self) -> dict[str, str]:
        """Texts of the files that it names, by their digests, as far as they are at hand."""
        found = dict[str, str]()
        for name, (_, many) in FILED.items():
            for table in getattr(self, name) if many else filter(None, [getattr(self, name)]):
                found |= table.files
        return found

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

    def _faults(self):
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

    def _growths(self, bearing):
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

    def ratings(self) -> Basic:
        """C, C0 and C_u: given, else the maker's, else those of the standards. Unavailable."""
        bearing, b, known = self.unmounted_bearing(), self.bearing, self.bearing.known_ratings
        if None in (b.dynamic_load_rating_N, b.static_load_rating_N):
            _ = Basic.of(bearing)  # a maker's are those of steel and usual grooves
        return Basic.of(bearing, **{name: value for name, (value, _) in known.items()})

    def row_loads(self) -> RowLoads:
        """Axial load, moment and tilt of the rows at rest, in SI."""
        b, operation = self.bearing.si(), self.operation
        return RowLoads(b["arrangement"], b["row_distance"] or 0.0, b["preload"] or 0.0, b["flange_height"],
            operation.axial_load_N or 0.0, operation.moment_N_m, 1e-3 * (operation.misalignment_mrad or 0.0))

    def mounting(self) -> Mounting:
        """What the bearing's section stands in, in SI."""
        return section_mounting(self.perfect_bearing(), self._mounting())

    def _mounting(self):
        return Mounting(**{} if self.support is None else self.support.parts(), shaft=self.operation.springs(),
            sensor=None if self.sensor is None else self.sensor.fact(Sensor))

    @property
    def parts(self) -> tuple[str, ...]:
        """Of `lagrange.columns.COLUMNS` that runs have beside those of every run."""
        there = {"surfaces": self.ideal_bearing().faults, "cage": self.cage, "damping": self.damping.acts,
            "axial": self.axial, "damping of tilt": self.axial and self.damping.contacts.acts}
        return *self.mounting().parts, *(name for name, is_there in there.items() if is_there)


parse_scene = Scene.parsed  # a scene from nested tables; SceneError: all that is wrong with them


# tables of a scene that name files: their class, and whether there may be many
FILED = {name: (kind, many) for name, field in Scene.model_fields.items()
    for kind, many in [table_of(field)] if kind is not None and kind.FILES}


def _file_keys(data):
    """Keys of a scene's tables that name files: place, table, key; tables of other forms are left to their checks."""
    for place, (kind, many) in FILED.items():
        given: Any = data.get(place)
        tables = enumerate(given if isinstance(given, list) else ()) if many else [("", given)]
        for number, table in tables:
            for name, file in kind.FILES.items() if isinstance(table, dict) else ():
                yield f"{place}.{number}".rstrip("."), table, name, file


def content_of(data: dict[str, Any], files: Mapping[str, str] | Path | None, name: str = "scene") -> None:
    """Put the files of [[profile]], [operation], [lagrange] and [axial] into the tables of a scene.

    `files` : the folder in which they are, or their texts by digests; None: all stay out. SceneError: no such file,
    unreadable, too large, not text; not the one whose digest the scene gives.
    """
    for place, table, field, file in _file_keys(data):
        given, content, sha256, text = table.get(field), beside(field, "content"), beside(field, "sha256"), None
        described, wrong = f'{place}.{field} = "{given}"', ""
        if content in table:
            described, wrong = f"{place}.{content}", f"unknown key; {file.kind} are read from a file"
        elif not isinstance(given, str) or not given or given in file.forms or files is None:
            continue
        elif not isinstance(files, Path):
            text = files.get(str(table.get(sha256)))
            wrong = "its text is not here" if text is None else ""
        else:
            try:
                text = plain_text(files / given, LARGEST_FILE)
                if table.setdefault(sha256, digest(text)) != digest(text):
                    wrong = (f"its sha256 is {digest(text)}, another than the scene gives; leave the sha256 out for "
                        "this file")
            except ValueError as error:
                wrong = f"{error}; is it a table of {file.kind}?"
                if "can't be read" in str(error):
                    forms = f"; forms are {', '.join(file.forms)}" if file.forms else ""
                    wrong = f"{error} (looked for in {(files / given).parent.resolve()}){forms}"
        if wrong:
            raise SceneError(f"{name}: {faults.printable(f'{described}: {wrong}')}")
        table[content] = text


def read_scene(
    path: str | Path | None = None, overrides: tuple[str, ...] = (), changes: Mapping[str, Any] | None = None
) -> Scene:
    """The scene of a TOML file (None: the paper's), with `table.key=value` overrides and values by key put on top.

    SceneError: unreadable file, bad TOML, unknown key (with the likely one), wrong type, value out of range,
    values that contradict each other; all faults of the file at once.
    """
    name, data = "built-in scene", {}
    if path is not None:
        name, path = str(path), Path(path)
        try:
            text = plain_text(path, faults.LONGEST_TEXT)
        except ValueError as error:
            if path.exists():
                hint = "" if "can't be read" in str(error) else "; is it a scene file?"
                raise SceneError(f"{name}: {error}{hint}") from None
            scenes = {each.stem: each for each in path.parent.glob("*.toml")} if path.parent.is_dir() else {}
            likely = faults.likely_of(path.stem, scenes)
            hint = f"did you mean {scenes[likely]}?" if likely else "run-fem --example NU206 writes one to begin with"
            raise SceneError(f"{name}: no such file; {hint}") from None
        data = load(text, name)
    for override in overrides:
        apply_override(data, override)
    _change(data, changes or {}, (override.partition("=")[0].strip() for override in overrides))
    content_of(data, Path() if path is None else Path(path).parent, name)
    return parse_scene(data, name)


def _change(data, changes, changed=()):
    """Set keys; refuse these, and others that were changed, where a table is in the value's place. SceneError."""
    for dotted, value in changes.items():
        set_key(data, dotted, value, dotted)
    operation, changed = data.get("operation"), {*changes, *changed}
    for table, name in run.IN_PLACE_OF.items():
        if f"operation.{name}" in changed and isinstance(operation, dict) and operation.get(table) is not None:
            raise SceneError(f"operation.{name} = {quoted(operation.get(name))}: operation.{table} = "
                f"{quoted(operation[table])} is in its place; leave one of them out")


def parse_scene_text(text: str, name: str, files: dict[str, str] | None = None, **usual: Any) -> Scene:
    """A scene from TOML text, e.g. the `scene` attribute of a result file.

    `files` : text of the files that it names, by their digests; None: a scene with profiles can be shown and compared,
    but gives no bearing; `usual` : tables where the text has none
    """
    data = load(text, name)
    content_of(data, files, name)
    return parse_scene(usual | data, name)


def parse_stored_scene(text: str, name: str, files: dict[str, str] | None = None) -> Scene:
    """The scene of a result file, as `parse_scene_text`; one without [cage], of an earlier version, had none."""
    try:
        return parse_scene_text(text, name, files, cage={"kind": "none"})
    except SceneError as error:
        raise SceneError(f"{error}\nif an earlier version wrote the file, run the scene again") from None
