#include "axode/constraints/loops/loop_joint.hpp"

#include <cmath>

#include "tests/laws/law.hpp"
#include "tests/lie/random_quantities.hpp"

/// Laws of every loop joint of the table: its residuals, its constraint wrenches and their biases belong
/// together.
namespace axode::test {
namespace {

using loops::EndMotion;
using loops::LoopFrames;
using loops::LoopWrenches;

constexpr double pitch = 0.3;

/// A loop joint without its own formula for the bias; the library must compute the bias from the wrenches.
template <class Joint> struct WithoutBias {
  Joint joint;
  int rows() const { return joint.rows(); }
  template <class T> void wrenches(const LoopFrames<T>& at, loops::SpatialWrench<T>* W) const {
    joint.wrenches(at, W);
  }
};

/// The pose of a frame at the time t near 0, on a body with constant twist and twist rate.
SE3<> moved(const SE3<>& C, const Screw<>& V, const Screw<>& dV, double t) {
  return exp(t * V + (t * t / 2) * dV) * C;
}

class LoopJoints : public testing::TestWithParam<LoopTraits> {
 protected:
  /// Calls f(joint, frames, motion, random) for random joints of the kind between frames anywhere.
  template <class F> static void each(const F& f) {
    for_seeds(100, [&](std::uint64_t seed) {
      Random<double> random(seed);
      const auto screw = [&] { return Screw<>{random.vector(), random.vector()}; };
      const LoopFrames<double> at{{random.rotation(), random.vector()}, {random.rotation(), random.vector()}};
      const EndMotion<double> motion{screw(), screw(), screw(), screw()};
      const LoopTraits& kind = GetParam();
      const LoopJoint joint = loop_joint(kind.kind, kind.has("pitch") ? pitch : 0, random.number(0.2, 0.9),
                                         seed % 2 == 0, {0.02, -0.01});
      std::visit([&](const auto& of_type) { f(of_type, at, motion); }, joint);
    });
  }
};

TEST_P(LoopJoints, ResidualsHaveTheRateOfTheirWrenches) {
  int compared = 0;
  each([&](const auto& joint, const LoopFrames<double>& at, const EndMotion<double>& motion) {
    const double h = 1e-3;
    const auto residual = [&](double t) {
      std::array<double, 6> r{};
      joint.residual(LoopFrames<double>{moved(at.a, motion.V_i, {}, t), moved(at.b, motion.V_j, {}, t)},
                     r.data());
      return r;
    };
    const auto a = residual(h), b = residual(-h), c = residual(2 * h), d = residual(-2 * h);
    LoopWrenches<double> R;
    loops::residual_wrenches(joint, at, R.data());
    for (std::size_t k = 0; k < static_cast<std::size_t>(joint.residuals()); ++k) {
      if (std::abs(a[k] - b[k]) > 0.1) continue;  // the residual jumps where it is half a turn or half a lead
      const double rate = (8 * (a[k] - b[k]) - c[k] + d[k]) / (12 * h);
      EXPECT_NEAR(loops::power(R[k], motion.V_j - motion.V_i), rate, 1e-7 * (1 + std::abs(rate)));
      ++compared;
    }
  });
  if (GetParam().residuals > 0) {
    EXPECT_GT(compared, 80 * GetParam().residuals);
  }
}

TEST_P(LoopJoints, BiasesAreThoseOfTheWrenchesOnDualNumbers) {
  each([&]<class Joint>(const Joint& joint, const LoopFrames<double>& at, const EndMotion<double>& motion) {
    LoopWrenches<double> W;
    joint.wrenches(at, W.data());
    std::array<double, 6> written{}, differentiated{};
    loops::bias(joint, at, W.data(), motion, written.data());
    loops::bias(WithoutBias<Joint>{joint}, at, W.data(), motion, differentiated.data());
    for (std::size_t k = 0; k < 6; ++k)
      EXPECT_NEAR(written[k], differentiated[k], 1e-13 * (10 + std::abs(written[k])));
  });
}

TEST_P(LoopJoints, BiasesAreRatesOfTheirVelocities) {
  each([&](const auto& joint, const LoopFrames<double>& at, const EndMotion<double>& motion) {
    const double h = 1e-3;
    const auto velocities = [&](double t) {
      LoopWrenches<double> W;
      joint.wrenches(LoopFrames<double>{moved(at.a, motion.V_i, motion.dV_i, t),
                                        moved(at.b, motion.V_j, motion.dV_j, t)},
                     W.data());
      const Screw<> X = (motion.V_j + t * motion.dV_j) - (motion.V_i + t * motion.dV_i);
      std::array<double, 6> out{};
      for (std::size_t k = 0; k < static_cast<std::size_t>(joint.rows()); ++k) out[k] = loops::power(W[k], X);
      return out;
    };
    LoopWrenches<double> W;
    joint.wrenches(at, W.data());
    std::array<double, 6> gamma{};
    loops::bias(joint, at, W.data(), motion, gamma.data());
    const auto a = velocities(h), b = velocities(-h), c = velocities(2 * h), d = velocities(-2 * h);
    for (std::size_t k = 0; k < 6; ++k) {
      const double rate = (8 * (a[k] - b[k]) - c[k] + d[k]) / (12 * h);
      EXPECT_NEAR(gamma[k], rate, 1e-6 * (10 + std::abs(rate)));
    }
  });
}

INSTANTIATE_TEST_SUITE_P(, LoopJoints, testing::ValuesIn(loop_kinds),
                         [](const auto& info) { return std::string(info.param.name); });

std::vector<LoopTraits> subgroups() {
  std::vector<LoopTraits> all;
  for (const LoopTraits& kind : loop_kinds)
    if (std::holds_alternative<loops::SubgroupClosure>(loop_joint(kind.kind, 0, 0, false)))
      all.push_back(kind);
  return all;
}

/// Loop joints that leave a subgroup of motions free: their residuals stay 0 along these motions and change
/// along others.
class Closures : public testing::TestWithParam<LoopTraits> {
 protected:
  /// A motion of the subgroup: a product of exponentials of up to 20 rad and 20 m.
  SE3<> motion(Random<double>& random) const {
    SE3<> g;
    for (int twice = 0; twice < 2; ++twice) {
      axode::Six<double> x{};
      for (std::size_t k = 0; k < 6; ++k)
        if (closure.free[k]) x[k] = random.number(-20, 20);
      if (closure.pitch != 0) x[5] = pitch * x[2];
      g = g * exp(Screw<>{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
    }
    return g;
  }
  std::array<double, 6> residual(const SE3<>& D) const {
    std::array<double, 6> r{};
    closure.residual(LoopFrames<double>{{}, D}, r.data());
    return r;
  }
  const loops::SubgroupClosure closure{GetParam().free, GetParam().has("pitch") ? pitch : 0};
};

TEST_P(Closures, VanishOnAllOfTheJointsMotions) {
  for_seeds(100, [&](std::uint64_t seed) {
    Random<double> random(seed);
    const SE3<> g = motion(random);
    for (const double r : residual(g)) EXPECT_NEAR(r, 0, 2e-14);
    LoopWrenches<double> W, R;
    closure.wrenches(LoopFrames<double>{inverse(g), {}}, W.data());
    closure.residual_wrenches(LoopFrames<double>{inverse(g), {}}, R.data());
    for (std::size_t k = 0; k < static_cast<std::size_t>(closure.rows()); ++k) {
      EXPECT_LT(norm(R[k].m - W[k].m), 3e-14);
      EXPECT_LT(norm(R[k].f - W[k].f), 3e-14);
    }
  });
}

/// A small displacement in any of the six directions that is not free changes the residual, each one another
/// component.
TEST_P(Closures, SeeEveryOtherMotion) {
  EXPECT_EQ(closure.rows(), GetParam().rows);
  Random<double> random;
  for (std::size_t k = 0; k < 6; ++k) {
    if (closure.free[k]) continue;
    axode::Six<double> x{};
    x[k] = 1e-3;
    const SE3<> D = motion(random) * exp(Screw<>{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}});
    double size = 0;
    for (const double r : residual(D)) size = std::max(size, std::abs(r));
    EXPECT_NEAR(size, 1e-3, 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(, Closures, testing::ValuesIn(subgroups()),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace axode::test
