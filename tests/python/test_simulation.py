"""Motions: `axode.simulate` and `axode.reconstruct`."""

import sys
from concurrent.futures import ThreadPoolExecutor

import axode
import numpy as np
import pytest

ARM = axode.load(axode.robots / "arm7.toml")
HUMANOID = axode.load(axode.robots / "humanoid.urdf", base="free")
REST = np.full(7, 0.3), np.zeros(7)


@pytest.mark.parametrize("method, step, tolerance", [("dopri5", None, 1e-7), ("rk4", 1e-3, 1e-7), ("euler", 1e-4, 1e-2),
                                                     ("generalized_alpha", 1e-3, 1e-3), ("midpoint", 1e-3, 1e-3),
                                                     ("suzuki4", 2e-3, 1e-7), ("kahan_li6", 5e-3, 1e-7),
                                                     ("rk4_momenta", 1e-3, 1e-7)])
def test_methods_agree_and_keep_the_energy(method, step, tolerance):
    exact = axode.simulate(ARM, *REST, 0.5, rtol=1e-12, atol=1e-13)
    motion = axode.simulate(ARM, *REST, 0.5, method=method, step=step)
    assert motion.t[0] == 0 and motion.t[-1] == 0.5
    assert motion.q.shape == (len(motion.t), 7) and motion.v.shape == motion.q.shape
    np.testing.assert_allclose(motion.q[-1], exact.q[-1], atol=tolerance)
    assert np.ptp(motion.energy) < 100 * tolerance
    assert motion.complete and motion.stop_reason == "" and motion.steps == len(motion.t) - 1
    assert motion.evaluations >= motion.steps
    np.testing.assert_allclose(axode.forward_dynamics(ARM, motion.q, motion.v, motion.tau), motion.a, atol=1e-8)


def test_times_and_states_in_between():
    times = np.linspace(0, 0.5, 11)
    at_times = axode.simulate(ARM, *REST, 0.5, times=times)
    motion = axode.simulate(ARM, *REST, 0.5)
    np.testing.assert_array_equal(at_times.t, times)
    q, v = motion.at(times)
    np.testing.assert_array_equal(at_times.q, q)
    np.testing.assert_array_equal(at_times.v, v)
    np.testing.assert_array_equal(motion.at(0.25)[0], motion.at([0.25])[0][0])
    np.testing.assert_array_equal(motion.at(0.5)[0], motion.q[-1])


@pytest.mark.parametrize("times", [None, np.linspace(0, 0.2, 7)])
def test_what_drives(times):
    def drive(t, q, v):
        return np.sin(t + np.arange(7)) - 0.3 * v

    motion = axode.simulate(ARM, *REST, 0.2, tau=drive, times=times)
    expected = [drive(t, q, v) for t, q, v in zip(motion.t, motion.q, motion.v)]
    np.testing.assert_allclose(motion.tau, expected, atol=1e-12)
    np.testing.assert_allclose(axode.forward_dynamics(ARM, motion.q, motion.v, motion.tau), motion.a,
                               atol=1e-10 if times is None else 1e-4)


def test_rollouts_under_a_function():
    random = np.random.default_rng(2)
    q, v, steps, step = random.normal(size=(3, 7)), random.normal(size=(3, 7)), 50, 1e-3
    asked = []

    def policy(t, q, v):
        asked.append((t, q.shape, v.shape))
        return 1 - q - 0.1 * v + np.sin(t)

    all_q, all_v = axode.rollout(ARM, q, v, policy, step, steps=steps)
    assert asked == [(k * step, (3, 7), (3, 7)) for k in range(steps)]
    held = np.stack([policy(k * step, all_q[:, k], all_v[:, k]) for k in range(steps)], axis=1)
    for ours, expected in zip((all_q, all_v), axode.rollout(ARM, q, v, held, step)):
        np.testing.assert_allclose(ours, expected, atol=1e-12)
    def writing_on_its_arguments(t, q, v):
        forces = policy(t, q, v)
        q[:], v[:] = 9, 9
        return forces

    np.testing.assert_array_equal(axode.rollout(ARM, q, v, writing_on_its_arguments, step, steps=steps)[0], all_q)
    one = axode.rollout(ARM, q[0], v[0], policy, step, steps=steps)
    np.testing.assert_allclose(one[0], all_q[0], atol=1e-12)
    assert axode.rollout(ARM, q, v, policy, step, steps=0)[1].tolist() == v[:, None].tolist()


