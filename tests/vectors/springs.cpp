#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axode/constraints/equilibrium.hpp"
#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/integration.hpp"
#include "axode/io.hpp"
#include "axode/model/building/builder.hpp"
#include "axode/model/configuration.hpp"
#include "tests/vectors/machine_files.hpp"

/// Gas springs, bushings and tendons against closed forms and trajectories of independent equations.
namespace axode::test {
namespace springs_of_files {
namespace {

using Numbers = std::vector<double>;

Vec3<> vector(const Json& x) { return {number(x.at(0)), number(x.at(1)), number(x.at(2))}; }
SE3<> pose(const Json& x) {
  const Json& R = x.at("rotation");
  return {transpose(SO3<>{vector(R.at(0)), vector(R.at(1)), vector(R.at(2))}), vector(x.at("position"))};
}
SixBySix matrix(const Json& x) {
  SixBySix A{};
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t l = 0; l < 6; ++l) A[k][l] = number(x.at(k).at(l));
  return A;
}
double largest(const Numbers& x) {
  double most = 0;
  for (const double x_k : x) most = std::max(most, std::abs(x_k));
  return most;
}
void expect_near(const Numbers& found, const Numbers& expected, double tolerance, const std::string& what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  for (std::size_t k = 0; k < found.size(); ++k)
    EXPECT_NEAR(found[k], expected[k], tolerance * (largest(expected) + 1e-300)) << what << "[" << k << "]";
}

/// Expects that a motion from the first row of the file passes through all rows. A column is measured by
/// its largest entry. The forces of one-sided springs have kinks, at which a step loses digits; hence the
/// tolerances.
void expect_motion(const Model& model, const Json& file) {
  const auto nq = static_cast<std::size_t>(model.nq());
  const auto row = [&](std::size_t k) { return numbers(file.at("values").at(k)); };
  const Numbers start = row(0), times = numbers(file.at("times"));
  const Trajectory motion =
      simulate(model, Numbers(start.begin(), start.begin() + static_cast<std::ptrdiff_t>(nq)),
               Numbers(start.begin() + static_cast<std::ptrdiff_t>(nq), start.end()), times.back(),
               {.relative = 1e-14, .absolute = 1e-14});
  ASSERT_TRUE(motion.complete) << motion.stop_reason;
  Numbers size(2 * nq), q(nq), v(nq);
  for (std::size_t k = 0; k < times.size(); ++k)
    for (std::size_t c = 0; c < 2 * nq; ++c) size[c] = std::max(size[c], std::abs(row(k)[c]));
  for (std::size_t k = 0; k < times.size(); ++k) {
    motion.at(times[k], q, v);
    q.insert(q.end(), v.begin(), v.end());
    for (std::size_t c = 0; c < 2 * nq; ++c)
      EXPECT_NEAR(q[c], row(k)[c], 1e-9 * size[c]) << "column " << c << " at " << times[k] << " s";
    q.resize(nq);
  }
}

// -------------------------------------------------------------------------------------------- gas springs

class GasSpring : public MachineOfFile {
 protected:
  Model model() const {
    const Json& given = file_.at("spring");
    Description d = drawing();
    SpringDescription it{.name = "strut",
                         .between = {given.at("between").at(0).text(), given.at("between").at(1).text()},
                         .points = {vector(given.at("points").at(0)), vector(given.at("points").at(1))},
                         .in = GivenIn::construction_frame,
                         .rest = number(given.at("length"))};
    it.curve = GasCurve{number(given.at("area")), number(given.at("pressure")), number(given.at("volume")),
                        number(given.at("exponent")), number(given.at("ambient"))};
    d.springs.push_back(it);
    return ModelBuilder(std::move(d)).build();
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, GasSpring, testing::ValuesIn(machines_of({"gas_spring"})),
                         [](const auto& file) { return file.param; });

TEST_P(GasSpring, HasForceEnergyAndStiffnessOfTheTable) {
  const Model machine = model();
  const ForceLaw& law = machine.springs().elements.at(0).law;
  for (const Json& row : file_.at("table")) {
    const double x = number(row.at("length"));
    const Tension<double> F = tension(law, x, 0.0);
    EXPECT_NEAR(-F.f, number(row.at("force")), 1e-12 * std::abs(F.f));
    EXPECT_NEAR(-F.by_x, number(row.at("stiffness")), 1e-12 * std::abs(F.by_x));
    EXPECT_NEAR(stored_energy(law, x), number(row.at("energy")),
                1e-12 * std::max(1.0, std::abs(number(row.at("energy")))));
  }
}

TEST_P(GasSpring, RestsAndSwingsAsInTheFile) {
  const Model machine = model();
  const Json& expected = file_.at("equilibrium");
  const EquilibriumResult rest = equilibrium(machine, Numbers{number(expected.at("q"))});
  ASSERT_EQ(rest.status, EquilibriumStatus::solved);
  EXPECT_NEAR(rest.q[0], number(expected.at("q")), 1e-12);
  Workspace<> workspace(machine);
  Numbers A(4), B(2);
  ASSERT_TRUE(linearize<double>(machine, workspace, rest.q, Numbers{0}, Numbers{0}, {A, B}).ok());
  const double omega = 2 * 3.14159265358979323846 * number(expected.at("frequency"));
  EXPECT_NEAR(-A[2], omega * omega, 1e-11 * omega * omega);
  Numbers M(1);
  mass_matrix(machine, workspace, std::span<const double>(rest.q), std::span(M));
  EXPECT_NEAR(-A[2] * M[0], number(expected.at("generalised_stiffness")),
              1e-11 * number(expected.at("generalised_stiffness")));
}

TEST_P(GasSpring, MovesAsInTheFileAndKeepsItsEnergy) {
  const Model machine = model();
  expect_motion(machine, file_);
  Workspace<> workspace(machine);
  for (std::size_t k = 0; k < file_.at("times").size(); ++k) {
    const Numbers row = numbers(file_.at("values").at(k)), q{row[0]}, v{row[1]};
    const double E = kinetic_energy<double>(machine, workspace, q, v) +
                     potential_energy<double>(machine, workspace, q) +
                     elastic_energy<double>(machine, workspace, q);
    EXPECT_NEAR(E, number(file_.at("energy").at(k)), 1e-11 * std::abs(number(file_.at("energy").at(0))));
  }
}

// ---------------------------------------------------------------------------------------------- bushings

class BushingOfFile : public MachineOfFile {
 protected:
  /// Two free bodies with the bushing between their frames.
  Model model() const {
    Description d{.name = GetParam(), .gravity = {0, 0, 0}};
    for (const char* const name : {"a", "b"})
      d.bodies.push_back({.name = name,
                          .joint = {.kind = JointKind::free},
                          .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}});
    SpringDescription it{.kind = SpringKind::bushing, .between = {"a", "b"}};
    it.rest_pose = pose(file_.at("rest"));
    it.K = matrix(file_.at("K"));
    it.C = matrix(file_.at("C"));
    d.springs.push_back(it);
    return ModelBuilder(std::move(d)).build();
  }
  /// The coordinates of both bodies in a state of the file, and velocities at which b moves with the relative
  /// twist and a rests.
  static Numbers coordinates(const Json& state) {
    Numbers q;
    for (const char* const key : {"C_a", "C_b"}) {
      const SE3<> C = pose(state.at(key));
      const Quaternion<> R = quaternion(C.R);
      q.insert(q.end(), {R.x, R.y, R.z, R.w, C.r.x, C.r.y, C.r.z});
    }
    return q;
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, BushingOfFile, testing::ValuesIn(machines_of({"bushing"})),
                         [](const auto& file) { return file.param; });

TEST_P(BushingOfFile, HasTheWrenchesEnergiesAndStiffnesses) {
  const Model machine = model();
  Workspace<> workspace(machine);
  for (const Json& state : file_.at("states")) {
    const Numbers q = coordinates(state), rest(12);
    Numbers tau(12), moving(12), v(12), by_q(144), by_v(144);
    spring_forces<double>(machine, workspace, q, rest, tau);
    const Numbers on_b = numbers(state.at("wrench_on_b"));
    expect_near({tau.begin(), tau.begin() + 6}, numbers(state.at("wrench_on_a")), 1e-12, "wrench on a");
    expect_near({tau.begin() + 6, tau.end()}, on_b, 1e-12, "wrench on b");
    EXPECT_NEAR(elastic_energy<double>(machine, workspace, q), number(state.at("energy")),
                1e-12 * number(state.at("energy")));
    std::ranges::copy(numbers(state.at("relative_twist_in_b")), v.begin() + 6);
    spring_forces<double>(machine, workspace, q, v, moving);
    Numbers damped(6);
    double lost = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      damped[k] = moving[6 + k] - tau[6 + k];
      lost -= damped[k] * v[6 + k];
    }
    expect_near(damped, numbers(state.at("damping_wrench_on_b")), 1e-12, "damping");
    EXPECT_NEAR(lost, number(state.at("power_lost")), 1e-11 * number(state.at("power_lost")));
    spring_force_derivatives<double>(machine, workspace, q, rest, {by_q, by_v});
    Numbers stiffness;
    for (std::size_t k = 6; k < 12; ++k)
      for (std::size_t l = 6; l < 12; ++l) stiffness.push_back(-by_q[12 * k + l]);
    expect_near(stiffness, numbers(state.at("stiffness")), 1e-12, "stiffness");
    // The part of the stiffness that is not symmetric is that of the wrench, -ad_X^T W for X = e_l (D16.13).
    const Vec3<> m{on_b[0], on_b[1], on_b[2]}, f{on_b[3], on_b[4], on_b[5]};
    for (std::size_t l = 0; l < 6; ++l) {
      Vec3<> w, u;
      (l < 3 ? w : u) = {l % 3 == 0 ? 1.0 : 0, l % 3 == 1 ? 1.0 : 0, l % 3 == 2 ? 1.0 : 0};
      const Vec3<> moment = cross(w, m) + cross(u, f), force = cross(w, f);
      const Numbers hat{moment.x, moment.y, moment.z, force.x, force.y, force.z};
      for (std::size_t k = 0; k < 6; ++k)
        EXPECT_NEAR(stiffness[6 * k + l] - stiffness[6 * l + k], hat[k], 1e-12 * largest(stiffness));
    }
  }
}

// ----------------------------------------------------------------------------------------------- tendons

class Tendon : public MachineOfFile {
 protected:
  Model model() const {
    const Json& given = file_.at("tendon");
    SpringDescription it{.name = "tendon", .kind = SpringKind::tendon, .in = GivenIn::construction_frame};
    it.stiffness = number(given.at("stiffness"));
    it.rest = number(given.at("rest"));
    it.acts = Acts::in_tension;
    for (const Json& point : given.at("points"))
      it.path.push_back({point.at("on").text(), vector(point.at("point"))});
    Description d = drawing();
    d.springs.push_back(it);
    it.name = "of constant force";
    it.curve = PolynomialCurve{{1}};
    it.rest = 0;
    it.acts = Acts::both_ways;
    d.springs.push_back(it);
    return ModelBuilder(std::move(d)).build();
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, Tendon, testing::ValuesIn(machines_of({"tendon"})),
                         [](const auto& file) { return file.param; });

TEST_P(Tendon, HasLengthsMomentArmsAndTheirDerivatives) {
  Description d = model().description();
  d.springs.erase(d.springs.begin());
  const Model machine = ModelBuilder(std::move(d)).build();
  Workspace<> workspace(machine);
  const auto nv = static_cast<std::size_t>(machine.nv());
  for (const Json& state : file_.at("states")) {
    const Numbers q = numbers(state.at("q"));
    Numbers gradient(nv), by_q(nv * nv), by_v(nv * nv);
    EXPECT_NEAR(spring_coordinate<double>(machine, workspace, 0, q, gradient), number(state.at("length")),
                1e-14);
    expect_near(gradient, numbers(state.at("gradient")), 1e-12, "gradient");
    spring_force_derivatives<double>(machine, workspace, q, Numbers(nv), {by_q, by_v});
    for (double& x : by_q) x = -x;
    expect_near(by_q, numbers(state.at("hessian")), 1e-12, "hessian");
  }
}

TEST_P(Tendon, MovesAsInTheFileTautAndSlack) {
  Description d = model().description();
  d.springs.pop_back();
  expect_motion(ModelBuilder(std::move(d)).build(), file_);
}

}  // namespace
}  // namespace springs_of_files
}  // namespace axode::test
