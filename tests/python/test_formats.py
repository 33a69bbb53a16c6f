"""File formats of other programs. MuJoCo computes the same from its files as axode does from the models that it reads
from them, and the same from the files that axode writes."""

import struct
import sys
import warnings
from pathlib import Path

import axode
import numpy as np
import pytest
from axode import convert
from mechanisms import close, random_states

STATES = 5

MATTER = '<inertial pos="0.1 0.05 0.2" quat="0.8 0.1 0.5 0.2" mass="1.3" diaginertia="1 1.1 0.9"/>'
MATTER += '<site/><geom type="box" size="0.1 0.1 0.1"/>'

#: A file with everything that MJCF can express about joints.
EVERYTHING = f"""<mujoco model="everything">
  <compiler angle="degree" eulerseq="zyx"/>
  <option gravity="1 2 -9"/>
  <default>
    <joint damping="0.2" armature="0.05"/>
    <default class="stiff"><joint stiffness="7" springref="20" frictionloss="0.3"/></default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <geom name="table" type="box" size="1 2 3" euler="10 20 30" pos="0 0 -3"/>
    <site name="mark" pos="1 2 3" quat="0.6 0 0.8 0"/>
    <body name="post" pos="0 1 0">{MATTER}
      <frame pos="0.1 0.2 0.3" euler="10 20 30">
        <body name="turret" euler="30 0 0" childclass="stiff">
          <joint name="yaw" axis="0 0 2" pos="0.1 0 0" ref="40" range="-90 90"/>
          <joint name="lift" type="slide" axis="1 0 1" ref="0.3" springref="0.1"/>
          <joint name="pitch" axis="0 1 0" pos="0 0.2 0.1" damping="3" actuatorfrcrange="-5 5"/>
          {MATTER}
          <body name="arm" pos="0.3 0 0.1" quat="0.8 0 0.6 0">
            <joint name="shoulder" type="ball" pos="0.05 0 0" springref="0"/>{MATTER}
            <body name="hand" pos="0 0.2 0"><joint type="hinge" axis="0 1 0" ref="-20"/>{MATTER}
              <body><joint name="swivel" type="ball"/><joint type="slide" axis="1 1 0"/>{MATTER}</body>
              <body><geom type="capsule" size="0.1 0.2"/></body>
            </body></body></body></frame></body>
    <body name="stone" pos="1 2 3" quat="0.5 0.5 -0.5 0.5"><freejoint/>{MATTER}
      <body name="drum"><joint name="spin" axis="1 2 2" ref="15"/>{MATTER}</body></body>
  </worldbody>
</mujoco>"""

#: A file with everything that couples coordinates and bodies.
TIED = f"""<mujoco>
  <compiler angle="radian"/>
  <default><joint axis="0 1 0"/></default>
  <worldbody>
    <body name="crank"><joint name="one"/>{MATTER}
      <body name="coupler" pos="0 0 1"><joint name="two"/>{MATTER}<site name="end" pos="2 0 0.1"/></body></body>
    <body name="rocker" pos="2 0 0"><joint name="three" ref="0.2"/>{MATTER}<site name="top" pos="0 0 1"/></body>
    <body name="left" pos="0 3 0"><joint name="left" ref="0.3"/>{MATTER}</body>
    <body name="right" pos="0 4 0"><joint name="right" ref="-0.1"/>{MATTER}</body>
    <body name="third" pos="0 5 0"><joint name="third" type="slide"/>{MATTER}</body>
    <body name="fourth" pos="0 6 0"><joint name="fourth"/>{MATTER}</body>
    <body name="lid" pos="0 7 0"><freejoint/>{MATTER}</body>
  </worldbody>
  <tendon>
    <fixed name="sum"><joint joint="third" coef="2"/><joint joint="fourth" coef="-1"/><joint joint="three" coef="1"/></fixed>
    <spatial name="band" stiffness="3" damping="2" springlength="0.7"><site site="end"/><site site="top"/></spatial>
    <spatial name="rope" range="0 1"><site site="end"/><site site="top"/></spatial>
  </tendon>
  <equality>
    <connect name="pin" site1="end" site2="top"/>
    <connect name="ball" body1="coupler" body2="rocker" anchor="2 0 0"/>
    <weld name="glue" body1="lid" body2="crank"/>
    <joint name="mirror" joint1="left" joint2="right" polycoef="0.1 -2 0 0 0"/>
    <joint name="again" joint1="right" joint2="left" polycoef="0 3 0 0 0"/>
    <joint name="curve" joint1="third" joint2="right" polycoef="0 0 1 0 0"/>
    <joint name="asleep" joint1="third" active="false"/>
    <tendon name="balance" tendon1="sum" polycoef="0.2 0 0 0 0"/>
  </equality>
  <actuator>
    <motor name="drive" joint="one" gear="3" ctrlrange="-2 1"/>
    <position name="servo" joint="left" kp="2" forcerange="-4 4"/>
  </actuator>
  <sensor><jointpos joint="one"/></sensor>
</mujoco>"""


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    """Runs the test in a folder of its own, because MuJoCo writes warnings to a file in the working folder."""
    monkeypatch.chdir(tmp_path)


