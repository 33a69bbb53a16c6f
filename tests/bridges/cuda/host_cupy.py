"""A stand-in for the part of CuPy that axode.cuda uses, for machines without a GPU: kernels are compiled for the
processor and run one thread after the other.

Arrays say that they are on a GPU. That a GPU computes the same cannot be shown with it.
"""

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

COMPILER = shutil.which("c++")

SHIM = r"""
#include <math.h>
#include <stdlib.h>
struct Index { unsigned x; };
static Index blockIdx, blockDim, threadIdx;
extern "C" void be_thread(unsigned block, unsigned size, unsigned thread) {
  blockIdx.x = block, blockDim.x = size, threadIdx.x = thread;
}
#define __device__
#define __global__
#define __forceinline__ inline
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(threads)
"""


class Device:
    def __init__(self, id):
        self.id = id

    def __eq__(self, other):
        return self.id == other.id

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None


class ndarray(np.ndarray):  # noqa: N801
    device = Device(0)  # numpy's own cannot be set

    def __array_finalize__(self, source):
        self.device = source.device if isinstance(source, ndarray) else Device(0)

    def __dlpack_device__(self):
        return 2, self.device.id


def asarray(x, dtype=None):
    return np.array(x, dtype).view(ndarray)


def empty(shape, dtype):
    return np.full(shape, 7, dtype).view(ndarray)


def zeros(shape, dtype=np.float64):
    return np.zeros(shape, dtype).view(ndarray)


def ascontiguousarray(x):
    return np.asanyarray(x, order="C")


def from_dlpack(x):
    return x.array


int32, moveaxis = np.int32, np.moveaxis


class RawModule:
    launches = []

    def __init__(self, code):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "kernels.cpp"
            file.write_text(SHIM + code)
            subprocess.run([COMPILER, "-std=c++14", "-O0", "-w", "-shared", "-fPIC", file, "-o", f"{folder}/kernels.so"], check=True)
            self.library = ctypes.CDLL(f"{folder}/kernels.so")

    def get_function(self, name):
        function = getattr(self.library, name)

        def launch(grid, block, arguments):
            *arrays, n = arguments
            assert len(grid) == len(block) == 1 and block[0] <= 128 and grid[0] * block[0] >= n
            assert all(type(x) is ndarray and x.flags.c_contiguous for x in arrays)
            assert all(x.shape[-1] == n or (x.ndim, n) == (1, 1) for x in arrays)
            assert type(n) is int32
            RawModule.launches.append((name, grid, block, [x.ctypes.data for x in arrays], n))
            pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in arrays]
            for index in range(grid[0]):
                for thread in range(block[0]):
                    self.library.be_thread(index, block[0], thread)
                    function(*pointers, ctypes.c_int(n))

        return launch
