"""Derivatives of axode.jax, in forward mode, in reverse mode and of second order, equal those of the functions of
plain numbers."""

import axode
import axode.jax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mechanisms import MECHANISMS, close, random_states

SHORT = 1e-5  # s; the machine moves fast
NEAR = 4e-7  # of quaternions that are not refused


def differences(f, x):
    """The derivatives by each number of the argument, along an additional last axis."""
    step = np.eye(x.size).reshape(x.size, *x.shape) * NEAR
    columns = [(np.asarray(f(x + d)) - np.asarray(f(x - d))) / (2 * NEAR) for d in step]
    return np.stack(columns, axis=-1).reshape(*np.shape(columns[0]), *x.shape)


def scalars(m):
    """Functions of q that return a weighted sum of all results."""
    random = np.random.default_rng(1)
    q, v, x, _ = random_states(m, 1)
    _, v, x = q[0], v[0], x[0]

    # Entries of very different sizes make large ones.
    size = np.diagonal(axode.inverse_mass_matrix(m, q[0])) ** -0.5

    def weigh(f):
        shape = jax.eval_shape(f, q[0]).shape
        weights = random.uniform(-1, 1, shape)
        return lambda q: jnp.sum(weights * f(q))

    return q[0], {
        "inverse_dynamics": weigh(lambda q: axode.jax.inverse_dynamics(m, q, v, x, joint_losses=True)),
        "forward_dynamics": weigh(lambda q: axode.jax.forward_dynamics(m, q, v, 1e-2 * x)),
        "mass_matrix": weigh(lambda q: axode.jax.mass_matrix(m, q)),
        "inverse_mass_matrix": weigh(lambda q: size * axode.jax.inverse_mass_matrix(m, q) * size[:, None]),
        "kinetic_energy": weigh(lambda q: axode.jax.kinetic_energy(m, q, v)),
        "potential_energy": weigh(lambda q: axode.jax.potential_energy(m, q)),
        "poses": weigh(lambda q: axode.jax.poses(m, q)),
        "jacobian": weigh(lambda q: axode.jax.jacobian(m, q, m.frame_names[-1], "mixed", offset=[0.1, 0.2, 0.3])),
    }


@pytest.mark.parametrize("name, function", [
    *(("machine", function) for function in ("inverse_dynamics", "forward_dynamics", "inverse_mass_matrix", "jacobian")),
    *(("arm", function) for function in ("forward_dynamics", "mass_matrix", "kinetic_energy", "potential_energy", "poses")),
    ("humanoid", "inverse_dynamics")])
def test_gradients_and_hessians_are_those_of_differences(name, function):
    q, all_functions = scalars(MECHANISMS[name])
    f = all_functions[function]
    gradient = jax.jit(jax.grad(f))
    many = jax.jit(jax.vmap(f))
    step = NEAR * np.eye(q.size)
    by_differences = (many(q + step) - many(q - step)) / (2 * NEAR)
    assert close(np.asarray(gradient(q)), np.asarray(by_differences), 3e-5)
    H = np.asarray(jax.jit(jax.hessian(f))(q))
    assert close(H, H.T, 1e-10)
    assert close(H, differences(gradient, q), 1e-5)


@pytest.mark.parametrize("name, function", [("machine", axode.jax.inverse_dynamics), ("arm", axode.jax.forward_dynamics)])
def test_forward_and_reverse_mode_agree_in_any_order(name, function):
    m = MECHANISMS[name]
    q, v, x, _ = (each[0] for each in random_states(m, 1))
    f = lambda q, v, x: function(m, q, v, x)  # noqa: E731
    forward, reverse = (jax.jit(D(f, argnums=(0, 1, 2)))(q, v, x) for D in (jax.jacfwd, jax.jacrev))
    assert all(close(np.asarray(a), np.asarray(b)) for a, b in zip(forward, reverse))
    s = lambda q, v, x: jnp.dot(v, f(q, v, x))  # noqa: E731
    ways = [(jax.jacrev, jax.jacrev), (jax.jacfwd, jax.jacfwd), *([(jax.jacfwd, jax.jacrev)] if name == "arm" else [])]
    seconds = [jax.jit(D(E(s, argnums=(0, 1, 2)), argnums=(0, 1, 2)))(q, v, x) for D, E in ways]
    for other in seconds[1:]:
        assert all(close(np.asarray(a), np.asarray(b), 1e-9)
                   for a, b in zip(jax.tree.leaves(seconds[0]), jax.tree.leaves(other)) if np.any(a))


