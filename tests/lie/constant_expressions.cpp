#include <gtest/gtest.h>

#include "axode/lie.hpp"

/// Functions that need no square root can be evaluated by the compiler.
namespace axode::test {
namespace {

constexpr bool operator==(const Vec3<>& a, const Vec3<>& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
constexpr bool operator==(const Screw<>& a, const Screw<>& b) { return a.w == b.w && a.v == b.v; }

constexpr SO3<> quarter_turn{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}};  // about z
constexpr SE3<> C{quarter_turn, {1, 2, 3}};
constexpr Screw<> X = screw(Vec3<>{0, 0, 1}, Vec3<>{2, 0, 0}, 0.5);
constexpr Twist<BodyFixed> V{{1, 0, 0}, {0, 1, 0}};
constexpr Wrench<BodyFixed> W{{2, 0, 0}, {0, 3, 0}};
constexpr Inertia<> M = inertia_from_com(2.0, Vec3<>{1, 0, 0}, Sym3<>{1, 1, 1, 0, 0, 0});

static_assert(cross(Vec3<>{1, 0, 0}, Vec3<>{0, 1, 0}) == Vec3<>{0, 0, 1});
static_assert(C * Vec3<>{1, 0, 0} == Vec3<>{1, 3, 3});
static_assert((inverse(C) * C).r == Vec3<>{});
static_assert(X == Screw<>{{0, 0, 1}, {0, -2, 0.5}});
static_assert(Ad_inv(C, Ad(C, X)) == X);
static_assert(ad(X, X) == Screw<>{});
static_assert(reciprocal_product(X, X) == 1.0);  // twice the pitch
static_assert((W | V) == 5.0);
static_assert((change<Hybrid>(C, W) | change<Hybrid>(C, V)) == 5.0);
static_assert((change<Mixed>(C, W) | change<Mixed>(C, V)) == 5.0);
static_assert((coAd(C, W) | Ad(C, V)) == 5.0);
static_assert(M.Theta.zz == 3.0 && M.Theta.xx == 1.0);
static_assert(inertia_about_com(M).zz == 1.0);
static_assert(transform(C, M).m == 2.0 && transform(C, M).h == Vec3<>{2, 6, 6});
static_assert(((M * V) | V) == 3.0);
static_assert(binet_tensor(Sym3<>{1, 1, 1, 0, 0, 0}).xx == 0.5);
static_assert(rotation(Quaternion<>{0, 0, 1, 0}).x == Vec3<>{-1, 0, 0});

TEST(ConstantExpressions, TheAlgebraIsConstexpr) {
  constexpr Twist<Spatial> V_s = Ad(C, V);
  EXPECT_EQ(V_s.w.y, 1.0);
}

}  // namespace
}  // namespace axode::test