def test_rollouts_under_a_function_that_cannot_go_on():
    def policy(t, q, v):
        return np.where(t > 2.5e-3, 1e300, 0.0) * np.arange(2)[:, None] * np.ones(7)

    q, v = np.tile(REST[0], (2, 1)), np.zeros((2, 7))
    with pytest.raises(axode.NotFiniteError) as failed:
        axode.rollout(ARM, q, v, policy, 1e-3, steps=6)
    found = failed.value.result
    assert found.shape == (2, 7, 7) and np.isfinite(found[:, :4]).all() and np.isnan(found[:, 5:]).all()
    for call, words in [(lambda: axode.rollout(ARM, q, v, policy, 1e-3), "steps is missing"),
                        (lambda: axode.rollout(ARM, q, v, np.zeros((2, 3, 7)), 1e-3, steps=3), "steps is for functions"),
                        (lambda: axode.rollout(ARM, q, v, policy, 1e-3, steps=-1), "steps is -1"),
                        (lambda: axode.rollout(ARM, q, v, lambda t, q, v: v[0], 1e-3, steps=2), r"expected shape \(2, 7\)")]:
        with pytest.raises(ValueError, match=words):
            call()


def test_as_a_table(tmp_path):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    motion = axode.simulate(HUMANOID, HUMANOID.neutral(), np.zeros(HUMANOID.nv), 0.05, times=[0, 0.02, 0.05])
    table = motion.to_pandas()
    assert table.index.name == "t" and table.index.tolist() == [0, 0.02, 0.05]
    for what, names, numbers in [("q", HUMANOID.coordinate_names, motion.q), ("v", HUMANOID.velocity_names, motion.v),
                                 ("a", HUMANOID.velocity_names, motion.a), ("tau", HUMANOID.velocity_names, motion.tau)]:
        np.testing.assert_array_equal(table[[f"{what} {name}" for name in names]], numbers)
    np.testing.assert_array_equal(table["energy"], motion.energy)
    assert len(table.columns) == HUMANOID.nq + 3 * HUMANOID.nv + 1
    table.to_parquet(tmp_path / "fall.parquet")
    pandas.testing.assert_frame_equal(pandas.read_parquet(tmp_path / "fall.parquet"), table)


def test_drives():
    gravity_free = axode.simulate(ARM, *REST, 0.3, tau=lambda t, q, v: axode.gravity_torques(ARM, q))
    np.testing.assert_allclose(gravity_free.q[-1], REST[0], atol=1e-9)
    constant = np.arange(7.0)
    np.testing.assert_array_equal(axode.simulate(ARM, *REST, 0.1, tau=constant).q,
                                  axode.simulate(ARM, *REST, 0.1, tau=lambda t, q, v: constant).q)
    held = axode.simulate(ARM, *REST, 0.2, tau=axode.gravity_torques(ARM, REST[0]),
                          loads=[axode.Load(frame="flange", wrench=np.zeros(6))], joint_losses=True)
    np.testing.assert_allclose(held.q[-1], REST[0], atol=1e-9)


def test_threads_give_the_same_and_a_free_body_keeps_its_momentum():
    m = axode.Model.from_bodies([{"name": "top", "joint": {"kind": "free"}, "mass": 2.0, "com": [0.1, 0.2, 0.3],
                                  "inertia": [1.0, 2.0, 2.5]}], gravity=[0, 0, 0])
    with ThreadPoolExecutor(8) as pool:
        motions = list(pool.map(lambda _: axode.simulate(m, m.neutral(), [1.0, -2.0, 0.5, 0.3, 0.2, -0.4], 3.0, rtol=1e-10), range(8)))
    for motion in motions:
        np.testing.assert_array_equal(motion.q, motions[0].q)
    assert np.max(np.abs(motions[0].momentum - motions[0].momentum[0])) < 1e-7


