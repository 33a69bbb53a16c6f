"""Conversion of states to the conventions of Pinocchio and of MuJoCo, and back, and of models of MuJoCo to
mechanisms.

| | Pinocchio | MuJoCo |
|---|---|---|
| joints | depth-first, at each link by the names of the joints | depth-first, in the order of the file, as in axode |
| unlimited angle | (cos, sin) | angle |
| planar joint | (x, y, cos, sin); (v_x, v_y, w) in axes that turn with it | (x, y, angle) and its rates, a joint each |
| free joint, q | position in its frame, quaternion x y z w | position of the body, quaternion w x y z |
| free joint, v | linear, angular; both in axes of the body | linear in inertial axes, angular in those of the body |
| spherical joint | quaternion x y z w | quaternion w x y z |
| follower | a separate joint; left out with mimic=True | a separate joint |

The velocities of the other library are P v; the columns of P are the images of unit vectors. Forces are mapped by its
transpose:

>>> P = axode.convert.to_pinocchio(arm, np.tile(arm.neutral(), (arm.nv, 1)), np.eye(arm.nv))[1].T
>>> tau_there = np.ones(7)
>>> tau = P.T @ tau_there

The accelerations of Pinocchio are P a. Those of MuJoCo are P a + P' v, because a free base turns the axes of its
linear velocity.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, overload

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import lie
from .support import arguments, coordinates, mujoco_model, signatures
from ._axode import Model
from ._axode import load_dict as _load_dict
from .support.coordinates import NUMPY

__all__ = ["from_mujoco", "from_pinocchio", "model_from_mujoco", "to_mujoco", "to_pinocchio"]

Array = NDArray[np.float64]


@overload
def from_pinocchio(m: Model, q: ArrayLike, v: ArrayLike, *, joints: Sequence[str] | None = None,
                   tolerance: float = 1e-9) -> tuple[Array, Array]: ...
@overload
def from_pinocchio(m: Model, q: ArrayLike, v: None = None, *, joints: Sequence[str] | None = None,
                   tolerance: float = 1e-9) -> tuple[Array, None]: ...
def from_pinocchio(m: Model, q: ArrayLike, v: ArrayLike | None = None, *, joints: Sequence[str] | None = None,
                   tolerance: float = 1e-9) -> tuple[Array, Array | None]:
    """Converts q and v of Pinocchio to (q, v) of axode, (nq,) and (nv,) or (N, nq) and (N, nv). If v is None, so is
    the v of the result.

    Pinocchio's model is that of buildModelFromUrdf on the file of m, with a free flyer at its root if m has a free
    base, and with or without mimic=True, which the length of q shows. Without mimic=True followers have coordinates:
    ValueError if one differs from its coupling by more than `tolerance`, in rad, m, rad/s and m/s; np.inf ignores
    them. Unlimited angles are in [-pi, pi], because (cos, sin) do not count turns.

    `joints` are the names of the joints of m in the order of a model of Pinocchio made in another way: its names[1:],
    with "free_base" for its "root_joint". KeyError for unknown names. ValueError for wrong shapes, for (cos, sin)
    that differ from the unit circle by more than 1e-6, and for joints that Pinocchio does not have: helical ones, and
    planar ones whose plane is not z = 0 of their body.

    >>> m = axode.load(axode.robots / "humanoid.urdf", base="free")
    >>> q_there = np.zeros(m.nq)
    >>> q_there[:7] = [0.1, 0.2, 0.3, 0, 0, 0, 1]
    >>> q, v = axode.convert.from_pinocchio(m, q_there, np.zeros(m.nv))
    >>> q[m.joint("free_base").q]
    array([0. , 0. , 0. , 1. , 0.1, 0.2, 0.3])
    """
    names, given = None if joints is None else tuple(joints), arguments.array("q", q)
    plain, coupled = (_layout(m, "Pinocchio", names, followers) for followers in (True, False))
    layout = coupled if given.shape[-1:] == (coupled.nq,) else plain
    return layout.from_there(given, v, tolerance)


@overload
def to_pinocchio(m: Model, q: ArrayLike, v: ArrayLike, *, joints: Sequence[str] | None = None,
                 mimic: bool = False) -> tuple[Array, Array]: ...
@overload
def to_pinocchio(m: Model, q: ArrayLike, v: None = None, *, joints: Sequence[str] | None = None,
                 mimic: bool = False) -> tuple[Array, None]: ...
def to_pinocchio(m: Model, q: ArrayLike, v: ArrayLike | None = None, *, joints: Sequence[str] | None = None,
                 mimic: bool = False) -> tuple[Array, Array | None]:
    """Converts q and v of axode, (nq,) and (nv,) or (N, nq) and (N, nv), to (q, v) of Pinocchio. If v is None, so is
    the v of the result.

    Arguments and errors are those of `from_pinocchio`. Followers get the coordinates and velocities that follow from
    their leaders; with mimic=True they are left out, as by buildModelFromUrdf(..., mimic=True).

    >>> m = axode.load(axode.robots / "humanoid.urdf", base="free")
    >>> q_there, v_there = axode.convert.to_pinocchio(m, m.neutral(), np.zeros(m.nv))
    >>> q_there[:7]
    array([0., 0., 0., 0., 0., 0., 1.])
    """
    names = None if joints is None else tuple(joints)
    return _layout(m, "Pinocchio", names, not mimic).to_there(q, v)


@overload
def from_mujoco(m: Model, q: ArrayLike, v: ArrayLike, *, joints: Sequence[str] | None = None,
                tolerance: float = 1e-9) -> tuple[Array, Array]: ...
@overload
def from_mujoco(m: Model, q: ArrayLike, v: None = None, *, joints: Sequence[str] | None = None,
                tolerance: float = 1e-9) -> tuple[Array, None]: ...
def from_mujoco(m: Model, q: ArrayLike, v: ArrayLike | None = None, *, joints: Sequence[str] | None = None,
                tolerance: float = 1e-9) -> tuple[Array, Array | None]:
    """Converts qpos and qvel of MuJoCo to (q, v) of axode, (nq,) and (nv,) or (N, nq) and (N, nv). qvel may be None.

    MuJoCo's model is the URDF of m, compiled, or MJCF of the same tree with the same frames of the bodies, in which a
    planar joint is two slides and a hinge. Followers are separate joints: ValueError if one differs from its coupling
    by more than `tolerance`, in rad, m, rad/s and m/s; np.inf ignores them, which may be necessary because MuJoCo's
    equalities are soft.

    `joints` are the names of the joints of m in the order of MuJoCo, if this is not the order of m. KeyError for
    unknown names. ValueError for wrong shapes, for quaternions of free joints whose norm differs from 1 by more than
    1e-6, and for helical joints, which MuJoCo does not have.

    >>> m = axode.load(axode.robots / "humanoid.urdf", base="free")
    >>> qpos = np.zeros(m.nq)
    >>> qpos[:7] = [0.1, 0.2, 0.3, 1, 0, 0, 0]
    >>> q, v = axode.convert.from_mujoco(m, qpos, np.zeros(m.nv))
    >>> q[m.joint("free_base").q]
    array([0. , 0. , 0. , 1. , 0.1, 0.2, 0.3])
    """
    names = None if joints is None else tuple(joints)
    return _layout(m, "MuJoCo", names, True).from_there(q, v, tolerance)


@overload
def to_mujoco(m: Model, q: ArrayLike, v: ArrayLike, *,
              joints: Sequence[str] | None = None) -> tuple[Array, Array]: ...
@overload
def to_mujoco(m: Model, q: ArrayLike, v: None = None, *,
              joints: Sequence[str] | None = None) -> tuple[Array, None]: ...
def to_mujoco(m: Model, q: ArrayLike, v: ArrayLike | None = None, *,
              joints: Sequence[str] | None = None) -> tuple[Array, Array | None]:
    """Converts q and v of axode, (nq,) and (nv,) or (N, nq) and (N, nv), to (qpos, qvel) of MuJoCo. v may be None.

    Arguments and errors are those of `from_mujoco`. Followers get the coordinates and velocities that follow from
    their leaders.

    >>> m = axode.load(axode.robots / "humanoid.urdf", base="free")
    >>> qpos, qvel = axode.convert.to_mujoco(m, m.neutral(), np.zeros(m.nv))
    >>> qpos[:7]
    array([0., 0., 0., 1., 0., 0., 0.])
    """
    names = None if joints is None else tuple(joints)
    return _layout(m, "MuJoCo", names, True).to_there(q, v)


def model_from_mujoco(model: Any, base: Literal["fixed", "free"] | None = None, *,
                      gravity: ArrayLike | None = None, strict: bool = False) -> Model:
    """The mechanism of a compiled model of MuJoCo, a mujoco.MjModel. Everything that is not carried over is reported
    in its warnings.

    Coordinates are MuJoCo's qpos in the order of `to_mujoco`, so that q = 0 need not be qpos0. A body with several
    joints is carried by massless bodies, one for each joint but the last. `load` reads MJCF by this function and has
    the same arguments.

    >>> import mujoco
    >>> geom = '<geom type="box" size="0.1 0.1 0.1"/>'
    >>> there = mujoco.MjModel.from_xml_string(f'<mujoco><worldbody><body name="b"><joint/>{geom}</body></worldbody></mujoco>')
    >>> axode.convert.model_from_mujoco(there).joint_names
    ['b_joint']
    """
    drawing, warnings = mujoco_model.read(model)
    return _load_dict(drawing, "", warnings, base, gravity, strict)


class _Coding:
    """The coding of the numbers of one joint in N states. Number k in the other library is number order[k] of q or v
    in axode."""

    def __init__(self, q_order: Sequence[int], v_order: Sequence[int]):
        self.q_order, self.v_order = list(q_order), list(v_order)
        self.q_back, self.v_back = np.argsort(self.q_order), np.argsort(self.v_order)

    def q_there(self, q: Array) -> Array:
        return q[:, self.q_order]

    def q_here(self, there: Array) -> Array:
        return there[:, self.q_back]

    def v_there(self, q: Array, v: Array) -> Array:
        return v[:, self.v_order]

    def v_here(self, q: Array, there: Array) -> Array:
        return there[:, self.v_back]


class _CosSin(_Coding):
    """The coding of an angle as (cos, sin), which comes after the lengths x and y of a planar joint."""

    def __init__(self, joint: str, lengths: Sequence[int] = ()):
        super().__init__([*lengths, 0, 0], [*lengths, 0])
        self.joint = joint

    def q_there(self, q: Array) -> Array:
        there = super().q_there(q)
        there[:, -2], there[:, -1] = np.cos(q[:, 0]), np.sin(q[:, 0])
        return there

    def q_here(self, there: Array) -> Array:
        c, s = there[:, -2], there[:, -1]
        _check_length(np.hypot(c, s), f'(cos, sin) of joint "{self.joint}"')
        return np.column_stack([np.arctan2(s, c), there[:, :-2]])


class _SlidesAndHinge(_Coding):
    """A planar joint as x, y, angle, one after the other: the axes of x and y do not turn with the angle."""

    def __init__(self) -> None:
        super().__init__([1, 2, 0], [1, 2, 0])

    def v_there(self, q: Array, v: Array) -> Array:
        return super().v_there(q, coordinates.rates(NUMPY, "planar", q, v))

    def v_here(self, q: Array, there: Array) -> Array:
        return np.asarray(coordinates.velocities(NUMPY, "planar", q, super().v_here(q, there)))


class _FreeBody(_Coding):
    """A free joint by the pose of its body, C = A C(q), with the linear velocity in inertial axes."""

    def __init__(self, joint: str, A: Array):
        super().__init__([4, 5, 6, 3, 0, 1, 2], [3, 4, 5, 0, 1, 2])
        self.joint, self.r, self.Q = joint, A[:3, 3], lie.quaternion(A[:3, :3])

    def q_there(self, q: Array) -> Array:
        self._check(q)
        Q = lie.quaternion_product(self.Q, q[:, :4])
        return super().q_there(np.hstack([Q, self.r + coordinates.turned(NUMPY, self.Q, q[:, 4:])]))

    def q_here(self, there: Array) -> Array:
        pose = super().q_here(there)
        self._check(pose)
        Q = lie.quaternion_product(_inverse(self.Q), pose[:, :4])
        return np.hstack([Q, coordinates.turned_back(NUMPY, self.Q, pose[:, 4:] - self.r)])

    def v_there(self, q: Array, v: Array) -> Array:
        Q = lie.quaternion_product(self.Q, q[:, :4])
        return super().v_there(q, np.hstack([v[:, :3], coordinates.turned(NUMPY, Q, v[:, 3:])]))

    def v_here(self, q: Array, there: Array) -> Array:
        Q, v = lie.quaternion_product(self.Q, q[:, :4]), super().v_here(q, there)
        return np.hstack([v[:, :3], coordinates.turned_back(NUMPY, Q, v[:, 3:])])

    def _check(self, pose: Array) -> None:
        _check_length(np.linalg.norm(pose[:, :4], axis=1), f'the quaternion of joint "{self.joint}"')


def _inverse(Q: Array) -> Array:
    return np.asarray(Q * [-1, -1, -1, 1])


def _check_length(length: Array, what: str) -> None:
    off = np.flatnonzero(np.abs(length - 1) > 1e-6)
    if off.size > 0:
        raise ValueError(f"q: {what} has length {length[off[0]]:.9g} in state {off[0]}; expected 1 within 1e-6")


def _check_axes(m: Model, joint: str, body: str, screws: Array, library: str) -> None:
    if not np.allclose(m.body(body).X[:len(screws)], screws, rtol=0, atol=1e-9):
        raise ValueError(f'joint "{joint}": its axes differ from the axes of body "{body}", to which the '
                         f"coordinates of a {m.joint(joint).kind} joint of {library} refer")


def _pinocchio_coding(m: Model, joint: str, body: str) -> _Coding:
    kind = m.joint(joint).kind
    if kind == "revolute" and np.isinf(m.joint(joint).lower[0]) and np.isinf(m.joint(joint).upper[0]):
        return _CosSin(joint)
    if kind in ("revolute", "prismatic"):
        return _Coding([0], [0])
    if kind == "planar":
        _check_axes(m, joint, body, np.eye(6)[:, 2:5], "Pinocchio")
        return _CosSin(joint, [1, 2])
    if kind == "spherical":
        _check_axes(m, joint, body, np.eye(3), "Pinocchio")
        return _Coding(range(4), range(3))
    if kind == "free":
        return _Coding([4, 5, 6, 0, 1, 2, 3], [3, 4, 5, 0, 1, 2])
    raise ValueError(f'joint "{joint}": is {kind}; no URDF, and so no model of Pinocchio\'s from one, has such a joint')


def _mujoco_coding(m: Model, joint: str, body: str) -> _Coding:
    kind = m.joint(joint).kind
    if kind in ("revolute", "prismatic"):
        return _Coding([0], [0])
    if kind == "planar":
        return _SlidesAndHinge()
    if kind == "spherical":
        _check_axes(m, joint, body, np.eye(3), "MuJoCo")
        return _Coding([3, 0, 1, 2], range(3))
    if kind == "free":
        return _FreeBody(joint, m.body(body).A)
    raise ValueError(f'joint "{joint}": is {kind}; MuJoCo has no such joint')


def _sorted_by_name(m: Model) -> list[str]:
    """The joints depth-first, at each link by the names of the joints that it carries, fixed ones included."""
    moved_by = dict(zip(m.body_names, m.joint_names))
    links: dict[str, Any] = {link["name"]: link for link in m.to_dict().get("body", [])}
    carried: dict[str, list[tuple[str, str, list[str]]]] = {}
    for name, link in links.items():
        joints: list[str] = []
        body = name
        while body in moved_by and (body == name or body not in links):  # two bodies for a cylindrical joint
            joints.insert(0, moved_by[body])
            body = m.body(body).predecessor
        joint = link.get("joint")
        fixed = joint.get("name") if isinstance(joint, dict) else None
        carried.setdefault(link["on"], []).append(((joints or [fixed or name + "_joint"])[0], name, joints))
    found: list[str] = []
    ahead = sorted(carried.get("ground", []), reverse=True)
    while ahead:
        _, name, joints = ahead.pop()
        found += joints
        ahead += sorted(carried.get(name, []), reverse=True)
    return found


class _Place(NamedTuple):
    """A joint: the positions of its numbers in axode (those of its leader for a follower) and in the other library."""

    joint: str
    coding: _Coding
    leader: str | None
    ratio: float
    offset: float
    q: slice
    v: slice
    q_there: slice
    v_there: slice


class _Layout:
    """The joints of m as another library has them, with or without its followers."""

    def __init__(self, m: Model, library: str, order: Sequence[str], followers: bool):
        self.places: list[_Place] = []
        self.nq_here, self.nv_here = m.nq, m.nv
        self.nq = self.nv = 0
        self.coordinates = f"{library}'s coordinates"
        self.velocities = f"{library}'s velocities"
        body_of = dict(zip(m.joint_names, m.body_names))
        for name in order:
            leader, ratio, offset = m.joint(name).leader or (None, 1.0, 0.0)
            if leader is not None and not followers:
                continue
            coding = (_pinocchio_coding if library == "Pinocchio" else _mujoco_coding)(m, name, body_of[name])
            nq, nv = self.nq + len(coding.q_order), self.nv + len(coding.v_order)
            own = m.joint(leader or name)
            self.places.append(_Place(name, coding, leader, ratio, offset, own.q, own.v, slice(self.nq, nq),
                                      slice(self.nv, nv)))
            self.nq, self.nv = nq, nv

    def to_there(self, q: ArrayLike, v: ArrayLike | None) -> tuple[Array, Array | None]:
        given = arguments.numbers("q", q, self.nq_here, "nq numbers")
        here, states = np.atleast_2d(given), given.shape[:-1]
        there = np.empty((len(here), self.nq))
        for x in self.places:
            there[:, x.q_there] = x.coding.q_there(x.ratio * here[:, x.q] + x.offset)
        if v is None:
            return there.reshape(*states, self.nq), None
        v_here = np.atleast_2d(arguments.numbers("v", v, self.nv_here, "nv numbers", states))
        v_there = np.empty((len(here), self.nv))
        for x in self.places:
            v_there[:, x.v_there] = x.coding.v_there(here[:, x.q], x.ratio * v_here[:, x.v])
        return there.reshape(*states, self.nq), v_there.reshape(*states, self.nv)

    def from_there(self, q: ArrayLike, v: ArrayLike | None, tolerance: float) -> tuple[Array, Array | None]:
        if not tolerance >= 0:
            raise ValueError(f"tolerance is {tolerance}; expected 0 or more")
        given = arguments.numbers("q", q, self.nq, self.coordinates)
        there, states = np.atleast_2d(given), given.shape[:-1]
        here = np.empty((len(there), self.nq_here))
        own = [x for x in self.places if x.leader is None]
        followers = [x for x in self.places if x.leader is not None]
        for x in own:
            here[:, x.q] = x.coding.q_here(there[:, x.q_there])
        for x in followers:
            off = x.coding.q_here(there[:, x.q_there]) - (x.ratio * here[:, x.q] + x.offset)
            if isinstance(x.coding, _CosSin):  # this coding does not count turns
                off = np.arctan2(np.sin(off), np.cos(off))
            _check_follower("q", x, off, tolerance)
        if v is None:
            return here.reshape(*states, self.nq_here), None
        v_there = np.atleast_2d(arguments.numbers("v", v, self.nv, self.velocities, states))
        v_here = np.empty((len(there), self.nv_here))
        for x in own:
            v_here[:, x.v] = x.coding.v_here(here[:, x.q], v_there[:, x.v_there])
        for x in followers:
            _check_follower("v", x, v_there[:, x.v_there] - x.ratio * v_here[:, x.v], tolerance)
        return here.reshape(*states, self.nq_here), v_here.reshape(*states, self.nv_here)


def _check_follower(name: str, x: _Place, off: Array, tolerance: float) -> None:
    if not np.max(np.abs(off), initial=0) <= tolerance:
        k = int(np.argmax(np.abs(off)))
        raise ValueError(f'{name}: joint "{x.joint}" follows joint "{x.leader}" and differs by '
                         f"{abs(off[k, 0]):.3g} from its coupling in state {k}; "
                         f"the tolerance is {tolerance:g}")


#: The conversions that have been made, as long as their models exist.
_layouts: WeakKeyDictionary[Model, dict[tuple[str, tuple[str, ...] | None, bool], _Layout]] = WeakKeyDictionary()


def _layout(m: Model, library: str, joints: tuple[str, ...] | None, followers: bool) -> _Layout:
    key = library, joints, followers
    if not isinstance(m, Model):
        raise TypeError(f"m: expected an axode.Model, got {type(m).__name__}")
    known = _layouts.setdefault(m, {})
    if key not in known:
        order = joints if joints is not None else tuple(
            _sorted_by_name(m) if library == "Pinocchio" else m.joint_names)
        for name in order:
            m.joint(name)
        if sorted(order) != sorted(m.joint_names):
            wrong = [name for name in m.joint_names if order.count(name) != 1]
            raise ValueError(f"joints: expected every joint of the model once; it is not so for {', '.join(wrong)}")
        known[key] = _Layout(m, library, order, followers)
    return known[key]


signatures.explain_calls(__name__)
