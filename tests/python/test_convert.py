"""States in the orders of Pinocchio and MuJoCo have the same meaning there, and converted back they are the same as
before."""

import random
import re

import axode
import numpy as np
import pytest
from axode import convert
from mechanisms import close, random_states

STATES = 5


# ---------------------------------------------------------------- mechanisms

LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def tree(seed, kinds, axes=("0 0 1",), followers=0):
    """A URDF of a random tree. The order of its elements differs from that of the tree and from that of their names."""
    chance = random.Random(seed)
    n = chance.randrange(4, 14)
    links, joints = [f"link {k}" for k in range(n)], [f"joint {k}" for k in range(1, n)]
    chance.shuffle(links)
    chance.shuffle(joints)
    elements, leaders = [], []

    def vector(scale):
        return " ".join(f"{scale * chance.uniform(-1, 1):.3f}" for _ in range(3))
    for k in range(1, n):
        kind = chance.choice(kinds)
        parent = links[chance.randrange(max(0, k - 4), k)]
        if kind == "floating" and k > 1:
            kind = "revolute"
        mimic = ""
        if kind in ("revolute", "continuous", "prismatic"):
            if followers and leaders and chance.random() < followers:
                mimic = (f'<mimic joint="{chance.choice(leaders)}" multiplier="{chance.uniform(-2, 2):.3f}" '
                         'offset="0.1"/>')
            else:
                leaders.append(joints[k - 1])
        elements.append(f'<joint name="{joints[k - 1]}" type="{kind}"><origin xyz="{vector(1)}" rpy="{vector(3)}"/>'
                        f'<parent link="{parent}"/><child link="{links[k]}"/>{LIMIT}{mimic}'
                        f'<axis xyz="{chance.choice(axes)}"/></joint>')
    for link in links:
        elements.append(f'<link name="{link}"><inertial><origin xyz="{vector(0.5)}" rpy="{vector(3)}"/>'
                        '<mass value="2"/><inertia ixx="1" iyy="1.2" izz="0.9" ixy="0.1" ixz="0" iyz="0.05"/>'
                        '</inertial></link>')
    chance.shuffle(elements)
    return f'<robot name="random">{"".join(elements)}</robot>'


def one_body(**more):
    return axode.Model.from_bodies([{"name": "b", "mass": 1.0, "com": [0, 0, 0], "inertia": [1, 1, 1], **more}])


def one_joint(**joint):
    return one_body(joint=joint)


AXES = ("0 0 1", "0 0 -1", "1 0 0", "0.6 0 0.8", "0.3 0.4 0.5")
TREES = range(40)


# ---------------------------------------------------------------- Pinocchio

class Pinocchio:
    """A model in Pinocchio, with its results for states that were converted to its order."""

    def __init__(self, model):
        import pinocchio as pin
        self.pin, self.model, self.data = pin, model, model.createData()
        self.bodies = {frame.name: k for k, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}

    def poses_and_twists(self, q, v):
        pin, model, data = self.pin, self.model, self.data
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        twists = [pin.getFrameVelocity(model, data, k, pin.ReferenceFrame.LOCAL).vector for k in self.bodies.values()]
        return [data.oMf[k].homogeneous for k in self.bodies.values()], np.roll(twists, 3, axis=1)

    def check_motion(self, m, mimic=False):
        q, v, _, _ = random_states(m, STATES)
        there = convert.to_pinocchio(m, q, v, mimic=mimic)
        assert there[0].shape == (len(q), self.model.nq) and there[1].shape == (len(v), self.model.nv)
        frames = [m.frame_names.index(name) for name in self.bodies]
        C, V = axode.poses(m, q)[:, frames], axode.twists(m, q, v, "body")[:, frames]
        for k, state in enumerate(zip(*there)):
            poses, twists = self.poses_and_twists(*state)
            assert close(C[k], poses)
            assert close(V[k], twists)

    def check_forces(self, m, mimic=False):
        """Checks P' tau_there = tau and a_there = P a for the matrix P with v_there = P v."""
        for q, v, a, _ in zip(*random_states(m, STATES)):
            P = convert.to_pinocchio(m, np.tile(q, (m.nv, 1)), np.eye(m.nv), mimic=mimic)[1].T
            q_there, v_there = convert.to_pinocchio(m, q, v, mimic=mimic)
            assert close(v_there, P @ v, 1e-15)
            tau_there = self.pin.rnea(self.model, self.data, q_there, v_there, P @ a)
            assert close(axode.inverse_dynamics(m, q, v, a), P.T @ tau_there)


