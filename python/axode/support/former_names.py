"""Former names of functions and attributes, which work for one minor version with a DeprecationWarning."""

from __future__ import annotations

import warnings

from .._axode import Trajectory
from ..records import JointState

functions: dict[str, str] = {"mobility": "inverse_operational_space_inertia"}
attributes: dict[type, dict[str, str]] = {
    Trajectory: {"gap": "position_residuals", "slip": "velocity_residuals", "stopped": "stop_reason"},
    JointState: {"gap": "position_residual", "slip": "velocity_residual"},
}


def _alias(owner: type, former: str, name: str) -> property:
    def get(self: object) -> object:
        warnings.warn(f"{owner.__name__}.{former} is now {name}", DeprecationWarning, stacklevel=2)
        return getattr(self, name)

    get.__name__, get.__module__ = former, owner.__module__  # so that the stubs of the class contain it
    return property(get, doc=f"Former name of {name}.")


def install() -> None:
    """Adds the former names of attributes to their classes."""
    for owner, names in attributes.items():
        for former, name in names.items():
            setattr(owner, former, _alias(owner, former, name))
