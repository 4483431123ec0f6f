"""What the bearing is: [bearing], [material], [fit], [bodies], [lubricant], [cage] and [axial] of the scene.

The default cage is a calibration: rollers orbit within −0.1 to +0.25 % of rolling, as they do where a film and drag
act, which the model has not. Its plays are not those of a maker's drawing.
"""

# fmt: off
from contextlib import suppress
from functools import lru_cache
from math import asin, cos, inf, pi, radians, sin
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from lagrange.axial.slices import Axial, Profile
from lagrange.bearing import Bearing, Cage, Guidance, Material, room_between_rollers
from lagrange.catalogue import SHAFT_WIDTHS, bearing_keys, has_balls, instead, listed, ratings, steel_ring_and_shaft
from lagrange.contact.hertz import contact_pairs
from lagrange.errors import exceeds
from lagrange.files.tables import rising
from lagrange.fits import REFERENCE_C, STEEL_EXPANSION, Fit
from lagrange.scene.faults import DecimalSign, Diameter, Digest, File, FileName, FileText, Rule, Share, Table, key, only
from lagrange.surface.film import Lubricant

MM, UM = 1e-3, 1e-6
FEWEST_ROLLERS = 3  # that are left where some are missing
LARGEST_PRELOAD, LARGEST_CLEARANCE = 0.005, 0.2  # of a roller's diameter
ITS_SIZES = ("give rollers, roller_diameter_mm, roller_length_mm, inner_raceway_diameter_mm, clearance_um, "
    "bore_diameter_mm and outside_diameter_mm")
CLEARANCE = "diametral clearance outer − inner − 2·roller = {t.clearance:.4g} mm is"
ROUNDED = 6  # decimals of a clearance in mm, a difference of diameters
USUAL_MASS = 0.078  # kg, of the paper's inner ring and shaft
# groove radius over ball diameter to which ISO 281 rates deep-groove bearings
USUAL_GROOVES = {"inner_conformity": 0.52, "outer_conformity": 0.53}
FOLLOWS = "; default with an inner raceway or a pitch"  # of which the paper's rings are none
OF_ROLLERS = {"rollers", "roller_diameter_mm", "roller_length_mm"}  # by which a bearing is a maker's
CLEARANCE_OF = ("inner_raceway_diameter_mm", "roller_diameter_mm", "contact_angle_deg")  # and the outer raceway
STEEL_DENSITY = 7850.0
Modulus = Annotated[float, Field(ge=0.1, le=2000.0)]
PoissonRatio = Annotated[float, Field(ge=0.0, le=0.45)]
Density = Annotated[float, Field(ge=100.0, le=30_000.0)]
Rated = Annotated[float, Field(gt=0.0, le=1e9)]
Conformity = Annotated[float, Field(gt=0.5, le=1.0)]
Temperature = Annotated[float, Field(ge=-200.0, le=500.0)]
Expansion = Annotated[float, Field(ge=0.0, le=1e-4)]
Rigidity = Literal["elastic", "rigid"]


def heavy_inner_ring_and_shaft(data: dict[str, Any]) -> float | None:
    """Mass of a ring as wide as its rows are long, with its shaft, kg, where the ring outweighs the default."""
    data = BearingTable.completed(data)
    with suppress(TypeError, OverflowError):
        bore, length, raceway, rows = BearingTable.values(
            data, "bore_diameter_mm", "roller_length_mm", "inner_raceway_diameter_mm", "rows")
        alone, bore = (SHAFT_WIDTHS, raceway) if bore == 0.0 else (0.0, bore)  # a solid one is the shaft itself
        ring, whole = (steel_ring_and_shaft(bore, rows * length, raceway, shaft) for shaft in (alone, SHAFT_WIDTHS))
        if ring >= USUAL_MASS and min(bore, length, raceway, rows) >= 0.0:
            return whole
    return None


Order = Annotated[float, Field(gt=0.0, lt=1000.0)]


