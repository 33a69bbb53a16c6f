"""Pseudo-inertias P = [[S, m c], [m c^T, m]] of bodies, and coordinates of symmetric 4 x 4 matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__: list[str] = []

Array = NDArray[np.float64]


def pseudo_inertia(pi: Array) -> Array:
    """P (..., 4, 4) of inertial parameters (..., 10)."""
    xx, yy, zz, xy, xz, yz = np.moveaxis(pi[..., 4:], -1, 0)
    P = np.empty((*pi.shape[:-1], 4, 4))
    for k, twice_S in enumerate([yy + zz - xx, xx + zz - yy, xx + yy - zz]):
        P[..., k, k] = twice_S / 2
    for i, j, product in [(0, 1, xy), (0, 2, xz), (1, 2, yz)]:
        P[..., i, j] = P[..., j, i] = -product
    P[..., :3, 3] = P[..., 3, :3] = pi[..., 1:4]
    P[..., 3, 3] = pi[..., 0]
    return P


def inertial_parameters(P: Array) -> Array:
    """The inverse of `pseudo_inertia`."""
    S = np.diagonal(P, axis1=-2, axis2=-1)[..., :3]
    Theta = S.sum(axis=-1, keepdims=True) - S
    products = -np.stack([P[..., 0, 1], P[..., 0, 2], P[..., 1, 2]], axis=-1)
    return np.concatenate([P[..., 3:, 3], P[..., :3, 3], Theta, products], axis=-1)


def _symmetric_basis() -> Array:
    E = np.zeros((10, 4, 4))
    pairs = [(0, 0), (1, 1), (2, 2), (3, 3), (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    for k, (i, j) in enumerate(pairs):
        E[k, i, j] = E[k, j, i] = 1 if i == j else np.sqrt(0.5)
    return E


#: An orthonormal basis of the symmetric 4 x 4 matrices, (10, 4, 4).
SYMMETRIC = _symmetric_basis()


def coordinates(A: Array) -> Array:
    """Coordinates (..., 10) of symmetric matrices (..., 4, 4) in the basis SYMMETRIC."""
    return np.asarray(np.einsum("kij,...ij->...k", SYMMETRIC, A))


def roots(pi: Array) -> Array:
    """Roots L of P = L L^T for the bodies of the drawing, (n, 10) to (n, 4, 4). Rods and points have no positive
    definite P and therefore get some extension: 3 % of their length, and 10 % of that of the largest body."""
    P = pseudo_inertia(pi)
    m, c = P[:, 3, 3], P[:, :3, 3] / P[:, 3:, 3]
    S, axes = np.linalg.eigh(P[:, :3, :3] - m[:, None, None] * c[:, :, None] * c[:, None, :])
    size = max(float((S[:, 2] / m).max()), 0.0) or 0.01  # m^2
    least = np.where(S[:, 2] > 1e-8 * m * size, 1e-3 * S[:, 2], 1e-2 * m * size)
    L = np.zeros_like(P)
    L[:, :3, :3] = axes * np.sqrt(np.maximum(S, least[:, None]))[:, None, :]
    L[:, :3, 3] = c * np.sqrt(m)[:, None]
    L[:, 3, 3] = np.sqrt(m)
    return L

