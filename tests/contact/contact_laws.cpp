#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "axode/contact/convex/support.hpp"
#include "axode/contact/derivatives/contact_jet.hpp"
#include "axode/model/kinds/shape_kinds.hpp"
#include "tests/contact/two_shapes.hpp"
#include "tests/laws/law.hpp"

/// Laws of contact points, over all kinds of shapes and random poses.
namespace axode::test {
namespace {

using ::testing::HasSubstr;

std::string name_of_kind(ShapeKind kind) { return std::string(to_string(kind)); }

class KindPairs : public testing::TestWithParam<std::pair<ShapeKind, ShapeKind>> {};
std::vector<std::pair<ShapeKind, ShapeKind>> kind_pairs() {
  std::vector<std::pair<ShapeKind, ShapeKind>> all;
  for (const ShapeKind a : bounded_kinds)
    for (const ShapeKind b : bounded_kinds) all.emplace_back(a, b);
  return all;
}
INSTANTIATE_TEST_SUITE_P(Contact, KindPairs, testing::ValuesIn(kind_pairs()), [](const auto& pair) {
  return name_of_kind(pair.param.first) + "_" + name_of_kind(pair.param.second);
});

/// The distance of a point from a body.
double distance_from(const ConvexShape& body, const SE3<>& pose, const Vec3<>& point) {
  return convex_distance(body, pose, sphere_shape(0), SE3<>{{}, point}).distance;
}

TEST_P(KindPairs, TheLeastGapIsTheDistanceAndPointsAreBetweenTheSurfaces) {
  const auto [kind_a, kind_b] = GetParam();
  const bool boxes = kind_a == ShapeKind::box && kind_b == ShapeKind::box;
  const auto has_side = [](ShapeKind kind) {
    return kind == ShapeKind::cylinder || kind == ShapeKind::capsule;
  };
  const bool sides = has_side(kind_a) && has_side(kind_b);
  for_seeds(100, [&, kind_a = kind_a, kind_b = kind_b](std::uint64_t seed) {
    Random<double> random(seed);
    TwoShapes pair(random_collision_shape(random, kind_a), random_collision_shape(random, kind_b));
    const double size = pair.size(), margin = 0.01;
    const SE3<> A = random.pose();
    SE3<> B{random.rotation(), A.r + 2 * size * random.direction()};
    const ConvexDistance apart = pair.distance(A, B);
    const double gap = std::array{0.02, 0.005, 1e-5, 0.0, -1e-5, -0.01}[seed % 6];
    B.r += (gap - apart.distance) * apart.normal;
    const ConvexDistance d = pair.distance(A, B);
    const std::span<const ContactPoint> points = pair.find(A, B, margin);
    if (d.distance > margin) {
      EXPECT_EQ(points.size(), 0U);
      return;
    }
    ASSERT_GE(points.size(), 1U);
    const double tolerance = (boxes ? 2e-6 : 2e-8) * size;
    double least = margin;
    std::set<std::uint64_t> keys;
    for (const ContactPoint& p : points) {
      least = std::min(least, p.gap);
      EXPECT_TRUE(keys.insert(p.key).second) << "a key occurs twice";
      EXPECT_EQ(p.a, 0);
      EXPECT_EQ(p.b, 1);
      EXPECT_NEAR(norm(p.normal), 1, 1e-14);
      EXPECT_GT(p.gap, d.distance - (sides ? 1e-3 : tolerance));
      if (sides) continue;  // lines that lie beside each other across the normal, see clip()
      EXPECT_LT(distance_from(pair.shapes[0].convex, A, p.point - p.gap / 2 * p.normal), tolerance);
      EXPECT_LT(distance_from(pair.shapes[1].convex, B, p.point + p.gap / 2 * p.normal), tolerance);
    }
    EXPECT_NEAR(least, d.distance, tolerance);
  });
}

TEST_P(KindPairs, AMotionOfBothBodiesMovesThePointsAndKeepsTheKeys) {
  const auto [kind_a, kind_b] = GetParam();
  for_seeds(30, [&, kind_a = kind_a, kind_b = kind_b](std::uint64_t seed) {
    Random<double> random(seed);
    TwoShapes pair(random_collision_shape(random, kind_a), random_collision_shape(random, kind_b));
    const SE3<> A = random.pose(), motion = random.pose();
    SE3<> B{random.rotation(), A.r + 2 * pair.size() * random.direction()};
    const ConvexDistance apart = pair.distance(A, B);
    B.r += (-1e-3 - apart.distance) * apart.normal;
    const auto here = pair.find(A, B, 0.01);
    const std::vector<ContactPoint> before(here.begin(), here.end());
    const auto after = pair.find(motion * A, motion * B, 0.01);
    ASSERT_EQ(after.size(), before.size());
    for (std::size_t k = 0; k < before.size(); ++k) {
      EXPECT_EQ(after[k].key, before[k].key);
      EXPECT_NEAR(after[k].gap, before[k].gap, 1e-9);
      EXPECT_LT(norm(after[k].point - motion * before[k].point), 1e-7);
    }
  });
}

/// A shape that lies on the upper face of a large box with a tilt about the y-axis.
std::vector<ContactPoint> on_a_table(const ShapeDescription& shape, double height, const SO3<>& R,
                                     double tilt) {
  TwoShapes pair(collision_shape(ShapeKind::box, {4, 4, 0.5}, 0, 0), shape);
  const SO3<> turned = exp_SO3(Vec3<>{0, tilt, 0}) * R;
  const auto points = pair.find({{}, {0, 0, -0.25}}, {turned, {0.1, 0.2, height}}, 0.01);
  return {points.begin(), points.end()};
}

TEST(FlatContact, KeepsItsPointsAndKeysUnderSmallTilts) {
  struct Lying {
    ShapeDescription shape;
    double height;
    SO3<> R;
    std::size_t points;
  };
  const SO3<> down = exp_SO3(Vec3<>{0, std::acos(0.0), 0});
  const SO3<> turned = exp_SO3(Vec3<>{0, 0, 0.3});
  for (const Lying& it : {Lying{collision_shape(ShapeKind::box, {0.4, 0.3, 0.2}, 0, 0), 0.1, turned, 4},
                          Lying{collision_shape(ShapeKind::cylinder, {}, 0.2, 0.4), 0.2, down, 2},
                          Lying{collision_shape(ShapeKind::capsule, {}, 0.1, 0.4), 0.1, down, 2},
                          Lying{collision_shape(ShapeKind::cylinder, {}, 0.2, 0.4), 0.2, {}, 8}}) {
    SCOPED_TRACE(name_of_kind(it.shape.kind));
    const bool standing = it.points == 8;  // whose points turn with the lowest one
    std::set<std::uint64_t> keys;
    for (const ContactPoint& p : on_a_table(it.shape, it.height, it.R, 0)) keys.insert(p.key);
    EXPECT_EQ(keys.size(), it.points);
    for (const double tilt : {1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3}) {
      SCOPED_TRACE(tilt);
      const std::vector<ContactPoint> points = on_a_table(it.shape, it.height, it.R, tilt);
      EXPECT_EQ(points.size(), it.points);
      for (const ContactPoint& p : points) {
        EXPECT_NEAR(p.gap, -(p.point.x - 0.1) * tilt, 1e-6 + 1e-2 * tilt);
        EXPECT_TRUE(standing || keys.contains(p.key));
      }
    }
    EXPECT_LT(on_a_table(it.shape, it.height, it.R, 0.2).size(), it.points);
  }
}

TEST(FlatContact, OfTwoBoxesIsThatOfABoxAndAPlane) {
  const ShapeDescription box = collision_shape(ShapeKind::box, {0.4, 0.3, 0.2}, 0, 0);
  const SE3<> pose{exp_SO3(Vec3<>{0.01, 0.02, 0.5}), {0.1, 0.2, 0.105}};
  TwoShapes on_box(collision_shape(ShapeKind::box, {4, 4, 0.5}, 0, 0), box);
  TwoShapes on_plane(collision_shape(ShapeKind::plane, {}, 0, 0), box);
  const auto boxes = on_box.find({{}, {0, 0, -0.25}}, pose, 0.01);
  const auto plane = on_plane.find({}, pose, 0.01);
  ASSERT_EQ(boxes.size(), plane.size());
  for (const ContactPoint& p : plane) {
    const auto same = std::ranges::find_if(boxes, [&](const ContactPoint& q) {
      return norm(q.point + 0.5 * q.gap * q.normal - p.point) < 1e-13;
    });
    ASSERT_NE(same, boxes.end());
    EXPECT_NEAR(same->gap, p.gap, 1e-14);
  }
}

/// The prism of a polygon with n corners at distance 0.2 m, 0.2 m high, about the origin.
MeshHull prism(int n) {
  std::vector<Vec3<>> vertices;
  std::vector<std::array<int, 3>> triangles;
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * std::acos(-1.0) * k / n;
    for (const double z : {-0.1, 0.1}) vertices.push_back({0.2 * std::cos(angle), 0.2 * std::sin(angle), z});
    const int low = 2 * k, next = 2 * ((k + 1) % n);
    triangles.push_back({low, next, next + 1});
    triangles.push_back({low, next + 1, low + 1});
    if (k == 0 || k == n - 1) continue;
    triangles.push_back({0, next, low});
    triangles.push_back({1, low + 1, next + 1});
  }
  return {make_hull(std::move(vertices), triangles), {}};
}

TEST(FlatContact, OfAHullWithManyVerticesHasItsOutermostOnes) {
  for (const int n : {8, 16, 64}) {
    SCOPED_TRACE(n);
    ShapeDescription mesh = collision_shape(ShapeKind::mesh, {}, 0, 0);
    const Model model = free_bodies({collision_shape(ShapeKind::plane, {}, 0, 0), mesh});
    ContactFinder finder(ContactShapes(model, [&](const auto&, const auto&) { return prism(n); }));
    const double tilt = 0.01;
    const std::array<SE3<>, 3> C{SE3<>{}, SE3<>{}, SE3<>{exp_SO3(Vec3<>{0, tilt, 0}), {0, 0, 0.1}}};
    ASSERT_TRUE(finder.find(C, 0.01));
    EXPECT_EQ(finder.points().size(), n <= 16 ? static_cast<std::size_t>(n) : 8U);
    double least = 1;
    Vec3<> low{1, 1, 0}, high{-1, -1, 0};
    for (const ContactPoint& p : finder.points()) {
      least = std::min(least, p.gap);
      low = {std::min(low.x, p.point.x), std::min(low.y, p.point.y), 0};
      high = {std::max(high.x, p.point.x), std::max(high.y, p.point.y), 0};
    }
    EXPECT_NEAR(least, 0.1 - 0.2 * std::sin(tilt) - 0.1 * std::cos(tilt), 1e-15);
    EXPECT_LT(std::max(low.x, low.y), -0.197);
    EXPECT_GT(std::min(high.x, high.y), 0.197);
  }
}

/// Boxes and hulls that touch with faces and corners, or with crossing edges.
TEST(ContactJets, OfHullsAndBoxesAgreeWithDifferences) {
  constexpr double far = 1;
  int faces = 0, crossings = 0, refused = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random<double> random(seed);
    const ShapeDescription mesh = collision_shape(ShapeKind::mesh, {}, 0, 0);
    const ShapeDescription box = collision_shape(ShapeKind::box, {0.5, 0.4, 0.3}, 0, 0);
    const ContactShapes shapes(
        free_bodies({mesh, seed % 2 == 0 ? mesh : box}),
        [&](const auto&, const auto&) { return prism(3 + static_cast<int>(seed % 5)); });
    ContactFinder finder(shapes);
    ContactJets jets(shapes);
    const SE3<> A{exp_SO3(random.vector(3)), random.vector(1)};
    SE3<> B{exp_SO3(random.vector(3)), {}};
    const Vec3<> direction = random.vector(1);
    const double gap = seed % 3 == 0 ? 1e-5 : 1e-3;
    double near = 0, far_away = 10 / norm(direction);  // in which the shapes are nearer and farther
    for (int k = 0; k < 60; ++k) {
      const double way = (near + far_away) / 2;
      B.r = A.r + way * direction;
      const bool is_near = convex_distance(shapes[0].convex, A, shapes[1].convex, B).distance < gap;
      (is_near ? near : far_away) = way;
    }
    const auto poses = [&](const Vec3<>& w, const Vec3<>& v) {
      return std::array<SE3<>, 3>{SE3<>{}, A, SE3<>{exp_SO3(w) * B.R, B.r + v}};
    };
    ASSERT_TRUE(finder.find(poses({}, {}), far));
    const std::vector<ContactPoint> points(finder.points().begin(), finder.points().end());
    ASSERT_FALSE(points.empty());
    if (!jets.find(points[0].key, poses({}, {}), far)) {  // a corner is nearest to a corner or an edge
      EXPECT_FALSE(jets.closed_form());
      ++refused;
      continue;
    }
    // The normal of a face does not turn, or turns with body b; that of two edges does neither.
    const double turn = jets.find(points[0].key, poses({}, {}), far)->normal_by.norm();
    (turn < 1e-12 || std::abs(turn - std::sqrt(2.0)) < 1e-12 ? faces : crossings) += 1;
    for (const ContactPoint& at : points) {
      const ContactJet* found = jets.find(at.key, poses({}, {}), far);
      ASSERT_TRUE(found);
      const ContactJet jet = *found;
      EXPECT_LT(norm(jet.point - at.point) + norm(jet.normal - at.normal), 1e-9);
      constexpr double step = 1e-6;
      for (int c = 0; c < 6; ++c) {
        std::array<ContactPoint, 2> moved;
        for (const int side : {0, 1}) {
          Vec3<> w{}, v{};
          (&(c < 3 ? w : v).x)[c % 3] = side == 0 ? -step : step;
          ASSERT_TRUE(finder.find(poses(w, v), far));
          const auto same = std::ranges::find(finder.points(), at.key, &ContactPoint::key);
          ASSERT_TRUE(same != finder.points().end());
          moved[static_cast<std::size_t>(side)] = *same;
        }
        const auto rate = [&](const auto& x) { return (1 / (2 * step)) * (x(moved[1]) - x(moved[0])); };
        const Vec3<> point = rate([](const ContactPoint&p) { return p.point; }),
                     normal = rate([](const ContactPoint&p) { return p.normal; });
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(jet.point_by(k, c), (&point.x)[k], 1e-5);
          EXPECT_NEAR(jet.normal_by(k, c), (&normal.x)[k], 1e-5);
        }
        EXPECT_NEAR(jet.gap_by(c), rate([](const ContactPoint& p) { return p.gap; }), 1e-5);
      }
    }
  }
  EXPECT_GE(faces, 10);
  EXPECT_GE(crossings, 10);
  EXPECT_LE(refused, 5);
}