@pytest.mark.parametrize("name", MECHANISMS)
def test_rollouts(name):
    m = MECHANISMS[name]
    q, v, x, _ = (each[0] for each in random_states(m, 1))
    tau = np.stack([x, -x])
    step = SHORT if name == "machine" else 1e-2
    random = np.random.default_rng(2)
    w_q, w_v = random.uniform(-1, 1, (3, m.nq)), random.uniform(-1, 1, (3, m.nv))

    def f(q, v, tau):
        q, v = axode.jax.rollout(m, q, v, tau, step)
        return jnp.sum(w_q * q) + jnp.sum(w_v * v)

    reverse = jax.jit(jax.grad(f, argnums=(0, 1, 2)))(q, v, tau)
    forward = jax.jit(jax.jacfwd(f, argnums=(0, 1, 2)))(q, v, tau)
    assert all(close(np.asarray(a), np.asarray(b), 1e-10) for a, b in zip(reverse, forward))
    f = jax.jit(f)
    assert close(np.asarray(reverse[0]), differences(lambda q: f(q, v, tau), q), 3e-5)
    assert close(np.asarray(reverse[1]), differences(lambda v: f(q, v, tau), v), 1e-6)
    if name != "machine":  # whose forces of 1 N do little in 20 us
        assert close(np.asarray(reverse[2]), differences(lambda tau: f(q, v, tau), tau), 1e-5)


def test_gradients_of_many_states_are_those_of_each():
    m = MECHANISMS["humanoid"]
    q, v, x, _ = random_states(m, 7)
    gradient = jax.grad(lambda q, v: jnp.sum(axode.jax.inverse_dynamics(m, q, v, v) ** 2))
    together = jax.jit(jax.vmap(gradient))
    assert together.lower(q, v).as_text().count("@axode_state_function") <= 2  # the value and the product
    one = jax.jit(gradient)
    assert close(np.asarray(together(q, v)), np.array([one(*each) for each in zip(q, v)]))


def test_a_quaternion_has_no_derivative_along_itself():
    m = MECHANISMS["humanoid"]
    q, v, x, _ = (each[0] for each in random_states(m, 1))
    gradient = np.asarray(jax.jit(jax.grad(lambda q: jnp.sum(axode.jax.inverse_dynamics(m, q, v, x))))(q))
    assert abs(gradient[:4] @ q[:4]) < 1e-12 * np.abs(gradient).max()
    by_velocities = axode.inverse_dynamics_vjp(m, q, v, x, np.ones(m.nv)).q
    assert close(gradient @ m.coordinate_rates(q, v), by_velocities @ v)
    assert close(np.asarray(axode.jax.inverse_dynamics(m, q * (1 + 5e-7), v, x)),
                 axode.inverse_dynamics(m, m.normalize(q * np.where(np.arange(m.nq) < 4, 1, 1 + 5e-7)), v, x), 1e-9)


def test_small_turns_have_derivatives():
    m = MECHANISMS["machine"]
    q = m.random(seed=1)
    weights = np.random.default_rng(3).uniform(-1, 1, m.nq)
    f = lambda dv: jnp.dot(weights, axode.jax.integrate(m, q, dv))  # noqa: E731
    gradient = jax.jit(jax.grad(f))
    for size in (0.0, 1e-9, 0.09, 0.11, 2.0):
        dv = size * np.random.default_rng(4).uniform(-1, 1, m.nv)
        steps = 1e-5 * np.eye(m.nv)
        values = [(weights @ m.integrate(q, dv + d) - weights @ m.integrate(q, dv - d)) / 2e-5 for d in steps]
        assert close(np.asarray(gradient(dv)), np.array(values), 1e-8)
    second = jax.jit(lambda dv, w: jax.jvp(jax.grad(f), (dv,), (w,))[1])
    w = np.ones(m.nv)
    by_differences = (gradient(1e-5 * w) - gradient(-1e-5 * w)) / 2e-5
    assert close(np.asarray(second(np.zeros(m.nv), w)), np.asarray(by_differences), 1e-8)


