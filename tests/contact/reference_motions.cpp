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

TEST_P(ContactMotions, TendToTheLimit) {
  const ReferenceContacts reference(GetParam());
  const Model model = reference.build();
  int compared = 0;
  reference.each("motions", [&](const Json& motion) {
    const std::string name = motion.at("state").text();
    SCOPED_TRACE(name);
    for (const Json& state : reference.file.at("states")) {
      if (state.at("name").text() != name || reference.begins_with_impact(model, state)) continue;
      const std::vector<double> q_0 = numbers(state.at("q")), v_0 = numbers(state.at("v"));
      const double until = number(motion.at("until")), steps = number(motion.at("steps"));
      const SimulationOptions options = ReferenceContacts::options_of(state);
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
