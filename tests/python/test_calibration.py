"""Calibration finds the geometry that was measured, as exactly as the noise allows, and as far as poses depend on it."""

import re

import axode
import numpy as np
import pytest
from axode.calibration import calibrate, with_geometry
from axode.fitting import least_squares
from measured_poses import FAR, built, every_joint, measured, noisy, seen
from mechanisms import MECHANISMS, close

EVERYWHERE = pytest.mark.parametrize("mechanism", MECHANISMS)
ARM = MECHANISMS["arm"]
FRAMES = {"arm": ["flange"], "machine": ["drill tip", "pointer tip", "cardan shaft", "jack", "lead screw", "chip"],
          "humanoid": ["left_palm", "right_palm", "left_sole"]}


def error(found, true, frame, device=FAR, n=40):
    """The largest error of poses in other configurations, in rad and m."""
    q = true.random(seed=999, n=n)
    off = axode.lie.inverse(seen(true, q, frame, device)) @ seen(found.model, q, frame, found.device)
    return np.abs(axode.lie.log(off)).max()


def serial(kinds, seed=0):
    """An arm of hinges ("r"), sliders ("p") and screws ("h") in general position."""
    random = np.random.default_rng(seed)
    arm, on = axode.Builder(kinds), "ground"
    for k, kind in enumerate(kinds):
        joint = {"kind": {"r": "revolute", "p": "prismatic", "h": "helical"}[kind], "axis": random.normal(size=3),
                 "point": random.uniform(-0.5, 0.5, 3)} | ({"pitch": 0.1} if kind == "h" else {})
        arm.body(f"link {k + 1}", on=on, joint=joint)
        on = f"link {k + 1}"
    return arm.frame("tool", on=on, position=random.uniform(-0.5, 0.5, 3)).build()


# ------------------------------------------------------------------------------------------ without noise


@EVERYWHERE
def test_poses_without_noise_are_explained_everywhere(mechanism):
    m = MECHANISMS[mechanism]
    true = built(m)
    found = calibrate(m, [measured(true, frame, 90) for frame in FRAMES[mechanism]], tool=False)
    assert found.converged and found.residual.max() < 1e-11 < 1e-2 < found.residual_before.min()
    for frame in FRAMES[mechanism]:
        assert error(found, true, frame) < 1e-9
    assert close(with_geometry(m, found.parameters).parameters, found.model.parameters)
    for names in ("body_names", "joint_names", "frame_names", "velocity_names"):
        assert getattr(found.model, names) == getattr(m, names)
    assert close(found.model.parameters, m.parameters, 1e-12)
    assert np.array_equal(found.model.limits()[0], m.limits()[0])


def test_every_kind_of_joint_is_calibrated_with_tool_and_device():
    m = every_joint()
    true = with_geometry(built(m, 2), np.zeros((m.n_bodies, 6)), {"tip": axode.lie.exp([0.2, 0, 0.1, 0.05, 0, 0.1])})
    found = calibrate(m, measured(true, "tip", 90))
    assert found.converged and error(found, true, "tip") < 1e-9
    commute = {"revolute": 2, "helical": 2, "prismatic": 4, "planar": 1, "spherical": 0, "free": 0}
    assert found.rank == 6 * m.n_bodies + 6 - sum(commute[joint.kind] for joint in m.joints)


def test_errors_of_ten_degrees_and_a_decimetre_converge():
    for seed in range(3):
        true = built(ARM, seed, 0.17, 0.1)
        true = with_geometry(true, np.zeros((7, 6)), {"flange": axode.lie.exp([0.3, 0.4, 0.5, 0.1, 0.2, 0.1])})
        found = calibrate(ARM, measured(true, "flange", 60))
        assert found.converged and error(found, true, "flange") < 1e-9 and found.iterations < 60
        found = calibrate(ARM, [{"frame": "flange", "q": (q := ARM.random(n=90)),
                                 "position": seen(true, q, "flange")[:, :3, 3]}])
        q = ARM.random(seed=5, n=20)
        assert close(seen(found.model, q, "flange", found.device)[:, :3, 3], seen(true, q, "flange")[:, :3, 3], 1e-9)


