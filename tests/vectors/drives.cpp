#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "axode/constraints.hpp"
#include "axode/drives.hpp"
#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/integration.hpp"
#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/vectors/machine_files.hpp"

/// Machines with drives against reference trajectories and closed forms.
namespace axode::test {
namespace {

using Parameters = std::vector<std::pair<std::string, double>>;

class DrivenMachine : public MachineOfFile {
 protected:
  const Json& drive() const { return file_.at("drive"); }
  double of_drive(const char* key) const { return number(drive().at(key)); }
  /// Parameters of a drive from the keys of the file.
  Parameters parameters(const std::vector<std::pair<const char*, const char*>>& keys) const {
    Parameters all;
    for (const auto& [ours, theirs] : keys) all.emplace_back(ours, of_drive(theirs));
    return all;
  }
  static Model with(Description d, DriveDescription drive) {
    d.drives = {std::move(drive)};
    return ModelBuilder(std::move(d)).build();
  }
  DriveDescription on_joint(DriveKind kind, Parameters parameters, DriveInput input) const {
    return {.kind = kind,
            .joints = {{drive().at("joint").text(), 1.0}},
            .parameters = std::move(parameters),
            .input = std::move(input)};
  }
  DriveDescription dc_motor() const {
    return on_joint(DriveKind::dc_motor,
                    parameters({{"resistance", "R"},
                                {"inductance", "L"},
                                {"torque_constant", "k"},
                                {"viscous", "viscous"},
                                {"ratio", "ratio"}}),
                    {.values = {of_drive("voltage")}});
  }
  DriveDescription pid(bool conditional) const {
    DriveDescription it = on_joint(DriveKind::pid,
                                   parameters({{"kp", "Kp"},
                                               {"ki", "Ki"},
                                               {"kd", "Kd"},
                                               {"filter_time", "filter"},
                                               {"tracking_time", "tracking"},
                                               {"limit", "limit"}}),
                                   {.values = {of_drive("reference")}});
    it.conditional = conditional;
    return it;
  }
  DriveDescription series_elastic(DriveInput input) const {
    return on_joint(DriveKind::series_elastic,
                    parameters({{"resistance", "R"},
                                {"inductance", "L"},
                                {"torque_constant", "k"},
                                {"viscous", "viscous"},
                                {"rotor_inertia", "rotor_inertia"},
                                {"ratio", "ratio"},
                                {"stiffness", "stiffness"},
                                {"damping", "damping"}}),
                    std::move(input));
  }
  DriveDescription lugre() const {
    DriveDescription it{.kind = DriveKind::lugre,
                        .parameters = parameters({{"bristle_stiffness", "sigma0"},
                                                  {"bristle_damping", "sigma1"},
                                                  {"viscous", "sigma2"},
                                                  {"coulomb", "coulomb"},
                                                  {"stiction", "stiction"},
                                                  {"stribeck_velocity", "stribeck_velocity"}})};
    const Json& port = drive().at("port");
    for (const std::string& joint : port.keys()) it.joints.emplace_back(joint, number(port.at(joint)));
    return it;
  }
  DriveDescription cylinder(DriveInput input) const {
    DriveDescription it{.kind = DriveKind::hydraulic_cylinder,
                        .parameters = parameters({{"closed_length", "length_at_zero_stroke"},
                                                  {"stroke", "stroke"},
                                                  {"area_a", "area_A"},
                                                  {"area_b", "area_B"},
                                                  {"dead_volume_a", "dead_volume_A"},
                                                  {"dead_volume_b", "dead_volume_B"},
                                                  {"bulk_modulus", "bulk_modulus"},
                                                  {"internal_leakage", "leak_internal"},
                                                  {"external_leakage", "leak_external"},
                                                  {"valve", "valve"},
                                                  {"smooth_pressure", "smooth_pressure"},
                                                  {"supply_pressure", "supply"},
                                                  {"tank_pressure", "tank"},
                                                  {"valve_time", "valve_time"},
                                                  {"viscous", "viscous"}}),
                        .input = std::move(input)};
    it.parameters.emplace_back("cushion_stiffness", number(drive().at("cushion").at("stiffness")));
    it.parameters.emplace_back("cushion_damping", number(drive().at("cushion").at("damping")));
    it.line = DriveDescription::Line{.in = GivenIn::construction_frame};
    for (std::size_t k = 0; k < 2; ++k) {
      it.line->between[k] = drive().at("between").at(k).text();
      const std::vector<double> point = numbers(drive().at("points").at(k));
      it.line->points[k] = {point[0], point[1], point[2]};
    }
    return it;
  }

