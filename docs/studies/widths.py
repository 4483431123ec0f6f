"""Draws docs/widths.png from studies/widths: the line of an outer ring's spall over its width."""

from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

G = 9.80665  # m/s²
RELEASED = {750.0: 0.33, 3000.0: 0.67, 12000.0: 1.1}  # mm, from which on a roller loses all of its load in the spall
PITCH, ROLLER, ROLLERS = 46.5, 9.0, 13  # mm, of NU206

with h5py.File("studies/widths/study.nc") as file:
    widths, loads, sensors = (file[name][...] for name in ("width_mm", "radial_load_N", "frequency_Hz"))
    level, passing = file["sensor_bpfo"][...], file["BPFO_Hz"][...]
speed = 1e-3 * 3.1416 * (PITCH + ROLLER) * passing.mean() / ROLLERS  # m/s, of a contact along the outer raceway
figure, axes = plt.subplots(1, 2, figsize=(10.0, 3.8), layout="constrained")
for axis, k in zip(axes, (1, 0), strict=True):
    for j, load in enumerate(loads):
        colour = plt.cm.viridis(j / (len(loads) - 0.5))
        axis.plot(widths, level[:, j, k] / G, "o-", color=colour, label=f"{load:.0f} N", markersize=4)
        axis.axvline(RELEASED[load], color=colour, linestyle=":", linewidth=1.2)
    axis.set(xlabel="width of the spall, mm", xlim=(0.0, 3.1), ylim=(0.0, None))
    axis.set_title(f"sensor of {1e-3 * sensors[k]:g} kHz: contacts run {1e3 * speed / sensors[k]:.2f} mm in its period")
    axis.grid(color="#E3E3E3")
axes[0].set_ylabel("BPFO of the sensor's envelope, g")
axes[1].legend(fontsize=9)
figure.savefig(Path(__file__).parents[1] / "widths.png", dpi=110)
print("BPFO, g: widths down; loads across, for each sensor")
for row, width in zip(level, widths, strict=True):
    print(f"{width:5.2f}  {'  '.join(f'{value / G:6.3f}' for value in row.T.ravel())}")
