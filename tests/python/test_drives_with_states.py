"""Drives with states of a mechanism: told, copied, simulated and refused."""

import pickle

import axode
import numpy as np
import pytest

MOTOR = {"resistance": 1, "inductance": 0.01, "torque_constant": 0.1}


def wheel():
    """A wheel without gravity."""
    return axode.Builder("wheel", gravity=[0, 0, 0]).body(
        "wheel", joint={"kind": "revolute", "axis": "z", "point": [0, 0, 0], "name": "axle"}, mass=1, com=[0, 0, 0],
        inertia=[0.01, 0.01, 0.02])


def test_a_motor_runs_up_as_its_closed_form():
    m = wheel().drive("dc_motor", "axle", name="motor", **MOTOR, input=12).build()
    times = np.linspace(0, 2, 9)
    motion = axode.simulate(m, [0], [0], 2, times=times, rtol=1e-11, atol=1e-12)
    assert motion.drive_states == ["motor.current"]
    poles, modes = np.linalg.eig(np.array([[-100, -10], [5, 0]]))
    rest = np.array([0, 120])
    parts = np.linalg.solve(modes, -rest)
    exact = np.array([rest + modes @ (np.exp(poles * t) * parts) for t in times])
    assert np.allclose(motion.x[:, 0], exact[:, 0], rtol=0, atol=1e-8)
    assert np.allclose(motion.v[:, 0], exact[:, 1], rtol=0, atol=1e-7)
    assert np.allclose(motion.tau[:, 0], 0.1 * exact[:, 0], rtol=0, atol=1e-8)


def test_a_motor_runs_up_in_every_method():
    m = wheel().drive("dc_motor", "axle", name="motor", **MOTOR, input=12).build()
    exact = axode.simulate(m, [0], [0], 0.2, rtol=1e-11, atol=1e-12)
    for method, options in {"midpoint": {}, "suzuki4": {}, "kahan_li6": {}, "rk4_momenta": {}, "contact": {}, "contact_adaptive": {}, "contact_exact": {},
                            "rattle": {"coordinates": "absolute"}, "rattle_suzuki4": {"coordinates": "absolute"},
                            "half_explicit": {"coordinates": "absolute"}, "dopri5": {"coordinates": "absolute"},
                            "generalized_alpha": {"coordinates": "absolute"}}.items():
        steps = {} if method in ("dopri5", "contact_adaptive", "contact_exact") else {"step": 1e-3}
        motion = axode.simulate(m, [0], [0], 0.2, method=method, **steps, **options)
        assert motion.complete and motion.drive_states == ["motor.current"] and motion.x.shape == (len(motion.t), 1)
        assert np.allclose(motion.x[-1], exact.x[-1], rtol=0, atol=2e-2), method
        assert np.allclose(motion.v[-1], exact.v[-1], rtol=0, atol=5e-2), method


def test_a_motion_continues_from_the_states_of_its_drives():
    m = wheel().drive("dc_motor", "axle", name="motor", **MOTOR, input=12).build()
    whole = axode.simulate(m, [0], [0], 2, method="rk4", step=0.01)
    rest = axode.simulate(m, whole.q[100], whole.v[100], 1, method="rk4", step=0.01, x=whole.x[100])
    assert np.allclose(rest.x[-1], whole.x[-1], rtol=1e-10) and np.allclose(rest.v[-1], whole.v[-1], rtol=1e-10)
    for x, sentence in (([1, 2], r"x has 2 entries; expected nx = 1"), ([np.nan], r"x"), ([[1]], r"x: expected shape \(nx,\)")):
        with pytest.raises(ValueError, match=sentence):
            axode.simulate(m, [0], [0], 1, x=x)
    with pytest.raises(ValueError, match="x has 1 entries; expected nx = 0"):
        axode.simulate(axode.load(axode.robots / "arm7.toml"), np.zeros(7), np.zeros(7), 1, method="midpoint", step=0.1, x=[1])


def test_every_copy_has_the_drives():
    builder = wheel().drive("pid", "axle", name="controller", kp=2, limit=5, input={"kind": "ramp", "to": 1, "end": 1})
    m = builder.drive("dc_motor", "axle", **MOTOR, input="controller", initial={"current": 0.5}).build()
    for copy in [m, axode.read_drawing(axode.drawing(m)), axode.Model.from_dict(m.to_dict()), pickle.loads(pickle.dumps(m))]:
        assert copy.drive_names == ["controller", "drive 2"]
        motion = axode.simulate(copy, [0], [0], 0.1)
        assert motion.x.shape == (len(motion.t), 3) and motion.x[0].tolist() == [0, 0, 0.5]


def test_wrong_drives_are_refused_by_name():
    with pytest.raises(axode.ModelError, match='acts on joint "axel", which is not described; did you mean "axle"'):
        wheel().drive("dc_motor", "axel", **MOTOR, input=1).build()
    with pytest.raises(axode.ModelError, match="has no input"):
        wheel().drive("dc_motor", "axle", **MOTOR).build()
    m = wheel().drive("dc_motor", "axle", **MOTOR, input=1).build()
    with pytest.raises(ValueError, match="sensitivities does not count .*rollout_derivatives_with_drives counts them"):
        axode.rollout_derivatives(m, [0], [0], np.zeros((3, 1)), 0.1)
    with pytest.raises(ValueError, match=r"x: expected shape \(1,\), a number for each state of the drives"):
        axode.rollout(m, [0], [0], np.zeros((3, 1)), 0.1, x=[0, 0])


def limited():
    """A wheel with a motor that reaches its limits of current and voltage."""
    return wheel().drive("dc_motor", "axle", name="motor", **MOTOR, current_limit=3, voltage_limit=10,
                         input={"kind": "harmonic", "amplitude": 14, "frequency": 3}).build()


