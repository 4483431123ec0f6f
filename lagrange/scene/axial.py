"""The scene file's [axial]: profiles, slices and tilt, the third dimension of rollers and shaft."""

from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from pydantic import Field

from lagrange.axial.facts import Axial, Kind, Profile
from lagrange.bearing import Bearing
from lagrange.files.tables import columns
from lagrange.limits import exceeds
from lagrange.scene.faults import Check, DecimalSign, Digest, FileName, FileText, Table

MM, UM = 1e-3, 1e-6
SHAPES: dict[str, Kind] = {
    "none": "none", "logarithmic": "logarithmic", "crowned": "crowned", "lundberg": "lundberg"
}  # fmt: skip
SURFACES = ("roller", "inner_raceway", "outer_raceway")  # before _profile
FEWEST, MOST = 3, 10_000  # points of a measured profile
NAMES = ("z_mm", "drop_um")
LARGEST_DROP = 1e5  # µm
PROFILE = '"none", "logarithmic" (ISO/TS 16281), "crowned", "lundberg", or a CSV file next to the scene with the '
PROFILE += "columns z_mm, drop_um"


class AxialTable(Table):
    """Rollers that tilt, divided into slices along their length; without this table the bearing is a plane section."""

    roller_profile: FileName = Field("logarithmic", description=f"profile of the rollers: {PROFILE}")
    roller_profile_sha256: Digest = None
    roller_profile_content: FileText = None
    inner_raceway_profile: FileName = Field("none", description="profile of the inner raceway: as roller_profile")
    inner_raceway_profile_sha256: Digest = None
    inner_raceway_profile_content: FileText = None
    outer_raceway_profile: FileName = Field("none", description="profile of the outer raceway: as roller_profile")
    outer_raceway_profile_sha256: Digest = None
    outer_raceway_profile_content: FileText = None
    decimal: DecimalSign = None
    crown_um: float | None = Field(
        None, gt=0.0, le=1e4, description='drop of a "crowned" profile (an arc) at the ends of a roller'
    )
    lundberg_load_N: float | None = Field(
        None, gt=0.0, le=1e7, description='load of a roller at which a "lundberg" profile has a uniform pressure'
    )
    slices: int = Field(21, ge=3, le=201, description="number of slices of a roller")
    coupling: bool = Field(True, description="neighbouring slices interact elastically; never in the Lagrangian model")
    ring_width_mm: float | None = Field(
        None, gt=0.0, le=10_000.0, description="width of both rings; default: twice the length of the rollers"
    )
    hub_tilt_inertia_kg_m2: float | None = Field(
        None,
        gt=0.0,
        le=1e6,
        description="moment of inertia of inner ring and shaft about an axis across theirs; default: the slope stays "
        "at operation.misalignment_mrad",
    )
    shaft_tilt_stiffness_N_m_rad: float | None = Field(
        None, ge=0.0, le=1e12, description="tilt stiffness of a shaft whose slope can change; default 0"
    )

    def checks(self) -> tuple[Check, ...]:
        return self._keys, self._files

    def _keys(self) -> Iterator[str]:
        kinds = [getattr(self, f"{surface}_profile") for surface in SURFACES]
        for key, kind, example in (("crown_um", "crowned", 5.0), ("lundberg_load_N", "lundberg", 1000.0)):
            given = getattr(self, key)
            if kind in kinds and given is None:
                yield f'a profile that is "{kind}" needs {key}, e.g. {key} = {example:g}'
            if kind not in kinds and given is not None:
                yield f'{key} = {given:g}: only with a profile that is "{kind}"; leave it out'
        if self.hub_tilt_inertia_kg_m2 is None and self.shaft_tilt_stiffness_N_m_rad is not None:
            yield (
                f"shaft_tilt_stiffness_N_m_rad = {self.shaft_tilt_stiffness_N_m_rad:g}: only for a shaft whose slope "
                "can change; give hub_tilt_inertia_kg_m2 too, or leave it out"
            )

    def _files(self) -> Iterator[str]:
        for surface in SURFACES:
            name, content = (getattr(self, f"{surface}_profile{end}") for end in ("", "_content"))
            if content is not None:
                try:
                    measured(content, self.decimal or ".")
                except ValueError as error:
                    yield f'{surface}_profile = "{name}": {error}'

    @property
    def files(self) -> dict[str, str]:
        """Texts of its files, by their digests, as far as they are at hand."""
        found = [[getattr(self, f"{surface}_profile_{end}") for end in ("sha256", "content")] for surface in SURFACES]
        return {digest: content for digest, content in found if digest is not None and content is not None}

    def axial(self, bearing: Bearing) -> Axial:
        """The table in SI. ValueError: a file is not at hand."""
        width = self.ring_width_mm
        return Axial(
            **{surface: self._profile(surface) for surface in SURFACES},
            slices=self.slices,
            coupling=self.coupling,
            ring_width=2.0 * bearing.roller_length if width is None else MM * width,
            hub_tilt_inertia=self.hub_tilt_inertia_kg_m2,
            shaft_tilt_stiffness=self.shaft_tilt_stiffness_N_m_rad or 0.0,
        )

    def _profile(self, surface: str) -> Profile:
        name, content = (getattr(self, f"{surface}_profile{end}") for end in ("", "_content"))
        if name in SHAPES:
            return Profile(kind=SHAPES[name], crown=UM * (self.crown_um or 0.0), load=self.lundberg_load_N or 0.0)
        if content is None:
            raise ValueError(f'axial.{surface}_profile = "{name}" is not at hand')
        points = measured(content, self.decimal or ".")
        return Profile(kind="measured", place=points.place, depth=points.depth)


