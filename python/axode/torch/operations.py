"""Operations of PyTorch: the function that defines them, and those of kinematics."""

from __future__ import annotations

import functools
import inspect
import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import torch  # type: ignore[import-not-found, unused-ignore]
from torch import Tensor

from ..support import coordinates
from .mechanism import Array, array, mechanism, sizes, with_parameters

__all__: list[str] = []


# Tensors

def tensor(result: Array, q: Tensor) -> Tensor:
    """A result for the states of q."""
    found = torch.from_numpy(np.asarray(result, order="C")).to(q.dtype)
    return found if q.ndim <= 2 else found.reshape(*q.shape[:-1], *found.shape[1:])


def evaluated(key: str, name: str, q: Tensor, *others: Tensor, parameters: Tensor | None = None) -> tuple[Tensor, ...]:
    """The results of a function of axode; if parameters are given, those of the model with these."""
    of = mechanism(key)
    arrays = [of.configurations(q), *map(array, others)]
    if parameters is None:
        found = of(name, *arrays)
    else:
        found = _by_parameters(key, name, arrays, array(parameters).astype(np.float64))
    return tuple(tensor(result, q) for result in found)


def _by_parameters(key: str, name: str, arrays: list[Array], pi: Array) -> tuple[Array, ...]:
    """The results of a function with the parameters of each state, with one call for all states that share theirs."""
    if len(pi) == 0:
        return mechanism(key)(name, *arrays)
    if pi.ndim == 1 or (pi == pi[0]).all():
        return with_parameters(key, (pi if pi.ndim == 1 else pi[0]).tobytes())(name, *arrays)
    states: dict[bytes, list[int]] = {}
    for k, own in enumerate(pi):
        states.setdefault(own.tobytes(), []).append(k)
    found = [(its, with_parameters(key, own)(name, *(a[its] for a in arrays))) for own, its in states.items()]
    results = tuple(np.empty((len(pi), *one.shape[1:])) for one in found[0][1])
    for its, own_results in found:
        for result, one in zip(results, own_results):
            result[its] = one
    return results


def times(A: Tensor, x: Tensor) -> Tensor:
    return (A @ x[..., None])[..., 0]


def cross(x: Tensor, y: Tensor) -> Tensor:
    return torch.linalg.cross(x, y, dim=-1)


def empty(x: Tensor, *item: int) -> Tensor:
    """A tensor with an item for each state of x."""
    return x.new_empty((*x.shape[:-1], *item))


# Coordinates: q' = E(q) v, where E has orthogonal columns

_ARRAYS = coordinates.Arrays(
    part=lambda x, first, end: x[..., first:end], join=lambda parts: torch.cat(parts, dim=-1), cross=cross,
    dot=lambda x, y: (x * y).sum(dim=-1, keepdim=True), where=torch.where, functions=torch)


def _joined(parts: list[Tensor], otherwise: Tensor) -> Tensor:
    return torch.cat(parts, dim=-1) if len(parts) > 0 else otherwise


def rates(key: str, q: Tensor, v: Tensor) -> Tensor:
    """The rates E v of the coordinates."""
    return _joined([coordinates.rates(_ARRAYS, kind, q[..., at_q], v[..., at_v])
                    for kind, at_q, at_v in mechanism(key).parts], v)


def displacement(key: str, q: Tensor, dq: Tensor) -> Tensor:
    """The left-trivialised displacement (..., nv) of q / |q| by dq (..., nq), E^+ dq."""
    return _joined([coordinates.velocities(_ARRAYS, kind, q[..., at_q], dq[..., at_q])
                    for kind, at_q, _ in mechanism(key).parts], dq)


def squares(key: str, q: Tensor) -> Tensor | float:
    """The diagonal of E^T E: |a|^2 / 4 for the angular velocity of a joint with the quaternion a, 1 for all other
    velocities."""
    if not mechanism(key).turning:
        return 1.0
    squares, one = [], torch.ones_like(q[..., :1])
    for kind, at_q, at_v in mechanism(key).parts:
        width = at_v.stop - at_v.start
        if kind in coordinates.TURNING:
            a = q[..., at_q.start:at_q.start + 4]
            squares.append((a.square().sum(dim=-1, keepdim=True) / 4).expand(*q.shape[:-1], 3))
            width -= 3
        squares.append(one.expand(*q.shape[:-1], width))
    return torch.cat(squares, dim=-1)


def by_coordinates(key: str, q: Tensor, g: Tensor) -> Tensor:
    """The gradient (..., nq) by q of a function of q / |q| from that along left-trivialised directions (..., nv), g
    E^+."""
    return rates(key, q, g / squares(key, q))


# Operations

