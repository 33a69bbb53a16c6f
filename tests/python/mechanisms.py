"""The mechanisms of these tests: every kind of joint, coupled ones, a free base, a fixed one."""

import axode
import numpy as np

MECHANISMS = {
    "arm": axode.load(axode.robots / "arm7.toml"),
    "machine": axode.load(axode.robots / "machine.toml"),
    "humanoid": axode.load(axode.robots / "humanoid.urdf", base="free"),
}
REPRESENTATIONS = ["body", "spatial", "hybrid", "mixed"]


def random_states(m, N, seed=0):
    """q (N, nq) and three arrays (N, nv)."""
    random = np.random.default_rng(seed)
    q = np.array([m.random(seed=seed * 1000 + k) for k in range(N)])
    return q, *random.uniform(-1, 1, (3, N, m.nv))


def close(x, y, tolerance=1e-11):
    """Whether two arrays are equal, up to a part of the largest entry."""
    scale = max(np.abs(y).max(initial=0), 1e-300)
    return np.shape(x) == np.shape(y) and np.abs(np.subtract(x, y)).max(initial=0) <= tolerance * scale
