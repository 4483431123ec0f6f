"""A scene's bearing as ratings need it: loads, lives, stiffness, films, friction, each computed once or unavailable."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from lagrange import BallBearing, Operation, contact_laws
from lagrange.axial import Axial
from lagrange.catalogue import dimension_series, listed, width_of
from lagrange.contact.hertz import LineContact, Pair, ball_pressure, contact_pairs, line_contact
from lagrange.first_state import equilibrium_state
from lagrange.fits import OperatingClearance, growths, outer_growth
from lagrange.kinematics import kinematics
from lagrange.mounting import HELD
from lagrange.rating.friction import Torque, caged_cylinders, conductance, palmgren_torque, power_loss, skf_torque
from lagrange.rating.life import (
    EXPONENT,
    OF_BALLS,
    Basic,
    Dimensions,
    DutyCycle,
    basic_life,
    contamination_factor,
    dynamic_capacity,
    in_hours,
    life_modification,
    reference_viscosity,
    reliability_factor,
)
from lagrange.rating.reference_life import (
    LAMINAE,
    LaminaLoads,
    RunLoads,
    positions,
    reference_life,
    rigid_loads,
    shared_out,
    turning_rings,
)
from lagrange.rating.sources import Unavailable
from lagrange.rating.stiffness import SAMPLES, Pitch, in_series, lagrangian_pitch
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene
from lagrange.section import load_factor, stiffness_factor
from lagrange.surface.film import film_thicknesses, under_films

if TYPE_CHECKING:
    from fem.rating.tilted import TiltedPitch

POSITIONS = 16  # of the cage in a pitch, for the standard's load distribution
INSTANTS = 2000  # of a load that changes with time
SLOPES = (0.0, 0.5, 1.0, 2.0, 3.0, 4.0)  # mrad
TILTS = "with [axial] damping is not implemented"
PLANE = "rollers do not tilt: the scene has no [axial]"
NO_RUN = "no run: give a result file of run-fem instead of the scene"
NO_FIT = "no [fit] in the scene: its clearance is assumed to include interference and temperatures"


@dataclass(frozen=True, kw_only=True)
class Options:
    """What a scene doesn't say."""

    name: str | None = None  # of the rating; None: the scene's
    viscosity: float | None = None  # mm²/s, kinematic, in operation; None: that of [lubricant] over the density
    oil_density: float = 870.0  # kg/m³
    contamination: float | None = None  # e_C; None: oil, filtered in line
    reliability: float = 90.0  # %
    roughness: float | None = None  # µm, rms of roller and raceway together
    width: float | None = None  # mm, of the bearing; None: that of its designation
    cycle: DutyCycle | None = None
    run: RunLoads | None = None  # of the same scene: its loads in place of the scene's


