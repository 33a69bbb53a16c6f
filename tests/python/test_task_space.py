"""Parallel manipulators in their task space, against the functions for any mechanism with loops."""

import threading

import axode
import numpy as np
import pytest

GOUGH, DELTA = (axode.load(axode.robots / name) for name in ("gough.toml", "delta.toml"))
FOUR_BAR = axode.load(axode.robots / "four_bar.toml")


def space_of(m):
    return axode.TaskSpace(m, m.neutral())


def moving(m, N=6, seed=1):
    """A task space, and states (q, V, v, dV) of N random motions."""
    space, rng = space_of(m), np.random.default_rng(seed)
    turn = 0.15 if m is GOUGH else 0.0
    q = np.stack([space.place_platform(axode.lie.exp(np.concatenate([turn * x[:3], 0.05 * x[3:]])), m.neutral())
                  for x in rng.uniform(-1, 1, (N, 6))])
    V, dV = rng.normal(size=(2, N, space.freedom))
    return space, q, V, space.velocities(q, V), dV


@pytest.mark.parametrize("m, names", [
    (GOUGH, [f"platform.{x}" for x in ("omega_x", "omega_y", "omega_z", "v_x", "v_y", "v_z")]),
    (DELTA, ["plate.v_x", "plate.v_y", "plate.v_z"])], ids=["gough", "delta"])
def test_limbs_and_task_velocities_are_named(m, names):
    space = space_of(m)
    assert space.names == names and space.freedom == len(names)
    assert space.platform == names[0].partition(".")[0]
    assert sorted(c for limb in space.limbs for c in limb) == list(range(6, m.nv))
    assert repr(space).startswith(f'TaskSpace of "{space.platform}" with {len(space.limbs)} limbs: {names[0]}, ')
    named = axode.TaskSpace(m, m.neutral(), space.platform)
    assert named.names == names and named.limbs == space.limbs


def test_without_a_platform_task_velocities_are_those_of_joints():
    space = space_of(FOUR_BAR)
    assert space.platform is None and space.freedom == 1 and set(space.names) <= set(FOUR_BAR.velocity_names)
    assert repr(space).startswith("TaskSpace of no platform with ")
    v = space.velocities(FOUR_BAR.neutral(), [1.0])
    np.testing.assert_allclose(axode.loop_jacobian(FOUR_BAR, FOUR_BAR.neutral()) @ v, 0, atol=1e-9)
    for call in (lambda: space.place_platform(np.eye(4), FOUR_BAR.neutral()), lambda: space.singularities(FOUR_BAR.neutral())):
        with pytest.raises(ValueError, match="platform"):
            call()


@pytest.mark.parametrize("m", [GOUGH, DELTA], ids=["gough", "delta"])
def test_motions_and_forces_are_those_of_the_mechanism_with_loops(m):
    space, q, V, v, dV = moving(m)
    a = space.accelerations(q, v, dV)
    for k in range(len(q)):
        A = axode.loop_jacobian(m, q[k])
        np.testing.assert_allclose(A @ v[k], 0, atol=1e-9)
        np.testing.assert_allclose(A @ a[k] + axode.loop_bias(m, q[k], v[k]), 0, atol=1e-8)
    loads = [axode.Load(frame=space.platform, representation="hybrid", wrench=np.outer(np.arange(1.0, 7), np.arange(6)))]
    for given in ({}, {"loads": loads, "joint_losses": True}):
        tau = space.inverse_dynamics(q, v, dV, **given)
        np.testing.assert_allclose(tau, axode.inverse_dynamics(m, q, v, a, **given), atol=1e-8 * np.abs(tau).max())
        back = space.forward_dynamics(q, v, tau, **given)
        np.testing.assert_allclose(back, dV, atol=1e-9 * np.abs(a).max())
        np.testing.assert_allclose(space.accelerations(q, v, back), axode.forward_dynamics(m, q, v, tau, **given),
                                   atol=1e-8 * np.abs(a).max())


