"""Every public name explains itself, with an example that runs and gives what it says."""

import doctest
import inspect

import axode
import numpy as np
import pytest

MODULES = [axode, axode.lie, axode.closed_form, axode.codegen, axode.convert]


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
# Records and methods of one line are explained by the functions that give them.
WITHOUT_EXAMPLE = {"axode.Body", "axode.Joint", "axode.Fault", "axode.InverseKinematics",
                   "axode.MassMatrixFactor.solve", "axode.MassMatrixFactor.inverse"}


@pytest.mark.parametrize("name", OBJECTS)
def test_docstring_has_an_example_that_runs(name):
    text = OBJECTS[name].__doc__
    assert text, f"{name} has no docstring"
    names = {"np": np, "axode": axode, "arm": axode.load(axode.robots / "arm7.toml")}
    test = doctest.DocTestParser().get_doctest(text, names, name, None, None)
    is_record = inspect.isclass(OBJECTS[name]) and issubclass(OBJECTS[name], tuple)
    assert test.examples or name in WITHOUT_EXAMPLE or is_record, f"{name} has no example"
    printed = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test, out=printed.append)
    assert not printed, "".join(printed)


def test_what_is_public_is_what_the_modules_list():
    for module in MODULES:
        assert len(module.__all__) == len(set(module.__all__))
        callables = {name for name, value in vars(module).items() if not name.startswith("_") and callable(value)
                     and getattr(value, "__module__", "").startswith("axode")}
        assert callables <= {*module.__all__, *axode.__all__}, callables - set(module.__all__)
