#include "tests/support/smallest_failure.hpp"

#include "axode/io.hpp"
#include "tests/laws/law.hpp"

namespace axode::test {
namespace {

/// The model in the drawing at the end of a report.
Model drawn_in(const std::string& report) {
  const std::string heading = "as a drawing:\n";
  return ModelBuilder(read_drawing_text(report.substr(report.find(heading) + heading.size()), "report"))
      .build();
}

TEST(SmallestFailures, AreThoseOfTheFirstBodiesThatFail) {
  int shortened = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto no_helical_joint = [&] {
      Random<double> random(seed);
      const Model model = ModelBuilder(random_description(random)).build();
      for (const Joint& joint : model.joints()) EXPECT_NE(joint.kind, Subgroup::helical) << joint.name;
    };
    Random<double> random(seed);
    const Model whole = ModelBuilder(random_description(random)).build();
    const auto helical = [](const Model& model) {
      return std::ranges::count(model.joints(), Subgroup::helical, &Joint::kind);
    };
    if (helical(whole) == 0) continue;
    const std::string report = smallest_failure(no_helical_joint);
    if (report == "with fewer bodies it does not fail") {
      EXPECT_EQ(whole.joint(whole.n_bodies()).kind, Subgroup::helical);
      continue;
    }
    ++shortened;
    const Model smallest = drawn_in(report);
    EXPECT_EQ(helical(smallest), 1) << report;
    EXPECT_LT(smallest.n_bodies(), whole.n_bodies());
  }
  EXPECT_GT(shortened, 5);
}

TEST(SmallestFailures, AreFoundForLawsThatThrow) {
  Random<double> random;
  do random_mechanism(random);
  while (last_mechanism().bodies == 1);
  const std::string report = smallest_failure([] {
    Random<double> again(3);
    random_description(again);
    throw std::runtime_error("always");
  });
  EXPECT_NE(report.find("with 1 body it still fails:\nthrows: always"), std::string::npos) << report;
  EXPECT_EQ(drawn_in(report).n_bodies(), 1);
}

}  // namespace
}  // namespace axode::test