def mujoco():
    return pytest.importorskip("mujoco")


def compiled(text):
    return mujoco().MjModel.from_xml_string(text)


def names_of(there):
    return [there.body(i).name or f"body {i}" for i in range(1, there.nbody)]


def velocity_rate(m, q, v):
    """The rate P' of the velocity map times v. It is R (w x v) for free and planar joints, whose linear velocities
    have other axes in MuJoCo."""
    rate = np.zeros(m.nv)
    for joint in m.joints:
        if joint.kind == "free":
            rate[joint.v] = np.concatenate([np.zeros(3), np.cross(v[joint.v][:3], v[joint.v][3:])])
        if joint.kind == "planar":
            w, x, y = v[joint.v]
            rate[joint.v] = [0, -w * y, w * x]
    return convert.to_mujoco(m, q, rate)[1]


def check_same(m, there, names, armature_of_free_joints=True, least=0.0):
    """Compares poses, the mass matrix and bias forces in random states."""
    data = mujoco().MjData(there)
    q, v, _, _ = random_states(m, STATES)
    C, M = axode.poses(m, q), axode.mass_matrix(m, q)
    bias = axode.coriolis_vector(m, q, v) + axode.gravity_torques(m, q)
    frames = [m.frame_index(name) for name in names]
    for k in range(STATES):
        data.qpos[:], data.qvel[:] = convert.to_mujoco(m, q[k], v[k])
        mujoco().mj_forward(there, data)
        assert close(C[k, frames, :3, 3], data.xpos[1:1 + len(names)])
        assert close(C[k, frames, :3, :3], data.xmat[1:1 + len(names)].reshape(-1, 3, 3))
        theirs = np.zeros((there.nv, there.nv))
        if hasattr(data, "qM"):
            mujoco().mj_fullM(there, theirs, data.qM)
        else:
            mujoco().mj_fullM(there, data, theirs)
        P = convert.to_mujoco(m, np.tile(q[k], (m.nv, 1)), np.eye(m.nv))[1].T
        assert np.abs(M[k] - P.T @ theirs @ P).max(initial=0) <= 1e-10 * np.abs(M[k]).max(initial=0) + least
        if armature_of_free_joints:
            assert close(bias[k], P.T @ (data.qfrc_bias + theirs @ velocity_rate(m, q[k], v[k])))
        still = convert.to_mujoco(m, q[k], np.zeros(m.nv))
        data.qpos[:], data.qvel[:] = still
        mujoco().mj_forward(there, data)
        if m.n_loops == 0:
            assert close(axode.spring_forces(m, q[k], np.zeros(m.nv)), P.T @ data.qfrc_spring)


# ---------------------------------------------------------------- MJCF in

def test_mujoco_finds_the_same_in_our_model_of_its_file():
    there = compiled(EVERYTHING)
    m = convert.model_from_mujoco(there)
    assert m.nv == there.nv and m.name == "everything"
    check_same(m, there, names_of(there))
    np.testing.assert_array_equal(m.gravity, [1, 2, -9])