class OrdersTable(Table):
    """Frequencies of a data sheet over the shaft's speed; check-vibration takes them in place of sizes."""

    bpfo: Order = key(..., "ball pass frequency of the outer ring")
    bpfi: Order = key(..., "ball pass frequency of the inner ring")
    bsf: Order = key(..., "spin frequency of a rolling element")
    ftf: Order = key(..., "frequency of the cage")

    @property
    def elements(self) -> int:
        return round(self.bpfo + self.bpfi)

    RULES = ((lambda t: t.elements < 3 or abs(t.bpfo + t.bpfi - t.elements) > 0.1
        or abs(t.bpfo / t.elements - t.ftf) > 0.02, "bpfo = {t.bpfo:g}, bpfi = {t.bpfi:g}, ftf = {t.ftf:g}: of no "
        "bearing; bpfo + bpfi is the number of rolling elements, and bpfo over it, where the outer ring stands, ftf"),)


class BearingTable(Table):
    """The bearing; the defaults are the paper's."""

    designation: str | None = key(None, "standard bearing, e.g. NU206/C3 or 6205; gives the other keys their defaults",
        max_length=40)
    type: Literal["roller", "ball"] = key("roller", 'roller or ball; balls not with model = "fem"')
    rollers: int = key(13, "number of rollers or balls", 3, 200)
    roller_diameter_mm: float = key(10.0, "diameter of a roller or ball", 0.5, 500.0)
    roller_length_mm: float = key(10.0, f"effective length of a roller{FOLLOWS}: its diameter", 0.1, 2000.0)
    inner_raceway_diameter_mm: Diameter = key(36.0, "diameter of the inner ring's raceway")
    outer_raceway_diameter_mm: Diameter = key(56.0, "diameter of the outer ring's raceway; outer − inner − 2 · roller "
        "· cos α is the clearance times cos α")
    bore_diameter_mm: float = key(25.0, "diameter of the inner ring's bore; 0: a solid shaft is the inner "
        f"ring{FOLLOWS}: that raceway less 1.1 roller diameters", 0.0, 10_000.0)
    outside_diameter_mm: Diameter = key(65.0, f"outside diameter of the outer ring{FOLLOWS}, and an outer raceway or a "
        "clearance: that raceway plus 0.9 roller diameters")
    clearance_um: float | None = key(None, "diametral clearance, instead of outer_raceway_diameter_mm; negative: "
        "preload", -10_000.0, 100_000.0)
    contact_angle_deg: float = key(0.0, "contact angle of tapered rollers or angular-contact balls; raceway diameters "
        "are those at the contacts", 0.0, 45.0)
    rows: int = key(1, "number of rows, each of that many rollers; they share the load equally", 1, 8)
    missing_rollers: list[Annotated[int, Field(ge=0)]] = key([], "numbers of the empty pockets, counted from 0",
        max_length=197)
    pitch_diameter_mm: Diameter | None = key(None, "instead of inner_raceway_diameter_mm, which is pitch − roller · "
        "cos(contact angle)")
    inner_conformity: Conformity | None = key(None, "balls: radius of the inner groove over the diameter of the ball; "
        "default 0.52")
    outer_conformity: Conformity | None = key(None, "balls: radius of the outer groove over the diameter of the ball; "
        "default 0.53")
    dynamic_load_rating_N: Rated | None = key(None, "the catalogue's C, in place of ISO 281's")
    static_load_rating_N: Rated | None = key(None, "the catalogue's C0, in place of ISO 76's")
    fatigue_load_limit_N: Rated | None = key(None, "the catalogue's C_u, in place of ISO 281's")
    arrangement: Literal["back_to_back", "face_to_face"] | None = key(None, "two rows with mirrored contact angles, in "
        "ratings only; default: all rows alike")
    row_distance_mm: Diameter | None = key(None, "distance of the middles of two mirrored rows; required with them")
    preload_N: float | None = key(None, "axial force between two mirrored rows without load; default 0", 0.0, 1e7)
    flange_height_mm: float | None = key(None, "height of the flanges of both rings, by which cylindrical rollers "
        "carry axial loads; default: NJ, NUP 0.2 roller diameters (estimate), others none", most=500.0, gt=0.0)
    orders: OrdersTable | None = None

    @classmethod
    def values(cls, data: dict[str, Any], *keys: str) -> list[Any]:
        """Of keys, which may be left out."""
        return [data.get(name, cls.model_fields[name].default) for name in keys]

    @classmethod
    def completed(cls, data: dict[str, Any]) -> dict[str, Any]:
        """Values of a standard bearing, grooves of balls; a pitch and a clearance become raceways' diameters.

        Of a bearing with an inner raceway, or a pitch, rings and length follow in proportion to the roller as the
        paper's do; without a raceway of its own the outer ring is the paper's.
        """
        data, outer = {name: value for name, value in data.items() if value is not None}, "outer_raceway_diameter_mm"
        outer_given = outer in data
        if type(number := data.get("designation")) is int:  # 6205 of a command line
            data["designation"] = str(number)
        if (found := listed(data.get("designation"))) is not None:
            plain = data.get("rows", 1) == 1 and not data.get("contact_angle_deg")
            instead_of = {"clearance_um": outer_given, "inner_raceway_diameter_mm": "pitch_diameter_mm" in data,
                "flange_height_mm": not plain}
            data = {name: value for name, value in bearing_keys(*found).items() if not instead_of.get(name)} | data
        if data.get("type") == "ball":
            data = USUAL_GROOVES | data
        pitch: Any = data.get("pitch_diameter_mm")
        clearance: Any = data.get("clearance_um")
        sized = pitch is not None or "inner_raceway_diameter_mm" in data
        with suppress(TypeError, OverflowError):  # of values that are no numbers, which are refused
            inner, roller, angle = cls.values(data, *CLEARANCE_OF)
            across = cos(radians(angle))
            if "inner_raceway_diameter_mm" not in data and pitch is not None and None in (clearance, data.get(outer)):
                # without clearance where neither it nor the outer raceway is given
                clearance = clearance if outer_given else clearance or 0.0
                inner = 2.0 * pitch - data[outer] if outer_given else pitch - (roller + 0.5e-3 * clearance) * across
                inner = data["inner_raceway_diameter_mm"] = round(inner, 9)
                del data["pitch_diameter_mm"]
            closed = inner + 2.0 * roller * across
            if sized:
                data.setdefault("bore_diameter_mm", round(max(inner - 1.1 * roller, 0.5 * inner), 6))
                data.setdefault("roller_length_mm", float(roller))
                if outer_given or clearance is not None:
                    data.setdefault("outside_diameter_mm", round(closed + 0.9 * roller, 6))
            if not outer_given and clearance is not None:
                data[outer] = round(closed + 1e-3 * clearance * across, 9)
                data.pop("clearance_um", None)
        return data

    @property
    def present(self) -> int:
        """Rollers that are there."""
        return self.rollers - len(self.missing_rollers)

    @property
    def cosine(self) -> float:
        """Of the contact angle."""
        return cos(radians(self.contact_angle_deg))

    @property
    def pitch(self) -> float:
        """Diameter, mm, on which rollers without clearance have their centres."""
        return 0.5 * (self.inner_raceway_diameter_mm + self.outer_raceway_diameter_mm)

    @property
    def clearance(self) -> float:
        """Diametral, mm."""
        across = (self.outer_raceway_diameter_mm - self.inner_raceway_diameter_mm) / self.cosine
        return round(across - 2.0 * self.roller_diameter_mm, ROUNDED)

    @property
    def known_ratings(self) -> dict[str, tuple[float, str]]:
        """C, C0 and C_u by fields of `Basic`, N, and where they come from: given, or the maker's of this very bearing.

        A standard bearing with other rollers, more rows or a contact angle is no longer its maker's."""
        found, known = listed(self.designation), dict[str, tuple[float, str]]()
        if found is not None and self.rows == 1 and self.contact_angle_deg == 0.0 and all(
                getattr(self, name) == size for name, size in bearing_keys(*found).items() if name in OF_ROLLERS):
            known = ratings(found[0])
        given = {"dynamic": self.dynamic_load_rating_N, "static": self.static_load_rating_N,
            "fatigue": self.fatigue_load_limit_N}
        return known | {name: (value, "given") for name, value in given.items() if value is not None}

    RULES: ClassVar[tuple[Rule, ...]] = (
        (lambda t: t.designation is not None and listed(t.designation) is None and instead(t.designation, ITS_SIZES),
            "designation = {t.designation!r}: not in the table; {0}"),
        (lambda t: (found := listed(t.designation)) and has_balls(found[0]) != (t.type == "ball"),
            'designation = {t.designation!r}: not with type = "{t.type}"; leave one of them out'),
        (lambda t: t.clearance_um is not None, "clearance_um = {t.clearance_um:g} and outer_raceway_diameter_mm = "
            "{t.outer_raceway_diameter_mm:g} say the same thing; leave one of them out"),  # else it is the diameter now
        (lambda t: t.pitch_diameter_mm is not None, "pitch_diameter_mm = {t.pitch_diameter_mm:g}: raceways and "
            "clearance already give the pitch; give it with roller_diameter_mm and either clearance_um or "
            "outer_raceway_diameter_mm"),  # else it is a raceway's diameter now
        (lambda t: (absent := [number for number in t.missing_rollers if number >= t.rollers]) and (
            ", ".join(map(str, absent)), t.rollers - 1), "missing_rollers = {t.missing_rollers}: there is no roller "
            "{0}; rollers = {t.rollers} are counted from 0 to {1}"),
        (lambda t: len(set(t.missing_rollers)) < len(t.missing_rollers),
            "missing_rollers = {t.missing_rollers}: a number is there twice"),
        (lambda t: t.present < FEWEST_ROLLERS, "missing_rollers = {t.missing_rollers}: leaves {t.present} rollers; at "
            f"least {FEWEST_ROLLERS} must be left"),
        only("inner_conformity outer_conformity", "type", "ball"),
        (lambda t: t.arrangement and (t.rows != 2 or t.contact_angle_deg == 0.0), 'arrangement = "{t.arrangement}": '
            "two rows are mirrored by their contact angle; not with rows = {t.rows} and contact_angle_deg = "
            "{t.contact_angle_deg:g}; give rows = 2 and an angle, or leave it out"),
        (lambda t: t.arrangement and t.row_distance_mm is None and 1.5 * t.roller_length_mm, 'arrangement = '
            '"{t.arrangement}": needs the distance of its rows, e.g. row_distance_mm = {0:g}'),
        only("row_distance_mm preload_N", "arrangement"),
        (lambda t: t.flange_height_mm and (t.type == "ball" or t.contact_angle_deg or t.rows > 1), "flange_height_mm = "
            "{t.flange_height_mm:g}: of one row of cylindrical rollers, without balls and contact_angle_deg; leave it "
            "out"),
        (lambda t: t.bore_diameter_mm >= t.inner_raceway_diameter_mm, "bore_diameter_mm = {t.bore_diameter_mm} must be "
            "below inner_raceway_diameter_mm = {t.inner_raceway_diameter_mm}"),
        (lambda t: t.outside_diameter_mm <= t.outer_raceway_diameter_mm, "outside_diameter_mm = "
            "{t.outside_diameter_mm} must be above outer_raceway_diameter_mm = {t.outer_raceway_diameter_mm}"),
        (lambda t: exceeds(least := -LARGEST_PRELOAD * t.roller_diameter_mm, t.clearance) and least, f"{CLEARANCE} "
            "more preload than the model allows (at least {0:.4g} mm); raise outer_raceway_diameter_mm = "
            "{t.outer_raceway_diameter_mm}"),
        (lambda t: exceeds(t.clearance, most := LARGEST_CLEARANCE * t.roller_diameter_mm) and most, f"{CLEARANCE} too "
            "large (at most {0:.4g} mm); lower outer_raceway_diameter_mm = {t.outer_raceway_diameter_mm}"),
        (lambda t: t.pitch * sin(pi / t.rollers) <= t.roller_diameter_mm and (
            int(pi / asin(t.roller_diameter_mm / t.pitch)) if t.roller_diameter_mm < t.pitch else 1),
            "rollers = {t.rollers} of roller_diameter_mm = {t.roller_diameter_mm} do not fit on the pitch circle of "
            "{t.pitch:g} mm; at most {0}"))


