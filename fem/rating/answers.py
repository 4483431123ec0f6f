"""Every number that a machine's designer asks of a bearing, with its unit, meaning and source; null with a reason.

`Case` computes what they need of a scene, each once; BLOCKS has a row for every answer.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from math import degrees, nan, pi, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lagrange import BallBearing, Operation, contact_laws
from lagrange.axial.slices import Axial
from lagrange.bearing import load_factor, stiffness_factor
from lagrange.catalogue import dimension_series, listed, width_of
from lagrange.contact import hertz
from lagrange.first_state import equilibrium_state
from lagrange.fits import growths, outer_growth
from lagrange.kinematics import kinematics
from lagrange.mounting import HELD
from lagrange.rating import equivalent, life, reference_life, sources
from lagrange.rating.axial_load import Balance, LaminaLoads, at_rest, rigid_loads
from lagrange.rating.equivalent import Factors
from lagrange.rating.life import Basic, Dimensions, DutyCycle, Torque, in_hours, reference_viscosity, reliability_factor
from lagrange.rating.reference_life import RunLoads
from lagrange.rating.sources import NotAsked, Source, Unavailable
from lagrange.rating.stiffness import SAMPLES, Pitch, lagrangian_pitch
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene
from lagrange.surface.film import film_thicknesses, under_films

if TYPE_CHECKING:
    from fem.rating.equilibria import TiltedPitch

POSITIONS = 16  # of the cage in a pitch, for the standard's load distribution
INSTANTS = 2000  # of a load that changes with time
SLOPES = (0.0, 0.5, 1.0, 2.0, 3.0, 4.0)  # mrad
ALLOWED_SLOPE = 4.0 / 60.0 * pi / 180.0  # rad, of cylindrical roller bearings of narrow series by makers' catalogues
NEGLIGIBLE = 5e5  # mm/min, n d_m up to which centrifugal forces change no contact angle of balls by much (Jones)
TO_SI = np.sqrt([1e3, 1e3, 1e3, 1e-3, 1e-3])  # of stiffnesses in mm of lengths and tilts
PLANAR = "no axial load, tilting moment or mirrored rows in the scene"
DIFFERING = 1.5  # of L10r and L10, either way
PLANE = "rollers do not tilt: the scene has no [axial]"
NO_RUN = "no run: give a result file of run-fem instead of the scene"
RATINGS = {"C": ("dynamic", "ISO 281"), "C0": ("static", "ISO 76"), "Cu": ("fatigue", "ISO 281")}
NOTED = 0.01  # difference of a rating from the standard's, relative
NO_FIT = "no [fit] in the scene: its clearance is assumed to include interference and temperatures"


class Options(NamedTuple):
    """What a scene doesn't say."""

    name: str | None = None  # of the rating; None: the scene's
    viscosity: float | None = None  # mm²/s, kinematic, in operation; None: that of [lubricant] over the density
    oil_density: float = 870.0  # kg/m³
    contamination: float | None = None  # e_C; None: oil, filtered in line
    reliability: float = 90.0  # %
    roughness: float | None = None  # µm, rms of roller and raceway together
    width: float | None = None  # mm, of the bearing; None: that of its designation
    life: float | None = None  # h, wanted
    cycle: DutyCycle | None = None
    run: RunLoads | None = None  # of the same scene: its loads in place of the scene's
    rotor: bool = False  # coefficients for one are wanted
    angles: int = SAMPLES  # of the cage in a pitch; a quarter of them where rollers tilt


