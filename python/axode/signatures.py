"""inspect.signature for the functions and methods of the compiled module."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from typing import Any

from . import _axode


def parameters(text: str, defaults: tuple[Any, ...]) -> Iterator[inspect.Parameter]:
    """The parameters of `def f(...) -> ...`, in which a backslash and a number stand for one of the defaults. What a
    property reads with has no name."""
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


_axode.describe(type(_axode.load_file), property(signature))
_axode.describe(type(_axode.Model.neutral), property(signature))
_axode.describe(type(_axode.Model.neutral.__get__(object())), property(signature_without_self))
setattr(_axode.MassMatrixFactor, "__signature__", signature_without_self(_axode.MassMatrixFactor.__init__))