def test_pinocchio_moves_as_we_do(robot, base):
    pin = pytest.importorskip("pinocchio")
    root = [pin.JointModelFreeFlyer()] if base == "free" else []
    m, theirs = axode.load(robot, base), Pinocchio(pin.buildModelFromUrdf(str(robot), *root))
    theirs.check_motion(m)
    theirs.check_forces(m)


def test_pinocchio_moves_as_we_do_where_it_couples_joints(base):
    pin = pytest.importorskip("pinocchio")
    coupled = 0
    for seed in TREES:
        text = tree(seed, ("revolute", "fixed", "prismatic"), AXES, followers=0.4)
        m = axode.read_urdf(text, base)
        try:
            model = pin.buildModelFromXML(text, *([pin.JointModelFreeFlyer()] if base == "free" else []), mimic=True)
        except ValueError:
            continue  # a leader behind its follower
        coupled += any(m.joint(name).leader for name in m.joint_names)
        Pinocchio(model).check_motion(m, mimic=True)
        Pinocchio(model).check_forces(m, mimic=True)
    assert coupled > 0


@pytest.mark.parametrize("seed", TREES)
def test_pinocchio_moves_as_we_do_with_every_joint_of_urdf(seed):
    pin = pytest.importorskip("pinocchio")
    for kinds, axes, followers in [(("revolute", "continuous", "prismatic", "fixed"), AXES, 0.3),
                                   (("planar", "floating", "fixed", "revolute"), ("0 0 1",), 0)]:
        text = tree(seed, kinds, axes, followers)
        m, theirs = axode.read_urdf(text), Pinocchio(pin.buildModelFromXML(text))
        theirs.check_motion(m)
        theirs.check_forces(m)


def test_pinocchio_moves_as_we_do_where_a_drawing_becomes_urdf():
    pin = pytest.importorskip("pinocchio")
    body = {"mass": 1.0, "com": [0, 0.1, 0.2], "inertia": [1, 1.1, 0.9]}
    m = axode.Model.from_bodies([
        {"name": "b", "joint": {"kind": "cylindrical", "axis": "x", "point": [0, 0, 1]}, **body},
        {"name": "a", "on": "b", "joint": {"kind": "universal", "axis": "y", "second_axis": "z", "point": [1, 0, 0]},
         **body},
        {"name": "d", "on": "b", "joint": "fixed", **body},
        {"name": "e", "on": "d", "joint": {"kind": "revolute", "axis": "z", "point": [0, 1, 0], "limits": [-1, 1]},
         **body},
        {"name": "c", "on": "b", "joint": {"kind": "prismatic", "axis": "z"}, **body}])
    theirs = Pinocchio(pin.buildModelFromXML(axode.urdf(m)))
    theirs.bodies = {name: k for name, k in theirs.bodies.items() if name in m.body_names}
    theirs.check_forces(m)


