"""Draws docs/studies.png from studies/clearance: stiffness, load zone and the error of Harris' law."""

from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

with h5py.File("studies/clearance/study.nc") as file:
    data = {name: values[...] for name, values in file.items()}
loads = data["radial_load_N"]  # the datasets' second dimension; the first: clearance_um
share = 100.0 * data["error_mean_y"] / loads
panels = (
    (1e-6 * data["static_stiffness"], "radial stiffness, N/µm"),
    (np.degrees(data["load_zone"]), "load zone, degrees"),
    (share, "error of Harris' law, % of the load"),
)
figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.4), layout="constrained")
for axis, (values, title) in zip(axes, panels, strict=True):
    for k, load in enumerate(loads):
        colour = plt.cm.viridis(k / (len(loads) - 0.5))
        axis.plot(data["clearance_um"], values[:, k], "o-", color=colour, label=f"{load:.0f} N")
    axis.set(xlabel="diametral clearance, µm", title=title)
    axis.grid(color="#E3E3E3")
axes[2].legend(fontsize=8)
figure.savefig(Path(__file__).parents[1] / "studies.png", dpi=110)
for values, title in panels:
    print(f"{title}: clearances down, loads across")
    print(np.round(values, 1))
