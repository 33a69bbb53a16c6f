#include <array>
#include <cmath>
#include <sstream>

#include "axode/derivatives.hpp"
#include "axode/dynamics.hpp"
#include "axode/io.hpp"
#include "axode/model.hpp"
#include "axode/model/building/edited.hpp"
#include "axode/model/kinds/joint_kinds.hpp"
#include "tests/lie/random_quantities.hpp"
#include "tests/support/comparison.hpp"

/// The place where a mechanism is drawn does not matter: a light mechanism ten kilometres from the origin of
/// the construction frame moves like the same one at the origin.
namespace axode::test {
namespace {

/// Where the body frames are: all at the construction frame, each at its joint, or each near its body and
/// turned.
enum class BodyFrames { construction, joints, turned };
/// The frame in which inertias about the centre of mass are given.
using Inertias = GivenIn;

/// A hand that is drawn at o: a palm, and a finger of 10 g with two links, a pad that is fixed to it and a
/// ball at its end. All lengths are sums of few powers of two, so that they are represented exactly wherever
/// o is. The joint of the tip may have any kind; the drawing of a prismatic one has no point.
Description hand(const Vec3<>& o, BodyFrames frames, Inertias inertias,
                 JointKind of_tip = JointKind::revolute) {
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
         .joint = {.name = std::string(name) + " joint",
                   .kind = kind,
                   .axis = axis,
                   .second_axis = {-0.5, 1, 0},
                   .point = kind == JointKind::prismatic ? Vec3<>{} : o + point,
                   .pitch = kind == JointKind::helical ? 1. / 64 : 0},
         .geometry = InConstructionFrame{A},
         .inertia = MassProperties{.mass = mass,
                                   .com = in_body ? transpose(A.R) * ((o - A.r) + com) : o + com,
                                   .Theta = mass * size * size * Sym3<>{1, 0.8, 0.5, 0.1, 0, 0.2},
                                   .in = inertias,
                                   .axes = in_body ? transpose(A.R) : SO3<>{}}});
  };
  add("palm", "ground", JointKind::revolute, {0, 0, 1}, {}, 0.4, {1. / 32, 0, 1. / 64}, 0.04);
  add("link", "palm", JointKind::revolute, {1, 0, 0}, {1. / 16, 0, 0}, 0.01, {1. / 16, 1. / 64, 0}, 0.01);
  add("tip", "link", of_tip, {1, 0.5, 0}, {1. / 16, 1. / 32, 0}, 0.004, {1. / 16, 3. / 64, 0}, 0.005);
  add("pad", "tip", JointKind::fixed, {0, 0, 1}, {}, 0.001, {1. / 16, 1. / 16, 1. / 256}, 0.002);
  add("ball", "pad", JointKind::spherical, {0, 0, 1}, {1. / 16, 5. / 64, 0}, 0.002, {1. / 16, 6. / 64, 0},
      0.004);
  return hand;
}

/// Expects the same dynamics of both models, in all representations whose quantities are not about the
/// inertial origin. Solutions of linear systems have the larger bound `solved`, because the masses of the
/// bodies differ by two orders of magnitude.
void expect_same_dynamics(const Model& far, const Model& near, Random<double>& random, double bound = 1e-13) {
  constexpr double solved = 1e-9;
  ASSERT_EQ(far.nv(), near.nv());
  const std::size_t nv = static_cast<std::size_t>(near.nv());
  const std::vector<double> q = random_configuration(near, 7);
  std::vector<double> v(nv), a(nv), tau(nv), expected(nv), M(nv * nv), M_expected(nv * nv);
  for (std::size_t c = 0; c < nv; ++c) v[c] = random.number(-1, 1), a[c] = random.number(-1, 1);
  Workspace<> workspace(near), far_workspace(far);
  Comparison force("force", bound);
  const auto compare = [&](auto representation) {
    using Rep = decltype(representation);
    inverse_dynamics<Rep>(near, workspace, q, v, a, expected);
    inverse_dynamics<Rep>(far, far_workspace, q, v, a, tau);
    force.expect_equal(tau, expected);
    mass_matrix<Rep>(near, workspace, q, M_expected);
    mass_matrix<Rep>(far, far_workspace, q, M);
    for (std::size_t r = 0; r < nv; ++r)  // an entry is compared relative to the diagonal entries of its row
                                          // and column
      for (std::size_t c = 0; c < nv; ++c)
        EXPECT_NEAR(M[r * nv + c], M_expected[r * nv + c],
                    bound * std::sqrt(M_expected[r * nv + r] * M_expected[c * nv + c]));
  };
  compare(Fast{}), compare(BodyFixed{}), compare(Hybrid{}), compare(Mixed{});

  std::vector<double> acceleration(nv), acceleration_expected(nv);
  ASSERT_TRUE(forward_dynamics(near, workspace, q, v, expected, acceleration_expected).ok());
  ASSERT_TRUE(forward_dynamics(far, far_workspace, q, v, expected, acceleration).ok());
  Comparison("acceleration", solved).expect_equal(acceleration, acceleration_expected);
  std::array<std::vector<double>, 6> of_far, of_near;
  for (auto* all : {&of_far, &of_near})
    for (std::vector<double>& matrix : *all) matrix.resize(nv * nv);
  const auto derivatives = [&](const Model& model, Workspace<>& its, auto& out) {
    inverse_dynamics_derivatives<double>(model, its, q, v, a, {.q = out[0], .v = out[1], .a = out[2]});
    EXPECT_TRUE(forward_dynamics_derivatives<double>(model, its, q, v, expected,
                                                     {.q = out[3], .v = out[4], .tau = out[5]})
                    .ok());
  };
  derivatives(near, workspace, of_near), derivatives(far, far_workspace, of_far);
  for (std::size_t k = 0; k < of_far.size(); ++k)
    Comparison("derivative", k < 3 ? bound : solved).expect_equal(of_far[k], of_near[k]);
}

