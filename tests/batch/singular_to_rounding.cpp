#include "axode/batch.hpp"
#include "axode/recursion/solvability.hpp"
#include "tests/laws/law.hpp"

/// Mass matrices that are singular to rounding are refused, and all others give correct results: for every
/// function that inverts the mass matrix, in every representation, by the fast path and in batches.
namespace axode::test {
namespace {

class SingularToRounding : public Law {};
INSTANTIATE_TEST_SUITE_P(Laws, SingularToRounding, testing::ValuesIn(cases_with_fast()), name_of);

/// A thin body that moves freely. Its principal moments of inertia are 1, 1 and `third`, in kg m², in a
/// random orientation R.
Model rod(double third, const SO3<>& R) {
  return ModelBuilder("rod")
      .add({.name = "rod",
            .joint = {.kind = JointKind::free},
            .inertia = MassProperties{.mass = 0.1, .Theta = {1, 1, third, 0, 0, 0}, .axes = R}})
      .build();
}

/// M⁻¹ from a batch of three copies of one state.
template <class T> Answer inverse_in_batch(const Model& model, const std::vector<double>& q) {
  std::vector<T> all;
  for (int k = 0; k < 3; ++k) all.insert(all.end(), q.begin(), q.end());
  const std::size_t nv2 = static_cast<std::size_t>(model.nv() * model.nv());
  std::vector<T> inverse(3 * nv2);
  const batch::Outcome outcome = batch::run<T>(model, "inverse_mass_matrix", {.q = all}, inverse);
  EXPECT_EQ(outcome.singular_states, outcome.ok() ? 0 : 3);
  return {{inverse.begin(), inverse.begin() + static_cast<std::ptrdiff_t>(nv2)}, outcome.solvability};
}
template <class T> Answer accelerations_in_batch(const Model& model, const Ask& ask) {
  std::vector<T> q, v, tau;
  for (int k = 0; k < 3; ++k) {
    q.insert(q.end(), ask.q.begin(), ask.q.end());
    v.insert(v.end(), ask.v.begin(), ask.v.end());
    tau.insert(tau.end(), ask.tau.begin(), ask.tau.end());
  }
  std::vector<T> a(v.size());
  const batch::Outcome outcome = batch::run<T>(model, "forward_dynamics", {.q = q, .v = v, .tau = tau}, a);
  EXPECT_EQ(outcome.singular_states, outcome.ok() ? 0 : 3);
  return {{a.begin(), a.begin() + model.nv()}, outcome.solvability};
}

/// A state of the rod and a torque about its thin axis alone.
struct Thin {
  SO3<> R;
  Model model;
  Ask ask;

  Thin(double third, Random<double>& random) : R(random.rotation()), model(rod(third, R)) {
    ask.q = random_state(model, random).q, ask.v.assign(6, 0);
    ask.tau = ask.p = {axis().x, axis().y, axis().z, 0, 0, 0};
    ask.place = 1;
  }
  Vec3<> axis() const { return R.z; }  ///< the thin axis in the body frame
};

TEST_P(SingularToRounding, IsRefusedInEveryDirection) {
  for_seeds(1000, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const Thin thin(0, random);
    const auto on = subject(GetParam(), thin.model);
    for (const char* function : {"forward_dynamics", "inverse_mass_matrix", "from_momenta", "momentum_form"})
      EXPECT_FALSE(on->call(function, thin.ask).solvability.ok()) << function;
    if (!GetParam().fast) {
      for (const char* function :
           {"impulse_response", "inverse_operational_space_inertia", "operational_space_inertia"})
        EXPECT_FALSE(on->call(function, thin.ask).solvability.ok()) << function;
      return;
    }
    EXPECT_FALSE((GetParam().single ? inverse_in_batch<float>(thin.model, thin.ask.q)
                                    : inverse_in_batch<double>(thin.model, thin.ask.q))
                     .solvability.ok())
        << "in a batch";
    EXPECT_FALSE((GetParam().single ? accelerations_in_batch<float>(thin.model, thin.ask)
                                    : accelerations_in_batch<double>(thin.model, thin.ask))
                     .solvability.ok())
        << "in a batch";
  });
}

TEST_P(SingularToRounding, IsRefusedOrRight) {
  const double rounding =
      GetParam().single ? std::numeric_limits<float>::epsilon() : std::numeric_limits<double>::epsilon();
  int right = 0, refused = 0;
  for_seeds(1000, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const double third = std::pow(10, random.number(-18, 0));
    const Thin thin(third, random);
    const auto check = [&](const Answer& answer, const char* how) {
      if (!answer.solvability.ok()) {
        ++refused;
        return;
      }
      ++right;
      const Vec3<> a{answer.numbers[0], answer.numbers[1], answer.numbers[2]};
      EXPECT_LE(norm(third * a - thin.axis()), std::min(0.5, 1e3 * rounding / third))
          << how << " with " << third;
    };
    check(subject(GetParam(), thin.model)->call("forward_dynamics", thin.ask), "one");
    check(subject(GetParam(), thin.model)->call("from_momenta", thin.ask), "momenta");
    if (!GetParam().fast) return;
    check(GetParam().single ? accelerations_in_batch<float>(thin.model, thin.ask)
                            : accelerations_in_batch<double>(thin.model, thin.ask),
          "many");
  });
  EXPECT_GT(right, (right + refused) / 10);
  EXPECT_GT(refused, (right + refused) / 20);
}

template <class T> void expect_seen() {
  for (std::size_t n = 1; n <= 100; ++n) {
    std::vector<T> x(n, T(1));
    EXPECT_TRUE(solved({}, static_cast<std::ptrdiff_t>(n), x.data()).ok()) << n;
    for (std::size_t k = 0; k < n; ++k)
      for (const double not_finite : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        x[k] = T(not_finite);
        EXPECT_TRUE(solved({}, static_cast<std::ptrdiff_t>(n), x.data()).not_finite) << k << " of " << n;
        x[k] = T(1);
      }
  }
}
TEST(Results, AreRefusedWhereverOneIsNotFinite) { expect_seen<double>(), expect_seen<float>(); }

}  // namespace
}  // namespace axode::test
