"""Drives of simulations: `axode.drives`."""

import threading
import time

import axode
import numpy as np
import pytest
from axode.drives import PD, ComputedTorque, Sampled, jerk_limited_profile, quintic_profile, trapezoidal_profile

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


# The goal and the motions of tests/integration/references.cpp, which expects the same numbers.
GOAL = np.array([0.3, 0.9, -0.2, -1.2, 0.1, 0.7, 0.0])
KP, KD = np.array([300, 300, 100, 100, 20, 20, 5.0]), np.array([30, 30, 10, 10, 1, 1, 0.2])
AFTER_HALF_A_SECOND = [
    (lambda motion: PD(KP, KD, motion), [0.102331471969416, 0.32730562631117, -0.0787280669991157, -0.46728652434372,
                                         0.0363755519853867, 0.247725641339614, 4.88768689048955e-05]),
    (lambda motion: ComputedTorque(400.0, 40.0, motion), [0.107996512861124, 0.348494549706939, -0.071997675240749,
                                                          -0.483152231099273, 0.0359988376203745, 0.251991863342621, 0])]


@pytest.mark.parametrize("drive, expected", AFTER_HALF_A_SECOND, ids=["PD", "ComputedTorque"])
def test_drives_follow_a_profile_as_in_cpp(drive, expected):
    motion = trapezoidal_profile(ARM, np.zeros(7), GOAL, acceleration=5.0)
    end = axode.simulate(ARM, np.zeros(7), np.zeros(7), 0.5, method="rk4", step=1e-3, tau=drive(motion)).q[-1]
    np.testing.assert_allclose(end, expected, atol=1e-9)


def made_motions():
    """Motions from rest to rest of an arm and of a humanoid on a free base, with their limits."""
    rng = np.random.default_rng(5)
    profiles = {"quintic": quintic_profile, "trapezoidal": trapezoidal_profile,
                "jerk-limited": lambda *x, **limits: jerk_limited_profile(*x, jerk=20.0, **limits)}
    for m in ARM, HUMANOID:
        limits = {"acceleration": rng.uniform(1, 5, m.nv), "velocity": rng.uniform(0.5, 2, m.nv)}
        for name, profile in profiles.items():
            yield pytest.param(m, *m.random(seed=2, n=2), profile, limits, id=f"{m.name} {name}")


@pytest.mark.parametrize("m, start, goal, profile, limits", [*made_motions()])
def test_profiles_reach_the_goal_within_their_limits(m, start, goal, profile, limits):
    motion = profile(m, start, goal, **limits)
    assert motion.t[0] == 0 and motion.steps == len(motion.t) - 1
    np.testing.assert_allclose(m.difference(motion.q[[0, -1]], [start, goal]), 0, atol=1e-12)
    np.testing.assert_allclose(motion.v[[0, -1]], 0, atol=1e-12)
    t, h = np.linspace(0, motion.t[-1], 303)[1:-1], 1e-5
    q, v = motion.at(t)
    assert np.all(np.abs(v) <= limits["velocity"] * (1 + 1e-9))
    before, after = motion.at(t - h), motion.at(t + h)
    np.testing.assert_allclose(m.difference(before[0], after[0]) / (2 * h), v, atol=6e-5)
    assert np.all(np.abs(after[1] - before[1]) <= 2 * h * limits["acceleration"] * (1 + 1e-6))
    assert np.all(np.abs(motion.a) <= limits["acceleration"] * (1 + 1e-9))
    reached = max(np.max(np.abs(motion.v) / limits["velocity"]), np.max(np.abs(motion.a) / limits["acceleration"]))
    assert reached > 0.98


def test_jerk_limited_profiles_keep_the_jerk_and_are_exact_between_their_states():
    motion = jerk_limited_profile(ARM, np.zeros(7), GOAL, acceleration=3.0, velocity=1.0, jerk=25.0)
    steps = np.diff(motion.t)
    jerks = np.diff(motion.a, axis=0) / steps[:, None]
    assert np.max(np.abs(jerks[steps > 1e-4])) <= 25 * (1 + 1e-6)
    one = jerk_limited_profile(ARM, np.zeros(7), GOAL * [0, 0, 0, 1, 0, 0, 0], acceleration=3.0, velocity=1.0, jerk=25.0)
    q, v = one.at(0.06)
    assert q[3] == pytest.approx(-25 * 0.06**3 / 6, abs=1e-12) and v[3] == pytest.approx(-25 * 0.06**2 / 2, abs=1e-10)
    assert one.t[-1] == pytest.approx(1.2 / 1.0 + 1.0 / 3.0 + 3.0 / 25.0)
    assert len(jerk_limited_profile(ARM, GOAL, GOAL, acceleration=3.0, jerk=25.0).t) == 1
    near = jerk_limited_profile(ARM, np.zeros(7), GOAL * 10.0 ** -np.arange(7), acceleration=3.0, jerk=25.0)
    np.testing.assert_allclose(near.q[-1], GOAL * 10.0 ** -np.arange(7), rtol=1e-14)


