"""The Python package computes the same as Pinocchio and MuJoCo, for every robot with a fixed and with a free base."""

from functools import lru_cache

import axode
import numpy as np
import pytest
from mechanisms import REPRESENTATIONS, close

pin = pytest.importorskip("pinocchio")
mujoco = pytest.importorskip("mujoco")

import mujoco_robot  # noqa: E402
import pinocchio_robot  # noqa: E402
from coordinates import FREE_BASE  # noqa: E402

STATES = 3
FAST = ["fast", *REPRESENTATIONS]


def assert_close(ours, theirs, of=0.0, bound=1e-10):
    """Expects that two arrays are equal, up to a part of the largest entry or of `of`."""
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    assert ours.shape == theirs.shape
    error, size = np.max(np.abs(ours - theirs), initial=0), max(np.max(np.abs(theirs), initial=0), of)
    assert error <= bound * size, f"differs by {error} in {size}"


def random_state(robot, random):
    """Random numbers for each joint, and a few loads on links."""
    values = {key: {name: random.uniform(-1, 1, 6 if name == FREE_BASE else 1).tolist()
                    for name in robot.independent_joints()} for key in ("q", "v", "a", "tau")}
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


class Case:
    """A robot in axode and in Pinocchio's adapter, in random states: numbers by joint, and the same as arrays."""

    def __init__(self, file, base):
        self.m, self.robot = axode.load(file, base), pinocchio_robot.Robot(file, base)
        self.independent = [name for name in self.m.joint_names if not self.m.joint(name).leader]
        self.links = [self.m.frame_names.index(name) for name in self.robot.links]
        random = np.random.default_rng(700)
        self.values, self.loads = zip(*(random_state(self.robot, random) for _ in range(STATES)))
        self.q, self.v, self.a, self.tau = (
            np.array([np.concatenate([values[key][name] for name in self.independent]) for values in self.values])
            for key in ("q", "v", "a", "tau"))
        self.P = self.robot.velocity_map(self.independent)  # theirs = P ours, of velocities and accelerations
        self.theirs = [(self.robot.coordinates(values["q"]), self.robot.velocities(values["v"]),
                        self.robot.velocities(values["a"])) for values in self.values]

    def loads_of(self, k):
        return [axode.Load(frame=frame, representation=rep, wrench=W) for frame, rep, W in self.loads[k]]

    @property
    def all_loads(self):
        """An array of wrenches (N, 6) for each load; a load acts in its own states only, and is zero in all others."""
        return [axode.Load(frame=frame, representation=rep, wrench=np.outer(np.arange(STATES) == k, W))
                for k in range(STATES) for frame, rep, W in self.loads[k]]

    def singular(self):
        """Whether a mass matrix is nearly singular after its diagonal was scaled to 1."""
        M = axode.mass_matrix(self.m, self.q)
        d = np.sqrt(np.einsum("kii->ki", M))
        return np.any(d <= 0) or np.min(np.linalg.eigvalsh(M / (d[:, :, None] * d[:, None]))) <= 1e-12


@lru_cache(maxsize=2)
def pinocchio_case(robot, base):
    return Case(robot, base)


@pytest.fixture
def case(robot, base):
    return pinocchio_case(robot, base)


# ---------------------------------------------------------------- Pinocchio

@pytest.mark.parametrize("representation", FAST)
def test_inverse_dynamics(case, representation):
    free = axode.inverse_dynamics(case.m, case.q, case.v, case.a, representation)
    loaded = axode.inverse_dynamics(case.m, case.q, case.v, case.a, representation, case.all_loads)
    for k, state in enumerate(case.theirs):
        assert_close(free[k], case.P.T @ case.robot.inverse_dynamics(*state, []))
        assert_close(loaded[k], case.P.T @ case.robot.inverse_dynamics(*state, case.loads[k]))


