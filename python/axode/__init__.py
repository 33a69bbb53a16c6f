"""Dynamics of multibody systems in the language of screws and SE(3).

    import axode
    arm = axode.load("robot.urdf")
    tau = axode.inverse_dynamics(arm, q, v, a)

q has shape (nq,), and v, a and tau have shape (nv,). For N states at once the shapes are (N, nq) and (N, nv), and
every result has the axis N as well. Units are SI: m, kg, s, rad, N. Six-vectors have the angular part before the
linear one, quaternions are x y z w, and accelerations are the true time derivatives of the components, without
gravity. Velocities of spherical, planar and free joints are components in the child's joint frame. Arguments may be
arrays of any real type and layout, lists or tuples; float64 arrays in C order are not copied. Results are new arrays
of float64.

The examples in the docstrings use `arm = axode.load(axode.robots / "arm7.toml")`, `fourbar`, of four_bar.toml there, and
numpy as `np`.
"""

from __future__ import annotations

import difflib
import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _axode, calibration, closed_form, codegen, convert, drives, fmi, identification, lie, table
from ._axode import *  # noqa: F403 (the functions of axode.table)
from ._axode import (
    Body,
    Joint,
    MassMatrixFactor,
    Model,
    TaskSpace,
    Trajectory,
    assemble,
    closure_coordinates,
    closure_derivatives,
    constraint_wrenches,
    contact_rollout_derivatives,
    contact_rollout_jvp,
    contact_rollout_vjp,
    contacts,
    distances,
    drawing,
    equilibrium,
    equilibrium_with_drives,
    forward_dynamics_at,
    forward_dynamics_rates,
    impact,
    independent_equations,
    independent_linearization,
    inverse_dynamics_rates,
    inverse_kinematics,
    inverse_kinematics_rates,
    jacobian_columns,
    jacobian_derivative_along,
    jacobian_derivatives,
    jacobian_partials,
    joint_state,
    kinematic_motion,
    linearize,
    linearize_with_drives,
    local_mobility,
    loop_bias,
    loop_hessian_product,
    loop_jacobian,
    loop_mobility,
    loop_multiplier_derivatives,
    loop_multipliers,
    loop_residual,
    loop_residual_jacobian,
    mjcf,
    motion_vjp,
    pair_distances,
    read_drawing,
    read_sdf,
    read_urdf,
    rollout_derivatives,
    rollout_derivatives_with_drives,
    rollout_jvp,
    rollout_vjp,
    second_order_inverse_dynamics,
    shape_pairs,
    spatial_momentum_form,
    spring_coordinate,
    twist_derivatives,
    twist_form,
    urdf,
    with_floor,
    with_shapes,
)
from ._axode import instruction_set as _instruction_set
from ._axode import name_here as _name_here
from ._axode import version as __version__
from .builder import Builder
from .errors import AssemblyError, Fault, ModelError, NotFiniteError, SimulationError, SingularError, StatesError
from .files import check, load
from .records import (
    BranchPoint,
    ContactRolloutDerivatives,
    ContactRolloutGradient,
    ContactEvent,
    ContactForce,
    DriveEquilibrium,
    DriveLinearization,
    DriveRolloutDerivatives,
    DynamicsAtTime,
    Equilibrium,
    ForwardDynamicsDerivatives,
    ForwardDynamicsHessian,
    InverseDynamicsDerivatives,
    InverseDynamicsHessian,
    InverseKinematics,
    JointState,
    KinematicMotion,
    Linearization,
    Load,
    LocalMobility,
    LoopMobility,
    MomentumFormDerivatives,
    MotionBranch,
    MotionChange,
    MotionDerivatives,
    PairDistances,
    PlayEvent,
    RedundantRow,
    Rollout,
    RolloutDerivatives,
    RolloutGradient,
    ShapeDistance,
    SpringCoordinate,
    StateDerivatives,
    Target,
    TaskEquations,
    TaskSingularity,
)
from .simulation import reconstruct, rollout, simulate
from .support import copies as _copies
from .viewer import Viewer, view

_copies.install()

