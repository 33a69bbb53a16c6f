"""Mechanisms with loops from Python."""

import axode
import numpy as np
import pytest


def bar(builder, name, on, p, end, axis="z", kind="revolute", **joint):
    d = np.subtract(end, p)
    inertia = ((d @ d + 0.01) * np.eye(3) - np.outer(d, d)) / 12
    return builder.body(name, on=on, joint={"kind": kind, "axis": axis, "point": list(p), **joint}, mass=1,
                        com=list(np.add(p, end) / 2), inertia=inertia.tolist())


def four_bar():
    builder = axode.Builder("four-bar", (0, -9.81, 0))
    bar(builder, "crank", "ground", (0, 0, 0), (0, 1, 0))
    bar(builder, "coupler", "crank", (0, 1, 0), (2, 2, 0), passive=True)
    bar(builder, "rocker", "ground", (3, 0, 0), (2, 2, 0), passive=True)
    return builder.loop("coupler", "rocker", name="pin", axis="z", point=[2, 2, 0]).build()


def gough():
    builder = axode.Builder("Gough").body("platform", joint="free", mass=10, com=[0, 0, 1.2], inertia=[0.5, 0.6, 0.9])
    feet, tops = ([(r * np.cos(k + e), r * np.sin(k + e), z) for k in (0, 2.1, 4.2) for e in (-w, w)]
                  for r, w, z in ((1, 0.9, 0), (0.6, 0.2, 1.2)))
    for k, (p, e) in enumerate(zip(np.array(feet), np.array(tops))):
        x = np.cross(e - p, [0, 0, 1])
        bar(builder, f"foot{k}", "ground", p, (p + e) / 2, x.tolist(), "universal",
            second_axis=np.cross(e - p, x).tolist(), passive=True)
        bar(builder, f"leg{k}", f"foot{k}", e, 0.4 * e + 0.6 * p, (e - p).tolist(), "prismatic")
        builder.loop(f"leg{k}", "platform", "spherical", name=f"ball {k}", point=e.tolist())
    return builder.build()


FOUR_BAR, GOUGH = four_bar(), gough()
MECHANISMS = {"four-bar": FOUR_BAR, "Gough": GOUGH}


def state(m, seed=1):
    rng = np.random.default_rng(seed)
    guess = m.integrate(m.neutral(), 0.1 * rng.normal(size=m.nv))
    q, v = axode.assemble(m, guess, rng.normal(size=m.nv))
    return q, v, 10 * rng.normal(size=m.nv)


@pytest.mark.parametrize("name", MECHANISMS)
def test_accelerations_keep_the_loops_and_come_from_closing_wrenches(name):
    m = MECHANISMS[name]
    q, v, tau = state(m)
    a, A = axode.forward_dynamics(m, q, v, tau), axode.loop_jacobian(m, q)
    assert np.abs(axode.loop_residual(m, q)).max() < 1e-11 and np.abs(A @ v).max() < 1e-11
    np.testing.assert_allclose(A @ a, -axode.loop_bias(m, q, v), atol=1e-8 * (1 + np.abs(a).max()))
    W = axode.constraint_wrenches(m, q, v, tau, "spatial")
    assert W.shape == (m.n_loops, 6)
    C = axode.poses(m, q)
    body = axode.constraint_wrenches(m, q, v, tau)
    for k, name_of_body in enumerate(["rocker"] if name == "four-bar" else ["platform"] * 6):
        of_frame = axode.lie.Ad(C[m.frame_names.index(name_of_body)]).T @ W[k]
        np.testing.assert_allclose(body[k], of_frame, atol=1e-9 * (1 + np.abs(W).max()))


