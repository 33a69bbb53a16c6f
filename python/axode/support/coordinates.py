"""The map q' = E(q) v from velocities to rates of coordinates, joint by joint, for the arrays of any library.

A joint is planar (angle, x, y), spherical (a quaternion x y z w), free (a quaternion and a position), or has q' = v.
Its velocities are along its own axes. Quaternions may have any length: a rotation R is that of a / |a|.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

__all__: list[str] = []

#: Kinds of joints that have a quaternion.
TURNING = ("spherical", "free")


class Arrays(NamedTuple):
    """The operations of a library on arrays whose last axis has the numbers of one joint."""

    part: Callable[[Any, int, int], Any]
    """part(x, a, b) are the numbers a to b - 1."""
    join: Callable[[Sequence[Any]], Any]
    """join(parts) are the numbers of all parts, one after the other."""
    cross: Callable[[Any, Any], Any]
    dot: Callable[[Any, Any], Any]
    """dot(x, y) is one number on the last axis."""
    cos: Callable[[Any], Any]
    sin: Callable[[Any], Any]


NUMPY = Arrays(part=lambda x, a, b: x[..., a:b], join=lambda parts: np.concatenate(parts, axis=-1), cross=np.cross,
               dot=lambda x, y: np.sum(x * y, axis=-1, keepdims=True), cos=np.cos, sin=np.sin)


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
    c, s, x, y = on.cos(angle), on.sin(angle), on.part(r, 0, 1), on.part(r, 1, 2)
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
