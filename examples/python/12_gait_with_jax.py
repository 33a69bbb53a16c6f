"""The gait of a swimming snake: torques that take it furthest, by shooting through its motion with gradients from JAX."""

# %% [markdown]
# Six links move on a plane, in a viscous fluid whose resistance across a link is ten times as large as along
# it. Each joint has a spring, like a flexible body, and a drive. All numbers are in m, kg and s.

# %%
from typing import Any

import axode
import axode.jax
import jax  # type: ignore[import-not-found, unused-ignore]
import jax.numpy as jnp  # type: ignore[import-not-found, unused-ignore]
import numpy as np
from scipy.optimize import minimize  # type: ignore[import-untyped, unused-ignore]

jax.config.update("jax_enable_x64", True)

links, length = 6, 0.2
builder, before = axode.Builder("snake"), None
for k in range(links):
    joint: dict[str, Any] = {"name": "base", "kind": "planar", "axis": "z", "point": [0, 0, 0]} if k == 0 else {
        "name": f"joint {k}", "kind": "revolute", "axis": "z", "point": [-length * (k - 0.5), 0, 0], "spring": {"stiffness": 0.5}}
    builder.body(f"link {k}", on=before or "ground", joint=joint, frame="com", mass=0.3, com=[-length * k, 0, 0],
                 inertia=[1e-4, 1e-3, 1e-3])
    before = f"link {k}"
snake = builder.build().with_gravity([0, 0, 0])

# %% [markdown]
# The fluid's wrench on a link is linear in its twist. Its forces on the joints are computed without a
# Jacobian, by the transpose of the map from v to all twists, which JAX gives by `vjp`.

# %%
resistance = np.zeros((snake.n_frames, 6))
resistance[1:links + 1] = [0, 0, 0.01, 0.3, 3.0, 0]  # N m s about z, N s/m along and across


def forces_of_the_fluid(q: jax.Array, v: jax.Array) -> jax.Array:
    V, transpose = jax.vjp(lambda v: axode.jax.twists(snake, q, v), v)
    return transpose(-resistance * V)[0]


# %% [markdown]
# Every joint has a torque of its own amplitude and phase, with the same period. Each step of the motion is
# one of `rollout`, with the fluid's forces at its beginning.

# %%
period, periods, step = 1.0, 3, 0.02
times = np.arange(0, periods * period, step)
waves = np.stack([np.sin(2 * np.pi * times / period), np.cos(2 * np.pi * times / period)], axis=1)


def motion(u: jax.Array) -> tuple[jax.Array, jax.Array]:
    """All configurations and torques of the motion. The torques have the sine and cosine amplitudes u (2, links - 1),
    N m."""
    def one_step(state: tuple[jax.Array, jax.Array], torques: jax.Array) -> tuple[Any, jax.Array]:
        q, v = state
        tau = forces_of_the_fluid(q, v).at[3:].add(torques)
        q, v = axode.jax.rollout(snake, q, v, tau[None], step)
        return (q[-1], v[-1]), q[-1]

    torques = jnp.asarray(waves) @ u
    return jax.lax.scan(one_step, (jnp.zeros(snake.nq), jnp.zeros(snake.nv)), torques)[1], torques


# %% [markdown]
# The snake is to swim far with little torque. At first all drives work in phase: a body that bends to and fro
# along the same path does not move on. The gradient finds the phases.

# %%
def cost(u: jax.Array) -> jax.Array:
    path, torques = motion(u.reshape(2, links - 1))
    return -axode.jax.center_of_mass(snake, path[-1])[0] + 0.3 * jnp.mean(torques ** 2)


first = np.stack([np.full(links - 1, 0.3), np.zeros(links - 1)])
found = minimize(jax.jit(jax.value_and_grad(cost)), first.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": 40})

# %%
swim = jax.jit(motion)
for name, u in (("together", first), ("found", found.x.reshape(2, links - 1))):
    path, torques = swim(jnp.asarray(u))
    way = axode.center_of_mass(snake, np.asarray(path))[:, 0]
    print(f"{name}: {way[-1] - way[0]:.3f} m in {periods} periods, torques to {np.abs(torques).max():.2f} N m")
phases = np.unwrap(np.arctan2(*found.x.reshape(2, links - 1)[::-1]))
print("phases from head to tail in degrees:", np.degrees(phases - phases[0]).round())