def test_joint_wrenches_are_about_the_body_or_the_joint():
    q, v, tau = state(GOUGH, 3)
    a = axode.forward_dynamics(GOUGH, q, v, tau)
    W, at_joint = (axode.joint_wrenches(GOUGH, q, v, a, at=at) for at in ("body", "joint"))
    for i, body in enumerate(GOUGH.body_names):
        S = GOUGH.body(body).S_self
        np.testing.assert_allclose(at_joint[i, :3], W[i, :3] - np.cross(S[:3, 3], W[i, 3:]), atol=1e-11 * (1 + np.abs(W).max()))
        np.testing.assert_array_equal(at_joint[i, 3:], W[i, 3:])
    both = axode.joint_wrenches(GOUGH, [q, q], [v, v], [a, a], threads=2)
    np.testing.assert_array_equal(both, [W, W])
    assert np.abs(axode.joint_wrenches(GOUGH, q, v, a, drives=range(GOUGH.nv)) - W).max() > 1e-6 * (1 + np.abs(W).max())
    with pytest.raises(ValueError, match="the drives cannot make these accelerations"):
        axode.joint_wrenches(GOUGH, q, v, a, drives=["leg0_joint"])
    with pytest.raises(ValueError, match="at is 'pin'; expected one of 'body', 'joint'"):
        axode.joint_wrenches(GOUGH, q, v, a, at="pin")


def test_drives_by_name_and_what_they_cannot_do():
    q, v, tau = state(FOUR_BAR)
    a = axode.forward_dynamics(FOUR_BAR, q, v, tau)
    by_name = axode.inverse_dynamics(FOUR_BAR, q, v, a, drives=["rocker_joint"])
    assert np.flatnonzero(by_name).tolist() == [2]
    np.testing.assert_allclose(axode.forward_dynamics(FOUR_BAR, q, v, by_name), a, atol=1e-8 * (1 + np.abs(a).max()))
    q, v, tau = state(GOUGH)
    a = axode.forward_dynamics(GOUGH, q, v, tau)
    with pytest.raises(ValueError, match="the drives cannot make these accelerations"):
        axode.inverse_dynamics(GOUGH, q, v, a, drives=["leg0_joint", "leg1_joint"])
    with pytest.raises(KeyError, match='has no joint "leg9_joint"; did you mean "leg0_joint"'):
        axode.inverse_dynamics(GOUGH, q, v, a, drives=["leg9_joint"])
    with pytest.raises(KeyError, match='has no joint "crank"; did you mean "crank_joint"|has no joint "crank"'):
        axode.assemble(FOUR_BAR, FOUR_BAR.neutral(), hold=["crank"])
    with pytest.raises(KeyError, match='has no joint "crank_jiont"; did you mean "crank_joint"'):
        axode.independent_equations(FOUR_BAR, FOUR_BAR.neutral(), np.zeros(3), ["crank_jiont"])
    with pytest.raises(ValueError, match="drives holds 99; expected names of joints or numbers of velocities, 0 to 23"):
        axode.inverse_dynamics(GOUGH, q, v, a, drives=[99])


@pytest.mark.parametrize("name", [*MECHANISMS, "arm"])
def test_drives_work_against_forces_that_act_besides(name):
    m = MECHANISMS.get(name) or axode.load(axode.robots / "arm7.toml")
    q, v, tau = (np.array(x) for x in zip(*(state(m, seed) for seed in (1, 2, 3))))
    a, besides = axode.forward_dynamics(m, q, v, tau), np.random.default_rng(8).normal(size=v.shape)
    u = axode.inverse_dynamics(m, q, v, a, forces=besides)
    np.testing.assert_allclose(axode.forward_dynamics(m, q, v, u + besides), a, atol=1e-7 * (1 + np.abs(a).max()))
    with pytest.raises(ValueError, match=r"^forces: expected shape \(3, .*got"):
        axode.inverse_dynamics(m, q, v, a, forces=besides[0])


