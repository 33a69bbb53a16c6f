#include <gtest/gtest.h>

#include <set>

#include "axode/codegen.hpp"
#include "axode/kinematics.hpp"
#include "axode/model.hpp"
#include "tests/codegen/compiled.hpp"

/// Frames may have names that generated functions of other frames have too.
namespace axode::test {
namespace {

using catalog::Id;
using codegen::Function;

/// A pendulum with a frame for each name; each frame is at another height.
Model pendulum(const std::vector<std::string>& frames) {
  ModelBuilder builder("pendulum");
  builder.add({.name = "rod",
               .joint = {.kind = JointKind::revolute, .axis = {0.6, 0.8, 0}},
               .inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}}});
  double height = 0;
  for (const std::string& name : frames) {
    height += 1;
    builder.add({.name = name, .body = "rod", .pose = {exp_SO3(Vec3<>{height, 0, 0}), {0, 0, height}}});
  }
  return builder.build();
}

TEST(GeneratedNames, OfAFrameNamedLikeARepresentationOfAnotherAreApart) {
  const Model model =
      pendulum({"tool", "tool_hybrid", "tool hybrid", "tool_hybrid_2", "tool_hybrid_hybrid", "tool_mixed",
                "spatial", "tool_2", "tool-2", "hybrid", "tool_body", "tool_spatial_spatial"});
  std::vector<Function> functions;
  for (int f = 0; f < model.n_frames(); ++f)
    for (const Representation representation :
         {Representation::body, Representation::spatial, Representation::hybrid, Representation::mixed})
      functions.push_back({Id("jacobian"), f, representation});
  const codegen::Source source = codegen::c_source(model, functions, {.prefix = "p"});
  std::set<std::string> names;
  for (const auto& function : source.functions) names.insert(function.name);
  ASSERT_EQ(names.size(), functions.size());
  const Compiled compiled(source.text);
  Workspace<> workspace(model);
  const std::vector<double> q{0.4};
  for (std::size_t k = 0; k < functions.size(); ++k) {
    double J[6];
    compiled.function<void(const double*, double*)>(source.functions[k].name)(q.data(), J);
    with_representation(functions[k].representation, [&]<class Rep>(Rep) {
      Twist<Rep> expected;
      jacobian<Rep>(model, workspace, q, functions[k].frame, {&expected, 1});
      const double numbers[]{expected.w.x, expected.w.y, expected.w.z,
                             expected.v.x, expected.v.y, expected.v.z};
      for (int r = 0; r < 6; ++r) EXPECT_NEAR(J[r], numbers[r], 1e-13) << source.functions[k].name;
    });
  }
}

}  // namespace
}  // namespace axode::test