def test_mujoco_finds_the_same_in_the_model_that_comes_with_it():
    """The base of this model has an armature, whose axes in MuJoCo do not turn with the base."""
    file = next((mujoco_folder() / "testdata").glob("model.xml"), None)
    if file is None:
        pytest.skip("this MuJoCo comes without models")
    there = mujoco().MjModel.from_xml_path(str(file))
    m = axode.load(file)
    check_same(m, there, names_of(there), armature_of_free_joints=False)
    assert any("hfield" in str(warning) for warning in m.warnings)


def mujoco_folder():
    return Path(mujoco().__file__).parent


def test_what_joints_say_is_kept():
    m = convert.model_from_mujoco(compiled(EVERYTHING))
    yaw, pitch, lift = m.joint("yaw"), m.joint("pitch"), m.joint("lift")
    assert close([yaw.lower[0], yaw.upper[0]], [-np.pi / 2, np.pi / 2])
    assert yaw.friction[0] == 0.3 and pitch.damping[0] == 3 and pitch.effort[0] == 5
    assert m.joint_names[:3] == ["yaw", "lift", "pitch"] and np.isinf(lift.lower[0])
    assert m.body_names[:3] == ["turret.yaw", "turret.lift", "turret"]


def test_sites_and_fixed_bodies_are_frames():
    m = convert.model_from_mujoco(compiled(EVERYTHING))
    C = axode.poses(m, m.neutral())[m.frame_index("mark")]
    assert close(C[:3, 3], [1, 2, 3]) and close(C[:3, 2], [0.96, 0, -0.28])
    assert {"post", "site 1"} <= set(m.frame_names)


def test_ties_become_loops_couplings_and_followers():
    there = compiled(TIED)
    m = convert.model_from_mujoco(there)
    d = m.to_dict()
    assert [(loop["kind"], loop["name"]) for loop in d["loop"]] == [("spherical", "pin"), ("spherical", "ball"),
                                                                    ("fixed", "glue")]
    leader, ratio, offset = m.joint("left").leader
    assert (leader, ratio) == ("right", -2) and offset == pytest.approx(0.3 + 0.1 + 2 * -0.1)
    assert [c["name"] for c in d["coupling"]] == ["again", "balance"]
    assert m.joint("one").effort[0] == 6 and m.joint("left").effort[0] == 4
    assert m.joint("three").passive and not m.joint("one").passive
    check_same(m, there, names_of(there))
    lost = "\n".join(map(str, m.warnings))
    for what in ("curve", "asleep", "rope", "servo", "sensors"):
        assert what in lost
    assert "drive" not in lost and "band" not in lost


def test_loops_are_as_far_open_as_mujoco_has_them():
    there = compiled(TIED)
    m, data = convert.model_from_mujoco(there), mujoco().MjData(there)
    q, v, _, _ = random_states(m, STATES)
    residual = axode.loop_residual(m, q)
    for k in range(STATES):
        data.qpos[:], data.qvel[:] = convert.to_mujoco(m, q[k], v[k])
        mujoco().mj_forward(there, data)
        equalities = data.efc_type == mujoco().mjtConstraint.mjCNSTR_EQUALITY
        first = data.efc_pos[equalities & (data.efc_id == 0)]
        assert close(np.linalg.norm(residual[k, :3]), np.linalg.norm(first))
        second = data.efc_pos[equalities & (data.efc_id == 1)]
        assert close(np.linalg.norm(residual[k, 3:6]), np.linalg.norm(second))
        balance = data.efc_pos[equalities & (data.efc_id == 7)]
        assert close(np.abs(residual[k, -1]), np.abs(balance[0]))


def test_springs_between_sites_pull_as_tendons_do():
    text = TIED[:TIED.index("<equality>")] + "</mujoco>"
    there = compiled(text)
    m = convert.model_from_mujoco(there)
    assert len(m.to_dict()["spring"]) == 1
    check_same(m, there, names_of(there))


def test_a_file_is_loaded_by_its_root_element(tmp_path):
    mujoco()
    file = tmp_path / "everything.xml"
    file.write_text("<?xml version='1.0'?>\n<!-- <robot> -->\n" + EVERYTHING)
    m = axode.load(file, gravity=[0, 0, -1])
    assert m.nv == compiled(EVERYTHING).nv and m.gravity[2] == -1
    assert axode.check(file) == m.warnings
    assert all(warning.file == str(file) for warning in m.warnings)
    robot = tmp_path / "robot.xml"
    robot.write_text('<robot name="r"><link name="a"/></robot>')
    assert axode.load(robot).nv == 0
    text = axode.drawing(m)
    assert axode.drawing(axode.read_drawing(text)) == text


