"""Every function of the state as f(m, q, v, a), for one state or many: the rows of the table, and others."""

import functools

import axode
import numpy as np
from axode.table import ROWS
from mechanisms import REPRESENTATIONS


def tool(m):
    """The last frame of a mechanism, which is the farthest from the ground."""
    return m.frame_names[-1]


def load_on(m, q):
    """A load whose wrench differs from state to state."""
    if not m.body_names:
        return []
    return [axode.Load(frame=tool(m), representation="hybrid", wrench=np.ones(np.shape(q)[:-1] + (6,)) * q[..., :1]),
            axode.Load(frame=m.body_names[0], representation="spatial", wrench=[1, 2, 3, 4, 5, 6])]


def given_to(row, m, q, v, a):
    """The arguments of the function of a row, by name, except the model."""
    numbers = {"q": q, "v": v, "a": a, "tau": a, "p": v, "dq": v, "dv": a, "da": 2 * v, "dtau": 2 * v, "w": v - a}
    settings = {"frame": tool(m), "base": m.frame_names[min(1, m.n_bodies)], "loads": load_on(m, q)}
    given = {name: (numbers | settings)[name] for name in row.takes if name in numbers or name in settings}
    losses = {"joint_losses": True} if "loads" in row.takes and row.counts["joint losses"][0] in ("optional", "partly") else {}
    return given | losses


def in_one(results, q):
    """The results of a function with several results as one array, one result after the other in each state."""
    return np.stack(results, axis=np.ndim(q) - 1) if isinstance(results, tuple) else results


def of_row(name, **more):
    def call(m, q, v, a):
        return in_one(getattr(axode, name)(m, **given_to(ROWS[name], m, q, v, a), **more), q)
    return call


@functools.cache
def wired(m):
    """The mechanism with a spring to its farthest frame; m itself if it is none."""
    if not isinstance(m, axode.Model):
        return m
    wire = {"name": "wire", "between": ["ground", tool(m)], "stiffness": 1.0}
    drawing = m.to_dict()
    return axode.Model.from_dict(drawing | {"spring": [*drawing.get("spring", []), wire]})


@functools.cache
def with_balls(m):
    """The mechanism with balls at the ground and at its farthest frame; m itself if it is none."""
    if not isinstance(m, axode.Model):
        return m
    drawing, ball = m.to_dict(), {"kind": "sphere", "role": "collision", "radius": 0.1}
    drawing["body"][-1].setdefault("shape", []).append(ball | {"position": [0.1, 0.2, 0.3]})
    return axode.Model.from_dict(drawing | {"shape": [*drawing.get("shape", []), ball]})


def value_and_gradient(x, gradient):
    return np.concatenate([np.expand_dims(x, -1), gradient], axis=-1)


def rates(v, a):
    return np.stack([v, a, v * a], axis=-2)


def steps(a):
    """The drive forces of two steps."""
    return np.stack([a, 0.5 * a], axis=-2)


def bodies_of(m, frames):
    return frames[..., 1:1 + m.n_bodies, :]


CALLS = {name: of_row(name) for name in ROWS}
CALLS |= {f"{name} {rep}": of_row(name, representation=rep) for name, row in ROWS.items() if row.choice != "none"
          for rep in REPRESENTATIONS}
CALLS |= {f"coriolis_matrix {form}": of_row("coriolis_matrix", form=form)
          for form in ["paper", "skew", "spatial", "christoffel"]}
