"""Distances of collision shapes are those of a formula, and their Jacobians those of differences."""

from pathlib import Path

import numpy as np
import pytest

import axode

GOOD = Path(__file__).resolve().parents[1] / "data/good/contact.toml"


def test_distances_of_a_finger_over_a_table():
    m = axode.load(GOOD)
    q = m.neutral()
    q[0] = 0.1
    table, puck = axode.distances(m, q)
    assert (table.a, table.b) == ("table", "tip") and np.isclose(table.distance, -0.02)
    assert (puck.a, puck.b) == ("tip", "puck shape 1") and np.isclose(puck.distance, 0.16)
    assert np.allclose(puck.normal, [0, 0, -1]) and np.allclose(puck.jacobian, [1, 0, 0, 0])
    assert puck.proved and puck.residual < 1e-15
    assert [d.b for d in axode.distances(m, q, margin=0.1)] == ["tip"]


def test_a_mesh_without_a_file_is_refused():
    drawing = axode.load(GOOD).to_dict()
    drawing["body"][0]["shape"] = [{"kind": "mesh", "role": "collision", "file": "nowhere.stl"}]
    m = axode.Model.from_dict(drawing)
    with pytest.raises(ValueError, match="there is no file"):
        axode.distances(m, m.neutral())
