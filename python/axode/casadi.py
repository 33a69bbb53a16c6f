"""Functions of one mechanism for CasADi: compiled for it, with exact first and second derivatives.

    import axode.casadi
    a = axode.casadi.function(arm, "forward_dynamics")(q, v, tau)

Needs CasADi, pip install "axode[casadi]", and a C compiler.

CasADi differentiates by the nq entries of q, one by one, while the library's derivatives are along the nv velocities. The
functions are therefore those of any q: quaternions count divided by their length, and where this is 1 they are what
the library has under the same name.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

try:
    import casadi  # type: ignore[import-not-found, import-untyped, unused-ignore]
except ImportError as error:
    raise ImportError('axode.casadi needs CasADi: pip install "axode[casadi]"') from error

from ._axode import Model
from ._axode.codegen import CasadiLibrary, casadi_library
from .records import Representation

__all__ = ["function"]

Function: TypeAlias = (
    Literal["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_mass_matrix", "poses", "coordinate_rates"]
    | tuple[Literal["pose"], str | int]
    | tuple[Literal["jacobian"], str | int]
    | tuple[Literal["jacobian"], str | int, Representation]
)

# Libraries that CasADi may have loaded: where there is no cache, their files would go with them.
_loaded: dict[str, CasadiLibrary] = {}


def function(m: Model, quantity: Function, states: int = 1, *, flags: Sequence[str] | None = None) -> Any:
    """A function of a mechanism as a `casadi.Function`, for numbers and for expressions of MX.

    quantity is "forward_dynamics" (q, v, tau -> a), "inverse_dynamics" (q, v, a -> tau), "mass_matrix" (q -> M, (nv, nv)),
    "inverse_mass_matrix", ("pose", frame) (q -> C, (4, 4)), "poses" (one C for each frame, named after it), ("jacobian",
    frame) or ("jacobian", frame, representation) (q -> J, (6, nv)), or "coordinate_rates" (q, v -> q'), which is made of
    SX and needs no compiler. Units and frames are those of the functions of these names.

    states is of how many it is, the columns of its arguments: q is (nq, states), and matrices stand side by side. To CasADi N
    states are then one operation, with derivatives that are blocks on a diagonal; N calls, or a map, are thousands. coordinate_rates
    is made for as many by `map`.

    Matrices are sparse where the mechanism has zeros. Jacobians and Hessians are exact. Evaluation fails, and IPOPT steps back,
    where the mass matrix may be singular. Armature and gravity of m are part of it; loads and joint losses are not, springs
    are not. The functions hold nothing: threads may share them, and they can be pickled for processes with the same cache.

    flags are for the compiler, as in `Model.specialise`; `axode.codegen.cache` keeps what it makes. ValueError for an unknown
    function and for dynamics of a mechanism with loops, RuntimeError where there is no compiler or it fails.

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
    if quantity == "coordinate_rates":
        rates = _coordinate_rates(m)
        return rates if states == 1 else rates.map(int(states))
    library = casadi_library(m, quantity, int(states), flags=flags)
    _loaded[library.file] = library
    # Of several directions, and always of several states, CasADi shall take the Jacobian: it costs as much as three to six. And
    # never for gradients, as the adjoints are what has second derivatives.
    return casadi.external(library.name, library.file, {"ad_weight": 0.75 if states == 1 else 1})


def _coordinate_rates(m: Model) -> Any:
    """q' from v, of SX."""
    q, v = casadi.SX.sym("q", m.nq), casadi.SX.sym("v", m.nv)
    rates = [_rates(joint.kind, q[joint.q], v[joint.v]) for joint in m.joints if joint.nv]
    return casadi.Function("coordinate_rates", [q, v], [casadi.vertcat(*rates)], ["q", "v"], ["dq"])


def _rates(kind: str, q: Any, v: Any) -> Any:
    if kind == "planar":
        sine, cosine = casadi.sin(q[0]), casadi.cos(q[0])
        return casadi.vertcat(v[0], cosine * v[1] - sine * v[2], sine * v[1] + cosine * v[2])
    if kind not in ("spherical", "free"):
        return v
    u, w = q[:3], q[3]
    rates = casadi.vertcat(w * v[:3] + casadi.cross(u, v[:3]), -casadi.dot(u, v[:3])) / 2
    if kind == "spherical":
        return rates
    turned = v[3:] + 2 / casadi.sumsqr(q[:4]) * casadi.cross(u, casadi.cross(u, v[3:]) + w * v[3:])
    return casadi.vertcat(rates, turned)
