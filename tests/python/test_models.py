"""Mechanisms from files, from Python, from pickles; their names and configurations."""

import copy
import pickle
import tomllib

import axode
import numpy as np
import pytest
from mechanisms import MECHANISMS, close, random_states

EVERYWHERE = pytest.mark.parametrize("mechanism", MECHANISMS)


def same_dynamics(m, n, exactly=True):
    q, v, a, _ = random_states(m, 5)
    x, y = (axode.inverse_dynamics(model, q, v, a) for model in (m, n))
    return np.array_equal(x, y) if exactly else close(x, y)


def same_names(m, n):
    return all(getattr(m, what) == getattr(n, what)
               for what in ("name", "nq", "nv", "body_names", "joint_names", "frame_names", "warnings"))


@EVERYWHERE
@pytest.mark.parametrize("twin", [lambda m: pickle.loads(pickle.dumps(m)), copy.deepcopy, copy.copy])
def test_pickles_and_copies_are_the_same_to_the_last_bit(mechanism, twin):
    m = MECHANISMS[mechanism]
    n = twin(m)
    assert n is not m and same_names(m, n) and same_dynamics(m, n)
    assert np.array_equal(m.gravity, n.gravity) and np.array_equal(np.array(m.limits()), np.array(n.limits()))


def test_pickles_keep_warnings_with_their_lines(tmp_path):
    file = tmp_path / "doubtful.urdf"
    file.write_text('<robot name="r"><link name="a"/>\n<link name="b"><inertial><mass value="1"/>'
                    '<inertia ixx="1" iyy="1" izz="9" ixy="0" ixz="0" iyz="0"/></inertial></link>\n'
                    '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>')
    m = axode.load(file)
    assert [fault.rule for fault in m.warnings] == ["inertia_not_realisable"] and m.warnings[0].line == 2
    assert str(m.warnings[0]).startswith(f"{file}:2: warning: body \"b\"")
    assert pickle.loads(pickle.dumps(m)).warnings == m.warnings


def test_what_never_changes_is_its_own_copy_and_says_what_to_pickle_instead():
    m = axode.load(axode.robots / "double_pendulum.toml")
    motion = axode.simulate(m, [1, 0], [0, 0], until=0.1)
    for it, instead in [(motion, "its arrays"), (m.joint("pin"), "the Model"), (m.body("upper rod"), "the Model")]:
        assert copy.copy(it) is it and copy.deepcopy([it])[0] is it
        with pytest.raises(TypeError, match=f"a {type(it).__name__} cannot be pickled; pickle {instead}"):
            pickle.dumps(it)


def test_a_pickle_of_something_else_is_refused():
    for state in ((), (1, 2), ("x",) * 6):
        with pytest.raises((ValueError, RuntimeError, TypeError)):
            axode.Model.__new__(axode.Model).__setstate__(state)


@EVERYWHERE
def test_a_dict_and_a_text_of_the_drawing_make_the_same_mechanism(mechanism):
    m = MECHANISMS[mechanism]
    from_dict, from_text = axode.Model.from_dict(m.to_dict()), axode.read_drawing(axode.drawing(m))
    assert same_names(from_dict, from_text) and same_dynamics(from_dict, from_text)
    assert same_dynamics(m, from_dict, exactly=False)
    assert m.to_dict() == tomllib.loads(axode.drawing(m))


def same_mass_matrix(m, n, tolerance):
    q = np.array([m.random(seed) for seed in range(3)])
    x, y = axode.mass_matrix(m, q), axode.mass_matrix(n, q)
    return np.abs(x - y).max() <= tolerance * np.abs(x).max()


def test_a_robot_is_the_same_from_its_dict_its_drawing_and_its_urdf(robot, base):
    m = axode.load(robot, base)
    twins = axode.Model.from_dict(m.to_dict()), axode.read_drawing(axode.drawing(m)), axode.read_urdf(axode.urdf(m))
    for n in twins:
        assert m.joint_names == n.joint_names and set(m.frame_names) <= set(n.frame_names)
        assert same_mass_matrix(m, n, 1e-13)
    q, v, a, _ = random_states(m, 3)
    tau = axode.inverse_dynamics(m, q, v, a)
    for n in twins:
        assert np.abs(axode.inverse_dynamics(n, q, v, a) - tau).max() <= 1e-13 * np.abs(tau).max()


