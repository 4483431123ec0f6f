"""The scene file: TOML in the bearing engineer's units, validated, given out as SI objects.

It stands on the ground floor because both the solver and the checker read it, and neither may know the other.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from copy import deepcopy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Self

import tomli_w
from pydantic import PrivateAttr, ValidationError, model_validator

from lagrange.catalogue import bearing_keys, inner_ring_and_shaft, listed
from lagrange.files.input import plain_text
from lagrange.scene.axial import SURFACES as AXIAL_SURFACES
from lagrange.scene.bearing import heavy_inner_ring_and_shaft
from lagrange.scene.cage import CageTable, default_cage
from lagrange.scene.columns import Columns
from lagrange.scene.combinations import COMBINATIONS
from lagrange.scene.faults import Check, SceneError, all_faults, likely_of, plain, printable, quoted, without_gone
from lagrange.scene.files import LONGEST_TEXT, apply_override, content_in_place, content_of, load, set_key
from lagrange.scene.operation import IN_PLACE_OF, TABLES
from lagrange.scene.run import DampingTable, LagrangeTable
from lagrange.scene.surfaces import SURFACES
from lagrange.scene.tables import SceneTables
from lagrange.step_size import fitting_interval, wave_interval
from lagrange.surface.passages import strike_interval

MESH_SHARE = 0.1  # of a roller's diameter, between surface nodes where the scene gives no mesh size
PROFILES = tuple(f"{surface}_profile_content" for surface in AXIAL_SURFACES)
FITTING = 6.0, 16.0  # mm, diameters of a standard bearing's rollers that the default mesh size serves
DECIDING = {  # keys whose defaults decide an answer, and what may be given in their place
    "speed_rpm": ("speed_table", "outer_ring_speed_rpm", "outer_ring_speed_table"),
    "radial_load_N": ("load_table", "rotating_load_N", "unbalance_g_mm"),
}
FILES = *TABLES, "law_table"  # keys of tables that name a file
CONTENTS = ("content", *(f"{name}_content" for name in FILES), *PROFILES)  # texts, in the tables that name them
FILE_KEYS = ("file", "sha256", "content", *FILES)


class Scene(SceneTables):
    """A whole scene. Defaults are the paper's bearing."""

    _written: dict[str, Any] | None = PrivateAttr(None)  # the tables as they were given, before they were completed

    @model_validator(mode="wrap")
    @classmethod
    def _remembered(cls, data: Any, handler: Callable[[Any], Self]) -> Self:
        """Keep what was written: a clearance that is varied must not meet the diameter that followed from another."""
        scene = handler(data)
        if isinstance(data, dict):
            scene._written = {key: plain(value) for key, value in data.items()}
            scene._choose_interval()
            scene._choose_cage()
        return scene

    def _choose_interval(self) -> None:
        """Between samples, where none is given: by the fastest vibration that moves, and so that no warning follows."""
        if "output_interval_us" in self.numerics.model_fields_set:
            return
        with suppress(ValueError):  # a table of speeds or loads that is not at hand
            bearing, operation = replace(self.perfect_bearing(), faults=self._faults()), self.ideal_operation()
            longest = min(strike_interval(bearing, operation), wave_interval(bearing, operation))
            interval = fitting_interval(bearing, operation, longest)
            numerics = self.numerics.model_copy(update={"output_interval_us": round(1e6 * interval, 3)})
            self.__dict__["numerics"] = numerics

    def _choose_cage(self) -> None:
        """Write out the cage that the bearing has: the table's, what it leaves out by default, or no table."""
        given = self.cage
        if given is None and self.model == "lagrange":
            return
        with suppress(ValueError):  # as above
            found = given or default_cage(self)
            moves = self.operation.turns_outer_ring is not None or self.mounting().bore is not None
            self.__dict__["cage"] = (
                found.filled(self.unmounted_bearing(), moves)
                if isinstance(found, CageTable) and found.kind != "none"
                else None
            )

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
        kind = bearing.get("type", known.get("type"))
        if (
            type(diameter) in (float, int)
            and 0.5 <= diameter <= 500.0
            and kind != "ball"
            and isinstance(numerics, dict)
        ):
            data = data | {"numerics": {"mesh_size_mm": round(MESH_SHARE * diameter, 6)} | numerics}
        if kind == "ball":
            data = {"model": "lagrange"} | data  # the one that has balls
        if kind == "ball" and isinstance(options, dict):
            data = data | {"lagrange": {"law": "hertz"} | LagrangeTable.completed(options)}
        if standard is not None and isinstance(operation, dict):
            mass = {"inner_ring_and_shaft_kg": inner_ring_and_shaft(standard[0])}
            data = {"name": standard[0]} | data | {"operation": mass | operation}
        elif isinstance(operation, dict) and (heavy := heavy_inner_ring_and_shaft(bearing)) is not None:
            data = data | {"operation": {"inner_ring_and_shaft_kg": heavy} | operation}
        return data

    def checks(self) -> tuple[Check, ...]:
        return tuple(partial(check, self) for check in COMBINATIONS)

    def varied(self, changes: Mapping[str, Any]) -> "Scene":
        """This scene with other values under dotted keys, as `--set` has them; the whole is validated anew.

            scene.varied({"operation.speed_rpm": 3000.0, "spall.0.body": "outer_ring"})

        Errors
        ------
        SceneError: an unknown key or an impossible value; a file, which only the reader of a scene puts in its place.
        """
        data = self._as_written()
        for key, value in changes.items():
            if key.rpartition(".")[2] in FILE_KEYS:
                raise SceneError(f"{key}: files of a scene can't be varied; write a scene for each file")
            set_key(data, key, value, key)
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
        found = [
            f"operation.{key} = {getattr(self.operation, key):g}"
            for key, others in DECIDING.items()
            if not any(other in operation for other in (key, *others))
        ]
        return ", ".join(found)

    def is_given(self, table: str, key: str | None = None) -> bool:
        """Whether a table, or a key of it, was written, and is no default."""
        written = self._as_written()
        return table in written if key is None else key in written.get(table, {})

    def _as_written(self) -> dict[str, Any]:
        """The tables before they were completed, without the texts of the files that they name."""
        data = self._tables() if self._written is None else deepcopy(self._written)
        named = [data.get(name, {}) for name in ("operation", "lagrange", "axial")]
        for table in (*data.get("profile", []), *named):
            for key in CONTENTS:
                table.pop(key, None)
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
        for name in SURFACES:
            if not tables[name]:
                del tables[name]
        for name, empty in (("damping", DampingTable()), ("table", Columns())):
            if getattr(self, name) == empty:
                del tables[name]
        return tomli_w.dumps(tables)

    def _tables(self) -> dict[str, Any]:
        """All tables; that a bearing has no cage is said where it would have one otherwise."""
        tables = self.model_dump(exclude_none=True)
        return tables if self.cage is not None or self.model == "lagrange" else tables | {"cage": {"kind": "none"}}


