"""Points of contact and their forces, in motions and at rest, and the page of contact with the command that writes it."""

import json
from pathlib import Path

import axode
import numpy as np
import pytest

SOURCE = Path(__file__).resolve().parents[2]
# They take a second or more each; `make nightly` computes them.
SLOW = {"tippe top", "quadruped", "sled", "bouncing ball"}


def cubes(count=1):
    box = {"kind": "box", "role": "collision", "size": [0.2, 0.2, 0.2]}
    return axode.with_floor(axode.Model.from_dict({
        "format": "axode drawing 1", "contact": {"friction": 0.5},
        "body": [{"name": f"cube {k}", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [0.007] * 3, "shape": [box]}
                 for k in range(count)]}))


def at(*heights):
    return np.concatenate([[0, 0, 0, 1, 0, 0, z] for z in heights])


def test_forces_of_a_motion_are_those_of_its_points():
    m = cubes(2)
    motion = axode.simulate(m, at(0.1, 0.3), np.zeros(12), 0.1, step=1e-2)
    assert len(motion.contacts) == len(motion.t) and motion.contacts[0] == []
    last = motion.contacts[-1]
    assert {(x.a, x.b, x.status) for x in last} == {("floor", "cube 0 shape 1", "stick"),
                                                    ("cube 0 shape 1", "cube 1 shape 1", "stick")}
    assert sum(x.force for x in last if x.a == "floor") == pytest.approx([0, 0, 2 * 9.81], abs=1e-9)
    for name, weight in (("cube 0", 1), ("cube 1", 1), ("cube 1 shape 1", 1), ("floor", -2), ("ground", -2)):
        assert motion.contact_forces(name)[-1] == pytest.approx([0, 0, 9.81 * weight], abs=1e-9), name
    assert np.all(motion.contact_forces("floor")[0] == 0)
    with pytest.raises(KeyError, match="wall"):
        motion.contact_forces("wall")


def test_samples_have_the_contacts_of_their_steps():
    m = cubes()
    ends = axode.simulate(m, at(0.1), np.zeros(6), 0.05, step=1e-2)
    samples = axode.simulate(m, at(0.1), np.zeros(6), 0.05, step=1e-2, times=[0, 0.015, 0.02, 0.021])
    assert [len(x) for x in samples.contacts] == [0, 4, 4, 4]
    for k, step in ((1, 2), (2, 2), (3, 3)):
        for found, expected in zip(samples.contacts[k], ends.contacts[step]):
            assert np.array_equal(found.force, expected.force) and np.array_equal(found.point, expected.point)
    free = axode.simulate(m, at(0.1), np.zeros(6), 0.05, contact=False)
    assert free.contacts == [[] for _ in free.t] and not free.contact_forces("cube 0").any()


def test_a_mechanism_on_a_floor_touches_it_unless_contact_is_off():
    box = {"kind": "box", "role": "collision", "size": [0.2, 0.2, 0.2]}
    robot = {"format": "axode drawing 1", "body": [{"name": "cube", "joint": "free", "mass": 1, "com": [0, 0, 0],
                                                    "inertia": [0.007] * 3, "shape": [box]}]}
    m = axode.with_floor(axode.Model.from_dict(robot))
    assert axode.simulate(m, at(0.2), np.zeros(6), 0.5).q[-1, 6] == pytest.approx(0.1, abs=1e-4)
    assert axode.simulate(m, at(0.2), np.zeros(6), 0.5, contact=False).q[-1, 6] < -0.9
    robot["body"][0].pop("shape")
    with pytest.raises(ValueError, match="no body of model \"mechanism\" has a collision shape, so that nothing could touch"):
        axode.with_floor(axode.Model.from_dict(robot))


