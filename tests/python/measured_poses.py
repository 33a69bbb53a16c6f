"""Mechanisms with errors in their geometry, and the poses of their frames that a device measures."""

import axode
import numpy as np
from axode.calibration import with_geometry

FAR = axode.lie.exp([0.3, -0.5, 2, 3, 1, -2])  # where the device is


def built(m, seed=0, angle=0.03, length=0.03):
    """The mechanism m with errors in the geometry of every joint."""
    pi = np.random.default_rng(seed).normal(size=(m.n_bodies, 6)) * np.repeat([angle, length], 3)
    return with_geometry(m, pi)


def seen(m, q, frame, device=FAR):
    return axode.lie.inverse(device) @ axode.poses(m, q)[:, m.frame_index(frame)]


def noisy(C, deviations, random):
    """The poses with noise of these standard deviations, in rad and m."""
    return C @ axode.lie.exp(random.normal(size=(len(C), 6)) * np.repeat(deviations, 3))


def measured(m, frame, N, deviations=(0, 0), seed=0, device=FAR):
    q = m.random(seed=seed + 1, n=N)
    return {"frame": frame, "q": q, "pose": noisy(seen(m, q, frame, device), deviations, np.random.default_rng(seed))}


def every_joint():
    """A chain of every kind of joint, one of them coupled, on a base that floats."""
    random = np.random.default_rng(3)
    chain, on = axode.Builder("chain"), "ground"
    for kind in ["free", "helical", "cylindrical", "universal", "spherical", "planar", "prismatic", "revolute", "fixed",
                 "revolute"]:
        name = f"{kind} body {len(chain.bodies)}"
        joint = {"kind": kind, "name": f"{kind} {len(chain.bodies)}"}
        if kind not in ("free", "fixed"):
            joint |= {"point": random.uniform(-0.5, 0.5, 3)}
        if kind not in ("free", "fixed", "spherical"):
            joint |= {"axis": random.normal(size=3)}
        if kind == "universal":
            joint |= {"second_axis": np.cross(joint["axis"], [1, 2, 3])}
        if kind == "helical":
            joint |= {"pitch": 0.1}
        if kind == "prismatic":
            joint |= {"follows": {"joint": "helical 1", "ratio": 0.5, "offset": 0.1}}
        given = {"A": {"position": random.uniform(-0.5, 0.5, 3), "rpy": random.uniform(-1, 1, 3)}}
        given |= {"inertia_axes": {"rpy": [0.1, 0.2, 0.3]}, "inertia_about": "origin"} if kind == "helical" else {}
        chain.body(name, on=on, joint=joint, mass=1, com=random.uniform(-1, 1, 3), inertia=[5, 5.5, 6], **given)
        on = name
    return chain.frame("tip", on=on, position=[0.1, 0.2, 0.3]).build()