def operation(schema: str, compute: Callable[..., Any], like: Callable[..., Any],
               backward: Callable[..., tuple[Tensor | None, ...]] | None = None,
               forward: Callable[..., Any] | None = None) -> Callable[..., Any]:
    """Makes an operation torch.ops.axode.NAME, and returns the function to call it by.

    Its first arguments are constants, the first of these a model; the others are tensors with the same leading axes.
    `like` returns empty results, `backward(ctx, constants, tensors, results, *weights)` a gradient for each tensor,
    `forward(constants, tensors, results, *directions)` the change of the results; a single constant is not in a
    tuple. Operations of torch.library support neither forward mode nor torch.func.grad. Therefore the function calls
    them through an autograd.Function, which supports both, unless it is being compiled.
    """
    name, _, signature = schema.partition("(")
    kinds = [argument.split()[0] for argument in signature.partition(")")[0].split(",")]
    front = sum(not kind.startswith("Tensor") for kind in kinds)
    op = torch.library.custom_op(f"axode::{name}", compute, mutates_args=(), device_types="cpu", schema="(" + signature)

    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Any) -> None:
        results = output if isinstance(output, tuple) else (output,)
        ctx.constants, ctx.mechanism = inputs[:front], mechanism(inputs[0])
        ctx.save_for_backward(*inputs[front:], *results)
        ctx.save_for_forward(*inputs[front:], *results)
        ctx.tensors = len(inputs) - front
        ctx.set_materialize_grads(False)

    def kept(ctx: Any, rule: Any) -> tuple[Any, tuple[Any, ...], tuple[Tensor, ...]]:
        if rule is None:
            raise NotImplementedError(f"axode.torch has no derivatives of {name.replace('_', ' ')}")
        constants = ctx.constants[0] if front == 1 else ctx.constants
        return constants, ctx.saved_tensors[:ctx.tensors], ctx.saved_tensors[ctx.tensors:]

    def differentiate(ctx: Any, *weights: Tensor) -> tuple[Tensor | None, ...]:
        constants, tensors, results = kept(ctx, backward)
        ctx.needed = ctx.needs_input_grad[front:]
        weights = tuple(torch.zeros_like(x) if w is None else w for x, w in zip(results, weights))
        return (*front * (None,), *backward(ctx, constants, tensors, results, *weights))  # type: ignore[misc]

    def push(ctx: Any, *directions: Any) -> Any:
        constants, tensors, results = kept(ctx, forward)
        given = [torch.zeros_like(x) if d is None and kind == "Tensor" else d
                 for kind, x, d in zip(kinds[front:], tensors, directions[front:])]
        return forward(constants, tensors, results, *given)  # type: ignore[misc]

    def batched(info: Any, in_dims: tuple[int | None, ...], *arguments: Any) -> tuple[Any, Any]:
        result = call(*arguments[:front], *_in_front(info.batch_size, in_dims[front:], arguments[front:]))
        return result, len(result) * (0,) if isinstance(result, tuple) else 0

    def value(*arguments: Any) -> Any:
        return op(*arguments)

    # The signature is asked for in every call.
    value.__signature__ = inspect.signature(value)  # type: ignore[attr-defined]
    statics = {"forward": value, "setup_context": setup_context, "backward": differentiate, "vmap": batched,
               "jvp": push}
    function: Any = type(name, (torch.autograd.Function,), {key: staticmethod(value) for key, value in statics.items()})

    def call(*arguments: Any) -> Any:
        return op(*arguments) if torch.compiler.is_compiling() else function.apply(*arguments)

    op.register_fake(like)
    op.register_autograd(differentiate, setup_context=setup_context)
    op.register_vmap(batched)
    return call


def _in_front(size: int, axes: tuple[int | None, ...], tensors: tuple[Any, ...]) -> Iterator[Any]:
    for axis, x in zip(axes, tensors):
        yield x if x is None else x.expand(size, *x.shape) if axis is None else x.movedim(axis, 0)


def one_of_v(key: str, q: Tensor, v: Tensor, *others: Any) -> Tensor:
    return empty(v, v.shape[-1])


def three_of_v(key: str, q: Tensor, v: Tensor, *others: Any) -> tuple[Tensor, ...]:
    return tuple(empty(v, v.shape[-1]) for _ in range(3))


# Kinematics: derivatives of poses are body-fixed twists and wrenches of all frames

def _loads(W: Tensor) -> list[Any]:
    wrenches = array(W, 2)
    return [{"frame": k, "wrench": wrenches[..., k, :]} for k in range(W.shape[-2])]


def loads_of(key: str, q: Tensor, W: Tensor) -> Tensor:
    states = mechanism(key).configurations(q)
    v = np.zeros((*states.shape[:-1], sizes(key)[1]))
    return tensor(mechanism(key)("generalized_loads", states, v, _loads(W))[0], q)


def _load_product_of(key: str, gradient: bool, q: Tensor, W: Tensor, v: Tensor) -> Tensor:
    """The gradient of v . Q(q, W) along q, or the change of Q by the displacement v."""
    of = mechanism(key)
    states, rest = of.configurations(q), np.zeros_like(array(v), dtype=np.float64)
    by_q = tensor(of("generalized_load_derivatives", states, rest, _loads(W))[0], q)
    return times(by_q.mT if gradient else by_q, v)


def _frames(key: str) -> int:
    return len(mechanism(key).model.frame_names)


