"""Inertial parameters, armatures and joint losses from measured motions and torques.

tau = Y(q, v, a) pi is linear in the inertial parameters, but motions determine only some combinations of them, the
base parameters, and their least-squares estimate may belong to no mass distribution. `identify` returns both: the
base parameters with their standard deviations, and a model in which every body has a mass distribution.

This needs SciPy (pip install scipy).

The pseudo-inertia of a body, P = [[S, m c], [m c^T, m]] with the second moments S = tr(Theta)/2 I - Theta, is
positive definite if and only if a mass distribution has these ten parameters (Wensing, Kim, Slotine, Linear matrix
inequalities for physically consistent inertial parameter identification, 2018). With P0 the pseudo-inertia of the
drawing, the distance between both is the entropic divergence D = tr(P0^-1 P) - log det(P0^-1 P) - 4 of Lee, Wensing
and Park, Geometric robot dynamic
identification, 2020: it does not depend on frames or units, and grows without bound as P approaches a matrix that is
    not positive definite. The model minimises chi^2 / 2 + sum D / prior^2. This function is convex in the parameters,
    so that there is one minimum,
and Newton's method finds it from the drawing while the prior is weakened step by step.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .support import signatures
from ._axode import Model, inverse_dynamics, jacobian_columns, regressor
from .convert import _numbers
from .records import Load

__all__ = ["Identification", "identify", "pseudo_inertia"]

Array = NDArray[np.float64]

#: Singular values of the balanced regressor below this part of the largest one count as rounding errors.
RANK_TOLERANCE = 1e-11
#: The least noise of a torque, relative to its size; it is also at least a thousandth of this for the largest torque.
NOISE_FLOOR = 1e-6
#: A body lighter than this part of the whole mechanism counts as known: URDF files have such bodies between two
#: joints.
DUMMY_MASS = 1e-6
#: Huber's threshold in standard deviations: 95 % efficient if there are no outliers.
HUBER = 1.345
#: The largest number of entries of the regressor that are in memory at once.
BLOCK = 1 << 22


class Identification(NamedTuple):
    """Result of `identify`. Its p parameters are those of `Model.parameters`, and then those of joints if they were requested.

    `parameters` and `model` are consistent: the pseudo-inertia of every body that is not in `known` is positive
    definite. `base_parameters` are the (weighted) least squares estimate without this condition and without the
    prior.
    """

    model: Model
    """m with the parameters found."""
    parameters: Array
    """(p,); the first 10 n_bodies are `model.parameters`, then armatures, damping and friction of velocities."""
    parameter_names: list[str]
    """`link 1 m`, ..., `A1 armature`, `A1 damping`, `A1 friction`."""
    deviations: Array
    """(p,) standard deviations of `parameters`, given motions, torques and prior; 0 for what is known."""
    base_parameters: Array
    """(rank,), each in the unit of the first parameter in its name."""
    base_deviations: Array
    """(rank,) standard deviations of `base_parameters`, without any prior."""
    base_matrix: Array
    """(rank, p): base parameters = base_matrix @ parameters, where those are the true ones."""
    base_names: list[str]
    """The rows of `base_matrix` in words, `link 2 Ixx + 0.3 * link 3 m`."""
    unidentifiable: Array
    """(number, p): a basis of the changes of unknown parameters that change no torque of these motions."""
    rank: int
    """The number of base parameters."""
    condition: float
    """Condition number of the weighted regressor of the base parameters, its columns scaled to length 1: how well the
    motions excite them."""
    noise: Array
    """(nv,) standard deviations of the torques, as given or as estimated, N m or N."""
    residual: Array
    """(nv,) root mean square of tau less the torques of `model`."""
    base_residual: Array
    """(nv,) the same for the base parameters."""
    known: list[str]
    """Bodies that were left as they are: those that were named, and those without mass."""
    iterations: int
    """Newton steps for the consistent parameters."""
    converged: bool
    """Whether noise and parameters settled; they do not where no consistent model is near to what was measured."""


def identify(m: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, tau: ArrayLike, *,
             loads: Sequence[Load] | None = None, joint_losses: bool = False, armature: bool = False,
             known: Sequence[str] = (), noise: ArrayLike | None = None, robust: bool = False,
             prior: float = 10.0) -> Identification:
    """Estimates the inertial parameters of m, and a consistent model, from N measured samples of q (N, nq), v, a and tau (N, nv).

    Begin with about 20 samples for each parameter, of motions that are fast and different; `condition` measures
    whether they excite all parameters (below 100 is good). Accelerations are best taken from filtered positions, and
    tau through the same filter. tau are drive forces with the inverse dynamics of `loads`, as in `inverse_dynamics`,
    N m or N.

    joint_losses: identify damping d and Coulomb friction f of each velocity, tau = ... + d v + f sign(v); without it,
        tau must not contain losses. armature: identify armatures, which are otherwise those of m. Joints that follow
        others keep their armatures; free joints have none.
    known: names of bodies whose parameters stay unchanged; those of bodies with less than a millionth of the mass do
        so, too.
    noise: standard deviation of tau, a number or (nv,); if left out, that of each velocity is estimated from its
        residuals, by iteratively reweighted least squares. Samples are assumed to be independent: if data are sampled
        much faster than their noise changes, the resulting standard deviations are too small.
    robust: whether outliers in tau count by their size instead of its square (Huber).
    prior: relative standard deviation of the parameters of m. 0.1 trusts the drawing to 10 %; 10 has little influence
        except on combinations that the motions do not determine. Parameters of joints that are 0 in m have no prior.

    Samples are compressed block by block in O(N nv p^2), and with `robust` in each of about 10 iterations; memory
    grows with N only by arrays as large as tau. ValueError for wrong shapes, numbers that are not finite, too few
    samples, and motions that determine no parameter; KeyError for unknown names; ImportError without SciPy.

    >>> random = np.random.default_rng(0)
    >>> q, v, a = arm.random(n=300), *random.uniform(-2, 2, (2, 300, 7))
    >>> built = arm.with_payload("flange", axode.lie.sphere_inertia(1.5, 0.05))  # what is measured
    >>> tau = axode.inverse_dynamics(built, q, v, a) + random.normal(0, 0.05, (300, 7))
    >>> found = axode.identification.identify(arm, q, v, a, tau)
    >>> found.rank, bool(found.condition < 100), found.noise.round(2)
    (43, True, array([0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05]))
    """
    linalg = _scipy_linalg()
    if not (np.isfinite(prior) and prior > 0):
        raise ValueError(f"prior is {prior}; expected a relative standard deviation, more than 0")
    if joint_losses:
        for joint in m.joints:
            if np.any(joint.gear_loss > 0) or np.any(joint.gear_loss_back > 0):
                raise ValueError(f'the gear of joint "{joint.name}" loses a part of the force that it transmits, which is '
                                 "not linear in the parameters; subtract it from tau, and set gear_loss to 0")
    samples = _samples(m, q, v, a, tau)
    given = None if noise is None else _given_noise(noise, m.nv)
    unknowns = _Unknowns(m, known, joint_losses, armature)
    data = _Data(m, unknowns, samples, loads, joint_losses)
    base = _Base(data, given, robust)
    fit = _Fit(unknowns, data, base, prior, linalg)

    N, K, first = _grouping(unknowns, base, linalg)
    to_base = np.linalg.inv(N[:, first])
    excitation = base.S @ N[:, first]  # the factor R of the weighted regressor of the base parameters
    parameters = unknowns.present + unknowns.matrix @ fit.x
    model = unknowns.model(parameters)
    return Identification(
        model=model,
        parameters=np.append(model.parameters, parameters[10 * m.n_bodies:]),
        parameter_names=unknowns.names,
        deviations=np.linalg.norm(unknowns.matrix @ fit.covariance_root, axis=1),
        base_parameters=to_base @ base.z,
        base_deviations=np.linalg.norm(to_base @ base.covariance_root, axis=1),
        base_matrix=K,
        base_names=[_in_words(row, unknowns.names, k) for row, k in zip(K, first)],
        unidentifiable=(unknowns.matrix @ base.null_space).T,
        rank=base.rank,
        condition=float(np.linalg.cond(excitation / np.linalg.norm(excitation, axis=0))),
        noise=base.noise,
        residual=data.residual(fit.x),
        base_residual=data.residual(base.lift @ base.z),
        known=unknowns.known,
        iterations=fit.iterations,
        converged=base.settled and fit.settled,
    )


def pseudo_inertia(pi: ArrayLike) -> Array:
    """The pseudo-inertia P = [[S, m c], [m c^T, m]], (..., 4, 4), of inertial parameters (..., 10); kg m^2, kg m and
    kg.

    A mass distribution has these parameters if and only if no eigenvalue is negative.

    >>> P = axode.identification.pseudo_inertia(arm.parameters.reshape(-1, 10))
    >>> P.shape, bool(np.linalg.eigvalsh(P).min() > 0)
    ((7, 4, 4), True)
    """
    given = np.asarray(pi, dtype=np.float64)
    if given.ndim == 0 or given.shape[-1] != 10:
        raise ValueError(f"pi: expected shape (..., 10), ten parameters of each body, got {given.shape}")
    xx, yy, zz, xy, xz, yz = np.moveaxis(given[..., 4:], -1, 0)
    P = np.empty((*given.shape[:-1], 4, 4))
    for k, twice_S in enumerate([yy + zz - xx, xx + zz - yy, xx + yy - zz]):
        P[..., k, k] = twice_S / 2
    for i, j, product in [(0, 1, xy), (0, 2, xz), (1, 2, yz)]:
        P[..., i, j] = P[..., j, i] = -product
    P[..., :3, 3] = P[..., 3, :3] = given[..., 1:4]
    P[..., 3, 3] = given[..., 0]
    return P


def _inertial_parameters(P: Array) -> Array:
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


def _coordinates(A: Array) -> Array:
    """Coordinates (..., 10) of symmetric matrices (..., 4, 4) in the basis _BASIS."""
    return np.asarray(np.einsum("kij,...ij->...k", SYMMETRIC, A))


def _pseudo_inertia_roots(pi: Array) -> Array:
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


class _Unknowns:
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
        L = _pseudo_inertia_roots(pi[self.bodies]) if self.bodies else np.zeros((0, 4, 4))
        for k, body in enumerate(self.bodies):
            W = _inertial_parameters(L[k] @ SYMMETRIC @ L[k].T).T
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
            m = _with_joints(m, of_joints)
        return m.with_parameters(parameters[:n])


def _with_joints(m: Model, of_joints: dict[str, Array]) -> Model:
    """The model m with other armatures, damping or friction, (nv,) each."""
    drawing = m.to_dict()
    links = _links_of_bodies(m, drawing)
    velocities: dict[str, list[int]] = {}  # of each link's joint
    for name, joint in zip(m.body_names, m.joints):
        velocities.setdefault(links[name]["name"], []).extend(range(joint.v.start, joint.v.stop))
    for name, own in velocities.items():
        joint_of_link = links[name]["joint"]
        if not own or joint_of_link == "free" or joint_of_link["kind"] == "free":
            continue
        dofs = joint_of_link.setdefault("dof", [{} for _ in own]) if len(own) > 1 else [joint_of_link]
        for dof, k in zip(dofs, own):
            dof.update({kind: float(values[k]) for kind, values in of_joints.items()})
    return Model.from_dict(drawing)


def _links_of_bodies(m: Model, drawing: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The link of each moving body. If one drawn joint moves two bodies, the first of them has the link of its
    successor."""
    links = {link["name"]: link for link in drawing["body"]}
    successor = {m.body(name).predecessor: name for name in m.body_names}
    return {name: links.get(name) or links[successor[name]] for name in m.body_names}


