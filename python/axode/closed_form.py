"""Kinematics and dynamics of the whole system in matrices, equation by equation as in the paper.

The functions are meant for analysis and for reading the paper; those of `axode` give the same results and are faster.
Vectors of the system are the twists of the moving bodies 1 to n stacked, (6n,), each with the angular part before the
linear one, in the frames in which the bodies were placed. All functions take one state: q (nq,), v and a (nv,);
anything else is a ValueError.

>>> q, v = arm.random(), np.ones(7)
>>> A, D, X = axode.closed_form.system_matrices(arm, q, "spatial")
>>> np.allclose((A @ X @ v)[-6:], axode.twists(arm, q, v, "spatial")[arm.n_bodies])
True
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .support import signatures
from ._axode.closed_form import (
    a_matrix,
    b_matrix,
    christoffel,
    coriolis_matrix,
    inertia_matrix,
    joint_accelerations,
    joint_velocities,
    lagrange_equations,
    mass_matrix,
    momentum_balance,
    poses_by_body_screws,
    poses_by_spatial_screws,
    projection_equations,
    spatial_factors,
    system_acceleration,
    system_matrices,
    system_twist,
)

__all__ = [
    "SpatialFactors",
    "SystemMatrices",
    "a_matrix",
    "b_matrix",
    "christoffel",
    "coriolis_matrix",
    "inertia_matrix",
    "joint_accelerations",
    "joint_velocities",
    "lagrange_equations",
    "mass_matrix",
    "momentum_balance",
    "poses_by_body_screws",
    "poses_by_spatial_screws",
    "projection_equations",
    "spatial_factors",
    "system_acceleration",
    "system_matrices",
    "system_twist",
]


class SystemMatrices(NamedTuple):
    """V = A X v with A = (I - D)^-1; see `system_matrices`.

    >>> axode.closed_form.system_matrices(arm, arm.neutral()).X.shape
    (42, 7)
    """

    A: NDArray[np.float64]
    """(6n, 6n)."""
    D: NDArray[np.float64]
    """(6n, 6n)."""
    X: NDArray[np.float64]
    """(6n, nv)."""


class SpatialFactors(NamedTuple):
    """J^s = A_s Y_s = A_sb X^b; see `spatial_factors`.

    >>> axode.closed_form.spatial_factors(arm, arm.neutral()).Y_s.shape
    (42, 7)
    """

    A_s: NDArray[np.float64]
    """(6n, 6n)."""
    Y_s: NDArray[np.float64]
    """(6n, nv)."""
    A_sb: NDArray[np.float64]
    """(6n, 6n)."""


signatures.explain_calls(__name__)
