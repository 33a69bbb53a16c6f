"""Drives for `simulate` and `rollout` that are computed without calls into Python, and motions that they follow.

A drive is the argument `tau` of `axode.simulate` and `axode.rollout`; `on(m)` is the drive of a mechanism m as a
function (t, q, v) -> tau. Profiles are motions from rest at a configuration to rest at another one within limits, as
an `axode.Trajectory` from t = 0 on. Every joint moves along its geodesic, rotations the shorter way round, and all joints
start and arrive together. With loops, states in between are not closed; controllers follow the coordinates of the
driven joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _axode
from .records import Load
from .support import signatures
from ._axode import Model, Trajectory

__all__ = ["PD", "ComputedTorque", "MotorMotion", "Sampled", "elastic_feed_forward", "jerk_limited_profile",
           "quintic_profile", "trapezoidal_profile"]


class Sampled:
    """Forces tau (K, nv) at times t (K,), s, which must increase.

    Between the samples the forces are interpolated linearly, or constant with hold=True. Before the first and after
    the last sample they are constant.

    When `simulate` starts, ValueError for wrong shapes and times that do not increase.

    >>> ramp = axode.drives.Sampled([0.0, 1.0], np.array([np.zeros(7), np.ones(7)]))
    >>> ramp.on(arm)(0.25, np.zeros(7), np.zeros(7))
    array([0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25])
    """

    def __init__(self, t: ArrayLike, tau: ArrayLike, hold: bool = False):
        self.t = t
        self.tau = tau
        self.hold = hold

    def on(self, m: Model) -> _axode.Drive:
        """Returns the drive as a function (t, q, v) -> tau (nv,) for model m."""
        return _axode.sampled_drive(m, self.t, self.tau, self.hold)


class PD:
    """tau = kp (q (-) q_now) + kd (v - v_now) + feedforward, with the difference on the group of configurations.

    kp (N m/rad, N/m) and kd (N m s/rad, N s/m): a number, or (nv,). With gains of 0 a joint, or a free base, is not
    controlled; gains of passive joints are taken as 0.
    q: the reference configuration (nq,), or a Trajectory, which has velocities as well: of a simulation, through samples,
        by functions of time, or a profile. The reference is at rest before a trajectory begins and after it ends.
    v: (nv,), 0 if left out. feedforward: (nv,), or a `Sampled`. clip: whether tau is limited to the effort limits of
        the joints. When `simulate` starts, ValueError for wrong shapes and for gains that are negative or not finite.

    >>> held = axode.simulate(arm, np.zeros(7), np.zeros(7), until=2.0,
    ...                       tau=axode.drives.PD(500.0, 60.0, np.full(7, 0.3),
    ...                                           feedforward=axode.gravity_torques(arm, np.full(7, 0.3))))
    >>> bool(np.allclose(held.q[-1], 0.3, atol=1e-2))
    True
    """

    def __init__(self, kp: ArrayLike, kd: ArrayLike, q: ArrayLike | Trajectory, v: ArrayLike | None = None,
                 feedforward: ArrayLike | Sampled | None = None, clip: bool = False):
        self.kp = kp
        self.kd = kd
        self.q = q
        self.v = v
        self.feedforward = feedforward
        self.clip = clip

    def on(self, m: Model) -> _axode.Drive:
        """The function (t, q, v) -> tau, (nv,)."""
        forward = self.feedforward.on(m) if isinstance(self.feedforward, Sampled) else self.feedforward
        return _axode.pd_drive(m, self.kp, self.kd, self.q, self.v, forward, self.clip)


class ComputedTorque:
    """tau = ID(q_now, v_now, a + kd (v - v_now) + kp (q (-) q_now)) minus the spring forces of the mechanism.

    The deviation x follows x'' + kd x' + kp x = 0: kp in 1/s^2, kd in 1/s, a number or (nv,).

    q, v, a: the reference, as in `PD`; a Trajectory has all three. Loads and joint losses of the simulation are not
    compensated. Passive joints get no force. With loops or passive joints, x is the deviation of the drives; their
    accelerations are the wanted ones as far as the drives can produce them, and tau is the result of
    `inverse_dynamics` with loops for this motion. ValueError as for `PD`.

    >>> there = axode.simulate(arm, np.zeros(7), np.ones(7), until=0.5, method="rk4", step=1e-3)
    >>> back = axode.simulate(arm, np.zeros(7), np.ones(7), until=0.5, tau=axode.drives.ComputedTorque(100.0, 20.0, there))
    >>> bool(np.allclose(back.q[-1], there.q[-1], atol=1e-6))
    True
    """

    def __init__(self, kp: ArrayLike, kd: ArrayLike, q: ArrayLike | Trajectory, v: ArrayLike | None = None,
                 a: ArrayLike | None = None):
        self.kp = kp
        self.kd = kd
        self.q = q
        self.v = v
        self.a = a

    def on(self, m: Model) -> _axode.Drive:
        """The function (t, q, v) -> tau, (nv,)."""
        return _axode.computed_torque_drive(m, self.kp, self.kd, self.q, self.v, self.a)


def quintic_profile(m: Model, start: ArrayLike, goal: ArrayLike, *, acceleration: ArrayLike,
                    velocity: ArrayLike | None = None) -> Trajectory:
    """The motion from start to goal by polynomials of degree 5 in time, with continuous accelerations.

    start, goal: (nq,). acceleration (rad/s^2, m/s^2) and velocity (rad/s, m/s) are the largest ones of each velocity: a
    number, or (nv,). If velocity is left out, it is the limit of the mechanism, which may be infinite. The time is the
    shortest within these limits.

    ValueError for wrong shapes, numbers that are not finite, a goal outside the limits of the joints, and limits that are
    not positive.

    >>> motion = axode.drives.quintic_profile(arm, np.zeros(7), np.full(7, 0.6), acceleration=2.0, velocity=0.5)
    >>> [round(float(x), 9) for x in (motion.t[-1], motion.q[-1, 0], np.max(motion.v))]
    [2.25, 0.6, 0.5]
    >>> followed = axode.simulate(arm, np.zeros(7), np.zeros(7), 2.25, tau=axode.drives.ComputedTorque(400.0, 40.0, motion))
    >>> bool(np.allclose(followed.q[-1], 0.6, atol=1e-5))
    True
    """
    return _axode.quintic_profile(m, start, goal, acceleration, velocity)


def trapezoidal_profile(m: Model, start: ArrayLike, goal: ArrayLike, *, acceleration: ArrayLike,
                        velocity: ArrayLike | None = None) -> Trajectory:
    """The fastest motion from start to goal: constant acceleration, constant velocity, constant deceleration.

    Arguments and errors are those of `quintic_profile`. Accelerations jump. A joint that does not reach its velocity
    limit has no phase of constant velocity; the profiles of the faster joints are stretched in time.

    >>> motion = axode.drives.trapezoidal_profile(arm, np.zeros(7), np.full(7, 0.6), acceleration=2.0, velocity=0.5)
    >>> [round(float(x), 9) for x in (motion.t[-1], np.max(motion.v), np.max(motion.a))]
    [1.45, 0.5, 2.0]
    """
    return _axode.trapezoidal_profile(m, start, goal, acceleration, velocity)


def jerk_limited_profile(m: Model, start: ArrayLike, goal: ArrayLike, *, acceleration: ArrayLike, jerk: ArrayLike,
                         velocity: ArrayLike | None = None) -> Trajectory:
    """The fastest motion from start to goal within limits of velocity, acceleration and jerk, by Ruckig.

    jerk (rad/s^3, m/s^3): a number, or (nv,). Other arguments and errors are those of `quintic_profile`. Ruckig
    (Berscheid and Kroeger 2021) is a package of its own, `pip install ruckig`; ImportError without it. RuntimeError if it
    finds no motion.

    >>> limits = {"acceleration": 2.0, "jerk": 20.0, "velocity": 0.5}
    >>> motion = axode.drives.jerk_limited_profile(arm, np.zeros(7), np.full(7, 0.6), **limits)
    >>> [round(float(x), 9) for x in (motion.t[-1], np.max(motion.v), np.max(motion.a))]
    [1.55, 0.5, 2.0]
    """
    try:
        import ruckig  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError as error:
        raise ImportError("axode.drives.jerk_limited_profile needs Ruckig: pip install ruckig") from error
    path = _axode.straight_path(m, start, goal)
    lengths = np.array(path.lengths)
    limits = (path.velocity_limits(velocity), path.limits("acceleration", acceleration), path.limits("jerk", jerk))
    v, a, j = (np.array(of_joints) / lengths for of_joints in limits)
    if not path.lengths:
        return path.follow([], 0.0, lambda t: ([], [], []))
    # Tolerances of Ruckig are absolute, so that distances are in units of the
    # lengths, and times in units of the longest time that a limit demands. A joint
    # that needs less than a tenth of it waits for others within these limits as well.
    least = np.max([1 / v, a**-0.5, np.cbrt(1 / j)], axis=0)
    unit = np.max(least)
    waits = least < unit / 10
    given = ruckig.InputParameter(len(lengths))
    given.target_position = [1.0] * len(lengths)
    given.max_velocity = np.where(waits, 10, v * unit).tolist()
    given.max_acceleration = np.where(waits, 100, a * unit**2).tolist()
    given.max_jerk = np.where(waits, 1000, j * unit**3).tolist()
    found = ruckig.Trajectory(len(lengths))
    try:
        ruckig.Ruckig(len(lengths)).calculate(given, found)
    except (ruckig.RuckigError, ValueError) as error:
        raise RuntimeError(f"jerk_limited_profile: Ruckig finds no motion from start to goal: {error}") from error
    scale = lengths / found.at_time(found.duration)[0]
    jumps = np.concatenate([np.cumsum(joint.t) for joint in found.profiles[0]])

    def distances(t: float) -> tuple[list[float], list[float], list[float]]:
        s, ds, dds = (scale * x for x in found.at_time(t / unit))
        return s.tolist(), (ds / unit).tolist(), (dds / unit**2).tolist()
    return path.follow((unit * jumps[jumps < found.duration]).tolist(), float(unit * found.duration), distances)


class MotorMotion(NamedTuple):
    """The motors of elastic drives, referred to their joints: arrays (nv,) or (N, nv), 0 where there is no drive."""

    position: NDArray[np.float64]  #: rad or m; 0 at joints with several velocities
    velocity: NDArray[np.float64]  #: rad/s or m/s
    force: NDArray[np.float64]  #: N m or N


def elastic_feed_forward(m: Model, q: ArrayLike, v: ArrayLike, a: ArrayLike, jerk: ArrayLike, snap: ArrayLike,
                         stiffness: ArrayLike, inertia: ArrayLike = 0.0,
                         loads: Sequence[Load] | None = None) -> MotorMotion:
    """How motors before springs must move, and which forces they need, so that the joints follow a motion exactly.

    q (nq,) or (N, nq) with v, a, jerk and snap: the motion of all joints. That of a parallel manipulator comes from
        `TaskSpace.inverse_dynamics_rates`; loops are counted.
    stiffness (N m/rad, N/m) of the springs and inertia (kg m^2, kg) of the motors behind their gears: a number, or (nv,).
        np.inf is a rigid drive, as joints with several velocities need.

    With the drive forces Q of the motion, theta = q + Q/k, theta' = v + Q'/k and u = Q + I (a + Q''/k) (eq. (D17.18)): the
    start must be on this motion. ValueError for a stiffness that is not positive, a negative inertia, or a spring at a
    joint with several velocities.

    >>> motion = np.full(7, 0.3), np.ones(7), np.zeros(7), np.zeros(7), np.zeros(7)
    >>> motors = axode.drives.elastic_feed_forward(arm, *motion, stiffness=2000.0, inertia=0.3)
    >>> bool(np.allclose(2000 * (motors.position - 0.3), axode.inverse_dynamics(arm, *motion[:3])))
    True
    """
    Q, dQ, ddQ = _axode.inverse_dynamics_rates(m, q, v, a, jerk, snap, loads=loads)
    k, I = (np.broadcast_to(np.asarray(x, float), (m.nv,)) for x in (stiffness, inertia))
    coordinate = np.full(m.nv, -1)
    driven = np.ones(m.nv, bool)
    for joint in m.joints:
        if joint.nv == 1:
            coordinate[joint.v] = joint.q.start
        elif joint.nv > 1 and not joint.passive and np.isfinite(k[joint.v]).any():
            raise ValueError(f"stiffness: joint \"{joint.name}\" has {joint.nv} velocities and no angle for a spring; "
                             "its stiffness must be np.inf")
        if joint.passive:
            driven[joint.v] = False
    if not (k[driven] > 0).all():
        raise ValueError(f"stiffness has {k[driven].min():g}; it must be positive (np.inf is a rigid drive)")
    if not ((I >= 0) & np.isfinite(I)).all():
        raise ValueError("inertia has a number that is negative or not finite")
    positions = np.where(coordinate < 0, 0.0, np.asarray(q, float)[..., coordinate])
    position = np.where(coordinate < 0, 0.0, positions + Q / k)
    return MotorMotion(*(np.where(driven, x, 0.0) for x in (position, v + dQ / k, Q + I * (a + ddQ / k))))


signatures.explain_calls(__name__)