TEST(ContactFinder, SaysThatItsCapacityIsExceeded) {
  ContactFinder finder(ContactShapes(free_bodies({collision_shape(ShapeKind::plane, {}, 0, 0),
                                                  collision_shape(ShapeKind::box, {1, 1, 1}, 0, 0)})),
                       3);
  const std::array<SE3<>, 3> C{SE3<>{}, SE3<>{}, SE3<>{{}, {0, 0, 0.5}}};
  EXPECT_FALSE(finder.find(C, 0.01));
  EXPECT_EQ(finder.points().size(), 3U);
}

TEST(ContactFinder, FindsWhatAllPairsByThemselvesHave) {
  for_seeds(20, [](std::uint64_t seed) {
    Random<double> random(seed);
    std::vector<ShapeDescription> shapes{collision_shape(ShapeKind::plane, {}, 0, 0)};
    for (int k = 0; k < 30; ++k)
      shapes.push_back(random_collision_shape(random, bounded_kinds[static_cast<std::size_t>(k) % 5]));
    const ContactShapes all(free_bodies(shapes));
    std::vector<SE3<>> C(all.size() + 1);
    for (int k = 1; k < all.size(); ++k) C[k + 1] = {random.rotation(), 1.5 * random.vector()};
    ContactFinder finder(all, 10000);
    ASSERT_TRUE(finder.find(C, 0.01));
    std::set<std::pair<int, int>> touching, found;
    for (const ContactPoint& p : finder.points()) found.emplace(std::min(p.a, p.b), std::max(p.a, p.b));
    for (const auto& [i, j] : all.pairs()) {
      if (i == 0) {
        const Vec3<> down = transpose(C[j + 1].R) * Vec3<>{0, 0, -1};
        const Vec3<> lowest = C[j + 1] * (all[j].pose * convex::support_point(all[j].convex, down));
        if (lowest.z < 0.01) touching.emplace(i, j);
      } else if (convex_distance(all[i].convex, C[i + 1], all[j].convex, C[j + 1]).distance < 0.01) {
        touching.emplace(i, j);
      }
    }
    EXPECT_EQ(found, touching);
  });
}

