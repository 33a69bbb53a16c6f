"""The closed forms against the recursions, and the factorisations of the paper, on every mechanism."""

import inspect

import axode
import numpy as np
import pytest
from axode import closed_form
from calls import load_on
from mechanisms import MECHANISMS, REPRESENTATIONS, close, random_states

EVERYWHERE = pytest.mark.parametrize("mechanism", MECHANISMS)
EVERY_WAY = pytest.mark.parametrize("representation", REPRESENTATIONS)
FORMS = ["paper", "skew", "spatial", "christoffel"]


def state(mechanism):
    m = MECHANISMS[mechanism]
    q, v, a, _ = (x[0] for x in random_states(m, 1, seed=2))
    return m, q, v, a


def of_bodies(m, frames):
    """The entries of the moving bodies, one below the other."""
    return frames[1:m.n_bodies + 1].reshape(-1, *frames.shape[2:])


def rate(m, q, v, f, h=1e-5):
    return (f(m.integrate(q, h * v)) - f(m.integrate(q, -h * v))) / (2 * h)


def blocks(matrices):
    """The block-diagonal matrix of (n, 6, 6)."""
    n = len(matrices)
    return np.einsum("iab,ij->iajb", matrices, np.eye(n)).reshape(6 * n, 6 * n)


@EVERYWHERE
@EVERY_WAY
def test_the_twists_are_A_X_v(mechanism, representation):
    m, q, v, a = state(mechanism)
    A, D, X = closed_form.system_matrices(m, q, representation)
    n = 6 * m.n_bodies
    assert A.shape == D.shape == (n, n) and X.shape == (n, m.nv)
    assert close(A @ (np.eye(n) - D), np.eye(n), 1e-12)
    V = closed_form.system_twist(m, q, v, representation)
    assert close(A @ X @ v, V) and close(V, of_bodies(m, axode.twists(m, q, v, representation)))
    J = np.vstack([axode.jacobian(m, q, body, representation) for body in m.body_names])
    assert close(A @ X, J)
    dV = closed_form.system_acceleration(m, q, v, a, representation)
    assert close(dV, of_bodies(m, axode.accelerations(m, q, v, a, representation)))
    assert close(closed_form.joint_velocities(m, q, V, representation), v, 1e-9)
    assert close(closed_form.joint_accelerations(m, q, V, dV, representation), a, 1e-9)


@EVERYWHERE
def test_the_spatial_jacobian_has_three_factorisations(mechanism):
    m, q, _, _ = state(mechanism)
    A_s, Y_s, A_sb = closed_form.spatial_factors(m, q)
    A, _, X = closed_form.system_matrices(m, q, "spatial")
    assert close(A_s @ Y_s, A @ X)
    assert close(A_sb @ closed_form.system_matrices(m, q, "body").X, A @ X)
    assert np.array_equal(closed_form.spatial_factors(m, m.neutral()).Y_s, Y_s)


@EVERYWHERE
def test_a_and_b_are_the_rates_of_the_jacobians(mechanism):
    m, q, v, _ = state(mechanism)

    def jacobian(representation):
        def J(at):
            A, _, X = closed_form.system_matrices(m, at, representation)
            return A @ X
        return J
    A, D, X = closed_form.system_matrices(m, q)
    assert close(-A @ closed_form.a_matrix(m, v) @ D @ A @ X, rate(m, q, v, jacobian("body")), 1e-7)
    A, _, X = closed_form.system_matrices(m, q, "spatial")
    b = closed_form.b_matrix(m, closed_form.system_twist(m, q, v, "spatial"))
    assert close(A @ b @ X, rate(m, q, v, jacobian("spatial")), 1e-7)
    V = closed_form.system_twist(m, q, v)
    assert np.array_equal(closed_form.b_matrix(m, V), blocks(axode.lie.ad(V.reshape(-1, 6))))


@EVERYWHERE
@EVERY_WAY
def test_the_mass_matrix_is_projected_from_those_of_the_bodies(mechanism, representation):
    m, q, v, _ = state(mechanism)
    M = closed_form.inertia_matrix(m, q, representation)
    V = closed_form.system_twist(m, q, v, representation)
    bodies = blocks(np.array([m.body(name).M for name in m.body_names]))
    V_b = closed_form.system_twist(m, q, v)
    assert close(V @ M @ V, V_b @ bodies @ V_b)
    if representation == "body":
        assert np.array_equal(M, bodies)
    assert close(closed_form.mass_matrix(m, q, representation), axode.mass_matrix(m, q))


