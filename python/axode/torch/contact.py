"""Operations of PyTorch for motions with contact."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import torch  # type: ignore[import-not-found, unused-ignore]
from torch import Tensor

from ..support import contact_motions
from .mechanism import array, mechanism, sizes
from .operations import by_coordinates, displacement, empty, operation, rates, squares, times

__all__: list[str] = []


def _computed(function: Callable[..., Any], key: str, step: float, layout: str, q: Tensor, v: Tensor, tau: Tensor,
              theta: Tensor) -> tuple[Tensor, ...]:
    """The results of a function of contact_motions for all states."""
    of, lead = mechanism(key), q.shape[:-1]
    N = lead.numel()
    arrays = (x.reshape(N, *x.shape[q.ndim - 1:]) for x in (q, v, tau, theta))
    unit, *others = (of.configurations(x) if k == 0 else array(x, x.ndim - 1).astype(np.float64) for k, x in enumerate(arrays))
    kinds = tuple((name, size) for name, size in json.loads(layout))
    found = function(of.model, kinds, step, unit, *others)
    return tuple(torch.from_numpy(x).to(q.dtype).reshape(*lead, *x.shape[1:]) for x in found)


def _states(tau: Tensor, *widths: int) -> tuple[Tensor, ...]:
    return tuple(tau.new_empty((*tau.shape[:-2], tau.shape[-2] + 1, n)) for n in widths)


def _like_matrices(key: str, step: float, layout: str, q: Tensor, v: Tensor, tau: Tensor,
                   theta: Tensor) -> tuple[Tensor, ...]:
    K, nv = tau.shape[-2:]
    return tuple(empty(q, K, 2 * nv, n) for n in (2 * nv, nv, theta.shape[-1]))


_matrices = operation(
    "contact_rollout_matrices(str model, float step, str layout, Tensor q, Tensor v, Tensor tau, Tensor theta)"
    " -> (Tensor, Tensor, Tensor)",
    lambda *x: _computed(contact_motions.derivatives, *x), _like_matrices)


def _backward(ctx: Any, constants: Any, x: Any, motion: Any, w_q: Tensor, w_v: Tensor) -> tuple[Tensor, ...]:
    key, path = constants[0], motion[0]
    A, B, C = (each.mT for each in _matrices(*constants, *x))
    weights = torch.cat([squares(key, path) * displacement(key, path, w_q), w_v], dim=-1)
    w, by_theta, by_tau = weights[..., -1, :], torch.zeros_like(x[3]), []
    for k in reversed(range(A.shape[-3])):
        by_tau.append(times(B[..., k, :, :], w))
        by_theta = by_theta + times(C[..., k, :, :], w)
        w = weights[..., k, :] + times(A[..., k, :, :], w)
    nv = sizes(key)[1]
    forces = torch.stack(by_tau[::-1], dim=-2) if by_tau else torch.zeros_like(x[2])
    return by_coordinates(key, x[0], w[..., :nv]), w[..., nv:], forces, by_theta


def _forward(constants: Any, x: Any, motion: Any, dq: Tensor, dv: Tensor, dtau: Tensor,
             dtheta: Tensor) -> tuple[Tensor, Tensor]:
    key = constants[0]
    A, B, C = _matrices(*constants, *x)
    changes = [torch.cat([displacement(key, x[0], dq), dv], dim=-1)]
    for k in range(A.shape[-3]):
        changes.append(times(A[..., k, :, :], changes[-1]) + times(B[..., k, :, :], dtau[..., k, :])
                       + times(C[..., k, :, :], dtheta))
    all_changes, nv = torch.stack(changes, dim=-2), sizes(key)[1]
    return rates(key, motion[0], all_changes[..., :nv]), all_changes[..., nv:].contiguous()


contact_rollout = operation(
    "contact_rollout(str model, float step, str layout, Tensor q, Tensor v, Tensor tau, Tensor theta) -> (Tensor, Tensor)",
    lambda *x: _computed(contact_motions.states, *x),
    lambda key, step, layout, q, v, tau, theta: _states(tau, q.shape[-1], v.shape[-1]), _backward, _forward)
