"""Identity of the job of a folder of parts: a digest of values and of code that is the same in every process."""

from __future__ import annotations

import copyreg
import hashlib
import types
from collections.abc import Iterator
from typing import Any

import numpy as np

__all__: list[str] = []

#: Values that their text describes.
PLAIN = (type(None), bool, int, float, complex, str, bytes, types.EllipsisType, types.NotImplementedType)
#: Everything that a code object does; the lines and the file where it is written do not count.
CODE = ("co_code", "co_consts", "co_names", "co_varnames", "co_freevars", "co_cellvars", "co_argcount", "co_posonlyargcount",
        "co_kwonlyargcount", "co_flags", "co_exceptiontable")


class Unknown(Exception):
    """A value holds something that cannot be compared with what an earlier call was given."""


def digest(value: Any) -> str | Unknown:
    """SHA-256 of a value. The digest of a function depends on its code, its defaults and the values to which it is
    bound; that of an object on its state and the code of its class; that of a compiled function, a compiled class or
    a module on its name. Global variables and the functions that are called by name do not count.

    An Unknown if the value holds something whose state Python cannot read, such as a lock or an open file.
    """
    try:
        return _Digests().of(value).hex()
    except Unknown as error:
        return error
    except RecursionError:
        return Unknown("is nested too deeply to be compared")


class _Digests:
    """The digests of values and of all that they are made of, each computed once."""

    def __init__(self) -> None:
        self.known: dict[int, tuple[bytes, Any]] = {}  # the value stays alive, and its id its own
        self.begun: dict[int, int] = {}  # depth at which each value around the present one began

    def of(self, value: Any) -> bytes:
        if type(value) in PLAIN:
            return f"{type(value).__name__} {value!r}".encode()
        key = id(value)
        if key in self.known:
            return self.known[key][0]
        if key in self.begun:  # it is a part of itself
            return f"outer {self.begun[key]}".encode()
        self.begun[key] = len(self.begun)
        parts = [_name(type(value)).encode(), *self._parts(value)]
        found = hashlib.sha256(b"".join(len(part).to_bytes(8, "little") + part for part in parts)).digest()
        del self.begun[key]
        self.known[key] = found, value
        return found

    def _parts(self, value: Any) -> Iterator[bytes]:
        if isinstance(value, (np.ndarray, np.generic)) and not value.dtype.hasobject:
            yield f"{value.dtype.descr if value.dtype.names else value.dtype.str} {value.shape}".encode()
            yield value.tobytes()
        elif type(value) in (set, frozenset):
            yield from sorted(map(self.of, value))
        elif isinstance(value, type):
            yield _name(value).encode()
            yield from self._class(value)
        else:
            yield from map(self.of, _made_of(value))

    def _class(self, kind: type) -> Iterator[bytes]:
        """The functions and the data of a class and of those that it is derived from."""
        for base in kind.__mro__[:-1]:
            for name, attribute in vars(base).items():
                functions = _functions_of(attribute)
                if functions:
                    yield name.encode()
                    yield from map(self.of, functions)
                elif not (name.startswith("__") or hasattr(type(attribute), "__get__")):
                    try:
                        yield self.of(attribute)
                    except Unknown:  # such as the caches of abstract classes
                        continue


def _name(of: Any) -> str:
    return f"{getattr(of, '__module__', '')}.{getattr(of, '__qualname__', '')}"


def _functions_of(attribute: Any) -> list[types.FunctionType]:
    """The Python functions that implement an attribute of a class."""
    behind = [attribute, *(getattr(attribute, name, None) for name in ("__func__", "func", "fget", "fset", "fdel"))]
    return [one for one in behind if isinstance(one, types.FunctionType)]


def _made_of(value: Any) -> Iterator[Any]:
    """The components of a value, in a fixed order."""
    if type(value) in (list, tuple):
        yield from value
    elif type(value) is dict:
        for item in value.items():
            yield from item
    elif isinstance(value, types.ModuleType):
        yield value.__name__
    elif isinstance(value, types.CodeType):
        yield from (getattr(value, name, None) for name in CODE)
    elif isinstance(value, types.FunctionType):
        yield from (value.__qualname__, value.__code__, value.__defaults__, value.__kwdefaults__, vars(value))
        for cell in value.__closure__ or ():
            try:
                yield cell.cell_contents
            except ValueError:
                yield "a variable without a value"
    else:
        yield from _state_of(value)


def _state_of(value: Any) -> Iterator[Any]:
    """The state of an object that pickle would write."""
    kind = type(value)
    reduce = copyreg.dispatch_table.get(kind)
    try:
        found = reduce(value) if reduce else value.__reduce_ex__(4)
    except Exception as error:
        if hasattr(value, "__wrapped__"):  # a compiled wrapper around a function
            yield value.__wrapped__
            return
        raise Unknown(f"holds an object of {_name(kind)}, which cannot be compared ({error})") from error
    if isinstance(found, str):  # something that is known by its name
        yield f"{getattr(value, '__module__', '')}.{found}"
        yield getattr(value, "__wrapped__", None)
        return
    maker, arguments, state, items, pairs = (*found, None, None, None)[:5]
    yield from (maker, arguments, state, list(items or ()), [tuple(pair) for pair in pairs or ()])
