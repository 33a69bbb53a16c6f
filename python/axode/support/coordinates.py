"""The map q' = E(q) v from velocities to rates of coordinates, and the configurations q (+) v and differences of
configurations, joint by joint, for the arrays of any library.

A joint is planar (angle, x, y), spherical (a quaternion x y z w), free (a quaternion and a position), or has q' = v.
Its velocities are along its own axes. Quaternions may have any length: a rotation R is that of a / |a|.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

__all__: list[str] = []

#: Kinds of joints that have a quaternion, and all kinds whose velocities are not the rates of their coordinates.
TURNING = ("spherical", "free")
GROUPS = ("planar", *TURNING)


class Arrays(NamedTuple):
    """The operations of a library on arrays whose last axis has the numbers of one joint."""

    part: Callable[[Any, int, int], Any]
    """part(x, a, b) are the numbers a to b - 1."""
    join: Callable[[Sequence[Any]], Any]
    """join(parts) are the numbers of all parts, one after the other."""
    cross: Callable[[Any, Any], Any]
    dot: Callable[[Any, Any], Any]
    """dot(x, y) is one number on the last axis."""
    where: Callable[[Any, Any, Any], Any]
    """where(condition, x, y) is x where the condition holds, and y elsewhere."""
    functions: Any
    """The module of cos, sin, sqrt and arctan2."""


NUMPY = Arrays(part=lambda x, a, b: x[..., a:b], join=lambda parts: np.concatenate(parts, axis=-1), cross=np.cross,
               dot=lambda x, y: np.sum(x * y, axis=-1, keepdims=True), where=np.where, functions=np)


def product(on: Arrays, a: Any, b: Any) -> Any:
    """The product of the quaternions a and b."""
    u, w, x, y = on.part(a, 0, 3), on.part(a, 3, 4), on.part(b, 0, 3), on.part(b, 3, 4)
    return on.join([w * x + y * u + on.cross(u, x), w * y - on.dot(u, x)])


def turned(on: Arrays, a: Any, r: Any) -> Any:
    """R r for a quaternion a."""
    u, w = on.part(a, 0, 3), on.part(a, 3, 4)
    return r + 2 / on.dot(a, a) * on.cross(u, on.cross(u, r) + w * r)


def turned_back(on: Arrays, a: Any, r: Any) -> Any:
    """R^T r for a quaternion a."""
    u, w = on.part(a, 0, 3), on.part(a, 3, 4)
    return r + 2 / on.dot(a, a) * on.cross(u, on.cross(u, r) - w * r)


def turned_in_plane(on: Arrays, angle: Any, r: Any) -> Any:
    c, s, x, y = on.functions.cos(angle), on.functions.sin(angle), on.part(r, 0, 1), on.part(r, 1, 2)
    return on.join([c * x - s * y, s * x + c * y])


def rates(on: Arrays, kind: str, q: Any, v: Any) -> Any:
    """q' = E v of a joint."""
    if kind == "planar":
        return on.join([on.part(v, 0, 1), turned_in_plane(on, on.part(q, 0, 1), on.part(v, 1, 3))])
    if kind not in TURNING:
        return v
    u, w, omega = on.part(q, 0, 3), on.part(q, 3, 4), on.part(v, 0, 3)
    turning = [(w * omega + on.cross(u, omega)) / 2, -on.dot(u, omega) / 2]
    return on.join(turning if kind == "spherical" else [*turning, turned(on, on.part(q, 0, 4), on.part(v, 3, 6))])


def velocities(on: Arrays, kind: str, q: Any, dq: Any) -> Any:
    """v with E v = q' of a joint; a change of the length of a quaternion is left out."""
    if kind == "planar":
        return on.join([on.part(dq, 0, 1), turned_in_plane(on, -on.part(q, 0, 1), on.part(dq, 1, 3))])
    if kind not in TURNING:
        return dq
    a, u, w = on.part(q, 0, 4), on.part(q, 0, 3), on.part(q, 3, 4)
    omega = 2 / on.dot(a, a) * (w * on.part(dq, 0, 3) - on.cross(u, on.part(dq, 0, 3)) - on.part(dq, 3, 4) * u)
    return omega if kind == "spherical" else on.join([omega, turned_back(on, a, on.part(dq, 4, 7))])


# Power series in s = x^2 of cos x, sin x / x, (1 - cos x) / x^2, (x - sin x) / x^3 and (1 - (x / 2)
# cot(x / 2)) / x^2. The coefficients of the last one are |B_2k| / (2k)! with the numbers of Bernoulli.
_COS, _SINC, _A, _B = ([(-1.0) ** k / math.factorial(2 * k + n) for k in range(11)] for n in range(4))
_BERNOULLI = (1 / 6, 1 / 30, 1 / 42, 1 / 30, 5 / 66, 691 / 2730, 7 / 6, 3617 / 510, 43867 / 798, 174611 / 330, 854513 / 138)
_KAPPA = [b / math.factorial(2 * k) for k, b in enumerate(_BERNOULLI, 1)]