def test_conserving_methods_refuse_forces_that_jump():
    arguments = dict(until=0.1, method="midpoint", step=1e-3)
    with pytest.raises(ValueError, match='events: method "midpoint" does not support them'):
        axode.simulate(ARM, *REST, **arguments, events=[lambda t, q, v: q[0]])
    m = axode.Model.from_bodies([{"name": "block", "mass": 1.0, "com": [0, 0, 0], "inertia": [1, 1, 1], "joint":
                                  {"name": "rail", "kind": "prismatic", "axis": "x", "friction": 0.5}}])
    with pytest.raises(ValueError, match='joint "rail" has dry friction of 0.5'):
        axode.simulate(m, [0.0], [1.0], **arguments, joint_losses=True)
    assert axode.simulate(m, [0.0], [1.0], **arguments).complete


def test_loads_that_are_computed():
    m = axode.Model.from_bodies([{"name": "body", "mass": 2.0, "com": [0, 0, 0], "inertia": [0.3, 0.2, 0.1],
                                  "joint": {"kind": "free"}}], gravity=[0, 0, 0])

    def push(t, q, v):
        return [{"frame": "body", "representation": "hybrid", "wrench": [0, 0, 0, np.sin(t), 0, 0]}]
    motion = axode.simulate(m, m.neutral(), [1, 2, 3, 0, 0, 0], 2.0, loads=push)
    assert axode.poses(m, motion.q[-1])[m.frame_names.index("body")][0, 3] == pytest.approx(1 - np.sin(2) / 2, abs=1e-7)
    with pytest.raises(ValueError, match="loads: expected a list of dicts"):
        axode.simulate(m, m.neutral(), np.zeros(6), 2.0, loads=lambda t, q, v: 3)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_rollouts_with_losses_are_simulations(friction):
    m = axode.Model.from_bodies([{"name": f"rod {k}", **({"on": f"rod {k - 1}"} if k else {}), "mass": 1.0,
                                  "com": [0, 0, -0.5 - k], "inertia": [0.1, 0.1, 0.01],
                                  "joint": {"kind": "revolute", "axis": "y", "point": [0, 0, -k], "damping": 0.3 + 0.1 * k,
                                            "friction": friction}} for k in range(3)])
    rng = np.random.default_rng(3)
    q, v = rng.normal(size=(9, 3)), rng.normal(size=(9, 3))
    v[:, 1] = 0
    tau = rng.normal(size=(9, 3))
    for given in (np.repeat(tau[:, None], 80, axis=1), None):
        q_t, v_t = axode.rollout(m, q, v, given if given is not None else tau[0], 0.02, threads=2, joint_losses=True,
                                 steps=80 if given is None else None)
        for k in range(9):
            one = axode.simulate(m, q[k], v[k], 1.6, method="rk4", step=0.02, tau=tau[k if given is not None else 0],
                                 joint_losses=True, times=np.arange(81) * 0.02 - 1e-15 * np.arange(81))
            assert np.allclose(q_t[k], one.q, atol=1e-9)
            assert np.allclose(v_t[k], one.v, atol=1e-8)
    assert not np.allclose(q_t, axode.rollout(m, q, v, tau[0], 0.02, steps=80)[0])


def test_rollouts_with_losses_say_why_they_end():
    m = axode.Model.from_bodies([{"name": "rod", "joint": {"name": "pin", "kind": "revolute", "axis": "y",
                                                           "point": [0, 0, 0], "friction": 1.0}}])
    with pytest.raises(axode.SingularError, match='joint "pin"'):
        axode.rollout(m, [0.0], [1.0], [0.0], 0.01, steps=5, joint_losses=True)


def test_a_bar_without_tqdm_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match="^progress=True shows a bar of tqdm, which is not installed: pip install tqdm$"):
        axode.simulate(axode.load(axode.robots / "double_pendulum.toml"), [1, 0], [0, 0], 1.0, progress=True)


def test_events():
    m = axode.Model.from_bodies([{"name": "ball", "joint": {"kind": "prismatic", "axis": "z"}, "mass": 1.0,
                                  "com": [0, 0, 0], "inertia": [1.0, 1.0, 1.0]}])

    def ground(t, q, v):
        return q[0]
    ground.terminal = True
    motion = axode.simulate(m, [2.0], [0.0], 5.0, events=[lambda t, q, v: q[0] - 1, ground])
    assert [k for k, _ in motion.events] == [0, 1]
    np.testing.assert_allclose([t for _, t in motion.events], np.sqrt([2 / 9.81, 4 / 9.81]), atol=1e-8)
    assert motion.t[-1] == motion.events[-1][1] and abs(motion.q[-1, 0]) < 1e-8
    with pytest.raises(ValueError, match=r"^events\[0\]: expected a function"):
        axode.simulate(m, [2.0], [0.0], 5.0, events=[3])