def test_what_mujoco_refuses_is_a_fault_with_its_line(tmp_path):
    mujoco()
    file = tmp_path / "bad.xml"
    file.write_text('<mujoco><worldbody><body>\n<joint type="hing"/></body></worldbody></mujoco>')
    with pytest.raises(axode.ModelError, match="invalid keyword: 'hing'") as error:
        axode.load(file)
    fault, = error.value.faults
    assert fault.line == 2 and fault.file == str(file) and "\n" not in fault.message
    assert axode.check(file) == [fault]


def test_mujoco_is_asked_for_where_it_is_missing(tmp_path, monkeypatch):
    file = tmp_path / "m.xml"
    file.write_text(EVERYTHING)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r"m.xml is MJCF, which needs MuJoCo: pip install mujoco"):
        axode.load(file)


def test_names_that_collide_are_changed_and_listed():
    there = compiled(f"""<mujoco><worldbody><body name="ground"><joint name="j"/>{MATTER}<site name="ground.j"/></body>
        <body name="a"><joint name="x"/><joint name="y"/>{MATTER}<site name="a.x"/></body></worldbody></mujoco>""")
    m = convert.model_from_mujoco(there)
    assert m.body_names == ["ground_2", "a.x_2", "a"]
    assert any('"ground" is called "ground_2"' in str(warning) for warning in m.warnings)


def test_the_inertia_of_what_has_no_mass_is_kept():
    there = compiled(f"""<mujoco><worldbody><body name="a"><joint axis="0 1 0"/>{MATTER}
        <body name="b"><inertial pos="0 0 0" mass="0" diaginertia="0.3 0.2 0.4"/></body></body></worldbody></mujoco>""")
    check_same(convert.model_from_mujoco(there), there, ["a", "b"])


# ---------------------------------------------------------------- MJCF out

ROBOTS = sorted(file.name for file in axode.robots.iterdir() if file.suffix in (".toml", ".urdf"))


@pytest.mark.parametrize("name", ROBOTS)
def test_mujoco_finds_the_same_in_what_we_write(name, base):
    mujoco()
    try:
        m = axode.load(axode.robots / name, base)
    except axode.ModelError:
        pytest.skip("no base to set free")
    try:
        with warnings.catch_warnings(record=True) as left_out:
            warnings.simplefilter("always")
            text = axode.mjcf(m)
    except axode.ModelError as error:
        refused = [fault for fault in error.faults if fault.severity == "error"]
        assert all(any(word in fault.message for word in ("helical", "no mass", "free and hangs")) for fault in refused), str(error)
        pytest.skip(str(refused[0]))
    if any("largest velocity" not in str(warning.message) for warning in left_out):
        pytest.skip(str(left_out[0].message))
    check_same(m, compiled(text), names_of(compiled(text)), least=1e-13)  # of moments that are 0
    back = convert.model_from_mujoco(compiled(text))
    check_same(back, compiled(text), names_of(compiled(text)))
    assert back.joint_names == m.joint_names and np.array_equal(back.effort_limits, m.effort_limits)