@pytest.mark.parametrize("m", [GOUGH, DELTA], ids=["gough", "delta"])
def test_equations_are_those_of_the_dynamics(m):
    space, q, V, v, dV = moving(m, 1)
    q, V, v, dV = q[0], V[0], v[0], dV[0]
    found = space.equations(q, v)
    np.testing.assert_allclose(found.F @ V, v, atol=1e-12)
    np.testing.assert_allclose(found.F @ dV + found.c, space.accelerations(q, v, dV), atol=1e-10)
    np.testing.assert_array_equal(found.J, found.F[found.drives])
    u = space.inverse_dynamics(q, v, dV)[found.drives]
    np.testing.assert_allclose(found.M @ dV + found.h, found.J.T @ u, atol=1e-9 * np.abs(u).max())
    np.testing.assert_allclose(found.M, found.F.T @ axode.mass_matrix(m, q) @ found.F, atol=1e-10)


def test_rates_of_forces_are_those_of_the_mechanism_with_loops():
    space, q, V, v, dV = moving(GOUGH, 3)
    rates = np.stack([V, dV, V - dV, V * dV], axis=1)
    tau, motion = space.inverse_dynamics_rates(q, rates)
    assert tau.shape == (3, 3, GOUGH.nv) and motion.shape == (3, 4, GOUGH.nv)
    np.testing.assert_allclose(motion[:, 0], v, atol=1e-12)
    np.testing.assert_allclose(tau[:, 0], space.inverse_dynamics(q, v, dV), atol=1e-9 * np.abs(tau).max())
    for x, y in zip(np.moveaxis(tau, 1, 0), axode.inverse_dynamics_rates(GOUGH, q, *np.moveaxis(motion, 1, 0)), strict=True):
        np.testing.assert_allclose(x, y, atol=1e-8 * np.abs(y).max())
    np.testing.assert_array_equal(space.inverse_dynamics_rates(q[1], rates[1])[0], tau[1])


def test_many_states_are_each_as_if_alone_on_any_number_of_threads():
    space, q, V, v, dV = moving(GOUGH)
    for f, x in ((lambda *x, **how: space.velocities(*x, **how), (q, V)),
                 (lambda *x, **how: space.accelerations(*x, **how), (q, v, dV)),
                 (lambda *x, **how: space.inverse_dynamics(*x, **how), (q, v, dV)),
                 (lambda *x, **how: space.forward_dynamics(*x, **how), (q, v, v))):
        many = f(*x)
        np.testing.assert_array_equal(f(*x, threads=3), many)
        np.testing.assert_array_equal(np.stack([f(*one) for one in zip(*x)]), many)


def test_threads_of_python_may_share_a_task_space():
    space, q, V, v, dV = moving(GOUGH)
    q, v, dV = (np.tile(x, (500, 1)) for x in (q, v, dV))
    expected, found = space.inverse_dynamics(q, v, dV), [None, None]

    def work(k):
        found[k] = space.inverse_dynamics(q, v, dV)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(x, expected) for x in found)


def test_the_platform_has_the_pose_or_an_error_says_which_limb_does_not_reach_it():
    space, C = space_of(GOUGH), axode.lie.exp([0.1, -0.2, 0.1, 0.02, 0.05, 0.1])
    q = space.place_platform(C, GOUGH.neutral())
    np.testing.assert_allclose(axode.pose(GOUGH, q, "platform"), C, atol=1e-12)
    assert np.abs(axode.loop_residual(GOUGH, q)).max() < 1e-9
    turned = axode.lie.exp([0.1, 0, 0, 0, 0, 0])
    with pytest.raises(axode.AssemblyError, match='^the limb with .* does not reach the pose: it stays open by ') as found:
        space_of(DELTA).place_platform(turned, DELTA.neutral())  # its plate does not turn
    assert found.value.q.shape == (DELTA.nq,) and found.value.residual > 1e-3