def test_motions_that_cannot_go_on_say_why():
    def burst(t, q, v):
        return np.full(7, 1e300 if t > 0.1 else 0.0)
    with pytest.raises(axode.SimulationError, match="at t = 0.1") as found:
        axode.simulate(ARM, *REST, 1.0, method="rk4", step=0.01, tau=burst)
    assert 0.05 < found.value.trajectory.t[-1] <= 0.11
    massless = axode.Model.from_bodies([{"name": "slide", "joint": {"kind": "prismatic", "axis": "z"}}])
    for times in (None, [0.0, 1.0]):
        with pytest.raises(axode.SimulationError, match='"slide_joint"') as found:
            axode.simulate(massless, [0.0], [0.0], 1.0, times=times)
        assert found.value.trajectory.q.shape == (0, 1)
    with pytest.raises(ZeroDivisionError):
        axode.simulate(ARM, *REST, 1.0, tau=lambda t, q, v: 1 / 0)
    with pytest.raises(ValueError, match=r"tau\(t, q, v\): expected shape \(7,\)"):
        axode.simulate(ARM, *REST, 1.0, tau=lambda t, q, v: np.zeros(6))
    with pytest.raises(ValueError, match=r"tau\(t, q, v\)\[3\] is nan"):
        axode.simulate(ARM, *REST, 1.0, tau=lambda t, q, v: np.where(np.arange(7) == 3, np.nan, 0))


@pytest.mark.parametrize("arguments, sentence", [
    (dict(until=-1.0), "until is -1"), (dict(until=np.nan), "until is nan"), (dict(until=np.inf), "until is inf"),
    (dict(until=1.0, method="rk4"), "step: method 'rk4'"), (dict(until=1.0, method="rk4", step=0.0), "step is 0"),
    (dict(until=1.0, method="rk4", step=-0.1), "step is -0.1"), (dict(until=1.0, step=-0.1), "step is -0.1"),
    (dict(until=1.0, step=0.0), "step is 0"),
    (dict(until=1.0, method="verlet"), "method is 'verlet'; expected one of 'dopri5', 'rk4', 'euler', 'generalized_alpha', 'midpoint'"),
    (dict(until=1.0, rtol=-1.0), "relative tolerance is -1"),
    (dict(until=1.0, times=[0, 0.5, 0.5]), r"times\[2\] is 0.5"), (dict(until=1.0, times=[2.0]), r"times\[0\] is 2"),
    (dict(until=1.0, tau=np.zeros(6)), r"tau: expected shape \(7,\)"),
    (dict(until=1.0, tau=np.full(7, np.nan)), r"tau\[0\] is nan")])
def test_what_cannot_be_used_is_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        axode.simulate(ARM, *REST, **arguments)


def test_nothing_at_all_moves():
    empty = axode.Model.from_bodies([])
    motion = axode.simulate(empty, [], [], 1.0)
    assert motion.q.shape == (len(motion.t), 0) and motion.energy.tolist() == [0.0] * len(motion.t)
    assert axode.rollout(empty, np.zeros((2, 0)), np.zeros((2, 0)), np.zeros((2, 3, 0)), 0.1)[0].shape == (2, 4, 0)


def test_outside_of_a_motion():
    motion = axode.simulate(ARM, *REST, 0.1)
    for t in (-0.1, 0.2, [0.05, 0.2]):
        with pytest.raises(ValueError, match="the trajectory is from 0"):
            motion.at(t)
    assert axode.simulate(ARM, *REST, 0.0).t.tolist() == [0.0]


