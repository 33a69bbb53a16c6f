"""What programs of JAX know of a model: a handle that they hold, and its coordinates."""

from __future__ import annotations

import collections
import functools
import hashlib
import weakref
from typing import Any

import jax.numpy as jnp  # type: ignore[import-not-found, unused-ignore]
import numpy as np
from numpy.typing import NDArray

from .._axode import Model
from .._axode import jax as _jax

__all__ = ["Mechanism", "cross", "integrated", "mechanism_of", "rates_of", "velocities_of"]

Array = Any  # of JAX, or a tracer


#: A program may be dropped while it runs in another thread, and then asks for its model: so many that were let go stay.
KEPT = 256
_let_go_last: collections.deque[str] = collections.deque()


def _let_go(key: str) -> None:
    _let_go_last.append(key)
    if len(_let_go_last) > KEPT:
        _jax.remove(_let_go_last.popleft())


class Mechanism:
    """A model as compiled programs name it: by a text that says what it consists of.

    Equal models have equal ones. The compiled module holds the model for as long as one of them is alive, and a while longer;
    programs hold the one that they were compiled for.
    """

    def __init__(self, m: Model, key: str):
        self.key, self.name = key, m.name
        self.nq, self.nv, self.n_frames, self.n_bodies = m.nq, m.nv, m.n_frames, m.n_bodies
        self.gravity, self.parameters = m.gravity, m.parameters.reshape(m.n_bodies, 10)
        self.still: Mechanism | None = None  # the same without gravity, where it was asked for
        self._tree = _jax.structure(m)
        self._screw_body = np.array(self._tree["screw_body"], dtype=int)
        self.n_screws = self._screw_body.size
        self._coordinates(m)
        _jax.add(key, m)
        weakref.finalize(self, _let_go, key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Mechanism) and other.key == self.key

    def __hash__(self) -> int:
        return hash(self.key)

    def __repr__(self) -> str:
        return f'"{self.name}"'

    # Which screws move what, a row of 0 and 1 over the joint screws for each frame, and for each screw's body. Only kinematics ask.

    @functools.cached_property
    def _moves_body(self) -> NDArray[np.float64]:
        on_path = np.zeros((self.n_bodies + 1, self.n_screws))
        for i, parent in enumerate(self._tree["parent"], start=1):
            on_path[i] = on_path[parent] + (self._screw_body == i)
        return on_path

    @functools.cached_property
    def moves_frame(self) -> NDArray[np.float64]:
        rows: NDArray[np.float64] = self._moves_body[np.array(self._tree["frame_body"], dtype=int)]
        return rows

    @functools.cached_property
    def moves_screw(self) -> NDArray[np.float64]:
        rows: NDArray[np.float64] = self._moves_body[self._screw_body]
        return rows

    @functools.cached_property
    def screw_rates(self) -> NDArray[np.float64]:
        """s = screw_rates @ v are the rates of the joint screws."""
        rates = np.zeros((self.n_screws, self.nv))
        rates[np.arange(self.n_screws), np.array(self._tree["screw_velocity"], dtype=int)] = self._tree["screw_ratio"]
        return rates

    def _coordinates(self, m: Model) -> None:
        """Where the numbers of joints are, by what their rates are to velocities."""
        rotations: list[tuple[int, int]] = []  # the first coordinate and velocity of each
        positions: list[tuple[int, int, int]] = []  # of the quaternion, and the position in q and v
        planes: list[tuple[int, int]] = []
        plain: list[tuple[int, int]] = []
        for joint in m.joints:
            q, v = joint.q.start, joint.v.start
            if joint.q.stop == q:
                continue
            if joint.kind in ("spherical", "free"):
                rotations.append((q, v))
            if joint.kind == "free":
                positions.append((q, q + 4, v + 3))
            elif joint.kind == "planar":
                planes.append((q, v))
            elif joint.kind != "spherical":
                plain += [(q + k, v + k) for k in range(joint.q.stop - q)]

        def runs(first: list[int], length: int) -> NDArray[np.int_]:
            return np.array(first, dtype=int)[:, None] + np.arange(length)

        self.plain_q, self.plain_v = (np.array([pair[k] for pair in plain], dtype=int) for k in (0, 1))
        self.turn_q, self.turn_v = runs([q for q, _ in rotations], 4), runs([v for _, v in rotations], 3)
        self.base_q = runs([q for q, _, _ in positions], 4)
        self.place_q, self.place_v = (runs([each[k] for each in positions], 3) for k in (1, 2))
        self.plane_q, self.plane_v = (runs([pair[k] for pair in planes], 3) for k in (0, 1))
        self.from_parts_v = np.argsort(np.concatenate(
            [self.plain_v, *(each.ravel() for each in (self.turn_v, self.place_v, self.plane_v))]))
        self.from_parts_q = np.argsort(np.concatenate(
            [self.plain_q, *(each.ravel() for each in (self.turn_q, self.place_q, self.plane_q))]))
        #: whether v is dq/dt
        self.is_vector = self.plain_v.size == self.nv and bool(np.all(self.plain_q == self.plain_v))


