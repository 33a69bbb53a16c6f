#include "apps/framed_tree.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/forward_dynamics.hpp"
#include "axode/recursion/momentum.hpp"
#include "axode/scalar/counted.hpp"
#include "tests/laws/law.hpp"

/// What the kernels cost: operations on numbers and on screws, in each representation and choice of body frames.
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

Tree<Counted> counting(const Model& model) { return cast<Counted>(model.tree<double>()); }

/// The operations of f(kernel, q, x, out, out2) on numbers that count.
template <class Kernel, class AnyTree, class F> Operations operations_of(const AnyTree& tree, const F& f) {
  WithScratch<Counted, Kernel> kernel(*tree.operator->());
  const std::vector<Counted> q(static_cast<std::size_t>(tree->nq), 0.3),
      x(static_cast<std::size_t>(tree->nv), 0.2);
  std::vector<Counted> out(x.size() * x.size()), out2(x.size());
  Counted::count() = {};
  f(*kernel, q.data(), x.data(), out.data(), out2.data());
  return Counted::count();
}

template <class Rep, class AnyTree> Operations of_accelerations(const AnyTree& tree) {
  return operations_of<TreeMotion<Rep, Counted>>(
      tree, [&](auto& motion, auto* q, auto* x, auto*, auto*) { motion.run(tree, q, x, x); });
}
template <class Rep, class AnyTree> Operations of_inverse_dynamics(const AnyTree& tree) {
  return operations_of<InverseDynamicsRecursion<Rep, Counted>>(
      tree, [&](auto& recursion, auto* q, auto* x, auto* out, auto*) {
        recursion.run(tree, q, x, x, {});
        recursion.project(tree, x, x, false, out);
      });
}
template <class Rep, class AnyTree> Operations of_mass_matrix(const AnyTree& tree) {
  return operations_of<CompositeBodies<Rep, Counted>>(tree,
                                                      [&](auto& bodies, auto* q, auto*, auto* out, auto*) {
                                                        bodies.run(tree, q, tree.armature.data(), out);
                                                      });
}
template <class Rep, class AnyTree> Operations of_forward_dynamics(const AnyTree& tree) {
  return operations_of<ForwardDynamicsRecursion<Rep, Counted>>(
      tree, [&](auto& recursion, auto* q, auto* x, auto* out, auto*) {
        EXPECT_TRUE(recursion.run(tree, q, x, x, {}, out).ok());
      });
}
template <class AnyTree> Operations of_momentum_form(const AnyTree& tree) {
  return operations_of<MomentumForm<Counted>>(tree, [&](auto& form, auto* q, auto* x, auto* out, auto* out2) {
    EXPECT_TRUE(form.run(tree, q, x, x, {}, out, out2).ok());
  });
}

void record(const std::string& name, int n, const Operations& x) {
  testing::Test::RecordProperty(name + " n" + std::to_string(n), std::to_string(x.products) + " mul, " +
                                                                     std::to_string(x.sums) + " add, " +
                                                                     std::to_string(x.total()) + " in all");
}

