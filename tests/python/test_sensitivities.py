"""Sensitivities of motions: `axode.rollout_derivatives`, `axode.rollout_jvp`, `axode.rollout_vjp`, and with contact."""

import axode
import numpy as np
import pytest
from mechanisms import MECHANISMS, close, random_states

K, N, STEP = 4, 3, 5e-3
# The joints of this mechanism have six, three, three and one velocities.
OTHERS = axode.Model.from_bodies([
    {"name": name, "on": on, "joint": {"kind": kind, **more}, "mass": 1.3, "com": [0.1, 0.2, -0.1],
     "inertia": [0.5, 0.7, 0.6, 0.02, 0.01, 0.03]}
    for name, on, kind, more in [("base", "ground", "free", {}), ("ball", "base", "spherical", {"point": [0.4, 0, 0]}),
                                 ("plate", "base", "planar", {"axis": "x", "point": [0, 0.5, 0]}),
                                 ("screw", "ball", "helical", {"axis": "y", "pitch": 0.2, "point": [0.7, 0.1, 0]})]])
ALL = {**MECHANISMS, "others": OTHERS}


def motions(m, seed=0):
    """q, v and tau of N motions, which begin with moderate accelerations, and a direction."""
    random = np.random.default_rng(seed)
    q, v, dq, dv = random_states(m, N, seed)
    tau = [axode.inverse_dynamics(m, q, v, random.normal(size=v.shape)) for _ in range(K)]
    return (q, v, np.stack(tau, axis=1)), (dq, dv, random.normal(size=(N, K, m.nv)) * np.abs(tau).mean(axis=(0, 1)))


@pytest.mark.parametrize("name", ALL)
def test_steps_and_gradients_are_those_of_displaced_motions(name):
    m = ALL[name]
    (q, v, tau), (dq, dv, dtau) = motions(m, 1)
    moved_q, moved_v = axode.rollout_jvp(m, q, v, tau, STEP, dq, dv, dtau)
    A, B = axode.rollout_derivatives(m, q, v, tau, STEP)
    assert A.shape == (N, K, 2 * m.nv, 2 * m.nv) and B.shape == (N, K, 2 * m.nv, m.nv)
    x = np.concatenate([dq, dv], axis=-1)
    for k in range(K):
        x = (A[:, k] @ x[..., None] + B[:, k] @ dtau[:, k, :, None])[..., 0]
        assert close(np.concatenate([moved_q[:, k + 1], moved_v[:, k + 1]], axis=-1), x)
    w_q, w_v = np.random.default_rng(2).normal(size=(2, N, K + 1, m.nv))
    gradient = axode.rollout_vjp(m, q, v, tau, STEP, w_q, w_v)
    back = [np.sum(g * d, axis=tuple(range(1, d.ndim))) for g, d in zip(gradient, (dq, dv, dtau))]
    forth = [np.sum(w * d, axis=(1, 2)) for w, d in zip((w_q, w_v), (moved_q, moved_v))]
    np.testing.assert_allclose(sum(back), sum(forth), rtol=0, atol=1e-12 * np.max(np.abs([*back, *forth])))


def test_one_motion_is_one_of_many_on_any_number_of_threads():
    m = OTHERS
    (q, v, tau), (dq, dv, dtau) = motions(m)
    w = np.ones((N, K + 1, m.nv))
    for f, more in [(axode.rollout_derivatives, ()), (axode.rollout_jvp, (dq, dv, dtau)), (axode.rollout_vjp, (w, w))]:
        all_of_them = f(m, q, v, tau, STEP, *more)
        for x, y in zip(all_of_them, f(m, q, v, tau, STEP, *more, threads=2)):
            np.testing.assert_array_equal(x, y)
        for n in range(N):
            for x, y in zip(all_of_them, f(m, q[n], v[n], tau[n], STEP, *(x[n] for x in more))):
                np.testing.assert_array_equal(x[n], y)


