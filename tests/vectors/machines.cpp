#include <gtest/gtest.h>

#include "axode/constraints.hpp"
#include "axode/integration.hpp"
#include "axode/integration/methods.hpp"
#include "axode/integration/prescribed/kinematic_motion.hpp"
#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "tests/vectors/machine_files.hpp"

/// Machines whose crank, or the length of whose cylinder, is prescribed, against closed forms.
namespace axode::test {
namespace {

std::vector<double> all_of(const Json& x) { return x.is_array() ? numbers(x) : std::vector{number(x)}; }

/// A machine that follows the motion of its file, and what the file knows of it.
class PrescribedMachine : public MachineOfFile {
 protected:
  Model model() const {
    Description d = drawing();
    d.motions.push_back(motion());
    return ModelBuilder(std::move(d)).build();
  }
  MotionDescription motion() const {
    const Json& given = file_.at("motion");
    MotionDescription it;
    it.of = given.at(given.contains("joint") ? "joint" : "loop").text();
    if (given.at("kind").text() == "harmonic") {
      it.kind = MotionDescription::Kind::harmonic;
      it.offset = number(given.at("offset")), it.amplitude = number(given.at("amplitude"));
      it.frequency = number(given.at("frequency")), it.phase = number(given.at("phase"));
    } else {
      it.kind = MotionDescription::Kind::polynomial;
      it.coefficients = numbers(given.at("coefficients"));
    }
    return it;
  }
  const Json& rows() const { return file_.at("rows"); }
  /// The forces of the load, nv.
  std::vector<double> load(const Model& model) const {
    std::vector<double> tau(static_cast<std::size_t>(model.nv()));
    if (file_.contains("load")) {
      const Joint& joint = model.joint(model.joint_index(file_.at("load").at("joint").text()));
      tau[static_cast<std::size_t>(joint.iv)] = number(file_.at("load").at("force"));
    }
    return tau;
  }
  /// The largest entry of each column of q, v, a or jerk, at least a thousandth of the largest one of all.
  std::vector<double> sizes(const char* key) const {
    std::vector<double> largest;
    for (const Json& row : rows()) {
      const std::vector<double> x = all_of(row.at(key));
      largest.resize(x.size());
      for (std::size_t c = 0; c < x.size(); ++c) largest[c] = std::max(largest[c], std::abs(x[c]));
    }
    const double least = 1e-3 * *std::ranges::max_element(largest);
    for (double& x : largest) x = std::max(x, least);
    return largest;
  }
  void expect_near(std::span<const double> found, std::size_t row, const char* key, double tolerance) const {
    const std::vector<double> expected = all_of(rows().at(row).at(key)), size = sizes(key);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t c = 0; c < found.size(); ++c)
      EXPECT_NEAR(found[c], expected[c], tolerance * size[c]) << key << "[" << c << "] of row " << row;
  }
  double time(std::size_t row) const { return number(rows().at(row).at("t")); }
};
INSTANTIATE_TEST_SUITE_P(Vectors, PrescribedMachine,
                         testing::ValuesIn(machines_of({"slider_crank", "rod_boom"})),
                         [](const auto& file) { return file.param; });

TEST_P(PrescribedMachine, MovesAsItsClosedFormWithoutDynamics) {
  const Model machine = model();
  std::vector<double> times;
  for (std::size_t k = 0; k < rows().size(); ++k) times.push_back(time(k));
  const KinematicMotion found = kinematic_motion(machine, all_of(rows().at(0).at("q")), times);
  EXPECT_TRUE(found.complete) << found.stop_reason;
  ASSERT_EQ(found.t, times);
  const auto nq = static_cast<std::size_t>(machine.nq());
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto row = [&](const std::vector<double>& all) { return std::span(all).subspan(k * nq, nq); };
    expect_near(row(found.q), k, "q", 1e-12);
    expect_near(row(found.v), k, "v", 1e-12);
    expect_near(row(found.a), k, "a", 1e-12);
    expect_near(row(found.jerk), k, "jerk", 1e-11);
  }
}

TEST_P(PrescribedMachine, TakesTheForceOfItsClosedForm) {
  const Model machine = model();
  const std::vector<double> tau = load(machine);
  const char* const key = rows().at(0).contains("multiplier") ? "multiplier" : "drive_torque";
  double size = 0;
  for (const Json& row : rows()) size = std::max(size, std::abs(number(row.at(key))));
  for (std::size_t k = 0; k < rows().size(); ++k) {
    const Json& row = rows().at(k);
    const DynamicsAtTime found =
        forward_dynamics_at(machine, time(k), all_of(row.at("q")), all_of(row.at("v")), tau);
    ASSERT_TRUE(found.solvability.ok());
    expect_near(found.a, k, "a", 1e-11);
    ASSERT_EQ(found.motion_forces.size(), 1U);
    EXPECT_NEAR(found.motion_forces[0], number(row.at(key)), 1e-11 * size) << "row " << k;
    if (!row.contains("power")) continue;
    const double rate = MotionFunction(machine.motions()[0])(time(k)).ds;
    EXPECT_NEAR(found.motion_forces[0] * rate, number(row.at("power")), 1e-11 * size);
  }
}

TEST_P(PrescribedMachine, MovesAsItsClosedFormWithDynamics) {
  const Model machine = model();
  const AssemblyResult start = assemble(machine, all_of(rows().at(0).at("q")), all_of(rows().at(0).at("v")));
  ASSERT_EQ(start.status, AssemblyStatus::closed) << to_string(machine, start);
  SimulationOptions options;
  options.drive = [tau = load(machine)](double, std::span<const double>, std::span<const double>,
                                        std::span<double> out) { std::ranges::copy(tau, out.begin()); };
  const double end = time(rows().size() - 1);
  std::vector<double> q(start.q), v(start.v);
  int tested = 0;
  for (const auto& [coordinates, kind] : coordinate_kinds)
    for (const auto& [name, method] : methods) {
      if (name == "contact_adaptive") continue;  // its long steps do not end at the times of the file
      SCOPED_TRACE(std::string(name) + " in coordinates " + std::string(coordinates));
      options.coordinates = kind;
      Trajectory motion(machine);
      try {
        motion = method.simulate({.model = machine,
                                  .q = start.q,
                                  .v = start.v,
                                  .until = end,
                                  .step = method.adapts ? 0 : end / 200,
                                  .tolerances = {.relative = 1e-12, .absolute = 1e-13},
                                  .spectral_radius = 0.8,
                                  .options = options});
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string_view(error.what()).find("oordinates"), std::string_view::npos) << error.what();
        continue;
      }
      ++tested;
      EXPECT_TRUE(motion.complete) << motion.stop_reason;
      for (std::size_t k = 0; k < rows().size(); ++k) {
        motion.at(time(k), q, v);
        expect_near(q, k, "q", 1e-9);
        if (name != "generalized_alpha_index3") expect_near(v, k, "v", 1e-9);
      }
    }
  EXPECT_EQ(tested, 37);
}

}  // namespace
}  // namespace axode::test
