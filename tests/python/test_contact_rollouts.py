"""Rollouts in which shapes touch are the motions of `simulate`, and are asked for as there."""

import pickle
import shutil

import axode
import numpy as np
import pytest

STEP = 1 / 256  # a power of 2, so that the times of steps are exact


def box_on_a_floor(**contact):
    box = {"kind": "box", "role": "collision", "size": [0.2, 0.2, 0.2]}
    return axode.with_floor(axode.Model.from_dict({
        "format": "axode drawing 1", "body": [
            {"name": "box", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [0.007] * 3, "shape": [box]}],
    } | contact))


BOX = box_on_a_floor(contact={"friction": 0.5})


def thrown(N=3):
    """States from which a box falls with a spin, and forces for 40 steps."""
    rng = np.random.default_rng(2)
    q = np.tile([0, 0, 0, 1.0, 0, 0, 0.2], (N, 1))
    q[:, 6] += 0.05 * rng.random(N)
    return q, rng.uniform(-1, 1, (N, 6)), rng.uniform(-1, 1, (N, 40, 6))


def same(a, b):
    assert all(np.array_equal(x, y) for x, y in zip((a.q, a.v, a.certificates), (b.q, b.v, b.certificates), strict=True))


def test_motions_are_those_of_simulate_bit_for_bit():
    q, v, _ = thrown()
    tau = np.array([0.1, -0.2, 0.3, 1.0, 0.5, -2.0])
    found = axode.rollout(BOX, q, v, tau, STEP, steps=40)
    assert found.q.shape == (3, 41, 7) and found.v.shape == (3, 41, 6) and found.certificates.shape == (3, 40)
    assert found.certificates.max() <= 1e-9 and found.q[:, -1, 6].max() < 0.18
    for k in range(3):
        motion = axode.simulate(BOX, q[k], v[k], 40 * STEP, tau=tau, step=STEP, contact=True)
        for ours, expected in ((found.q, motion.q), (found.v, motion.v), (found.certificates, motion.certificates)):
            np.testing.assert_array_equal(ours[k], expected)


def test_a_step_has_its_forces_and_every_kind_of_tau_is_the_same():
    q, v, tau = thrown()
    found = axode.rollout(BOX, q, v, tau, STEP)
    for k in (0, 17):
        motion = axode.simulate(BOX, found.q[1, k], found.v[1, k], STEP, tau=tau[1, k], step=STEP)
        np.testing.assert_allclose(motion.q[-1], found.q[1, k + 1], atol=1e-9)
    same(axode.rollout(BOX, q, v, tau, STEP, threads=3), found)
    one = axode.rollout(BOX, q[1], v[1], tau[1], STEP)
    assert one.certificates.shape == (40,)
    same(one, axode.Rollout(found.q[1], found.v[1], found.certificates[1]))
    constant = axode.rollout(BOX, q, v, tau[0, 0], STEP, steps=40)
    same(axode.rollout(BOX, q, v, np.broadcast_to(tau[0, 0], tau.shape), STEP), constant)
    held = axode.drives.Sampled([0.0], [tau[0, 0]])
    same(axode.rollout(BOX, q, v, held, STEP, steps=40), constant)
    times = []

    def policy(t, q_t, v_t):
        times.append(t)
        return np.broadcast_to(tau[0, 0], v_t.shape)

    called = axode.rollout(BOX, q, v, policy, STEP, steps=40)
    assert times == [k * STEP for k in range(40)] and called.certificates.max() <= 1e-9
    np.testing.assert_allclose(called.q, constant.q, atol=1e-7)


def test_contact_counts_as_in_simulate():
    q, v, tau = thrown()
    touching = axode.rollout(BOX, q, v, tau, STEP)
    same(axode.rollout(BOX, q, v, tau, STEP, contact=True), touching)
    falls = axode.rollout(BOX, q, v, tau, STEP, contact=False)
    assert falls.certificates.size == 0 and falls.q[0, -1, 6] < touching.q[0, -1, 6] - 0.05
    drawing = BOX.to_dict()
    drawing.pop("contact")
    silent = axode.Model.from_dict(drawing)
    same(axode.rollout(silent, q, v, tau, STEP), falls)
    assert axode.rollout(silent, q, v, tau, STEP, contact=True).q[0, -1, 6] > falls.q[0, -1, 6] + 0.05
    assert axode.simulate(silent, q[0], v[0], STEP).certificates.size == 0
    with pytest.raises(TypeError, match="contact: expected True, False or None, got str"):
        axode.rollout(BOX, q, v, tau, STEP, contact="yes")