def test_no_motions_no_steps_and_nothing_that_moves():
    arm, none, empty = ALL["arm"], np.zeros((0, 7)), axode.Model.from_bodies([])
    A, B = axode.rollout_derivatives(arm, none, none, np.zeros((0, 3, 7)), STEP)
    assert A.shape == (0, 3, 14, 14) and B.shape == (0, 3, 14, 7)
    one, no_step = np.ones(7), np.zeros((0, 7))
    np.testing.assert_array_equal(axode.rollout_jvp(arm, one, one, no_step, STEP, one, 2 * one, no_step)[1], [2 * one])
    gradient = axode.rollout_vjp(arm, one, one, no_step, STEP, [one], [3 * one])
    np.testing.assert_array_equal(gradient.v, 3 * one)
    assert gradient.tau.shape == (0, 7) and not gradient.geometry.any()
    nothing = np.zeros((2, 0)), np.zeros((2, 0)), np.zeros((2, 3, 0))
    assert axode.rollout_derivatives(empty, *nothing, STEP).A.shape == (2, 3, 0, 0)
    assert axode.rollout_jvp(empty, *nothing, STEP, *nothing)[0].shape == (2, 4, 0)


def test_motions_that_cannot_go_on_are_named():
    arm = ALL["arm"]
    q, v, tau = np.full((3, 7), 0.1), np.zeros((3, 7)), np.zeros((3, 5, 7))
    tau[1, 2] = 1e300
    w = np.ones((3, 6, 7))
    for f, more in [(axode.rollout_derivatives, ()), (axode.rollout_jvp, (v, v, tau)), (axode.rollout_vjp, (w, w))]:
        with pytest.raises(axode.NotFiniteError, match="state 1") as found:
            f(arm, q, v, tau, 1e-2, *more)
        assert found.value.states == [1]
        assert np.all(np.isfinite(found.value.result[[0, 2]])) and np.any(np.isnan(found.value.result[1]))
    massless = axode.Model.from_bodies([{"name": "slide", "joint": {"kind": "prismatic", "axis": "z"}}])
    with pytest.raises(axode.SingularError, match='"slide_joint"'):
        axode.rollout_derivatives(massless, [0], [0], [[0]], STEP)


ONE, FIVE, SIX = np.zeros(7), np.zeros((5, 7)), np.zeros((6, 7))


@pytest.mark.parametrize("function, arguments, sentence", [
    ("rollout_derivatives", (ONE, ONE, ONE, STEP), r"tau: expected shape \(k, nv\)"),
    ("rollout_derivatives", (ONE, ONE, np.zeros((5, 6)), STEP), r"tau: expected shape \(5, 7\)"),
    ("rollout_derivatives", (ONE, ONE, FIVE, 0.0), "step is 0"),
    ("rollout_jvp", (ONE, ONE, FIVE, -1.0, ONE, ONE, FIVE), "step is -1"),
    ("rollout_jvp", (ONE, ONE, FIVE, STEP, FIVE, ONE, FIVE), r"dq: expected shape \(7,\)"),
    ("rollout_jvp", (ONE, ONE, FIVE, STEP, ONE, ONE, SIX), r"dtau: expected shape \(5, 7\)"),
    ("rollout_vjp", (ONE, ONE, FIVE, np.nan, SIX, SIX), "step is nan"),
    ("rollout_vjp", (ONE, ONE, FIVE, STEP, SIX, FIVE), r"w_v: expected shape \(6, 7\)"),
    ("rollout_vjp", (SIX, SIX, FIVE, STEP, SIX, SIX), r"tau: expected shape \(N, k, nv\)")])
