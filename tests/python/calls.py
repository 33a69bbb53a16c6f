"""Every function of the state, as f(m, q, v, a) of states that are one row or many."""

import axode
import numpy as np
from mechanisms import REPRESENTATIONS


def tool(m):
    """The last frame, which is farthest from the ground."""
    return m.frame_names[-1]


def load_on(m, q):
    """A wrench that is another one in every state."""
    if not m.body_names:
        return []
    return [axode.Load(frame=tool(m), representation="hybrid", wrench=np.ones(np.shape(q)[:-1] + (6,)) * q[..., :1]),
            axode.Load(frame=m.body_names[0], representation="spatial", wrench=[1, 2, 3, 4, 5, 6])]


def rates(v, a):
    return np.stack([v, a, v * a], axis=-2)


def bodies_of(m, frames):
    return frames[..., 1:1 + m.n_bodies, :]


CALLS = {
    "normalize": lambda m, q, v, a: m.normalize(q),
    "coordinate_rates": lambda m, q, v, a: m.coordinate_rates(q, v),
    "velocities_from_rates": lambda m, q, v, a: m.velocities_from_rates(q, m.coordinate_rates(q, a)),
    "integrate": lambda m, q, v, a: m.integrate(q, v),
    "difference": lambda m, q, v, a: m.difference(q, m.integrate(q, a)),
    "interpolate": lambda m, q, v, a: m.interpolate(q, m.integrate(q, a), 0.3),
    "clamp": lambda m, q, v, a: m.clamp(m.integrate(q, 9 * a)),
    "poses": lambda m, q, v, a: axode.poses(m, q),
    "pose": lambda m, q, v, a: axode.pose(m, q, tool(m)),
    "joint_screws": lambda m, q, v, a: axode.joint_screws(m, q),
    "center_of_mass": lambda m, q, v, a: axode.center_of_mass(m, q),
    "center_of_mass_jacobian": lambda m, q, v, a: axode.center_of_mass_jacobian(m, q),
    "centroidal_momentum_matrix": lambda m, q, v, a: axode.centroidal_momentum_matrix(m, q),
    "centroidal_momentum_matrix_rate": lambda m, q, v, a: axode.centroidal_momentum_matrix_rate(m, q, v),
    "inverse_dynamics": lambda m, q, v, a: axode.inverse_dynamics(m, q, v, a),
    "inverse_dynamics with loads": lambda m, q, v, a: axode.inverse_dynamics(m, q, v, a, loads=load_on(m, q),
                                                                             joint_losses=True),
    "forward_dynamics": lambda m, q, v, a: axode.forward_dynamics(m, q, v, a),
    "forward_dynamics with loads": lambda m, q, v, a: axode.forward_dynamics(m, q, v, a, loads=load_on(m, q),
                                                                             joint_losses=True),
    "loop_residual": lambda m, q, v, a: axode.loop_residual(m, q),
    "loop_jacobian": lambda m, q, v, a: axode.loop_jacobian(m, q),
    "loop_bias": lambda m, q, v, a: axode.loop_bias(m, q, v),
    "loop_residual_jacobian": lambda m, q, v, a: axode.loop_residual_jacobian(m, q),
    "loop_hessian_product": lambda m, q, v, a: axode.loop_hessian_product(m, q, axode.loop_residual(m, q), v),
    "loop_multipliers": lambda m, q, v, a: axode.loop_multipliers(m, q, v, a),
    "loop_multiplier_derivatives": lambda m, q, v, a: axode.loop_multiplier_derivatives(m, q, v, a).q,
    "impact": lambda m, q, v, a: axode.impact(m, q, v),
    "constraint_wrenches": lambda m, q, v, a: axode.constraint_wrenches(m, q, v, a),
    "mass_matrix": lambda m, q, v, a: axode.mass_matrix(m, q),
    "inverse_mass_matrix": lambda m, q, v, a: axode.inverse_mass_matrix(m, q),
    "mass_matrix_partials": lambda m, q, v, a: axode.mass_matrix_partials(m, q),
    "inverse_mass_matrix_partials": lambda m, q, v, a: axode.inverse_mass_matrix_partials(m, q),
    "coriolis_vector": lambda m, q, v, a: axode.coriolis_vector(m, q, v),
    "christoffel": lambda m, q, v, a: axode.christoffel(m, q),
    "gravity_torques": lambda m, q, v, a: axode.gravity_torques(m, q),
    "generalized_loads": lambda m, q, v, a: axode.generalized_loads(m, q, v, load_on(m, q), joint_losses=True),
    "spring_forces": lambda m, q, v, a: axode.spring_forces(m, q, v),
    "elastic_energy": lambda m, q, v, a: axode.elastic_energy(m, q),
    "load_powers": lambda m, q, v, a: axode.load_powers(m, q, v, load_on(m, q)),
    "kinetic_energy": lambda m, q, v, a: axode.kinetic_energy(m, q, v),
    "potential_energy": lambda m, q, v, a: axode.potential_energy(m, q),
    "centroidal_inertia": lambda m, q, v, a: axode.centroidal_inertia(m, q),
    "regressor": lambda m, q, v, a: axode.regressor(m, q, v, a),
    "kinetic_energy_regressor": lambda m, q, v, a: axode.kinetic_energy_regressor(m, q, v),
    "potential_energy_regressor": lambda m, q, v, a: axode.potential_energy_regressor(m, q),
    "momenta": lambda m, q, v, a: axode.momenta(m, q, v),
    "from_momenta": lambda m, q, v, a: axode.from_momenta(m, q, v),
    "momentum_form": lambda m, q, v, a: np.stack(axode.momentum_form(m, q, v, a, load_on(m, q)), axis=-2),
    "spatial_momentum": lambda m, q, v, a: axode.spatial_momentum(m, q, v),
    "centroidal_momentum": lambda m, q, v, a: axode.centroidal_momentum(m, q, v),
    "spatial_momentum_form": lambda m, q, v, a: axode.spatial_momentum_form(
        m, q, axode.body_momenta(m, q, v, "spatial"), a)[1],
}
for name in ["inverse_dynamics", "forward_dynamics"]:
    CALLS |= {
        f"{name}_derivatives": lambda m, q, v, a, name=name: np.stack(getattr(axode, f"{name}_derivatives")(
            m, q, v, a, load_on(m, q), joint_losses=True), axis=-3),
        f"{name}_jvp": lambda m, q, v, a, name=name: getattr(axode, f"{name}_jvp")(
            m, q, v, a, v, a, 2 * v, load_on(m, q)),
        f"{name}_vjp": lambda m, q, v, a, name=name: np.stack(getattr(axode, f"{name}_vjp")(
            m, q, v, a, v - a, load_on(m, q)), axis=-2),
        f"{name}_hessian": lambda m, q, v, a, name=name: np.stack(getattr(axode, f"{name}_hessian")(
            m, q, v, a, v - a, load_on(m, q)), axis=-3),
    }
    CALLS |= {
        f"{name}_geometry_derivatives": lambda m, q, v, a, name=name: getattr(axode, f"{name}_geometry_derivatives")(
            m, q, v, a, load_on(m, q)),
        f"{name}_geometry_vjp": lambda m, q, v, a, name=name: getattr(axode, f"{name}_geometry_vjp")(
            m, q, v, a, v - a, load_on(m, q)),
    }
    CALLS[f"{name}_second_derivatives"] = lambda m, q, v, a, name=name: np.stack(
        getattr(axode, f"{name}_second_derivatives")(m, q, v, a), axis=-4)
