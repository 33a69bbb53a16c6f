"""Identification finds the parameters that caused the torques, as exactly as the noise allows, and they are
physically consistent."""

import subprocess
import sys

import axode
import numpy as np
import pytest
from axode.fitting import least_squares
from axode.identification import identify, pseudo_inertia
from mechanisms import MECHANISMS, close

pytest.importorskip("scipy.linalg", reason="SciPy is not installed")

EVERYWHERE = pytest.mark.parametrize("mechanism", MECHANISMS)
ARM = MECHANISMS["arm"]


def motion(m, N, seed=0):
    return m.random(seed=seed, n=N), *np.random.default_rng(seed).uniform(-2, 2, (2, N, m.nv))


def measured(m, N, deviation=0.0, seed=0, **forces):
    """(q, v, a, tau) of m, with noise."""
    states = motion(m, N, seed)
    tau = axode.inverse_dynamics(m, *states, **forces)
    return *states, tau + deviation * np.random.default_rng([seed, 1]).normal(size=tau.shape)


def varied(m, seed=0, size=0.1):
    """The mechanism m with other masses and inertias that are physically consistent."""
    random = np.random.default_rng(seed)
    pi = m.parameters.reshape(-1, 10)
    return m.with_parameters((random.uniform(1 - size, 1 + size, (len(pi), 1)) * pi).ravel())


def lowest_eigenvalue(m, but=()):
    P = pseudo_inertia(m.parameters.reshape(-1, 10))
    return min(np.linalg.eigvalsh(P_k).min() / np.trace(P_k) for P_k, name in zip(P, m.body_names) if name not in but)


def chi_squared(found, true):
    """The chi-squared value of the base parameters with their standard deviations, per degree of freedom."""
    errors = found.base_parameters - found.base_matrix @ true
    return np.mean((errors / found.base_deviations) ** 2)


@EVERYWHERE
def test_base_parameters_of_torques_without_noise_are_exact(mechanism):
    true = varied(MECHANISMS[mechanism])
    q, v, a, tau = measured(true, 80)
    found = identify(MECHANISMS[mechanism], q, v, a, tau)
    assert found.converged and found.rank == len(found.base_parameters) < len(found.parameters)
    assert close(found.base_parameters, found.base_matrix @ true.parameters, 1e-9)
    assert close(found.base_matrix @ found.parameters, found.base_parameters, 1e-6)
    assert lowest_eigenvalue(found.model, found.known) > 0
    others = motion(true, 20, seed=9)
    assert close(axode.inverse_dynamics(found.model, *others), axode.inverse_dynamics(true, *others), 1e-6)


@EVERYWHERE
def test_base_parameters_are_as_many_as_independent_columns_of_the_regressor(mechanism):
    m = MECHANISMS[mechanism]
    q, v, a, tau = measured(m, 80)
    found = identify(m, q, v, a, tau)
    Y = axode.regressor(m, q, v, a)[:, :, [name not in found.known for name in m.body_names for _ in range(10)]]
    Y /= np.abs(Y).max(axis=(0, 2), keepdims=True)
    Y = Y.reshape(-1, Y.shape[-1])
    sigma = np.linalg.svd(Y / np.maximum(np.linalg.norm(Y, axis=0), 1e-4 * np.linalg.norm(Y)), compute_uv=False)
    assert found.rank == np.sum(sigma > 1e-10 * sigma[0])
    assert len(found.unidentifiable) == Y.shape[1] - found.rank
    assert np.linalg.matrix_rank(found.unidentifiable) == len(found.unidentifiable)
    changes = axode.regressor(m, q, v, a) @ (found.unidentifiable.T / np.abs(found.unidentifiable).max(axis=1))
    assert np.abs(changes).max() < 1e-9 * np.abs(axode.regressor(m, q, v, a)).max()


