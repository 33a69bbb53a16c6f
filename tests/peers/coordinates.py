"""Coordinates of robots by joint, in which a mimic joint is a function of its leader."""

import xml.etree.ElementTree as ElementTree

import numpy as np

FREE_BASE = "free_base"


def mimic_joints(file):
    """Follower -> (leader, ratio, offset) of the joints that move, from the file itself."""
    found = {}
    for joint in ElementTree.parse(file).getroot().findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and joint.get("type") != "fixed":
            found[joint.get("name")] = (mimic.get("joint"), float(mimic.get("multiplier", 1)),
                                        float(mimic.get("offset", 0)))
    return found


class CoupledCoordinates:
    """What a robot in another library has besides: `mimic`, and velocities(values) in that library's order."""

    def __init__(self, file):
        self.mimic = mimic_joints(file)

    def follow(self, name, values, with_offset):
        """The coordinate, or velocity, of a joint from lists of numbers by independent joint."""
        if name not in self.mimic:
            return values[name][0]
        leader, ratio, offset = self.mimic[name]
        return ratio * self.follow(leader, values, with_offset) + (offset if with_offset else 0)

    def velocity_map(self, joints):
        """P with the other library's v = P times the velocities of independent joints in the order of `joints`."""
        sizes = [6 if name == FREE_BASE else 1 for name in joints]
        columns = []
        for at in np.eye(sum(sizes)):
            values, start = {}, 0
            for name, size in zip(joints, sizes):
                values[name] = at[start:start + size].tolist()
                start += size
            columns.append(self.velocities(values))
        return np.array(columns).T
