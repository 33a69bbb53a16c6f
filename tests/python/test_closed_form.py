"""The closed forms have the documented shapes and places, and take one state. Their numbers are tested in C++."""

import inspect

import axode
import numpy as np
import pytest
from axode import closed_form
from calls import load_on
from mechanisms import MECHANISMS, REPRESENTATIONS, close, random_states

EVERY_WAY = pytest.mark.parametrize("representation", REPRESENTATIONS)
FORMS = ["paper", "skew", "spatial", "christoffel"]


def blocks(matrices):
    """The block-diagonal matrix with the n blocks of an array (n, 6, 6)."""
    n = len(matrices)
    return np.einsum("iab,ij->iajb", matrices, np.eye(n)).reshape(6 * n, 6 * n)


@EVERY_WAY
def test_numbers_of_every_form_are_in_their_places(representation):
    m = MECHANISMS["machine"]
    q, v, a, _ = (x[0] for x in random_states(m, 1, seed=2))
    A, D, X = closed_form.system_matrices(m, q, representation)
    n = 6 * m.n_bodies
    assert A.shape == (n, n) and X.shape == (n, m.nv) and close(A @ (np.eye(n) - D), np.eye(n), 1e-12)
    V, dV = closed_form.system_twist(m, q, v, representation), closed_form.system_acceleration(m, q, v, a, representation)
    bodies = slice(1, m.n_bodies + 1)
    assert close(A @ X @ v, V) and close(V, axode.twists(m, q, v, representation)[bodies].ravel())
    assert close(A @ X, np.vstack([axode.jacobian(m, q, body, representation) for body in m.body_names]))
    assert close(dV, axode.accelerations(m, q, v, a, representation)[bodies].ravel())
    assert close(closed_form.joint_velocities(m, q, V, representation), v, 1e-9)
    assert close(closed_form.joint_accelerations(m, q, V, dV, representation), a, 1e-9)
    M = closed_form.inertia_matrix(m, q, representation)
    assert close((A @ X).T @ M @ A @ X, closed_form.mass_matrix(m, q, representation) - np.diag(armatures(m)))
    assert close(closed_form.mass_matrix(m, q, representation), axode.mass_matrix(m, q))
    loads = load_on(m, q)
    tau = axode.inverse_dynamics(m, q, v, a, loads=loads, joint_losses=True)
    forms = [lambda *x, **more: closed_form.projection_equations(*x, representation, **more), closed_form.momentum_balance,
             closed_form.lagrange_equations]
    for form in forms:
        assert close(form(m, q, v, a, loads=loads, joint_losses=True), tau, 1e-10)


def armatures(m):
    own = np.zeros(m.nv)
    for joint in m.joints:
        own[joint.v] = joint.armature if joint.leader is None else 0
    return own


def test_matrices_of_velocities_and_factors_are_in_their_places():
    m = MECHANISMS["machine"]
    q, v, _, _ = (x[0] for x in random_states(m, 1, seed=2))
    A_s, Y_s, A_sb = closed_form.spatial_factors(m, q)
    A, _, X = closed_form.system_matrices(m, q, "spatial")
    assert close(A_s @ Y_s, A @ X) and close(A_sb @ closed_form.system_matrices(m, q, "body").X, A @ X)
    V = closed_form.system_twist(m, q, v)
    assert np.array_equal(closed_form.b_matrix(m, V), blocks(axode.lie.ad(V.reshape(-1, 6))))
    assert np.array_equal(closed_form.inertia_matrix(m, q), blocks(np.array([m.body(name).M for name in m.body_names])))
    A, D, X = closed_form.system_matrices(m, q)
    at = [closed_form.system_matrices(m, m.integrate(q, s * v)) for s in (1e-5, -1e-5)]
    rate = (at[0].A @ at[0].X - at[1].A @ at[1].X) / 2e-5
    assert close(-A @ closed_form.a_matrix(m, v) @ D @ A @ X, rate, 1e-7)
    for form in FORMS:
        assert close(closed_form.coriolis_matrix(m, q, v, form), axode.coriolis_matrix(m, q, v, form), 1e-10)
    arm, humanoid = MECHANISMS["arm"], MECHANISMS["humanoid"]
    q = arm.random(seed=2)
    assert close(closed_form.christoffel(arm, q), axode.christoffel(arm, q), 1e-10)
    with pytest.raises(ValueError, match='joint "free_base" has 6 degrees of freedom'):
        closed_form.christoffel(humanoid, humanoid.random())


ARM = MECHANISMS["arm"]
Q, V = np.zeros(7), np.zeros(42)
CALLS = {
    "system_matrices": ("q",), "spatial_factors": ("q",), "a_matrix": ("v",), "b_matrix": ("V",),
    "system_twist": ("q", "v"), "system_acceleration": ("q", "v", "a"), "joint_velocities": ("q", "V"),
    "joint_accelerations": ("q", "V", "dV"), "inertia_matrix": ("q",), "projection_equations": ("q", "v", "a"),
    "momentum_balance": ("q", "v", "a"), "mass_matrix": ("q",), "coriolis_matrix": ("q", "v"),
    "lagrange_equations": ("q", "v", "a"), "christoffel": ("q",), "poses_by_body_screws": ("q",),
    "poses_by_spatial_screws": ("q",),
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
