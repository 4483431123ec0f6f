# %% [markdown]
# # A notebook: from a bearing to its fault line
#
# Executed anew whenever this site is built; its source is `docs/notebook.py`, a script that Jupyter opens as a notebook
# (with jupytext). To run in Jupyter it needs a kernel.

# %%
import matplotlib.pyplot as plt
import numpy as np

from fem.interface import Scene, simulate, statics

# %% [markdown]
# ## Load zone and clearance
#
# How the paper's bearing shares 2000 N between its rollers, by how much room it has. `statics` gives the equilibrium
# that a run would start from; the reduced model knows elastic rollers and rings.

# %%
axes = plt.subplot(projection="polar", theta_offset=-np.pi / 2)
for clearance in (-10.0, 0.0, 20.0, 40.0):
    scene = Scene(model="reduced", bearing={"clearance_um": clearance})
    still = statics(scene)
    load, n = still.inner_force, len(still.inner_force)
    angle = 2.0 * np.pi * np.arange(n + 1) / n  # from the load's direction
    axes.plot(angle, np.append(load, load[0]), label=f"{clearance:g} µm")
    carrying, lower = np.sum(load > 0.0), -1e6 * still.hub[1]
    print(f"{clearance:4g} µm: {carrying:2d} rollers carry, at most {load.max():.0f} N; hub {lower:.1f} µm lower")
axes.set_title("load of each roller, N; the load points down")
axes.legend(title="clearance", loc="center left", bbox_to_anchor=(1.1, 0.5))
plt.show()

# %% [markdown]
# ## A spall in the outer raceway
#
# The Lagrangian model is the fast one. A spall of 2 mm lies in the load zone; each roller that crosses it lets go of
# the hub for a moment and strikes the edge where it leaves.

# %%
spalled = Scene(
    model="lagrange",
    spall=[{"body": "outer_ring", "width_mm": 2.0}],
    damping={"contact_N_s_m": 200.0},
    numerics={"duration_ms": 120.0},
)
result = simulate(spalled)
print({name: round(value, 1) for name, value in result.labels.items() if name.endswith("_Hz")})

# %%
time, force = 1e3 * result.time, result["outer_force"]
events = [event for event in result.events if 20.0 < 1e3 * event.time < 28.0]
figure, (upper, lower) = plt.subplots(2, 1, sharex=True, layout="constrained")
shown = (time > 20.0) & (time < 28.0)
upper.plot(time[shown], force[shown].max(axis=1))
for kind, colour in (("entry", "tab:green"), ("strike", "tab:red"), ("exit", "tab:gray")):
    times = [1e3 * event.time for event in events if event.kind == kind]
    upper.plot(times, [0.0] * len(times), "^", color=colour, label=kind, clip_on=False)
upper.set_ylabel("largest load of a roller, N")
upper.legend(ncols=3, loc="upper right")
lower.plot(time[shown], result["inner_ay"][shown])
lower.set(xlabel="time, ms", ylabel="hub's acceleration, m/s²")
plt.show()

# %% [markdown]
# ## What a vibration engineer would see
#
# `residual` is the check of `check-residual`; with it comes the envelope of the hub's acceleration. The line of a
# spalled outer raceway is the frequency at which rollers pass it, BPFO.

# %%
check = result.residual()
envelope = check.y.vibration.envelope.spectrum
inside = envelope.frequency < 2200.0
plt.semilogy(envelope.frequency[inside], envelope.psd[inside])
for k in range(1, 6):
    plt.axvline(k * check.lines["BPFO"], color="tab:red", linestyle="--", linewidth=0.8, zorder=0)
plt.xlabel("frequency, Hz (dashed: BPFO and multiples)")
plt.ylabel("envelope's PSD, m²/s⁴/Hz")
plt.show()
print("stand out:", ", ".join(line.name for line in check.y.vibration.lines if line.stands_out))

# %% [markdown]
# ## How good is the law?
#
# The same bearing, sound, with elastic bodies (`reduced`), put into the equation of the hub: what is left is the error
# of the contact law that the equation was given.

# %%
elastic = simulate(Scene(model="reduced", numerics={"duration_ms": 30.0}))
for law in ("harris", "palmgren", "johnson", "fitted"):
    left = elastic.residual(law=law).y.error
    print(f"{law:9s} mean {left.mean:6.1f} N, varies by {left.std:.1f} N rms; the load is 2000 N")
