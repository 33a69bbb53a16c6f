"""One motion in four representations, as a picture: `python 02_representations.py [figure.svg]`."""

# %% [markdown]
# An arm, 1 m long and 0.5 m above the ground, swings about a column at 1 rad/s. At its
# tip is a wheel whose axis is the arm; it spins at 3 rad/s. How does the center of the
# wheel move? Both speeds are constant, and yet most numbers below are not: they depend
# on the axes in which a twist is written, and on the point whose velocity it holds.

# %%
import sys

import axode
import matplotlib.pyplot as plt
import numpy as np

grinder = (
    axode.Builder("swinging grinder")
    .body("arm", joint={"name": "swing", "kind": "revolute", "axis": "z", "point": [0, 0, 0]})
    .body("wheel", on="arm", joint={"name": "spin", "kind": "revolute", "axis": "x", "point": [0, 0, 0.5]})
    .frame("center", on="wheel", position=[1, 0, 0.5])
    .build()
)
t = np.linspace(0, 2 * np.pi, 201)  # s, one turn of the arm
v = np.tile([1.0, 3.0], (len(t), 1))  # rad/s
q = t[:, None] * v
center = grinder.frame_index("center")

# %% [markdown]
# One call for each representation gives the twists of all
# frames at all times, (201, n_frames, 6), angular part first.

# %%
twists = {
    "body": axode.twists(grinder, q, v, "body")[:, center],
    "mixed": axode.twists(grinder, q, v, "mixed")[:, center],
    "hybrid": axode.twists(grinder, q, v, "hybrid")[:, center],
    "spatial": axode.twists(grinder, q, v, "spatial")[:, center],
}
print("twist of the center after an eighth of a turn; rad/s and m/s")
print("            w_x      w_y      w_z      v_x      v_y      v_z")
for name, V in twists.items():
    print(f"{name:7}" + "".join(f" {x:8.3f}" for x in V[len(t) // 8]))

# %% [markdown]
# Panels of one tint show the same numbers. The angular part knows only axes, the wheel's
# or inertial ones. The linear part is the velocity of the center, in either; but in the
# spatial twist it is that of the point of the wheel, thought to go on without end, that
# is at the inertial origin. It is 0.5 m off the wheel's axis: 3 rad/s * 0.5 m = 1.5 m/s.

# %%
TURNING, INERTIAL, CENTER, OTHER = "#fff3df", "#e6f0fa", "#e8f4e8", "#ffffff"
PANELS = {
    "body": [("angular, wheel's axes", TURNING), ("of the center, wheel's axes", OTHER)],
    "mixed": [("angular, wheel's axes", TURNING), ("of the center, inertial axes", CENTER)],
    "hybrid": [("angular, inertial axes", INERTIAL), ("of the center, inertial axes", CENTER)],
    "spatial": [("angular, inertial axes", INERTIAL), ("at the inertial origin, inertial axes", OTHER)],
}
figure, axes = plt.subplots(2, 4, figsize=(11, 5.4), sharex=True, sharey="row", layout="constrained")
for column, (name, V) in enumerate(twists.items()):
    for row, part in enumerate([V[:, :3], V[:, 3:]]):
        panel, (meaning, tint) = axes[row, column], PANELS[name][row]
        panel.set_facecolor(tint)
        panel.margins(x=0)
        panel.set_title(meaning, fontsize=9)
        panel.plot(t, np.linalg.norm(part, axis=1), color="#555555", linestyle=":", label="length of the vector")
        for label, color, line in zip("xyz", ["#d55e00", "#009e73", "#0055aa"], part.T):
            panel.plot(t, line, color=color, label=label)
    axes[0, column].set_title(f"{name}\n", fontweight="bold", loc="left")
    axes[1, column].set_xlabel("time in s")
axes[0, 0].set_ylabel("angular part in rad/s")
axes[1, 0].set_ylabel("linear part in m/s")
figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
figure.suptitle("The same motion in four twists: panels of one tint show the same numbers")
plt.rcParams["svg.hashsalt"] = "axode"  # the same file every time
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "representations.svg", metadata={"Date": None})
