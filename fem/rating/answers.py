"""Every number that a machine's designer asks of a bearing, with its unit, meaning and source; null with a reason."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from math import nan, pi, sin
from typing import Any

import numpy as np

from fem.rating.case import NO_FIT, TILTS, Case, Options, positive, refuse
from lagrange.contact.hertz import FATIGUE, PERMITTED, PERMITTED_OF_BALLS, LineContact
from lagrange.rating import sources
from lagrange.rating.life import (
    in_hours,
    reference_viscosity,
    reliability_factor,
    speed_warning,
)
from lagrange.rating.sources import Source, Unavailable
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene

ALLOWED_SLOPE = 4.0 / 60.0 * pi / 180.0  # rad, of cylindrical roller bearings of narrow series by makers' catalogues


@dataclass(frozen=True, kw_only=True)
class Answer:
    """One number, or some that belong together; `value` None where there is none, and then `reason` says why."""

    name: str
    value: Any
    unit: str
    meaning: str
    source: Source
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class Rating(Mapping[str, Any]):
    """Values by name; `answers` have units and sources beside them."""

    scene: Scene
    answers: tuple[Answer, ...]
    warnings: tuple[str, ...]
    case: Case

    def __getitem__(self, name: str) -> Any:
        return self.answer(name).value

    def __iter__(self) -> Iterator[str]:
        return iter(answer.name for answer in self.answers)

    def __len__(self) -> int:
        return len(self.answers)

    @property
    def name(self) -> str:
        return self.case.options.name or self.scene.name

    def answer(self, name: str) -> Answer:
        """KeyError: there is none of that name."""
        for answer in self.answers:
            if answer.name == name:
                return answer
        raise KeyError(name)

    @property
    def clearances(self) -> list[tuple[str, float | None]]:
        return list(self["operating_clearance_parts_um"].items())

    def to_json(self) -> dict[str, Any]:
        """Values, and by their names the reasons of those that are null, and the sources."""
        return {
            **{answer.name: _plain(answer.value) for answer in self.answers},
            "warnings": list(self.warnings),
            "reasons": {answer.name: answer.reason for answer in self.answers if answer.reason}
            | {f"operating_clearance_parts_um.{name}": NO_FIT for name, part in self.clearances if part is None},
            "sources": {
                answer.name: {
                    "source": f"{answer.source.name}: {answer.source.text}",
                    "second_hand": answer.source.second_hand or None,
                }
                for answer in self.answers
            },
        }


_Declared = tuple[str, str, str, Source, Callable[[Case], Any]]
s = sources
DECLARED: tuple[_Declared, ...] = (
    ("C_N", "N", "basic dynamic load rating C", s.DYNAMIC, lambda c: c.basic.dynamic),
    ("C0_N", "N", "basic static load rating C0", s.STATIC, lambda c: c.basic.static),
    ("Cu_N", "N", "fatigue load limit C_u", s.FATIGUE, lambda c: c.basic.fatigue),
    ("P_N", "N", "equivalent dynamic load P{weight}", s.LOAD, lambda c: c.load),
    ("P0_N", "N", "equivalent static load P0", s.STATIC, lambda c: c.largest_load),
    ("s0", "1", "static safety factor", s.STATIC,
     lambda c: c.basic.static / positive(c.largest_load, "infinite")),
    ("speed_rpm", "1/min", "relative ring speed (mean over the duty cycle)", s.LOAD, lambda c: c.rpm),
    ("L10_Mrev", "Mrev", "basic rating life L10", s.LIFE, lambda c: c.basic_life()),
    ("L10_h", "h", "basic rating life L10", s.LIFE,
     lambda c: in_hours(c.basic_life(), c.rpm)),
    ("a1", "1", "reliability factor a1", s.RELIABILITY, lambda c: reliability_factor(c.options.reliability)),
    ("nu_mm2_s", "mm²/s", "kinematic viscosity in operation", s.VISCOSITY, lambda c: c.viscosity),
    ("nu1_mm2_s", "mm²/s", "reference viscosity ν1", s.VISCOSITY, lambda c: reference_viscosity(c.rpm, c.basic.pitch)),
    ("kappa", "1", "viscosity ratio κ", s.VISCOSITY, lambda c: c.kappa),
    ("e_C", "1", "contamination factor e_C", s.CONTAMINATION, lambda c: c.contamination),
    ("a_ISO", "1", "life modification factor a_ISO", s.A_ISO, lambda c: c.a_iso),
    ("Lnm_h", "h", "modified rating life a1 a_ISO L10", s.A_ISO, lambda c: c.modified_life()),
    ("L10r_Mrev", "Mrev", "reference rating life L10r, rigid rings", s.REFERENCE,
     lambda c: c.reference_life(c.rigid.loads)),
    ("L10r_pitch_Mrev", "Mrev", "L10r, rigid rings, mean over a pitch", s.REFERENCE,
     lambda c: c.reference_life(c.rigid_pitch)),
    ("L10r_elastic_Mrev", "Mrev", "L10r, elastic rings, mean over a pitch", s.LOAD_SHARING,
     lambda c: c.elastic_life()),
    ("L10r_run_Mrev", "Mrev", "L10r, roller loads of the run", s.OF_RUN,
     lambda c: c.run.life(c.row, c.axial is not None)),
    ("Lnmr_h", "h", "modified reference rating life Lnmr", s.REFERENCE,
     lambda c: refuse("not implemented: no source for the equivalent load of a lamina")),
    ("peak_pressure_MPa", "MPa", "largest Hertz pressure", s.HERTZ, lambda c: 1e-6 * c.peak_pressure),
    ("contacts", "", "most loaded contact of each raceway", s.HERTZ,
     lambda c: {name: _stresses(each) for name, each in c.stressed.items()}),
    ("pressure_over_permitted", "1", "peak pressure / ISO 76's limit", s.STRESS_LIMITS,
     lambda c: c.peak_pressure / (PERMITTED_OF_BALLS if c.balls else PERMITTED)),
    ("pressure_over_fatigue", "1", "peak pressure / 1500 MPa (fatigue limit)", s.STRESS_LIMITS,
     lambda c: c.peak_pressure / FATIGUE),
    ("roller_loads_N", "N", "roller loads at the first angle, rigid rings", s.REFERENCE,
     lambda c: c.rigid.of_rollers),
    ("operating_clearance_um", "µm", "diametral clearance in operation", s.CLEARANCE,
     lambda c: sum(part for part in c.clearance_parts.values() if part is not None)),
    ("operating_clearance_parts_um", "µm", "parts of that clearance", s.CLEARANCE, lambda c: c.clearance_parts),
    ("fit_pressure_MPa", "MPa", "fit pressure in operation", s.FITS,
     lambda c: {"shaft": 1e-6 * c.build_up.shaft_pressure, "housing": 1e-6 * c.build_up.housing_pressure}),
    ("stiffness_N_per_m", "N/m", "stiffness kxx, kxy; kyx, kyy, mean over a pitch", s.LINEARISED,
     lambda c: c.pitch.mean),
    ("stiffness_range_N_per_m", "N/m", "stiffness, lowest and highest of each entry", s.LINEARISED,
     lambda c: c.pitch.range),
    ("stiffness_harmonics_N_per_m", "N/m", "stiffness, amplitudes at 1, 2 ... times the ball pass frequency",
     s.LINEARISED, lambda c: c.pitch.harmonics),
    ("stiffness_contacts", "", "contacts of that stiffness", s.LINEARISED, lambda c: (c.pitch, c.contacts)[1]),
    ("stiffness_with_housing_N_per_m", "N/m", "stiffness in series with the housing's springs", s.LINEARISED,
     lambda c: c.with_housing()),
    ("misalignment_mrad", "mrad", "slope of the shaft, +z end towards the load", s.TILTED,
     lambda c: 1e3 * c.tilted.slope),
    ("tilting_moment_N_m", "N m", "moment needed for that misalignment, mean over a pitch", s.TILTED,
     lambda c: c.tilted.moment),
    ("hub_stiffness_N_per_m", "N/m", "hub stiffness including springs of housing and shaft", s.LINEARISED,
     lambda c: c.at_hub()),
    ("tilt_stiffness_N_m_per_rad", "N m/rad", "stiffness against tilting at constant load, mean over a pitch",
     s.TILTED, lambda c: c.tilted.tilt_stiffness),
    ("stiffness_with_tilt", "N/m, N, N m", "stiffness matrix of x, y and slopes in x, y, mean over a pitch", s.TILTED,
     lambda c: c.tilted.stiffness),
    ("L10r_by_misalignment_Mrev", "Mrev", "L10r, rigid rings, by misalignment", s.REFERENCE,
     lambda c: c.lives_by_slope()),
    ("damping_N_s_per_m", "N s/m", "damping of the contacts, mean over a pitch", s.LINEARISED,
     lambda c: refuse(TILTS) if c.axial is not None
     else c.pitch.damping.mean(axis=0) if c.scene.damping.contacts.acts
     else refuse("the scene has no [damping] of contacts")),
    ("hub_frequencies_Hz", "Hz", "natural frequencies of the hub on its contacts", s.LINEARISED,
     lambda c: c.frequencies()),
    ("hub_um", "µm", "hub position x, y at speed, mean over a pitch", s.LINEARISED,
     lambda c: 1e6 * c.pitch.place.mean(axis=0)),
    ("film_um", "µm", "minimum film thickness of both raceways", s.FILM,
     lambda c: 1e6 * c.film),
    ("lambda", "1", "film thickness / roughness, λ", s.FILM, lambda c: c.lambda_ratio()),
    ("friction_torque_N_mm", "N mm", "frictional torque, ±30 %", s.BOTH_FRICTIONS,
     lambda c: {name: torque.total for name, torque in c.torques.items()}),
    ("friction_torque_palmgren_N_mm", "N mm", "Palmgren's speed and load parts", s.PALMGREN,
     lambda c: {"speed": c.torques["palmgren"].rolling, "load": c.torques["palmgren"].sliding}),
    ("friction_torque_run_N_mm", "N mm", "torque from the run's dissipation (friction and damping of contacts only)",
     s.OF_RUN, lambda c: 1e3 * c.run.torque),
    ("dissipated_run_W", "W", "power dissipated in the run", s.OF_RUN, lambda c: c.run.dissipated),
    ("power_loss_W", "W", "heat, ±30 %", s.BOTH_FRICTIONS, lambda c: c.losses),
    ("temperature_rise_K", "K", "temperature above the surroundings, first estimate", s.HEAT,
     lambda c: {name: loss / c.conductance for name, loss in c.losses.items()}),
)  # fmt: skip


def _stresses(contact: LineContact) -> dict[str, float]:
    return {
        "peak_pressure_MPa": 1e-6 * contact.peak_pressure,
        "half_width_um": 1e6 * contact.half_width,
        "largest_shear_MPa": 1e-6 * contact.largest_shear,
        "shear_depth_um": 1e6 * contact.shear_depth,
        "largest_von_mises_MPa": 1e-6 * contact.largest_von_mises,
        "von_mises_depth_um": 1e6 * contact.von_mises_depth,
    }


def _plain(value: Any) -> Any:
    """For JSON: arrays as lists, what is infinite or no number as null."""
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def rating(scene: Scene, options: Options | None = None) -> Rating:
    """All answers to a scene.

    Example
    -------
    rating(Scene(bearing={"designation": "NU206"}))["C_N"]
    """
    case = Case(scene, options or Options())
    found = [_answer(case, *declared) for declared in DECLARED]
    answers = tuple(found)
    return Rating(scene=scene, answers=answers, warnings=tuple(_warnings(case, answers)), case=case)


def values_of(scene: Scene, names: Collection[str]) -> dict[str, float]:
    """Some answers to a scene that are one number each, without computing the others; NaN of what is unavailable."""
    case = Case(scene, Options())
    found = (_answer(case, *declared) for declared in DECLARED if declared[0] in names)
    return {answer.name: nan if answer.value is None else float(answer.value) for answer in found}


def _answer(case: Case, name: str, unit: str, meaning: str, source: Source, compute: Callable[[Case], Any]) -> Answer:
    value, reason = None, ""
    try:
        value = compute(case)
    except Unavailable as error:
        reason = str(error)
    weight = "" if case.options.cycle is not None else ", weight included"  # loads of a file are taken as they stand
    meaning = meaning.format(weight=weight)
    return Answer(name=name, value=value, unit=unit, meaning=meaning, source=source, reason=reason)


def _warnings(case: Case, answers: tuple[Answer, ...]) -> Iterator[str]:
    values = {answer.name: answer.value for answer in answers}
    if values["stiffness_N_per_m"] is not None and not case.pitch.is_stable:
        yield (
            "the stiffness across the load is not positive at every cage angle: the hub balances on single rollers, "
            "and the mean matrix is of little use; raise the load or reduce the clearance"
        )
    if values["s0"] is not None and values["s0"] < 1.0:
        yield f"static safety {values['s0']:.2f} is below 1: permanent dents in the raceways"
    if values["C_N"] is not None and (values["P_N"] or 0.0) > 0.5 * values["C_N"]:
        yield "P is beyond C/2, beyond the range of ISO 281's life formula"
    if values["C_N"] is not None and 0.0 < (values["P_N"] or 0.0) < 0.02 * values["C_N"]:
        yield "P is below 2 % of C: rollers may skid, and rating lives are of little use"
    if case.history is not None and not case.history.is_steady:
        yield "speed or load changes with time: stiffness, stresses and film are those at its start"
    if case.bearing.contact_angle and case.bearing.rows == 1 and values["stiffness_N_per_m"] is not None:
        axial = float(case.pitch.inner_force.sum(axis=1).mean()) * sin(case.bearing.contact_angle)
        yield (
            f"through the contact angle the radial load causes an axial force of {axial:.4g} N (Σ Q sin α), which "
            "another bearing must carry; external axial loads are not supported"
        )
    if case.oscillation:
        yield f"{case.oscillation}: L10 from the mean speed is of little use, and no lubricant is drawn in"
    if case.bearing.rows > 1 and values["C_N"] is not None and not case.balls:
        yield (
            f"rows = {case.bearing.rows} share the load equally, with b_m = 1.1 for cylindrical and tapered rollers; "
            "spherical roller bearings (b_m = 1.15) are not supported"
        )
    if abs(case.operation.misalignment) > ALLOWED_SLOPE:
        yield (
            f"a slope of {1e3 * case.operation.misalignment:.3g} mrad is beyond the 4 minutes of arc, "
            f"{1e3 * ALLOWED_SLOPE:.2g} mrad, that catalogues allow cylindrical rollers"
        )
    rpm = max(*(abs(speed) / RPM for speed in case.operation.ring_speeds), values["speed_rpm"] or 0.0)
    if fast := speed_warning(case.bearing, rpm):
        yield f"{fast}, and friction and temperature are extrapolated"
    if case.options.cycle is not None:
        yield (
            f"stiffness, stresses and film are those of the scene's load, {case.operation.radial_load:.4g} N, not of "
            f"the duty cycle, whose largest load is {case.options.cycle.largest_load:.4g} N"
        )
    if values["kappa"] is not None and values["kappa"] < 1.0:
        yield f"κ = {values['kappa']:.2g}: mixed lubrication, surfaces touch; a higher viscosity raises κ"
    if case.scene.damping.contacts.acts is False:
        yield "the scene has no contact damping: a rotor on these coefficients is undamped"
