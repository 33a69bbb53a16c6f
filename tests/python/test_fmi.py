"""FMUs, run by fmpy: a simulator that knows nothing of axode."""

import ctypes
import re
import subprocess
import sysconfig
import zipfile
from pathlib import Path

import axode
import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy")
fmpy_validation = pytest.importorskip("fmpy.validation")
from fmpy.fmi2 import FMU2Model, FMU2Slave  # noqa: E402
from fmpy.fmi3 import FMU3Model, FMU3Slave  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

COMMAND = Path(sysconfig.get_path("scripts")) / "axode"
VERSIONS = ["2.0", "3.0"]
MECHANISMS = {
    "arm7.toml": {"q.A2": 0.5, "q.A4": 1.0, "q.A6": 0.2, "v.A1": 1.0, "v.A5": -0.5},
    "four_bar.toml": {},
    "gough.toml": {},
    "double_pendulum.toml": {},
}


def number_of(name):
    """The reference of a joint's coordinate or velocity among q or v, as in `q.A2`."""
    return name.partition(".")[::2]


def start_of(m, values):
    q, v = (np.array(x) for x in m.initial_state())
    for name, value in values.items():
        what, joint = number_of(name)
        if what == "q":
            q[m.coordinate_names.index(joint)] = value
        else:
            v[m.velocity_names.index(joint)] = value
    return q, v