class MaterialOverride(Table):
    """Material of this body; keys left out are those of [material]."""

    youngs_modulus_GPa: Modulus | None = key(None, "Young's modulus of this body")
    poisson_ratio: PoissonRatio | None = key(None, "Poisson's ratio of this body")
    density_kg_m3: Density | None = key(None, "density of this body")


class MaterialTable(Table):
    """Material of all bodies; [material.roller], [material.inner_ring] and [material.outer_ring] override it."""

    youngs_modulus_GPa: Modulus = key(210.0, "Young's modulus")
    poisson_ratio: PoissonRatio = key(0.3, "Poisson's ratio")
    density_kg_m3: Density = key(7850.0, "density")
    roller: MaterialOverride = key(MaterialOverride(), "material of the rollers")
    inner_ring: MaterialOverride = key(MaterialOverride(), "material of the inner ring")
    outer_ring: MaterialOverride = key(MaterialOverride(), "material of the outer ring")

    def of(self, body: Literal["roller", "inner_ring", "outer_ring"], rigid: bool = False) -> Material:
        """Material of one kind of body, SI."""
        own = {name: value for name, value in getattr(self, body).si().items() if value is not None}
        return self.fact(Material, **own, rigid=rigid)


class FitTable(Table):
    """Operating clearance from that of the unmounted bearing: fits, temperatures, spin, film."""

    shaft_interference_um: float = key(0.0, "shaft minus bore diameter at 20 °C, less the smoothing of the surfaces; "
        "negative: loose", -10_000.0, 10_000.0)
    housing_interference_um: float = key(0.0, "outside diameter of the outer ring minus housing bore at 20 °C; "
        "negative: loose", -10_000.0, 10_000.0)
    shaft_bore_mm: float = key(0.0, "bore of a hollow shaft; 0: solid", 0.0, 10_000.0)
    housing_outside_diameter_mm: float = key(0.0, "outside diameter of the housing, taken as a ring; 0: so thick that "
        "it is stiff", 0.0, 100_000.0)
    shaft_youngs_modulus_GPa: Modulus = key(210.0, "Young's modulus of the shaft")
    shaft_poisson_ratio: PoissonRatio = key(0.3, "Poisson's ratio of the shaft")
    shaft_density_kg_m3: Density = key(STEEL_DENSITY, "density of the shaft, for its spin")
    housing_youngs_modulus_GPa: Modulus = key(210.0, "Young's modulus of the housing; aluminium 70")
    housing_poisson_ratio: PoissonRatio = key(0.3, "Poisson's ratio of the housing; aluminium 0.33")
    inner_ring_C: Temperature = key(REFERENCE_C, "temperature in operation")
    outer_ring_C: Temperature = key(REFERENCE_C, "temperature in operation")
    rollers_C: Temperature | None = key(None, "temperature in operation; default: mean of both rings'")
    shaft_C: Temperature | None = key(None, "temperature in operation; default: that of the ring")
    housing_C: Temperature | None = key(None, "temperature in operation; default: that of the ring")
    ring_expansion_1_K: Expansion = key(STEEL_EXPANSION, "thermal expansion of the rings; default bearing steel")
    roller_expansion_1_K: Expansion = key(STEEL_EXPANSION, "thermal expansion of the rollers; silicon nitride 3.2e-6")
    shaft_expansion_1_K: Expansion = key(STEEL_EXPANSION, "thermal expansion of the shaft")
    housing_expansion_1_K: Expansion = key(STEEL_EXPANSION, "thermal expansion of the housing; aluminium 23.8e-6")

    def fit(self) -> Fit:
        """The fits in SI."""
        si = self.si() | {"housing_density": STEEL_DENSITY}  # it stands still
        usual = {"shaft_C": self.inner_ring_C, "rollers_C": 0.5 * (self.inner_ring_C + self.outer_ring_C),
            "housing_C": self.outer_ring_C}
        names = "youngs_modulus", "poisson_ratio", "density"
        bodies = {body: Material(**{name: si[f"{body}_{name}"] for name in names}) for body in ("shaft", "housing")}
        warm = {name: value for name, value in usual.items() if si[name] is None}
        return self.fact(Fit, **bodies, **warm, housing_outside=si["housing_outside_diameter"] or inf)


