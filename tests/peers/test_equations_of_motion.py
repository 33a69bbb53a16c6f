"""The equations of motion against Pinocchio, on every robot with its base fixed and free."""

import numpy as np
import pinocchio as pin
import pytest
from axode_command import REPRESENTATIONS, evaluate, refusal, robots
from pinocchio_robot import Robot
from states import as_json, assert_close, random_state

STATES = 2
WITHOUT_INVERSE = ["mass_matrix", "coriolis_matrix", "coriolis_vector", "gravity_torques", "regressor",
                   "body_momenta", "kinetic_energy", "potential_energy", "centroidal_momentum", "centroidal_inertia",
                   "momenta"]
# theta xx xy yy xz yz zz of Pinocchio in our order xx yy zz xy xz yz, after m, m c
PARAMETERS = [0, 1, 2, 3, 4, 6, 9, 5, 7, 8]


class Case:
    """A robot in a random state, evaluated by both."""

    def __init__(self, file, base, seed):
        self.file, self.base = file, base
        self.robot = Robot(file, base)
        self.values, self.loads = random_state(self.robot, np.random.default_rng(300 + seed))
        self.q = self.robot.coordinates(self.values["q"])
        self.v, self.a = (self.robot.velocities(self.values[key]) for key in ("v", "a"))

    def ask(self, want, representation="body", **more):
        state = {**as_json(self.values, self.loads), **more}
        answer = evaluate(self.file, state, want, self.base, representation)
        self.P = self.robot.velocity_map(answer["joints"])
        return answer["results"]

    def reason_to_refuse(self, want):
        return refusal(self.file, as_json(self.values, self.loads), want, self.base)


def moved_in_order(case, bodies):
    """The joints of Pinocchio that move our bodies, in our order."""
    model = case.robot.model
    return [model.frames[case.robot.links[body]].parentJoint for body in bodies]


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_terms(file, base):
    for seed in range(STATES):
        case = Case(file, base, seed)
        ours = case.ask(WITHOUT_INVERSE)
        model, data, q, v, a, P = case.robot.model, case.robot.data, case.q, case.v, case.a, case.P
        ours_v = np.linalg.lstsq(P, v, rcond=None)[0]

        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        assert_close("mass matrix", ours["mass_matrix"], P.T @ M @ P)
        assert_close("generalised momenta", ours["momenta"], P.T @ M @ v)

        C = P.T @ pin.computeCoriolisMatrix(model, data, q, v) @ P
        size = np.max(np.abs(C))
        assert_close("Coriolis matrix", ours["coriolis_matrix"], C, size)
        assert_close("Coriolis vector", ours["coriolis_vector"], C @ ours_v, size)
        h = 1e-6

        def M_at(s):
            X = pin.crba(model, data, pin.integrate(model, q, s * v)).copy()
            return P.T @ (np.triu(X) + np.triu(X, 1).T) @ P
        rate = (M_at(h) - M_at(-h)) / (2 * h)
        skew = rate - 2 * np.array(ours["coriolis_matrix"])
        assert np.max(np.abs(skew + skew.T)) <= 1e-6 * max(np.max(np.abs(M_at(0))), size)

        assert_close("gravity", ours["gravity_torques"], P.T @ pin.computeGeneralizedGravity(model, data, q))
        assert_close("kinetic energy", ours["kinetic_energy"], pin.computeKineticEnergy(model, data, q, v))
        assert_close("potential energy", ours["potential_energy"], pin.computePotentialEnergy(model, data, q))
        h_c = pin.computeCentroidalMomentum(model, data, q, v)
        assert_close("centroidal momentum", ours["centroidal_momentum"], np.roll(h_c.vector, 3))
        pin.ccrba(model, data, q, v)
        I_c = np.array(data.Ig.inertia)
        assert_close("centroidal inertia", ours["centroidal_inertia"]["inertia"],
                     [I_c[0, 0], I_c[1, 1], I_c[2, 2], I_c[0, 1], I_c[0, 2], I_c[1, 2]])

        Y = P.T @ pin.computeJointTorqueRegressor(model, data, q, v, a)
        columns = [10 * (joint - 1) + k for joint in moved_in_order(case, ours["body_momenta"]) for k in PARAMETERS]
        assert_close("regressor", ours["regressor"], Y[:, columns])


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_forward_dynamics(file, base):
    for seed in range(STATES):
        case = Case(file, base, seed)
        M = np.array(case.ask(["mass_matrix"])["mass_matrix"])
        definite = np.min(np.linalg.eigvalsh(M / np.sqrt(np.outer(np.diag(M), np.diag(M))))) if np.all(
            np.diag(M) > 0) else 0
        if definite <= 1e-12:
            assert "the mass matrix is singular" in case.reason_to_refuse("forward_dynamics")
            assert "the mass matrix is singular" in case.reason_to_refuse("inverse_mass_matrix")
            continue
        for representation in REPRESENTATIONS:
            ours = case.ask(["forward_dynamics", "inverse_mass_matrix"], representation)
            a = np.array(ours["forward_dynamics"])
            robot, P = case.robot, case.P
            ours_tau = tau_in_order(case)
            # What their inverse dynamics asks for our accelerations is the force that was given.
            theirs = P.T @ robot.inverse_dynamics(case.q, case.v, P @ a, case.loads)
            assert_close("tau", theirs, ours_tau, np.max(np.abs(M)) * np.max(np.abs(a)))
            if not robot.mimic and representation == "body":
                inverse = pin.computeMinverse(robot.model, robot.data, case.q)
                inverse = np.triu(inverse) + np.triu(inverse, 1).T
                P_inverse = np.linalg.inv(P)
                assert_close("inverse mass matrix", ours["inverse_mass_matrix"], P_inverse @ inverse @ P_inverse.T)


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_articulated_body_algorithm(file, base):
    case = Case(file, base, 0)
    if case.robot.mimic:
        pytest.skip("Pinocchio's algorithm does not couple these joints")
    case.loads = []
    a = np.array(case.ask(["forward_dynamics"])["forward_dynamics"])
    tau = np.linalg.inv(case.P).T @ tau_in_order(case)
    theirs = pin.aba(case.robot.model, case.robot.data, case.q, case.v, tau)
    assert_close("accelerations", case.P @ a, theirs)


def tau_in_order(case):
    """The drive forces in the order of our velocities."""
    joints = evaluate(case.file, as_json(case.values, []), ["poses"], case.base, "body")["joints"]
    return np.concatenate([case.values["tau"][name] for name in joints])