DOUBTFUL = {"name": "plate", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1,
            "com": [1, 0, 0], "inertia": [1, 1, 3]}


def test_doubts_are_warnings_and_errors_with_strict(tmp_path):
    m = axode.Model.from_bodies([DOUBTFUL])
    assert [fault.rule for fault in m.warnings] == ["inertia_not_realisable"]
    drawing, urdf = tmp_path / "plate.toml", tmp_path / "plate.urdf"
    drawing.write_text(axode.drawing(m))
    urdf.write_text(axode.urdf(m))
    ways = [lambda **strict: axode.load(drawing, **strict), lambda **strict: axode.load(urdf, **strict),
            lambda **strict: axode.read_drawing(axode.drawing(m), **strict),
            lambda **strict: axode.read_urdf(axode.urdf(m), **strict),
            lambda **strict: axode.Model.from_dict(m.to_dict(), **strict),
            lambda **strict: axode.Model.from_bodies([DOUBTFUL], **strict),
            lambda **strict: axode.Builder().body(**DOUBTFUL).build(**strict)]
    for way in ways:
        assert [fault.severity for fault in way().warnings] == ["warning"]
        with pytest.raises(axode.ModelError, match="no density can produce its inertia"):
            way(strict=True)
    for file in (drawing, urdf):
        assert [fault.severity for fault in axode.check(file)] == ["warning"]
        assert [fault.severity for fault in axode.check(file, strict=True)] == ["error"]
    assert axode.check(drawing, "free")[0].rule == "no_base"


def test_the_frame_of_a_body_is_where_it_is_asked_for():
    body = {key: value for key, value in DOUBTFUL.items() if key != "joint"} | {"com": [3, 0, 0]}
    joint = {"kind": "revolute", "axis": "z", "point": [2, 0, 0]}
    origins = {"joint": [2, 0, 0], "com": [3, 0, 0]}
    drawn = axode.Builder().body(joint=joint, **body).build()
    assert np.array_equal(axode.poses(drawn, [0])[1], np.eye(4))
    for frame, origin in origins.items():
        m = axode.Builder().body(joint=joint, frame=frame, **body).build()
        assert np.array_equal(axode.poses(m, [0])[1, :3, 3], origin)
        assert np.array_equal(axode.poses(axode.Model.from_dict(m.to_dict()), [0.3]), axode.poses(m, [0.3]))
        assert same_dynamics(drawn, m, exactly=False)
    with pytest.raises(axode.ModelError, match='key "parent" is not known; it is called "on" here'):
        axode.Builder().body(joint=joint, parent="ground", **body).build()


def test_names_of_other_libraries_are_told_what_they_are_called_here():
    told = {"crba": "it is called 'mass_matrix' here", "gravity_vector": "it is called 'gravity_torques' here",
            "mass_matrx": "did you mean 'mass_matrix'?", "zzz": "no attribute 'zzz'$"}
    for name, says in told.items():
        with pytest.raises(AttributeError, match=says):
            getattr(axode, name)


@pytest.mark.parametrize("file", ["arm7.toml", "machine.toml", "double_pendulum.toml"])
def test_a_drawing_read_by_tomllib_is_the_same_mechanism(file):
    drawing = tomllib.loads((axode.robots / file).read_text())
    m, n = axode.load(axode.robots / file), axode.Model.from_dict(drawing)
    assert same_names(m, n) and same_dynamics(m, n)


def test_the_builder_makes_what_from_bodies_makes():
    drawing = tomllib.loads((axode.robots / "machine.toml").read_text())
    builder = axode.Builder(drawing["name"], drawing.get("gravity", (0, 0, -9.81)))
    for body in drawing["body"]:
        builder.body(**{"on": "ground"} | body)
    for frame in drawing.get("frame", []):
        builder.frame(**{{"in": "in_"}.get(key, key): value for key, value in frame.items()})
    assert same_names(builder.build(), MECHANISMS["machine"]) and same_dynamics(builder.build(), MECHANISMS["machine"])