def test_rollouts_are_the_motions_one_by_one():
    rng = np.random.default_rng(3)
    q0, v0, tau = HUMANOID.random(n=6), 0.1 * rng.normal(size=(6, HUMANOID.nv)), rng.normal(size=(6, 4, HUMANOID.nv))
    q, v = axode.rollout(HUMANOID, q0, v0, tau, 1e-3)
    assert q.shape == (6, 5, HUMANOID.nq) and v.shape == (6, 5, HUMANOID.nv)
    np.testing.assert_array_equal(q[:, 0], q0)
    for n in range(6):
        at = q0[n], v0[n]
        for k in range(4):
            step = axode.simulate(HUMANOID, *at, 1e-3, method="rk4", step=1e-3, tau=tau[n, k])
            at = step.q[-1], step.v[-1]
        np.testing.assert_allclose(q[n, -1], at[0], atol=1e-13)
        np.testing.assert_allclose(v[n, -1], at[1], atol=1e-11)
    for x, y in zip((q, v), axode.rollout(HUMANOID, q0, v0, tau, 1e-3, threads=2)):
        np.testing.assert_array_equal(x, y)
    assert axode.rollout(ARM, np.zeros((0, 7)), np.zeros((0, 7)), np.zeros((0, 3, 7)), 1e-3)[0].shape == (0, 4, 7)


def test_rollouts_say_which_motions_cannot_go_on():
    tau = np.zeros((3, 5, 7))
    tau[1, 2] = 1e300
    with pytest.raises(axode.NotFiniteError) as found:
        axode.rollout(ARM, np.full((3, 7), 0.1), np.zeros((3, 7)), tau, 1e-2)
    assert found.value.states == [1]
    assert np.all(np.isfinite(found.value.result[[0, 2]])) and np.all(np.isnan(found.value.result[1, -1]))
    for arguments, sentence in [((np.zeros(7), np.zeros(7), tau, 1e-2), r"tau: expected shape \(K, 7\)"),
                                ((np.zeros((3, 7)), np.zeros((3, 7)), tau[:2], 1e-2), "tau: expected shape"),
                                ((np.zeros((3, 7)), np.zeros((3, 7)), tau, 0.0), "step is 0")]:
        with pytest.raises(ValueError, match=sentence):
            axode.rollout(ARM, *arguments)


def twisting(t):
    return np.array([np.sin(2 * t), 1 + t, np.cos(3 * t), t, 0.5, -t])


@pytest.mark.parametrize("representation", ["body", "spatial"])
def test_reconstruction(representation):
    C0 = axode.lie.exp(np.array([0.1, 0.2, -0.3, 1.0, 2.0, 3.0]))
    times = np.linspace(0, 1, 201)
    C = axode.reconstruct(C0, twisting, times, representation)
    assert C.shape == (201, 4, 4)
    np.testing.assert_array_equal(C[0], C0)
    middle = axode.lie.log(axode.lie.inverse(C[99]) @ C[101] if representation == "body"
                           else C[101] @ axode.lie.inverse(C[99])) / (times[101] - times[99])
    np.testing.assert_allclose(middle, twisting(times[100]), atol=1e-3)
    sampled = axode.reconstruct(C0, np.array([twisting(t) for t in times]), times, representation)
    np.testing.assert_allclose(sampled, C, atol=1e-8)
    for method in ("cayley", "magnus", "apart"):
        np.testing.assert_allclose(axode.reconstruct(C0, twisting, times, representation, method=method), C, atol=1e-8)
    low = axode.reconstruct(C0, twisting, times, representation, order=1)
    assert 1e-4 < np.max(np.abs(low[-1] - C[-1])) < 0.1


def test_reconstruction_refuses():
    with pytest.raises(ValueError, match="order is 7"):
        axode.reconstruct(np.eye(4), twisting, [0, 1], order=7)
    with pytest.raises(ValueError, match="Magnus' method is of order 4"):
        axode.reconstruct(np.eye(4), twisting, [0, 1], order=3, method="magnus")
    with pytest.raises(ValueError, match="method is 'euler'; expected one of 'munthe_kaas'"):
        axode.reconstruct(np.eye(4), twisting, [0, 1], method="euler")
    with pytest.raises(ValueError, match="'body' or 'spatial'"):
        axode.reconstruct(np.eye(4), twisting, [0, 1], "hybrid")
    with pytest.raises(ValueError, match=r"times\[1\]"):
        axode.reconstruct(np.eye(4), twisting, [1, 0])
    with pytest.raises(ValueError, match="twist: expected shape"):
        axode.reconstruct(np.eye(4), np.zeros((3, 6)), [0, 1])
    assert axode.reconstruct(np.eye(4), np.zeros(6), []).shape == (0, 4, 4)


