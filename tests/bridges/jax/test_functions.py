"""Functions of axode.jax give the same results as those of axode, under every transformation that applies them to
many states."""

import axode
import axode.jax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mechanisms import MECHANISMS, close, random_states

SHORT = 1e-5  # s; the machine moves fast


def functions(m):
    """Name -> the function of axode.jax, that of axode, and the arguments that they take out of q, v and two more."""
    last = m.frame_names[-1]
    point = [0.1, -0.2, 0.3]
    return {
        "inverse_dynamics": (axode.jax.inverse_dynamics, axode.inverse_dynamics, "qvx", {}),
        "losses": (axode.jax.inverse_dynamics, axode.inverse_dynamics, "qvx", {"joint_losses": True}),
        "forward_dynamics": (axode.jax.forward_dynamics, axode.forward_dynamics, "qvx", {}),
        "forward losses": (axode.jax.forward_dynamics, axode.forward_dynamics, "qvx", {"joint_losses": True}),
        "mass_matrix": (axode.jax.mass_matrix, axode.mass_matrix, "q", {}),
        "inverse_mass_matrix": (axode.jax.inverse_mass_matrix, axode.inverse_mass_matrix, "q", {}),
        "gravity_torques": (axode.jax.gravity_torques, axode.gravity_torques, "q", {}),
        "coriolis_vector": (axode.jax.coriolis_vector, axode.coriolis_vector, "qv", {}),
        "momenta": (axode.jax.momenta, axode.momenta, "qv", {}),
        "kinetic_energy": (axode.jax.kinetic_energy, axode.kinetic_energy, "qv", {}),
        "potential_energy": (axode.jax.potential_energy, axode.potential_energy, "q", {}),
        "center_of_mass": (axode.jax.center_of_mass, axode.center_of_mass, "q", {}),
        "poses": (axode.jax.poses, axode.poses, "q", {}),
        "integrate": (axode.jax.integrate, axode.Model.integrate, "qv", {}),
        "coordinate_rates": (axode.jax.coordinate_rates, axode.Model.coordinate_rates, "qv", {}),
        **{f"{name} {form}": (getattr(axode.jax, name), getattr(axode, name), of, {"representation": form})
           for name, of in (("twists", "qv"), ("accelerations", "qvx")) for form in ("body", "spatial", "hybrid", "mixed")},
        **{f"jacobian {form}": (axode.jax.jacobian, axode.jacobian, "q",
                                {"frame": last, "representation": form, "offset": point})
           for form in ("body", "spatial", "hybrid", "mixed")},
        "jacobian of a pose": (axode.jax.jacobian, axode.jacobian, "q",
                               {"frame": last, "offset": axode.lie.exp([0.1, 0.2, 0.3, 1, 2, 3])}),
    }


@pytest.mark.parametrize("name", MECHANISMS)
def test_values_are_those_of_axode(name):
    m = MECHANISMS[name]
    q, v, x, _ = random_states(m, 5)
    given = {"q": q, "v": v, "x": x}

    @jax.jit
    def all_of(given):
        return {function: here(m, *(given[each] for each in of), **more)
                for function, (here, _, of, more) in functions(m).items()}

    found = all_of(given)
    for function, (_, there, of, more) in functions(m).items():
        assert close(np.asarray(found[function]), there(m, *(given[each] for each in of), **more)), function


@pytest.mark.parametrize("name", MECHANISMS)
def test_rollouts_are_those_of_axode(name):
    m = MECHANISMS[name]
    q, v, tau, _ = random_states(m, 4)
    tau = np.stack([tau, 2 * tau, -tau], axis=1)
    for k in (0, 1):
        assert close(np.asarray(axode.jax.rollout(m, q, v, tau, SHORT)[k]), axode.rollout(m, q, v, tau, SHORT)[k])
        assert close(np.asarray(axode.jax.rollout(m, q[0], v[0], tau[0], SHORT)[k]),
                     axode.rollout(m, q[0], v[0], tau[0], SHORT)[k])


@pytest.mark.parametrize("name", MECHANISMS)
def test_velocities_are_found_from_rates(name):
    m = MECHANISMS[name]
    q, v, _, _ = random_states(m, 3)
    there_and_back = jax.jit(lambda q, v: axode.jax.velocities_from_rates(m, q, axode.jax.coordinate_rates(m, q, v)))
    assert close(np.asarray(there_and_back(q, v)), v)