def test_tool_and_device_alone_are_found_exactly():
    tool = axode.lie.exp([0.3, 0, -0.2, 0.05, 0.1, 0])
    true = with_geometry(ARM, np.zeros((7, 6)), {"flange": tool})
    found = calibrate(ARM, measured(true, "flange", 20), bodies=[])
    assert close(found.tools["flange"], tool, 1e-9) and close(found.device, FAR, 1e-9)
    assert found.rank == 12 and not len(found.unidentifiable) and not found.parameters.any()
    alone = calibrate(ARM, measured(true, "flange", 20, device=np.eye(4)), bodies=[], device=False)
    assert close(alone.tools["flange"], tool, 1e-9) and np.array_equal(alone.device, np.eye(4))


def in_joint_frames(m):
    """The mechanism m with body frames in the joints, to which the prior refers."""
    drawing = m.to_dict()
    for body in drawing["body"]:
        if body["joint"] != "fixed":
            body["frame"] = "joint"
    return axode.Model.from_dict(drawing)


def test_a_wrist_whose_point_does_not_move_is_calibrated_by_rotations():
    wrist = axode.Builder("wrist")
    for k, axis in enumerate("zyx"):
        wrist.body(f"link {k + 1}", on=f"link {k}" if k else "ground",
                   joint={"kind": "revolute", "axis": axis, "point": [0, 0, 1]})
    m = wrist.frame("center", on="link 3", position=[0, 0, 1]).build()
    for seed in range(4):
        tool = axode.lie.exp([*np.roll([3.0, 0.1, 0.2], seed), 0, 0, 0])
        true = with_geometry(built(m, seed, 0.02, 1e-4), np.zeros((3, 6)), {"center": tool})
        device = axode.lie.exp([*np.roll([0.1, 2.9, -0.5], seed), 1, 2, 3])
        found = calibrate(m, measured(true, "center", 40, device=device))
        assert found.converged and error(found, true, "center", device) < 1e-9


@pytest.mark.parametrize("angle", [1.0, 2.0, 3.0])
def test_a_tool_and_a_device_turned_by_any_angle_are_no_obstacle(angle):
    for seed in range(3):
        e = np.random.default_rng(seed).normal(size=3)
        tool = axode.lie.exp([*(angle * e / np.linalg.norm(e)), 0.1, 0.2, 0.1])
        true = with_geometry(built(ARM, seed), np.zeros((7, 6)), {"flange": tool})
        found = calibrate(ARM, measured(true, "flange", 60))
        assert found.converged and error(found, true, "flange") < 1e-9


def test_bodies_that_are_not_named_stay_and_the_others_are_found():
    pi = np.zeros((7, 6))
    pi[3] = [0.01, 0.02, -0.01, 0.003, 0.002, 0.001]
    true = with_geometry(ARM, pi)
    found = calibrate(ARM, measured(true, "flange", 30), bodies=["link 4"])
    assert close(found.parameters, pi, 1e-9) and found.rank == 18
    assert found.parameter_names[0] == "link 4 rx" and found.parameter_names[6] == "tool flange rx"


def test_far_from_the_origin_and_in_other_body_frames_the_poses_found_are_the_same():
    q, true = ARM.random(n=40), built(ARM)
    at = {}
    C = noisy(seen(true, q, "flange"), (1e-3, 1e-3), np.random.default_rng(0))
    for frame in ("construction", "joint", "com"):
        drawing = ARM.to_dict()
        for body in drawing["body"][1:]:
            body |= {} if frame == "construction" else {"frame": frame}
        found = calibrate(axode.Model.from_dict(drawing), {"frame": "flange", "q": q, "pose": C})
        at[frame] = seen(found.model, q, "flange", found.device)
        assert found.rank == 34
    assert close(at["joint"], at["construction"], 1e-6) and close(at["com"], at["construction"], 1e-6)


# ------------------------------------------------------------------------------------- what can be identified


@pytest.mark.parametrize("kinds", ["r", "rr", "rrr", "rpr", "ppp", "rhp", "rrrrrr", "pprrr"])
def test_identifiable_parameters_are_as_many_as_theory_says(kinds):
    m = serial(kinds)
    found = calibrate(m, measured(built(m), "tool", 60))
    assert found.rank == sum({"r": 4, "h": 4, "p": 2}[kind] for kind in kinds) + 6
    assert len(found.unidentifiable) == len(found.unidentifiable_names) == 6 * (len(kinds) + 2) - found.rank
    same = calibrate(m, measured(built(m), "tool", 60, device=np.eye(4)), device=False)
    assert same.rank == found.rank and error(found, built(m), "tool") < 1e-9
    without = calibrate(m, measured(built(m), "tool", 60, device=np.eye(4)), device=False, tool=False)
    assert without.rank == found.rank - (2 if kinds[-1] == "p" else 4)


