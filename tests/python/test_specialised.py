"""Specialised models give the same results as the library, in any number of processes. Without a cache or a compiler
they raise an error that says so."""

import os
import shutil
import signal
import subprocess
import sys
import time

import axode
import numpy as np
import pytest
from axode.table import ROWS
from calls import given_to
from mechanisms import MECHANISMS, close, random_states

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler cc")
QUICKLY = ["-O1", "-march=native", "-ffp-contract=fast"]
ARM = MECHANISMS["arm"]
PENDULUM = axode.load(axode.robots / "double_pendulum.toml")
RECORDED = [name for name, row in ROWS.items() if row.recorded and "frame" not in row.takes]
CHEAP = ["inverse_dynamics", "mass_matrix", "poses"]


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """The folder of the cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    return tmp_path / "axode"


def arguments(m, function, N=None):
    """The arguments (q, ...) of N states, or of one state."""
    state = [x if N is not None else x[0] for x in random_states(m, N or 1, seed=1)[:3]]
    if N == 0:
        state = [x[:0] for x in state]
    given = given_to(ROWS[function], m, *state)
    return [given[name] for name in ROWS[function].arrays]


def assert_same(m, s, functions, N, tolerance=1e-11):
    for function in functions:
        given = arguments(m, function, N)
        found, expected = getattr(s, function)(*given), getattr(axode, function)(m, *given)
        assert type(found) is type(expected)
        for x, y in zip(*([z] if isinstance(z, np.ndarray) else z for z in (found, expected)), strict=True):
            assert close(x, y, tolerance), function


def test_every_function_of_one_state_and_of_many():
    s = PENDULUM.specialise([*RECORDED, ("jacobian", 2), ("jacobian", 1, "mixed")], flags=QUICKLY)
    for N in (None, 0, 1, 7, 33):
        assert_same(PENDULUM, s, RECORDED, N)
    q = random_states(PENDULUM, 9)[0]
    assert close(s.jacobian(q, 2), axode.jacobian(PENDULUM, q, 2))
    assert close(s.jacobian(q[0], 1, "mixed"), axode.jacobian(PENDULUM, q[0], 1, "mixed"))
    assert np.array_equal(s.forward_dynamics(*arguments(PENDULUM, "forward_dynamics", 1000), threads=4),
                          s.forward_dynamics(*arguments(PENDULUM, "forward_dynamics", 1000)))
    assert s.model is PENDULUM


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_mechanisms_with_joints_of_all_kinds(mechanism):
    m = MECHANISMS[mechanism]
    assert_same(m, m.specialise(CHEAP, flags=["-O0", "-march=native"]), CHEAP, 11, 1e-12)


def test_single_precision_is_float32():
    s = ARM.specialise(CHEAP, "float32", flags=QUICKLY)
    for function in CHEAP:
        given = arguments(ARM, function, 20)
        found = getattr(s, function)(*given)
        assert found.dtype == np.float32
        assert close(found, getattr(axode, function)(ARM, *given), 1e-5)


def test_arguments_are_checked_as_the_library_checks_them():
    s = PENDULUM.specialise(["inverse_dynamics", "forward_dynamics"], flags=QUICKLY)
    q, v, a = np.zeros((3, 2))
    for wrong in [(q[:1], v, a), (q, v, np.full(2, np.nan)), (q, v, "a"), ([[q]], v, a), (np.zeros((3, 2)), v, a)]:
        with pytest.raises(ValueError) as theirs:
            axode.inverse_dynamics(PENDULUM, *wrong)
        with pytest.raises(ValueError) as ours:
            s.inverse_dynamics(*wrong)
        assert str(ours.value) == str(theirs.value)
    with pytest.raises(ValueError, match="threads is 0; expected 1 or more"):
        s.inverse_dynamics(q, v, a, threads=0)
    with pytest.raises(axode.NotFiniteError) as raised:
        s.forward_dynamics(np.zeros((4, 2)), [[0, 0], [0, 0], [0, 1e200], [0, 0]], np.zeros((4, 2)))
    assert raised.value.states == [2]
    with pytest.raises(ValueError, match="lanes is 3; expected 1, 2, 4, 8 or 16"):
        PENDULUM.specialise(["poses"], lanes=3)
    with pytest.raises(ValueError, match="made without mass_matrix; name it among the functions of Model.specialise"):
        s.mass_matrix(q)
    with pytest.raises(ValueError, match="made without jacobian of that frame in that representation"):
        s.jacobian(q, 1)
    free = axode.load(axode.robots / "humanoid.urdf", base="free")
    with pytest.raises(ValueError, match="quaternion"):
        free.specialise(["poses"], flags=["-O0"]).poses(np.zeros(free.nq))


@pytest.mark.parametrize(("request_", "error", "message"), [
    (([],), ValueError, "functions is empty"),
    ((["crba"],), ValueError, "it is called 'mass_matrix' here"),
    ((["poses"], "float16"), ValueError, "scalar is 'float16'; expected one of 'float64', 'float32'"),
    (([("jacobian", "hand")],), KeyError, "has no frame"),
])
def test_a_wrong_request_is_refused(request_, error, message):
    with pytest.raises(error, match=message):
        PENDULUM.specialise(*request_)


def test_a_model_without_degrees_of_freedom():
    m = axode.Model.from_bodies([{"name": "block", "joint": "fixed"}])
    s = m.specialise(["poses", "mass_matrix"], flags=QUICKLY)
    assert close(s.poses([]), axode.poses(m, []))
    assert s.mass_matrix([]).shape == (0, 0)


PROGRAM = """
import axode, numpy as np, sys
m = axode.load(axode.robots / "arm7.toml")
print("started", flush=True)
s = m.specialise(["inverse_dynamics", "inverse_dynamics_derivatives"], flags=[sys.argv[1]])
print(np.allclose(s.inverse_dynamics(np.ones(7), np.ones(7), np.ones(7)),
                  axode.inverse_dynamics(m, np.ones(7), np.ones(7), np.ones(7))))
