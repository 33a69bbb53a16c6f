"""Calls of the compiled module from programs of JAX, and the rules by which JAX differentiates and batches them.

Every call is one primitive with the function's name. Its arguments have the same leading axes, which count states.
Tangents and gradients by configurations are those along velocities of the joints, nv numbers: the rules in this
module convert between them and the nq numbers of q, by which JAX differentiates, with the functions of `mechanism`.
Hence every derivative is exact, and JAX's own rules derive second derivatives from the first ones.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import jax  # type: ignore[import-not-found, unused-ignore]
import jax.numpy as jnp  # type: ignore[import-not-found, unused-ignore]
import numpy as np
from jax.extend.core import Primitive  # type: ignore[import-not-found, unused-ignore]
from jax.interpreters import ad, batching, mlir  # type: ignore[import-not-found, unused-ignore]

from .._axode import Model, pair_distances
from .._axode import jax as _jax
from ..table import ROWS
from .mechanism import Array, Mechanism, cross, rates_of, velocities_of

__all__ = ["distances_of", "motion", "state_function"]

for _name, _handler in _jax.handlers().items():
    jax.ffi.register_ffi_target(_name, _handler, platform="cpu")

primitive: Any = Primitive("axode")
primitive.multiple_results = True


def state_function(function: str, m: Mechanism, *arguments: Array, joint_losses: bool = False, parameters: bool = False,
                   threads: int = 1) -> Array:
    """A function of the table; with `parameters` the last argument has inertial parameters for each state."""
    options = (("joint_losses", joint_losses), ("parameters", parameters), ("threads", threads))
    return primitive.bind(*arguments, function=function, mechanism=m, options=options)[0]


def motion(function: str, m: Mechanism, *arguments: Array, step: float, threads: int = 1) -> list[Array]:
    """`rollout`, `rollout_jvp` or `rollout_vjp`."""
    return list(primitive.bind(*arguments, function=function, mechanism=m, options=(("step", step), ("threads", threads))))


def _results(function: str, m: Mechanism, arguments: Sequence[Any]) -> list[tuple[int, ...]]:
    lead = arguments[0].shape[:-1]
    if function in ROWS:
        return [(*lead, *ROWS[function].item(m))]
    K = arguments[2].shape[-2]
    if function == "rollout_vjp":
        return [(*lead, m.nv), (*lead, m.nv), (*lead, K, m.nv)]
    return [(*lead, K + 1, m.nq if function == "rollout" else m.nv), (*lead, K + 1, m.nv)]


def _abstract(*arguments: Any, function: str, mechanism: Mechanism, options: Any) -> list[Any]:
    return [jax.core.ShapedArray(shape, arguments[0].dtype) for shape in _results(function, mechanism, arguments)]


@functools.lru_cache(maxsize=256)
def _compiled(function: str, mechanism: Mechanism, options: Any) -> Any:
    return jax.jit(functools.partial(primitive.bind, function=function, mechanism=mechanism, options=options))


def _run(*arguments: Array, function: str, mechanism: Mechanism, options: Any) -> Any:
    return _compiled(function, mechanism, options)(*arguments)


def _lower(ctx: Any, *arguments: Any, function: str, mechanism: Mechanism, options: Any) -> Any:
    ctx.module_context.add_keepalive(mechanism)
    given = dict(options)
    attributes: dict[str, Any] = {"function": function, "model": mechanism.key, "threads": np.int64(given["threads"])}
    if function in ROWS:
        attributes |= {"joint_losses": given["joint_losses"], "parameters": given["parameters"],
                       "item_axes": np.int64(len(ROWS[function].item(mechanism)))}
        return jax.ffi.ffi_lowering("axode_state_function")(ctx, *arguments, **attributes)
    return jax.ffi.ffi_lowering("axode_motion")(ctx, *arguments, **attributes, step=np.float64(given["step"]))


def _refuse_device(ctx: Any, *arguments: Any, function: str, mechanism: Mechanism, options: Any) -> Any:
    where = " and ".join(ctx.platforms or ctx.module_context.platforms)
    raise NotImplementedError(f"axode.jax computes on the CPU, and {function} is to be run on {where}; put its arguments there, "
                              'as with jax.device_put(x, jax.devices("cpu")[0])')


primitive.def_abstract_eval(_abstract)
primitive.def_impl(_run)
mlir.register_lowering(primitive, _lower, platform="cpu")
mlir.register_lowering(primitive, _refuse_device)


def _batch(arguments: Sequence[Array], axes: Sequence[Any], **what: Any) -> tuple[Any, list[int]]:
    """Computes all states of a batch in one call: the batch axis goes in front, and arguments that are the same for
    all states are repeated."""
    size = next(x.shape[axis] for x, axis in zip(arguments, axes) if axis is not None)
    moved = [jnp.broadcast_to(x, (size, *x.shape)) if axis is None else jnp.moveaxis(x, axis, 0)
             for x, axis in zip(arguments, axes)]
    results = primitive.bind(*moved, **what)
    return results, [0] * len(results)


batching.primitive_batchers[primitive] = _batch


# Derivatives. A tangent that is 0 comes as ad.Zero.

_FIRST_BY_PARAMETERS = ("axode.jax has first derivatives by inertial parameters; a second one was asked for. If you do "
                        "not need it, pass jax.lax.stop_gradient(parameters)")


def _along(tangents: Sequence[Any]) -> list[Array]:
    return [ad.instantiate_zeros(each) for each in tangents]


def _all_zero(tangents: Sequence[Any]) -> bool:
    return all(isinstance(each, ad.Zero) for each in tangents)


def _velocity_tangents(m: Mechanism, q: Array, tangents: Sequence[Any]) -> list[Array]:
    """Tangents of the arguments; that of q is converted to directions of the velocities."""
    dq, *others = _along(tangents)
    return [velocities_of(m, q, dq), *others]


def _times(H: Array, x: Sequence[Array]) -> tuple[Array, Array, Array]:
    """The change of the gradient along a direction x by the Hessian H, in its parts by q, v and the third argument t.

    H has the parts by (q, q), (q, v), (v, v) and (t, q); for entry [k, l] of a part, the displacement along k comes
    first.
    """
    qq, qv, vv, tq = (H[..., k, :, :] for k in range(4))
    q, v, t = x

    def rows(a: Array, A: Array) -> Array:
        return jnp.einsum("...k,...kl->...l", a, A)

    def columns(A: Array, a: Array) -> Array:
        return jnp.einsum("...kl,...l->...k", A, a)

    return rows(q, qq) + columns(qv, v) + rows(t, tq), rows(q, qv) + rows(v, vv), columns(tq, q)


def _all_hessians(dynamics: str, m: Mechanism, state: Sequence[Array], pi: Sequence[Array], what: dict[str, Any]) -> Array:
    """Hessians of each component of inverse or forward dynamics, with an axis of nv after that of the states."""
    def spread(x: Array) -> Array:
        return jnp.broadcast_to(x[..., None, :], (*x.shape[:-1], m.nv, x.shape[-1]))

    q = state[0]
    unit = jnp.broadcast_to(jnp.eye(m.nv, dtype=q.dtype), (*q.shape[:-1], m.nv, m.nv))
    return state_function(f"{dynamics}_hessian", m, *map(spread, state), unit, *map(spread, pi), **what)


def _parts(x: Sequence[Any], what: dict[str, Any]) -> tuple[Sequence[Any], Sequence[Any], Sequence[Any]]:
    """Splits the arguments into the state (q, v, a or tau), the arguments in which the function is linear, and the
    inertial parameters, if any."""
    end = len(x) - what["parameters"]
    return x[:3], x[3:end], x[end:]


def _dynamics_tangent(dynamics: str, m: Mechanism, x: Sequence[Array], tangents: Sequence[Any], value: Array,
                      what: dict[str, Any]) -> Array:
    """Tangent of inverse or forward dynamics. tau = Y pi + ... is linear in the parameters, and a change dpi acts on
    a as a change -Y dpi of tau."""
    state, _, pi = _parts(x, what)
    dx, _, dpi = _parts(tangents, what)
    dq, dv, dt = _velocity_tangents(m, state[0], dx)
    more = jnp.zeros_like(dt)
    if not _all_zero(dpi):
        a = value if dynamics == "forward_dynamics" else state[2]
        Y = state_function("regressor", m, *state[:2], a, threads=what["threads"])
        more = jnp.einsum("...ij,...j->...i", Y, dpi[0])
    if dynamics == "forward_dynamics":
        return state_function(f"{dynamics}_jvp", m, *state, dq, dv, dt - more, *pi, **what)
    return state_function(f"{dynamics}_jvp", m, *state, dq, dv, dt, *pi, **what) + more


def _derivative_tangent(function: str, m: Mechanism, x: Sequence[Array], tangents: Sequence[Any],
                        what: dict[str, Any]) -> Array:
    """Tangent of products with the first derivatives of dynamics, and of the Hessian."""
    dynamics, _, order = function.rpartition("_")
    state, linear, pi = _parts(x, what)
    dx, d_linear, dpi = _parts(tangents, what)
    if not _all_zero(dpi):
        raise NotImplementedError(_FIRST_BY_PARAMETERS)
    tangent = state_function(function, m, *state, *_along(d_linear), *pi, **what)
    if _all_zero(dx):
        return tangent
    if order == "hessian":
        raise NotImplementedError(f"axode.jax has first and second derivatives of {dynamics}; a third one was asked for")
    by = _velocity_tangents(m, state[0], dx)
    if order == "vjp":
        H = state_function(f"{dynamics}_hessian", m, *state, *linear, *pi, **what)
        return tangent + jnp.stack(_times(H, by), axis=-2)
    gradients = _times(_all_hessians(dynamics, m, state, pi, what), [each[..., None, :] for each in by])
    return tangent + sum(jnp.einsum("...il,...l->...i", g, each) for g, each in zip(gradients, linear))


def _mass_matrix_tangent(m: Mechanism, q: Array, dq: Array, threads: int) -> Array:
    """The tangent of M. A column of M is the inverse dynamics of a unit acceleration at rest without gravity, and so
    is its derivative."""
    assert m.still is not None
    delta, unit = velocities_of(m, q, dq), jnp.eye(m.nv, dtype=q.dtype)
    lead = q.shape[:-1]
    columns = [jnp.broadcast_to(each, (*lead, m.nv, each.shape[-1])) for each in (q[..., None, :], delta[..., None, :], unit)]
    none = jnp.zeros_like(columns[1])
    return state_function("inverse_dynamics_jvp", m.still, columns[0], none, columns[2], columns[1], none, none, threads=threads)


def twists_by(m: Mechanism, moves: np.ndarray[Any, Any], screws: Array, v: Array) -> Array:
    """The spatial twists of the bodies or frames that the joint screws move, as given by the rows of `moves`."""
    rates = v @ m.screw_rates.T.astype(v.dtype)
    return jnp.einsum("fk,...k,...kc->...fc", moves.astype(v.dtype), rates, screws)


def _kinematics_tangent(function: str, m: Mechanism, q: Array, dq: Array, value: Array, threads: int) -> Array:
    """dC = V^s C of frames, and dJ = [V^s, J] of the screws that the bodies carry (eq. JsX)."""
    v = velocities_of(m, q, dq)
    screws = value if function == "joint_screws" else state_function("joint_screws", m, q, threads=threads)
    if function == "joint_screws":
        V = twists_by(m, m.moves_screw, screws, v)
        w, u = screws[..., :3], screws[..., 3:]
        return jnp.concatenate([cross(V[..., :3], w), cross(V[..., :3], u) + cross(V[..., 3:], w)], axis=-1)
    V = twists_by(m, m.moves_frame, screws, v)
    columns = value.reshape(*value.shape[:-1], 4, 3)  # the columns of R, then r
    turned = cross(V[..., None, :3], columns)
    return (turned.at[..., 3, :].add(V[..., 3:])).reshape(value.shape)


def _state_function_tangent(function: str, m: Mechanism, x: Sequence[Array], tangents: Sequence[Any], value: Array,
                            what: dict[str, Any]) -> Array:
    if function in ("inverse_dynamics", "forward_dynamics"):
        return _dynamics_tangent(function, m, x, tangents, value, what)
    if "dynamics" in function:
        return _derivative_tangent(function, m, x, tangents, what)
    if function == "regressor":
        raise NotImplementedError(_FIRST_BY_PARAMETERS)
    q, dq, threads = x[0], _along(tangents)[0], what["threads"]
    if function == "mass_matrix":
        return _mass_matrix_tangent(m, q, dq, threads)
    if function == "inverse_mass_matrix":
        return -value @ _mass_matrix_tangent(m, q, dq, threads) @ value
    return _kinematics_tangent(function, m, q, dq, value, threads)


def _motion_tangent(function: str, m: Mechanism, x: Sequence[Array], tangents: Sequence[Any], values: Sequence[Array],
                    what: dict[str, Any]) -> list[Array]:
    if function == "rollout":
        dq, dv = motion("rollout_jvp", m, *x, *_velocity_tangents(m, x[0], tangents), **what)
        return [rates_of(m, values[0], dq), dv]
    if not _all_zero(tangents[:3]):
        raise NotImplementedError("axode.jax has first derivatives of rollout; a second one was asked for. Steps that you "
                                  "write with forward_dynamics and integrate in jax.lax.scan have second derivatives")
    return motion(function, m, *x[:3], *_along(tangents[3:]), **what)


def _differentiate(x: Sequence[Array], tangents: Sequence[Any], *, function: str, mechanism: Mechanism,
                   options: Any) -> tuple[Any, Any]:
    values = primitive.bind(*x, function=function, mechanism=mechanism, options=options)
    if function in ROWS:
        return values, [_state_function_tangent(function, mechanism, x, tangents, values[0], dict(options))]
    return values, _motion_tangent(function, mechanism, x, tangents, values, dict(options))


ad.primitive_jvps[primitive] = _differentiate


def _transpose(cotangents: Sequence[Any], *x: Any, function: str, mechanism: Mechanism, options: Any) -> list[Any]:
    """Transpose of a function that is linear in the arguments after the state: products with directions and products with
