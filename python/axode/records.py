"""Types of arguments and results other than arrays."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .support import signatures

__all__ = ["BranchPoint", "ContactEvent", "ContactForce", "ContactRolloutDerivatives", "ContactRolloutGradient", "DriveEquilibrium",
           "DriveLinearization", "DriveRolloutDerivatives", "DynamicsAtTime", "Equilibrium",
           "ForwardDynamicsDerivatives", "ForwardDynamicsHessian",
           "IndependentEquations", "IndependentLinearization", "InverseDynamicsDerivatives", "InverseDynamicsHessian",
           "InverseKinematics", "JointState", "KinematicMotion", "Linearization", "Load", "LocalMobility",
           "LoopMobility", "MomentumFormDerivatives", "MotionBranch", "MotionChange", "MotionDerivatives",
           "PairDistances", "PlayEvent", "RedundantRow", "Rollout", "RolloutDerivatives", "RolloutGradient", "ShapeDistance",
           "SpringCoordinate", "StateDerivatives", "Target", "TaskEquations", "TaskSingularity"]

Array = NDArray[np.float64]
Representation = Literal["body", "spatial", "hybrid", "mixed"]


class _LoadNeeds(TypedDict):
    frame: str | int
    wrench: ArrayLike


class Load(_LoadNeeds, total=False):
    """A wrench on a frame: moment (N m), then force (N), shape (6,), or (N, 6) for N states.

    `representation` says in which axes and about which point it is: "body" (those of the frame, the default),
    "spatial" (inertial axes, about the inertial origin), "hybrid" (inertial axes, about the frame's origin) or
    "mixed". A Load is a dict; `axode.Load(frame="flange", wrench=W)` is the same as `{"frame": "flange", "wrench":
    W}`.

    >>> weight = axode.Load(frame="flange", representation="hybrid", wrench=[0, 0, 0, 0, 0, -50])
    >>> axode.generalized_loads(arm, np.full(7, 0.5), np.zeros(7), [weight])[1].round(3)
    np.float64(13.174)
    """

    representation: Representation


class _TargetNeeds(TypedDict):
    frame: str | int
    pose: ArrayLike


class Target(_TargetNeeds, total=False):
    """A target pose (4, 4) in the inertial frame for a frame, or for a point (3,) or pose (4, 4) `offset` in this
    frame.

    `angular_weight` and `linear_weight` (1 if absent) scale the parts of the error; a weight of 0 leaves its part
    free.

    >>> axode.Target(frame="flange", pose=np.eye(4), angular_weight=0.0)["frame"]
    'flange'
    """

    offset: ArrayLike
    angular_weight: float
    linear_weight: float


class InverseKinematics(NamedTuple):
    """The best configuration that `inverse_kinematics` found, and the norm of the error there (rad and m)."""

    status: Literal["solved", "stalled", "iteration_limit"]
    q: Array
    residual: float
    iterations: int
    restarts: int


class RedundantRow(NamedTuple):
    """A row of `loop_jacobian` that depends on other rows.

    It belongs to a state of stress that the loops can have without external forces; `wrench` describes it in the
    inertial frame. `dependency` @ A = 0, with 1 at this row; multipliers of rows where it is not 0 are indeterminate.
    """

    row: int
    loop: str
    wrench: str
    dependency: Array


class LoopMobility(NamedTuple):
    """Mobility of a mechanism with loops: degrees_of_freedom = nv - rank.

    `redundant` has the rows that depend on other rows, in their order. `mobility` is "regular" if all velocities of
    the `kernel` (nv, degrees_of_freedom) begin motions, "branches" if several motions meet, "shaky" if no finite
    motion exists. The motion does not determine the multipliers of the rows `indeterminate`: a stress of the loops
    may be added to them.
    """

    degrees_of_freedom: int
    rank: int
    redundant: list[RedundantRow]
    mobility: Literal["regular", "branches", "shaky"]
    kernel: Array
    indeterminate: list[int]


class BranchPoint(NamedTuple):
    """A point of a `MotionBranch` near q that Newton's method has closed.

    `parameter` (dimension,), the coordinates `x` (n,) in rad and m, the configuration `q` (nq,), and the residual of the loops
    in rad and characteristic lengths.
    """

    parameter: Array
    x: Array
    q: Array
    residual: float


class MotionBranch(NamedTuple):
    """A branch of the configuration space at q: x of the n coordinates of `LocalMobility`, in rad and m.

    Products and norms divide lengths by the characteristic length. `T` (D, n) has orthonormal rows that span the tangents at q,
    and x = T^T tau + sum of tau_a tau_b II[a, b] / 2 + ... with T II = 0. For D = 1 the columns of `series` (n, orders + 1) are
    the coefficients of s = T x, and II is the curvature. At a cusp (`power` above 1) they belong to zeta with zeta^power = T x,
    and II is None.

    `dead` joints have no velocity at q and move beside q; `idle` joints rest along the branch. `loops` are those in which
    something moves. `settled`: enough orders were left to exclude that a higher one ends the branch. `closes`: points on both
    sides of q were closed. `multiple`: the equations hold doubly along the branch. `residual_orders`: the measured orders of
    the residual of the series cut after 1, 2, ... terms.
    """

    dimension: int
    power: int
    T: Array
    II: Array | None
    series: Array | None
    settled: bool
    closes: bool
    multiple: bool
    differential_mobility_beside: int
    dead: list[str]
    idle: list[str]
    loops: list[str]
    points: list[BranchPoint]
    residual_orders: Array


class LocalMobility(NamedTuple):
    """Mobility of higher order of a mechanism with loops at a configuration.

    `words` name what was found. `mobility_by_order` has the dimensions of the kinematic tangent cones of order 1, 2, ...;
    `local_mobility` is the largest dimension of a branch, and `rigid_at_order` the first order with mobility 0 if nothing
    moves, else 0. The n `coordinates` are joints in loops, with their index among `velocities` of the model, and loop joints
    (-1); velocities `outside` are in no loop, and each adds 1 to every mobility. `conditions` are pairs (degree, loops): what
    is left after the elimination of all that the loops determine to first order.

    The loops give `equations` of this `rank`; `smallest_kept` and `largest_dropped` are the singular values on either side of
    it. `decided_by_rank`: ranks and roots alone decide; otherwise points are the evidence. `probe` counts random starts near
    q, the closed points to which they led, and those of them on no branch.
    """

    words: list[str]
    local_mobility: int
    differential_mobility: int
    mobility_by_order: list[int]
    settled: bool
    settled_at_order: int
    rigid_at_order: int
    branches: list[MotionBranch]
    conditions: list[tuple[int, list[str]]]
    coordinates: list[str]
    velocities: list[int]
    outside: list[int]
    loops: list[str]
    order: int
    length: float
    equations: int
    rank: int
    smallest_kept: float
    largest_dropped: float
    decided_by_rank: bool
    probe: tuple[int, int, int]


class ContactForce(NamedTuple):
    """A point at which the collision shapes `a` and `b` touch or nearly touch, and what acts there, in the inertial frame.

    `normal` is a unit vector from a to b, and `gap` (m) is negative in overlap. `force` (N) acts on b, and its opposite on a;
    `moment` (N m) is that of drilling and rolling friction. `friction` is the coefficient of sliding friction, and `status` says
    which branch of the law holds; without a force the point is open.
    """

    a: str
    b: str
    point: Array
    normal: Array
    gap: float
    force: Array
    moment: Array
    friction: float
    status: Literal["open", "stick", "slide"]


class ContactEvent(NamedTuple):
    """A change of a contact, a hard stop or a joint with dry friction at the time `t` (s), see `Trajectory.contact_events`.

    `kind`: "bounce" and "close" are impacts (or closures without speed) after which it is open and closed; "open": its normal
    force becomes 0; "slip": it begins to slide; "stick" and "reverse": its sliding velocity becomes 0, and friction can hold it
    or cannot. `of` has the names of two shapes, as '"floor" and "ball"', or that of a joint. `speed` is that of approach before
    an impact, m/s or rad/s. `shortened`: whether it was closed because its next bounces would be below rounding.
    """

    kind: Literal["bounce", "close", "open", "slip", "stick", "reverse"]
    t: float
    of: str
    speed: float
    shortened: bool


class PlayEvent(NamedTuple):
    """The play of a `coupling` that meets one of its ends at the time `t` (s), or leaves it.

    `side` is -1 at the lower end and 1 at the upper one. `impact`: whether the play meets the end; otherwise it leaves. `stays`:
    whether it is at the end after the event. `speed` is that before an impact, in units of the offset per s, and `impulse` that
    of the impact along the coupling.
    """

    coupling: str
    t: float
    side: Literal[-1, 1]
    impact: bool
    stays: bool
    speed: float
    impulse: float


class SpringCoordinate(NamedTuple):
    """The `coordinate` of a spring, m or rad, (N,) for N states, and its `gradient` (nv,) or (N, nv), see `spring_coordinate`."""

    coordinate: Array
    gradient: Array


class DriveLinearization(NamedTuple):
    """Small motions z' = A z + B du of a mechanism with drives, z = (delta, dv, dx), see `linearize_with_drives`.

    With nx states of the drives A has the shape (2 nv + nx, 2 nv + nx). `states` names those of dx, and `inputs` the drives
    whose input is a function of time, which du changes: B has the shape (2 nv + nx, number of inputs).
    """

    A: Array
    B: Array
    states: list[str]
    inputs: list[str]


class DriveEquilibrium(NamedTuple):
    """The best state that `equilibrium_with_drives` met: q (nq,) and the states x (nx,) of the drives, named in `states`.

    `residual` is the largest acceleration that remains, or rate of a state relative to its usual size, in SI units; `found` says
    whether it is at most 1e-9.
    """

    found: bool
    q: Array
    x: Array
    states: list[str]
    residual: float


class ShapeDistance(NamedTuple):
    """Signed distance of the collision shapes `a` and `b` (m), negative in overlap, with the normal from a to b.

    `point_a` and `point_b` are the nearest points, in the inertial frame. The true distance is at least `distance`, and at most `residual`
    more; if the shapes overlap, this is certain where `proved` is true. `jacobian` (nv,) is the rate of the distance for a unit of
    each velocity; it is exact if the nearest points are unique.
    """

    a: str
    b: str
    distance: float
    normal: Array
    point_a: Array
    point_b: Array
    residual: float
    proved: bool
    jacobian: Array


class PairDistances(NamedTuple):
    """Signed distances of pairs of collision shapes (..., P), m, and their rates for a unit of each velocity (..., P, nv)."""

    distances: Array
    jacobians: Array


class IndependentEquations(NamedTuple):
    """Equations of motion in independent velocities y: M y' + h = N^T tau, v = N y, a = N y' + c.

    `velocities` are the indices of the independent velocities.
    """

    velocities: list[int]
    M: Array
    h: Array
    N: Array
    c: Array


class IndependentLinearization(NamedTuple):
    """Small motions x' = A x + B dtau in independent velocities, x = (delta, dv): N delta and N dv + D delta of all joints.

    `velocities` are the indices of the independent velocities.
    """

    velocities: list[int]
    A: Array
    B: Array
    N: Array
    D: Array


class TaskEquations(NamedTuple):
    """Equations of motion of a parallel manipulator in task velocities V: M dV + h = J^T u, v = F V, a = F dV + c.

    u are the forces of the drives, whose velocities have the indices `drives` and are J V. With f task velocities and d drives
    M has the shape (f, f), J (d, f) and F (nv, f). h (f,) has Coriolis, centrifugal and gravity forces, less those of loads.
    """

    M: Array
    h: Array
    J: Array
    drives: list[int]
    F: Array
    c: Array


class TaskSingularity(NamedTuple):
    """A singularity of a parallel manipulator near a configuration, or at it, with a `sentence` about it.

    `type`: "limb" (type 1: `joints` of the limb of the number `limb` can move while the platform is at rest), "drives" (type 2:
    the platform can move while all drives are locked; `joints` are drives that hold each other) or "constraint" (the limbs leave
    the platform another freedom). `distance` is the least singular value divided by the largest one, 0 at the singularity.
    `twist` (6,) is the spatial twist of the platform that becomes free, angular before linear; it is 0 for a limb.
    """

    type: Literal["limb", "drives", "constraint"]
    limb: int | None
    distance: float
    twist: Array
    joints: list[str]
    sentence: str


class JointState(NamedTuple):
    """Coordinates and velocities of the joints, and the residuals of the bodies' motion.

    `position_residual` is the largest residual of a joint or loop (rad, m), `velocity_residual` that of its rate.
    """

    q: Array
    v: Array
    position_residual: float
    velocity_residual: float


class InverseDynamicsDerivatives(NamedTuple):
    """Derivatives by configuration, velocities and accelerations: of the forces, or of a number that they make."""

    q: Array
    v: Array
    a: Array


class ForwardDynamicsDerivatives(NamedTuple):
    """Derivatives by configuration, velocities and forces: of the accelerations, or of a number that they make."""

    q: Array
    v: Array
    tau: Array


class StateDerivatives(NamedTuple):
    """Derivatives by configuration and velocities."""

    q: Array
    v: Array


class MotionDerivatives(NamedTuple):
    """Derivatives of a twist V and of its rate dV by configuration and velocities, a column for each direction."""

    V_q: Array
    V_v: Array
    dV_q: Array
    dV_v: Array


class MotionChange(NamedTuple):
    """Changes of the pose, a displacement X, of a twist V and of its rate dV."""

    X: Array
    V: Array
    dV: Array


class MomentumFormDerivatives(NamedTuple):
    """Derivatives of the velocities v and of the rates dp of the momenta by configuration and momenta."""

    v_q: Array
    v_p: Array
    dp_q: Array
    dp_p: Array


class InverseDynamicsHessian(NamedTuple):
    """Second derivatives by pairs of configuration, velocities and accelerations, [outer, inner]; the others vanish."""

    qq: Array
    qv: Array
    vv: Array
    aq: Array


class ForwardDynamicsHessian(NamedTuple):
    """Second derivatives by pairs of configuration, velocities and forces, [outer, inner]; the others vanish."""

    qq: Array
    qv: Array
    vv: Array
    tauq: Array


class Linearization(NamedTuple):
    """The linear system x' = A x + B dtau of small deviations from a motion, x displacements before velocities."""

    A: Array
    B: Array


class Rollout(tuple[Array, Array]):
    """The pair (q, v) of the states of N motions, the `certificates` (N, K) of steps with contact, and states `x` of drives.

    A certificate says how exactly the laws of contact hold in a step, 1e-12 being rounding. Without contact there are none,
    and their shape is (0,). x has the shape (N, K + 1, nx), where nx is 0 if no drive has states.

    >>> q, v = path = axode.rollout(arm, np.zeros((5, 7)), np.zeros((5, 7)), np.ones((5, 20, 7)), 1e-3)
    >>> path.q is q, path.certificates.size
    (True, 0)
    """

    certificates: Array
    x: Array

    def __new__(cls, q: Array, v: Array,
                certificates: Array | None = None, x: Array | None = None) -> Rollout:
        made = super().__new__(cls, (q, v))
        made.certificates = np.empty(0) if certificates is None else certificates
        made.x = np.empty(0) if x is None else x
        return made

    def __getnewargs__(self) -> tuple[Array, Array]:
        return self[0], self[1]

    @property
    def q(self) -> Array:
        """(K + 1, nq) or (N, K + 1, nq)."""
        return self[0]

    @property
    def v(self) -> Array:
        """(K + 1, nv) or (N, K + 1, nv)."""
        return self[1]


class RolloutDerivatives(NamedTuple):
    """Linear maps of small deviations x over the steps of a motion, x_{k+1} = A_k x_k + B_k dtau_k, displacements before velocities."""

    A: Array
    B: Array


class DriveRolloutDerivatives(NamedTuple):
    """A motion with drives, and linear maps of small deviations over its steps, see `rollout_derivatives_with_drives`.

    With nx states of the drives and nu inputs q, v and x have K + 1 rows, and A (K, 2 nv + nx, 2 nv + nx), B (K, 2 nv + nx, nv)
    and C (K, 2 nv + nx, nu), each with another axis N in front for N motions. `states` names the states of x, and `inputs` the
    drives whose input is a function of time.
    """

    q: Array
    v: Array
    x: Array
    A: Array
    B: Array
    C: Array
    states: list[str]
    inputs: list[str]


class ContactRolloutDerivatives(NamedTuple):
    """A motion with contact, linear maps of small deviations over its steps, and how exact they are, see `contact_rollout_derivatives`."""

    q: Array
    v: Array
    A: Array
    B: Array
    C: Array
    certificate: float
    unique: bool
    at_kink: bool
    placement: Array | None = None
    inertia: Array | None = None
    geometry: Array | None = None


class ContactRolloutGradient(NamedTuple):
    """Gradient of a scalar function of a motion with contact by its start, the drive forces and the parameters.

    `surfaces` (3, n) has that by friction, restitution and the thickness of a layer on each of n collision shapes; `placement`
    (n, 6), `inertia` (10 n_bodies,) and `geometry` (n_bodies, 6) are explained in `contact_rollout_derivatives`.
    """

    q: Array
    v: Array
    tau: Array
    surfaces: Array
    placement: Array
    inertia: Array
    geometry: Array | None


class RolloutGradient(NamedTuple):
    """Gradient of a scalar function of a motion by the initial q and v, the drive forces and the geometric parameters."""

    q: Array
    v: Array
    tau: Array
    geometry: Array


class Equilibrium(NamedTuple):
    """The best configuration that `equilibrium` met, and the norm of the forces that are missing there (N m and N)."""

    status: Literal["solved", "stalled", "iteration_limit", "open"]
    q: Array
    residual: float
    iterations: int


class DynamicsAtTime(NamedTuple):
    """Accelerations at a time, multipliers of the loops, and the force that each motion takes."""

    a: Array
    multipliers: Array
    motion_forces: Array


class KinematicMotion(NamedTuple):
    """A motion without dynamics, up to the last time that could be reached."""

    t: Array
    q: Array
    v: Array
    a: Array
    jerk: Array
    complete: bool
    stop_reason: str


signatures.explain_calls(__name__)
