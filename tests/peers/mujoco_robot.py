"""A robot in MuJoCo, in the conventions of axode.

MuJoCo's free joint has its velocity as (linear part in inertial axes; angular part in body axes) and its position
before its quaternion w x y z. Its URDF reader ignores mimic joints, so that this file couples them by a matrix.
"""

import xml.etree.ElementTree as ElementTree

import mujoco
import numpy as np
from coordinates import FREE_BASE, CoupledCoordinates


class CannotLoad(Exception):
    pass


def without_geometry(file, base):
    """The text of a URDF without elements that need a mesh, and with a floating joint if the base is free."""
    root = ElementTree.parse(file).getroot()
    for link in root.findall("link"):
        for element in link.findall("visual") + link.findall("collision"):
            link.remove(element)
    for element in root.findall("mujoco"):
        root.remove(element)
    for element in root.iter():  # a link of this name would be MuJoCo's world itself
        for key in ("name", "link"):
            if element.get(key) == "world":
                element.set(key, "root of the robot")
    if base == "free":
        children = {joint.find("child").get("link") for joint in root.findall("joint")}
        base_link = next(link.get("name") for link in root.findall("link") if link.get("name") not in children)
        ElementTree.SubElement(root, "link", {"name": "inertial frame"})
        joint = ElementTree.SubElement(root, "joint", {"name": FREE_BASE, "type": "floating"})
        ElementTree.SubElement(joint, "parent", {"link": "inertial frame"})
        ElementTree.SubElement(joint, "child", {"link": base_link})
    options = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(options, "compiler", {"fusestatic": "true", "strippath": "true", "balanceinertia": "false"})
    return ElementTree.tostring(root, encoding="unicode")


class Robot(CoupledCoordinates):
    def __init__(self, file, base):
        try:
            self.model = mujoco.MjModel.from_xml_string(without_geometry(file, base))
        except ValueError as error:
            raise CannotLoad(str(error).splitlines()[0]) from error
        self.data = mujoco.MjData(self.model)
        super().__init__(file)
        self.joints = {self.model.joint(k).name: self.model.joint(k) for k in range(self.model.njnt)}

    def set(self, values):
        """Sets q and v from lists of numbers by joint."""
        for name, joint in self.joints.items():
            if name == FREE_BASE:
                x, y, z, w, *position = values["q"][name]
                self.data.qpos[joint.qposadr[0]:joint.qposadr[0] + 7] = [*position, w, x, y, z]
            else:
                self.data.qpos[joint.qposadr[0]] = self.follow(name, values["q"], with_offset=True)
        self.R = np.eye(3)
        mujoco.mj_kinematics(self.model, self.data)
        if FREE_BASE in self.joints:
            self.R = self.data.xmat[self.model.jnt_bodyid[self.joints[FREE_BASE].id]].reshape(3, 3)
        self.data.qvel[:] = self.velocities(values["v"])
        mujoco.mj_forward(self.model, self.data)

    def velocities(self, values):
        v = np.zeros(self.model.nv)
        for name, joint in self.joints.items():
            at = joint.dofadr[0]
            if name == FREE_BASE:
                v[at:at + 3], v[at + 3:at + 6] = self.R @ values[name][3:], values[name][:3]
            else:
                v[at] = self.follow(name, values, with_offset=False)
        return v

    def mass_matrix(self):
        M = np.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(M, np.eye(self.model.nv)):
            mujoco.mj_mulM(self.model, self.data, column, unit)
        return M
