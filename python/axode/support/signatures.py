"""inspect.signature for the functions of the compiled module, and explanations of wrong calls of any function of this
package."""

from __future__ import annotations

import ast
import difflib
import functools
import inspect
import numbers
import re
import sys
from collections.abc import Callable, Iterator
from types import FunctionType, ModuleType
from typing import Any

from .. import _axode


def parameters(text: str, defaults: tuple[Any, ...]) -> Iterator[inspect.Parameter]:
    """The parameters of `def f(...) -> ...`, in which a backslash and a number mean one of the defaults. The
    parameter of a property getter has no name."""
    named = text.replace("def (", "def getter(", 1)
    function = ast.parse(re.sub(r"\\(\d+)", r"default_\1", named) + ": ...").body[0]
    assert isinstance(function, ast.FunctionDef)
    given = {f"default_{k}": value for k, value in enumerate(defaults)}

    def parameter(argument: ast.arg, default: ast.expr | None, kind: Any) -> inspect.Parameter:
        annotation = ast.unparse(argument.annotation) if argument.annotation else inspect.Parameter.empty
        value: Any = inspect.Parameter.empty
        if default is not None:
            value = given[default.id] if isinstance(default, ast.Name) else ast.literal_eval(default)
        return inspect.Parameter(argument.arg, kind, default=value, annotation=annotation)

    names = function.args
    before = [*names.posonlyargs, *names.args]
    of_last: list[ast.expr | None] = [*[None] * (len(before) - len(names.defaults)), *names.defaults]
    for argument, default in zip(before, of_last):
        positional = argument in names.posonlyargs
        yield parameter(argument, default, inspect.Parameter.POSITIONAL_ONLY if positional
                        else inspect.Parameter.POSITIONAL_OR_KEYWORD)
    if names.vararg:
        yield parameter(names.vararg, None, inspect.Parameter.VAR_POSITIONAL)
    for argument, keyword_default in zip(names.kwonlyargs, names.kw_defaults):
        yield parameter(argument, keyword_default, inspect.Parameter.KEYWORD_ONLY)


def signature(function: Any) -> inspect.Signature:
    text, _, defaults = function.__nb_signature__[0]
    return inspect.Signature(list(parameters(text, defaults or ())), return_annotation=text.rpartition(" -> ")[2])


def signature_without_self(method: Any) -> inspect.Signature:
    whole = signature(method)
    return whole.replace(parameters=list(whole.parameters.values())[1:])


#: The requirement on an argument in words, by its annotation, as far as Python can check it.
KINDS = {"Model": (_axode.Model, "an axode.Model"), "axode._axode.Model": (_axode.Model, "an axode.Model"),
         "int": (numbers.Integral, "a whole number"), "float": (numbers.Real, "a number"), "bool": (bool, "True or False"),
         "str": (str, "a text"), "dict[str, typing.Any]": (dict, "a dict")}


def in_words(names: list[str]) -> str:
    return " and ".join([", ".join(map(repr, names[:-1])), repr(names[-1])] if len(names) > 1 else map(repr, names))


def wrong_names(callee: str, takes: list[inspect.Parameter], given: list[Any], by_name: dict[str, Any]) -> str | None:
    """Explanation of wrong names or a wrong number of arguments, or None."""
    names = [x.name for x in takes]
    positional = [x.name for x in takes if x.kind is not x.KEYWORD_ONLY]
    for name in by_name:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            return (f"{callee} has no argument {name!r}; " +
                    (f"did you mean {near[0]!r}?" if near else f"it takes {', '.join(names) or 'none'}"))
    if len(given) > len(positional):
        after = [name for name in names if name not in positional and name not in by_name]
        return (f"{callee} takes at most {len(positional)} arguments by their places"
                f"{' (' + ', '.join(positional) + ')' if positional else ''}, got {len(given)}" +
                (f"; write {after[0]}=... for an argument by name" if after else ""))
    if twice := [name for name in positional[:len(given)] if name in by_name]:
        return f"{callee} is given {in_words(twice)} twice, by place and by name"
    missing = [x.name for x in takes if x.default is x.empty and x.name not in [*positional[:len(given)], *by_name]]
    return f"{callee} needs {in_words(missing)} as well" if missing else None


