"""Agreement with Pinocchio on every robot, with its base fixed and free, in every representation."""

import numpy as np
import pinocchio as pin
import pytest
from axode_command import FREE_BASE, REPRESENTATIONS, by_joint, evaluate, robots
from pinocchio_robot import Robot

BOUND = 1e-10  # of the largest entry
STATES = 3
WANT = ["inverse_dynamics", "poses", "twists", "accelerations", "joint_wrenches", "center_of_mass"]


def assert_equal(quantity, ours, theirs):
    """Both map names to numbers: the same names, and the same numbers to a part of the largest one."""
    assert ours.keys() == theirs.keys(), quantity
    scale = max(np.max(np.abs(x), initial=0) for x in theirs.values())
    worst = max(ours, key=lambda name: np.max(np.abs(ours[name] - theirs[name]), initial=0))
    error = np.max(np.abs(ours[worst] - theirs[worst]))
    assert error <= BOUND * scale, f"{quantity} of {worst} differs by {error} in {scale}"


def random_state(robot, random):
    """Numbers by joint, and a few loads on links."""
    values = {key: {name: random.uniform(-1, 1, 6 if name == FREE_BASE else 1).tolist()
                    for name in robot.independent_joints()} for key in ("q", "v", "a")}
    for name in robot.independent_joints():
        if name == FREE_BASE:
            quaternion = random.normal(size=4)
            position = random.uniform(-1, 1, 3)
            values["q"][name] = [*(quaternion / np.linalg.norm(quaternion)).tolist(), *position.tolist()]
        else:
            values["q"][name] = [np.pi * values["q"][name][0]]
    loads = [(str(random.choice(list(robot.links))), str(random.choice(REPRESENTATIONS)),
              random.uniform(-20, 20, 6).tolist()) for _ in range(4)]
    return values, loads


def arrays(by_name, names=None):
    return {name: np.array(by_name[name]) for name in names or by_name}


@pytest.mark.parametrize("representation", REPRESENTATIONS)
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_agrees(file, base, representation):
    robot = Robot(file, base)
    links = robot.links
    assert robot.model.nv > 0
    for seed in range(STATES):
        values, loads = random_state(robot, np.random.default_rng(seed))
        keys = ("frame", "representation", "wrench")
        state = {**values, "loads": [dict(zip(keys, load)) for load in loads]}
        answer = evaluate(file, state, WANT, base, representation)
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