/// Calls law(the hand at o, the hand at the origin) for every way to draw it and for places from near to far.
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

TEST(FarFromTheOrigin, JointsOfEveryKindLoseNothing) {
  Random<double> random(4);
  for (const JointTraits& kind : joint_kinds)
    for (const double o : {1., 100., 10'000.})
      for (const BodyFrames frames : {BodyFrames::construction, BodyFrames::joints, BodyFrames::turned})
        for (const Inertias inertias : {GivenIn::construction_frame, GivenIn::body_frame}) {
          // The coordinates of a free joint describe its body frame, so that this frame must be near the
          // body.
          if (kind.kind == JointKind::free && frames == BodyFrames::construction) continue;
          SCOPED_TRACE(std::string(kind.name) + " at " + std::to_string(o) + " m, body frames " +
                       std::to_string(static_cast<int>(frames)));
          const auto drawn_at = [&](const Vec3<>& origin) {
            return hand(origin, frames, inertias, kind.kind);
          };
          const Vec3<> away{o, -o, o / 2};
          expect_same_dynamics(ModelBuilder(drawn_at(away)).build(), ModelBuilder(drawn_at({})).build(),
                               random, 1e-12);
          expect_same_dynamics(
              append(ModelBuilder("nothing").build(), "ground", ModelBuilder(drawn_at(away)).build()),
              ModelBuilder(drawn_at({})).build(), random, 1e-12);
        }
}

TEST(FarFromTheOrigin, AMasslessSlideLosesNothing) {
  Random<double> random(5);
  const auto gantry = [](const Vec3<>& o) {
    Description all = hand(o, BodyFrames::construction, GivenIn::construction_frame, JointKind::prismatic);
    all.bodies.insert(all.bodies.begin() + 3, all.bodies[2]);
    all.bodies[2].name = "cross slide", all.bodies[2].joint.name = "", all.bodies[2].inertia.reset();
    all.bodies[2].joint.axis = {0, 0, 1};
    all.bodies[3].predecessor = "cross slide";
    return ModelBuilder(all).build();
  };
  for (const double o : {1., 100., 10'000.}) expect_same_dynamics(gantry({o, -o, o / 2}), gantry({}), random);
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
      const std::string_view last = less_near.joint(1).name;  // lock one more joint
      expect_same_dynamics(reduced(less_far, {&last, 1}, neutral(less_far)),
                           reduced(less_near, {&last, 1}, neutral(less_near)), random);
    }
  });
}

TEST(FarFromTheOrigin, ADrawingLosesNothing) {
  Random<double> random(3);
  for_hands([&](const Description& far, const Description& near) {
    if (far.bodies[0].inertia->in == GivenIn::body_frame)
      return;  // drawings are written with inertias in the construction frame
    std::stringstream drawing;
    write_drawing(ModelBuilder(far).build(), drawing);
    expect_same_dynamics(ModelBuilder(read_drawing_text(drawing.str(), "hand.toml")).build(),
                         ModelBuilder(near).build(), random);
  });
}

}  // namespace
}  // namespace axode::test
