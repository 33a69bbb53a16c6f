"""Mechanisms with loops against Pinocchio's constrained dynamics, on every robot whose joints all move on their own."""

import subprocess

import numpy as np
import pinocchio as pin
import pytest
from axode_command import COMMAND, evaluate, robots
from pinocchio_robot import Robot
from states import arrays, as_json, assert_close, random_state

STATES = 4
KINDS = {"spherical": pin.ContactType.CONTACT_3D, "fixed": pin.ContactType.CONTACT_6D}


def drawing_of(file, folder):
    drawing = folder / "robot.toml"
    subprocess.run([COMMAND, "convert", file, drawing], check=True, capture_output=True)
    return drawing


def loop_text(kind, links, C):
    """A loop that is closed where the links have the poses C: its frame is that of the second."""
    first, second = (np.linalg.inv(C[links[0]]) @ C[links[1]], np.eye(4))
    frames = ", ".join(f"{{ position = {F[:3, 3].tolist()}, rotation = {F[:3, :3].tolist()} }}" for F in (first, second))
    return f'\n[[loop]]\nbetween = ["{links[0]}", "{links[1]}"]\nkind = "{kind}"\nframes = [{frames}]\n'


def constraint(robot, kind, links, C):
    def on(link):
        frame = robot.model.frames[robot.links[link]]
        return frame.parentJoint, frame.placement
    (i, at_i), (j, at_j) = map(on, links)
    first = at_i * pin.SE3(np.linalg.inv(C[links[0]]) @ C[links[1]])
    return pin.RigidConstraintModel(KINDS[kind], robot.model, i, first, j, at_j, pin.ReferenceFrame.LOCAL)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("file", robots())
def test_accelerations(file, base, kind, tmp_path):
    robot = Robot(file, base)
    if robot.mimic:
        pytest.skip("Pinocchio's mimic joints move on their own here")
    drawing = drawing_of(file, tmp_path)
    for seed in range(STATES):
        random = np.random.default_rng(seed)
        values, _ = random_state(robot, random)
        poses = arrays(evaluate(file, as_json(values, []), ["poses"], base, "body")["results"]["poses"], robot.links)
        moving = [link for link in robot.links if robot.model.frames[robot.links[link]].parentJoint > 0]
        links = random.choice(moving, 2, replace=False).tolist()
        if len({robot.model.frames[robot.links[link]].parentJoint for link in links}) < 2:
            continue
        closed = tmp_path / f"closed_{seed}.toml"
        closed.write_text(drawing.read_text() + loop_text(kind, links, poses))
        state = as_json(values, [])
        assembled = evaluate(closed, state, ["assembly", "loop_mobility"], base, "body")
        if assembled["results"]["loop_mobility"]["redundant"]:
            continue
        v = assembled["results"]["assembly"]["v"]
        ours = evaluate(closed, {**state, "v": v}, ["forward_dynamics", "loop_residual"], base, "body")
        assert max(np.abs(r).max() for r in ours["results"]["loop_residual"].values()) < 1e-12
        P = robot.velocity_map(ours["joints"])
        q, tau = robot.coordinates(values["q"]), robot.velocities(values["tau"])
        models, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        models.append(constraint(robot, kind, links, poses))
        datas.append(models[0].createData())
        pin.initConstraintDynamics(robot.model, robot.data, models, datas)
        a = pin.constraintDynamics(robot.model, robot.data, q, P @ np.array(v), tau, models, datas)
        assert_close("accelerations", P @ np.array(ours["results"]["forward_dynamics"]), a, bound=1e-8)
