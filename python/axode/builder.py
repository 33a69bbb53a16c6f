"""Mechanisms that are described body by body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from numpy.typing import ArrayLike

from .support import signatures
from ._axode import Model

__all__ = ["Builder"]


class Builder:
    """Collects bodies, frames, springs and loops, with the keys of the drawing format, and builds a model from them.

    Everything is given in one frame with every joint at zero, in SI units; docs/drawing-format.md has every key. This
    construction frame is also the frame of every body, with an origin that may be far from the body. To give a body
    another frame, frame="joint" puts the origin at the joint, and frame="com" at the centre of mass. Nothing is
    checked before `build`, which reports every fault at once.

    >>> crane = axode.Builder("crane")
    >>> crane.body("column", joint={"kind": "revolute", "axis": "z", "point": [0, 0, 0]},
    ...            mass=800, com=[0, 0, 1.5], inertia=[620, 620, 40])
    Builder("crane": column)
    >>> crane.body("jib", on="column", joint={"kind": "revolute", "axis": [0, -1, 0], "point": [0.3, 0, 3]},
    ...            mass=300, com=[2.1, 0, 3], inertia=[8, 330, 330])
    Builder("crane": column, jib)
    >>> crane.frame("hook", on="jib", position=[4, 0, 3]).build()
    Model("crane": 2 moving bodies, nq = 2, nv = 2, 4 frames, 1100 kg)
    """

    def __init__(self, name: str = "mechanism", gravity: ArrayLike = (0.0, 0.0, -9.81)):
        self.name = name
        self.gravity = gravity
        self.bodies: list[dict[str, Any]] = []
        self.frames: list[dict[str, Any]] = []
        self.springs: list[dict[str, Any]] = []
        self.loops: list[dict[str, Any]] = []
        self.couplings: list[dict[str, Any]] = []
        self.motions: list[dict[str, Any]] = []
        self.drives: list[dict[str, Any]] = []
        self.initial: dict[str, Any] | None = None

    def body(self, name: str, *, on: str = "ground", joint: dict[str, Any] | str, **keys: Any) -> Builder:
        """Adds a body that hangs on another one by a joint. Returns the builder.

        `joint` is a dict such as {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, or just "fixed" or "free";
        mass (kg), com (m), inertia (kg m^2), frame and the other keys are those of a body in a drawing.
        """
        self.bodies.append({"name": name, "on": on, "joint": joint, **keys})
        return self

    def frame(self, name: str, *, on: str, **keys: Any) -> Builder:
        """Adds a frame of interest to a body: a tool, a sensor. Returns the builder.

        `position` (m) and a rotation are given in the construction frame, or in the frame of the body with
        in_="body".
        """
        if "in_" in keys:
            keys["in"] = keys.pop("in_")
        self.frames.append({"name": name, "on": on, **keys})
        return self

    def spring(self, one: str = "", other: str = "", **keys: Any) -> Builder:
        """Adds a spring and damper between two bodies or frames, or "ground". Returns the builder.

        `stiffness` (N/m), `rest` (m) and `damping` (N s/m) act along the line between two `points` (m), which are
        given in the construction frame, or each in its own frame with in_="body". If no points are given, they are
        the origins of the two frames. The other keys are those of `[[spring]]`: `kind`, `law`, `preload`, ...
        Springs of kind "tendon" and "joints" have no frames `one` and `other`, but a `path` or `terms`.
        """
        if "in_" in keys:
            keys["in"] = keys.pop("in_")
        self.springs.append({**({"between": [one, other]} if one else {}), **keys})
        return self

    def loop(self, one: str, other: str, kind: str = "revolute", **keys: Any) -> Builder:
        """Closes a loop by a joint between two bodies or frames, or "ground". Returns the builder.

        `kind` is fixed, revolute, prismatic, helical, cylindrical, spherical, planar, translational, universal, rod,
        rolling or belt; axis, point (m), points and the other keys are those of a loop in a drawing, in the
        construction frame with every joint at zero, where the loop is closed. If it is not closed there,
        frames=[{}, {}] closes it between the frames of the two bodies; poses in these dicts select other frames on
        them.

        >>> def bar(x, z, x_com, z_com):
        ...     hinge = {"kind": "revolute", "axis": "y", "point": [x, 0, z]}
        ...     return {"joint": hinge, "mass": 1, "com": [x_com, 0, z_com], "inertia": [0.1, 0.1, 0.1]}
        >>> four_bar = axode.Builder("four-bar").body("crank", **bar(0, 0, 0, 0.5))
        >>> four_bar.body("coupler", on="crank", **bar(0, 1, 1, 1)).body("rocker", **bar(2, 0, 2, 0.5))
        Builder("four-bar": crank, coupler, rocker)
        >>> four_bar.loop("coupler", "rocker", "revolute", name="pin", axis="y", point=[2, 0, 1]).build().loop_names
        ['pin']
        """
        self.loops.append({"between": [one, other], "kind": kind, **keys})
        return self

    def coupling(self, terms: Mapping[str, float], offset: float = 0.0, **keys: Any) -> Builder:
        """Couples joints of one velocity: the sum of factor times coordinate is `offset`. Returns the builder.

        `terms` has the factor of each joint, by its name; the only other key is `name`.

        >>> wheel = {"joint": {"kind": "revolute", "axis": "x", "point": [0, 0, 0]}, "mass": 1, "com": [0, 0, 0],
        ...          "inertia": [1, 1, 1]}
        >>> differential = axode.Builder().body("left", **wheel).body("right", **wheel).body("shaft", **wheel)
        >>> terms = {"left_joint": 1, "right_joint": 1, "shaft_joint": -2}
        >>> differential.coupling(terms, name="differential").build().n_loops
        1
        """
        self.couplings.append({"terms": dict(terms), "offset": offset, **keys})
        return self

    def motion(self, of: str, kind: str, **keys: Any) -> Builder:
        """Prescribes the motion of a joint of one velocity, or of the length of a rod. Returns the builder.

        `of` names the joint or the rod; `kind` is harmonic, ramp, polynomial or samples, and the other keys are those of a
        motion in a drawing (rad or m, s, Hz).

        >>> link = {"joint": {"kind": "revolute", "axis": "y", "point": [0, 0, 0]}, "mass": 1, "com": [0, 0, -1],
        ...         "inertia": [1, 1, 1]}
        >>> shaker = axode.Builder().body("link", **link)
        >>> shaker.motion("link_joint", "harmonic", amplitude=0.2, frequency=3).build().motion_names
        ['motion of link_joint']
        """
        self.motions.append({"of": of, "kind": kind, **keys})
        return self

    def drive(self, kind: str, joint: str | None = None, **keys: Any) -> Builder:
        """Adds a drive with states of its own. Returns the builder.

        `kind` is dc_motor, pid, series_elastic, lugre or hydraulic_cylinder, and `joint` the joint of one velocity on
        which it acts; `joints` with factors, or `between` and `points`, may take its place. The other keys are those of
        a drive in a drawing (SI units).

        >>> wheel = {"joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1, "com": [0, 0, 0],
        ...          "inertia": [1, 1, 1]}
        >>> driven = axode.Builder().body("wheel", **wheel)
        >>> motor = {"resistance": 1, "inductance": 0.01, "torque_constant": 0.1}
        >>> driven = driven.drive("dc_motor", "wheel_joint", **motor, input=12)
        >>> axode.simulate(driven.build(), [0], [0], until=1).drive_states
        ['drive 1.current']
        """
        if "in_" in keys:
            keys["in"] = keys.pop("in_")
        given = {} if joint is None else {"joint": joint}
        self.drives.append({"kind": kind, **given, **keys})
        return self

    def state(self, q: Mapping[str, Any] | None = None, v: Mapping[str, Any] | None = None) -> Builder:
        """Says where motions of the mechanism start: coordinates and velocities by joint. Returns the builder.

        Joints that are not named are at zero and at rest; a joint with several numbers has a list of them.

        >>> link = {"joint": {"kind": "revolute", "axis": "y", "point": [0, 0, 0]}, "mass": 1, "com": [0, 0, -1],
        ...         "inertia": [1, 1, 1]}
        >>> axode.Builder().body("link", **link).state(q={"link_joint": 0.5}).build().initial_state()
        (array([0.5]), array([0.]))
        """
        self.initial = {"q": dict(q or {}), "v": dict(v or {})}
        return self

    def build(self, base: Literal["fixed", "free"] | None = None, *, strict: bool = False) -> Model:
        """Builds the model. ModelError lists every fault; `base` and `strict` are those of `load`."""
        return Model.from_bodies(
            self.bodies, self.frames, springs=self.springs, loops=self.loops, couplings=self.couplings,
            motions=self.motions, drives=self.drives, state=self.initial, name=self.name, gravity=self.gravity, base=base,
            strict=strict
        )

    def __repr__(self) -> str:
        names = ", ".join(str(body["name"]) for body in self.bodies)
        return f'Builder("{self.name}": {names or "no bodies"})'


signatures.explain_calls(__name__)