@EVERYWHERE
def test_errors_are_as_large_as_their_deviations(mechanism):
    m, chi = MECHANISMS[mechanism], []
    seeds = range(1 if m.nv > 20 else 3)
    for seed in seeds:
        found = identify(m, *measured(m, 150, 0.05, seed))
        assert found.noise == pytest.approx(np.full(m.nv, 0.05), rel=0.3)
        errors = found.base_parameters - found.base_matrix @ m.parameters
        assert np.abs(errors / found.base_deviations).max() < 4.5
        chi.append(chi_squared(found, m.parameters))
    assert np.mean(chi) == pytest.approx(1, abs=5 * np.sqrt(2 / (len(seeds) * found.rank)))


def test_deviations_shrink_with_the_root_of_the_number_of_samples():
    few, many = (identify(ARM, *measured(ARM, N, 0.05)) for N in (250, 4000))
    assert few.rank == many.rank
    common = sorted(set(few.base_names) & set(many.base_names))
    ratios = [few.base_deviations[few.base_names.index(name)] / many.base_deviations[many.base_names.index(name)]
              for name in common]
    assert len(ratios) > 10 and np.median(ratios) == pytest.approx(4, rel=0.1)


def test_noise_that_differs_between_velocities_is_found_and_weighs():
    noise = 0.01 * 3.0 ** np.arange(7)
    q, v, a, tau = measured(ARM, 400)
    tau += noise * np.random.default_rng(5).normal(size=tau.shape)
    found = identify(ARM, q, v, a, tau)
    assert found.noise == pytest.approx(noise, rel=0.15)
    given, equal = identify(ARM, q, v, a, tau, noise=noise), identify(ARM, q, v, a, tau, noise=1.0)
    assert np.array_equal(given.noise, noise) and 0.5 < chi_squared(given, ARM.parameters) < 1.6
    assert equal.base_names == found.base_names
    error = [np.linalg.norm(x.base_parameters - x.base_matrix @ ARM.parameters) for x in (found, equal)]
    assert error[0] < error[1]


def test_what_least_squares_makes_negative_can_be_built_here():
    q, v, a, tau = measured(ARM, 40, 2.0, seed=3)
    Y = axode.regressor(ARM, q, v, a).reshape(-1, 70)
    plain = np.linalg.lstsq(Y, tau.ravel() - Y @ ARM.parameters, rcond=1e-9)[0] + ARM.parameters
    assert np.linalg.eigvalsh(pseudo_inertia(plain.reshape(-1, 10))).min() < -0.1
    found = identify(ARM, q, v, a, tau)
    assert lowest_eigenvalue(found.model) > 0 and found.converged and not found.model.warnings
    assert np.array_equal(found.model.parameters, found.parameters)
    assert np.all(found.residual < 1.1 * np.sqrt(np.mean(tau**2, axis=0)))


@EVERYWHERE
def test_the_consistent_model_explains_the_torques_as_well_as_least_squares(mechanism):
    m = MECHANISMS[mechanism]
    found = identify(m, *measured(varied(m), 150, 0.05))
    assert lowest_eigenvalue(found.model, found.known) > 0
    assert np.all(found.residual < 1.1 * found.base_residual)


def test_robots_are_identified(robot):
    m = axode.load(robot, base="fixed")
    q, v, a, tau = measured(m, 200, 0.05)
    found = identify(m, q, v, a, tau)
    assert found.converged and lowest_eigenvalue(found.model, found.known) > 0
    assert chi_squared(found, m.parameters) == pytest.approx(1, abs=5 * np.sqrt(2 / found.rank))
    assert np.all(found.residual < 0.06)


@pytest.mark.parametrize("seed", range(4))
def test_random_trees_are_identified(seed):
    random = np.random.default_rng(seed)
    kinds = ["revolute", "prismatic", "helical", "cylindrical", "universal", "spherical", "planar", "free"]
    tree, names = axode.Builder(f"tree {seed}"), []
    for kind in random.permutation(kinds):
        joint = {"kind": str(kind)}
        if kind not in ("free",):
            joint |= {"point": random.uniform(-1, 1, 3)}
        if kind not in ("free", "spherical"):
            joint |= {"axis": np.eye(3)[random.integers(3)]}
        if kind == "universal":
            joint |= {"second_axis": np.roll(joint["axis"], 1)}
        if kind == "helical":
            joint |= {"pitch": 0.1}
        on = {"on": names[random.integers(len(names))]} if names else {}
        tree.body(f"{kind} body", **on, joint=joint, mass=random.uniform(1, 5), com=random.uniform(-1, 1, 3),
                  inertia=random.uniform(0.2, 0.3, 3))
        names.append(f"{kind} body")
    m = tree.build()
    true = varied(m, seed)
    q, v, a, tau = measured(true, 120)
    found = identify(m, q, v, a, tau)
    assert close(found.base_parameters, found.base_matrix @ true.parameters, 1e-9)
    assert lowest_eigenvalue(found.model, found.known) > 0


