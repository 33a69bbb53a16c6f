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


@pytest.mark.parametrize("name", MECHANISMS)
def test_drives_make_the_accelerations(name):
    m = MECHANISMS[name]
    q, v, tau = state(m, 2)
    a = axode.forward_dynamics(m, q, v, tau)
    u = axode.inverse_dynamics(m, q, v, a)  # of the joints that are not passive
    driven = [c for joint in map(m.joint, m.joint_names) if not joint.passive for c in range(m.nv)[joint.v]]
    assert not np.delete(u, driven).any()
    np.testing.assert_allclose(axode.forward_dynamics(m, q, v, u), a, atol=1e-7 * (1 + np.abs(a).max()))
    everywhere = axode.inverse_dynamics(m, q, v, a, drives=range(m.nv))
    assert np.linalg.norm(everywhere) <= np.linalg.norm(u) + 1e-9
    np.testing.assert_allclose(axode.forward_dynamics(m, q, v, everywhere), a, atol=1e-7 * (1 + np.abs(a).max()))


@pytest.mark.parametrize("name", MECHANISMS)
def test_joint_wrenches_are_those_of_drives_and_loops(name):
    m = MECHANISMS[name]
    q, v, tau = state(m, 3)
    a = axode.forward_dynamics(m, q, v, tau)
    u = axode.inverse_dynamics(m, q, v, a)
    W = axode.joint_wrenches(m, q, v, a)
    at_joint = axode.joint_wrenches(m, q, v, a, at="joint")
    size = 1 + np.abs(W).max()
    for i, body in enumerate(m.body_names):
        joint, b = m.joint(m.joint_names[i]), m.body(body)
        np.testing.assert_allclose(b.X.T @ W[i], u[joint.v], atol=1e-8 * size)
        np.testing.assert_allclose(at_joint[i, :3], W[i, :3] - np.cross(b.S_self[:3, 3], W[i, 3:]), atol=1e-11 * size)
        np.testing.assert_array_equal(at_joint[i, 3:], W[i, 3:])
    both = axode.joint_wrenches(m, [q, q], [v, v], [a, a], threads=2)
    np.testing.assert_array_equal(both, [W, W])
    assert np.abs(axode.joint_wrenches(m, q, v, a, drives=range(m.nv)) - W).max() > 1e-6 * size
    if name == "Gough":
        with pytest.raises(ValueError, match="the drives cannot make these accelerations"):
            axode.joint_wrenches(m, q, v, a, drives=["leg0_joint"])
    with pytest.raises(ValueError, match="at is 'pin'; expected one of 'body', 'joint'"):
        axode.joint_wrenches(m, q, v, a, at="pin")


def test_controllers_give_passive_joints_no_force():
    q, v, _ = state(GOUGH, 4)
    assert GOUGH.joint("platform_joint").passive  # free, and the drawing does not say that it is driven
    legs = np.array([kind == "prismatic" for kind in (GOUGH.joint(n).kind for n in GOUGH.joint_names)])
    driven = np.concatenate([np.full(GOUGH.joint(n).v.stop - GOUGH.joint(n).v.start, leg)
                             for n, leg in zip(GOUGH.joint_names, legs)])
    there = axode.assemble(GOUGH, GOUGH.neutral())[0]
    for drive in (axode.drives.ComputedTorque(9.0, 6.0, there), axode.drives.PD(9.0, 6.0, there)):
        tau = drive.on(GOUGH)(0.0, q, v)
        assert not tau[~driven].any() and tau[driven].all()


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
    with pytest.raises(ValueError, match="drives holds"):
        axode.inverse_dynamics(GOUGH, q, v, a, drives=[99])


@pytest.mark.parametrize("name", [*MECHANISMS, "arm"])
def test_drives_work_against_forces_that_act_besides(name):
    m = MECHANISMS.get(name) or axode.load(axode.robots / "arm7.toml")
    rng = np.random.default_rng(8)
    q, v, tau = (np.array(x) for x in zip(*(state(m, seed) for seed in (1, 2, 3))))
    a, besides = axode.forward_dynamics(m, q, v, tau), rng.normal(size=v.shape)
    u = axode.inverse_dynamics(m, q, v, a, forces=besides)
    np.testing.assert_allclose(axode.forward_dynamics(m, q, v, u + besides), a, atol=1e-7 * (1 + np.abs(a).max()))
    np.testing.assert_allclose(axode.inverse_dynamics(m, q[1], v[1], a[1], forces=list(besides[1])), u[1], atol=1e-9)
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
    with pytest.raises(ValueError, match=rf'^state 1: a tears loop "{first}" open at [0-9.]+ \(rad/s\^2 and m/s\^2\)'):
        axode.inverse_dynamics(m, q, v, torn)
    with pytest.raises(ValueError, match=f'^a tears loop "{first}" open at'):
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


