"""The factors of the mass matrix: arguments that they refuse, and threads that run at the same time."""

import sys
import threading

import axode
import numpy as np
import pytest
from mechanisms import MECHANISMS, close

HUMANOID = MECHANISMS["humanoid"]
Q = np.array([HUMANOID.random(seed=k) for k in range(5)])
M = axode.mass_matrix(HUMANOID, Q[0])
# Two velocities of different limbs.
APART = tuple(int(k) for k in np.argwhere((axode.mass_matrix(HUMANOID, Q) == 0).all(axis=0))[-1])


def changed(r, c, x):
    other = M.copy()
    other[r, c] = x
    return other


def test_entries_of_velocities_on_different_paths_are_refused():
    r, c = max(APART), min(APART)
    other = M.copy()
    other[r, c] = other[c, r] = 0.125
    with pytest.raises(ValueError, match=rf"^M\({r}, {c}\) is 0.125; velocities {r} and {c} are on different paths, "
                                         "where a mass matrix is 0$"):
        axode.MassMatrixFactor(HUMANOID, other)


def test_a_matrix_that_is_not_symmetric_is_refused():
    for r, c in ((1, 0), (0, 1)):
        with pytest.raises(ValueError, match=r"^M\(1, 0\) is .* and M\(0, 1\) is .*; a mass matrix is symmetric$"):
            axode.MassMatrixFactor(HUMANOID, changed(r, c, M[r, c] + 0.5))
    with pytest.raises(ValueError, match=r"a mass matrix is symmetric"):
        axode.MassMatrixFactor(HUMANOID, changed(*APART, 0.125))


def test_what_is_but_rounding_is_no_fault():
    nearly = M * (1 + 1e-15 * np.random.default_rng(1).uniform(-1, 1, M.shape))
    assert close(axode.MassMatrixFactor(HUMANOID, nearly).solve(M), np.eye(HUMANOID.nv), 1e-9)


def test_what_is_not_definite_names_the_joint():
    with pytest.raises(axode.SingularError, match='joint ".*" of body ".*" moves no mass'):
        axode.MassMatrixFactor(HUMANOID, np.zeros_like(M))
    with pytest.raises(axode.SingularError):
        axode.MassMatrixFactor(HUMANOID, -M)


CHAIN = axode.Model.from_bodies([
    {"name": f"b{k}", "on": f"b{k - 1}" if k else "ground",
     "joint": {"kind": "revolute", "axis": "zyx"[k % 3], "point": [0, 0, 0]},
     "mass": 1, "com": [0.1, 0.2, 0.3], "inertia": [1, 1, 1]} for k in range(700)])
M_CHAIN = axode.mass_matrix(CHAIN, CHAIN.random())
FACTOR = axode.MassMatrixFactor(CHAIN, M_CHAIN)
LONG = {
    "factors": lambda: axode.MassMatrixFactor(CHAIN, M_CHAIN),
    "solutions": lambda: FACTOR.solve(M_CHAIN),
    "inverse": FACTOR.inverse,
}


@pytest.mark.parametrize("call", LONG)
def test_other_threads_run_meanwhile(call):
    started, ended = threading.Event(), threading.Event()

    def work():
        started.set()
        LONG[call]()
        ended.set()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(60)  # nobody is interrupted: others run only where the call lets them
    try:
        thread = threading.Thread(target=work)
        thread.start()
        started.wait()
        assert not ended.is_set()
    finally:
        sys.setswitchinterval(interval)
        thread.join()
