"""Jacobians and their time variation against Pinocchio, on every robot with its base fixed and free."""

import numpy as np
import pinocchio as pin
import pytest
from axode_command import REPRESENTATIONS, evaluate, robots
from pinocchio_robot import Robot
from states import arrays, as_json, assert_equal, random_state

STATES = 2


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_agrees(file, base):
    robot = Robot(file, base)
    model, data = robot.model, robot.data
    for seed in range(STATES):
        values, loads = random_state(robot, np.random.default_rng(100 + seed))
        q, v = robot.coordinates(values["q"]), robot.velocities(values["v"])
        pin.computeJointJacobiansTimeVariation(model, data, q, v)
        pin.updateFramePlacements(model, data)
        for representation in REPRESENTATIONS:
            answer = evaluate(file, as_json(values, []), ["jacobian", "jacobian_rate"], base, representation)
            P = robot.velocity_map(answer["joints"])
            ours = answer["results"]
            assert_equal(f"Jacobian, {representation},", arrays(ours["jacobian"], robot.links),
                         {name: robot.jacobian(name, representation) @ P for name in robot.links})
            assert_equal(f"rate of the Jacobian, {representation},", arrays(ours["jacobian_rate"], robot.links),
                         {name: robot.jacobian_rate(name, representation) @ P for name in robot.links})


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_agrees_about_the_centre_of_mass(file, base):
    robot = Robot(file, base)
    model, data = robot.model, robot.data
    want = ["center_of_mass_jacobian", "centroidal_momentum_matrix", "centroidal_momentum_matrix_rate"]
    for seed in range(STATES):
        values, loads = random_state(robot, np.random.default_rng(200 + seed))
        q, v = robot.coordinates(values["q"]), robot.velocities(values["v"])
        answer = evaluate(file, as_json(values, []), want, base, "body")
        P, ours = robot.velocity_map(answer["joints"]), answer["results"]
        def A(s):
            return np.roll(pin.computeCentroidalMap(model, data, pin.integrate(model, q, s * v)), 3, axis=0) @ P

        def compare(quantity, theirs, times, bound=1e-10):
            assert_equal(quantity, {"robot": np.array(ours[quantity]) @ times}, {"robot": theirs}, bound)
        compare("center_of_mass_jacobian", pin.jacobianCenterOfMass(model, data, q) @ P, times=np.eye(P.shape[1]))
        compare("centroidal_momentum_matrix", A(0), times=np.eye(P.shape[1]))
        # Pinocchio's rate is not the derivative of its own matrix, though its product with v is that of the momentum.
        h = 1e-6
        compare("centroidal_momentum_matrix_rate", (A(h) - A(-h)) / (2 * h), bound=1e-7, times=np.eye(P.shape[1]))
        dA = np.roll(pin.computeCentroidalMapTimeVariation(model, data, q, v), 3, axis=0)
        ours_v = np.linalg.lstsq(P, v, rcond=None)[0]
        compare("centroidal_momentum_matrix_rate", dA @ v, times=ours_v)
