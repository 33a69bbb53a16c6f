"""Generated C, compiled and called, gives what the library gives."""

import ctypes
import shutil
import subprocess

import axode
import numpy as np
import pytest
from mechanisms import MECHANISMS, REPRESENTATIONS, close, random_states

COMPILER = shutil.which("cc")
COMPILED = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler cc")
EVERYWHERE = pytest.mark.parametrize("mechanism", MECHANISMS)
ARM = MECHANISMS["arm"]


class Compiled:
    """The functions of a source, called with arrays."""

    def __init__(self, source, folder, dtype=np.float64):
        (folder / "source.c").write_text(source.text)
        subprocess.run([COMPILER, "-std=c99", "-Wall", "-Werror", "-O1", "-shared", "-fPIC", "source.c", "-o",
                        "source.so", "-lm"], cwd=folder, check=True)
        self.library, self.dtype = ctypes.CDLL(str(folder / "source.so")), dtype

    def __call__(self, name, *arguments, size):
        """(what it returns, its result)."""
        arrays = [np.array(x, self.dtype) for x in arguments] + [np.full(size, np.nan, self.dtype)]
        status = getattr(self.library, name)(*(x.ctypes.data_as(ctypes.c_void_p) for x in arrays))
        return status, arrays[-1]


@COMPILED
@EVERYWHERE
def test_compiled_functions_agree_with_the_library(mechanism, tmp_path):
    m = MECHANISMS[mechanism]
    frame = m.frame_names[-1]
    jacobians = [("jacobian", frame, representation) for representation in REPRESENTATIONS]
    source = axode.codegen.c_source(
        m, ["inverse_dynamics", "forward_dynamics", "mass_matrix", *jacobians], prefix="p")
    names = [cost.name for cost in source.functions]
    assert names[:3] == ["p_inverse_dynamics", "p_forward_dynamics", "p_mass_matrix"] and len(names) == 7
    call = Compiled(source, tmp_path)
    for q, v, a in zip(*random_states(m, 5)[:3]):
        tau = axode.inverse_dynamics(m, q, v, a)
        assert close(call(names[0], q, v, a, size=m.nv)[1], tau, 1e-11)
        status, again = call(names[1], q, v, tau, size=m.nv)
        assert status == 0 and close(again, a, 1e-8)
        assert close(call(names[2], q, size=m.nv**2)[1].reshape(m.nv, m.nv), axode.mass_matrix(m, q), 1e-12)
        for name, representation in zip(names[3:], REPRESENTATIONS, strict=True):
            J = call(name, q, size=6 * m.nv)[1].reshape(6, m.nv)
            assert close(J, axode.jacobian(m, q, frame, representation), 1e-12)


@COMPILED
def test_single_precision_is_float(tmp_path):
    source = axode.codegen.c_source(ARM, ["inverse_dynamics"], single_precision=True)
    assert "const float *" in source.text and "double *" not in source.text
    call = Compiled(source, tmp_path, np.float32)
    q, v, a, _ = (x[0] for x in random_states(ARM, 1))
    tau = call("arm7_inverse_dynamics", q, v, a, size=7)[1]
    assert close(tau, axode.inverse_dynamics(ARM, q, v, a), 1e-5)


@COMPILED
def test_a_singular_mass_matrix_is_told(tmp_path):
    m = axode.Model.from_bodies([
        {"name": "rod", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}, "mass": 1, "com": [1, 0, 0],
         "inertia": [1, 1, 1]},
        {"name": "wrist", "on": "rod", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}}])
    call = Compiled(axode.codegen.c_source(m, ["forward_dynamics"], "m"), tmp_path)
    assert call("m_forward_dynamics", [0, 0], [0, 0], [0, 1], size=2)[0] == 1


def test_costs_are_those_that_the_text_says():
    source = axode.codegen.c_source(ARM, ("inverse_dynamics", ("jacobian", "flange")))
    assert [cost.name for cost in source.functions] == ["arm7_inverse_dynamics", "arm7_jacobian_flange"]
    for cost in source.functions:
        assert (f"{cost.products} products, {cost.sums} sums, {cost.divisions} divisions, {cost.angles} sines"
                in source.text)
        assert cost.products > 10 and cost.sums > 10 and cost.angles == 12
        assert cost.divisions == cost.roots == 0


def test_frames_are_names_or_numbers():
    number = ARM.frame_names.index("flange")
    assert axode.codegen.c_source(ARM, [("jacobian", number)]) == axode.codegen.c_source(ARM, [("jacobian", "flange")])


WRONG = {
    "no functions": ([], {}, "there are no functions"),
    "a word instead of a list": ("inverse_dynamics", {}, "functions is 'inverse_dynamics'; expected a list"),
    "a function of another library": (["crba"], {}, r"functions\[0\] is 'crba'; .*it is called 'mass_matrix' here"),
    "an unknown function": (["inverse_dynamic"], {}, r"functions\[0\] is 'inverse_dynamic'; .*did you mean"),
    "a jacobian of nothing": (["mass_matrix", "jacobian"], {}, r"functions\[1\] is 'jacobian'; expected .*frame"),
    "a mass matrix of a frame": ([("mass_matrix", "flange")], {}, r"functions\[0\] is .*; expected"),
    "too much": ([("jacobian", "flange", "body", "body")], {}, r"functions\[0\] is .*; expected"),
    "an empty tuple": ([()], {}, r"functions\[0\] is \(\); expected"),
    "no word": ([3], {}, r"functions\[0\] is 3; expected"),
    "a list": ([["jacobian", "flange"]], {}, r"functions\[0\] is \['jacobian', 'flange'\]; expected"),
    "an unknown representation": ([("jacobian", "flange", "world")], {},
                                  r"functions\[0\], representation is 'world'; expected one of 'body'"),
    "a frame out of range": ([("jacobian", 99)], {}, r"functions\[0\], frame is 99; model"),
    "the same twice": (["mass_matrix", "mass_matrix"], {}, "arm7_mass_matrix is asked for twice"),
    "an unknown abi": (["mass_matrix"], {"abi": "cud"}, "abi is 'cud'; expected one of 'plain', 'casadi', 'cuda'; did you mean"),
    "a prefix with a space": (["mass_matrix"], {"prefix": "my arm"}, 'the prefix "my arm" is no C identifier'),
}


@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_request_is_refused(kind):
    functions, options, message = WRONG[kind]
    with pytest.raises(ValueError, match=message):
        axode.codegen.c_source(ARM, functions, **options)


def test_kernels_for_a_gpu_cost_what_functions_do():
    functions = ["inverse_dynamics", ("jacobian", "flange", "hybrid")]
    source = axode.codegen.c_source(ARM, functions, abi="cuda")
    assert source.functions == axode.codegen.c_source(ARM, functions).functions
    assert all(f"void {cost.name}_states(" in source.text for cost in source.functions)


def test_an_unknown_frame_is_a_key_error():
    with pytest.raises(KeyError, match='has no frame "flang"; did you mean "flange"'):
        axode.codegen.c_source(ARM, [("jacobian", "flang")])
