#include "axode/integration/exact/simulate_contact_exact.hpp"
#include "axode/model/configuration.hpp"
#include "tests/contact/reference_contacts.hpp"

/// Motions of the reference files by the exact mode.
namespace axode::test {
namespace {

class ExactContactMotions : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == no_case) GTEST_SKIP() << missing(contact_folder(), "AXODE_VECTORS");
  }
};
INSTANTIATE_TEST_SUITE_P(Vectors, ExactContactMotions, testing::ValuesIn(contact_cases()), case_name);

TEST_P(ExactContactMotions, EndAtTheLimit) {
  const ReferenceContacts reference(GetParam());
  const Model model = reference.build();
  int compared = 0;
  reference.each("motions", [&](const Json& motion) {
    const std::string name = motion.at("state").text();
    SCOPED_TRACE(name);
    for (const Json& state : reference.file.at("states")) {
      if (state.at("name").text() != name || reference.begins_with_impact(model, state)) continue;
      const Trajectory found = simulate_contact_exact(
          model, numbers(state.at("q")), numbers(state.at("v")), number(motion.at("until")),
          {.relative = 1e-11, .absolute = 1e-11}, ReferenceContacts::options_of(state));
      // The laws leave some motions open, and then the exact mode says so.
      if (!found.complete && found.stop_reason.find("use the method contact") != std::string::npos) continue;
      ASSERT_TRUE(found.complete) << found.stop_reason;
      EXPECT_LE(std::ranges::max(found.certificates), 1e-9);
      const Json& limit = motion.at("limit");
      const std::vector<double> q = numbers(limit.at("q")), v = numbers(limit.at("v"));
      double most = 0;
      for (const double d : difference(model, q, found.q(found.size() - 1)))
        most = std::max(most, std::abs(d));
      for (std::size_t c = 0; c < v.size(); ++c)
        most = std::max(most, std::abs(found.v(found.size() - 1)[c] - v[c]));
      EXPECT_LE(most, 2 * ReferenceContacts::number_or(limit, "error", 0) + 1e-9);
      ++compared;
    }
  });
  if (compared == 0) GTEST_SKIP() << "no motion is decided by the laws and begins without an impact";
}

}  // namespace
}  // namespace axode::test