def test_what_cannot_be_used_is_refused(function, arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        getattr(axode, function)(ALL["arm"], *arguments)


def test_a_quaternion_that_is_none_is_named_with_its_motion():
    q = np.array([OTHERS.neutral()] * 2)
    q[1, 3] = 2
    with pytest.raises(ValueError, match="state 1: .*base"):
        axode.rollout_vjp(OTHERS, q, np.zeros((2, 13)), np.zeros((2, 1, 13)), STEP, *np.zeros((2, 2, 2, 13)))


def test_contact_rollout_derivatives_agree_with_differences():
    """A ball that slides and a ball that bounces on a floor, along deviations of the first velocity and of a force."""
    ball = {"kind": "sphere", "role": "collision", "radius": 0.1, "friction": 0.3, "restitution": 0.5}
    floor = {"kind": "plane", "role": "collision", "friction": 0.3}
    bodies = [{"name": name, "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [4e-3] * 3, "shape": [ball]}
              for name in ("slider", "bouncer")]
    m = axode.Model.from_dict({"format": "axode drawing 1", "shape": [floor], "body": bodies})
    q = np.array([0, 0, 0, 1, 0, 0, 0.1, 0, 0, 0, 1, 1, 0, 0.1035])
    v = np.array([1, 0, 2, 1.5, 0.5, 0, 0.5, 1, 0, 0.5, 0, -1.0])
    tau, step = np.full((4, 12), 0.05), 5e-3
    motion = axode.contact_rollout_derivatives(m, q, v, tau, step)
    assert motion.unique and not motion.at_kink and motion.certificate < 1e-9

    def end(v, tau):
        state_q, state_v = q, v
        for force in tau:
            state = axode.simulate(m, state_q, state_v, step, step=step, method="contact", joint_losses=True,
                                   tau=force)
            state_q, state_v = state.q[-1], state.v[-1]
        return np.append(m.difference(motion.q[-1], state_q), state_v)

    rng = np.random.default_rng(1)
    dv, dtau = rng.standard_normal(12), rng.standard_normal(tau.shape)
    x = np.append(np.zeros(12), dv)
    for A, B, by in zip(motion.A, motion.B, dtau):
        x = A @ x + B @ by
    e = 1e-5
    differences = (end(v + e * dv, tau + e * dtau) - end(v - e * dv, tau - e * dtau)) / (2 * e)
    np.testing.assert_allclose(x, differences, rtol=1e-6, atol=1e-6)


def test_contact_rollouts_have_derivatives_by_all_parameters():
    """Matrices and products of a quadruped that falls on its feet."""
    m = axode.load(axode.robots / "quadruped.toml")
    rng = np.random.default_rng(2)
    q, v, tau, step = m.neutral(), 0.1 * rng.standard_normal(m.nv), rng.standard_normal((3, m.nv)), 2e-3
    q[6] += 1e-3 - min(d.distance for d in axode.distances(m, q) if d.a == "floor")
    v[5] = -1
    motion = axode.contact_rollout_derivatives(m, q, v, tau, step, parameters=True)
    n, K, none = motion.C.shape[-1], len(tau), (np.zeros(m.nv), np.zeros(m.nv), 0 * tau)
    changes = {"placement": rng.standard_normal((n, 6)), "inertia": rng.standard_normal(10 * m.n_bodies),
               "geometry": rng.standard_normal((m.n_bodies, 6)), "surfaces": rng.standard_normal((3, n))}
    matrices = {**motion._asdict(), "surfaces": motion.C}
    w_q, w_v = rng.standard_normal((2, K + 1, m.nv))
    gradient = axode.contact_rollout_vjp(m, q, v, tau, step, w_q, w_v)
    for name, dx in changes.items():
        dq, dv = axode.contact_rollout_jvp(m, q, v, tau, step, *none, **{name: dx})
        x = np.zeros(2 * m.nv)
        for A, C in zip(motion.A, matrices[name]):
            x = A @ x + C.reshape(2 * m.nv, -1) @ dx.ravel()
        np.testing.assert_allclose(np.append(dq[-1], dv[-1]), x, rtol=1e-9, atol=1e-9)
        forward = np.sum(w_q * dq) + np.sum(w_v * dv)
        np.testing.assert_allclose(np.sum(getattr(gradient, name) * dx), forward, rtol=1e-9, atol=1e-9)


def test_geometry_of_loops_is_refused_in_motions_with_contact():
    m = axode.load(axode.robots / "four_bar.toml")
    motion = m.neutral(), np.zeros(m.nv), np.zeros((2, m.nv)), 1e-3
    assert axode.contact_rollout_derivatives(*(m, *motion), parameters=True).geometry is None
    with pytest.raises(ValueError, match='"four-bar.*" has closed loops'):
        axode.contact_rollout_jvp(m, *motion, motion[1], *motion[1:3], geometry=np.zeros((m.n_bodies, 6)))


def test_shapes_that_do_not_exist_are_refused():
    m = axode.load(axode.robots / "quadruped.toml")
    with pytest.raises(ValueError, match="friction has 2 numbers; model"):
        axode.with_shapes(m, friction=[0.5, 0.5])
    with pytest.raises(ValueError, match="placement: expected shape"):
        axode.with_shapes(m, placement=[0.5, 0.5])