def test_a_batch_is_one_call_whatever_its_axes():
    m = MECHANISMS["humanoid"]
    q, v, x, _ = random_states(m, 6)
    expected = axode.forward_dynamics(m, q, v, x).reshape(2, 3, m.nv)
    q, v, x = (each.reshape(2, 3, -1) for each in (q, v, x))
    f = lambda q, v, x: axode.jax.forward_dynamics(m, q, v, x)  # noqa: E731
    for g in (f, jax.vmap(f), jax.vmap(jax.vmap(f)), jax.vmap(jax.vmap(f), in_axes=1, out_axes=1)):
        program = jax.jit(g).lower(q, v, x)
        assert program.as_text().count("@axode_state_function") == 1
        assert np.array_equal(program.compile()(q, v, x), expected)


def test_what_is_the_same_for_all_is_not_given_for_each():
    m = MECHANISMS["arm"]
    q, v, x, _ = random_states(m, 4)
    expected = axode.inverse_dynamics(m, q, np.tile(v[0], (4, 1)), np.tile(x[0], (4, 1)))
    assert np.array_equal(axode.jax.inverse_dynamics(m, q, v[0], x[0]), expected)
    assert np.array_equal(jax.vmap(lambda q: axode.jax.inverse_dynamics(m, q, v[0], x[0]))(q), expected)
    turned = jax.vmap(lambda v: axode.jax.inverse_dynamics(m, q[0], v, x[0]), in_axes=1)(v.T)
    assert np.array_equal(turned, axode.inverse_dynamics(m, np.tile(q[0], (4, 1)), v, np.tile(x[0], (4, 1))))


@pytest.mark.parametrize("shape", [(0,), (3, 0), (1, 1)])
def test_any_number_of_states(shape):
    m = MECHANISMS["machine"]
    q = np.zeros((*shape, m.nq))
    q[...] = m.neutral()
    v, tau = np.zeros((*shape, m.nv)), np.zeros((*shape, 2, m.nv))
    assert axode.jax.forward_dynamics(m, q, v, v).shape == (*shape, m.nv)
    assert axode.jax.rollout(m, q, v, tau, SHORT)[0].shape == (*shape, 3, m.nq)
    assert axode.jax.rollout(m, q, v, tau[..., :0, :], SHORT)[0].shape == (*shape, 1, m.nq)
    gradient = jax.jit(jax.grad(lambda q: jnp.sum(axode.jax.inverse_dynamics(m, q, v, v))))(q)
    assert gradient.shape == q.shape and np.all(np.isfinite(gradient))


def test_a_model_that_cannot_move():
    m = axode.Builder("block").body("block", joint="fixed", mass=1, com=[0, 0, 0], inertia=[1, 1, 1]).build()
    for lead in ((), (4,)):
        none = np.zeros((*lead, 0))
        assert axode.jax.inverse_dynamics(m, none, none, none).shape == (*lead, 0)
        assert axode.jax.mass_matrix(m, none).shape == (*lead, 0, 0)
        assert np.array_equal(axode.jax.poses(m, none), np.broadcast_to(axode.poses(m, np.zeros(0)), (*lead, m.n_frames, 4, 4)))
        assert axode.jax.rollout(m, none, none, np.zeros((*lead, 2, 0)), 0.1)[0].shape == (*lead, 3, 0)


def test_inside_loops_and_branches_of_jax():
    m = MECHANISMS["arm"]
    q, v, tau, _ = random_states(m, 1)
    h = 1e-3

    def step(state, force):
        q, v = state
        v = v + h * axode.jax.forward_dynamics(m, q, v, force)
        return (axode.jax.integrate(m, q, h * v), v), q

    def end(force):
        return jax.lax.scan(step, (q[0], v[0]), jnp.tile(force, (10, 1)))[0][1][-1]

    q_k, v_k = q[0], v[0]
    for _ in range(10):
        v_k = v_k + h * axode.forward_dynamics(m, q_k, v_k, tau[0])
        q_k = q_k + h * v_k
    assert np.allclose(jax.jit(end)(tau[0]), v_k[-1])
    assert close(np.asarray(jax.jit(jax.grad(end))(tau[0])), np.asarray(jax.jit(jax.jacfwd(end))(tau[0])))


def test_threads_change_no_bit():
    m = MECHANISMS["humanoid"]
    q, v, x, _ = random_states(m, 50)
    assert np.array_equal(axode.jax.forward_dynamics(m, q, v, x, threads=2), axode.jax.forward_dynamics(m, q, v, x))
    assert np.array_equal(axode.jax.poses(m, q, threads=2), axode.jax.poses(m, q))
