"""Steps of every fit of parameters: blocks of rows, their triangular factor, its rank, and combinations in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__: list[str] = []

Array = NDArray[np.float64]

#: The largest number of entries of a matrix of all rows that are in memory at once.
BLOCK = 1 << 20


def blocks(rows: int, width: int) -> Iterator[slice]:
    """Consecutive rows, at least one, which together take at most BLOCK entries if each takes `width`."""
    size = max(BLOCK // width, 1)
    for start in range(0, rows, size):
        yield slice(start, start + size)


def triangle(rows: Array) -> Array:
    """The factor R of rows = Q R."""
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)


def huber_weight(u: Array, threshold: float) -> Array:
    """Weights of residuals u, given in standard deviations: 1 up to Huber's threshold."""
    return np.asarray(threshold / np.maximum(np.abs(u), threshold))


class Spectrum(NamedTuple):
    """U diag(sigma) Vt = A, for the singular values that do not count as rounding errors."""

    U: Array
    sigma: Array
    Vt: Array
    null_space: Array
    """(n, n - rank): orthonormal directions that A does not show."""

    @property
    def rank(self) -> int:
        return len(self.sigma)


def spectrum(A: Array, tolerance: float) -> Spectrum:
    """The singular value decomposition of A. Singular values below `tolerance` times the largest one are left out."""
    U, sigma, Vt = np.linalg.svd(A)
    rank = int(np.sum(sigma > tolerance * sigma[0]))
    return Spectrum(U[:, :rank], sigma[:rank], Vt[:rank], Vt[rank:].T)


def in_words(row: Array, names: list[str], first: int) -> str:
    """The combination of the named parameters that a row is, `link 2 Ixx + 0.3 * link 3 m`, the first one in front."""
    terms = names[first]
    for k in np.flatnonzero(row):
        if k != first:
            factor = f"{abs(row[k]):.4g}"
            terms += f" {'-' if row[k] < 0 else '+'} {'' if factor == '1' else factor + ' * '}{names[k]}"
    return terms
