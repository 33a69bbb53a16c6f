"""A tippe top turns over: friction against sliding and drilling lifts it onto its stem."""

import axode
import numpy as np

MASS, INERTIA = 6e-3, [8e-7, 8e-7, 7e-7]  # the top of Leine and Glocker
BALL, STEM = (1.5e-2, 3e-3), (5e-3, 1.6e-2)  # radius, and height of the centre above the centre of mass
SURFACE = {"friction": 0.3, "spin_friction": 1.5e-4}  # drilling friction is a length, m


def sphere(name: str, radius: float, height: float) -> dict[str, object]:
    return {"name": name, "kind": "sphere", "role": "collision", "radius": radius, "position": [0, 0, height], **SURFACE}


top = axode.Model.from_dict({
    "format": "axode drawing 1", "name": "tippe top", "contact": {},
    "shape": [{"name": "floor", "kind": "plane", "role": "collision", **SURFACE}],
    "body": [{"name": "top", "joint": "free", "mass": MASS, "com": [0, 0, 0], "inertia": INERTIA,
              "shape": [sphere("ball", *BALL), sphere("stem", *STEM)]}]})
lean = 0.1  # rad
start = [np.sin(lean / 2), 0, 0, np.cos(lean / 2), 0, 0, BALL[0] - BALL[1] * np.cos(lean)]
motion = axode.simulate(top, start, [0, 0, 180, 0, 0, 0], until=3.0, step=1e-3)

axis = axode.poses(top, motion.q)[:, top.frame_index("top"), 2, 2]  # cosine of the inclination
stem = np.linalg.norm(motion.contact_forces("stem"), axis=1)
print(f"the stem touches after {motion.t[np.flatnonzero(stem)[0]]:.2f} s")
print(f"the top turns by up to {np.degrees(np.arccos(axis.min())):.0f} degrees")
print(f"the energy falls from {1e3 * motion.energy[0]:.2f} mJ to {1e3 * motion.energy[-1]:.2f} mJ, "
      f"in every step: {bool(np.diff(motion.energy).max() <= 1e-15)}")
print(f"largest certificate {motion.certificates.max():.0e}")
