"""Swing an acrobot up and lead an arm's flange to a point: direct collocation with CasADi, IPOPT and exact Hessians."""

# %% [markdown]
# The time is cut into intervals. On each of them the states are polynomials through its first point and three
# points of Radau, where q' = v and v' = a(q, v, tau) hold; the forces are constant. All these states and
# forces are the unknowns of one optimisation, and `axode.casadi.function` gives a with its exact derivatives.

# %%
from typing import Any, NamedTuple

import axode
import axode.casadi
import casadi as ca  # type: ignore[import-not-found, unused-ignore]
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Motion(NamedTuple):
    """States (points, n) and forces (intervals, nv), the length of an interval, and the status that IPOPT returned."""

    q: Array
    v: Array
    tau: Array
    step: float
    status: str
    iterations: int


def derivatives(intervals: int, degree: int) -> Any:
    """D: if x has the values of polynomials at all points, x D has those of their derivatives at all but the first, per interval."""
    D = ca.DM(intervals * degree + 1, intervals * degree)
    for first in range(0, intervals * degree, degree):
        D[first:first + degree + 1, first:first + degree] = ca.collocation_coeff(ca.collocation_points(degree, "radau"))[0]
    return D


def least_forces(m: axode.Model, seconds: float, intervals: int, start: Array, guess: Array, effort: Array, speed: Array,
                 end: Any, degree: int = 3) -> Motion:
    """A motion from rest with a least integral of the squares of tau / effort, where end(q) = 0 at rest.

    Joints whose effort is 0 have no drive; none turns faster than its speed.
    """
    step, points = seconds / intervals, intervals * degree + 1
    q, v, u = ca.MX.sym("q", m.nq, points), ca.MX.sym("v", m.nv, points), ca.MX.sym("u", m.nv, intervals)
    forces = effort * ca.horzcat(*[u[:, k] for k in range(intervals) for _ in range(degree)])
    a = axode.casadi.function(m, "forward_dynamics", points - 1)(q[:, 1:], v[:, 1:], forces)
    D = derivatives(intervals, degree)
    equations = [end(q[:, -1]), ca.vec(q @ D - step * v[:, 1:]), ca.vec(v @ D - step * a)]
    cost = step * ca.sumsqr(u)

    upper = np.full((m.nq + m.nv, points), np.inf)
    upper[m.nq:] = speed[:, None]
    lower = -upper
    for bound in (lower, upper):
        bound[:, 0] = np.concatenate([start, np.zeros(m.nv)])
        bound[m.nq:, -1] = 0

    def column(x: Array, y: Array) -> Array:
        return np.concatenate([x[:m.nq].ravel("F"), x[m.nq:].ravel("F"), y.ravel("F")])

    driven = np.repeat((effort > 0)[:, None], intervals, axis=1).astype(float)
    solver = ca.nlpsol("solver", "ipopt", {"x": ca.veccat(q, v, u), "f": cost, "g": ca.vertcat(*equations)},
                       {"ipopt": {"print_level": 0, "sb": "yes"}, "print_time": False})
    ramp = np.linspace(start, guess, points).T
    rates = np.repeat((guess - start)[:, None] / seconds, points, axis=1)
    solved = solver(x0=column(np.vstack([ramp, rates]), 0 * driven), lbx=column(lower, -driven), ubx=column(upper, driven),
                    lbg=0, ubg=0)
    x = np.array(solved["x"]).ravel()
    cuts = [m.nq * points, (m.nq + m.nv) * points]
    q_found, v_found, u_found = (part.reshape(-1, m.nv) for part in np.split(x, cuts))
    return Motion(q_found, v_found, u_found * effort, step, solver.stats()["return_status"], solver.stats()["iter_count"])


def off_when_simulated(m: axode.Model, motion: Motion, degree: int = 3, steps: int = 40) -> float:
    """The largest differences, in rad and rad/s, between the ends of the intervals and simulations of each interval
    by the library."""
    tau = np.repeat(motion.tau[:, None], steps, axis=1)
    q, v = axode.rollout(m, motion.q[:-1:degree], motion.v[:-1:degree], tau, motion.step / steps)
    return float(max(np.abs(q[:, -1] - motion.q[degree::degree]).max(), np.abs(v[:, -1] - motion.v[degree::degree]).max()))


# %% [markdown]
# The acrobot is a double pendulum without a drive at its pin. From hanging it has to stand on its head.

# %%
acrobot = axode.load(axode.robots / "double_pendulum.toml")
upright = np.array([np.pi, 0.0])
swing = least_forces(acrobot, seconds=4.0, intervals=120, start=np.zeros(2), guess=upright, effort=np.array([0.0, 20.0]),
                     speed=np.full(2, np.inf), end=lambda q: q - upright)
print(f"acrobot: {swing.status} after {swing.iterations} iterations; the elbow needs {np.abs(swing.tau).max():.2f} N m")
print(f"simulated it is off by {off_when_simulated(acrobot, swing):.0e}")

# %% [markdown]
# The arm's flange shall be at a point after a second, in whatever configuration that is cheapest. The pose of
# the flange is a function with exact derivatives as well.

# %%
arm = axode.load(axode.robots / "arm7.toml")
target = np.array([0.5, 0.3, 0.6])
pose = axode.casadi.function(arm, ("pose", "flange"))
effort, speed = (np.array([getattr(joint, limit)[0] for joint in arm.joints]) for limit in ("effort", "velocity"))
reach = least_forces(arm, seconds=1.0, intervals=20, start=arm.neutral(), guess=np.full(7, 0.3), effort=effort,
                     speed=speed, end=lambda q: pose(q)[:3, 3] - target)
flange = axode.poses(arm, reach.q[-1])[arm.frame_index("flange"), :3, 3]
print(f"arm: {reach.status} after {reach.iterations} iterations; {100 * np.abs(reach.tau / effort).max():.0f} % of the drives' torques")
print(f"the flange is {np.linalg.norm(flange - target):.0e} m from the target; simulated the joints are off by "
      f"{off_when_simulated(arm, reach):.0e}")
