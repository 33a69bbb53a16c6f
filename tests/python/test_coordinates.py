"""The formulas for the coordinates of single joints, which the bridges share, agree with the library."""

from pathlib import Path

import axode
import numpy as np
import pytest
from axode.support import coordinates
from axode.support.coordinates import NUMPY
from mechanisms import close

EVERY_KIND = axode.load(Path(__file__).parents[1] / "data/good/every_key.toml")


@pytest.mark.parametrize("name", [name for name in EVERY_KIND.joint_names if EVERY_KIND.joint(name).nv > 0])
def test_every_joint_moves_as_in_the_library(name):
    m, random = EVERY_KIND, np.random.default_rng(0)
    joint = m.joint(name)
    q0, q1 = (m.random(seed=k) for k in range(2))
    v = random.uniform(-1, 1, m.nv)
    on, at_q, at_v = NUMPY, joint.q, joint.v
    rates, moved, apart = m.coordinate_rates(q0, v), m.integrate(q0, v), m.difference(q0, q1)
    assert close(coordinates.rates(on, joint.kind, q0[at_q], v[at_v]), rates[at_q])
    assert close(coordinates.velocities(on, joint.kind, q0[at_q], rates[at_q]), v[at_v])
    assert close(coordinates.integrated(on, joint.kind, q0[at_q], v[at_v]), moved[at_q])
    assert close(coordinates.difference(on, joint.kind, q0[at_q], q1[at_q]), apart[at_v])
