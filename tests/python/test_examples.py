"""The examples run from any folder, and the statements that they print are true."""

import os
import re
import runpy
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import axode
import numpy as np
import pytest
from mechanisms import REPRESENTATIONS

EXAMPLES = Path(__file__).resolve().parents[2] / "examples/python"


def run(folder, name, *arguments):
    """Runs an example and returns its output."""
    done = subprocess.run([sys.executable, EXAMPLES / name, *arguments], cwd=folder, capture_output=True, text=True,
                          env={**os.environ, "MPLBACKEND": "Agg"})
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return done.stdout


def numbers_behind(text, words):
    """The numbers in the line of the output that begins with these words."""
    line = next(line for line in text.splitlines() if line.startswith(words))
    return [float(number) for number in re.findall(r"(?<![\w^.])-?\d+\.?\d*(?:e-?\d+)?", line.removeprefix(words))]


def test_every_example_is_run_here():
    assert sorted(file.name for file in EXAMPLES.glob("*.py")) == [
        "01_drawing_to_dynamics.py", "02_representations.py", "03_batch_trajectory.py",
        "04_identification.py", "05_calibration.py", "06_elastic_drives.py", "07_simulation.py",
        "08_elastic_arm.py", "09_trajectory_optimization.py",
        "10_casadi_collocation.py", "11_learning_with_torch.py", "12_gait_with_jax.py", "13_monte_carlo.py",
        "14_on_a_gpu.py",  # these in tests/bridges
        "15_tippe_top.py", "16_gripper.py", "17_quadruped.py", "18_fmu.py", "19_parallel_manipulator.py",
    ]


def test_the_crane_holds_what_levers_say_and_dynamics_are_inverse(tmp_path):
    printed = run(tmp_path, "01_drawing_to_dynamics.py")
    slew, luff, travel = numbers_behind(printed, "to hold it:")
    assert (slew, travel) == (0, 0)
    assert [luff] == numbers_behind(printed, "luff by hand:")
    loaded = numbers_behind(printed, "with 500 kg on the hook:")[0]
    assert loaded - luff == pytest.approx(500 * 9.81 * 2.5, abs=0.1)
    slip = numbers_behind(printed, "the trolley slips:")
    assert slip[0] == slip[-1] > 0
    assert "these drive forces again: True" in printed


@pytest.mark.parametrize("arguments", [[], ["figure.svg"]])
def test_the_figure_shows_three_lines_and_their_length_in_eight_panels(tmp_path, arguments):
    run(tmp_path, "02_representations.py", *arguments)
    assert [file.name for file in tmp_path.iterdir()] == (arguments or ["representations.svg"])
    figure = ElementTree.parse(next(tmp_path.iterdir())).getroot()
    panels = [group for group in figure.findall(".//{*}g") if re.fullmatch(r"axes_\d+", group.get("id", ""))]
    assert len(panels) == 8
    assert all(len(panel.findall("{*}g/{*}path[@clip-path]")) == 4 for panel in panels)
    text = next(tmp_path.iterdir()).read_text()
    for label in ["angular part in rad/s", "linear part in m/s", "time in s", *REPRESENTATIONS]:
        assert f"<!-- {label}" in text


def test_the_four_twists_are_those_of_the_jacobians(tmp_path):
    printed = run(tmp_path, "02_representations.py", "figure.png")
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
    grinder = axode.Model.from_bodies(
        [{"name": "arm", "joint": {"kind": "revolute", "axis": "z", "point": [0, 0, 0]}},
         {"name": "wheel", "on": "arm", "joint": {"kind": "revolute", "axis": "x", "point": [0, 0, 0.5]}}],
        [{"name": "center", "on": "wheel", "position": [1, 0, 0.5]}])
    for representation in REPRESENTATIONS:
        J = axode.jacobian(grinder, np.pi / 4 * np.array([1, 3]), "center", representation)
        assert numbers_behind(printed, representation) == pytest.approx(J @ [1, 3], abs=6e-4)


def test_peaks_and_means_of_the_torques_are_those_of_the_equations_of_motion(tmp_path):
    printed = run(tmp_path, "03_batch_trajectory.py")
    example = runpy.run_path(str(EXAMPLES / "03_batch_trajectory.py"))
    arm, q, v, a = (example[name] for name in ("arm", "q", "v", "a"))
    tau = np.einsum("nij,nj->ni", axode.mass_matrix(arm, q), a) + axode.coriolis_vector(arm, q, v) \
        + axode.gravity_torques(arm, q)
    for joint in map(arm.joint, arm.joint_names):
        peak, rms, effort, used = numbers_behind(printed, joint.name)
        torque = np.abs(tau[:, joint.v])
        assert [peak, rms] == pytest.approx([torque.max(), np.linalg.norm(torque) / np.sqrt(len(q))], abs=0.006)
        assert peak < effort == joint.effort[0]
        assert used == pytest.approx(100 * peak / effort, abs=0.06)
    assert "all torques within the limits: True" in printed
    assert numbers_behind(printed, "largest difference to a loop:")[0] < 1e-11
    assert numbers_behind(printed, "loop over 4096 states:")[0] > 0


def test_the_identified_arm_is_the_one_that_was_measured(tmp_path):
    printed = run(tmp_path, "04_identification.py")
    rows = [line for line in printed.splitlines() if re.match(r"link \d", line)]
    assert len(rows) == 6
    for row in rows:
        found, true, deviation = map(float, row[29:].split())
        assert abs(found - true) < 4 * deviation + 1e-4
    for name in [f"A{k}" for k in range(1, 8)]:
        _, friction, noise, true_noise = numbers_behind(printed, name)
        assert friction == pytest.approx(1.5, abs=0.3) and noise == pytest.approx(true_noise, rel=0.1)
    drawn, found = (numbers_behind(printed, f"torques of the {name} model")[0] for name in ("drawn", "found"))
    assert found < 0.1 * drawn
    assert "every body can be built: True" in printed


