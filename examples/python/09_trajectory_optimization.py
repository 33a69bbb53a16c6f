"""The least drive forces that swing a double pendulum up, from the exact derivatives of its motion."""

# %% [markdown]
# The pendulum hangs at rest, and is to stand at rest after a second. Of all drive forces u
# that take it there, we look for those with the least sum of squares. A change du displaces
# the end by S du, and S follows from the matrices A and B of the steps: a displacement from
# the previous steps is multiplied by A, and the forces of the step itself add B.

# %%
import axode
import numpy as np
from numpy.typing import NDArray

pendulum = axode.load(axode.robots / "double_pendulum.toml")
steps, step = 50, 0.02
hanging, still = np.zeros(2), np.zeros(2)


def end_off(u: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """The difference between the end of the motion and a target at rest: displacements, then velocities."""
    q, v = axode.rollout(pendulum, hanging, still, u, step)
    return np.concatenate([pendulum.difference(target, q[-1]), v[-1]])


def end_by_forces(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """The matrix S of derivatives of the end with respect to all drive forces."""
    S = np.zeros((4, 0))
    for A, B in zip(*axode.rollout_derivatives(pendulum, hanging, still, u, step)):
        S = np.hstack([A @ S, B])
    return S


# %% [markdown]
# Newton's step is the shortest u that would reach the target if the end were linear in it. The target is
# raised from hanging to standing in forty parts, so that each is near.

# %%
u = np.zeros((steps, 2))
for angle in np.append(np.linspace(0, np.pi, 41)[1:], 40 * [np.pi]):
    S = end_by_forces(u)
    u = (np.linalg.pinv(S) @ (S @ u.ravel() - end_off(u, np.array([angle, 0.0])))).reshape(steps, 2)

off = np.linalg.norm(end_off(u, np.array([np.pi, 0.0])))
print(f"it stands after {steps * step:.0f} s to within {off:.0e}")
print("largest drive torques in N m:", np.abs(u).max(axis=0).round(1))

# %% [markdown]
# The shortest u is a combination of the rows of S: the gradient of the end, weighted with some factors. This
# gradient can also be computed without matrices.

# %%
factors = np.linalg.lstsq(end_by_forces(u).T, u.ravel(), rcond=None)[0]
w_q, w_v = np.zeros((2, steps + 1, 2))
w_q[-1], w_v[-1] = factors[:2], factors[2:]
gradient = axode.rollout_vjp(pendulum, hanging, still, u, step, w_q, w_v)
print(f"the forces are a gradient of the end to within {np.abs(gradient.tau - u).max():.0e} N m")
