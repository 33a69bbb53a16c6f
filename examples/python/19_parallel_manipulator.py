"""Feed-forward for a Gough platform whose drives are elastic, from the time derivatives of its drive forces."""

# %% [markdown]
# A Gough platform is carried by six legs, each of which follows from the motion of the
# platform alone. `TaskSpace` computes with the twist of the platform in place of the 24
# velocities of the joints. If a spring is between each motor and its leg, the platform
# is flat: its motion, up to the third derivative of its twist, determines the motors.

# %%
import axode
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

m = axode.load(axode.robots / "gough.toml")
space = axode.TaskSpace(m, m.neutral())
print(space)
K, J = 5e5, 20.0  # of each drive and its motor along the leg, N/m and kg
drives = space.equations(m.neutral(), np.zeros(m.nv)).drives
legs = [m.joint(m.velocity_names[c]).q.start for c in drives]
amplitude, rhythm = np.array([0.05, -0.03, 0.08]), np.array([7.0, 9.0, 11.0])  # m, rad/s


def pose(t: float) -> Array:
    """The wanted pose of the plate, which moves without turning."""
    C = np.eye(4)
    C[:3, 3] = amplitude * (1 - np.cos(rhythm * t))
    return C


def twist_and_rates(t: float) -> Array:
    """Its twist and the first three derivatives of it, (4, 6)."""
    rows = np.zeros((4, 6))
    for k in range(4):
        rows[k, 3:] = amplitude * rhythm ** (k + 1) * np.sin(rhythm * t + k * np.pi / 2)
    return rows


# %% [markdown]
# The springs are wound up by the drive forces u, so that the
# motors must be at x + u / K and accelerate with x'' + u'' / K.


# %%
def motors(t: float, near: Array, with_springs: bool) -> tuple[Array, Array, Array, Array]:
    """The configuration at a time, and places, speeds and forces of the motors."""
    q = space.place_platform(pose(t), near)
    tau, motion = space.inverse_dynamics_rates(q, twist_and_rates(t))
    u, du, ddu = tau[:, drives]
    _, a, *_ = motion[:, drives]
    return q, q[legs] + u / K, motion[0, drives] + du / K, u + J * (a + (ddu / K if with_springs else 0))


def largest_error(with_springs: bool, step: float = 1e-3, steps: int = 200) -> float:
    """The largest error of the plate in open loop, in m. The motion begins without error and is computed by Runge-Kutta's
    method: coordinates of the mechanism, twist of the plate, places and speeds of the motors."""
    q, place, speed, force = motors(0, m.neutral(), with_springs)
    x = np.concatenate([q, np.zeros(6), place, speed])
    n, worst = m.nq, 0.0

    def rate(x: Array, force: Array) -> Array:
        q, V, place, speed = np.split(x, [n, n + 6, n + 12])
        tau = np.zeros(m.nv)
        tau[drives] = spring = K * (place - q[legs])
        q = m.normalize(q)
        v = space.velocities(q, V)
        return np.concatenate([m.coordinate_rates(q, v), space.forward_dynamics(q, v, tau), speed, (force - spring) / J])

    for k in range(steps):
        middle = motors((k + 0.5) * step, q, with_springs)[3]
        q, *_, end = motors((k + 1) * step, q, with_springs)
        k1 = rate(x, force)
        k2 = rate(x + step / 2 * k1, middle)
        k3 = rate(x + step / 2 * k2, middle)
        x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + step * k3, end))
        reached = axode.pose(m, m.normalize(x[:n]), "platform")
        worst = max(worst, float(np.linalg.norm(reached[:3, 3] - pose((k + 1) * step)[:3, 3])))
        x[:n] = space.place_platform(reached, m.normalize(x[:n]))  # the legs are closed again
        force = end
    return worst


print(f"plate off by, without u'' in the forces of the motors: {largest_error(False):.1e} m")
print(f"plate off by, with it: {largest_error(True):.1e} m")

# %% [markdown]
# Turned by a quarter turn the platform is singular: it moves while all drives are locked, along a screw.

# %%
q = m.neutral()
for angle in (0.5, 1.0, np.pi / 2):
    q = space.place_platform(axode.lie.exp(np.array([0, 0, angle, 0, 0, 0])), q)
for found in space.singularities(q):
    print(f"turned by 90 degrees: {found.sentence}")