def test_numpy_numbers_and_arrays_describe_a_body():
    plain = {"name": "rod", "joint": {"kind": "revolute", "axis": [0, 1, 0], "point": [0, 0, 2]}, "mass": 1,
             "com": [0, 0, 1], "inertia": [1, 1, 0.5]}
    typed = {"name": "rod",
             "joint": {"kind": "revolute", "axis": np.array([0, 1, 0]), "point": (0.0, np.float32(0), 2)},
             "mass": np.int64(1), "com": np.array([0, 0, 1.0]), "inertia": np.diag([1, 1, 0.5])}
    assert same_dynamics(*(axode.Model.from_bodies([body]) for body in (plain, typed)))


def test_every_fault_of_a_mechanism_is_listed():
    with pytest.raises(axode.ModelError) as caught:
        axode.Model.from_bodies([
            {"name": "a", "joint": {"kind": "revolute", "axis": [0, 0, 0], "point": [0, 0, 0]}, "mass": -1,
             "com": [0, 0, 0], "inertia": [1, 1, 1]},
            {"name": "b", "on": "nobody", "joint": "free"},
            {"name": "a", "on": "a", "joint": {"kind": "prismatic", "axis": "z"}, "mass": 1, "com": [0, 0, np.nan],
             "inertia": [1, 1, 9]}])
    rules = {fault.rule for fault in caught.value.faults}
    assert {"zero_axis", "mass_not_positive", "unknown_predecessor", "two_predecessors"} <= rules
    assert "non_finite_number" in rules
    assert isinstance(caught.value, ValueError)
    for fault in caught.value.faults:
        assert fault.message in str(caught.value) and fault.element in str(caught.value)
    assert pickle.loads(pickle.dumps(caught.value)).faults == caught.value.faults


def test_every_fault_of_a_joint_of_an_unknown_kind_is_listed():
    with pytest.raises(axode.ModelError) as caught:
        axode.Model.from_bodies([{"name": "a", "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1], "joint": {
            "kind": "revolte", "axis": "q", "point": [0, 0], "limits": [1, 2, 3], "damping": "x", "passive": "yes"}}])
    told = [fault.message for fault in caught.value.faults]
    for word in ("kind is", "axis is", "point is", "limits is", "damping is", "passive is"):
        assert sum(message.startswith(word) for message in told) == 1, word
    with pytest.raises(axode.ModelError) as caught:
        axode.read_urdf("""<robot name="r"><link name="a"/><link name="b"/>
            <joint name="j" type="revolut"><parent link="a"/><child link="b"/><axis xyz="0 0"/>
            <limit effort="x" velocity="1"/><dynamics damping="y"/></joint></robot>""")
    told = [fault.message for fault in caught.value.faults]
    for word in ("type is", "<axis> xyz is", "<limit> effort:", "<dynamics> damping:"):
        assert sum(message.startswith(word) for message in told) == 1, word


@pytest.mark.parametrize("body", [5, "rod", None, [], {"name": 3}, {"name": "rod", 7: 1},
                                  {"name": "rod", "joint": {1, 2}}, {"name": "rod", "joint": "free", "com": object()},
                                  {"name": "rod\0", "joint": "free"},
                                  {"name": "\ud800", "joint": "free"}])
def test_what_is_no_body_is_refused(body):
    with pytest.raises((axode.ModelError, TypeError, ValueError)):
        axode.Model.from_bodies([body])


def test_bodies_that_hold_themselves_are_refused():
    body = {"name": "rod", "joint": "free"}
    body["mesh"] = [body]
    with pytest.raises(ValueError, match="nested too deeply"):
        axode.Model.from_bodies([body])


@pytest.mark.parametrize("joint", [5, None, ["revolute"], {"kind": 3}, {"axis": "z"}, "revolve"])
def test_the_builder_refuses_what_is_no_joint_with_the_faults(joint):
    builder = axode.Builder("x").body("a", joint=joint)
    with pytest.raises((axode.ModelError, TypeError), match="joint"):
        builder.build()
    with pytest.raises(axode.ModelError, match="frame is 5"):
        axode.Model.from_bodies([], frames=5)