@pytest.mark.parametrize("name", MECHANISMS)
def test_accelerations_that_tear_loops_are_refused(name):
    m = MECHANISMS[name]
    q, v, tau = (np.array(x) for x in zip(*(state(m, seed) for seed in (1, 2, 3))))
    a = axode.forward_dynamics(m, q, v, tau)
    axode.inverse_dynamics(m, q, v, a)
    torn = a + [[0], [1], [0]]
    first = m.loop_names[0]
    with pytest.raises(ValueError, match=rf'^state 1: a does not keep loop "{first}" closed: A a \+ gamma is [0-9.]+ \(rad/s\^2 and m/s\^2\)'):
        axode.inverse_dynamics(m, q, v, torn)
    with pytest.raises(ValueError, match=f'^a does not keep loop "{first}" closed'):
        axode.inverse_dynamics(m, q[1], v[1], torn[1])
    open_q = m.integrate(q[1], 0.1 * np.ones(m.nv))
    with pytest.raises(ValueError, match='^q leaves loop ".*" open by'):  # which is why
        axode.inverse_dynamics(m, open_q, v[1], torn[1])


def test_many_states_are_as_one_by_one():
    states = [state(GOUGH, seed) for seed in range(1, 6)]
    q, v, tau = (np.array(x) for x in zip(*states))
    for threads in (1, 2):
        a = axode.forward_dynamics(GOUGH, q, v, tau, threads=threads)
        assert a.shape == v.shape
        for k in range(len(q)):
            np.testing.assert_array_equal(a[k], axode.forward_dynamics(GOUGH, q[k], v[k], tau[k]))
    assert axode.loop_residual(GOUGH, q).shape == (5, 18)
    assert axode.loop_jacobian(GOUGH, q).shape == (5, 18, GOUGH.nv)
    assert axode.constraint_wrenches(GOUGH, q, v, tau).shape == (5, 6, 6)


def test_assembly():
    q, v = axode.assemble(FOUR_BAR, [0.5, 0.1, 0.2])
    assert not v.any() and np.abs(axode.loop_residual(FOUR_BAR, q)).max() < 1e-11
    q, v = axode.assemble(FOUR_BAR, [0.5, 0, 0], [3, 0, 0], hold=["crank_joint"])
    assert q[0] == 0.5 and v[0] == 3 and np.abs(axode.loop_jacobian(FOUR_BAR, q) @ v).max() < 1e-10
    builder = axode.Builder("too far")
    bar(builder, "one", "ground", (0, 0, 0), (1, 0, 0))
    apart = builder.frame("ring", on="ground", position=[5, 0, 0]).loop(
        "one", "ring", "spherical", name="catch", frames=[{"position": [1, 0, 0]}, {}]).build()
    with pytest.raises(axode.AssemblyError, match='loop "catch" stays open by') as caught:
        axode.assemble(apart, [0.3])
    assert caught.value.residual > 3 and caught.value.q.shape == (1,)


def test_mobility():
    found = axode.loop_mobility(GOUGH, GOUGH.neutral())
    assert (found.degrees_of_freedom, found.rank, found.redundant, found.mobility) == (6, 18, [], "regular")
    found = axode.loop_mobility(FOUR_BAR, FOUR_BAR.neutral())
    assert (found.degrees_of_freedom, found.rank, len(found.redundant)) == (1, 2, 3)
    A = axode.loop_jacobian(FOUR_BAR, FOUR_BAR.neutral())
    for row in found.redundant:
        assert row.loop == "pin" and np.abs(row.dependency @ A).max() < 1e-12
    assert np.abs(A @ found.kernel).max() < 1e-12