class BodiesTable(Table):
    """Which bodies are rigid."""

    rollers: Rigidity = key("elastic", "rollers; not rigid together with a ring")
    inner_ring: Rigidity = key("elastic", "inner ring")
    outer_ring: Rigidity = key("elastic", "outer ring")

    RULES = ((lambda t: t.rollers == "rigid" and " and ".join(f'{name} = "rigid"' for name in t.rigid[1:]),
        'rollers = "rigid" together with {0}: a contact of two rigid bodies has no compliance and so no force; leave '
        'the rollers or the rings "elastic", or, for bodies that are all rigid with a contact law between them, leave '
        "[bodies] out and use run-fem --model lagrange"),)

    @property
    def rigid(self) -> tuple[str, ...]:
        """The keys of those that are."""
        return tuple(name for name in type(self).model_fields if getattr(self, name) == "rigid")


class LubricantTable(Table):
    """A film that takes up gap, as thick as Dowson and Higginson's under the largest static load of a raceway."""

    viscosity_Pa_s: float = key(0.02, "viscosity at the inlet of the contacts", 1e-5, 100.0)
    pressure_viscosity_1_Pa: float = key(2e-8, "pressure-viscosity coefficient", 1e-10, 1e-6)
    traction_coefficient: Share = key(0.05, "traction coefficient of the film, instead of contact.friction_coefficient")

    def lubricant(self) -> Lubricant:
        """The oil, SI."""
        return self.fact(Lubricant)


