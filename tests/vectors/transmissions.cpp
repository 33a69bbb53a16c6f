#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/constraints.hpp"
#include "axode/integration.hpp"
#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/vectors/machine_files.hpp"

/// Belts and gears with play against closed forms.
namespace axode::test {
namespace transmissions {
namespace {

using Numbers = std::vector<double>;
using Span = std::span<const double>;

// -------------------------------------------------------------------------------------------------- belts

/// An arm that turns about the origin with a pulley at its tip, and a pulley on the ground.
class Belt : public MachineOfFile {
 protected:
  Model model() const {
    const double arm = number(file_.at("arm"));
    const Vec3<> center{number(file_.at("center_1").at(0)), number(file_.at("center_1").at(1)), 0};
    const MassProperties mass{
        .mass = 1, .com = {0.1, 0, 0}, .Theta = {1, 1, 1}, .in = GivenIn::construction_frame};
    const auto hinge = [&](const char* name, const char* on, const Vec3<>& at) {
      return BodyDescription{.name = name,
                             .predecessor = on,
                             .joint = {.kind = JointKind::revolute, .axis = {0, 0, 1}, .point = at},
                             .inertia = mass};
    };
    Description d{.name = GetParam()};
    d.bodies = {hinge("arm", "ground", {}), hinge("pulley 1", "ground", center),
                hinge("pulley 2", "arm", {arm, 0, 0})};
    LoopDescription belt{.name = "belt", .between = {"pulley 1", "pulley 2"}, .kind = LoopKind::belt};
    belt.points = {center, Vec3<>{arm, 0, 0}};
    belt.radii = {number(file_.at("sense_1")) * number(file_.at("radius_1")),
                  number(file_.at("sense_2")) * number(file_.at("radius_2"))};
    d.loops.push_back(belt);
    return ModelBuilder(std::move(d)).build();
  }
  /// The indices of the velocities of the arm and the pulleys.
  static std::array<std::size_t, 3> order(const Model& machine) {
    std::array<std::size_t, 3> all{};
    for (std::size_t k = 0; k < 3; ++k)
      all[k] = static_cast<std::size_t>(
          machine.joint(machine.joint_index(std::array{"arm_joint", "pulley 1_joint", "pulley 2_joint"}[k]))
              .iv);
    return all;
  }
  static Numbers sorted(const Model& machine, Span x) {
    Numbers out(3);
    for (std::size_t k = 0; k < 3; ++k) out[order(machine)[k]] = x[k];
    return out;
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, Belt, testing::ValuesIn(machines_of({"belt"})),
                         [](const auto& file) { return file.param; });

TEST_P(Belt, HasTheRowOfItsSpan) {
  const Model machine = model();
  LoopWorkspace<> workspace(machine);
  for (const Json& state : file_.at("states")) {
    const Numbers row = sorted(machine, numbers(state.at("row")));
    Numbers A(3), gamma(1);
    const Numbers q = sorted(machine, numbers(state.at("q")));
    loop_jacobian<double>(machine, workspace, q, A);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(A[k], row[k], 1e-14);
    const Numbers slopes = numbers(state.at("derivative_of_row"));
    Numbers v{0.7, -1.1, 0.4};
    loop_bias<double>(machine, workspace, q, v, gamma);
    double bias = 0;
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l)
        bias += slopes[3 * k + l] * v[order(machine)[k]] * v[order(machine)[l]];
    EXPECT_NEAR(gamma[0], bias, 1e-13);
  }
}

TEST_P(Belt, HasTheRowThatIsTheGradientOfItsLength) {
  const Model machine = model();
  LoopWorkspace<> workspace(machine);
  for (const Json& state : file_.at("states")) {
    const Numbers q = sorted(machine, numbers(state.at("q")));
    // Gauss' rule of two points on many parts of the straight line from the drawn configuration to q.
    constexpr int parts = 2000;
    double change = 0;
    for (int part = 0; part < parts; ++part)
      for (const double at : {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)}) {
        Numbers here(3), A(3);
        for (std::size_t k = 0; k < 3; ++k) here[k] = (part + at) / parts * q[k];
        loop_jacobian<double>(machine, workspace, here, A);
        for (std::size_t k = 0; k < 3; ++k) change += A[k] * q[k] / (2 * parts);
      }
    EXPECT_NEAR(change, number(state.at("residual")), 1e-13);
  }
}

// ----------------------------------------------------------------------------------------------- backlash

class BacklashOfFile : public MachineOfFile {
 protected:
  Model model() const {
    const Json& given = file_.at("backlash");
    Description d = drawing();
    CouplingDescription gear{.name = "gear"};
    for (const char* const joint : {"motor_joint", "load_joint"})
      gear.terms.emplace_back(joint, number(given.at("terms").at(joint)));
    gear.play = number(given.at("play"));
    gear.restitution = number(given.at("restitution"));
    d.couplings.push_back(gear);
    d.contact = ContactDescription{.threshold = number(given.at("threshold"))};
    return ModelBuilder(std::move(d)).build();
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, BacklashOfFile, testing::ValuesIn(machines_of({"backlash"})),
                         [](const auto& file) { return file.param; });

TEST_P(BacklashOfFile, MovesAndMeetsItsEndsAsInTheFile) {
  const Model machine = model();
  const Json& torque = file_.at("torque");
  const double amplitude = number(torque.at("amplitude")), omega = number(torque.at("angular_frequency")),
               load = number(torque.at("load"));
  SimulationOptions options;
  options.drive = [&](double t, Span, Span, std::span<double> tau) {
    tau[0] = amplitude * std::cos(omega * t);
    tau[1] = -load;
  };
  const Numbers start = numbers(file_.at("initial")), times = numbers(file_.at("times"));
  const Trajectory motion = simulate(machine, Numbers{start[0], start[2]}, Numbers{start[1], start[3]},
                                     times.back(), {.relative = 1e-12, .absolute = 1e-13}, options);
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Numbers size(4), q(2), v(2);
  for (std::size_t k = 0; k < times.size(); ++k)
    for (std::size_t c = 0; c < 4; ++c)
      size[c] = std::max(size[c], std::abs(number(file_.at("values").at(k).at(c))));
  for (std::size_t k = 0; k < times.size(); ++k) {
    motion.at(times[k], q, v);
    const Numbers row = numbers(file_.at("values").at(k)), found{q[0], v[0], q[1], v[1]};
    for (std::size_t c = 0; c < 4; ++c)
      EXPECT_NEAR(found[c], row[c], 1e-9 * size[c]) << "column " << c << " at " << times[k] << " s";
  }
  const Json& events = file_.at("events");
  ASSERT_EQ(motion.play_events.size(), events.size());
  for (std::size_t k = 0; k < events.size(); ++k) {
    const Trajectory::PlayEvent& found = motion.play_events[k];
    const Json& expected = events.at(k);
    EXPECT_NEAR(found.t, number(expected.at("t")), 1e-9) << "event " << k;
    EXPECT_EQ(found.side, int(number(expected.at("side")))) << "event " << k;
    EXPECT_EQ(found.impact, expected.at("kind").text() == "impact") << "event " << k;
    if (!found.impact) continue;
    EXPECT_EQ(found.stays, expected.at("then").text() == "contact") << "event " << k;
    EXPECT_NEAR(found.side * found.speed, number(expected.at("relative_speed")), 1e-9) << "event " << k;
    EXPECT_NEAR(found.side * found.impulse, number(expected.at("impulse_on_load")), 1e-9) << "event " << k;
  }
}

}  // namespace
}  // namespace transmissions
}  // namespace axode::test
