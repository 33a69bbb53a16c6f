"""The geometry of an arm from poses that a tracker has measured, with outliers, and what such poses cannot show."""

# %% [markdown]
# The measured arm is the one that was built: every joint is off by half a degree and some millimetres, and a
# reflector is at its flange. The tracker stands somewhere in the hall,
# its noise is 0.1 mm and 0.2 mrad, and one pose of thirty is wrong.

# %%
import axode
import numpy as np
from numpy.typing import NDArray

drawn = axode.load(axode.robots / "arm7.toml")
random = np.random.default_rng(5)
errors = random.normal(size=(drawn.n_bodies, 6)) * np.repeat([0.01, 0.003], 3)  # rad, m
reflector = axode.lie.exp([0.1, -0.05, 0.2, 0.03, 0.01, 0.08])
built = axode.calibration.with_geometry(drawn, errors, {"flange": reflector})
tracker = axode.lie.exp([0, 0, 2.2, 3, -1, 0.4])


def measure(m: axode.Model, q: NDArray[np.float64], device: NDArray[np.float64]) -> NDArray[np.float64]:
    """Poses of the flange as the tracker sees it."""
    return axode.lie.inverse(device) @ axode.poses(m, q)[:, m.frame_index("flange")]


q = drawn.random(n=120)
C = measure(built, q, tracker) @ axode.lie.exp(random.normal(size=(120, 6)) * np.repeat([2e-4, 1e-4], 3))
wrong = random.random(120) < 1 / 30
C[wrong] = C[wrong] @ axode.lie.exp(random.normal(0, 0.03, (wrong.sum(), 6)))

# %% [markdown]
# The poses of reflector and tracker are unknown too. The measured poses depend on 34 combinations of the 54
# parameters: 4 for each hinge, and 6 more.

# %%
found = axode.calibration.calibrate(drawn, {"frame": "flange", "q": q, "pose": C}, robust=True)
print(f"{len(found.parameter_names)} parameters, {found.rank} of their combinations in these poses; "
      f"condition {found.condition:.0f}")
print(f"noise: {1e3 * found.noise[0]:.2f} mrad, {1e3 * found.noise[1]:.2f} mm")
print(f"the tracker is near {found.device[:3, 3].round(2)}")
print("\nsome of what no such poses can show:")
for name in found.unidentifiable_names[:4]:
    print(f"  {name}")

# %% [markdown]
# The result is tested with other poses. For comparison, the poses of the drawing are computed with the best
# places of the tracker and the reflector.

# %%
q = drawn.random(seed=1, n=500)
true = measure(built, q, tracker)
fixture = axode.calibration.calibrate(drawn, {"frame": "flange", "q": q, "pose": true}, bodies=[])
for name, result in [("drawn", fixture), ("found", found)]:
    off = axode.lie.log(axode.lie.inverse(measure(result.model, q, result.device)) @ true)
    angle, length = np.sqrt(np.mean(np.sum(off.reshape(-1, 2, 3)**2, axis=2), axis=0))
    print(f"poses of the {name} model are off by {1e3 * angle:.2f} mrad, {1e3 * length:.2f} mm")
print("masses and names are those of the drawing:",
      found.model.frame_names == drawn.frame_names and found.model.total_mass == drawn.total_mass)
