"""Robots and worlds that others wrote: every file that their packages ship is read as MuJoCo and Pinocchio read it, and converted.

The tests compare the poses of all bodies that both know and the mass matrix in random states; for MJCF the bias
forces too. A file may be refused only if the other reader refuses it too, or if `REFUSED` names it. `pytest -rs` says
why a comparison was left out.
"""

import sys
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import axode
import numpy as np
import pytest
from axode import convert

mujoco = pytest.importorskip("mujoco")
pin = pytest.importorskip("pinocchio")
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "peers"))

from mujoco_robot import without_geometry  # noqa: E402

STATES = 2
PACKAGES = ["dm-control", "gymnasium", "pybullet", "example-robot-data", "icub-models", "gym-ignition-models"]
#: A few of a thousand similar files, each with an object of one link.
ONE_OF_MANY = "pybullet_data/random_urdfs/"
MANY = ("050", "450", "850")

#: Files that others read and axode does not or only in part, by the end of their paths.
REFUSED = {
    "ur_description/urdf/ur3.urdf": "no attribute name",  # MuJoCo reads a robot without links in it
    "pybullet_data/torus_deform.urdf": "has no <link>",  # a soft body
}
#: Messages with which MuJoCo refuses a URDF, or a file that axode writes, although axode accepts it.
MUJOCO_REFUSES = ["inertia must satisfy", "positive eigenvalues", "must be larger than mjMINVAL", "repeated element"]
#: Messages for models that MJCF or URDF cannot express.
NO_WORDS = ["no density can produce", "moves and has no mass", "armature", "gravity: is", "ellipsoid", "has a spring",
            "is spherical", "is free and hangs", "is passive", "closes", "loop", "several degrees of freedom", "coupl",
            "is helical", "follows", "elastic", "URDF has no", "URDF has none", "MJCF has no word"]


def sample():
    """(name, file) of each: the files of a package that end as a mechanism's do, but for parts of others."""
    for package in PACKAGES:
        try:
            files = distribution(package).files or []
        except PackageNotFoundError:
            continue
        for entry in sorted(files, key=str):
            file = Path(str(entry.locate()))
            many = ONE_OF_MANY in str(entry) and file.stem not in MANY
            if file.suffix in (".urdf", ".sdf", ".world", ".xml") and not many and root_of(file):
                yield f"{package}:{'/'.join(file.parts[-3:])}", file


def root_of(file):
    """The root element of a file if that describes a mechanism; otherwise nothing."""
    text = file.read_text(errors="replace")
    return next((root for root in ("<robot", "<mujoco", "<sdf") if root in text), None)


SAMPLE = dict(sample())
FILES = [pytest.param(file, id=name) for name, file in SAMPLE.items()] or [
    pytest.param(None, id="none", marks=pytest.mark.skip(reason="none of the packages of the sample is installed"))]


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    """Runs the test in a folder of its own, because MuJoCo writes warnings to a file in the working folder."""
    monkeypatch.chdir(tmp_path)


def assert_close(ours, theirs, what, bound=1e-9):
    size = max(np.abs(theirs).max(initial=0), 1e-300)
    error = np.abs(np.subtract(ours, theirs)).max(initial=0)
    assert error <= bound * size, f"{what} differ by {error} in {size}"


def states(m):
    return [m.random(seed=k) for k in range(STATES)]


@lru_cache(maxsize=4)
def loaded(file, base=None):
    """The model, or the error that says why there is none."""
    try:
        return axode.load(file, base)
    except axode.ModelError as error:
        return error


def model(file, base=None):
    m = loaded(file, base)
    if isinstance(m, axode.ModelError):
        pytest.skip(f"{m.faults[0].rule}: {m.faults[0].message}")
    return m


def compiled(text):
    """MuJoCo's model of a file. Skips the test if MuJoCo refuses inertias that axode accepts."""
    try:
        return mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        if any(reason in str(error) for reason in MUJOCO_REFUSES):
            pytest.skip(f"MuJoCo refuses it: {str(error).splitlines()[0]}")
        raise


def written(write, m):
    """The file that a writer makes from a model. Skips the test if the format cannot express all of it."""
    try:
        return write(m, strict=True)
    except axode.ModelError as error:
        unknown = [fault for fault in error.faults if not any(words in fault.message or words in str(fault) for words in NO_WORDS)]
        assert not unknown, str(unknown[0])
        pytest.skip(f"{len(error.faults)} faults: {error.faults[0].message}")


def without_shapes(m):
    """Meshes are looked for beside the file."""
    drawing = m.to_dict()
    drawing.pop("shape", None)
    for body in drawing.get("body", []):
        body.pop("shape", None)
    return axode.Model.from_dict(drawing)


def common_frames(m, theirs):
    """(key, our frame) of the frames that both have, from pairs (key, name in the other library), where a link called
    `ground` is not the inertial frame."""
    known = {name: k for k, name in enumerate(m.frame_names)}
    known["ground"] = known.get("ground_2", known["ground"])
    known["root of the robot"] = known.get("world")  # as `without_geometry` calls it
    return [(key, known[name]) for key, name in theirs if known.get(name) is not None]


