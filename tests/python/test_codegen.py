"""The generated C is the same as that of the command. The C++ tests compile and call it."""

import subprocess
import sys

import axode
import pytest
from mechanisms import MECHANISMS

ARM = MECHANISMS["arm"]


@pytest.mark.parametrize("single", [False, True])
def test_the_text_is_the_one_that_the_command_writes(single):
    words = ["--functions", "inverse_dynamics,mass_matrix,jacobian:flange:hybrid", "--name", "p", *(["--float"] if single else [])]
    written = subprocess.run([sys.executable, "-m", "axode", "codegen", axode.robots / "arm7.toml", *words],
                             capture_output=True, text=True, check=True).stdout
    functions = ["inverse_dynamics", "mass_matrix", ("jacobian", "flange", "hybrid")]
    assert axode.codegen.c_source(ARM, functions, "p", single).text == written


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
    "no functions": ([], {}, "functions is empty"),
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
    "a prefix with a space": (["mass_matrix"], {"prefix": "my arm"}, 'the prefix "my arm" is not a C identifier'),
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