def test_joints_of_pinocchio_may_be_named():
    pin = pytest.importorskip("pinocchio")
    m = axode.load(axode.robots / "humanoid.urdf", "free")
    model = pin.buildModelFromUrdf(str(axode.robots / "humanoid.urdf"), pin.JointModelFreeFlyer(), "free_base")
    q, v, _, _ = random_states(m, STATES)
    for ours, named in zip(convert.to_pinocchio(m, q, v), convert.to_pinocchio(m, q, v, joints=list(model.names)[1:])):
        np.testing.assert_array_equal(ours, named)
    back = convert.from_pinocchio(m, *convert.to_pinocchio(m, q, v, joints=m.joint_names), joints=m.joint_names)
    assert close(back[0], q, 1e-15)
    unlike = convert.to_pinocchio(m, q, v, joints=[m.joint_names[0], *m.joint_names[:0:-1]])
    np.testing.assert_array_equal(unlike[1][:, 6:], v[:, :5:-1])


def test_pinocchio_moves_as_we_do_with_joints_that_urdf_does_not_have():
    pin = pytest.importorskip("pinocchio")
    model = pin.Model()
    inertia = pin.Inertia(1.0, np.array([0.1, 0, 0.2]), np.diag([1, 1.1, 0.9]))
    for parent, joint, name in [(0, pin.JointModelFreeFlyer(), "base"), (1, pin.JointModelSpherical(), "shoulder")]:
        placement = pin.SE3(pin.exp3(np.array([0.1, 0.2, 0.3])), np.array([1.0, 2, 3]))
        number = model.addJoint(parent, joint, placement, name)
        model.appendBodyToJoint(number, inertia, pin.SE3.Identity())
        model.addFrame(pin.Frame(f"body {number}", number, pin.SE3.Identity(), pin.FrameType.BODY))
    pose = {"position": [1, 2, 3], "quaternion": list(pin.Quaternion(placement.rotation).coeffs())}
    ours = {"B": pose, "mass": 1.0, "com": [0.1, 0, 0.2], "inertia": [1, 1.1, 0.9]}
    m = axode.Model.from_bodies([
        {"name": "body 1", "joint": {"kind": "free", "name": "base"}, **ours},
        {"name": "body 2", "on": "body 1", "joint": {"kind": "spherical", "name": "shoulder"}, **ours}])
    Pinocchio(model).check_motion(m)
    Pinocchio(model).check_forces(m)


# ---------------------------------------------------------------- MuJoCo

class MuJoCo:
    """A model in MuJoCo, with its results for states that were converted to its order."""

    def __init__(self, model):
        import mujoco
        self.mujoco, self.model, self.data = mujoco, model, mujoco.MjData(model)

    def check_motion(self, m):
        q, v, _, _ = random_states(m, STATES)
        bodies = [self.model.body("root of the robot" if name == "world" else name).id
                  for name in m.body_names]  # as the adapter renames it
        C, V = axode.poses(m, q)[:, 1:1 + m.n_bodies], axode.twists(m, q, v, "hybrid")[:, 1:1 + m.n_bodies]
        for k, state in enumerate(zip(*convert.to_mujoco(m, q, v))):
            self.data.qpos[:], self.data.qvel[:] = state
            self.mujoco.mj_forward(self.model, self.data)
            twists = np.empty((len(bodies), 6))
            for b, twist in zip(bodies, twists):
                self.mujoco.mj_objectVelocity(self.model, self.data, self.mujoco.mjtObj.mjOBJ_XBODY, b, twist, 0)
            assert close(C[k, :, :3, 3], self.data.xpos[bodies])
            assert close(C[k, :, :3, :3], self.data.xmat[bodies].reshape(-1, 3, 3))
            assert close(V[k], twists)

    def check_forces(self, m):
        """Checks P' tau_there = tau for the matrix P with v_there = P v; here a_there is P a plus the rate of P times
        v."""
        for q, v, a, _ in zip(*random_states(m, STATES)):
            P, h = self.map(m, q), 1e-6
            self.data.qpos[:], self.data.qvel[:] = convert.to_mujoco(m, q, v)
            assert close(self.data.qvel, P @ v, 1e-14)
            P_rate = (self.map(m, m.integrate(q, h * v)) - self.map(m, m.integrate(q, -h * v))) / (2 * h)
            self.data.qacc[:] = P @ a + P_rate @ v
            self.mujoco.mj_inverse(self.model, self.data)
            assert close(axode.inverse_dynamics(m, q, v, a), P.T @ self.data.qfrc_inverse, 1e-9)  # for P_rate

    @staticmethod
    def map(m, q):
        return convert.to_mujoco(m, np.tile(q, (m.nv, 1)), np.eye(m.nv))[1].T


