"""What is singular but for rounding is refused, and numbers that overflow are an error and never a silent NaN."""

import axode
import numpy as np
import pytest
from mechanisms import MECHANISMS, REPRESENTATIONS, random_states

ARM = MECHANISMS["arm"]
WAYS = ["fast", *REPRESENTATIONS]


def rod(third, R):
    """A free body of 0.1 kg with the principal inertias 1, 1 and `third`, turned by R."""
    Theta = R @ np.diag([1, 1, third]) @ R.T
    return axode.Model.from_bodies([{
        "name": "rod", "joint": {"kind": "free"}, "mass": 0.1, "com": [0, 0, 0],
        "inertia": [*np.diag(Theta), Theta[0, 1], Theta[0, 2], Theta[1, 2]]}])


def rotations(N, seed):
    return axode.lie.exp_SO3(np.random.default_rng(seed).normal(size=(N, 3)))


def calls(m, q, tau):
    """The accelerations by every function that finds them, for one state or many."""
    zero = np.zeros_like(tau)
    for way in WAYS:
        yield f"forward_dynamics {way}", lambda: axode.forward_dynamics(m, q, zero, tau, way)
        yield f"inverse_mass_matrix {way}", lambda: (axode.inverse_mass_matrix(m, q, way) @ tau[..., None])[..., 0]
    yield "from_momenta", lambda: axode.from_momenta(m, q, tau)
    for way in REPRESENTATIONS:
        yield f"impulse_response {way}", lambda: np.atleast_2d(
            (tau[..., None, :] @ axode.impulse_response(m, q, "rod", way))[..., 0, :])


def test_a_thin_rod_is_refused_in_every_direction():
    for k, R in enumerate(rotations(1000, 1)):
        m = rod(0, R)
        q = m.random(seed=k)
        for states in (q, np.tile(q, (3, 1))):
            tau = np.zeros((*states.shape[:-1], 6))
            tau[..., :3] = R[:, 2]
            for name, call in calls(m, states, tau):
                with pytest.raises(axode.SingularError) as refused:
                    call()
                assert len(refused.value.states) == np.size(states) // 7, name
                assert np.isnan(refused.value.result).all(), name


def test_a_rod_that_is_not_refused_is_answered_right():
    right = 0
    random = np.random.default_rng(2)
    for k, R in enumerate(rotations(300, 2)):
        third = 10 ** random.uniform(-18, 0)
        m = rod(third, R)
        q = m.random(seed=k)
        tau = np.concatenate([R[:, 2], np.zeros(3)])
        for name, call in calls(m, q, tau):
            if name.startswith("impulse"):
                continue
            try:
                assert np.linalg.norm(third * call()[:3] - R[:, 2]) < 0.5, name
                right += 1
            except axode.SingularError:
                assert third < 1e-12, name
    assert right > 1000


FINITE = {
    "inverse_dynamics": lambda q, x, way: axode.inverse_dynamics(ARM, q, x, x, way),
    "forward_dynamics": lambda q, x, way: axode.forward_dynamics(ARM, q, x, x, way),
    "kinetic_energy": lambda q, x, way: axode.kinetic_energy(ARM, q, x),
    "coriolis_vector": lambda q, x, way: axode.coriolis_vector(ARM, q, x),
    "momentum_form": lambda q, x, way: axode.momentum_form(ARM, q, x, x),
    "accelerations": lambda q, x, way: axode.accelerations(ARM, q, x, x),
    "joint_wrenches": lambda q, x, way: axode.joint_wrenches(ARM, q, x, x),
    "regressor": lambda q, x, way: axode.regressor(ARM, q, x, x),
    "jacobian_rate": lambda q, x, way: axode.jacobian_rate(ARM, q, x, "flange", offset=[1e200, 0, 0]),
    "twist_derivatives": lambda q, x, way: axode.twist_derivatives(ARM, q, np.stack([x, x], axis=-2), "flange"),
}


@pytest.mark.parametrize("function", FINITE)
@pytest.mark.parametrize("way", ["fast", "body", "spatial"])
def test_numbers_that_overflow_are_an_error_and_the_others_are_right(function, way):
    q, x, _, _ = random_states(ARM, 20)
    call = FINITE[function]
    if function != "jacobian_rate":
        expected = call(q, x, way)
        many = x.copy()
        many[3] = 1e200
        many[11] = -1e200
        with pytest.raises(axode.NotFiniteError, match=r"^state 3 and 1 other: ") as refused:
            call(q, many, way)
        assert refused.value.states == [3, 11]
        if isinstance(expected, np.ndarray):
            others = np.delete(np.arange(20), [3, 11])
            assert np.array_equal(refused.value.result[others], expected[others])
    with pytest.raises(axode.NotFiniteError, match="not finite|overflow"):
        call(q[0], np.full(7, 1e200), way)
