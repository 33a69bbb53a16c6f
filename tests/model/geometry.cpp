#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "axode/dynamics.hpp"
#include "axode/kinematics/higher_order/product_of_exponentials.hpp"
#include "tests/model/random_mechanism.hpp"

/// The three ways to give the geometry of a mechanism lead to the same model.
namespace axode::test {
namespace {

constexpr double rounding = 1e-13;
const std::vector<JointKind> kinds_with_one_screw =
    kinds_that([](const JointTraits& it) { return it.dof < 2 || it.chain; });
const std::vector<JointKind> kinds_that_stay_whole =
    kinds_that([](const JointTraits& it) { return !it.chain; });

Way any_way(Random<double>& random) { return ways[static_cast<std::size_t>(random.number(0, 3))]; }

void expect_equal_trees(const Tree<double>& a, const Tree<double>& b) {
  EXPECT_EQ(a->parent, b->parent);
  EXPECT_EQ(a->by_kind, b->by_kind);
  EXPECT_EQ(a->iq, b->iq);
  EXPECT_EQ(a->iv, b->iv);
  EXPECT_EQ(a.pitch, b.pitch);
  EXPECT_EQ(a->frame_body, b->frame_body);
  for (int i = 0; i <= a->n; ++i) {
    EXPECT_LE(distance(a.B[i], b.B[i]), rounding);
    EXPECT_LE(distance(a.M[i], b.M[i]), 10 * rounding);
  }
  for (int f = 0; f < a->n_frames(); ++f) EXPECT_LE(distance(a.frame_offset[f], b.frame_offset[f]), rounding);
}

/// Expects the same A, B, screws and inertia of every body and the same pose of every frame, because all of
/// these refer to the frames of the user.
void expect_equal_bodies(const Model& a, const Model& b) {
  ASSERT_EQ(a.n_bodies(), b.n_bodies());
  ASSERT_EQ(a.n_frames(), b.n_frames());
  for (int i = 0; i <= a.n_bodies(); ++i) {
    const Body &x = a.body(i), &y = b.body(i);
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.predecessor, y.predecessor);
    EXPECT_LE(distance(x.A, y.A), rounding) << x.name;
    EXPECT_LE(distance(x.B, y.B), rounding) << x.name;
    EXPECT_LE(distance(x.M, y.M), 10 * rounding) << x.name;
    ASSERT_EQ(x.X.size(), y.X.size());
    for (std::size_t k = 0; k < x.X.size(); ++k) EXPECT_LE(distance(x.X[k], y.X[k]), rounding) << x.name;
  }
  for (int f = 0; f < a.n_frames(); ++f) EXPECT_LE(distance(a.frame(f).pose, b.frame(f).pose), rounding);
}
void expect_equal_joint_frames(const Model& a, const Model& b) {
  for (int i = 1; i <= a.n_bodies(); ++i) {
    EXPECT_LE(distance(a.body(i).S_prev, b.body(i).S_prev), rounding) << a.body(i).name;
    EXPECT_LE(distance(a.body(i).S_self, b.body(i).S_self), rounding) << a.body(i).name;
  }
}

TEST(Geometry, TheThreeWaysGiveOneMechanism) {
  Random<double> random(11);
  for (int trial = 0; trial < 100; ++trial) {
    const Description drawn = random_tree(random, 8, kinds_with_one_screw);
    const Model reference = ModelBuilder(drawn).build();
    for (const Way way : ways)
      expect_equal_bodies(ModelBuilder(described(drawn, random, [&](auto) { return way; })).build(),
                          reference);
    expect_equal_bodies(ModelBuilder(described(drawn, random, [&](auto) { return any_way(random); })).build(),
                        reference);
  }
}

TEST(Geometry, TheThreeWaysMoveAlikeAndNeedTheSameForces) {
  Random<double> random(12);
  for (int trial = 0; trial < 50; ++trial) {
    const Description drawn = random_tree(random, 8, kinds_with_one_screw);
    const Model a = ModelBuilder(drawn).build();
    const Model b = ModelBuilder(described(drawn, random, [&](auto) { return any_way(random); })).build();
    Workspace<double> workspace(a);
    const std::vector<double> q = random_numbers(random, a.nq(), 3), v = random_numbers(random, a.nv()),
                              dv = random_numbers(random, a.nv());
    std::vector<SE3<>> C_a(a.n_frames()), C_b(a.n_frames());
    poses(a, workspace, q, C_a);
    poses(b, workspace, q, C_b);
    for (int f = 0; f < a.n_frames(); ++f) EXPECT_LE(distance(C_a[f], C_b[f]), 100 * rounding);
    std::vector<double> tau_a(a.nv()), tau_b(a.nv());
    inverse_dynamics(a, workspace, q, v, dv, tau_a);
    inverse_dynamics(b, workspace, q, v, dv, tau_b);
    EXPECT_LE(distance(tau_a, tau_b), 1e-10 * (1 + size(tau_a)));
  }
}

TEST(Geometry, TheJointFramesOfAModelGiveItAgain) {
  Random<double> random(13);
  for (int trial = 0; trial < 50; ++trial) {
    const Description drawn = random_tree(random, 8, kinds_that_stay_whole);
    const Model reference = ModelBuilder(drawn).build();
    Description again = drawn;
    for (BodyDescription& body : again.bodies) {
      if (body.joint.kind == JointKind::fixed) continue;
      const Body& built = reference.body(reference.body_index(body.name));
      const SE3<> J = built.A * built.S_self;
      body = described(body, Way::joint_frames, reference_pose(drawn, body.predecessor), J);
      body.joint.axis = {0, 0, 2};
      body.joint.point = {};
    }
    const Model model = ModelBuilder(again).build();
    expect_equal_bodies(model, reference);
    expect_equal_joint_frames(model, reference);
    expect_equal_trees(model.tree<double>(), reference.tree<double>());
  }
}

TEST(Geometry, WhereNoBodyFrameIsTurnedTheThreeWaysGiveOneTree) {
  Random<double> random(14);
  for (int trial = 0; trial < 50; ++trial) {
    Description drawn = random_tree(random, 8, all_kinds);
    for (BodyDescription& body : drawn.bodies) body.geometry = InConstructionFrame{{{}, random.vector()}};
    const Model reference = ModelBuilder(drawn).build();
    Description mixed = drawn;
    for (std::size_t i = 0; i < mixed.bodies.size(); ++i)
      mixed.bodies[i] = described(drawn.bodies[i], any_way(random),
                                  reference_pose(drawn, drawn.bodies[i].predecessor), {{}, random.vector()});
    const Model model = ModelBuilder(mixed).build();
    expect_equal_bodies(model, reference);
    expect_equal_joint_frames(model, reference);
    expect_equal_trees(model.tree<double>(), reference.tree<double>());
  }
}

TEST(Geometry, ScrewsAreThoseOfTheDrawnAxes) {
  Random<double> random(15);
  const Description drawn = random_tree(random, 400, one_dof_kinds);
  const Model model = ModelBuilder(described(drawn, random, [&](auto) { return any_way(random); })).build();
  ASSERT_EQ(model.n_bodies(), 400);
  for (const BodyDescription& from : drawn.bodies) {
    const Body& body = model.body(model.body_index(from.name));
    const Vec3<> e = (1 / norm(from.joint.axis)) * from.joint.axis;
    const Screw<> Y = from.joint.kind == JointKind::prismatic ? Screw<>{{}, e}
                                                              : screw(e, from.joint.point, from.joint.pitch);
    ASSERT_EQ(body.X.size(), 1u);
    EXPECT_LE(distance(Ad(body.A, body.X[0]), Y), rounding) << "Y = Ad_A X";
  }
}

TEST(Geometry, AxesMayHaveAnyLength) {
  Random<double> random(16);
  for (const double length : {5e-324, 1e-310, 1e-200, 1e-3, 1.0, 7.0, 1e200, 1.7e308}) {
    for (const JointKind kind :
         {JointKind::revolute, JointKind::prismatic, JointKind::helical, JointKind::planar}) {
      BodyDescription body = random_body(random, 0, "ground", kind);
      body.geometry = InConstructionFrame{};
      body.joint.axis = {0, 0.6, -0.8};
      const Model unit = ModelBuilder().add(body).build();
      body.joint.axis = {0, 0.6 * length, -0.8 * length};
      if (length < 1e-320) body.joint.axis = {0, length, -length};
      const Model model = ModelBuilder().add(body).build();
      const Vec3<> z = model.body(1).S_self.R.z;
      EXPECT_NEAR(norm(z), 1, 1e-15);
      if (length > 1e-305) {
        EXPECT_LE(distance(model.body(1).S_self, unit.body(1).S_self), rounding) << length;
      }
      EXPECT_LE(distance(transpose(model.body(1).S_self.R) * model.body(1).S_self.R, SO3<>{}), rounding);
    }
  }
}

TEST(Geometry, ReferencePosesAreOneWithTheJointFrames) {
  Random<double> random(17);
  const Description drawn = random_tree(random, 300, kinds_that_stay_whole);
  const Model model = ModelBuilder(described(drawn, random, [&](auto) { return any_way(random); })).build();
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    const SE3<> A_predecessor = model.body(body.predecessor).A;
    EXPECT_LE(distance(body.B, body.S_prev * inverse(body.S_self)), rounding) << "B = S_prev S_self⁻¹";
    EXPECT_LE(distance(body.A, A_predecessor * body.B), 10 * rounding) << "A_i = A_p B_i";
    EXPECT_LE(distance(body.A, reference_pose(drawn, body.name)), 10 * rounding);
  }
}