def test_what_has_no_derivative_says_so():
    m = MECHANISMS["arm"]
    q, v, x, _ = (each[0] for each in random_states(m, 1))
    third = jax.jacfwd(jax.hessian(lambda q: axode.jax.inverse_dynamics(m, q, v, x)[0]))
    with pytest.raises(NotImplementedError, match="first and second derivatives of inverse_dynamics; a third"):
        jax.eval_shape(third, q)
    with pytest.raises(NotImplementedError, match="first derivatives of rollout; a second .* forward_dynamics"):
        jax.eval_shape(jax.hessian(lambda q: axode.jax.rollout(m, q, v, x[None], 0.01)[1][-1, 0]), q)


def test_kinematics_have_derivatives_of_any_order():
    m = axode.load(axode.robots / "double_pendulum.toml")
    f = lambda x: axode.jax.potential_energy(m, jnp.array([0.3, 0.0]) + x * jnp.array([0.0, 1.0]))  # noqa: E731
    first = jax.grad(f)
    # The second derivative of a cosine.
    assert close(np.asarray(jax.jit(jax.grad(jax.grad(first)))(0.5)), -np.asarray(jax.jit(first)(0.5)))


@pytest.mark.parametrize("name", ["machine", "arm"])
@pytest.mark.parametrize("here, there", [(axode.jax.inverse_dynamics, axode.inverse_dynamics),
                                         (axode.jax.forward_dynamics, axode.forward_dynamics)])
def test_inertial_parameters(name, here, there):
    m = MECHANISMS[name]
    q, v, x, _ = random_states(m, 6)
    pi = m.parameters * np.random.default_rng(5).uniform(1, 1.1, (3, 1))
    of_each = np.repeat(pi, 2, axis=0)
    f = jax.jit(lambda q, pi: here(m, q, v, x, parameters=pi))
    expected = [there(m.with_parameters(pi[k]), q[2 * k:2 * k + 2], v[2 * k:2 * k + 2], x[2 * k:2 * k + 2]) for k in range(3)]
    assert close(np.asarray(f(q, of_each)), np.concatenate(expected))

    weights = np.random.default_rng(6).uniform(-1, 1, x.shape)
    gradient = jax.jit(jax.grad(lambda q, pi: jnp.sum(weights * here(m, q, v, x, parameters=pi)), argnums=(0, 1)))(q, of_each)
    along = 1e-4 * m.parameters
    ends = [np.sum(weights * f(q, of_each + s * along)) for s in (-1, 1)]
    assert close(np.sum(gradient[1] @ along), (ends[1] - ends[0]) / 2, 1e-5)
    without = jax.jit(jax.grad(lambda q: jnp.sum(weights[:2] * here(m.with_parameters(pi[0]), q, v[:2], x[:2]))))(q[:2])
    assert close(np.asarray(gradient[0][:2]), np.asarray(without))


def test_inertial_parameters_have_first_derivatives():
    m = MECHANISMS["arm"]
    q, v, x, _ = (each[0] for each in random_states(m, 1))
    f = lambda q, pi: axode.jax.forward_dynamics(m, q, v, x, parameters=pi)[1]  # noqa: E731
    for argnums in (1, (0, 1)):
        with pytest.raises(NotImplementedError, match="first derivatives by inertial parameters; a second"):
            jax.eval_shape(jax.hessian(f, argnums=argnums), q, m.parameters)
    H = jax.jit(jax.hessian(f))(q, m.parameters)
    assert close(np.asarray(H), np.asarray(jax.jit(jax.hessian(lambda q: axode.jax.forward_dynamics(m, q, v, x)[1]))(q)))
    with pytest.raises(ValueError, match=r"parameters: expected shape \(..., 70\) with ten for each body, got \(7,\)"):
        axode.jax.forward_dynamics(m, q, v, x, parameters=q)