_of_models: weakref.WeakKeyDictionary[Model, Mechanism] = weakref.WeakKeyDictionary()
_by_key: weakref.WeakValueDictionary[str, Mechanism] = weakref.WeakValueDictionary()


def mechanism_of(m: Model, still: bool = False) -> Mechanism:
    """The one of a model, with `still` also that of the model without gravity."""
    if not isinstance(m, Model):
        raise TypeError(f"m: expected a Model, got {type(m).__name__}")
    found = _of_models.get(m)
    if found is None:
        key = hashlib.sha256(repr(m.__getstate__()).encode()).hexdigest()
        found = _by_key.get(key) or Mechanism(m, key)
        _by_key[key] = _of_models[m] = found
    if still and found.still is None:
        found.still = mechanism_of(m.with_gravity(np.zeros(3)))
    return found


# Products of vectors and of quaternions, and R |a|^2 of a quaternion a, as linear maps: XLA compiles few operations quickly.
_CROSS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _j, _k], _CROSS[_i, _k, _j] = 1, -1  # [of the result, of a, of b]
_QUATERNION = np.zeros((4, 4, 4))
_QUATERNION[:3, :3, :3] = _CROSS
_QUATERNION[3] = np.diag([-1, -1, -1, 1])
_QUATERNION[np.arange(3), 3, np.arange(3)] = _QUATERNION[np.arange(3), np.arange(3), 3] = 1
_CONJUGATE = np.diag([-1.0, -1, -1, 1])
#: [of the row, of the column, of a, of a]: R r = Im(a (r; 0) a*)
_ROTATION = np.einsum("ipm,pnj,mk->ijnk", _QUATERNION[:3], _QUATERNION[:, :, :3], _CONJUGATE)


def _bilinear(table: NDArray[np.float64], a: Array, b: Array) -> Array:
    n, k, l = table.shape
    rows = (a @ np.moveaxis(table, 1, 0).reshape(k, n * l).astype(a.dtype)).reshape(*a.shape[:-1], n, l)
    return jnp.sum(rows * b[..., None, :], axis=-1)


def cross(a: Array, b: Array) -> Array:
    """a x b."""
    return _bilinear(_CROSS, a, b)


def _product(a: Array, b: Array) -> Array:
    """Of quaternions x y z w."""
    return _bilinear(_QUATERNION, a, b)


def _conjugate(a: Array) -> Array:
    return a * np.diag(_CONJUGATE).astype(a.dtype)


def _turned(a: Array, r: Array) -> Array:
    """R r with the rotation R of a quaternion a of any length."""
    pairs = (a[..., :, None] * a[..., None, :]).reshape(*a.shape[:-1], 16)
    R = (pairs @ _ROTATION.reshape(9, 16).T.astype(a.dtype)).reshape(*a.shape[:-1], 3, 3)
    return jnp.sum(R * r[..., None, :], axis=-1) / jnp.sum(a * a, axis=-1, keepdims=True)


def _turned_in_plane(angle: Array, r: Array) -> Array:
    s, c = jnp.sin(angle), jnp.cos(angle)
    return jnp.stack([c * r[..., 0] - s * r[..., 1], s * r[..., 0] + c * r[..., 1]], axis=-1)


def _in_order(parts: list[Array], order: NDArray[np.int_]) -> Array:
    """The numbers of joints of one kind behind those of the other, (..., joints, numbers), in their places."""
    flat = [each.reshape(*each.shape[:-2], each.shape[-2] * each.shape[-1]) for each in parts if each.shape[-2]]
    return jnp.concatenate(flat, axis=-1)[..., order]