class Points(NamedTuple):
    """Of a measured profile, m; the least drop is 0."""

    place: tuple[float, ...]
    depth: tuple[float, ...]


@lru_cache(maxsize=8)
def measured(text: str, decimal: str = ".") -> Points:
    """The drops of a table's text. ValueError: a sentence on the text."""
    z, drop = columns(text, NAMES, decimal).T
    if not FEWEST <= len(z) <= MOST:
        raise ValueError(f"it holds {len(z)} points; at least {FEWEST} and at most {MOST} are allowed")
    if not np.all(np.isfinite(z)) or not np.all(np.isfinite(drop)):
        raise ValueError("a value is not finite")
    if np.abs(drop).max() > LARGEST_DROP:
        raise ValueError(f"drop_um = {drop[np.argmax(np.abs(drop))]:g}: at most {LARGEST_DROP:g} either way")
    if np.any(np.diff(z) <= 0.0):
        at = int(np.argmax(np.diff(z) <= 0.0))
        raise ValueError(f"z_mm must rise from row to row: after {z[at]:g} comes {z[at + 1]:g}")
    return Points(tuple(MM * z), tuple(UM * (drop - drop.min())))


def axial_faults(bearing: Bearing, table: AxialTable) -> Iterator[str]:
    """What does not fit the bearing: rings narrower than rollers, profiles shorter than them."""
    length = 1e3 * bearing.roller_length
    if table.ring_width_mm is not None and exceeds(length, table.ring_width_mm):
        yield (f"axial.ring_width_mm = {table.ring_width_mm:g} must be at least bearing.roller_length_mm = {length:g}")
    for surface in SURFACES:
        content = getattr(table, f"{surface}_profile_content")
        if content is None:
            continue
        place = 1e3 * np.array(measured(content, table.decimal or ".").place)
        reach = 0.5 * length * (1.0 - 1.0 / table.slices)
        if exceeds(reach, -place[0]) or exceeds(reach, place[-1]):
            yield (
                f'axial.{surface}_profile = "{getattr(table, f"{surface}_profile")}": its z_mm go from {place[0]:g} to '
                f"{place[-1]:g}; slices of rollers of {length:g} mm have their middles from {-reach:g} to {reach:g}"
            )
