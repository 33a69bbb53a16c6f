"""What an arm can hold when nobody knows its masses well: peak torques of 1,000 arms as they may be built."""

# %% [markdown]
# Castings are a few per cent heavier or lighter than their drawing, and what the gripper holds weighs what it
# weighs. Each variant is drawn from its seed alone, so that it does not matter who computes it, in which
# order, and after how many interruptions.

# %%
import sys

import axode
import numpy as np
from axode import distributed

arm = axode.load(axode.robots / "arm7.toml")
t = np.linspace(0, 4, 200)[:, None]  # s
posture, rhythm = np.array([0.0, 0.9, 0.0, -0.6, 0.0, 0.7, 0.0]), np.linspace(3, 7, 7)  # rad, rad/s
q = posture + 0.4 * np.sin(rhythm * t)
v, a = 0.4 * rhythm * np.cos(rhythm * t), -0.4 * rhythm**2 * np.sin(rhythm * t)


def built(m: axode.Model, seed: int) -> axode.Model:
    """An arm whose links differ from the drawing by some 3 % in all of their inertia, with a payload of 0 to 12 kg
    that is held some cm off the middle."""
    random = np.random.default_rng(seed)
    parameters = m.parameters.reshape(m.n_bodies, 10) * random.normal(1, 0.03, (m.n_bodies, 1))
    held = axode.lie.exp([0, 0, 0, *random.normal([0, 0, 0.1], 0.02)])
    payload = axode.lie.transform_inertia(held, axode.lie.sphere_inertia(random.uniform(0, 12), 0.05))
    return m.with_parameters(parameters.ravel()).with_payload("flange", payload)


def peaks(m: axode.Model, seed: int) -> dict[str, object]:
    """The largest torque of each drive along the motion, N m, and the mass of the arm, kg."""
    variant = built(m, seed)
    return {"mass": variant.total_mass, "peak": np.abs(axode.inverse_dynamics(variant, q, v, a)).max(axis=0)}


# %% [markdown]
# Without further arguments the study runs in this process. `local` starts
# Ray on the cores of this machine, and an address is that of a cluster.

# %%
cluster = sys.argv[1] if len(sys.argv) > 1 else None
found = distributed.sweep(arm, peaks, {"seed": range(1000)}, cluster=cluster)
print(f"{len(found['seed'])} arms of {found['mass'].min():.1f} to {found['mass'].max():.1f} kg")

print("\njoint   median   99 %   effort   too weak")
for name, torque, effort in zip(arm.velocity_names, found["peak"].T, arm.effort_limits):
    median, most = np.quantile(torque, [0.5, 0.99])
    print(f"{name:5} {median:8.2f} {most:6.2f} {effort:8.1f} {np.mean(torque > effort):10.1%}")
print("arms with a drive that is too weak:", f"{np.mean((found['peak'] > arm.effort_limits).any(axis=1)):.1%}")
