#include "tests/laws/law.hpp"
#include "tests/support/functions.hpp"

/// Mechanisms without moving joints have states without numbers. Every function of the catalogue answers for
/// them too.
namespace axode::test {
namespace {

class NothingMoves : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, NothingMoves, testing::ValuesIn(cases_with_fast()), name_of);

TEST_P(NothingMoves, AndEveryFunctionAnswers) {
  const Model model =
      ModelBuilder(
          Description{
              .name = "table",
              .bodies = {{.name = "table", .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}}},
          })
          .build();
  ASSERT_EQ(model.nv(), 0);
  with_scalar(GetParam(), [&](auto scalar) {
    using T = decltype(scalar);
    Workspace<T> workspace(model);
    const std::vector<AppliedWrench<T>> wrenches{
        {1, Representation::hybrid, {T(1), T(2), T(3)}, {T(4), T(5), T(6)}}};
    catalog::Arguments<T> given{};
    given.loads = {wrenches, true};
    given.place = 1, given.base = 0;
    for (const catalog::Function<T>& function : functions_of<T>(GetParam())) {
      SCOPED_TRACE(function.name);
      std::vector<T> out(function.size(model, wrenches.size()), std::numeric_limits<T>::quiet_NaN());
      try {
        const Solvability found = function.call(model, workspace, given, out);
        EXPECT_EQ(found.directions, function.name == "operational_space_inertia" ? 0 : 6);
        EXPECT_TRUE(found.singular_body == 0 && !found.not_finite);
      } catch (const std::domain_error& error) {
        EXPECT_TRUE(function.name.starts_with("center") || function.name.starts_with("centroidal"))
            << error.what();
        continue;
      }
      const bool has_inertia =
          function.name != "operational_space_inertia";  // it does not exist for a frame that cannot move
      for (const T x : out) EXPECT_EQ(std::isfinite(x), has_inertia);
    }
  });
}

}  // namespace
}  // namespace axode::test