def compiled(file, base):
    """A MuJoCo model of a URDF that feels no damping; skips where MuJoCo refuses it."""
    mujoco = pytest.importorskip("mujoco")
    import mujoco_robot
    try:
        model = mujoco_robot.Robot(file, base).model
    except mujoco_robot.CannotLoad as reason:
        pytest.skip(f"MuJoCo does not load it: {reason}")
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_DAMPER
    return model


def test_mujoco_moves_as_we_do(robot, base):
    """MuJoCo and axode agree about motions, also of files whose inertias MuJoCo would refuse."""
    mujoco = pytest.importorskip("mujoco")
    import mujoco_robot
    text = mujoco_robot.without_geometry(robot, base)
    text = re.sub("<inertia [^>]*>", '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>', text)
    text = re.sub("<mass [^>]*>", '<mass value="1"/>', text)
    MuJoCo(mujoco.MjModel.from_xml_string(text)).check_motion(axode.load(robot, base))


def test_mujoco_needs_the_same_forces(robot, base):
    MuJoCo(compiled(robot, base)).check_forces(axode.load(robot, base))


@pytest.mark.parametrize("seed", TREES)
def test_mujoco_moves_as_we_do_with_every_joint_of_urdf(seed, base, tmp_path):
    file = tmp_path / "random.urdf"
    file.write_text(tree(seed, ("revolute", "continuous", "prismatic", "fixed", "planar"), AXES, followers=0.3))
    m, theirs = axode.load(file, base), MuJoCo(compiled(file, base))
    theirs.check_motion(m)
    theirs.check_forces(m)


def test_mujoco_moves_as_we_do_from_mjcf():
    mujoco = pytest.importorskip("mujoco")
    inertial = '<inertial pos="0.1 0 0.2" mass="1" diaginertia="1 1.1 0.9"/>'
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
        <body name="base" pos="1 2 3" quat="0.5 0.5 -0.5 0.5"><freejoint/>{inertial}
          <body name="arm" pos="0.3 0 0.1" quat="0.8 0 0.6 0"><joint name="shoulder" type="ball"/>{inertial}
            <body name="hand" pos="0 0.2 0"><joint type="hinge" axis="0 1 0"/>{inertial}</body>
          </body></body></worldbody></mujoco>""")
    inertia = {"mass": 1.0, "com": [0.1, 0, 0.2], "inertia": [1, 1.1, 0.9]}
    m = axode.Model.from_bodies([
        {"name": "base", "joint": "free", "B": {"position": [1, 2, 3], "quaternion": [0.5, -0.5, 0.5, 0.5]}, **inertia},
        {"name": "arm", "on": "base", "joint": {"kind": "spherical"},
         "B": {"position": [0.3, 0, 0.1], "quaternion": [0, 0.6, 0, 0.8]}, **inertia},
        {"name": "hand", "on": "arm", "joint": {"kind": "revolute", "axis": "y"}, "B": {"position": [0, 0.2, 0]},
         **inertia}])
    MuJoCo(model).check_motion(m)
    MuJoCo(model).check_forces(m)
    assert close(convert.to_mujoco(m, m.neutral())[0], model.qpos0)


@pytest.mark.parametrize("x, y, z, w", [(0, 0, 0, 1), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0.5, -0.5, 0.7, 0.1)])
def test_mujoco_places_a_free_body_where_we_do(x, y, z, w):
    mujoco = pytest.importorskip("mujoco")
    Q = np.array([x, y, z, w]) / np.linalg.norm([x, y, z, w])
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
        <body name="b" pos="1 2 3" quat="{Q[3]} {Q[0]} {Q[1]} {Q[2]}"><freejoint/>
          <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody></mujoco>""")
    MuJoCo(model).check_motion(one_body(joint="free", B={"position": [1, 2, 3], "quaternion": Q}))


