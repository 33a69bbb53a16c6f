"""An arm with springs between its motors and links: controllers of the motors lead it to a target."""

import axode
import numpy as np

rigid = axode.load(axode.robots / "arm7.toml")
stiffness = {"A1": 8e3, "A2": 8e3, "A3": 5e3, "A4": 5e3, "A5": 3e3, "A6": 2e3, "A7": 1e3}  # N m/rad
rotor = 0.5  # kg m^2, behind the gear

# Each joint becomes two: one that the motor turns, with the rotor's inertia, and one that its spring holds.
drawing = rigid.to_dict()
bodies = []
for body in drawing["body"]:
    joint = body["joint"]
    if joint != "fixed":
        motor = "motor " + joint["name"]
        place = {key: joint[key] for key in ("kind", "axis", "point")}
        bodies.append({"name": motor, "on": body["on"],
                       "joint": {**place, "name": motor, "effort": joint["effort"], "armature": rotor}})
        body = {**body, "on": motor,
                "joint": {**place, "name": joint["name"], "spring": {"stiffness": stiffness[joint["name"]]}}}
    bodies.append(body)
arm = axode.Model.from_dict({**drawing, "body": bodies})
motors = np.array([name.startswith("motor") for name in arm.velocity_names])

# The motors are controlled to the target as those of a rigid arm,
# with its weight compensated. The springs are not taken into account.
start, target = np.zeros(arm.nv), np.zeros(arm.nv)
target[motors] = [0.4, 0.6, -0.3, -0.8, 0.2, 0.5, 0.1]
weight = np.where(motors, axode.gravity_torques(arm, target), 0)
drive = axode.drives.PD(np.where(motors, 900.0, 0.0), np.where(motors, 110.0, 0.0), target, feedforward=weight, clip=True)

# The last links are light and their springs stiff: an implicit method need not follow how they ring.
motion = axode.simulate(arm, start, np.zeros(arm.nv), until=5.0, tau=drive, method="generalized_alpha", step=2e-3)
print(f"{motion.steps} steps, {motion.evaluations / motion.steps:.1f} evaluations in each")
for t in (0.1, 0.5, 1.0, 5.0):
    q, v = motion.at(t)
    springs = axode.spring_forces(arm, q, v)[~motors]
    print(f"t = {t:.1f} s: motors {np.linalg.norm((q - target)[motors]):.4f} rad from the target, "
          f"links {1e3 * np.abs(q[~motors]).max():.2f} mrad behind, springs up to {np.abs(springs).max():.1f} N m")

rest = axode.gravity_torques(arm, motion.q[-1])[~motors]
print("the springs carry the weight:", np.allclose(springs, rest, atol=0.5))
