"""Feed-forward for an arm whose drives are elastic, from the time derivatives of its torques."""

# %% [markdown]
# Gears and torque sensors are springs between motors and links: M(q) a + C v + g = tau = K (theta - q) and J
# theta'' + tau = tau_m. Such an arm is flat: a motion q(t) of the links determines all the rest. The springs
# must be wound up by tau, so theta = q + tau / K, and the motors must turn with theta'' = a + tau'' / K. So
# tau'' is needed, with q up to its fourth derivative.

# %%
import axode
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

arm = axode.load(axode.robots / "arm7.toml")
K = np.array([8e3, 8e3, 5e3, 5e3, 3e3, 2e3, 1e3])  # N m/rad
J = np.array([1.2, 1.2, 0.8, 0.8, 0.4, 0.2, 0.1])  # kg m^2, behind the gears

step, n = 5e-4, 2000  # s: one second
t = np.linspace(0, step * n, 2 * n + 1)[:, None]  # and between the steps
posture, swing = np.array([0.0, 0.9, 0.0, -0.6, 0.0, 0.7, 0.0]), 0.5  # rad
rhythm = np.linspace(2.0, 5.0, 7)  # rad/s
# q, v, a, jerk and snap of a swing in each joint
motion = [swing * rhythm**k * np.sin(rhythm * t + k * np.pi / 2) for k in range(5)]
motion[0] += posture
tau, dtau, ddtau = axode.inverse_dynamics_rates(arm, *motion)
q, v, a = motion[:3]

# %% [markdown]
# Two feed-forwards, each with the same feedback of the motors: one that knows of the springs, and one that
# does not. They are run on the arm with its springs.

# %%
flat = (q + tau / K, v + dtau / K, J * (a + ddtau / K) + tau)
rigid = (q, v, J * a + tau)


def largest_error(theta: Array, omega: Array, torque: Array) -> float:
    """The largest error of the links, in mrad. The motion begins without error and is computed by Runge-Kutta's
    method, with four calls for a step."""
    stiffness, damping = 2e3 * J, 80.0 * J
    # The state: links, their rates, motors, their rates.
    x = np.stack([q[0], v[0], q[0] + tau[0] / K, v[0] + dtau[0] / K])

    def rate(x: Array, k: int) -> Array:
        spring = K * (x[2] - x[0])
        drive = torque[k] + stiffness * (theta[k] - x[2]) + damping * (omega[k] - x[3])
        return np.stack([x[1], axode.forward_dynamics(arm, x[0], x[1], spring), x[3], (drive - spring) / J])

    worst = 0.0
    for k in range(0, 2 * n, 2):
        k1 = rate(x, k)
        k2 = rate(x + step / 2 * k1, k + 1)
        k3 = rate(x + step / 2 * k2, k + 1)
        x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + step * k3, k + 2))
        worst = max(worst, float(np.abs(x[0] - q[k + 2]).max()))
    return 1e3 * worst


print(f"wind-up of the springs: up to {1e3 * np.abs(tau / K).max():.1f} mrad")
print(f"motor torques: tau'' is up to {np.abs(J * ddtau / K).max():.1f} of {np.abs(flat[2]).max():.1f} N m")
print(f"links off by, without the springs in the feed-forward: {largest_error(*rigid):.2f} mrad")
print(f"links off by, with them: {largest_error(*flat):.1e} mrad")
