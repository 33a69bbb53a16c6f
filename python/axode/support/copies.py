"""Copies of compiled objects that never change: each is its own copy. They have no pickles, and the error says what to
pickle instead."""

from __future__ import annotations

from typing import NoReturn, TypeVar

from .._axode import Body, Joint, Trajectory

T = TypeVar("T")

#: What has a pickle and tells as much.
INSTEAD: dict[type, str] = {Trajectory: "its arrays, such as t, q and v, or its to_pandas()",
                            Joint: "the Model and the name of the joint", Body: "the Model and the name of the body"}


def _itself(self: T, memo: object = None) -> T:
    return self


def _refuse(self: object, protocol: int) -> NoReturn:
    kind = type(self)
    raise TypeError(f"a {kind.__name__} cannot be pickled; pickle {INSTEAD[kind]}")


def install() -> None:
    for kind in INSTEAD:
        setattr(kind, "__copy__", _itself)
        setattr(kind, "__deepcopy__", _itself)
        setattr(kind, "__reduce_ex__", _refuse)