CALLS["inverse_dynamics_rates"] = lambda m, q, v, a: np.stack(axode.inverse_dynamics_rates(
    m, q, v, a, v, v * a, loads=load_on(m, q)), axis=-2)
CALLS |= {
    "gravity_derivatives": lambda m, q, v, a: axode.gravity_derivatives(m, q),
    "coriolis_derivatives": lambda m, q, v, a: np.stack(axode.coriolis_derivatives(m, q, v), axis=-3),
    "generalized_load_derivatives": lambda m, q, v, a: np.stack(axode.generalized_load_derivatives(
        m, q, v, load_on(m, q), joint_losses=True), axis=-3),
    "spring_force_derivatives": lambda m, q, v, a: np.stack(axode.spring_force_derivatives(m, q, v), axis=-3),
    "rollout": lambda m, q, v, a: axode.rollout(m, q, v, np.stack([a, 0.5 * a], axis=-2), 1e-4)[1],
    "rollout_derivatives": lambda m, q, v, a: np.concatenate(axode.rollout_derivatives(
        m, q, v, np.stack([a, 0.5 * a], axis=-2), 1e-4), axis=-1),
    "rollout_jvp": lambda m, q, v, a: np.stack(axode.rollout_jvp(
        m, q, v, np.stack([a, 0.5 * a], axis=-2), 1e-4, v, a, np.stack([v, a], axis=-2)), axis=-3),
    "rollout_vjp": lambda m, q, v, a: axode.rollout_vjp(
        m, q, v, np.stack([a, 0.5 * a], axis=-2), 1e-4, *2 * [np.stack([v, a, v], axis=-2)]).tau,
    "momentum_form_derivatives": lambda m, q, v, a: np.stack(axode.momentum_form_derivatives(
        m, q, a, load_on(m, q)), axis=-3),
    "kinetic_energy_gradient": lambda m, q, v, a: np.stack(axode.kinetic_energy_gradient(m, q, v), axis=-2),
    "frame_geometry_jacobian": lambda m, q, v, a: axode.frame_geometry_jacobian(m, q, tool(m)),
    "jacobian_geometry_derivatives": lambda m, q, v, a: axode.jacobian_geometry_derivatives(m, q, tool(m)),
}
CALLS["linearize"] = lambda m, q, v, a: np.concatenate(axode.linearize(m, q, v, a, load_on(m, q), joint_losses=True),
                                                       axis=-1)