def test_what_cannot_be_identified_changes_no_pose():
    m, found = ARM, calibrate(ARM, measured(built(ARM), "flange", 60))
    q, h = ARM.random(seed=3, n=10), 1e-4
    assert np.linalg.matrix_rank(found.unidentifiable) == len(found.unidentifiable) == 54 - 34
    for row in found.unidentifiable:
        steps = axode.lie.exp(h * row.reshape(-1, 6))
        pi = axode.lie.log(axode.lie.exp(found.parameters) @ steps[:7])
        C = seen(with_geometry(m, pi, {"flange": found.tools["flange"] @ steps[7]}), q, "flange",
                 found.device @ steps[8])
        assert np.abs(C - seen(found.model, q, "flange", found.device)).max() < 100 * h**2


def test_what_two_hinges_share_is_said_in_words():
    found = calibrate(ARM, measured(ARM, "flange", 60, device=np.eye(4)), device=False)
    assert {"link 1 rz - link 2 rz", "link 1 z - link 2 z", "link 2 y - link 3 y",
            "link 7 z - tool flange z"} <= set(found.unidentifiable_names)
    for name, row in zip(found.unidentifiable_names, found.unidentifiable):
        for term in re.split(r" [+-] ", name):
            assert abs(row[found.parameter_names.index(term.rpartition(" * ")[2])]) > 0.009
        assert np.isclose(np.abs(row), 1).any()


def test_of_positions_the_axes_of_the_tool_cannot_be_seen():
    true = with_geometry(built(ARM), np.zeros((7, 6)), {"flange": axode.lie.exp([0, 0, 0, 0.1, 0, 0])})
    q = ARM.random(n=150)
    p = seen(true, q, "flange")[:, :3, 3]
    found = calibrate(ARM, {"frame": "flange", "q": q, "position": p})
    q = ARM.random(seed=4, n=30)
    assert close(seen(found.model, q, "flange", found.device)[:, :3, 3], seen(true, q, "flange")[:, :3, 3], 1e-9)
    assert {"tool flange rx", "tool flange ry", "tool flange rz"} <= set(found.unidentifiable_names)
    assert found.rank == 4 * 7 + 3
    assert np.isnan(found.noise[0]) and np.isnan(found.residual[0]) and found.residual[1] < 1e-11


def test_without_a_prior_the_correction_is_the_smallest():
    true = built(ARM)
    poses = measured(true, "flange", 60, device=np.eye(4))
    found = calibrate(ARM, poses, device=False)
    exact = np.random.default_rng(0).normal(size=(7, 6)) * 0.03  # those of `built`
    assert np.linalg.norm(found.parameters) < np.linalg.norm(exact)
    assert np.abs(calibrate(ARM, measured(ARM, "flange", 60)).parameters).max() < 1e-9
    near, far = (calibrate(ARM, poses, device=False, noise=[1e-6, 1e-6], prior=[s, s]) for s in (1e-2, 1e-9))
    assert np.abs(far.parameters).max() < 1e-3 * np.abs(near.parameters).max() and near.residual.max() < 1e-6


# ------------------------------------------------------------------------------------------ noise


@pytest.mark.parametrize("mechanism", ["arm", "machine"])
def test_errors_of_predictions_are_as_large_as_their_deviations(mechanism):
    m, frame, deviations, chi = MECHANISMS[mechanism], FRAMES[mechanism][0], np.array([2e-4, 1e-4]), []
    for seed in range(5):
        true = built(m, seed)
        found = calibrate(m, measured(true, frame, 60, deviations, seed))
        assert found.converged and found.noise == pytest.approx(deviations, rel=0.25)
        q = m.random(seed=77, n=200)
        C = seen(found.model, q, frame, found.device)
        e = axode.lie.log(axode.lie.inverse(C) @ seen(true, q, frame))
        bodies = [k for k, name in enumerate(m.body_names) if f"{name} rx" in found.parameter_names]
        of_bodies = axode.frame_geometry_jacobian(found.model, q, frame)[:, :, bodies].reshape(200, 6, -1)
        of_device = -axode.lie.Ad(axode.lie.inverse(C))
        J = np.concatenate([of_bodies, np.tile(np.eye(6), (200, 1, 1)), of_device], axis=2)
        U, sigma, Vt = np.linalg.svd(J.reshape(1200, -1), full_matrices=False)
        U, SVt = U[:, :found.rank], sigma[:found.rank, None] * Vt[:found.rank]
        y = U.T @ e.ravel()  # identifiable combinations
        chi.append(y @ np.linalg.solve(SVt @ found.covariance @ SVt.T, y) / found.rank)
        assert np.all(found.deviations >= 0) and np.linalg.matrix_rank(found.covariance, 1e-16) <= len(found.covariance)
    assert np.mean(chi) == pytest.approx(1, abs=5 * np.sqrt(2 / (5 * found.rank)))