def test_faults_of_files_have_their_lines(tmp_path):
    file = tmp_path / "bad.toml"
    file.write_text('format = "axode drawing 1"\n[[body]]\nname = "a"\njoint = "fre"\nmass = "x"\n')
    with pytest.raises(axode.ModelError) as caught:
        axode.load(file)
    assert {fault.line for fault in caught.value.faults} >= {4, 5}
    assert axode.check(file) == caught.value.faults
    with pytest.raises(axode.ModelError, match="cannot be read"):
        axode.load(tmp_path / "none.urdf")
    with pytest.raises(axode.ModelError):
        axode.read_drawing("format = ")
    with pytest.raises(axode.ModelError):
        axode.read_urdf("<robot")


def test_the_base_is_as_asked_for():
    free, fixed = (axode.load(axode.robots / "humanoid.urdf", base=base) for base in ("free", "fixed"))
    assert free.nv == fixed.nv + 6 and free.joint_names[0] == "free_base"
    assert axode.load(axode.robots / "humanoid.urdf").nv == fixed.nv
    assert axode.load(str(axode.robots / "humanoid.urdf")).nv == fixed.nv
    assert axode.Model.from_dict(free.to_dict(), base="fixed").nv == fixed.nv
    with pytest.raises(ValueError, match="base is 'floating'; expected one of 'fixed', 'free'"):
        axode.load(axode.robots / "humanoid.urdf", base="floating")


def test_what_a_urdf_cannot_say_is_named():
    with pytest.raises(axode.ModelError, match="helical"):
        axode.urdf(MECHANISMS["machine"])


@EVERYWHERE
def test_names_are_of_bodies_joints_and_frames_in_order(mechanism):
    m = MECHANISMS[mechanism]
    assert len(m.body_names) == len(m.joint_names) == m.n_bodies and len(m.frame_names) == m.n_frames
    assert m.frame_names[0] == "ground" and m.frame_names[1:1 + m.n_bodies] == m.body_names
    q, v = np.zeros(m.nq), np.zeros(m.nv)
    for name in m.joint_names:
        joint = m.joint(name)
        assert joint.name == name and len(q[joint.q]) == joint.nq and len(v[joint.v]) == joint.nv
        assert (joint.nq == 0) == (joint.leader is not None)
        q[joint.q] += 1
        v[joint.v] += 1
        assert len(joint.lower) == len(joint.upper) == len(joint.armature)
    assert (q == 1).all() and (v == 1).all()
    for name in m.body_names:
        body = m.body(name)
        assert body.predecessor in ["ground", *m.body_names]
        assert close(axode.poses(m, m.neutral())[m.frame_names.index(name)], body.A)
    assert sum(m.body(name).mass for name in m.body_names) == pytest.approx(m.total_mass)
    for name in m.frame_names:
        body, pose = m.frame_pose(name)
        C = axode.poses(m, m.random(1))
        assert close(C[m.frame_names.index(body)] @ pose, C[m.frame_names.index(name)])


@EVERYWHERE
def test_what_is_printed_names_the_mechanism_and_its_joints(mechanism):
    m = MECHANISMS[mechanism]
    assert f'"{m.name}"' in repr(m) and f"nq = {m.nq}" in repr(m) and f"nv = {m.nv}" in repr(m)
    assert "\n" not in repr(m)
    assert len(str(m).splitlines()) == m.n_bodies + 2
    assert all(name in str(m) and body in str(m) for name, body in zip(m.joint_names, m.body_names))
    assert m.joint_names[0] in repr(m.joint(m.joint_names[0])) and m.body_names[0] in repr(m.body(m.body_names[0]))


def test_models_cannot_be_changed():
    m = MECHANISMS["arm"]
    for attribute in ("nq", "gravity", "body_names"):
        with pytest.raises(AttributeError):
            setattr(m, attribute, 3)
    m.gravity[2] = 5
    m.body("link 1").M[:] = 0
    assert m.gravity[2] == -9.81 and m.body("link 1").M[3, 3] > 0