def _at_hand(path: Path) -> str:
    """What to take instead of a scene file that is not there."""
    scenes = {each.stem: each for each in path.parent.glob("*.toml")} if path.parent.is_dir() else {}
    likely = likely_of(path.stem, scenes)
    return f"did you mean {scenes[likely]}?" if likely else "run-fem --example NU206 writes one to begin with"


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
        name = str(path)
        try:
            text = plain_text(path, LONGEST_TEXT)
        except ValueError as error:
            if not Path(path).exists():
                raise SceneError(f"{name}: no such file; {_at_hand(Path(path))}") from None
            hint = "" if "can't be read" in str(error) else "; is it a scene file?"
            raise SceneError(f"{name}: {error}{hint}") from None
        data = load(text, name)
    for override in overrides:
        apply_override(data, override)
    for key, value in (changes or {}).items():
        set_key(data, key, value, key)
    _refuse_beside_tables(data, [*(override.partition("=")[0].strip() for override in overrides), *(changes or {})])
    with _refused(name):
        content_in_place(data, Path() if path is None else Path(path).parent)
    return parse_scene(data, name)


def _refuse_beside_tables(data: dict[str, Any], changed: Iterable[str]) -> None:
    """Refuse a change of a value in whose place a table is. SceneError."""
    operation = data.get("operation")
    for table, key in IN_PLACE_OF.items():
        if f"operation.{key}" in changed and isinstance(operation, dict) and operation.get(table) is not None:
            raise SceneError(
                f"operation.{key} = {quoted(operation.get(key))}: operation.{table} = {quoted(operation[table])} is in "
                "its place; leave one of them out"
            )


def parse_scene_text(text: str, name: str, files: dict[str, str] | None = None) -> Scene:
    """A scene from TOML text, e.g. the `scene` attribute of a result file.

    Parameters
    ----------
    files : text of the files that it names, by their digests; None: a scene with profiles can be shown and compared,
        but gives no bearing
    """
    data = load(text, name)
    with _refused(name):
        content_of(data, files)
    return parse_scene(data, name)


def parse_stored_scene(text: str, name: str, files: dict[str, str] | None = None) -> Scene:
    """The scene of a result file, as `parse_scene_text`; one without [cage], of an earlier version, had none."""
    data = load(text, name)
    with _refused(name):
        content_of(data, files)
    try:
        return parse_scene({"cage": {"kind": "none"}} | data, name)
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
    """A scene from nested tables."""
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        raise SceneError("\n".join(f"{name}: {fault}" for fault in all_faults(error, Scene, data))) from None
