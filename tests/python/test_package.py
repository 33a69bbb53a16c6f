"""The files that an installed package has besides its functions."""

import inspect
import json
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import axode
import numpy as np
import pytest

COMMAND = Path(sysconfig.get_path("scripts")) / "axode"
WAYS = {"the command": [COMMAND], "the module": [sys.executable, "-m", "axode"]}


@pytest.mark.parametrize("way", WAYS)
def test_the_command_comes_with_the_package(way, tmp_path):
    def run(*words):
        return subprocess.run([*WAYS[way], *words], cwd=tmp_path, capture_output=True, text=True)

    assert run("--version").stdout.startswith(f"axode {axode.__version__}")
    assert "7 moving bodies" in run("info", axode.robots / "arm7.toml").stdout
    assert run("info", "none.toml").returncode == 1
    if axode.viewer.PAGE.exists():
        assert run("view", axode.robots / "arm7.toml", "--output", "page.html").returncode == 0
        assert (tmp_path / "page.html").stat().st_size > 1e5


def test_its_map_runs_in_the_environment_of_the_package(tmp_path):
    pytest.importorskip("pyarrow")
    done = subprocess.run([COMMAND, "map", "poses", axode.robots / "arm7.toml", "none.parquet", "out"], cwd=tmp_path,
                          env={"PATH": "/nowhere"}, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (1, "axode map: none.parquet: there is no such file or folder\n")


def functions_of_a_state():
    functions = {name: getattr(axode, name) for name in axode.__all__ if not inspect.isclass(getattr(axode, name))}
    return [name for name, function in functions.items()
            if callable(function) and list(inspect.signature(function).parameters)[:2] == ["m", "q"]]


def evaluated(model, name, *words, state=None):
    return subprocess.run([COMMAND, "eval", axode.robots / model, "--want", name, "--format", "json", *words],
                          input=json.dumps(state), capture_output=True, text=True)


@pytest.mark.parametrize("name", functions_of_a_state())
def test_the_command_computes_every_function_of_a_state_or_says_what_to_use(name):
    done = evaluated("arm7.toml", name, "--frame", "flange", "--state", "-", state={"q": 7 * [0.3]})
    if done.returncode:
        done = evaluated("four_bar.toml", name)
    if done.returncode:
        remedy = done.stderr.partition(f"--want: {name} is not a quantity: ")[2].partition(" (see")[0]
        assert remedy, done.stderr
        for quantity in re.findall(r'"(\w+)"', remedy):
            shown = subprocess.run([COMMAND, "eval", "--help"], capture_output=True, text=True).stdout
            assert f"  {quantity} " in shown
        for command in re.findall(r"axode (\w+)", remedy):
            assert subprocess.run([COMMAND, command, "--help"], capture_output=True).returncode == 0


def test_what_the_command_says_of_loops_and_rates_is_what_the_functions_give():
    m = axode.load(axode.robots / "four_bar.toml")
    q, v = axode.assemble(m, [0.4, 0.0, 0.0], [1.0, 0.0, 0.0], hold=["crank_joint"])
    state = {"q": q.tolist(), "v": v.tolist(), "tau": [0.5, 0.0, 0.0]}
    tau = np.array(state["tau"])
    d = axode.loop_multiplier_derivatives(m, q, v, tau)
    expected = {"loop_jacobian": axode.loop_jacobian(m, q), "loop_bias": axode.loop_bias(m, q, v),
                "loop_residual_jacobian": axode.loop_residual_jacobian(m, q),
                "loop_multipliers": axode.loop_multipliers(m, q, v, tau),
                "loop_multiplier_derivatives": np.hstack([d.q, d.v, d.tau])}
    for name, value in expected.items():
        done = evaluated("four_bar.toml", name, "--state", "-", state=state)
        found, = json.loads(done.stdout)["results"][name].values()
        assert np.allclose(found, value, atol=1e-12) and np.any(value), name
    opening = {"q": q.tolist(), "v": [1.0, 0.0, 0.0]}
    found = json.loads(evaluated("four_bar.toml", "impact", "--state", "-", state=opening).stdout)["results"]["impact"]
    assert np.allclose(found["v"], axode.impact(m, q, opening["v"])) and any(found["impulses"])
    printed = evaluated("four_bar.toml", "independent_equations", "--state", "-", state=state).stdout
    found = json.loads(printed)["results"]
    equations = axode.independent_equations(m, q, v)
    for name in "MNhc":
        assert np.allclose(found["independent_equations"][name], getattr(equations, name), atol=1e-12)
    arm = axode.load(axode.robots / "arm7.toml")
    rows = np.random.default_rng(1).uniform(-1, 1, (5, 7))
    state = dict(zip(("q", "v", "a", "jerk", "snap"), rows.tolist()))
    found = json.loads(evaluated("arm7.toml", "inverse_dynamics_rates", "--state", "-", state=state).stdout)["results"]
    assert np.allclose(found["inverse_dynamics_rates"], axode.inverse_dynamics_rates(arm, *rows))