def ends_of(result, m):
    """The last q and v of a result of fmpy."""
    return (np.array([result[f"q.{name}"][-1] for name in m.coordinate_names]),
            np.array([result[f"v.{name}"][-1] for name in m.velocity_names]))


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Exports a mechanism once."""
    folder, made = tmp_path_factory.mktemp("fmus"), {}

    def export(m, version, **options):
        key = (axode.drawing(m), version, str(options))
        if key not in made:
            made[key] = str(folder / f"{len(made)}.fmu")
            axode.fmi.export(m, made[key], version=version, **options)
        return made[key]

    return export


class Driven:
    """An FMU for model exchange or co-simulation, driven by hand."""

    def __init__(self, fmu, kind="ModelExchange", token=None):
        self.description = fmpy.read_model_description(fmu)
        self.version = self.description.fmiVersion
        two = self.version == "2.0"
        types = {"ModelExchange": (FMU2Model, FMU3Model), "CoSimulation": (FMU2Slave, FMU3Slave)}[kind]
        self.fmu = types[0 if two else 1](
            instanceName="one", unzipDirectory=fmpy.extract(fmu),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            guid=token or (self.description.guid if two else self.description.instantiationToken))
        self.fmu.instantiate()
        if two:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.references = {each.name: each.valueReference for each in self.description.modelVariables}
        self.get = self.fmu.getReal if two else self.fmu.getFloat64
        self.set = self.fmu.setReal if two else self.fmu.setFloat64

    def names(self, condition):
        return [each.name for each in self.description.modelVariables if condition(each)]

    def put(self, **values):
        for name, value in values.items():
            self.set([self.references[name]], [value])

    def value(self, name):
        return self.get([self.references[name]])[0]

    def start(self):
        fmu, two = self.fmu, self.version == "2.0"
        self.rates_of = fmu.getDerivatives if two else fmu.getContinuousStateDerivatives
        fmu.exitInitializationMode()
        (fmu.newDiscreteStates if two else fmu.updateDiscreteStates)()
        fmu.enterContinuousTimeMode()
        self.n = self.description.numberOfContinuousStates
        self.x, self.dx = np.zeros(self.n), np.zeros(self.n)
        self.fmu.getContinuousStates(self._at(self.x), self.n)
        return self.x.copy()

    def _at(self, array):
        return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    def rates(self, t, x):
        self.x[:] = x
        self.fmu.setTime(t)
        self.fmu.setContinuousStates(self._at(self.x), self.n)
        self.rates_of(self._at(self.dx), self.n)
        return self.dx.copy()

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("file", MECHANISMS)
def test_descriptions_are_valid_and_motions_are_those_of_axode(exported, file, version):
    m = axode.load(axode.robots / file)
    q, v = start_of(m, MECHANISMS[file])
    motion = axode.simulate(m, q, v, 0.5, rtol=1e-12, atol=1e-13)
    fmu = exported(m, version)
    assert fmpy_validation.validate_fmu(fmu) == []
    for kind, tolerance, off in [("CoSimulation", 1e-12, 1e-9), ("ModelExchange", 1e-10, 1e-4)]:
        result = fmpy.simulate_fmu(fmu, fmi_type=kind, stop_time=0.5, output_interval=0.005,
                                   relative_tolerance=tolerance, start_values=MECHANISMS[file])
        at = ends_of(result, m)
        assert np.allclose(at[0], motion.q[-1], rtol=0, atol=off), kind
        assert np.allclose(at[1], motion.v[-1], rtol=0, atol=100 * off), kind


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("file", ["four_bar.toml", "double_pendulum.toml"])
def test_an_exact_integrator_of_the_master_gives_the_motion_of_axode(exported, file, version):
    m = axode.load(axode.robots / file)
    driven = Driven(exported(m, version))
    x = driven.start()
    motion = axode.simulate(m, x[:m.nq], x[m.nq:], 0.5, rtol=1e-12, atol=1e-13)
    found = solve_ivp(driven.rates, (0, 0.5), x, method="DOP853", rtol=1e-12, atol=1e-13)
    driven.close()
    assert np.allclose(found.y[:, -1], [*motion.q[-1], *motion.v[-1]], rtol=0, atol=1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_directional_derivatives_are_those_of_the_rates(exported, version):
    m = axode.load(axode.robots / "arm7.toml")
    driven = Driven(exported(m, version, frames=("flange",)))
    driven.put(**MECHANISMS["arm7.toml"])
    driven.start()
    states = driven.names(lambda each: each.initial == "exact" and each.causality == "output")
    inputs = driven.names(lambda each: each.causality == "input")
    knowns = [driven.references[name] for name in [*states, *inputs]]
    unknowns = [driven.references[name] for name in driven.names(lambda each: each.initial == "calculated")]
    x, u = driven.x.copy(), np.linspace(-1, 1, len(inputs))

    def values(y):
        driven.rates(0, y[:driven.n])
        driven.set(knowns[driven.n:], list(y[driven.n:]))
        return np.array(driven.get(unknowns))

    y = np.concatenate([x, u])
    values(y)
    J = np.array([driven.fmu.getDirectionalDerivative(unknowns, [k], [1.0]) for k in knowns]).T
    for k, step in enumerate(1e-3 * np.eye(len(y))):
        difference = (values(y - 2 * step) - 8 * values(y - step) + 8 * values(y + step) - values(y + 2 * step)) / 12e-3
        assert np.allclose(J[:, k], difference, rtol=0, atol=1e-7 * np.abs(J).max())
    values(y)
    seed = np.linspace(1, 2, len(y))
    both = driven.fmu.getDirectionalDerivative(unknowns, knowns, list(seed))
    assert np.allclose(both, J @ seed, rtol=0, atol=1e-12 * np.abs(J).max())
    if version == "3.0":
        weights = np.linspace(-1, 1, len(unknowns))
        adjoint = driven.fmu.getAdjointDerivative(unknowns, knowns, list(weights), nSensitivity=len(knowns))
        assert np.allclose(adjoint, weights @ J, rtol=0, atol=1e-12 * np.abs(J).max())
    driven.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_inputs_parameters_and_poses_are_those_of_the_library(exported, version):
    m = axode.load(axode.robots / "arm7.toml")
    fmu = exported(m, version, frames=("flange",))
    assert fmpy_validation.validate_fmu(fmu) == []
    start = {**MECHANISMS["arm7.toml"], "body.link 7.mass": 5.0, "tau.A2": -40.0}
    result = fmpy.simulate_fmu(fmu, fmi_type="CoSimulation", stop_time=0.2, output_interval=0.1, relative_tolerance=1e-12,
                               start_values=start)
    changed = m.to_dict()
    next(body for body in changed["body"] if body["name"] == "link 7")["mass"] = 5.0
    heavier = axode.Model.from_dict(changed)
    q, v = start_of(m, MECHANISMS["arm7.toml"])
    tau = np.zeros(m.nv)
    tau[m.joint("A2").v] = -40
    motion = axode.simulate(heavier, q, v, 0.2, tau=tau, rtol=1e-12, atol=1e-13)
    at, _ = ends_of(result, m)
    assert np.allclose(at, motion.q[-1], rtol=0, atol=1e-9)
    pose = axode.poses(m, at)[m.frame_names.index("flange")]
    assert np.allclose([result[f"frame.flange.position[{k}]"][-1] for k in range(3)], pose[:3, 3], atol=1e-12)
    assert np.allclose([[result[f"frame.flange.rotation[{i},{k}]"][-1] for k in range(3)] for i in range(3)],
                       pose[:3, :3], atol=1e-12)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_stop_is_an_event_of_model_exchange(exported, version):
    m = axode.Builder("door").body(
        "door", joint={"kind": "revolute", "axis": "y", "point": [0, 0, 0], "name": "hinge", "limits": [-0.5, 0.5],
                       "stop": {"stiffness": 2e4, "damping": 0.2}},
        mass=2, com=[0.4, 0, 0], inertia=[0.01, 0.1, 0.1]).build()
    motion = axode.simulate(m, [0.2], [0], 0.6, rtol=1e-11, atol=1e-12)
    result = fmpy.simulate_fmu(exported(m, version), fmi_type="ModelExchange", stop_time=0.6, output_interval=0.005,
                               relative_tolerance=1e-9, start_values={"q.hinge": 0.2}, record_events=True)
    assert len(result["time"]) > 122  # with the times at which the door meets and leaves the stop
    assert result["q.hinge"][-1] == pytest.approx(motion.q[-1, 0], abs=1e-5)


def pendulums(**of_elbow):
    """A double pendulum, whose second joint has these keys."""
    rod = {"mass": 1.2, "inertia": [0.1, 0.1, 0.001]}
    return (axode.Builder("pendulums")
            .body("upper", joint={"kind": "revolute", "axis": "y", "point": [0, 0, 0], "name": "pin"}, com=[0, 0, -0.5], **rod)
            .body("lower", on="upper", com=[0, 0, -1.5], **rod,
                  joint={"kind": "revolute", "axis": "y", "point": [0, 0, -1], "name": "elbow", **of_elbow}))


def assert_model_exchange_moves(fmu, m, motion, start, off):
    """Compares the end of a model exchange by CVode, started at q = `start`, with that of a motion of the library."""
    assert fmpy_validation.validate_fmu(fmu) == []
    result = fmpy.simulate_fmu(fmu, fmi_type="ModelExchange", stop_time=motion.t[-1], output_interval=0.01,
                               relative_tolerance=1e-12, record_events=True,
                               start_values={f"q.{name}": x for name, x in zip(m.coordinate_names, start, strict=True)})
    at = ends_of(result, m)
    assert np.allclose(at[0], motion.q[-1], rtol=0, atol=off)
    assert np.allclose(at[1], motion.v[-1], rtol=0, atol=10 * off)
    return result


@pytest.mark.parametrize("version", VERSIONS)
def test_dry_friction_is_an_event_of_model_exchange(exported, version):
    m = pendulums(friction=2.5, damping=0.05).build()
    fmu = exported(m, version, joint_losses=True)
    assert fmpy.read_model_description(fmu).numberOfEventIndicators == 1
    start = [0.9, -0.8]
    motion = axode.simulate(m, start, [0, 0], 2, joint_losses=True, rtol=1e-12, atol=1e-13)
    result = assert_model_exchange_moves(fmu, m, motion, start, 1e-9)
    sticks = result["v.elbow"] == 0
    assert 20 < np.count_nonzero(sticks) < len(sticks) - 20


@pytest.mark.parametrize("version", VERSIONS)
def test_joints_of_a_loop_stick_together_in_model_exchange(exported, version):
    drawing = axode.load(axode.robots / "four_bar.toml").to_dict()
    for k, body in enumerate(drawing["body"]):
        body["joint"]["friction"] = 0.02 + 0.01 * k
    m = axode.Model.from_dict(drawing)
    q, v = m.initial_state()
    motion = axode.simulate(m, q, v, 2, joint_losses=True, rtol=1e-12, atol=1e-13)
    result = assert_model_exchange_moves(exported(m, version, joint_losses=True), m, motion, q, 2e-9)
    assert all(result[f"v.{name}"][-1] == 0 for name in m.velocity_names)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("restitution", [0, 0.5])
def test_a_hard_stop_of_model_exchange_is_a_play_of_axode(exported, version, restitution):
    fmu = exported(pendulums(limits=[-0.4, 0.3], stop="hard", restitution=restitution).build(), version)
    play = pendulums().coupling({"elbow": 1}, -0.05, play=0.7, restitution=restitution).build()
    motion = axode.simulate(play, [1.2, 0.1], [0, 0], 2, rtol=1e-12, atol=1e-13)
    assert len(motion.play_events) >= 2
    assert_model_exchange_moves(fmu, play, motion, [1.2, 0.1], 1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_ends_of_a_play_are_events_of_model_exchange(exported, version):
    m = pendulums().coupling({"pin": 1, "elbow": -2}, play=0.3, restitution=0.3).build()
    motion = axode.simulate(m, [0.5, 0.3], [0, 0], 1, rtol=1e-12, atol=1e-13)
    assert len(motion.play_events) >= 2
    assert_model_exchange_moves(exported(m, version), m, motion, [0.5, 0.3], 1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_limits_and_inputs_of_a_motor_are_events(exported, version):
    m = axode.Builder("wheel", gravity=[0, 0, 0]).body(
        "wheel", joint={"kind": "revolute", "axis": "z", "point": [0, 0, 0], "name": "axle"}, mass=1, com=[0, 0, 0],
        inertia=[0.01, 0.01, 0.02]).drive(
        "dc_motor", "axle", name="motor", resistance=1, inductance=0.01, torque_constant=0.1, current_limit=5,
        input={"kind": "steps", "times": [0, 0.5], "values": [12, -8]}).build()
    assert fmpy_validation.validate_fmu(exported(m, version)) == []
    motion = axode.simulate(m, [0], [0], 1, rtol=1e-11, atol=1e-12)
    for kind, tolerance, off in [("CoSimulation", 1e-12, 1e-9), ("ModelExchange", 1e-10, 1e-6)]:
        result = fmpy.simulate_fmu(exported(m, version), fmi_type=kind, stop_time=1, output_interval=0.01,
                                   relative_tolerance=tolerance, output=["q.axle", "drive.motor.current"])
        assert result["q.axle"][-1] == pytest.approx(motion.q[-1, 0], abs=off)
        assert result["drive.motor.current"][-1] == pytest.approx(motion.x[-1, 0], abs=off)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_saved_state_continues_as_it_was(exported, version):
    m = axode.load(axode.robots / "four_bar.toml")
    driven = Driven(exported(m, version), "CoSimulation")
    driven.fmu.exitInitializationMode()

    def step(t):
        driven.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=0.1)
        return driven.value("q.crank_joint")

    step(0)
    state = driven.fmu.getFMUState()
    once = step(0.1)
    driven.fmu.setFMUState(state)
    assert step(0.1) == once
    driven.fmu.freeFMUState(state)
    driven.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_faults_of_a_master_are_named_in_its_log(exported, version, capfd):
    fmu = exported(axode.load(axode.robots / "arm7.toml"), version)
    with pytest.raises(Exception):
        Driven(fmu, token="{0}")
    assert 'the master shows the token "{0}", and the FMU has' in capfd.readouterr().out
    driven = Driven(fmu)
    driven.put(**{"body.link 1.mass": -1.0})
    with pytest.raises(Exception):
        driven.fmu.exitInitializationMode()
    assert "mass is -1 kg" in capfd.readouterr().out
    driven.put(**{"body.link 1.mass": 1.0})
    driven.start()
    with pytest.raises(Exception):
        driven.put(**{"body.link 1.mass": 2.0})
    assert 'variable "body.link 1.mass" can be set before the end of the initialization only' in capfd.readouterr().out
    driven.close()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_co_simulation_touches_as_axode_does(exported, version):
    m = axode.load(axode.robots / "quadruped.toml")
    fmu = exported(m, version, kinds=["co_simulation"])
    assert fmpy_validation.validate_fmu(fmu) == []
    q, v = m.initial_state()
    motion = axode.simulate(m, q, v, 0.1, method="contact", step=1e-3)
    result = fmpy.simulate_fmu(fmu, fmi_type="CoSimulation", stop_time=0.1, output_interval=0.01)
    at = ends_of(result, m)
    assert np.allclose(at[0], motion.q[-1], rtol=0, atol=1e-6)
    assert np.allclose(at[1], motion.v[-1], rtol=0, atol=1e-5)


def test_what_an_fmu_does_not_count_is_refused(tmp_path):
    quadruped = axode.load(axode.robots / "quadruped.toml")
    with pytest.raises(ValueError, match='for model exchange does not count contact, and model "quadruped" has shapes that'):
        axode.fmi.export(quadruped, tmp_path / "a.fmu")
    arm = axode.load(axode.robots / "arm7.toml")
    with pytest.raises(KeyError, match='has no frame "hand"'):
        axode.fmi.export(arm, tmp_path / "a.fmu", frames=["hand"])
    with pytest.raises(ValueError, match="version is '1.0'; expected one of '2.0', '3.0'"):
        axode.fmi.export(arm, tmp_path / "a.fmu", version="1.0")
    with pytest.raises(ValueError, match="kinds is 'both'; expected one of"):
        axode.fmi.export(arm, tmp_path / "a.fmu", kinds=["both"])
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    m = axode.load(axode.robots / "double_pendulum.toml")
    file = tmp_path / "no" / "pendulum.fmu"
    with pytest.raises(FileNotFoundError, match=re.escape(f"{file} cannot be written: there is no folder {file.parent}")):
        axode.fmi.export(m, file)


def test_the_command_writes_the_same_files(tmp_path, exported):
    file = tmp_path / "arm.fmu"
    done = subprocess.run([COMMAND, "fmu", axode.robots / "arm7.toml", "--output", file, "--frame", "flange"],
                          capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    fmu = exported(axode.load(axode.robots / "arm7.toml"), "3.0", frames=("flange",))
    with zipfile.ZipFile(file) as of_command, zipfile.ZipFile(fmu) as of_python:
        assert of_command.namelist() == of_python.namelist()
        for name in of_command.namelist():
            assert of_command.read(name) == of_python.read(name), name
