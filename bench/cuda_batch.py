"""Times of axode's kernels on a GPU, compared with its batches on the processor: cuda_batch.py [--threads N].

For the arm and the humanoid with a free base, in float64 and float32, medians of the time from the launch to the end of the
kernel, with arguments and results on the GPU; transfers and compiling do not count. GRiD's published times of a call for
an arm with seven joints stand beside them; they were taken elsewhere, so only their order of magnitude compares.
Without a GPU it says so.
"""

import argparse
import os
import statistics
import sys
import time

import axode
import numpy as np

STATES = [4096, 16384, 65536, 262144, 1_000_000]
FUNCTIONS = ["inverse_dynamics", "forward_dynamics", "forward_dynamics_derivatives"]
GRID = {"inverse_dynamics": 3.0, "forward_dynamics_derivatives": 12.9}  # us a call, of an arm
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


def measure(cupy, m, function, scalar, threads):
    kernels = axode.cuda.kernels(m, [function], scalar)
    for N in STATES:
        if N * m.nv**2 * 3 * 8 > MOST_BYTES and function.endswith("derivatives"):
            continue
        q = m.random(seed=1, n=N)
        v, a = np.random.default_rng(1).uniform(-1, 1, (2, N, m.nv))
        given = [cupy.asarray(x.T, scalar, order="C").T for x in (q, v, a)]
        gpu = seconds_on_gpu(cupy, lambda: getattr(kernels, function)(*given))
        cpu = seconds(lambda: getattr(axode, function)(m, q, v, a, threads=threads))
        grid = f"{GRID[function] / (gpu / N * 1e6):10.0f}" if m.name == "arm7" and function in GRID else f"{'-':>10}"
        print(f"{m.name:9} {function:29} {scalar} {N:8} {gpu * 1e6:10.1f} {gpu / N * 1e9:9.2f} {cpu / N * 1e9:9.1f} "
              f"{cpu / gpu:7.1f} {grid}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="of the processor's batches")
    threads = parser.parse_args().threads
    cupy = gpu_or_exit()
    print(cupy.cuda.runtime.getDeviceProperties(0)["name"].decode(), f"beside {threads} threads of the processor")
    print("robot     function                      scalar    states   us a call  ns/state  CPU ns/st CPU/GPU GRiD call/state")
    for m in (axode.load(axode.robots / "arm7.toml"), axode.load(axode.robots / "humanoid.urdf", base="free")):
        for function in FUNCTIONS:
            for scalar in ("float64", "float32"):
                measure(cupy, m, function, scalar, threads)


if __name__ == "__main__":
    main()