@pytest.mark.parametrize("method", ["rk4", "midpoint", "generalized_alpha", "rk4_momenta"])
def test_steps_by_cayley_s_map_lead_to_the_same_motion(method):
    m = HUMANOID
    q, v = m.random(seed=1), np.random.default_rng(1).normal(size=m.nv)
    ends = [axode.simulate(m, q, v, 0.02, method=method, step=1e-3, local_coordinates=coordinates).q[-1]
            for coordinates in ("exponential", "cayley")]
    apart = np.linalg.norm(m.difference(*ends))
    assert 0 < apart < 1e-3


def test_local_coordinates_are_named_and_have_their_limits():
    with pytest.raises(ValueError, match="local_coordinates is 'polar'; expected one of 'exponential', 'cayley'"):
        axode.simulate(ARM, *REST, 0.1, local_coordinates="polar")
    with pytest.raises(ValueError, match='RATTLE in absolute coordinates needs local_coordinates = "exponential"; got "cayley"'):
        axode.simulate(ARM, *REST, 0.1, method="rattle", step=1e-3, coordinates="absolute",
                       local_coordinates="cayley")


FALLING = """format = "axode drawing 1"
name = "ball"
[[shape]]
kind = "plane"
role = "collision"
[[body]]
name = "ball"
joint = { kind = "free" }
mass = 1
com = [0, 0, 0]
inertia = [0.01, 0.01, 0.01]
[[body.shape]]
kind = "sphere"
radius = 0.1
role = "collision"
"""


def test_what_falls_on_a_floor_stays_there(tmp_path):
    file = tmp_path / "ball.toml"
    file.write_text(FALLING)
    ball = axode.load(file)
    start = np.array([0, 0, 0, 1, 0, 0, 0.3])
    motion = axode.simulate(ball, start, np.zeros(6), 0.5, step=1e-3, contact=True)
    assert abs(motion.q[-1, 6] - 0.1) < 1e-12 and np.abs(motion.v[-1]).max() < 1e-12
    assert len(motion.certificates) == motion.steps and motion.certificates.max() < 1e-9
    file.write_text(FALLING + "[contact]\n")
    touching = axode.load(file)
    assert np.array_equal(axode.simulate(touching, start, np.zeros(6), 0.5, step=1e-3).q, motion.q)
    assert np.array_equal(axode.simulate(touching, start, np.zeros(6), 0.5).q, motion.q), "steps of 1 ms if none are given"
    assert axode.simulate(touching, start, np.zeros(6), 0.5, contact=False).q[-1, 6] < 0
    through = axode.simulate(ball, start, np.zeros(6), 0.5, step=1e-3, method="midpoint")
    assert through.q[-1, 6] < 0 and len(through.certificates) == 0


def test_plays_tell_when_they_meet_their_ends():
    slider = {"kind": "prismatic", "axis": "x"}
    m = axode.Model.from_dict({
        "format": "axode drawing 1", "gravity": [0, 0, 0],
        "body": [{"name": name, "joint": slider | {"name": name}, "mass": mass, "com": [0, 0, 0], "inertia": [1, 1, 1]}
                 for name, mass in (("a", 1), ("b", 2))],
        "coupling": [{"name": "buffer", "terms": {"a": 1, "b": -1}, "play": 0.2, "restitution": 0.5}]})
    motion = axode.simulate(m, [0, 0], [3, 0], 0.2)
    first, second = motion.play_events
    assert (first.coupling, first.side, first.impact, first.stays) == ("buffer", 1, True, False)
    assert (first.t, first.speed, first.impulse) == pytest.approx((0.1 / 3, 3, 3), abs=1e-9)
    assert second.side == -1 and second.t == pytest.approx(0.1 / 3 + 0.2 / 1.5, abs=1e-9)
    assert axode.simulate(m, [0, 0], [3, 0], 0.2, times=[0, 0.2]).play_events == motion.play_events
    assert axode.simulate(m, [0, 0], [0, 0], 0.2).play_events == []
