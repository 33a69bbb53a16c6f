"""Exceptions of this package in addition to ValueError, KeyError and TypeError."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from .support import signatures

if TYPE_CHECKING:
    from ._axode import Trajectory

__all__ = ["AssemblyError", "Fault", "ModelError", "NotFiniteError", "SimulationError", "SingularError", "StatesError"]


@dataclass(frozen=True)
class Fault:
    """An error or a warning about a mechanism.

    `rule` is a short name that does not change between versions (`mass_not_positive`), `element` is the faulty
    element (`body "forearm"`), and `message` has the value and the rule. `file` and `line` are "" and 0 for
    mechanisms described in Python.
    """

    severity: Literal["error", "warning"]
    rule: str
    element: str
    message: str
    file: str
    line: int
    _text: str = field(repr=False)

    def __str__(self) -> str:
        return self._text


class ModelError(ValueError):
    """A mechanism that cannot be built. `faults` lists everything that is wrong with it, not only the first.

    >>> try:
    ...     axode.Model.from_bodies([{"name": "rod", "joint": {"kind": "prismatic", "axis": [0, 0, 0]}, "mass": -1,
    ...                               "com": [0, 0, 0], "inertia": [1, 1, 1]}])
    ... except axode.ModelError as error:
    ...     print([fault.rule for fault in error.faults])
    ['zero_axis', 'mass_not_positive']
    """

    def __init__(self, text: str, faults: list[Fault]):
        super().__init__(text, faults)
        self.faults = faults

    def __str__(self) -> str:
        return str(self.args[0])


class StatesError(ArithmeticError):
    """Some of the states of a call have no result. `states` are their indices ([0] for a single state), and `result`
    is the result of the call, with the results of all other states.

    >>> issubclass(axode.SingularError, axode.StatesError)
    True
    """

    def __init__(self, text: str, states: list[int], result: NDArray[np.float64]):
        super().__init__(text, states, result)
        self.states = states
        self.result = result

    def __str__(self) -> str:
        return str(self.args[0])


class SingularError(StatesError):
    """The mass matrix of some states cannot be inverted; the message names the joint. Their results are NaN.

    >>> massless = axode.Model.from_bodies([{"name": "slide", "joint": {"kind": "prismatic", "axis": "z"}}])
    >>> try:
    ...     axode.forward_dynamics(massless, [0.0], [0.0], [0.0])
    ... except axode.SingularError as error:
    ...     print(error.states, error.result)
    [0] [nan]
    """


class NotFiniteError(StatesError):
    """The numbers of some states are so large that their results overflow.

    >>> try:
    ...     axode.kinetic_energy(arm, arm.neutral(), np.full(7, 1e200))
    ... except axode.NotFiniteError as error:
    ...     print(error.states, error.result)
    [0] nan
    """


class AssemblyError(ArithmeticError):
    """Loops that cannot be closed from a guess; the message names them and their residuals. `q` is the best
    configuration that was found, and `residual` the residual there, rad and m.

    >>> try:
    ...     axode.assemble(fourbar, [3.0, 0.0, 0.0], hold=["crank_joint"], iterations=0)
    ... except axode.AssemblyError as error:
    ...     print(error.q[0])
    3.0
    """

    def __init__(self, text: str, q: NDArray[np.float64], residual: float):
        super().__init__(text, q, residual)
        self.q = q
        self.residual = residual

    def __str__(self) -> str:
        return str(self.args[0])


class SimulationError(ArithmeticError):
    """A motion that could not continue; the message says when and why. `trajectory` is the motion until then.

    >>> try:
    ...     axode.simulate(arm, np.zeros(7), np.zeros(7), 1.0, tau=lambda t, q, v: np.full(7, 1e200))
    ... except axode.SimulationError as error:
    ...     print(error.trajectory.t)
    [0.]
    """

    def __init__(self, text: str, trajectory: Trajectory):
        super().__init__(text, trajectory)
        self.trajectory = trajectory

    def __str__(self) -> str:
        return str(self.args[0])


signatures.explain_calls(__name__)
