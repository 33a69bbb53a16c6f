"""The place where a mechanism is drawn does not matter: ten kilometres away a finger of 10 g moves like one at the
origin."""

import axode
import numpy as np
import pytest
from mechanisms import REPRESENTATIONS, random_states

ORIGINS = [0, 1, 100, 10_000]
# Representations whose quantities are not about the origin.
WAYS = ["fast", *(way for way in REPRESENTATIONS if way != "spatial")]


def bodies(o):
    """The bodies of a hand that is drawn at o. All lengths are sums of few powers of two, so that they are exact
    wherever it is."""
    def body(name, on, joint, mass, com):
        return {"name": name, "on": on, "joint": {"name": f"{name} joint", **joint, "point": list(o + joint["point"])},
                "mass": mass, "com": list(o + com),
                "inertia": list(mass * 1e-4 * np.array([1, 0.8, 0.5, 0.1, 0, 0.2]))}

    at = lambda x, y, z: np.array([x, y, z]) / 256  # noqa: E731
    return [
        body("palm", "ground", {"kind": "revolute", "axis": "z", "point": at(0, 0, 0)}, 0.4, at(8, 0, 4)),
        body("link", "palm", {"kind": "revolute", "axis": "x", "point": at(16, 0, 0)}, 0.01, at(16, 4, 0)),
        body("tip", "link", {"kind": "revolute", "axis": [1, 0.5, 0], "point": at(16, 8, 0)}, 0.004, at(16, 12, 0)),
        body("ball", "tip", {"kind": "spherical", "point": at(16, 20, 0)}, 0.002, at(16, 24, 0))]


def from_bodies(o, tmp_path):
    return axode.Model.from_bodies(bodies(o))


def from_builder(o, tmp_path):
    builder = axode.Builder("hand")
    for body in bodies(o):
        joint = body.pop("joint")
        builder.body(body.pop("name"), on=body.pop("on"), joint=joint, **body)
    return builder.build()


def from_file(o, tmp_path):
    file = tmp_path / "hand.toml"
    file.write_text(axode.drawing(axode.Model.from_bodies(bodies(o))))
    return axode.load(file)


def from_dict(o, tmp_path):
    return axode.Model.from_dict(axode.Model.from_bodies(bodies(o)).to_dict())


def agree(far, near):
    """The largest difference of forces and of entries of M; those of M relative to the diagonal entries of their row
    and column."""
    q, v, a, _ = random_states(near, 8)
    worst = 0
    for way in WAYS:
        tau, expected = (axode.inverse_dynamics(m, q, v, a, way) for m in (far, near))
        worst = max(worst, (abs(tau - expected) / abs(expected)).max())
        M, expected = (axode.mass_matrix(m, q, way) for m in (far, near))
        size = np.sqrt(np.einsum("nr,nc->nrc", *[np.diagonal(expected, axis1=1, axis2=2)] * 2))
        worst = max(worst, (abs(M - expected) / size).max())
    return worst


@pytest.mark.parametrize("o", ORIGINS)
@pytest.mark.parametrize("make", [from_bodies, from_builder, from_file, from_dict])
def test_dynamics_are_those_at_the_origin(make, o, tmp_path):
    o = np.array([o, -o, o / 2])
    far, near = make(o, tmp_path), make(0 * o, tmp_path)
    assert agree(far, near) < 1e-13
    q = near.random(seed=5)
    for locked in (["palm joint"], ["link joint"], ["tip joint"], ["link joint", "tip joint"], ["ball joint"]):
        less_far, less_near = far.reduced(locked, q), near.reduced(locked, q)
        assert agree(less_far, less_near) < 1e-13
        # They agree to the rounding of the poses of a drawing.
        assert agree(less_far.__class__.from_dict(less_far.to_dict()), less_near) < 1e-9