@pytest.mark.parametrize("representation", FAST)
def test_forward_dynamics(case, representation):
    m, P = case.m, case.P
    if case.singular():
        with pytest.raises(axode.SingularError):
            axode.forward_dynamics(m, case.q, case.v, case.tau, representation)
        return
    M = np.abs(axode.mass_matrix(m, case.q)).max()
    free = axode.forward_dynamics(m, case.q, case.v, case.tau, representation)
    loaded = axode.forward_dynamics(m, case.q, case.v, case.tau, representation, case.all_loads)
    for k, (q, v, _) in enumerate(case.theirs):
        # Pinocchio's inverse dynamics of our accelerations gives the forces back.
        for a, loads in (free[k], []), (loaded[k], case.loads[k]):
            tau = P.T @ case.robot.inverse_dynamics(q, v, P @ a, loads)
            assert_close(tau, case.tau[k], of=M * np.abs(a).max())
        if not case.robot.mimic:  # which their algorithm does not couple
            theirs = pin.aba(case.robot.model, case.robot.data, q, v, np.linalg.inv(P).T @ case.tau[k])
            assert_close(P @ free[k], theirs, bound=1e-9)


@pytest.mark.parametrize("representation", FAST)
def test_mass_matrix_and_its_inverse(case, representation):
    m, P, model, data = case.m, case.P, case.robot.model, case.robot.data
    M = axode.mass_matrix(m, case.q, representation)
    if case.singular():
        with pytest.raises(axode.SingularError):
            axode.inverse_mass_matrix(m, case.q, representation)
    else:
        inverse = axode.inverse_mass_matrix(m, case.q, representation)
    for k, (q, _, _) in enumerate(case.theirs):
        crba = symmetric(pin.crba(model, data, q))
        assert_close(M[k], P.T @ crba @ P)
        if not case.singular() and not case.robot.mimic:
            back = np.linalg.inv(P)
            assert_close(inverse[k], back @ symmetric(pin.computeMinverse(model, data, q)) @ back.T, bound=1e-9)


def symmetric(upper):
    return np.triu(upper) + np.triu(upper, 1).T


def test_terms_of_the_equations_of_motion(case):
    m, P, model, data = case.m, case.P, case.robot.model, case.robot.data
    C, Cv = axode.coriolis_matrix(m, case.q, case.v, "christoffel"), axode.coriolis_vector(m, case.q, case.v)
    g, p = axode.gravity_torques(m, case.q), axode.momenta(m, case.q, case.v)
    T, U = axode.kinetic_energy(m, case.q, case.v), axode.potential_energy(m, case.q)
    for k, (q, v, _) in enumerate(case.theirs):
        theirs = P.T @ pin.computeCoriolisMatrix(model, data, q, v) @ P
        assert_close(C[k], theirs)
        assert_close(Cv[k], theirs @ case.v[k], of=np.abs(theirs).max())
        assert_close(g[k], P.T @ pin.computeGeneralizedGravity(model, data, q))
        assert_close(p[k], P.T @ symmetric(pin.crba(model, data, q)) @ v)
        assert_close(T[k], pin.computeKineticEnergy(model, data, q, v))
        assert_close(U[k], pin.computePotentialEnergy(model, data, q))


def test_poses(case):
    ours = axode.poses(case.m, case.q)
    for k, state in enumerate(case.theirs):
        case.robot.update(*state)
        assert_close(ours[k, case.links], [case.robot.pose(name).homogeneous for name in case.robot.links])


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_twists_and_accelerations(case, representation):
    """Hybrid accelerations are the classical ones."""
    V = axode.twists(case.m, case.q, case.v, representation)
    dV = axode.accelerations(case.m, case.q, case.v, case.a, representation)
    for k, state in enumerate(case.theirs):
        case.robot.update(*state)
        assert_close(V[k, case.links], [case.robot.twist(name, representation) for name in case.robot.links])
        assert_close(dV[k, case.links], [case.robot.acceleration(name, representation) for name in case.robot.links])