def _power(coefficients: Sequence[float], s: Any) -> Any:
    power: Any = 0
    for c in reversed(coefficients):
        power = c + s * power
    return power


def _of_square(on: Arrays, s: Any, series: Sequence[float], f: Callable[[Any], Any]) -> Any:
    """The function f(x) as a function of s = x^2. For s < 1 it is a power series in s, so that it has derivatives of
    every order at 0. Some libraries compute both cases; therefore f is never called with 0."""
    near = s < 1
    return on.where(near, _power(series, on.where(near, s, 0)), f(on.functions.sqrt(on.where(near, 1, s))))


def _dexp(on: Arrays, w: Any, v: Any) -> Any:
    """The map from the linear part v of a screw to the translation of its motion with the rotation vector w."""
    s, t, f = on.dot(w, w), on.cross(w, v), on.functions
    return (v + _of_square(on, s, _A, lambda x: (1 - f.cos(x)) / x**2) * t
            + _of_square(on, s, _B, lambda x: (x - f.sin(x)) / x**3) * on.cross(w, t))


def _dexp_inverse(on: Arrays, w: Any, v: Any) -> Any:
    t, f = on.cross(w, v), on.functions
    kappa = _of_square(on, on.dot(w, w), _KAPPA, lambda x: (1 - x / 2 * f.cos(x / 2) / f.sin(x / 2)) / x**2)
    return v - t / 2 + kappa * on.cross(w, t)


def _rotation_vector(on: Arrays, a: Any) -> Any:
    """The rotation vector, of at most a half turn, of a quaternion of any norm."""
    a = on.where(on.part(a, 3, 4) < 0, -1, 1) * a
    u, w = on.part(a, 0, 3), on.part(a, 3, 4)
    s = on.dot(u, u)
    near = s < 0.04 * w**2  # if so, atan(x) / x with x^2 = s / w^2 by its power series
    power = _power([(-1) ** k / (2 * k + 1) for k in range(13)], on.where(near, s, 0) / on.where(near, w, 1) ** 2)
    x = on.functions.sqrt(on.where(near, 1, s))
    return 2 * u * on.where(near, power / on.where(near, w, 1), on.functions.arctan2(x, w) / x)


def _in_plane(on: Arrays, angle: Any, r: Any) -> tuple[Any, Any]:
    """The rotation vector and the vector in space of an angle and a vector in the plane of a planar joint."""
    return on.join([0 * angle, 0 * angle, angle]), on.join([r, 0 * angle])


def integrated(on: Arrays, kind: str, q: Any, v: Any) -> Any:
    """q (+) v of a joint. The length of a quaternion does not change."""
    if kind == "planar":
        angle = on.part(q, 0, 1)
        moved = on.part(_dexp(on, *_in_plane(on, on.part(v, 0, 1), on.part(v, 1, 3))), 0, 2)
        return on.join([angle + on.part(v, 0, 1), on.part(q, 1, 3) + turned_in_plane(on, angle, moved)])
    if kind not in TURNING:
        return q + v
    a, w = on.part(q, 0, 4), on.part(v, 0, 3)
    s, f = on.dot(w, w) / 4, on.functions
    turn = on.join([_of_square(on, s, _SINC, lambda x: f.sin(x) / x) * w / 2, _of_square(on, s, _COS, f.cos)])
    after = product(on, a, turn)
    return after if kind == "spherical" else on.join(
        [after, on.part(q, 4, 7) + turned(on, a, _dexp(on, w, on.part(v, 3, 6)))])


def difference(on: Arrays, kind: str, q0: Any, q1: Any) -> Any:
    """v with q0 (+) v = q1 for a joint. Rotations take the shorter way round."""
    if kind == "planar":
        turn, f = on.part(q1, 0, 1) - on.part(q0, 0, 1), on.functions
        angle = f.arctan2(f.sin(turn), f.cos(turn))
        moved = turned_in_plane(on, -on.part(q0, 0, 1), on.part(q1, 1, 3) - on.part(q0, 1, 3))
        return on.join([angle, on.part(_dexp_inverse(on, *_in_plane(on, angle, moved)), 0, 2)])
    if kind not in TURNING:
        return q1 - q0
    a = on.part(q0, 0, 4)
    w = _rotation_vector(on, product(on, on.join([-on.part(a, 0, 3), on.part(a, 3, 4)]), on.part(q1, 0, 4)))
    return w if kind == "spherical" else on.join(
        [w, _dexp_inverse(on, w, turned_back(on, a, on.part(q1, 4, 7) - on.part(q0, 4, 7)))])


def normalized(on: Arrays, kind: str, q: Any) -> Any:
    """q of a joint with a quaternion of length 1."""
    if kind not in TURNING:
        return q
    a = on.part(q, 0, 4)
    a = a / on.functions.sqrt(on.dot(a, a))
    return a if kind == "spherical" else on.join([a, on.part(q, 4, 7)])
