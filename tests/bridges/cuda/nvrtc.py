"""NVRTC, the compiler of CUDA, of the package nvidia-cuda-nvrtc-cu12."""

import ctypes
import sysconfig
from pathlib import Path

LIBRARY = next(iter(sorted(Path(sysconfig.get_path("purelib")).glob("nvidia/cuda_nvrtc/lib/libnvrtc.so.*"))), None)


def compiled(source, architecture, *options):
    """(PTX or None, the messages of the compiler)."""
    library, program = ctypes.CDLL(str(LIBRARY)), ctypes.c_void_p()
    words = [f"--gpu-architecture={architecture}".encode(), *(option.encode() for option in options)]

    def text(of):
        size = ctypes.c_size_t()
        assert getattr(library, f"nvrtcGet{of}Size")(program, ctypes.byref(size)) == 0
        buffer = ctypes.create_string_buffer(size.value)
        assert getattr(library, f"nvrtcGet{of}")(program, buffer) == 0
        return buffer.value.decode()

    assert library.nvrtcCreateProgram(ctypes.byref(program), source.encode(), b"kernels.cu", 0, None, None) == 0
    try:
        failed = library.nvrtcCompileProgram(program, len(words), (ctypes.c_char_p * len(words))(*words))
        return None if failed else text("PTX"), text("ProgramLog")
    finally:
        library.nvrtcDestroyProgram(ctypes.byref(program))