TEST(Geometry, InternalFramesLieOnTheAxes) {
  Random<double> random(18);
  const Model model = ModelBuilder(described(random_tree(random, 300, all_kinds), random, [&](auto) {
                        return any_way(random);
                      })).build();
  for (int i = 1; i <= model.n_bodies(); ++i) {
    const Body& body = model.body(i);
    const Joint& joint = model.joint(i);
    const double h = joint.pitch;
    const Vec3<> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, o{};
    std::vector<Screw<>> S;
    switch (joint.kind) {
      case Subgroup::revolute: S = {{z, o}}; break;
      case Subgroup::prismatic: S = {{o, z}}; break;
      case Subgroup::helical: S = {{z, h * z}}; break;
      case Subgroup::spherical: S = {{x, o}, {y, o}, {z, o}}; break;
      case Subgroup::planar: S = {{z, o}, {o, x}, {o, y}}; break;
      case Subgroup::free: S = {{x, o}, {y, o}, {z, o}, {o, x}, {o, y}, {o, z}}; break;
    }
    ASSERT_EQ(body.X.size(), S.size());
    for (std::size_t k = 0; k < S.size(); ++k)
      EXPECT_LE(distance(Ad_inv(body.S_self, body.X[k]), S[k]), rounding) << body.name;
    EXPECT_LE(distance(model.tree<double>().frame_offset[i], inverse(body.S_self)), rounding);
  }
}

