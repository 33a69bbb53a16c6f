"""The torques of a hop: a leg stands, leaps half a metre and stands again, by shooting with gradients from JAX."""

# %% [markdown]
# A trunk on a leg with a thigh, a shank and a foot moves in a plane. Springs in its joints hold it in a crouch; drives at
# hip, knee and ankle shall make it leap. All numbers are at the crouch, in m and kg.

# %%
from typing import Any

import axode
import axode.jax
import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import least_squares

jax.config.update("jax_enable_x64", True)


def turning(name: str, point: list[float], spring: float) -> dict[str, Any]:
    return {"name": name, "kind": "revolute", "axis": "y", "point": point, "spring": {"stiffness": spring}}


hopper = (
    axode.Builder("hopper")
    .body("trunk", joint={"name": "base", "kind": "planar", "axis": "-y", "point": [0, 0, 0]}, frame="joint",
          mass=6, com=[0, 0, 0.75], inertia=[0.1, 0.1, 0.1])
    .body("thigh", on="trunk", joint=turning("hip", [0, 0, 0.6], 300), mass=1.5, com=[0.1, 0, 0.47],
          inertia=[0.015, 0.015, 0.015])
    .body("shank", on="thigh", joint=turning("knee", [0.2, 0, 0.35], 300), mass=1.0, com=[0.1, 0, 0.2],
          inertia=[0.01, 0.01, 0.01])
    .body("foot", on="shank", joint=turning("ankle", [0, 0, 0.05], 300), mass=0.6, com=[0.02, 0, 0.02],
          inertia=[0.002, 0.002, 0.002])
    .frame("heel", on="foot", position=[-0.1, 0, 0])
    .frame("toe", on="foot", position=[0.15, 0, 0])
    .build()
)
soles = [hopper.frame_index(name) for name in ("heel", "toe")]
drives = [hopper.joint(name).v.start for name in ("hip", "knee", "ankle")]

# %% [markdown]
# The ground is a spring and a damper under heel and toe, with friction that grows smoothly to its limit. What it does to the
# joints is the transpose of a Jacobian times the force; the gradient goes through both.

# %%
stiffness, damping, friction = 3e3, 1.0, 0.8  # N/m, s/m, -


def forces_of_the_ground(q: jax.Array, v: jax.Array) -> jax.Array:
    places, total = axode.jax.poses(hopper, q), jnp.zeros(hopper.nv)
    for sole in soles:
        J = axode.jax.jacobian(hopper, q, sole, "hybrid")[jnp.array([3, 5])]  # of x and z
        speed = J @ v
        depth = 2e-3 * jax.nn.softplus(-places[sole, 2, 3] / 2e-3)
        normal = stiffness * depth * jax.nn.softplus(5 * (1 - damping * speed[1])) / 5
        total += J.T @ jnp.array([-friction * normal * jnp.tanh(speed[0] / 0.4), normal])
    return total


# %% [markdown]
# Torques are given at knots and go straight from one to the next. Each step of the motion is one of `rollout`, with the
# ground's forces at its beginning.

# %%
duration, steps, knots = 0.7, 280, 15
step = duration / steps
times = np.linspace(0, duration, steps)
fraction = np.array([np.interp(times, np.linspace(0, duration, knots), unit) for unit in np.eye(knots)]).T  # (steps, knots)


@jax.jit
def motion(start: jax.Array, u: jax.Array) -> tuple[jax.Array, jax.Array]:
    """From rest under torques u (knots, 3): where it ends, configuration and velocities, and all configurations."""
    def one_step(state: tuple[jax.Array, jax.Array], torques: jax.Array) -> tuple[Any, jax.Array]:
        q, v = state
        tau = forces_of_the_ground(q, v).at[jnp.array(drives)].add(torques)
        q, v = axode.jax.rollout(hopper, q, v, tau[None], step)
        return (q[-1], v[-1]), q[-1]

    (q, v), path = jax.lax.scan(one_step, (start, jnp.zeros(hopper.nv)), jnp.asarray(fraction) @ u)
    return jnp.concatenate([q, v]), path


# %% [markdown]
# First it settles on its springs. The end shall then be the beginning, 0.5 m further on and at rest again: that makes a gait
# of it, one hop after the other. Torques cost a little.

# %%
standing = jnp.asarray(hopper.neutral())
for _ in range(5):
    standing = motion(standing, jnp.zeros((knots, 3)))[0][:hopper.nq]
wanted = jnp.concatenate([standing, jnp.zeros(hopper.nv)]).at[1].add(0.5)
weights = jnp.array([20, 20, 20, 5, 5, 5, 1, 1, 1, 0.2, 0.2, 0.2])


@jax.jit
def residuals(u: jax.Array) -> jax.Array:
    off = motion(standing, u.reshape(knots, 3))[0] - wanted
    return jnp.concatenate([weights * off, 5e-3 * u])


# %% [markdown]
# Gauss and Newton's method wants the derivative by all 45 numbers. JAX takes the 45 directions through the motion at once,
# each of them a state in the lanes of the library.

# %%
found = least_squares(residuals, np.zeros(3 * knots), jac=jax.jit(jax.jacfwd(residuals)), bounds=(-150, 150), max_nfev=60)
u = found.x.reshape(knots, 3)
end, path = motion(standing, jnp.asarray(u))

# %%
heights = axode.poses(hopper, np.asarray(path))[:, soles, 2, 3].min(axis=1)
print(f"it moves by {end[1] - standing[1]:.3f} m, {heights.max():.3f} m above the ground")
print(f"at the end it is off the beginning by {np.abs(end[:6] - wanted[:6]).max():.3f}, its velocity is {np.abs(end[6:]).max():.3f}")
print("largest torques of hip, knee and ankle in N m:", np.abs(u).max(axis=0).round(0))
