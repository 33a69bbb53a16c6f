"""Mechanisms that touch, for the cases of contact: free bodies on a plane, as drawings."""

import axode
import numpy as np

G = 9.81


def shape(kind, **keys):
    """A collision shape."""
    return {"kind": kind, "role": "collision", **keys}


def solid_box(mass, edges):
    """The moments of inertia of a box."""
    x, y, z = np.square(edges)
    return (mass / 12 * np.array([y + z, x + z, x + y])).tolist()


def body(name, mass, inertia, shapes, joint="free", com=(0, 0, 0)):
    """A body with the construction frame as its frame."""
    return {"name": name, "joint": joint, "mass": mass, "com": list(com), "inertia": list(inertia), "shape": shapes}


def scene(*bodies, friction=0.0, gravity=(0, 0, -G), floor=True, **contact):
    """A model of bodies on the plane z = 0, all with one coefficient of friction."""
    ground = [shape("plane", name="floor", **contact)] if floor else []
    return axode.Model.from_dict({"format": "axode drawing 1", "gravity": list(gravity), "shape": ground,
                                  "contact": {"friction": friction}, "body": list(bodies)})


def cube(name="box", mass=1.0, half=0.1):
    """A cube of 0.2 m and 1 kg."""
    edges = [2 * half] * 3
    return body(name, mass, solid_box(mass, edges), [shape("box", size=edges)])


def ball(restitution=0.0):
    """A ball of 0.1 m and 1 kg."""
    return body("ball", 1, [0.004] * 3, [shape("sphere", radius=0.1, restitution=restitution)])


def at(*heights):
    """Coordinates of free bodies above each other."""
    return np.concatenate([[0, 0, 0, 1, 0, 0, z] for z in heights])


TIPPE_TOP = {"mass": 6e-3, "inertia": [8e-7, 8e-7, 7e-7], "radii": [1.5e-2, 5e-3], "centres": [3e-3, 1.6e-2],
             "friction": 0.3, "spin_friction": 1.5e-4, "spin": 180.0, "inclination": 0.1}


def tippe_top(spin_friction):
    """The tippe top of Leine and Glocker: a ball whose centre is above the centre of mass, with a ball as its stem."""
    properties = {"friction": TIPPE_TOP["friction"], "spin_friction": spin_friction}
    balls = [shape("sphere", radius=r, position=[0, 0, z], **properties)
             for r, z in zip(TIPPE_TOP["radii"], TIPPE_TOP["centres"])]
    top = body("top", TIPPE_TOP["mass"], TIPPE_TOP["inertia"], balls)
    top["shape"][1]["name"] = "stem"
    half = TIPPE_TOP["inclination"] / 2
    height = TIPPE_TOP["radii"][0] - TIPPE_TOP["centres"][0] * np.cos(2 * half)
    q = np.array([np.sin(half), 0, 0, np.cos(half), 0, 0, height])
    return scene(top, **properties), q, np.array([0, 0, TIPPE_TOP["spin"], 0, 0, 0])


FEET = np.array([[0.2, 0.1], [0.2, -0.1], [-0.2, 0.0]])
SLED = {"height": 0.1, "foot": 0.02, "friction": 0.3, "inertia": [0.01, 0.015, 0.02], "start": [1.0, 0.3, 4.0]}


def sled():
    """A body of 1 kg on three feet, which slides and turns."""
    feet = [shape("sphere", radius=SLED["foot"], position=[x, y, SLED["foot"] - SLED["height"]]) for x, y in FEET]
    x, y, turn = SLED["start"]
    return scene(body("sled", 1, SLED["inertia"], feet), friction=SLED["friction"]), [0, 0, turn, x, y, 0]


def grasp(friction):
    """A box between two fingers that slide towards each other."""
    fingers = []
    for x in (-0.12, 0.12):
        joint = {"kind": "prismatic", "axis": [-np.sign(x), 0, 0]}
        pad = shape("box", size=[0.04, 0.1, 0.1], position=[x, 0, 0])
        fingers.append(body(f"finger at {x}", 0.2, [0.01] * 3, [pad], joint, (x, 0, 0)))
    return scene(*fingers, cube(), friction=friction, floor=False)
