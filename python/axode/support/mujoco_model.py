"""A compiled model of MuJoCo as a dict with the keys of the drawing format, and a list of what these cannot express."""

from __future__ import annotations

import importlib
import types
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import lie

__all__: list[str] = []

Array = NDArray[np.float64]
UNLIMITED = 1e10  # MuJoCo's largest number
KINDS = {"mjJNT_FREE": "free", "mjJNT_BALL": "spherical", "mjJNT_SLIDE": "prismatic", "mjJNT_HINGE": "revolute"}
SHAPES = {"mjGEOM_SPHERE": "sphere", "mjGEOM_CAPSULE": "capsule", "mjGEOM_ELLIPSOID": "ellipsoid",
          "mjGEOM_CYLINDER": "cylinder", "mjGEOM_BOX": "box", "mjGEOM_MESH": "mesh", "mjGEOM_PLANE": "plane"}
#: Geoms of higher groups are not drawn unless one asks.
VISIBLE_GROUPS = 3


def import_mujoco(who: str) -> types.ModuleType:
    try:
        return importlib.import_module("mujoco")
    except ImportError as error:
        raise ImportError(f"{who} needs MuJoCo: pip install mujoco") from error


def read(m: Any) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """A dict for Model.from_dict, and (element, message) for everything that is not carried over. Coordinates are
    MuJoCo's qpos: poses at zero are computed from those at qpos0."""
    reader = _Reader(m)
    return reader.drawing(), reader.warnings()


class _Names:
    """Makes names that differ from each other and resemble the given names."""

    def __init__(self, *taken: str):
        self.taken = set(taken)
        self.changed: list[str] = []

    def free(self, wished: str) -> str:
        name, k = wished, 2
        while name in self.taken:
            name, k = f"{wished}_{k}", k + 1
        if name != wished:
            self.changed.append(f'"{wished}" is called "{name}"')
        self.taken.add(name)
        return name


def _position(x: Array) -> list[float]:
    return [float(value) for value in x]


def _quaternion(wxyz: Array) -> list[float]:
    return [float(wxyz[k]) for k in (1, 2, 3, 0)]


def _pose(position: Array, wxyz: Array) -> dict[str, list[float]]:
    return {"position": _position(position), "quaternion": _quaternion(wxyz)}


def _matrix(position: Array, wxyz: Array) -> Array:
    C = np.eye(4)
    C[:3, :3], C[:3, 3] = lie.rotation(_quaternion(wxyz / np.linalg.norm(wxyz))), position
    return C


def _pose_of(C: Array) -> dict[str, list[float]]:
    return {"position": _position(C[:3, 3]), "quaternion": _position(lie.quaternion(C[:3, :3]))}