def test_parts_outlive_their_model():
    joint, body = (lambda m: (m.joint("A2"), m.body("link 2")))(axode.load(axode.robots / "arm7.toml"))
    assert joint.name == "A2" and body.name == "link 2"


@EVERYWHERE
def test_names_and_limits_go_with_every_number(mechanism):
    m = MECHANISMS[mechanism]
    assert len(m.coordinate_names) == m.nq and len(m.velocity_names) == m.nv
    assert [joint.name for joint in m.joints] == m.joint_names
    speed, effort = np.full(m.nv, np.nan), np.full(m.nv, np.nan)
    for joint in m.joints:
        names = m.velocity_names[joint.v]
        assert all(name.partition("[")[0] == joint.name for name in names + m.coordinate_names[joint.q])
        assert names == [joint.name] or joint.nv != 1
        if joint.nv:
            speed[joint.v], effort[joint.v] = joint.velocity, joint.effort
    assert np.array_equal(m.velocity_limits, speed) and np.array_equal(m.effort_limits, effort)


def test_gravity_is_that_of_the_file_or_the_one_given():
    file = axode.robots / "arm7.toml"
    m = axode.load(file, gravity=[0, 0, -1.62])
    assert np.array_equal(m.gravity, [0, 0, -1.62])
    assert same_dynamics(m, axode.load(file).with_gravity([0, 0, -1.62]))
    for wrong in (lambda: axode.load(file, gravity=-1.62), lambda: m.with_gravity([0, -1.62])):
        with pytest.raises(ValueError, match=r"^gravity: expected shape \(3,\), m/s\^2"):
            wrong()


# --------------------------------------------------------- configurations and edits, whose laws are C++ tests


@EVERYWHERE
def test_maps_of_configurations_are_each_other_s_way_back(mechanism):
    m = MECHANISMS[mechanism]
    q, dv, _, _ = random_states(m, 30)
    assert close(m.difference(q, m.integrate(q, dv)), dv)
    assert close(m.difference(q[0], m.interpolate(q[0], m.integrate(q[0], dv[0]), 0.25)), dv[0] / 4)
    rates = m.coordinate_rates(q, dv)
    assert close(m.velocities_from_rates(q, rates), dv)
    assert close((m.integrate(q, 1e-6 * dv) - m.integrate(q, -1e-6 * dv)) / 2e-6, rates, 1e-8)
    many, (lower, upper) = m.random(5, n=20), m.limits()
    assert np.array_equal(many[0], m.random(5)) and not np.array_equal(m.random(5), m.random(6))
    assert m.random(5, n=0).shape == (0, m.nq) and (np.abs(np.diff(many, axis=0)).max(axis=0) > 0).all()
    assert (lower <= many).all() and (many <= upper).all() and close(m.clamp(many), many)
    longer = q.copy()
    for joint in m.joints:
        longer[:, joint.q][:, :4] *= 3 if joint.kind in ("free", "spherical") else 1
    assert close(m.normalize(longer), q)
    for call, name in [(lambda: m.difference(q[0, :-1], q[0]), "q0"), (lambda: m.difference(q[0], q[0, :-1]), "q1"),
                       (lambda: m.integrate(q[0], dv[0, :-1]), "dv"), (lambda: m.velocities_from_rates(q, rates[:, 1:]), "dq")]:
        with pytest.raises(ValueError, match=f"^{name}: expected shape"):
            call()


def test_quaternions_of_no_length_are_not_normalised():
    m = MECHANISMS["humanoid"]
    with pytest.raises(ValueError, match='the quaternion of joint "free_base" has norm 0'):
        m.normalize(m.random(2, n=3) * np.where(np.arange(m.nq) < 4, 0, 1))


