"""From a drawing to inverse and forward dynamics: axes, points and masses in one frame, no joint frames."""

# %% [markdown]
# A slewing crane: a column that turns, a jib that luffs, a trolley that runs out along the jib. Every axis,
# point and center of mass is read off one drawing with all joints at zero, in m and kg. The frame of the
# drawing is that of every body as well; `frame="joint"` or `frame="com"` in a body would put its frame there.

# %%
import axode
import numpy as np

crane = (
    axode.Builder("crane")
    .body("column", joint={"name": "slew", "kind": "revolute", "axis": "z", "point": [0, 0, 0]},
          mass=800, com=[0, 0, 1.5], inertia=[620, 620, 40])
    .body("jib", on="column", joint={"name": "luff", "kind": "revolute", "axis": "-y", "point": [0.3, 0, 3]},
          mass=300, com=[2.1, 0, 3], inertia=[8, 330, 330])
    .body("trolley", on="jib", joint={"name": "travel", "kind": "prismatic", "axis": "x"},
          mass=60, com=[0.8, 0, 3], inertia=[1.1, 1.6, 1.9])
    .frame("hook", on="trolley", position=[0.8, 0, 1.4])
    .build()
)
print(crane)

# %% [markdown]
# Which drive forces hold the crane at rest, with the jib level and the trolley 2 m out? The slewing drive
# needs none; the luffing drive carries both weights, each with its lever.

# %%
q, rest = np.array([0.0, 0.0, 2.0]), np.zeros(3)  # rad, rad, m
tau = axode.inverse_dynamics(crane, q, rest, rest)
levers = 300 * (2.1 - 0.3) + 60 * (0.8 + 2.0 - 0.3)  # kg m, from the pin of the jib
print(f"\nto hold it: slew {tau[0]:.1f} N m, luff {tau[1]:.1f} N m, travel {tau[2]:.1f} N")
print(f"luff by hand: {9.81 * levers:.1f} N m")

# %% [markdown]
# The same with 500 kg on the hook. A wrench is a moment and then a force;
# "hybrid" means that both are in inertial axes and act at the frame.

# %%
weight = axode.Load(frame="hook", representation="hybrid", wrench=[0, 0, 0, 0, 0, -500 * 9.81])
print(f"with 500 kg on the hook: luff {axode.inverse_dynamics(crane, q, rest, rest, loads=[weight])[1]:.1f} N m")

# %% [markdown]
# Forward dynamics computes accelerations from forces. While the crane
# slews, let the brake of the trolley slip: the trolley runs out.

# %%
v = np.array([0.3, 0.0, 0.0])  # rad/s, rad/s, m/s
tau = axode.inverse_dynamics(crane, q, v, rest)
tau[crane.joint("travel").v] = 0.0
a = axode.forward_dynamics(crane, q, v, tau)
print(f"\nthe trolley slips: {a[2]:.3f} m/s^2, as fast as 0.3^2 times its radius: {0.3**2 * (0.8 + 2.0):.3f} m/s^2")
print("inverse dynamics gives these drive forces again:", np.allclose(axode.inverse_dynamics(crane, q, v, a), tau))
