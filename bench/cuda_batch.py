"""Times of axode's kernels on a GPU, beside its batches on the processor and MuJoCo MJX on the same GPU.

    python bench/cuda_batch.py                 # prints the table
    python bench/cuda_batch.py docs/cuda.md    # and writes it into the page
    python bench/cuda_batch.py --threads 8     # of the processor's batches

All arguments and results are on the GPU, or in the memory of the processor for the processor. Times are medians, from
the launch to the end of the kernel; neither transfers nor compiling count. Before a function is timed, its results for
1000 states are compared with those of the library, and the results of MJX for the arm as well. MJX is measured if it is
installed (pip install mujoco-mjx), in float32, in which it computes, without constraints, up to 65536 states. Without a
GPU this says so.
"""

import argparse
import os
import statistics
import sys
import time
import warnings
from pathlib import Path

os.environ.setdefault("XLA_PYTHON_CLIENT_PREALLOCATE", "false")  # the memory of the GPU is shared with CuPy

import axode  # noqa: E402
import numpy as np  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tools"))
from page import Page, table  # noqa: E402

STATES = [4096, 65536, 1_000_000]
MOST_STATES_OF_MJX = 65536
FUNCTIONS = ["inverse_dynamics", "forward_dynamics", "forward_dynamics_derivatives"]
BOUND = {"float64": 1e-9, "float32": 2e-3}  # of the difference to the library, by the largest entry
MOST_BYTES = 8e9  # of a result


def gpu_or_exit():
    try:
        import cupy
        cupy.cuda.runtime.getDeviceCount()
    except ImportError:
        sys.exit('no GPU was measured: there is no CuPy; pip install cupy-cuda12x')
    except Exception as error:
        sys.exit(f"no GPU was measured: there is none that CuPy can use ({error})")
    return cupy


def seconds_on_gpu(cupy, call, repetitions=20):
    call()
    times = []
    for _ in range(repetitions):
        start, end = cupy.cuda.Event(), cupy.cuda.Event()
        start.record()
        call()
        end.record()
        end.synchronize()
        times.append(cupy.cuda.get_elapsed_time(start, end) / 1e3)
    return statistics.median(times)


def seconds(call, repetitions=5):
    call()
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def bandwidth(cupy):
    """Bytes read and written in a second by a copy on the GPU."""
    x = cupy.ones(2**28)
    y = cupy.empty_like(x)
    return 2 * x.nbytes / seconds_on_gpu(cupy, lambda: cupy.copyto(y, x))


def states(m, N):
    return m.random(seed=1, n=N), *np.random.default_rng(1).uniform(-1, 1, (2, N, m.nv))


def in_one(result):
    return [*result] if isinstance(result, tuple) else [result]


def check(name, found, expected, bound):
    """Compares the states that have a result, nine of ten at least. In float32 more mass matrices may be singular."""
    found, expected = np.stack(found), np.stack(expected)
    there = np.isfinite(found).all(axis=(0, *range(2, found.ndim)))
    error = np.abs(found - expected)[:, there].max() / np.abs(expected).max()
    if not (error <= bound and there.mean() >= 0.9):
        sys.exit(f"{name}: {there.sum()} of {there.size} states have a result, which differs from the library's by {error:.1e} of "
                 f"the largest entry; 9 of 10 and at most {bound:.0e} are expected")


def _mjcf(m):
    with warnings.catch_warnings(action="ignore"):  # MJCF has no largest velocities
        return axode.mjcf(m)


