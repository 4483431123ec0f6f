"""What a plan, and a run at its end, warns of: it is sound, but its numbers need care."""

from dataclasses import replace
from math import inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from lagrange import Bearing, Operation, contact_laws
from lagrange.bearing import CORE
from lagrange.kinematics import kinematics_met, roller_angles
from lagrange.limits import exceeds
from lagrange.rating.life import Basic, speed_warning
from lagrange.rating.sources import Unavailable
from lagrange.scene.faults import RPM
from lagrange.scene.scene import Scene
from lagrange.step_size import wave_interval
from lagrange.surface.faults import Spall
from lagrange.surface.passages import interval_warning

if TYPE_CHECKING:
    from fem.contacts.model import Model
    from fem.statics.equilibrium import Equilibrium

# Static load rating of roller bearings (ISO 76): at this Hertz pressure steel keeps a dent of 1e-4 of the diameter
ISO_76_PRESSURE = 4e9  # Pa
RIGID_CORE = (
    f"bearing.bore_diameter_mm = 0: the mesh has a rigid core in the solid shaft, {CORE:g} of its radius: the hub's "
    'displacement is off by up to 1 % and loads by up to 3 %; model = "reduced" has the whole shaft elastic'
)
WIDEST_CLEARANCE = 0.05  # of a roller's diameter: beyond C5 of ISO 5753-1, which is up to 0.04 (needles)
LIGHTEST = 1e-3  # of the static load rating: loads below are hardly meant, but for none at all
FEWEST_PASSAGES = 2.0  # of rollers, in a default duration
USUAL_TIME_US = 12.5  # of a contact's damping over its stiffness, as ROSS takes it; Krämer: 2.5 to 25 (docs/damping.md)


def plan_warnings(
    scene: Scene, model: "Model", operation: Operation, equilibrium: "Equilibrium", interval: float
) -> tuple[str, ...]:
    """Sentences; none where all is well. `interval` between samples, s."""
    found = (
        RIGID_CORE if scene.model == "fem" and model.bearing.bore_radius == 0.0 else None,
        _yield(model, equilibrium),
        _sampling(model, operation, equilibrium, interval),
        _edges(model, equilibrium),
    )
    return (*(sentence for sentence in found if sentence), *of_scene(scene, model.bearing, operation, interval))


def of_scene(scene: Scene, bearing: Bearing, operation: Operation, interval: float) -> tuple[str, ...]:
    """Sentences that follow from the scene alone, whatever the model."""
    found = (
        interval_warning(bearing, operation, interval),
        _waves(bearing, operation, interval),
        _undamped(scene, operation),
        _brief(scene, bearing, operation),
        _clearance(bearing),
        _light(scene, bearing, operation),
        speed_warning(bearing, operation.fastest / RPM),
    )
    return tuple(sentence for sentence in found if sentence)


def _clearance(bearing: Bearing) -> str | None:
    clearance, diameter = round(2.0 * bearing.radial_clearance, 9), 2.0 * bearing.element_radius
    if not exceeds(clearance, WIDEST_CLEARANCE * diameter):
        return None
    return (
        f"the operating clearance, {1e6 * clearance:.4g} µm, is {100.0 * clearance / diameter:.2g} % of a roller's "
        "diameter; group C5 of ISO 5753-1 has at most 4 %; is bearing.clearance_um in µm?"
    )


def _light(scene: Scene, bearing: Bearing, operation: Operation) -> str | None:
    load, mass = scene.operation.radial_load_N, scene.operation.inner_ring_and_shaft_kg
    if load == 0.0 or bearing.radial_clearance < 0.0 or operation.history is not None:
        return None
    try:
        rating = Basic.of(scene.unmounted_bearing()).static
    except Unavailable:
        return None
    if load + mass * scene.operation.gravity_m_s2 >= LIGHTEST * rating:
        return None
    return (
        f"operation.radial_load_N = {load:g} is below a thousandth of the static load rating, C0 = {1e-3 * rating:.3g} "
        "kN: rollers hardly touch; is it in N?"
    )


def _brief(scene: Scene, bearing: Bearing, operation: Operation) -> str | None:
    """A default duration in which hardly a roller passes the load."""
    seconds = 1e-3 * scene.numerics.duration_ms
    cage = float(np.abs(kinematics_met(bearing, operation).cage).max()) / (2.0 * pi)
    passages = bearing.n_rollers * cage * seconds
    if cage == 0.0 or passages >= FEWEST_PASSAGES or scene.is_given("numerics", "duration_ms"):
        return None
    return (
        f"numerics.duration_ms = {scene.numerics.duration_ms:g} (default) is {cage * seconds:.2g} turns of the cage, "
        f"too short for lines of the cage; one turn takes {1e3 / cage:.3g} ms"
    )