TEST(OperationCounts, TheMomentumFormTakesFewerThanForwardDynamicsInSpatialTwists) {
  for (const int n : {7, 36, 100}) {
    const Tree<Counted> model = counting(chain(n));
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
  const Operations ten = of_forward_dynamics<BodyFixed>(counting(chain(10))),
                   twenty = of_forward_dynamics<BodyFixed>(counting(chain(20))),
                   thirty = of_forward_dynamics<BodyFixed>(counting(chain(30)));
  EXPECT_EQ(thirty.total() - twenty.total(), twenty.total() - ten.total());
}

/// f(tree) for a chain of n hinges in all four choices of body frames.
template <class F> void in_all_frames(int n, const F& f) {
  const Tree<Counted> tree = counting(chain(n));
  f(tree);
  f(FramedTree<Counted, UserFrames>(tree));
  f(FramedTree<Counted, MassCenterFrames>(tree));
  f(FramedTree<Counted, ConstructionFrames>(tree));
}

/// Operations on screws, in the order of ScrewOperation.
using Screws = std::array<long, n_screw_operations>;

/// Sections 4.1 to 4.3 of the paper count 3 (n - 1) frame transformations and 2 n - 1 brackets for body-fixed twists; n,
/// n of inertias and 2 n - 1 for spatial; 3 n - 3 translations, n rotations, n of inertias and 3 n - 1 for hybrid ones.
/// The kernels treat the ground as a body, which gravity accelerates: n instead of n - 1. And they transform S v, S a and
/// W of every joint instead of its screw: 3 n instead of n.
TEST(OperationCounts, OfInverseDynamicsAreThePapersWithTheGroundAsABody) {
  for (const int n : {1, 7, 36})
    in_all_frames(n, [n](const auto& tree) {
      EXPECT_EQ(of_inverse_dynamics<BodyFixed>(tree).screws, (Screws{3 * n, 0, 0, 0, 0, 0, 2 * n}));
      EXPECT_EQ(of_inverse_dynamics<Spatial>(tree).screws, (Screws{3 * n, 0, 0, n, 0, 0, 2 * n}));
      EXPECT_EQ(of_inverse_dynamics<Hybrid>(tree).screws, (Screws{0, 3 * n, 3 * n, 0, n, 0, 3 * n}));
      EXPECT_EQ(of_inverse_dynamics<Mixed>(tree).screws, (Screws{3 * n, 3 * n, 0, 0, 0, 0, 3 * n}));
    });
}

TEST(OperationCounts, OfAccelerationsAreThoseOfTheForwardRecursion) {
  for (const int n : {1, 7, 36})
    in_all_frames(n, [n](const auto& tree) {
      EXPECT_EQ(of_accelerations<BodyFixed>(tree).screws, (Screws{2 * n, 0, 0, 0, 0, 0, n}));
      EXPECT_EQ(of_accelerations<Spatial>(tree).screws, (Screws{2 * n, 0, 0, 0, 0, 0, n}));
      EXPECT_EQ(of_accelerations<Hybrid>(tree).screws, (Screws{0, 2 * n, 2 * n, 0, 0, 0, 2 * n}));
      EXPECT_EQ(of_accelerations<Mixed>(tree).screws, (Screws{2 * n, 2 * n, 0, 0, 0, 0, 2 * n}));
    });
}

TEST(OperationCounts, OfTheMassMatrixCarryEveryImpulseToTheRootUnlessTheyAreSpatial) {
  for (const int n : {1, 7, 36})
    in_all_frames(n, [n](const auto& tree) {
      const long pairs = n * (n - 1) / 2;
      EXPECT_EQ(of_mass_matrix<BodyFixed>(tree).screws, (Screws{pairs, 0, 0, n, 0, 0, 0}));
      EXPECT_EQ(of_mass_matrix<Spatial>(tree).screws, (Screws{n, 0, 0, n, 0, 0, 0}));
      EXPECT_EQ(of_mass_matrix<Hybrid>(tree).screws, (Screws{0, n, pairs, 0, n, n, 0}));
      EXPECT_EQ(of_mass_matrix<Mixed>(tree).screws, (Screws{pairs, n, 0, n, 0, 0, 0}));
    });
}

TEST(OperationCounts, OfForwardDynamicsTransformTwoInertiasPerBody) {
  for (const int n : {1, 7, 36})
    in_all_frames(n, [n](const auto& tree) {
      EXPECT_EQ(of_forward_dynamics<BodyFixed>(tree).screws, (Screws{5 * n, 0, 0, 2 * n, 0, 0, 2 * n}));
      EXPECT_EQ(of_forward_dynamics<Spatial>(tree).screws, (Screws{4 * n, 0, 0, 2 * n, 0, 0, 2 * n}));
      EXPECT_EQ(of_forward_dynamics<Hybrid>(tree).screws, (Screws{0, 4 * n, 5 * n, 0, 2 * n, 2 * n, 3 * n}));
      EXPECT_EQ(of_forward_dynamics<Mixed>(tree).screws, (Screws{5 * n, 4 * n, 0, 2 * n, 0, 0, 3 * n}));
    });
}

/// Products and sums of one hinge.
struct PerHinge {
  long products, sums;
  bool operator==(const PerHinge&) const = default;
  friend void PrintTo(const PerHinge& x, std::ostream* out) {
    *out << x.products << " mul, " << x.sums << " add";
  }
};
template <class Rep> std::vector<PerHinge> of_one_more_hinge(int n) {
  std::vector<PerHinge> out;
  in_all_frames(n, [&](const auto& tree) {
    const Operations x = of_inverse_dynamics<Rep>(tree);
    out.push_back({x.products, x.sums});
  });
  std::size_t k = 0;
  in_all_frames(n + 1, [&](const auto& tree) {
    const Operations x = of_inverse_dynamics<Rep>(tree);
    out[k] = {x.products - out[k].products, x.sums - out[k].sums};
    ++k;
  });
  return out;
}

/// In joint frames, the user's, at the centres of mass, in the construction frame; docs/comparative-study.md quotes them.
TEST(OperationCounts, OfInverseDynamicsPerHingeAreTheSameForEveryHinge) {
  for (const int n : {1, 6, 35}) {
    EXPECT_EQ(of_one_more_hinge<BodyFixed>(n),
              (std::vector<PerHinge>{{172, 152}, {202, 175}, {151, 130}, {193, 164}}));
    EXPECT_EQ(of_one_more_hinge<Spatial>(n),
              (std::vector<PerHinge>{{285, 238}, {315, 261}, {288, 234}, {306, 250}}));
    EXPECT_EQ(of_one_more_hinge<Hybrid>(n),
              (std::vector<PerHinge>{{256, 209}, {286, 232}, {226, 181}, {277, 221}}));
    EXPECT_EQ(of_one_more_hinge<Mixed>(n),
              (std::vector<PerHinge>{{247, 200}, {277, 223}, {217, 175}, {268, 212}}));
  }
}

/// What one transformation takes.
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