CALLS |= {
    "normalize": lambda m, q, v, a: m.normalize(q),
    "coordinate_rates": lambda m, q, v, a: m.coordinate_rates(q, v),
    "velocities_from_rates": lambda m, q, v, a: m.velocities_from_rates(q, m.coordinate_rates(q, a)),
    "integrate": lambda m, q, v, a: m.integrate(q, v),
    "difference": lambda m, q, v, a: m.difference(q, m.integrate(q, a)),
    "interpolate": lambda m, q, v, a: m.interpolate(q, m.integrate(q, a), 0.3),
    "clamp": lambda m, q, v, a: m.clamp(m.integrate(q, 9 * a)),
    "loop_residual": lambda m, q, v, a: axode.loop_residual(m, q),
    "loop_jacobian": lambda m, q, v, a: axode.loop_jacobian(m, q),
    "loop_bias": lambda m, q, v, a: axode.loop_bias(m, q, v),
    "loop_residual_jacobian": lambda m, q, v, a: axode.loop_residual_jacobian(m, q),
    "loop_hessian_product": lambda m, q, v, a: axode.loop_hessian_product(m, q, axode.loop_residual(m, q), v),
    "loop_multipliers": lambda m, q, v, a: axode.loop_multipliers(m, q, v, a),
    "loop_multiplier_derivatives": lambda m, q, v, a: axode.loop_multiplier_derivatives(m, q, v, a).q,
    "impact": lambda m, q, v, a: axode.impact(m, q, v),
    "constraint_wrenches": lambda m, q, v, a: axode.constraint_wrenches(m, q, v, a),
    "spatial_momentum_form": lambda m, q, v, a: axode.spatial_momentum_form(
        m, q, axode.body_momenta(m, q, v, "spatial"), a)[1],
    "inverse_dynamics_rates": lambda m, q, v, a: in_one(axode.inverse_dynamics_rates(
        m, q, v, a, v, v * a, loads=load_on(m, q)), q),
    "second_order_inverse_dynamics": lambda m, q, v, a: in_one(axode.second_order_inverse_dynamics(
        m, q, v, a, v, v * a, loads=load_on(m, q)), q),
    "forward_dynamics_rates": lambda m, q, v, a: axode.forward_dynamics_rates(m, q, v, np.stack([a, v], axis=-2), load_on(m, q)),
    "inverse_kinematics_rates": lambda m, q, v, a: axode.inverse_kinematics_rates(
        m, q, axode.twist_derivatives(m, q, rates(v, a), tool(m)), tool(m)),
    "spring_coordinate": lambda m, q, v, a: value_and_gradient(*axode.spring_coordinate(wired(m), q, "wire")),
    "pair_distances": lambda m, q, v, a: value_and_gradient(*axode.pair_distances(with_balls(m), q)),
    "rollout": lambda m, q, v, a: axode.rollout(m, q, v, steps(a), 1e-4)[1],
    "rollout_derivatives": lambda m, q, v, a: np.concatenate(axode.rollout_derivatives(m, q, v, steps(a), 1e-4), axis=-1),
    "rollout_derivatives_with_drives": lambda m, q, v, a: np.concatenate(
        axode.rollout_derivatives_with_drives(m, q, v, steps(a), 1e-4)[3:5], axis=-1),
    "rollout_jvp": lambda m, q, v, a: in_one(axode.rollout_jvp(m, q, v, steps(a), 1e-4, v, a, np.stack([v, a], axis=-2)), q),
    "rollout_vjp": lambda m, q, v, a: axode.rollout_vjp(m, q, v, steps(a), 1e-4, *2 * [np.stack([v, a, v], axis=-2)]).tau,
    "linearize": lambda m, q, v, a: np.concatenate(axode.linearize(m, q, v, a, load_on(m, q), joint_losses=True), axis=-1),
}
for rep in REPRESENTATIONS:
    CALLS |= {
        f"jacobian {rep} of a point": of_row("jacobian", representation=rep, offset=[1, 2, 3]),
        f"jacobians {rep} of two frames": lambda m, q, v, a, rep=rep: axode.jacobians(m, q, [tool(m), 0], rep),
        f"jacobian_partials {rep}": lambda m, q, v, a, rep=rep: axode.jacobian_partials(m, q, tool(m), rep, 2),
        f"jacobian_derivative_along {rep}": lambda m, q, v, a, rep=rep: axode.jacobian_derivative_along(
            m, q, tool(m), np.stack([v, a], axis=-2), rep),
        f"twist_derivatives {rep}": lambda m, q, v, a, rep=rep: axode.twist_derivatives(m, q, rates(v, a), tool(m), rep),
        f"jacobian_derivatives {rep}": lambda m, q, v, a, rep=rep: axode.jacobian_derivatives(
            m, q, rates(v, a), tool(m), rep),
        f"motion_vjp {rep}": lambda m, q, v, a, rep=rep: in_one(axode.motion_vjp(
            m, q, v, a, tool(m), np.broadcast_to(np.arange(18.0).reshape(3, 6), (*q.shape[:-1], 3, 6)), rep), q),
        f"twist_form {rep}": lambda m, q, v, a, rep=rep: axode.twist_form(
            m, q, bodies_of(m, axode.twists(m, q, v, rep)), a, rep)[1],
    }