@pytest.mark.parametrize("representation", REPRESENTATIONS)
def test_jacobians_and_their_rates(case, representation):
    robot = case.robot
    ours = np.array([[axode.jacobian(case.m, case.q, name, representation),
                      axode.jacobian_rate(case.m, case.q, case.v, name, representation)] for name in robot.links])
    for k, (q, v, _) in enumerate(case.theirs):
        pin.computeJointJacobiansTimeVariation(robot.model, robot.data, q, v)
        pin.updateFramePlacements(robot.model, robot.data)
        J, dJ = ours[:, 0, k], ours[:, 1, k]
        assert_close(J, [robot.jacobian(name, representation) @ case.P for name in robot.links])
        assert_close(dJ, [robot.jacobian_rate(name, representation) @ case.P for name in robot.links])


def test_wrenches_that_the_joints_transmit(case):
    W = axode.joint_wrenches(case.m, case.q, case.v, case.a, "body", case.all_loads)
    for k, state in enumerate(case.theirs):
        case.robot.inverse_dynamics(*state, case.loads[k])
        assert_close(W[k], [case.robot.joint_wrench(name) for name in case.m.joint_names])


def test_center_of_mass_and_momentum_about_it(case):
    m, P, model, data = case.m, case.P, case.robot.model, case.robot.data
    c, J = axode.center_of_mass(m, case.q), axode.center_of_mass_jacobian(m, case.q)
    A, dA = axode.centroidal_momentum_matrix(m, case.q), axode.centroidal_momentum_matrix_rate(m, case.q, case.v)
    h, I_c = axode.centroidal_momentum(m, case.q, case.v), axode.centroidal_inertia(m, case.q)
    for k, (q, v, _) in enumerate(case.theirs):
        assert_close(c[k], pin.centerOfMass(model, data, q))
        assert_close(J[k], pin.jacobianCenterOfMass(model, data, q) @ P)
        assert_close(A[k], np.roll(pin.computeCentroidalMap(model, data, q), 3, axis=0) @ P)
        A_at = [np.roll(pin.computeCentroidalMap(model, data, pin.integrate(model, q, s * v)), 3, axis=0) @ P
                for s in (1e-6, -1e-6)]
        assert_close(dA[k], (A_at[0] - A_at[1]) / 2e-6, bound=1e-7)
        # Pinocchio's rate is not the derivative of its own matrix, though its product with v is that of the
        # momentum; and not even that on data in which computeCentroidalMomentum left another state.
        rate = np.roll(pin.computeCentroidalMapTimeVariation(model, model.createData(), q, v), 3, axis=0)
        assert_close(dA[k] @ case.v[k], rate @ v)
        assert_close(h[k], np.roll(pin.computeCentroidalMomentum(model, data, q, v).vector, 3))
        pin.ccrba(model, data, q, v)
        assert_close(I_c[k], np.roll(data.Ig.matrix(), (3, 3), axis=(0, 1)))


#: The parameters xx xy yy xz yz zz of Pinocchio in our order xx yy zz xy xz yz, after m, m c.
PARAMETERS = [0, 1, 2, 3, 4, 6, 9, 5, 7, 8]


def test_regressor(case):
    robot, Y = case.robot, axode.regressor(case.m, case.q, case.v, case.a)
    moved = [robot.model.frames[robot.links[body]].parentJoint for body in case.m.body_names]
    columns = [10 * (joint - 1) + k for joint in moved for k in PARAMETERS]
    for k, state in enumerate(case.theirs):
        theirs = case.P.T @ pin.computeJointTorqueRegressor(robot.model, robot.data, *state)
        assert_close(Y[k], theirs[:, columns])