def velocities_of(m: Mechanism, q: Array, dq: Array) -> Array:
    """v from dq/dt. What changes the length of a quaternion is left out, and quaternions count as brought to length 1."""
    if m.is_vector:
        return dq
    parts = [dq[..., m.plain_q[:, None]]]
    if m.turn_q.size:
        a = q[..., m.turn_q]
        w = 2 * _product(_conjugate(a), dq[..., m.turn_q])[..., :3]
        parts.append(w / jnp.sum(a * a, axis=-1, keepdims=True))
    if m.place_q.size:
        parts.append(_turned(_conjugate(q[..., m.base_q]), dq[..., m.place_q]))
    if m.plane_q.size:
        plane = dq[..., m.plane_q]
        parts.append(jnp.concatenate([plane[..., :1], _turned_in_plane(-q[..., m.plane_q[:, 0]], plane[..., 1:])], axis=-1))
    return _in_order(parts, m.from_parts_v)


def rates_of(m: Mechanism, q: Array, v: Array) -> Array:
    """dq/dt from v."""
    if m.is_vector:
        return v
    parts = [v[..., m.plain_v[:, None]]]
    if m.turn_q.size:
        w = v[..., m.turn_v]
        parts.append(0.5 * _product(q[..., m.turn_q], jnp.concatenate([w, jnp.zeros_like(w[..., :1])], axis=-1)))
    if m.place_q.size:
        parts.append(_turned(q[..., m.base_q], v[..., m.place_v]))
    if m.plane_q.size:
        plane = v[..., m.plane_v]
        parts.append(jnp.concatenate([plane[..., :1], _turned_in_plane(q[..., m.plane_q[:, 0]], plane[..., 1:])], axis=-1))
    return _in_order(parts, m.from_parts_q)


def _sinc(s: Array) -> Array:
    """sin(x)/x as a function of s = x², which can be differentiated at 0."""
    near = s < 0.01
    x = jnp.sqrt(jnp.where(near, 1, s))
    return jnp.where(near, 1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110)))), jnp.sin(x) / x)


def _rest_of_sinc(s: Array) -> Array:
    """(1 - sin(x)/x) / x² of the same."""
    near = s < 0.01
    series = (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110)))) / 6
    return jnp.where(near, series, (1 - _sinc(s)) / jnp.where(near, 1, s))


def _exp_quaternion(w: Array) -> Array:
    s = jnp.sum(w * w, axis=-1, keepdims=True) / 4
    return jnp.concatenate([0.5 * _sinc(s) * w, 1 - 0.5 * s * _sinc(s / 4) ** 2], axis=-1)


def _carried(w: Array, v: Array) -> Array:
    """dexp_w v: how far a screw motion with the rotation vector w goes."""
    s, t = jnp.sum(w * w, axis=-1, keepdims=True), cross(w, v)
    return v + 0.5 * _sinc(s / 4) ** 2 * t + _rest_of_sinc(s) * cross(w, t)


def integrated(m: Mechanism, q: Array, dv: Array) -> Array:
    """q (+) dv."""
    if m.is_vector:
        return q + dv
    parts = [q[..., m.plain_q[:, None]] + dv[..., m.plain_v[:, None]]]
    if m.turn_q.size:
        parts.append(_product(q[..., m.turn_q], _exp_quaternion(dv[..., m.turn_v])))
    if m.place_q.size:
        moved = _carried(dv[..., m.place_v - 3], dv[..., m.place_v])
        parts.append(q[..., m.place_q] + _turned(q[..., m.base_q], moved))
    if m.plane_q.size:
        plane, by = q[..., m.plane_q], dv[..., m.plane_v]
        axis = jnp.concatenate([jnp.zeros_like(by[..., :2]), by[..., :1]], axis=-1)
        ahead = _carried(axis, jnp.concatenate([by[..., 1:], jnp.zeros_like(by[..., :1])], axis=-1))[..., :2]
        parts.append(jnp.concatenate(
            [plane[..., :1] + by[..., :1], plane[..., 1:] + _turned_in_plane(plane[..., 0], ahead)], axis=-1))
    return _in_order(parts, m.from_parts_q)