def test_the_calibrated_arm_is_where_the_tracker_sees_it(tmp_path):
    printed = run(tmp_path, "05_calibration.py")
    assert numbers_behind(printed, "54 parameters,")[0] == 4 * 7 + 6
    assert numbers_behind(printed, "noise:") == pytest.approx([0.2, 0.1], rel=0.15)
    assert "  link 1 rz - link 2 rz\n" in printed
    drawn, found = (np.array(numbers_behind(printed, f"poses of the {name} model are off by"))
                    for name in ("drawn", "found"))
    assert np.all(found < [0.2, 0.1]) and np.all(drawn > 100 * found)
    assert "masses and names are those of the drawing: True" in printed


def test_feed_forward_that_knows_of_the_springs_leaves_no_error(tmp_path):
    printed = run(tmp_path, "06_elastic_drives.py")
    wind_up, = numbers_behind(printed, "wind-up of the springs: up to")
    rigid, = numbers_behind(printed, "links off by, without the springs in the feed-forward:")
    flat, = numbers_behind(printed, "links off by, with them:")
    assert rigid > 0.5 * wind_up > 1
    assert flat < 1e-4 * rigid


def test_the_arm_falls_with_its_energy_and_is_drawn_to_the_target(tmp_path):
    printed = run(tmp_path, "07_simulation.py")
    steps, energy = numbers_behind(printed, "it falls:")
    assert steps > 50 and energy < 1e-5
    distances = [float(line.split()[4]) for line in printed.splitlines() if line.startswith("t = ")]
    assert len(distances) == 7 and distances[0] > 1 and distances[-1] < 0.01


def test_the_elastic_arm_swings_and_arrives(tmp_path):
    printed = run(tmp_path, "08_elastic_arm.py")
    rows = [[float(x) for x in re.findall(r"\d+\.\d+", line)] for line in printed.splitlines() if line.startswith("t = ")]
    assert [row[0] for row in rows] == [0.1, 0.5, 1.0, 5.0]
    assert rows[0][1] > 0.5 and rows[-1][1] < 0.02
    assert all(row[2] > 1 for row in rows)
    steps, evaluations = numbers_behind(printed, "")[:2]
    assert steps == 2500 and evaluations < 6
    assert "the springs carry the weight: True" in printed


def test_the_pendulum_stands_by_the_least_forces(tmp_path):
    printed = run(tmp_path, "09_trajectory_optimization.py")
    assert numbers_behind(printed, "it stands after 1 s to within")[0] < 1e-9
    assert max(numbers_behind(printed, "largest drive torques in N m:")) < 30
    assert numbers_behind(printed, "the forces are a gradient of the end to within")[0] < 1e-5


def test_the_tippe_top_stands_on_its_stem_and_gains_no_energy(tmp_path):
    printed = run(tmp_path, "15_tippe_top.py")
    assert numbers_behind(printed, "the stem touches after")[0] == pytest.approx(1.43, abs=0.02)
    assert numbers_behind(printed, "the top turns by up to")[0] > 170
    before, after = numbers_behind(printed, "the energy falls from")
    assert after < before and "in every step: True" in printed
    assert numbers_behind(printed, "largest certificate")[0] <= 1e-9


def test_what_the_gripper_holds_does_not_creep(tmp_path):
    printed = run(tmp_path, "16_gripper.py")
    assert numbers_behind(printed, "the box is lifted by")[0] == pytest.approx(0.199, abs=1e-3)
    assert numbers_behind(printed, "between 3 s and")[1] <= 1e-10
    one, other, lift = numbers_behind(printed, "the fingers press with")
    assert [one, other] == pytest.approx([5, 5], abs=1e-3) and lift == pytest.approx(0.2 * 9.81, abs=1e-3)
    assert numbers_behind(printed, "largest certificate")[0] <= 1e-9


def test_the_quadruped_stands_and_trots(tmp_path):
    printed = run(tmp_path, "17_quadruped.py")
    press, weight = numbers_behind(printed, "it stands:")
    assert press == pytest.approx(weight, rel=1e-3)
    way, _, mean = numbers_behind(printed, "it trots")
    assert way > 0.3 and mean == pytest.approx(weight, rel=0.05)
    assert numbers_behind(printed, "largest certificate")[0] <= 1e-9
    assert (tmp_path / "forces.svg").read_text().count("<!-- FL -->") == 1


def test_another_simulator_moves_the_four_bar_as_axode_does(tmp_path):
    pytest.importorskip("fmpy")
    printed = run(tmp_path, "18_fmu.py")
    _, off = numbers_behind(printed, "ModelExchange: crank at")
    assert off < 1e-5
    _, off = numbers_behind(printed, "CoSimulation: crank at")
    assert off < 1e-9


def test_the_platform_with_elastic_drives_follows_its_motion(tmp_path):
    printed = run(tmp_path, "19_parallel_manipulator.py")
    [without] = numbers_behind(printed, "plate off by, without u'' in the forces of the motors:")
    [with_springs] = numbers_behind(printed, "plate off by, with it:")
    assert with_springs < 1e-7 and without > 1e-5
    assert "turned by 90 degrees: type 2: the platform can move while all drives are locked, about the axis" in printed
