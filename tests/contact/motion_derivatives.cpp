#include <gtest/gtest.h>

#include "axode/integration/contact_sensitivities.hpp"
#include "axode/integration/simulation.hpp"
#include "axode/model/building/edited.hpp"
#include "axode/model/configuration.hpp"
#include "axode/model/inertial_parameters.hpp"
#include "tests/contact/reference_contacts.hpp"
#include "tests/support/random_tree.hpp"

/// Derivatives of motions with contact of the mechanisms of all files against differences of fourth order.
namespace axode::test {
namespace {

using Vector = Eigen::VectorXd;

/// Mechanisms of all files, with stops, dry joints and loops, along motions of some steps.
class MotionDerivatives : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == no_case) GTEST_SKIP() << missing(contact_folder(), "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, MotionDerivatives, testing::ValuesIn(contact_cases()), case_name);

/// Forces and inertias change the ends of motions as differences say, wherever both one-sided differences
/// agree.
TEST_P(MotionDerivatives, ByForcesAndInertiasAgreeWithDifferences) {
  const ReferenceContacts reference(GetParam());
  const Model model = reference.build();
  const ContactShapes shapes(model);
  const std::size_t nv = static_cast<std::size_t>(model.nv()), K = 3;
  int compared = 0, kinks = 0;
  for (const Json& state : reference.file.at("states")) {
    SCOPED_TRACE(state.at("name").text());
    const std::vector<double> q = numbers(state.at("q")), v = numbers(state.at("v")),
                              tau_1 = numbers(state.at("tau"));
    const double step = 2e-3;
    Random<double> random(7);
    std::vector<double> tau, dtau = random_numbers(random, static_cast<int>(K * nv)),
                             dinertia = inertial_parameters(model);
    for (double& x : dinertia) x *= random.number(-0.03, 0.03);
    for (std::size_t k = 0; k < K; ++k) tau.insert(tau.end(), tau_1.begin(), tau_1.end());
    std::vector<double> dq((K + 1) * nv), dv(dq);
    const std::vector<double> none(nv);
    const ContactSensitivity found = contact_rollout_jvp(model, shapes, q, v, tau, step, none, none, dtau, dq,
                                                         dv, {}, {.inertia = dinertia});
    ASSERT_TRUE(found.ok()) << found.failure.why;
    if (found.certificate > 1e-9 || !found.unique) continue;
    std::vector<double> from = q;
    const auto at = [&](double by) {
      SimulationOptions options;
      options.joint_losses = true;
      options.drive = [&](double t, std::span<const double>, std::span<const double>, std::span<double> out) {
        const std::size_t k = std::min(K - 1, static_cast<std::size_t>(t / step));
        for (std::size_t c = 0; c < nv; ++c) out[c] = tau[k * nv + c] + by * dtau[k * nv + c];
      };
      std::vector<double> pi = inertial_parameters(model);
      for (std::size_t c = 0; c < pi.size(); ++c) pi[c] += by * dinertia[c];
      const Trajectory motion =
          simulate_contact(with_parameters(model, pi), q, v, step * static_cast<double>(K), step, options);
      EXPECT_TRUE(motion.complete) << motion.stop_reason;
      const std::size_t last = motion.size() - 1;
      Vector out(2 * static_cast<Eigen::Index>(nv));
      if (by == 0) from.assign(motion.q(last).begin(), motion.q(last).end());
      const std::vector<double> moved = difference(model, from, motion.q(last));
      out << as_eigen(std::span<const double>(moved)), as_eigen(motion.v(last));
      return out;
    };
    // Where several points share a load and slide, solutions differ by more than rounding: two sizes of the
    // differences say by how much.
    const Vector here = at(0);
    const auto difference_of = [&](double size, Vector& jump) {
      const Vector one = at(size), two = at(2 * size), back = at(-size), far = at(-2 * size);
      jump = (4 * (one + back) - (two + far) - 6 * here) / (2 * size);  // of one-sided differences
      return Vector((8 * (one - back) - (two - far)) / (12 * size));
    };
    Vector jump, other_jump;
    const Vector central = difference_of(1e-3, jump), other = difference_of(2.5e-4, other_jump);
    Vector exact(2 * static_cast<Eigen::Index>(nv));
    exact << as_eigen(std::span<const double>(dq).last(nv)), as_eigen(std::span<const double>(dv).last(nv));
    if (jump.norm() > 1e-3 * central.norm()) {
      ++kinks;
      continue;
    }
    ++compared;
    EXPECT_LE((exact - central).norm(), 1e-7 * central.norm() + 1e-9 + 2 * (central - other).norm())
        << exact.transpose() << "\n"
        << central.transpose();
  }
  EXPECT_GE(compared, 1) << "states where the motion has a derivative";
}

}  // namespace
}  // namespace axode::test