_load_product = operation(
    "load_product(str model, bool gradient, Tensor q, Tensor W, Tensor v) -> Tensor",
    _load_product_of, lambda key, gradient, q, W, v: empty(v, v.shape[-1]))
_generalized_loads: Callable[..., Any] = operation(  # Q = sum of J^T W
    "generalized_loads(str model, Tensor q, Tensor W) -> Tensor",
    loads_of, lambda key, q, W: empty(q, sizes(key)[1]),
    lambda ctx, key, x, Q, w: (by_coordinates(key, x[0], _load_product(key, True, *x, w)) if ctx.needed[0] else None,
                               twists(key, x[0], w) if ctx.needed[1] else None),
    lambda key, x, Q, dq, dW: (_load_product(key, False, *x, displacement(key, x[0], dq))
                               + _generalized_loads(key, x[0], dW)))
twists: Callable[..., Any] = operation(  # V = J v, so w . V = v . Q(q, w)
    "twists(str model, Tensor q, Tensor v) -> Tensor",
    lambda key, q, v: evaluated(key, "twists", q, v)[0], lambda key, q, v: empty(q, _frames(key), 6),
    lambda ctx, key, x, V, w: (
        by_coordinates(key, x[0], _load_product(key, True, x[0], w, x[1])) if ctx.needed[0] else None,
        _generalized_loads(key, x[0], w) if ctx.needed[1] else None))


def _poses_backward(ctx: Any, key: Any, x: Any, C: Any, w: Tensor) -> tuple[Tensor]:
    """dC = C hat(X): w . dC = W . X with the body-fixed wrench W = (axial(R^T w_R); R^T w_r)."""
    q, R = x[0], C[0][..., :3, :3]
    A = R.mT @ w[..., :3, :3]
    axial = [A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]]
    moment = torch.stack(axial, dim=-1)
    W = torch.cat([moment, times(R.mT, w[..., :3, 3])], dim=-1)
    return (by_coordinates(key, q, _generalized_loads(key, q, W)),)


def _poses_forward(key: Any, x: Any, C: Any, dq: Tensor) -> Tensor:
    x, y, z, *u = twists(key, x[0], displacement(key, x[0], dq)).unbind(-1)
    o = torch.zeros_like(z)
    rows = [o, -z, y, u[0], z, o, -x, u[1], -y, x, o, u[2], o, o, o, o]
    return C[0] @ torch.stack(rows, dim=-1).unflatten(-1, (4, 4))


poses = operation(
    "poses(str model, Tensor q) -> Tensor",
    lambda key, q: evaluated(key, "poses", q)[0], lambda key, q: empty(q, _frames(key), 4, 4),
    _poses_backward, _poses_forward)


def _jacobian_of(key: str, frame: int, representation: str, order: int, q: Tensor) -> Tensor:
    of = mechanism(key)
    name, more = ("jacobian_partials", (order,)) if order > 0 else ("jacobian", ())
    return tensor(of(name, of.configurations(q), frame, representation, *more)[0], q)


def _jacobian_backward(ctx: Any, constants: Any, x: Any, J: Any, w: Tensor) -> tuple[Tensor]:
    key, frame, representation, order = constants
    partials = jacobian_partials(key, frame, representation, order + 1, *x)  # the outermost derivative first
    along = times(partials.flatten(-(order + 2)), w.flatten(-(order + 2)))
    return (by_coordinates(key, x[0], along),)


def _jacobian_forward(constants: Any, x: Any, J: Any, dq: Tensor) -> Tensor:
    key, frame, representation, order = constants
    partials = jacobian_partials(key, frame, representation, order + 1, *x)
    along = displacement(key, x[0], dq)[..., None, :] @ partials.flatten(-(order + 2))
    return along.reshape(J[0].shape)


jacobian_partials = operation(
    "jacobian_partials(str model, int frame, str representation, int order, Tensor q) -> Tensor", _jacobian_of,
    lambda key, frame, representation, order, q: empty(q, *order * (sizes(key)[1],), 6, sizes(key)[1]),
    _jacobian_backward, _jacobian_forward)


# Distances of collision shapes; the names of their pairs are a text of JSON

def _pair_distances(result: int, key: str, pairs: str, q: Tensor) -> Tensor:
    of = mechanism(key)
    return tensor(of("pair_distances", of.configurations(q), json.loads(pairs))[result], q)


_pair_jacobians = operation(
    "pair_jacobians(str model, str pairs, Tensor q) -> Tensor", functools.partial(_pair_distances, 1),
    lambda key, pairs, q: empty(q, len(json.loads(pairs)), sizes(key)[1]))
pair_distances = operation(
    "pair_distances(str model, str pairs, Tensor q) -> Tensor", functools.partial(_pair_distances, 0),
    lambda key, pairs, q: empty(q, len(json.loads(pairs))),
    lambda ctx, constants, x, d, w: (
        by_coordinates(constants[0], x[0], (w[..., None, :] @ _pair_jacobians(*constants, x[0]))[..., 0, :]),),
    lambda constants, x, d, dq: times(_pair_jacobians(*constants, x[0]), displacement(constants[0], x[0], dq)))
