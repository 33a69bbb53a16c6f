"""Identification of geometric parameters from measured poses: the true positions of the joints of a real mechanism.

Section 6.2 of the paper: B_i is replaced by B_i exp(pi_i), six parameters for each body. Frames of the mechanism have
the poses C_f = C_b O exp(rho), O the drawn pose of the frame on its last body and rho the error of the tool; a device
whose own frame has the pose D measures D^-1 C_f, or only the position of its origin. `calibrate` finds all these
parameters from many measured poses: the residuals are log((D^-1 C_f)^-1 C_measured), their Jacobian is exact
(`frame_geometry_jacobian`), and the steps are those of Levenberg and Marquardt on SE(3). There are no Euler angles,
and parallel axes cause no singularity.

Six parameters for each joint are more than poses can determine: a displacement of body i along its own joint has the
same effect as one of its successor, in 2 parameters of a hinge or a screw, and in 4 of a slider. Measured poses of a
serial arm in general position determine 4 parameters for each hinge, 2 for each slider, and 6 more. Directions that
cannot be determined are found and reported, and the correction is the smallest one that explains the poses, unless a
`prior` says how well the drawing is known. An offset of a joint coordinate is a displacement along the joint, which
pi contains already. Displacements that the device shares with the first joints are attributed to the device.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import lie
from .support import signatures
from ._axode import Model, frame_geometry_jacobian, poses
from .convert import _array, _finite, _numbers
from .identification import _in_words, _links_of_bodies, _triangle

__all__ = ["Calibration", "Measurement", "calibrate", "with_geometry"]

Array = NDArray[np.float64]

#: Singular values below this part of the largest one count as rounding errors.
RANK_TOLERANCE = 1e-10
#: The least standard deviation that a measured pose may have, in rad and relative to the largest measured distance.
NOISE_FLOOR = 1e-11
#: The largest ratio between the noise of angles and that of lengths, relative to the size of the measured points.
NOISE_RATIO = 1e-4
#: Huber's threshold for the norm of three components in standard deviations: 95 % efficient without outliers.
HUBER = 1.7
#: The median of this norm if there are no outliers.
MEDIAN = 1.5382
#: The largest deviation of a measured rotation from an orthonormal matrix.
ROUNDED = 1e-3
#: The largest number of entries of the Jacobian that are in memory at once.
BLOCK = 1 << 20


class _MeasurementNeeds(TypedDict):
    frame: str | int
    q: ArrayLike


class Measurement(_MeasurementNeeds, total=False):
    """Measurements of a frame in N configurations q (N, nq): `pose` (N, 4, 4) or `position` (N, 3), in m.

    Both are in the frame of the measuring device, which is the inertial frame if `calibrate` is called with
    device=False. A Measurement is a dict.

    >>> measured = axode.calibration.Measurement(frame="flange", q=np.zeros((1, 7)), position=[[0, 0, 1.306]])
    >>> measured["frame"]
    'flange'
    """

    pose: ArrayLike
    position: ArrayLike


class Calibration(NamedTuple):
    """Result of `calibrate`. There are p parameters: six of each calibrated body, six of each measured frame, and six
    of the device."""

    model: Model
    """m with the geometry found, the poses of measured frames on their bodies included."""
    parameters: Array
    """(n_bodies, 6): pi_i in the order of `m.body_names`, angles (rad) before lengths (m), 0 where not calibrated."""
    tools: dict[str, Array]
    """Of each measured frame exp(rho), its pose (4, 4) in the one that is drawn."""
    device: Array
    """(4, 4): the pose of the device in the inertial frame."""
    parameter_names: list[str]
    """(p) of what was calibrated: `link 1 rx`, ..., `link 1 z`, `tool flange rx`, ..., `device z`."""
    covariance: Array
    """(p, p), of small displacements, angular before linear, in the axes of the frames found: B exp(pi) exp(error)."""
    deviations: Array
    """(p,) standard deviations, the roots of its diagonal. They are those of the smallest correction, to which what
    cannot be identified contributes nothing, or with a prior those of what is known after the measurement."""
    rank: int
    """The number of combinations of parameters that the measured poses show, without any prior."""
    unidentifiable: Array
    """(p - rank, p): a basis of the small displacements that change no measured pose."""
    unidentifiable_names: list[str]
    """Its rows in words, `link 1 rz - link 2 rz`, rounded: terms below 5 % are left out."""
    condition: float
    """Condition number of the weighted Jacobian on what it shows, lengths in parts of the size of what was measured."""
    noise: Array
    """(2,) standard deviations of each component, rad and m, as given or as estimated. nan for rad without poses."""
    residual: Array
    """(2,) root mean square of angles (rad) and distances (m) between measured poses and those of `model`."""
    residual_before: Array
    """(2,) the same for m, where what is sought of the device's pose and of tools' rotations is roughly so."""
    iterations: int
    """How often the equations were linearised."""
    converged: bool
    """Whether the steps and the noise came to an end."""


def calibrate(m: Model, measurements: Measurement | Sequence[Measurement], *, bodies: Sequence[str] | None = None,
              tool: bool = True, device: bool = True, noise: ArrayLike | None = None, prior: ArrayLike | None = None,
              robust: bool = False) -> Calibration:
    """Identifies the geometry of m from measured poses or positions of frames: a `Measurement`, or a list of them.

    Begin with about 3 to 5 poses for each unknown combination, spread over the whole workspace. One frame may be
    measured in several parts, and several frames by one device.

    bodies: names of the bodies whose six parameters are identified; if left out, all bodies that carry a measured
        frame. The two bodies of a cylindrical or universal joint have separate parameters: the resulting model has
        two joints with the same names.
    tool: whether the pose of each measured frame on its body is identified; with False it is that of m. ValueError if
        the frame is that of a moving body itself, because this has no pose of its own.
    device: whether the pose of the device is identified, wherever the device is; with False its frame is the inertial
        frame.
    noise: standard deviations (rad, m) of each component of a measured pose; if left out, they are estimated.
    prior: standard deviations (rad, m) of the joints and tools in the drawing, about the point of each joint. If it
        is left out, directions that the poses do not determine get the smallest correction.
    robust: whether outliers count by their size instead of its square (Huber), separately for angles and positions.

    Measured rotations may differ from orthonormal matrices by 1e-3 and are replaced by the nearest rotation. Device
    and tool may be turned by any angle; the method converges for errors of joints of up to ten degrees and a
    decimetre. O(N p^2) for each of about 20 iterations; memory grows with N only by arrays as large as the poses.
    ValueError for wrong shapes, numbers that are not finite, matrices that are not poses and too few measurements;
    KeyError for unknown names and keys.

    >>> random = np.random.default_rng(0)
    >>> built = axode.calibration.with_geometry(arm, random.normal(0, 0.01, (7, 6)))  # some 0.6 degrees and 10 mm
    >>> q = arm.random(n=60)
    >>> C = axode.poses(built, q)[:, arm.frame_index("flange")] @ axode.lie.exp(random.normal(0, 1e-4, (60, 6)))
    >>> found = axode.calibration.calibrate(arm, {"frame": "flange", "q": q, "pose": C})
    >>> found.rank, found.residual_before.round(3), found.residual.round(4), found.noise.round(4)
    (34, array([0.033, 0.042]), array([0.0002, 0.0002]), array([0.0001, 0.0001]))
    >>> found.unidentifiable_names[0]
    'link 1 z - link 2 z'
    """
    data = _Data(m, measurements)
    unknowns = _Unknowns(m, data, bodies, tool, device)
    given = None if noise is None else _deviations("noise", noise)
    fit = _Fit(data, unknowns, given, None if prior is None else _deviations("prior", prior), robust)
    covariance = fit.covariance()
    unidentifiable, words = unknowns.directions(fit)
    return Calibration(
        model=fit.geometry.model,
        parameters=lie.log(fit.geometry.bodies),
        tools=fit.geometry.tools,
        device=fit.geometry.device,
        parameter_names=unknowns.names,
        covariance=covariance,
        deviations=np.sqrt(np.diagonal(covariance)),
        rank=fit.rank,
        unidentifiable=unidentifiable,
        unidentifiable_names=words,
        condition=fit.condition,
        noise=fit.noise,
        residual=fit.residual,
        residual_before=fit.residual_before,
        iterations=fit.iterations,
        converged=fit.converged,
    )


def with_geometry(m: Model, parameters: ArrayLike, tools: Mapping[str, ArrayLike] | None = None) -> Model:
    """The model m with B_i exp(pi_i) instead of B_i, for `parameters` pi (n_bodies, 6), rad and m, and with displaced
    tools.

    `tools` has, by the name of a frame, the pose exp(rho) (4, 4) by which the frame is displaced on its body.
    Everything else stays the same: joint screws and inertias in the frames of the bodies, names, limits, losses,
    couplings, other frames. Cylindrical and universal joints become the two joints of which they consist. The
    derivatives by pi at 0 are `frame_geometry_jacobian`. ValueError for wrong shapes and for tools that are frames of
    moving bodies; KeyError for unknown frames.

    >>> pi = np.zeros((7, 6))
    >>> pi[3, 3] = 0.002  # the elbow is 2 mm further in x
    >>> built = axode.calibration.with_geometry(arm, pi)
    >>> axode.poses(built, arm.neutral())[arm.frame_index("flange"), :3, 3].round(4)
    array([0.002, 0.   , 1.306])
    """
    pi = _rows("parameters", parameters, (m.n_bodies, 6), "(n_bodies, 6), six for each body")
    own = {name: _poses(f"tools[{name!r}]", C, (4, 4)) for name, C in (tools or {}).items()}
    for name in own:
        _check_tool(m, m.frame_names[m.frame_index(name)], f"tools[{name!r}]")
    return _Drawing(m).build(lie.exp(pi), own)


def _check_tool(m: Model, name: str, argument: str) -> None:
    if name == "ground" or name in m.body_names:
        raise ValueError(f'{argument}: frame "{name}" is that of a body; only frames that are fixed to one can be '
                         "displaced on it: expected such a frame, or tool=False")


class _Drawing:
    """The mechanism m as links whose poses are relative to their predecessors, so that each link can be displaced
    separately."""

    def __init__(self, m: Model):
        self.m = m
        self._drawing = m.to_dict()
        self._link = _links_of_bodies(m, self._drawing)
        #: For each link and frame: the moving body to which it belongs, and its pose on this body.
        self._on = {name: m.frame_pose(name) for name in m.frame_names}
        self._B = np.array([m.body(name).B for name in m.body_names]).reshape(-1, 4, 4)

    def build(self, displaced: Array, tools: Mapping[str, Array]) -> Model:
        """Builds the model with displaced B (n_bodies, 4, 4) and displaced frames."""
        m = self.m
        on = {name: (body, O @ tools[name] if name in tools else O) for name, (body, O) in self._on.items()}
        bodies: list[dict[str, Any]] = []
        at = dict(zip(m.body_names, zip(m.joints, self._B @ displaced)))
        for drawn in self._drawing["body"]:
            name = drawn["name"]
            link = {key: value for key, value in drawn.items() if key not in PLACING}
            link |= _matter(drawn, lie.inverse(self._A(name) @ on[name][1]))
            if name not in at:
                base = lie.inverse(on[drawn["on"]][1])
                bodies.append(link | {"on": drawn["on"], "joint": drawn["joint"], "B": _as_dict(base @ on[name][1])})
                continue
            joints = _single_joints(drawn["joint"])
            chain = [m.body(name).predecessor, name][-len(joints):]
            predecessor, base = drawn["on"], lie.inverse(on[drawn["on"]][1])
            for body, joint in zip(chain, joints):
                of_model, B = at[body]
                S = m.body(body).S_self
                bodies.append((link if body == name else {}) | {
                    "name": body, "on": predecessor, "S_prev": _as_dict(base @ B @ S), "S_self": _as_dict(S),
                    "joint": joint | {"name": of_model.name, "kind": of_model.kind}})
                predecessor, base = body, np.eye(4)
        frames = [{"name": frame["name"], "on": frame["on"], "in": "body",
                   **_as_dict(lie.inverse(on[frame["on"]][1]) @ on[frame["name"]][1])}
                  for frame in self._drawing.get("frame", [])]
        return Model.from_dict(self._drawing | {"body": bodies, "frame": frames})

    def _A(self, name: str) -> Array:
        """The pose, in the construction frame, of the body to which a link or frame belongs."""
        body = self._on[name][0]
        return np.asarray(self.m.body(body).A) if body != "ground" else np.eye(4)

    def point(self, name: str) -> Array:
        """A point on the joint of a body, in the frame of the body."""
        link = self._link[name]
        if "S_self" in link:
            return np.asarray(link["S_self"].get("position", np.zeros(3)))
        joint = link["joint"]
        if isinstance(joint, str) or "point" not in joint:
            return np.zeros(3)
        return np.asarray((lie.inverse(self._A(name)) @ [*joint["point"], 1])[:3])


#: The keys of a drawing that determine the pose of a link, and those of its mass and inertia.
PLACING = {"A", "B", "S_prev", "S_self", "frame", "joint", "on", "com", "inertia", "inertia_about", "inertia_in",
           "inertia_axes"}


def _single_joints(joint: dict[str, Any] | str) -> list[dict[str, Any]]:
    """A drawn joint without its position, or the two joints of which a cylindrical or universal joint consists."""
    if isinstance(joint, str):
        return [{}]
    if joint["kind"] in ("cylindrical", "universal"):
        return [dict(dof) for dof in joint.get("dof", [{}, {}])]
    return [{key: value for key, value in joint.items() if key not in ("axis", "second_axis", "point")}]


def _matter(link: dict[str, Any], C: Array) -> dict[str, Any]:
    """Centre of mass and inertia of a link in its own frame; C maps construction coordinates to coordinates of the
    link."""
    if "inertia" not in link:
        return {}
    if "S_self" in link and link.get("inertia_in") != "construction":
        C = np.eye(4)
    com = (C @ [*link["com"], 1])[:3]
    axes = C[:3, :3] @ link.get("inertia_axes", {}).get("rotation", np.eye(3))
    xx, yy, zz, xy, xz, yz = link["inertia"]
    Theta = axes @ [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] @ axes.T
    if link.get("inertia_about") == "origin":
        r = com - C[:3, 3]
        Theta -= link["mass"] * (r @ r * np.eye(3) - np.outer(r, r))
    return {"com": com.tolist(), "inertia": Theta.tolist()}


def _as_dict(C: Array) -> dict[str, Any]:
    return {"position": C[:3, 3].tolist(), "rotation": C[:3, :3].tolist()}


class _Part(NamedTuple):
    """One measurement: poses or positions of one frame."""

    frame: str
    q: Array
    pose: Array | None
    position: Array


class _Data:
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
        expected = [np.concatenate([C for _, C in _predicted(m, part, np.eye(4))]) for part in self.parts]
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

    def residuals(self, geometry: _Geometry) -> list[Array]:
        """Residuals of each part: log((D^-1 C)^-1 C_measured), (N, 6), or differences of positions, (N, 3)."""
        r = []
        for part in self.parts:
            blocks = []
            for own, C in _predicted(geometry.model, part, lie.inverse(geometry.device)):
                if part.pose is not None:
                    blocks.append(lie.log(lie.inverse(C) @ part.pose[own]))
                else:
                    blocks.append(part.position[own] - C[:, :3, 3])
            r.append(np.concatenate(blocks))
        return r

    def rms(self, r: list[Array]) -> Array:
        """Root mean square of the angles and of the distances."""
        squares = _squares(r)
        return np.array([np.sqrt(3 * x.sum() / n) if n else np.nan for x, n in zip(squares, self.components)])


def _predicted(m: Model, part: _Part, to_device: Array) -> Iterator[tuple[slice, Array]]:
    """The measurements that the model predicts with these parameters, block by block."""
    block = max(BLOCK // (16 * m.n_frames), 1)
    for start in range(0, len(part.q), block):
        own = slice(start, start + block)
        yield own, to_device @ poses(m, part.q[own])[:, m.frame_index(part.frame)]


def _turns(R: Array) -> Array:
    """Axis times sine of the angle of the rotations between successive measurements, (N - 1, 3); continuous at every angle."""
    turn = R[1:] @ R[:-1].swapaxes(1, 2)
    return np.asarray(lie.from_skew((turn - turn.swapaxes(1, 2)) / 2))


def _squares(r: list[Array]) -> tuple[Array, Array]:
    """Squared norms of all angular and of all linear residuals."""
    angular = [np.sum(x[:, :3]**2, axis=1) for x in r if x.shape[1] == 6]
    return np.concatenate([np.zeros(0), *angular]), np.concatenate([np.sum(x[:, -3:]**2, axis=1) for x in r])


class _Geometry:
    """The present estimate: displacements exp(pi) of bodies and exp(rho) of frames, and the pose of the device."""

    def __init__(self, drawing: _Drawing, bodies: Array, tools: dict[str, Array], device: Array):
        self._drawing, self.bodies, self.tools, self.device = drawing, bodies, tools, device
        self.model = drawing.build(bodies, tools)

    def moved(self, unknowns: _Unknowns, x: Array) -> _Geometry:
        """The estimate displaced by the screws x (p,), each of which is in the frame that it displaces."""
        steps = dict(zip(unknowns.blocks, lie.exp(x.reshape(-1, 6))))
        bodies = self.bodies.copy()
        for k in unknowns.bodies:
            bodies[k] = bodies[k] @ steps["body", k]
        tools = {name: C @ steps["tool", name] if ("tool", name) in steps else C for name, C in self.tools.items()}
        device = self.device @ steps["device", 0] if ("device", 0) in steps else self.device
        return _Geometry(self._drawing, bodies, tools, device)


class _Unknowns:
    """The p parameters x in blocks of six, and x = T z with scaled parameters z: in z a body is displaced about the
    point of its joint, and lengths are relative to the size of the measured points."""

    def __init__(self, m: Model, data: _Data, bodies: Sequence[str] | None, tool: bool, device: bool):
        if isinstance(bodies, str):
            raise TypeError(f"bodies is {bodies!r}; expected a list of names of bodies")
        self.drawing = _Drawing(m)
        predecessor = {name: m.body(name).predecessor for name in m.body_names}
        moved_by: set[str] = set()
        for frame in data.frames:
            body = m.frame_pose(frame)[0]
            while body != "ground" and body not in moved_by:
                moved_by.add(body)
                body = predecessor[body]
        for name in bodies or ():
            if m.body(name).name == "ground":
                raise ValueError('bodies: "ground" has no joint; expected names of moving bodies')
        chosen = moved_by if bodies is None else set(bodies)
        if tool:
            for frame in data.frames:
                _check_tool(m, frame, "measurements")
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
        #: The groups of blocks that may share displacements: each block alone, and each block with those that depend
        #: on it.
        self.families = [[k] for k in range(len(self.blocks))]
        hangs_on = [m.frame_pose(x)[0] if kind == "tool" else predecessor[m.body_names[x]] if kind == "body" else ""
                    for kind, x in self.blocks]
        for k, (kind, x) in enumerate(self.blocks):
            name = {"device": "ground", "body": m.body_names[x] if kind == "body" else "", "tool": ""}[kind]
            self.families.append([k] + [j for j, base in enumerate(hangs_on) if base == name])

    def jacobian(self, geometry: _Geometry, part: _Part, own: slice, C: Array) -> Array:
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

    def correction(self, geometry: _Geometry) -> tuple[Array, Array]:
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

    def directions(self, fit: _Fit) -> tuple[Array, list[str]]:
        """A basis of the directions that cannot be identified, beginning with those that few blocks share, and their
        descriptions in words."""
        N = fit.null_space
        found: list[Array] = []
        basis = np.zeros((self.n, 0))  # orthonormal basis of the directions found so far
        rest = [list(range(len(self.blocks)))]
        for family in self.families + rest:
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
            words.append(_in_words(np.where(sizes > 0.05 * sizes[first], found[k], 0).round(2), self.names, first))
        return np.array(found).reshape(-1, self.n), words


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


class _Fit:
    """The geometry that minimises the weighted squares, or Huber's function, of the residuals and of the prior."""

    def __init__(self, data: _Data, unknowns: _Unknowns, given: Array | None, prior: Array | None, robust: bool):
        self._data, self._unknowns, self._robust = data, unknowns, robust
        self._P = np.zeros(unknowns.n)  # weights of z
        if prior is not None:
            weights = np.tile(np.repeat([1, unknowns.size] / prior, 3), len(unknowns.blocks))
            self._P = np.where(unknowns.drawn, weights, 0)
        self._has_prior = prior is not None
        m = unknowns.drawing.m
        sought = {kind for kind, _ in unknowns.blocks}
        start = data.start(m, "tool" in sought, "device" in sought)
        self.geometry = _Geometry(unknowns.drawing, np.tile(np.eye(4), (m.n_bodies, 1, 1)), *start)
        self._r = data.residuals(self.geometry)
        self.residual_before = data.rms(self._r)
        self.iterations = 0
        balanced = np.array([1, data.size])
        self.noise = balanced * np.nanmax(self._estimated(np.zeros(2)) / balanced) if given is None else given
        for _ in range(50):
            minimised = self._minimise()
            self.converged = self._slide() and minimised
            if given is not None:
                break
            before = self.noise
            self.noise = self._estimated(self._spent())
            if np.all(np.abs(np.log(self.noise / before)[data.components > 0]) < 1e-3):
                break
        else:
            self.converged = False
        self._finish()

    # ---------------------------------------------------------------- the equations, linearised

    def _factors(self, weighted: bool) -> list[Array]:
        """The factors R of [J, r] = Q R for angles and for lengths, in z, with or without Huber's weights."""
        self.iterations += 1
        data, unknowns = self._data, self._unknowns
        R = [np.zeros((0, unknowns.n + 1)) for _ in range(2)]
        to_device = lie.inverse(self.geometry.device)
        for part, r in zip(data.parts, self._r):
            block = max(BLOCK // (12 * (unknowns.n + self.geometry.model.n_frames)), 1)
            for start in range(0, len(r), block):
                own = slice(start, start + block)
                e = r[own]
                C = to_device @ poses(self.geometry.model, part.q[own])[:, self.geometry.model.frame_index(part.frame)]
                J = unknowns.jacobian(self.geometry, part, own, C)
                J = C[:, :3, :3] @ J[:, 3:] if part.pose is None else lie.dexp_inv(e) @ J
                for k in range(2):
                    rows, e_k = (J[:, -3:], e[:, -3:]) if k else (J[:, :-3], e[:, :-3])
                    both = np.concatenate([rows, e_k[:, :, None]], axis=2)
                    if weighted and self._robust:
                        u = np.linalg.norm(e_k, axis=1) / self.noise[k]
                        both *= np.sqrt(HUBER / np.maximum(u, HUBER))[:, None, None]
                    R[k] = _triangle(np.vstack([R[k], both.reshape(-1, unknowns.n + 1)]))
        for R_k in R:
            R_k[:, :-1] = R_k[:, :-1] @ unknowns.T
        return R

    def _system(self) -> tuple[Array, Array]:
        """S and c of the measurements: near the present estimate the cost is |S dz - c|^2, plus the cost of the
        prior."""
        S, c = self._compress(self._factors(weighted=True), self.noise)
        if not self._has_prior:
            return S, c
        z, L = self._unknowns.correction(self.geometry)
        return np.vstack([S, self._P[:, None] * L]), np.append(c, -self._P * z)

    def _compress(self, factors: list[Array], noise: Array) -> tuple[Array, Array]:
        """Computes S and c of the measurements, and finds the directions that they determine."""
        R = _triangle(np.vstack([R_k / s for R_k, s in zip(factors, noise) if len(R_k)]))
        self._S = R[:, :-1]
        _, sigma, Vt = np.linalg.svd(self._S)
        self.rank = int(np.sum(sigma > RANK_TOLERANCE * sigma[0])) if sigma[0] > 0 else 0
        if not self.rank:
            raise ValueError("measurements: none of the poses depends on the parameters to calibrate")
        self.condition = float(sigma[0] / sigma[self.rank - 1])
        self.null_space = Vt[self.rank:].T
        return self._S, R[:, -1]

    def _cost(self, r: list[Array], geometry: _Geometry) -> float:
        cost = 0.0
        for squares, s in zip(_squares(r), self.noise):
            u = np.sqrt(squares) / s
            inside = np.minimum(u, HUBER) if self._robust else u
            cost += float(np.sum(inside * (2 * u - inside)))
        if self._has_prior:
            cost += float(np.sum((self._P * self._unknowns.correction(geometry)[0])**2))
        return cost

    # ---------------------------------------------------------------- steps

    def _minimise(self) -> bool:
        """Takes the steps of Levenberg and Marquardt from the present geometry. Returns whether they converged."""
        damping, cost = 1e-6, self._cost(self._r, self.geometry)
        for _ in range(100):
            S, c = self._system()
            U, sigma, Vt = np.linalg.svd(S, full_matrices=False)
            kept = sigma > RANK_TOLERANCE * sigma[0]
            g, sigma, Vt = (U.T @ c)[kept], sigma[kept], Vt[kept]
            last = g @ g < 1e-6  # the step is less than a thousandth of the standard deviations
            while True:
                filtered = sigma / (sigma**2 + (0 if last else damping) * sigma[0]**2)
                geometry = self.geometry.moved(self._unknowns, self._unknowns.T @ (Vt.T @ (filtered * g)))
                r = self._data.residuals(geometry)
                reached = self._cost(r, geometry)
                if last or reached < cost:
                    break
                damping = max(10 * damping, 1e-10)
                if damping > 1e10:
                    return False
            self.geometry, self._r, cost, damping = geometry, r, reached, damping / 10
            if last:
                return True
        return False

    def _slide(self) -> bool:
        """Moves along the directions that cannot be identified to the smallest correction, while Gauss-Newton steps
        keep the poses. Returns whether this converged."""
        if self._has_prior:
            return True
        for _ in range(50):
            S, c = self._system()
            if not self.null_space.shape[1]:
                return True
            U, sigma, Vt = np.linalg.svd(S, full_matrices=False)
            dz = Vt[:self.rank].T @ ((U.T @ c)[:self.rank] / sigma[:self.rank])
            z, _ = self._unknowns.correction(self.geometry)
            slide = -self.null_space @ (self._to_smallest() @ (z + self._unknowns.drawn * dz))
            self.geometry = self.geometry.moved(self._unknowns, self._unknowns.T @ (dz + slide))
            self._r = self._data.residuals(self.geometry)
            if np.abs(slide).max() < 1e-6:
                return True
        return False

    def _to_smallest(self) -> Array:
        """Computes Y for which z - N Y z is the smallest correction of the drawn geometry."""
        drawn = self._unknowns.drawn
        return np.asarray(np.linalg.pinv(drawn[:, None] * self.null_space, rcond=1e-6) * drawn)

    # ---------------------------------------------------------------- noise and covariance

    def _spent(self) -> Array:
        """Number of degrees of freedom of angles and of lengths that the parameters use."""
        root = self._covariance_root()
        spent = [np.linalg.norm(R_k[:, :-1] @ root / s)**2 for R_k, s in zip(self._factors(weighted=False), self.noise)]
        free = self._data.components - spent
        if np.any((free < 0.5) & (self._data.components > 0)):
            raise ValueError(f"measurements: {self._data.N} are too few for {self.rank} parameters and the noise; "
                             "expected more of them, or noise")
        return np.asarray(spent)

    def _estimated(self, spent: Array) -> Array:
        noise = np.full(2, np.nan)
        for k, squares in enumerate(_squares(self._r)):
            if n := self._data.components[k]:
                mean = np.median(squares) / MEDIAN**2 if self._robust else squares.sum() / n
                noise[k] = np.sqrt(mean * n / (n - spent[k]))
        largest = np.nanmax(noise / [1, self._data.size])
        least = np.maximum(self._data.least_noise, NOISE_RATIO * largest * np.array([1, self._data.size]))
        return np.asarray(np.maximum(noise, least))

    def _covariance_root(self) -> Array:
        """A root B of the covariance B B^T of z."""
        S = self._S
        if self._has_prior:
            S = np.vstack([S, self._P[:, None] * self._unknowns.correction(self.geometry)[1]])
        _, sigma, Vt = np.linalg.svd(S)
        rank = int(np.sum(sigma > RANK_TOLERANCE * sigma[0]))
        B = Vt[:rank].T / sigma[:rank]
        if not self._has_prior:
            B = B - self.null_space @ (self._to_smallest() @ B)
        return np.asarray(B)

    def _finish(self) -> None:
        """The final estimate without Huber's weights, with the effective noise after weighting."""
        data = self._data
        effective = self.noise.copy()
        if self._robust:
            for k, squares in enumerate(_squares(self._r)):
                if len(squares):
                    u = np.sqrt(squares) / self.noise[k]
                    slope = np.mean(np.where(u <= HUBER, 1, 2 / 3 * HUBER / np.maximum(u, HUBER)))
                    effective[k] *= np.sqrt(np.mean(np.minimum(u, HUBER)**2) / 3) / slope
        effective = np.maximum(effective, data.least_noise)
        self._compress(self._factors(weighted=False), effective)
        self.residual = data.rms(self._r)

    def covariance(self) -> Array:
        """The covariance (p, p) of x."""
        B = self._unknowns.T @ self._covariance_root()
        return np.asarray(B @ B.T)


def _part(m: Model, argument: str, given: Any) -> _Part:
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
    q = _numbers(f"{argument}.q", given["q"], m.nq, "nq numbers")
    if q.ndim != 2 or not len(q):
        raise ValueError(f"{argument}.q: expected shape (N, {m.nq}), nq numbers of each configuration, got {q.shape}")
    if "pose" in given:
        C = _poses(f"{argument}.pose", given["pose"], (len(q), 4, 4))
        return _Part(frame, q, C, C[:, :3, 3])
    expected = (len(q), 3)
    return _Part(frame, q, None, _rows(f"{argument}.position", given["position"], expected, f"{expected}, as q has"))


def _rows(argument: str, given: ArrayLike, shape: tuple[int, ...], meaning: str) -> Array:
    """The argument as an array of finite numbers with this shape."""
    x = _array(argument, given)
    if x.shape != shape:
        raise ValueError(f"{argument}: expected shape {meaning}, got {x.shape}")
    return _finite(argument, x)


def _poses(argument: str, given: ArrayLike, shape: tuple[int, ...]) -> Array:
    """The poses with their rotations replaced by the nearest exact ones."""
    C = _rows(argument, given, shape, f"{shape}, poses").copy()
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


def _deviations(argument: str, given: ArrayLike) -> Array:
    x = _rows(argument, given, (2,), "(2,), standard deviations in rad and m")
    if not np.all(x > 0):
        raise ValueError(f"{argument} is {x.tolist()}; expected standard deviations in rad and m, more than 0")
    return x


signatures.explain_calls(__name__)
