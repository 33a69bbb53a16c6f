"""Loops, couplings and passive joints in the description of a mechanism: given, copied and refused."""

import copy
import pickle
import tomllib
from pathlib import Path

import axode
import numpy as np
import pytest

FOUR_BAR = (Path(__file__).resolve().parents[1] / "data/good/loops.toml").read_text(encoding="utf-8")
M = axode.read_drawing(FOUR_BAR)
NAMES = ["pin", "loop 2", "loop 3", "loop 4", "coupling 1"]


def test_a_model_names_its_loops_then_its_couplings():
    assert M.n_loops == 5
    assert M.loop_names == NAMES
    assert [joint.passive for joint in M.joints] == [False, True, True]
    assert axode.load(axode.robots / "arm7.toml").loop_names == []


def same(n):
    assert n.loop_names == NAMES
    assert [joint.passive for joint in n.joints] == [False, True, True]
    a, b = M.to_dict(), n.to_dict()
    assert a["loop"] == b["loop"]
    assert a["coupling"] == b["coupling"]
    return True


def test_every_copy_has_them():
    assert same(axode.Model.from_dict(M.to_dict()))
    assert same(axode.Model.from_dict(tomllib.loads(FOUR_BAR)))
    assert same(axode.read_drawing(axode.drawing(M)))
    assert same(pickle.loads(pickle.dumps(M)))
    assert same(copy.deepcopy(M))
    assert same(M.with_gravity([0, 0, 0]))
    assert same(M.with_parameters(M.parameters))


def test_a_builder_tells_them():
    drawing = tomllib.loads(FOUR_BAR)
    built = axode.Builder("four-bar")
    for body in drawing["body"]:
        built.body(**body)
    built.frame(**drawing["frame"][0])
    for loop in drawing["loop"]:
        built.loop(*loop.pop("between"), **loop)
    for coupling in drawing["coupling"]:
        built.coupling(**coupling)
    assert same(built.build())
    assert same(axode.Model.from_bodies(drawing["body"], drawing["frame"], loops=M.to_dict()["loop"],
                                        couplings=M.to_dict()["coupling"]))


def test_a_loop_between_two_frames_takes_their_names():
    drawing = tomllib.loads(FOUR_BAR)
    drawing["loop"] = [{"frames": ["eye", "ground"], "kind": "spherical"}]
    by_names = axode.Model.from_dict(drawing)
    drawing["loop"] = [{"between": ["eye", "ground"], "frames": [{}, {}], "kind": "spherical"}]
    assert axode.Model.from_dict(drawing).to_dict()["loop"] == by_names.to_dict()["loop"]


def test_numbers_of_numpy_and_tuples_are_numbers():
    built = axode.Builder("bars")
    for name, x in (("one", 0.0), ("two", 1.0)):
        built.body(name, joint={"kind": "revolute", "axis": "y", "point": np.array([x, 0, 0])}, mass=1, com=(x, 0, 1),
                   inertia=np.ones(3))
    m = built.loop("one", "two", "rod", points=np.eye(3)[:2], length=np.float64(1)).coupling(
        {"one_joint": np.float64(2), "two_joint": np.int64(-1)}, np.float32(0.5)).build()
    assert m.to_dict()["coupling"] == [{"terms": {"one_joint": 2.0, "two_joint": -1.0}, "offset": 0.5}]


def test_a_mechanism_on_another_and_a_reduced_one_keep_them():
    both = M.append("eye", M, prefix="2 ")
    assert both.loop_names == NAMES[:4] + ["2 " + name for name in NAMES[:4]] + ["coupling 1", "2 coupling 1"]
    with pytest.raises(ValueError, match='"pin", "loop 2", "loop 3", "loop 4", "coupling 1"; give a prefix'):
        M.append("eye", M)
    locked = M.reduced(["rocker_joint"], [0.1, 0.2, 0.25])
    assert locked.loop_names == ["pin", "loop 2", "loop 4", "coupling 1"]
    assert locked.to_dict()["coupling"] == [
        {"name": "coupling 1", "terms": {"crank_joint": 1.0}, "offset": 0.5 + 1.5 * 0.25}]
    assert M.reduced(M.joint_names, [0, 0, 0]).n_loops == 0


def test_a_urdf_has_no_words_for_them():
    with pytest.raises(axode.ModelError, match='"rocker_joint": is passive; URDF has no word for it') as found:
        axode.urdf(M, strict=True)
    assert "is rod; URDF has no word for it" in str(found.value)
    assert 'coupling "coupling 1": is one of the coordinates of 2 joints' in str(found.value)


@pytest.mark.parametrize(("change", "message"), [
    (lambda d: d["loop"][0].update(between=["coupler", "rockr"]), 'neither a body nor a frame; did you mean "rocker"'),
    (lambda d: d["loop"][0].update(between=["eye", "coupler"]), "do not move against each other"),
    (lambda d: d["loop"][0].update(kind="knot"), 'kind is "knot"; it is one of "fixed"'),
    (lambda d: d["loop"][0].update(pitch=1), "pitch has no meaning here: a revolute loop has no pitch"),
    (lambda d: d["loop"][0].update(name="crank_joint"), "the name is taken"),
    (lambda d: d["loop"][1].update(length=0), "length is 0 m"),
    (lambda d: d["loop"][2].update(axis="z"), "axis has no meaning here: frames say where the loop is"),
    (lambda d: d["loop"][3].pop("center"), "has no center"),
    (lambda d: d["coupling"][0]["terms"].update(crank_joint=0), 'factor of joint "crank_joint" is 0'),
    (lambda d: d["coupling"][0]["terms"].update(cranck=1), 'joint "cranck", which is not described'),
    (lambda d: d["coupling"][0].update(terms={}), "has no terms"),
    (lambda d: d["body"][0]["joint"].update(passive=1), "passive is 1; it needs true or false"),
    (lambda d: d["body"][1].pop("mass") and d["body"][1].pop("com") and d["body"][1].pop("inertia"),
     "moves no mass when the loops are cut")])
def test_what_is_wrong_is_said(change, message):
    drawing = tomllib.loads(FOUR_BAR)
    change(drawing)
    with pytest.raises(axode.ModelError, match=message):
        axode.Model.from_dict(drawing)
