"""Drives of simulations: `axode.drives`."""

import threading
import time

import axode
import numpy as np
import pytest
from axode.drives import PD, ComputedTorque, Sampled

ARM = axode.load(axode.robots / "arm7.toml")
HUMANOID = axode.load(axode.robots / "humanoid.urdf", base="free")
REST = np.full(7, 0.3), np.zeros(7)
TARGET = np.array([0.0, 0.5, 0.0, -1.0, 0.0, 0.8, 0.0])


def agree(m, start, drive, function, until=0.2):
    """Expects the same motion, step by step, under a drive and under the equivalent Python function."""
    one = axode.simulate(m, *start, until, method="rk4", step=1e-3, tau=drive)
    other = axode.simulate(m, *start, until, method="rk4", step=1e-3, tau=function)
    np.testing.assert_allclose(one.q, other.q, atol=1e-12)
    np.testing.assert_allclose(one.v, other.v, atol=1e-10)
    again = axode.simulate(m, *start, until, method="rk4", step=1e-3, tau=drive.on(m))
    np.testing.assert_array_equal(again.q, one.q)


def test_samples_are_numpys_interpolation():
    t = np.array([0.0, 0.05, 0.12, 0.15])
    tau = np.random.default_rng(2).normal(size=(4, 7))
    agree(ARM, REST, Sampled(t, tau), lambda now, q, v: [np.interp(now, t, column) for column in tau.T])
    agree(ARM, REST, Sampled(t, tau, hold=True),
          lambda now, q, v: tau[np.searchsorted(t, now, side="right") - 1])


def test_pd_is_its_formula_on_the_group():
    rng = np.random.default_rng(3)
    kp, kd = rng.uniform(0, 2, HUMANOID.nv), rng.uniform(0, 0.01, HUMANOID.nv)  # the wrists are light
    target, speed, forward = HUMANOID.random(seed=4), rng.normal(size=HUMANOID.nv), rng.normal(size=HUMANOID.nv)
    start = HUMANOID.neutral(), np.zeros(HUMANOID.nv)
    agree(HUMANOID, start, PD(kp, kd, target, speed, feedforward=forward),
          lambda t, q, v: kp * HUMANOID.difference(q, target) + kd * (speed - v) + forward, 0.02)
    limit = ARM.effort_limits
    agree(ARM, REST, PD(200.0, 0.05, TARGET, clip=True),
          lambda t, q, v: np.clip(200 * (TARGET - q) - 0.05 * v, -limit, limit), 0.05)
    assert np.any(np.abs(200 * (TARGET - REST[0])) > limit)
    samples = Sampled([0.0, 0.1], np.stack([np.zeros(7), np.arange(7.0)]))
    agree(ARM, REST, PD(10.0, 0.05, TARGET, feedforward=samples),
          lambda t, q, v: 10 * (TARGET - q) - 0.05 * v + min(t / 0.1, 1) * np.arange(7.0))


def test_computed_torque_is_its_formula():
    agree(ARM, REST, ComputedTorque(400.0, 40.0, TARGET),
          lambda t, q, v: axode.inverse_dynamics(ARM, q, v, 400 * (TARGET - q) - 40 * v))
    resting = np.ones(7), 2 * np.ones(7)
    agree(ARM, REST, ComputedTorque(4.0, 2.0, TARGET, *resting),
          lambda t, q, v: axode.inverse_dynamics(ARM, q, v, 2 + 2 * (1 - v) + 4 * (TARGET - q)), 0.05)
    reference = axode.simulate(ARM, *REST, 1.0, rtol=1e-11, tau=lambda t, q, v: 20 * np.sin(3 * t + np.arange(7)) - 5 * v)
    followed = axode.simulate(ARM, *REST, 1.0, rtol=1e-10, tau=ComputedTorque(100.0, 20.0, reference))
    times = np.linspace(0, 1, 23)
    np.testing.assert_allclose(followed.at(times)[0], reference.at(times)[0], atol=1e-6)


def test_a_simulation_under_a_drive_lets_other_threads_run():
    counted, done = 0, threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(1e-4)
    other = threading.Thread(target=count)
    other.start()
    before = counted
    axode.simulate(HUMANOID, HUMANOID.neutral(), np.zeros(HUMANOID.nv), 0.5, method="rk4", step=1e-4,
                   tau=PD(0.0, 0.1, HUMANOID.neutral()))
    during = counted - before
    done.set()
    other.join()
    assert during > 10


DRIVES_OF_MANY = {
    "PD": lambda m, q, v: PD(2.0, 0.01, q, v, feedforward=np.linspace(-1, 1, m.nv)),
    "clipped": lambda m, q, v: PD(500.0, 0.01, q, feedforward=Sampled([0.0, 0.004], np.stack([v, -v])), clip=True),
    "computed": lambda m, q, v: ComputedTorque(100.0, 20.0, q, v, -v), "held": lambda m, q, v: Sampled([0.0, 3e-3], [v, -v], hold=True),
    "motion": lambda m, q, v: ComputedTorque(100.0, 20.0, axode.simulate(m, q, 0.1 * v, 4e-3)), "constant": lambda m, q, v: v}