def test_derivatives_of_inverse_dynamics(case):
    """The wrenches are constant in the frames of links, as Pinocchio takes them."""
    m, P, robot, dg = case.m, case.P, case.robot, axode.gravity_derivatives(case.m, case.q)
    for k, state in enumerate(case.theirs):
        loads = [(link, "body", W) for link, _, W in case.loads[k]]
        ours = axode.inverse_dynamics_derivatives(
            m, case.q[k], case.v[k], case.a[k],
            [axode.Load(frame=link, representation=rep, wrench=W) for link, rep, W in loads])
        robot.update(*state)
        by_q, by_v, by_a = pin.computeRNEADerivatives(robot.model, robot.data, *state, robot.on_joints(loads))
        for x, y in zip(ours, (by_q, by_v, symmetric(by_a)), strict=True):
            assert_close(x, P.T @ y @ P)
        assert_close(dg[k], P.T @ pin.computeGeneralizedGravityDerivatives(robot.model, robot.data, state[0]) @ P)


def test_derivatives_of_forward_dynamics(case):
    m, P, model, data = case.m, case.P, case.robot.model, case.robot.data
    if case.robot.mimic:
        pytest.skip("Pinocchio's algorithm does not couple these joints")
    M, back = axode.mass_matrix(m, case.q), np.linalg.inv(P)
    if case.singular() or np.linalg.cond(M).max() > 1e10:
        pytest.skip("the mass matrix is singular, or nearly so")
    ours = axode.forward_dynamics_derivatives(m, case.q, case.v, case.tau)
    for k, (q, v, _) in enumerate(case.theirs):
        pin.computeABADerivatives(model, data, q, v, back.T @ case.tau[k])
        for x, y in ((ours.q[k], data.ddq_dq), (ours.v[k], data.ddq_dv)):
            # The residual of M da = -dtau is compared in the
            # units of forces, because M may be ill-conditioned.
            assert_close(M[k] @ x, M[k] @ back @ y @ P, of=np.abs(M[k]).max() * np.abs(x).max())
        assert_close(ours.tau[k], back @ symmetric(np.array(data.Minv)) @ back.T, bound=1e-9)


def test_derivatives_of_the_motion_of_a_frame(case):
    robot, link = case.robot, list(case.robot.links)[-1]
    ours = axode.motion_derivatives(case.m, case.q, case.v, case.a, link)
    for k, state in enumerate(case.theirs):
        pin.computeForwardKinematicsDerivatives(robot.model, robot.data, *state)
        pin.updateFramePlacements(robot.model, robot.data)
        V_q, dV_q, dV_v, V_v = pin.getFrameAccelerationDerivatives(robot.model, robot.data, robot.links[link],
                                                                   pinocchio_robot.LOCAL)
        for x, y in zip(ours, (V_q, V_v, dV_q, dV_v), strict=True):
            assert_close(x[k], np.roll(y, 3, axis=0) @ case.P, of=1.0)


CONTACTS = {"spherical": pin.ContactType.CONTACT_3D, "fixed": pin.ContactType.CONTACT_6D}


@pytest.mark.parametrize("kind", CONTACTS)
def test_accelerations_of_closed_robots(case, kind):
    """A loop joins two links where they are."""
    m, robot, random = case.m, case.robot, np.random.default_rng(5)
    if robot.mimic:
        pytest.skip("Pinocchio's mimic joints move on their own here")
    moving = [link for link in robot.links if robot.model.frames[robot.links[link]].parentJoint > 0]
    compared = 0
    for k, (q, _, _) in enumerate(case.theirs):
        links = random.choice(moving, 2, replace=False).tolist()
        frames = [robot.model.frames[robot.links[link]] for link in links]
        if frames[0].parentJoint == frames[1].parentJoint:
            continue
        C = axode.poses(m, case.q[k])[[m.frame_index(link) for link in links]]
        between = np.linalg.inv(C[0]) @ C[1]
        places = [{"position": F[:3, 3].tolist(), "rotation": F[:3, :3].tolist()} for F in (between, np.eye(4))]
        closed = axode.Model.from_dict(m.to_dict() | {"loop": [{"between": links, "kind": kind, "frames": places}]})
        if axode.loop_mobility(closed, case.q[k]).redundant:
            continue
        at, v = axode.assemble(closed, case.q[k], case.v[k])
        assert close(at, case.q[k], 1e-12) and np.abs(axode.loop_residual(closed, case.q[k])).max() < 1e-12
        contact = pin.RigidConstraintModel(CONTACTS[kind], robot.model, frames[0].parentJoint,
                                           frames[0].placement * pin.SE3(between), frames[1].parentJoint,
                                           frames[1].placement, pin.ReferenceFrame.LOCAL)
        models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        models.append(contact)
        datas.append(contact.createData())
        pin.initConstraintDynamics(robot.model, robot.data, models, datas)
        theirs = pin.constraintDynamics(robot.model, robot.data, q, case.P @ v, np.linalg.inv(case.P).T @ case.tau[k],
                                        models, datas)
        ours = axode.forward_dynamics(closed, case.q[k], v, case.tau[k])
        assert_close(case.P @ ours, theirs, bound=1e-8)
        compared += 1
    if compared == 0:
        pytest.skip("the joints between these links cannot keep such a loop's rows independent")


