"""Draws docs/studies.png from studies/clearance: stiffness, load zone and the error of Harris' law."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import xarray

data = xarray.open_dataset("studies/clearance/study.nc")
share = 100.0 * data.error_mean_y / data.radial_load_N
panels = (
    (1e-6 * data.static_stiffness, "radial stiffness, N/µm"),
    (np.degrees(data.load_zone), "load zone, degrees"),
    (share, "error of Harris' law, % of the load"),
)
figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.4), layout="constrained")
for axis, (values, title) in zip(axes, panels, strict=True):
    for k, load in enumerate(data.radial_load_N.values):
        colour = plt.cm.viridis(k / (data.sizes["radial_load_N"] - 0.5))
        axis.plot(data.clearance_um, values.sel(radial_load_N=load), "o-", color=colour, label=f"{load:.0f} N")
    axis.set(xlabel="diametral clearance, µm", title=title)
    axis.grid(color="#E3E3E3")
axes[2].legend(fontsize=8)
figure.savefig(Path(__file__).parents[1] / "studies.png", dpi=110)
print(share.round(1).to_pandas())
print((1e-6 * data.static_stiffness).round(0).to_pandas())
print(np.degrees(data.load_zone).round(0).to_pandas())
