"""Mass matrix and bias forces against MuJoCo, on every robot that it loads, with its base fixed and free."""

import numpy as np
import pinocchio_robot
import pytest
from axode_command import FREE_BASE, evaluate, robots
from mujoco_robot import CannotLoad, Robot
from states import as_json, random_state

BOUND = 1e-9  # of the largest entry
STATES = 2


def assert_close(quantity, ours, theirs):
    size = np.max(np.abs(theirs))
    error = np.max(np.abs(np.array(ours) - theirs))
    assert error <= BOUND * size, f"{quantity} differs by {error} in {size}"


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_agrees(file, base):
    try:
        robot = Robot(file, base)
    except CannotLoad as reason:
        pytest.skip(f"MuJoCo does not load {file.name}: {reason}")
    names = pinocchio_robot.Robot(file, base)
    for seed in range(STATES):
        values, _ = random_state(names, np.random.default_rng(400 + seed))
        want = ["mass_matrix", "coriolis_vector", "gravity_torques"]
        answer = evaluate(file, as_json(values, []), want, base, "body")
        ours = answer["results"]
        robot.set(values)
        P = robot.velocity_map(answer["joints"])
        assert_close("mass matrix", ours["mass_matrix"], P.T @ robot.mass_matrix() @ P)
        # Our velocities of a free base are those of a body frame: where it turns, P turns, and a' = P a + P' v.
        dP_v = np.zeros(robot.model.nv)
        if FREE_BASE in values["v"]:
            w, v = np.array(values["v"][FREE_BASE][:3]), np.array(values["v"][FREE_BASE][3:])
            at = robot.joints[FREE_BASE].dofadr[0]
            dP_v[at:at + 3] = robot.R @ np.cross(w, v)
        bias = P.T @ (robot.data.qfrc_bias + robot.mass_matrix() @ dP_v)
        assert_close("bias", np.array(ours["coriolis_vector"]) + np.array(ours["gravity_torques"]), bias)
