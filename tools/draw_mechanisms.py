"""Draws all mechanisms with loops that come with the package in their drawn configuration: closed, with every joint
at zero.

    build/venv/bin/python tools/draw_mechanisms.py docs/mechanisms.svg

A line for each body, between all joints and frames on it. Needs matplotlib, and nothing that has to be built.
"""

import argparse
import tomllib
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "axode", "svg.fonttype": "none"})
from matplotlib import pyplot  # noqa: E402  the backend comes first

ROBOTS = Path(__file__).resolve().parents[1] / "examples" / "robots"
XY, XZ = np.eye(3)[[0, 1]], np.eye(3)[[0, 2]]
Y_UP = np.array([[1, 0, -0.45], [0, 1, -0.3]])  # where x, y, z point on paper, as columns
Z_UP = np.array([[-0.45, 1, 0], [-0.3, 0, 1]])
FROM_ABOVE = np.array([[1, -0.5, 0], [0.2, 0.5, 1]])
COLUMNS = 4
BODIES = ["#4477aa", "#ee7733", "#228833", "#aa3377", "#999933", "#66ccee", "#cc3311"]
LOOP, SPRING = "#cc3311", "#777777"
HINGE = {"marker": "o", "markersize": 4, "markerfacecolor": "white", "markeredgecolor": "black", "linestyle": "none"}
SLIDE = HINGE | {"marker": "s", "markersize": 6}
ON_GROUND = HINGE | {"marker": "^", "markersize": 6, "markerfacecolor": "black"}
CLOSING = HINGE | {"markersize": 8, "markerfacecolor": "none", "markeredgecolor": LOOP, "markeredgewidth": 1.5}


def place(body):
    """The place of the joint of a body, or its centre of mass if the joint has no place."""
    return body["com"] if body["joint"] == "fixed" else body["joint"].get("point", body["com"])


def floats(body):
    return body["joint"] != "fixed" and body["joint"]["kind"] == "free"


def ends(loop):
    """The points of a loop on the first and on the second body."""
    return loop.get("points") or [loop.get("center") or loop["point"]] * 2


def points_on(body, drawing):
    name = body["name"]
    points = [place(one) for one in drawing["body"] if one.get("on") == name or one is body and not floats(body)]
    for tie in drawing["loop"] + drawing.get("spring", []):
        points += [end for end, one in zip(ends(tie), tie["between"], strict=True) if one == name]
    points += [frame["position"] for frame in drawing.get("frame", []) if frame["on"] == name]
    points = list(dict.fromkeys(map(tuple, points)))
    return np.array(points if len(points) > 1 else [*points, tuple(body["com"])])


def view_of(drawing):
    """Where x, y, z point on paper: the plane of a planar mechanism, from above for wheels, else with gravity down."""
    points = np.concatenate([points_on(body, drawing) for body in drawing["body"]])
    thickness = np.ptp(points, axis=0)
    if any(loop["kind"] == "rolling" for loop in drawing["loop"]):
        return FROM_ABOVE
    if thickness[2] == 0:
        return XY
    if thickness[1] == 0:
        return XZ
    return Y_UP if drawing["gravity"][1] < 0 else Z_UP


def outline(corners):
    """Corners in the order of their angles about the middle, the first once more at the end."""
    x, y = (corners - corners.mean(axis=0)).T
    order = np.argsort(np.arctan2(y, x))
    return corners[[*order, order[0]]].T


def rim(loop, view):
    """The rim of a rolling body: a circle about the axis of a wheel, or the outline of a sphere."""
    center, turn = np.array(loop["center"]), np.linspace(0, 2 * np.pi, 49)
    radius = center[2] - loop["point"][2]
    circle = radius * np.array([np.cos(turn), np.sin(turn)])
    if "wheel_axis" in loop:
        circle = view[:, [0, 2]] @ circle
    return (view @ center)[:, None] + circle


def draw(drawing, view, axes):
    for body, color in zip(drawing["body"], BODIES * 3, strict=False):
        axes.plot(*outline(points_on(body, drawing) @ view.T), color=color, linewidth=2.2, solid_capstyle="round")
    for tie in drawing.get("spring", []):
        axes.plot(*(np.array(ends(tie)) @ view.T).T, color=SPRING, linestyle=":", linewidth=1.5)
    for body in drawing["body"]:
        if body["joint"] == "fixed":
            axes.plot(*(view @ place(body)), "o", color="black", markersize=8)
        elif not floats(body):
            slides = body["joint"]["kind"] == "prismatic"
            axes.plot(*(view @ place(body)), **(SLIDE if slides else HINGE if "on" in body else ON_GROUND))
    for loop in drawing["loop"]:
        if loop["kind"] == "rolling":
            axes.plot(*rim(loop, view), color=LOOP, linewidth=1)
        else:
            axes.plot(*(np.array(ends(loop)) @ view.T).T, color=LOOP, linestyle="--", linewidth=1)
            axes.plot(*(np.array(ends(loop)) @ view.T).T, **CLOSING)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set_axis_off()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("svg", type=Path, help="the file to draw")
    arguments = parser.parse_args()
    drawings = {file.name: tomllib.loads(file.read_text(encoding="utf-8")) for file in sorted(ROBOTS.glob("*.toml"))}
    closed = {name: drawing for name, drawing in drawings.items() if "loop" in drawing}
    rows = -(-len(closed) // COLUMNS)
    figure, panels = pyplot.subplots(rows, COLUMNS, figsize=(11, 2.7 * rows), layout="constrained")
    for axes in panels.flat[len(closed):]:
        axes.set_axis_off()
    for (name, drawing), axes in zip(closed.items(), panels.flat, strict=False):
        draw(drawing, view_of(drawing), axes)
        axes.set_title(name, fontsize="small")
    kinds = {"joint": HINGE, "slide": SLIDE, "joint on the ground": ON_GROUND, "closes a loop": CLOSING}
    handles = [pyplot.Line2D([], [], **kind) for kind in kinds.values()]
    handles += [pyplot.Line2D([], [], color=LOOP, linestyle="--"), pyplot.Line2D([], [], color=SPRING, linestyle=":")]
    labels = [*kinds, "rod without mass", "spring"]
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize="small")
    figure.savefig(arguments.svg, metadata={"Date": None})


if __name__ == "__main__":
    main()