class Case:
    """A scene with its options; each property is computed once, or is `Unavailable`."""

    def __init__(self, scene: Scene, options: Options):
        self.scene, self.options = scene, options
        self.bearing = under_films(scene.perfect_bearing(), scene.films())
        operation = scene.ideal_operation()
        self.history, self.operation = operation.history, replace(operation, history=None)
        self.turning = turning_rings(operation)  # against the load

    @cached_property
    def row(self) -> Dimensions:
        return Dimensions.of(self.scene.unmounted_bearing())

    @cached_property
    def basic(self) -> Basic:
        return Basic.of(self.scene.unmounted_bearing())

    @property
    def balls(self) -> bool:
        return isinstance(self.bearing, BallBearing)

    @property
    def exponent(self) -> float:
        """Of life over load."""
        return OF_BALLS if self.balls else EXPONENT

    def basic_life(self) -> float:
        return basic_life(self.basic.dynamic, self.load, self.exponent)

    @cached_property
    def laws(self):
        return contact_laws(self.scene.lagrange.law, self.bearing)

    @cached_property
    def on_bearing(self) -> Operation:
        """The operation with what loads the bearing alone: without what the shaft's springs carry."""
        operation, shaft = self.operation, self.operation.mounting.shaft
        if shaft is not None:
            try:
                state = equilibrium_state(self.bearing, operation, self.laws).state
            except RuntimeError as error:
                raise Unavailable(str(error)) from None
            places = float(state.x + state.ring_x), float(state.y + state.ring_y)
            aside, down = (-shaft.stiffness * place for place in places)
            operation = replace(
                operation, side_load=operation.side_load + aside, radial_load=operation.radial_load - down
            )
        return replace(operation, mounting=HELD)

    @cached_property
    def static_load(self) -> float:
        """At t = 0, weight of shaft and ring included, N."""
        operation = self.on_bearing
        down = operation.radial_load + operation.inner_mass * operation.gravity
        return load_factor(self.bearing) * float(np.hypot(operation.side_load, down))

    @cached_property
    def cycle(self) -> DutyCycle | None:
        """Given, or of a load or speed that changes with time."""
        if self.options.run is not None:
            return self.options.run.cycle
        if self.options.cycle is not None or self.history is None or self.history.is_steady:
            return self.options.cycle
        time = 1e-3 * self.scene.numerics.duration_ms * (np.arange(INSTANTS) + 0.5) / INSTANTS
        (x, y), (inner, outer) = self.history.force(time), self.history.ring_speeds(time)
        weight = self.operation.inner_mass * self.operation.gravity
        load = load_factor(self.bearing) * np.hypot(
            np.broadcast_to(x, time.shape), np.broadcast_to(y, time.shape) - weight
        )
        speeds = np.broadcast_to(np.asarray(inner - outer) / RPM, time.shape)
        if not speeds.any():
            raise Unavailable("the bearing does not turn")
        return DutyCycle(loads=load, speeds=speeds, shares=np.ones(INSTANTS))

    @cached_property
    def load(self) -> float:
        """P, N."""
        return self.static_load if self.cycle is None else self.cycle.load_by(self.exponent)

    @cached_property
    def largest_load(self) -> float:
        """P0, N."""
        return self.static_load if self.cycle is None else self.cycle.largest_load

    @cached_property
    def rpm(self) -> float:
        """Of one ring against the other."""
        return abs(self.relative_speed) / RPM if self.cycle is None else self.cycle.speed

    @property
    def relative_speed(self) -> float:
        """Of the inner ring against the outer one at the start, rad/s."""
        return self.operation.speed - self.operation.outer_speed

    @cached_property
    def viscosity(self) -> float:
        """Kinematic, mm²/s."""
        if self.options.viscosity is not None:
            return self.options.viscosity
        if self.scene.lubricant is None:
            raise Unavailable("no viscosity: the scene has no [lubricant]; or give --viscosity in mm²/s")
        return 1e6 * self.scene.lubricant.viscosity_Pa_s / self.options.oil_density

    @cached_property
    def kappa(self) -> float:
        return self.viscosity / reference_viscosity(self.rpm, self.basic.pitch)

    @cached_property
    def contamination(self) -> float:
        given = self.options.contamination
        return contamination_factor(self.kappa, self.basic.pitch) if given is None else given

    @cached_property
    def a_iso(self) -> float:
        ratio = self.contamination * self.basic.fatigue / self.some_load
        return life_modification(self.kappa, ratio, self.balls)

    @cached_property
    def axial(self) -> Axial | None:
        return self.scene.ideal_axial()

    @cached_property
    def profile(self) -> bool | np.ndarray:
        """As `rigid_loads` takes it: the standard's without [axial]."""
        if self.axial is None:
            return True
        axial, z = self.axial, 1e-3 * positions(self.row)
        drops = [each.drop(z, self.bearing) for each in (axial.roller, axial.inner_raceway, axial.outer_raceway)]
        return 1e3 * (2.0 * drops[0] + drops[1] + drops[2])

    def rigid_at(
        self, first: float = 0.0, slope: float | None = None, profile: bool | None = None, load: float | None = None
    ) -> LaminaLoads:
        """The standard's load distribution, roller 0 at an angle from the load, rad.

        `slope` : rad, of the shaft, `profile` : of `rigid_loads`; None: the scene's; `load` : N, None: P
        """
        return rigid_loads(
            self.row, self.section_load if load is None else load / load_factor(self.bearing),
            2e3 * self.bearing.radial_clearance,
            self.operation.misalignment if slope is None else slope,
            profile=self.profile if profile is None else profile, first=first,
        )  # fmt: skip

    @cached_property
    def rigid(self) -> LaminaLoads:
        """The standard's load distribution."""
        return self.rigid_at()

    @property
    def some_load(self) -> float:
        """P, N, above 0."""
        return positive(self.load, "no load on the rollers")

    @property
    def section_load(self) -> float:
        """What P is of one row's section, N: P/(i cos α)."""
        return self.some_load / load_factor(self.bearing)

    @cached_property
    def rigid_pitch(self) -> np.ndarray:
        """The same at further angles of the cage, (n_rollers · POSITIONS, n_laminae), N."""
        firsts = 2.0 * pi / self.row.rollers * np.arange(POSITIONS) / POSITIONS
        return np.concatenate([self.rigid_at(at).loads for at in firsts])

    @cached_property
    def elastic(self) -> Pitch:
        return self.elastic_under(self.on_bearing)

    def elastic_under(self, operation: Operation, samples: int = SAMPLES) -> Pitch:
        mounting = self.scene.mounting()
        if mounting.points is not None or mounting.bore is not None:
            raise Unavailable("[support]: elastic rings need an outer ring held all around")
        if self.axial is not None:
            return self.tilted_under(operation, elastic=True).pitch
        return self.plane_under(operation, True, samples)

    @cached_property
    def lagrangian(self) -> Pitch:
        return self.lagrangian_under(self.on_bearing)

    def lagrangian_under(self, operation: Operation, samples: int = SAMPLES) -> Pitch:
        if self.axial is not None:
            return self.tilted_under(operation, elastic=False).pitch
        return self.plane_under(operation, False, samples)

    def plane_under(self, operation: Operation, elastic: bool, samples: int) -> Pitch:
        """Equilibria with parallel axes, by elastic rings, or rigid ones on the scene's contact law."""
        damping = self.scene.damping.contacts
        bearing = under_films(self.scene.perfect_bearing(), self.scene.films(operation))
        if elastic:
            from fem.rating.elastic import elastic_pitch

            return elastic_pitch(bearing, operation, damping, samples)
        try:
            return lagrangian_pitch(bearing, operation, self.laws, damping, samples)
        except RuntimeError as error:
            raise Unavailable(str(error)) from None

    def tilted_under(self, operation: Operation, elastic: bool, axial: Axial | None = None) -> "TiltedPitch":
        """Equilibria with rollers that tilt, by elastic rings, or rigid ones on the scene's contact law."""
        from fem.rating.tilted import tilted_pitch

        axial = axial or self.axial or refuse(PLANE)
        return tilted_pitch(self.bearing, axial, operation, None if elastic else self.laws)

    @cached_property
    def tilted(self) -> "TiltedPitch":
        """By the contacts of the scene's model."""
        return self.tilted_under(self.on_bearing, elastic=self.scene.model != "lagrange")

    def lives_by_slope(self) -> dict[str, float]:
        """L10r, 10⁶ revolutions, by misalignment in mrad."""
        if self.axial is None:
            raise Unavailable(PLANE)
        return {f"{mrad:g} mrad": self.reference_life(self.rigid_at(slope=1e-3 * mrad).loads)
                for mrad in SLOPES}  # fmt: skip

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
    def pitch(self) -> Pitch:
        """By the contacts of the scene's model."""
        return self.lagrangian if self.scene.model == "lagrange" else self.elastic

    @property
    def contacts(self) -> str:
        """Which those are, in words."""
        law = f"rigid rings on the contact law {self.scene.lagrange.law}"
        return law if self.scene.model == "lagrange" else "elastic rings and rollers"

    @property
    def line_contacts(self) -> tuple[Pair, Pair, Pair]:
        if isinstance(self.bearing, BallBearing):
            raise Unavailable("stresses and films are those of line contacts; this bearing has balls")
        return contact_pairs(self.bearing)

    @cached_property
    def stressed(self) -> dict[str, LineContact]:
        """The most loaded contact of each raceway over the pitch."""
        pairs = self.line_contacts
        if self.axial is not None:
            peaks = self.tilted.peaks
            return {pair.kind: line_contact(pair, peaks[pair.kind]) for pair in pairs[:2]}
        forces = self.pitch.inner_force.max(), self.pitch.outer_force.max()
        return {pair.kind: line_contact(pair, float(q)) for pair, q in zip(pairs, forces, strict=False)}

    @cached_property
    def peak_pressure(self) -> float:
        """Largest Hertz pressure of any contact over the pitch, Pa."""
        if isinstance(self.bearing, BallBearing):
            return max(
                ball_pressure(self.bearing, "inner", float(self.pitch.inner_force.max())),
                ball_pressure(self.bearing, "outer", float(self.pitch.outer_force.max())),
            )
        return max(each.peak_pressure for each in self.stressed.values())

    @cached_property
    def film(self) -> float:
        """Least thickness at either raceway, m."""
        if self.scene.lubricant is None:
            raise Unavailable("no film: the scene has no [lubricant]")
        _ = self.line_contacts
        forces = float(self.pitch.inner_force.max()), float(self.pitch.outer_force.max())
        speeds, oil = (self.relative_speed, 0.0), self.scene.lubricant.lubricant()
        found = film_thicknesses(self.bearing, speeds, forces, oil) if min(forces) > 0.0 else ()
        if not found:
            raise Unavailable("the bearing does not turn or carries no load: no film forms")
        return min(found)

    @property
    def diameters(self) -> tuple[float, float]:
        """d and D, mm; of a solid shaft its own."""
        return 2e3 * (self.bearing.bore_radius or self.bearing.inner_raceway_radius), 2e3 * self.bearing.outside_radius

    @cached_property
    def torques(self) -> dict[str, Torque]:
        return {"skf": self.torque(skf_torque, self.rpm), "palmgren": self.torque(palmgren_torque, self.rpm)}

    def torque(self, model: Callable[..., Torque], rpm: float) -> Torque:
        caged_cylinders(self.row)
        series = dimension_series(self.scene.bearing.designation)
        return model(*self.diameters, self.load, rpm, self.viscosity, series)

    @cached_property
    def losses(self) -> dict[str, float]:
        """W."""
        return {name: power_loss(torque.total, self.rpm) for name, torque in self.torques.items()}

    @cached_property
    def conductance(self) -> float:
        """W/K."""
        width, known = self.options.width, listed(self.scene.bearing.designation)
        if width is None and known is not None:
            width = width_of(known[0])
        if width is None:
            raise Unavailable("the bearing's width is not known: no designation; give --width in mm")
        return conductance(*self.diameters, width)

    @cached_property
    def spinning_loss(self) -> float:
        """Of clearance by the inner ring and the rollers as they grow with speed, µm."""
        if any(material.rigid for material in (self.bearing.roller, self.bearing.inner_ring)):
            return 0.0
        motion = kinematics(self.bearing, *self.operation.ring_speeds)
        inner, roller = growths(self.bearing, motion)
        return 2e6 * (inner + 2.0 * roller - outer_growth(self.bearing, motion)) / self.bearing.cosine

    @cached_property
    def build_up(self) -> OperatingClearance:
        """Of the scene's [fit]."""
        found = self.scene.operating_clearance()
        return refuse(NO_FIT) if found is None else found

    @cached_property
    def clearance_parts(self) -> dict[str, float | None]:
        """µm."""
        if self.scene.fit is not None:
            return {name: round(1e6 * part, 6) for name, part in self.build_up.parts.items()}
        return {
            "given": round(2e6 * self.scene.perfect_bearing().radial_clearance / self.bearing.cosine, 6) + 0.0,
            "shaft_fit": None,
            "housing_fit": None,
            "temperature": None,
            "speed": -self.spinning_loss,
            "film": 1e6 * self.scene.film_loss() / self.bearing.cosine,
        }

    @property
    def run(self) -> RunLoads:
        return self.options.run or refuse(NO_RUN)

    def at_hub(self) -> np.ndarray:
        """Of the hub against the ground, N/m: bearing and housing behind each other, beside the shaft's springs."""
        mounting, factor = self.scene.mounting(), stiffness_factor(self.bearing)
        if mounting.housing is None and mounting.shaft is None:
            raise Unavailable("the scene has neither a housing nor a shaft on springs")
        found = self.pitch.mean if mounting.housing is None else self.with_housing()
        return found + (0.0 if mounting.shaft is None else factor * mounting.shaft.stiffness) * np.eye(2)

    def with_housing(self) -> np.ndarray:
        housing = self.scene.mounting().housing
        if housing is None:
            raise Unavailable("the scene has no [support] with a housing on springs")
        return in_series(self.pitch.mean, stiffness_factor(self.bearing) * housing.stiffness * np.eye(2))

    def frequencies(self) -> list[float]:
        """Of the hub on its linearised mean stiffness, Hz."""
        values = np.linalg.eigvalsh(self.pitch.mean)
        if not values[0] > 0.0:
            raise Unavailable("the mean stiffness is positive in one direction at most")
        mass = stiffness_factor(self.bearing) * self.operation.inner_mass
        return [sqrt(value / mass) / (2.0 * pi) for value in values]

    def lambda_ratio(self) -> float:
        if self.options.roughness is None:
            raise Unavailable("no roughness of the surfaces: give --roughness, rms of both together, in µm")
        return 1e6 * self.film / self.options.roughness

    def elastic_life(self) -> float:
        acting = self.on_bearing
        if self.cycle is not None:
            weight = self.operation.inner_mass * self.operation.gravity
            acting = replace(acting, side_load=0.0, radial_load=self.load / load_factor(self.bearing) - weight)
        if self.axial is not None:  # slices alone, which the standard's factor of edges is made for
            alone = replace(self.axial, slices=LAMINAE, coupling=False)
            return self.reference_life(*self.tilted_under(acting, True, alone).loads)
        pitch = self.elastic if self.cycle is None else self.elastic_under(acting)
        inner, outer = (shared_out(self.row, q) for q in (pitch.inner_force, pitch.outer_force))
        return self.reference_life(inner, outer)

    def reference_life(self, inner: np.ndarray, outer: np.ndarray | None = None) -> float:
        """L10r, 10⁶ revolutions, under loads of laminae, N."""
        mounting = self.scene.mounting()
        if mounting.points is not None or mounting.bore is not None:
            raise Unavailable("[support]: the outer ring bends, and L10r assumes rigid rings")
        if self.oscillation:
            raise Unavailable(f"{self.oscillation}: no ring turns relative to the load, which L10r assumes")
        return reference_life(self.row, dynamic_capacity(self.row), inner, outer, turning=self.turning)

    def modified_life(self) -> float:
        return in_hours(reliability_factor(self.options.reliability) * self.a_iso * self.basic_life(), self.rpm)


def refuse(reason: str) -> Any:
    raise Unavailable(reason)


def positive(load: float, else_what: str) -> float:
    """The load, N. Unavailable: there is none."""
    if not load > 0.0:
        raise Unavailable(f"without load {else_what}")
    return load
