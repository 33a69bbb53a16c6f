"""Inertial parameters, armatures and joint losses of a mechanism as unknowns without dimension."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from . import pseudo_inertias, redrawing
from .._axode import Model

__all__: list[str] = []

Array = NDArray[np.float64]

#: A body lighter than this part of the whole mechanism counts
#: as known: URDF files have such bodies between two joints.
DUMMY_MASS = 1e-6


class Unknowns:
    """The unknowns x, with parameters = present + matrix @ x, where `present` are the known parameters.

    The ten unknowns of a body are the entries of A in P = L A L^T, where L L^T is the pseudo-inertia of the drawing.
    They have no dimension, depend on the frame of the body only by a rotation, and A = I in the drawing. The unknowns
    of joints are relative to their values in m if these are not 0.
    """

    def __init__(self, m: Model, known: Sequence[str], joint_losses: bool, armature: bool):
        if isinstance(known, str):
            raise TypeError(f"known is {known!r}; expected a list of names of bodies")
        for name in known:
            m.body(name)
        pi = m.parameters.reshape(-1, 10)
        self.known = [name for name, body in zip(m.body_names, pi)
                      if name in known or body[0] <= DUMMY_MASS * m.total_mass]
        self.bodies = [k for k, name in enumerate(m.body_names) if name not in self.known]
        own = [joint for joint in m.joints if joint.nv]
        kinds = armature * ["armature"] + joint_losses * ["damping", "friction"]
        self.joints = [(kind, k) for kind in kinds for joint in own if joint.kind != "free"
                       for k in range(joint.v.start, joint.v.stop)]
        if not self.bodies and not self.joints:
            raise ValueError(f'model "{m.name}" has nothing to identify: each of its bodies is known or has no mass')
        self.names = m.parameter_names + [f"{m.velocity_names[k]} {kind}" for kind, k in self.joints]
        self._drawing = m
        self._of_joints = {kind: np.concatenate([getattr(joint, kind) for joint in own]) for kind in kinds}

        present = np.append(pi.ravel(), [self._of_joints[kind][k] for kind, k in self.joints])
        self.n = 10 * len(self.bodies) + len(self.joints)
        self.matrix, self.inverse = np.zeros((len(self.names), self.n)), np.zeros((self.n, len(self.names)))
        L = pseudo_inertias.roots(pi[self.bodies]) if self.bodies else np.zeros((0, 4, 4))
        for k, body in enumerate(self.bodies):
            W = pseudo_inertias.inertial_parameters(L[k] @ pseudo_inertias.SYMMETRIC @ L[k].T).T
            rows, columns = slice(10 * body, 10 * body + 10), slice(10 * k, 10 * k + 10)
            self.matrix[rows, columns], self.inverse[columns, rows] = W, np.linalg.inv(W)
        of_joints = present[pi.size:]
        #: For each unknown: whether m has a value for it.
        self.drawn = np.append(np.ones(10 * len(self.bodies), bool), of_joints > 0)
        for k, value in enumerate(of_joints):
            row, column, unit = pi.size + k, 10 * len(self.bodies) + k, value if value > 0 else 1.0
            self.matrix[row, column], self.inverse[column, row] = unit, 1 / unit
        self.present = np.where(self.matrix.any(axis=1), 0, present)

    def model(self, parameters: Array) -> Model:
        """The drawing with these parameters."""
        m, n = self._drawing, 10 * self._drawing.n_bodies
        if self.joints:
            of_joints = {kind: values.copy() for kind, values in self._of_joints.items()}
            for (kind, k), value in zip(self.joints, parameters[n:]):
                of_joints[kind][k] = value
            m = redrawing.with_joints(m, of_joints)
        return m.with_parameters(parameters[:n])
