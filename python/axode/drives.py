"""Drives for `simulate` and `rollout` that are computed without calls into Python: samples and controllers.

A drive is the argument `tau` of `axode.simulate` and `axode.rollout`; `on(m)` is the drive of a mechanism m as a
function (t, q, v) -> tau.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from . import _axode
from .support import signatures
from ._axode import Model, Trajectory

__all__ = ["PD", "ComputedTorque", "Sampled"]


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
        """The function (t, q, v) -> tau, (nv,)."""
        return _axode.sampled_drive(m, self.t, self.tau, self.hold)


class PD:
    """tau = kp (q (-) q_now) + kd (v - v_now) + feedforward, with the difference on the group of configurations.

    kp (N m/rad, N/m) and kd (N m s/rad, N s/m): a number, or (nv,). With gains of 0 a joint, or a free base, is not
    controlled; gains of passive joints are taken as 0.
    q: the reference configuration (nq,), or a Trajectory, which has velocities as well. The reference is at rest
        before a trajectory begins and after it ends.
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


signatures.explain_calls(__name__)
