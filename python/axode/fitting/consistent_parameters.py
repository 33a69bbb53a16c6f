"""Parameters to which mass distributions belong: the minimum of chi^2 / 2 and the divergence from the drawing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .base_parameters import BaseParameters, Torques
from .inertial_unknowns import Unknowns
from .pseudo_inertias import SYMMETRIC, coordinates

__all__: list[str] = []

Array = NDArray[np.float64]


class ConsistentParameters:
    """The consistent parameters: the minimum of |G x - c|^2 / 2 + sum of mu D, by Newton's method from the drawing.

    D is tr A - log det A - 4 for a body, and y - log y - 1 for a parameter x = y scale of a joint. This function is
    self-concordant: if the decrement is small, full steps converge. mu is decreased from a value at which the drawing
    is nearly the minimum.
    """

    def __init__(self, unknowns: Unknowns, data: Torques, base: BaseParameters, prior: float, linalg: Any):
        self._linalg, self._n_bodies = linalg, len(unknowns.bodies)
        self._G, self._c = base.S @ base.V.T, base.c
        joints = slice(10 * self._n_bodies, None)
        torque = np.array([np.linalg.norm(data.b[:, k]) for _, k in unknowns.joints])
        size = data.sizes.sum(axis=0)[joints]
        hundredth = 0.01 * torque / np.where(size > 0, size, 1)
        self._scale = np.where(unknowns.drawn[joints] | (hundredth == 0), 1, hundredth)
        self.x = np.append(np.tile(coordinates(np.eye(4)), self._n_bodies), self._scale)

        mu = 1 / np.where(unknowns.drawn, prior, max(prior, 10.0))**2
        stronger = max(float(np.linalg.norm(self._G.T @ (self._c - self._G @ self.x)) / mu.min()), 1.0)
        self.settled = False
        for self.iterations in range(1, 201):
            decrement = self._step(mu * stronger)
            self.settled = stronger == 1 and decrement < 1e-3
            if self.settled:
                break
            if decrement < 0.5:
                stronger = max(stronger / 5, 1.0)
        rows, _ = self._divergence(mu)
        self.covariance_root = self._factor(rows)[1]

    def _A(self, x: Array) -> tuple[Array, Array]:
        """The matrices A (n, 4, 4) of the bodies, and y of the joints."""
        bodies = x[:10 * self._n_bodies].reshape(-1, 10)
        return np.einsum("bk,kij->bij", bodies, SYMMETRIC), x[10 * self._n_bodies:] / self._scale

    def _divergence(self, mu: Array) -> tuple[Array, Array]:
        """(K, d), from which follow the Hessian K^T K and the gradient -K^T d of sum mu D at x.

        With A = U U^T, of a change Z in dA = U Z U^T: the Hessian is |Z|^2, the gradient tr((U^T U - I) Z)."""
        A, y = self._A(self.x)
        U = np.linalg.cholesky(A)
        V = np.linalg.inv(U)
        K, d = np.zeros((len(mu), len(mu))), np.empty(len(mu))
        for k in range(self._n_bodies):
            own = slice(10 * k, 10 * k + 10)
            K[own, own] = coordinates(V[k] @ SYMMETRIC @ V[k].T).T
            d[own] = coordinates(np.eye(4) - U[k].T @ U[k])
        joints = np.arange(10 * self._n_bodies, len(mu))
        K[joints, joints], d[joints] = 1 / (self._scale * y), 1 - y
        return np.sqrt(mu)[:, None] * K, np.sqrt(mu) * d

    def _factor(self, K: Array) -> tuple[Array, Array]:
        """Q and B of J = [G; K] = Q B^-1; B B^T is the inverse of the Hessian J^T J."""
        Q, R, order = self._linalg.qr(np.vstack([self._G, K]), mode="economic", pivoting=True)
        B = np.empty_like(R)
        B[order] = self._linalg.solve_triangular(R, np.eye(len(R)))
        return Q, B

    def _step(self, mu: Array) -> float:
        """Takes a step of Newton's method. Returns the decrement before it, in units of the divergence."""
        K, d = self._divergence(mu)
        Q, B = self._factor(K)
        r = self._c - self._G @ self.x
        reduced = Q.T @ np.append(r, d)
        dx = B @ reduced
        decrement = float(np.linalg.norm(reduced) / np.sqrt(mu.min()))
        before, t = self._A(self.x), 1.0
        Gdx = self._G @ dx
        while decrement > 0.3:
            after = self._A(self.x + t * dx)
            if (change := self._change(before, after, mu)) is not None:
                change += t * (t / 2 * Gdx @ Gdx - r @ Gdx)
                if change <= -0.1 * t * (reduced @ reduced):
                    break
            t /= 2
            if t < 1e-12:
                break
        self.x = self.x + t * dx
        return decrement

    def _change(self, before: tuple[Array, Array], after: tuple[Array, Array], mu: Array) -> float | None:
        """The change of sum mu D; None if it is infinite."""
        if np.any(after[1] <= 0) or np.any(np.linalg.eigvalsh(after[0]) <= 0):
            return None

        def divergence(A: Array, y: Array) -> float:
            of_bodies = np.trace(A, axis1=1, axis2=2) - np.linalg.slogdet(A)[1]
            n = 10 * self._n_bodies
            return float(mu[0:n:10] @ of_bodies + mu[n:] @ (y - np.log(y)))

        return divergence(*after) - divergence(*before)