# ---------------------------------------------------------------- MuJoCo

class MuJoCoCase:
    """The same states in MuJoCo, without its losses; velocities there are P(q) times ours."""

    def __init__(self, file, base):
        self.case = pinocchio_case(file, base)
        try:
            self.robot = mujoco_robot.Robot(file, base)
        except mujoco_robot.CannotLoad as reason:
            pytest.skip(f"MuJoCo does not load {file.name}: {reason}")
        off = mujoco.mjtDisableBit
        self.robot.model.opt.disableflags |= off.mjDSBL_CONSTRAINT | off.mjDSBL_SPRING | off.mjDSBL_DAMPER

    def states(self):
        """Sets each state in MuJoCo and gives its index k, the matrix P and its rate times v."""
        for k, values in enumerate(self.case.values):
            self.robot.set(values)
            P = self.robot.velocity_map(self.case.independent)
            dP_v = np.zeros(self.robot.model.nv)
            # Linear velocities are along inertial axes there and along body axes here.
            if FREE_BASE in self.robot.joints:
                w, v = np.split(np.array(values["v"][FREE_BASE]), 2)
                at = self.robot.joints[FREE_BASE].dofadr[0]
                dP_v[at:at + 3] = self.robot.R @ np.cross(w, v)
            yield k, P, dP_v

    def force(self, P, dP_v, a):
        """The forces that MuJoCo's inverse dynamics gives for our accelerations, in our coordinates."""
        self.robot.data.qacc[:] = P @ a + dP_v
        mujoco.mj_inverse(self.robot.model, self.robot.data)
        return P.T @ self.robot.data.qfrc_inverse

    def bodies(self):
        """Our moving bodies, and their indices in MuJoCo."""
        renamed = {"world": "root of the robot"}
        return [(name, self.robot.model.body(renamed.get(name, name)).id) for name in self.case.m.body_names]


@pytest.fixture
def peer(robot, base):
    return MuJoCoCase(robot, base)


def test_mujoco_agrees_about_forces(peer):
    case, m = peer.case, peer.case.m
    M, Cv = axode.mass_matrix(m, case.q), axode.coriolis_vector(m, case.q, case.v)
    g, tau = axode.gravity_torques(m, case.q), axode.inverse_dynamics(m, case.q, case.v, case.a)
    for k, P, dP_v in peer.states():
        theirs = peer.robot.mass_matrix()
        assert_close(M[k], P.T @ theirs @ P)
        assert_close(Cv[k] + g[k], P.T @ (peer.robot.data.qfrc_bias + theirs @ dP_v))
        assert_close(tau[k], peer.force(P, dP_v, case.a[k]))


def test_mujoco_agrees_about_accelerations_from_forces(peer):
    case, m = peer.case, peer.case.m
    if case.singular():
        pytest.skip("the mass matrix is singular")
    M, a = np.abs(axode.mass_matrix(m, case.q)).max(), axode.forward_dynamics(m, case.q, case.v, case.tau)
    for k, P, dP_v in peer.states():
        assert_close(peer.force(P, dP_v, a[k]), case.tau[k], of=M * np.abs(a[k]).max())
        if not case.robot.mimic:  # which MuJoCo does not couple
            peer.robot.data.qfrc_applied[:] = np.linalg.inv(P).T @ case.tau[k]
            mujoco.mj_forward(peer.robot.model, peer.robot.data)
            peer.robot.data.qfrc_applied[:] = 0
            assert_close(P @ a[k] + dP_v, peer.robot.data.qacc, bound=1e-8)