def test_deviations_shrink_with_the_root_of_the_number_of_poses_and_hold_for_each_parameter():
    bodies = ["link 3"]
    few, many = (calibrate(ARM, measured(ARM, "flange", N, (1e-3, 1e-3)), bodies=bodies) for N in (50, 800))
    assert few.deviations / many.deviations == pytest.approx(np.full(18, 4), rel=0.35)
    errors = []
    for seed in range(8):
        found = calibrate(ARM, measured(ARM, "flange", 50, (1e-3, 1e-3), seed), bodies=bodies)
        x = np.concatenate([found.parameters[2], axode.lie.log(found.tools["flange"]),
                            axode.lie.log(axode.lie.inverse(FAR) @ found.device)])
        errors.append(x @ np.linalg.solve(found.covariance, x) / 18)
    assert np.mean(errors) == pytest.approx(1, abs=5 * np.sqrt(2 / (8 * 18)))


def test_noise_of_angles_and_lengths_is_told_apart_and_weighs():
    true = built(ARM)
    poses = measured(true, "flange", 80, (1e-2, 1e-5))
    found = calibrate(ARM, poses)
    assert found.noise == pytest.approx([1e-2, 1e-5], rel=0.25)
    equal = calibrate(ARM, poses, noise=[1e-3, 1e-3])
    assert np.array_equal(equal.noise, [1e-3, 1e-3])
    q = ARM.random(seed=9, n=50)
    off = [np.linalg.norm(seen(x.model, q, "flange", x.device)[:, :3, 3] - seen(true, q, "flange")[:, :3, 3])
           for x in (found, equal)]
    assert off[0] < 0.2 * off[1]


def test_a_prior_that_is_true_makes_the_geometry_better_and_deviations_honest():
    deviations, chi = (1e-3, 1e-3), []
    for seed in range(6):
        pi = np.random.default_rng(seed).normal(0, 0.003, (7, 6))
        m = in_joint_frames(ARM)
        true = with_geometry(m, pi)
        found = calibrate(m, measured(true, "flange", 12, deviations, seed), prior=[0.003, 0.003], noise=deviations,
                          tool=False)
        e = axode.lie.log(axode.lie.inverse(axode.lie.exp(found.parameters)) @ axode.lie.exp(pi)).ravel()
        chi.append(e @ np.linalg.solve(found.covariance[:42, :42], e) / 42)
        assert found.converged and found.deviations[:42].max() < 0.0031 and found.rank == 30
    assert np.mean(chi) == pytest.approx(1, abs=5 * np.sqrt(2 / (6 * 42)))


def test_noise_is_estimated_well_from_few_poses():
    found = [calibrate(ARM, measured(built(ARM, seed), "flange", 12, (1e-3, 2e-3), seed)).noise for seed in range(6)]
    assert np.mean(found, axis=0) == pytest.approx([1e-3, 2e-3], rel=0.15)


def test_deviations_of_the_smallest_correction_are_honest():
    true, chi = built(ARM), []
    exact = calibrate(ARM, measured(true, "flange", 60))
    for seed in range(6):
        poses = measured(true, "flange", 60)
        poses["pose"] = noisy(poses["pose"], (1e-5, 1e-5), np.random.default_rng(seed))
        found = calibrate(ARM, poses)
        e = axode.lie.log(axode.lie.inverse(axode.lie.exp(exact.parameters)) @ axode.lie.exp(found.parameters)).ravel()
        chi.append((e / found.deviations[:42])[6:] ** 2)
        # The first six parameters are shared with the pose of the device and have no deviation of their own.
        assert max(np.abs(e[:6]).max(), found.deviations[:6].max()) < 1e-12
    assert np.mean(chi) == pytest.approx(1, abs=0.3)


