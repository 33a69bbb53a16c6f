"""Identification of geometric parameters from measured poses: the true positions of the joints of a real mechanism.

Section 6.2 of the paper: B_i is replaced by B_i exp(pi_i), six parameters for each body. Frames of the mechanism have
the poses C_f = C_b O exp(rho), O the drawn pose of the frame on its last body and rho the error of the tool; a device
whose own frame has the pose D measures D^-1 C_f, or only the position of its origin. `calibrate` finds all these
parameters from many measured poses: the residuals are log((D^-1 C_f)^-1 C_measured), their Jacobian is exact
(`frame_geometry_jacobian`), and the steps are those of Levenberg and Marquardt on SE(3). There are no Euler angles,
and parallel axes cause no singularity.

Six parameters for each joint are more than poses can determine: a displacement of body i along its own joint has the
same effect as one of its successor, in 2 parameters of a hinge or a screw, and in 4 of a slider. Measured poses of a
serial arm in general position determine 4 parameters for each hinge, 2 for each slider, and 6 more. Directions that
cannot be determined are found and reported, and the correction is the smallest one that explains the poses, unless a
`prior` says how well the drawing is known. An offset of a joint coordinate is a displacement along the joint, which
pi contains already. Displacements that the device shares with the first joints are attributed to the device.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import lie
from .fitting import geometric_unknowns, geometry_fit, measured_poses, redrawing
from .support import arguments, signatures
from ._axode import Model

__all__ = ["Calibration", "Measurement", "calibrate", "with_geometry"]

Array = NDArray[np.float64]


class _MeasurementNeeds(TypedDict):
    frame: str | int
    q: ArrayLike


class Measurement(_MeasurementNeeds, total=False):
    """Measurements of a frame in N configurations q (N, nq): `pose` (N, 4, 4) or `position` (N, 3), in m.

    Both are in the frame of the measuring device, which is the inertial frame if `calibrate` is called with
    device=False. A Measurement is a dict.

    >>> measured = axode.calibration.Measurement(frame="flange", q=np.zeros((1, 7)), position=[[0, 0, 1.306]])
    >>> measured["frame"]
    'flange'
    """

    pose: ArrayLike
    position: ArrayLike


class Calibration(NamedTuple):
    """Result of `calibrate`. There are p parameters: six of each calibrated body, six of each measured frame, and six
    of the device."""

    model: Model
    """m with the geometry found, the poses of measured frames on their bodies included."""
    parameters: Array
    """(n_bodies, 6): pi_i in the order of `m.body_names`, angles (rad) before lengths (m), 0 where not calibrated."""
    tools: dict[str, Array]
    """Of each measured frame exp(rho), its pose (4, 4) in the one that is drawn."""
    device: Array
    """(4, 4): the pose of the device in the inertial frame."""
    parameter_names: list[str]
    """(p) of what was calibrated: `link 1 rx`, ..., `link 1 z`, `tool flange rx`, ..., `device z`."""
    covariance: Array
    """(p, p), of small displacements, angular before linear, in the axes of the frames found: B exp(pi) exp(error)."""
    deviations: Array
    """(p,) standard deviations, the roots of its diagonal. They are those of the smallest correction, to which what
    cannot be identified contributes nothing, or with a prior those of what is known after the measurement."""
    rank: int
    """The number of combinations of parameters that the measured poses show, without any prior."""
    unidentifiable: Array
    """(p - rank, p): a basis of the small displacements that change no measured pose."""
    unidentifiable_names: list[str]
    """Its rows in words, `link 1 rz - link 2 rz`, rounded: terms below 5 % are left out."""
    condition: float
    """Condition number of the weighted Jacobian on what it shows, lengths in parts of the size of what was measured."""
    noise: Array
    """(2,) standard deviations of each component, rad and m, as given or as estimated. nan for rad without poses."""
    residual: Array
    """(2,) root mean square of angles (rad) and distances (m) between measured poses and those of `model`."""
    residual_before: Array
    """(2,) the same for m, where what is sought of the device's pose and of tools' rotations is roughly so."""
    iterations: int
    """How often the equations were linearised."""
    converged: bool
    """Whether the steps and the noise came to an end."""


def calibrate(m: Model, measurements: Measurement | Sequence[Measurement], *, bodies: Sequence[str] | None = None,
              tool: bool = True, device: bool = True, noise: ArrayLike | None = None, prior: ArrayLike | None = None,
              robust: bool = False) -> Calibration:
    """Identifies the geometry of m from measured poses or positions of frames: a `Measurement`, or a list of them.

    Begin with about 3 to 5 poses for each unknown combination, spread over the whole workspace. One frame may be
    measured in several parts, and several frames by one device.

    bodies: names of the bodies whose six parameters are identified; if left out, all bodies that carry a measured
        frame. The two bodies of a cylindrical or universal joint have separate parameters: the resulting model has
        two joints with the same names.
    tool: whether the pose of each measured frame on its body is identified; with False it is that of m. ValueError if
        the frame is that of a moving body itself, because this has no pose of its own.
    device: whether the pose of the device is identified, wherever the device is; with False its frame is the inertial
        frame.
    noise: standard deviations (rad, m) of each component of a measured pose; if left out, they are estimated.
    prior: standard deviations (rad, m) of the joints and tools in the drawing, about the point of each joint. If it
        is left out, directions that the poses do not determine get the smallest correction.
    robust: whether outliers count by their size instead of its square (Huber), separately for angles and positions.

    Measured rotations may differ from orthonormal matrices by 1e-3 and are replaced by the nearest rotation. Device
    and tool may be turned by any angle; the method converges for errors of joints of up to ten degrees and a
    decimetre. O(N p^2) for each of about 20 iterations; memory grows with N only by arrays as large as the poses.
    ValueError for wrong shapes, numbers that are not finite, matrices that are not poses and too few measurements;
    KeyError for unknown names and keys.

    >>> random = np.random.default_rng(0)
    >>> built = axode.calibration.with_geometry(arm, random.normal(0, 0.01, (7, 6)))  # some 0.6 degrees and 10 mm
    >>> q = arm.random(n=60)
    >>> C = axode.poses(built, q)[:, arm.frame_index("flange")] @ axode.lie.exp(random.normal(0, 1e-4, (60, 6)))
    >>> found = axode.calibration.calibrate(arm, {"frame": "flange", "q": q, "pose": C})
    >>> found.rank, found.residual_before.round(3), found.residual.round(4), found.noise.round(4)
    (34, array([0.033, 0.042]), array([0.0002, 0.0002]), array([0.0001, 0.0001]))
    >>> found.unidentifiable_names[0]
    'link 1 z - link 2 z'
    """
    data = measured_poses.Measurements(m, measurements)
    unknowns = geometric_unknowns.Unknowns(m, data, bodies, tool, device)
    given = None if noise is None else _deviations("noise", noise)
    known = None if prior is None else _deviations("prior", prior)
    fit = geometry_fit.GeometryFit(data, unknowns, given, known, robust)
    covariance = fit.covariance()
    unidentifiable, words = unknowns.directions(fit.null_space)
    return Calibration(
        model=fit.geometry.model,
        parameters=lie.log(fit.geometry.bodies),
        tools=fit.geometry.tools,
        device=fit.geometry.device,
        parameter_names=unknowns.names,
        covariance=covariance,
        deviations=np.sqrt(np.diagonal(covariance)),
        rank=fit.rank,
        unidentifiable=unidentifiable,
        unidentifiable_names=words,
        condition=fit.condition,
        noise=fit.noise,
        residual=fit.residual,
        residual_before=fit.residual_before,
        iterations=fit.iterations,
        converged=fit.converged,
    )


def with_geometry(m: Model, parameters: ArrayLike, tools: Mapping[str, ArrayLike] | None = None) -> Model:
    """The model m with B_i exp(pi_i) instead of B_i, for `parameters` pi (n_bodies, 6), rad and m, and with displaced
    tools.

    `tools` has, by the name of a frame, the pose exp(rho) (4, 4) by which the frame is displaced on its body.
    Everything else stays the same: joint screws and inertias in the frames of the bodies, names, limits, losses,
    couplings, other frames. Cylindrical and universal joints become the two joints of which they consist. The
    derivatives by pi at 0 are `frame_geometry_jacobian`. ValueError for wrong shapes and for tools that are frames of
    moving bodies; KeyError for unknown frames.

    >>> pi = np.zeros((7, 6))
    >>> pi[3, 3] = 0.002  # the elbow is 2 mm further in x
    >>> built = axode.calibration.with_geometry(arm, pi)
    >>> axode.poses(built, arm.neutral())[arm.frame_index("flange"), :3, 3].round(4)
    array([0.002, 0.   , 1.306])
    """
    pi = arguments.shaped("parameters", parameters, (m.n_bodies, 6), "(n_bodies, 6), six for each body")
    own = {name: measured_poses.exact_poses(f"tools[{name!r}]", C, (4, 4)) for name, C in (tools or {}).items()}
    for name in own:
        redrawing.check_tool(m, m.frame_names[m.frame_index(name)], f"tools[{name!r}]")
    return redrawing.Drawing(m).build(lie.exp(pi), own)


def _deviations(argument: str, given: ArrayLike) -> Array:
    x = arguments.shaped(argument, given, (2,), "(2,), standard deviations in rad and m")
    if not np.all(x > 0):
        raise ValueError(f"{argument} is {x.tolist()}; expected standard deviations in rad and m, more than 0")
    return x


signatures.explain_calls(__name__)
