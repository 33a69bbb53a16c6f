"""The pages of all mechanisms that come with the package, and of robots of others, in a real browser."""

import json
import os
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import axode
import axode.viewer
import numpy as np
import pytest
from conftest import ROBOTS

SOURCE = Path(__file__).resolve().parents[2]
MODULES = SOURCE / "build/release/viewer/node_modules"
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
pytestmark = pytest.mark.skipif(not axode.viewer.PAGE.exists(), reason="this build has no viewer: there was no npm")

MECHANISMS = [*sorted(axode.robots.iterdir()), *sorted(ROBOTS.glob("*.urdf"))]
LARGEST_PAGE = 1_200_000


class Scene(HTMLParser):
    """The scene of a page."""

    def __init__(self, text):
        super().__init__()
        self.inside, self.text = False, ""
        self.feed(text)
        self.close()
        self.scene = json.loads(self.text)

    def handle_starttag(self, tag, attrs):
        self.inside = dict(attrs).get("id") == "scene"

    def handle_data(self, data):
        if self.inside:
            self.text += data


def written(file, folder):
    """The page of a mechanism and its scene."""
    page = folder / f"{file.stem}.html"
    axode.view(axode.load(file), output=page)
    return page, Scene(page.read_text(encoding="utf-8")).scene


def z_axis(pose):
    x, y, z, w = pose[3:]
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def distance_across(offsets, axis):
    """The least length of vectors without their parts along an axis, which may be zero."""
    return np.linalg.norm(offsets - np.outer(offsets @ axis, axis), axis=1).min()


@pytest.mark.parametrize("file", MECHANISMS, ids=lambda file: file.stem)
def test_every_body_is_drawn_where_its_joints_are(file, tmp_path):
    page, scene = written(file, tmp_path)
    meshes = sum(len(mesh["data"]) for mesh in scene["meshes"])
    assert page.stat().st_size - meshes < LARGEST_PAGE
    bodies = scene["bodies"]
    places = [[] for _ in bodies]
    for i, body in enumerate(bodies[1:], 1):
        places[i] += [body["S_self"][:3], body["com"]]
        places[body["predecessor"]].append(body["S_prev"][:3])
    for frame in scene["frames"]:
        places[frame["body"]].append(frame["pose"][:3])
    for loop in scene["loops"]:
        for end in loop["ends"]:
            places[end["body"]].append(end["pose"][:3])
    for line in scene["lines"]:
        for end in line["ends"]:
            places[end["body"]].append(end["point"])
    drawn = {shape["body"] for shape in scene["shapes"] if shape["role"] == "visual"}
    assert drawn - {0}, "no body is drawn"
    for i, body in enumerate(bodies[1:], 1):
        size = np.ptp([*places[i], [0, 0, 0]], axis=0).max()
        assert i in drawn or body["mass"] == 0 or size < 1e-9, f"{body['name']} is not drawn"
    # Bodies of a planar mechanism lie above each other along the axes of their hinges, and a rail has mounts at its ends.
    axes = [np.zeros(3)] + [z_axis(body["S_self"]) * (body["joint"]["kind"] == "revolute") for body in bodies[1:]]
    ends_of_rails = [
        np.array(shape["pose"][:3]) + side * shape["length"] / 2 * z_axis(shape["pose"])
        for shape in scene["shapes"] if shape["body"] == 0 and shape["kind"] == "capsule" for side in (-1, 1)
    ]
    for shape in scene["shapes"]:
        if not shape["stand_in"] or not places[shape["body"]]:
            continue
        points = np.array(shape.get("points", [[0, 0, 0]])) + shape["pose"][:3]
        size = max(shape.get("radius", 0) + shape.get("length", 0), max(shape.get("size", [0])), *np.ptp(points, axis=0))
        around = places[shape["body"]] + (ends_of_rails if shape["body"] == 0 else [])
        away = min(distance_across(points - place, axes[shape["body"]]) for place in around)
        assert away <= size + 1e-9, f"a part of {bodies[shape['body']]['name']} of {size} m is {away} m from its joints"


@pytest.mark.skipif(not (CHROMIUM and MODULES.exists()), reason="there is no Chromium, or no playwright-core")
def test_loops_stay_closed_while_sliders_move_and_the_console_is_silent(tmp_path):
    walked = MECHANISMS if os.environ.get("AXODE_EVERY_PAGE") else MECHANISMS[::4]  # a browser takes 2 s of CPU for each
    pages = [written(file, tmp_path) for file in walked]
    walk = subprocess.run(["node", Path(__file__).with_name("page_walk.mjs"), MODULES, CHROMIUM], text=True, check=True,
                          input="".join(f"{page.as_uri()}\n" for page, _ in pages), stdout=subprocess.PIPE)
    for (page, scene), line in zip(pages, walk.stdout.splitlines(), strict=True):
        seen = json.loads(line)
        assert seen["said"] == [], page.stem
        assert seen["pixels"] > 200, f"{page.stem}: {seen['pixels']} pixels are drawn"
        assert seen["gap"] < 1e-9, f"{page.stem}: loops open by {seen['gap']}"
        if scene["loops"]:
            assert seen["reached"] > 0.2 * seen["asked"], f"{page.stem}: {seen['notes']}"
        else:
            assert seen["notes"] == [], page.stem
