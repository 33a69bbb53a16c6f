"""The motions that the example finds are motions of the library, and its Hessian equals that of differences."""

import os
import re
import subprocess
import sys

import axode
import axode.casadi
import casadi as ca
import numpy as np
import pytest
from pages import SOURCE, run_page

EXAMPLE = SOURCE / "examples/python/10_casadi_collocation.py"


def test_the_example_swings_up_and_reaches(tmp_path):
    done = subprocess.run([sys.executable, EXAMPLE], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    numbers = [[float(x) for x in re.findall(r"\d+\.?\d*(?:e-\d+)?", line)] for line in done.stdout.splitlines()]
    assert done.stdout.count("Solve_Succeeded") == 2
    (iterations, effort), (off,), (arm_iterations, share), (missed, arm_off) = numbers
    assert 5 < iterations < 300 and 5 < arm_iterations < 300
    assert 1 < effort <= 20.001 and 1 < share <= 100
    assert off < 5e-3 and arm_off < 5e-3 and missed < 1e-6


def test_the_hessian_of_a_collocation_is_exact():
    m = axode.load(axode.robots / "double_pendulum.toml")
    F = axode.casadi.function(m, "forward_dynamics")
    slopes = ca.collocation_coeff(ca.collocation_points(2, "radau"))[0]
    q, v, u = ca.MX.sym("q", 2, 5), ca.MX.sym("v", 2, 5), ca.MX.sym("u", 1, 2)
    equations = []
    for k, first in enumerate((0, 2)):
        a = ca.horzcat(*[F(q[:, i], v[:, i], ca.vertcat(0, u[k])) for i in (first + 1, first + 2)])
        equations += [ca.vec(q[:, first:first + 3] @ slopes - 0.1 * v[:, first + 1:first + 3]),
                      ca.vec(v[:, first:first + 3] @ slopes - 0.1 * a)]
    x, g = ca.veccat(q, v, u), ca.vertcat(*equations)
    solver = ca.nlpsol("solver", "ipopt", {"x": x, "f": ca.sumsqr(u), "g": g}, {"ipopt": {"print_level": 0}, "print_time": False})
    solver(x0=0.1, lbg=0, ubg=0)
    random = np.random.default_rng(0)
    at, weights = random.uniform(-1, 1, x.numel()), random.uniform(-1, 1, g.numel())
    H = np.array(ca.DM(solver.get_function("nlp_hess_l")(at, [], 1, weights)))
    H = H + np.triu(H, 1).T
    gradient = ca.Function("gradient", [x], [ca.gradient(ca.sumsqr(u) + ca.dot(weights, g), x)])
    steps = 1e-5 * np.eye(len(at))
    differences = np.column_stack([np.array(gradient(at + step) - gradient(at - step)).ravel() / 2e-5 for step in steps])
    assert np.abs(H - differences).max() < 1e-7 * np.abs(H).max()


def test_what_the_page_shows_is_what_happens(tmp_path, monkeypatch):
    release = SOURCE / "build/release"
    if not (release / "axode").exists():
        pytest.skip("there is no build/release/axode; `make build` builds it")
    monkeypatch.chdir(tmp_path)
    run_page("docs/casadi.md", {**os.environ, "PATH": f"{release}:{os.environ['PATH']}"})
