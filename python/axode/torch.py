"""Functions of the state as operations of PyTorch: axode.torch.inverse_dynamics(m, q, v, a), and what learns through them.

Names and arguments are those of axode, on tensors of float64 or float32 with any axes in front, which broadcast. Gradients
are exact, by the vjp of the library, second derivatives by its second derivatives. Every function is an operation
`torch.ops.axode`, which torch.compile, torch.func and torch.export know. See docs/torch.md.

Needs PyTorch: pip install torch.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import inspect
import itertools
import math
import pickle
import weakref
from collections.abc import Callable, Iterator
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _axode
from ._axode import Model, check_counts
from .codegen import Specialised
from .records import Representation

try:
    import torch  # type: ignore[import-not-found, unused-ignore]
    from torch import Tensor
except ImportError as error:
    raise ImportError('axode.torch needs PyTorch: pip install torch') from error

__all__ = ["center_of_mass", "forward_dynamics", "handle", "inertial_parameters", "inverse_dynamics", "inverse_mass_matrix",
           "jacobian", "kinetic_energy", "mass_matrix", "poses", "potential_energy", "rollout"]

Array = NDArray[np.float64]

#: Models that are kept for operations to come, the last ones that were used.
KEPT = 256
#: Models with other parameters that are kept, so that backward finds that of forward.
KEPT_PARAMETERS = 32
#: Calls with fewer states run on one core.
MANY = 64
#: How far a quaternion may be from length 1, as in the library.
OFF_LENGTH = {torch.float64: 1e-6, torch.float32: 1e-4}


# Models, which operations know by a word

class _Part(NamedTuple):
    """Coordinates of one joint, or of several that have a velocity for each coordinate, its rate."""

    kind: Literal["plain", "planar", "spherical", "free"]
    q: slice
    v: slice


class _Mechanism:
    """A model as operations know it."""

    def __init__(self, m: Model | Specialised, key: str):
        self.key = key
        self.model = m if isinstance(m, Model) else m.model
        self.compiled = {} if isinstance(m, Model) else _compiled(m)
        self.is_specialised = not isinstance(m, Model)
        self.sizes = (self.model.nq, self.model.nv, 10 * self.model.n_bodies)
        self.parts = _parts(self.model)
        self.turning = [part for part in self.parts if part.kind in ("spherical", "free")]

    def __call__(self, name: str, *arguments: Any) -> tuple[Array, ...]:
        """What a function of axode gives."""
        states = np.shape(arguments[0])
        many = len(states) == 2 and states[0] >= MANY
        function = self.compiled.get(name) or functools.partial(getattr(_axode, name), self.model)
        result = function(*arguments, threads=torch.get_num_threads() if many else 1)
        return result if isinstance(result, tuple) else (result,)

    def configurations(self, q: Tensor) -> Array:
        """With the quaternions made as long as they should be; the library refuses those that are too far from that."""
        given = _array(q)
        if not self.turning:
            return given
        unit = given.astype(np.float64)
        for part in self.turning:
            at = slice(part.q.start, part.q.start + 4)
            length = np.linalg.norm(unit[..., at], axis=-1, keepdims=True)
            if np.all(np.abs(length - 1) <= OFF_LENGTH[q.dtype]):
                unit[..., at] /= length
        return unit

    @property
    def tree(self) -> _Mechanism:
        """The mechanism without its loops, as mass matrices and energies see it."""
        return self if self.model.n_loops == 0 else self._cut

    @functools.cached_property
    def _cut(self) -> _Mechanism:
        drawing = {key: value for key, value in self.model.to_dict().items() if key not in ("loop", "coupling")}
        return _mechanism_of(Model.from_dict(drawing))

    @functools.cached_property
    def still(self) -> _Mechanism:
        """The same without gravity, where forces at rest are M a."""
        return _mechanism_of(self.tree.model.with_gravity([0, 0, 0]))

    @functools.cached_property
    def heights(self) -> list[_Mechanism]:
        """The same with a gravity of 1 m/s^2 against x, y and z: potential energies are first moments of mass."""
        return [_mechanism_of(self.tree.model.with_gravity(-axis)) for axis in np.eye(3)]

    @functools.cached_property
    def solids(self) -> list[_Mechanism]:
        """The same with bodies of 1 kg and 10 kg m^2, and then with one more of each parameter in turn."""
        like = np.tile([1, 0, 0, 0, 10, 10, 10, 0, 0, 0], self.model.n_bodies)
        return [_Mechanism(self.model.with_parameters(like + more), self.key) for more in [0 * like, *np.eye(len(like))]]


def _compiled(s: Specialised) -> dict[str, Callable[..., Any]]:
    """The functions that a specialised model was made with."""
    q, v = np.empty((0, s.model.nq)), np.empty((0, s.model.nv))
    found = {}
    for name, others in [("mass_matrix", 0), ("inverse_mass_matrix", 0), ("poses", 0)] + [
            (dynamics + kind, others) for dynamics in ("inverse_dynamics", "forward_dynamics")
            for kind, others in (("", 2), ("_jvp", 5), ("_vjp", 3), ("_hessian", 3))]:
        try:
            getattr(s, name)(q, *others * [v])
        except ValueError:
            continue  # it is left to the library
        found[name] = getattr(s, name)
    if "forward_dynamics" in found:
        found["rollout_under"] = functools.partial(_axode.rollout_under, s.model, compiled=s)
    return found


def _parts(m: Model) -> list[_Part]:
    parts: list[_Part] = []
    for joint in m.joints:
        if joint.nv == 0:
            continue
        kind = joint.kind if joint.kind in ("planar", "spherical", "free") else "plain"
        if kind == "plain" and parts and parts[-1].kind == "plain":
            before = parts.pop()
            parts.append(_Part("plain", slice(before.q.start, joint.q.stop), slice(before.v.start, joint.v.stop)))
        else:
            parts.append(_Part(kind, joint.q, joint.v))  # type: ignore[arg-type]
    return parts


#: Those that are alive: some of the last ones used, and all that a graph is to go back through.
_mechanisms: weakref.WeakValueDictionary[str, _Mechanism] = weakref.WeakValueDictionary()
_specialised_number = itertools.count(1)


@functools.lru_cache(maxsize=KEPT)
def _mechanism_of(m: Model | Specialised) -> _Mechanism:
    model = m if isinstance(m, Model) else m.model
    key = f"{model.name} {hashlib.sha256(pickle.dumps(model)).hexdigest()[:16]}"
    if not isinstance(m, Model):
        key += f" specialised {next(_specialised_number)}"
    if (found := _mechanisms.get(key)) is not None:
        return found
    return _mechanisms.setdefault(key, _Mechanism(m, key))


@functools.lru_cache(maxsize=KEPT_PARAMETERS)
def _with_parameters(key: str, pi: bytes) -> _Mechanism:
    mechanism = _mechanism(key)
    if mechanism.is_specialised:
        raise ValueError("parameters: those of a specialised model are compiled into it; give the model itself")
    return _Mechanism(mechanism.model.with_parameters(np.frombuffer(pi)), key)


@atexit.register
def _forget() -> None:
    """PyTorch keeps operations and graphs, and what they refer to, to the very end, where models would be taken for leaked."""
    _mechanism_of.cache_clear()
    _with_parameters.cache_clear()
    for mechanism in list(_mechanisms.values()):
        vars(mechanism).clear()


def _mechanism(key: str) -> _Mechanism:
    try:
        return _mechanisms[key]
    except KeyError:
        raise KeyError(f"this process knows no model {key!r}; axode.torch.handle(m) tells it one") from None


def handle(m: Model | Specialised) -> str:
    """The word by which operations of `torch.ops.axode` know a model, which models alike share, in every process.

    Functions of this module ask for it themselves. What was exported, or compiled elsewhere, finds its models where
    this was called. The last 256 models are kept, and those whose graph is still to be gone back through.

    >>> axode.torch.handle(arm) == axode.torch.handle(arm.with_gravity([0, 0, -1.62]))
    False
    >>> import pickle
    >>> axode.torch.handle(arm) == axode.torch.handle(pickle.loads(pickle.dumps(arm)))
    True
    """
    if not isinstance(m, (Model, Specialised)):
        raise TypeError(f"m: expected an axode.Model, or what Model.specialise makes of one, got {type(m).__name__}")
    return _mechanism_of(m).key


def _sizes(key: str) -> tuple[int, int, int]:
    return _mechanism(key).sizes


def _total_mass(key: str) -> float:
    return _mechanism(key).model.total_mass


def _heights(key: str) -> tuple[str, str, str]:
    x, y, z = _mechanism(key).heights
    return x.key, y.key, z.key


def _refuse_loops(key: str, name: str) -> None:
    check_counts(_mechanism(key).model, name)


def _frame(key: str, frame: str | int) -> int:
    return _mechanism(key).model.frame_index(frame)


# What depends on a model alone is a constant to torch.compile, which compiles anew for another model.
for _constant in (handle, _sizes, _total_mass, _heights, _refuse_loops, _frame):
    torch.compiler.assume_constant_result(_constant)


# Tensors and arrays

def _array(x: Tensor, axes: int = 1) -> Array:
    """The numbers of a tensor, with the axes of an item and at most one in front."""
    a: Array = x.detach().numpy()
    lead, item = a.shape[:a.ndim - axes], a.shape[a.ndim - axes:]
    return a if len(lead) < 2 else a.reshape(math.prod(lead), *item)


def _tensor(result: Array, q: Tensor) -> Tensor:
    """A result for the states of q."""
    found = torch.from_numpy(np.asarray(result, order="C")).to(q.dtype)
    return found if q.ndim <= 2 else found.reshape(*q.shape[:-1], *found.shape[1:])


def _evaluated(key: str, name: str, q: Tensor, *others: Tensor, parameters: Tensor | None = None) -> tuple[Tensor, ...]:
    """A function of axode on states; where they have parameters, of a model with these."""
    mechanism = _mechanism(key)
    arrays = [mechanism.configurations(q), *map(_array, others)]
    if parameters is None:
        found = mechanism(name, *arrays)
    else:
        found = _by_parameters(key, name, arrays, _array(parameters).astype(np.float64))
    return tuple(_tensor(result, q) for result in found)


def _by_parameters(key: str, name: str, arrays: list[Array], pi: Array) -> tuple[Array, ...]:
    if pi.ndim == 1:
        return _with_parameters(key, pi.tobytes())(name, *arrays)
    if len(pi) == 0:
        return _mechanism(key)(name, *arrays)
    if (pi == pi[0]).all():
        return _with_parameters(key, pi[0].tobytes())(name, *arrays)
    states: dict[bytes, list[int]] = {}
    for k, own in enumerate(pi):
        states.setdefault(own.tobytes(), []).append(k)
    found = [(its, _with_parameters(key, own)(name, *(a[its] for a in arrays))) for own, its in states.items()]
    results = tuple(np.empty((len(pi), *one.shape[1:])) for one in found[0][1])
    for its, own_results in found:
        for result, one in zip(results, own_results):
            result[its] = one
    return results


# Quaternions: derivatives along velocities, and by coordinates

def _by_coordinates(key: str, q: Tensor, g: Tensor) -> Tensor:
    """The gradient by q (..., nq) of a function of q / |q| from that along left-trivialised directions (..., nv).

    With dq = E(q) w it is 4 E g / |q|^2 for a quaternion, E g for what else turns with the joint (E is orthogonal there).
    """
    parts = []
    for kind, at_q, at_v in _mechanism(key).parts:
        x, y = q[..., at_q], g[..., at_v]
        if kind == "planar":
            parts.append(torch.cat([y[..., :1], _turned(x[..., 0], y[..., 1:])], dim=-1))
        elif kind == "plain":
            parts.append(y)
        else:
            u, w, double = x[..., :3], x[..., 3:4], 2 / x[..., :4].square().sum(dim=-1, keepdim=True)
            parts += [double * (w * y[..., :3] + _cross(u, y[..., :3])), -double * (u * y[..., :3]).sum(dim=-1, keepdim=True)]
            if kind == "free":
                r = y[..., 3:]
                parts.append(r + double * _cross(u, _cross(u, r) + w * r))
    return torch.cat(parts, dim=-1) if len(parts) > 1 else g


def _along(key: str, q: Tensor, dq: Tensor) -> Tensor:
    """The displacement (..., nv) of q / |q| by dq (..., nq), the transpose of `_by_coordinates`."""
    parts = []
    for kind, at_q, at_v in _mechanism(key).parts:
        x, d = q[..., at_q], dq[..., at_q]
        if kind == "planar":
            parts.append(torch.cat([d[..., :1], _turned(-x[..., 0], d[..., 1:])], dim=-1))
        elif kind == "plain":
            parts.append(d)
        else:
            u, w, double = x[..., :3], x[..., 3:4], 2 / x[..., :4].square().sum(dim=-1, keepdim=True)
            parts.append(double * (w * d[..., :3] + _cross(d[..., :3], u) - d[..., 3:4] * u))
            if kind == "free":
                r = d[..., 4:]
                parts.append(r + double * _cross(u, _cross(u, r) - w * r))
    return torch.cat(parts, dim=-1) if len(parts) > 1 else dq


def _rates(key: str, x: Tensor) -> Tensor:
    """Scales (..., nv) by 1/4 what turns a quaternion: `_by_coordinates` of it is E(q) x, dq/dt."""
    scale = x.new_ones(x.shape[-1])
    for part in _mechanism(key).turning:
        scale[part.v.start:part.v.start + 3] = 0.25
    return x * scale


def _turned(angle: Tensor, x: Tensor) -> Tensor:
    c, s = torch.cos(angle), torch.sin(angle)
    return torch.stack([c * x[..., 0] - s * x[..., 1], s * x[..., 0] + c * x[..., 1]], dim=-1)


def _cross(x: Tensor, y: Tensor) -> Tensor:
    return torch.linalg.cross(x, y, dim=-1)


# Operations

def _operation(schema: str, compute: Callable[..., Any], like: Callable[..., Any],
               backward: Callable[..., tuple[Tensor | None, ...]] | None = None,
               forward: Callable[..., Any] | None = None) -> Callable[..., Any]:
    """An operation torch.ops.axode.NAME, and the function to call it by.

    Its first arguments are constants, the first of these a model; the others are tensors with the same leading axes.
    `like` gives empty results, `backward(ctx, constants, tensors, results, *weights)` a gradient for each tensor,
    `forward(constants, tensors, results, *directions)` what these do to the results; a single constant is not in a tuple. Operations of torch.library know neither
    forward mode nor torch.func.grad, so that but for compilation it is called through an autograd.Function, which does.
    """
    name, _, signature = schema.partition("(")
    kinds = [argument.split()[0] for argument in signature.partition(")")[0].split(",")]
    front = sum(not kind.startswith("Tensor") for kind in kinds)
    op = torch.library.custom_op(f"axode::{name}", compute, mutates_args=(), device_types="cpu", schema="(" + signature)

    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Any) -> None:
        results = output if isinstance(output, tuple) else (output,)
        ctx.constants, ctx.mechanism = inputs[:front], _mechanism(inputs[0])
        ctx.save_for_backward(*inputs[front:], *results)
        if forward is not None:
            ctx.save_for_forward(*inputs[front:], *results)
        ctx.tensors = len(inputs) - front
        ctx.set_materialize_grads(False)

    def kept(ctx: Any) -> tuple[Any, tuple[Any, ...], tuple[Tensor, ...]]:
        return ctx.constants[0] if front == 1 else ctx.constants, ctx.saved_tensors[:ctx.tensors], ctx.saved_tensors[ctx.tensors:]

    def differentiate(ctx: Any, *weights: Tensor) -> tuple[Tensor | None, ...]:
        if backward is None:
            raise NotImplementedError(f"axode.torch has no derivatives of {name.replace('_', ' ')}")
        ctx.needed = ctx.needs_input_grad[front:]
        constants, tensors, results = kept(ctx)
        weights = tuple(torch.zeros_like(x) if w is None else w for x, w in zip(results, weights))
        return (*front * (None,), *backward(ctx, constants, tensors, results, *weights))

    def push(ctx: Any, *directions: Any) -> Any:
        assert forward is not None
        constants, tensors, results = kept(ctx)
        given = [torch.zeros_like(x) if d is None and kind == "Tensor" else d
                 for kind, x, d in zip(kinds[front:], tensors, directions[front:])]
        return forward(constants, tensors, results, *given)

    def batched(info: Any, in_dims: tuple[int | None, ...], *arguments: Any) -> tuple[Any, Any]:
        result = call(*arguments[:front], *_in_front(info.batch_size, in_dims[front:], arguments[front:]))
        return result, len(result) * (0,) if isinstance(result, tuple) else 0

    def value(*arguments: Any) -> Any:
        return op(*arguments)

    value.__signature__ = inspect.signature(value)  # type: ignore[attr-defined]  # which is asked for in every call
    statics = {"forward": value, "setup_context": setup_context, "backward": differentiate, "vmap": batched,
               **({"jvp": push} if forward is not None else {})}
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


def _empty(x: Tensor, *item: int) -> Tensor:
    """For the states of x."""
    return x.new_empty((*x.shape[:-1], *item))


def _one_of_v(key: str, q: Tensor, v: Tensor, *others: Any) -> Tensor:
    return _empty(v, v.shape[-1])


def _three_of_v(key: str, q: Tensor, v: Tensor, *others: Any) -> tuple[Tensor, ...]:
    return tuple(_empty(v, v.shape[-1]) for _ in range(3))


def _times(A: Tensor, x: Tensor) -> Tensor:
    return (A @ x[..., None])[..., 0]


NO_SECOND = ("axode.torch has first derivatives by inertial parameters only where there are loops: give parameters that need no "
             "gradient, parameters.detach(), where second derivatives are wanted")


# Motion and loads of all frames, body-fixed: the parts from which derivatives of poses and by parameters are made

def _loads(frames: int, W: Array) -> list[Any]:
    return [{"frame": k, "wrench": W[..., k, :]} for k in range(frames)]


def _loads_of(key: str, q: Tensor, W: Tensor) -> Tensor:
    mechanism, states = _mechanism(key), _mechanism(key).configurations(q)
    v = np.zeros((*states.shape[:-1], mechanism.model.nv))
    return _tensor(mechanism("generalized_loads", states, v, _loads(W.shape[-2], _array(W, 2)))[0], q)


def _load_product_of(key: str, gradient: bool, q: Tensor, W: Tensor, v: Tensor) -> Tensor:
    """The gradient of v . Q(q, W) along q, or what the displacement v does to Q."""
    mechanism, states = _mechanism(key), _mechanism(key).configurations(q)
    by_q, _ = mechanism("generalized_load_derivatives", states, np.zeros_like(_array(v), dtype=np.float64),
                        _loads(W.shape[-2], _array(W, 2)))
    return _times(_tensor(by_q, q).mT if gradient else _tensor(by_q, q), v)


def _frames(key: str) -> int:
    return len(_mechanism(key).model.frame_names)


_load_product = _operation(
    "load_product(str model, bool gradient, Tensor q, Tensor W, Tensor v) -> Tensor",
    _load_product_of, lambda key, gradient, q, W, v: _empty(v, v.shape[-1]))
_generalized_loads: Callable[..., Any] = _operation(  # Q = sum of J^T W
    "generalized_loads(str model, Tensor q, Tensor W) -> Tensor",
    _loads_of, lambda key, q, W: _empty(q, _sizes(key)[1]),
    lambda ctx, key, x, Q, w: (_by_coordinates(key, x[0], _load_product(key, True, *x, w)) if ctx.needed[0] else None,
                               _twists(key, x[0], w) if ctx.needed[1] else None),
    lambda key, x, Q, dq, dW: _load_product(key, False, *x, _along(key, x[0], dq)) + _generalized_loads(key, x[0], dW))
_twists: Callable[..., Any] = _operation(  # V = J v, so w . V = v . Q(q, w)
    "twists(str model, Tensor q, Tensor v) -> Tensor",
    lambda key, q, v: _evaluated(key, "twists", q, v)[0], lambda key, q, v: _empty(q, _frames(key), 6),
    lambda ctx, key, x, V, w: (_by_coordinates(key, x[0], _load_product(key, True, x[0], w, x[1])) if ctx.needed[0] else None,
                               _generalized_loads(key, x[0], w) if ctx.needed[1] else None))


def _poses_backward(ctx: Any, key: Any, x: Any, C: Any, w: Tensor) -> tuple[Tensor]:
    """dC = C hat(X): w . dC = W . X with the body-fixed wrench W = (axial(R^T w_R); R^T w_r)."""
    q, R = x[0], C[0][..., :3, :3]
    A = R.mT @ w[..., :3, :3]
    moment = torch.stack([A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]], dim=-1)
    W = torch.cat([moment, _times(R.mT, w[..., :3, 3])], dim=-1)
    return (_by_coordinates(key, q, _generalized_loads(key, q, W)),)


def _poses_forward(key: Any, x: Any, C: Any, dq: Tensor) -> Tensor:
    x, y, z, *u = _twists(key, x[0], _along(key, x[0], dq)).unbind(-1)
    o = torch.zeros_like(z)
    rows = [o, -z, y, u[0], z, o, -x, u[1], -y, x, o, u[2], o, o, o, o]
    return C[0] @ torch.stack(rows, dim=-1).unflatten(-1, (4, 4))


_poses = _operation(
    "poses(str model, Tensor q) -> Tensor",
    lambda key, q: _evaluated(key, "poses", q)[0], lambda key, q: _empty(q, _frames(key), 4, 4),
    _poses_backward, _poses_forward)


# Inertial parameters, in which inverse dynamics is linear: tau = Y(q, v, a) pi + what does not depend on them

def _components(x: Tensor) -> list[Tensor]:
    """Along the last axis, each in one piece of memory."""
    return list(x.movedim(-1, 0).contiguous().unbind(0))


def _product(x: list[Tensor], y: list[Tensor]) -> list[Tensor]:
    """The vector product, by components."""
    return [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]


def _body_motion(key: str, q: Tensor, v: Tensor, a: Tensor) -> tuple[list[Tensor], list[Tensor], list[Tensor]]:
    """Of each moving body, in its axes: angular velocity, its rate, and r'' - g of the origin of its frame; by components."""
    m = _mechanism(key).model
    bodies = slice(1, m.n_bodies + 1)  # in front of them stands the ground
    (V,), (dV,), (C,) = (_evaluated(key, "twists", q, v), _evaluated(key, "accelerations", q, v, a), _evaluated(key, "poses", q))
    motion, rate = _components(V[..., bodies, :]), _components(dV[..., bodies, :])
    R = _components(C[..., bodies, :3, :3].flatten(-2))
    r = [x + y - sum(float(g) * R[3 * j + k] for j, g in enumerate(m.gravity))
         for k, (x, y) in enumerate(zip(rate[3:], _product(motion[:3], motion[3:])))]
    return motion[:3], rate[:3], r


def _parameters_vjp_of(key: str, q: Tensor, v: Tensor, a: Tensor, w: Tensor) -> Tensor:
    """w . Y: the power of what each parameter asks for (eq. NEb) in the motion with the velocities w."""
    omega, alpha, r = _body_motion(key, q, v, a)
    W, = _evaluated(key, "twists", q, w)
    motion = _components(W[..., 1:_mechanism(key).model.n_bodies + 1, :])
    mu, nu = motion[:3], motion[3:]

    def dot(x: list[Tensor], y: list[Tensor]) -> Tensor:
        return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]

    def moment(i: int, j: int) -> Tensor:
        return mu[i] * alpha[j] + turned[i] * omega[j]

    along, square, turned = dot(omega, nu), dot(omega, omega), _product(mu, omega)
    by_h = [x + y + omega[k] * along - nu[k] * square
            for k, (x, y) in enumerate(zip(_product(r, mu), _product(nu, alpha)))]
    products = [moment(i, j) + moment(j, i) for i, j in ((0, 1), (0, 2), (1, 2))]
    by = [dot(nu, r), *by_h, moment(0, 0), moment(1, 1), moment(2, 2), *products]
    return torch.stack(by, dim=-1).flatten(-2)


def _parameters_jvp_of(key: str, q: Tensor, v: Tensor, a: Tensor, dpi: Tensor) -> Tensor:
    """Y dpi: the wrenches that bodies with these parameters need, as forces of the joints."""
    omega, alpha, r = (torch.stack(x, dim=-1) for x in _body_motion(key, q, v, a))
    m, h, Theta = dpi.unflatten(-1, (-1, 10)).split([1, 3, 6], dim=-1)
    Theta = Theta[..., [0, 3, 4, 3, 1, 5, 4, 5, 2]].unflatten(-1, (3, 3))
    moment = _times(Theta, alpha) + _cross(omega, _times(Theta, omega)) + _cross(h, r)
    force = m * r + _cross(alpha, h) + _cross(omega, _cross(omega, h))
    none = moment.new_zeros((*moment.shape[:-2], 1, 6))
    return _loads_of(key, q, torch.cat([none, torch.cat([moment, force], dim=-1)], dim=-2))


def _of_each_parameter(key: str, name: str, q: Tensor, *others: Tensor) -> Iterator[tuple[Array, ...]]:
    """A function that is linear in the parameters, of 1 for one of them and 0 for all others, for each in turn."""
    arrays = [_mechanism(key).configurations(q), *map(_array, others)]
    like, *each = (mechanism(name, *arrays) for mechanism in _mechanism(key).solids)
    for found in each:
        yield tuple(x - y for x, y in zip(found, like))


def _parameters_gradient_of(key: str, q: Tensor, v: Tensor, a: Tensor, w: Tensor, dpi: Tensor) -> tuple[Tensor, ...]:
    """Of w . Y dpi, along q and by v and a."""
    each = zip(_components(dpi), _of_each_parameter(key, "inverse_dynamics_vjp", q, v, a, w))
    by = [tuple(c[..., None] * _tensor(x, q) for x in found) for c, found in each]
    return tuple(torch.stack(parts).sum(dim=0) for parts in zip(*by))


def _parameters_along_of(key: str, q: Tensor, v: Tensor, a: Tensor, w: Tensor, dq: Tensor, dv: Tensor, da: Tensor) -> Tensor:
    """What a direction does to w . Y."""
    each = _of_each_parameter(key, "inverse_dynamics_jvp", q, v, a, dq, dv, da)
    return torch.stack([(w * _tensor(change, q)).sum(dim=-1) for change, in each], dim=-1)


def _parameters_by_state(ctx: Any, key: str, q: Tensor, v: Tensor, a: Tensor, w: Tensor,
                         dpi: Tensor) -> tuple[Tensor | None, ...]:
    if not any(ctx.needed[:3]):
        return None, None, None
    by_q, by_v, by_a = _parameters_gradient(key, q, v, a, w, dpi)
    return _by_coordinates(key, q, by_q), by_v, by_a


def _parameters_vjp_backward(ctx: Any, key: Any, x: Any, result: Any, c: Tensor) -> tuple[Tensor | None, ...]:
    q, v, a, w = x
    return *_parameters_by_state(ctx, key, q, v, a, w, c), _parameters_jvp(key, q, v, a, c) if ctx.needed[3] else None


def _parameters_vjp_forward(key: Any, x: Any, result: Any, dq: Tensor, dv: Tensor, da: Tensor, dw: Tensor) -> Tensor:
    return _parameters_along(key, *x, _along(key, x[0], dq), dv, da) + _parameters_vjp(key, *x[:3], dw)


def _parameters_jvp_backward(ctx: Any, key: Any, x: Any, result: Any, c: Tensor) -> tuple[Tensor | None, ...]:
    q, v, a, dpi = x
    return *_parameters_by_state(ctx, key, q, v, a, c, dpi), _parameters_vjp(key, q, v, a, c) if ctx.needed[3] else None


_parameters_gradient = _operation(
    "inverse_dynamics_parameters_gradient(str model, Tensor q, Tensor v, Tensor a, Tensor w, Tensor dpi)"
    " -> (Tensor, Tensor, Tensor)", _parameters_gradient_of, _three_of_v)
_parameters_along = _operation(
    "inverse_dynamics_parameters_along(str model, Tensor q, Tensor v, Tensor a, Tensor w, Tensor dq, Tensor dv, Tensor da)"
    " -> Tensor", _parameters_along_of, lambda key, q, *others: _empty(q, _sizes(key)[2]))
_parameters_vjp: Callable[..., Any] = _operation(
    "inverse_dynamics_parameters_vjp(str model, Tensor q, Tensor v, Tensor a, Tensor w) -> Tensor",
    _parameters_vjp_of, lambda key, q, v, a, w: _empty(q, _sizes(key)[2]), _parameters_vjp_backward, _parameters_vjp_forward)
_parameters_jvp: Callable[..., Any] = _operation(
    "inverse_dynamics_parameters_jvp(str model, Tensor q, Tensor v, Tensor a, Tensor dpi) -> Tensor",
    _parameters_jvp_of, _one_of_v, _parameters_jvp_backward)


# Inverse and forward dynamics, f(q, v, x) with x the accelerations or the forces

class _Dynamics:
    """The operations of one of both: its value, products of its derivatives, and second derivatives."""

    def __init__(self, name: Literal["inverse_dynamics", "forward_dynamics"], x: str):
        self.name = name
        arguments = f"(str model, Tensor q, Tensor v, Tensor {x}, Tensor? parameters"
        self.hessian = _operation(
            f"{name}_hessian{arguments}, Tensor w, Tensor dq, Tensor dv, Tensor d{x}) -> (Tensor, Tensor, Tensor)"
            .replace("str model", "str model, bool gradient"), self._hessian,
            lambda key, gradient, *x: _three_of_v(key, *x))
        self.jvp = _operation(
            f"{name}_jvp{arguments}, Tensor dq, Tensor dv, Tensor d{x}) -> Tensor",
            lambda key, *x: self._product(key, "_jvp", *x)[0], _one_of_v, self._jvp_backward)
        self.vjp = _operation(
            f"{name}_vjp{arguments}, Tensor w) -> (Tensor, Tensor, Tensor)",
            lambda key, *x: self._product(key, "_vjp", *x), _three_of_v, self._vjp_backward,
            self._vjp_forward)
        self.value = _operation(
            f"{name}{arguments}) -> Tensor",
            lambda key, q, v, x, parameters: _evaluated(key, name, q, v, x, parameters=parameters)[0],
            _one_of_v, self._backward, self._forward)

    def _product(self, key: str, kind: str, q: Tensor, v: Tensor, x: Tensor, parameters: Tensor | None,
                 *w: Tensor) -> tuple[Tensor, ...]:
        if _mechanism(key).model.n_loops == 0 or self.name == "inverse_dynamics":
            return _evaluated(key, self.name + kind, q, v, x, *w, parameters=parameters)
        by = _evaluated(key, self.name + "_derivatives", q, v, x, parameters=parameters)
        if kind == "_vjp":
            return tuple(_times(d.mT, *w) for d in by)
        return (sum(_times(d, dw) for d, dw in zip(by, w)),)

    def _hessian(self, key: str, gradient: bool, q: Tensor, v: Tensor, x: Tensor, parameters: Tensor | None, w: Tensor, dq: Tensor,
                 dv: Tensor, dx: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """The gradient of the derivative of w . f along (dq, dv, dx), or the derivative of its gradient.

        f is linear in x, where v does not matter. On joints with several velocities qq is not symmetric.
        """
        qq, qv, vv, xq = _evaluated(key, self.name + "_hessian", q, v, x, w, parameters=parameters)
        return _times(qq if gradient else qq.mT, dq) + _times(qv, dv) + _times(xq.mT, dx), _times(qv.mT, dq) + _times(vv, dv), _times(xq, dq)

    def _second(self, key: Any, x: Any, w: Tensor, directions: Any) -> tuple[Tensor, ...]:
        q, v, last, parameters = x[:4]
        by_q, by_v, by_x = self.hessian(key, True, q, v, last, parameters, w, *directions)
        return _by_coordinates(key, q, by_q), by_v, by_x

    def _by_parameters(self, key: str, x: Any, w: Tensor, directions: Any) -> Tensor:
        """The gradient of w . f' by the parameters, f' being what the directions do to f.

        With the accelerations a, their change a' and l = M^-1 w, parameters dpi change w . a' by -l . (Y dpi)' where a is
        held, and by l . M' M^-1 Y dpi through a.
        """
        q, v, last, parameters = x
        if self.name == "inverse_dynamics":
            return _parameters_along(key, q, v, last, w, *directions)
        still, none = self._still(key), torch.zeros_like(v)
        a, l = self.value(key, *x), self.vjp(key, *x, w)[2]
        turned = _inverse_dynamics.jvp(still, q, none, l, parameters, directions[0], none, none)
        return (_parameters_vjp(key, q, v, a, self.jvp(key, *x, none, none, turned))
                - _parameters_along(key, q, v, a, l, *directions[:2], self.jvp(key, *x, *directions)))

    def _gradient_along_parameters(self, key: str, x: Any, w: Tensor, dpi: Tensor) -> tuple[Tensor, ...]:
        """What parameters dpi more do to the gradient of w . f; of accelerations it is -(l T_q, l T_v, -l) with T(q, v, a) = tau."""
        q, v, last, parameters = x
        if self.name == "inverse_dynamics":
            return tuple(_parameters_gradient(key, q, v, last, w, dpi))
        still, none = self._still(key), torch.zeros_like(v)
        a, l = self.value(key, *x), self.vjp(key, *x, w)[2]
        da, dl = (self.jvp(key, *x, none, none, -_parameters_jvp(*state, dpi)) for state in ((key, q, v, a), (still, q, none, l)))
        held, by_l = _parameters_gradient(key, q, v, a, l, dpi), _inverse_dynamics.vjp(key, q, v, a, parameters, dl)
        through_a = _inverse_dynamics.vjp(still, q, none, da, parameters, l)
        return -(held[0] + by_l[0] + through_a[0]), -(held[1] + by_l[1]), dl

    def _still(self, key: str) -> str:
        if _mechanism(key).model.n_loops > 0:
            raise NotImplementedError(NO_SECOND)
        return _mechanism(key).still.key

    def _vjp_backward(self, ctx: Any, key: Any, x: Any, result: Any, *directions: Tensor) -> tuple[Tensor | None, ...]:
        second = self._second(key, x, x[4], directions) if any(ctx.needed[:3]) else (None, None, None)
        return (*second, self._by_parameters(key, x[:4], x[4], directions) if ctx.needed[3] else None,
                self.jvp(key, *x[:4], *directions) if ctx.needed[4] else None)

    def _vjp_forward(self, key: Any, x: Any, result: Any, dq: Any, dv: Any, dx: Any, dpi: Any, dw: Any) -> tuple[Tensor, ...]:
        changes = [self.hessian(key, False, *x, _along(key, x[0], dq), dv, dx), self.vjp(key, *x[:4], dw)]
        if dpi is not None:
            changes.append(self._gradient_along_parameters(key, x[:4], x[4], dpi))
        return tuple(sum(parts) for parts in zip(*changes))

    def _jvp_backward(self, ctx: Any, key: Any, x: Any, result: Any, w: Tensor) -> tuple[Tensor | None, ...]:
        second = self._second(key, x, w, x[4:]) if any(ctx.needed[:3]) else (None, None, None)
        by_parameters = self._by_parameters(key, x[:4], w, x[4:]) if ctx.needed[3] else None
        return *second, by_parameters, *(self.vjp(key, *x[:4], w) if any(ctx.needed[4:]) else (None, None, None))

    def _backward(self, ctx: Any, key: Any, x: Any, result: Any, w: Tensor) -> tuple[Tensor | None, ...]:
        q, v, last, parameters = x
        by_q: Any = None
        by_v, by_x, by_parameters = by_q, by_q, by_q
        if any(ctx.needed[:3]) or self.name == "forward_dynamics":
            by_q, by_v, by_x = self.vjp(key, *x, w)
        if ctx.needed[3]:  # forces Y dpi more act on accelerations as the same forces less
            by_parameters = _parameters_vjp(key, q, v, last, w) if self.name == "inverse_dynamics" else \
                _parameters_vjp(key, q, v, result[0], -by_x)
        return _by_coordinates(key, q, by_q) if ctx.needed[0] else None, by_v, by_x, by_parameters

    def _forward(self, key: Any, x: Any, result: Any, dq: Any, dv: Any, dx: Any, dpi: Any) -> Tensor:
        q, v, last, parameters = x
        dq = _along(key, q, dq)
        if self.name == "forward_dynamics":
            dx = dx if dpi is None else dx - _parameters_jvp(key, q, v, result[0], dpi)
            return self.jvp(key, *x, dq, dv, dx)
        change = self.jvp(key, *x, dq, dv, dx)
        return change if dpi is None else change + _parameters_jvp(key, q, v, last, dpi)


_inverse_dynamics = _Dynamics("inverse_dynamics", "a")
_forward_dynamics = _Dynamics("forward_dynamics", "tau")


# Mass matrices and energies, made of inverse dynamics

def _n_times(x: Tensor, n: int) -> Tensor:
    return x[..., None, :].expand(*x.shape[:-1], n, x.shape[-1])


def _unit_accelerations(key: str, x: Any, like: Tensor) -> tuple[str, tuple[Tensor, ...], Tensor | None]:
    """At rest without gravity, where the forces that the acceleration e_j needs are column j of M: model, states, parameters."""
    (q, parameters), n = x, like.shape[-1]
    states = _n_times(q, n), torch.zeros_like(like), torch.eye(n, dtype=q.dtype).expand_as(like)
    return _mechanism(key).still.key, states, None if parameters is None else _n_times(parameters, n)


def _mass_matrix_gradient(key: str, x: Any, w: Tensor, needed: tuple[bool, ...]) -> tuple[Tensor | None, ...]:
    """Of w . M."""
    still, states, pi = _unit_accelerations(key, x, w)
    by_q = _inverse_dynamics.vjp(still, *states, pi, w.mT)[0].sum(dim=-2) if needed[0] else None
    return (None if by_q is None else _by_coordinates(key, x[0], by_q),
            _parameters_vjp(still, *states, w.mT).sum(dim=-2) if needed[1] else None)


def _mass_matrix_forward(key: Any, x: Any, M: Any, dq: Any, dpi: Any) -> Tensor:
    still, states, pi = _unit_accelerations(key, x, M[0])
    none = torch.zeros_like(M[0])
    rows = _inverse_dynamics.jvp(still, *states, pi, _n_times(_along(key, x[0], dq), M[0].shape[-1]), none, none)
    return rows if dpi is None else rows + _parameters_jvp(still, *states, _n_times(dpi, M[0].shape[-1]))


def _of_matrix(name: str) -> Callable[..., Tensor]:
    return lambda key, q, parameters: _evaluated(key, name, q, parameters=parameters)[0]


def _square(key: str, q: Tensor, parameters: Tensor | None) -> Tensor:
    return _empty(q, _sizes(key)[1], _sizes(key)[1])


_mass_matrix = _operation(
    "mass_matrix(str model, Tensor q, Tensor? parameters) -> Tensor", _of_matrix("mass_matrix"), _square,
    lambda ctx, key, x, M, w: _mass_matrix_gradient(key, x, w, ctx.needed), _mass_matrix_forward)
_inverse_mass_matrix = _operation(  # dW = -W dM W
    "inverse_mass_matrix(str model, Tensor q, Tensor? parameters) -> Tensor", _of_matrix("inverse_mass_matrix"), _square,
    lambda ctx, key, x, W, w: _mass_matrix_gradient(key, x, -(W[0] @ w @ W[0]), ctx.needed),
    lambda key, x, W, *directions: -(W[0] @ _mass_matrix_forward(key, x, W, *directions) @ W[0]))


def _kinetic_energy_gradient(key: str, x: Any) -> tuple[Tensor, Tensor]:
    """Of v . M v / 2, along q and by v."""
    q, v, parameters = x
    by_q, _, p = _inverse_dynamics.vjp(_mechanism(key).still.key, q, torch.zeros_like(v), v, parameters, v)
    return by_q / 2, p


def _kinetic_energy_backward(ctx: Any, key: Any, x: Any, T: Any, w: Tensor) -> tuple[Tensor | None, ...]:
    q, v, _ = x
    by_q, p = _kinetic_energy_gradient(key, x) if any(ctx.needed[:2]) else (None, None)
    w = w[..., None]
    return (w * _by_coordinates(key, q, by_q) if ctx.needed[0] else None, w * p if ctx.needed[1] else None,
            w / 2 * _parameters_vjp(_mechanism(key).still.key, q, torch.zeros_like(v), v, v) if ctx.needed[2] else None)


def _kinetic_energy_forward(key: Any, x: Any, T: Any, dq: Tensor, dv: Tensor, dpi: Any) -> Tensor:
    q, v, _ = x
    by_q, p = _kinetic_energy_gradient(key, x)
    change = (by_q * _along(key, q, dq) + p * dv).sum(dim=-1)
    if dpi is None:
        return change
    return change + (v * _parameters_jvp(_mechanism(key).still.key, q, torch.zeros_like(v), v, dpi)).sum(dim=-1) / 2


def _potential_energy_forward(key: Any, x: Any, U: Any, dq: Tensor, dpi: Any) -> Tensor:
    change = (_gravity_torques(key, *x) * _along(key, x[0], dq)).sum(dim=-1)
    return change if dpi is None else change + (_potential_energy_regressor(key, x[0]) * dpi).sum(dim=-1)


def _potential_energy_regressor(key: str, q: Tensor) -> Tensor:
    """y with U = y pi, from the poses of the bodies: -g . r for a mass, -R^T g for a first moment."""
    m = _mechanism(key).model
    C, g = _poses(key, q)[..., 1:m.n_bodies + 1, :, :], torch.tensor(m.gravity, dtype=q.dtype)
    by_m, by_h = -_times(C[..., None, :3, 3], g), -_times(C[..., :3, :3].mT, g)
    return torch.cat([by_m, by_h, by_h.new_zeros((*by_h.shape[:-1], 6))], dim=-1).flatten(-2)


def _gravity_torques(key: str, q: Tensor, parameters: Tensor | None) -> Tensor:
    at_rest = _empty(q, _sizes(key)[1]).zero_()
    return _inverse_dynamics.value(_mechanism(key).tree.key, q, at_rest, at_rest, parameters)


_kinetic_energy = _operation(
    "kinetic_energy(str model, Tensor q, Tensor v, Tensor? parameters) -> Tensor",
    lambda key, q, v, parameters: _evaluated(key, "kinetic_energy", q, v, parameters=parameters)[0],
    lambda key, q, *_: _empty(q), _kinetic_energy_backward, _kinetic_energy_forward)
_potential_energy = _operation(
    "potential_energy(str model, Tensor q, Tensor? parameters) -> Tensor",
    lambda key, q, parameters: _evaluated(key, "potential_energy", q, parameters=parameters)[0],
    lambda key, q, *_: _empty(q),
    lambda ctx, key, x, U, w: (
        w[..., None] * _by_coordinates(key, x[0], _gravity_torques(key, *x)) if ctx.needed[0] else None,
        w[..., None] * _potential_energy_regressor(key, x[0]) if ctx.needed[1] else None),
    _potential_energy_forward)


# Jacobians, of any order

def _jacobian_of(key: str, frame: int, representation: str, order: int, q: Tensor) -> Tensor:
    mechanism = _mechanism(key)
    name, more = ("jacobian_partials", (order,)) if order > 0 else ("jacobian", ())
    return _tensor(mechanism(name, mechanism.configurations(q), frame, representation, *more)[0], q)


def _jacobian_backward(ctx: Any, constants: Any, x: Any, J: Any, w: Tensor) -> tuple[Tensor]:
    key, frame, representation, order = constants
    partials = _jacobian_partials(key, frame, representation, order + 1, *x)  # the outermost derivative first
    along = partials.flatten(-(order + 2)) @ w.flatten(-(order + 2))[..., None]
    return (_by_coordinates(key, x[0], along[..., 0]),)


def _jacobian_forward(constants: Any, x: Any, J: Any, dq: Tensor) -> Tensor:
    key, frame, representation, order = constants
    partials = _jacobian_partials(key, frame, representation, order + 1, *x)
    along = _along(key, x[0], dq)[..., None, :] @ partials.flatten(-(order + 2))
    return along.reshape(J[0].shape)


_jacobian_partials = _operation(
    "jacobian_partials(str model, int frame, str representation, int order, Tensor q) -> Tensor", _jacobian_of,
    lambda key, frame, representation, order, q: _empty(q, *order * (_sizes(key)[1],), 6, _sizes(key)[1]),
    _jacobian_backward, _jacobian_forward)


# Motions in steps

def _rollout_arrays(key: str, *tensors: Tensor) -> tuple[_Mechanism, list[Array]]:
    q, v, *rows = tensors
    return _mechanism(key), [_mechanism(key).configurations(q), _array(v), *(_array(x, 2) for x in rows)]


def _rollout_of(key: str, step: float, q: Tensor, v: Tensor, tau: Tensor) -> tuple[Tensor, Tensor]:
    mechanism, arrays = _rollout_arrays(key, q, v, tau)
    states, velocities = mechanism("rollout_under", *arrays, step)
    return _tensor(states, q), _tensor(velocities, q)


def _rollout_vjp_of(key: str, step: float, q: Tensor, v: Tensor, tau: Tensor, w_q: Tensor,
                    w_v: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    mechanism, (*motion, of_q, of_v) = _rollout_arrays(key, q, v, tau, w_q, w_v)
    by_q, by_v, by_tau, _ = mechanism("rollout_vjp", *motion, step, of_q, of_v)
    return _tensor(by_q, q), _tensor(by_v, q), _tensor(by_tau, q)


def _rollout_jvp_of(key: str, step: float, q: Tensor, v: Tensor, tau: Tensor, dq: Tensor, dv: Tensor,
                    dtau: Tensor) -> tuple[Tensor, Tensor]:
    mechanism, motion = _rollout_arrays(key, q, v, tau)
    of_q, of_v = mechanism("rollout_jvp", *motion, step, _array(dq), _array(dv), _array(dtau, 2))
    return _tensor(of_q, q), _tensor(of_v, q)


def _rollout_backward(ctx: Any, constants: Any, x: Any, motion: Any, w_q: Tensor, w_v: Tensor) -> tuple[Tensor, ...]:
    key = constants[0]
    along = _rates(key, _along(key, motion[0], w_q))  # E^T w_q
    by_q, by_v, by_tau = _rollout_vjp(*constants, *x, along, w_v)
    return _by_coordinates(key, x[0], by_q), by_v, by_tau


def _rollout_forward(constants: Any, x: Any, motion: Any, dq: Any, dv: Any, dtau: Any) -> tuple[Tensor, Tensor]:
    key, q = constants[0], x[0]
    of_q, of_v = _rollout_jvp(*constants, *x, _along(key, q, dq), dv, dtau)
    return _by_coordinates(key, motion[0], _rates(key, of_q)), of_v


def _states_of(q: Tensor, n: int, tau: Tensor) -> Tensor:
    return _empty(q, tau.shape[-2] + 1, n)


_rollout_vjp = _operation(
    "rollout_vjp(str model, float step, Tensor q, Tensor v, Tensor tau, Tensor w_q, Tensor w_v) -> (Tensor, Tensor, Tensor)",
    _rollout_vjp_of, lambda key, step, q, v, tau, *_: (_empty(v, v.shape[-1]), _empty(v, v.shape[-1]),
                                                       tau.new_empty(tau.shape)))
_rollout_jvp = _operation(
    "rollout_jvp(str model, float step, Tensor q, Tensor v, Tensor tau, Tensor dq, Tensor dv, Tensor dtau)"
    " -> (Tensor, Tensor)",
    _rollout_jvp_of, lambda key, step, q, v, tau, *_: (_states_of(q, v.shape[-1], tau), _states_of(q, v.shape[-1], tau)))
_rollout = _operation(
    "rollout(str model, float step, Tensor q, Tensor v, Tensor tau) -> (Tensor, Tensor)",
    _rollout_of, lambda key, step, q, v, tau: (_states_of(q, q.shape[-1], tau), _states_of(q, v.shape[-1], tau)),
    _rollout_backward, _rollout_forward)


# What users call

def _checked(m: Model | Specialised, parameters: Tensor | None, **given: Tensor) -> tuple[str, list[Tensor], Tensor | None]:
    """The model's word, and the tensors with the same axes in front."""
    key = handle(m)
    nq, nv, n = _sizes(key)
    if parameters is not None:
        given["parameters"] = parameters
    for name, x in given.items():
        size, meaning = (nq, "nq numbers") if name == "q" else (nv, "nv numbers") if name != "parameters" else \
            (n, "ten numbers for each body")
        if not isinstance(x, Tensor):
            raise ValueError(f"{name}: expected a tensor, got {type(x).__name__}")
        if x.device.type != "cpu":
            raise ValueError(f"{name} is on the device {x.device}; axode computes on the CPU, where {name}.cpu() takes it")
        if x.layout != torch.strided:
            raise ValueError(f"{name}: expected a dense tensor, got {x.layout}")
        if x.dtype != torch.float64 and x.dtype != torch.float32:
            raise ValueError(f"{name}: expected a tensor of float64 or float32, got {x.dtype}")
        if x.dtype != given["q"].dtype:
            raise ValueError(f"{name} is of {x.dtype} and q of {given['q'].dtype}; expected one type for all")
        if x.ndim == 0 or x.shape[-1] != size:
            raise ValueError(f"{name}: expected shape (..., {size}), {meaning}, got {tuple(x.shape)}")
    same = _broadcast(given)
    return key, same if parameters is None else same[:-1], None if parameters is None else same[-1]


