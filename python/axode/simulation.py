"""Motion in time: `simulate`, `rollout` and `reconstruct`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _axode
from .support import signatures
from ._axode import Model, Trajectory
from .codegen import Specialised
from .drives import PD, ComputedTorque, Sampled
from .errors import SimulationError, StatesError
from .support.progress import progress_bar
from .records import Load, Rollout

__all__ = ["reconstruct", "rollout", "simulate"]

Array = NDArray[np.float64]


def simulate(m: Model, q: ArrayLike, v: ArrayLike, until: float, *,
             method: Literal["dopri5", "rk4", "euler", "generalized_alpha", "generalized_alpha_index3", "midpoint",
                             "suzuki4", "kahan_li6", "rk4_momenta", "rattle", "rattle_suzuki4", "rattle_kahan_li6",
                             "half_explicit", "contact", "contact_adaptive", "contact_exact"] | None = None,
             coordinates: Literal["relative", "absolute", "absolute_SO3xR3", "absolute_by_joint"] = "relative",
             local_coordinates: Literal["exponential", "cayley"] = "exponential",
             step: float | None = None, rtol: float = 1e-8, atol: float = 1e-10, spectral_radius: float = 0.8,
             tau: ArrayLike | Callable[[float, Array, Array], ArrayLike] | Sampled | PD | ComputedTorque | None = None,
             loads: Sequence[Load] | Callable[[float, Array, Array], Sequence[Load]] | None = None,
             joint_losses: bool = False, times: ArrayLike | None = None,
             events: Sequence[Callable[[float, Array, Array], float]] | None = None,
             motions: Mapping[str, Callable[[float], ArrayLike]] | None = None, x: ArrayLike | None = None,
             contact: bool | None = None, progress: bool = False) -> Trajectory:
    """Simulates a mechanism from (q, v) at t = 0 until a time (s), on the Lie group of its configurations.

    method: "dopri5" takes steps as long as rtol and atol allow, errors being measured in the algebra (rad, m; rad/s,
        m/s), `step` being the first; "rk4" (fourth order) and "euler" (first order, semi-implicit) take steps of
        `step` s; so does "generalized_alpha", an implicit method of second order for stiff systems, which damps what
        oscillates quickly (in a step to `spectral_radius` of it). Every explicit method is Munthe-Kaas': no
        coordinates are singular, and quaternions stay on the sphere. Symplectic methods on (q, p), for which errors of
        the energy stay bounded, are "midpoint" (second order, implicit), and "suzuki4" and "kahan_li6" (fourth and sixth
        order), which are composed of midpoint steps; "rk4_momenta" is an explicit method on (q, p). All four keep the
        momentum of floating bases to rounding, and do not support events, stops and dry friction. Every method keeps
        loops closed; the symplectic methods on (q, p) do not support rolling contacts. "contact" takes steps in which
        collision shapes touch with Coulomb's friction, and joints stop at hard stops; "contact_adaptive" takes such steps
        as long as rtol and atol allow; "contact_exact", for few contacts, integrates smooth phases as "dopri5" does and finds
        impacts, stick and slip as roots, see `contact_events`. The default is "dopri5", or "contact" if the drawing has
        `[contact]`.
    coordinates: coordinates of the integration; results are always joint coordinates. "relative": those of the joints;
        "absolute": bodies are points of SE(3), and every joint is a constraint; "absolute_SO3xR3": of SO(3) x R^3;
        "absolute_by_joint": of SE(3) if a joint on the ground constrains the body, and of SO(3) x R^3 otherwise. In
        absolute ones "dopri5", "rk4" and "euler" bring joints and loops back after each step, and others hold them:
        "rattle", "rattle_suzuki4" and "rattle_kahan_li6" (of second, fourth and sixth order, no events; symplectic, or with
        rolling contacts only symmetric), "half_explicit" (third order), "generalized_alpha" (stabilised, index 2) and
        "generalized_alpha_index3".
    local_coordinates: those of a step on the group. With "cayley" every method keeps its order; those of second order err
        more where a body turns fast (docs/integration.md). In absolute coordinates only explicit methods take it.
    tau: drive forces, (nv,) for constant ones; one of `axode.drives`; or a function (t, q, v) -> (nv,), called for each
        evaluation. Springs, dampers and stops of the mechanism act in addition, see `spring_forces`.
    loads: wrenches on frames, constant in their representations, or a function (t, q, v) -> such wrenches, called for each
        evaluation.
    joint_losses: whether damping, dry friction and losses of gears act. A joint at rest sticks as long as its friction can
        hold it; steps end where a joint comes to rest or begins to slide, so that one of given length becomes two. In
        absolute coordinates such a joint creeps instead, the slower the shorter steps are.
    times: when states are wanted, increasing from 0 to until; without it, at the ends of the steps.
    events: functions (t, q, v) -> number whose zeros are met; `f.terminal = True` ends the motion there,
        `f.direction = 1` or -1 counts rising or falling ones alone. One that is met twice within a step is found where it
        goes towards zero at the beginning of the step and away from it at the end.
    motions: functions t -> (s, ds, dds) that joints of one velocity or lengths of rods follow, by the names of these,
        in addition to those of the drawing; the derivatives must be exact. They act with every method, in all coordinates.
        One that cannot be followed ends the motion.
    x: the states of the drives at t = 0, in the order of `drive_states` of the motion; if left out, those with which the
        drives start by themselves.
    contact: whether shapes touch, by the method "contact"; if left out, they do if the drawing has `[contact]` and no other
        method is named. Steps are 1 ms if `step` is left out. `certificates` of the motion say for each step how exactly
        the laws of contact hold, 1e-12 being rounding; `contacts` and `contact_forces` have the forces.
    progress: whether a bar is shown, which needs tqdm (`pip install tqdm`).

    ValueError for wrong shapes, numbers that are not finite, until < 0 and step <= 0. SimulationError, with the
    motion so far, if accelerations cannot be computed or are not finite. Ctrl-C ends the call.

    >>> fall = axode.simulate(arm, np.full(7, 0.1), np.zeros(7), until=1.0, times=[0, 0.5, 1])
    >>> fall.q.shape, bool(np.ptp(fall.energy) < 1e-6)
    ((3, 7), True)
    """
    if isinstance(tau, (Sampled, PD, ComputedTorque)):
        tau = tau.on(m)
    _check_contact(contact)
    if contact is not None:
        if method is not None and method.startswith("contact") != contact:
            raise ValueError(f"contact is {contact} and method is {method!r}; leave one of them out")
        method = method or ("contact" if contact else "dopri5")
    bar, report = None, None
    if progress:
        bar = progress_bar(float(until), unit="s", bar_format="{l_bar}{bar}| {n:.3g}/{total:.3g} s [{remaining}]")

        def report(t: float) -> None:
            bar.update(t - bar.n)
    try:
        motion = _axode.simulate_motion(m, q, v, float(until), method, coordinates, local_coordinates, step, rtol, atol,
                                        spectral_radius, tau, loads, joint_losses, times, list(events or []), motions,
                                        x, report)
    finally:
        if bar is not None:
            bar.close()
    if not motion.complete:
        raise SimulationError(motion.stop_reason, motion)
    return motion


def rollout(m: Model | Specialised, q: ArrayLike, v: ArrayLike,
            tau: ArrayLike | Callable[[float, Array, Array], ArrayLike] | Sampled | PD | ComputedTorque, step: float, *,
            steps: int | None = None, joint_losses: bool = False, threads: int = 1, contact: bool | None = None,
            x: ArrayLike | None = None) -> Rollout:
    """(q, v): the states of N motions of K steps of `step` s, (N, K + 1, nq) and (N, K + 1, nv), beginning with the
    given ones.

    q (N, nq) and v (N, nv) are the initial states, and tau (N, K, nv) the drive forces, which are constant in each
    step; for one motion all arrays are without the axis N. If `steps` is K, tau may instead be one of `axode.drives`
    for all motions, which acts as in `simulate` at every stage of a step, from t = 0 on; or constant forces (nv,); or
    a function (t, q, v) -> (N, nv), which is called once for each step with all states. Springs of the mechanism act
    in addition, and loops are closed again after each step. The method is Munthe-Kaas' of fourth order, as in
    `simulate` with method="rk4". Everything except functions in Python runs in `threads` threads; several motions are
    computed at once in SIMD lanes if there are no springs, loops, coupled joints and dry friction.
    joint_losses: whether damping and dry friction act, as in `simulate`. m may be a model that is specialised with
    forward_dynamics, which is several times as fast; then lanes are also used for coupled joints, and if it is in
    float32, so are the motions.
    x: the states of the drives of the mechanism at t = 0, (nx,) or (N, nx), in the order of `drive_states` of `simulate`; if
        left out, those with which the drives start by themselves. The result has their states in `x`, (N, K + 1, nx). Their
        inputs are functions of time from t = 0 on, and parts of a step end where an input jumps or a drive reaches a limit,
        so that motions are those of `simulate` to the last bit. If tau is a function, the drives choose anew at each step
        which limits hold, and there must not be dry friction with joint_losses.
    contact: whether shapes touch and hard stops stop, as in `simulate` with method="contact", which steps in double
    precision and takes no specialised model. If left out, they do if the drawing has `[contact]`. The result then has
    `certificates`, see `Rollout`. Motions are those of `simulate` to the last bit, unless tau is a function: then the solver
    of contacts begins anew after each step, so that motions differ by its tolerance, and by more where friction at several
    points has more than one solution.

    ValueError for wrong shapes, numbers that are not finite, a drive of another mechanism, loops that are open at
    first and step <= 0. StatesError, with q, if a motion cannot continue: SingularError or NotFiniteError without contact.
    Its later states are NaN, and those of all motions if tau is a function.

    >>> q, v = axode.rollout(arm, np.zeros((5, 7)), np.zeros((5, 7)), np.ones((5, 20, 7)), 1e-3)
    >>> q.shape
    (5, 21, 7)
    >>> q, v = axode.rollout(arm, q[:, -1], v[:, -1], lambda t, q, v: -q - 0.1 * v, 1e-3, steps=100)
    >>> q.shape
    (5, 101, 7)
    >>> q, v = axode.rollout(arm, q[:, -1], v[:, -1], axode.drives.ComputedTorque(100.0, 20.0, np.zeros(7)), 1e-3, steps=900)
    >>> bool(np.max(np.abs(q[:, -1])) < 1e-2)
    True
    """
    compiled = m if isinstance(m, Specialised) else None
    model = m.model if isinstance(m, Specialised) else m
    _check_contact(contact)
    touches = _axode.has_contact(model) if contact is None else bool(contact)
    if touches and compiled is not None:
        raise ValueError(f"contact: code that is compiled for {model.name!r} has no contact; give the model, or contact=False")
    shapes = _axode.contact_shapes(model) if touches else None
    if isinstance(tau, (Sampled, PD, ComputedTorque)):
        tau = tau.on(model)
    given: dict[str, Any] = {"threads": threads, "joint_losses": joint_losses}

    def under(q: ArrayLike, v: ArrayLike, tau: ArrayLike, x: ArrayLike | None, t: float = 0.0) -> Rollout:
        if shapes is None:
            return _without_contact(_axode.rollout_under(model, q, v, tau, step, compiled, x=x, t=t, **given))
        return Rollout(*_axode.contact_rollout_under(model, shapes, q, v, tau, step, x=x, t=t, **given))

    if steps is None:
        if callable(tau):
            raise ValueError("steps is missing; a function or a drive as tau needs the number of steps")
        return under(q, v, tau, x)
    if steps < 0:
        raise ValueError(f"steps is {steps}; it must not be negative")
    if not callable(tau):
        if np.ndim(tau) != 1:
            raise ValueError("steps is for functions, drives and constant forces (nv,); tau has forces for each step")
        tau = Sampled([0.0], np.asarray(tau)[None]).on(model)
    if isinstance(tau, _axode.Drive):
        if shapes is None:
            return _without_contact(_axode.rollout_driven(model, q, v, tau, steps, step, compiled, x=x, **given))
        return Rollout(*_axode.contact_rollout_driven(model, shapes, q, v, tau, steps, step, x=x, **given))
    q_0, v_0 = np.asarray(q, dtype=np.float64), np.asarray(v, dtype=np.float64)
    begun = under(q_0, v_0, np.empty((*q_0.shape[:-1], 0, model.nv)), x)
    q_k, v_k = begun
    all_q = np.full((*q_0.shape[:-1], steps + 1, model.nq), np.nan, q_k.dtype)
    all_v = np.full((*q_0.shape[:-1], steps + 1, model.nv), np.nan, v_k.dtype)
    certificates = None if shapes is None else np.full((*q_0.shape[:-1], steps), np.nan)
    all_q[..., :1, :], all_v[..., :1, :] = q_k, v_k
    all_x = np.full((*begun.x.shape[:-2], steps + 1, begun.x.shape[-1]), np.nan)
    all_x[..., :1, :] = begun.x
    for k in range(steps):
        q_k, v_k = all_q[..., k, :], all_v[..., k, :]
        forces = np.asarray(tau(k * step, q_k.copy(), v_k.copy()), dtype=np.float64)
        if forces.shape != v_k.shape:
            raise ValueError(f"tau(t, q, v): expected shape {v_k.shape}, got {forces.shape}")
        try:
            made = under(q_k, v_k, forces[..., None, :], all_x[..., k, :], k * step)
        except StatesError as error:
            all_q[..., k:k + 2, :] = error.result
            error.result = all_q
            raise
        all_q[..., k + 1, :], all_v[..., k + 1, :] = made.q[..., 1, :], made.v[..., 1, :]
        all_x[..., k + 1, :] = made.x[..., 1, :]
        if certificates is not None:
            certificates[..., k:k + 1] = made.certificates
    return Rollout(all_q, all_v, certificates, all_x)


def _without_contact(made: tuple[Array, Array, Array]) -> Rollout:
    q, v, x = made
    return Rollout(q, v, None, x)


def _check_contact(contact: bool | None) -> None:
    if contact is not None and not isinstance(contact, (bool, np.bool_)):
        raise TypeError(f"contact: expected True, False or None, got {type(contact).__name__}")


def reconstruct(C0: ArrayLike, twist: ArrayLike | Callable[[float], ArrayLike], times: ArrayLike,
                representation: Literal["body", "spatial"] = "body", order: int = 4,
                method: Literal["munthe_kaas", "cayley", "magnus", "apart"] = "munthe_kaas") -> Array:
    """The poses (N, 4, 4) of a body at `times` (N,), from the pose C0 (4, 4) at the first and its twist.

    twist: a constant twist (6,); a function t -> (6,); or the values (N, 6) at the times, which are interpolated by
        cubics. Angular before linear; "body" is C^-1 C', "spatial" C' C^-1 (eqs. Vbs, Vdexp).
    order: of Munthe-Kaas' method on SE(3), 1 to 5; a step lies between any two times.
    method: "munthe_kaas", "cayley" (the same with Cayley's map), "magnus" (Magnus' series, of order 4, two twists a step)
        or "apart" (rotation and position separately, on SO(3) x R^3, for comparison).

    >>> screw = np.array([0, 0, np.pi / 2, 0, 0, 0.1])
    >>> axode.reconstruct(np.eye(4), screw, [0.0, 1.0])[-1].round(6)
    array([[ 0. , -1. ,  0. ,  0. ],
           [ 1. ,  0. ,  0. ,  0. ],
           [ 0. ,  0. ,  1. ,  0.1],
           [ 0. ,  0. ,  0. ,  1. ]])
    """
    t = np.asarray(times, dtype=np.float64)
    if t.ndim != 1:
        raise ValueError(f"times: expected shape (N,), got {t.shape}")
    at = t[:-1, None] + np.diff(t)[:, None] * _axode.stage_times(order, method)[None, :]
    if callable(twist):
        V = np.array([np.asarray(twist(float(x)), dtype=np.float64) for x in at.ravel()]).reshape(-1, 6)
    else:
        V = _sampled(np.asarray(twist, dtype=np.float64), t, at.ravel())
    return np.asarray(_axode.reconstruct_poses(C0, V.reshape(*at.shape, 6), t, representation, order, method))


def _sampled(given: Array, t: Array, at: Array) -> Array:
    """The twist as a function of time: constant, or a cubic through the four nearest samples."""
    if given.shape == (6,):
        return np.tile(given, (at.size, 1))
    if given.shape != (t.size, 6):
        raise ValueError(f"twist: expected shape (6,) or ({t.size}, 6), as times has, or a function, got {given.shape}")
    n = min(4, t.size)
    first = np.clip(np.searchsorted(t, at, side="right") - 2, 0, t.size - n)
    near = first[:, None] + np.arange(n)
    out: Any = 0.0
    for k in range(n):
        others = [j for j in range(n) if j != k]
        weight = np.prod([(at - t[near[:, j]]) / (t[near[:, k]] - t[near[:, j]]) for j in others], axis=0)
        out = out + np.broadcast_to(weight, at.shape)[:, None] * given[near[:, k]]
    return np.asarray(out)


signatures.explain_calls(__name__)