@pytest.mark.parametrize("name", MECHANISMS)
def test_derivatives(name):
    m = MECHANISMS[name]
    q, v, tau = state(m, 3)
    by_q, by_v, by_tau = axode.forward_dynamics_derivatives(m, q, v, tau)
    x, h = np.random.default_rng(4).normal(size=m.nv), 1e-5

    def difference(f):
        return (f(h * x) - f(-h * x)) / (2 * h)
    for D, f in ((by_q, lambda x: axode.forward_dynamics(m, m.integrate(q, x), v, tau)),
                 (by_v, lambda x: axode.forward_dynamics(m, q, v + x, tau)),
                 (by_tau, lambda x: axode.forward_dynamics(m, q, v, tau + x))):
        expected = difference(f)
        np.testing.assert_allclose(D @ x, expected, atol=1e-5 * (1 + np.abs(expected).max()))
    many = axode.forward_dynamics_derivatives(m, *(np.array([x, x]) for x in (q, v, tau)))
    np.testing.assert_array_equal(many.q[1], by_q)


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


@pytest.mark.parametrize("method", ["rk4", "dopri5", "generalized_alpha"])
def test_motions_keep_loops_and_energy(method):
    q, v = axode.assemble(FOUR_BAR, FOUR_BAR.neutral(), [-2.0, 0, 0])
    step = {"rk4": {"step": 0.005}, "generalized_alpha": {"step": 1e-3, "spectral_radius": 1}}.get(method, {})
    motion = axode.simulate(FOUR_BAR, q, v, 3.0, method=method, **step)
    assert np.abs(axode.loop_residual(FOUR_BAR, motion.q)).max() < 1e-11
    A = axode.loop_jacobian(FOUR_BAR, motion.q)
    assert np.abs(np.einsum("kij,kj->ki", A, motion.v)).max() < 1e-10
    E = np.asarray(axode.kinetic_energy(FOUR_BAR, motion.q, motion.v)) + axode.potential_energy(FOUR_BAR, motion.q)
    assert np.abs(E - E[0]).max() < (1e-3 if method == "generalized_alpha" else 2e-5)


def sprung_five_bar():
    """A stiff, driven mechanism with loops, and a drive of it that depends on the state."""
    drawing = axode.load(axode.robots / "five_bar_arm.toml").to_dict()
    drawing["body"][0]["joint"]["spring"] = {"stiffness": 4e5, "rest": 0.0}
    drawing["body"][0]["joint"]["damping"] = 2e3
    m = axode.Model.from_dict(drawing)
    return m, lambda t, q, v: np.concatenate([[np.sin(9 * t) - 2e3 * v[0]], -0.1 * v[1:]])


def test_stiff_motions_keep_loops_and_have_their_order():
    m, drive = sprung_five_bar()
    q, v = axode.assemble(m, m.neutral())
    # Neither fast nor far from rest after the start: errors are those of the smooth motion.
    fine = axode.simulate(m, q, v, 0.2, method="generalized_alpha", step=2.5e-4, tau=drive)
    assert np.abs(axode.loop_residual(m, fine.q)).max() < 1e-11
    errors = []
    for step in (4e-3, 2e-3):
        motion = axode.simulate(m, q, v, 0.2, method="generalized_alpha", step=step, tau=drive)
        errors.append(np.abs(motion.q[-1] - fine.q[-1]).max())
    assert 3 < errors[0] / errors[1] < 5.5
    explicit = axode.simulate(m, q, v, 0.2, rtol=1e-9, tau=drive)
    np.testing.assert_allclose(fine.q[-1], explicit.q[-1], atol=3 * errors[1])
    assert explicit.steps > 5 * 0.2 / 2e-3  # what is stiff


def test_motions_start_closed():
    with pytest.raises(ValueError, match='q leaves loop "pin" open by .*assemble'):
        axode.simulate(FOUR_BAR, [0.3, 0, 0], np.zeros(3), 1.0)
    with pytest.raises(ValueError, match='v tears loop "pin" open at .*assemble'):
        axode.simulate(FOUR_BAR, FOUR_BAR.neutral(), [1.0, 0, 0], 1.0)


@pytest.mark.parametrize("name", ["four_bar", "five_bar_arm", "slider_crank", "gough", "leg"])
def test_methods_on_momenta_and_rollouts_keep_loops_closed(name):
    m = axode.load(axode.robots / f"{name}.toml")
    rng = np.random.default_rng(6)
    q, v = axode.assemble(m, m.neutral(), 0.3 * rng.normal(size=m.nv))
    tau = 0.1 * rng.normal(size=m.nv)
    exact = axode.simulate(m, q, v, 0.1, tau=tau, rtol=1e-11, atol=1e-12)
    for method, step, error in [("midpoint", 5e-4, 1e-4), ("suzuki4", 2e-3, 1e-6), ("rk4_momenta", 1e-3, 1e-6)]:
        motion = axode.simulate(m, q, v, 0.1, tau=tau, method=method, step=step)
        assert np.abs(axode.loop_residual(m, motion.q)).max() < 1e-11
        assert np.abs(np.einsum("nij,nj->ni", axode.loop_jacobian(m, motion.q), motion.v)).max() < 1e-10
        assert np.abs(m.difference(motion.q[-1], exact.q[-1])).max() < error
    rolled = axode.rollout(m, np.stack([q, q]), np.stack([v, 0 * v]), tau, 1e-3, steps=100, threads=2)
    one = axode.simulate(m, q, v, 0.1, tau=tau, method="rk4", step=1e-3)
    np.testing.assert_allclose(rolled[0][0], one.q, atol=1e-10)
    with pytest.raises(ValueError, match='state 1: v tears loop "'):
        axode.rollout(m, np.stack([q, q]), np.stack([v, rng.normal(size=m.nv)]), tau, 1e-3, steps=1)


