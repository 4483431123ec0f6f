"""Tables of the scene that say what the bearing is: [bearing], [material], [bodies], [lubricant]."""

from collections.abc import Iterator
from math import asin, cos, pi, radians, sin
from typing import Annotated, Any, Literal

from pydantic import Field

from lagrange.bearing import Material
from lagrange.catalogue import SHAFT_WIDTHS, bearing_keys, has_balls, instead, listed, steel_ring_and_shaft
from lagrange.limits import exceeds
from lagrange.scene.faults import Check, Table
from lagrange.surface.film import Lubricant

# groove radius over ball diameter to which ISO 281 rates deep-groove bearings
USUAL_GROOVES = {"inner_conformity": 0.52, "outer_conformity": 0.53}

FEWEST_ROLLERS = 3  # that are left where some are missing
LARGEST_PRELOAD, LARGEST_CLEARANCE = 0.005, 0.2  # of a roller's diameter
ROUNDED = 6  # decimals of a clearance in mm, a difference of diameters

FOLLOWS = "; default with an inner raceway or a pitch"  # of which the paper's rings are none
SIZES = "inner_raceway_diameter_mm", "pitch_diameter_mm"  # where one is given, what is not follows from the roller's
CLEARANCE_OF = ("inner_raceway_diameter_mm", "roller_diameter_mm", "contact_angle_deg")  # and the outer raceway

MM = 1e-3
USUAL_MASS = 0.078  # kg, of the paper's inner ring and shaft


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def heavy_inner_ring_and_shaft(data: dict[str, Any]) -> float | None:
    """Mass of a ring as wide as its rows are long, with its shaft, kg, where the ring outweighs the default."""
    keys = ("bore_diameter_mm", "roller_length_mm", "inner_raceway_diameter_mm", "rows")
    data = BearingTable.completed(data)
    sizes = [data.get(key, BearingTable.model_fields[key].default) for key in keys]
    if any(type(size) not in (float, int) or size < 0.0 for size in sizes):
        return None
    bore, length, raceway, rows = sizes
    length *= rows
    if bore == 0.0:  # the shaft itself
        solid = steel_ring_and_shaft(raceway, length, raceway, SHAFT_WIDTHS)
        return None if solid < USUAL_MASS else solid
    ring = steel_ring_and_shaft(bore, length, raceway, 0.0)
    return None if ring < USUAL_MASS else steel_ring_and_shaft(bore, length, raceway, SHAFT_WIDTHS)


