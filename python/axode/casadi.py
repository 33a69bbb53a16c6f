"""Functions of one mechanism for CasADi, compiled for this mechanism, with exact first and second derivatives.

    import axode.casadi
    a = axode.casadi.function(arm, "forward_dynamics")(q, v, tau)

This needs CasADi (pip install casadi) and a C compiler.

CasADi differentiates by the nq entries of q, one by one, while the library's derivatives are along the nv velocities.
Therefore the functions are defined for any q: quaternions are divided by their norm. If the norm is 1, the functions
equal those of the library with the same names.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

try:
    import casadi  # type: ignore[import-not-found, import-untyped, unused-ignore]
except ImportError as error:
    raise ImportError('axode.casadi needs CasADi: pip install casadi') from error

from .support import coordinates, signatures
from ._axode import Model, pair_distances, shape_pairs
from ._axode.codegen import CasadiLibrary, casadi_library
from .records import Representation

__all__ = ["function"]

Function: TypeAlias = (
    Literal["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_mass_matrix", "poses", "coordinate_rates", "integrate",
            "difference"]
    | tuple[Literal["pose"], str | int]
    | tuple[Literal["jacobian"], str | int]
    | tuple[Literal["jacobian"], str | int, Representation]
    | Literal["pair_distances"] | tuple[Literal["pair_distances"], Sequence[tuple[str, str]]]
)

# Libraries that CasADi may have loaded. They are kept, because
# without a cache their files would be removed with them.
_loaded: dict[str, CasadiLibrary] = {}


def function(m: Model, quantity: Function, states: int = 1, *, flags: Sequence[str] | None = None) -> Any:
    """A function of a mechanism as a `casadi.Function`, for numbers and for expressions of MX.

    quantity is "forward_dynamics" (q, v, tau -> a), "inverse_dynamics" (q, v, a -> tau), "mass_matrix" (q -> M, (nv,
    nv)), "inverse_mass_matrix", ("pose", frame) (q -> C, (4, 4)), "poses" (one C for each frame, named after it),
    ("jacobian", frame) or ("jacobian", frame, representation) (q -> J, (6, nv)), "coordinate_rates" (q, v -> q'),
    "integrate" (q, dv -> q (+) dv) or "difference" (q0, q1 -> dv with q0 (+) dv = q1, the shorter way round). The
    last three are made of SX and need no compiler. Units and frames are those of the functions of the same names; the
    last three are methods of the model. "pair_distances" or ("pair_distances", pairs) (q -> distances, (P,)) calls
    `axode.pair_distances` in Python; it needs no compiler, has a Jacobian but no Hessian (for IPOPT set
    hessian_approximation to "limited-memory"), and cannot be pickled.

    states is the number of states that one call takes; they are the columns of the arguments: q is (nq, states), and
    matrices are side by side. For CasADi, N states are then one operation, with derivatives that are blocks on a
    diagonal; N calls, or a map, would be thousands of operations. Functions that are made of SX get several states by
    `map`.

    Matrices are sparse where the mechanism has zeros. Jacobians and Hessians are exact; "inverse_mass_matrix" has no
    Hessian, for which use casadi.inv of "mass_matrix". Evaluation fails if the mass matrix may be singular; IPOPT
    then shortens its step. Armature and gravity of m are included; loads, joint losses and springs are not. The
    functions have no state: threads may share them, and they can be pickled for processes with the same cache.

    flags are for the compiler, as in `Model.specialise`; `axode.codegen.cache` keeps the result. ValueError for an
    unknown function and for dynamics of a mechanism with loops, RuntimeError if there is no compiler or it fails.

    >>> import casadi
    >>> F = axode.casadi.function(arm, "mass_matrix", flags=["-O1"])
    >>> q = np.full(7, 0.5)
    >>> np.allclose(F(q).full(), axode.mass_matrix(arm, q))
    True
    >>> x = casadi.MX.sym("q", 7)
    >>> casadi.jacobian(F(x), x).shape
    (49, 7)
    >>> axode.casadi.function(arm, ("pose", "flange"), 5, flags=["-O1"])(np.zeros((7, 5))).shape
    (4, 20)
    """
    if not isinstance(states, (int, np.integer)):
        raise TypeError(f"states is {states!r}; expected a whole number")
    if not 1 <= states < 2**31:
        raise ValueError(f"states is {states}; expected 1 to 2147483647")
    if isinstance(quantity, str) and quantity in _OF_CONFIGURATIONS:
        one = _of_configurations(m, quantity)
        return one if states == 1 else one.map(int(states))
    if quantity == "pair_distances" or (isinstance(quantity, tuple) and quantity[:1] == ("pair_distances",)):
        return _pair_distances_of(m, quantity, int(states))
    library = casadi_library(m, quantity, int(states), flags=flags)
    _loaded[library.file] = library
    # For several directions, and always for several states, CasADi uses the
    # Jacobian, which costs as much as three to six directions. It never uses the
    # Jacobian for gradients, because only the adjoints have second derivatives.
    return casadi.external(library.name, library.file, {"ad_weight": 0.75 if states == 1 else 1})


# ------------------------------------------------------------------------------ distances of collision shapes

# CasADi calls these objects without owning them, so that they stay until the end of the process.
_called_back: dict[tuple[Any, ...], Any] = {}


class _CalledBack(casadi.Callback):  # type: ignore[misc]
    """A function of CasADi with dense arguments and one dense result, that calls a function of arrays."""

    def __init__(self, name: str, names: tuple[list[str], str], shapes: list[tuple[int, int]], call: Callable[..., Any],
                 jacobian: Callable[..., Any] | None = None) -> None:
        casadi.Callback.__init__(self)
        self._names, self._shapes, self._call, self._jacobian = names, shapes, call, jacobian
        self._of_jacobian: Any = None
        self.construct(name, {})

    def get_n_in(self) -> int:
        return len(self._names[0])

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, k: int) -> str:
        return self._names[0][k]

    def get_name_out(self, k: int) -> str:
        return self._names[1]

    def get_sparsity_in(self, k: int) -> Any:
        return casadi.Sparsity.dense(*self._shapes[k])

    def get_sparsity_out(self, k: int) -> Any:
        return casadi.Sparsity.dense(*self._shapes[-1])

    def eval(self, arguments: Any) -> list[Any]:
        return [casadi.densify(casadi.DM(self._call(arguments[0].full())))]

    def has_jacobian(self) -> bool:
        return self._jacobian is not None

    def get_jacobian(self, name: str, names: Any, result: Any, options: Any) -> Any:
        if self._of_jacobian is None:  # it is made once, because expressions may still call the first one
            q, distances = self._shapes
            shapes = [q, distances, (math.prod(distances), math.prod(q))]
            self._of_jacobian = _CalledBack(name, ([names[0], names[1]], result[0]), shapes, self._jacobian)  # type: ignore[arg-type]
        return self._of_jacobian


def _pair_distances_of(m: Model, quantity: Any, states: int) -> Any:
    """The distances of pairs of shapes, with a column for each state."""
    pairs = shape_pairs(m) if isinstance(quantity, str) else [*quantity[1]]
    key = (m, tuple(map(tuple, pairs)), states)
    if key in _called_back:
        return _called_back[key]
    P = len(pair_distances(m, m.neutral(), pairs).distances)
    q, dq = casadi.SX.sym("q", m.nq), casadi.SX.sym("dq", m.nq)
    v = [coordinates.velocities(_ARRAYS, joint.kind, q[joint.q], dq[joint.q]) for joint in m.joints if joint.nv]
    velocities = casadi.Function("velocities", [q], [casadi.jacobian(casadi.vertcat(*v), dq)])

    def distances(q: Any) -> Any:
        return pair_distances(m, m.normalize(q.T), pairs).distances.T

    def jacobian(q: Any) -> Any:
        J = pair_distances(m, m.normalize(q.T), pairs).jacobians
        return casadi.diagcat(*(J[k] @ velocities(q[:, k]).full() for k in range(states)))

    made = _CalledBack("pair_distances", (["q"], "distances"), [(m.nq, states), (P, states)], distances, jacobian)
    return _called_back.setdefault(key, made)


# ------------------------------------------------------------------------- the group of configurations, of SX

_ARRAYS = coordinates.Arrays(part=lambda x, first, end: x[first:end], join=lambda parts: casadi.vertcat(*parts),
                             cross=casadi.cross, dot=casadi.dot, where=casadi.if_else, functions=casadi)


def _of_configurations(m: Model, name: str) -> Any:
    """A function of the coordinates that is computed for each joint separately."""
    of_joint, first, second, result = _OF_CONFIGURATIONS[name]
    x, y = casadi.SX.sym(first, m.nq), casadi.SX.sym(second, m.nq if second == "q1" else m.nv)
    parts = [of_joint(joint.kind, x[joint.q], y[joint.q if second == "q1" else joint.v]) for joint in m.joints if joint.nv]
    return casadi.Function(name, [x, y], [casadi.vertcat(*parts)], [first, second], [result])


def _integrated(kind: str, q: Any, dv: Any) -> Any:
    return coordinates.integrated(_ARRAYS, kind, coordinates.normalized(_ARRAYS, kind, q), dv)


_OF_CONFIGURATIONS: dict[str, tuple[Callable[[str, Any, Any], Any], str, str, str]] = {
    "coordinate_rates": (functools.partial(coordinates.rates, _ARRAYS), "q", "v", "dq"),
    "integrate": (_integrated, "q", "dv", "q1"),
    "difference": (functools.partial(coordinates.difference, _ARRAYS), "q0", "q1", "dv"),
}


signatures.explain_calls(__name__)
