#include "apps/study/study.hpp"
#include "tests/laws/law.hpp"
#include "tests/model/hinge_chain.hpp"

/// The cost of the kernels: their operations on numbers and on screws, in each representation and with each
/// choice of body frames.
namespace axode::test {
namespace {

using command::Algorithm;
enum class Frames { joint, user, mass_center, construction };

/// The operations of one call of an algorithm with the recursion in Rep.
template <class Rep> Operations operations_of(Algorithm algorithm, Frames frames, const Model& model) {
  const std::vector<double> q(static_cast<std::size_t>(model.nq()), 0.3),
      v(static_cast<std::size_t>(model.nv()), 0.2);
  const command::State state{.q = q, .v = v, .a = v};
  switch (frames) {
    case Frames::joint: return command::operations<Rep, command::JointFrames>(algorithm, model, state);
    case Frames::user: return command::operations<Rep, UserFrames>(algorithm, model, state);
    case Frames::mass_center: return command::operations<Rep, MassCenterFrames>(algorithm, model, state);
    case Frames::construction: break;
  }
  return command::operations<Rep, ConstructionFrames>(algorithm, model, state);
}
Operations operations_of(Algorithm algorithm, Representation in, Frames frames, const Model& model) {
  return with_representation(
      in, [&](auto rep) { return operations_of<decltype(rep)>(algorithm, frames, model); });
}
using enum Representation;

void record(const std::string& name, int n, const Operations& x) {
  testing::Test::RecordProperty(name + " n" + std::to_string(n), std::to_string(x.products) + " mul, " +
                                                                     std::to_string(x.sums) + " add, " +
                                                                     std::to_string(x.total()) + " in all");
}

TEST(OperationCounts, TheMomentumFormTakesFewerThanForwardDynamicsExceptInMixedTwists) {
  for (const int n : {7, 36, 100}) {
    const Model model = chain(n);
    const auto count = [&](Algorithm algorithm, Representation in) {
      return operations_of(algorithm, in, Frames::joint, model);
    };
    for (const Representation in : representations) {
      const Operations momentum = count(Algorithm::momentum_form, in),
                       forward = count(Algorithm::forward_dynamics, in);
      record("momentum form " + std::string(name(in)), n, momentum);
      record("forward dynamics " + std::string(name(in)), n, forward);
      EXPECT_EQ(momentum.total() < forward.total(), in != mixed) << name(in) << ' ' << n;
    }
  }
}

TEST(OperationCounts, GrowInProportionToTheBodies) {
  const auto count = [](int n) {
    return operations_of(Algorithm::forward_dynamics, body, Frames::joint, chain(n));
  };
  const Operations ten = count(10), twenty = count(20), thirty = count(30);
  EXPECT_EQ(thirty.total() - twenty.total(), twenty.total() - ten.total());
}

/// Numbers of operations on screws, in the order of ScrewOperation.
using Screws = std::array<long, n_screw_operations>;

/// Expects these operations for a chain of n hinges, with all four choices of body frames.
void expect_screws(Algorithm algorithm, Representation in, int n, const Screws& expected) {
  const Model model = chain(n);
  for (const Frames frames : {Frames::joint, Frames::user, Frames::mass_center, Frames::construction})
    EXPECT_EQ(operations_of(algorithm, in, frames, model).screws, expected) << name(in);
}

/// Sections 4.1 to 4.3 of the paper count 3 (n - 1) frame transformations and 2 n - 1 brackets for body-fixed
/// twists; n, n of inertias and 2 n - 1 for spatial; 3 n - 3 translations, n rotations, n of inertias and
/// 3 n - 1 for hybrid ones. The kernels treat the ground as a body, which gravity accelerates: n instead of
/// n - 1. And they transform S v, S a and W of every joint instead of its screw: 3 n instead of n.
TEST(OperationCounts, OfInverseDynamicsAreThePapersWithTheGroundAsABody) {
  for (const int n : {1, 7, 36}) {
    expect_screws(Algorithm::inverse_dynamics, body, n, {3 * n, 0, 0, 0, 0, 0, 2 * n});
    expect_screws(Algorithm::inverse_dynamics, spatial, n, {3 * n, 0, 0, n, 0, 0, 2 * n});
    expect_screws(Algorithm::inverse_dynamics, hybrid, n, {0, 3 * n, 3 * n, 0, n, 0, 3 * n});
    expect_screws(Algorithm::inverse_dynamics, mixed, n, {3 * n, 3 * n, 0, 0, 0, 0, 3 * n});
  }
}

TEST(OperationCounts, OfAccelerationsAreThoseOfTheForwardRecursion) {
  for (const int n : {1, 7, 36}) {
    expect_screws(Algorithm::accelerations, body, n, {2 * n, 0, 0, 0, 0, 0, n});
    expect_screws(Algorithm::accelerations, spatial, n, {2 * n, 0, 0, 0, 0, 0, n});
    expect_screws(Algorithm::accelerations, hybrid, n, {0, 2 * n, 2 * n, 0, 0, 0, 2 * n});
    expect_screws(Algorithm::accelerations, mixed, n, {2 * n, 2 * n, 0, 0, 0, 0, 2 * n});
  }
}

TEST(OperationCounts, OfTheMassMatrixCarryEveryImpulseToTheRootUnlessTheyAreSpatial) {
  for (const int n : {1, 7, 36}) {
    const long pairs = n * (n - 1) / 2;
    expect_screws(Algorithm::mass_matrix, body, n, {pairs, 0, 0, n, 0, 0, 0});
    expect_screws(Algorithm::mass_matrix, spatial, n, {n, 0, 0, n, 0, 0, 0});
    expect_screws(Algorithm::mass_matrix, hybrid, n, {0, n, pairs, 0, n, n, 0});
    expect_screws(Algorithm::mass_matrix, mixed, n, {pairs, n, 0, n, 0, 0, 0});
  }
}

/// Body-fixed and mixed recursions transform the articulated inertia, the spatial one that of the body, and
/// the hybrid one rotates that of the body and shifts the articulated one. Every screw is transformed once.
TEST(OperationCounts, OfForwardDynamicsTransformOneInertiaPerBody) {
  for (const int n : {1, 7, 36}) {
    expect_screws(Algorithm::forward_dynamics, body, n, {3 * n, 0, 0, n, 0, 0, 2 * n});
    expect_screws(Algorithm::forward_dynamics, spatial, n, {n, 0, 0, n, 0, 0, 2 * n});
    expect_screws(Algorithm::forward_dynamics, hybrid, n, {0, n, 3 * n, 0, n, n, 3 * n});
    expect_screws(Algorithm::forward_dynamics, mixed, n, {3 * n, n, 0, n, 0, 0, 3 * n});
  }
}

/// The multiplications and additions for one hinge.
struct PerHinge {
  long products, sums;
  bool operator==(const PerHinge&) const = default;
  friend void PrintTo(const PerHinge& x, std::ostream* out) {
    *out << x.products << " mul, " << x.sums << " add";
  }
};
std::vector<PerHinge> of_one_more_hinge(Representation in, int n) {
  std::vector<PerHinge> out;
  for (const Frames frames : {Frames::joint, Frames::user, Frames::mass_center, Frames::construction}) {
    const Operations x = operations_of(Algorithm::inverse_dynamics, in, frames, chain(n)),
                     y = operations_of(Algorithm::inverse_dynamics, in, frames, chain(n + 1));
    out.push_back({y.products - x.products, y.sums - x.sums});
  }
  return out;
}

/// The four pairs are those in joint frames, in frames of the user, at the centres of mass and in the
/// construction frame; docs/comparative-study.md quotes them.
TEST(OperationCounts, OfInverseDynamicsPerHingeAreTheSameForEveryHinge) {
  for (const int n : {1, 6, 35}) {
    EXPECT_EQ(of_one_more_hinge(body, n),
              (std::vector<PerHinge>{{172, 152}, {202, 175}, {151, 130}, {193, 164}}));
    EXPECT_EQ(of_one_more_hinge(spatial, n),
              (std::vector<PerHinge>{{285, 238}, {315, 261}, {288, 234}, {306, 250}}));
    EXPECT_EQ(of_one_more_hinge(hybrid, n),
              (std::vector<PerHinge>{{256, 209}, {286, 232}, {226, 181}, {277, 221}}));
    EXPECT_EQ(of_one_more_hinge(mixed, n),
              (std::vector<PerHinge>{{247, 200}, {277, 223}, {217, 175}, {268, 212}}));
  }
}

/// The operations of one transformation.
template <class F> PerHinge of_one(const F& f) {
  Counted::count() = {};
  f();
  return {Counted::count().products, Counted::count().sums};
}
TEST(OperationCounts, AnInertiaTakesThreeTimesAsManyAsAScrewToTransform) {
  const SE3<Counted> C{};
  const Screw<Counted> X{};
  const Inertia<Counted> M{};
  EXPECT_EQ(of_one([&] { static_cast<void>(Ad(C, X)); }), (PerHinge{24, 18}));
  EXPECT_EQ(of_one([&] { static_cast<void>(Ad(C.R, X)); }), (PerHinge{18, 12}));
  EXPECT_EQ(of_one([&] { static_cast<void>(Ad(C.r, X)); }), (PerHinge{6, 6}));
  EXPECT_EQ(of_one([&] { static_cast<void>(ad(X, X)); }), (PerHinge{18, 12}));
  EXPECT_EQ(of_one([&] { static_cast<void>(transform(C, M)); }), (PerHinge{77, 59}));
  EXPECT_EQ(of_one([&] { static_cast<void>(transform(C.R, M)); }), (PerHinge{54, 36}));
  EXPECT_EQ(of_one([&] { static_cast<void>(transform(C.r, M)); }), (PerHinge{23, 23}));
}

TEST(OperationCounts, NoOperationCountsWithinAnother) {
  Counted::count() = {};
  static_cast<void>(transform(SE3<Counted>{}, Inertia<Counted>{}));
  EXPECT_EQ(Counted::count().screws, (Screws{0, 0, 0, 1, 0, 0, 0}));
  static_cast<void>(ad(Twist<Spatial, Counted>{}, Twist<Spatial, Counted>{}));
  EXPECT_EQ(Counted::count().screws, (Screws{0, 0, 0, 1, 0, 0, 1}));
}

}  // namespace
}  // namespace axode::test
