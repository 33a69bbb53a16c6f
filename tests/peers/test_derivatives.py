"""Derivatives of dynamics and of the motion of frames against Pinocchio, on every robot with its base fixed and free."""

import numpy as np
import pinocchio as pin
import pytest
from axode_command import evaluate, robots
from pinocchio_robot import LOCAL, Robot
from states import as_json, assert_close, random_state

STATES = 2


class Case:
    """A robot in a random state under wrenches that are constant in the frames of links, as Pinocchio takes them."""

    def __init__(self, file, base, seed):
        self.file, self.base = file, base
        self.robot = Robot(file, base)
        self.values, loads = random_state(self.robot, np.random.default_rng(700 + seed))
        self.loads = [(link, "body", wrench) for link, _, wrench in loads]
        self.q = self.robot.coordinates(self.values["q"])
        self.v, self.a = (self.robot.velocities(self.values[key]) for key in ("v", "a"))

    def ask(self, want):
        answer = evaluate(self.file, as_json(self.values, self.loads), [want], self.base, "body")
        self.P = self.robot.velocity_map(answer["joints"])
        return answer["results"][want]

    def on_joints(self):
        forces = [pin.Force.Zero() for _ in range(self.robot.model.njoints)]
        for link, _, wrench in self.loads:
            frame = self.robot.model.frames[self.robot.links[link]]
            forces[frame.parentJoint] += frame.placement.act(pin.Force(np.array(wrench[3:]), np.array(wrench[:3])))
        return forces

    def symmetric(self, M):
        return np.triu(M) + np.triu(M, 1).T


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_inverse_dynamics(file, base):
    for seed in range(STATES):
        case = Case(file, base, seed)
        ours = case.ask("inverse_dynamics_derivatives")
        model, data, P = case.robot.model, case.robot.data, case.P
        by_q, by_v, by_a = pin.computeRNEADerivatives(model, data, case.q, case.v, case.a, case.on_joints())
        assert_close("dtau/dq", ours["dtau/dq"], P.T @ by_q @ P)
        assert_close("dtau/dv", ours["dtau/dv"], P.T @ by_v @ P)
        assert_close("dtau/da", ours["dtau/da"], P.T @ case.symmetric(by_a) @ P)
        gravity = pin.computeGeneralizedGravityDerivatives(model, data, case.q)
        assert_close("dg/dq", case.ask("gravity_derivatives"), P.T @ gravity @ P)


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_forward_dynamics(file, base):
    case = Case(file, base, 0)
    if case.robot.mimic:
        pytest.skip("Pinocchio's algorithm does not couple these joints")
    case.loads = []
    M = np.array(case.ask("mass_matrix"))
    if np.any(np.diag(M) <= 0) or np.linalg.cond(M) > 1e10:
        pytest.skip("the mass matrix is singular, or nearly so")
    ours = case.ask("forward_dynamics_derivatives")
    model, data, P = case.robot.model, case.robot.data, case.P
    tau = np.linalg.inv(P).T @ np.concatenate([case.values["tau"][name] for name in order_of(case)])
    pin.computeABADerivatives(model, data, case.q, case.v, tau)
    back = np.linalg.inv(P)
    scale = np.max(np.abs(np.linalg.inv(M)))
    for name, theirs in (("da/dq", data.ddq_dq), ("da/dv", data.ddq_dv)):
        # What is left of the equation M da = -dtau in the units of forces, where M may be ill-conditioned.
        assert_close(name, M @ np.array(ours[name]), M @ back @ theirs @ P, np.max(np.abs(M)) * np.max(np.abs(ours[name])))
    inverse = case.symmetric(np.array(data.Minv))
    assert_close("da/dtau", ours["da/dtau"], back @ inverse @ back.T, scale)


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_motion_of_a_frame(file, base):
    for seed in range(STATES):
        case = Case(file, base, seed)
        link = list(case.robot.links)[-1]
        ours = case.ask("motion_derivatives")[link]
        model, data, P = case.robot.model, case.robot.data, case.P
        pin.computeForwardKinematicsDerivatives(model, data, case.q, case.v, case.a)
        pin.updateFramePlacements(model, data)
        V_q, dV_q, dV_v, V_v = pin.getFrameAccelerationDerivatives(model, data, case.robot.links[link], LOCAL)
        for name, theirs in (("dV/dq", V_q), ("dV/dv", V_v), ("dV'/dq", dV_q), ("dV'/dv", dV_v)):
            assert_close(name, ours[name], np.roll(theirs, 3, axis=0) @ P, 1.0)


def order_of(case):
    return evaluate(case.file, as_json(case.values, []), ["mass_matrix"], case.base, "body")["joints"]
