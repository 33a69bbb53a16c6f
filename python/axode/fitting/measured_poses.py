"""Measured poses and positions of frames, and how far a model is from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import least_squares
from .. import lie
from .._axode import Model, poses
from ..support import arguments

if TYPE_CHECKING:
    from .geometric_unknowns import Geometry
    from ..calibration import Measurement

__all__: list[str] = []

Array = NDArray[np.float64]

#: The least standard deviation that a measured pose may have,
#: in rad and relative to the largest measured distance.
NOISE_FLOOR = 1e-11
#: The largest deviation of a measured rotation from an orthonormal matrix.
ROUNDED = 1e-3


class MeasuredPart(NamedTuple):
    """One measurement: poses or positions of one frame."""

    frame: str
    q: Array
    pose: Array | None
    position: Array

    def predicted(self, m: Model, to_device: Array, more: int = 0) -> Iterator[tuple[slice, Array]]:
        """The poses that the model predicts, block by block; `more` numbers will be computed from each of them."""
        for own in least_squares.blocks(len(self.q), 16 * m.n_frames + more):
            yield own, to_device @ poses(m, self.q[own])[:, m.frame_index(self.frame)]


class Measurements:
    """All measurements."""

    def __init__(self, m: Model, measurements: Measurement | Sequence[Measurement]):
        given = [measurements] if isinstance(measurements, Mapping) else measurements
        if isinstance(given, str) or not isinstance(given, Sequence) or not given:
            raise ValueError("measurements: expected a dict with the keys frame, q and pose or position, or a list of "
                             "such dicts")
        self.parts = [_part(m, f"measurements[{k}]", x) for k, x in enumerate(given)]
        self.frames = list(dict.fromkeys(part.frame for part in self.parts))
        points = np.vstack([part.position for part in self.parts])
        self.N = len(points)
        #: The numbers of measured components: of angles and of lengths.
        self.components = np.array([3 * sum(len(x.q) for x in self.parts if x.pose is not None), 3 * self.N])
        #: The length (m) that corresponds to one radian.
        self.size = float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0))**2, axis=1)))) or 1.0
        self.least_noise = NOISE_FLOOR * np.array([1, np.abs(points).max(initial=1)])

    def start(self, m: Model, tool: bool, device: bool) -> tuple[dict[str, Array], Array]:
        """The rotations of the tools and the pose of the device that fit m well, in closed form, as a first guess.

        The rotation of the device follows from the measured points about their centre, and from the measured
        rotations. If the tool is unknown, rotations from one pose to the next, R_k R_{k-1}^T, are used, because the
        tool has no influence on them."""
        expected = [np.concatenate([C for _, C in part.predicted(m, np.eye(4))]) for part in self.parts]
        p = np.vstack([C[:, :3, 3] for C in expected])
        measured = np.vstack([part.position for part in self.parts])
        D, tools = np.eye(4), {name: np.eye(4) for name in self.frames}
        both = [(part.frame, C[:, :3, :3], part.pose[:, :3, :3]) for C, part in zip(expected, self.parts)
                if part.pose is not None]
        if device:
            P = (p - p.mean(axis=0)).T @ (measured - measured.mean(axis=0)) / self.size**2
            for _, R, R_measured in both:
                P += _turns(R).T @ _turns(R_measured) if tool else np.einsum("nij,nkj->ik", R, R_measured)
            D[:3, :3] = _nearest_rotation(P)
            D[:3, 3] = p.mean(axis=0) - D[:3, :3] @ measured.mean(axis=0)
        if tool:
            for name in {name for name, _, _ in both}:
                sums = [np.einsum("nji,jk,nkl->il", R, D[:3, :3], R_measured) for x, R, R_measured in both if x == name]
                tools[name][:3, :3] = _nearest_rotation(np.sum(sums, axis=0))
        return tools, D

    def residuals(self, geometry: Geometry) -> list[Array]:
        """Residuals of each part: log((D^-1 C)^-1 C_measured), (N, 6), or differences of positions, (N, 3)."""
        r = []
        for part in self.parts:
            predicted = part.predicted(geometry.model, lie.inverse(geometry.device))
            r.append(np.concatenate([part.position[own] - C[:, :3, 3] if part.pose is None
                                     else lie.log(lie.inverse(C) @ part.pose[own]) for own, C in predicted]))
        return r

    def rms(self, r: list[Array]) -> Array:
        """Root mean square of the angles and of the distances."""
        squares = squares_of(r)
        return np.array([np.sqrt(3 * x.sum() / n) if n else np.nan for x, n in zip(squares, self.components)])


def _turns(R: Array) -> Array:
    """Axis times sine of the angle of the rotations between successive measurements, (N - 1, 3). It is continuous at
    every angle."""
    turn = R[1:] @ R[:-1].swapaxes(1, 2)
    return np.asarray(lie.from_skew((turn - turn.swapaxes(1, 2)) / 2))


def squares_of(r: list[Array]) -> tuple[Array, Array]:
    """Squared norms of all angular and of all linear residuals."""
    angular = [np.sum(x[:, :3]**2, axis=1) for x in r if x.shape[1] == 6]
    return np.concatenate([np.zeros(0), *angular]), np.concatenate([np.sum(x[:, -3:]**2, axis=1) for x in r])


def _part(m: Model, argument: str, given: Any) -> MeasuredPart:
    """The measurement, checked. KeyError for wrong keys and unknown frames, ValueError for wrong values."""
    if not isinstance(given, Mapping):
        raise ValueError(f"{argument}: expected a dict, got {type(given).__name__}")
    for key in given:
        if key not in ("frame", "q", "pose", "position"):
            raise KeyError(f"{argument}: a key is {key!r}; expected one of 'frame', 'q', 'pose', 'position'")
    for key in ("frame", "q"):
        if key not in given:
            raise KeyError(f"{argument}: has no key {key!r}")
    if ("pose" in given) == ("position" in given):
        raise KeyError(f"{argument}: expected one of the keys 'pose' and 'position'")
    frame = m.frame_names[m.frame_index(given["frame"])]
    q = arguments.configurations(f"{argument}.q", given["q"], m.nq, "configuration")
    if "pose" in given:
        C = exact_poses(f"{argument}.pose", given["pose"], (len(q), 4, 4))
        return MeasuredPart(frame, q, C, C[:, :3, 3])
    shape = (len(q), 3)
    position = arguments.shaped(f"{argument}.position", given["position"], shape, f"{shape}, as q has")
    return MeasuredPart(frame, q, None, position)


def exact_poses(argument: str, given: ArrayLike, shape: tuple[int, ...]) -> Array:
    """The poses with their rotations replaced by the nearest exact ones."""
    C = arguments.shaped(argument, given, shape, f"{shape}, poses").copy()
    R = _nearest_rotation(C[..., :3, :3])
    off = np.maximum(np.abs(R - C[..., :3, :3]).max(axis=(-2, -1)), np.abs(C[..., 3, :] - [0, 0, 0, 1]).max(axis=-1))
    if np.any(off > ROUNDED):
        k = int(np.argmax(off > ROUNDED)) if off.ndim else None
        raise ValueError(f"{argument}{'' if k is None else f'[{k}]'}: expected a pose, a matrix of a rotation and an "
                         f"origin with (0, 0, 0, 1) as its last row; it is off by {np.atleast_1d(off)[k or 0]:.3g}, "
                         f"and {ROUNDED} is made exact")
    C[..., :3, :3] = R
    C[..., 3, :] = [0, 0, 0, 1]
    return np.asarray(C)


def _nearest_rotation(A: Array) -> Array:
    U, _, Vt = np.linalg.svd(A)
    U[..., :, 2] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    return np.asarray(U @ Vt)
