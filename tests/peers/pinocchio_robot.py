"""A robot in Pinocchio, in the conventions of axode.

Angular before linear, quaternions before positions, angles instead of cosines and sines, joints by name, and
mimic joints as functions of their leaders, whose generalised forces take the share of their followers.
"""

import numpy as np
import pinocchio as pin
from coordinates import FREE_BASE, CoupledCoordinates

LOCAL, WORLD = pin.ReferenceFrame.LOCAL, pin.ReferenceFrame.WORLD
ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class Robot(CoupledCoordinates):
    def __init__(self, file, base):
        root = [pin.JointModelFreeFlyer(), FREE_BASE] if base == "free" else []
        self.model = pin.buildModelFromUrdf(str(file), *root)
        self.data = self.model.createData()
        super().__init__(file)
        self.links = {frame.name: index for index, frame in enumerate(self.model.frames)
                      if frame.type == pin.FrameType.BODY}
        self.joints = {name: self.model.joints[index] for index, name in enumerate(self.model.names)
                       if index > 0}

    def independent_joints(self):
        return [name for name in self.joints if name not in self.mimic]

    def coordinates(self, values):
        """The q of Pinocchio from lists of numbers by joint."""
        q = np.zeros(self.model.nq)
        for name, joint in self.joints.items():
            if name == FREE_BASE:
                q[joint.idx_q:joint.idx_q + 7] = values[name][4:] + values[name][:4]
                continue
            angle = self.follow(name, values, with_offset=True)
            turns = joint.nq == 2
            q[joint.idx_q:joint.idx_q + joint.nq] = [np.cos(angle), np.sin(angle)] if turns else [angle]
        return q

    def velocities(self, values):
        """The v or a of Pinocchio from lists of numbers by joint."""
        v = np.zeros(self.model.nv)
        for name, joint in self.joints.items():
            v[joint.idx_v:joint.idx_v + joint.nv] = (values[name][3:] + values[name][:3] if name == FREE_BASE
                                                     else self.follow(name, values, with_offset=False))
        return v

    def update(self, q, v, a):
        pin.forwardKinematics(self.model, self.data, q, v, a)
        pin.updateFramePlacements(self.model, self.data)

    def inverse_dynamics(self, q, v, a, loads):
        """tau with loads (link, representation, wrench); leaves the joints' wrenches in data.f."""
        self.update(q, v, a)
        return pin.rnea(self.model, self.data, q, v, a, self.on_joints(loads))

    def on_joints(self, loads):
        """The forces of loads on every joint; after update()."""
        on_joints = [pin.Force.Zero() for _ in range(self.model.njoints)]
        for link, representation, wrench in loads:
            frame, C = self.model.frames[self.links[link]], self.pose(link)
            moment, force = np.array(wrench[:3]), np.array(wrench[3:])
            R_t = C.rotation.T
            local = {"body": lambda: pin.Force(force, moment),
                     "spatial": lambda: C.actInv(pin.Force(force, moment)),
                     "hybrid": lambda: pin.Force(R_t @ force, R_t @ moment),
                     "mixed": lambda: pin.Force(R_t @ force, moment)}[representation]()
            on_joints[frame.parentJoint] += frame.placement.act(local)
        return on_joints

    def joint_wrench(self, name):
        """The wrench that a joint transmits, in the frame of its child link."""
        force = self.data.f[self.model.getJointId(name)]
        return np.concatenate([force.angular, force.linear])

    def pose(self, link):
        return self.data.oMf[self.links[link]]

    def twist(self, link, representation):
        def velocity(frame):
            return pin.getFrameVelocity(self.model, self.data, self.links[link], frame)
        return self._motion(velocity, velocity, representation)

    def acceleration(self, link, representation):
        """The time derivative of the components of the twist: Pinocchio's `acceleration` is that of local and
        spatial twists, its `classical acceleration` holds r''."""
        def spatial(frame):
            return pin.getFrameAcceleration(self.model, self.data, self.links[link], frame)

        def classical(frame):
            return pin.getFrameClassicalAcceleration(self.model, self.data, self.links[link], frame)
        return self._motion(spatial, classical, representation)

    def jacobian(self, link, representation):
        """Angular rows first, a column for each of Pinocchio's velocities; after computeJointJacobians."""
        def of(frame):
            return pin.getFrameJacobian(self.model, self.data, self.links[link], frame)
        return self._rows(of, representation)

    def jacobian_rate(self, link, representation):
        """The time derivative of the Jacobian; after computeJointJacobiansTimeVariation."""
        def of(frame):
            return pin.getFrameJacobianTimeVariation(self.model, self.data, self.links[link], frame)
        return self._rows(of, representation)

    @staticmethod
    def _rows(of, representation):
        angular, linear = {"body": (LOCAL, LOCAL), "spatial": (WORLD, WORLD), "hybrid": (ALIGNED, ALIGNED),
                           "mixed": (LOCAL, ALIGNED)}[representation]
        return np.vstack([of(angular)[3:], of(linear)[:3]])

    @staticmethod
    def _motion(of_screw, of_origin, representation):
        angular, linear = {"body": (of_screw(LOCAL).angular, of_screw(LOCAL).linear),
                           "spatial": (of_screw(WORLD).angular, of_screw(WORLD).linear),
                           "hybrid": (of_origin(ALIGNED).angular, of_origin(ALIGNED).linear),
                           "mixed": (of_screw(LOCAL).angular, of_origin(ALIGNED).linear)}[representation]
        return np.concatenate([angular, linear])
