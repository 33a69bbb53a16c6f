#include <cmath>
#include <sstream>

#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "axode/model.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/support/comparison.hpp"

/// Where a mechanism is drawn does not matter: a light one ten kilometres from the origin of the construction frame is
/// the one at the origin.
namespace axode::test {
namespace {

/// Where body frames are: all in the construction frame, each in its joint, or each turned somewhere near its body.
enum class BodyFrames { construction, joints, turned };
/// In which frame inertias are given, about the centre of mass.
using Inertias = GivenIn;

/// A palm, and a finger of 10 g with two links, a pad that is fixed to it and a ball at its end, drawn at o. All lengths
/// are sums of few powers of two, so that they are exact wherever o is.
Description hand(const Vec3<>& o, BodyFrames frames, Inertias inertias) {
  Description hand{.name = "hand"};
  const auto add = [&](const char* name, const char* on, JointKind kind, const Vec3<>& axis,
                       const Vec3<>& point, double mass, const Vec3<>& com, double size) {
    const SE3<> turned{exp_SO3(Vec3<>{0.3, -0.2, 0.1}), o + point + Vec3<>{1. / 256, 0, 1. / 128}};
    const SE3<> A = frames == BodyFrames::construction ? SE3<>{}
                    : frames == BodyFrames::joints     ? SE3<>{{}, o + point}
                                                       : turned;
    const bool in_body = inertias == GivenIn::body_frame;
    hand.bodies.push_back(
        {.name = name,
         .predecessor = on,
         .joint = {.name = std::string(name) + " joint", .kind = kind, .axis = axis, .point = o + point},
         .geometry = InConstructionFrame{A},
         .inertia = MassProperties{.mass = mass,
                                   .com = in_body ? transpose(A.R) * ((o - A.r) + com) : o + com,
                                   .Theta = mass * size * size * Sym3<>{1, 0.8, 0.5, 0.1, 0, 0.2},
                                   .in = inertias,
                                   .axes = in_body ? transpose(A.R) : SO3<>{}}});
  };
  add("palm", "ground", JointKind::revolute, {0, 0, 1}, {}, 0.4, {1. / 32, 0, 1. / 64}, 0.04);
  add("link", "palm", JointKind::revolute, {1, 0, 0}, {1. / 16, 0, 0}, 0.01, {1. / 16, 1. / 64, 0}, 0.01);
  add("tip", "link", JointKind::revolute, {1, 0.5, 0}, {1. / 16, 1. / 32, 0}, 0.004, {1. / 16, 3. / 64, 0},
      0.005);
  add("pad", "tip", JointKind::fixed, {0, 0, 1}, {}, 0.001, {1. / 16, 1. / 16, 1. / 256}, 0.002);
  add("ball", "pad", JointKind::spherical, {0, 0, 1}, {1. / 16, 5. / 64, 0}, 0.002, {1. / 16, 6. / 64, 0},
      0.004);
  return hand;
}

/// Their dynamics agree, in all representations whose quantities are not about the origin itself.
void expect_same_dynamics(const Model& far, const Model& near, Random<double>& random) {
  ASSERT_EQ(far.nv(), near.nv());
  const std::size_t nv = static_cast<std::size_t>(near.nv());
  const std::vector<double> q = random_configuration(near, 7);
  std::vector<double> v(nv), a(nv), tau(nv), expected(nv), M(nv * nv), M_expected(nv * nv);
  for (std::size_t c = 0; c < nv; ++c) v[c] = random.number(-1, 1), a[c] = random.number(-1, 1);
  Workspace<> workspace(near), far_workspace(far);
  Comparison force("force", 1e-13);
  const auto compare = [&](auto representation) {
    using Rep = decltype(representation);
    inverse_dynamics<Rep>(near, workspace, q, v, a, expected);
    inverse_dynamics<Rep>(far, far_workspace, q, v, a, tau);
    force.expect_equal(tau, expected);
    mass_matrix<Rep>(near, workspace, q, M_expected);
    mass_matrix<Rep>(far, far_workspace, q, M);
    for (std::size_t r = 0; r < nv; ++r)  // each entry as its own row and column let it be known
      for (std::size_t c = 0; c < nv; ++c)
        EXPECT_NEAR(M[r * nv + c], M_expected[r * nv + c],
                    1e-13 * std::sqrt(M_expected[r * nv + r] * M_expected[c * nv + c]));
  };
  compare(Fast{}), compare(BodyFixed{}), compare(Hybrid{}), compare(Mixed{});
}

/// law(at o, at the origin) for every way to draw the hand, from near to far.
template <class Law> void for_hands(const Law& law) {
  for (const double o : {0., 1., 100., 10'000.})
    for (const BodyFrames frames : {BodyFrames::construction, BodyFrames::joints, BodyFrames::turned})
      for (const Inertias inertias : {GivenIn::construction_frame, GivenIn::body_frame}) {
        SCOPED_TRACE("at " + std::to_string(o) + " m, body frames " +
                     std::to_string(static_cast<int>(frames)) + ", inertias " +
                     std::to_string(static_cast<int>(inertias)));
        law(hand({o, -o, o / 2}, frames, inertias), hand({}, frames, inertias));
      }
}

TEST(FarFromTheOrigin, DynamicsAreThoseAtTheOrigin) {
  Random<double> random(1);
  for_hands([&](const Description& far, const Description& near) {
    expect_same_dynamics(ModelBuilder(far).build(), ModelBuilder(near).build(), random);
  });
}

TEST(FarFromTheOrigin, LockedJointsLoseNothing) {
  Random<double> random(2);
  for_hands([&](const Description& far, const Description& near) {
    const Model all_far = ModelBuilder(far).build(), all_near = ModelBuilder(near).build();
    const std::vector<double> q = random_configuration(all_near, 3);
    using Names = std::vector<std::string_view>;
    for (const Names& locked :
         {Names{"palm joint"}, Names{"link joint"}, Names{"tip joint"}, Names{"ball joint"},
          Names{"link joint", "tip joint"}, Names{"palm joint", "tip joint"}}) {
      SCOPED_TRACE(locked.front());
      const Model less_far = reduced(all_far, locked, q), less_near = reduced(all_near, locked, q);
      expect_same_dynamics(less_far, less_near, random);
      const std::string_view last = less_near.joint(1).name;  // and once more
      expect_same_dynamics(reduced(less_far, {&last, 1}, neutral(less_far)),
                           reduced(less_near, {&last, 1}, neutral(less_near)), random);
    }
  });
}

TEST(FarFromTheOrigin, ADrawingLosesNothing) {
  Random<double> random(3);
  for_hands([&](const Description& far, const Description& near) {
    if (far.bodies[0].inertia->in == GivenIn::body_frame)
      return;  // a drawing has them in the construction frame
    std::stringstream drawing;
    write_drawing(ModelBuilder(far).build(), drawing);
    expect_same_dynamics(ModelBuilder(read_drawing_text(drawing.str(), "hand.toml")).build(),
                         ModelBuilder(near).build(), random);
  });
}

}  // namespace
}  // namespace axode::test