def test_rollouts_are_simulations():
    m = limited()
    q, v, x = np.linspace(-1, 1, 5)[:, None], np.linspace(0, 3, 5)[:, None], np.linspace(-1, 1, 5)[:, None]
    tau = axode.drives.PD(2.0, 0.1, [0.5])
    path = axode.rollout(m, q, v, tau, 2e-3, steps=250, x=x)
    assert path.x.shape == (5, 251, 1)
    for n in range(5):
        motion = axode.simulate(m, q[n], v[n], 0.5, method="rk4", step=2e-3, tau=tau, x=x[n],
                                times=np.minimum(2e-3 * np.arange(251), 0.5))
        assert len(np.unique(path.x[n] == 3)) == 2  # the current is limited at times
        for found, expected in ((path.q[n], motion.q), (path.v[n], motion.v), (path.x[n], motion.x)):
            np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    eight = axode.rollout(m, q, v, tau, 2e-3, steps=250, x=x, threads=8)
    np.testing.assert_array_equal(eight.x, path.x)
    np.testing.assert_array_equal(eight.q, path.q)

    def by_hand(t, q, v):
        return np.full_like(v, 0.1)
    one, other = axode.rollout(m, q, v, by_hand, 2e-3, steps=250, x=x), axode.rollout(m, q, v, [0.1], 2e-3, steps=250, x=x)
    np.testing.assert_allclose(one.x, other.x, rtol=0, atol=1e-6)
    np.testing.assert_allclose(one.q, other.q, rtol=0, atol=1e-6)
    assert axode.rollout(m, [0], [0], np.zeros((3, 1)), 1e-3).x.shape == (4, 1)
    copy = pickle.loads(pickle.dumps(one))
    np.testing.assert_array_equal(copy.x, one.x)
    arm = axode.load(axode.robots / "arm7.toml")
    assert axode.rollout(arm, np.zeros(7), np.zeros(7), np.zeros((3, 7)), 1e-3).x.shape == (4, 0)


def test_sensitivities_of_rollouts_are_limits_of_differences():
    m, h = limited(), 1e-5
    q, v, x, tau = np.array([0.1]), np.array([0.2]), np.array([0.3]), np.zeros((200, 1))
    steps = axode.rollout_derivatives_with_drives(m, q, v, tau, 2e-3, x)
    assert steps.states == ["motor.current"] and steps.inputs == ["motor"]
    at_end = np.linalg.multi_dot(steps.A[::-1])

    def end(dz):
        path = axode.rollout(m, q + dz[:1], v + dz[1:2], tau, 2e-3, x=x + dz[2:])
        return np.concatenate([path.q[-1], path.v[-1], path.x[-1]])
    for k, dz in enumerate(h * np.eye(3)):
        np.testing.assert_allclose((end(dz) - end(-dz)) / (2 * h), at_end[:, k], rtol=0, atol=1e-6)
    both = axode.rollout_derivatives_with_drives(m, [q, q], [v, v], [tau, tau], 2e-3, [x, x], threads=2)
    np.testing.assert_array_equal(both.A, [steps.A, steps.A])


def test_small_motions_without_the_drives_are_refused():
    m = wheel().drive("dc_motor", "axle", **MOTOR, input=1).build()
    for small_motions in (axode.linearize, axode.independent_linearization):
        with pytest.raises(ValueError, match="linear.* does not count drives with states"):
            small_motions(m, [0], [0], [0])
    with pytest.raises(ValueError, match="contact does not count drives with states"):
        axode.contact_rollout_derivatives(m, [0], [0], np.zeros((3, 1)), 0.01)


def test_small_motions_with_the_drives_are_those_of_simulations():
    m = axode.Builder("arm").body("arm", joint={"name": "axle", "kind": "revolute", "axis": "y", "point": [0, 0, 0]}, mass=1,
                                  com=[0.2, 0, 0], inertia=[0.01, 0.02, 0.02]).drive(
        "pid", "axle", name="controller", kp=30, ki=10, kd=2, filter_time=0.02, limit=50,
        input={"kind": "harmonic", "amplitude": 0.1, "frequency": 1}).drive(
        "dc_motor", "axle", name="motor", input="controller", **MOTOR).build()
    rest = axode.equilibrium_with_drives(m, [0.1])
    assert rest.found and rest.residual < 1e-9 and rest.states == ["controller.integral", "controller.filter", "motor.current"]
    small = axode.linearize_with_drives(m, rest.q, [0], rest.x)
    assert small.A.shape == (5, 5) and small.B.shape == (5, 1) and small.inputs == ["controller"]
    assert small.states == rest.states and np.linalg.eigvals(small.A).real.max() < 0
    assert small.A[1, 4] == pytest.approx(0.1 / 0.06)  # torque constant over inertia about the axle
    started = axode.linearize_with_drives(m, [0.1], [0])
    np.testing.assert_array_equal(started.A, axode.linearize_with_drives(m, [0.1], [0], [0, -0.1, 0]).A)


@pytest.mark.parametrize("call, words", [
    (lambda m: axode.linearize_with_drives(m, [0], [0], [0, 0]), r"x: expected shape \(1,\), a number for each state"),
    (lambda m: axode.linearize_with_drives(m, [0, 0], [0]), "q: expected shape"),
    (lambda m: axode.linearize_with_drives(m, [0], [0], t=np.nan), "^t"),
    (lambda m: axode.equilibrium_with_drives(m, [0], [np.inf]), "^x")])
def test_wrong_states_of_drives_are_refused(call, words):
    with pytest.raises(ValueError, match=words):
        call(wheel().drive("dc_motor", "axle", **MOTOR, input=1).build())
