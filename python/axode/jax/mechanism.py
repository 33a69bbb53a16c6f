"""Models in programs of JAX: a handle, and operations on coordinates."""

from __future__ import annotations

import collections
import functools
import hashlib
import weakref
from typing import Any

import jax.numpy as jnp  # type: ignore[import-not-found, unused-ignore]
import numpy as np
from numpy.typing import NDArray

from ..support import coordinates
from .._axode import Model
from .._axode import jax as _jax

__all__ = ["Mechanism", "cross", "integrated", "mechanism_of", "rates_of", "velocities_of"]

Array = Any  # of JAX, or a tracer


#: The number of models that stay in memory after their release. A program may be dropped while it runs in
#: another thread, and still needs its model then.
KEPT = 256
_let_go_last: collections.deque[str] = collections.deque()


def _let_go(key: str) -> None:
    _let_go_last.append(key)
    if len(_let_go_last) > KEPT:
        _jax.remove(_let_go_last.popleft())


class Mechanism:
    """A handle of a model for compiled programs.

    It has a key that is made of the contents of the model, so that equal models have equal keys. The compiled module
    keeps the model as long as one of its handles exists, and for some time longer; a program holds the handle for
    which it was compiled.
    """

    def __init__(self, m: Model, key: str):
        self.key, self.name = key, m.name
        self.nq, self.nv, self.n_frames, self.n_bodies = m.nq, m.nv, m.n_frames, m.n_bodies
        self.gravity, self.parameters = m.gravity, m.parameters.reshape(m.n_bodies, 10)
        self.still: Mechanism | None = None  # the same mechanism without gravity, once it is needed
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

    # The joint screws that move each frame, and the body of each screw:
    # a row of 0 and 1 over the joint screws. Only kinematics need them.

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
        """The matrix for which screw_rates @ v are the rates of the joint screws."""
        rates = np.zeros((self.n_screws, self.nv))
        rates[np.arange(self.n_screws), np.array(self._tree["screw_velocity"], dtype=int)] = self._tree["screw_ratio"]
        return rates

    def _coordinates(self, m: Model) -> None:
        """Groups the joints by kind: the places of their numbers in q and in v, (joints, numbers)."""
        places: dict[str, list[tuple[range, range]]] = {}
        for joint in m.joints:
            q, v = (range(of.start, of.stop) for of in (joint.q, joint.v))
            if joint.kind in coordinates.GROUPS:
                places.setdefault(joint.kind, []).append((q, v))
            else:
                places.setdefault("plain", []).extend((range(i, i + 1), range(j, j + 1)) for i, j in zip(q, v))
        self.joints: list[tuple[str, NDArray[np.int_], NDArray[np.int_]]] = [
            (kind, np.array([q for q, _ in joints]), np.array([v for _, v in joints]))
            for kind, joints in places.items()]
        self.q_order = np.argsort([k for _, at, _ in self.joints for k in at.ravel()])
        self.v_order = np.argsort([k for _, _, at in self.joints for k in at.ravel()])
        #: whether v is dq/dt
        self.is_vector = set(places) <= {"plain"}


_of_models: weakref.WeakKeyDictionary[Model, Mechanism] = weakref.WeakKeyDictionary()
_by_key: weakref.WeakValueDictionary[str, Mechanism] = weakref.WeakValueDictionary()


def mechanism_of(m: Model, still: bool = False) -> Mechanism:
    """The handle of a model; with `still`, its member `still` is the handle of the model without gravity."""
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


# The vector product as a linear map: XLA compiles few operations quickly.
_CROSS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _j, _k], _CROSS[_i, _k, _j] = 1, -1  # [index of the result, of a, of b]


def cross(a: Array, b: Array) -> Array:
    """The vector product a x b."""
    rows = (a @ np.moveaxis(_CROSS, 1, 0).reshape(3, 9).astype(a.dtype)).reshape(*a.shape[:-1], 3, 3)
    return jnp.sum(rows * b[..., None, :], axis=-1)


_ARRAYS = coordinates.Arrays(
    part=lambda x, first, end: x[..., first:end], join=lambda parts: jnp.concatenate(parts, axis=-1), cross=cross,
    dot=lambda x, y: jnp.sum(x * y, axis=-1, keepdims=True), where=jnp.where, functions=jnp)


def _in_order(parts: list[Array], order: NDArray[np.int_]) -> Array:
    """Puts the numbers of all joints, given kind by kind, (..., joints, numbers), at their positions."""
    flat = [each.reshape(*each.shape[:-2], each.shape[-2] * each.shape[-1]) for each in parts]
    return jnp.concatenate(flat, axis=-1)[..., order]


def velocities_of(m: Mechanism, q: Array, dq: Array) -> Array:
    """The velocities v from dq/dt. Changes of the norm of a quaternion are left out, and quaternions are divided by
    their norm."""
    if m.is_vector:
        return dq
    parts = [coordinates.velocities(_ARRAYS, kind, q[..., at], dq[..., at]) for kind, at, _ in m.joints]
    return _in_order(parts, m.v_order)


def rates_of(m: Mechanism, q: Array, v: Array) -> Array:
    """The rates dq/dt from v."""
    if m.is_vector:
        return v
    parts = [coordinates.rates(_ARRAYS, kind, q[..., at_q], v[..., at_v]) for kind, at_q, at_v in m.joints]
    return _in_order(parts, m.q_order)


def integrated(m: Mechanism, q: Array, dv: Array) -> Array:
    """The configuration q (+) dv."""
    if m.is_vector:
        return q + dv
    parts = [coordinates.integrated(_ARRAYS, kind, q[..., at_q], dv[..., at_v]) for kind, at_q, at_v in m.joints]
    return _in_order(parts, m.q_order)
