"""Drive torques of a whole trajectory in one call, and whether the drives can deliver them."""

# %% [markdown]
# Functions take one state, q of shape (nq,), or N states, q of shape (N, nq), so
# that no loop in Python is needed. Here an arm carries 8 kg at its flange, and
# its joints swing about a posture for four seconds, each at a rhythm of its own.

# %%
from timeit import repeat

import axode
import numpy as np
from numpy.typing import NDArray

drawing = axode.load(axode.robots / "arm7.toml").to_dict()
drawing["body"].append({"name": "payload", "on": "link 7", "joint": "fixed", "mass": 8.0, "com": [0.04, 0, 1.4],
                        "inertia": [0.03, 0.03, 0.03]})
arm = axode.Model.from_dict(drawing)

t = np.linspace(0, 4, 4096)[:, None]  # s
posture = np.array([0.0, 0.9, 0.0, -0.6, 0.0, 0.7, 0.0])  # rad
swing, rhythm = 0.4, np.linspace(1.5, 4.5, 7)  # rad, rad/s
q = posture + swing * np.sin(rhythm * t)
v = swing * rhythm * np.cos(rhythm * t)
a = -swing * rhythm**2 * np.sin(rhythm * t)
tau = axode.inverse_dynamics(arm, q, v, a)
print(f"{arm.name}: tau has shape {tau.shape}, N m")

# %% [markdown]
# Are the drives strong enough? What each of them can do is in the model: `effort` in N m.

# %%
print("\njoint     peak      rms   effort   used")
for name, torque, effort in zip(arm.velocity_names, tau.T, arm.effort_limits):
    peak, rms = np.abs(torque).max(), np.sqrt(np.mean(torque**2))
    print(f"{name:5} {peak:8.2f} {rms:8.2f} {effort:8.1f} {peak / effort:6.1%}")
print("all torques within the limits:", bool((np.abs(tau) <= arm.effort_limits).all()))

# %% [markdown]
# The same computed by a loop over the states, and by the batch on two cores. A batch
# computes several states at once with SIMD instructions, and lets other Python
# threads run meanwhile. The numbers agree to rounding; times are the best of five.

# %%
def loop() -> list[NDArray[np.float64]]:
    return [axode.inverse_dynamics(arm, *state) for state in zip(q, v, a)]


print(f"\nlargest difference to a loop: {np.abs(tau - loop()).max():.0e} N m")
by_loop = min(repeat(loop, number=1, repeat=5))
print(f"loop over {len(q)} states: {1e3 * by_loop:.2f} ms")
for threads in (1, 2):
    time = min(repeat(lambda: axode.inverse_dynamics(arm, q, v, a, threads=threads), number=1, repeat=5))
    print(f"one call, threads={threads}: {1e3 * time:.2f} ms, {by_loop / time:.0f} times as fast")
