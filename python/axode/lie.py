"""SE(3), screws, and single rigid bodies.

All functions take arrays of one item or of many items, with any axes in front: exp maps (..., 6) to (..., 4, 4).
Arguments must have the same leading axes, or none. Results are new arrays of float64.

Screws and twists are (angular; linear), wrenches (moment; force), quaternions x y z w; poses are matrices [[R, r],
[0, 1]] that map coordinates in a frame to coordinates in the frame in which the pose is given. Linear maps of screws,
such as Ad, ad and dexp, are matrices, to be used with @. The functions dexp are right-trivialised. SI units.

>>> X = axode.lie.screw([0, 0, 1], [1, 0, 0])  # turns about the axis in z through (1, 0, 0)
>>> C = axode.lie.exp(np.linspace(0, np.pi, 3)[:, None] * X)
>>> C.shape
(3, 4, 4)
>>> C[1].round(3)
array([[ 0., -1.,  0.,  1.],
       [ 1.,  0.,  0., -1.],
       [ 0.,  0.,  1.,  0.],
       [ 0.,  0.,  0.,  1.]])
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .support import signatures
from ._axode.lie import (
    acceleration,
    Ad,
    ad,
    box_inertia,
    capsule_inertia,
    cay,
    cay_inv,
    cay_inv_SO3,
    cay_of_ad,
    cay_of_ad_inv,
    cay_quaternion,
    cay_SO3,
    center_of_mass,
    change_momentum,
    change_twist,
    change_twist_rate,
    change_wrench,
    cylinder_inertia,
    dcay,
    dcay_inv,
    dcay_inv_of_ad,
    dcay_inv_SO3,
    dcay_of_ad,
    dcay_SO3,
    ddcay,
    ddcay_inv,
    ddcay_inv_of_ad,
    ddcay_inv_SO3,
    ddcay_of_ad,
    ddcay_SO3,
    ddexp,
    ddexp_inv,
    ddexp_inv_SO3,
    ddexp_SO3,
    dexp,
    dexp_inv,
    dexp_inv_SO3,
    dexp_SO3,
    exchange_halves,
    exp,
    exp_quaternion,
    exp_SO3,
    from_hat,
    from_scalar_first,
    from_skew,
    hat,
    inertia,
    inertia_about_com,
    inertia_in_frames,
    inverse,
    log,
    log_quaternion,
    log_SO3,
    mesh_inertia,
    mesh_volume,
    newton_euler,
    newton_euler_in_frames,
    pluecker,
    quaternion,
    quaternion_product,
    realisability,
    reciprocal_product,
    rotation,
    rotation_to,
    scalar_first,
    screw,
    screw_axis,
    skew,
    sphere_inertia,
    transform_inertia,
    twist_in_frames,
    twist_rate_in_frames,
    wrench_in_frames,
)

__all__ = [
    "Ad",
    "FramePair",
    "ScrewAxis",
    "acceleration",
    "ad",
    "box_inertia",
    "capsule_inertia",
    "cay",
    "cay_SO3",
    "cay_inv",
    "cay_inv_SO3",
    "cay_of_ad",
    "cay_of_ad_inv",
    "cay_quaternion",
    "center_of_mass",
    "change_momentum",
    "change_twist",
    "change_twist_rate",
    "change_wrench",
    "cylinder_inertia",
    "dcay",
    "dcay_SO3",
    "dcay_inv",
    "dcay_inv_SO3",
    "dcay_inv_of_ad",
    "dcay_of_ad",
    "ddcay",
    "ddcay_SO3",
    "ddcay_inv",
    "ddcay_inv_SO3",
    "ddcay_inv_of_ad",
    "ddcay_of_ad",
    "ddexp",
    "ddexp_SO3",
    "ddexp_inv",
    "ddexp_inv_SO3",
    "dexp",
    "dexp_SO3",
    "dexp_inv",
    "dexp_inv_SO3",
    "exchange_halves",
    "exp",
    "exp_SO3",
    "exp_quaternion",
    "from_hat",
    "from_scalar_first",
    "from_skew",
    "hat",
    "inertia",
    "inertia_about_com",
    "inertia_in_frames",
    "inverse",
    "log",
    "log_SO3",
    "log_quaternion",
    "mesh_inertia",
    "mesh_volume",
    "newton_euler",
    "newton_euler_in_frames",
    "pluecker",
    "quaternion",
    "quaternion_product",
    "realisability",
    "reciprocal_product",
    "rotation",
    "rotation_to",
    "scalar_first",
    "screw",
    "screw_axis",
    "skew",
    "sphere_inertia",
    "transform_inertia",
    "twist_in_frames",
    "twist_rate_in_frames",
    "wrench_in_frames",
]


class ScrewAxis(NamedTuple):
    """The geometry of screws, in the order of the arguments of `screw`.

    >>> axode.lie.screw_axis([0, 0, 0, 0, 3, 0]).e  # a translation
    array([0., 1., 0.])
    """

    e: NDArray[np.float64]
    """Direction, a unit vector, (..., 3)."""
    p: NDArray[np.float64]
    """The point of the axis that is nearest to the origin, m, (..., 3)."""
    h: NDArray[np.float64]
    """Pitch, m/rad, (...); inf for a translation."""
    magnitude: NDArray[np.float64]
    """(...), e.g. rad/s of a twist that turns, m/s of one that does not."""


class FramePair(NamedTuple):
    """A frame F_j, at whose origin motions and forces are measured, and a frame F_k, in whose axes they are resolved.

    Both frames may move; all four members are in the inertial frame, with any axes in front. If both are the body
    frame, the representation is the body-fixed one; if both are the inertial frame, it is the spatial one.

    >>> V = axode.twists(arm, arm.neutral(), np.ones(7), "spatial")[arm.frame_index("flange")]
    >>> tip = axode.poses(arm, arm.neutral())[arm.frame_index("flange"), :3, 3]
    >>> jk = axode.lie.FramePair(r_j=tip, dr_j=[0, 0, 0], R_k=np.eye(3), w_k=[0, 0, 0])  # now as hybrid
    >>> np.allclose(axode.lie.twist_in_frames(jk, V), axode.twists(arm, arm.neutral(), np.ones(7), "hybrid")[9])
    True
    """

    r_j: ArrayLike
    """Position of the origin of F_j, m, (..., 3)."""
    dr_j: ArrayLike
    """Its velocity, m/s, (..., 3)."""
    R_k: ArrayLike
    """Rotation of F_k, (..., 3, 3)."""
    w_k: ArrayLike
    """Angular velocity of F_k, rad/s, (..., 3)."""


signatures.explain_calls(__name__)