def test_a_body_that_flies_is_known_altogether():
    m = (axode.Builder("stone").body("stone", joint="free", mass=2, com=[0.1, 0, 0], inertia=[0.1, 0.2, 0.25]).build())
    true = m.with_parameters(pi := np.array([2.5, 0.3, 0.1, 0, 0.15, 0.22, 0.3, 0.01, 0, 0.02]))
    found = identify(m, *measured(true, 50))
    assert found.rank == 10 and not len(found.unidentifiable)
    assert found.parameters == pytest.approx(pi, abs=1e-8)


def test_the_prior_fills_what_the_motions_leave_open():
    q, v, a, tau = measured(varied(ARM), 200, 0.02)
    pi = ARM.parameters
    assert identify(ARM, *measured(ARM, 200)).parameters == pytest.approx(pi, abs=1e-6)
    assert identify(ARM, q, v, a, tau, prior=1e-7).parameters == pytest.approx(pi, abs=1e-5)
    found = identify(ARM, q, v, a, tau)
    distances = [np.linalg.norm(identify(ARM, q, v, a, tau, prior=prior).parameters - pi) for prior in (1e-4, 1e-3, 10)]
    assert distances == sorted(distances)
    assert found.deviations.max() > 1e4 * found.deviations.min() > 0


def test_the_model_found_does_not_depend_on_the_frames_of_the_bodies():
    at = {}
    for frame in ("construction", "com"):
        drawing = ARM.to_dict()
        for body in drawing["body"]:
            if frame == "com" and "mass" in body:
                body["frame"] = "com"
        m = axode.Model.from_dict(drawing)
        q, v, a, tau = measured(ARM, 60, 1.0)
        at[frame] = axode.inverse_dynamics(identify(m, q, v, a, tau).model, q, v, a)
    assert close(at["com"], at["construction"], 1e-6)


@pytest.mark.parametrize("given", [None, 0.05])
def test_outliers_do_less_harm_to_the_robust_estimate(given):
    q, v, a, tau = measured(ARM, 600, 0.05)
    random = np.random.default_rng(2)
    wrong = random.random(tau.shape) < 0.05
    tau[wrong] += 20 * random.normal(size=wrong.sum())
    plain, robust = (identify(ARM, q, v, a, tau, robust=robust, noise=given) for robust in (False, True))
    errors = [np.linalg.norm(x.base_parameters - x.base_matrix @ ARM.parameters) for x in (plain, robust)]
    assert plain.base_names == robust.base_names and errors[1] < 0.1 * errors[0]
    assert robust.converged and robust.noise == pytest.approx(np.full(7, 0.05), rel=0.2)
    assert chi_squared(robust, ARM.parameters) < 2
    clean = identify(ARM, *measured(ARM, 600, 0.05), robust=True)
    assert clean.noise.mean() == pytest.approx(0.05, rel=0.06)  # three standard deviations
    assert chi_squared(clean, ARM.parameters) == pytest.approx(1, abs=5 * np.sqrt(2 / 43))
    assert given or np.mean(clean.noise) == pytest.approx(0.05, rel=0.05)  # of 4,200 torques to 1.5 %


def with_joints(m, **values):
    drawing = m.to_dict()
    for body in drawing["body"]:
        if isinstance(body["joint"], dict) and body["joint"]["kind"] == "revolute":
            body["joint"] |= values
    return axode.Model.from_dict(drawing)