# ---------------------------------------------------------------- there and back

WAYS = {"pinocchio": (convert.to_pinocchio, convert.from_pinocchio),
        "mujoco": (convert.to_mujoco, convert.from_mujoco)}
EVERY = ("revolute", "continuous", "prismatic", "fixed", "planar", "floating")


def check_there_and_back(m, to, back):
    q, v, _, _ = random_states(m, 20)
    q_there, v_there = to(m, q, v)
    q_again, v_again = back(m, q_there, v_there)
    assert close(q_again, q, 1e-14)
    assert close(v_again, v, 1e-14)
    only_q, nothing = back(m, q_there, None)
    assert nothing is None and to(m, q)[1] is None
    np.testing.assert_array_equal(only_q, q_again)
    for k in range(len(q)):  # one state at a time, bit for bit
        for many, one in [((q_there, v_there), to(m, q[k], v[k])),
                          ((q_again, v_again), back(m, q_there[k], v_there[k]))]:
            np.testing.assert_array_equal(many[0][k], one[0])
            np.testing.assert_array_equal(many[1][k], one[1])


@pytest.mark.parametrize("way", WAYS)
def test_states_come_back(robot, base, way):
    check_there_and_back(axode.load(robot, base), *WAYS[way])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", TREES)
def test_states_of_every_joint_come_back(seed, way):
    check_there_and_back(axode.read_urdf(tree(seed, EVERY, followers=0.3)), *WAYS[way])


def test_states_come_back_where_followers_are_left_out():
    for seed in TREES:
        m = axode.read_urdf(tree(seed, EVERY, followers=0.5))
        check_there_and_back(m, lambda m, q, v=None: convert.to_pinocchio(m, q, v, mimic=True), convert.from_pinocchio)


@pytest.mark.parametrize("way", WAYS)
def test_no_states_are_states(way):
    m = axode.read_urdf(tree(0, EVERY))
    to, back = WAYS[way]
    q, v = to(m, np.empty((0, m.nq)), np.empty((0, m.nv)))
    assert [x.shape for x in back(m, q, v)] == [(0, m.nq), (0, m.nv)]


# ---------------------------------------------------------------- refusals

COUPLED = f"""<robot name="coupled"><link name="base"/><link name="b"/><link name="c"/>
  <joint name="b" type="revolute"><parent link="base"/><child link="b"/>{LIMIT}</joint>
  <joint name="c" type="continuous"><parent link="b"/><child link="c"/><mimic joint="b" multiplier="2" offset="0.1"/>
  </joint></robot>"""


def coupled():
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    return axode.read_urdf(COUPLED.replace('"/>', f'">{inertial}</link>', 3).replace('"base"></link>', '"base"/>'))


@pytest.mark.parametrize("way", WAYS)
def test_joints_without_counterpart_are_named(way):
    m = one_joint(name="screw", kind="helical", axis="z", point=[0, 0, 0], pitch=0.1)
    for f in WAYS[way]:
        with pytest.raises(ValueError, match='joint "screw": is helical'):
            f(m, [0.0])


def test_planes_that_pinocchio_does_not_have_are_refused():
    m = one_joint(name="table", kind="planar", axis="x", point=[0, 0, 0])
    with pytest.raises(ValueError, match='joint "table": its axes'):
        convert.to_pinocchio(m, m.neutral())


