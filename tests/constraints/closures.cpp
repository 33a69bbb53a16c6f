#include "axode/constraints/closure.hpp"

#include <Eigen/Core>

#include "tests/laws/law.hpp"
#include "tests/lie/random_quantities.hpp"

/// Residuals of loop joints along their own motions and beside them.
namespace axode::test {
namespace {

constexpr LoopKind subgroups[] = {LoopKind::fixed,   LoopKind::revolute,     LoopKind::prismatic,
                                  LoopKind::helical, LoopKind::cylindrical,  LoopKind::spherical,
                                  LoopKind::planar,  LoopKind::translational};
constexpr double pitch = 0.3;

class Closures : public testing::TestWithParam<LoopKind> {
 protected:
  /// A product of exponentials of up to 20 rad and 20 m.
  SE3<> motion(Random<double>& random) const {
    SE3<> g;
    for (int twice = 0; twice < 2; ++twice) {
      const std::array<bool, 6> is_free = free_coordinates(GetParam());
      axode::Six<double> x{};
      for (std::size_t k = 0; k < 6; ++k)
        if (is_free[k]) x[k] = random.number(-20, 20);
      if (GetParam() == LoopKind::helical) x[5] = pitch * x[2];
      g = g * exp(Screw<>{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
    }
    return g;
  }
  const Closure<double> closure{GetParam(), pitch};
};

TEST_P(Closures, VanishOnAllOfTheJointsMotions) {
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const SE3<> g = motion(random);
    for (const double r : closure.residual(g)) EXPECT_NEAR(r, 0, 2e-14);
    std::vector<axode::Six<double>> T;
    closure.each_wrench([&](int, const axode::Six<double>& W) { T.push_back(W); });
    closure.each_residual_row(g, [&](int k, const axode::Six<double>& P) {
      for (std::size_t c = 0; c < 6; ++c) EXPECT_NEAR(P[c], T[static_cast<std::size_t>(k)][c], 3e-14);
    });
  });
}

TEST_P(Closures, HaveTheRateThatTheirRowsSay) {
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const SE3<> D = motion(random) * exp(Screw<>{random.vector(0.4), random.vector(0.4)});
    const Screw<> X{random.vector(), random.vector()};
    const double h = 1e-3;
    const auto r = [&](double t) { return closure.residual(D * exp(t * X)); };
    const axode::Six<double> a = r(h), b = r(-h), c = r(2 * h), d = r(-2 * h);
    closure.each_residual_row(D, [&](int row, const axode::Six<double>& P) {
      const auto k = static_cast<std::size_t>(row);
      const double rate = (8 * (a[k] - b[k]) - c[k] + d[k]) / (12 * h);
      const axode::Six<double> x = six(X.w, X.v);
      double said = 0;
      for (std::size_t e = 0; e < 6; ++e) said += P[e] * x[e];
      EXPECT_NEAR(said, rate, 2e-9);
    });
  });
}

/// All six directions that are not free make the residual move, one each: it vanishes on nothing else nearby.
TEST_P(Closures, SeeEveryOtherMotion) {
  const std::array<bool, 6> is_free = free_coordinates(GetParam());
  const int rows = traits(GetParam()).rows;
  EXPECT_EQ(rows, 6 - std::ranges::count(is_free, true));
  Random<double> random;
  for (std::size_t k = 0; k < 6; ++k) {
    if (is_free[k]) continue;
    axode::Six<double> x{};
    x[k] = 1e-3;
    const SE3<> D = motion(random) * exp(Screw<>{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
    double size = 0;
    for (const double r : closure.residual(D)) size = std::max(size, std::abs(r));
    EXPECT_NEAR(size, 1e-3, 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(, Closures, testing::ValuesIn(subgroups),
                         [](const auto& info) { return std::string(to_string(info.param)); });

}  // namespace
}  // namespace axode::test
