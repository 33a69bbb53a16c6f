"""Motions with contact in programs of JAX, which XLA asks Python for."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any

import jax  # type: ignore[import-not-found, unused-ignore]
import jax.numpy as jnp  # type: ignore[import-not-found, unused-ignore]
import numpy as np

from .._axode import Model
from ..errors import StatesError
from ..support import contact_motions
from ..support.contact_motions import Layout
from .calls import OFF_LENGTH
from .mechanism import Array, Mechanism, rates_of, velocities_of

__all__ = ["contact_motion"]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2, 3))
def contact_motion(m: Model, of: Mechanism, layout: Layout, step: float, q: Array, v: Array, tau: Array,
                   theta: Array) -> list[Array]:
    """The states of motions, whose parameters are the rows of theta."""
    K = tau.shape[-2]
    return _called(contact_motions.states, m, layout, step, [(K + 1, of.nq), (K + 1, of.nv)], q, v, tau, theta)


@contact_motion.defjvp  # type: ignore[untyped-decorator, unused-ignore]
def _change_of_motion(m: Model, of: Mechanism, layout: Layout, step: float, primals: Any, tangents: Any) -> tuple[Any, Any]:
    (q, *_), (dq, dv, dtau, dtheta) = primals, tangents
    path, velocities = contact_motion(m, of, layout, step, *primals)
    A, B, C = _matrices(m, of, layout, step, *primals)
    forced = jnp.einsum("...krj,...kj->...kr", B, dtau) + jnp.einsum("...krp,...p->...kr", C, dtheta)
    start = jnp.concatenate([velocities_of(of, q, dq), dv], axis=-1)

    def advance(x: Array, of_step: Any) -> tuple[Array, Array]:
        A_k, forced_k = of_step
        x = jnp.einsum("...rc,...c->...r", A_k, x) + forced_k
        return x, x

    _, later = jax.lax.scan(advance, start, (jnp.moveaxis(A, -3, 0), jnp.moveaxis(forced, -2, 0)))
    x = jnp.concatenate([start[..., None, :], jnp.moveaxis(later, 0, -2)], axis=-2)
    return [path, velocities], [rates_of(of, path, x[..., :of.nv]), x[..., of.nv:]]


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2, 3))
def _matrices(m: Model, of: Mechanism, layout: Layout, step: float, q: Array, v: Array, tau: Array, theta: Array) -> list[Array]:
    K, rows = tau.shape[-2], 2 * of.nv
    items = [(K, rows, rows), (K, rows, of.nv), (K, rows, theta.shape[-1])]
    return _called(contact_motions.derivatives, m, layout, step, items, q, v, tau, theta)


@_matrices.defjvp  # type: ignore[untyped-decorator, unused-ignore]
def _refuse_second_derivatives(*_: Any) -> Any:
    raise NotImplementedError("axode.jax.contact_rollout has first derivatives; a second one was asked for")


def _called(function: Callable[..., Any], m: Model, layout: Layout, step: float, items: Sequence[tuple[int, ...]], q: Array,
            v: Array, tau: Array, theta: Array) -> list[Array]:
    """The results of a function of contact_motions; NaN for motions that are not finite or cannot continue."""
    dtype = q.dtype

    def compute(*given: Any) -> list[Any]:
        lead = given[0].shape[:-1]
        N = math.prod(lead)
        q, v, tau, theta = (np.asarray(x, np.float64).reshape(N, *x.shape[len(lead):]) for x in given)
        results = [np.full((N, *item), np.nan) for item in items]
        for k in range(N):
            if not all(np.isfinite(x[k]).all() for x in (q, v, tau, theta)):
                continue
            unit = m.normalize(q[k])
            own = unit if np.abs(q[k] - unit).max(initial=0) <= OFF_LENGTH[dtype.name] else q[k]
            try:
                found = function(m, layout, step, own[None], v[k:k + 1], tau[k:k + 1], theta[k:k + 1])
            except StatesError:
                continue
            for result, one in zip(results, found):
                result[k] = one[0]
        return [result.reshape(*lead, *item).astype(dtype) for result, item in zip(results, items)]

    shapes = [jax.ShapeDtypeStruct((*q.shape[:-1], *item), dtype) for item in items]
    return list(jax.pure_callback(compute, shapes, q, v, tau, theta, vmap_method="broadcast_all"))