for form in ["paper", "skew", "spatial", "christoffel"]:
    CALLS[f"coriolis_matrix {form}"] = lambda m, q, v, a, form=form: axode.coriolis_matrix(m, q, v, form)
for rep in REPRESENTATIONS:
    CALLS |= {
        f"twists {rep}": lambda m, q, v, a, rep=rep: axode.twists(m, q, v, rep),
        f"accelerations {rep}": lambda m, q, v, a, rep=rep: axode.accelerations(m, q, v, a, rep),
        f"jacobian {rep}": lambda m, q, v, a, rep=rep: axode.jacobian(m, q, tool(m), rep),
        f"jacobian {rep} of a point": lambda m, q, v, a, rep=rep: axode.jacobian(m, q, tool(m), rep, offset=[1, 2, 3]),
        f"jacobians {rep}": lambda m, q, v, a, rep=rep: axode.jacobians(m, q, representation=rep),
        f"jacobians {rep} of two frames": lambda m, q, v, a, rep=rep: axode.jacobians(m, q, [tool(m), 0], rep),
        f"jacobian_rate {rep}": lambda m, q, v, a, rep=rep: axode.jacobian_rate(m, q, v, tool(m), rep),
        f"jacobian_partials {rep}": lambda m, q, v, a, rep=rep: axode.jacobian_partials(m, q, tool(m), rep, 2),
        f"jacobian_derivative_along {rep}": lambda m, q, v, a, rep=rep: axode.jacobian_derivative_along(
            m, q, tool(m), np.stack([v, a], axis=-2), rep),
        f"relative_jacobian {rep}": lambda m, q, v, a, rep=rep: axode.relative_jacobian(
            m, q, tool(m), m.body_names[0], rep),
        f"twist_derivatives {rep}": lambda m, q, v, a, rep=rep: axode.twist_derivatives(
            m, q, rates(v, a), tool(m), rep),
        f"jacobian_derivatives {rep}": lambda m, q, v, a, rep=rep: axode.jacobian_derivatives(
            m, q, rates(v, a), tool(m), rep),
        f"inverse_dynamics {rep}": lambda m, q, v, a, rep=rep: axode.inverse_dynamics(m, q, v, a, rep),
        f"forward_dynamics {rep}": lambda m, q, v, a, rep=rep: axode.forward_dynamics(m, q, v, a, rep),
        f"mass_matrix {rep}": lambda m, q, v, a, rep=rep: axode.mass_matrix(m, q, rep),
        f"inverse_mass_matrix {rep}": lambda m, q, v, a, rep=rep: axode.inverse_mass_matrix(m, q, rep),
        f"joint_wrenches {rep}": lambda m, q, v, a, rep=rep: axode.joint_wrenches(m, q, v, a, rep, load_on(m, q)),
        f"impulse_response {rep}": lambda m, q, v, a, rep=rep: axode.impulse_response(m, q, tool(m), rep),
        f"inverse_operational_space_inertia {rep}": lambda m, q, v, a, rep=rep: axode.inverse_operational_space_inertia(
            m, q, tool(m), rep
        ),
        f"operational_space_inertia {rep}": lambda m, q, v, a, rep=rep: axode.operational_space_inertia(
            m, q, tool(m), rep),
        f"body_momenta {rep}": lambda m, q, v, a, rep=rep: axode.body_momenta(m, q, v, rep),
        f"motion_derivatives {rep}": lambda m, q, v, a, rep=rep: np.stack(axode.motion_derivatives(
            m, q, v, a, tool(m), rep), axis=-3),
        f"motion_jvp {rep}": lambda m, q, v, a, rep=rep: np.stack(axode.motion_jvp(
            m, q, v, a, tool(m), a, v, a, rep), axis=-2),
        f"motion_vjp {rep}": lambda m, q, v, a, rep=rep: np.stack(axode.motion_vjp(
            m, q, v, a, tool(m), np.broadcast_to(np.arange(18.0).reshape(3, 6), (*q.shape[:-1], 3, 6)), rep), axis=-2),
        f"twist_form {rep}": lambda m, q, v, a, rep=rep: axode.twist_form(
            m, q, bodies_of(m, axode.twists(m, q, v, rep)), a, rep)[1],
    }
