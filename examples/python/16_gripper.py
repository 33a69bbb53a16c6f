"""A gripper takes a box, lifts it and holds it for a minute. What sticks does not creep."""

import axode
import numpy as np

FORCE, UNTIL = 5.0, 60.0  # N of each finger; s


def box(size: list[float], position: list[float]) -> list[dict[str, object]]:
    return [{"kind": "box", "role": role, "size": size, "position": position} for role in ("visual", "collision")]


def finger(side: int) -> dict[str, object]:
    joint: dict[str, object] = {"name": f"finger {side}", "kind": "prismatic", "axis": [-side, 0, 0]}
    if side < 0:
        joint["follows"] = {"joint": "finger 1"}
    return {"name": f"finger {side}", "on": "palm", "joint": joint, "mass": 0.1, "com": [0.06 * side, 0, 0.04],
            "inertia": [1e-5, 1e-5, 1e-5], "shape": box([0.02, 0.03, 0.04], [0.06 * side, 0, 0.04])}


gripper = axode.Model.from_dict({
    "format": "axode drawing 1", "name": "gripper", "contact": {"friction": 0.6},
    "shape": [{"name": "floor", "kind": "plane", "role": "collision"}],
    "body": [
        {"name": "palm", "joint": {"name": "lift", "kind": "prismatic", "axis": "z"}, "mass": 0.5, "com": [0, 0, 0.1],
         "inertia": [1e-3, 1e-3, 1e-3]},
        finger(1), finger(-1),
        {"name": "box", "joint": "free", "mass": 0.2, "com": [0, 0, 0.03], "inertia": [1.2e-4, 1.2e-4, 1.2e-4],
         "shape": box([0.06, 0.06, 0.06], [0, 0, 0.03])}]})
lift, finger_joint = gripper.joint("lift").v.start, gripper.joint("finger 1").v.start

# The fingers close at once; the palm carries its own weight and rises by 0.2 m between 0.5 and 1.5 s.
KP, KD, PALM = 2000.0, 100.0, 9.81 * 0.7  # N/m, N s/m, N
t = np.linspace(0, 2, 201)
s = np.clip(t - 0.5, 0, 1)
forces = np.zeros((len(t), gripper.nv))
forces[:, finger_joint] = 2 * FORCE
forces[:, lift] = PALM + KP * 0.2 * s * s * (3 - 2 * s)
only_lift = np.arange(gripper.nv) == lift
drive = axode.drives.PD(KP * only_lift, KD * only_lift, gripper.neutral(), feedforward=axode.drives.Sampled(t, forces))

motion = axode.simulate(gripper, gripper.neutral(), np.zeros(gripper.nv), UNTIL, step=1e-2, tau=drive)
poses = axode.poses(gripper, motion.q)
palm, held = gripper.frame_index("palm"), gripper.frame_index("box")
between = np.linalg.inv(poses[:, palm]) @ poses[:, held]
from_here = np.searchsorted(motion.t, 3.0)
moved = np.abs(between[from_here:] - between[from_here]).max()
print(f"the box is lifted by {poses[-1, held, 2, 3]:.4f} m")
print(f"between 3 s and {UNTIL:.0f} s it moves {moved:.0e} m in the gripper")
one, other = (motion.contact_forces(name)[-1] for name in ("finger 1", "finger -1"))
print(f"the fingers press with {one[0]:.3f} N and {-other[0]:.3f} N and together lift {-(one + other)[2]:.4f} N")
print(f"largest certificate {motion.certificates.max():.0e}")
