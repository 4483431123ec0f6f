"""Draws docs/profiles.png from studies/profiles: largest pressure and life over the crown of rollers, by slope."""

from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

with h5py.File("studies/profiles/study.nc") as file:
    data = {name: values[...] for name, values in file.items()}
slopes, crown = data["misalignment_mrad"], data["crown_um"]  # the datasets' second dimension, and the first
panels = (
    (1e-6 * data["rating_peak_pressure"], "largest pressure, MPa"),
    (1e-9 * data["rating_life"], "L10r, 10⁹ revolutions"),
    (data["rating_moment"], "moment on the shaft, N m"),
)
figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.4), layout="constrained")
for axis, (values, title) in zip(axes, panels, strict=True):
    for k, slope in enumerate(slopes):
        axis.plot(crown, values[:, k], "o-", color=plt.cm.viridis(k / (len(slopes) - 0.5)), label=f"{slope:g} mrad")
    axis.set(xlabel="crown, µm", title=title, ylim=(0.0 if "MPa" not in title else None, None), xlim=(0.0, None))
    axis.grid(color="#E3E3E3")
axes[1].legend(fontsize=8)
figure.savefig(Path(__file__).parents[1] / "profiles.png", dpi=110)
for values, title in panels:
    print(f"{title}: crowns down, slopes across")
    print(np.round(values, 1))