@pytest.mark.parametrize("f", [f for way in WAYS.values() for f in way])
def test_balls_in_axes_of_their_own_are_refused(f):
    m = one_body(joint={"kind": "spherical", "name": "ball", "point": [0, 0, 0]}, A={"quaternion": [0.6, 0, 0, 0.8]})
    with pytest.raises(ValueError, match='joint "ball": its axes differ from the axes of body "b"'):
        f(m, m.neutral())


def test_angles_off_the_unit_circle_are_refused():
    m = one_joint(name="wheel", kind="revolute", axis="z", point=[0, 0, 0])
    assert convert.from_pinocchio(m, [0.6, 0.8 + 5e-7])[0] == pytest.approx(np.arctan2(0.8, 0.6), abs=1e-6)
    with pytest.raises(ValueError, match=r'q: \(cos, sin\) of joint "wheel" has length .* in state 1; expected 1'):
        convert.from_pinocchio(m, [[0.6, 0.8], [0.6, 0.80001]])


def test_quaternions_off_unit_length_are_refused():
    m = one_joint(name="base", kind="free")
    with pytest.raises(ValueError, match='q: the quaternion of joint "base" has length 1.01 in state 0'):
        convert.from_mujoco(m, [0, 0, 0, 1.01, 0, 0, 0])
    with pytest.raises(ValueError, match='q: the quaternion of joint "base"'):
        convert.to_mujoco(m, [0, 0, 0, 1.01, 0, 0, 0])


@pytest.mark.parametrize("way", WAYS)
def test_followers_off_their_place_are_refused(way):
    m = coupled()
    to, back = WAYS[way]
    q, v = to(m, [[0.3], [0.4]], [[1.0], [1.0]])
    off = q.copy()
    off[1, -1] += 1e-8
    with pytest.raises(ValueError, match='q: joint "c" follows joint "b" and differs by .* from its coupling in state 1'):
        back(m, off, v)
    np.testing.assert_allclose(back(m, off, v, tolerance=1e-6)[0], [[0.3], [0.4]])
    v[0, 1] = 5
    with pytest.raises(ValueError, match='v: joint "c" follows'):
        back(m, q, v)
    np.testing.assert_array_equal(back(m, q, v, tolerance=np.inf)[1], [[1.0], [1.0]])


@pytest.mark.parametrize("f", [f for way in WAYS.values() for f in way])
def test_wrong_arguments_are_named(f):
    m = axode.load(axode.robots / "arm7.toml")
    n = np.zeros(7)
    for q, v, says in [(np.zeros(6), n, r"q: expected shape \(7,\) or \(N, 7\), .*, got \(6,\)"),
                       (n, np.zeros(8), r"v: expected shape \(7,\), .*, got \(8,\)"),
                       (np.zeros((2, 7)), n, r"v: expected shape \(2, 7\), .*, got \(7,\)"),
                       (np.zeros((1, 1, 7)), n, r"q: expected shape"),
                       (3.0, n, r"q: expected shape"),
                       ([0.0] * 6 + [np.nan], n, r"q\[6\] is nan; expected finite numbers"),
                       (n, [[0.0] * 7, [0.0]], "v: expected numbers in rows of equal length"),
                       (n, ["a"] * 7, "v: expected real numbers"),
                       (n.astype(complex), n, r"q: expected real numbers \(float64\), got dtype complex128")]:
        with pytest.raises(ValueError, match=says):
            f(m, q, v)
    with pytest.raises(ValueError, match="q: expected numbers in rows of equal length"):
        f(m, [[0.0] * 7, [0.0]], n)
    with pytest.raises(KeyError, match="A9"):
        f(m, n, n, joints=["A9", *m.joint_names[1:]])
    with pytest.raises(ValueError, match="joints: expected every joint of the model once; it is not so for A1, A2"):
        f(m, n, n, joints=["A2", *m.joint_names[1:]])


def test_a_model_without_bodies_has_no_coordinates_there():
    empty = axode.Model.from_bodies([])
    assert convert.to_pinocchio(empty, [])[0].shape == convert.from_pinocchio(empty, [])[0].shape == (0,)
