"""Agreement with Pinocchio on every robot, with its base fixed and free, in every representation."""

import numpy as np
import pinocchio as pin
import pytest
from axode_command import REPRESENTATIONS, by_joint, evaluate, robots
from pinocchio_robot import Robot
from states import arrays, assert_equal, as_json, random_state

STATES = 3
WANT = ["inverse_dynamics", "poses", "twists", "accelerations", "joint_wrenches", "center_of_mass"]


@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_agrees(file, base, representation):
    robot = Robot(file, base)
    links = robot.links
    assert robot.model.nv > 0
    for seed in range(STATES):
        values, loads = random_state(robot, np.random.default_rng(seed))
        answer = evaluate(file, as_json(values, loads), WANT, base, representation)
        ours = answer["results"]

        q, v, a = robot.coordinates(values["q"]), robot.velocities(values["v"]), robot.velocities(values["a"])
        forces = robot.forces(robot.inverse_dynamics(q, v, a, loads))
        assert_equal("inverse dynamics", arrays(by_joint(answer, ours["inverse_dynamics"])), forces)
        if representation == "body":
            assert_equal("joint wrenches", arrays(ours["joint_wrenches"]),
                         {name: robot.joint_wrench(name) for name in robot.joints})

        robot.update(q, v, a)
        assert_equal("poses", arrays(ours["poses"], links),
                     {name: robot.pose(name).homogeneous for name in links})
        assert_equal("twists", arrays(ours["twists"], links),
                     {name: robot.twist(name, representation) for name in links})
        assert_equal("accelerations", arrays(ours["accelerations"], links),
                     {name: robot.acceleration(name, representation) for name in links})
        assert_equal("centre of mass", {"robot": np.array(ours["center_of_mass"])},
                     {"robot": pin.centerOfMass(robot.model, robot.data, q)})