def test_what_is_found_with_a_prior_is_the_minimum_of_what_is_said():
    m, prior, noise = in_joint_frames(ARM), np.array([0.1, 0.1]), np.array([0.1, 0.1])
    true = built(m, 0, 0.2, 0.1)
    poses = measured(true, "flange", 12, noise, device=np.eye(4))
    found = calibrate(m, poses, prior=prior, noise=noise, tool=False, device=False)

    def cost(parameters):
        r = axode.lie.log(axode.lie.inverse(seen(with_geometry(m, parameters), poses["q"], "flange", np.eye(4)))
                          @ poses["pose"])
        return np.sum((r / np.repeat(noise, 3))**2) + np.sum((parameters / np.repeat(prior, 3))**2)

    assert found.converged and np.abs(found.parameters).max() > 0.1
    h = 1e-5
    for k in range(42):
        step = np.zeros(42)
        step[k] = h
        slope = [cost(found.parameters + s * step.reshape(7, 6)) for s in (-1, 1)]
        assert abs(slope[1] - slope[0]) / (2 * h) < 0.05  # without the exact derivatives it is above 1


@pytest.mark.parametrize("given", [None, [1e-4, 1e-4]])
def test_outliers_do_less_harm_to_the_robust_estimate(given):
    true, random = built(ARM), np.random.default_rng(2)
    poses = measured(true, "flange", 150, (1e-4, 1e-4))
    wrong = random.random(150) < 0.08
    poses["pose"][wrong] = noisy(poses["pose"][wrong], (0.05, 0.05), random)
    plain, robust = (calibrate(ARM, poses, robust=robust, noise=given) for robust in (False, True))
    assert robust.converged and robust.noise == pytest.approx([1e-4, 1e-4], rel=0.25)
    assert error(robust, true, "flange") < 0.1 * error(plain, true, "flange")
    clean = measured(true, "flange", 150, (1e-4, 1e-4))
    ratio = calibrate(ARM, clean, robust=True).deviations / calibrate(ARM, clean).deviations
    assert np.median(ratio) == pytest.approx(1.02, abs=0.08)


def test_several_frames_of_a_tree_share_what_carries_them():
    m = MECHANISMS["humanoid"]
    true = built(m, 4)
    parts = [measured(true, frame, 100, (1e-5, 1e-5)) for frame in ("left_palm", "right_palm")]
    found = calibrate(m, parts)
    assert found.converged and set(found.tools) == {"left_palm", "right_palm"}
    for frame in found.tools:
        assert error(found, true, frame) < 3e-4
    carry = {name.rpartition(" ")[0] for name in found.parameter_names}
    assert "left_hand" in carry and "left_foot" not in carry


def test_poses_and_positions_of_one_frame_in_parts_are_as_in_one():
    true = built(ARM)
    poses = measured(true, "flange", 90, (1e-4, 1e-4))
    q, C = poses["q"], poses["pose"]
    once = calibrate(ARM, poses)
    parts = calibrate(ARM, [{"frame": "flange", "q": q[:30], "pose": C[:30]},
                            {"frame": "flange", "q": q[30:], "pose": C[30:]}])
    assert close(parts.parameters, once.parameters, 1e-6) and close(parts.covariance, once.covariance, 1e-6)
    mixed = calibrate(ARM, [{"frame": "flange", "q": q[:30], "pose": C[:30]},
                            {"frame": "flange", "q": q[30:], "position": C[30:, :3, 3]}])
    assert mixed.rank == 34 and error(mixed, true, "flange") < 2e-3


def test_blocks_of_poses_give_the_same(monkeypatch):
    poses = measured(built(ARM), "flange", 90, (1e-4, 1e-4))
    once = calibrate(ARM, poses, robust=True)
    monkeypatch.setattr(least_squares, "BLOCK", 12 * 64 * 7)
    blocks = calibrate(ARM, poses, robust=True)
    assert close(blocks.parameters, once.parameters, 1e-6) and close(blocks.covariance, once.covariance, 1e-6)


# ------------------------------------------------------------------------------------------ arguments