PLAY, INNER_GUIDE_PLAY = 1e-3, 0.5e-3  # of the pitch diameter; rollers gain on rolling in proportion to it
MASS = 0.1  # of all rolling elements: a polyamide ring half as high as they are, less its pockets
STIFFNESS = 1e7  # N/m, of a roller on polyamide; stiffer ones only shorten the step
SHARE_OF_LINE = 0.1  # of 1/A: the slope of a line contact, 1/(A ln …), whose logarithm is about 10
FULL_COMPLEMENT = 0.07  # of a roller's diameter: a smaller gap between neighbours has no room for a bar
SIZES = "rollers", "roller_diameter_mm", "inner_raceway_diameter_mm"  # by which a bearing is the paper's
Play = Annotated[float, Field(ge=1e-3, le=100.0)]


class CageTable(Table):
    """A rigid cage that moves under the forces on it; keys left out are those of the default cage."""

    kind: Literal["rigid", "none"] = key("rigid", "rigid, or none: the bearing has no cage")
    mass_kg: float | None = key(None, "mass of the cage; default: a tenth of the rolling elements' mass", 1e-6, 1e5)
    inertia_kg_m2: float | None = key(None, "moment of inertia about its centre; default: a thin ring of the pitch "
        "radius", 1e-12, 1e6)
    pocket_clearance_mm: Play | None = key(None, "clearance of a roller in its pocket along the pitch circle, both "
        "sides together; default: 0.001 of the pitch diameter")
    guidance: Guidance | None = key(None, "what centres the cage: the rollers (round pockets) or a ring (flat "
        "pockets); default: the outer ring, or the inner ring if the outer one turns or has a fit")
    guidance_clearance_mm: Play | None = key(None, "diametral clearance between cage and guiding ring; default: 0.001 "
        "of the pitch diameter, at the inner ring half of it or the bearing's clearance")
    stiffness_N_per_m: float | None = key(None, "stiffness of each contact of the cage; default: 1e7, or that of a "
        "raceway contact if lower", 1e4, 1e11)
    damping_N_s_m: float = key(1.0, "damping of each closed contact of the cage; never pulls", 0.0, 1e6)
    friction_coefficient: Share = key(0.05, "friction coefficient in pockets and at the guiding ring")
    drag_torque_N_m: float = key(0.0, "drag torque of the lubricant on the cage", 0.0, 1e6)

    RULES = (only("guidance_clearance_mm", "guidance", "inner_ring", "outer_ring", None),)

    def filled(self, bearing: Bearing, outer_ring_moves: bool) -> "CageTable":
        """With the default cage's values for keys that are left out."""
        guidance = self.guidance or ("inner_ring" if outer_ring_moves else "outer_ring")
        pitch, line = 2.0 * bearing.pitch_radius, max(pair.line_compliance for pair in contact_pairs(bearing)[:2])
        defaults = {"mass_kg": max(MASS * bearing.n_rollers * bearing.roller_mass, 1e-6),
            "pocket_clearance_mm": min(PLAY * pitch, 0.5 * room_between_rollers(bearing)) / MM, "guidance": guidance,
            "stiffness_N_per_m": max(min(STIFFNESS, SHARE_OF_LINE / line), 1e4)}
        if guidance != "rollers":  # the inner ring leaves the middle of the rollers' orbit by half the clearance
            inner = max(INNER_GUIDE_PLAY * pitch, 2.0 * bearing.radial_clearance, 1e-6)
            defaults["guidance_clearance_mm"] = (PLAY * pitch if guidance == "outer_ring" else inner) / MM
        shown = {name: float(f"{each:.3g}") if isinstance(each, float) else each for name, each in defaults.items()}
        return self.model_copy(update={name: each for name, each in shown.items() if getattr(self, name) is None})

    def cage(self, bearing: Bearing) -> Cage:
        """The cage in SI, of a table that is `filled`. ValueError: it is not."""
        if self.mass_kg is None or self.guidance is None:
            raise ValueError("the bearing is not known, and so the cage is not")
        thin_ring = self.mass_kg * bearing.pitch_radius**2
        return self.fact(Cage, inertia=thin_ring if self.inertia_kg_m2 is None else self.inertia_kg_m2)

    @property
    def words(self) -> str:
        """The cage in words, for plans."""
        guide = f"guided by {'' if self.guidance == 'rollers' else 'the '}{self.guidance}" if self.guidance else ""
        play = "" if self.guidance_clearance_mm is None else f" with {self.guidance_clearance_mm:g} mm"
        return (f"{1e3 * (self.mass_kg or 0.0):.3g} g, {guide.replace('_', ' ')}{play}, pocket clearance "
            f"{self.pocket_clearance_mm:g} mm, {self.stiffness_N_per_m:.3g} N/m")