class _Reader:
    def __init__(self, m: Any):
        self.m, self.mj = m, import_mujoco("a model of MuJoCo")
        self.lost: dict[str, list[str]] = {}
        self.actuators = int(getattr(m, "nactuator", m.nu))  # which one control moved each, before MuJoCo 4
        self.body_names, self.joint_names = _Names("ground"), _Names()
        self.bodies = ["ground"] + [self.body_names.free(m.body(i).name or f"body {i}") for i in range(1, m.nbody)]
        self.joints = [self.joint_names.free(self._joint_name(j)) for j in range(m.njnt)]
        self.sites = [self.body_names.free(m.site(s).name or f"site {s}") for s in range(m.nsite)]
        self.follows: dict[int, dict[str, Any]] = {}
        self.loops: list[dict[str, Any]] = []
        self.couplings: list[dict[str, Any]] = []

    def _joint_name(self, j: int) -> str:
        body = int(self.m.jnt_bodyid[j])
        if name := self.m.joint(j).name:
            return str(name)
        alone = self.m.body_jntnum[body] == 1
        return self.bodies[body] + ("_joint" if alone else f"_joint_{j - self.m.body_jntadr[body] + 1}")

    def lose(self, what: str, name: str) -> None:
        self.lost.setdefault(what, []).append(name)

    def warnings(self) -> list[tuple[str, str]]:
        changed = self.body_names.changed + self.joint_names.changed
        renamed = [("names", ", ".join(changed[:5]) + (", ..." if len(changed) > 5 else "")
                    + "; names of bodies and frames must differ in axode, and names of joints")] if changed else []
        return renamed + [(what, self._listed(names)) for what, names in self.lost.items()]

    @staticmethod
    def _listed(names: list[str]) -> str:
        if not any(names):
            return "not carried over" + (f" ({len(names)} times)" if len(names) > 1 else "")
        shown = ", ".join(f'"{name}"' for name in names[:5])
        return f"{shown}{', ...' if len(names) > 5 else ''}: not carried over"

    # ---------------------------------------------------------------- the whole

    def drawing(self) -> dict[str, Any]:
        m = self.m
        self._equalities()
        weightless = m.opt.disableflags & int(self.mj.mjtDisableBit.mjDSBL_GRAVITY)
        out: dict[str, Any] = {"format": "axode drawing 1", "name": m.names.split(b"\0")[0].decode() or "mechanism",
                               "gravity": [0.0, 0.0, 0.0] if weightless else _position(m.opt.gravity)}
        effort, driven = self._drives()
        bodies = [part for i in range(1, m.nbody) for part in self._body(i, effort, driven)]
        frames = [{"name": self.sites[s], "on": self.bodies[m.site_bodyid[s]], "in": "body",
                   **_pose(m.site_pos[s], m.site_quat[s])} for s in range(m.nsite)]
        shapes = self._shapes(0)
        springs = self._tendons()
        self._rest()
        for key, value in [("body", bodies), ("frame", frames), ("shape", shapes), ("spring", springs),
                           ("loop", self.loops), ("coupling", self.couplings)]:
            if value:
                out[key] = value
        return out

    # ---------------------------------------------------------------- bodies and joints

    def _body(self, i: int, effort: dict[int, float], driven: set[int]) -> Iterable[dict[str, Any]]:
        """The body, after a massless body for each of its joints but the last."""
        m, on = self.m, self.bodies[self.m.body_parentid[i]]
        first, count = int(m.body_jntadr[i]), int(m.body_jntnum[i])
        C = _matrix(m.body_pos[i], m.body_quat[i])
        for j in range(first, first + count):
            C = C @ self._back_to_zero(j)
            last = j == first + count - 1
            name = self.bodies[i] if last else self.body_names.free(f"{self.bodies[i]}.{self.joints[j]}")
            yield {"name": name, "on": on, "B": _pose_of(C), "joint": self._joint(j, effort, driven),
                   **(self._matter(i) if last else {})}
            C, on = np.eye(4), name
        if count == 0:
            yield {"name": self.bodies[i], "on": on, "B": _pose(m.body_pos[i], m.body_quat[i]), "joint": "fixed",
                   **self._matter(i)}

    def _back_to_zero(self, j: int) -> Array:
        """exp(-S qpos0): MuJoCo's poses are those at qpos0, a drawing's those at zero."""
        m, axis = self.m, self.m.jnt_axis[j]
        kind, reference = self._kind(j), float(m.qpos0[m.jnt_qposadr[j]])
        if kind == "prismatic":
            return np.asarray(lie.exp([0.0, 0.0, 0.0, *(-reference * axis)]))
        if kind == "revolute":
            return np.asarray(lie.exp([*(-reference * axis), *(-reference * np.cross(m.jnt_pos[j], axis))]))
        return np.eye(4)

    def _kind(self, j: int) -> str:
        return KINDS[self.mj.mjtJoint(self.m.jnt_type[j]).name]

    def _matter(self, i: int) -> dict[str, Any]:
        m, out = self.m, {}
        if m.body_mass[i] > 0 or np.any(m.body_inertia[i]):
            out = {"mass": float(m.body_mass[i]), "com": _position(m.body_ipos[i]),
                   "inertia": _position(m.body_inertia[i]),
                   "inertia_axes": {"quaternion": _quaternion(m.body_iquat[i])}}
        if shapes := self._shapes(i):
            out["shape"] = shapes
        if m.body_gravcomp[i] != 0:
            self.lose("gravity compensation of bodies", self.bodies[i])
        if m.body_mocapid[i] >= 0:
            self.lose("mocap bodies, which are fixed in axode", self.bodies[i])
        return out

    def _joint(self, j: int, effort: dict[int, float], driven: set[int]) -> dict[str, Any]:
        m, kind, name = self.m, self._kind(j), self.joints[j]
        at, v = int(m.jnt_qposadr[j]), int(m.jnt_dofadr[j])
        dof: dict[str, Any] = {"damping": float(m.dof_damping[v]), "friction": float(m.dof_frictionloss[v]),
                               "armature": float(m.dof_armature[v])}
        stiffness = float(m.jnt_stiffness[j])
        joint: dict[str, Any] = {"name": name, "kind": kind}
        if self._is_curved("dof_dampingpoly", v) or self._is_curved("jnt_stiffnesspoly", j):
            self.lose("damping and stiffness that are not linear", name)
        if kind in ("revolute", "prismatic"):
            joint["axis"] = _position(m.jnt_axis[j])
            if m.jnt_limited[j]:
                joint["limits"] = [float(np.inf * np.sign(x)) if abs(x) >= UNLIMITED else float(x)
                                   for x in m.jnt_range[j]]
            if j in effort:
                joint["effort"] = effort[j]
            if stiffness:
                dof["spring"] = {"stiffness": stiffness, "rest": float(m.qpos_spring[at])}
            if j in self.follows:
                joint["follows"] = self.follows[j]
        else:
            if m.jnt_limited[j]:
                self.lose("limits of ball joints", name)
            if stiffness and kind == "spherical" and np.allclose(m.qpos_spring[at:at + 4], [1, 0, 0, 0], atol=1e-12):
                dof["spring"] = {"stiffness": stiffness}
            elif stiffness:
                self.lose("springs of ball joints at rest elsewhere, and of free joints", name)
            if kind == "free" and dof["armature"]:
                self.lose("the axes in which the armature of a free joint acts, which do not turn there", name)
        if j not in driven and j not in self.follows:
            joint["passive"] = True
        if kind in ("revolute", "spherical"):
            joint["point"] = _position(m.jnt_pos[j])
        dof = {key: value for key, value in dof.items() if value}
        if kind in ("spherical", "free") and dof:
            joint["dof"] = [dof] * (3 if kind == "spherical" else 6)
        else:
            joint.update(dof)
        return joint

    def _is_curved(self, polynomials: str, k: int) -> bool:
        """Whether a force law has more than its linear term; older versions of MuJoCo have only this term."""
        return hasattr(self.m, polynomials) and bool(np.any(getattr(self.m, polynomials)[k]))

    def _drives(self) -> tuple[dict[int, float], set[int]]:
        """The largest force of hinges and slides that actuators limit, and all joints that actuators drive."""
        m, trn = self.m, self.mj.mjtTrn
        bounds: dict[int, list[float]] = {j: [max(abs(x) for x in m.jnt_actfrcrange[j])]
                                          for j in range(m.njnt) if m.jnt_actfrclimited[j]}
        single: dict[int, list[float]] = {}
        driven: set[int] = set()
        for a in range(self.actuators):
            name, gear = m.actuator(a).name or f"actuator {a}", m.actuator_gear[a]
            j = int(m.actuator_trnid[a, 0])
            of_a_joint = int(m.actuator_trntype[a]) in (int(trn.mjTRN_JOINT), int(trn.mjTRN_JOINTINPARENT))
            if of_a_joint:
                driven.add(j)
            elif int(m.actuator_trntype[a]) == int(trn.mjTRN_TENDON):
                driven.update(self.joints.index(joint) for joint in self._sum_of_coordinates(j))
            motor = (m.actuator_gaintype[a] == int(self.mj.mjtGain.mjGAIN_FIXED)
                     and m.actuator_biastype[a] == int(self.mj.mjtBias.mjBIAS_NONE)
                     and m.actuator_dyntype[a] == int(self.mj.mjtDyn.mjDYN_NONE))
            hinge = of_a_joint and self._kind(j) in ("revolute", "prismatic")
            if not hinge:
                unlimited = not m.actuator_forcelimited[a] and not m.actuator_ctrllimited[a]
                if not (of_a_joint and motor and unlimited):
                    self.lose("actuators of anything but a single hinge or slide", name)
                continue
            largest = np.inf
            if m.actuator_forcelimited[a]:
                largest = float(max(abs(m.actuator_forcerange[a])))
            if motor and m.actuator_ctrllimited[a]:
                largest = min(largest, float(abs(m.actuator_gainprm[a, 0]) * max(abs(m.actuator_ctrlrange[a]))))
            if not motor:
                self.lose("control laws of actuators other than motors", name)
            single.setdefault(j, []).append(abs(float(gear[0])) * largest)
        for j, forces in single.items():
            bounds.setdefault(j, []).append(sum(forces))
        effort = {j: min(all_) for j, all_ in bounds.items() if np.isfinite(min(all_))}
        return effort, driven if self.actuators else set(range(m.njnt))

    # ---------------------------------------------------------------- shapes

    def _shapes(self, i: int) -> list[dict[str, Any]]:
        m, found = self.m, []
        for g in map(int, np.flatnonzero(m.geom_bodyid == i)):
            kind = SHAPES.get(self.mj.mjtGeom(m.geom_type[g]).name)
            if kind is None:
                what = self.mj.mjtGeom(m.geom_type[g]).name.removeprefix("mjGEOM_").lower()
                self.lose(f"geoms of type {what}", m.geom(g).name)
                continue
            shape = self._shape(g, kind)
            touches = m.geom_contype[g] != 0 or m.geom_conaffinity[g] != 0
            if shape is not None and (not touches or m.geom_group[g] < VISIBLE_GROUPS):
                found.append({"role": "visual", **shape})
            if shape is not None and touches:
                found.append({"role": "collision", **shape, **self._friction(g)})
        return found

    def _friction(self, g: int) -> dict[str, float]:
        """The frictions that the dimension of the contacts of a geom lets act."""
        sliding, spinning, rolling = map(float, self.m.geom_friction[g])
        rows = int(self.m.geom_condim[g])
        return {"friction": sliding if rows > 1 else 0.0, **({"spin_friction": spinning} if rows > 3 else {}),
                **({"rolling_friction": rolling} if rows > 4 else {})}

    def _shape(self, g: int, kind: str) -> dict[str, Any] | None:
        m, size = self.m, self.m.geom_size[g]
        C = _matrix(m.geom_pos[g], m.geom_quat[g])
        shape: dict[str, Any] = {"kind": kind}
        if name := m.geom(g).name:
            shape["name"] = name
        if kind == "box":
            shape["size"] = _position(2 * size)
        elif kind == "ellipsoid":
            shape["semi_axes"] = _position(size)
        elif kind == "mesh":
            mesh = int(m.geom_dataid[g])
            if m.mesh_pathadr[mesh] < 0:
                self.lose("meshes without a file", m.mesh(mesh).name)
                return None
            shape["file"] = m.paths[m.mesh_pathadr[mesh]:].split(b"\0")[0].decode()
            shape["scale"] = _position(m.mesh_scale[mesh])
            # MuJoCo moved the mesh to its centre.
            C = C @ lie.inverse(_matrix(m.mesh_pos[mesh], m.mesh_quat[mesh]))
        elif kind != "plane":
            shape["radius"] = float(size[0])
            if kind != "sphere":
                shape["length"] = float(2 * size[1])
        color = m.mat_rgba[m.geom_matid[g]] if m.geom_matid[g] >= 0 else m.geom_rgba[g]
        return {**shape, **_pose_of(C), "color": [float(x) for x in color]}

    # ---------------------------------------------------------------- equalities and tendons

    def _equalities(self) -> None:
        m, kinds = self.m, self.mj.mjtEq
        readers: dict[int, Callable[[int, str], bool]] = {
            int(kinds.mjEQ_CONNECT): self._loop, int(kinds.mjEQ_WELD): self._loop,
            int(kinds.mjEQ_JOINT): self._joint_equality, int(kinds.mjEQ_TENDON): self._tendon_equality}
        loop_names = _Names(*self.joints)
        for e in range(m.neq):
            name = m.equality(e).name
            if not m.eq_active0[e]:
                self.lose("equalities that are not active", name)
                continue
            free = loop_names.free(name) if name else ""
            read = readers.get(int(m.eq_type[e]))
            if read is None or not read(e, free):
                what = kinds(m.eq_type[e]).name.removeprefix("mjEQ_").lower()
                self.lose(f"equalities of type {what} that are not linear, or between bodies that are fixed to each other", name)

    def _loop(self, e: int, name: str) -> bool:
        m, one, other, data = self.m, int(self.m.eq_obj1id[e]), int(self.m.eq_obj2id[e]), self.m.eq_data[e]
        connect = m.eq_type[e] == int(self.mj.mjtEq.mjEQ_CONNECT)
        no_turn = np.array([1.0, 0.0, 0.0, 0.0])
        if m.eq_objtype[e] == int(self.mj.mjtObj.mjOBJ_SITE):
            ends = [int(m.site_bodyid[one]), int(m.site_bodyid[other])]
            between, frames = [self.sites[one], self.sites[other]], list[dict[str, list[float]]]([{}, {}])
        else:
            ends = [one, max(other, 0)]
            between = [self.bodies[k] for k in ends]
            frames = ([_pose(data[:3], no_turn), _pose(data[3:6], no_turn)] if connect
                      else [_pose(data[3:6], data[6:10] / np.linalg.norm(data[6:10])), _pose(data[:3], no_turn)])
        if m.body_weldid[ends[0]] == m.body_weldid[ends[1]]:
            return False
        self.loops.append({**({"name": name} if name else {}), "kind": "spherical" if connect else "fixed",
                           "between": between, "frames": frames})
        return True

    def _joint_equality(self, e: int, name: str) -> bool:
        """A joint equality y - y0 = a0 + a1 (x - x0) as a coupling."""
        m, y, x = self.m, int(self.m.eq_obj1id[e]), int(self.m.eq_obj2id[e])
        a0, a1 = (float(a) for a in m.eq_data[e][:2])
        if np.any(m.eq_data[e][2:5]):
            return False
        offset = float(m.qpos0[m.jnt_qposadr[y]]) + a0
        if x < 0 or a1 == 0:
            self._couple(name, {self.joints[y]: 1.0}, offset)
            return True
        offset -= a1 * float(m.qpos0[m.jnt_qposadr[x]])
        leader = x
        while leader in self.follows and leader != y:
            leader = self.joints.index(self.follows[leader]["joint"])
        if y in self.follows or leader == y:
            self._couple(name, {self.joints[y]: 1.0, self.joints[x]: -a1}, offset)
        else:
            self.follows[y] = {"joint": self.joints[x], "ratio": a1, "offset": offset}
        return True

    def _couple(self, name: str, terms: dict[str, float], offset: float) -> None:
        self.couplings.append({**({"name": name} if name else {}), "terms": terms, "offset": offset})

    def _tendon_equality(self, e: int, name: str) -> bool:
        """The equality of a tendon whose length is a sum of coordinates, as a coupling."""
        m, t = self.m, int(self.m.eq_obj1id[e])
        terms = self._sum_of_coordinates(t)
        if m.eq_obj2id[e] >= 0 or not terms:
            return False
        self._couple(name, terms, float(m.tendon_length0[t] + m.eq_data[e][0]))
        return True

    def _sum_of_coordinates(self, t: int) -> dict[str, float]:
        m, terms = self.m, {}
        for w in range(m.tendon_adr[t], m.tendon_adr[t] + m.tendon_num[t]):
            if m.wrap_type[w] != int(self.mj.mjtWrap.mjWRAP_JOINT):
                return {}
            if m.wrap_prm[w] != 0:
                terms[self.joints[m.wrap_objid[w]]] = float(m.wrap_prm[w])
        return terms

    def _tendons(self) -> list[dict[str, Any]]:
        """Tendons through sites become springs; of all other tendons only equalities are carried over."""
        m, springs = self.m, []
        for t in range(m.ntendon):
            first, name = int(m.tendon_adr[t]), m.tendon(t).name or f"tendon {t}"
            plain = not (m.tendon_limited[t] or m.tendon_frictionloss[t] or m.tendon_armature[t]
                         or self._is_curved("tendon_stiffnesspoly", t) or self._is_curved("tendon_dampingpoly", t))
            elastic = m.tendon_stiffness[t] != 0 or m.tendon_damping[t] != 0
            wraps = range(first, first + int(m.tendon_num[t]))
            straight = all(m.wrap_type[w] == int(self.mj.mjtWrap.mjWRAP_SITE) for w in wraps)
            if straight and plain and elastic and m.tendon_lengthspring[t, 0] == m.tendon_lengthspring[t, 1]:
                sites = [self.sites[m.wrap_objid[w]] for w in wraps]
                points = [{"on": site, "point": [0.0, 0.0, 0.0]} for site in sites]
                path = {"kind": "tendon", "in": "body", "path": points}
                springs.append({**({"between": sites} if len(sites) == 2 else path),
                                "stiffness": float(m.tendon_stiffness[t]), "rest": float(m.tendon_lengthspring[t, 0]),
                                "damping": float(m.tendon_damping[t])})
            elif elastic or not plain or not self._sum_of_coordinates(t):
                self.lose("tendons", name)
        return springs

    def _rest(self) -> None:
        m = self.m
        for what, count, named in [("cameras", m.ncam, m.camera), ("lights", m.nlight, m.light),
                                   ("sensors", m.nsensor, m.sensor), ("keyframes", m.nkey, m.key),
                                   ("contact pairs", m.npair, m.pair), ("flexes", m.nflex, None),
                                   ("skins", m.nskin, None), ("plugins", m.nplugin, None)]:
            for k in range(count):
                self.lose(what, named(k).name if named else "")
        if m.opt.density != 0 or m.opt.viscosity != 0:
            self.lose("forces of the medium", "")
