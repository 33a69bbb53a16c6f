"""Models with other joints or other poses of their bodies than a given model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import lie
from .._axode import Model

__all__: list[str] = []

Array = NDArray[np.float64]

#: The keys of a drawing that determine the pose of a link, and those of its mass and inertia.
PLACING = {"A", "B", "S_prev", "S_self", "frame", "joint", "on", "com", "inertia", "inertia_about", "inertia_in",
           "inertia_axes"}


def _links_of_bodies(m: Model, drawing: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The link of each moving body. If one drawn joint moves two bodies, the first of them has the link of its
    successor."""
    links = {link["name"]: link for link in drawing["body"]}
    successor = {m.body(name).predecessor: name for name in m.body_names}
    return {name: links.get(name) or links[successor[name]] for name in m.body_names}


def with_joints(m: Model, of_joints: dict[str, Array]) -> Model:
    """The model m with other armatures, damping or friction, (nv,) each."""
    drawing = m.to_dict()
    links = _links_of_bodies(m, drawing)
    velocities: dict[str, list[int]] = {}  # of each link's joint
    for name, joint in zip(m.body_names, m.joints):
        velocities.setdefault(links[name]["name"], []).extend(range(joint.v.start, joint.v.stop))
    for name, own in velocities.items():
        joint_of_link = links[name]["joint"]
        if not own or joint_of_link == "free" or joint_of_link["kind"] == "free":
            continue
        dofs = joint_of_link.setdefault("dof", [{} for _ in own]) if len(own) > 1 else [joint_of_link]
        for dof, k in zip(dofs, own):
            dof.update({kind: float(values[k]) for kind, values in of_joints.items()})
    return Model.from_dict(drawing)


def check_tool(m: Model, name: str, argument: str) -> None:
    """ValueError if the frame is that of a body, which has no pose of its own."""
    if name == "ground" or name in m.body_names:
        raise ValueError(f'{argument}: frame "{name}" is that of a body; only frames that are fixed to one can be '
                         "displaced on it: expected such a frame, or tool=False")


class Drawing:
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