def test_losses_and_armatures_of_joints_are_found_and_in_the_model():
    true = with_joints(ARM, damping=0.3, friction=0.7, armature=0.2)
    q, v, a, tau = measured(true, 400, 0.01, joint_losses=True)
    found = identify(ARM, q, v, a, tau, joint_losses=True, armature=True)
    assert found.parameter_names[70:72] == ["A1 armature", "A2 armature"]
    assert np.array_equal(found.parameters[:70], found.model.parameters)
    for kind, value, start in [("armature", 0.2, 70), ("damping", 0.3, 77), ("friction", 0.7, 84)]:
        in_model = np.concatenate([getattr(joint, kind) for joint in found.model.joints])
        assert np.array_equal(in_model, found.parameters[start:start + 7])
        if kind != "armature":  # of which that of A1 is as well an inertia of link 1
            assert np.all(np.abs(in_model - value) < 4.5 * found.deviations[start:start + 7])
    assert chi_squared(found, np.append(true.parameters, np.repeat([0.2, 0.3, 0.7], 7))) < 1.8
    error = axode.inverse_dynamics(found.model, q, v, a, joint_losses=True) - tau
    assert np.sqrt(np.mean(error**2)) < 0.011
    assert identify(ARM, q, v, a, tau).noise.min() > 0.1


def test_losses_of_every_kind_of_joint_reach_the_model():
    drawing = MECHANISMS["machine"].to_dict()
    carriage = next(body for body in drawing["body"] if body["name"] == "carriage")
    carriage["joint"] |= {"damping": 2e4, "friction": 100.0}  # it follows the screw, and what it has is known
    m = axode.Model.from_dict(drawing)
    q, v, a, tau = measured(m, 300, joint_losses=True)
    found = identify(m, q, v, a, tau, joint_losses=True, armature=True)
    assert found.converged and found.model.joint_names == m.joint_names
    assert found.model.joint("carriage slide").damping == m.joint("carriage slide").damping
    true = {f"{name} {kind}": value for kind in ("armature", "damping", "friction") for joint in m.joints if joint.nv
            for name, value in zip(m.velocity_names[joint.v], getattr(joint, kind))}
    pi = np.append(m.parameters, [true[name] for name in found.parameter_names[100:]])
    assert close(found.base_parameters, found.base_matrix @ pi, 1e-9)
    assert close(axode.inverse_dynamics(found.model, q, v, a, joint_losses=True), tau, 1e-6)


def test_armatures_of_the_model_are_taken_off_the_torques():
    m = with_joints(ARM, armature=0.5)
    found = identify(m, *measured(m, 200))
    assert close(found.base_parameters, found.base_matrix @ ARM.parameters, 1e-9)
    assert [joint.armature[0] for joint in found.model.joints] == [0.5] * 7


def test_loads_are_known():
    q, v, a = motion(ARM, 200)
    loads = [axode.Load(frame="flange", representation="hybrid", wrench=np.random.default_rng(1).normal(size=(200, 6)))]
    tau = axode.inverse_dynamics(ARM, q, v, a, loads=loads)
    found = identify(ARM, q, v, a, tau, loads=loads)
    assert close(found.base_parameters, found.base_matrix @ ARM.parameters, 1e-9)
    assert identify(ARM, q, v, a, tau).noise.min() > 0.01


def test_known_bodies_stay_and_the_others_are_found():
    true = ARM.with_payload("flange", axode.lie.transform_inertia(axode.lie.exp([0, 0, 0, 0, 0, 0.1]),
                                                                 axode.lie.sphere_inertia(1.5, 0.05)))
    found = identify(ARM, *measured(true, 100), known=ARM.body_names[:6])
    assert found.known == ARM.body_names[:6] and close(found.parameters[:60], ARM.parameters[:60], 1e-14)
    assert not found.deviations[:60].any() and not found.base_matrix[:, :60].any() and found.rank == 10
    assert close(found.parameters[60:], true.parameters[60:], 1e-6)


