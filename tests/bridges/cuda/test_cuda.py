"""Kernels for GPUs compile and give the same results as the library: on the processor, and on a GPU if there is one."""

import importlib
import importlib.util
import os
import re
import subprocess
import sys
import types

import axode
import host_cupy
import numpy as np
import nvrtc
import pytest
from axode.table import ROWS
from calls import given_to
from mechanisms import MECHANISMS, close, random_states
from pages import SOURCE, run_page

ARM, PENDULUM = MECHANISMS["arm"], axode.load(axode.robots / "double_pendulum.toml")
RECORDED = [name for name, row in ROWS.items() if row.recorded and "frame" not in row.takes]
CHEAP = ["inverse_dynamics", "forward_dynamics", "mass_matrix", "inverse_mass_matrix", "poses", "inverse_dynamics_vjp"]
LONG = ["forward_dynamics_derivatives", "inverse_dynamics_derivatives"]  # in parts


@pytest.fixture
def cuda(monkeypatch):
    """axode.cuda with kernels that run on the processor."""
    if host_cupy.COMPILER is None:
        pytest.skip("there is no C++ compiler c++")
    monkeypatch.setitem(sys.modules, "cupy", host_cupy)
    monkeypatch.delitem(sys.modules, "axode.cuda", raising=False)
    yield importlib.import_module("axode.cuda")
    sys.modules.pop("axode.cuda", None)
    vars(axode).pop("cuda", None)


def arguments(m, function, N, dtype=np.float64):
    given = given_to(ROWS[function], m, *(x[:N] for x in random_states(m, max(N, 1), seed=3)[:3]))
    return [given[name].astype(dtype) for name in ROWS[function].arrays]


def assert_same(found, expected, tolerance):
    assert isinstance(found, tuple) == isinstance(expected, tuple)
    if isinstance(found, tuple):
        assert type(found) is type(expected)
    for x, y in zip(*([z] if isinstance(z, np.ndarray) else z for z in (found, expected)), strict=True):
        assert close(np.asarray(x), y, tolerance)


@pytest.mark.parametrize("mechanism, functions, tolerance", [
    ("pendulum", RECORDED, 1e-11), ("arm", CHEAP + LONG, 1e-9), ("machine", CHEAP, 1e-9), ("humanoid", CHEAP, 1e-9)])
def test_kernels_give_what_the_library_gives(cuda, mechanism, functions, tolerance):
    m = PENDULUM if mechanism == "pendulum" else MECHANISMS[mechanism]
    frame = m.frame_names[-1]
    gpu = cuda.kernels(m, [*functions, ("jacobian", frame), ("jacobian", frame, "hybrid")])
    assert gpu.model is m and gpu.scalar == "float64"
    for function in functions:
        given = arguments(m, function, 131)
        expected = getattr(axode, function)(m, *given)
        assert_same(getattr(gpu, function)(*map(host_cupy.asarray, given)), expected, tolerance)
        one = [x[0] for x in given]
        assert_same(getattr(gpu, function)(*map(host_cupy.asarray, one)), getattr(axode, function)(m, *one), tolerance)
    q = arguments(m, "poses", 5)[0]
    assert_same(gpu.jacobian(host_cupy.asarray(q), frame), axode.jacobian(m, q, frame), 1e-12)
    assert_same(gpu.jacobian(host_cupy.asarray(q), m.frame_index(frame), "hybrid"), axode.jacobian(m, q, frame, "hybrid"), 1e-12)


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_float32_is_float(cuda, mechanism):
    m = MECHANISMS[mechanism]
    source = axode.codegen.c_source(m, CHEAP, single_precision=True, abi="cuda").text.partition("*/")[2]
    assert not re.search(r"\bdouble\b|\b(sin|cos|sqrt|sincos|atan2|nan)\(|\d\.\d*(e-?\d+)?[^\df.e]", source.replace("(0.0 / 0.0)", ""))
    gpu = cuda.kernels(m, ["inverse_dynamics", "mass_matrix"], "float32")
    for function in ("inverse_dynamics", "mass_matrix"):
        given = arguments(m, function, 3, np.float32)
        found = getattr(gpu, function)(*map(host_cupy.asarray, given))
        assert found.dtype == np.float32
        assert_same(found, getattr(axode, function)(m, *given), 1e-5)


@pytest.mark.parametrize("mechanism", ["arm", "humanoid"])
def test_forward_dynamics_in_float32_has_a_result_in_every_state_of_a_robot(cuda, mechanism):
    m = MECHANISMS[mechanism]
    given = arguments(m, "forward_dynamics", 300, np.float32)
    found = cuda.kernels(m, ["forward_dynamics"], "float32").forward_dynamics(*map(host_cupy.asarray, given))
    assert_same(found, axode.forward_dynamics(m, *given), 1e-3)


def test_angles_may_have_any_size(cuda):
    gpu = cuda.kernels(ARM, ["mass_matrix"])
    q = 1e7 * arguments(ARM, "mass_matrix", 4)[0]
    assert_same(gpu.mass_matrix(host_cupy.asarray(q)), axode.mass_matrix(ARM, q), 1e-12)


