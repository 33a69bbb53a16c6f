"""axode in JAX: functions to which `jax.jit`, `jax.vmap`, `jax.grad` and the other transformations apply.

They have the names and the order of arguments of axode's own functions. Arrays may have any axes in front, which are
broadcast; under `jax.vmap` all states go to the library in one call. float32 is computed as float64 and rounded;
results have the type of the arguments. A model is static: close over it, or make it a static argument. Derivatives by
q are those by its nq numbers, where quaternions are divided by their norm; a norm that differs from 1 by more than
1e-6 (1e-4 in float32) is an error. A state without a result, because its mass matrix is singular or its numbers
overflow, has NaN.

The functions compute on the CPU. This needs JAX (pip install jax).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

try:
    import jax  # type: ignore[import-not-found, unused-ignore]
    import jax.numpy as jnp  # type: ignore[import-not-found, unused-ignore]
except ImportError as error:
    raise ImportError('axode.jax needs JAX: pip install jax') from error

from ..support import signatures
from .._axode import Model, check_counts, shape_pairs
from ..support.contact_motions import PARAMETERS
from .calls import distances_of, motion, state_function, twists_by
from .contact import contact_motion
from .mechanism import Array, Mechanism, cross, integrated, mechanism_of, rates_of, velocities_of

__all__ = [
    "accelerations", "center_of_mass", "contact_rollout", "coordinate_rates", "coriolis_vector", "forward_dynamics",
    "gravity_torques", "integrate", "inverse_dynamics", "inverse_mass_matrix", "jacobian", "kinetic_energy", "mass_matrix",
    "momenta", "pair_distances", "poses", "potential_energy", "rollout", "twists", "velocities_from_rates",
]

Representation = Literal["body", "spatial", "hybrid", "mixed"]


def inverse_dynamics(m: Model, q: Array, v: Array, a: Array, *, parameters: Array | None = None,
                     joint_losses: bool = False, threads: int = 1) -> Array:
    """The drive forces (..., nv) that produce the accelerations a, see `axode.inverse_dynamics`.

    `parameters` (..., 10 n_bodies) replace `m.parameters`; for each run of states with different parameters a model
    is built. First and second derivatives exist; by the parameters only first ones. O(n); a product with the
    derivative or its transpose costs about the same again, a Hessian O(n^2). Loads on frames can be added with
    `jacobian`.

    >>> q = jnp.full(7, 0.3)
    >>> axode.jax.inverse_dynamics(arm, q, 0 * q, 0 * q).shape
    (7,)
    """
    of = _without_loops(m, "inverse_dynamics")
    given = _arrays(of, q=q, v=v, a=a, **({} if parameters is None else {"parameters": parameters}))
    return state_function("inverse_dynamics", of, *given, joint_losses=bool(joint_losses), parameters=parameters is not None,
                          threads=_positive(threads))


def forward_dynamics(m: Model, q: Array, v: Array, tau: Array, *, parameters: Array | None = None,
                     joint_losses: bool = False, threads: int = 1) -> Array:
    """The accelerations (..., nv) that the drive forces tau produce, see `axode.forward_dynamics`; NaN if M is
    singular.

    Parameters, derivatives and costs are those of `inverse_dynamics`; a Hessian takes O(n^3).

    >>> q = jnp.full(7, 0.3)
    >>> tau = axode.jax.inverse_dynamics(arm, q, 0 * q, q)
    >>> bool(jnp.allclose(axode.jax.forward_dynamics(arm, q, 0 * q, tau), q, atol=1e-4))
    True
    """
    of = _without_loops(m, "forward_dynamics")
    given = _arrays(of, q=q, v=v, tau=tau, **({} if parameters is None else {"parameters": parameters}))
    return state_function("forward_dynamics", of, *given, joint_losses=bool(joint_losses), parameters=parameters is not None,
                          threads=_positive(threads))


def mass_matrix(m: Model, q: Array, *, threads: int = 1) -> Array:
    """The mass matrix M (..., nv, nv), see `axode.mass_matrix`. First and second derivatives exist; a product with
    one costs O(n^2).

    >>> axode.jax.mass_matrix(arm, jnp.full(7, 0.3)).shape
    (7, 7)
    """
    of = mechanism_of(m, still=True)
    return state_function("mass_matrix", of, *_arrays(of, q=q), threads=_positive(threads))


def inverse_mass_matrix(m: Model, q: Array, *, threads: int = 1) -> Array:
    """The inverse mass matrix (..., nv, nv), see `axode.inverse_mass_matrix`; NaN if M is singular. First and second
    derivatives exist.

    >>> q = jnp.full(7, 0.3)
    >>> product = axode.jax.inverse_mass_matrix(arm, q) @ axode.jax.mass_matrix(arm, q)
    >>> bool(jnp.allclose(product, jnp.eye(7), atol=1e-3))
    True
    """
    of = mechanism_of(m, still=True)
    return state_function("inverse_mass_matrix", of, *_arrays(of, q=q), threads=_positive(threads))


def gravity_torques(m: Model, q: Array, *, threads: int = 1) -> Array:
    """The drive forces (..., nv) that hold the mechanism at rest, see `axode.gravity_torques`.

    >>> axode.jax.gravity_torques(arm, jnp.zeros(7)).shape
    (7,)
    """
    of = mechanism_of(m)
    (q,) = _arrays(of, q=q)
    none = _still(of, q)
    return state_function("inverse_dynamics", of, q, none, none, threads=_positive(threads))


def coriolis_vector(m: Model, q: Array, v: Array, *, threads: int = 1) -> Array:
    """The Coriolis vector C(q, v) v, (..., nv), see `axode.coriolis_vector`.

    >>> axode.jax.coriolis_vector(arm, jnp.zeros(7), jnp.ones(7)).shape
    (7,)
    """
    of = mechanism_of(m, still=True).still
    assert of is not None
    q, v = _arrays(of, q=q, v=v)
    return state_function("inverse_dynamics", of, q, v, jnp.zeros_like(v), threads=_positive(threads))


def momenta(m: Model, q: Array, v: Array, *, threads: int = 1) -> Array:
    """The generalised momenta p = M v, (..., nv), see `axode.momenta`; O(n), without the matrix M.

    >>> q, v = jnp.full(7, 0.3), jnp.ones(7)
    >>> bool(jnp.allclose(axode.jax.momenta(arm, q, v), axode.jax.mass_matrix(arm, q) @ v, atol=1e-4))
    True
    """
    of = mechanism_of(m, still=True).still
    assert of is not None
    q, v = _arrays(of, q=q, v=v)
    return state_function("inverse_dynamics", of, q, jnp.zeros_like(v), v, threads=_positive(threads))


def kinetic_energy(m: Model, q: Array, v: Array, *, threads: int = 1) -> Array:
    """Kinetic energy of bodies and armatures, (...), J, see `axode.kinetic_energy`. First and second derivatives.

    >>> q, v = jnp.full(7, 0.3), jnp.ones(7)
    >>> p = jax.grad(axode.jax.kinetic_energy, argnums=2)(arm, q, v)
    >>> bool(jnp.allclose(p, axode.jax.momenta(arm, q, v), atol=1e-4))
    True
    """
    _, v = _arrays(mechanism_of(m), q=q, v=v)
    return 0.5 * jnp.sum(v * momenta(m, q, v, threads=threads), axis=-1)


def potential_energy(m: Model, q: Array, *, threads: int = 1) -> Array:
    """Potential energy of gravity, (...), J, see `axode.potential_energy`. Derivatives of any order.

    >>> q = jnp.full(7, 0.3)
    >>> g = jax.grad(axode.jax.potential_energy, argnums=1)(arm, q)
    >>> bool(jnp.allclose(g, axode.jax.gravity_torques(arm, q), atol=1e-3))
    True
    """
    of = mechanism_of(m)
    (q,) = _arrays(of, q=q)
    return -_first_moment(of, q, _positive(threads)) @ of.gravity.astype(q.dtype)


def center_of_mass(m: Model, q: Array, *, threads: int = 1) -> Array:
    """Centre of mass of all moving bodies, (..., 3), m, in the inertial frame, see `axode.center_of_mass`. Derivatives of any order.

    >>> axode.jax.center_of_mass(arm, jnp.zeros(7)).shape
    (3,)
    """
    of = mechanism_of(m)
    (q,) = _arrays(of, q=q)
    return _first_moment(of, q, _positive(threads)) / of.parameters[:, 0].sum()


def poses(m: Model, q: Array, *, threads: int = 1) -> Array:
    """The poses (..., n_frames, 4, 4) of all frames in the order of `m.frame_names`, see `axode.poses`. Derivatives
    of any order.

    >>> axode.jax.poses(arm, jnp.zeros(7)).shape
    (10, 4, 4)
    """
    of = mechanism_of(m)
    (q,) = _arrays(of, q=q)
    R_r = jnp.swapaxes(_columns(of, q, _positive(threads)), -1, -2)
    last = jnp.broadcast_to(jnp.array([0, 0, 0, 1], dtype=q.dtype), (*R_r.shape[:-2], 1, 4))
    return jnp.concatenate([R_r, last], axis=-2)


def twists(m: Model, q: Array, v: Array, representation: Representation = "body", *, threads: int = 1) -> Array:
    """The twists (..., n_frames, 6) of all frames, rad/s and m/s, see `axode.twists`. Derivatives of any order.

    >>> axode.jax.twists(arm, jnp.zeros(7), jnp.ones(7), "hybrid").shape
    (10, 6)
    """
    of = mechanism_of(m)
    q, v = _arrays(of, q=q, v=v)
    screws = state_function("joint_screws", of, q, threads=_positive(threads))
    return _from_spatial(twists_by(of, of.moves_frame, screws, v), _columns(of, q, threads), representation)


def accelerations(m: Model, q: Array, v: Array, a: Array, representation: Representation = "body", *,
                  threads: int = 1) -> Array:
    """The time derivatives (..., n_frames, 6) of the components of `twists`, see `axode.accelerations`.

    >>> axode.jax.accelerations(arm, jnp.zeros(7), jnp.ones(7), jnp.ones(7), "hybrid").shape
    (10, 6)
    """
    of = mechanism_of(m)
    q, v, a = _arrays(of, q=q, v=v, a=a)
    return jax.jvp(lambda q, v: twists(m, q, v, representation, threads=threads), (q, v), (rates_of(of, q, v), a))[1]


def jacobian(m: Model, q: Array, frame: str | int, representation: Representation = "body", *, offset: Array | None = None,
             threads: int = 1) -> Array:
    """The Jacobian J (..., 6, nv) with V = J v, see `axode.jacobian`. It has derivatives of any order, also by the
    offset.

    A wrench on the frame in the same representation has the generalised forces J^T W, which can be added to the drive
    forces tau.

    >>> J = axode.jax.jacobian(arm, jnp.zeros(7), "flange", "hybrid", offset=[0, 0, 0.1])
    >>> push = J.T @ jnp.array([0, 0, 0, 0, 0, -50.0])
    >>> push.shape
    (7,)
    """
    of = mechanism_of(m)
    f = m.frame_index(frame) if isinstance(frame, str) else _number_of_frame(of, frame)
    (q,) = _arrays(of, q=q)
    screws = state_function("joint_screws", of, q, threads=_positive(threads))
    columns = _columns(of, q, threads)[..., f, :, :]
    if offset is not None:
        columns = _displaced(columns, jnp.asarray(offset, dtype=q.dtype))
    rates = (of.moves_frame[f][:, None] * of.screw_rates).astype(q.dtype)
    J = jnp.einsum("kv,...kc->...vc", rates, screws)
    return jnp.swapaxes(_from_spatial(J, columns[..., None, :, :], representation), -1, -2)


def pair_distances(m: Model, q: Array, pairs: Sequence[tuple[str, str]] | None = None, *, threads: int = 1) -> Array:
    """The signed distances (..., P) of P pairs of collision shapes, m, see `axode.pair_distances`. First derivatives.

    `pairs` are names of shapes; None: all pairs that may touch, as `axode.shape_pairs` lists them.

    >>> robot = axode.load(axode.robots / "quadruped.toml")
    >>> feet = [pair for pair in axode.shape_pairs(robot) if pair[0] == "floor"]
    >>> q = jnp.array(robot.neutral())
    >>> jax.jacobian(axode.jax.pair_distances, 1)(robot, q, feet).shape == (len(feet), robot.nq)
    True
    """
    of = mechanism_of(m)
    (q,) = _arrays(of, q=q)
    chosen = tuple((a, b) for a, b in (shape_pairs(m) if pairs is None else pairs))
    return distances_of(m, of, chosen, _positive(threads), q)


def rollout(m: Model, q: Array, v: Array, tau: Array, step: float, *, threads: int = 1) -> tuple[Array, Array]:
    """(q, v): the states of motions of K steps of `step` s: (..., K + 1, nq) and (..., K + 1, nv), see
    `axode.rollout` with contact=False.

    tau has shape (..., K, nv). First derivatives exist; a product with them costs O(n) for each step and stores only
    the states. If a motion cannot continue, its later states are NaN.

    >>> q, v = axode.jax.rollout(arm, jnp.zeros(7), jnp.zeros(7), jnp.ones((20, 7)), 1e-3)
    >>> q.shape
    (21, 7)
    """
    of = _without_loops(m, "rollout")
    if not isinstance(step, (int, float, np.integer, np.floating)):
        raise TypeError(f"step: expected a number, which programs are compiled for, got {type(step).__name__}")
    if not (np.isfinite(step) and step > 0):
        raise ValueError(f"step is {step}; it must be finite and above 0")
    q, v, tau = _arrays(of, rows=True, q=q, v=v, tau=tau)
    q_out, v_out = motion("rollout", of, q, v, tau, step=float(step), threads=_positive(threads))
    return q_out, v_out


def contact_rollout(m: Model, q: Array, v: Array, tau: Array, step: float, *, parameters: Array | None = None,
                    friction: Array | None = None, restitution: Array | None = None,
                    placement: Array | None = None) -> tuple[Array, Array]:
    """(q, v): the states (..., K + 1, nq) and (..., K + 1, nv) of motions with contact, with friction and damping of joints,
    under tau (..., K, nv), see `axode.rollout`.

    `parameters` (..., 10 n_bodies) replace `m.parameters`, and `friction` (..., n), `restitution` (..., n) and `placement`
    (..., 6 n) the properties of n collision shapes, see `axode.with_shapes`. First derivatives by all of them exist, see
    `axode.contact_rollout_derivatives`; contacts without a closed form are an error. XLA calls Python for each motion. If a motion
    cannot continue, its states are NaN.

    >>> box = {"kind": "box", "role": "collision", "size": [0.2, 0.2, 0.2], "friction": 0.2}
    >>> table = axode.Model.from_dict({"format": "axode drawing 1", "shape": [{"kind": "plane", "role": "collision"}],
    ...     "body": [{"name": "box", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [7e-3, 7e-3, 7e-3], "shape": [box]}]})
    >>> def speed(mu):
    ...     q, v = axode.jax.contact_rollout(table, jnp.array([0, 0, 0, 1, 0, 0, 0.1]), jnp.array([0, 0, 0, 1.0, 0, 0]),
    ...                                      jnp.zeros((5, 6)), 1e-2, friction=jnp.array([mu, mu]))
    ...     return v[-1, 3]
    >>> round(float(jax.grad(speed)(0.2)), 4)  # -g t
    -0.4905
    """
    of = mechanism_of(m)
    if not isinstance(step, (int, float, np.integer, np.floating)):
        raise TypeError(f"step: expected a number, which programs are compiled for, got {type(step).__name__}")
    if not (np.isfinite(step) and step > 0):
        raise ValueError(f"step is {step}; it must be finite and above 0")
    all_given = dict(zip(PARAMETERS, (parameters, friction, restitution, placement)))
    given = {name: x for name, x in all_given.items() if x is not None}
    q, v, tau, *theta = _arrays(of, rows=True, q=q, v=v, tau=tau, **given)
    layout = tuple((name, x.shape[-1]) for name, x in zip(given, theta))
    none = jnp.zeros((*q.shape[:-1], 0), q.dtype)
    path, velocities = contact_motion(m, of, layout, float(step), q, v, tau, jnp.concatenate([none, *theta], axis=-1))
    return path, velocities


def integrate(m: Model, q: Array, dv: Array) -> Array:
    """The configuration q (+) dv, (..., nq), see `Model.integrate`. It has derivatives of any order; quaternions keep
    their norms.

    >>> axode.jax.integrate(arm, jnp.zeros(7), jnp.full(7, 0.1)).shape
    (7,)
    """
    of = mechanism_of(m)
    q, dv = _arrays(of, q=q, dv=dv)
    return integrated(of, q, dv)


def coordinate_rates(m: Model, q: Array, v: Array) -> Array:
    """The rates dq/dt (..., nq) that belong to v, see `Model.coordinate_rates`.

    >>> axode.jax.coordinate_rates(arm, jnp.zeros(7), jnp.ones(7)).shape
    (7,)
    """
    of = mechanism_of(m)
    return rates_of(of, *_arrays(of, q=q, v=v))


def velocities_from_rates(m: Model, q: Array, dq: Array) -> Array:
    """The velocities v (..., nv) that belong to dq/dt, see `Model.velocities_from_rates`. A gradient by v times this
    map is a gradient by q.

    >>> axode.jax.velocities_from_rates(arm, jnp.zeros(7), jnp.ones(7)).shape
    (7,)
    """
    of = mechanism_of(m)
    return velocities_of(of, *_arrays(of, q=q, dq=dq))


def _arrays(m: Mechanism, rows: bool = False, **given: Array) -> list[Array]:
    """The arguments as arrays of one type with the same leading axes; with `rows` the last one has a row for each step."""
    arrays = {name: _array(name, x) for name, x in given.items()}
    dtype = jnp.result_type(*(x if jnp.issubdtype(x.dtype, jnp.inexact) else float for x in arrays.values()))
    if dtype not in (np.float32, np.float64):
        name = next(name for name, x in arrays.items() if x.dtype not in (np.float32, np.float64))
        raise TypeError(f"{name}: expected numbers of float32 or float64, got {arrays[name].dtype}")
    sizes = {"q": (m.nq, "nq coordinates"), "dq": (m.nq, "nq coordinates"), "parameters": (10 * m.n_bodies, "ten for each body")}
    leads = []
    for name, x in arrays.items():
        last = 2 if rows and name == "tau" else 1
        length, what = sizes.get(name, (m.nv, "nv numbers"))
        if name in PARAMETERS and name != "parameters":
            length, what = x.shape[-1] if x.ndim > 0 else 0, "numbers for all collision shapes"
        if x.ndim < last or x.shape[-1] != length:
            expected = f"(..., K, {length})" if last == 2 else f"(..., {length})"
            raise ValueError(f"{name}: expected shape {expected} with {what}, got {x.shape}")
        leads.append(x.shape[:-last])
    try:
        lead = jnp.broadcast_shapes(*leads)
    except ValueError:
        raise ValueError(f"the axes in front of {', '.join(arrays)} do not go together: {', '.join(map(str, leads))}") from None
    return [_broadcast(x if x.dtype == dtype else x.astype(dtype), (*lead, *x.shape[len(own):]))
            for own, x in zip(leads, arrays.values())]


def _array(name: str, x: Array) -> Array:
    try:
        return jnp.asarray(x)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected an array of numbers, got {type(x).__name__}") from None


def _broadcast(x: Array, shape: tuple[int, ...]) -> Array:
    return x if x.shape == shape else jnp.broadcast_to(x, shape)


def _positive(threads: int) -> int:
    if not isinstance(threads, int) or threads < 1:
        raise ValueError(f"threads is {threads}; expected 1 or more")
    return threads


def _without_loops(m: Model, function: str) -> Mechanism:
    check_counts(m, function)
    return mechanism_of(m)


def _still(m: Mechanism, q: Array) -> Array:
    return jnp.zeros((*q.shape[:-1], m.nv), dtype=q.dtype)


def _columns(m: Mechanism, q: Array, threads: int) -> Array:
    """The columns of R and r of every frame, (..., n_frames, 4, 3)."""
    found = state_function("poses", m, q, threads=threads)
    return found.reshape(*found.shape[:-1], 4, 3)


def _first_moment(m: Mechanism, q: Array, threads: int) -> Array:
    """The sum of m r over all moving bodies, (..., 3), kg m."""
    bodies = _columns(m, q, threads)[..., 1:m.n_bodies + 1, :, :]
    # m c in the axes of the body, and m at its origin.
    moments = m.parameters[:, [1, 2, 3, 0]].astype(q.dtype)
    return jnp.einsum("bk,...bkc->...c", moments, bodies)


def _from_spatial(V: Array, columns: Array, representation: Representation) -> Array:
    """Spatial twists of frames, (..., 6), in another representation."""
    if representation not in ("body", "spatial", "hybrid", "mixed"):
        raise ValueError(f'representation: expected "body", "spatial", "hybrid" or "mixed", got {representation!r}')
    if representation == "spatial":
        return V
    w, R, r = V[..., :3], columns[..., :3, :], columns[..., 3, :]
    dr = V[..., 3:] + cross(w, r)
    if representation != "hybrid":
        w = jnp.einsum("...kc,...c->...k", R, w)
    if representation == "body":
        dr = jnp.einsum("...kc,...c->...k", R, dr)
    return jnp.concatenate([w, dr], axis=-1)


def _displaced(columns: Array, offset: Array) -> Array:
    """Poses of a point (3,) or pose (4, 4) that is given in a frame."""
    if offset.shape == (3,):
        return columns.at[..., 3, :].add(jnp.einsum("k,...kc->...c", offset, columns[..., :3, :]))
    if offset.shape == (4, 4):
        turned = jnp.einsum("kl,...kc->...lc", offset[:3], columns[..., :3, :])
        return turned.at[..., 3, :].add(columns[..., 3, :])
    raise ValueError(f"offset: expected shape (3,) or (4, 4), got {offset.shape}")


def _number_of_frame(m: Mechanism, frame: int) -> int:
    if not isinstance(frame, (int, np.integer)):
        raise TypeError(f"frame: expected a name or a number, got {type(frame).__name__}")
    if not 0 <= frame < m.n_frames:
        raise ValueError(f"frame is {frame}; expected 0 to {m.n_frames - 1}")
    return int(frame)


signatures.explain_calls(__name__)
