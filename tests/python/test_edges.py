"""Extreme arguments: the largest numbers, the deepest nesting, the longest trees, and arguments without any entries."""

import subprocess
import sys

import axode
import numpy as np
import pytest
from calls import CALLS
from mechanisms import MECHANISMS

ARM = MECHANISMS["arm"]


def one_joint(kind, **joint):
    return axode.Model.from_bodies([{"name": "b", "joint": {"kind": kind, "name": "j", "point": [0, 0, 0], **joint},
                                     "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}])


def test_steps_without_a_finite_result_are_refused():
    ball, slide = one_joint("spherical"), one_joint("prismatic", axis="z")
    with pytest.raises(ValueError, match='dv: at joint "j" it is not finite, or so large that the result is not'):
        ball.integrate(ball.neutral(), [0, 1e200, 0])
    with pytest.raises(ValueError, match='state 1: dv: at joint "j"'):
        ball.integrate(np.tile(ball.neutral(), (2, 1)), [[0, 0, 0], [0, 1e200, 0]])
    with pytest.raises(ValueError, match='q1 - q0: at joint "j"'):
        slide.difference([-1e308], [1e308])
    assert slide.integrate([0.0], [1e200]) == [1e200]


def test_random_configurations_are_finite_within_any_limits():
    slide = one_joint("prismatic", axis="z", limits=[-1e308, 1e308])
    q = np.array([slide.random(seed=k) for k in range(100)])
    assert np.isfinite(q).all() and np.ptp(q / 1e308) > 1


@pytest.mark.parametrize("row", [["a", "b", "c", "d"], [0, 0, 0, 2], [0, 0, 0], [0, 0, 0, np.nan], None])
def test_a_target_pose_with_another_last_row_is_refused(row):
    pose = [[1, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0.3], row]
    with pytest.raises(ValueError, match=r"^targets\[0\].pose"):
        axode.inverse_kinematics(ARM, [{"frame": "flange", "pose": pose}], ARM.neutral())


def test_several_free_bodies_are_fixed_together(tmp_path):
    bodies = [{"name": name, "joint": {"kind": "free"}, "mass": 1, "com": [k, 0, 0], "inertia": [1, 1, 1]}
              for k, name in enumerate(["left", "right"])]
    both = axode.Model.from_bodies(bodies)
    assert both.nv == 12
    file = tmp_path / "both.toml"
    file.write_text(axode.drawing(both))
    for fixed in (axode.load(file, base="fixed"), axode.Model.from_bodies(bodies, base="fixed"),
                  axode.Model.from_dict(both.to_dict(), base="fixed")):
        assert fixed.nv == 0 and {"left", "right"} <= set(fixed.frame_names)


def test_what_is_nested_a_hundred_thousand_deep_is_refused():
    rows, tables = [], {}
    for _ in range(100_000):
        rows, tables = [rows], {"joint": tables}
    for refused in (lambda: axode.Model.from_bodies([{"name": "b", "com": rows}]),
                    lambda: axode.Model.from_bodies([{"name": "b", "joint": tables}]),
                    lambda: axode.Model.from_dict(tables), lambda: axode.mass_matrix(ARM, rows),
                    lambda: axode.lie.exp(rows)):
        with pytest.raises(ValueError):
            refused()
    while rows or tables:  # Python frees what is nested deeply without a stack, but not what compares it
        rows, tables = rows[0] if rows else [], tables.get("joint", {})


@pytest.mark.parametrize("call", CALLS)
def test_mechanisms_that_do_not_move_have_states_without_numbers(call):
    m = axode.Model.from_bodies([{"name": "table", "joint": "fixed", "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}])
    single, many = np.zeros(0), np.zeros((3, 0))
    if call.startswith(("center_of_mass", "centroidal")):
        with pytest.raises(ValueError, match='^model "mechanism" has no mass that moves, so no centre of mass$'):
            CALLS[call](m, many, many, many)
        return
    one = np.asarray(CALLS[call](m, single, single, single))
    assert CALLS[call](m, many, many, many).shape == (3, *one.shape)


def test_mechanisms_that_do_not_move_have_closed_states():
    m = axode.Model.from_bodies([{"name": "table", "joint": "fixed", "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}])
    none = np.zeros(0)
    assert [x.shape for x in axode.assemble(m, none, none)] == [(0,), (0,)]
    assert axode.loop_mobility(m, none).degrees_of_freedom == 0
    equations = axode.independent_equations(m, none, none)
    assert equations.velocities == [] and equations.M.shape == (0, 0) and equations.h.shape == (0,)
    small = axode.independent_linearization(m, none, none, none)
    assert small.velocities == [] and small.A.shape == (0, 0)
    assert axode.equilibrium(m, none).status == "solved"
    assert axode.inverse_dynamics(m, none, none, none, drives=[]).shape == (0,)
    assert axode.joint_wrenches(m, none, none, none, drives=[]).shape == (0, 6)
    found = axode.joint_state(m, axode.poses(m, none), axode.twists(m, none, none))
    assert found.q.shape == found.v.shape == (0,) and found.position_residual == 0


def test_names_may_be_of_any_alphabet(tmp_path):
    names = ["основание", "腕", "ไหล่", "é" * 300, 'a "b" \\ c', "🦾"]
    m = axode.Model.from_bodies([
        {"name": name, "on": names[k - 1] if k else "ground", "mass": 1, "com": [0, 0, k], "inertia": [1, 1, 1],
         "joint": {"kind": "revolute", "name": f"{name} joint", "axis": "x", "point": [0, 0, k]}}
        for k, name in enumerate(names)], name="робот")
    file = tmp_path / "робот 🦾.toml"
    file.write_text(axode.drawing(m), encoding="utf-8")
    again = axode.load(file)
    assert again.name == m.name and again.body_names == names == m.body_names
    assert axode.jacobian(again, m.neutral(), "腕").shape == (6, 6)
    with pytest.raises(KeyError, match='did you mean "腕"'):
        m.body("腕腕")
    source = axode.codegen.c_source(m, [("jacobian", name) for name in names])
    assert len({function.name for function in source.functions}) == len(names)
    assert source.text.isascii() or "腕" in source.text


def test_rows_are_counted_however_many():
    table = axode.Model.from_bodies([{"name": "table", "joint": "fixed", "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}])
    with pytest.raises(ValueError, match="rates: expected shape with 2147483647 rows at most"):
        axode.twist_derivatives(table, np.zeros(0), np.zeros((2**31, 0)), "table")


@pytest.mark.parametrize("name, what", {
    "jax": "JAX: pip install jax", "torch": "PyTorch: pip install torch", "casadi": "CasADi: pip install casadi",
    "cuda": "CuPy: pip install cupy-cuda12x", "distributed": "pyarrow: pip install pyarrow"}.items())
def test_a_module_that_needs_another_package_is_not_there_without_it(name, what):
    needs = {"cuda": "cupy", "distributed": "pyarrow"}.get(name, name)
    program = f"""
import sys; sys.modules[{needs!r}] = None
import axode
print(hasattr(axode, {name!r}), getattr(axode, {name!r}, 3))
for get in (lambda: getattr(axode, {name!r}), lambda: __import__("axode.{name}"), lambda: exec("from axode import {name}")):
    try: get()
    except Exception as error: print(type(error).__name__, error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    first, *rest = done.stdout.splitlines()
    assert first == "False 3", done.stderr
    sentences = {line.partition(" ")[2] for line in rest}
    assert [line.partition(" ")[0] for line in rest] == ["AttributeError", "ImportError", "ImportError"]
    assert sentences == {f"axode.{name} needs {what}"}


def test_views_that_run_backwards_or_stand_still_are_read_as_they_are():
    q = np.random.default_rng(1).uniform(-1, 1, (6, 7))
    expected = axode.mass_matrix(ARM, q)
    assert np.array_equal(axode.mass_matrix(ARM, q[::-1])[::-1], expected)
    assert np.array_equal(axode.mass_matrix(ARM, np.ascontiguousarray(q[:, ::-1])[:, ::-1]), expected)
    still = np.broadcast_to(q[0], (4, 7))
    assert np.array_equal(axode.mass_matrix(ARM, still), np.repeat(expected[:1], 4, axis=0))
    unaligned = np.frombuffer(b"\0" + q.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(6, 7)
    assert np.array_equal(axode.mass_matrix(ARM, unaligned), expected)
    records = np.zeros(6, dtype=[("name", "U3"), ("q", np.float64, 7)])
    records["q"] = q
    assert np.array_equal(axode.mass_matrix(ARM, records["q"]), expected)
