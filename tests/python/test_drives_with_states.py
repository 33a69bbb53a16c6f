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
    for method, options in {"midpoint": {}, "suzuki4": {}, "kahan_li6": {}, "rk4_momenta": {}, "contact": {}, "contact_adaptive": {},
                            "rattle": {"coordinates": "absolute"}, "rattle_suzuki4": {"coordinates": "absolute"},
                            "half_explicit": {"coordinates": "absolute"}, "dopri5": {"coordinates": "absolute"},
                            "generalized_alpha": {"coordinates": "absolute"}}.items():
        steps = {} if method in ("dopri5", "contact_adaptive") else {"step": 1e-3}
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
    with pytest.raises(ValueError, match="rollout does not count drives with states"):
        axode.rollout(m, [0], [0], np.zeros((3, 1)), 0.1)


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