@pytest.mark.parametrize("name", DRIVES_OF_MANY)
def test_rollouts_under_drives_are_the_simulations_one_by_one(name):
    rng = np.random.default_rng(7)
    for m, n in (ARM, 5), (HUMANOID, 9):
        q0, v0 = m.random(n=n), 0.1 * rng.normal(size=(n, m.nv))
        drive = DRIVES_OF_MANY[name](m, m.random(seed=1), rng.normal(size=m.nv))
        q, v = axode.rollout(m, q0, v0, drive, 1e-3, steps=6)
        for k in range(n):
            one = axode.simulate(m, q0[k], v0[k], 6e-3, method="rk4", step=1e-3, tau=drive)
            np.testing.assert_allclose(q[k], one.q, atol=1e-12)
            np.testing.assert_allclose(v[k], one.v, atol=1e-12 * max(1, np.max(np.abs(one.v))))
        for x, y in zip((q, v), axode.rollout(m, q0, v0, drive, 1e-3, steps=6, threads=2)):
            np.testing.assert_array_equal(x, y)
        alone = axode.rollout(m, q0[0], v0[0], drive, 1e-3, steps=6)
        np.testing.assert_allclose(alone[1], v[0], atol=1e-12 * max(1, np.max(np.abs(v[0]))))


def test_rollouts_refuse_what_is_no_drive_of_theirs():
    q, v, pd = np.zeros((2, 7)), np.zeros((2, 7)), PD(1.0, 1.0, TARGET)
    for arguments, steps, words in [((pd, 1e-3), None, "steps is missing"), ((pd, 1e-3), -1, "steps is -1"),
                                    ((pd, 0.0), 3, "step is 0"), ((np.zeros(6), 1e-3), 3, r"tau: expected shape \(1, 7\)"),
                                    ((PD(1.0, 1.0, HUMANOID.neutral()).on(HUMANOID), 1e-3), 3, 'tau: a drive of model "humanoid"'),
                                    ((PD(-1.0, 1.0, TARGET), 1e-3), 3, r"kp\[0\] is -1")]:
        with pytest.raises(ValueError, match=words):
            axode.rollout(ARM, q, v, *arguments, steps=steps)
    with pytest.raises(axode.NotFiniteError) as found:
        axode.rollout(ARM, q, v + [[0], [1e200]] * np.ones(7), pd, 1e-3, steps=3)
    assert found.value.states == [1] and np.isfinite(found.value.result[0]).all()
    assert axode.rollout(ARM, q, v, pd.on(ARM), 1e-3, steps=0)[0].tolist() == q[:, None].tolist()
    empty = axode.Model.from_bodies([])
    none = np.zeros((2, 0))
    assert axode.rollout(empty, none, none, np.zeros(0), 0.1, steps=3)[0].shape == (2, 4, 0)


@pytest.mark.parametrize("drive, sentence", [
    (Sampled([0, 0], np.zeros((2, 7))), r"t\[1\] is 0"), (Sampled([], np.zeros((0, 7))), "t is empty"),
    (Sampled([0, 1], np.zeros((3, 7))), r"tau: expected shape \(2, 7\)"), (Sampled(0.0, np.zeros(7)), r"t: expected shape \(K,\)"),
    (Sampled([0, np.nan], np.zeros((2, 7))), r"t\[1\] is nan"), (Sampled([0.0], np.full((1, 7), np.inf)), r"tau\[0, 0\] is inf"),
    (PD(-1.0, 1.0, TARGET), r"kp\[0\] is -1"), (PD(np.ones(6), 1.0, TARGET), r"kp: expected shape \(\) or \(7,\)"),
    (PD(1.0, np.nan, TARGET), "kd is nan"), (PD(1.0, 1.0, np.zeros(6)), r"q: expected shape \(7,\)"),
    (PD(1.0, 1.0, TARGET, np.zeros(6)), r"v: expected shape \(7,\)"),
    (PD(1.0, 1.0, TARGET, feedforward=np.zeros(6)), r"feedforward: expected shape \(7,\)"),
    (PD(1.0, 1.0, TARGET, feedforward=Sampled([0.0], [np.zeros(6)])), r"tau: expected shape \(1, 7\)"),
    (ComputedTorque(1.0, 1.0, TARGET, a=np.zeros(6)), r"a: expected shape \(7,\)"),
    (PD(1.0, 1.0, axode.simulate(ARM, *REST, 0.01), np.zeros(7)), "v: leave it out, because q is a trajectory"),
    (PD(1.0, 1.0, axode.simulate(HUMANOID, HUMANOID.neutral(), np.zeros(HUMANOID.nv), 0.001)),
     "the trajectory has nq = "),
    (PD(1.0, 1.0, HUMANOID.neutral()).on(HUMANOID), 'tau: a drive of model "humanoid"')])
def test_what_cannot_be_used_is_refused(drive, sentence):
    with pytest.raises(ValueError, match=sentence):
        axode.simulate(ARM, *REST, 1.0, tau=drive)