def test_rollouts_end_where_loops_cannot_be_kept_closed():
    q, v = axode.assemble(FOUR_BAR, FOUR_BAR.neutral(), [300.0, 0, 0])
    with pytest.raises(axode.SingularError, match="^the loops cannot be kept closed; a shorter step may help") as found:
        axode.rollout(FOUR_BAR, q, v, np.zeros(3), 0.1, steps=3)
    assert np.isfinite(found.value.result[0]).all() and np.isnan(found.value.result[-1]).all()


@pytest.mark.parametrize("call", [
    lambda m, q, v: axode.linearize(m, q, v, v),
    lambda m, q, v: axode.inverse_kinematics(m, [axode.Target(pose=np.eye(4), frame="ground")], q),
    lambda m, q, v: axode.inverse_dynamics_jvp(m, q, v, v, v, v, v),
    lambda m, q, v: axode.codegen.c_source(m, ["forward_dynamics"]),
], ids=["linearize", "inverse kinematics", "derivatives", "codegen"])
def test_what_does_not_count_loops_says_so(call):
    with pytest.raises(ValueError, match="loops"):
        call(FOUR_BAR, FOUR_BAR.neutral(), np.zeros(3))


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


@pytest.mark.parametrize("name", ["four_bar", "five_bar_arm", "slider_crank", "gough", "leg", "governor", "andrews", "bricard"])
def test_small_motions_are_those_of_the_mechanism(name):
    m = axode.load(axode.robots / f"{name}.toml")
    rng = np.random.default_rng(6)
    q, v = axode.assemble(m, m.neutral(), 0.1 * rng.normal(size=m.nv))
    tau = rng.normal(size=m.nv)
    small = axode.independent_linearization(m, q, v, tau)
    k = len(small.velocities)
    assert small.A.shape == (2 * k, 2 * k) and small.B.shape == (2 * k, m.nv)
    form = axode.independent_equations(m, q, v, small.velocities)
    np.testing.assert_allclose(small.N, form.N, atol=1e-9)
    np.testing.assert_allclose(small.B[k:], np.linalg.solve(form.M, form.N.T), rtol=1e-6, atol=1e-8)
    # A motion that begins elsewhere comes apart as exp(A t) says.
    x, t = 1e-5 * rng.normal(size=2 * k), 1e-4 if name != "andrews" else 1e-5
    there = axode.assemble(m, m.integrate(q, small.N @ x[:k]), hold=small.velocities)[0]
    other = axode.independent_equations(m, there, np.zeros(m.nv), small.velocities).N @ (v[small.velocities] + x[k:])
    ends = [axode.simulate(m, *start, t, tau=tau, rtol=1e-12, atol=1e-14) for start in ((q, v), (there, other))]
    apart = np.concatenate([m.difference(ends[0].q[-1], ends[1].q[-1])[small.velocities],
                            (ends[1].v[-1] - ends[0].v[-1])[small.velocities]])
    said = x + t * small.A @ x
    np.testing.assert_allclose(apart, said, atol=3e-2 * np.abs(said - x).max() + 1e-12)


def test_small_motions_at_open_places_are_refused():
    with pytest.raises(ValueError, match='q leaves loop "pin" open by'):
        axode.independent_linearization(FOUR_BAR, [0.3, 0, 0], np.zeros(3), np.zeros(3))
    with pytest.raises(ValueError, match="linearize.*loops"):
        axode.linearize(FOUR_BAR, FOUR_BAR.neutral(), np.zeros(3), np.zeros(3))


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "five_bar_arm", "gough", "leg"])
def test_mechanisms_rest_where_they_are_held(name):
    m = axode.load(axode.robots / f"{name}.toml")
    q, _ = axode.assemble(m, m.integrate(m.neutral(), 0.1 * np.ones(m.nv)))
    tau = axode.inverse_dynamics(m, q, np.zeros(m.nv), np.zeros(m.nv), drives=range(m.nv))
    found = axode.equilibrium(m, m.integrate(q, 0.01 * np.ones(m.nv)), tau)
    assert found.status == "solved" and np.abs(axode.loop_residual(m, found.q)).max() < 1e-10
    assert np.abs(axode.forward_dynamics(m, found.q, np.zeros(m.nv), tau)).max() < 1e-6


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