def test_derivatives_of_multipliers():
    m = axode.load(axode.robots / "five_bar_arm.toml")
    rng = np.random.default_rng(7)
    q, v = axode.assemble(m, m.neutral(), rng.normal(size=m.nv))
    tau, x = rng.normal(size=m.nv), rng.normal(size=m.nv)
    mobility = axode.loop_mobility(m, q)
    kept = np.setdiff1d(np.arange(axode.loop_jacobian(m, q).shape[0]), [row.row for row in mobility.redundant])
    A = axode.loop_jacobian(m, q)[kept]

    def multipliers(q, v, tau):  # of the rows that are kept
        reaction = axode.loop_jacobian(m, q).T @ axode.loop_multipliers(m, q, v, tau)
        return np.linalg.lstsq(axode.loop_jacobian(m, q)[kept].T, reaction, rcond=None)[0]

    d, h = axode.loop_multiplier_derivatives(m, q, v, tau), 1e-6
    tangent = x - np.linalg.pinv(A) @ (A @ x)  # along which the loops stay closed
    for D, e, f in ((d.q, tangent, lambda e: multipliers(m.integrate(q, e), v, tau)),
                    (d.v, x, lambda e: multipliers(q, v + e, tau)), (d.tau, x, lambda e: multipliers(q, v, tau + e))):
        expected = (f(h * e) - f(-h * e)) / (2 * h)
        np.testing.assert_allclose((D @ e)[kept], expected, atol=1e-5 * (1 + np.abs(expected).max()))


def test_motions_start_closed():
    q = FOUR_BAR.neutral()
    with pytest.raises(ValueError, match='q leaves loop "pin" open by .*assemble'):
        axode.simulate(FOUR_BAR, [0.3, 0, 0], np.zeros(3), 1.0)
    with pytest.raises(ValueError, match='v does not keep loop "pin" closed: .*assemble'):
        axode.simulate(FOUR_BAR, q, [1.0, 0, 0], 1.0)
    with pytest.raises(ValueError, match='state 1: v does not keep loop "'):
        axode.rollout(FOUR_BAR, np.stack([q, q]), [[0, 0, 0], [1, 0, 0]], np.zeros(3), 1e-3, steps=1)
    with pytest.raises(ValueError, match="loops"):
        axode.inverse_kinematics(FOUR_BAR, [axode.Target(pose=np.eye(4), frame="ground")], q)


def test_rollouts_end_where_loops_cannot_be_kept_closed():
    q, v = axode.assemble(FOUR_BAR, FOUR_BAR.neutral(), [300.0, 0, 0])
    with pytest.raises(axode.SingularError, match="^the loops do not stay closed; use a shorter step") as found:
        axode.rollout(FOUR_BAR, q, v, np.zeros(3), 0.1, steps=3)
    assert np.isfinite(found.value.result[0]).all() and np.isnan(found.value.result[-1]).all()


@pytest.mark.parametrize("name", ["four_bar", "five_bar_arm", "slider_crank", "gough", "leg", "governor", "andrews"])
def test_independent_equations_are_those_of_the_mechanism(name):
    m = axode.load(axode.robots / f"{name}.toml")
    rng = np.random.default_rng(5)
    q, v = axode.assemble(m, m.neutral(), rng.normal(size=m.nv))
    tau = rng.normal(size=m.nv)
    a = axode.forward_dynamics(m, q, v, tau)
    form = axode.independent_equations(m, q, v, joint_losses=False)
    k = axode.loop_mobility(m, q).degrees_of_freedom
    assert form.M.shape == (k, k) and form.N.shape == (m.nv, k)
    np.testing.assert_allclose(form.N @ v[form.velocities], v, atol=1e-9 * (1 + np.abs(v).max()))
    rates = np.linalg.solve(form.M, form.N.T @ tau - form.h)
    np.testing.assert_allclose(form.N @ rates + form.c, a, atol=1e-8 * (1 + np.abs(a).max()))
    if k < m.nv:
        with pytest.raises(ValueError, match=f"the loops leave {k} independent"):
            axode.independent_equations(m, q, v, range(m.nv))