@EVERYWHERE
def test_parameters_are_those_of_the_bodies_in_order(mechanism):
    m = MECHANISMS[mechanism]
    pi = m.parameters * np.random.default_rng(1).uniform(0.9, 1.1, len(m.parameters))
    n = m.with_parameters(pi)
    assert close(n.parameters, pi) and n.frame_names == m.frame_names
    assert len(m.parameter_names) == len(pi) and m.parameter_names[9] == m.body_names[0] + " Iyz"
    assert close([n.body(name).mass for name in n.body_names], pi[::10])
    twin = pickle.loads(pickle.dumps(n))
    assert np.array_equal(twin.parameters, n.parameters) and same_dynamics(twin, n)
    with pytest.raises(ValueError, match=rf"^pi: expected shape \({len(pi)},\), ten numbers for each body"):
        m.with_parameters(pi[1:])
    with pytest.raises(axode.ModelError, match="a mass must be positive"):
        m.with_parameters(-pi)


def test_edits_make_models_with_the_names_of_their_parts():
    arm, hand, humanoid = MECHANISMS["arm"], MECHANISMS["machine"], MECHANISMS["humanoid"]
    q = arm.random(1)
    assert arm.reduced(["A6", "A7"], q).joint_names == arm.joint_names[:5]
    M = axode.lie.transform_inertia(axode.lie.exp([0.1, 0.2, 0.3, 0.1, 0, 0.05]), axode.lie.box_inertia(3, [0.1, 0.2, 0.3]))
    loaded = arm.with_payload("flange", M, name="box")
    assert "box" in loaded.frame_names and loaded.total_mass == pytest.approx(arm.total_mass + 3)
    both = arm.append("flange", hand, prefix="hand ")
    assert both.coordinate_names[arm.nq:] == ["hand " + name for name in hand.coordinate_names]
    mount = axode.poses(arm, q)[arm.frame_index("flange")]
    poses = axode.poses(both, np.concatenate([q, hand.random(2)]))
    for frame, pose in zip(hand.frame_names[1:], axode.poses(hand, hand.random(2))[1:]):
        assert close(poses[both.frame_index("hand " + frame)], mount @ pose)
    mounted = arm.append("flange", hand, "hand ", {"kind": "revolute", "axis": "z", "point": [0.1, 0, 0], "limits": [-1, 2],
                                                   "follows": {"joint": "A1", "ratio": 2}})
    assert mounted.joint("hand mount").upper[0] == 2 and mounted.joint("hand mount").leader == ("A1", 2, 0)
    assert arm.append("ground", arm, "second ", joint="free").joint_names[-8] == "second mount"
    rerooted = humanoid.rerooted(humanoid.body_names[-1])
    assert rerooted.body_names[0] == humanoid.body_names[-1]
    assert sorted(rerooted.joint_names) == sorted(humanoid.joint_names)
    q, v, _, _ = (x[0] for x in random_states(humanoid, 1))
    order = [humanoid.frame_index(name) for name in ["ground", *rerooted.body_names]]
    there = axode.joint_state(rerooted, axode.poses(humanoid, q)[order], axode.twists(humanoid, q, v)[order])
    assert there.position_residual < 1e-9 and there.velocity_residual < 1e-9
    assert close(axode.kinetic_energy(rerooted, there.q, there.v), axode.kinetic_energy(humanoid, q, v))
    pendulum = axode.load(axode.robots / "double_pendulum.toml")
    for error, sentence, call in [
            (axode.ModelError, 'body "box": the name is taken', lambda: loaded.with_payload("flange", M, name="box")),
            (KeyError, 'did you mean "flange"', lambda: arm.with_payload("flang", M)),
            (ValueError, r"^M: expected shape \(6, 6\)", lambda: arm.with_payload("flange", M[0])),
            (ValueError, '^append: both models have "base", "base_joint", "link 1", .*; give a prefix', lambda: arm.append("flange", arm)),
            (axode.ModelError, "axis", lambda: arm.append("flange", hand, "hand ", {"kind": "revolute"})),
            (axode.ModelError, 'follows joint "A9"', lambda: arm.append(
                "flange", hand, "hand ", {"kind": "prismatic", "axis": "z", "follows": {"joint": "A9"}})),
            (ValueError, "is revolute; only a root that is fixed or free", lambda: pendulum.rerooted(pendulum.body_names[-1]))]:
        with pytest.raises(error, match=sentence):
            call()
