#include "axode/integration/simulation.hpp"
#include "axode/model/configuration.hpp"
#include "tests/contact/reference_contacts.hpp"

/// Tests that simulations approach the motions of the reference files as steps become shorter.
namespace axode::test {
namespace {

class ContactMotions : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == no_case) GTEST_SKIP() << missing(contact_folder(), "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, ContactMotions, testing::ValuesIn(contact_cases()), case_name);

struct MotionEnd {
  std::vector<double> q, v;
};

/// Whether a contact of a state is closed and its bodies approach: an impact, whose friction the method of
/// the files takes against another velocity.
bool begins_with_impact(const ReferenceContacts& reference, const Model& model, const Json& state) {
  ContactDynamics dynamics(model, reference.contact_rows());
  const std::vector<Contact> contacts = reference.contacts(model, state);
  static_cast<void>(dynamics.solve(numbers(state.at("q")), numbers(state.at("v")), numbers(state.at("tau")),
                                   contacts, {.h = 1e-3, .threshold = reference.threshold}));
  std::vector<double> u(static_cast<std::size_t>(dynamics.system().problem().rows()));
  dynamics.system().times(numbers(state.at("v")).data(), u.data());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const int row = dynamics.system().problem().blocks()[k].first;
    if (contacts[k].gap < 1e-9 && u[static_cast<std::size_t>(row)] < -1e-3) return true;
  }
  return false;
}

TEST_P(ContactMotions, TendToTheLimit) {
  const ReferenceContacts reference(GetParam());
  const Model model = reference.build();
  int compared = 0;
  reference.each("motions", [&](const Json& motion) {
    const std::string name = motion.at("state").text();
    SCOPED_TRACE(name);
    for (const Json& state : reference.file.at("states")) {
      if (state.at("name").text() != name || begins_with_impact(reference, model, state)) continue;
      const std::vector<double> q_0 = numbers(state.at("q")), v_0 = numbers(state.at("v")),
                                tau = numbers(state.at("tau"));
      const double until = number(motion.at("until")), steps = number(motion.at("steps"));
      SimulationOptions options;
      options.joint_losses = true;
      options.drive = [&](double, std::span<const double>, std::span<const double>, std::span<double> out) {
        std::ranges::copy(tau, out.begin());
      };
      const auto end = [&](double parts) {
        const Trajectory found = simulate_contact(model, q_0, v_0, until, until / (steps * parts), options);
        EXPECT_TRUE(found.complete) << found.stop_reason;
        EXPECT_LE(std::ranges::max(found.certificates), 1e-9);
        return MotionEnd{to_vector(found.q(found.size() - 1)), to_vector(found.v(found.size() - 1))};
      };
      const auto distance = [&](const MotionEnd& x, const std::vector<double>& q,
                                const std::vector<double>& v) {
        double most = 0;
        for (const double d : difference(model, q, x.q)) most = std::max(most, std::abs(d));
        for (std::size_t c = 0; c < v.size(); ++c) most = std::max(most, std::abs(v[c] - x.v[c]));
        return most;
      };
      const MotionEnd half = end(8), found = end(16);
      const Json& limit = motion.at("limit");
      const double own_error = distance(half, found.q, found.v);
      const double error = distance(found, numbers(limit.at("q")), numbers(limit.at("v")));
      EXPECT_LE(error, 2 * number(limit.at("error")) + 2 * own_error + 1e-9);
      EXPECT_LE(own_error, 1e-3);
      ++compared;
    }
  });
  if (compared == 0) GTEST_SKIP() << "no motion begins without an impact";
}

}  // namespace
}  // namespace axode::test
