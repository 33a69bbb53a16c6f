"""Functions of one mechanism for many states on a GPU of NVIDIA, by CUDA that is generated for the mechanism and
compiled by CuPy.

    import axode.cuda
    gpu = axode.cuda.kernels(arm, ["inverse_dynamics"])
    tau = gpu.inverse_dynamics(q, v, a)  # arrays on the GPU, of CuPy or PyTorch

This needs CuPy (pip install cupy-cuda12x) and a GPU. `axode.codegen.c_source(m, functions, abi="cuda")` generates the
source without either.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

try:
    import cupy  # type: ignore[import-not-found, import-untyped, unused-ignore]
except ImportError as error:
    raise ImportError('axode.cuda needs CuPy: pip install cupy-cuda12x') from error

from .support import signatures
from ._axode import Model
from .codegen import Function, c_source
from .records import (
    ForwardDynamicsDerivatives,
    ForwardDynamicsHessian,
    InverseDynamicsDerivatives,
    InverseDynamicsHessian,
    Representation,
)
from .table import ROWS

__all__ = ["Kernels", "kernels"]

BLOCK = 128  # threads: the launch bound of the generated kernels

# The named tuples for the consecutive blocks of a result, by
# the function that it differentiates and the number of blocks.
_BLOCKS: dict[tuple[str, int], Any] = {
    ("inverse_dynamics", 3): InverseDynamicsDerivatives, ("inverse_dynamics", 4): InverseDynamicsHessian,
    ("forward_dynamics", 3): ForwardDynamicsDerivatives, ("forward_dynamics", 4): ForwardDynamicsHessian,
}


class _Kernel(NamedTuple):
    launch: Any
    name: str
    arrays: tuple[str, ...]  # names of the arguments
    shape: tuple[int, ...]  # of the result of one state, as it is generated
    size: int  # number of its numbers
    blocks: Any  # the named tuple of its results, if they are blocks


class Kernels:
    """Functions of one mechanism, compiled for a GPU by `kernels`. Threads may share the object.

    Each function is a method with the name and the arguments of the function in axode, without loads and threads. The
    arguments are arrays on one GPU, of one state or N states, from CuPy, PyTorch or any library with DLPack, in the
    precision that was chosen. Results have the shapes of axode, and are arrays of the library of the first argument,
    or of CuPy if that library has no from_dlpack. The kernels read states side by side, (nq, N): an array of shape
    (N, nq) is copied, unless it is the transpose of an array in C order. Results are such transposes.

    No call waits for the GPU. Therefore numbers are not checked: NaN gives NaN, and quaternions are not normalised.
    If the mass matrix may be singular, the results of forward dynamics and of related functions are NaN;
    `axode.forward_dynamics` decides such cases. TypeError for arguments that are not arrays on a GPU and for another
    precision, ValueError for wrong shapes.
    """

    def __init__(self, m: Model, functions: Sequence[Function], scalar: Literal["float64", "float32"]) -> None:
        source = c_source(m, functions, "axode", scalar == "float32", "cuda")
        module = cupy.RawModule(code=source.text)
        self.model, self.scalar, self._type = m, scalar, np.dtype(scalar)
        self._kernels = {
            _key(m, function): _kernel(m, function, module.get_function(f"{cost.name}_states"))
            for function, cost in zip(functions, source.functions, strict=True)}

    def __getattr__(self, name: str) -> Any:
        if name in ROWS and ROWS[name].recorded:
            return lambda *arrays: self._call((name,), arrays)
        raise AttributeError(f"axode.cuda.Kernels has no {name!r}")

    def jacobian(self, q: Any, frame: str | int, representation: Representation = "body") -> Any:
        """Computes `axode.jacobian`."""
        return self._call(_key(self.model, ("jacobian", frame, representation)), (q,))

    def _call(self, key: tuple[Any, ...], arrays: tuple[Any, ...]) -> Any:
        kernel = self._kernels.get(key)
        if kernel is None:
            raise ValueError(f"these kernels were made without {' '.join(map(str, key))}; name it in axode.cuda.kernels")
        names = kernel.arrays
        if len(arrays) != len(names):
            raise TypeError(f"{kernel.name} takes {', '.join(names)}; {len(arrays)} arguments were given")
        states = [self._states(name, x) for name, x in zip(names, arrays, strict=True)]
        one, N, device = states[0].ndim == 1, states[0].shape[-1] if states[0].ndim == 2 else 1, states[0].device
        for name, x in zip(names, states, strict=True):
            if x.ndim != states[0].ndim or (not one and x.shape[-1] != N):
                raise ValueError(f"{name} is of {_count(x)}; q is of {_count(states[0])}")
            if x.device != device:
                raise ValueError(f"{name} is on GPU {x.device.id}; q is on GPU {device.id}")
        if N >= 2**31:
            raise ValueError(f"{N} states are too many for one call; at most 2147483647 are possible")
        with device:
            out = cupy.empty((kernel.size, N), self._type)
            if out.size > 0:
                kernel.launch(((N + BLOCK - 1) // BLOCK,), (BLOCK,), (*map(cupy.ascontiguousarray, states), out, cupy.int32(N)))
            parts = [cupy.moveaxis(x, -1, 0) for x in _formed(kernel, out.reshape(*kernel.shape, N))]
        parts = [_returned(arrays[0], x[0] if one else x) for x in parts]
        return kernel.blocks(*parts) if kernel.blocks else parts[0]

    def _states(self, name: str, x: Any) -> Any:
        """The array with the entries of a state first."""
        if isinstance(x, cupy.ndarray):
            array = x
        elif hasattr(x, "__dlpack_device__") and x.__dlpack_device__()[0] in (2, 13):  # CUDA, CUDA managed
            array = cupy.from_dlpack(x)
        else:
            kind = f"{type(x).__module__}.{type(x).__name__}"
            raise TypeError(f"{name} is a {kind} and not on a GPU; move it there (cupy.asarray, tensor.cuda()), or call the "
                            "function of this name in axode")
        if array.dtype != self._type:
            raise TypeError(f"{name} is of {array.dtype}; these kernels are of {self.scalar}")
        length = self.model.nq if name == "q" else self.model.nv
        if array.ndim not in (1, 2) or array.shape[-1] != length:
            raise ValueError(f"{name} has shape {tuple(array.shape)}; expected ({length},) or (N, {length})")
        return array.T


def kernels(m: Model, functions: Sequence[Function], scalar: Literal["float64", "float32"] = "float64") -> Kernels:
    """Functions of m as kernels for a GPU, a thread for each state.

    functions are those of `axode.codegen.c_source`. CuPy compiles a function when it is first called, in about a
    second for short functions and in minutes for the derivatives of a humanoid, and caches the result. Armature and
    gravity are included; loads, joint losses and springs are not. ValueError for an unknown function, for dynamics of
    a mechanism with loops and for another precision, KeyError for an unknown frame.

    >>> gpu = axode.cuda.kernels(arm, ["inverse_dynamics"])  # doctest: +SKIP
    >>> q, v, a = cupy.zeros((3, 4096, 7))  # doctest: +SKIP
    >>> gpu.inverse_dynamics(q, v, a).shape  # doctest: +SKIP
    (4096, 7)
    """
    if scalar not in ("float64", "float32"):
        raise ValueError(f"scalar is {scalar!r}; expected one of 'float64', 'float32'")
    return Kernels(m, functions, scalar)


def _word(function: Function) -> str:
    return function if isinstance(function, str) else function[0]


def _key(m: Model, function: Function) -> tuple[Any, ...]:
    """Key that distinguishes functions."""
    if isinstance(function, str):
        return (function,)
    frame = function[1] if isinstance(function[1], int) else m.frame_index(function[1])
    return ("jacobian", m.frame_names[frame], function[2] if len(function) == 3 else "body")


def _kernel(m: Model, function: Function, launch: Any) -> _Kernel:
    row = ROWS[_word(function)]
    shape = (m.n_frames, 4, 3) if row.name == "poses" else row.item(m)
    shape = shape[::-1] if row.name == "jacobian" else shape
    return _Kernel(launch, row.name, row.arrays, shape, math.prod(shape), _BLOCKS.get((row.derivative_of, len(row.symbols))))


def _formed(kernel: _Kernel, out: Any) -> Any:
    """The parts of a result."""
    if kernel.blocks:
        return list(out)
    if kernel.name != "poses":
        return [out]
    C = cupy.zeros((out.shape[0], 4, 4, out.shape[-1]), out.dtype)
    C[:, :3] = out.swapaxes(1, 2)  # columns of R, r
    C[:, 3, 3] = 1
    return [C]


def _returned(given: Any, result: Any) -> Any:
    """The result as an array of the library that the argument came from."""
    if isinstance(given, cupy.ndarray):
        return result
    library = sys.modules[type(given).__module__.partition(".")[0]]
    return library.from_dlpack(result) if hasattr(library, "from_dlpack") else result


def _count(x: Any) -> str:
    return "one state" if x.ndim == 1 else f"{x.shape[-1]} states"


signatures.explain_calls(__name__)