class Mjx:
    """The same functions of MJX, with all states in one call."""

    def __init__(self, m):
        import jax
        import mujoco
        from mujoco import mjx
        model = mujoco.MjModel.from_xml_string(_mjcf(m))
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_CONTACT
        on_gpu, self._jax = mjx.put_model(model), jax
        data = mjx.make_data(on_gpu)

        def inverse(q, v, a):
            return mjx.inverse(on_gpu, data.replace(qpos=q, qvel=v, qacc=a)).qfrc_inverse

        def forward(q, v, tau):
            return mjx.forward(on_gpu, data.replace(qpos=q, qvel=v, qfrc_applied=tau)).qacc

        self._functions = {"inverse_dynamics": jax.jit(jax.vmap(inverse)), "forward_dynamics": jax.jit(jax.vmap(forward))}

    def call(self, function, given):
        arrays = [self._jax.device_put(np.asarray(x, np.float32)) for x in given]
        return lambda: self._functions[function](*arrays).block_until_ready()


def mjx_of(m):
    try:
        return Mjx(m)
    except ImportError:
        return None


def rows_of(cupy, m, function, threads, mjx, copied):
    """A row for each number of states: times in ns for each state."""
    for scalar in ("float64", "float32"):
        kernels = axode.cuda.kernels(m, [function], scalar)
        for N in STATES:
            if N * m.nv**2 * 3 * 8 > MOST_BYTES and function.endswith("derivatives"):
                continue
            q, v, a = states(m, N)
            given = [cupy.asarray(x.T, scalar, order="C").T for x in (q, v, a)]

            def on_gpu(kernels=kernels, given=given):
                return getattr(kernels, function)(*given)

            few = [np.asarray(x[:1000], scalar).astype(float) for x in (q, v, a)]
            found = [cupy.asnumpy(x) for x in in_one(getattr(kernels, function)(*(cupy.asarray(x, scalar) for x in few)))]
            check(f"{function} of {m.name} in {scalar}", found, in_one(getattr(axode, function)(m, *few)), BOUND[scalar])
            gpu = seconds_on_gpu(cupy, on_gpu) / N
            moved = sum(x[0].nbytes for x in found) + sum(x.nbytes for x in given) / N
            library = mjx_times = ""
            if scalar == "float64":
                cpu = seconds(lambda: getattr(axode, function)(m, q, v, a, threads=threads)) / N  # noqa: B023
                library = f"{cpu / gpu:.0f}"
            elif mjx and N <= MOST_STATES_OF_MJX and not function.endswith("derivatives"):
                call = mjx.call(function, (q, v, a))
                if m.nq == m.nv:
                    check(f"{function} of {m.name} by MJX", [np.asarray(call())[:1000]],
                          [getattr(axode, function)(m, q[:1000], v[:1000], a[:1000])], 1e-2)
                mjx_times = f"{seconds(call) / N / gpu:.0f}"
            row = [m.name, function, scalar, f"{N:,}", f"{gpu * 1e9:.2f}", f"{100 * moved / gpu / copied:.0f} %", library,
                   mjx_times]
            print(" ".join(f"{cell:>12}" for cell in row), flush=True)
            yield row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", nargs="?", type=Path, help="a page with <!-- gpu --> and <!-- end -->")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="of the processor's batches")
    given = parser.parse_args()
    cupy = gpu_or_exit()
    import axode.cuda  # noqa: F401
    copied = bandwidth(cupy)
    name = cupy.cuda.runtime.getDeviceProperties(0)["name"].decode()
    print(f"{name}, copies {copied / 1e12:.2f} TB/s; {given.threads} threads of the processor", flush=True)
    rows = []
    for m in (axode.load(axode.robots / "arm7.toml"), axode.load(axode.robots / "humanoid.urdf", base="free")):
        mjx = mjx_of(m)
        for function in FUNCTIONS:
            rows += rows_of(cupy, m, function, given.threads, mjx, copied)
    header = ["robot", "function", "scalar", "states", "ns a state", "of the bandwidth", "library / GPU", "MJX / GPU"]
    if given.page:
        text = f"{name}, whose copies move {copied / 1e12:.2f} TB/s, beside {given.threads} threads of the processor:\n\n"
        Page(given.page).part("gpu", text + table(header, rows, "---:::::"))


if __name__ == "__main__":
    main()
