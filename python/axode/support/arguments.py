"""Arguments as arrays of finite numbers. What is none is a ValueError that names the argument."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__: list[str] = []

Array = NDArray[np.float64]


def array(name: str, given: ArrayLike) -> NDArray[Any]:
    """The argument as an array of real numbers of any type."""
    try:
        x = np.asarray(given)
    except ValueError as error:
        raise ValueError(f"{name}: expected numbers in rows of equal length") from error
    if x.dtype.kind not in "fiu":
        raise ValueError(f"{name}: expected real numbers (float64), got dtype {x.dtype}")
    return x


def shaped(name: str, given: ArrayLike, shape: tuple[int, ...], meaning: str) -> Array:
    """The argument as an array of this shape; `meaning` is the shape in words."""
    x = array(name, given)
    if x.shape != shape:
        raise ValueError(f"{name}: expected shape {meaning}, got {x.shape}")
    return _finite(name, x)


def numbers(name: str, given: ArrayLike, length: int, meaning: str, states: tuple[int, ...] | None = None) -> Array:
    """The argument as an array (length,) or (N, length), with the N of `states` if these are given."""
    if states is not None:
        return shaped(name, given, (*states, length), f"{(*states, length)}, {meaning}")
    x = array(name, given)
    if x.ndim not in (1, 2) or x.shape[-1] != length:
        raise ValueError(f"{name}: expected shape ({length},) or (N, {length}), {meaning}, got {x.shape}")
    return _finite(name, x)


def configurations(name: str, given: ArrayLike, nq: int, of_each: str) -> Array:
    """The argument as an array (N, nq) of at least one configuration, one of each measurement or sample."""
    q = numbers(name, given, nq, "nq numbers")
    if q.ndim != 2 or not len(q):
        raise ValueError(f"{name}: expected shape (N, {nq}), nq numbers of each {of_each}, got {q.shape}")
    return q


def _finite(name: str, x: NDArray[Any]) -> Array:
    if not np.all(np.isfinite(x)):
        at = tuple(int(k) for k in np.argwhere(~np.isfinite(x))[0])
        raise ValueError(f"{name}[{', '.join(map(str, at))}] is {x[at]}; expected finite numbers")
    return x.astype(np.float64, copy=False)