def every_joint():
    matter = {"mass": 2.0, "com": [0.1, 0.2, 0.3], "inertia": [1, 1.2, 0.9, 0.1, 0.02, -0.05]}
    turned = {"position": [0.3, -0.2, 0.1], "quaternion": [0.5, -0.5, 0.5, 0.5]}
    tilted = {"position": [0.2, 0.1, 0.4], "rpy": [0.3, -0.8, 1.1]}
    return axode.Model.from_bodies([
        {"name": "world", "joint": "fixed", "B": turned, **matter},
        {"name": "a", "on": "world", "B": tilted, **matter,
         "joint": {"kind": "cylindrical", "name": "c", "axis": [1, 2, 2], "point": [0.1, 0, 0],
                   "dof": [{"limits": [-1, 2], "damping": 3}, {"effort": 4, "friction": 0.5, "armature": 0.2}]}},
        {"name": "b", "on": "a", "B": turned, **matter,
         "joint": {"kind": "universal", "name": "u", "axis": "x", "second_axis": "z", "point": [0, 0.1, 0]}},
        {"name": "p", "on": "b", "B": tilted, **matter,
         "joint": {"kind": "planar", "name": "table", "axis": [0, 1, 1], "point": [0, 0, 0.2]}},
        {"name": "s", "on": "p", "B": turned, **matter,
         "joint": {"kind": "spherical", "name": "ball", "point": [0.1, 0.2, 0],
                   "dof": [{"spring": {"stiffness": 2}, "damping": 1}] * 3}},
        {"name": "f", "on": "a", "B": tilted, **matter,
         "joint": {"kind": "revolute", "name": "r", "axis": "y", "point": [0, 0, 0],
                   "spring": {"stiffness": 3, "rest": 0.2}}},
        {"name": "g", "on": "f", "B": turned, **matter,
         "joint": {"kind": "prismatic", "name": "follower", "axis": "x",
                   "follows": {"joint": "r", "ratio": -0.5, "offset": 0.1}}}],
        [{"name": "tool", "on": "s", "in": "body", **tilted}],
        springs=[{"between": ["tool", "ground"], "points": [[0.1, 0, 0], [1, 2, 3]], "in": "body", "stiffness": 5,
                  "rest": 0.3, "damping": 0.1}], name="every <joint> & \"more\"", gravity=[0, 1, -9])


def test_a_free_body_on_what_stands_still_is_written_on_the_world():
    matter = {"mass": 2.0, "com": [0.1, 0.2, 0.3], "inertia": [1, 1.2, 0.9]}
    post = {"position": [1, 2, 3], "quaternion": [0.5, -0.5, 0.5, 0.5]}
    bodies = [{"name": "base", "joint": "fixed", "B": post}, {"name": "post", "on": "base", "joint": "fixed", "B": post}]
    for name in ("one", "two"):
        bodies += [{"name": name, "on": "post", "joint": {"kind": "free", "name": name}, "B": post, **matter},
                   {"name": f"on {name}", "on": name, "joint": {"kind": "revolute", "name": f"j {name}", "axis": "x"},
                    "B": post, **matter}]
    m = axode.Model.from_bodies(bodies)
    check_same(m, compiled(axode.mjcf(m)), [])
    there = compiled(axode.mjcf(m))
    data = mujoco().MjData(there)
    data.qpos[:] = convert.to_mujoco(m, m.random(seed=3))[0]
    mujoco().mj_forward(there, data)
    for name in ("post", "one", "on two"):
        assert close(axode.poses(m, m.random(seed=3))[m.frame_index(name), :3, 3], data.body(name).xpos)
    with pytest.raises(axode.ModelError, match="is free and hangs on body"):
        axode.mjcf(axode.Model.from_bodies([*bodies, {"name": "rider", "on": "one", "joint": "free", **matter}]))


def test_every_joint_that_mjcf_has_is_written():
    m = every_joint()
    check_same(m, compiled(axode.mjcf(m)), [])
    back = convert.model_from_mujoco(compiled(axode.mjcf(m)))
    assert back.name == m.name
    assert [name for name in back.joint_names if "." not in name] == ["ball", "r", "follower"]
    assert back.joint("c.rotation").upper[0] == 2 and back.joint("c.translation").effort[0] == 4
    assert back.joint("follower").leader == ("r", -0.5, 0.1)
    assert close(axode.poses(back, convert.from_mujoco(back, convert.to_mujoco(m, m.random())[0])[0])[0], np.eye(4))


