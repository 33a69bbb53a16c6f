"""Ctrl-C interrupts every call on many states or items before it has ended."""

import functools
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import axode
import numpy as np
import pytest
from mechanisms import MECHANISMS, random_states

ARM, MACHINE = MECHANISMS["arm"], MECHANISMS["machine"]
GOUGH = axode.load(axode.robots / "gough.toml")
PLATFORM = axode.TaskSpace(GOUGH, GOUGH.neutral())
POSES = axode.poses(ARM, ARM.random())
FAR_AWAY = axode.lie.exp(np.array([0, 0, 0, 9.0, 0, 0]))
FALL = axode.simulate(ARM, np.full(7, 0.1), np.zeros(7), 0.5)


def of_states(m, f):
    """f(q, v, a) of N states of m, as a function that makes the arguments of N and one that takes them."""
    state = random_states(m, 16)[:3]
    return lambda N: [np.resize(x, (N, x.shape[1])) for x in state], lambda q, v, a: f(q, v, a)


def of_items(f, *items):
    return lambda N: [np.repeat(item[None], N, axis=0) for item in items], f


@functools.cache
def specialised():
    """Derivatives of forward dynamics in code that is slow enough for few states."""
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler cc")
    return ARM.specialise(["forward_dynamics_derivatives"], lanes=1, flags=["-O0"]).forward_dynamics_derivatives


LONG = {
    "inverse dynamics": of_states(ARM, lambda q, v, a: axode.inverse_dynamics(ARM, q, v, a)),
    "inverse dynamics on two threads": of_states(ARM, lambda q, v, a: axode.inverse_dynamics(ARM, q, v, a, threads=2)),
    "inverse dynamics, body": of_states(ARM, lambda q, v, a: axode.inverse_dynamics(ARM, q, v, a, "body")),
    "forward dynamics": of_states(ARM, lambda q, v, a: axode.forward_dynamics(ARM, q, v, a)),
    "forward dynamics, coupled": of_states(MACHINE, lambda q, v, a: axode.forward_dynamics(MACHINE, q, v, a)),
    "forward dynamics, body, two threads": of_states(
        ARM, lambda q, v, a: axode.forward_dynamics(ARM, q, v, a, "body", threads=2)),
    "forward dynamics with losses": of_states(ARM, lambda q, v, a: axode.forward_dynamics(ARM, q, v, a,
                                                                                          joint_losses=True)),
    "mass matrix": of_states(ARM, lambda q, v, a: axode.mass_matrix(ARM, q)),
    "mass matrix, coupled": of_states(MACHINE, lambda q, v, a: axode.mass_matrix(MACHINE, q)),
    "its inverse": of_states(ARM, lambda q, v, a: axode.inverse_mass_matrix(ARM, q)),
    "its partials": of_states(ARM, lambda q, v, a: axode.mass_matrix_partials(ARM, q)),
    "poses": of_states(ARM, lambda q, v, a: axode.poses(ARM, q)),
    "jacobian": of_states(ARM, lambda q, v, a: axode.jacobian(ARM, q, "flange")),
    "partials of the jacobian": of_states(ARM, lambda q, v, a: axode.jacobian_partials(ARM, q, "flange", order=2)),
    "higher derivatives": of_states(ARM, lambda q, v, a: axode.twist_derivatives(
        ARM, q, np.stack([v, a, v, a], axis=1), "flange")),
    "specialised derivatives": of_states(ARM, lambda q, v, a: specialised()(q, v, a).q),
    "specialised derivatives on two threads": of_states(ARM, lambda q, v, a: specialised()(q, v, a, threads=2).q),
    "energy": of_states(ARM, lambda q, v, a: axode.kinetic_energy(ARM, q, v)),
    "integrate": of_states(MACHINE, lambda q, v, a: MACHINE.integrate(q, v)),
    "difference": of_states(MACHINE, lambda q, v, a: MACHINE.difference(q, q)),
    "interpolate": of_states(MACHINE, lambda q, v, a: MACHINE.interpolate(q, q, 0.5)),
    "clamp": of_states(MACHINE, lambda q, v, a: MACHINE.clamp(q)),
    "exp": of_items(axode.lie.exp, np.ones(6)),
    "log": of_items(axode.lie.log, POSES[-1]),
    "ddexp": of_items(axode.lie.ddexp, np.ones(6), np.ones(6)),
    "Ad": of_items(axode.lie.Ad, POSES[-1]),
    "solutions by a factor": of_items(axode.MassMatrixFactor(ARM, axode.mass_matrix(ARM, ARM.neutral())).solve,
                                      np.ones(7)),
    "rollouts": of_states(ARM, lambda q, v, a: axode.rollout(ARM, q, v, a[:, None], 1e-4)[0]),
    "one rollout": of_items(lambda tau: axode.rollout(ARM, np.zeros(7), np.zeros(7), tau, 1e-9)[0][1:],
                            np.zeros(7)),
    "rollouts and back": of_states(ARM, lambda q, v, a: axode.rollout_vjp(
        ARM, q, v, a[:, None], 1e-4, *np.zeros((2, len(q), 2, 7))).q),
    "one rollout and back": of_items(lambda tau: axode.rollout_vjp(
        ARM, np.zeros(7), np.zeros(7), tau, 1e-9, *np.zeros((2, len(tau) + 1, 7))).tau, np.zeros(7)),
    "a direction along one rollout": of_items(lambda tau: axode.rollout_jvp(
        ARM, np.zeros(7), np.zeros(7), tau, 1e-9, np.ones(7), np.zeros(7), tau)[0][1:], np.zeros(7)),
    "steps of one rollout": of_items(lambda tau: axode.rollout_derivatives(
        ARM, np.zeros(7), np.zeros(7), tau, 1e-9).B, np.zeros(7)),
    "inverse kinematics from many starts": (lambda N: [N], lambda restarts: np.zeros(axode.inverse_kinematics(
        ARM, [{"frame": "flange", "pose": FAR_AWAY}], np.zeros(7), iterations=5, restarts=restarts).restarts)),
    "rollouts with contact": of_states(ARM, lambda q, v, a: axode.rollout(ARM, q, v, a[:, None], 1e-4, contact=True)[0]),
    "task space": of_items(lambda q, dV: PLATFORM.inverse_dynamics(q, np.zeros((len(q), 24)), dV), GOUGH.neutral(), np.ones(6)),
    "states in between": (lambda N: [np.linspace(0, 0.5, N)], lambda t: FALL.at(t)[0]),
}