def test_bodies_without_mass_and_without_extension_are_no_obstacle():
    hinge = {"kind": "revolute", "axis": "y", "point": [0, 0, 1]}
    m = (axode.Builder("pendulum").body("dummy", joint={"kind": "revolute", "axis": "z", "point": [0, 0, 0]})
         .body("rod", on="dummy", joint=hinge, mass=1, com=[0, 0, 0.5], inertia=[0, 0, 0]).build())
    true = m.with_parameters(np.append(np.zeros(10), [1.2, 0, 0, 0.5, 0.3, 0.3, 0.02, 0, 0, 0]))
    found = identify(m, *measured(true, 50))
    assert found.known == ["dummy"] and not found.model.parameters[:10].any()
    assert close(found.base_parameters, found.base_matrix @ true.parameters, 1e-9)
    assert lowest_eigenvalue(found.model, ["dummy"]) > 0
    assert np.all(found.residual < 1e-5)


def test_blocks_of_samples_give_the_same(monkeypatch):
    samples = measured(ARM, 300, 0.05)
    once = identify(ARM, *samples, robust=True)
    monkeypatch.setattr(least_squares, "BLOCK", 7 * 70 * 13)
    blocks = identify(ARM, *samples, robust=True)
    assert close(blocks.parameters, once.parameters, 1e-8) and close(blocks.base_residual, once.base_residual, 1e-9)


def test_names_of_base_parameters_are_their_rows():
    found = identify(ARM, *measured(ARM, 100))
    for name, row in zip(found.base_names, found.base_matrix):
        first, *others = name.replace(" - ", " + -").split(" + ")
        terms = {first: 1.0}
        for term in others:
            factor, _, parameter = term.rpartition(" * ")
            sign = -1 if term.startswith("-") else 1
            terms[parameter.removeprefix("-")] = float(factor) if factor else sign
        assert {found.parameter_names[k] for k in np.flatnonzero(row)} == set(terms)
        for parameter, factor in terms.items():
            assert row[found.parameter_names.index(parameter)] == pytest.approx(factor, rel=1e-3)


def test_arguments_that_are_wrong_are_named():
    q, v, a, tau = measured(ARM, 50)
    broken = np.where(np.arange(350).reshape(50, 7) == 22, np.nan, tau)
    rows = "nq numbers of each sample, got"
    for error, words, arguments, options in [
        (ValueError, rf"q: expected shape \(N, 7\), {rows} \(7,\)", (q[0], v[0], a[0], tau[0]), {}),
        (ValueError, rf"q: expected shape \(N, 7\), {rows} \(0, 7\)", [x[:0] for x in (q, v, a, tau)], {}),
        (ValueError, r"v: expected shape \(50, 7\), nv numbers of each sample, got \(9, 7\)", (q, v[:9], a, tau), {}),
        (ValueError, r"tau\[3, 1\] is nan; expected finite", (q, v, a, broken), {}),
        (ValueError, "3 samples are too few for 21 base parameters", (q[:3], v[:3], a[:3], tau[:3]), {}),
        (ValueError, r"noise: expected shape \(7,\), nv numbers, got \(2,\)", (q, v, a, tau), {"noise": [1, 2]}),
        (ValueError, r"noise\[0\] is 0.0; expected standard deviations, more than 0", (q, v, a, tau), {"noise": 0}),
        (ValueError, "prior is -1; expected", (q, v, a, tau), {"prior": -1}),
        (KeyError, 'no body "link 9"', (q, v, a, tau), {"known": ["link 9"]}),
        (TypeError, "known is 'link 1'; expected a list", (q, v, a, tau), {"known": "link 1"}),
        (ValueError, "nothing to identify", (q, v, a, tau), {"known": ARM.body_names}),
    ]:
        with pytest.raises(error, match=words):
            identify(ARM, *arguments, **options)
    with pytest.raises(ValueError, match="no torque of these motions depends"):
        identify(ARM.with_gravity([0, 0, 0]), q, 0 * v, 0 * a, tau)
    with pytest.raises(ValueError, match=r"pi: expected shape \(..., 10\)"):
        pseudo_inertia([1, 2])


def test_scipy_is_needed_here_and_nowhere_else(monkeypatch):
    program = "import sys, axode; assert 'scipy' not in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True)
    monkeypatch.setitem(sys.modules, "scipy.linalg", None)
    with pytest.raises(ImportError, match="needs SciPy: pip install scipy"):
        identify(ARM, *measured(ARM, 50))