def _undamped(scene: Scene, operation: Operation) -> str | None:
    """Vibration that is excited again and again, and that nothing but friction takes energy from."""
    housing = operation.mounting.housing
    excited = {
        "[[spall]]": bool(scene.spall),
        "operation.load_table": scene.operation.load_table is not None,
        'support.kind = "housing"': housing is not None and housing.damping == 0.0,
    }
    named = [name for name, there in excited.items() if there]
    takes_none = (scene.model == "fem" and scene.contact.model != "subgrid") or scene.axial is not None
    if not named or scene.damping.acts or takes_none or scene.numerics.duration_ms == 0.0:
        return None
    return (
        f"{' and '.join(named)} without [damping]: excited vibration hardly decays; give damping.contact_time_us, e.g. "
        f"{USUAL_TIME_US:g}"
    )


def _yield(model: "Model", equilibrium: "Equilibrium") -> str | None:
    """The model is elastic at any pressure; steel is not."""
    worst, name, force = max(
        (law.pair.peak_pressure(float(forces.max())), law.pair.kind, float(forces.max()))
        for law, forces in ((model.inner_law, equilibrium.inner_force), (model.outer_law, equilibrium.outer_force))
    )
    if worst <= ISO_76_PRESSURE:
        return None
    return (
        f"the largest static force, {force:.4g} N on the {name} raceway, gives a Hertz pressure of {1e-6 * worst:.0f} "
        f"MPa, above ISO 76's {1e-6 * ISO_76_PRESSURE:.0f} MPa; real steel would yield; lower operation.radial_load_N, "
        "or the preload (a larger bearing.outer_raceway_diameter_mm)"
    )


def _sampling(model: "Model", operation: Operation, equilibrium: "Equilibrium", interval: float) -> str | None:
    bearing = model.bearing
    laws = contact_laws("johnson", bearing)
    inner, outer = (
        law.slope(law.approach(forces))
        for law, forces in ((laws.inner, equilibrium.inner_force), (laws.outer, equilibrium.outer_force))
    )
    loaded = (inner > 0.0) & (outer > 0.0)
    in_series = np.where(loaded, inner * outer / np.where(loaded, inner + outer, 1.0), 0.0)
    angle = roller_angles(bearing, operation.first_roller_angle)
    resonance = sqrt(float(np.sum(in_series * np.sin(angle) ** 2)) / operation.inner_mass) / (2.0 * pi)
    if 2.0 * resonance * interval < 1.0:
        return None
    return (
        f"numerics.output_interval_us = {1e6 * interval:g}: too coarse for the hub's vibration on its contacts, about "
        f"{1e-3 * resonance:.3g} kHz; check-residual needs less than {0.5e6 / resonance:.3g}"
    )


def _edges(model: "Model", equilibrium: "Equilibrium") -> str | None:
    """An edge that carries a contact has a far higher pressure than the raceway; the model stays elastic."""
    inner, outer = float(equilibrium.inner_force.max()), float(equilibrium.outer_force.max())
    on_body = {"inner_ring": inner, "outer_ring": outer, "roller": max(inner, outer)}
    spalls = [fault for fault in model.bearing.faults if isinstance(fault, Spall) and on_body[fault.body] > 0.0]

    def pressure_on(spall: Spall) -> float:
        radii = spall.edge_radius, model.bearing.roller_radius
        pair = replace(model.inner_law.pair, radii=radii) if spall.edge_radius > 0.0 else None
        return inf if pair is None else pair.peak_pressure(on_body[spall.body])

    worst = max(spalls, key=pressure_on, default=None)
    if worst is None or (pressure := pressure_on(worst)) <= ISO_76_PRESSURE:
        return None
    sharpest, force = worst.edge_radius, on_body[worst.body]
    size = "an unlimited pressure" if pressure == inf else f"{1e-6 * pressure:.0f} MPa"
    return (
        f"[[spall]] edge_radius_mm = {1e3 * sharpest:g}: under the largest static force, {force:.4g} N, the edge would "
        f"carry {size}, above ISO 76's {1e-6 * ISO_76_PRESSURE:.0f} MPa; real steel would yield"
    )


def _waves(bearing: Bearing, operation: Operation, interval: float) -> str | None:
    longest = wave_interval(bearing, operation)
    if interval <= longest:
        return None
    return (
        f"numerics.output_interval_us = {1e6 * interval:g}: too coarse to resolve a [[waviness]]; at most "
        f"{1e6 * longest:.3g}"
    )
