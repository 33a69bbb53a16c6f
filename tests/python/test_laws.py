"""Functions without a row in the table return their numbers in the places, axes and orders that the docstrings state.

Functions with a row are compared with the command in test_table.py.
"""

import axode
import numpy as np
import pytest
from calls import load_on, tool
from mechanisms import MECHANISMS, REPRESENTATIONS, close, random_states

EVERYWHERE = pytest.mark.parametrize("mechanism", MECHANISMS)
EVERY_WAY = pytest.mark.parametrize("representation", REPRESENTATIONS)


def state(mechanism, seed=1):
    m = MECHANISMS[mechanism]
    return m, *(x[0] for x in random_states(m, 1, seed))


def rate(m, q, v, f, h=1e-5):
    """The rate of f along v, by central differences."""
    return (f(m.integrate(q, h * v)) - f(m.integrate(q, -h * v))) / (2 * h)


@EVERYWHERE
@EVERY_WAY
def test_jacobians_give_twists_and_accelerations_by_names_numbers_and_columns(mechanism, representation):
    m, q, v, a, _ = state(mechanism)
    V, dV = axode.twists(m, q, v, representation), axode.accelerations(m, q, v, a, representation)
    J_all = axode.jacobians(m, q, representation=representation)
    assert np.array_equal(axode.jacobians(m, q, m.frame_names[::-1], representation), J_all[::-1])
    for k, frame in enumerate(m.frame_names):
        J, dJ = axode.jacobian(m, q, frame, representation), axode.jacobian_rate(m, q, v, frame, representation)
        assert close(J @ v, V[k]) if k else not (J @ v).any()
        assert close(J @ a + dJ @ v, dV[k]) if k else not (J @ a).any()
        assert m.frame_index(frame) == k
        assert np.array_equal(axode.jacobian(m, q, k, representation), J)
        assert np.array_equal(axode.jacobian(m, q, np.int32(k), representation), J)
        velocities, columns = axode.jacobian_columns(m, q, frame, representation)
        dense = np.zeros((6, m.nv))
        np.add.at(dense.T, velocities, columns.T)
        assert close(dense, J)


@EVERYWHERE
@EVERY_WAY
def test_higher_derivatives_continue_the_lower_ones(mechanism, representation):
    m, q, v, a, jerk = state(mechanism)
    frame, k = tool(m), m.frame_names.index(tool(m))
    J = lambda x: axode.jacobian(m, x, frame, representation)
    first = axode.jacobian_partials(m, q, frame, representation)
    assert first.shape == (m.nv, 6, m.nv) and close(first[1], rate(m, q, np.eye(m.nv)[1], J), 1e-7)
    outer = rate(m, q, v, lambda x: axode.jacobian_derivative_along(m, x, frame, [a], representation))
    assert close(axode.jacobian_derivative_along(m, q, frame, [a, v], representation), outer, 1e-6)
    if m.nv < 20:
        second = axode.jacobian_partials(m, q, frame, representation, order=2)
        assert close(np.einsum("kl...,k,l->...", second, v, a), outer, 1e-6)
    found = axode.twist_derivatives(m, q, [v, a, jerk], frame, representation)
    assert close(found[0], axode.twists(m, q, v, representation)[k])
    assert close(found[1], axode.accelerations(m, q, v, a, representation)[k])
    J = axode.jacobian_derivatives(m, q, [v, a, jerk], frame, representation)
    assert close(J[0], axode.jacobian(m, q, frame, representation))
    assert close(J[1], axode.jacobian_rate(m, q, v, frame, representation))
    assert close(J[2] @ v + 2 * J[1] @ a + J[0] @ jerk, found[2])


@EVERYWHERE
def test_the_first_axis_of_partials_is_the_coordinate(mechanism):
    m, q, v, _, _ = state(mechanism)
    assert close(np.tensordot(v, axode.mass_matrix_partials(m, q), 1),
                 rate(m, q, v, lambda x: axode.mass_matrix(m, x)), 1e-7)
    assert close(axode.christoffel(m, q) @ v, axode.coriolis_matrix(m, q, v, "christoffel"))
    assert isinstance(axode.kinetic_energy(m, q, v), float)


@EVERYWHERE
def test_offsets_move_the_frame(mechanism):
    m, q, v, _, _ = state(mechanism)
    J, p = axode.jacobian(m, q, tool(m), "hybrid"), np.array([0.3, -0.2, 0.5])
    C = axode.poses(m, q)[m.frame_names.index(tool(m))]
    moved = axode.jacobian(m, q, tool(m), "hybrid", offset=p) @ v
    assert close(moved, np.append((J @ v)[:3], (J @ v)[3:] + np.cross((J @ v)[:3], C[:3, :3] @ p)))
    S = np.eye(4)
    S[:3, 3] = p
    assert close(axode.jacobian(m, q, tool(m), "hybrid", offset=S) @ v, moved)