def _broadcast(given: dict[str, Tensor]) -> list[Tensor]:
    lead = given["q"].shape[:-1]
    if not all(x.shape[:-1] == lead for x in given.values()):
        try:
            lead = torch.broadcast_shapes(*(x.shape[:-1] for x in given.values()))
        except RuntimeError:
            shapes = ", ".join(f"{name} {tuple(x.shape)}" for name, x in given.items())
            raise ValueError(f"the axes in front of the last do not broadcast: {shapes}") from None
    return [x if x.shape[:-1] == lead else x.expand(*lead, x.shape[-1]) for x in given.values()]


def inverse_dynamics(m: Model | Specialised, q: Tensor, v: Tensor, a: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """tau = M(q) a + C(q, v) v + g(q), (..., nv), as `axode.inverse_dynamics`.

    parameters, (..., 10 n_bodies), are inertial parameters in the place of `m.parameters`, one set for all states or one
    for each. Derivatives up to the second; those by parameters and the state take 10 n_bodies + 1 products each. O(n), backwards
    too. ValueError for wrong shapes, types and devices, and models with loops; ModelError for masses below 0.

    >>> q, v, a = torch.full((3, 1000, 7), 0.5, dtype=torch.float64)
    >>> pi = torch.tensor(arm.parameters, requires_grad=True)
    >>> tau = axode.torch.inverse_dynamics(arm, q, v, a, parameters=pi)
    >>> tau.square().mean().backward()
    >>> tau.shape, pi.grad.shape
    (torch.Size([1000, 7]), torch.Size([70]))
    """
    key, states, pi = _checked(m, parameters, q=q, v=v, a=a)
    _refuse_loops(key, "inverse_dynamics")
    return _inverse_dynamics.value(key, *states, pi)


def forward_dynamics(m: Model | Specialised, q: Tensor, v: Tensor, tau: Tensor, *,
                     parameters: Tensor | None = None) -> Tensor:
    """The accelerations (..., nv) that drive forces make, as `axode.forward_dynamics`; with loops, first derivatives alone.

    parameters and derivatives as in `inverse_dynamics`. O(n), backwards too. SingularError where the mass matrix is singular.

    >>> q, v, tau = torch.zeros(3, 7, dtype=torch.float64)
    >>> axode.torch.forward_dynamics(arm, q, v, tau).shape
    torch.Size([7])
    """
    key, states, pi = _checked(m, parameters, q=q, v=v, tau=tau)
    return _forward_dynamics.value(key, *states, pi)


def mass_matrix(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """M(q), (..., nv, nv), as `axode.mass_matrix`. Derivatives as in `inverse_dynamics`, O(n nv) backwards.

    >>> q = torch.zeros(5, 7, dtype=torch.float64, requires_grad=True)
    >>> axode.torch.mass_matrix(arm, q).shape
    torch.Size([5, 7, 7])
    """
    key, states, pi = _checked(m, parameters, q=q)
    return _mass_matrix(key, *states, pi)


def inverse_mass_matrix(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """The inverse of M(q), (..., nv, nv), as `axode.inverse_mass_matrix`. Derivatives as in `mass_matrix`.

    >>> q = torch.zeros(7, dtype=torch.float64)
    >>> W = axode.torch.inverse_mass_matrix(arm, q)
    >>> torch.allclose(W @ axode.torch.mass_matrix(arm, q), torch.eye(7, dtype=torch.float64))
    True
    """
    key, states, pi = _checked(m, parameters, q=q)
    return _inverse_mass_matrix(key, *states, pi)


def kinetic_energy(m: Model | Specialised, q: Tensor, v: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """T = v^T M v / 2, J, of shape (...), as `axode.kinetic_energy`. Derivatives as in `inverse_dynamics`. O(n).

    >>> q, v = torch.ones(2, 7, dtype=torch.float64)
    >>> (p,) = torch.autograd.grad(axode.torch.kinetic_energy(arm, q, v.requires_grad_()), v)
    >>> np.allclose(p, axode.momenta(arm, q, v.detach()))
    True
    """
    key, states, pi = _checked(m, parameters, q=q, v=v)
    return _kinetic_energy(key, *states, pi)


def potential_energy(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """U, J, of shape (...), as `axode.potential_energy`; its gradient are `axode.gravity_torques`. O(n).

    Derivatives up to the third by q, the second by parameters.

    >>> q = torch.ones(7, dtype=torch.float64, requires_grad=True)
    >>> (g,) = torch.autograd.grad(axode.torch.potential_energy(arm, q), q)
    >>> np.allclose(g, axode.gravity_torques(arm, q.detach()))
    True
    """
    key, states, pi = _checked(m, parameters, q=q)
    return _potential_energy(key, *states, pi)


def center_of_mass(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """Where it is, (..., 3), m, as `axode.center_of_mass`. Derivatives as in `potential_energy`. O(n).

    >>> axode.torch.center_of_mass(arm, torch.zeros(7, dtype=torch.float64)).numpy()[1:].round(3)
    array([-0.003,  0.619])
    """
    key, (q,), pi = _checked(m, parameters, q=q)
    moments = torch.stack([_potential_energy(height, q, pi) for height in _heights(key)], dim=-1)
    return moments / (_total_mass(key) if pi is None else pi[..., ::10].sum(dim=-1, keepdim=True))


def poses(m: Model | Specialised, q: Tensor) -> Tensor:
    """C_i of every frame, (..., n_frames, 4, 4), as `axode.poses`. Derivatives up to the second. O(n).

    >>> q = torch.zeros(7, dtype=torch.float64, requires_grad=True)
    >>> axode.torch.poses(arm, q)[arm.frame_index("flange"), 0, 3].backward()  # how far forward the flange is
    >>> q.grad.numpy()[[1, 3, 5]].round(3)
    array([ 0.946, -0.526,  0.126])
    """
    key, states, _ = _checked(m, None, q=q)
    return _poses(key, *states)


def jacobian(m: Model | Specialised, q: Tensor, frame: str | int, representation: Representation = "body") -> Tensor:
    """J of a frame, (..., 6, nv), with V = J v, as `axode.jacobian`. Derivatives of any order up to 12. O(n^2) backwards.

    >>> q, v = torch.ones(2, 7, dtype=torch.float64)
    >>> V = axode.torch.jacobian(arm, q, "flange", "hybrid") @ v
    >>> np.allclose(V, axode.twists(arm, q, v, "hybrid")[arm.frame_index("flange")])
    True
    """
    key, states, _ = _checked(m, None, q=q)
    return _jacobian_partials(key, _frame(key, frame), representation, 0, *states)


def rollout(m: Model, q: Tensor, v: Tensor, tau: Tensor, step: float) -> tuple[Tensor, Tensor]:
    """(q, v) of motions of K steps, (..., K + 1, nq) and (..., K + 1, nv), under tau (..., K, nv), as `axode.rollout`.

    First derivatives by q, v and tau, O(n) for each step; only states are kept for them. With K = 1 it is a step. ValueError for
    models with loops, SingularError and NotFiniteError where motions cannot go on.

    >>> q, v = torch.zeros(2, 5, 7, dtype=torch.float64)
    >>> tau = torch.zeros(5, 20, 7, dtype=torch.float64, requires_grad=True)
    >>> path, _ = axode.torch.rollout(arm, q, v, tau, 1e-3)
    >>> path[:, -1].square().sum().backward()
    >>> path.shape, tau.grad.shape
    (torch.Size([5, 21, 7]), torch.Size([5, 20, 7]))
    """
    if not isinstance(tau, Tensor) or tau.ndim < 2:
        got = tuple(tau.shape) if isinstance(tau, Tensor) else type(tau).__name__
        raise ValueError(f"tau: expected a tensor of shape (..., K, nv), forces for each step, got {got}")
    if isinstance(step, Tensor) and step.requires_grad:
        raise ValueError("step needs a gradient; expected a number, rollout has no derivative by it")
    key, (q, v, _), _ = _checked(m, None, q=q, v=v, tau=tau[..., 0, :] if tau.shape[-2] > 0 else tau.sum(dim=-2))
    _refuse_loops(key, "rollout")
    states, velocities = _rollout(key, float(step), q, v, tau.expand(*q.shape[:-1], *tau.shape[-2:]))
    return states, velocities


def inertial_parameters(P: Tensor) -> Tensor:
    """The ten parameters (..., 10) of bodies with the pseudo-inertias P (..., 4, 4), the inverse of
    `axode.identification.pseudo_inertia`.

    There is matter with them where P is positive definite: with P = L L^T any lower triangular L with a positive diagonal
    gives parameters that a body can have. kg, kg m and kg m^2.

    >>> P = torch.tensor(axode.identification.pseudo_inertia(arm.parameters.reshape(-1, 10)))
    >>> np.allclose(axode.torch.inertial_parameters(P).flatten(), arm.parameters)
    True
    """
    if not isinstance(P, Tensor) or P.shape[-2:] != (4, 4):
        got = tuple(P.shape) if isinstance(P, Tensor) else type(P).__name__
        raise ValueError(f"P: expected a tensor of shape (..., 4, 4), a pseudo-inertia of each body, got {got}")
    S = torch.diagonal(P, dim1=-2, dim2=-1)[..., :3]
    products = -torch.stack([P[..., 0, 1], P[..., 0, 2], P[..., 1, 2]], dim=-1)
    return torch.cat([P[..., 3, 3:], P[..., 3, :3], S.sum(dim=-1, keepdim=True) - S, products], dim=-1)
