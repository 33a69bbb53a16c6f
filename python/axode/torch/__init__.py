"""Functions of the state as operations of PyTorch: axode.torch.inverse_dynamics(m, q, v, a), through which networks
can learn.

Names and arguments are those of axode, with tensors of float64 or float32; they may have any axes in front, which
broadcast. Gradients are exact: first derivatives use the products of the library, and second derivatives its second
derivatives. Every function consists of operations `torch.ops.axode`, which torch.compile, torch.func and torch.export
support. See docs/torch.md.

This needs PyTorch (pip install torch).
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from ..support import signatures
from .._axode import Model
from ..codegen import Specialised
from ..records import Representation

try:
    import torch  # type: ignore[import-not-found, unused-ignore]
    from torch import Tensor
except ImportError as error:
    raise ImportError('axode.torch needs PyTorch: pip install torch') from error

from . import contact, dynamics, operations
from ..support.contact_motions import PARAMETERS
from .mechanism import frame_index, heights, key_of, pairs_of, refuse_loops, sizes, still, total_mass

__all__ = ["center_of_mass", "contact_rollout", "forward_dynamics", "handle", "inertial_parameters", "inverse_dynamics",
           "inverse_mass_matrix", "jacobian", "kinetic_energy", "mass_matrix", "pair_distances", "poses", "potential_energy", "rollout"]


def _checked(m: Model | Specialised, parameters: Tensor | None,
             **given: Tensor) -> tuple[str, list[Tensor], Tensor | None]:
    """The key of the model, and the tensors with the same axes in front."""
    key = key_of(m)
    nq, nv, n = sizes(key)
    if parameters is not None:
        given["parameters"] = parameters
    for name, x in given.items():
        size, meaning = {"q": (nq, "nq numbers"), "parameters": (n, "ten numbers for each body")}.get(name, (nv, "nv numbers"))
        if not isinstance(x, Tensor):
            raise ValueError(f"{name}: expected a tensor, got {type(x).__name__}")
        if x.device.type != "cpu":
            raise ValueError(f"{name} is on the device {x.device}; axode computes on the CPU, where {name}.cpu() "
                             "takes it")
        if x.layout != torch.strided:
            raise ValueError(f"{name}: expected a dense tensor, got {x.layout}")
        if x.dtype != torch.float64 and x.dtype != torch.float32:
            raise ValueError(f"{name}: expected a tensor of float64 or float32, got {x.dtype}")
        if x.dtype != given["q"].dtype:
            raise ValueError(f"{name} is of {x.dtype} and q of {given['q'].dtype}; expected one type for all")
        if name in PARAMETERS[1:]:  # with_shapes checks their number
            size = x.shape[-1] if x.ndim > 0 else 0
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


def handle(m: Model | Specialised) -> str:
    """The key by which operations of `torch.ops.axode` refer to a model; equal models have the same key in every
    process.

    The functions of this module call `handle` themselves. Programs that were exported, or compiled in another
    process, find their models if `handle` has been called in this process. The last 256 models are kept, and those
    that a graph needs.

    >>> axode.torch.handle(arm) == axode.torch.handle(arm.with_gravity([0, 0, -1.62]))
    False
    >>> import pickle
    >>> axode.torch.handle(arm) == axode.torch.handle(pickle.loads(pickle.dumps(arm)))
    True
    """
    return key_of(m)


def inverse_dynamics(m: Model | Specialised, q: Tensor, v: Tensor, a: Tensor, *,
                     parameters: Tensor | None = None) -> Tensor:
    """The drive forces tau = M(q) a + C(q, v) v + g(q), (..., nv), see `axode.inverse_dynamics`.

    parameters, (..., 10 n_bodies), replace `m.parameters`, one set for all states or one for each. Derivatives exist
    up to the second order, by parameters of first order. O(n), also backwards. ValueError for wrong shapes, types and
    devices, and models with loops; ModelError for masses below 0.

    >>> q, v, a = torch.full((3, 1000, 7), 0.5, dtype=torch.float64)
    >>> pi = torch.tensor(arm.parameters, requires_grad=True)
    >>> tau = axode.torch.inverse_dynamics(arm, q, v, a, parameters=pi)
    >>> tau.square().mean().backward()
    >>> tau.shape, pi.grad.shape
    (torch.Size([1000, 7]), torch.Size([70]))
    """
    key, states, pi = _checked(m, parameters, q=q, v=v, a=a)
    refuse_loops(key, "inverse_dynamics")
    return dynamics.inverse_dynamics.value(key, *states, pi)


def forward_dynamics(m: Model | Specialised, q: Tensor, v: Tensor, tau: Tensor, *,
                     parameters: Tensor | None = None) -> Tensor:
    """The accelerations (..., nv) that drive forces produce, see `axode.forward_dynamics`; with loops, only first
    derivatives exist.

    parameters and derivatives are those of `inverse_dynamics`. O(n), also backwards. SingularError if the mass matrix
    is singular.

    >>> q, v, tau = torch.zeros(3, 7, dtype=torch.float64)
    >>> axode.torch.forward_dynamics(arm, q, v, tau).shape
    torch.Size([7])
    """
    key, states, pi = _checked(m, parameters, q=q, v=v, tau=tau)
    return dynamics.forward_dynamics.value(key, *states, pi)


def mass_matrix(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """The mass matrix M(q), (..., nv, nv), see `axode.mass_matrix`. Derivatives are those of `inverse_dynamics`; O(n
    nv) backwards.

    >>> q = torch.zeros(5, 7, dtype=torch.float64, requires_grad=True)
    >>> axode.torch.mass_matrix(arm, q).shape
    torch.Size([5, 7, 7])
    """
    key, states, pi = _checked(m, parameters, q=q)
    return dynamics.mass_matrix(key, *states, pi)


def inverse_mass_matrix(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """The inverse of M(q), (..., nv, nv), see `axode.inverse_mass_matrix`. Derivatives are those of `mass_matrix`.

    >>> q = torch.zeros(7, dtype=torch.float64)
    >>> W = axode.torch.inverse_mass_matrix(arm, q)
    >>> torch.allclose(W @ axode.torch.mass_matrix(arm, q), torch.eye(7, dtype=torch.float64))
    True
    """
    key, states, pi = _checked(m, parameters, q=q)
    return dynamics.inverse_mass_matrix(key, *states, pi)


def kinetic_energy(m: Model | Specialised, q: Tensor, v: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """The kinetic energy T = v^T M v / 2, J, of shape (...), see `axode.kinetic_energy`. Derivatives are those of
    `inverse_dynamics`. O(n).

    >>> q, v = torch.ones(2, 7, dtype=torch.float64)
    >>> (p,) = torch.autograd.grad(axode.torch.kinetic_energy(arm, q, v.requires_grad_()), v)
    >>> np.allclose(p, axode.momenta(arm, q, v.detach()))
    True
    """
    key, (q, v), pi = _checked(m, parameters, q=q, v=v)
    momenta = dynamics.inverse_dynamics.value(still(key), q, torch.zeros_like(v), v, pi)
    return (v * momenta).sum(dim=-1) / 2


def potential_energy(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """The potential energy U, J, of shape (...), see `axode.potential_energy`; its gradient is
    `axode.gravity_torques`. O(n).

    Derivatives exist up to the third order by q, and of first order by parameters.

    >>> q = torch.ones(7, dtype=torch.float64, requires_grad=True)
    >>> (g,) = torch.autograd.grad(axode.torch.potential_energy(arm, q), q)
    >>> np.allclose(g, axode.gravity_torques(arm, q.detach()))
    True
    """
    key, states, pi = _checked(m, parameters, q=q)
    return dynamics.potential_energy(key, *states, pi)


def center_of_mass(m: Model | Specialised, q: Tensor, *, parameters: Tensor | None = None) -> Tensor:
    """Centre of mass of all moving bodies, (..., 3), m, as `axode.center_of_mass`. Derivatives are those of
    `potential_energy`. O(n).

    >>> axode.torch.center_of_mass(arm, torch.zeros(7, dtype=torch.float64)).numpy()[1:].round(3)
    array([-0.003,  0.619])
    """
    key, (q,), pi = _checked(m, parameters, q=q)
    moments = torch.stack([dynamics.potential_energy(height, q, pi) for height in heights(key)], dim=-1)
    return moments / (total_mass(key) if pi is None else pi[..., ::10].sum(dim=-1, keepdim=True))


def poses(m: Model | Specialised, q: Tensor) -> Tensor:
    """The pose C_i of every frame, (..., n_frames, 4, 4), see `axode.poses`. Derivatives exist up to the second
    order. O(n).

    >>> q = torch.zeros(7, dtype=torch.float64, requires_grad=True)
    >>> axode.torch.poses(arm, q)[arm.frame_index("flange"), 0, 3].backward()  # how far forward the flange is
    >>> q.grad.numpy()[[1, 3, 5]].round(3)
    array([ 0.946, -0.526,  0.126])
    """
    key, states, _ = _checked(m, None, q=q)
    return operations.poses(key, *states)


def jacobian(m: Model | Specialised, q: Tensor, frame: str | int, representation: Representation = "body") -> Tensor:
    """The Jacobian J of a frame, (..., 6, nv), with V = J v, see `axode.jacobian`. Derivatives exist up to order 12.
    O(n^2) backwards.

    >>> q, v = torch.ones(2, 7, dtype=torch.float64)
    >>> V = axode.torch.jacobian(arm, q, "flange", "hybrid") @ v
    >>> np.allclose(V, axode.twists(arm, q, v, "hybrid")[arm.frame_index("flange")])
    True
    """
    key, states, _ = _checked(m, None, q=q)
    return operations.jacobian_partials(key, frame_index(key, frame), representation, 0, *states)


def pair_distances(m: Model | Specialised, q: Tensor, pairs: Sequence[tuple[str, str]] | None = None) -> Tensor:
    """The signed distances (..., P) of P pairs of collision shapes, m, see `axode.pair_distances`. First derivatives.

    `pairs` are names of shapes; None: all pairs that may touch, as `axode.shape_pairs` lists them.

    >>> robot = axode.load(axode.robots / "quadruped.toml")
    >>> feet = [pair for pair in axode.shape_pairs(robot) if pair[0] == "floor"]
    >>> q = torch.tensor(robot.neutral(), requires_grad=True)
    >>> axode.torch.pair_distances(robot, q, feet).sum().backward()
    >>> q.grad.shape == q.shape
    True
    """
    key, (q,), _ = _checked(m, None, q=q)
    return operations.pair_distances(key, pairs_of(key) if pairs is None else json.dumps([*map(list, pairs)]), q)


def rollout(m: Model, q: Tensor, v: Tensor, tau: Tensor, step: float) -> tuple[Tensor, Tensor]:
    """(q, v): the states of motions of K steps, (..., K + 1, nq) and (..., K + 1, nv), under tau (..., K, nv), see
    `axode.rollout` with contact=False.

    First derivatives by q, v and tau exist; they take O(n) for each step and store only the states. With K = 1 it
    computes one step. ValueError for models with loops, SingularError and NotFiniteError if a motion cannot continue.

    >>> q, v = torch.zeros(2, 5, 7, dtype=torch.float64)
    >>> tau = torch.zeros(5, 20, 7, dtype=torch.float64, requires_grad=True)
    >>> path, _ = axode.torch.rollout(arm, q, v, tau, 1e-3)
    >>> path[:, -1].square().sum().backward()
    >>> path.shape, tau.grad.shape
    (torch.Size([5, 21, 7]), torch.Size([5, 20, 7]))
    """
    one_step = _one_step(tau, step, "rollout")
    key, (q, v, _), _ = _checked(m, None, q=q, v=v, tau=one_step)
    refuse_loops(key, "rollout")
    states, velocities = dynamics.rollout(key, float(step), q, v, tau.expand(*q.shape[:-1], *tau.shape[-2:]))
    return states, velocities


def contact_rollout(m: Model, q: Tensor, v: Tensor, tau: Tensor, step: float, *, parameters: Tensor | None = None,
                    friction: Tensor | None = None, restitution: Tensor | None = None,
                    placement: Tensor | None = None) -> tuple[Tensor, Tensor]:
    """(q, v): the states (..., K + 1, nq) and (..., K + 1, nv) of motions with contact, with friction and damping of joints,
    under tau (..., K, nv), see `axode.rollout`.

    `parameters` (..., 10 n_bodies) replace `m.parameters`, and `friction` (..., n), `restitution` (..., n) and `placement`
    (..., 6 n) the properties of n collision shapes, see `axode.with_shapes`. First derivatives by all of them exist, see
    `axode.contact_rollout_derivatives`; ValueError for contacts without a closed form, and StatesError if a motion cannot continue.

    >>> box = {"kind": "box", "role": "collision", "size": [0.2, 0.2, 0.2]}
    >>> table = axode.Model.from_dict({"format": "axode drawing 1", "shape": [{"kind": "plane", "role": "collision"}],
    ...     "body": [{"name": "box", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [7e-3, 7e-3, 7e-3], "shape": [box]}]})
    >>> q, v = (torch.tensor(x, dtype=torch.float64) for x in ([0, 0, 0, 1, 0, 0, 0.1], [0, 0, 0, 1, 0, 0]))
    >>> mu = torch.full((2,), 0.2, dtype=torch.float64, requires_grad=True)
    >>> _, velocities = axode.torch.contact_rollout(table, q, v, torch.zeros(4, 6, dtype=torch.float64), 1e-2, friction=mu)
    >>> velocities[-1, 3].backward()
    >>> mu.grad  # -g t / 2
    tensor([-0.1962, -0.1962], dtype=torch.float64)
    """
    one_step = _one_step(tau, step, "contact_rollout")
    given = {name: x for name, x in zip(PARAMETERS[1:], (friction, restitution, placement)) if x is not None}
    key, (q, v, _, *theta), pi = _checked(m, parameters, q=q, v=v, tau=one_step, **given)
    named = dict(zip(given, theta)) if pi is None else {"parameters": pi, **dict(zip(given, theta))}
    layout = json.dumps([(name, x.shape[-1]) for name, x in named.items()])
    together = torch.cat([q.new_empty((*q.shape[:-1], 0)), *named.values()], dim=-1)
    states, velocities = contact.contact_rollout(key, float(step), layout, q, v, tau.expand(*q.shape[:-1], *tau.shape[-2:]),
                                                 together)
    return states, velocities


def _one_step(tau: Tensor, step: float, function: str) -> Tensor:
    """The forces of one step, for checks."""
    if not isinstance(tau, Tensor) or tau.ndim < 2:
        got = tuple(tau.shape) if isinstance(tau, Tensor) else type(tau).__name__
        raise ValueError(f"tau: expected a tensor of shape (..., K, nv), forces for each step, got {got}")
    if isinstance(step, Tensor) and step.requires_grad:
        raise ValueError(f"step requires a gradient; expected a number, because {function} has no derivative by step")
    return tau[..., 0, :] if tau.shape[-2] > 0 else tau.sum(dim=-2)


def inertial_parameters(P: Tensor) -> Tensor:
    """The ten parameters (..., 10) of bodies with the pseudo-inertias P (..., 4, 4), the inverse of
    `axode.identification.pseudo_inertia`.

    A mass distribution has these parameters if P is positive definite: with P = L L^T any lower triangular L with a
    positive diagonal gives parameters that a body can have. kg, kg m and kg m^2.

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


signatures.explain_calls(__name__)