def test_distances_of_pairs_are_those_of_the_list():
    m = axode.load(axode.robots / "quadruped.toml")
    q = m.random(seed=1, n=20)
    pairs = axode.shape_pairs(m)
    for chosen, threads in ((None, 1), (pairs[3:1:-1], 3)):
        distances, jacobians = axode.pair_distances(m, q, chosen, threads=threads)
        for k in range(20):
            expected = {(x.a, x.b): x for x in axode.distances(m, q[k])}
            for p, pair in enumerate(chosen or pairs):
                assert distances[k, p] == expected[pair].distance
                assert np.array_equal(jacobians[k, p], expected[pair].jacobian)
        one = axode.pair_distances(m, q[0], chosen)
        assert np.array_equal(one.distances, distances[0]) and np.array_equal(one.jacobians, jacobians[0])
    assert axode.pair_distances(m, q, []).jacobians.shape == (20, 0, m.nv)
    with pytest.raises(KeyError, match='there is no collision shape "FL fot"; did you mean "FL foot"'):
        axode.pair_distances(m, q, [("floor", "FL fot")])
    for wrong in ("floor", [("floor",)], [1, 2], [("floor", "belly", "FL foot")]):
        with pytest.raises(TypeError, match="pairs: expected pairs of names of collision shapes"):
            axode.pair_distances(m, q, wrong)
    with pytest.raises(ValueError, match='floor'):
        axode.pair_distances(m, q, [("floor", "floor")])


@pytest.mark.parametrize("friction", [1e3, 1e6, 1e12, 1e300])
def test_friction_with_which_nothing_slides_is_certified(friction):
    ball = {"name": "ball", "joint": "free", "mass": 1, "com": [0, 0, 0], "inertia": [0.004] * 3,
            "shape": [{"kind": "sphere", "role": "collision", "radius": 0.1}]}
    drawing = {"format": "axode drawing 1", "contact": {"friction": friction}, "body": [ball]}
    m = axode.with_floor(axode.Model.from_dict(drawing))
    assert [str(fault).count("contact counts more than 1000 as 1000") for fault in m.warnings] == [1] * (friction > 1e3)
    motion = axode.simulate(m, at(0.2), np.array([0, 0, 0, 1.0, 0, 0]), 0.5)
    assert motion.q[-1, 6] == pytest.approx(0.1, abs=1e-4) and motion.certificates.max() < 1e-9
    omega, v = motion.v[-1, :3], motion.v[-1, 3:]
    assert v[0] != 0 and np.linalg.norm(v) == pytest.approx(0.1 * np.linalg.norm(omega), rel=1e-6)  # it rolls


def test_forces_at_rest_are_those_of_a_first_step():
    m = cubes()
    push = axode.Load(frame="cube 0", representation="hybrid", wrench=[0, 0, 0, 4.0, 0, 0])
    [*points] = axode.contacts(m, at(0.1), loads=[push])
    motion = axode.simulate(m, at(0.1), np.zeros(6), 1e-3, step=1e-3, loads=[push])
    assert sum(x.force for x in points) == pytest.approx([-4, 0, 9.81], abs=1e-9)
    assert sum(x.force for x in motion.contacts[-1]) == pytest.approx([-4, 0, 9.81], abs=1e-9)
    assert {x.status for x in points} == {"stick"}
    assert {x.status for x in axode.contacts(m, at(0.105))} == {"open"}
    assert axode.contacts(m, at(0.105), margin=1e-3) == []
    assert {x.status for x in axode.contacts(m, at(0.105), touching=0.01)} == {"stick"}
    tau = np.array([0, 0, 0, 0, 0, 20.0])
    assert {x.status for x in axode.contacts(m, at(0.1), tau)} == {"open"}
    for wrong in (dict(touching=-1), dict(margin=np.inf), dict(tau=[1.0])):
        with pytest.raises(ValueError):
            axode.contacts(m, at(0.1), **wrong)


