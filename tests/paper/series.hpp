#pragma once
#include "axode/model/tree.hpp"
#include "tests/paper/matrix.hpp"

/// Time derivatives without formulas: every quantity that depends on the motion is a series in t, whose
/// coefficients give its derivatives at t = 0. Six-vectors have their angular part first.
namespace axode::test::paper {

using PoseOfT = SE3<Series>;

// ------------------------------------------------------------------------- series, their values, their rates

inline Series derivative(const Series& x) {
  Series d;
  for (std::size_t k = 0; k + 1 < d.c.size(); ++k) d.c[k] = static_cast<double>(k + 1) * x.c[k + 1];
  return d;
}
inline Vec3<Series> derivative(const Vec3<Series>& x) {
  return {derivative(x.x), derivative(x.y), derivative(x.z)};
}
MatrixOfT derivative(const MatrixOfT& x);

/// x(0).
inline double now(const Series& x) { return x.c[0]; }
inline Vec3<> now(const Vec3<Series>& x) { return {now(x.x), now(x.y), now(x.z)}; }
inline SO3<> now(const SO3<Series>& R) { return {now(R.x), now(R.y), now(R.z)}; }
inline SE3<> now(const SE3<Series>& C) { return {now(C.R), now(C.r)}; }
Matrix now(const MatrixOfT& x);

/// x'(0).
inline double rate(const Series& x) { return x.c[1]; }
inline Vec3<> rate(const Vec3<Series>& x) { return now(derivative(x)); }
Matrix rate(const MatrixOfT& x);

/// x''(0).
inline Vec3<> second_rate(const Vec3<Series>& x) { return rate(derivative(x)); }

// ------------------------------------------------------------- the paper's notation for vectors and matrices

/// Ad_C, Ad_R and Ad_r (Müller, eqs. Ad, AdRr).
Mat6 Ad(const SE3<>& C);
Mat6 Ad(const SO3<>& R);
Mat6 Ad(const Vec3<>& r);
Mat6 Ad(const Mat3& R);
Mat6 Ad(const Vec3d& r);
MatrixOfT Ad(const SE3<Series>& C);
MatrixOfT Ad(const SO3<Series>& R);
MatrixOfT Ad(const Vec3<Series>& r);

/// ad_X, ad_ω and ad_v (Müller, eq. adse3).
Mat6 ad(const Vec6& X);
Mat6 ad_w(const Vec3d& w);
Mat6 ad_v(const Vec3d& v);

/// x̃ and X̂.
Mat3 tilde(const Vec3d& x);
Mat4 hat(const Screw<>& X);
MatrixOfT hat(const Screw<Series>& X);

/// The angular and the linear part of a six-vector.
Vec3d angular(const Vec6& X);
Vec3d linear(const Vec6& X);
/// (ω; 0) (Müller, eq. Vw).
Vec6 angular_screw(const Vec6& X);

// -------------------------------------------------------------------------------- twists by their definition

/// The twist of a frame with pose C(t), from the definitions of appendix A.
Vec6OfT twist_of(const PoseOfT& C, Representation representation);

}  // namespace axode::test::paper