TEST(ContactShapes, LeaveOutPairsThatDoNotTouch) {
  const ShapeDescription ball = collision_shape(ShapeKind::sphere, {}, 0.1, 0);
  const MassProperties matter{.mass = 1, .com = {}, .Theta = {1, 1, 1, 0, 0, 0}};
  const auto body = [&](const char* name, const char* on, JointKind kind) {
    return BodyDescription{
        .name = name, .predecessor = on, .joint = {.kind = kind}, .inertia = matter, .shapes = {ball}};
  };
  Description d;
  d.shapes = {ball, ball};
  d.bodies = {body("arm", "ground", JointKind::revolute), body("hand", "arm", JointKind::universal),
              body("ring", "hand", JointKind::fixed),     body("stand", "ground", JointKind::fixed),
              body("tool", "ground", JointKind::free),    body("cap", "ground", JointKind::free)};
  d.loops = {{.between = {"tool", "cap"}, .kind = LoopKind::spherical}};
  d.contact = ContactDescription{.ignored = {{"ring", "tool"}, {"ground", "cap"}}};
  const ContactShapes shapes(ModelBuilder(d).build());
  ASSERT_EQ(shapes.size(), 8);
  EXPECT_EQ(shapes[2].name, "arm shape 1");
  std::set<std::string> pairs;
  const std::vector<std::string> names{"g1", "g2", "arm", "hand", "ring", "stand", "tool", "cap"};
  for (const auto& [i, j] : shapes.pairs()) pairs.insert(names[i] + " " + names[j]);
  const std::set<std::string> expected{"g1 arm",     "g2 arm",     "g1 hand",   "g2 hand",   "g1 ring",
                                       "g2 ring",    "g1 tool",    "g2 tool",   "arm stand", "hand stand",
                                       "ring stand", "stand tool", "stand cap", "arm tool",  "arm cap",
                                       "hand tool",  "hand cap",   "ring cap"};
  EXPECT_EQ(pairs, expected);
}

