"""The envelope line of a measured bearing with a spall on its outer ring: `python -m tests.accuracy.measured_bearing`.

Rexnord ZA-2115 of the IMS rig: 16 rollers of 8.407 mm on a pitch of 71.501 mm, contact angle α = 15.17°, 2000 rpm,
6000 lb. The record has its envelope line at 236.0 Hz, kinematics of the contact angle at 236.40 Hz.

The scene has the catalogue's sizes: `contact_angle_deg` and `pitch_diameter_mm` make its plane section. Of the 6000
lb, which act on a shaft with four bearings, two between two others, each takes 3000 lb. What the rig's papers leave out
is assumed: two rows of rollers 10 mm long, rings 10 mm thick, 2 kg at the hub, a spall of 0.5 mm, and 20 µm of radial
preload. Preload takes the place of the cage that the model lacks: without either, rollers lag in the unloaded half,
0.6 % on the average of all.

Source: Lee, Qiu, Yu, Lin, Bearing data set, IMS, University of Cincinnati, NASA Prognostics Data Repository (2007).
"""

from dataclasses import replace
from math import cos, radians

import numpy as np
from scipy.signal import decimate

from fem.solver.simulate import make_plan
from lagrange.kinematics import kinematics
from lagrange.scene.scene import Scene, read_scene
from residual.spectrum import kinematic_lines
from residual.vibration import Vibration, vibration
from tests.accuracy.reduced import found

ROLLERS, DIAMETER, PITCH, CONTACT_ANGLE = 16, 8.4074, 71.501, 15.17  # mm and degrees
MEASURED = 236.0  # Hz
RATE = 20_480.0  # of the record, samples per second
FINER = 10  # times that rate a run is sampled at; filtered and thinned out to it as the record was
HARMONICS = (0.62, 0.36, 0.24)  # measured, second to fourth over the first
SPAN = 8.0  # Hz on either side in which a line is looked for


def plane_scene(seconds: float, preload_um: float) -> Scene:
    """The bearing with a radial preload."""
    across = DIAMETER * cos(radians(CONTACT_ANGLE))
    return read_scene(None, (
        "model=reduced", f"bearing.rollers={ROLLERS}", f"bearing.roller_diameter_mm={DIAMETER}", "bearing.rows=2",
        f"bearing.pitch_diameter_mm={PITCH}", f"bearing.contact_angle_deg={CONTACT_ANGLE}",
        f"bearing.clearance_um={-2.0 * preload_um!r}", "bearing.roller_length_mm=10",
        f"bearing.bore_diameter_mm={PITCH - across - 20.0!r}",
        f"bearing.outside_diameter_mm={PITCH + across + 20.0!r}", "operation.speed_rpm=2000",
        "operation.radial_load_N=13345", "operation.inner_ring_and_shaft_kg=2",
        "spall.0.body=outer_ring", "spall.0.width_mm=0.5",
        f"numerics.duration_ms={1e3 * seconds}", f"numerics.output_interval_us={1e6 / (FINER * RATE)!r}",
    ))  # fmt: skip


def hub_vibration(seconds: float, preload_um: float) -> tuple[Vibration, float]:
    """As the report's section has it, vertical; and the run's own BPFO, Hz, by its rollers' angles."""
    scene = plane_scene(seconds, preload_um)
    run = found(make_plan(scene)).values
    ideal = kinematics(scene.ideal_bearing(), scene.ideal_operation().speed)
    theta, time = run["roller_theta"], run["time"]
    cage = float(np.mean(theta[-1] - theta[0])) / (time[-1] - time[0])
    lines = kinematic_lines(replace(ideal, cage=cage))
    acceleration = decimate(run["inner_ay"], FINER, ftype="fir")
    return vibration(acceleration, 1.0 / RATE, lines), lines["BPFO"]


def line(measured: Vibration, near: float) -> tuple[float, float]:
    """Place, Hz, and height of the highest line near a frequency; between bins by a parabola through three of them."""
    spectrum = measured.envelope.spectrum
    chosen = np.flatnonzero(np.abs(spectrum.frequency - near) < SPAN)
    k = chosen[np.argmax(spectrum.psd[chosen])]
    low, top, high = np.log(spectrum.psd[k - 1 : k + 2])
    beyond = 0.5 * (low - high) / (low - 2.0 * top + high)
    return float(spectrum.frequency[k] + beyond * spectrum.resolution), float(np.sqrt(spectrum.psd[k]))


def main() -> None:
    """Print the line and its harmonics."""
    print(f"measured {MEASURED:g} Hz; harmonics over the first {', '.join(f'{share:g}' for share in HARMONICS)}")
    for preload_um in (20.0, 0.0):
        measured, rolling = hub_vibration(0.6, preload_um)
        lines = [line(measured, k * rolling) for k in range(1, 5)]
        shares = ", ".join(f"{height / lines[0][1]:.2f}" for _, height in lines[1:])
        bpfo = next(each for each in measured.lines if each.name == "BPFO")
        print(
            f"preload {preload_um:g} µm: {lines[0][0]:.2f} Hz, {bpfo.ratio:.3g} times its floor, rollers pass at "
            f"{rolling:.2f} Hz; harmonics {shares}"
        )


if __name__ == "__main__":
    main()
