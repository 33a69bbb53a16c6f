"""Coordinates of robots by joint. The coordinate of a mimic joint is a function of that of its leader."""

import xml.etree.ElementTree as ElementTree

import numpy as np

FREE_BASE = "free_base"


def mimic_joints(file):
    """Follower -> (leader, ratio, offset) of the mimic joints that move, read from the file."""
    found = {}
    for joint in ElementTree.parse(file).getroot().findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and joint.get("type") != "fixed":
            found[joint.get("name")] = (mimic.get("joint"), float(mimic.get("multiplier", 1)),
                                        float(mimic.get("offset", 0)))
    return found


class CoupledCoordinates:
    """Common part of the robots in other libraries. These have `mimic`, and velocities(values) in the order of their
    library."""

    def __init__(self, file):
        self.mimic = mimic_joints(file)

    def follow(self, name, values, with_offset):
        """The coordinate, or the velocity, of a joint from lists of numbers for the independent joints."""
        if name not in self.mimic:
            return values[name][0]
        leader, ratio, offset = self.mimic[name]
        return ratio * self.follow(leader, values, with_offset) + (offset if with_offset else 0)

    def velocity_map(self, joints):
        """The matrix P with which the velocities v of the other library are P times those of the independent joints
        in the order of `joints`."""
        sizes = [6 if name == FREE_BASE else 1 for name in joints]
        columns = []
        for at in np.eye(sum(sizes)):
            values, start = {}, 0
            for name, size in zip(joints, sizes):
                values[name] = at[start:start + size].tolist()
                start += size
            columns.append(self.velocities(values))
        return np.array(columns).T