def test_a_rollout_is_a_pair_with_certificates():
    q, v = path = axode.rollout(BOX, *(x[0] for x in thrown()), STEP)
    assert path.q is q and path.v is v and len(path) == 2 and path.certificates.shape == (40,)
    same(pickle.loads(pickle.dumps(path)), path)


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler cc")
def test_compiled_code_has_no_contact():
    q, v, tau = thrown()
    fast = BOX.specialise(["forward_dynamics"], flags=["-O0"])
    with pytest.raises(ValueError, match="^contact: code that is compiled for .* has no contact; give the model"):
        axode.rollout(fast, q, v, tau, STEP)
    without = axode.rollout(fast, q, v, tau, STEP, contact=False)
    np.testing.assert_allclose(without.q, axode.rollout(BOX, q, v, tau, STEP, contact=False).q, atol=1e-10)


def test_a_motion_that_cannot_continue_is_named_with_the_states_until_then():
    q, v, tau = thrown()
    tau[1, 5] = 1e300
    with pytest.raises(axode.StatesError, match="^state 1: the motion with contact cannot continue: ") as found:
        axode.rollout(BOX, q, v, tau, STEP)
    assert found.value.states == [1]
    assert np.isfinite(found.value.result[[0, 2]]).all() and np.isfinite(found.value.result[1, :6]).all()
    assert np.isnan(found.value.result[1, 7:]).all()


def test_what_is_wrong_is_refused_as_without_contact():
    q, v, tau = thrown()
    for given, words in (((q, v, tau[:, :, :5], STEP), r"tau: expected shape \(3, K, 6\)"),
                         ((q, v, tau, 0.0), "step is 0"), ((q, v[:, :5], tau, STEP), "v: expected shape"),
                         ((q, v, np.nan * tau, STEP), "tau")):
        with pytest.raises(ValueError, match=words):
            axode.rollout(BOX, *given)
    with pytest.raises(ValueError, match="drive of model"):
        axode.rollout(BOX, q, v, axode.drives.PD(1.0, 1.0, np.zeros(7)).on(axode.load(axode.robots / "arm7.toml")), STEP, steps=2)


def test_drives_act_as_in_simulate_bit_for_bit():
    m = axode.Builder("press").body(
        "ram", joint={"name": "guide", "kind": "prismatic", "axis": "z", "point": [0, 0, 0], "limits": [0.0, 1.0], "stop": "hard"},
        mass=1, com=[0, 0, 0], inertia=[1, 1, 1]).drive(
            "dc_motor", "guide", name="motor", resistance=1, inductance=0.02, torque_constant=2, current_limit=4,
            input={"kind": "steps", "times": [0, 0.0501], "values": [2, 12]}).build()
    q, v = np.array([[0.02], [0.1]]), np.zeros((2, 1))
    found = axode.rollout(m, q, v, np.zeros((2, 60, 1)), STEP, contact=True, threads=2)
    assert found.x.shape == (2, 61, 1) and np.max(found.x) > 4 - 1e-9
    for k in range(2):
        motion = axode.simulate(m, q[k], v[k], 60 * STEP, step=STEP, contact=True)
        ends = np.isin(motion.t, STEP * np.arange(61))
        for ours, expected in ((found.q, motion.q), (found.v, motion.v), (found.x, motion.x)):
            np.testing.assert_array_equal(ours[k], expected[ends])
    started = axode.rollout(m, q, v, np.zeros((2, 5, 1)), STEP, contact=True, x=[[1.0], [2.0]])
    np.testing.assert_array_equal(started.x[:, 0], [[1.0], [2.0]])
    called = axode.rollout(m, q, v, lambda t, q, v: np.zeros((2, 1)), STEP, steps=60, contact=True)
    np.testing.assert_allclose(called.q, found.q, atol=1e-9)
    with pytest.raises(ValueError, match="x: expected shape"):
        axode.rollout(m, q, v, np.zeros((2, 5, 1)), STEP, contact=True, x=[1.0])


def test_loops_may_be_open_where_no_motion_begins():
    m = axode.Builder("double pendulum with a rod").body(
        "one", joint={"kind": "revolute", "axis": "y", "point": [0, 0, 0]}, mass=1, com=[0.5, 0, 0], inertia=[0.1] * 3).body(
        "two", on="one", joint={"kind": "revolute", "axis": "y", "point": [1, 0, 0]}, mass=1, com=[1.5, 0, 0], inertia=[0.1] * 3).loop(
        "two", "ground", kind="rod", points=[[2, 0, 0], [3, 0, 0.5]], length=1.3).build()
    q, v = axode.assemble(m, m.neutral())[0], np.zeros(2)
    assert np.abs(axode.loop_residual(m, m.neutral())).max() > 0.1
    found = axode.rollout(m, q, v, np.zeros((20, 2)), STEP, contact=True)
    np.testing.assert_array_equal(found.q, axode.simulate(m, q, v, 20 * STEP, step=STEP, contact=True).q)