def test_small_motions_have_the_independent_equations():
    q, v, tau = state(GOUGH, 6)
    small = axode.independent_linearization(GOUGH, q, v, tau)
    form = axode.independent_equations(GOUGH, q, v, small.velocities)
    assert small.A.shape == (12, 12) and small.B.shape == (12, GOUGH.nv)
    np.testing.assert_allclose(small.N, form.N, atol=1e-9)
    np.testing.assert_allclose(small.B[6:], np.linalg.solve(form.M, form.N.T), rtol=1e-6, atol=1e-8)
    with pytest.raises(ValueError, match='q leaves loop "pin" open by'):
        axode.independent_linearization(FOUR_BAR, [0.3, 0, 0], np.zeros(3), np.zeros(3))
    with pytest.raises(ValueError, match="linearize.*loops"):
        axode.linearize(FOUR_BAR, FOUR_BAR.neutral(), np.zeros(3), np.zeros(3))


def test_multipliers_that_redundancy_leaves_open_are_named():
    mobility = axode.loop_mobility(FOUR_BAR, FOUR_BAR.neutral())  # planar, in space
    assert set(row.row for row in mobility.redundant) <= set(mobility.indeterminate) != {0, 1, 2, 3, 4}
    A, some = axode.loop_jacobian(FOUR_BAR, FOUR_BAR.neutral()), np.zeros(5)
    some[mobility.indeterminate] = 1
    for row in mobility.redundant:
        np.testing.assert_allclose(A.T @ row.dependency, 0, atol=1e-12)
        assert not (row.dependency * (1 - some)).any()


def test_impacts():
    torn = np.array([1.0, 0.5, -0.3])
    A = axode.loop_jacobian(FOUR_BAR, FOUR_BAR.neutral())
    for e in (0, 0.5, 1):
        np.testing.assert_allclose(A @ axode.impact(FOUR_BAR, FOUR_BAR.neutral(), torn, e), -e * A @ torn, atol=1e-10)
    with pytest.raises(ValueError, match="restitution is 2"):
        axode.impact(FOUR_BAR, FOUR_BAR.neutral(), torn, 2)


def test_trees_have_none():
    arm = axode.load(axode.robots / "arm7.toml")
    assert axode.loop_residual(arm, arm.neutral()).shape == (0,)
    assert axode.loop_jacobian(arm, arm.neutral()).shape == (0, 7)
    q, v = axode.assemble(arm, arm.random(), np.ones(7))
    assert v.tolist() == [1] * 7
    assert axode.loop_mobility(arm, q).degrees_of_freedom == 7


def test_forces_of_a_platform_and_their_rates_follow_from_the_motion_of_the_platform():
    m = axode.load(axode.robots / "gough.toml")
    random = np.random.default_rng(2)
    q, V = m.neutral(), random.uniform(-0.5, 0.5, (4, 6))
    rates = axode.inverse_kinematics_rates(m, q, V, "platform")
    assert np.allclose(axode.twist_derivatives(m, q, rates, "platform"), V)
    tau, dtau, ddtau = axode.inverse_dynamics_rates(m, q, *rates)
    np.testing.assert_allclose(tau, axode.inverse_dynamics(m, q, rates[0], rates[1]), atol=1e-10 * np.abs(tau).max())

    def forces_at(t):
        there, _ = axode.assemble(m, m.integrate(q, t * rates[0] + t**2 / 2 * rates[1]))
        v, a = axode.inverse_kinematics_rates(m, there, [V[0] + t * V[1] + t**2 / 2 * V[2], V[1] + t * V[2] + t**2 / 2 * V[3]], "platform")
        return axode.inverse_dynamics(m, there, v, a)
    after, before = forces_at(1e-4), forces_at(-1e-4)
    np.testing.assert_allclose((after - before) / 2e-4, dtau, atol=1e-6 * np.abs(dtau).max())
    np.testing.assert_allclose((after - 2 * tau + before) / 1e-8, ddtau, atol=1e-3 * np.abs(ddtau).max())
    with pytest.raises(ValueError, match="row 1 does not keep loop"):
        axode.inverse_dynamics_rates(m, q, rates[0], 0 * rates[1])
    with pytest.raises(ValueError, match="the joints cannot produce row 0 of V"):
        axode.inverse_kinematics_rates(m, q, V, "lower leg 1")