def test_what_mjcf_has_no_words_for_is_named():
    body = {"mass": 1.0, "com": [0, 0, 0], "inertia": [1, 1, 1]}
    point = {"point": [0, 0, 0]}
    m = axode.Model.from_bodies(
        [{"name": "a", "joint": {"kind": "helical", "name": "screw", "axis": "z", "pitch": 0.1, **point}, **body},
         {"name": "b", "on": "a", "joint": {"kind": "free", "name": "loose"}, **body},
         {"name": "c", "joint": {"kind": "revolute", "name": "stopped", "axis": "z", "limits": [-1, 1],
                                 "stop": {"stiffness": 5}, **point}, **body},
         {"name": "d", "on": "c", "joint": {"kind": "revolute", "name": "light", "axis": "x", **point}},
         {"name": "e", "on": "c", "joint": "fixed", **body, "inertia": [1, 1, 3]}])
    tied = axode.Model.from_bodies([{"name": "c", "joint": {"kind": "revolute", "axis": "z", **point}, **body}], loops=[
        {"name": "slot", "between": ["c", "ground"], "kind": "planar", "axis": "x", "point": [0, 0, 0]}])
    for model, strict, elements in [(m, False, ['joint "screw"', 'joint "loose"', 'joint "stopped"', 'body "d"', 'body "e"']),
                                    (tied, True, ['loop "slot"'])]:
        with pytest.raises(axode.ModelError) as error:
            axode.mjcf(model, strict=strict)
        assert [fault.element for fault in error.value.faults] == elements
    with pytest.warns(UserWarning, match='loop "slot": is planar; MJCF has no word for it, and it is left out'):
        assert "equality" not in axode.mjcf(tied)


def test_what_is_left_out_of_a_joint_is_named_and_the_rest_is_written():
    joints = {
        "hinge": {"kind": "revolute", "axis": "z", "point": [0, 0, 0], "limits": [-1, 2], "velocity": 3, "effort": 4, "damping": 5},
        "table": {"kind": "planar", "axis": "z", "point": [0, 0, 0],
                  "dof": [{"limits": [-1, 1], "damping": 2}, {"limits": [-3, 4], "armature": 5}, {"limits": [-6, 7], "armature": 5}]},
        "ball": {"kind": "spherical", "point": [0, 0, 0], "dof": [{"damping": 1, "friction": 2}, {"damping": 1}, {"damping": 1}]}}
    m = axode.Model.from_bodies([{"name": f"b{k}", "mass": 1.0, "com": [0, 0, 0], "inertia": [1, 1, 1], "joint": {"name": name, **joint}}
                                 for k, (name, joint) in enumerate(joints.items())])
    with warnings.catch_warnings(record=True) as left_out:
        warnings.simplefilter("always")
        back = convert.model_from_mujoco(compiled(axode.mjcf(m)))
    assert [str(w.message).split("joint ")[1] for w in left_out] == [
        '"hinge": has a largest velocity; MJCF has no word for it, and it is left out',
        *[f'"ball": has {what} in degrees of freedom that differ; MJCF has no word for it, and it is left out'
          for what in ("damping", "friction")]]
    for name, lower, upper in [("hinge", -1, 2), ("table.angle", -1, 1), ("table.x", -3, 4), ("table.y", -6, 7)]:
        assert (back.joint(name).lower[0], back.joint(name).upper[0]) == (lower, upper)
    assert back.joint("hinge").effort[0] == 4 and list(back.joint("hinge").velocity) == [np.inf]
    assert [back.to_dict()["body"][k]["joint"].get("damping") for k in (0, 3)] == [5, 2]


