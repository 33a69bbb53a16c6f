"""Displacements of bodies, tools and measuring device as unknowns, and the directions that poses do not show."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .least_squares import in_words
from .measured_poses import MeasuredPart, Measurements
from .redrawing import Drawing, check_tool
from .. import lie
from .._axode import Model, frame_geometry_jacobian

__all__: list[str] = []

Array = NDArray[np.float64]


class Geometry:
    """The present estimate: displacements exp(pi) of bodies and exp(rho) of frames, and the pose of the device."""

    def __init__(self, drawing: Drawing, bodies: Array, tools: dict[str, Array], device: Array):
        self._drawing, self.bodies, self.tools, self.device = drawing, bodies, tools, device
        self.model = drawing.build(bodies, tools)

    def moved(self, unknowns: Unknowns, x: Array) -> Geometry:
        """The estimate displaced by the screws x (p,), each of which is in the frame that it displaces."""
        steps = dict(zip(unknowns.blocks, lie.exp(x.reshape(-1, 6))))
        bodies = self.bodies.copy()
        for k in unknowns.bodies:
            bodies[k] = bodies[k] @ steps["body", k]
        tools = {name: C @ steps["tool", name] if ("tool", name) in steps else C for name, C in self.tools.items()}
        device = self.device @ steps["device", 0] if ("device", 0) in steps else self.device
        return Geometry(self._drawing, bodies, tools, device)


class Unknowns:
    """The p parameters x in blocks of six, and x = T z with scaled parameters z: in z a body is displaced about the
    point of its joint, and lengths are relative to the size of the measured points."""

    def __init__(self, m: Model, data: Measurements, bodies: Sequence[str] | None, tool: bool, device: bool):
        if isinstance(bodies, str):
            raise TypeError(f"bodies is {bodies!r}; expected a list of names of bodies")
        self.drawing = Drawing(m)
        for name in bodies or ():
            if m.body(name).name == "ground":
                raise ValueError('bodies: "ground" has no joint; expected names of moving bodies')
        chosen = _carrying(m, data.frames) if bodies is None else set(bodies)
        for frame in data.frames if tool else []:
            check_tool(m, frame, "measurements")
        self.bodies = [k for k, name in enumerate(m.body_names) if name in chosen]
        self.blocks: list[tuple[str, Any]] = [("body", k) for k in self.bodies]
        self.blocks += [("tool", name) for name in data.frames if tool] + [("device", 0)] * device
        if not self.blocks:
            raise ValueError("bodies, tool, device: they select no parameter to calibrate")
        self.n = 6 * len(self.blocks)
        words: dict[tuple[str, Any], str] = {("body", k): m.body_names[k] for k in self.bodies}
        words |= {("tool", name): f"tool {name}" for name in data.frames} | {("device", 0): "device"}
        self.names = [f"{words[block]} {axis}" for block in self.blocks for axis in ("rx", "ry", "rz", "x", "y", "z")]
        self.size = data.size
        self.drawn = np.repeat([kind != "device" for kind, _ in self.blocks], 6)
        self.T = np.zeros((self.n, self.n))
        for k, (kind, body) in enumerate(self.blocks):
            at_joint = np.eye(4)
            if kind == "body":
                at_joint[:3, 3] = self.drawing.point(m.body_names[body])
            own = slice(6 * k, 6 * k + 6)
            self.T[own, own] = lie.Ad(at_joint) * np.repeat([1, data.size], 3)

    def jacobian(self, geometry: Geometry, part: MeasuredPart, own: slice, C: Array) -> Array:
        """The body-fixed Jacobian (n, 6, p) of the frame relative to the device, where the frame has the poses C (n,
        4, 4)."""
        J = np.zeros((len(C), 6, self.n))
        of_bodies = frame_geometry_jacobian(geometry.model, part.q[own], part.frame)
        for k, (kind, x) in enumerate(self.blocks):
            columns = slice(6 * k, 6 * k + 6)
            if kind == "body":
                J[:, :, columns] = of_bodies[:, :, x]
            elif kind == "device":
                J[:, :, columns] = -lie.Ad(lie.inverse(C))
            elif x == part.frame:
                J[:, :, columns] = np.eye(6)
        return J

    def correction(self, geometry: Geometry) -> tuple[Array, Array]:
        """The whole correction of the drawn geometry as z, which is 0 for the device, and its derivative by a further
        step."""
        x, L = np.zeros(self.n), np.eye(self.n)
        for k, (kind, name) in enumerate(self.blocks):
            if kind != "device":
                own = slice(6 * k, 6 * k + 6)
                x[own] = lie.log(geometry.bodies[name] if kind == "body" else geometry.tools[name])
                L[own, own] = lie.dexp_inv(-x[own])
        z, dz = np.linalg.solve(self.T, x), np.linalg.solve(self.T, L @ self.T)
        return np.asarray(z), np.asarray(dz)

    def _families(self) -> list[list[int]]:
        """The groups of blocks that may share displacements: each block alone, each block with those that depend on
        it, and all blocks."""
        m = self.drawing.m
        own, hangs_on = [], []  # for each block the body that it displaces, and that on which it depends
        for kind, x in self.blocks:
            body = m.body_names[x] if kind == "body" else ""
            own.append("ground" if kind == "device" else body)
            hangs_on.append(m.frame_pose(x)[0] if kind == "tool" else m.body(body).predecessor if body else "")
        alone = [[k] for k in range(len(own))]
        joined = [[k] + [j for j, base in enumerate(hangs_on) if base and base == name] for k, name in enumerate(own)]
        return [*alone, *joined, list(range(len(own)))]

    def directions(self, N: Array) -> tuple[Array, list[str]]:
        """A basis of the directions N z that cannot be identified, beginning with those that few blocks share, and
        their descriptions in words."""
        found: list[Array] = []
        basis = np.zeros((self.n, 0))  # orthonormal basis of the directions found so far
        for family in self._families():
            if len(found) == N.shape[1]:
                break
            columns = (6 * np.array(family)[:, None] + np.arange(6)).ravel()
            others = np.setdiff1d(np.arange(self.n), columns)
            local = N @ _null_space(N[others], 1e-7)
            for z in _tidy(local).T:
                new = z - basis @ (basis.T @ z)
                new -= basis @ (basis.T @ new)
                if np.linalg.norm(new) > 1e-6 * np.linalg.norm(z) and len(found) < N.shape[1]:
                    basis = np.column_stack([basis, new / np.linalg.norm(new)])
                    found.append(self.T @ z)
        words = []
        for k, x in enumerate(found):
            sizes = np.abs(x) / np.tile(np.repeat([1, self.size], 3), len(self.blocks))
            first = int(np.argmax(sizes > 0.999 * sizes.max()))
            found[k] = x / x[first]
            words.append(in_words(np.where(sizes > 0.05 * sizes[first], found[k], 0).round(2), self.names, first))
        return np.array(found).reshape(-1, self.n), words


def _carrying(m: Model, frames: Sequence[str]) -> set[str]:
    """The moving bodies on which the poses of the frames depend."""
    found: set[str] = set()
    for frame in frames:
        body = m.frame_pose(frame)[0]
        while body != "ground" and body not in found:
            found.add(body)
            body = m.body(body).predecessor
    return found


def _null_space(A: Array, tolerance: float) -> Array:
    """Orthonormal columns that A maps to less than the tolerance."""
    if not A.shape[0]:
        return np.eye(A.shape[1])
    _, sigma, Vt = np.linalg.svd(A)
    return np.asarray(Vt[int(np.sum(sigma > tolerance)):].T)


def _tidy(N: Array) -> Array:
    """A basis of the same space in which each column has an entry 1 in a row where all other columns have 0."""
    rows = N.T.copy()
    for k in range(len(rows)):
        j = int(np.argmax(np.abs(rows[k:]).max(axis=0)))
        largest = k + int(np.argmax(np.abs(rows[k:, j])))
        rows[[k, largest]] = rows[[largest, k]]
        rows[k] /= rows[k, j]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, j], rows[k])
    rows[np.abs(rows) < 1e-9] = 0
    return rows.T