TEST(Geometry, PosesFollowTheProductOfExponentials) {
  Random<double> random(19);
  for (int trial = 0; trial < 50; ++trial) {
    const Model model = ModelBuilder(described(random_tree(random, 12, all_kinds), random, [&](auto) {
                          return any_way(random);
                        })).build();
    Workspace<double> workspace(model);
    const std::vector<double> q = random_configuration(model, static_cast<std::uint64_t>(trial));
    std::vector<SE3<>> C(model.n_frames());
    poses(model, workspace, q, C);
    const std::vector<SE3<>> by_X = poses_by_body_screws(model, q.data()),
                             by_Y = poses_by_spatial_screws(model, q.data());
    for (int i = 0; i <= model.n_bodies(); ++i) {
      EXPECT_LE(distance(C[i], by_X[i]), 100 * rounding);
      EXPECT_LE(distance(C[i], by_Y[i]), 100 * rounding);
    }
  }
}

// ----------------------------------------------------------- which frame the joint frame keeps its axes from

/// Calls f(joint frame, body) for a joint whose geometry is given in each of the ways. The joint frame is
/// expressed in the frame in which the axis was given.
void each_joint_frame(const JointDescription& joint,
                      const std::function<void(const SE3<>& J, const Body& body)>& f) {
  Random<double> random(20);
  const SE3<> A = random.pose(), S_prev = random.pose(), S_self = random.pose();
  const auto built = [&](const Geometry& geometry) {
    return ModelBuilder()
        .add({.name = "b", .joint = joint, .geometry = geometry, .inertia = MassProperties{.mass = 1}})
        .build();
  };
  const Model in_construction = built(InConstructionFrame{A}), in_body = built(InBodyFrame{A}),
              in_joint = built(InJointFrames{S_prev, S_self});
  f(A * in_construction.body(1).S_self, in_construction.body(1));
  f(in_body.body(1).S_self, in_body.body(1));
  f(inverse(S_self) * in_joint.body(1).S_self, in_joint.body(1));
}

TEST(Geometry, ThePlaneKeepsItsAxesByTheShortestTurnFromTheGivenFrame) {
  Random<double> random(21);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3<> n = random.direction(), p = random.vector();
    const JointKind kind = trial % 2 ? JointKind::planar : JointKind::revolute;
    each_joint_frame({.kind = kind, .axis = 3.0 * n, .point = p}, [&](const SE3<>& J, const Body&) {
      EXPECT_LE(distance(J.R.z, n), rounding);
      EXPECT_LE(distance(J.r, p), 10 * rounding);
      const Vec3<> turn = log_SO3(J.R);
      EXPECT_NEAR(turn.z, 0, rounding) << "about an axis normal to e_z";
      EXPECT_NEAR(norm(turn), std::acos(n.z), 1e-7) << "by no more than needed";
    });
  }
}