def processor_time():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def interrupt(call, whole):
    """Calls what takes `whole` seconds of processor time, and interrupts it at the eighth of the moments at which it
    answers one of forty signals. A call that answers at its begin and at its end alone has no such moment."""
    answered = 0

    def handler(*_):
        nonlocal answered
        answered += 1
        if answered == 8:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGPROF, handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_PROF, whole / 40, whole / 40)
            call()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@pytest.mark.parametrize("call", LONG)
def test_ctrl_c_is_answered_long_before_the_call_would_have_ended(call):
    make, f = LONG[call]
    whole, N, took = 0.4, 500, 0  # seconds of processor time
    while took < whole / 10:
        N *= 2
        arguments = make(N)
        start = processor_time()
        f(*arguments)
        took = processor_time() - start
    arguments = make(int(N * whole / took))
    interrupt(lambda: f(*arguments), whole)
    few = make(10)
    assert np.shape(f(*few))[0] == 10  # and the next call is as if nothing had been


@pytest.mark.parametrize("call", [
    lambda: axode.jacobian_partials(ARM, ARM.random(seed=1), "flange", "hybrid", order=7),
    lambda: axode.jacobian_derivative_along(ARM, ARM.random(seed=1), "flange", np.repeat([np.ones(7), -np.ones(7)], 60, axis=0))])
def test_ctrl_c_is_answered_in_the_midst_of_one_state(call):
    start = processor_time()
    call()
    interrupt(call, processor_time() - start)


def test_ctrl_c_from_another_process_ends_a_program():
    program = """
import axode, numpy as np
m = axode.load(axode.robots / "humanoid.urdf", base="free")
q = np.repeat(m.neutral()[None], 3000, axis=0)
v = np.zeros((3000, m.nv))
print("started", flush=True)
while True:
    axode.inverse_mass_matrix_partials(m, q)
"""
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                             # A shell may ignore SIGINT.
                             preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    assert child.stdout.readline() == "started\n"
    time.sleep(0.3)
    os.kill(child.pid, signal.SIGINT)
    try:
        error = child.communicate(timeout=120)[1]
    finally:
        child.kill()
    assert child.returncode == -signal.SIGINT
    assert error.rstrip().endswith("KeyboardInterrupt")


def test_ctrl_c_while_an_argument_is_read_is_no_other_error():
    class Slow:
        def __array__(self, *args, **kwargs):
            raise KeyboardInterrupt

    class Wrong:
        def __array__(self, *args, **kwargs):
            raise OSError("no file")

    for f in (lambda x: axode.mass_matrix(ARM, x), axode.lie.exp, ARM.clamp,
              lambda x: axode.inverse_dynamics(ARM, np.zeros(7), np.zeros(7), x),
              lambda x: axode.MassMatrixFactor(ARM, x)):
        with pytest.raises(KeyboardInterrupt):
            f(Slow())
        with pytest.raises(ValueError, match="expected numbers") as raised:
            f(Wrong())
        assert isinstance(raised.value.__cause__, OSError)
