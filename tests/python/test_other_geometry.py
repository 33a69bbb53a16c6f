"""Models with other geometry: bodies and tools are displaced as `with_geometry` says, and nothing else changes."""

import axode
import numpy as np
import pytest
from axode.calibration import with_geometry
from measured_poses import every_joint
from mechanisms import MECHANISMS, close

ARM = MECHANISMS["arm"]


@pytest.mark.parametrize("m", [*MECHANISMS.values(), every_joint()], ids=lambda m: m.name)
def test_a_model_without_errors_is_the_one_that_was_drawn(m):
    same = with_geometry(m, np.zeros((m.n_bodies, 6)))
    q = m.random(n=5)
    assert close(axode.poses(same, q), axode.poses(m, q), 1e-14) and close(same.parameters, m.parameters, 1e-14)
    for names in ("body_names", "joint_names", "frame_names", "coordinate_names", "velocity_names", "warnings"):
        assert getattr(same, names) == getattr(m, names)
    for x, y in zip(same.joints, m.joints):
        assert (x.kind, x.leader, x.pitch) == (y.kind, y.leader, y.pitch)
        for value in ("lower", "upper", "velocity", "effort", "damping", "friction", "armature"):
            assert np.array_equal(getattr(x, value), getattr(y, value)), (x.name, value)
    assert np.array_equal(same.gravity, m.gravity)


@pytest.mark.parametrize("m", [*MECHANISMS.values(), every_joint()], ids=lambda m: m.name)
def test_errors_displace_what_they_say_and_keep_screws_and_inertias(m):
    pi = np.random.default_rng(1).normal(0, 0.1, (m.n_bodies, 6))
    other = with_geometry(m, pi)
    for k, name in enumerate(m.body_names):
        drawn, found = m.body(name), other.body(name)
        assert close(found.B, drawn.B @ axode.lie.exp(pi[k]), 1e-13)
        assert close(found.X, drawn.X, 1e-13) and close(found.M, drawn.M, 1e-13) and found.mass == drawn.mass
    for name in m.frame_names:
        assert m.frame_pose(name)[0] == other.frame_pose(name)[0]
        assert close(other.frame_pose(name)[1], m.frame_pose(name)[1], 1e-13)
    q, frame, h = m.random(n=1)[0], m.frame_names[-1], 1e-5
    J = axode.frame_geometry_jacobian(other, q, frame)
    for k in [0, m.n_bodies // 2, m.n_bodies - 1]:
        for u in range(6):
            step = np.zeros((m.n_bodies, 6))
            step[k, u] = h
            C = [axode.poses(with_geometry(other, s * step), q)[m.frame_index(frame)] for s in (-1, 1)]
            assert np.allclose(axode.lie.log(axode.lie.inverse(C[0]) @ C[1]) / (2 * h), J[:, k, u], atol=1e-8)


def test_a_tool_is_displaced_and_nothing_else():
    m = MECHANISMS["humanoid"]
    tool = axode.lie.exp([0.1, 0.2, 0.3, 0.01, 0.02, 0.03])
    other = with_geometry(m, np.zeros((m.n_bodies, 6)), {"left_sole": tool})
    q = m.random(n=3)
    moved = axode.lie.inverse(axode.poses(m, q)) @ axode.poses(other, q)
    k = m.frame_index("left_sole")
    assert np.allclose(moved[:, k], tool, atol=1e-13)
    assert np.allclose(np.delete(moved, k, axis=1), np.eye(4), atol=1e-13)
    drawing = ARM.to_dict()  # a body on a plate that is itself measured, and has mass
    drawing["body"].append({"name": "plate", "on": "link 7", "joint": "fixed", "mass": 1, "com": [0, 0, 1.4],
                            "inertia": [0.01, 0.02, 0.02], "A": {"position": [0, 0, 1.3], "rpy": [0.1, 0.2, 0.3]}})
    drawing["body"].append({"name": "wheel", "on": "plate", "joint": {"kind": "revolute", "axis": "x",
                                                                      "point": [0, 0, 1.4]}})
    m = axode.Model.from_dict(drawing)
    other, q = with_geometry(m, np.zeros((8, 6)), {"plate": tool}), m.random(n=3)
    moved = axode.lie.inverse(axode.poses(m, q)) @ axode.poses(other, q)
    k = m.frame_index("plate")
    assert np.allclose(moved[:, k], tool, atol=1e-13) and close(other.parameters, m.parameters, 1e-13)
    assert np.allclose(np.delete(moved, k, axis=1), np.eye(4), atol=1e-13)