weights are transposes of each other."""
    what, weights = dict(options), _along(cotangents)
    if function in ROWS:
        state, linear, pi = _parts(x, what)
        found = _transposed_derivative(function, mechanism, state, pi, weights[0], what)
    else:
        state, linear, pi = x[:3], x[3:], ()
        other = "rollout_jvp" if function == "rollout_vjp" else "rollout_vjp"
        found = motion(other, mechanism, *state, *weights, **what)
    assert not any(ad.is_undefined_primal(each) for each in (*state, *pi))
    gradients = [each if ad.is_undefined_primal(given) else None for each, given in zip(found, linear)]
    return [*[None] * len(state), *gradients, *[None] * len(pi)]


def _transposed_derivative(function: str, m: Mechanism, state: Sequence[Array], pi: Sequence[Array], w: Array,
                           what: dict[str, Any]) -> list[Array]:
    dynamics, _, order = function.rpartition("_")
    if order == "jvp":
        gradient = state_function(f"{dynamics}_vjp", m, *state, w, *pi, **what)
        return [gradient[..., k, :] for k in range(3)]
    if order == "vjp":
        return [state_function(f"{dynamics}_jvp", m, *state, *(w[..., k, :] for k in range(3)), *pi, **what)]
    return [jnp.einsum("...hkl,...ihkl->...i", w, _all_hessians(dynamics, m, state, pi, what))]


ad.primitive_transposes[primitive] = _transpose


# Distances of collision shapes, which XLA asks Python for

#: How far the norm of a quaternion may be from 1, by the type of the numbers.
OFF_LENGTH = {"float64": 1e-6, "float32": 1e-4}


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2, 3))
def distances_of(m: Model, of: Mechanism, pairs: tuple[tuple[str, str], ...], threads: int, q: Array) -> Array:
    """The signed distances (..., P) of pairs of collision shapes."""
    return _with_jacobians(m, of, pairs, threads, q)[0]


@distances_of.defjvp  # type: ignore[untyped-decorator, unused-ignore]
def _change_of_distances(m: Model, of: Mechanism, pairs: Any, threads: int, primals: Any, tangents: Any) -> tuple[Array, Array]:
    (q,), (dq,) = primals, tangents
    distances, J = _with_jacobians(m, of, pairs, threads, q)
    return distances, jnp.einsum("...pv,...v->...p", J, velocities_of(of, q, dq))


@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2, 3))
def _with_jacobians(m: Model, of: Mechanism, pairs: Any, threads: int, q: Array) -> list[Array]:
    def compute(q: Any) -> list[Any]:
        states = np.asarray(q, np.float64).reshape(-1, of.nq)
        finite = np.isfinite(states).all(axis=-1)
        unit = m.normalize(states[finite])
        near = np.abs(states[finite] - unit).max(axis=-1, initial=0) <= OFF_LENGTH[q.dtype.name]
        results = []
        for x in pair_distances(m, np.where(near[:, None], unit, states[finite]), pairs, threads=threads):
            result = np.full((len(states), *x.shape[1:]), np.nan, q.dtype)
            result[finite] = x
            results.append(result.reshape(*q.shape[:-1], *x.shape[1:]))
        return results

    lead, P = q.shape[:-1], len(pairs)
    shapes = [jax.ShapeDtypeStruct((*lead, P), q.dtype), jax.ShapeDtypeStruct((*lead, P, of.nv), q.dtype)]
    return list(jax.pure_callback(compute, shapes, q, vmap_method="broadcast_all"))


@_with_jacobians.defjvp  # type: ignore[untyped-decorator, unused-ignore]
def _refuse_second_derivatives(m: Model, of: Mechanism, pairs: Any, threads: int, primals: Any, tangents: Any) -> Any:
    raise NotImplementedError("axode.jax.pair_distances has first derivatives; a second one was asked for")
