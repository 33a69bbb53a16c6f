"""Every public name has a docstring, with an example that runs and gives the output that it shows."""

import ast
import doctest
import inspect

import axode
import numpy as np
import pytest

MODULES = [axode, axode.lie, axode.closed_form, axode.codegen, axode.convert, axode.drives, axode.fmi, axode.identification,
           axode.calibration]


def public_objects():
    """(dotted name, object) of all public functions, classes and methods."""
    for module in MODULES:
        for name in module.__all__:
            value = getattr(module, name)
            if callable(value):
                yield f"{module.__name__}.{name}", value
                if inspect.isclass(value) and value.__module__.endswith("_axode"):
                    for method, function in vars(value).items():
                        if not method.startswith("_") and callable(function):
                            yield f"{module.__name__}.{name}.{method}", function


OBJECTS = dict(public_objects())
# Records and methods with a docstring of one line are explained by the functions that return them.
WITHOUT_EXAMPLE = {"axode.Body", "axode.Joint", "axode.Fault", "axode.InverseKinematics",
                   "axode.MassMatrixFactor.solve", "axode.MassMatrixFactor.inverse"}


@pytest.mark.parametrize("name", OBJECTS)
def test_docstring_has_an_example_that_runs(name):
    text = OBJECTS[name].__doc__
    assert text, f"{name} has no docstring"
    names = {"np": np, "axode": axode, "arm": axode.load(axode.robots / "arm7.toml"),
             "fourbar": axode.load(axode.robots / "four_bar.toml")}
    test = doctest.DocTestParser().get_doctest(text, names, name, None, None)
    is_record = inspect.isclass(OBJECTS[name]) and issubclass(OBJECTS[name], tuple)
    assert test.examples or name in WITHOUT_EXAMPLE or is_record, f"{name} has no example"
    printed = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test, out=printed.append)
    assert not printed, "".join(printed)


@pytest.mark.parametrize("name", OBJECTS)
def test_signature_is_the_one_of_the_docstring(name):
    if name in {"axode.Model", "axode.Body", "axode.Joint", "axode.Trajectory", "axode.Load", "axode.Target",
                "axode.calibration.Measurement", "axode.codegen.Specialised"}:
        return  # they have no constructor, or that of a dict
    signature = inspect.signature(OBJECTS[name])
    written = (OBJECTS[name].__doc__ or "").partition("\n")[0]
    if written.startswith(name.rpartition(".")[2] + "("):
        function = ast.parse(f"def {written}: ...")
        assert set(signature.parameters) == {node.arg for node in ast.walk(function) if isinstance(node, ast.arg)}


def test_signatures_have_defaults_kinds_and_no_self_where_it_is_bound():
    dynamics = inspect.signature(axode.inverse_dynamics)
    assert list(dynamics.parameters)[:4] == ["m", "q", "v", "a"]
    assert dynamics.parameters["threads"].default == 1
    assert dynamics.parameters["threads"].kind is inspect.Parameter.KEYWORD_ONLY
    arm = axode.load(axode.robots / "arm7.toml")
    assert list(inspect.signature(axode.Model.difference).parameters) == ["self", "q0", "q1"]
    assert list(inspect.signature(arm.difference).parameters) == ["q0", "q1"]
    assert inspect.signature(arm.random).parameters["seed"].default == 0
    assert list(inspect.signature(axode.MassMatrixFactor).parameters) == ["m", "M"]
    inspect.signature(arm.random).bind(seed=3, n=2)
    assert list(inspect.signature(axode.Model.joint_names.fget).parameters) == ["self"]


def test_what_is_public_is_what_the_modules_list():
    for module in MODULES:
        assert len(module.__all__) == len(set(module.__all__))
        callables = {name for name, value in vars(module).items() if not name.startswith("_") and callable(value)
                     and getattr(value, "__module__", "").startswith("axode")}
        assert callables <= {*module.__all__, *axode.__all__}, callables - set(module.__all__)
