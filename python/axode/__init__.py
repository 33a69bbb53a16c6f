"""Dynamics of multibody systems in screws and SE(3)."""

from pathlib import Path

from ._axode import (
    Body,
    Joint,
    Model,
    check,
    drawing,
    inverse_dynamics,
    load,
    poses,
    read_drawing,
    read_urdf,
    twists,
    urdf,
)
from .errors import Fault, ModelError, SingularError

robots = Path(__file__).parent / "robots"