TEST(Geometry, ThePlaneOfCommonNormals) {
  const auto axes = [](const Vec3<>& n, const Vec3<>& x, const Vec3<>& y) {
    each_joint_frame({.kind = JointKind::planar, .axis = n}, [&](const SE3<>& J, const Body&) {
      EXPECT_LE(distance(J.R.x, x), rounding);
      EXPECT_LE(distance(J.R.y, y), rounding);
    });
  };
  axes({0, 0, 1}, {1, 0, 0}, {0, 1, 0});
  axes({0, 0, -2}, {1, 0, 0}, {0, -1, 0});  // half a turn about e_x
  axes({5, 0, 0}, {0, 0, -1}, {0, 1, 0});
  axes({0, 1, 0}, {1, 0, 0}, {0, 0, -1});
}

TEST(Geometry, NormalsNearMinusZKeepTheirPrecision) {
  for (const double tilt : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 0.0}) {
    const Vec3<> n{tilt, -2 * tilt, -1};
    each_joint_frame({.kind = JointKind::planar, .axis = n}, [&](const SE3<>& J, const Body&) {
      EXPECT_LE(distance(J.R.z, (1 / norm(n)) * n), rounding) << tilt;
      EXPECT_LE(distance(transpose(J.R) * J.R, SO3<>{}), rounding) << tilt;
    });
  }
}

TEST(Geometry, ASphericalJointKeepsTheAxesOfTheGivenFrame) {
  const Vec3<> p{0.1, -0.2, 0.3};
  each_joint_frame({.kind = JointKind::spherical, .axis = {1, 2, 3}, .point = p},
                   [&](const SE3<>& J, const Body&) {
                     EXPECT_LE(distance(J, SE3<>{{}, p}), rounding);
                   });
}

TEST(Geometry, AFreeJointIsTheBodyFrame) {
  each_joint_frame({.kind = JointKind::free, .axis = {1, 2, 3}, .point = {4, 5, 6}},
                   [&](const SE3<>&, const Body& body) {
                     EXPECT_EQ(distance(body.S_self, SE3<>{}), 0);
                     EXPECT_LE(distance(body.S_prev, body.B), 0);
                   });
}

// ------------------------------------------------------------------------------------------------- inertia

TEST(Geometry, InertiaIsOneHoweverItIsGiven) {
  Random<double> random(22);
  for (int trial = 0; trial < 100; ++trial) {
    const SE3<> A = random.pose();
    const Inertia<> M = random.inertia();  // expressed in the body frame
    for (const GivenIn in : {GivenIn::body_frame, GivenIn::construction_frame})
      for (const InertiaAbout about : {InertiaAbout::center_of_mass, InertiaAbout::frame_origin})
        for (const bool turned : {false, true}) {
          const Inertia<> in_frame = in == GivenIn::body_frame ? M : transform(A, M);
          const Sym3<> Theta =
              about == InertiaAbout::center_of_mass ? inertia_about_com(in_frame) : in_frame.Theta;
          const SO3<> axes = turned ? random.rotation() : SO3<>{};
          const Model model = ModelBuilder()
                                  .add({.name = "b",
                                        .joint = {.kind = JointKind::revolute, .axis = random.direction()},
                                        .geometry = InConstructionFrame{A},
                                        .inertia = MassProperties{.mass = M.m,
                                                                  .com = center_of_mass(in_frame),
                                                                  .Theta = rotate(transpose(axes), Theta),
                                                                  .in = in,
                                                                  .about = about,
                                                                  .axes = axes}})
                                  .build();
          EXPECT_LE(distance(model.body(1).M, M), 1e-12);
          EXPECT_LE(distance(model.tree<double>().M[1], transform(inverse(model.body(1).S_self), M)), 1e-12)
              << "and in the internal frame";
        }
  }
}

TEST(Geometry, TheFloatTreeIsTheDoubleOneRounded) {
  Random<double> random(23);
  const Model model = ModelBuilder(random_tree(random, 30, all_kinds)).build();
  const Tree<double>& a = model.tree<double>();
  const Tree<float>& b = model.tree<float>();
  EXPECT_EQ(a->parent, b->parent);
  EXPECT_EQ(a->iq, b->iq);
  for (int i = 0; i <= a->n; ++i) {
    EXPECT_EQ(static_cast<float>(a.B[i].r.x), b.B[i].r.x);
    EXPECT_EQ(static_cast<float>(a.B[i].R.y.z), b.B[i].R.y.z);
    EXPECT_EQ(static_cast<float>(a.M[i].Theta.xy), b.M[i].Theta.xy);
    EXPECT_EQ(static_cast<float>(a.pitch[i]), b.pitch[i]);
  }
}

}  // namespace
}  // namespace axode::test