def test_singular_states_and_nan_are_nan_and_their_neighbours_are_not(cuda):
    m = axode.Model.from_bodies([
        {"name": "a", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}},
        {"name": "b", "on": "a", "joint": {"kind": "revolute", "axis": "y", "point": [0, 0, 0]}},
        {"name": "c", "on": "b", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1, "com": [0, 0, 0],
         "inertia": [0.1, 0.2, 0.25]}])
    gpu = cuda.kernels(m, ["forward_dynamics", "inverse_mass_matrix", "inverse_dynamics"])
    q = host_cupy.asarray([[0.3, 1, 0.2], [0.3, 0, 0.2], [0.3, 1, 0.2], [np.nan, np.nan, np.nan], [0.3, 1, 0.2]])
    v, tau = host_cupy.asarray(np.zeros((2, 5, 3)))
    for result in (gpu.forward_dynamics(q, v, tau), gpu.inverse_mass_matrix(q)):
        assert np.isnan(result.reshape(5, -1)).all(1).tolist() == [False, True, False, True, False]
        assert np.isfinite(result[::2]).all()
    with pytest.raises(axode.SingularError):
        axode.forward_dynamics(m, q[1], v[1], tau[1])


def test_a_launch_has_a_thread_for_each_state_and_copies_only_what_lies_otherwise(cuda):
    gpu = cuda.kernels(ARM, ["inverse_dynamics"])
    for N in (0, 1, 128, 129, 1000):
        host_cupy.RawModule.launches.clear()
        # Arrays as the kernels want them.
        q, v, a = (host_cupy.asarray(np.ascontiguousarray(x.T)).T for x in arguments(ARM, "inverse_dynamics", N))
        tau = gpu.inverse_dynamics(q, v, a)
        assert tau.shape == (N, 7) and tau.T.flags.c_contiguous
        assert len(host_cupy.RawModule.launches) == (N > 0)
        for name, grid, block, pointers, n in host_cupy.RawModule.launches:
            assert name == "axode_inverse_dynamics_states" and n == N
            assert (grid[0] - 1) * block[0] < N <= grid[0] * block[0]
            assert pointers == [x.ctypes.data for x in (q, v, a, tau)]
    rows = host_cupy.asarray(arguments(ARM, "inverse_dynamics", 6)[0])
    strided = host_cupy.asarray(np.repeat(rows, 2, 0))[::2]
    assert np.array_equal(gpu.inverse_dynamics(strided, strided, strided), gpu.inverse_dynamics(rows, rows, rows))


def test_arrays_of_another_library_come_back_as_its_own(cuda, monkeypatch):
    class Tensor:
        __module__ = "tensors.core"

        def __init__(self, array):
            self.array = array

        def __dlpack_device__(self):
            return self.array.__dlpack_device__()

    monkeypatch.setitem(sys.modules, "tensors", types.SimpleNamespace(from_dlpack=Tensor))
    gpu = cuda.kernels(ARM, ["inverse_dynamics"])
    given = [host_cupy.asarray(x) for x in arguments(ARM, "inverse_dynamics", 3)]
    tau = gpu.inverse_dynamics(*map(Tensor, given))
    assert type(tau) is Tensor and np.array_equal(tau.array, gpu.inverse_dynamics(*given))
    monkeypatch.setitem(sys.modules, "tensors", types.SimpleNamespace())
    assert type(gpu.inverse_dynamics(*map(Tensor, given))) is host_cupy.ndarray


def test_wrong_arguments_are_refused_in_a_sentence(cuda):
    gpu = cuda.kernels(ARM, ["inverse_dynamics"])
    x = host_cupy.asarray(np.zeros((4, 7)))
    other = x.copy()
    other.device = host_cupy.Device(1)
    for error, message, given in [
        (TypeError, r"q is a numpy.ndarray and not on a GPU; move it there", (np.zeros((4, 7)), x, x)),
        (TypeError, r"v is a builtins.list and not on a GPU", (x, [0] * 7, x)),
        (TypeError, r"a is of float32; these kernels are of float64", (x, x, host_cupy.asarray(x, np.float32))),
        (TypeError, r"inverse_dynamics takes q, v, a; 2 arguments were given", (x, x)),
        (ValueError, r"v has shape \(4, 6\); expected \(7,\) or \(N, 7\)", (x, x[:, :6], x)),
        (ValueError, r"q has shape \(1, 4, 7\); expected", (x[None], x, x)),
        (ValueError, r"v is of 3 states; q is of 4 states", (x, x[:3], x)),
        (ValueError, r"a is of one state; q is of 4 states", (x, x, x[0])),
        (ValueError, r"v is on GPU 1; q is on GPU 0", (x, other, x)),
    ]:
        with pytest.raises(error, match=message):
            gpu.inverse_dynamics(*given)
    with pytest.raises(ValueError, match="made without mass_matrix; name it in axode.cuda.kernels"):
        gpu.mass_matrix(x)
    with pytest.raises(ValueError, match="made without jacobian flange body"):
        gpu.jacobian(x, "flange")
    with pytest.raises(AttributeError, match="no 'crba'"):
        gpu.crba(x)
    with pytest.raises(ValueError, match="scalar is 'float16'; expected one of"):
        cuda.kernels(ARM, ["mass_matrix"], "float16")
    with pytest.raises(ValueError, match="functions is empty"):
        cuda.kernels(ARM, [])
    with pytest.raises(ValueError, match="it is called 'mass_matrix' here"):
        cuda.kernels(ARM, ["crba"])


