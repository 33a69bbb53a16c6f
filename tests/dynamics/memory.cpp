#include "axode/dynamics.hpp"
#include "tests/model/random_mechanism.hpp"

/// How much memory mechanisms need, and models whose memory was moved into other ones.
namespace axode::test {
namespace {

/// Which hinges follow others: none of them, the last one follows the first, each second one follows the one
/// before it, or all follow the first.
enum class Couplings { none, one, pairs, all };
/// A description of n hinges on the ground.
Description hinges(int n, Couplings couplings) {
  Description description{.name = "hinges"};
  for (int i = 0; i < n; ++i) {
    BodyDescription body{.name = numbered('b', i)};
    body.joint = {.name = numbered('j', i), .kind = JointKind::revolute, .axis = {0, 1, 0}};
    body.inertia = MassProperties{.mass = 1, .com = {0.1, 0, 0.2}, .Theta = {1, 1, 1}};
    if (couplings == Couplings::pairs && i % 2 == 1)
      body.joint.coupling = Coupling{numbered('j', i - 1), 2, 0};
    if ((couplings == Couplings::one && i == n - 1) || (couplings == Couplings::all && i > 0))
      body.joint.coupling = Coupling{"j0", 2, 0};
    description.bodies.push_back(std::move(body));
  }
  return description;
}

/// The same hinges on a body that moves.
Description on_a_carrier(Description hinges) {
  for (BodyDescription& body : hinges.bodies) body.predecessor = "carrier";
  BodyDescription carrier{.name = "carrier", .joint = {.name = "carrier joint", .kind = JointKind::free}};
  carrier.inertia = MassProperties{.mass = 1, .Theta = {1, 1, 1}};
  hinges.bodies.insert(hinges.bodies.begin(), std::move(carrier));
  return hinges;
}

std::string name_of_couplings(const testing::TestParamInfo<Couplings>& couplings) {
  constexpr std::array names{"none", "one", "pairs", "all"};
  return names[static_cast<std::size_t>(couplings.param)];
}
class MemoryOfCouplings : public testing::TestWithParam<Couplings> {};
INSTANTIATE_TEST_SUITE_P(, MemoryOfCouplings,
                         testing::Values(Couplings::none, Couplings::one, Couplings::pairs, Couplings::all),
                         name_of_couplings);

TEST_P(MemoryOfCouplings, GrowsWithTheBodiesAndNotWithTheirSquare) {
  for (const bool carried : {false, true}) {
    const auto bytes = [&](int n) {
      const Description description = hinges(n, GetParam());
      return Workspace<>(ModelBuilder(carried ? on_a_carrier(description) : description).build()).bytes();
    };
    const std::size_t few = bytes(2000), many = bytes(20'000);
    EXPECT_LT(many, 11 * few);
  }
}

TEST_P(MemoryOfCouplings, ManyMoreHingesThanAnIntHasPairsOf) {
  const int n = 100'002;  // 50,001 pairs; the square of that number does not fit into an int
  const Model model = ModelBuilder(hinges(n, GetParam())).build();
  Workspace<> workspace(model);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  std::vector<double> q(nv), v(nv), a(nv), tau(nv), again(nv);
  for (std::size_t c = 0; c < nv; ++c) {
    const double k = static_cast<double>(c);
    q[c] = std::sin(k), v[c] = std::cos(k), a[c] = std::sin(2 * k);
  }
  inverse_dynamics(model, workspace, q, v, a, tau);
  ASSERT_TRUE(forward_dynamics(model, workspace, q, v, tau, again).ok());
  for (std::size_t c = 0; c < nv; ++c) ASSERT_NEAR(again[c], a[c], 1e-9);
}

TEST(MovedModels, AreStillModels) {
  Model model = ModelBuilder(hinges(3, Couplings::one)).build();
  const Model taken = std::move(model);
  for (const Model& each : {model, taken}) {
    EXPECT_EQ(each.name(), "hinges");
    EXPECT_EQ(each.nv(), 2);
    Workspace<> workspace(each);
    std::vector<double> tau(2);
    inverse_dynamics(each, workspace, neutral(each), std::vector<double>(2), std::vector<double>(2), tau);
    EXPECT_GT(std::abs(tau[0]), 0.1);
  }
  Model assigned = ModelBuilder("nothing").build();
  assigned = std::move(model);
  EXPECT_EQ(model.joint(1).name, assigned.joint(1).name);
}

}  // namespace
}  // namespace axode::test
