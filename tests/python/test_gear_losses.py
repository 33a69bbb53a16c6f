"""Gears that lose a part of the force that they transmit."""

import pickle

import axode
import numpy as np
import pytest


def hoist(loss, **more):
    """A load of 2 kg on a vertical slide, whose gear has a rotor of 0.5 kg."""
    joint = {"name": "slide", "kind": "prismatic", "axis": "z", "point": [0, 0, 0], "armature": 0.5, "gear_loss": loss, **more}
    load = {"name": "load", "mass": 2, "com": [0, 0, 0], "inertia": [1, 1, 1], "joint": joint}
    return axode.Model.from_dict({"format": "axode drawing 1", "gravity": [0, 0, -10], "body": [load]})


def test_losses_are_kept():
    m = hoist(0.25, gear_loss_back=1.5)
    for again in (m, axode.Model.from_dict(m.to_dict()), pickle.loads(pickle.dumps(m))):
        joint = again.joint("slide")
        assert joint.gear_loss == [0.25] and joint.gear_loss_back == [1.5]
    assert hoist(0.25).joint("slide").gear_loss_back == [0.25]


def test_inverse_and_forward_dynamics():
    m = hoist(0.25, gear_loss_back=0.4)
    for v, loss in ((1, 0.25), (-1, -0.4), (0, 0)):
        tau = axode.inverse_dynamics(m, [0], [v], [3], joint_losses=True)
        np.testing.assert_allclose(tau, 0.5 * 3 + 2 * 13 * (1 + loss), rtol=1e-14)
        np.testing.assert_allclose(axode.forward_dynamics(m, [0], [v], tau, joint_losses=True), 3, rtol=1e-13)
    # many states at once
    tau = axode.inverse_dynamics(m, np.zeros((2, 1)), [[1], [-1]], np.full((2, 1), 3), joint_losses=True)
    np.testing.assert_allclose(tau[:, 0], 1.5 + 26 * np.array([1.25, 0.6]), rtol=1e-14)


def test_springs_act_behind_the_gear():
    m = hoist(0.25, spring={"stiffness": 10})
    forces = axode.spring_forces(m, [0.2], [1])
    tau = axode.inverse_dynamics(m, [0.2], [1], [3], joint_losses=True, forces=forces)
    np.testing.assert_allclose(tau, 1.5 + 1.25 * (26 + 2), rtol=1e-14)
    motion = axode.simulate(m, [0.2], [1], 0.1, tau=tau, joint_losses=True)
    np.testing.assert_allclose(motion.a[0], 3, rtol=1e-13)
    with pytest.raises(ValueError, match="would not pass through the gears"):
        axode.inverse_dynamics(m, [0.2], [1], [3], joint_losses=True)


def test_a_gear_locks_itself():
    motion = axode.simulate(hoist(1.1), [0.7], [0], 2, joint_losses=True)
    assert motion.complete and (motion.q == 0.7).all()
    falling = axode.simulate(hoist(0.5), [0.7], [0], 1, joint_losses=True)
    np.testing.assert_allclose(falling.q[-1], 0.7 - 0.5 * 20 / 3)
    with pytest.raises(axode.SimulationError, match='gear of joint "slide" locks itself so strongly'):
        axode.simulate(hoist(1.3), [0.7], [1], 1, joint_losses=True)
    with pytest.raises(axode.SingularError, match="locks itself so strongly"):
        axode.forward_dynamics(hoist(1.3), [0], [1], [0], joint_losses=True)


def test_what_is_refused():
    m = hoist(0.5)
    for call in (lambda: axode.inverse_dynamics_derivatives(m, [0], [1], [0], joint_losses=True),
                 lambda: axode.simulate(m, [0], [1], 1, coordinates="absolute", joint_losses=True),
                 lambda: axode.simulate(m, [0], [1], 1, method="midpoint", step=0.1, joint_losses=True)):
        with pytest.raises(ValueError, match='gear of joint "slide"'):
            call()
    with pytest.raises(ValueError, match="not linear in the parameters"):
        axode.identification.identify(m, *np.ones((4, 50, 1)), joint_losses=True)