@EVERYWHERE
def test_every_form_of_the_equations_gives_inverse_dynamics(mechanism):
    m, q, v, a = state(mechanism)
    for more in ({}, {"loads": load_on(m, q)}, {"loads": load_on(m, q), "joint_losses": True}):
        tau = axode.inverse_dynamics(m, q, v, a, **more)
        for representation in REPRESENTATIONS:
            assert close(closed_form.projection_equations(m, q, v, a, representation, **more), tau, 1e-10)
        assert close(closed_form.momentum_balance(m, q, v, a, **more), tau, 1e-10)
        assert close(closed_form.lagrange_equations(m, q, v, a, **more), tau, 1e-10)


@EVERYWHERE
@pytest.mark.parametrize("form", FORMS)
def test_coriolis_matrices_are_those_of_the_recursions(mechanism, form):
    m, q, v, _ = state(mechanism)
    C = closed_form.coriolis_matrix(m, q, v, form)
    assert close(C, axode.coriolis_matrix(m, q, v, form), 1e-10)
    assert close(C @ v, axode.coriolis_vector(m, q, v), 1e-10)


def test_christoffel_symbols_are_those_of_joint_screws_where_joints_have_one_degree_of_freedom():
    m, q, _, _ = state("arm")
    assert close(closed_form.christoffel(m, q), axode.christoffel(m, q), 1e-10)
    humanoid, q, _, _ = state("humanoid")
    with pytest.raises(ValueError, match='joint "free_base" has 6 degrees of freedom'):
        closed_form.christoffel(humanoid, q)


ARM = MECHANISMS["arm"]
Q, V = np.zeros(7), np.zeros(42)
CALLS = {
    "system_matrices": ("q",), "spatial_factors": ("q",), "a_matrix": ("v",), "b_matrix": ("V",),
    "system_twist": ("q", "v"), "system_acceleration": ("q", "v", "a"), "joint_velocities": ("q", "V"),
    "joint_accelerations": ("q", "V", "dV"), "inertia_matrix": ("q",), "projection_equations": ("q", "v", "a"),
    "momentum_balance": ("q", "v", "a"), "mass_matrix": ("q",), "coriolis_matrix": ("q", "v"),
    "lagrange_equations": ("q", "v", "a"), "christoffel": ("q",),
}


def test_every_function_is_among_those_that_are_tried():
    assert set(CALLS) == {name for name in closed_form.__all__ if not inspect.isclass(getattr(closed_form, name))}


@pytest.mark.parametrize("name", CALLS)
def test_one_state_is_taken_and_nothing_else(name):
    f, right = getattr(closed_form, name), {k: V if k in ("V", "dV") else Q for k in CALLS[name]}
    f(ARM, **right)
    f(ARM, **{k: x.tolist() for k, x in right.items()})
    for k, x in right.items():
        for wrong in (x[:-1], x[None], np.stack([x, x]), 0.0):
            with pytest.raises(ValueError, match=rf"^{k}: expected shape \({len(x)},\), .*, got "):
                f(ARM, **(right | {k: wrong}))
        with pytest.raises(ValueError, match=rf"^{k}\[0\] is inf"):
            f(ARM, **(right | {k: np.where(np.arange(len(x)) == 0, np.inf, x)}))
        with pytest.raises(ValueError, match=rf"^{k}: expected real numbers"):
            f(ARM, **(right | {k: x + 0j}))
    with pytest.raises(TypeError):
        f(None, **right)


@pytest.mark.parametrize("name", [name for name, arguments in CALLS.items() if "q" in arguments])
def test_a_quaternion_off_1_is_refused(name):
    m = MECHANISMS["humanoid"]
    sizes = {"q": m.nq, "v": m.nv, "a": m.nv, "V": 6 * m.n_bodies, "dV": 6 * m.n_bodies}
    with pytest.raises(ValueError, match="free_base"):
        getattr(closed_form, name)(m, **{k: np.zeros(sizes[k]) for k in CALLS[name]})


def test_words_and_loads_are_checked():
    with pytest.raises(ValueError, match="representation is 'fast'; expected one of 'body'"):
        closed_form.system_matrices(ARM, Q, "fast")
    with pytest.raises(ValueError, match="form is 'body'; expected one of 'paper'"):
        closed_form.coriolis_matrix(ARM, Q, Q, "body")
    with pytest.raises(KeyError, match='has no frame "flang"'):
        closed_form.momentum_balance(ARM, Q, Q, Q, [{"frame": "flang", "wrench": np.zeros(6)}])