def test_a_page_shows_the_contacts_of_a_motion(tmp_path):
    if not hasattr(axode, "view"):
        pytest.skip("no viewer")
    m = cubes()
    motion = axode.simulate(m, at(0.1), np.zeros(6), 0.02, step=1e-2)
    axode.view(m, motion=motion, output=tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert '"contact_shapes":["floor","cube 0 shape 1"]' in page and '"contacts":[[],[[0,1,' in page


def test_a_file_of_a_motion_shows_the_contacts_of_the_motion(tmp_path):
    m = cubes()
    motion = axode.simulate(m, at(0.1), [0, 0, 0, 1, 0, 0], 0.02, step=1e-2)
    run = {"t": motion.t.tolist(), "q": motion.q.tolist(), "v": motion.v.tolist(), "a": motion.a.tolist(),
           "tau": motion.tau.tolist(), "contact_shapes": ["floor", "cube 0 shape 1"],
           "contacts": [[{name: x.tolist() if isinstance(x, np.ndarray) else x for name, x in point._asdict().items()}
                         for point in points] for points in motion.contacts]}
    file, pages = tmp_path / "run.json", [tmp_path / "motion.html", tmp_path / "file.html"]
    file.write_text(json.dumps(run))
    for page, shown in zip(pages, (motion, file)):
        axode.view(m, motion=shown, output=page)
    assert pages[1].read_text(encoding="utf-8") == pages[0].read_text(encoding="utf-8")
    first = run["contacts"][1][0]
    for wrong in ({"a": "wall"}, {"status": "glue"}, {"gap": "1 m"}, {"force": [1, 2]}, {"gap": 10**400}):
        file.write_text(json.dumps({**run, "contacts": [[], [first | wrong], []]}))
        with pytest.raises(ValueError, match="the contacts in .*run.json lack a key or have a wrong value"):
            axode.view(m, motion=file, output=pages[1])
    for wrong in ({"contacts": [[]]}, {"contacts": [[], [first | {"gap": np.nan}], []]}):
        file.write_text(json.dumps({**run, **wrong}))
        with pytest.raises(ValueError, match="motion.contacts"):
            axode.view(m, motion=file, output=pages[1])


def test_a_motion_that_does_not_begin_has_the_names_of_its_shapes():
    m = cubes()
    motion = axode.simulate(m, at(0.1), np.zeros(6), 0.0, step=1e-2)
    assert motion.contact_forces("floor").tolist() == [[0, 0, 0]]


def test_what_acts_and_is_not_counted_is_refused():
    foot = {"name": "foot", "joint": {"name": "down", "kind": "prismatic", "axis": "z"}, "mass": 1, "com": [0, 0, 0],
            "inertia": [1, 1, 1]}
    motor = {"kind": "dc_motor", "joint": "down", "resistance": 1, "inductance": 0.01, "torque_constant": 0.1, "input": 12}
    m = axode.Model.from_dict({"format": "axode drawing 1", "body": [foot], "drive": [motor]})
    with pytest.raises(ValueError, match="contacts_at_rest does not count drives with states"):
        axode.contacts(m, [0])
    with pytest.raises(ValueError, match="margin is nan m"):
        axode.contacts(cubes(), at(0.1), margin=np.nan)


def test_a_mechanism_without_velocities_has_no_contacts():
    assert axode.contacts(axode.with_floor(axode.Model.from_dict({"format": "axode drawing 1"})), []) == []


@pytest.fixture
def tables(monkeypatch):
    pytest.importorskip("scipy")
    monkeypatch.syspath_prepend(SOURCE / "tools")
    monkeypatch.syspath_prepend(SOURCE / "tests/validation")
    import contact_tables

    return contact_tables


def rows_of_page(name):
    page = (SOURCE / "docs/contact.md").read_text(encoding="utf-8")
    text = page.partition(f"<!-- {name} -->\n")[2].partition("<!-- end -->")[0]
    return [line.strip("| ").split(" | ") for line in text.splitlines()][2:]


def test_cases_are_on_the_page_and_within_their_bounds(tables):
    cases = tables.contact_cases.CASES
    rows = {row[0]: row[-1] for row in rows_of_page("cases")}
    assert list(rows) == [case.what for case in cases.values()]
    for name, case in cases.items():
        assert float(rows[case.what].split()[0]) <= case.bound, name
        if name not in SLOW:
            assert case.ours() <= case.bound, name


def test_the_page_has_the_orders_and_the_certificates_of_its_command(tables):
    laws = tables.contact_laws
    assert [row[0] for row in rows_of_page("order")] == [*laws.MOTIONS, laws.IMPACTS]
    assert all(float(row[2]) <= tables.CERTIFICATE and row[3] == "0" for row in rows_of_page("certificates"))
    assert float(rows_of_page("energy")[0][1]) <= tables.ENERGY
    assert laws.tower().certificates.max() <= tables.CERTIFICATE
    made, energy = laws.energy_made(0.0, 5e-3)
    assert made <= tables.ENERGY * energy


def test_events_of_the_exact_mode_are_roots_and_on_the_page(tables):
    rows = list(tables.contact_events.rows())
    on_page = rows_of_page("events")
    assert [(row[0], row[1]) for row in on_page] == [(name, str(count)) for name, count, _, _ in rows]
    for row, (name, _, _, error) in zip(on_page, rows):
        assert error <= tables.TIME and float(row[3].removesuffix(" s")) <= tables.TIME, name