@pytest.mark.parametrize("name", [name for name in ROBOTS if "passive = true" in (axode.robots / name).read_text()])
def test_drives_come_back(name):
    m = axode.load(axode.robots / name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            back = convert.model_from_mujoco(compiled(axode.mjcf(m)))
        except axode.ModelError as error:
            pytest.skip(str(error.faults[0]))
    if back.n_loops == 0:
        pytest.skip("MJCF has none of its loops")
    if all(joint.passive for joint in m.joints):
        with pytest.warns(UserWarning, match="is passive, as all joints are"):
            axode.mjcf(m)
        return
    assert {joint.name: joint.passive for joint in back.joints} == {joint.name: joint.passive for joint in m.joints}
    q, _ = axode.assemble(m, m.neutral())
    there = convert.from_mujoco(back, convert.to_mujoco(m, q)[0])[0]
    rest, rest_there = np.zeros(m.nv), np.zeros(back.nv)
    forces = convert.to_mujoco(m, q, axode.inverse_dynamics(m, q, rest, rest))[1]
    assert close(convert.to_mujoco(back, there, axode.inverse_dynamics(back, there, rest_there, rest_there))[1], forces)


def cart_and_pole(cart_is_passive: bool) -> axode.Model:
    matter = {"mass": 1, "com": [0, 0, 0.2], "inertia": [0.1, 0.1, 0.1]}
    return axode.Model.from_bodies([
        {"name": "cart", "joint": {"kind": "prismatic", "axis": "x", "name": "slide", "passive": cart_is_passive},
         **matter},
        {"name": "pole", "on": "cart",
         "joint": {"kind": "revolute", "axis": "y", "point": [0, 0, 0], "name": "pin", "passive": True}, **matter}])


def test_passive_joints_of_trees_come_back_or_are_said():
    m = cart_and_pole(cart_is_passive=False)
    back = convert.model_from_mujoco(compiled(axode.mjcf(m)))
    assert {joint.name: joint.passive for joint in back.joints} == {"slide": False, "pin": True}
    with pytest.warns(UserWarning, match='joint "pin": is passive; URDF has no word for it'):
        axode.urdf(m)
    with pytest.raises(axode.ModelError, match='joint "pin": is passive'):
        axode.urdf(m, strict=True)
    with pytest.warns(UserWarning, match='joint "slide": is passive, as all joints are; MJCF has no word for it'):
        axode.mjcf(cart_and_pole(cart_is_passive=True))


def test_loops_are_written_as_points_that_meet():
    m = axode.load(axode.robots / "four_bar.toml")
    there = compiled(axode.mjcf(m))
    back = convert.model_from_mujoco(there)
    q, _ = axode.assemble(m, m.neutral())
    at = convert.from_mujoco(back, convert.to_mujoco(m, q)[0])[0]
    assert np.abs(axode.loop_residual(back, at)).max() < 1e-9
    far = at + 0.1 * np.arange(1, back.nq + 1)
    assert np.abs(axode.loop_residual(back, far)).max() > 1e-3
    assert axode.loop_mobility(back, at).degrees_of_freedom == axode.loop_mobility(m, q).degrees_of_freedom == 1
    assert [name for name in back.frame_names if "pin" in name] == ["pin.first", "pin.axis.first", "pin.second",
                                                                    "pin.axis.second"]
    assert axode.mjcf(back).count("<site") == axode.mjcf(m).count("<site")


# ---------------------------------------------------------------- shapes

#: The friction of collision shapes that have none of their own.
FRICTION = 0.6

SHAPES = [{"kind": "box", "size": [1, 2, 3], "name": "crate", "color": [1, 0.5, 0.25, 1], "position": [1, 2, 3],
           "rpy": [0.1, 0.2, 0.3]},
          {"kind": "sphere", "radius": 0.5, "role": "collision", "color": [0, 0, 0, 1]},
          {"kind": "cylinder", "radius": 0.5, "length": 2, "color": [0, 0, 0, 1]},
          {"kind": "capsule", "radius": 0.5, "length": 2, "role": "collision", "color": [0, 0, 0, 1]},
          {"kind": "ellipsoid", "semi_axes": [1, 2, 3], "color": [0, 0, 0, 1]},
          {"kind": "mesh", "file": "tetrahedron.stl", "scale": [2, 1, 1], "position": [1, 2, 3], "color": [0, 0, 0, 1]}]


def tetrahedron(file):
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for k in face for x in corners[k]), 0) for face in faces)
    file.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + triangles)


def with_shapes(shapes):
    return axode.Model.from_dict({
        "format": "axode drawing 1", "shape": shapes,
        "body": [{"name": "b", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1,
                  "com": [0, 0, 0], "inertia": [1, 1, 1], "shape": shapes}]})


def assert_same_shapes(one, other):
    def rows(m):
        d = m.to_dict()
        return [*d.get("shape", []), *d["body"][0]["shape"]]
    assert len(rows(one)) == len(rows(other))
    for x, y in zip(rows(one), rows(other)):
        assert x.keys() - {"name", "rotation", "friction"} == y.keys() - {"name", "rotation", "friction"}
        assert x.get("friction", FRICTION) == y.get("friction", FRICTION)
        for key, value in x.items():
            if key in ("kind", "role", "file"):
                assert y[key] == value
            elif key not in ("name", "friction"):
                assert close(y.get(key, np.eye(3)), value, 1e-12)


