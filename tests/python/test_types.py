"""The package has type hints, and mypy finds them correct."""

import subprocess
import sys
from pathlib import Path

import axode

SOURCE = Path(__file__).resolve().parents[2]
PACKAGE = Path(axode.__file__).parent

GOOD = """
from typing import assert_type

import axode
import numpy as np
from numpy.typing import NDArray

m = axode.load(axode.robots / "arm7.toml", base="fixed")
assert_type(m, axode.Model)
assert_type(m.joint_names, list[str])
assert_type(m.loop_names, list[str])
assert_type(m.joint("A2").passive, bool)
assert_type(m.warnings, list[axode.Fault])
q, v = m.neutral(), [0.0] * m.nv
q[m.joint("A2").q] = 0.8
load = axode.Load(frame="flange", representation="hybrid", wrench=[0, 0, 0, 0, 0, -50])
assert_type(axode.inverse_dynamics(m, q, v, v, "spatial", loads=[load, {"frame": 3, "wrench": np.zeros(6)}]),
            NDArray[np.float64])
assert_type(axode.jacobian(m, q, "flange", "hybrid", offset=(0, 0, 0.1)), NDArray[np.float64])
assert_type(axode.linearize(m, q, v, v, [load]).A, NDArray[np.float64])
assert_type(axode.equilibrium(m, q, loads=[load]).q, NDArray[np.float64])
assert_type(axode.inverse_kinematics(m, [{"frame": "flange", "pose": np.eye(4)}], q).status == "solved", bool)
try:
    axode.Builder("rod").body("rod", joint="free", mass=1, com=[0, 0, 0], inertia=[1, 1, 1]).build(base="fixed")
except axode.ModelError as error:
    print([fault.line for fault in error.faults])
"""

BAD = {
    'axode.load("a.urdf", base="floating")': "arg-type",
    'axode.load(3)': "arg-type",
    'axode.inverse_dynamics(m, q, q, q, "world")': "arg-type",
    'axode.inverse_dynamics(m, q, q)': "call-arg",
    'axode.inverse_dynamics(m, q, q, q, loads=[{"frame": "flange"}])': "typeddict-item",
    'axode.jacobian(m, q, 1.5)': "arg-type",
    'm.nq = 3': "misc",
    'm.joint("A2").stiffness': "attr-defined",
    'axode.torques(m, q)': "attr-defined",
}


def mypy(tmp_path, *arguments):
    run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path.parent / "mypy", *arguments],
                         capture_output=True, text=True, cwd=tmp_path)
    return run.returncode, run.stdout + run.stderr


def test_the_package_is_typed(tmp_path):
    assert (PACKAGE / "py.typed").exists()
    status, output = mypy(tmp_path, "--package", "axode")
    assert status == 0, output


def test_a_program_without_mistakes_has_none(tmp_path):
    (tmp_path / "good.py").write_text(GOOD)
    status, output = mypy(tmp_path, "good.py")
    assert status == 0, output


def test_mistakes_are_found_where_they_are(tmp_path):
    lines = ["import axode", 'm = axode.load("arm.urdf")', "q = m.neutral()", *BAD]
    (tmp_path / "bad.py").write_text("\n".join(lines) + "\n")
    _, output = mypy(tmp_path, "bad.py")
    for number, (line, kind) in enumerate(BAD.items(), start=4):
        found = [message for message in output.splitlines() if message.startswith(f"bad.py:{number}: error")]
        assert any(f"[{kind}]" in message for message in found), (line, output)


def test_the_examples_are_typed(tmp_path):
    examples = sorted((SOURCE / "examples/python").glob("*.py"))
    assert examples
    status, output = mypy(tmp_path, *map(str, examples))
    assert status == 0, output