class BearingTable(Table):
    """The bearing; the defaults are the paper's."""

    designation: str | None = Field(
        None, max_length=40, description="standard bearing, e.g. NU206/C3 or 6205; gives the other keys their defaults"
    )
    type: Literal["roller", "ball"] = Field("roller", description='roller or ball; balls not with model = "fem"')
    rollers: int = Field(13, ge=3, le=200, description="number of rollers or balls")
    roller_diameter_mm: float = Field(10.0, ge=0.5, le=500.0, description="diameter of a roller or ball")
    roller_length_mm: float = Field(
        10.0, ge=0.1, le=2000.0, description=f"effective length of a roller{FOLLOWS}: its diameter"
    )
    inner_raceway_diameter_mm: float = Field(
        36.0, gt=0.0, le=10_000.0, description="diameter of the inner ring's raceway"
    )
    outer_raceway_diameter_mm: float = Field(
        56.0,
        gt=0.0,
        le=10_000.0,
        description="diameter of the outer ring's raceway; outer − inner − 2 · roller · cos α is the clearance times "
        "cos α",
    )
    bore_diameter_mm: float = Field(
        25.0,
        ge=0.0,
        le=10_000.0,
        description="diameter of the inner ring's bore; 0: a solid shaft is the inner ring"
        + FOLLOWS
        + ": that raceway less 1.1 roller diameters",
    )
    outside_diameter_mm: float = Field(
        65.0,
        gt=0.0,
        le=10_000.0,
        description=f"outside diameter of the outer ring{FOLLOWS}: its raceway plus 0.9 roller diameters",
    )
    clearance_um: float | None = Field(
        None,
        ge=-10_000.0,
        le=100_000.0,
        description="diametral clearance, instead of outer_raceway_diameter_mm; negative: preload",
    )
    contact_angle_deg: float = Field(
        0.0,
        ge=0.0,
        le=45.0,
        description="contact angle of tapered rollers or angular-contact balls; raceway diameters are those at the "
        "contacts",
    )
    rows: int = Field(
        1, ge=1, le=8, description="number of rows, each of that many rollers; they share the load equally"
    )
    missing_rollers: list[Annotated[int, Field(ge=0)]] = Field(
        [], max_length=197, description="numbers of the empty pockets, counted from 0"
    )
    pitch_diameter_mm: float | None = Field(
        None,
        gt=0.0,
        le=10_000.0,
        description="instead of inner_raceway_diameter_mm, which is pitch − roller · cos(contact angle)",
    )
    inner_conformity: float | None = Field(
        None,
        gt=0.5,
        le=1.0,
        description="balls: radius of the inner groove over the diameter of the ball; default 0.52",
    )
    outer_conformity: float | None = Field(
        None,
        gt=0.5,
        le=1.0,
        description="balls: radius of the outer groove over the diameter of the ball; default 0.53",
    )

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Values of a standard bearing, grooves of balls; a clearance becomes the outer raceway's diameter."""
        outer = "outer_raceway_diameter_mm" in data
        if (found := listed(data.get("designation"))) is not None:
            given = {"clearance_um": outer, "inner_raceway_diameter_mm": data.get("pitch_diameter_mm") is not None}
            data = {key: value for key, value in bearing_keys(*found).items() if not given.get(key)} | data
        if data.get("type") == "ball":
            data = USUAL_GROOVES | data
        sized = any(data.get(key) is not None for key in SIZES)
        data = cls._with_inner_raceway(data)
        if sized:
            data = cls._rings(data) | data
        parts = [data.get(key, cls.model_fields[key].default) for key in CLEARANCE_OF] + [data.get("clearance_um")]
        if outer or not all(map(_is_number, parts)):
            return data
        inner, roller, angle, clearance = parts
        data = {key: value for key, value in data.items() if key != "clearance_um"}
        closed = inner + 2.0 * roller * cos(radians(angle))
        return data | {"outer_raceway_diameter_mm": round(closed + 1e-3 * clearance * cos(radians(angle)), 9)}

    @classmethod
    def _with_inner_raceway(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The inner raceway of a pitch diameter, without clearance where neither it nor the outer raceway is given."""
        pitch: Any = data.get("pitch_diameter_mm")
        roller, angle = (data.get(key, cls.model_fields[key].default) for key in CLEARANCE_OF[1:])
        if "inner_raceway_diameter_mm" in data or not all(map(_is_number, (pitch, roller, angle))):
            return data
        outer: Any = data.get("outer_raceway_diameter_mm")
        clearance: Any = data.get("clearance_um", 0.0 if outer is None else None)
        if outer is None and _is_number(clearance):
            inner = pitch - (roller + 0.5e-3 * clearance) * cos(radians(angle))
        elif clearance is None and _is_number(outer):
            inner = 2.0 * pitch - outer
        else:
            return data
        data = {key: value for key, value in data.items() if key not in ("pitch_diameter_mm", "clearance_um")}
        kept = {} if clearance is None else {"clearance_um": clearance}
        return data | {"inner_raceway_diameter_mm": round(inner, 9)} | kept

    @classmethod
    def _rings(cls, data: dict[str, Any]) -> dict[str, float]:
        """Rings, and length, of rollers on such an inner raceway: in proportion to the roller as the paper's are."""
        inner, roller, angle = (data.get(key, cls.model_fields[key].default) for key in CLEARANCE_OF)
        if not all(map(_is_number, (inner, roller, angle))):
            return {}
        outer = inner + 2.0 * roller * cos(radians(angle))
        return {
            "bore_diameter_mm": round(max(inner - 1.1 * roller, 0.5 * inner), 6),
            "outside_diameter_mm": round(outer + 0.9 * roller, 6),
            "roller_length_mm": float(roller),
        }

    @property
    def present(self) -> int:
        """Rollers that are there."""
        return self.rollers - len(self.missing_rollers)

    @property
    def cosine(self) -> float:
        """Of the contact angle."""
        return cos(radians(self.contact_angle_deg))

    def checks(self) -> tuple[Check, ...]:
        return (
            self._standard,
            self._clearance_twice,
            self._pitch_twice,
            self._missing,
            self._grooves,
            self._inner_ring,
            self._outer_ring,
            self._clearance,
            self._room,
        )

    def _standard(self) -> Iterator[str]:
        name, found = self.designation, listed(self.designation)
        if name is not None and found is None:
            yield (
                f"designation = {name!r}: not in the table; "
                + instead(
                    name,
                    "give rollers, roller_diameter_mm, roller_length_mm, inner_raceway_diameter_mm, clearance_um, "
                    "bore_diameter_mm and outside_diameter_mm",
                )
            )
        if found is not None and has_balls(found[0]) != (self.type == "ball"):
            yield f'designation = {name!r}: not with type = "{self.type}"; leave one of them out'

    def _clearance_twice(self) -> Iterator[str]:
        if self.clearance_um is not None:  # else it has become the diameter
            yield (
                f"clearance_um = {self.clearance_um:g} and outer_raceway_diameter_mm = "
                f"{self.outer_raceway_diameter_mm:g} say the same thing; leave one of them out"
            )

    def _pitch_twice(self) -> Iterator[str]:
        if self.pitch_diameter_mm is not None:  # else it has become a raceway's diameter
            yield (
                f"pitch_diameter_mm = {self.pitch_diameter_mm:g}: raceways and clearance already give the pitch; give "
                "it with roller_diameter_mm and either clearance_um or outer_raceway_diameter_mm"
            )

    def _missing(self) -> Iterator[str]:
        numbers = self.missing_rollers
        for number in numbers:
            if number >= self.rollers:
                yield (
                    f"missing_rollers = {numbers}: there is no roller {number}; rollers = {self.rollers} are counted "
                    f"from 0 to {self.rollers - 1}"
                )
        if len(set(numbers)) < len(numbers):
            yield f"missing_rollers = {numbers}: a number is there twice"
        if self.present < FEWEST_ROLLERS:
            yield f"missing_rollers = {numbers}: leaves {self.present} rollers; at least {FEWEST_ROLLERS} must be left"

    def _grooves(self) -> Iterator[str]:
        for key in USUAL_GROOVES:
            if self.type == "roller" and getattr(self, key) is not None:
                yield f'{key} = {getattr(self, key)}: only for balls; add type = "ball" or leave it out'

    def _inner_ring(self) -> Iterator[str]:
        inner = self.inner_raceway_diameter_mm
        if self.bore_diameter_mm >= inner:
            yield f"bore_diameter_mm = {self.bore_diameter_mm} must be below inner_raceway_diameter_mm = {inner}"

    def _outer_ring(self) -> Iterator[str]:
        outer = self.outer_raceway_diameter_mm
        if self.outside_diameter_mm <= outer:
            yield f"outside_diameter_mm = {self.outside_diameter_mm} must be above outer_raceway_diameter_mm = {outer}"

    def _clearance(self) -> Iterator[str]:
        roller, outer = self.roller_diameter_mm, self.outer_raceway_diameter_mm
        along_contacts = (outer - self.inner_raceway_diameter_mm) / self.cosine
        clearance = round(along_contacts - 2.0 * roller, ROUNDED)
        if exceeds(-LARGEST_PRELOAD * roller, clearance):
            yield (
                f"diametral clearance outer − inner − 2·roller = {clearance:.4g} mm is more preload than the model "
                f"allows (at least {-LARGEST_PRELOAD * roller:.4g} mm); raise outer_raceway_diameter_mm = {outer}"
            )
        if exceeds(clearance, LARGEST_CLEARANCE * roller):
            yield (
                f"diametral clearance outer − inner − 2·roller = {clearance:.4g} mm is too large (at most "
                f"{LARGEST_CLEARANCE * roller:.4g} mm); lower outer_raceway_diameter_mm = {outer}"
            )

    def _room(self) -> Iterator[str]:
        roller = self.roller_diameter_mm
        pitch = 0.5 * (self.inner_raceway_diameter_mm + self.outer_raceway_diameter_mm)
        if pitch * sin(pi / self.rollers) <= roller:
            most = int(pi / asin(roller / pitch)) if roller < pitch else 1
            yield (
                f"rollers = {self.rollers} of roller_diameter_mm = {roller} do not fit on the pitch circle of "
                f"{pitch:g} mm; at most {most}"
            )


class MaterialOverride(Table):
    """Material of this body; keys left out are those of [material]."""

    youngs_modulus_GPa: float | None = Field(None, ge=0.1, le=2000.0, description="Young's modulus of this body")
    poisson_ratio: float | None = Field(None, ge=0.0, le=0.45, description="Poisson's ratio of this body")
    density_kg_m3: float | None = Field(None, ge=100.0, le=30_000.0, description="density of this body")


class MaterialTable(Table):
    """Material of all bodies; [material.roller], [material.inner_ring] and [material.outer_ring] override it."""

    youngs_modulus_GPa: float = Field(210.0, ge=0.1, le=2000.0, description="Young's modulus")
    poisson_ratio: float = Field(0.3, ge=0.0, le=0.45, description="Poisson's ratio")
    density_kg_m3: float = Field(7850.0, ge=100.0, le=30_000.0, description="density")
    roller: MaterialOverride = Field(MaterialOverride(), description="material of the rollers")
    inner_ring: MaterialOverride = Field(MaterialOverride(), description="material of the inner ring")
    outer_ring: MaterialOverride = Field(MaterialOverride(), description="material of the outer ring")

    def of(self, body: Literal["roller", "inner_ring", "outer_ring"]) -> Material:
        """Material of one kind of body, SI."""
        own = getattr(self, body)

        def pick(key):
            value = getattr(own, key)
            return getattr(self, key) if value is None else value

        return Material(
            youngs_modulus=pick("youngs_modulus_GPa") * 1e9,
            poisson_ratio=pick("poisson_ratio"),
            density=pick("density_kg_m3"),
        )


class BodiesTable(Table):
    """Which bodies are rigid."""

    rollers: Literal["elastic", "rigid"] = Field("elastic", description="rollers; not rigid together with a ring")
    inner_ring: Literal["elastic", "rigid"] = Field("elastic", description="inner ring")
    outer_ring: Literal["elastic", "rigid"] = Field("elastic", description="outer ring")

    def checks(self) -> tuple[Check, ...]:
        return (self._partners,)

    def _partners(self) -> Iterator[str]:
        rings = [name for name in ("inner_ring", "outer_ring") if getattr(self, name) == "rigid"]
        if self.rollers == "rigid" and rings:
            too = " and ".join(f'{name} = "rigid"' for name in rings)
            yield (
                f'rollers = "rigid" together with {too}: a contact of two rigid bodies has no compliance and so no '
                'force; leave the rollers or the rings "elastic", or, for bodies that are all rigid with a contact law '
                "between them, leave [bodies] out and use run-fem --model lagrange"
            )

    @property
    def rigid(self) -> tuple[str, ...]:
        """The keys of those that are."""
        return tuple(name for name in type(self).model_fields if getattr(self, name) == "rigid")


class LubricantTable(Table):
    """A film that takes up gap, as thick as Dowson and Higginson's under the largest static load of a raceway."""

    viscosity_Pa_s: float = Field(0.02, ge=1e-5, le=100.0, description="viscosity at the inlet of the contacts")
    pressure_viscosity_1_Pa: float = Field(2e-8, ge=1e-10, le=1e-6, description="pressure-viscosity coefficient")
    traction_coefficient: float = Field(
        0.05, ge=0.0, le=1.0, description="traction coefficient of the film, instead of contact.friction_coefficient"
    )

    def lubricant(self) -> Lubricant:
        """The oil, SI."""
        return Lubricant(
            viscosity=self.viscosity_Pa_s,
            pressure_viscosity=self.pressure_viscosity_1_Pa,
            traction_coefficient=self.traction_coefficient,
        )
