"""Measured torques, the base parameters that they determine, and the least-squares estimate of these."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import least_squares
from .inertial_unknowns import Unknowns
from .least_squares import huber_weight, spectrum, triangle
from .._axode import Model, inverse_dynamics, jacobian_columns, regressor
from ..records import Load

__all__: list[str] = []

Array = NDArray[np.float64]

#: Singular values of the balanced regressor below this part of the largest one count as rounding errors.
RANK_TOLERANCE = 1e-11
#: The least noise of a torque, relative to its size; it is
#: also at least a thousandth of this for the largest torque.
NOISE_FLOOR = 1e-6
#: Huber's threshold in standard deviations: 95 % efficient if there are no outliers.
HUBER = 1.345


class Torques:
    """The torques b that are due to the unknowns x, and their regressor X: b = X x.

    The samples of velocity k are needed only in the form of the factor R of their rows, [X, b] = Q R.
    """

    def __init__(self, m: Model, unknowns: Unknowns, samples: list[Array], loads: Sequence[Load] | None,
                 joint_losses: bool):
        q, v, a, tau = samples
        self._m, self._unknowns, self._states = m, unknowns, (q, v, a)
        rest = unknowns.model(unknowns.present)
        self.b = tau - inverse_dynamics(rest, q, v, a, loads=loads, joint_losses=joint_losses)
        self.N, self.nv = self.b.shape
        active = np.zeros((m.nv, unknowns.n), bool)
        for k, body in enumerate(unknowns.bodies):
            active[jacobian_columns(m, q[0], m.body_names[body])[0], 10 * k:10 * k + 10] = True
        for column, (_, k) in enumerate(unknowns.joints, start=10 * len(unknowns.bodies)):
            active[k, column] = True
        self.columns = [np.flatnonzero(of_k) for of_k in active]
        self._squares = np.zeros((m.nv, len(unknowns.names)))
        self.R, _ = self.factors(np.zeros(unknowns.n), np.full(m.nv, np.inf))
        #: (nv, n) roots of the sums of squares of X, no less
        #: than those of the terms that its entries are sums of.
        self.sizes = np.sqrt(self._squares) @ np.abs(unknowns.matrix)

    def _regressor(self) -> Iterator[tuple[slice, Array]]:
        """The regressor of all parameters, block by block."""
        q, v, a = self._states
        width = len(self._unknowns.names)
        for part in least_squares.blocks(self.N, self.nv * width):
            inertial = regressor(self._m, q[part], v[part], a[part])
            Y = np.concatenate([inertial, np.zeros((*v[part].shape, width - inertial.shape[2]))], axis=2)
            for column, (kind, k) in enumerate(self._unknowns.joints, start=inertial.shape[2]):
                Y[:, k, column] = {"armature": a, "damping": v, "friction": np.sign(v)}[kind][part, k]
            yield part, Y

    def factors(self, x: Array, noise: Array) -> tuple[list[Array], Array]:
        """The factor R of each velocity, for samples with Huber's weights, and the residuals b - X x, (N, nv)."""
        R = [np.zeros((0, len(columns) + 1)) for columns in self.columns]
        e = np.empty_like(self.b)
        self._squares[:] = 0
        for part, Y in self._regressor():
            self._squares += np.einsum("nki,nki->ki", Y, Y)
            for k, columns in enumerate(self.columns):
                X = Y[:, k] @ self._unknowns.matrix[:, columns]
                e[part, k] = self.b[part, k] - X @ x[columns]
                weight = huber_weight(e[part, k] / noise[k], HUBER)
                rows = np.column_stack([X, self.b[part, k]]) * np.sqrt(weight)[:, None]
                R[k] = triangle(np.vstack([R[k], rows]))
        return R, e

    def largest_of_body(self, sizes: Array) -> Array:
        """For each unknown, the largest value of its body."""
        n = 10 * len(self._unknowns.bodies)
        return np.append(np.repeat(sizes[:n].reshape(-1, 10).max(axis=1), 10), sizes[n:])

    def projected(self, R: list[Array], lift: Array) -> list[tuple[Array, Array]]:
        """The pair (X, b) of each velocity for unknowns x = lift @ z."""
        return [(R_k[:, :-1] @ lift[columns], R_k[:, -1]) for R_k, columns in zip(R, self.columns)]

    def residual(self, x: Array) -> Array:
        """The root mean square of b - X x for each velocity, (nv,)."""
        problems = self.projected(self.R, x[:, None])
        return np.array([np.linalg.norm(b - X[:, 0]) / np.sqrt(self.N) for X, b in problems])


