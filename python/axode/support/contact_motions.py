"""Motions with contact as functions of their start, their drive forces and parameters, for JAX and PyTorch."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _axode, lie
from .._axode import Model

__all__ = ["Layout", "PARAMETERS", "derivatives", "states"]

Array = NDArray[np.float64]

#: The kinds of parameters, in the order in which a vector of parameters has them: inertial parameters (10 n_bodies), and
#: friction (n), restitution (n) and displacements (n, 6) of n collision shapes.
PARAMETERS = ("parameters", "friction", "restitution", "placement")
#: The kinds of parameters in a vector, each with its number of entries.
Layout = tuple[tuple[str, int], ...]


def _parts(layout: Layout, theta: Array) -> dict[str, Array]:
    given, first = {}, 0
    for name, size in layout:
        given[name] = theta[first:first + size]
        first += size
    if "placement" in given:
        given["placement"] = given["placement"].reshape(-1, 6)
    return given


def _model(m: Model, given: dict[str, Array]) -> Model:
    """The mechanism with the given parameters."""
    shapes = {name: x for name, x in given.items() if name != "parameters"}
    if "parameters" in given:
        m = m.with_parameters(given["parameters"])
    return _axode.with_shapes(m, **shapes) if shapes else m


def states(m: Model, layout: Layout, step: float, q: Array, v: Array, tau: Array, theta: Array) -> tuple[Array, Array]:
    """The states (N, K + 1, nq) and (N, K + 1, nv) of N motions, each with the parameters of its row of theta. ValueError and
    StatesError if a motion cannot continue."""
    found = []
    for k in range(len(q)):
        own = _model(m, _parts(layout, theta[k]))
        found.append(_axode.contact_rollout_under(own, _axode.contact_shapes(own), q[k], v[k], tau[k], step,
                                                  joint_losses=True)[:2])
    K = tau.shape[1]
    return (np.array([one[0] for one in found]).reshape(-1, K + 1, m.nq),
            np.array([one[1] for one in found]).reshape(-1, K + 1, m.nv))


def derivatives(m: Model, layout: Layout, step: float, q: Array, v: Array, tau: Array,
                theta: Array) -> tuple[Array, Array, Array]:
    """The derivatives A (N, K, 2 nv, 2 nv) by the state, B (N, K, 2 nv, nv) by the forces and C (N, K, 2 nv, p) by the p
    parameters of all steps of N motions, see `axode.contact_rollout_derivatives`."""
    N, K, rows, p = len(q), tau.shape[1], 2 * m.nv, theta.shape[-1]
    A, B, C = np.empty((N, K, rows, rows)), np.empty((N, K, rows, m.nv)), np.empty((N, K, rows, p))
    more = any(name in ("parameters", "placement") for name, _ in layout)
    for k in range(N):
        given = _parts(layout, theta[k])
        found = _axode.contact_rollout_derivatives(_model(m, given), q[k], v[k], tau[k], step, parameters=more)
        A[k], B[k] = found.A, found.B
        C[k] = np.concatenate([_by(name, x, found) for name, x in given.items()] or [C[k]], axis=-1)
    return A, B, C


def _by(name: str, x: Array, found: Any) -> Array:
    if name == "parameters":
        of_all: Array = found.inertia
        return of_all
    if name == "placement":  # exp(x + dx) = exp(x) exp(dexp_{-x} dx)
        turned = np.einsum("krni,nij->krnj", found.placement, lie.dexp(-x))
        placed: Array = turned.reshape(*turned.shape[:2], -1)
        return placed
    by_surface: Array = found.C[:, :, ("friction", "restitution").index(name)]
    return by_surface
