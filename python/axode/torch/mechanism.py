"""Models for operations of PyTorch, which refer to them by a key, with arrays of the library."""

from __future__ import annotations

import atexit
import contextlib
import functools
import hashlib
import itertools
import json
import math
import pickle
import weakref
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import torch  # type: ignore[import-not-found, unused-ignore]
from numpy.typing import NDArray
from torch import Tensor

from .. import _axode
from .._axode import Model, check_counts
from ..codegen import Specialised
from ..support.coordinates import GROUPS, TURNING
from ..table import ROWS

__all__: list[str] = []

Array = NDArray[np.float64]

#: The number of recently used models that are kept for later operations.
KEPT = 256
#: The number of models with other parameters that are kept, so that backward finds the model of forward.
KEPT_PARAMETERS = 32
#: Calls with fewer states run on one core.
MANY = 64
#: The largest difference of the norm of a quaternion from 1, as in the library.
OFF_LENGTH = {torch.float64: 1e-6, torch.float32: 1e-4}


def array(x: Tensor, axes: int = 1) -> Array:
    """The numbers of a tensor, with the axes of an item and at most one in front."""
    a: Array = x.detach().numpy()
    lead, item = a.shape[:a.ndim - axes], a.shape[a.ndim - axes:]
    return a if len(lead) < 2 else a.reshape(math.prod(lead), *item)


class Part(NamedTuple):
    """Coordinates of one joint, or of several joints whose velocities are the rates of their coordinates."""

    kind: str
    q: slice
    v: slice


class Mechanism:
    """A model for operations of PyTorch."""

    def __init__(self, m: Model | Specialised, key: str):
        self.key = key
        self.model = m if isinstance(m, Model) else m.model
        self.compiled = {} if isinstance(m, Model) else _compiled(m)
        self.is_specialised = not isinstance(m, Model)
        self.sizes = (self.model.nq, self.model.nv, 10 * self.model.n_bodies)
        self.parts = _parts(self.model)
        self.turning = [part for part in self.parts if part.kind in TURNING]

    def __call__(self, name: str, *arguments: Any) -> tuple[Array, ...]:
        """The results of a function of axode."""
        states = np.shape(arguments[0])
        many = len(states) == 2 and states[0] >= MANY
        function = self.compiled.get(name) or functools.partial(getattr(_axode, name), self.model)
        result = function(*arguments, threads=torch.get_num_threads() if many else 1)
        return result if isinstance(result, tuple) else (result,)

    def configurations(self, q: Tensor) -> Array:
        """The configurations with quaternions of length 1; the library refuses those that are too far from it."""
        given = array(q)
        if not self.turning:
            return given
        unit = given.astype(np.float64)
        for part in self.turning:
            at = slice(part.q.start, part.q.start + 4)
            length = np.linalg.norm(unit[..., at], axis=-1, keepdims=True)
            if np.all(np.abs(length - 1) <= OFF_LENGTH[q.dtype]):
                unit[..., at] /= length
        return unit

    @functools.cached_property
    def tree(self) -> Mechanism:
        """The mechanism without its loops, whose mass matrix and energies are those of the mechanism."""
        if self.model.n_loops == 0:
            return self
        drawing = {key: value for key, value in self.model.to_dict().items() if key not in ("loop", "coupling")}
        return mechanism_of(Model.from_dict(drawing))

    @functools.cached_property
    def still(self) -> Mechanism:
        """The tree without gravity, whose forces at rest are M a."""
        return mechanism_of(self.tree.model.with_gravity([0, 0, 0]))

    @functools.cached_property
    def heights(self) -> list[Mechanism]:
        """The tree with a gravity of 1 m/s^2 against x, y and z: its potential energies are first moments of mass."""
        return [mechanism_of(self.tree.model.with_gravity(-axis)) for axis in np.eye(3)]


def _compiled(s: Specialised) -> dict[str, Callable[..., Any]]:
    """The functions for which a specialised model was compiled."""
    found = {}
    for name, row in ROWS.items():
        if hasattr(s, name) and "frame" not in row.takes:
            with contextlib.suppress(ValueError):  # the library computes it instead
                getattr(s, name)(*(np.empty((0, s.model.nq if x == "q" else s.model.nv)) for x in row.arrays))
                found[name] = getattr(s, name)
    if "forward_dynamics" in found:
        found["rollout_under"] = functools.partial(_axode.rollout_under, s.model, compiled=s)
    return found


def _parts(m: Model) -> list[Part]:
    parts: list[Part] = []
    for joint in m.joints:
        if joint.nv == 0:
            continue
        kind = joint.kind if joint.kind in GROUPS else "plain"
        first = parts.pop() if kind == "plain" and parts and parts[-1].kind == "plain" else joint
        parts.append(Part(kind, slice(first.q.start, joint.q.stop), slice(first.v.start, joint.v.stop)))
    return parts


#: The models that are alive: the last ones that were used, and all that a graph goes back through.
_mechanisms: weakref.WeakValueDictionary[str, Mechanism] = weakref.WeakValueDictionary()
_specialised_number = itertools.count(1)


@functools.lru_cache(maxsize=KEPT)
def mechanism_of(m: Model | Specialised) -> Mechanism:
    model = m if isinstance(m, Model) else m.model
    key = f"{model.name} {hashlib.sha256(pickle.dumps(model)).hexdigest()[:16]}"
    if not isinstance(m, Model):
        key += f" specialised {next(_specialised_number)}"
    if (found := _mechanisms.get(key)) is not None:
        return found
    return _mechanisms.setdefault(key, Mechanism(m, key))


@functools.lru_cache(maxsize=KEPT_PARAMETERS)
def with_parameters(key: str, pi: bytes) -> Mechanism:
    known = mechanism(key)
    if known.is_specialised:
        raise ValueError("parameters: a specialised model is compiled with its own parameters; give the model itself")
    return Mechanism(known.model.with_parameters(np.frombuffer(pi)), key)


@atexit.register
def _forget() -> None:
    """Removes all models at the end of the process. PyTorch keeps operations and graphs until then, and their models
    would be reported as leaks."""
    mechanism_of.cache_clear()
    with_parameters.cache_clear()
    for each in list(_mechanisms.values()):
        vars(each).clear()


def mechanism(key: str) -> Mechanism:
    try:
        return _mechanisms[key]
    except KeyError:
        raise KeyError(f"this process knows no model {key!r}; axode.torch.handle(m) registers one") from None


def key_of(m: Model | Specialised) -> str:
    """The key by which operations refer to a model."""
    if not isinstance(m, (Model, Specialised)):
        raise TypeError(f"m: expected an axode.Model, or a specialised model from Model.specialise, got {type(m).__name__}")
    return mechanism_of(m).key


def _of_model(value: Callable[..., Any]) -> Callable[..., Any]:
    """A function of the key of a model. For torch.compile the key is a constant, so that it compiles again for
    another model."""

    def constant(key: str, *arguments: Any) -> Any:
        return value(mechanism(key), *arguments)

    torch.compiler.assume_constant_result(constant)
    return constant


torch.compiler.assume_constant_result(key_of)
sizes = _of_model(lambda of: of.sizes)
total_mass = _of_model(lambda of: of.model.total_mass)
still = _of_model(lambda of: of.still.key)
heights = _of_model(lambda of: tuple(each.key for each in of.heights))
refuse_loops = _of_model(lambda of, name: check_counts(of.model, name))
pairs_of = _of_model(lambda of: json.dumps(_axode.shape_pairs(of.model)))
frame_index = _of_model(lambda of, frame: of.model.frame_index(frame))
