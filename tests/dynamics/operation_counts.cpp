#include "axode/dynamics/momentum_recursion.hpp"
#include "axode/scalar/counted.hpp"
#include "tests/laws/law.hpp"

/// What the momentum form and forward dynamics cost, in the same units: operations of the kernels.
namespace axode::test {
namespace {

/// n hinges about z at every body frame's origin, or at a skew axis.
Model chain(int n) {
  Random<double> random(1);
  ModelBuilder builder("chain");
  for (int i = 0; i < n; ++i) {
    BodyDescription link{.name = "link " + std::to_string(i)};
    if (i > 0) link.predecessor = "link " + std::to_string(i - 1);
    link.joint = {.kind = JointKind::revolute, .axis = random.vector(1)};
    link.geometry = InBodyFrame{{random.rotation(), random.vector(0.3)}};
    link.inertia = MassProperties{.mass = 1, .com = random.vector(0.1), .Theta = {0.02, 0.02, 0.02}};
    builder.add(std::move(link));
  }
  return builder.build();
}

/// The operations of f(tree, workspace, q, x, tau, out, out2) on numbers that count.
template <class F> Operations operations_of(const Model& model, const F& f) {
  const Tree<Counted> tree = cast<Counted>(model.tree<double>());
  Workspace<Counted> workspace(tree);
  const std::vector<Counted> q(static_cast<std::size_t>(tree.nq), 0.3),
      x(static_cast<std::size_t>(tree.nv), 0.2);
  std::vector<Counted> out(x.size()), out2(x.size());
  Counted::count() = {};
  f(tree, workspace, q.data(), x.data(), out.data(), out2.data());
  return Counted::count();
}
template <class Rep> Operations of_forward_dynamics(const Model& model) {
  return operations_of(model, [](const auto& tree, auto& workspace, auto* q, auto* x, auto* out, auto*) {
    typename Workspace<Counted>::Arena arena(workspace);
    EXPECT_TRUE((solve_forward_dynamics<Rep, Counted>(tree, arena, q, x, x, {}, out).ok()));
  });
}
Operations of_momentum_form(const Model& model) {
  return operations_of(model, [](const auto& tree, auto& workspace, auto* q, auto* x, auto* out, auto* out2) {
    EXPECT_TRUE(solve_momentum_form<Counted>(tree, workspace, q, x, x, {}, out, out2).ok());
  });
}

void record(const std::string& name, int n, const Operations& x) {
  testing::Test::RecordProperty(name + " n" + std::to_string(n), std::to_string(x.products) + " mul, " +
                                                                     std::to_string(x.sums) + " add, " +
                                                                     std::to_string(x.total()) + " in all");
}

TEST(OperationCounts, TheMomentumFormTakesFewerThanForwardDynamicsInSpatialTwists) {
  for (const int n : {7, 36, 100}) {
    const Model model = chain(n);
    const Operations momentum = of_momentum_form(model), spatial = of_forward_dynamics<Spatial>(model);
    record("momentum form", n, momentum);
    record("forward dynamics body", n, of_forward_dynamics<BodyFixed>(model));
    record("forward dynamics spatial", n, spatial);
    record("forward dynamics hybrid", n, of_forward_dynamics<Hybrid>(model));
    record("forward dynamics mixed", n, of_forward_dynamics<Mixed>(model));
    EXPECT_LT(momentum.total(), spatial.total());
  }
}

TEST(OperationCounts, GrowInProportionToTheBodies) {
  const Operations ten = of_forward_dynamics<BodyFixed>(chain(10)),
                   twenty = of_forward_dynamics<BodyFixed>(chain(20)),
                   thirty = of_forward_dynamics<BodyFixed>(chain(30));
  EXPECT_EQ(thirty.total() - twenty.total(), twenty.total() - ten.total());
}

}  // namespace
}  // namespace axode::test