TEST(ContactShapes, CombineSurfaces) {
  ShapeDescription one = collision_shape(ShapeKind::sphere, {}, 1, 0), other = one;
  one.contact = {.friction = 0.9, .spin_friction = 0.04, .rolling_friction = 0.01, .restitution = 0.2};
  other.contact = {.friction = {}, .spin_friction = 0.01, .rolling_friction = 0, .restitution = 0.5};
  const SurfacePair pair = ContactShapes(free_bodies({one, other})).surface(0, 1);
  EXPECT_DOUBLE_EQ(pair.friction, std::sqrt(0.9 * 0.6));
  EXPECT_DOUBLE_EQ(pair.spin_friction, 0.02);
  EXPECT_EQ(pair.rolling_friction, 0);
  EXPECT_EQ(pair.restitution, 0.5);
}

TEST(ContactShapes, RefuseWhatCannotTouch) {
  const auto refusal = [](const ShapeDescription& one, const ShapeDescription& other) -> std::string {
    try {
      ContactShapes shapes(free_bodies({one, other}));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const ShapeDescription plane = collision_shape(ShapeKind::plane, {}, 0, 0);
  const ShapeDescription ball = collision_shape(ShapeKind::sphere, {}, 1, 0);
  ShapeDescription mesh = collision_shape(ShapeKind::mesh, {}, 0, 0);
  mesh.file = "part.stl";
  EXPECT_EQ(refusal(plane, ball), "");
  EXPECT_THAT(refusal(plane, plane), HasSubstr("are planes that move against each other"));
  EXPECT_THAT(refusal(ball, mesh), HasSubstr("is the mesh \"part.stl\", whose hull is not known"));
  EXPECT_THAT(refusal(ball, collision_shape(ShapeKind::sphere, {}, 0, 0)), HasSubstr("its radius is 0 m"));
  EXPECT_THAT(refusal(ball, collision_shape(ShapeKind::ellipsoid, {1, 0, 1}, 0, 0)),
              HasSubstr("its semi_axes is 0 m"));
}

}  // namespace
}  // namespace axode::test
