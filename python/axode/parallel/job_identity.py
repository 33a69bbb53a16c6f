"""Identity of the job of a folder of parts: a digest of values and of code that is the same in every process."""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import types
from typing import Any

import numpy as np

__all__: list[str] = []

#: Everything that a code object does; the lines and the file where it is written do not count.
CODE = ("co_code", "co_consts", "co_names", "co_varnames", "co_freevars", "co_cellvars", "co_argcount",
        "co_posonlyargcount", "co_kwonlyargcount", "co_flags", "co_exceptiontable")
#: Where the Python functions behind an attribute of a class are.
BEHIND = ("__func__", "func", "fget", "fset", "fdel")


class Unknown(str):
    """Explanation why a value cannot be compared with that of an earlier call."""


def digest(value: Any) -> str | Unknown:
    """SHA-256 of a value. The digest of a function depends on its code, its defaults and the values to which it is
    bound; that of an object on its state and the code of its class; that of a compiled function, a compiled class or
    a module on its name. Global variables and the functions that are called by name do not count.

    An Unknown if the value holds something whose state pickle cannot write, such as a lock or an open file.
    """
    digests = _Digests({})
    try:
        return digests.of(value)
    except Exception as error:
        return Unknown(f"holds an object of {_name(type(digests.last))}, which cannot be compared ({error})")


def _name(of: Any) -> str:
    return f"{getattr(of, '__module__', '')}.{getattr(of, '__qualname__', '')}"


class _Digests(pickle.Pickler):
    """Pickles values so that equal ones have equal bytes: values that Python may share or not, such as texts and
    tuples, are never references to earlier ones. Functions and classes are written with their code."""

    def __init__(self, seen: dict[int, tuple[int, Any]]):
        self.hash, self.seen, self.last = hashlib.sha256(), seen, None
        super().__init__(types.SimpleNamespace(write=self.hash.update), protocol=4)

    def of(self, value: Any) -> str:
        self.dump(value)
        return self.hash.hexdigest()

    def persistent_id(self, value: Any) -> Any:
        """What is written instead of a value, or None."""
        self.last = value
        kind = type(value)
        if kind in (str, bytes):
            return int.from_bytes(repr(value).encode(), "big")
        if kind is tuple:
            return ["tuple", *value]
        if kind in (set, frozenset):
            return [kind.__name__, *sorted(_Digests(self.seen).of(x) for x in value)]
        if isinstance(value, (np.ndarray, np.generic)) and not value.dtype.hasobject:
            return [_name(kind), value.dtype.descr, value.shape, hashlib.sha256(value.tobytes()).digest()]
        if isinstance(value, (types.ModuleType, np.ufunc)):
            return [kind.__name__, value.__name__]
        if kind is types.CodeType:
            return ["code", *(getattr(value, name, None) for name in CODE)]
        if id(value) in self.seen:
            return self.seen[id(value)][0]
        if kind is types.FunctionType or isinstance(value, type):
            self.seen[id(value)] = -len(self.seen), value  # stays alive, and its id its own
            return self._class(value) if isinstance(value, type) else [
                "function", value.__qualname__, value.__code__, value.__defaults__, value.__kwdefaults__, vars(value),
                value.__closure__]
        if kind is types.CellType:
            return ["cell", *([value.cell_contents] if value != types.CellType() else [])]
        if hasattr(value, "__wrapped__") and types.FunctionType not in map(type, vars(kind).values()):
            return ["compiled", value.__wrapped__]
        return None

    def _class(self, kind: type) -> list[Any]:
        """The functions and the data of a class and of those that it is derived from."""
        found: list[Any] = [_name(kind)]
        for base in kind.__mro__[:-1]:
            for name, attribute in vars(base).items():
                behind = [attribute, *(getattr(attribute, of, None) for of in BEHIND)]
                if functions := [one for one in behind if isinstance(one, types.FunctionType)]:
                    found += [name, functions]
                elif not (name.startswith("__") or hasattr(type(attribute), "__get__")):
                    with contextlib.suppress(Exception):  # such as the caches of abstract classes
                        found += [name, _Digests(self.seen).of(attribute)]
        return found