def default_cage(table: BearingTable, bearing: Bearing, friction_coefficient: float) -> CageTable | str:
    """The cage of a scene that does not describe one; in words why there is none."""
    if all(getattr(table, name) == BearingTable.model_fields[name].default for name in SIZES):
        return "as the paper's bearing"
    if friction_coefficient == 0.0:
        return "raceways without friction would not drive it"
    if room_between_rollers(bearing) < FULL_COMPLEMENT * 2.0 * bearing.roller_radius:
        return "full complement"
    return CageTable()


SURFACES = ("roller", "inner_raceway", "outer_raceway")  # before _profile
SHAPES = ("none", "logarithmic", "crowned", "lundberg")
NAMES = ("z_mm", "drop_um")
FEWEST, MOST = 3, 10_000  # points of a measured profile
LARGEST_DROP = 1e5  # µm


class Points(NamedTuple):
    """Of a measured profile, m; the least drop is 0."""

    place: tuple[float, ...]
    depth: tuple[float, ...]


@lru_cache(maxsize=8)
def measured(text: str, decimal: str = ".") -> Points:
    """The drops of a table's text. ValueError: a sentence on the text."""
    z, drop = rising(text, NAMES, decimal, FEWEST, MOST).T
    if np.abs(drop).max() > LARGEST_DROP:
        raise ValueError(f"drop_um = {drop[np.argmax(np.abs(drop))]:g}: at most {LARGEST_DROP:g} either way")
    return Points(tuple(MM * z), tuple(UM * (drop - drop.min())))