def test_rotations_that_are_rounded_are_made_exact():
    true = built(ARM)
    poses = measured(true, "flange", 60, (1e-3, 1e-3))
    rounded = poses | {"pose": poses["pose"].round(5)}
    assert np.abs(calibrate(ARM, rounded).parameters - calibrate(ARM, poses).parameters).max() < 1e-4


def test_arguments_that_are_wrong_are_named():
    poses = measured(ARM, "flange", 20)
    q, C = poses["q"], poses["pose"]
    off, mirrored, broken = C.copy(), C.copy(), C.copy()
    off[3, 0, :3] *= 1.1
    mirrored[2, :3, 0] *= -1
    broken[4, 1, 2] = np.nan
    few = {"frame": "flange", "q": q[:3], "pose": C[:3]}
    on_link = {"frame": "link 7", "q": q, "pose": C}
    for kind, words, measurements, options in [
        (ValueError, r"measurements: expected a dict with the keys frame, q and pose or position, or a list", [], {}),
        (ValueError, r"measurements\[0\]: expected a dict, got int", [3], {}),
        (KeyError, r"measurements\[0\]: a key is 'poses'; expected", {"frame": "flange", "q": q, "poses": C}, {}),
        (KeyError, r"\[0\]: expected one of the keys 'pose' and 'position'", {"frame": "flange", "q": q}, {}),
        (KeyError, r"measurements\[0\]: has no key 'q'", {"frame": "flange", "pose": C}, {}),
        (KeyError, 'no frame "flang"; did you mean "flange"', {"frame": "flang", "q": q, "pose": C}, {}),
        (ValueError, r"measurements\[1\].q: expected shape \(7,\) or \(N, 7\), nq numbers, got \(20, 6\)",
         [poses, {"frame": "flange", "q": q[:, :6], "pose": C}], {}),
        (ValueError, r"measurements\[0\].q: expected shape \(N, 7\)", {"frame": "flange", "q": q[0], "pose": C[0]}, {}),
        (ValueError, r"pose: expected shape \(20, 4, 4\), poses, got \(19, 4, 4\)",
         {"frame": "flange", "q": q, "pose": C[1:]}, {}),
        (ValueError, r"position: expected shape \(20, 3\), as q has, got \(20, 4, 4\)",
         {"frame": "flange", "q": q, "position": C}, {}),
        (ValueError, r"measurements\[0\].pose\[4, 1, 2\] is nan; expected finite", poses | {"pose": broken}, {}),
        (ValueError, r"pose\[3\]: expected a pose, a matrix of a rotation .* off by 0.\d+, and 0.001 is made exact",
         poses | {"pose": off}, {}),
        (ValueError, r"pose\[2\]: expected a pose", poses | {"pose": mirrored}, {}),
        (ValueError, "3 are too few for .* expected more of them, or noise", few, {}),
        (ValueError, r"noise: expected shape \(2,\), standard deviations in rad and m, got \(\)", poses, {"noise": 1}),
        (ValueError, r"noise is \[0.0, 1.0\]; expected standard deviations", poses, {"noise": [0, 1]}),
        (ValueError, r"prior is \[1.0, -1.0\]; expected", poses, {"prior": [1, -1]}),
        (KeyError, 'no body "link 9"', poses, {"bodies": ["link 9"]}),
        (TypeError, "bodies is 'link 1'; expected a list", poses, {"bodies": "link 1"}),
        (ValueError, '"ground" has no joint', poses, {"bodies": ["ground"]}),
        (ValueError, "they select no parameter to calibrate", poses, {"bodies": [], "tool": False, "device": False}),
        (ValueError, 'frame "link 7" is that of a body', on_link, {}),
        (ValueError, "none of the poses depends", {"frame": "base", "q": q, "pose": np.tile(np.eye(4), (20, 1, 1))},
         {"bodies": ["link 1"], "tool": False, "device": False}),
    ]:
        with pytest.raises(kind, match=words):
            calibrate(ARM, measurements, **options)
    with pytest.raises(ValueError, match=r"parameters: expected shape \(n_bodies, 6\), six for each .* \(6, 6\)"):
        with_geometry(ARM, np.zeros((6, 6)))
    with pytest.raises(ValueError, match='frame "link 1" is that of a body'):
        with_geometry(ARM, np.zeros((7, 6)), {"link 1": np.eye(4)})