def quarter_turn(space):
    q = GOUGH.neutral()
    for angle in (0.3, 0.6, 0.9, 1.2, np.pi / 2):
        q = space.place_platform(axode.lie.exp([0, 0, angle, 0, 0, 0]), q)
    return q


def test_a_singularity_of_the_drives_has_its_screw_and_their_names():
    space = space_of(GOUGH)
    assert space.singularities(GOUGH.neutral()) == []
    q = quarter_turn(space)
    [found] = space.singularities(q)
    assert found.type == "drives" and found.limb is None and found.distance < 1e-9
    assert found.joints == [f"drive {k}" for k in range(1, 7)]
    assert found.sentence.startswith("type 2: the platform can move while all drives are locked, about the axis along ")
    twist = axode.lie.change_twist(axode.pose(GOUGH, q, "platform"), found.twist, "spatial", "body")
    v = space.velocities(q, twist)
    assert np.abs(v[space.equations(GOUGH.neutral(), np.zeros(24)).drives]).max() < 1e-9 < np.abs(v).max()


def test_states_that_are_singular_are_named_and_the_others_have_results():
    space = space_of(GOUGH)
    q = np.stack([GOUGH.neutral(), quarter_turn(space)])
    with pytest.raises(axode.SingularError, match="^state 1: type 2: the platform can move") as found:
        space.inverse_dynamics(q, np.zeros((2, 24)), np.ones((2, 6)))
    assert found.value.states == [1]
    np.testing.assert_array_equal(found.value.result[0], space.inverse_dynamics(q[0], np.zeros(24), np.ones(6)))
    assert np.isnan(found.value.result[1]).all()
    with pytest.raises(axode.NotFiniteError):
        space.inverse_dynamics(q[0], np.full(24, 1e200), np.ones(6))


@pytest.mark.parametrize("call, error, words", [
    (lambda: axode.TaskSpace(GOUGH, GOUGH.neutral(), "plattform"), KeyError, 'did you mean "platform"'),
    (lambda: axode.TaskSpace(FOUR_BAR, FOUR_BAR.neutral(), "coupler"), ValueError, '"coupler" hangs on another body'),
    (lambda: axode.TaskSpace(GOUGH, GOUGH.neutral() + 0.1 * (np.arange(25) == 6)), ValueError, "q leaves loop"),
    (lambda: axode.TaskSpace(axode.load(axode.robots / "arm7.toml"), np.zeros(7)), ValueError, "has no loops"),
    (lambda: axode.TaskSpace(GOUGH), TypeError, "TaskSpace needs 'q' as well"),
    (lambda: space_of(GOUGH).velocities(GOUGH.neutral(), np.zeros(5)), ValueError, r"V: expected shape \(6,\)"),
    (lambda: space_of(GOUGH).accelerations(GOUGH.neutral(), np.zeros(6), np.zeros(6)), ValueError, r"v: expected shape \(24,\)"),
    (lambda: space_of(GOUGH).inverse_dynamics_rates(GOUGH.neutral(), np.zeros((1, 6))), ValueError, r"\(K \+ 1, 6\)"),
    (lambda: space_of(GOUGH).inverse_dynamics_rates(GOUGH.neutral(), np.zeros((9, 6))), ValueError, "1 to 7 rows"),
    (lambda: space_of(GOUGH).place_platform(np.zeros((4, 4)), GOUGH.neutral()), ValueError, "^C"),
    (lambda: space_of(GOUGH).singularities(GOUGH.neutral(), within=2), ValueError, "within is 2"),
    (lambda: space_of(GOUGH).velocities(np.stack(2 * [GOUGH.neutral()]) * [[1], [2]], np.zeros((2, 6))), ValueError, "^state 1: "),
])
def test_what_is_wrong_is_refused_by_its_name(call, error, words):
    with pytest.raises(error, match=words):
        call()