  static Trajectory run(const Model& model, double until, double q = 0, double v = 0) {
    std::vector<double> q_0(static_cast<std::size_t>(model.nq())), v_0(q_0.size());
    if (!q_0.empty()) q_0[0] = q;
    if (!v_0.empty()) v_0[0] = v;
    if (!model.motions().empty()) v_0 = assemble(model, q_0, v_0).v;
    const Trajectory motion = simulate(model, q_0, v_0, until, {.relative = 1e-12, .absolute = 1e-13});
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    return motion;
  }
  /// The first coordinate and velocity at a time, and all states of the drives.
  struct State {
    std::vector<double> q, v, x;
  };
  static State state(const Trajectory& motion, double t) {
    const Model& model = motion.model();
    State at{std::vector<double>(static_cast<std::size_t>(model.nq())),
             std::vector<double>(static_cast<std::size_t>(model.nv())), std::vector<double>(motion.nx())};
    motion.at(t, at.q, at.v);
    motion.drive_states_at(t, at.x);
    return at;
  }
  /// The integral of a power along a motion, from step end to step end until a time at which f is called.
  template <class Power>
  static std::vector<double> integrals(const Trajectory& motion, const std::vector<double>& times,
                                       const Power& power) {
    std::vector<double> ends(motion.t().begin(), motion.t().end());
    ends.insert(ends.end(), times.begin(), times.end());
    std::ranges::sort(ends);
    std::vector<double> found;
    double sum = 0;
    std::size_t next = 0;
    for (std::size_t k = 0; k < ends.size(); ++k) {
      if (k > 0 && ends[k] > ends[k - 1]) {
        const double middle = (ends[k] + ends[k - 1]) / 2, h = ends[k] - ends[k - 1];
        const double x = std::sqrt(0.15) * h;
        sum += h / 18 *
               (5 * power(middle - x, state(motion, middle - x)) + 8 * power(middle, state(motion, middle)) +
                5 * power(middle + x, state(motion, middle + x)));
      }
      while (next < times.size() && ends[k] == times[next]) {
        found.push_back(sum);
        ++next;
      }
    }
    return found;
  }
  /// Whether a step ends at a time.
  static void expect_step_end(const Trajectory& motion, double t) {
    double nearest = 1;
    for (const double end : motion.t()) nearest = std::min(nearest, std::abs(end - t));
    EXPECT_LT(nearest, 1e-10) << "no step ends at " << t;
  }
  static void expect_matrix(const Eigen::MatrixXd& found, const Json& expected, double tolerance) {
    for (Eigen::Index i = 0; i < found.rows(); ++i) {
      const std::vector<double> row = numbers(expected.at(static_cast<std::size_t>(i)));
      for (Eigen::Index j = 0; j < found.cols(); ++j) {
        const double x = row[static_cast<std::size_t>(j)];
        EXPECT_NEAR(found(i, j), x, tolerance * std::max(1.0, std::abs(x))) << i << ", " << j;
      }
    }
  }
  /// Compares the rows of a table with values(t), column by column.
  template <class Values>
  static void expect_table(const Json& table, std::vector<double> sizes, const Values& values) {
    const std::vector<double> times = numbers(table.at("times"));
    std::vector<std::vector<double>> expected;
    for (const Json& row : table.at("values")) expected.push_back(numbers(row));
    if (sizes.empty()) {
      sizes.resize(expected[0].size());
      for (const auto& row : expected)
        for (std::size_t c = 0; c < row.size(); ++c) sizes[c] = std::max(sizes[c], std::abs(row[c]));
    }
    for (std::size_t k = 0; k < times.size(); ++k) {
      const std::vector<double> found = values(k, times[k]);
      ASSERT_EQ(found.size(), expected[k].size());
      for (std::size_t c = 0; c < found.size(); ++c)
        EXPECT_NEAR(found[c], expected[k][c], 1e-9 * sizes[c])
            << table.at("columns").at(c).text() << " at " << times[k] << " s";
    }
  }
};
class DrivenByMotor : public DrivenMachine {};
INSTANTIATE_TEST_SUITE_P(Vectors, DrivenByMotor, testing::ValuesIn(machines_of({"dc_motor"})),
                         [](const auto& file) { return file.param; });
class DrivenByController : public DrivenMachine {};
INSTANTIATE_TEST_SUITE_P(Vectors, DrivenByController, testing::ValuesIn(machines_of({"pid"})),
                         [](const auto& file) { return file.param; });
class DrivenBySeriesElasticity : public DrivenMachine {};
INSTANTIATE_TEST_SUITE_P(Vectors, DrivenBySeriesElasticity,
                         testing::ValuesIn(machines_of({"series_elastic"})),
                         [](const auto& file) { return file.param; });
class BristleFriction : public DrivenMachine {};
INSTANTIATE_TEST_SUITE_P(Vectors, BristleFriction, testing::ValuesIn(machines_of({"lugre"})),
                         [](const auto& file) { return file.param; });
class DrivenByCylinder : public DrivenMachine {};
INSTANTIATE_TEST_SUITE_P(Vectors, DrivenByCylinder, testing::ValuesIn(machines_of({"hydraulic_boom"})),
                         [](const auto& file) { return file.param; });

TEST_P(DrivenByMotor, MotorRunsUpAsItsClosedForm) {
  const double N = of_drive("ratio");
  for (const char* key : {"unlimited", "limited"}) {
    const Json& known = file_.at(key);
    DriveDescription motor = dc_motor();
    if (known.contains("current_limit"))
      motor.parameters.emplace_back("current_limit", number(known.at("current_limit")));
    const Json& rows = known.at("rows");
    const Trajectory motion = run(with(drawing(), motor), number(rows.at(rows.size() - 1).at("t")));
    for (const Json& row : rows) {
      const double t = number(row.at("t"));
      const State at = state(motion, t);
      const double current = number(row.at("current")), speed = number(row.at("motor_speed"));
      EXPECT_NEAR(at.x[0], current, 1e-9 * 10) << key << " at " << t;
      EXPECT_NEAR(N * at.v[0], speed, 1e-9 * number(file_.at("steady").at("motor_speed"))) << key;
      EXPECT_NEAR(at.q[0], number(row.at("load_angle")), 1e-9 * 10) << key;
    }
    if (known.contains("events"))
      for (const Json& t : known.at("events")) expect_step_end(motion, number(t));
  }
}

TEST_P(DrivenByMotor, MotorWarms) {
  const Json& known = file_.at("thermal");
  DriveDescription motor = dc_motor();
  for (const auto& [ours, theirs] : {std::pair{"heat_capacity", "C"},
                                     {"thermal_resistance", "R_th"},
                                     {"temperature_coefficient", "alpha"},
                                     {"ambient_temperature", "ambient"},
                                     {"reference_temperature", "R_at"}})
    motor.parameters.emplace_back(ours, number(known.at(theirs)));
  const Model model = with(drawing(), motor);
  const std::vector<double> times = numbers(known.at("times"));
  const Trajectory motion = run(model, times.back());
  DriveSystem drives(model);
  drives.set_state(0, motion.q(0), motion.v(0), motion.x(0));
  const auto energies = [&](double DriveEnergy::*part) {
    return integrals(motion, times,
                     [&](double t, const State& at) { return drives.energy(t, at.q, at.v, at.x).*part; });
  };
  const std::vector<double> supplied = energies(&DriveEnergy::supplied), lost = energies(&DriveEnergy::lost);
  expect_table(known, {}, [&](std::size_t k, double t) {
    const State at = state(motion, t);
    return std::vector{at.x[0], of_drive("ratio") * at.v[0], at.x[1], at.q[0], supplied[k], lost[k]};
  });
}

TEST_P(DrivenByController, ControllerSaturatesAndRecovers) {
  for (const char* key : {"back_calculation", "conditional"}) {
    const Json& known = file_.at(key);
    Description d = drawing();
    const Model model = with(std::move(d), pid(std::string(key) == "conditional"));
    SimulationOptions options;
    options.joint_losses = true;
    const Trajectory motion = simulate(model, {{0.0}}, {{0.0}}, numbers(known.at("times")).back(),
                                       {.relative = 1e-12, .absolute = 1e-13}, options);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    expect_table(known, {}, [&](std::size_t, double t) {
      const State at = state(motion, t);
      return std::vector{at.q[0], at.v[0], at.x[0], at.x[1]};
    });
    for (const Json& event : known.at("events"))
      if (std::string(key) == "conditional" || number(event.at("saturated")) != 0)
        expect_step_end(motion, number(event.at("t")));
  }
}

TEST_P(DrivenBySeriesElasticity, SeriesElasticJointRestsAndSwings) {
  const Json& rest = file_.at("equilibrium");
  const Model still = with(drawing(), series_elastic({.values = {number(rest.at("voltage"))}}));
  DriveSystem drives(still);
  const std::vector<double> guess{number(rest.at("q")) + 0.1, 0, number(rest.at("rotor_angle")) + 2, 0};
  const DriveEquilibrium found =
      equilibrium_with_drives(still, drives, 0, std::span(guess).first(1), std::span(guess).last(3));
  EXPECT_TRUE(found.found) << found.residual;
  EXPECT_NEAR(found.q[0], number(rest.at("q")), 1e-12);
  EXPECT_NEAR(found.x[0], number(rest.at("current")), 1e-12);
  EXPECT_NEAR(found.x[1], number(rest.at("rotor_angle")), 1e-10);
  const DriveLinearization linear = linearize_with_drives(still, drives, 0, found.q, {{0.0}}, found.x);
  expect_matrix(linear.A, rest.at("A"), 1e-11);
  const std::vector<double> B = numbers(rest.at("B"));
  for (Eigen::Index k = 0; k < 5; ++k)
    EXPECT_NEAR(linear.B(k, 0), B[static_cast<std::size_t>(k)], 1e-11 * 1200);
  const Eigen::VectorXcd poles = linear.A.eigenvalues();
  for (const Json& expected : rest.at("eigenvalues")) {
    const std::complex<double> pole(number(expected.at(0)), number(expected.at(1)));
    EXPECT_LT((poles.array() - pole).abs().minCoeff(), 1e-9 * std::abs(pole));
  }

  const Json &wave = drive().at("voltage"), &known = file_.at("trajectory");
  MotionDescription voltage{.kind = MotionDescription::Kind::harmonic};
  voltage.offset = number(wave.at("offset")), voltage.amplitude = number(wave.at("amplitude"));
  voltage.frequency = number(wave.at("frequency"));
  DriveDescription drive = series_elastic({.function = voltage});
  const std::vector<double> first = numbers(known.at("values").at(0)), times = numbers(known.at("times"));
  drive.initial = {{"current", first[0]}, {"rotor_angle", first[1]}, {"rotor_speed", first[2]}};
  const Model model = with(drawing(), drive);
  const Trajectory motion = run(model, times.back(), first[3], first[4]);
  DriveSystem system(model);
  const auto energies = [&](double DriveEnergy::*part) {
    return integrals(motion, times,
                     [&](double t, const State& at) { return system.energy(t, at.q, at.v, at.x).*part; });
  };
  const std::vector<double> supplied = energies(&DriveEnergy::supplied), lost = energies(&DriveEnergy::lost);
  expect_table(known, {}, [&](std::size_t k, double t) {
    const State at = state(motion, t);
    return std::vector{at.x[0], at.x[1], at.x[2], at.q[0], at.v[0], supplied[k], lost[k]};
  });
}

TEST_P(BristleFriction, FrictionWithBristlesSticksAndSlips) {
  Description d = drawing();
  MotionDescription belt{.of = file_.at("motion").at("joint").text()};
  belt.coefficients = numbers(file_.at("motion").at("coefficients"));
  d.motions = {belt};
  const Model model = with(std::move(d), lugre());
  DriveSystem drives(model);
  for (const Json& known : file_.at("steady_friction")) {
    const std::vector<double> q(2), v{number(known.at("w")), 0}, x{number(known.at("bristle"))};
    std::vector<double> tau(2), dx(1);
    drives.set_state(0, q, v, x);
    drives.evaluate(0, q, v, x, tau, dx);
    EXPECT_NEAR(tau[0], number(known.at("force")), 1e-12 * 5);
    EXPECT_NEAR(tau[1], -tau[0], 1e-15);
    EXPECT_NEAR(dx[0], 0, 1e-12);
  }
  const std::vector<double> times = numbers(file_.at("times"));
  const Trajectory motion = run(model, times.back());
  for (const Json& event : file_.at("events")) expect_step_end(motion, number(event.at("t")));
  const auto work = integrals(motion, times, [&](double t, const State& at) {
    std::vector<double> tau(2), dx(1);
    drives.set_state(t, at.q, at.v, at.x);
    drives.evaluate(t, at.q, at.v, at.x, tau, dx);
    return tau[0] * at.v[0];
  });
  const auto lost = integrals(motion, times, [&](double t, const State& at) {
    drives.set_state(t, at.q, at.v, at.x);
    return drives.energy(t, at.q, at.v, at.x).lost;
  });
  expect_table(file_, {1e-2, 0.1, 1e-3, 1, 1}, [&](std::size_t k, double t) {
    const State at = state(motion, t);
    return std::vector{at.q[0], at.v[0], at.x[0], work[k], lost[k]};
  });
}

TEST_P(DrivenByCylinder, CylinderLiftsAndLowersItsBoom) {
  const std::vector<double> initial = numbers(file_.at("initial"));
  DriveInput steps;
  for (const Json& step : file_.at("input")) {
    steps.times.push_back(number(step.at(0)));
    steps.values.push_back(number(step.at(1)));
  }
  DriveDescription drive = cylinder(steps);
  drive.initial = {{"pressure_a", initial[2]}, {"pressure_b", initial[3]}, {"spool", initial[4]}};
  const Model model = with(drawing(), drive);

  DrivePort port(model.springs().drive_lines[0]);
  port.update(model.tree<double>(), std::span(initial).first(1), {{1.0}});
  const Json& geometry = file_.at("geometry");
  EXPECT_NEAR(port.l(), number(geometry.at("length")), 1e-14);
  EXPECT_NEAR(port.w(), number(geometry.at("dlength_dq")), 1e-14);

  const std::vector<double> times = numbers(file_.at("times"));
  const Trajectory motion = run(model, times.back(), initial[0], initial[1]);
  expect_table(file_, {1, 1, 1e6, 1e6, 1}, [&](std::size_t, double t) {
    const State at = state(motion, t);
    return std::vector{at.q[0], at.v[0], at.x[0], at.x[1], at.x[2]};
  });
  for (const Json& event : file_.at("events")) expect_step_end(motion, number(event.at("t")));
}

TEST_P(DrivenByCylinder, CylinderWithAClosedValveIsASpring) {
  DriveDescription drive = cylinder({.values = {0}});
  for (auto& [name, value] : drive.parameters)
    if (name.ends_with("leakage")) value = 0;
  const Model model = with(drawing(), drive);
  DriveSystem drives(model);
  const std::vector<double> initial = numbers(file_.at("initial"));
  const DriveEquilibrium rest =
      equilibrium_with_drives(model, drives, 0, std::span(initial).first(1), std::span(initial).last(3));
  EXPECT_TRUE(rest.found) << rest.residual;
  const DriveLinearization linear = linearize_with_drives(model, drives, 0, rest.q, {{0.0}}, rest.x);
  const Json& known = file_.at("linearised");
  expect_matrix(linear.A.topLeftCorner(4, 4), known.at("A"), 1e-8);
  const Eigen::VectorXcd poles = linear.A.topLeftCorner(4, 4).eigenvalues();
  for (const Json& expected : known.at("eigenvalues")) {
    const std::complex<double> pole(number(expected.at(0)), number(expected.at(1)));
    EXPECT_LT((poles.array() - pole).abs().minCoeff(), 1e-8 * std::max(1.0, std::abs(pole)));
  }
}

/// A rotor on a predecessor of the joint that it drives.
class GearedRotor : public DrivenMachine {
 protected:
  const Json& rotor() const { return file_.at("rotor"); }
  double of_rotor(const char* key) const { return number(rotor().at(key)); }
  /// The machine with the rotor as a body that follows its joint, or that is fixed, with reflected inertia.
  Model machine(bool exact) const {
    Description d = drawing();
    const std::vector<double> point = numbers(rotor().at("point"));
    const Vec3<> center{point[0], point[1], point[2]};
    const std::string driven = rotor().at("joint").text(), axis = rotor().at("axis").text();
    const double axial = of_rotor("axial_inertia"), across = of_rotor("transverse_inertia"),
                 N = of_rotor("ratio");
    const Vec3<> e{axis == "x" ? 1.0 : 0, axis == "y" ? 1.0 : 0, axis == "z" ? 1.0 : 0};
    BodyDescription body{.name = "rotor", .predecessor = rotor().at("on").text()};
    body.inertia = MassProperties{.mass = of_rotor("mass"),
                                  .com = center,
                                  .Theta = {across + (axial - across) * e.x, across + (axial - across) * e.y,
                                            across + (axial - across) * e.z, 0, 0, 0},
                                  .in = GivenIn::construction_frame};
    if (exact) {
      body.joint = {.name = "rotor_joint", .kind = JointKind::revolute, .axis = e, .point = center};
      body.joint.coupling = Coupling{driven, N};
    } else {
      for (BodyDescription& each : d.bodies)
        if (each.joint.name == driven) each.joint.dof = {Dof{.armature = axial * N * N}};
    }
    d.bodies.push_back(body);
    return ModelBuilder(std::move(d)).build();
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, GearedRotor, testing::ValuesIn(machines_of({"geared_rotor"})),
                         [](const auto& file) { return file.param; });

TEST_P(GearedRotor, IsABodyThatFollowsItsJointOrReflectedInertia) {
  const std::vector<double> q = numbers(file_.at("initial").at("q")),
                            v = numbers(file_.at("initial").at("v")), tau = numbers(file_.at("tau")),
                            none(v.size());
  for (const char* key : {"exact", "reflected"}) {
    const Json& known = file_.at(key);
    const Model model = machine(std::string(key) == "exact");
    Workspace<> workspace(model);
    const Eigen::Index nv = model.nv();
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M(nv, nv);
    mass_matrix(model, workspace, q, as_span(M));
    expect_matrix(M, known.at("mass_matrix"), 1e-13);
    std::vector<double> bias(v.size()), a(v.size());
    inverse_dynamics(model, workspace, q, v, none, bias);
    ASSERT_TRUE(forward_dynamics(model, workspace, q, v, tau, a).ok());
    const std::vector<double> expected_bias = numbers(known.at("bias")),
                              expected_a = numbers(known.at("acceleration"));
    for (std::size_t c = 0; c < v.size(); ++c) {
      EXPECT_NEAR(bias[c], expected_bias[c], 1e-12 * 10) << key;
      EXPECT_NEAR(a[c], expected_a[c], 1e-12 * 10) << key;
    }
    SimulationOptions options;
    options.drive = [&](double, std::span<const double>, std::span<const double>, std::span<double> out) {
      std::ranges::copy(tau, out.begin());
    };
    const Trajectory motion = simulate(model, q, v, numbers(known.at("times")).back(),
                                       {.relative = 1e-12, .absolute = 1e-13}, options);
    EXPECT_TRUE(motion.complete) << motion.stop_reason;
    expect_table(known, {}, [&](std::size_t, double t) {
      const State at = state(motion, t);
      std::vector<double> row = at.q;
      row.insert(row.end(), at.v.begin(), at.v.end());
      return row;
    });
  }
}

}  // namespace
}  // namespace axode::test
