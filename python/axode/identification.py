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
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .fitting import base_parameters, consistent_parameters, inertial_unknowns, least_squares, pseudo_inertias
from .support import arguments, signatures
from ._axode import Model
from .records import Load

__all__ = ["Identification", "identify", "pseudo_inertia"]

Array = NDArray[np.float64]


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
    unknowns = inertial_unknowns.Unknowns(m, known, joint_losses, armature)
    data = base_parameters.Torques(m, unknowns, samples, loads, joint_losses)
    base = base_parameters.BaseParameters(data, given, robust)
    fit = consistent_parameters.ConsistentParameters(unknowns, data, base, prior, linalg)

    N, K, first = base_parameters.grouping(unknowns, base, linalg)
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
        base_names=[least_squares.in_words(row, unknowns.names, k) for row, k in zip(K, first)],
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
    return pseudo_inertias.pseudo_inertia(given)


def _samples(m: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, tau: ArrayLike) -> list[Array]:
    rows = arguments.configurations("q", q, m.nq, "sample")
    return [rows] + [arguments.numbers(name, x, m.nv, "nv numbers of each sample", rows.shape[:1])
                     for name, x in [("v", v), ("a", a), ("tau", tau)]]


def _given_noise(noise: ArrayLike, nv: int) -> Array:
    x = np.broadcast_to(noise, (nv,)) if np.ndim(noise) == 0 else noise
    numbers = arguments.numbers("noise", x, nv, "nv numbers", ())
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