def test_nothing_to_compute(cuda):
    fixed = axode.Model.from_bodies([{"name": "block", "joint": "fixed", "mass": 1, "com": [0, 0, 0], "inertia": [1, 1, 1]}])
    gpu = cuda.kernels(fixed, ["inverse_dynamics", "poses"])
    nothing = host_cupy.asarray(np.zeros((3, 0)))
    assert gpu.inverse_dynamics(nothing, nothing, nothing).shape == (3, 0)
    assert_same(gpu.poses(nothing), axode.poses(fixed, np.zeros((3, 0))), 1e-15)


NVRTC = pytest.mark.skipif(nvrtc.LIBRARY is None, reason="there is no NVRTC: pip install nvidia-cuda-nvrtc-cu12")


@NVRTC
@pytest.mark.parametrize("architecture", ["compute_70", "compute_75", "compute_80", "compute_86", "compute_89", "compute_90"])
def test_sources_compile_for_every_architecture(architecture):
    for m, functions in ((PENDULUM, RECORDED), (ARM, ["inverse_dynamics", ("jacobian", "flange", "hybrid")])):
        for single in (False, True):
            source = axode.codegen.c_source(m, functions, "p", single, "cuda")
            ptx, said = nvrtc.compiled(source.text, architecture)
            assert ptx is not None, said
            assert re.sub("nvrtc: warning: Architectures prior to .* are deprecated.*\n", "", said) == ""
            assert re.findall(r"\.entry (\w+)\(", ptx) == [f"{cost.name}_states" for cost in source.functions]
            assert f".target {architecture.replace('compute', 'sm')}" in ptx


@NVRTC
@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_sources_of_all_mechanisms_compile_and_read_each_argument_where_it_is(mechanism):
    m = MECHANISMS[mechanism]
    for single in (False, True):
        # The functions of the humanoid are written in parts.
        source = axode.codegen.c_source(m, ["inverse_dynamics", "mass_matrix"], "p", single, "cuda")
        ptx, said = nvrtc.compiled(source.text, "compute_80")
        assert ptx is not None and said == "", said
        assert "ld.global" in ptx and not re.search(r"\b(ld|st)\.f(32|64)", ptx), "addresses are known to be global or local"


@NVRTC
def test_fast_math_is_refused():
    source = axode.codegen.c_source(PENDULUM, ["mass_matrix"], abi="cuda").text
    ptx, said = nvrtc.compiled(source, "compute_80", "--use_fast_math")
    assert ptx is None and "compile this file without --use_fast_math" in said


def gpu_or_skip():
    cupy = pytest.importorskip("cupy", reason="there is no CuPy, and no GPU to try it on")
    try:
        cupy.cuda.runtime.getDeviceCount()
    except cupy.cuda.runtime.CUDARuntimeError as error:
        pytest.skip(f"there is no GPU: {error}")
    return cupy


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_a_gpu_gives_what_the_library_gives(mechanism):
    cupy, m = gpu_or_skip(), MECHANISMS[mechanism]
    gpu = axode.cuda.kernels(m, CHEAP)
    for function in CHEAP:
        given = arguments(m, function, 1000)
        found = getattr(gpu, function)(*map(cupy.asarray, given))
        host = type(found)(*map(cupy.asnumpy, found)) if isinstance(found, tuple) else cupy.asnumpy(found)
        assert_same(host, getattr(axode, function)(m, *given), 1e-9)


def test_the_page_shows_what_happens(cuda, tmp_path, monkeypatch):
    command = SOURCE / "build/release/axode"
    if not command.exists():
        pytest.skip("there is no build/release/axode; `make build` builds it")
    monkeypatch.chdir(tmp_path)
    run_page("docs/cuda.md", {**os.environ, "PATH": f"{command.parent}:{os.environ['PATH']}"})


def test_the_example_finds_the_possible_candidates_wherever_it_runs():
    example = SOURCE / "examples/python/14_on_a_gpu.py"
    done = subprocess.run([sys.executable, example], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    assert re.search(r"^20000 states on ", done.stdout, re.MULTILINE)
    possible = int(re.search(r"possible candidates: (\d+) of 200", done.stdout)[1])
    assert 0 < possible < 200
    assert float(re.search(r"library: (\S+) N m", done.stdout)[1]) < 1e-9


def test_the_benchmark_says_what_it_lacks():
    done = subprocess.run([sys.executable, SOURCE / "bench/cuda_batch.py"], capture_output=True, text=True)
    if done.returncode == 0:
        assert "inverse_dynamics" in done.stdout
    else:
        assert re.fullmatch(r"no GPU was measured: there is (no CuPy; pip install cupy-cuda12x|none that CuPy .*)\n", done.stderr)