"""


def start(flag):
    """A process that has started. Its output is not buffered here: what readline() had read ahead, communicate() would
    not return."""
    child = subprocess.Popen([sys.executable, "-c", PROGRAM, flag], bufsize=0, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                             preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
    assert child.stdout.readline() == b"started\n"
    return child


def wait_for_the_compiler(cache):
    while not list(cache.glob("*/model.c")):
        time.sleep(0.01)
    time.sleep(0.1)


def test_processes_that_specialise_at_once_compile_once_and_a_killed_one_does_no_harm(cache):
    first = start("-O0")
    wait_for_the_compiler(cache)
    others = [start("-O0") for _ in range(3)]
    first.kill()
    first.wait()
    assert [child.communicate(timeout=120) for child in others] == [(b"True\n", b"")] * 3
    assert sorted(file.suffix for file in cache.iterdir()) == ["", ".so"]  # the lock, and one library


def test_ctrl_c_ends_the_compiler_and_leaves_nothing(cache):
    child = start("-O3")
    wait_for_the_compiler(cache)
    os.kill(child.pid, signal.SIGINT)
    error = child.communicate(timeout=120)[1]
    assert error.rstrip().endswith(b"KeyboardInterrupt")
    assert [file.name for file in cache.iterdir()] == ["lock"]


def test_without_a_compiler_there_is_one_sentence_and_the_library(monkeypatch):
    monkeypatch.setenv("CC", "/nonexistent")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(RuntimeError, match='^there is no C compiler to specialise a model with: .CC is "/nonexistent"'):
        PENDULUM.specialise(["poses"])
    assert np.isfinite(axode.poses(PENDULUM, [0, 0])).all()


def specialised_elsewhere(**environment):
    """The output of a new process that specialises a model, and has not asked the compiler for its version before."""
    program = "import axode; m = axode.load(axode.robots / 'double_pendulum.toml'); print(m.specialise(['poses']).poses([0, 0]).shape)"
    return subprocess.run([sys.executable, "-c", program], env={**os.environ, **environment}, capture_output=True, text=True)


def test_a_folder_of_temporary_files_is_needed_only_without_a_cache(tmp_path):
    gone = str(tmp_path / "gone")
    assert specialised_elsewhere(TMPDIR=gone).stdout == "(4, 4, 4)\n"
    refused = specialised_elsewhere(TMPDIR=gone, XDG_CACHE_HOME="/proc/none")
    assert refused.stderr.rstrip().endswith(
        f'RuntimeError: there is no folder to compile in: the cache cannot be written to, and TMPDIR is "{gone}", which is not a '
        "folder; set TMPDIR or XDG_CACHE_HOME to a folder that can be written to")


def test_the_cache_says_what_it_has_and_is_cleared(cache):
    assert axode.codegen.cache() == (str(cache), 0, 0)
    s = PENDULUM.specialise(["mass_matrix"], flags=QUICKLY)
    PENDULUM.specialise(["mass_matrix"], flags=QUICKLY)
    PENDULUM.specialise(["poses"], flags=QUICKLY)
    there = axode.codegen.cache()
    assert there.models == 2 and there.bytes == sum(file.stat().st_size for file in cache.glob("*.so"))
    axode.codegen.clear_cache()
    assert axode.codegen.cache().models == 0
    assert_same(PENDULUM, s, ["mass_matrix"], 3)


@pytest.mark.parametrize("losses", [False, True])
def test_rollouts_are_the_librarys(losses):
    q, v, *_ = random_states(PENDULUM, 20, seed=3)
    tau = np.random.default_rng(4).uniform(-1, 1, (20, 30, 2))
    pd = axode.drives.PD(3.0, 0.1, np.zeros(2), clip=True)
    ways = [(tau, None), (tau[0, 0], 30), (pd, 30), (lambda t, q, v: -0.1 * v, 30)]
    for scalar, tolerance in (("float64", 1e-11), ("float32", 1e-4)):
        s = PENDULUM.specialise(["forward_dynamics"], scalar, flags=QUICKLY)
        for forces, steps in ways:
            given = {"steps": steps, "joint_losses": losses}
            expected = axode.rollout(PENDULUM, q, v, forces, 1e-3, **given)
            found = axode.rollout(s, q, v, forces, 1e-3, **given, threads=2)
            one = forces[0] if steps is None else forces
            alone = axode.rollout(s, q[0], v[0], one, 1e-3, **given)
            for x, y, z in zip(found, expected, alone, strict=True):
                assert x.dtype == z.dtype == scalar
                assert close(x, y, tolerance) and close(z, y[0], tolerance)


def test_rollouts_by_a_specialised_model_are_checked_as_the_librarys_are():
    s = PENDULUM.specialise(["forward_dynamics"], flags=QUICKLY)
    q, v, tau = np.zeros((4, 2)), np.zeros((4, 2)), np.zeros((4, 3, 2))
    for wrong in [(q[:, :1], v, tau, 1e-3), (q, v, tau[0], 1e-3), (q, v, tau, 0), (q, v, np.full((4, 3, 2), np.nan), 1e-3)]:
        with pytest.raises(ValueError) as theirs:
            axode.rollout(PENDULUM, *wrong)
        with pytest.raises(ValueError) as ours:
            axode.rollout(s, *wrong)
        assert str(ours.value) == str(theirs.value)
    v[2, 1] = 1e200
    with pytest.raises(axode.NotFiniteError) as raised:
        axode.rollout(s, q, v, tau, 1e-3)
    assert raised.value.states == [2]
    with pytest.raises(ValueError, match="made without forward_dynamics; name it among the functions of Model.specialise"):
        axode.rollout(PENDULUM.specialise(["mass_matrix"], flags=QUICKLY), q, v, tau, 1e-3)