#: Two balls on a floor: one slides, and one meets it.
TABLE = axode.Model.from_dict({
    "format": "axode drawing 1", "shape": [{"kind": "plane", "role": "collision", "friction": 0.3}],
    "body": [{"name": name, "joint": "free", "mass": 1, "com": [0.01, 0, 0.02], "inertia": [4e-3, 5e-3, 6e-3], "shape": [
        {"kind": "sphere", "role": "collision", "radius": 0.1, "friction": 0.3, "restitution": 0.5}]} for name in ("slider", "bouncer")]})
ON_TABLE = [np.array(x, dtype=float) for x in (
    [0, 0, 0, 1, 0, 0, 0.1, 0, 0, 0.6, 0.8, 1, 0, 0.1035], [1, 0, 2, 1.5, 0.5, 0, 0.5, 1, 0, 0.5, 0, -1.0], np.full((2, 12), 0.05),
    1.1 * TABLE.parameters, [0.2, 0.4, 0.3], [0.1, 0.5, 0.4], 0.01 * np.sin(np.arange(18)))]


def contact_end(*x):
    q, v = axode.jax.contact_rollout(TABLE, *x[:3], 5e-3, **dict(zip(("parameters", "friction", "restitution", "placement"), x[3:])))
    return jnp.append(q[..., -1, :], v[..., -1, :])


def test_motions_with_contact_have_first_derivatives_by_parameters():
    f = jax.jit(contact_end)
    changed = axode.with_shapes(TABLE.with_parameters(ON_TABLE[3]), friction=ON_TABLE[4], restitution=ON_TABLE[5],
                                placement=ON_TABLE[6].reshape(3, 6))
    expected = axode.rollout(changed, *ON_TABLE[:3], 5e-3, joint_losses=True, contact=True)
    assert close(np.asarray(f(*ON_TABLE)), np.append(expected.q[-1], expected.v[-1]), 1e-12)
    dx = [np.sin(k + np.arange(x.size)).reshape(x.shape) for k, x in enumerate(ON_TABLE)]
    dx[0][:4] = dx[0][7:11] = 0  # quaternions keep their norms
    change = np.asarray(jax.jvp(f, ON_TABLE, dx)[1])
    e = 1e-6
    after, before = (np.asarray(f(*(x + s * d for x, d in zip(ON_TABLE, dx)))) for s in (e, -e))
    assert close(change, (after - before) / (2 * e), 1e-6)
    w = np.cos(np.arange(26))
    gradients = jax.vjp(f, *ON_TABLE)[1](w)
    assert close(sum(np.sum(g * d) for g, d in zip(gradients, dx)), w @ change, 1e-9)
    two = [np.stack([x, x]) for x in ON_TABLE[:3]]
    assert close(np.asarray(jax.vmap(contact_end)(*two))[1], np.asarray(f(*ON_TABLE[:3])))
    with pytest.raises(NotImplementedError, match="contact_rollout has first derivatives; a second one was asked for"):
        jax.hessian(lambda v: contact_end(ON_TABLE[0], v, ON_TABLE[2]).sum())(ON_TABLE[1])


def test_distances_of_shapes_have_first_derivatives():
    m = axode.load(axode.robots / "quadruped.toml")
    pairs = axode.shape_pairs(m)[:5]
    q = m.random(seed=3, n=4)
    f = jax.jit(lambda q: axode.jax.pair_distances(m, q, pairs))
    assert close(np.asarray(f(q)), axode.pair_distances(m, q, pairs).distances, 1e-14)
    assert np.array_equal(jax.vmap(f)(q[:, None])[:, 0], f(q)) and f(q[0]).shape == (5,)
    assert axode.jax.pair_distances(m, q).shape == (4, len(axode.shape_pairs(m)))
    for D in (jax.jacfwd, jax.jacrev):
        assert close(np.asarray(D(f)(q[0])), differences(f, q[0]), 1e-7)
    assert f(q.astype(np.float32)).dtype == np.float32
    holed = f(np.where(np.arange(4)[:, None] == 2, np.nan, q))
    assert np.isnan(holed).all(axis=1).tolist() == [False, False, True, False]
    with pytest.raises(NotImplementedError, match="pair_distances has first derivatives; a second one was asked for"):
        jax.hessian(lambda q: f(q).sum())(q[0])