def explanation(function: Any, given: list[Any], by_name: dict[str, Any]) -> str | None:
    """Explanation of a wrong call of a function of nanobind; None if the reason is not clear."""
    takes = list(signature(function).parameters.values())
    # A constructor is called by the name of its class.
    callee = function.__qualname__.removesuffix(".__init__")
    if takes and takes[0].name == "self":
        if not given:
            return None
        takes, given = takes[1:], given[1:]
    if wrong := wrong_names(callee, takes, given, by_name):
        return wrong
    values = {**dict(zip([x.name for x in takes], given)), **by_name}
    for x in takes:
        if x.name not in values or (values[x.name] is None and x.default is None):
            continue
        value, annotation = values[x.name], str(x.annotation)
        kind, expected = KINDS.get(annotation.removesuffix(" | None"), (object, annotation))
        if not isinstance(value, kind) or (value is None and "None" not in annotation):
            return f"{callee}: {x.name}: expected {expected}, got {type(value).__name__}"
    for name, value in values.items():
        if isinstance(value, numbers.Integral) and not 0 <= int(value) < 2**31:
            return f"{callee}: {name} is {value}; " + ("it must not be negative" if value < 0 else "it is too large")
    return None


def functions_in(where: ModuleType | type) -> Iterator[Any]:
    """The functions of nanobind in a module."""
    for value in vars(where).values():
        if isinstance(value, (type(_axode.load_file), type(_axode.Model.neutral))):
            yield value
        elif isinstance(value, (ModuleType, type)):
            yield from functions_in(value)


def explained(function: Callable[..., Any], is_method: bool) -> Callable[..., Any]:
    """A Python function that explains wrong names of arguments as the functions of nanobind do."""

    @functools.wraps(function)
    def call(*given: Any, **by_name: Any) -> Any:
        try:
            return function(*given, **by_name)
        except TypeError as error:
            # The function itself has raised the error.
            if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                raise
            takes = list(inspect.signature(function).parameters.values())[is_method:]
            if any(x.kind in (x.VAR_POSITIONAL, x.VAR_KEYWORD) for x in takes):
                raise
            callee = function.__qualname__
            # The constructor of the class, or of a base class.
            if function.__name__ in ("__init__", "__new__"):
                callee = (given[0] if function.__name__ == "__new__" else type(given[0])).__qualname__
            wrong = wrong_names(callee, takes, list(given)[is_method:], by_name)
            if wrong is None:
                raise
            raise TypeError(wrong) from None

    return call


def _refuse_name(module: ModuleType, name: str) -> Any:
    near = difflib.get_close_matches(name, module.__all__, n=1)
    raise AttributeError(f"module {module.__name__!r} has no attribute {name!r}"
                         + (f"; did you mean {near[0]!r}?" if near else ""))


def explain_calls(module: str) -> None:
    """Explains the functions, the constructors and the methods that a module of this package makes public, and names
    that it does not have."""
    here = sys.modules[module]
    setattr(here, "__getattr__", functools.partial(_refuse_name, here))
    for name in here.__all__:
        value = getattr(here, name)
        if isinstance(value, FunctionType) and value.__module__ == module:
            setattr(here, name, explained(value, False))
        elif isinstance(value, type) and value.__module__.startswith(_axode.__name__.partition(".")[0]):
            for key, attribute in list(vars(value).items()):
                function = getattr(attribute, "__func__", attribute)
                if isinstance(function, FunctionType) and (key in ("__init__", "__new__") or not key.startswith("_")):
                    better = explained(function, not isinstance(attribute, staticmethod) or key == "__new__")
                    setattr(value, key, better if function is attribute else type(attribute)(better))


for found in functions_in(_axode):
    _axode.explain_wrong_calls(found, explanation)
_axode.describe(type(_axode.load_file), property(signature))
_axode.describe(type(_axode.Model.neutral), property(signature))
_axode.describe(type(_axode.Model.neutral.__get__(object())), property(signature_without_self))
for made in (_axode.MassMatrixFactor, _axode.TaskSpace):
    setattr(made, "__signature__", signature_without_self(made.__init__))
