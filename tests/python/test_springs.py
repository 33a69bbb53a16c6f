"""Springs, dampers and stops of a mechanism."""

import copy
import pickle
import tomllib
from pathlib import Path

import axode
import numpy as np
import pytest

FLAP = (Path(__file__).resolve().parents[1] / "data/good/springs.toml").read_text(encoding="utf-8")
M = axode.read_drawing(FLAP)


def states(N=20):
    rng = np.random.default_rng(1)
    return M.integrate(M.random(n=N), 0.5 * rng.normal(size=(N, M.nv))), rng.normal(size=(N, M.nv))


def same(m, n):
    q, v = states()
    np.testing.assert_allclose(axode.spring_forces(m, q, v), axode.spring_forces(n, q, v), rtol=1e-12, atol=1e-10)
    np.testing.assert_allclose(axode.elastic_energy(m, q), axode.elastic_energy(n, q), rtol=1e-12)


def test_every_copy_has_them():
    same(M, axode.Model.from_dict(M.to_dict()))
    same(M, axode.Model.from_dict(tomllib.loads(FLAP)))
    same(M, axode.read_drawing(axode.drawing(M)))
    same(M, pickle.loads(pickle.dumps(M)))
    same(M, copy.deepcopy(M))
    same(M, M.with_gravity([0, 0, 0]))
    same(M, M.with_parameters(M.parameters))
    drawing = tomllib.loads(FLAP)
    built = axode.Builder("flap")
    for body in drawing["body"]:
        built.body(**body)
    built.frame(**drawing["frame"][0])
    for spring in drawing["spring"]:
        built.spring(*spring.pop("between", []), **spring)
    same(M, built.build())
    assert np.ptp(axode.elastic_energy(M, states()[0])) > 1


def test_a_urdf_has_no_words_for_them():
    with pytest.raises(axode.ModelError, match="has a spring; URDF has no word for it") as found:
        axode.urdf(M, strict=True)
    assert 'spring 1: is between "eye" and "drone"' in str(found.value)


def test_derivatives_are_by_the_last_axis():
    q, v = states()
    d, x, h = axode.spring_force_derivatives(M, q, v), np.random.default_rng(2).normal(size=(20, M.nv)), 1e-6
    by_q = (axode.spring_forces(M, M.integrate(q, h * x), v) - axode.spring_forces(M, M.integrate(q, -h * x), v)) / (2 * h)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", d.q, x), by_q, atol=1e-5 * np.abs(d.q).max())
    by_v = axode.spring_forces(M, q, v + x) - axode.spring_forces(M, q, v)
    assert np.abs(np.einsum("nij,nj->ni", d.v, x) - by_v).max() < 1e-9 * np.abs(by_v).max()


def test_they_act_in_simulations_alone():
    q, v = states()
    bare = M.to_dict()
    bare.pop("spring")
    for body in bare["body"]:
        if isinstance(body["joint"], dict):
            for key in ("spring", "stop", "dof"):
                body["joint"].pop(key, None)
    n = axode.Model.from_dict(bare)
    a = axode.forward_dynamics(M, q, v, np.ones_like(v))
    np.testing.assert_allclose(a, axode.forward_dynamics(n, q, v, np.ones_like(v)), rtol=1e-12)
    np.testing.assert_array_equal(axode.spring_forces(n, q, v), 0)

    def by_hand(t, q, v):
        return axode.spring_forces(M, q, v)
    sprung = axode.simulate(M, q[0], v[0], 0.3, method="rk4", step=1e-3)
    driven = axode.simulate(n, q[0], v[0], 0.3, method="rk4", step=1e-3, tau=by_hand)
    np.testing.assert_allclose(sprung.q, driven.q, atol=1e-9)
    rolled, _ = axode.rollout(M, q[0], v[0], np.zeros((300, M.nv)), 1e-3)
    np.testing.assert_allclose(rolled[-1], sprung.q[-1], atol=1e-9)


@pytest.mark.parametrize("change, sentence", [
    (lambda d: d["body"][0]["joint"].update(spring={"stiffness": -1}), "stiffness of the spring is -1"),
    (lambda d: d["body"][0]["joint"].update(spring={"rest": 1}), "spring of joint .*has no stiffness"),
    (lambda d: d["body"][0]["joint"].update(spring=5), "spring is 5; it needs a table"),
    (lambda d: d["body"][0]["joint"].update(limits=[-np.inf, np.inf]), "has stops but no limits"),
    (lambda d: d["body"][1]["joint"]["dof"][0].update(spring={"stiffness": 1, "rest": 1}), "rests as drawn, at 0"),
    (lambda d: d["body"][1]["joint"]["dof"][0].update(stop={"stiffness": 1}), "several velocities"),
    (lambda d: d["spring"][0].update(between=["eye"]), "between is an array of 1"),
    (lambda d: d["spring"][0].update(between=["eye", "drown"]), 'did you mean "drone"'),
    (lambda d: d["spring"][0].update(rest=-1), "spring 1: rest is -1"),
    (lambda d: d["spring"][0].update(damping=np.nan), "not finite"),
    (lambda d: d["spring"][0].update(length=1), 'spring 1: key "length" is not known')])
def test_what_cannot_be_is_refused(change, sentence):
    drawing = tomllib.loads(FLAP)
    change(drawing)
    with pytest.raises(axode.ModelError, match=sentence):
        axode.Model.from_dict(drawing)


def test_coordinates_of_springs_have_their_gradients_and_energies():
    q, _ = states()
    for spring in ("tendon", "clock", "cam", "spring 1"):
        x, gradient = axode.spring_coordinate(M, q, spring)
        assert x.shape == (20,) and gradient.shape == (20, M.nv)
        step = 1e-6
        for c in range(M.nv):
            to = np.zeros((20, M.nv))
            to[:, c] = step
            ahead, back = (axode.spring_coordinate(M, M.integrate(q, sign * to), spring).coordinate for sign in (1, -1))
            np.testing.assert_allclose(gradient[:, c], (ahead - back) / (2 * step), atol=1e-6)
        one = axode.spring_coordinate(M, q[3], spring)
        assert one.coordinate == x[3] and np.array_equal(one.gradient, gradient[3])
    flap = M.joint("flap_joint").q.start
    np.testing.assert_allclose(axode.spring_coordinate(M, q, "cam").coordinate, 1.5 * q[:, flap], atol=1e-12)


@pytest.mark.parametrize("spring, error, words", [
    ("tendom", KeyError, 'has no spring "tendom"; did you mean "tendon"'), ("mount", ValueError, '"mount" is a bushing'),
    (99, ValueError, "spring is 99; the model has springs 0 to"), (0.5, ValueError, "spring is 0.5; expected its name or number")])
def test_what_is_no_spring_has_no_coordinate(spring, error, words):
    with pytest.raises(error, match=words):
        axode.spring_coordinate(M, M.neutral(), spring)