def test_mujoco_agrees_about_motion(peer):
    """Hybrid: inertial axes, about the origin of the body."""
    case, m, bodies = peer.case, peer.case.m, peer.bodies()
    frames = [m.frame_names.index(name) for name, _ in bodies]
    C, V = axode.poses(m, case.q), axode.twists(m, case.q, case.v, "hybrid")
    J = np.array([axode.jacobian(m, case.q, f, "hybrid") for f in frames])
    model, data = peer.robot.model, peer.robot.data
    for k, P, dP_v in peer.states():
        assert_close(C[k, frames, :3, 3], [data.xpos[b] for _, b in bodies])
        assert_close(C[k, frames, :3, :3], [data.xmat[b].reshape(3, 3) for _, b in bodies])
        twists, jacobians = np.empty((len(bodies), 6)), np.empty((len(bodies), 6, model.nv))
        for (_, b), twist, (angular, linear) in zip(bodies, twists, jacobians.reshape(-1, 2, 3, model.nv)):
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, b, twist, 0)
            mujoco.mj_jac(model, data, linear, angular, data.xpos[b], b)
        assert_close(V[k, frames], twists)
        assert_close(J[:, k], jacobians @ P)


def test_mujoco_agrees_about_classical_accelerations(peer):
    case, m, bodies = peer.case, peer.case.m, peer.bodies()
    dV = axode.accelerations(m, case.q, case.v, case.a, "hybrid")
    model, data = peer.robot.model, peer.robot.data
    for k, P, dP_v in peer.states():
        data.qacc[:] = P @ case.a[k] + dP_v
        mujoco.mj_rnePostConstraint(model, data)
        theirs = np.empty((len(bodies), 6))
        for (_, b), acceleration in zip(bodies, theirs):
            mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_XBODY, b, acceleration, 0)
        theirs[:, 3:] += model.opt.gravity  # theirs is what an accelerometer feels
        assert_close(dV[k, [m.frame_names.index(name) for name, _ in bodies]], theirs)


def test_mujoco_agrees_about_the_momentum_about_the_center_of_mass(peer):
    case, m = peer.case, peer.case.m
    c, h = axode.center_of_mass(m, case.q), axode.centroidal_momentum(m, case.q, case.v)
    data = peer.robot.data
    for k, _, _ in peer.states():
        mujoco.mj_subtreeVel(peer.robot.model, data)
        assert_close(c[k], data.subtree_com[0])
        assert_close(h[k], [*data.subtree_angmom[0], *m.total_mass * data.subtree_linvel[0]])


def test_mujoco_moves_likewise(peer):
    """Robots without coupled joints, by MuJoCo's Runge-Kutta method in short steps."""
    case, m, model, data = peer.case, peer.case.m, peer.robot.model, peer.robot.data
    if case.robot.mimic or case.singular():
        pytest.skip("MuJoCo does not couple joints" if case.robot.mimic else "the mass matrix is singular")
    model.opt.integrator, model.opt.timestep, steps = mujoco.mjtIntegrator.mjINT_RK4, 1e-4, 100
    next(peer.states())
    for _ in range(steps):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    end = axode.simulate(m, case.q[0], case.v[0], steps * 1e-4, rtol=1e-11, atol=1e-13).q[-1]
    C = axode.poses(m, end)
    for name, b in peer.bodies():
        ours = C[m.frame_names.index(name)]
        assert_close(ours[:3, :3], data.xmat[b].reshape(3, 3), bound=1e-7)
        assert_close(ours[:3, 3], data.xpos[b], of=1.0, bound=1e-7)