class BaseParameters:
    """The base parameters z = V^T x that the motions determine, and their weighted least squares estimate, the minimum
    of |S z - c|."""

    def __init__(self, data: Torques, given: Array | None, robust: bool):
        self._data, self._estimate = data, given is None
        rms = np.sqrt(np.mean(data.b**2, axis=0))
        self._least_noise = NOISE_FLOOR * np.maximum(rms, 1e-3 * (rms.max() or 1.0))
        sizes = np.array([np.linalg.norm(R[:, :-1]) for R in data.R]) / np.sqrt(data.N)
        balanced = np.where(sizes > 0, sizes, 1)
        self._find_rank(balanced)
        self.noise = balanced if given is None else given
        self._weigh()
        if robust:
            self._resist_outliers()

    def _find_rank(self, balanced: Array) -> None:
        """Determines the rank from the singular values of X, after scaling velocities and bodies to the same size.
        Single columns are not scaled, because columns that should be 0 contain rounding errors."""
        data = self._data
        sizes = np.linalg.norm(data.sizes / balanced[:, None], axis=0)
        scale = np.maximum(data.largest_of_body(sizes), 1e-4 * sizes.max()) if sizes.any() else np.ones_like(sizes)
        X = []
        for R, columns, size in zip(data.R, data.columns, balanced):
            rows = np.zeros((len(R), len(scale)))
            rows[:, columns] = R[:, :-1] / size
            X.append(rows / scale)
        seen = spectrum(triangle(np.vstack(X)), RANK_TOLERANCE)
        self.rank = seen.rank
        if not self.rank:
            raise ValueError("q, v, a: no torque of these motions depends on the parameters to identify")
        self.V = scale[:, None] * seen.Vt.T
        self.lift = seen.Vt.T / scale[:, None]  # V^T lift = 1
        self.null_space = seen.null_space / scale[:, None]

    def _solve(self, problems: list[tuple[Array, Array]], noise: Array) -> None:
        rows = np.vstack([np.column_stack(problem) / s for problem, s in zip(problems, noise)])
        R = triangle(rows)[:self.rank]
        self.S, self.c = R[:, :-1], R[:, -1]
        self.covariance_root = np.linalg.inv(self.S)
        self.z = self.covariance_root @ self.c

    def _weigh(self) -> None:
        """Weights the velocities by iteratively reweighted least squares: the noise of each velocity is that of its
        residuals."""
        problems = self._data.projected(self._data.R, self.lift)
        self.settled = False
        for _ in range(200):
            self._solve(problems, self.noise)
            spent = [np.linalg.norm(X @ self.covariance_root / s)**2 for (X, _), s in zip(problems, self.noise)]
            self._free = self._data.N - np.array(spent)
            if self._estimate and not self.settled:
                self._demand_samples()
                squares = np.array([np.sum((X @ self.z - b)**2) for X, b in problems])
                noise = np.maximum(np.sqrt(squares / self._free), self._least_noise)
                self.settled = bool(np.all(np.abs(np.log(noise / self.noise)) < 1e-4))
                self.noise = noise
            else:
                self.settled = True
                return

    def _demand_samples(self) -> None:
        k = int(np.argmin(self._free))
        if self._free[k] < 0.5:
            raise ValueError(f"q, v, a, tau: {self._data.N} samples are too few for {self.rank} base parameters and "
                             f"the noise of velocity {k}; expected more samples, or noise")

    def _resist_outliers(self) -> None:
        """Computes Huber's estimate and the root of its asymptotic covariance."""
        data, noise = self._data, self.noise
        for _ in range(50):
            R, e = data.factors(self.lift @ self.z, noise)
            if self._estimate:
                noise = 1.4826 * np.median(np.abs(e), axis=0) * np.sqrt(data.N / np.maximum(self._free, 0.5))
                noise = np.maximum(noise, self._least_noise)
            u = e / noise
            inside = np.maximum(np.mean(np.abs(u) <= HUBER, axis=0), 0.1)
            limited = huber_weight(u, HUBER) * u
            effective = np.maximum(noise * np.sqrt(np.mean(limited**2, axis=0)) / inside, self._least_noise)
            before = self.z
            self._solve(data.projected(R, self.lift), effective * np.sqrt(inside))
            self.settled = bool(np.linalg.norm(self.S @ (self.z - before)) < 0.01)
            if self.settled:
                break
        self.noise = noise
        unweighted = [X / s for (X, _), s in zip(data.projected(data.R, self.lift), effective)]
        self.covariance_root = np.linalg.inv(triangle(np.vstack(unweighted)))


def grouping(unknowns: Unknowns, base: BaseParameters, linalg: Any) -> tuple[Array, Array, NDArray[np.intp]]:
    """(N, K, first): z = N parameters, and base parameters = K parameters, each of which is one of the parameters
    `first` combined with others.

    `first` are the parameters whose columns are the most independent.
    """
    N = base.V.T @ unknowns.inverse
    # The size of each parameter, so that all torques of a body have one size.
    unit = np.linalg.norm(unknowns.matrix, axis=1)
    torque, n = np.linalg.norm(N, axis=0) * unit, len(unit) - len(unknowns.joints)
    of_body = np.append(np.repeat(torque[:n].reshape(-1, 10).max(axis=1), 10), torque[n:])
    unit /= np.maximum(of_body, 1e-4 * torque.max())
    first = np.sort(linalg.qr(N * unit, mode="r", pivoting=True)[1][:base.rank])
    K = np.linalg.solve(N[:, first] * unit[first], N * unit)
    K[np.abs(K) < 1e-10] = 0
    K[:, unit > 0] *= unit[first, None] / unit[unit > 0]
    return N, K, first