class Case:
    """A scene with its options; each property is computed once, or is `Unavailable`. Loads in N."""

    def __init__(self, scene: Scene, options: Options):
        self.scene, self.options = scene, options
        self.bearing = under_films(scene.perfect_bearing(), scene.films())
        operation = scene.ideal_operation()
        self.history, self.operation = operation.history, replace(operation, history=None)
        self.turning = reference_life.turning_rings(operation)  # against the load
        self.mounting, self.axial = scene.mounting(), scene.ideal_axial()
        self.balls = isinstance(self.bearing, BallBearing)
        self.exponent = life.OF_BALLS if self.balls else life.EXPONENT  # of life over load
        self.relative_speed = operation.speed - operation.outer_speed  # at the start, rad/s
        self.bends = self.mounting.points is not None or self.mounting.bore is not None  # the outer ring
        self.weight = operation.inner_mass * operation.gravity
        self.radial_load = float(np.hypot(self.operation.side_load, self.operation.radial_load))
        given = self.given = scene.row_loads()
        self.in_plane = not (given.axial_load or given.arrangement or (given.tilt and self.axial is None)) and (
            given.moment is None
        )

    @property
    def elements(self) -> str:  # in words
        of = self.scene.bearing
        long = "" if self.balls else f" × {of.roller_length_mm:g}"
        words = f"{of.present} {'balls' if self.balls else 'rollers'} of {of.roller_diameter_mm:g}{long} mm"
        return words if of.rows == 1 else f"{of.rows} rows of {words}"

    def of_scene(self, load: float) -> float:
        return load if self.options.cycle is None else _not_asked("loads are those of --cycle")

    row = cached_property(lambda self: Dimensions.of(self.scene.unmounted_bearing()))
    basic = cached_property(lambda self: self.scene.ratings())
    basic_life = property(lambda self: life.basic_life(self.basic.dynamic, self.load, self.exponent))
    laws = cached_property(lambda self: contact_laws(self.scene.lagrange.law, self.bearing))

    @cached_property
    def on_bearing(self) -> Operation:
        """The operation with what loads the bearing alone: without what the shaft's springs carry."""
        side, down = self.operation.side_load, self.operation.radial_load
        if (shaft := self.mounting.shaft) is not None:
            try:
                state = equilibrium_state(self.bearing, self.operation, self.laws).state
            except RuntimeError as error:
                raise Unavailable(str(error)) from None
            side -= shaft.stiffness * float(state.x + state.ring_x)
            down += shaft.stiffness * float(state.y + state.ring_y)
        return replace(self.operation, side_load=side, radial_load=down, mounting=HELD)

    @cached_property
    def static_load(self) -> float:  # at t = 0, weight of shaft and ring included
        acting = self.on_bearing
        return load_factor(self.bearing) * float(np.hypot(acting.side_load, acting.radial_load + self.weight))

    @cached_property
    def cycle(self) -> DutyCycle | None:  # given, or of a load or speed that changes with time
        if self.options.run is not None:
            return self.options.run.cycle
        if self.options.cycle is not None or self.history is None or self.history.is_steady:
            return self.options.cycle
        time = 1e-3 * self.scene.numerics.duration_ms * (np.arange(INSTANTS) + 0.5) / INSTANTS
        (x, y), (inner, outer) = self.history.force(time), self.history.ring_speeds(time)
        load = np.hypot(np.broadcast_to(x, time.shape), np.broadcast_to(y, time.shape) - self.weight)
        speeds = np.broadcast_to(np.asarray(inner - outer) / RPM, time.shape)
        if not speeds.any():
            raise Unavailable("the bearing does not turn")
        return DutyCycle(loads=load_factor(self.bearing) * load, speeds=speeds, shares=np.ones(INSTANTS))

    mirrored = property(lambda self: self.given.arrangement is not None)
    series = property(lambda self: dimension_series(self.scene.bearing.designation))

    @property
    def loads(self) -> tuple[np.ndarray, np.ndarray]:  # radial and axial, of all steps, (n,), or of one
        radial = np.array([self.static_load]) if self.cycle is None else self.cycle.loads
        axial = None if self.cycle is None else self.cycle.axial_loads
        return radial, np.broadcast_to(self.given.axial_load if axial is None else axial, radial.shape)

    @property
    def factors(self) -> dict[float, Factors]:  # by axial load
        axial = np.unique(self.loads[1])
        factors = equivalent.factors
        return {a: factors(self.bearing, self.basic.static, a, self.mirrored, self.series) for a in axial if a != 0.0}

    def mean(self, loads: np.ndarray) -> float:
        """Of loads of all steps the one of the same life."""
        return float(loads[0]) if self.cycle is None else replace(self.cycle, loads=loads).load(self.exponent)

    @cached_property
    def load(self) -> float:  # P
        (radial, axial), found = self.loads, self.loads[0].copy()
        for each, factors in self.factors.items():
            found[axial == each] = factors.load(radial[axial == each], each)
        return self.mean(found)

    # P0; what the mean radial load is of one row's section, F_r/(i cos α); speed of one ring against the other
    @property
    def largest_load(self) -> float:
        radial, axial = self.loads
        return float(equivalent.static_load(self.bearing, radial, axial, self.mirrored).max())

    radial_mean = property(lambda self: positive(self.mean(self.loads[0]), "rollers carry none"))
    section_load = property(lambda self: self.radial_mean / load_factor(self.bearing))
    rpm = cached_property(lambda self: abs(self.relative_speed) / RPM if self.cycle is None else self.cycle.speed)

    @cached_property
    def viscosity(self) -> float:  # kinematic, mm²/s
        if self.options.viscosity is not None:
            return self.options.viscosity
        unknown = "no viscosity: no [lubricant] in the scene; or give --viscosity in mm²/s"
        oil = self.scene.lubricant or _not_asked(unknown)
        return 1e6 * oil.viscosity_Pa_s / self.options.oil_density

    kappa = cached_property(lambda self: self.viscosity / reference_viscosity(self.rpm, self.basic.pitch))

    @cached_property
    def contamination(self) -> float:
        given = self.options.contamination
        return life.contamination_factor(self.kappa, self.basic.pitch) if given is None else given

    def a_iso(self, load: float) -> float:
        ratio = self.contamination * self.basic.fatigue / positive(load, "a_ISO has no meaning")
        return life.life_modification(self.kappa, ratio, self.balls)

    modified_life = property(lambda self: self.a_iso(self.load) * self.basic_life)  # 90 % reach it
    a1 = property(lambda self: reliability_factor(self.options.reliability))

    @property
    def wanted(self) -> float:  # 10⁶ revolutions
        hours = self.options.life or _not_asked("no life is wanted: give --life in hours")
        return life.revolutions(hours, self.rpm) or _refuse("the bearing does not turn")

    def reliabilities(self) -> dict[str, float | None]:
        """Of the wanted life by L10 and by the modified life, %."""
        found: dict[str, float | None] = {"L10": life.reliability(self.wanted / self.basic_life), "L10m": None}
        with suppress(Unavailable):
            found["L10m"] = life.reliability(self.wanted / self.modified_life)
        return found

    @property
    def required(self) -> float:  # C for the wanted life, N
        turns = self.wanted / self.a1
        return life.required_capacity(positive(self.load, "none is needed"), turns, self.exponent)

    def flange_limit(self) -> float:  # N
        _ = self.given.flange_height or _not_asked("no flanges of both rings")
        static, sizes = self.basic.static, self.diameters
        return equivalent.flange_limit(static, *sizes, self.rpm, self.radial_mean, self.series)

    @cached_property
    def profile(self) -> bool | np.ndarray:  # as `rigid_loads` takes it: the standard's without [axial]
        if self.axial is None:
            return True
        axial, z = self.axial, 1e-3 * reference_life.positions(self.row)
        drops = [each.drop(z, self.bearing) for each in (axial.roller, axial.inner_raceway, axial.outer_raceway)]
        return 1e3 * (2.0 * drops[0] + drops[1] + drops[2])

    def rigid_at(
        self, first: float = 0.0, slope: float | None = None, profile: bool | None = None, load: float | None = None
    ) -> LaminaLoads:
        """The standard's load distribution, roller 0 at an angle from the load, rad.
        `slope` : rad, of the shaft, `profile` : of `rigid_loads`; None: the scene's; `load` : None: P"""
        self.refuse_space()
        return rigid_loads(
            self.row, self.section_load if load is None else load / load_factor(self.bearing),
            2e3 * self.bearing.radial_clearance, self.operation.misalignment if slope is None else slope,
            profile=self.profile if profile is None else profile, first=first)  # fmt: skip

    rigid = cached_property(lambda self: self.rigid_at())

    @cached_property
    def balance(self) -> Balance:  # of rows on rigid rings at the first angle, under axial load and moment
        first, acting = self.operation.first_roller_angle, self.on_bearing
        force = load_factor(self.bearing) * np.array([acting.side_load, -acting.radial_load - self.weight])
        if self.in_plane:
            force = np.array([0.0, -self.radial_mean])
        elif self.mounting.shaft is not None:
            raise Unavailable("a shaft on springs: not with axial load, tilting moment or mirrored rows")
        return at_rest(self.bearing, force, self.given, self.laws, first, True if self.balls else self.profile)

    in_space = property(lambda self: _not_asked(PLANAR) if self.in_plane else self.balance)

    def life_of_rows(self, a_iso: Callable[[float], float] | None = None) -> float:
        """L10r, or times a_ISO, 10⁶ revolutions, rings rigid, at the first angle."""
        if self.in_plane and not self.balls:
            return self.reference_life(self.rigid.loads, a_iso=a_iso)
        rows, capacity = self.balance.rows, self.basic.dynamic
        if isinstance(self.bearing, BallBearing):
            self.refuse_reference_life()
            loads = np.stack([row.loads for row in rows])
            found = reference_life.ball_reference_life(self.bearing, capacity, loads, turning=self.turning)
            return found if a_iso is None else found * a_iso(self.reference_load)
        lives = [self.reference_life(row.inner, row.outer, a_iso) for row in rows if row.loads.any()]  # others are open
        damage = positive(sum(each ** (-9 / 8) for each in lives), "the rating life is infinite")
        return (damage / len(rows)) ** (-8 / 9)

    @property
    def contacts_in_words(self) -> str:
        if not self.in_plane:
            return f"rigid rings, {'Hertz' if self.balls else 'laminae of ISO/TS 16281'}"
        _ = self.pitch
        law = f"rigid rings on the contact law {self.scene.lagrange.law}"
        return law if self.rigid_rings else "elastic rings and rollers"

    def contact_angles(self) -> list[float]:
        """Of loaded elements, least and largest, degrees."""
        _ = self.balls or _not_asked("rollers keep their contact angle")
        loaded = np.concatenate([np.degrees(np.abs(row.angle[row.loads > 0.0])) for row in self.in_space.rows])
        return [float(loaded.min()), float(loaded.max())] if loaded.size else _refuse("nothing is loaded")

    @property
    def stiffness(self) -> np.ndarray:  # of the hub in x and y, (2, 2), N/m
        return self.pitch.mean if self.in_plane else 1e3 * self.balance.condensed(0, 1)

    def under(self, operation: Operation, elastic: bool, samples: int | None = None) -> Pitch:
        """Equilibria over a pitch, by elastic rings, or rigid ones on the scene's contact law."""
        if elastic and self.bends:
            raise Unavailable("[support]: elastic rings need an outer ring held all around")
        if self.axial is not None:
            is_own = operation is self.on_bearing and elastic == (self.scene.model != "lagrange")
            return (self.tilted if is_own else self.tilted_under(operation, elastic)).pitch
        return self.plane_under(operation, elastic, samples or self.options.angles)

    def refuse_space(self) -> None:
        """Unavailable: the bearing leaves its plane."""
        if not self.in_plane:
            raise NotAsked("over a pitch and with elastic rings only without axial load, moment and mirrored rows")

    def plane_under(self, operation: Operation, elastic: bool, samples: int) -> Pitch:
        """The same with parallel axes, the outer ring held all around."""
        self.refuse_space()
        damping = self.scene.damping.contacts
        bearing = under_films(self.scene.perfect_bearing(), self.scene.films(operation))
        if elastic:
            from fem.rating.equilibria import elastic_pitch

            return elastic_pitch(bearing, operation, damping, samples)
        try:
            return lagrangian_pitch(bearing, operation, self.laws, damping, samples)
        except RuntimeError as error:
            raise Unavailable(str(error)) from None

    def tilted_under(self, operation: Operation, elastic: bool, axial: Axial | None = None) -> "TiltedPitch":
        """The same with rollers that tilt."""
        from fem.rating.equilibria import tilted_pitch

        self.refuse_space()
        axial = axial or self.axial or _not_asked(PLANE)
        return tilted_pitch(self.bearing, axial, operation, None if elastic else self.laws, self.options.angles // 4)

    # over a pitch: by elastic rings, by rigid ones, by the contacts of the scene's model without and with tilting
    elastic = cached_property(lambda self: self.under(self.on_bearing, True))
    lagrangian = cached_property(lambda self: self.under(self.on_bearing, False))
    rigid_rings = property(lambda self: self.scene.model == "lagrange" or self.balls)
    pitch = property(lambda self: self.lagrangian if self.rigid_rings else self.elastic)
    tilted = cached_property(lambda self: self.tilted_under(self.on_bearing, not self.rigid_rings))

    @cached_property
    def oscillation(self) -> str:
        """Words on a swing of the rings in which rollers do not reach their neighbours' tracks; empty: there is none.
        Source: Harris, Rolling Bearing Analysis: critical amplitude 360°/(Z (1 − γ)) either way, of the outer raceway.
        """
        duration, history = 1e-3 * self.scene.numerics.duration_ms, self.history
        if history is None or not history.reverses(duration):
            return ""
        inner, outer = history.ring_turns(np.linspace(0.0, duration, INSTANTS))
        gamma = self.bearing.roller_radius / self.bearing.pitch_radius
        swing, critical = 0.5 * float(np.ptp(inner - outer)), 2.0 * pi / (self.bearing.pockets * (1.0 - gamma))
        if swing >= critical:
            return ""
        return (
            f"the rings swing by ±{degrees(swing):.3g}°, below the critical amplitude of ±{degrees(critical):.3g}°, at "
            "which rollers reach their neighbours' tracks"
        )

    @property
    def line_contacts(self) -> tuple[hertz.Pair, hertz.Pair, hertz.Pair]:
        if isinstance(self.bearing, BallBearing):
            raise Unavailable("stresses and films are those of line contacts; this bearing has balls")
        return hertz.contact_pairs(self.bearing)

    # at inner and outer raceway over the pitch
    @property
    def largest_forces(self) -> tuple[float, float]:
        if self.in_plane:
            return float(self.pitch.inner_force.max()), float(self.pitch.outer_force.max())
        return (max(float(row.loads.max()) for row in self.balance.rows),) * 2

    @cached_property
    def stressed(self) -> dict[str, hertz.LineContact]:  # the most loaded contact of each raceway over the pitch
        pairs = self.line_contacts[:2]
        forces: Sequence[float] = self.largest_forces
        if not self.in_plane:  # as if the most loaded lamina's load were that of all
            forces = [reference_life.LAMINAE * max(float(getattr(row, pair.kind).max()) for row in self.balance.rows)
                      for pair in pairs]  # fmt: skip
        elif self.axial is not None:
            forces = [self.tilted.peaks[pair.kind] for pair in pairs]
        return {pair.kind: hertz.line_contact(pair, force) for pair, force in zip(pairs, forces, strict=True)}

    @cached_property
    def peak_pressure(self) -> float:  # largest Hertz pressure of any contact over the pitch, Pa
        if isinstance(self.bearing, BallBearing):
            (inner, outer), of = self.largest_forces, hertz.ball_pressure
            return max(of(self.bearing, "inner", inner), of(self.bearing, "outer", outer))
        return max(each.peak_pressure for each in self.stressed.values())

    @cached_property
    def film(self) -> float:  # least thickness at either raceway, m
        oil = (self.scene.lubricant or _not_asked("no film: the scene has no [lubricant]")).lubricant()
        _ = self.line_contacts
        forces, speeds = self.largest_forces, (self.relative_speed, 0.0)
        found = film_thicknesses(self.bearing, speeds, forces, oil) if min(forces) > 0.0 else ()
        return min(found or _refuse("the bearing does not turn or carries no load: no film forms"))

    def film_ratio(self) -> float:  # λ
        unknown = "no roughness of the surfaces: give --roughness, rms of both together, in µm"
        roughness = self.options.roughness or _not_asked(unknown)
        return 1e6 * self.film / roughness

    @property
    def diameters(self) -> tuple[float, float]:  # d and D, mm; of a solid shaft its own
        return 2e3 * (self.bearing.bore_radius or self.bearing.inner_raceway_radius), 2e3 * self.bearing.outside_radius

    def torque(self, model: Callable[..., Torque], rpm: float) -> Torque:
        life.caged_cylinders(self.row)
        return model(*self.diameters, self.load, rpm, self.viscosity, self.series)

    torques = cached_property(lambda self: {name: self.torque(law, self.rpm) for name, law in life.FRICTION.items()})

    # W
    losses = property(lambda self: {name: life.power_loss(of.total, self.rpm) for name, of in self.torques.items()})

    def temperature_rises(self) -> dict[str, float]:  # K
        losses, known = self.losses, listed(self.scene.bearing.designation)
        width = self.options.width or (known and width_of(known[0]))
        width = width or _refuse("the bearing's width is not known: no designation; give --width in mm")
        return {name: loss / life.conductance(*self.diameters, width) for name, loss in losses.items()}

    build_up = property(lambda self: self.scene.operating_clearance() or _not_asked(NO_FIT))

    @cached_property
    def clearance_parts(self) -> dict[str, float | None]:  # µm
        if self.scene.fit is not None:
            return {name: round(1e6 * part, 6) for name, part in self.build_up.parts.items()}
        spin, cosine = 0.0, self.bearing.cosine  # by the inner ring and the rollers as they grow with speed, m
        if not (self.bearing.roller.rigid or self.bearing.inner_ring.rigid):
            motion = kinematics(self.bearing, *self.operation.ring_speeds)
            inner, roller = growths(self.bearing, motion)
            spin = inner + 2.0 * roller - outer_growth(self.bearing, motion)
        given = round(2e6 * self.scene.perfect_bearing().radial_clearance / cosine, 6) + 0.0
        of_speed = {"speed": -2e6 * spin / cosine, "film": 1e6 * self.scene.film_loss() / cosine}
        return {"given": given, "shaft_fit": None, "housing_fit": None, "temperature": None, **of_speed}

    run = property(lambda self: self.options.run or _not_asked(NO_RUN))

    @property
    def with_housing(self) -> np.ndarray:  # stiffness of the bearing and its housing behind each other, (2, 2), N/m
        housing = self.mounting.housing or _not_asked("the scene has no [support] with a housing on springs")
        springs = stiffness_factor(self.bearing) * housing.stiffness * np.eye(2)
        return np.linalg.inv(np.linalg.inv(self.stiffness) + np.linalg.inv(springs))

    def at_hub(self) -> np.ndarray:
        """Of the hub against the ground, N/m: bearing and housing behind each other, beside the shaft's springs."""
        housing, shaft = self.mounting.housing, self.mounting.shaft
        _ = housing or shaft or _not_asked("the scene has neither a housing nor a shaft on springs")
        beside = 0.0 if shaft is None else stiffness_factor(self.bearing) * shaft.stiffness
        return (self.stiffness if housing is None else self.with_housing) + beside * np.eye(2)

    def frequencies(self) -> list[float]:
        """Of the hub on its linearised mean stiffness, Hz."""
        values = np.linalg.eigvalsh(self.stiffness)
        if not values[0] > 0.0:
            raise Unavailable("the mean stiffness is positive in one direction at most")
        return (np.sqrt(values / (stiffness_factor(self.bearing) * self.operation.inner_mass)) / (2.0 * pi)).tolist()

    rigid_life = cached_property(lambda self: self.life_of_rows())
    pitch_life = cached_property(lambda self: self.reference_life(np.concatenate(
        [self.rigid_at(2.0 * pi / self.row.rollers * k / POSITIONS).loads for k in range(POSITIONS)])))  # fmt: skip

    @cached_property
    def elastic_life(self) -> float:
        acting = self.on_bearing
        if self.cycle is not None:
            acting = replace(acting, side_load=0.0, radial_load=self.section_load - self.weight)
        if self.axial is not None:  # slices alone, which the standard's factor of edges is made for
            alone = replace(self.axial, slices=reference_life.LAMINAE, coupling=False)
            return self.reference_life(*self.tilted_under(acting, True, alone).loads)
        pitch = self.elastic if self.cycle is None else self.under(acting, True)
        forces = pitch.inner_force, pitch.outer_force
        inner, outer = (reference_life.shared_out(self.row, force) for force in forces)
        return self.reference_life(inner, outer)

    def refuse_reference_life(self) -> None:
        """Unavailable: L10r is that of rigid rings which turn under the load."""
        if self.bends:
            raise Unavailable("[support]: the outer ring bends, and L10r assumes rigid rings")
        if self.oscillation:
            raise Unavailable(f"{self.oscillation}: no ring turns relative to the load, which L10r assumes")
        if self.cycle is not None and self.loads[1].any():
            raise Unavailable("L10r is that of steady loads: not with a duty cycle that has axial ones")

    def reference_life(
        self, inner: np.ndarray, outer: np.ndarray | None = None, a_iso: Callable[[float], float] | None = None
    ) -> float:
        """L10r, or times a_ISO, 10⁶ revolutions, under loads of laminae, N."""
        self.refuse_reference_life()
        capacity = self.basic.dynamic
        return reference_life.reference_life(self.row, capacity, inner, outer, turning=self.turning, a_iso=a_iso)

    reference_load = property(lambda self: self.basic.dynamic / self.rigid_life ** (1.0 / self.exponent))  # N

    @cached_property
    def catalogue(self) -> dict[str, dict[str, Any]]:  # C, C0 and C_u, N, where each comes from, and the standard's
        known, iso, found = self.scene.bearing.known_ratings, None, {}
        with suppress(Unavailable):
            iso = Basic.of(self.scene.unmounted_bearing())
        for letter, (name, standard) in RATINGS.items():
            value, words = getattr(self.basic, name), ""
            own = value if iso is None else getattr(iso, name)
            source = known[name][1] if name in known else standard if value == own else f"{standard} from that C0"
            if abs(off := value / own - 1.0) > NOTED:
                off_by = f"{100.0 * abs(off):.0f} % {'above' if off > 0.0 else 'below'} {standard}'s {own:.0f} N"
                words = f"{letter} {value:.0f} N ({source}), {off_by}"
            found[letter] = {"value_N": value, "source": source, "ISO_N": iso and own, "words": words}
        return found


def _refuse(reason):
    raise Unavailable(reason)


def _not_asked(reason):
    raise NotAsked(reason)


def _only(factors):
    if not factors:
        raise NotAsked("no axial load")
    return next(iter(factors.values())) if len(factors) == 1 else _refuse("they differ from step to step")


def positive(load: float, else_what: str) -> float:
    """The load, N. Unavailable: there is none."""
    return load if load > 0.0 else _refuse(f"without load {else_what}")


class Answer(NamedTuple):
    """One number, or some that belong together; `value` None where there is none, and then `reason` says why.
    `asked` : False of what only an option or a part of the scene that was not given would bring."""

    block: str
    name: str
    value: Any
    unit: str
    meaning: str
    source: Source
    reason: str = ""
    asked: bool = True


STRESSES = {  # of a contact, and what turns them out of SI
    "peak_pressure_MPa": 1e-6, "half_width_um": 1e6, "largest_shear_MPa": 1e-6, "shear_depth_um": 1e6,
    "largest_von_mises_MPa": 1e-6, "von_mises_depth_um": 1e6}  # fmt: skip

s = sources
Row = tuple[str, str, str, Source, Callable[[Case], Any]]


def _life(name, meaning, source, of):
    """In revolutions and in hours."""
    hours = f"{name}_h", "h", meaning, source, lambda c: in_hours(of(c), c.rpm)
    return (f"{name}_Mrev", "Mrev", meaning, source, of), hours


# Blocks of the sheet: name in the JSON file, unit, meaning, source, value. Neighbours of one meaning share a line.
BLOCKS: dict[str, tuple[Row, ...]] = {
    "bearing": (
        ("designation", "", "bearing", s.SCENE,
         lambda c: c.scene.bearing.designation or _not_asked("no standard bearing: the scene has its sizes")),
        ("elements", "", "rolling elements", s.SCENE, lambda c: c.elements),
        ("C_N", "N", "basic dynamic load rating C", s.DYNAMIC, lambda c: c.basic.dynamic),
        ("C0_N", "N", "basic static load rating C0", s.STATIC, lambda c: c.basic.static),
        ("Cu_N", "N", "fatigue load limit C_u", s.FATIGUE, lambda c: c.basic.fatigue),
        ("catalogue", "", "origin of these ratings", s.KNOWN, lambda c: c.catalogue),
        ("operating_clearance_um", "µm", "clearance in operation", s.CLEARANCE,
         lambda c: sum(part for part in c.clearance_parts.values() if part is not None)),
        ("operating_clearance_parts_um", "µm", "of that", s.CLEARANCE, lambda c: c.clearance_parts),
        ("fit_pressure_MPa", "MPa", "fit pressure in operation", s.FITS,
         lambda c: {"shaft": 1e-6 * c.build_up.shaft_pressure, "housing": 1e-6 * c.build_up.housing_pressure})),
    "loads": (
        ("radial_load_N", "N", "radial load", s.SCENE, lambda c: c.of_scene(load_factor(c.bearing) * c.radial_load)),
        ("axial_load_N", "N", "axial load", s.SCENE, lambda c: c.of_scene(c.given.axial_load) or _not_asked(PLANAR)),
        ("weight_N", "N", "weight of ring and shaft", s.SCENE, lambda c: c.of_scene(load_factor(c.bearing) * c.weight)),
        ("P_N", "N", "equivalent dynamic load P", s.LOAD, lambda c: c.load),
        ("factors", "", "e, Y up to it, X and Y beyond", s.LOAD,
         lambda c: {name: float(value) for name, value in _only(c.factors)._asdict().items()}),
        ("reference_load_N", "N", "load with L10r's life", s.REFERENCE, lambda c: c.reference_load),
        ("P0_N", "N", "equivalent static load P0", s.STATIC_LOAD, lambda c: c.largest_load),
        ("s0", "1", "static safety C0/P0", s.STATIC,
         lambda c: c.basic.static / positive(c.largest_load, "it is infinite")),
        ("minimum_load_N", "N", "minimum radial load", s.LEAST_LOAD,
         lambda c: equivalent.least_load(c.basic.dynamic, c.balls)),
        ("permitted_axial_load_N", "N", "permitted axial load", s.FLANGES, lambda c: c.flange_limit()),
        ("speed_rpm", "1/min", "relative ring speed", s.SCENE, lambda c: c.rpm),
        ("hub_displacement_um", "µm", "hub at x, y, z", s.IN_SPACE, lambda c: 1e3 * c.in_space.hub[:3]),
        ("hub_tilt_mrad", "mrad", "tilt of the hub", s.IN_SPACE, lambda c: 1e3 * c.in_space.hub[3]),
        ("moment_on_hub_N_m", "N m", "moment that holds it", s.IN_SPACE,
         lambda c: _not_asked("the hub is free to tilt") if c.given.moment is not None else 1e-3 * c.in_space.force[3]),
        ("largest_load_N", "N", "largest load of an element", s.IN_SPACE,
         lambda c: max(float(row.loads.max()) for row in c.in_space.rows)),
        ("contact_angle_range_deg", "°", "contact angles under load", s.IN_SPACE, lambda c: c.contact_angles()),
        ("roller_loads_N", "N", "roller loads at the first angle, rigid rings", s.REFERENCE,
         lambda c: c.rigid.of_rollers if c.in_plane and not c.balls
         else np.concatenate([row.loads for row in c.balance.rows])),
        ("misalignment_mrad", "mrad", "slope of the shaft", s.TILTED, lambda c: 1e3 * c.tilted.slope),
        ("tilting_moment_N_m", "N m", "moment that holds it", s.TILTED, lambda c: round(c.tilted.moment, 9))),
    "lives": (
        *_life("L10", "basic rating life L10", s.LIFE, lambda c: c.basic_life),
        ("a1", "1", "reliability factor a1", s.RELIABILITY, lambda c: c.a1),
        ("Ln_h", "h", "life a1 L10", s.RELIABILITY,
         lambda c: _not_asked("no other reliability than that of L10") if c.options.reliability == 90.0
         else in_hours(c.a1 * c.basic_life, c.rpm)),
        ("e_C", "1", "contamination factor e_C", s.CONTAMINATION, lambda c: c.contamination),
        ("a_ISO", "1", "modification factor a_ISO", s.A_ISO, lambda c: c.a_iso(c.load)),
        ("Lnm_h", "h", "modified rating life Lnm", s.A_ISO, lambda c: in_hours(c.a1 * c.modified_life, c.rpm)),
        *_life("L10r", "L10r, rigid rings", s.REFERENCE, lambda c: c.rigid_life),
        *_life("L10r_pitch", "L10r, rigid rings, mean", s.REFERENCE, lambda c: c.pitch_life),
        *_life("L10r_elastic", "L10r, elastic rings, mean", s.LOAD_SHARING, lambda c: c.elastic_life),
        *_life("L10r_run", "L10r, loads of the run", s.OF_RUN,
               lambda c: c.run.life(c.row, c.basic.dynamic, c.axial is not None)),
        ("L10r_by_misalignment_Mrev", "Mrev", "L10r, rigid rings, by misalignment", s.REFERENCE,
         lambda c: _not_asked(PLANE) if c.axial is None else
         {f"{slope:g} mrad": c.reference_life(c.rigid_at(slope=1e-3 * slope).loads) for slope in SLOPES}),
        ("Lnmr_h", "h", "modified L10r, Lnmr", s.MODIFIED_REFERENCE,
         lambda c: in_hours(c.a1 * c.life_of_rows(c.a_iso), c.rpm)),
        ("reliability_percent", "%", "reliability at --life", s.RELIABILITY, lambda c: c.reliabilities()),
        ("required_C_N", "N", "required C", s.LIFE, lambda c: c.required),
        ("required_C_over_C", "1", "required C / C", s.LIFE, lambda c: c.required / c.basic.dynamic)),
    "stresses": (
        ("peak_pressure_MPa", "MPa", "largest Hertz pressure", s.HERTZ, lambda c: 1e-6 * c.peak_pressure),
        ("pressure_over_permitted", "1", "peak pressure / permitted", s.STRESS_LIMITS,
         lambda c: c.peak_pressure / (hertz.PERMITTED_OF_BALLS if c.balls else hertz.PERMITTED)),
        ("pressure_over_fatigue", "1", "peak pressure / fatigue", s.STRESS_LIMITS,
         lambda c: c.peak_pressure / hertz.FATIGUE),
        ("contacts", "", "most loaded contact of each raceway", s.HERTZ,
         lambda c: {name: {key: factor * getattr(contact, key.rpartition("_")[0]) for key, factor in STRESSES.items()}
                    for name, contact in c.stressed.items()})),
    "stiffness": (
        ("stiffness_N_per_m", "N/m", "stiffness in x, y", s.LINEARISED, lambda c: c.stiffness),
        ("stiffness_range_N_per_m", "N/m", "from lowest to highest", s.LINEARISED, lambda c: c.pitch.range),
        ("stiffness_harmonics_N_per_m", "N/m", "stiffness, amplitudes at 1, 2 ... times the ball pass frequency",
         s.LINEARISED, lambda c: c.pitch.harmonics),
        ("stiffness_contacts", "", "contacts", s.LINEARISED, lambda c: c.contacts_in_words),
        ("stiffness_with_housing_N_per_m", "N/m", "with the housing", s.LINEARISED, lambda c: c.with_housing),
        ("hub_stiffness_N_per_m", "N/m", "with housing and shaft", s.LINEARISED, lambda c: c.at_hub()),
        ("tilt_stiffness_N_m_per_rad", "N m/rad", "tilting at constant load", s.TILTED,
         lambda c: c.tilted.tilt_stiffness),
        ("stiffness_with_tilt", "N/m, N, N m", "stiffness in x, y, tilts", s.TILTED,
         lambda c: c.tilted.stiffness),
        ("stiffness_5x5", "N/m, N, N m", "stiffness in x, y, z, tilts", s.IN_SPACE,
         lambda c: np.outer(TO_SI, TO_SI) * c.in_space.stiffness),
        ("damping_N_s_per_m", "N s/m", "damping in x, y", s.LINEARISED,
         lambda c: _refuse("with [axial] damping is not implemented") if c.axial is not None
         else c.pitch.damping.mean(axis=0) if c.scene.damping.contacts.acts
         else _not_asked("the scene has no [damping] of contacts")),
        ("hub_frequencies_Hz", "Hz", "natural frequencies of hub", s.LINEARISED, lambda c: c.frequencies()),
        ("hub_um", "µm", "hub at x, y", s.LINEARISED, lambda c: 1e6 * c.pitch.place.mean(axis=0))),
    "friction and film": (
        ("nu_mm2_s", "mm²/s", "viscosity in operation", s.VISCOSITY, lambda c: c.viscosity),
        ("nu1_mm2_s", "mm²/s", "reference viscosity ν1", s.VISCOSITY,
         lambda c: reference_viscosity(c.rpm, c.basic.pitch)),
        ("kappa", "1", "viscosity ratio κ", s.VISCOSITY, lambda c: c.kappa),
        ("film_um", "µm", "least film thickness", s.FILM, lambda c: 1e6 * c.film),
        ("lambda", "1", "film / roughness λ", s.FILM, lambda c: c.film_ratio()),
        ("friction_torque_N_mm", "N mm", "frictional torque, ±30 %", s.BOTH_FRICTIONS,
         lambda c: {name: torque.total for name, torque in c.torques.items()}),
        ("friction_torque_palmgren_N_mm", "N mm", "Palmgren's speed and load parts", s.PALMGREN,
         lambda c: {"speed": c.torques["palmgren"].rolling, "load": c.torques["palmgren"].sliding}),
        ("power_loss_W", "W", "heat, ±30 %", s.BOTH_FRICTIONS, lambda c: c.losses),
        ("temperature_rise_K", "K", "temperature rise", s.HEAT, lambda c: c.temperature_rises()),
        ("friction_torque_run_N_mm", "N mm", "torque by dissipation", s.OF_RUN, lambda c: 1e3 * c.run.torque),
        ("dissipated_run_W", "W", "power dissipated in the run", s.OF_RUN, lambda c: c.run.dissipated))}  # fmt: skip
DECLARED = tuple((block, *row) for block, rows in BLOCKS.items() for row in rows)
BULKY = {  # in the file and on the page only
    "catalogue", "factors", "operating_clearance_parts_um", "roller_loads_N", "L10r_by_misalignment_Mrev", "contacts",
    "stiffness_harmonics_N_per_m", "friction_torque_palmgren_N_mm"}  # fmt: skip
OPTION_OF = {"a_ISO": "contamination", "Lnm_h": "reliability", "Lnmr_h": "reliability", "lambda": "roughness",
             "temperature_rise_K": "width"}  # fmt: skip


class Rating(Mapping[str, Any]):
    """Values by name; `answers` have units and sources beside them."""

    def __init__(self, case: Case, without: Collection[str] = (), count: Callable[[], None] = lambda: None):
        self.case, self.scene, self.answers = case, case.scene, dict[str, Answer]()
        for declared in DECLARED:
            if declared[1] not in without:
                self.answers[declared[1]] = _answer(case, *declared)
            count()
        self.warnings = tuple(_warnings(case, {name: answer.value for name, answer in self.answers.items()}))

    def __getitem__(self, name: str) -> Any:
        return self.answers[name].value

    def __iter__(self) -> Iterator[str]:
        return iter(self.answers)

    def __len__(self) -> int:
        return len(self.answers)

    name = property(lambda self: self.case.options.name or self.scene.name)

    def to_json(self) -> dict[str, Any]:
        """Values, and by their names the reasons of those that are null, and the sources."""
        reasons = {name: answer.reason for name, answer in self.answers.items() if answer.reason}
        parts = self["operating_clearance_parts_um"].items()
        reasons |= {f"operating_clearance_parts_um.{name}": NO_FIT for name, part in parts if part is None}
        sources = {name: {"source": f"{of.source.name}: {of.source.text}", "second_hand": of.source.second_hand or None}
                   for name, of in self.answers.items()}  # fmt: skip
        values = {name: _plain(value) for name, value in self.items()}
        return values | {"warnings": list(self.warnings), "reasons": reasons, "sources": sources}


def _plain(value):  # for JSON: arrays as lists, what is infinite or no number as null
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def rating(scene: Scene, options: Options | None = None) -> Rating:
    """All answers to a scene, as rating(Scene(bearing={"designation": "NU206"}))["C_N"]."""
    return Rating(Case(scene, options or Options()))


def values_of(scene: Scene, names: Collection[str]) -> dict[str, float]:
    """Some answers to a scene that are one number each, without computing the others; NaN of what is unavailable."""
    case = Case(scene, Options())
    found = (_answer(case, *declared) for declared in DECLARED if declared[1] in names)
    return {answer.name: nan if answer.value is None else float(answer.value) for answer in found}


def _answer(case, block, name, unit, meaning, source, compute):
    value, reason, asked = None, "", True
    try:
        value = compute(case)
        if RATINGS.get(name.removesuffix("_N"), ("",))[0] in case.scene.bearing.known_ratings:
            own = case.catalogue[name.removesuffix("_N")]
            source = Source(own["source"].partition(" of ")[0], own["words"] or own["source"])
    except Unavailable as error:
        reason, option = str(error), OPTION_OF.get(name)
        given = option is not None and getattr(case.options, option) != Options._field_defaults[option]
        asked = given or not isinstance(error, NotAsked)
    return Answer(block, name, value, unit, meaning, source, reason, asked)


def _differing(case, ratio):
    """Why L10r and L10 differ, where they do by more than DIFFERING times, and which to use."""
    given, clearance = case.given, 2e6 * case.bearing.radial_clearance / case.bearing.cosine
    causes = [words for there, words in (
        (abs(clearance) >= 0.5, f"a {'clearance' if clearance > 0.0 else 'preload'} of {abs(clearance):.3g} µm"),
        (given.tilt, f"a tilt of {1e3 * given.tilt:.3g} mrad"), (given.moment, f"a moment of {given.moment} N m"),
        (given.axial_load, f"an axial load of {given.axial_load:.4g} N")) if there]  # fmt: skip
    why, use = "elements share the load otherwise than ISO 281 assumes", "L10r"
    if ratio > 1.0 and not case.balls:
        why = "it falls with the fourth power of a line contact's load, L10, which has a reserve for uneven pressure, "
        why, use = f"{why}with the power 10/3", "L10 beside catalogues, L10r to compare designs"
    if not 1.0 / DIFFERING <= ratio <= DIFFERING:
        yield f"L10r is {ratio:.2g} times L10: {why}{', with ' * bool(causes)}{' and '.join(causes)}; use {use}"


def _warnings(case, values):
    stiff, rated, load = values["stiffness_N_per_m"] is not None, values["C_N"], values["P_N"] or 0.0
    bearing, operation, slope = case.bearing, case.operation, 1e3 * case.operation.misalignment
    rpm = max(*(abs(speed) / RPM for speed in operation.ring_speeds), values["speed_rpm"] or 0.0)
    if stiff and case.in_plane and not case.pitch.is_stable:
        yield "at some cage angles the hub balances on single rollers: raise the load or reduce the clearance"
    if values["s0"] is not None and values["s0"] < 1.0:
        yield f"static safety {values['s0']:.2f} is below 1: permanent dents in the raceways"
    if rated is not None and load > 0.5 * rated:
        yield "P is beyond C/2, beyond the range of ISO 281's life formula"
    if rated is not None and 0.0 < load < (least := equivalent.least_load(rated, case.balls)):
        elements = "balls" if case.balls else "rollers"
        yield f"P is below {least / rated:.0%} of C: {elements} may skid, and rating lives are of little use"
    if (limit := values["permitted_axial_load_N"]) is not None and (
        axial := float(np.abs(case.loads[1]).max())
    ) > limit:
        yield f"the axial load of {axial:.4g} N is beyond {limit:.4g} N, which flanges carry for long with oil"
    if None not in (basic := values["L10_Mrev"], shared := values["L10r_Mrev"]):
        yield from _differing(case, shared / basic)
    if case.history is not None and not case.history.is_steady:
        yield "speed or load changes with time: stiffness, stresses and film are those at its start"
    if bearing.contact_angle and bearing.rows == 1 and stiff and case.in_plane:
        axial = float(case.pitch.inner_force.sum(axis=1).mean()) * sin(bearing.contact_angle)
        yield f"the radial load causes an axial force of {axial:.4g} N (Σ Q sin α), which another bearing must carry"
    if case.balls and not case.in_plane and 2e3 * bearing.pitch_radius * rpm > NEGLIGIBLE:
        yield f"n d_m is beyond {NEGLIGIBLE:.0f} mm/min: there centrifugal forces, left out, part the contact angles"
    if case.oscillation:
        yield f"{case.oscillation}: L10 from the mean speed is of little use, and no lubricant is drawn in"
    if bearing.rows > 1 and rated is not None and not (case.balls or case.mirrored):
        yield f"{bearing.rows} rows share the load equally, with b_m = 1.1; spherical rollers (1.15) are not supported"
    if abs(slope) > 1e3 * ALLOWED_SLOPE and not (case.balls or bearing.contact_angle):
        yield f"a slope of {slope:.3g} mrad is beyond the 4 minutes of arc that catalogues allow cylindrical rollers"
    if fast := life.speed_warning(bearing, rpm):
        yield f"{fast}, and friction and temperature are extrapolated"
    if case.options.cycle is not None:
        own, most = operation.radial_load, case.options.cycle.loads.max()
        yield f"stiffness, stresses and film are of the scene's load, {own:.4g} N, not of the duty cycle's {most:.4g} N"
    if values["kappa"] is not None and values["kappa"] < 1.0:
        yield f"κ = {values['kappa']:.2g}: mixed lubrication, surfaces touch; a higher viscosity raises κ"
    if case.options.rotor and not case.scene.damping.contacts.acts:
        yield "the scene has no contact damping: a rotor on these coefficients is undamped"
