"""The geometry that explains measured poses best, by the method of Levenberg and Marquardt on SE(3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .geometric_unknowns import Geometry, Unknowns
from .least_squares import Spectrum, huber_weight, spectrum, triangle
from .measured_poses import Measurements, squares_of
from .. import lie

__all__: list[str] = []

Array = NDArray[np.float64]

#: Singular values below this part of the largest one count as rounding errors.
RANK_TOLERANCE = 1e-10
#: The largest ratio between the noise of angles and that
#: of lengths, relative to the size of the measured points.
NOISE_RATIO = 1e-4
#: Huber's threshold for the norm of three components in standard deviations: 95 % efficient without outliers.
HUBER = 1.7
#: The median of this norm if there are no outliers.
MEDIAN = 1.5382


class GeometryFit:
    """The geometry that minimises the weighted squares, or Huber's function, of the residuals and of the prior."""

    def __init__(self, data: Measurements, unknowns: Unknowns, given: Array | None, prior: Array | None, robust: bool):
        self._data, self._unknowns, self._robust = data, unknowns, robust
        self._P = np.zeros(unknowns.n)  # weights of z
        if prior is not None:
            weights = np.tile(np.repeat([1, unknowns.size] / prior, 3), len(unknowns.blocks))
            self._P = np.where(unknowns.drawn, weights, 0)
        m = unknowns.drawing.m
        sought = {kind for kind, _ in unknowns.blocks}
        start = data.start(m, "tool" in sought, "device" in sought)
        self.geometry = Geometry(unknowns.drawing, np.tile(np.eye(4), (m.n_bodies, 1, 1)), *start)
        self._r = data.residuals(self.geometry)
        self.residual_before = data.rms(self._r)
        self.iterations = 0
        balanced = np.array([1, data.size])
        self.noise = balanced * np.nanmax(self._estimated(np.zeros(2)) / balanced) if given is None else given
        for _ in range(50):
            minimised = self._minimise()
            self.converged = self._slide() and minimised
            if given is not None:
                break
            before = self.noise
            self.noise = self._estimated(self._spent())
            if np.all(np.abs(np.log(self.noise / before)[data.components > 0]) < 1e-3):
                break
        else:
            self.converged = False
        self._finish()

    # ---------------------------------------------------------------- the equations, linearised

    def _factors(self, weighted: bool) -> list[Array]:
        """The factors R of [J, r] = Q R for angles and for lengths, in z, with or without Huber's weights."""
        self.iterations += 1
        data, unknowns = self._data, self._unknowns
        R = [np.zeros((0, unknowns.n + 1)) for _ in range(2)]
        to_device = lie.inverse(self.geometry.device)
        for part, r in zip(data.parts, self._r):
            for own, C in part.predicted(self.geometry.model, to_device, 12 * unknowns.n):
                e = r[own]
                J = unknowns.jacobian(self.geometry, part, own, C)
                J = C[:, :3, :3] @ J[:, 3:] if part.pose is None else lie.dexp_inv(e) @ J
                for k in range(2):
                    rows, e_k = (J[:, -3:], e[:, -3:]) if k else (J[:, :-3], e[:, :-3])
                    both = np.concatenate([rows, e_k[:, :, None]], axis=2)
                    if weighted and self._robust:
                        u = np.linalg.norm(e_k, axis=1) / self.noise[k]
                        both *= np.sqrt(huber_weight(u, HUBER))[:, None, None]
                    R[k] = triangle(np.vstack([R[k], both.reshape(-1, unknowns.n + 1)]))
        for R_k in R:
            R_k[:, :-1] = R_k[:, :-1] @ unknowns.T
        return R

    def _system(self) -> tuple[Spectrum, Array]:
        """U diag(sigma) Vt and g: near the present estimate the cost is |diag(sigma) Vt dz - g|^2 and a constant."""
        c = self._compress(self._factors(weighted=True), self.noise)
        P_L, P_z = self._prior()
        system = spectrum(np.vstack([self._S, P_L]), RANK_TOLERANCE)
        return system, system.U.T @ np.append(c, -P_z)

    def _prior(self) -> tuple[Array, Array]:
        """The rows P L and P z of the cost |P (z + L dz)|^2 of the prior; there are none without a prior."""
        z, L = self._unknowns.correction(self.geometry)
        rows = self._P > 0
        return (self._P[:, None] * L)[rows], (self._P * z)[rows]

    def _compress(self, factors: list[Array], noise: Array) -> Array:
        """Computes S of the measurements, whose cost is |S dz - c|^2, and the directions that they determine. Returns
        c."""
        R = triangle(np.vstack([R_k / s for R_k, s in zip(factors, noise) if len(R_k)]))
        self._S = R[:, :-1]
        seen = spectrum(self._S, RANK_TOLERANCE)
        self.rank, self.null_space = seen.rank, seen.null_space
        if not self.rank:
            raise ValueError("measurements: none of the poses depends on the parameters to calibrate")
        self.condition = float(seen.sigma[0] / seen.sigma[-1])
        return R[:, -1]

    def _cost(self, r: list[Array], geometry: Geometry) -> float:
        cost = 0.0
        for squares, s in zip(squares_of(r), self.noise):
            u = np.sqrt(squares) / s
            inside = np.minimum(u, HUBER) if self._robust else u
            cost += float(np.sum(inside * (2 * u - inside)))
        return cost + float(np.sum((self._P * self._unknowns.correction(geometry)[0])**2))

    # ---------------------------------------------------------------- steps

    def _minimise(self) -> bool:
        """Takes the steps of Levenberg and Marquardt from the present geometry. Returns whether they converged."""
        damping, cost = 1e-6, self._cost(self._r, self.geometry)
        for _ in range(100):
            (_, sigma, Vt, _), g = self._system()
            last = g @ g < 1e-6  # the step is less than a thousandth of the standard deviations
            while True:
                filtered = sigma / (sigma**2 + (0 if last else damping) * sigma[0]**2)
                geometry = self.geometry.moved(self._unknowns, self._unknowns.T @ (Vt.T @ (filtered * g)))
                r = self._data.residuals(geometry)
                reached = self._cost(r, geometry)
                if last or reached < cost:
                    break
                damping = max(10 * damping, 1e-10)
                if damping > 1e10:
                    return False
            self.geometry, self._r, cost, damping = geometry, r, reached, damping / 10
            if last:
                return True
        return False

    def _slide(self) -> bool:
        """Moves along the directions that cannot be identified to the smallest correction, while Gauss-Newton steps
        keep the poses. Returns whether this converged."""
        if self._P.any():
            return True
        for _ in range(50):
            (_, sigma, Vt, _), g = self._system()
            if not self.null_space.shape[1]:
                return True
            dz = Vt.T @ (g / sigma)
            z, _ = self._unknowns.correction(self.geometry)
            slide = -self.null_space @ (self._to_smallest() @ (z + self._unknowns.drawn * dz))
            self.geometry = self.geometry.moved(self._unknowns, self._unknowns.T @ (dz + slide))
            self._r = self._data.residuals(self.geometry)
            if np.abs(slide).max() < 1e-6:
                return True
        return False

    def _to_smallest(self) -> Array:
        """Computes Y for which z - N Y z is the smallest correction of the drawn geometry."""
        drawn = self._unknowns.drawn
        return np.asarray(np.linalg.pinv(drawn[:, None] * self.null_space, rcond=1e-6) * drawn)

    # ---------------------------------------------------------------- noise and covariance

    def _spent(self) -> Array:
        """Number of degrees of freedom of angles and of lengths that the parameters use."""
        root = self._covariance_root()
        spent = [np.linalg.norm(R_k[:, :-1] @ root / s)**2 for R_k, s in zip(self._factors(weighted=False), self.noise)]
        free = self._data.components - spent
        if np.any((free < 0.5) & (self._data.components > 0)):
            raise ValueError(f"measurements: {self._data.N} are too few for {self.rank} parameters and the noise; "
                             "expected more of them, or noise")
        return np.asarray(spent)

    def _estimated(self, spent: Array) -> Array:
        noise = np.full(2, np.nan)
        for k, squares in enumerate(squares_of(self._r)):
            if n := self._data.components[k]:
                mean = np.median(squares) / MEDIAN**2 if self._robust else squares.sum() / n
                noise[k] = np.sqrt(mean * n / (n - spent[k]))
        largest = np.nanmax(noise / [1, self._data.size])
        least = np.maximum(self._data.least_noise, NOISE_RATIO * largest * np.array([1, self._data.size]))
        return np.asarray(np.maximum(noise, least))

    def _covariance_root(self) -> Array:
        """A root B of the covariance B B^T of z."""
        _, sigma, Vt, _ = spectrum(np.vstack([self._S, self._prior()[0]]), RANK_TOLERANCE)
        B = Vt.T / sigma
        return B if self._P.any() else B - self.null_space @ (self._to_smallest() @ B)

    def _finish(self) -> None:
        """The final estimate without Huber's weights, with the effective noise after weighting."""
        data = self._data
        effective = self.noise.copy()
        if self._robust:
            for k, squares in enumerate(squares_of(self._r)):
                if len(squares):
                    u = np.sqrt(squares) / self.noise[k]
                    weight = huber_weight(u, HUBER)
                    slope = np.mean(np.where(u <= HUBER, 1, 2 / 3 * weight))
                    effective[k] *= np.sqrt(np.mean((weight * u)**2) / 3) / slope
        effective = np.maximum(effective, data.least_noise)
        self._compress(self._factors(weighted=False), effective)
        self.residual = data.rms(self._r)

    def covariance(self) -> Array:
        """The covariance (p, p) of x."""
        B = self._unknowns.T @ self._covariance_root()
        return np.asarray(B @ B.T)