class AxialTable(Table):
    """Rollers that tilt, divided into slices along their length; without this table the bearing is a plane section."""

    roller_profile: FileName = key("logarithmic", 'profile of the rollers: "none", "logarithmic" (ISO/TS 16281), '
        '"crowned", "lundberg", or a CSV file next to ' "the scene with the columns z_mm, drop_um")
    roller_profile_sha256: Digest = None
    roller_profile_content: FileText = None
    inner_raceway_profile: FileName = key("none", "profile of the inner raceway: as roller_profile")
    inner_raceway_profile_sha256: Digest = None
    inner_raceway_profile_content: FileText = None
    outer_raceway_profile: FileName = key("none", "profile of the outer raceway: as roller_profile")
    outer_raceway_profile_sha256: Digest = None
    outer_raceway_profile_content: FileText = None
    decimal: DecimalSign = None
    crown_um: float | None = key(None, 'drop of a "crowned" profile (an arc) at the ends of a roller', most=1e4, gt=0.0)
    lundberg_load_N: float | None = key(None, 'load of a roller at which a "lundberg" profile has a uniform pressure',
        most=1e7, gt=0.0)
    slices: int = key(21, "number of slices of a roller", 3, 201)
    coupling: bool = key(True, "neighbouring slices interact elastically; never in the Lagrangian model")
    ring_width_mm: Diameter | None = key(None, "width of both rings; default: twice the length of the rollers")
    hub_tilt_inertia_kg_m2: float | None = key(None, "moment of inertia of inner ring and shaft about an axis across "
        "theirs; default: the slope stays at operation.misalignment_mrad", most=1e6, gt=0.0)
    shaft_tilt_stiffness_N_m_rad: float | None = key(None, "tilt stiffness of a shaft whose slope can change; default "
        "0", 0.0, 1e12)

    FILES: ClassVar = {f"{surface}_profile": File("drops", measured, SHAPES) for surface in SURFACES}

    def _shapes(self):
        kinds = [getattr(self, name) for name in self.FILES]
        for name, kind, example in (("crown_um", "crowned", 5.0), ("lundberg_load_N", "lundberg", 1000.0)):
            given = getattr(self, name)
            if kind in kinds and given is None:
                yield f'a profile that is "{kind}" needs {name}, e.g. {name} = {example:g}'
            if kind not in kinds and given is not None:
                yield f'{name} = {given:g}: only with a profile that is "{kind}"; leave it out'

    RULES = (_shapes, only("shaft_tilt_stiffness_N_m_rad", "hub_tilt_inertia_kg_m2"))

    def axial(self, bearing: Bearing) -> Axial:
        """The table in SI. ValueError: a file is not at hand."""
        return self.fact(Axial, **{surface: self._profile(f"{surface}_profile") for surface in SURFACES},
            ring_width=2.0 * bearing.roller_length if self.ring_width_mm is None else MM * self.ring_width_mm,
            shaft_tilt_stiffness=self.shaft_tilt_stiffness_N_m_rad or 0.0)

    def _profile(self, name):
        kind = getattr(self, name)
        if kind in SHAPES:
            return Profile(kind=kind, crown=UM * (self.crown_um or 0.0), load=self.lundberg_load_N or 0.0)
        points = self.read(name)
        if points is None:
            raise ValueError(f'axial.{name} = "{kind}" is not at hand')
        return Profile(kind="measured", place=points.place, depth=points.depth)