def _huber(u: Array) -> Array:
    """Weights of residuals u, given in standard deviations."""
    return np.asarray(HUBER / np.maximum(np.abs(u), HUBER))


def _triangle(rows: Array) -> Array:
    """The factor R of rows = Q R."""
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)


class _Data:
    """The torques b that are due to the unknowns x, and their regressor X: b = X x.

    The samples of velocity k are needed only in the form of the factor R of their rows, [X, b] = Q R.
    """

    def __init__(self, m: Model, unknowns: _Unknowns, samples: list[Array], loads: Sequence[Load] | None,
                 joint_losses: bool):
        q, v, a, tau = samples
        self._m, self._unknowns, self._states = m, unknowns, (q, v, a)
        rest = unknowns.model(unknowns.present)
        self.b = tau - inverse_dynamics(rest, q, v, a, loads=loads, joint_losses=joint_losses)
        self.N, self.nv = self.b.shape
        felt = np.zeros((m.nv, unknowns.n), bool)
        for k, body in enumerate(unknowns.bodies):
            felt[jacobian_columns(m, q[0], m.body_names[body])[0], 10 * k:10 * k + 10] = True
        for column, (_, k) in enumerate(unknowns.joints, start=10 * len(unknowns.bodies)):
            felt[k, column] = True
        self.columns = [np.flatnonzero(of_k) for of_k in felt]
        self._squares = np.zeros((m.nv, len(unknowns.names)))
        self.R, _ = self.factors(np.zeros(unknowns.n), np.full(m.nv, np.inf))
        #: (nv, n) roots of the sums of squares of X, no less than those of the terms that its entries are sums of.
        self.sizes = np.sqrt(self._squares) @ np.abs(unknowns.matrix)

    def _regressor(self) -> Iterator[tuple[slice, Array]]:
        """The regressor of all parameters, block by block."""
        q, v, a = self._states
        width = len(self._unknowns.names)
        block = max(BLOCK // (self.nv * width), 1)
        for start in range(0, self.N, block):
            part = slice(start, start + block)
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
                rows = np.column_stack([X, self.b[part, k]]) * np.sqrt(_huber(e[part, k] / noise[k]))[:, None]
                R[k] = _triangle(np.vstack([R[k], rows]))
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


class _Base:
    """The base parameters z = V^T x that the motions determine, and their weighted least squares estimate, the minimum of |S z - c|."""

    def __init__(self, data: _Data, given: Array | None, robust: bool):
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
        _, sigma, Vt = np.linalg.svd(_triangle(np.vstack(X)))
        self.rank = int(np.sum(sigma > RANK_TOLERANCE * sigma[0])) if sigma[0] > 0 else 0
        if not self.rank:
            raise ValueError("q, v, a: no torque of these motions depends on the parameters to identify")
        self.V = scale[:, None] * Vt[:self.rank].T
        self.lift = Vt[:self.rank].T / scale[:, None]  # V^T lift = 1
        self.null_space = Vt[self.rank:].T / scale[:, None]

    def _solve(self, problems: list[tuple[Array, Array]], noise: Array) -> None:
        rows = np.vstack([np.column_stack(problem) / s for problem, s in zip(problems, noise)])
        R = _triangle(rows)[:self.rank]
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
            effective = np.maximum(noise * np.sqrt(np.mean((_huber(u) * u)**2, axis=0)) / inside, self._least_noise)
            before = self.z
            self._solve(data.projected(R, self.lift), effective * np.sqrt(inside))
            self.settled = bool(np.linalg.norm(self.S @ (self.z - before)) < 0.01)
            if self.settled:
                break
        self.noise = noise
        unweighted = [X / s for (X, _), s in zip(data.projected(data.R, self.lift), effective)]
        self.covariance_root = np.linalg.inv(_triangle(np.vstack(unweighted)))


class _Fit:
    """The consistent parameters: the minimum of |G x - c|^2 / 2 + sum of mu D, by Newton's method from the drawing.

    D is tr A - log det A - 4 for a body, and y - log y - 1 for a parameter x = y scale of a joint. This function is
    self-concordant: if the decrement is small, full steps converge. mu is decreased from a value at which the drawing
    is nearly the minimum.
    """

    def __init__(self, unknowns: _Unknowns, data: _Data, base: _Base, prior: float, linalg: Any):
        self._linalg, self._n_bodies = linalg, len(unknowns.bodies)
        self._G, self._c = base.S @ base.V.T, base.c
        joints = slice(10 * self._n_bodies, None)
        torque = np.array([np.linalg.norm(data.b[:, k]) for _, k in unknowns.joints])
        size = data.sizes.sum(axis=0)[joints]
        hundredth = 0.01 * torque / np.where(size > 0, size, 1)
        self._scale = np.where(unknowns.drawn[joints] | (hundredth == 0), 1, hundredth)
        self.x = np.append(np.tile(_coordinates(np.eye(4)), self._n_bodies), self._scale)

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
            K[own, own] = _coordinates(V[k] @ SYMMETRIC @ V[k].T).T
            d[own] = _coordinates(np.eye(4) - U[k].T @ U[k])
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


def _grouping(unknowns: _Unknowns, base: _Base, linalg: Any) -> tuple[Array, Array, NDArray[np.intp]]:
    """(N, K, first): z = N parameters, and base parameters = K parameters, each of which is one of the parameters
    `first` combined with others.

    `first` are the parameters whose columns are the most independent.
    """
    N = base.V.T @ unknowns.inverse
    unit = np.linalg.norm(unknowns.matrix, axis=1)  # of each parameter, so that all torques of a body have one size
    torque, n = np.linalg.norm(N, axis=0) * unit, len(unit) - len(unknowns.joints)
    of_body = np.append(np.repeat(torque[:n].reshape(-1, 10).max(axis=1), 10), torque[n:])
    unit /= np.maximum(of_body, 1e-4 * torque.max())
    first = np.sort(linalg.qr(N * unit, mode="r", pivoting=True)[1][:base.rank])
    K = np.linalg.solve(N[:, first] * unit[first], N * unit)
    K[np.abs(K) < 1e-10] = 0
    K[:, unit > 0] *= unit[first, None] / unit[unit > 0]
    return N, K, first


def _in_words(row: Array, names: list[str], first: int) -> str:
    terms = names[first]
    for k in np.flatnonzero(row):
        if k != first:
            factor = f"{abs(row[k]):.4g}"
            terms += f" {'-' if row[k] < 0 else '+'} {'' if factor == '1' else factor + ' * '}{names[k]}"
    return terms


def _samples(m: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, tau: ArrayLike) -> list[Array]:
    rows = _numbers("q", q, m.nq, "nq numbers")
    if rows.ndim != 2 or not len(rows):
        raise ValueError(f"q: expected shape (N, {m.nq}), nq numbers of each sample, got {rows.shape}")
    return [rows] + [_numbers(name, x, m.nv, "nv numbers of each sample", rows.shape[:1])
                     for name, x in [("v", v), ("a", a), ("tau", tau)]]


def _given_noise(noise: ArrayLike, nv: int) -> Array:
    x = np.broadcast_to(noise, (nv,)) if np.ndim(noise) == 0 else noise
    numbers = _numbers("noise", x, nv, "nv numbers", ())
    if not np.all(numbers > 0):
        k = int(np.argmin(numbers))
        raise ValueError(f"noise[{k}] is {numbers[k]}; expected standard deviations, more than 0")
    return numbers


def _scipy_linalg() -> Any:
    try:
        return importlib.import_module("scipy.linalg")
    except ImportError as error:
        raise ImportError("axode.identification needs SciPy: pip install scipy") from error


signatures.explain_calls(__name__)