def check_with_mujoco(m, there, bias=False):
    data = mujoco.MjData(there)
    pairs = common_frames(m, [(i, there.body(i).name or f"body {i}") for i in range(1, there.nbody)])
    assert len(pairs) >= min(m.n_bodies, 1)
    for q in states(m):
        v = np.random.default_rng(3).uniform(-1, 1, m.nv)
        data.qpos[:], data.qvel[:] = convert.to_mujoco(m, q, v)
        mujoco.mj_forward(there, data)
        C = axode.poses(m, q)
        for i, k in pairs:
            assert_close(C[k, :3], np.column_stack([data.xmat[i].reshape(3, 3), data.xpos[i]]), f"poses of {there.body(i).name}")
        theirs = np.zeros((there.nv, there.nv))
        for column, unit in zip(theirs, np.eye(there.nv)):
            mujoco.mj_mulM(there, data, column, unit)
        P = convert.to_mujoco(m, np.tile(q, (m.nv, 1)), np.eye(m.nv))[1].T
        assert_close(axode.mass_matrix(m, q), P.T @ theirs @ P, "mass matrices")
        if bias:
            ours = axode.coriolis_vector(m, q, v) + axode.gravity_torques(m, q)
            assert_close(ours, P.T @ (data.qfrc_bias + theirs @ rate_of_free_joints(m, q, v)), "bias forces")


def rate_of_free_joints(m, q, v):
    """The rate P' of the velocity map times v. It is R (w x v) for free joints, whose linear velocities have other
    axes in the other library."""
    rate = np.zeros(m.nv)
    for joint in m.joints:
        if joint.kind == "free":
            rate[joint.v] = np.concatenate([np.zeros(3), np.cross(v[joint.v][:3], v[joint.v][3:])])
    return convert.to_mujoco(m, q, rate)[1]


def check_with_pinocchio(m, there):
    data = there.createData()
    frames = common_frames(m, [(k, f.name) for k, f in enumerate(there.frames) if f.type == pin.FrameType.BODY])
    for q in states(m):
        there_q = convert.to_pinocchio(m, q)[0]
        pin.framesForwardKinematics(there, data, there_q)
        C = axode.poses(m, q)
        for k, frame in frames:
            assert_close(C[frame], data.oMf[k].homogeneous, f"poses of {there.frames[k].name}")
        upper = np.triu(pin.crba(there, data, there_q))
        P = convert.to_pinocchio(m, np.tile(q, (m.nv, 1)), np.eye(m.nv))[1].T
        assert_close(axode.mass_matrix(m, q), P.T @ (upper + np.triu(upper, 1).T) @ P, "mass matrices")


def check_same(a, b, names=None):
    """Expects the same dynamics of two models of axode with the same joints."""
    assert a.joint_names == b.joint_names
    frames = [name for name in (names or a.frame_names) if name in set(a.frame_names) & set(b.frame_names)]
    for q in states(a):
        ours, theirs = (axode.poses(m, q)[[m.frame_index(name) for name in frames]] for m in (a, b))
        assert_close(ours, theirs, "poses")
        assert_close(axode.mass_matrix(a, q), axode.mass_matrix(b, q), "mass matrices")


# ---------------------------------------------------------------- what is read

@pytest.mark.parametrize("file", FILES)
def test_what_we_refuse_is_refused_by_its_own_reader(file):
    m = loaded(file)
    if not isinstance(m, axode.ModelError):
        return
    expected = next((why for path, why in REFUSED.items() if str(file).endswith(path)), None)
    if expected is not None:
        assert expected in str(m)
        return
    if file.suffix == ".urdf":
        with pytest.raises(ValueError):
            pin.buildModelFromUrdf(str(file))
    elif file.suffix == ".xml":
        assert root_of(file) != "<mujoco" or "MuJoCo does not compile it" in str(m)
    else:  # as libsdformat does
        assert any(why in str(m) for why in ("reserved name", "the name is taken", "malformed")), str(m)


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", [it for it in FILES if it.id.endswith(".urdf")])
def test_urdf_as_pinocchio(file, base):
    root = [pin.JointModelFreeFlyer(), "free_base"] if base == "free" else []
    check_with_pinocchio(model(file, base), pin.buildModelFromUrdf(str(file), *root))


@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", [it for it in FILES if it.id.endswith(".urdf")])
def test_urdf_as_mujoco(file, base):
    """MuJoCo drops the inertia of bodies without mass that are fixed to others."""
    m = model(file, base)
    if any("mass is 0" in str(warning) for warning in m.warnings):
        pytest.skip("a link has an inertia and no mass")
    try:
        text = without_geometry(file, base)
    except SyntaxError as error:
        pytest.skip(f"Python does not parse it: {error}")
    check_with_mujoco(m, compiled(text))


@pytest.mark.parametrize("file", [it for it in FILES if it.id.endswith(".xml")])
def test_mjcf_as_mujoco(file):
    """The armature of a free joint acts in other axes there."""
    m = model(file)
    turning = any(joint.kind == "free" and np.any(joint.armature) for joint in m.joints)
    check_with_mujoco(m, mujoco.MjModel.from_xml_path(str(file)), bias=not turning)


# ---------------------------------------------------------------- what is written

@pytest.mark.parametrize("file", FILES)
def test_as_a_drawing(file):
    m = model(file)
    check_same(m, axode.read_drawing(axode.drawing(m)))


@pytest.mark.parametrize("file", FILES)
def test_as_urdf(file, tmp_path):
    m = model(file)
    text = written(axode.urdf, m)
    (tmp_path / "robot.urdf").write_text(text)
    check_same(m, axode.load(tmp_path / "robot.urdf"))
    check_with_pinocchio(m, pin.buildModelFromXML(text))


@pytest.mark.parametrize("base", [None, "free"])
@pytest.mark.parametrize("file", FILES)
def test_as_mjcf(file, base):
    """A model that was written and read again may have other names of massless bodies, and a joint with a follower
    instead of two coupled coordinates."""
    m = without_shapes(model(file, base))
    there = compiled(written(axode.mjcf, m))
    check_with_mujoco(m, there)
    back = convert.model_from_mujoco(there)
    check_with_mujoco(back, there)
    if back.nq == m.nq:
        check_same(m, back, [there.body(i).name for i in range(1, there.nbody)])