def test_shapes_come_back(tmp_path):
    m = with_shapes(SHAPES)
    assert_same_shapes(m, axode.read_drawing(axode.drawing(m)))
    in_urdf = with_shapes([shape for shape in SHAPES if shape["kind"] != "ellipsoid"])
    assert_same_shapes(in_urdf, axode.read_urdf(axode.urdf(in_urdf)))
    mujoco()
    tetrahedron(tmp_path / "tetrahedron.stl")
    (tmp_path / "m.xml").write_text(axode.mjcf(m))
    assert_same_shapes(m, axode.load("m.xml"))


def test_planes_and_friction_of_geoms_are_read():
    there = compiled('<mujoco><worldbody><geom type="plane" size="0 0 1" zaxis="0 1 0" friction="0.8"/>'
                     '<body name="b"><freejoint/><geom size="0.1" friction="0.5 0.02 0.01" condim="4"/></body></worldbody></mujoco>')
    m = convert.model_from_mujoco(there).to_dict()
    plane, ball = m["shape"][-1], m["body"][0]["shape"][-1]
    assert (plane["kind"], plane["role"], plane["friction"]) == ("plane", "collision", 0.8)
    assert close(np.array(plane["rotation"])[:, 2], [0, 1, 0])
    assert (ball["friction"], ball["spin_friction"], ball.get("rolling_friction", 0)) == (0.5, 0.02, 0)


def test_what_touches_and_is_seen_is_both():
    there = compiled('<mujoco><worldbody><body name="b"><freejoint/><geom name="g" size="0.1"/>'
                     '<geom name="h" size="0.1" contype="0" conaffinity="0"/><geom name="i" size="0.1" group="3"/>'
                     '</body></worldbody></mujoco>')
    shapes = convert.model_from_mujoco(there).to_dict()["body"][0]["shape"]
    assert [(shape["name"], shape["role"]) for shape in shapes] == [("g", "visual"), ("g", "collision"),
                                                                    ("h", "visual"), ("i", "collision")]


# ---------------------------------------------------------------- SDFormat and xacro

def test_sdf_is_loaded_by_its_ending_and_its_root_element(tmp_path):
    text = ('<sdf version="1.9"><model name="m"><link name="a"/><link name="b"/><joint name="j" type="revolute">'
            '<parent>a</parent><child>b</child><axis/></joint></model></sdf>')
    for name in ("m.sdf", "m.world", "m.xml", "m"):
        (tmp_path / name).write_text(text)
        assert axode.load(tmp_path / name).joint_names == ["free_base", "j"]
        assert axode.load(tmp_path / name, "fixed").joint_names == ["j"]
    assert axode.read_sdf(text, "free").nv == 7


XACRO = """<?xml version="1.0"?>
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="length" value="0.5"/>
  <xacro:macro name="link" params="name"><link name="${name}"><inertial><origin xyz="${length} 0 0"/><mass value="1"/>
    <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></xacro:macro>
  <xacro:link name="a"/>
  <xacro:link name="b"/>
  <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
</robot>"""


def test_xacro_is_expanded(tmp_path):
    pytest.importorskip("xacro")
    file = tmp_path / "r.urdf.xacro"
    file.write_text(XACRO)
    m = axode.load(file)
    assert m.joint_names == ["j"] and close(axode.center_of_mass(m, [0.0]), [0.5, 0, 0])
    assert axode.load(file, "free", gravity=[0, 0, 1]).nv == 7
    assert axode.check(file) == m.warnings
    file.write_text(XACRO.replace("${length}", "${width}"))
    with pytest.raises(axode.ModelError, match="xacro does not expand it: .*width"):
        axode.load(file)
    file.write_text(XACRO.replace('<child link="b"/>', '<child link="c"/>'))
    with pytest.raises(axode.ModelError, match='its child is link "c"'):
        axode.load(file)


def test_xacro_is_asked_for_where_it_is_missing(tmp_path, monkeypatch):
    file = tmp_path / "r.xacro"
    file.write_text(XACRO)
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(ImportError, match=r"is a xacro file, which needs xacro: pip install xacro"):
        axode.load(file)