#: The folder of the mechanisms that come with the package: arm7.toml, double_pendulum.toml, humanoid.urdf,
#: machine.toml.
robots: Path = Path(__file__).parent / "share/axode/robots"
#: The instruction set whose code is used, such as "x86-64-v3": the best one of this processor, or the one
#: that the environment variable AXODE_INSTRUCTION_SET named when axode was imported.
instruction_set: str = _instruction_set

__all__ = [
    # mechanisms
    "Model", "Body", "Joint", "Builder", "load", "check", "read_drawing", "read_urdf", "read_sdf", "drawing", "urdf",
    "mjcf", "robots", "instruction_set", "__version__",
    # kinematics
    "jacobian_partials", "jacobian_derivatives", "jacobian_derivative_along", "jacobian_columns", "twist_derivatives",
    "inverse_kinematics", "inverse_kinematics_rates",
    # dynamics
    "MassMatrixFactor", "spring_coordinate",
    # momentum form
    "twist_form", "spatial_momentum_form",
    # derivatives
    "inverse_dynamics_rates", "second_order_inverse_dynamics", "forward_dynamics_rates", "motion_vjp", "linearize",
    "linearize_with_drives", "equilibrium", "equilibrium_with_drives",
    # closed loops
    "loop_residual", "loop_jacobian", "loop_bias", "loop_residual_jacobian", "loop_hessian_product", "assemble",
    "loop_mobility", "local_mobility", "closure_coordinates", "closure_derivatives", "impact", "constraint_wrenches",
    "independent_equations", "independent_linearization", "loop_multipliers", "loop_multiplier_derivatives",
    "joint_state", "TaskSpace",
    # prescribed motions
    "forward_dynamics_at", "kinematic_motion",
    # collision shapes
    "contacts", "distances", "pair_distances", "shape_pairs", "with_floor", "with_shapes",
    # motion in time
    "simulate", "rollout", "rollout_derivatives", "rollout_derivatives_with_drives", "rollout_jvp", "rollout_vjp",
    "contact_rollout_derivatives", "contact_rollout_jvp", "contact_rollout_vjp", "reconstruct", "Trajectory",
    # in a browser
    "view", "Viewer",
    # what else is taken, given and raised
    "Load", "Target", "InverseKinematics", "InverseDynamicsDerivatives", "ForwardDynamicsDerivatives",
    "InverseDynamicsHessian", "ForwardDynamicsHessian", "SpringCoordinate", "StateDerivatives", "MotionDerivatives",
    "MotionChange", "MomentumFormDerivatives", "Linearization", "Equilibrium", "DriveLinearization", "DriveEquilibrium",
    "DriveRolloutDerivatives", "DynamicsAtTime", "KinematicMotion", "Rollout", "RolloutDerivatives", "RolloutGradient",
    "TaskEquations",
    "TaskSingularity", "JointState", "LoopMobility", "RedundantRow", "LocalMobility", "MotionBranch", "BranchPoint",
    "ContactRolloutDerivatives", "ContactRolloutGradient", "ShapeDistance", "PairDistances", "ContactEvent", "ContactForce", "PlayEvent",
    "AssemblyError", "Fault", "ModelError", "NotFiniteError", "SimulationError", "SingularError", "StatesError",
    # modules
    "lie", "closed_form", "codegen", "convert", "drives", "fmi", "identification", "calibration", "table",
]
__all__ += _axode.__all__  # the functions of axode.table

#: Modules that need other packages, which are imported where one asks for them.
BRIDGES = ("casadi", "cuda", "distributed", "jax", "torch")

if not TYPE_CHECKING:  # to a type checker every name would be known

    def __getattr__(name: str) -> Any:
        if name in BRIDGES:
            try:
                return importlib.import_module(f"{__name__}.{name}")
            # hasattr catches AttributeError only; `import axode.jax` raises ImportError.
            except ImportError as error:
                raise AttributeError(str(error)) from error
        message = f"module {__name__!r} has no attribute {name!r}"
        if (here := _name_here(name)) in __all__:
            raise AttributeError(f"{message}; it is called {here!r} here")
        near = difflib.get_close_matches(name, [*__all__, *BRIDGES], n=1)
        raise AttributeError(message + (f"; did you mean {near[0]!r}?" if near else ""))
