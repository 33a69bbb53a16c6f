"""Operations of PyTorch for dynamics: forces, accelerations, mass matrices, energies and motions in steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import torch  # type: ignore[import-not-found, unused-ignore]
from torch import Tensor

from .mechanism import Array, Mechanism, array, mechanism, sizes, still
from .operations import (
    by_coordinates,
    cross,
    displacement,
    empty,
    evaluated,
    loads_of,
    one_of_v,
    operation,
    poses,
    rates,
    squares,
    tensor,
    three_of_v,
    times,
)

__all__: list[str] = []


# Inertial parameters, in which inverse dynamics is linear:
# tau = Y(q, v, a) pi + (terms that do not depend on pi)

def _components(x: Tensor) -> list[Tensor]:
    """The components along the last axis, each in contiguous memory."""
    return list(x.movedim(-1, 0).contiguous().unbind(0))


def _product(x: list[Tensor], y: list[Tensor]) -> list[Tensor]:
    """The vector product, by components."""
    return [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]


def _body_motion(key: str, q: Tensor, v: Tensor, a: Tensor) -> tuple[list[Tensor], list[Tensor], list[Tensor]]:
    """Motion of each moving body, in its axes: angular velocity, its rate, and r'' - g of the origin of its frame; by
    components."""
    m = mechanism(key).model
    bodies = slice(1, m.n_bodies + 1)  # the ground comes before them
    V, = evaluated(key, "twists", q, v)
    dV, = evaluated(key, "accelerations", q, v, a)
    C, = evaluated(key, "poses", q)
    motion, rate = _components(V[..., bodies, :]), _components(dV[..., bodies, :])
    R = _components(C[..., bodies, :3, :3].flatten(-2))
    r = [x + y - sum(float(g) * R[3 * j + k] for j, g in enumerate(m.gravity))
         for k, (x, y) in enumerate(zip(rate[3:], _product(motion[:3], motion[3:])))]
    return motion[:3], rate[:3], r


def _parameters_vjp_of(key: str, q: Tensor, v: Tensor, a: Tensor, w: Tensor) -> Tensor:
    """The product w . Y: the power of the wrenches that each parameter requires (eq. NEb) in the motion with the
    velocities w."""
    omega, alpha, r = _body_motion(key, q, v, a)
    W, = evaluated(key, "twists", q, w)
    motion = _components(W[..., 1:mechanism(key).model.n_bodies + 1, :])
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
    """The product Y dpi: the joint forces of the wrenches that bodies with the parameters dpi require."""
    omega, alpha, r = (torch.stack(x, dim=-1) for x in _body_motion(key, q, v, a))
    m, h, Theta = dpi.unflatten(-1, (-1, 10)).split([1, 3, 6], dim=-1)
    Theta = Theta[..., [0, 3, 4, 3, 1, 5, 4, 5, 2]].unflatten(-1, (3, 3))
    moment = times(Theta, alpha) + cross(omega, times(Theta, omega)) + cross(h, r)
    force = m * r + cross(alpha, h) + cross(omega, cross(omega, h))
    none = moment.new_zeros((*moment.shape[:-2], 1, 6))
    return loads_of(key, q, torch.cat([none, torch.cat([moment, force], dim=-1)], dim=-2))


_parameters_vjp = operation(
    "inverse_dynamics_parameters_vjp(str model, Tensor q, Tensor v, Tensor a, Tensor w) -> Tensor",
    _parameters_vjp_of, lambda key, q, *others: empty(q, sizes(key)[2]))
_parameters_jvp = operation(
    "inverse_dynamics_parameters_jvp(str model, Tensor q, Tensor v, Tensor a, Tensor dpi) -> Tensor",
    _parameters_jvp_of, one_of_v)


# Inverse and forward dynamics, f(q, v, x) with x the accelerations or the forces

class _Dynamics:
    """The operations of inverse or of forward dynamics: the value, products of its derivatives, and second
    derivatives."""

    def __init__(self, name: Literal["inverse_dynamics", "forward_dynamics"], x: str):
        self.name = name
        arguments = f"Tensor q, Tensor v, Tensor {x}, Tensor? parameters"
        directions = f"Tensor dq, Tensor dv, Tensor d{x}"
        self.hessian = operation(
            f"{name}_hessian(str model, bool gradient, {arguments}, Tensor w, {directions})"
            " -> (Tensor, Tensor, Tensor)", self._hessian, lambda key, gradient, *x: three_of_v(key, *x))
        self.jvp = operation(
            f"{name}_jvp(str model, {arguments}, {directions}) -> Tensor",
            lambda key, *x: self._product(key, "_jvp", *x)[0], one_of_v, self._jvp_backward)
        self.vjp = operation(
            f"{name}_vjp(str model, {arguments}, Tensor w) -> (Tensor, Tensor, Tensor)",
            lambda key, *x: self._product(key, "_vjp", *x), three_of_v, self._vjp_backward, self._vjp_forward)
        self.value = operation(
            f"{name}(str model, {arguments}) -> Tensor",
            lambda key, q, v, x, parameters: evaluated(key, name, q, v, x, parameters=parameters)[0],
            one_of_v, self._backward, self._forward)

    def _product(self, key: str, kind: str, q: Tensor, v: Tensor, x: Tensor, parameters: Tensor | None,
                 *w: Tensor) -> tuple[Tensor, ...]:
        if mechanism(key).model.n_loops == 0 or self.name == "inverse_dynamics":
            return evaluated(key, self.name + kind, q, v, x, *w, parameters=parameters)
        by = evaluated(key, self.name + "_derivatives", q, v, x, parameters=parameters)
        if kind == "_vjp":
            return tuple(times(d.mT, *w) for d in by)
        return (sum(times(d, dw) for d, dw in zip(by, w)),)

    def _hessian(self, key: str, gradient: bool, q: Tensor, v: Tensor, x: Tensor, parameters: Tensor | None, w: Tensor,
                 dq: Tensor, dv: Tensor, dx: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """The gradient of the derivative of w . f along (dq, dv, dx), or the derivative of its gradient.

        f is linear in x, and this part does not depend on v. For joints with several velocities qq is not symmetric.
        """
        qq, qv, vv, xq = evaluated(key, self.name + "_hessian", q, v, x, w, parameters=parameters)
        by_q = times(qq if gradient else qq.mT, dq) + times(qv, dv) + times(xq.mT, dx)
        return by_q, times(qv.mT, dq) + times(vv, dv), times(xq, dq)

    def _second(self, ctx: Any, key: Any, x: Any, w: Tensor, directions: Any) -> tuple[Tensor | None, ...]:
        """The gradient of the derivative of w . f along directions by q, v and x, and none by parameters."""
        if ctx.needed[3]:
            _refuse_parameters()
        if not any(ctx.needed[:3]):
            return None, None, None, None
        by_q, by_v, by_x = self.hessian(key, True, *x[:4], w, *directions)
        return by_coordinates(key, x[0], by_q), by_v, by_x, None

    def _vjp_backward(self, ctx: Any, key: Any, x: Any, result: Any, *directions: Tensor) -> tuple[Tensor | None, ...]:
        return (*self._second(ctx, key, x, x[4], directions),
                self.jvp(key, *x[:4], *directions) if ctx.needed[4] else None)

    def _vjp_forward(self, key: Any, x: Any, result: Any, dq: Any, dv: Any, dx: Any, dpi: Any,
                     dw: Any) -> tuple[Tensor, ...]:
        if dpi is not None:
            _refuse_parameters()
        of_state = self.hessian(key, False, *x, displacement(key, x[0], dq), dv, dx)
        return tuple(y + z for y, z in zip(of_state, self.vjp(key, *x[:4], dw)))

    def _jvp_backward(self, ctx: Any, key: Any, x: Any, result: Any, w: Tensor) -> tuple[Tensor | None, ...]:
        return (*self._second(ctx, key, x, w, x[4:]),
                *(self.vjp(key, *x[:4], w) if any(ctx.needed[4:]) else (None, None, None)))

    def _backward(self, ctx: Any, key: Any, x: Any, result: Any, w: Tensor) -> tuple[Tensor | None, ...]:
        q, v, a, _ = x
        of_state: Any = (None, None, None)
        if any(ctx.needed[:3]) or self.name == "forward_dynamics":
            of_state = self.vjp(key, *x, w)
        by_q, by_v, by_x = of_state
        # Required forces that are larger by Y dpi change a as drive forces that are smaller by Y dpi do.
        if self.name == "forward_dynamics":
            a, w = result[0], -by_x
        return (by_coordinates(key, q, by_q) if ctx.needed[0] else None, by_v, by_x,
                _parameters_vjp(key, q, v, a, w) if ctx.needed[3] else None)

    def _forward(self, key: Any, x: Any, result: Any, dq: Any, dv: Any, dx: Any, dpi: Any) -> Tensor:
        q, v, a, _ = x
        dq = displacement(key, q, dq)
        if dpi is None:
            return self.jvp(key, *x, dq, dv, dx)
        if self.name == "forward_dynamics":
            return self.jvp(key, *x, dq, dv, dx - _parameters_jvp(key, q, v, result[0], dpi))
        return self.jvp(key, *x, dq, dv, dx) + _parameters_jvp(key, q, v, a, dpi)


def _refuse_parameters() -> None:
    raise NotImplementedError("axode.torch has first derivatives by inertial parameters; a second one was asked for. If you "
                              "do not need it, pass parameters.detach()")


inverse_dynamics = _Dynamics("inverse_dynamics", "a")
forward_dynamics = _Dynamics("forward_dynamics", "tau")


# Mass matrices: column j of M are the forces of the acceleration e_j at rest without gravity

def _n_times(x: Tensor, n: int) -> Tensor:
    return x[..., None, :].expand(*x.shape[:-1], n, x.shape[-1])


def _unit_accelerations(key: str, x: Any, like: Tensor) -> tuple[str, tuple[Tensor, ...], Tensor | None]:
    """The model, the states and the parameters with which inverse dynamics gives the columns of M."""
    (q, parameters), n = x, like.shape[-1]
    states = _n_times(q, n), torch.zeros_like(like), torch.eye(n, dtype=q.dtype).expand_as(like)
    return still(key), states, None if parameters is None else _n_times(parameters, n)


def _mass_matrix_gradient(key: str, x: Any, w: Tensor, needed: tuple[bool, ...]) -> tuple[Tensor | None, ...]:
    """The gradient of w . M."""
    still, states, pi = _unit_accelerations(key, x, w)
    by_q = inverse_dynamics.vjp(still, *states, pi, w.mT)[0].sum(dim=-2) if needed[0] else None
    return (None if by_q is None else by_coordinates(key, x[0], by_q),
            _parameters_vjp(still, *states, w.mT).sum(dim=-2) if needed[1] else None)


def _mass_matrix_forward(key: Any, x: Any, M: Any, dq: Any, dpi: Any) -> Tensor:
    still, states, pi = _unit_accelerations(key, x, M[0])
    none, n = torch.zeros_like(M[0]), M[0].shape[-1]
    rows = inverse_dynamics.jvp(still, *states, pi, _n_times(displacement(key, x[0], dq), n), none, none)
    return rows if dpi is None else rows + _parameters_jvp(still, *states, _n_times(dpi, n))


def _of_matrix(name: str) -> tuple[str, Callable[..., Tensor], Callable[..., Tensor]]:
    return (f"{name}(str model, Tensor q, Tensor? parameters) -> Tensor",
            lambda key, q, parameters: evaluated(key, name, q, parameters=parameters)[0],
            lambda key, q, parameters: empty(q, sizes(key)[1], sizes(key)[1]))


mass_matrix = operation(
    *_of_matrix("mass_matrix"),
    lambda ctx, key, x, M, w: _mass_matrix_gradient(key, x, w, ctx.needed), _mass_matrix_forward)
inverse_mass_matrix = operation(  # dW = -W dM W
    *_of_matrix("inverse_mass_matrix"),
    lambda ctx, key, x, W, w: _mass_matrix_gradient(key, x, -(W[0] @ w @ W[0]), ctx.needed),
    lambda key, x, W, *directions: -(W[0] @ _mass_matrix_forward(key, x, W, *directions) @ W[0]))


# Energies

def _gravity_torques(key: str, q: Tensor, parameters: Tensor | None) -> Tensor:
    at_rest = empty(q, sizes(key)[1]).zero_()
    return inverse_dynamics.value(mechanism(key).tree.key, q, at_rest, at_rest, parameters)


def _potential_energy_regressor(key: str, q: Tensor) -> Tensor:
    """The row y with U = y pi, from the poses of the bodies: -g . r for a mass, -R^T g for a first moment."""
    m = mechanism(key).model
    C, g = poses(key, q)[..., 1:m.n_bodies + 1, :, :], torch.tensor(m.gravity, dtype=q.dtype)
    by_m, by_h = -times(C[..., None, :3, 3], g), -times(C[..., :3, :3].mT, g)
    return torch.cat([by_m, by_h, by_h.new_zeros((*by_h.shape[:-1], 6))], dim=-1).flatten(-2)


def _potential_energy_forward(key: Any, x: Any, U: Any, dq: Tensor, dpi: Any) -> Tensor:
    change = (_gravity_torques(key, *x) * displacement(key, x[0], dq)).sum(dim=-1)
    return change if dpi is None else change + (_potential_energy_regressor(key, x[0]) * dpi).sum(dim=-1)


potential_energy = operation(
    "potential_energy(str model, Tensor q, Tensor? parameters) -> Tensor",
    lambda key, q, parameters: evaluated(key, "potential_energy", q, parameters=parameters)[0],
    lambda key, q, *_: empty(q),
    lambda ctx, key, x, U, w: (
        w[..., None] * by_coordinates(key, x[0], _gravity_torques(key, *x)) if ctx.needed[0] else None,
        w[..., None] * _potential_energy_regressor(key, x[0]) if ctx.needed[1] else None),
    _potential_energy_forward)


# Motions in steps

def _rollout_arrays(key: str, *tensors: Tensor) -> tuple[Mechanism, list[Array]]:
    q, v, *rows = tensors
    return mechanism(key), [mechanism(key).configurations(q), array(v), *(array(x, 2) for x in rows)]


def _rollout_of(key: str, step: float, q: Tensor, v: Tensor, tau: Tensor) -> tuple[Tensor, ...]:
    of, arrays = _rollout_arrays(key, q, v, tau)
    return tuple(tensor(x, q) for x in of("rollout_under", *arrays, step)[:2])


def _rollout_vjp_of(key: str, step: float, q: Tensor, v: Tensor, tau: Tensor, w_q: Tensor,
                    w_v: Tensor) -> tuple[Tensor, ...]:
    of, (*motion, of_q, of_v) = _rollout_arrays(key, q, v, tau, w_q, w_v)
    return tuple(tensor(x, q) for x in of("rollout_vjp", *motion, step, of_q, of_v)[:3])


def _rollout_jvp_of(key: str, step: float, q: Tensor, v: Tensor, tau: Tensor, dq: Tensor, dv: Tensor,
                    dtau: Tensor) -> tuple[Tensor, ...]:
    of, motion = _rollout_arrays(key, q, v, tau)
    return tuple(tensor(x, q) for x in of("rollout_jvp", *motion, step, array(dq), array(dv), array(dtau, 2)))


def _rollout_backward(ctx: Any, constants: Any, x: Any, motion: Any, w_q: Tensor, w_v: Tensor) -> tuple[Tensor, ...]:
    key, path = constants[0], motion[0]
    along = squares(key, path) * displacement(key, path, w_q)  # E^T w_q
    by_q, by_v, by_tau = _rollout_vjp(*constants, *x, along, w_v)
    return by_coordinates(key, x[0], by_q), by_v, by_tau


def _rollout_forward(constants: Any, x: Any, motion: Any, dq: Any, dv: Any, dtau: Any) -> tuple[Tensor, Tensor]:
    key, q = constants[0], x[0]
    of_q, of_v = _rollout_jvp(*constants, *x, displacement(key, q, dq), dv, dtau)
    return rates(key, motion[0], of_q), of_v


def _states_of(tau: Tensor, *sizes: int) -> tuple[Tensor, ...]:
    return tuple(tau.new_empty((*tau.shape[:-2], tau.shape[-2] + 1, n)) for n in sizes)


_rollout_vjp = operation(
    "rollout_vjp(str model, float step, Tensor q, Tensor v, Tensor tau, Tensor w_q, Tensor w_v)"
    " -> (Tensor, Tensor, Tensor)",
    _rollout_vjp_of,
    lambda key, step, q, v, tau, *_: (empty(v, v.shape[-1]), empty(v, v.shape[-1]), tau.new_empty(tau.shape)))
_rollout_jvp = operation(
    "rollout_jvp(str model, float step, Tensor q, Tensor v, Tensor tau, Tensor dq, Tensor dv, Tensor dtau)"
    " -> (Tensor, Tensor)",
    _rollout_jvp_of, lambda key, step, q, v, tau, *_: _states_of(tau, v.shape[-1], v.shape[-1]))
rollout = operation(
    "rollout(str model, float step, Tensor q, Tensor v, Tensor tau) -> (Tensor, Tensor)",
    _rollout_of, lambda key, step, q, v, tau: _states_of(tau, q.shape[-1], v.shape[-1]),
    _rollout_backward, _rollout_forward)