def test_motions_through_samples_and_by_functions_are_followed():
    t = np.linspace(0, 0.3, 31)
    x = 0.3 * np.sin(5 * t[:, None] + np.arange(HUMANOID.nv))
    q = HUMANOID.integrate(np.tile(HUMANOID.neutral(), (31, 1)), x - x[0])
    motion = axode.Trajectory.from_samples(HUMANOID, t, q)
    assert (motion.q.shape, motion.v.shape, motion.a.shape) == (q.shape, x.shape, x.shape)
    np.testing.assert_allclose(motion.v[:, 6:], 1.5 * np.cos(5 * t[:, None] + np.arange(6, HUMANOID.nv)), atol=1e-5)
    again = axode.Trajectory.from_samples(HUMANOID, t, q, motion.v, motion.a)
    for one, other in zip(motion.at(0.123), again.at(0.123)):
        np.testing.assert_array_equal(one, other)
    by_velocities = axode.Trajectory.from_samples(HUMANOID, t, q, motion.v)
    np.testing.assert_allclose(by_velocities.a, motion.a, atol=2e-3)
    done = axode.simulate(HUMANOID, q[0], motion.v[0], 0.3, tau=ComputedTorque(400.0, 40.0, motion))
    np.testing.assert_allclose(HUMANOID.difference(done.q[-1], q[-1]), 0, atol=1e-5)

    swing = {"A2": lambda now: (0.5 * np.sin(2 * now), np.cos(2 * now), -2 * np.sin(2 * now))}
    motion = axode.Trajectory.from_functions(ARM, np.linspace(0, 1, 41), swing, REST[0])
    expected = REST[0] * (np.arange(7) != 1) + 0.5 * np.sin(2 * 0.517) * (np.arange(7) == 1)
    np.testing.assert_allclose(motion.at(0.517)[0], expected, atol=1e-10)
    done = axode.simulate(ARM, motion.q[0], motion.v[0], 1.0, tau=ComputedTorque(400.0, 40.0, motion))
    np.testing.assert_allclose(done.q[-1], motion.q[-1], atol=1e-6)


T_Q = [0.0, 1.0], np.zeros((2, 7))
SAMPLES, FUNCTIONS = axode.Trajectory.from_samples, axode.Trajectory.from_functions


@pytest.mark.parametrize("call, sentence", [
    (lambda: SAMPLES(ARM, [0.0], np.zeros((1, 7))), "t has 1 times; a trajectory needs at least two"),
    (lambda: SAMPLES(ARM, [0.0, 0.0], np.zeros((2, 7))), r"t\[1\] is 0"),
    (lambda: SAMPLES(ARM, 0.0, np.zeros((1, 7))), r"t: expected shape \(K,\)"),
    (lambda: SAMPLES(ARM, [0.0, 1.0], np.zeros((3, 7))), r"q: expected shape \(2, 7\), nq numbers for each time"),
    (lambda: SAMPLES(ARM, *T_Q, np.zeros(7)), r"v: expected shape \(2, 7\), nv numbers"),
    (lambda: SAMPLES(ARM, *T_Q, a=np.zeros((2, 7))), "v is missing"),
    (lambda: SAMPLES(ARM, [0.0, 1.0], np.full((2, 7), np.nan)), r"q\[0, 0\] is nan"),
    (lambda: SAMPLES(HUMANOID, [0.0, 1.0], np.zeros((2, HUMANOID.nq))), r"q\[0\]: the quaternion of joint .* has norm 0"),
    (lambda: FUNCTIONS(ARM, [0.0, 1.0], {"A9": lambda t: (0, 0, 0)}), 'no joint and no rod "A9"'),
    (lambda: FUNCTIONS(ARM, [0.0, 1.0], {"A1": lambda t: (0, 0)}), r"motions\[\"A1\"\]\(t\): expected shape"),
    (lambda: FUNCTIONS(ARM, [0.0, 1.0], {}, np.zeros(6)), r"q: expected shape \(7,\)"),
    (lambda: quintic_profile(ARM, np.zeros(6), GOAL, acceleration=1.0), r"start: expected shape \(7,\)"),
    (lambda: quintic_profile(ARM, np.zeros(7), 10 * GOAL, acceleration=1.0), r'goal\[\d\] is .* has the limits'),
    (lambda: quintic_profile(ARM, np.zeros(7), GOAL, acceleration=0.0), r"acceleration\[0\] is 0; a limit must be positive"),
    (lambda: quintic_profile(ARM, np.zeros(7), GOAL, acceleration=np.inf), r"acceleration\[0\] is inf"),
    (lambda: quintic_profile(ARM, np.zeros(7), GOAL, acceleration=np.ones(6)), r"acceleration: expected shape \(\) or \(7,\)"),
    (lambda: trapezoidal_profile(ARM, np.zeros(7), GOAL, acceleration=1.0, velocity=-1.0), r"velocity\[0\] is -1"),
    (lambda: jerk_limited_profile(ARM, np.zeros(7), GOAL, acceleration=1.0, jerk=0.0), r"jerk\[0\] is 0")])
def test_motions_that_cannot_be_made_are_refused(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()