@EVERYWHERE
@EVERY_WAY
def test_states_in_twists_and_momenta_have_the_rates_of_the_joints(mechanism, representation):
    m, q, v, _, tau = state(mechanism)
    loads = load_on(m, q)
    a = axode.forward_dynamics(m, q, v, tau, loads=loads)
    bodies = slice(1, 1 + m.n_bodies)
    V = axode.twists(m, q, v, representation)[bodies]
    found, dV = axode.twist_form(m, q, V, tau, representation, loads)
    assert close(found, v, 1e-9)
    assert close(dV, axode.accelerations(m, q, v, a, representation)[bodies], 1e-8)
    found, dPi = axode.spatial_momentum_form(m, q, axode.body_momenta(m, q, v, "spatial"), tau, loads)
    assert close(found, v, 1e-9)
    h = 1e-7  # some accelerations are large
    at = [axode.body_momenta(m, m.integrate(q, s * v + s * s / 2 * a), v + s * a, "spatial") for s in (h, -h)]
    assert close(dPi, (at[0] - at[1]) / (2 * h), 1e-6)


@EVERYWHERE
def test_the_linear_system_has_the_derivatives_of_forward_dynamics_and_the_brackets_of_the_joints(mechanism):
    m, q, v, tau, _ = state(mechanism)
    loads, nv = load_on(m, q), m.nv
    A, B = axode.linearize(m, q, v, tau, loads, joint_losses=True)
    d = axode.forward_dynamics_derivatives(m, q, v, tau, loads, joint_losses=True)
    assert np.array_equal(A[nv:], np.hstack([d.q, d.v])) and np.array_equal(B[nv:], d.tau)
    assert np.array_equal(A[:nv, nv:], np.eye(nv)) and not B[:nv].any()
    for joint in m.joints:
        if joint.kind == "free":
            assert close(A[joint.v, joint.v] + 1, 1 - axode.lie.ad(v[joint.v]))
        if joint.nv == 1:
            assert not A[joint.v, :nv].any()


def test_a_pendulum_rests_where_its_drive_holds_it():
    m = axode.Model.from_bodies([{"name": "bob", "joint": {"kind": "revolute", "axis": [0, -1, 0], "point": [0, 0, 0]},
                                  "mass": 1, "com": [0, 0, -1], "inertia": [0, 0, 0]}])
    found = axode.equilibrium(m, [0.1], [9.81 / 2])
    assert found.status == "solved" and found.residual <= 1e-9 and close(found.q, [np.pi / 6], 1e-9)
    assert axode.equilibrium(m, [0.1], [9.82]).status == "stalled"
    turned = axode.Load(frame="bob", representation="hybrid", wrench=[0, -1, 0, 0, 0, 0])
    lifted = axode.equilibrium(m, [0.1], loads=[turned])
    assert close(lifted.q, [np.arcsin(1 / 9.81)], 1e-9)
    assert axode.equilibrium(m, [0.1], iterations=1).status == "iteration_limit"
    for arguments, more, sentence in [(([0.1],), {"tolerance": 0}, "equilibrium: tolerance is 0; it must be positive"),
                                      (([0.1], [1, 2]), {}, r"tau: expected shape \(1,\)"),
                                      (([[0.1]],), {}, "q0: expected shape")]:
        with pytest.raises(ValueError, match=sentence):
            axode.equilibrium(m, *arguments, **more)


def test_a_solved_target_is_reached():
    m = MECHANISMS["arm"]
    goal = axode.poses(m, m.random(4))[m.frame_names.index("flange")]
    found = axode.inverse_kinematics(m, [axode.Target(frame="flange", pose=goal)], m.neutral())
    assert found.status == "solved" and close(axode.poses(m, found.q)[m.frame_names.index("flange")], goal, 1e-8)
    goal[:3, 3] = 10
    assert axode.inverse_kinematics(m, [{"frame": "flange", "pose": goal}], m.neutral(), restarts=2).status != "solved"
    with pytest.raises(ValueError, match="targets.0..pose: expected a pose"):
        axode.inverse_kinematics(m, [{"frame": "flange", "pose": 2 * np.eye(4)}], m.neutral())
    with pytest.raises(KeyError, match="targets.0. has no pose"):
        axode.inverse_kinematics(m, [{"frame": "flange"}], m.neutral())


def test_the_factor_of_the_mass_matrix_is_lower_triangular():
    m, q, _, _, _ = state("humanoid")
    M = axode.mass_matrix(m, q)
    factor = axode.MassMatrixFactor(m, M)
    L = factor.L
    assert np.array_equal(L, np.tril(L)) and close(L.T @ np.diag(factor.D) @ L, M)
    assert close(factor.inverse(), axode.inverse_mass_matrix(m, q), 1e-9)
    assert close(factor.solve(M), np.eye(m.nv), 1e-9)
    with pytest.raises(ValueError, match=r"x: expected shape \(\d+,\) or \(N, \d+\), got \(3,\)"):
        factor.solve(np.ones(3))
    with pytest.raises(ValueError, match="M: expected shape"):
        axode.MassMatrixFactor(m, M[:2])
