#pragma once
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <concepts>

#include "axode/eigen.hpp"
#include "axode/model/tree.hpp"
#include "axode/scalar/taylor.hpp"

/// Time derivatives without formulas: whatever moves is a series in t, and its coefficients are its
/// derivatives at t = 0. Matrices and vectors are Eigen's, six-vectors angular part first.
namespace axode::test::paper {

using Vec3d = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Vec6 = Vector6<double>;
using Mat6 = Matrix6<double>;

using Series = Taylor<double, 3>;
using PoseOfT = SE3<Series>;
using Vec6OfT = Vector6<Series>;

// ------------------------------------------------------------------------------- series, their values, their rates

inline Series derivative(const Series& x) {
  Series d;
  for (std::size_t k = 0; k + 1 < d.c.size(); ++k) d.c[k] = static_cast<double>(k + 1) * x.c[k + 1];
  return d;
}
inline Vec3<Series> derivative(const Vec3<Series>& x) {
  return {derivative(x.x), derivative(x.y), derivative(x.z)};
}
template <int Rows, int Cols> auto derivative(const Eigen::Matrix<Series, Rows, Cols>& x) {
  return Eigen::Matrix<Series, Rows, Cols>(x.unaryExpr([](const Series& s) { return derivative(s); }));
}

/// x(0).
inline double now(const Series& x) { return x.c[0]; }
inline Vec3<> now(const Vec3<Series>& x) { return {now(x.x), now(x.y), now(x.z)}; }
inline SO3<> now(const SO3<Series>& R) { return {now(R.x), now(R.y), now(R.z)}; }
inline SE3<> now(const SE3<Series>& C) { return {now(C.R), now(C.r)}; }
template <int Rows, int Cols>
Eigen::Matrix<double, Rows, Cols> now(const Eigen::Matrix<Series, Rows, Cols>& x) {
  return x.unaryExpr([](const Series& s) { return now(s); });
}

/// x'(0).
inline double rate(const Series& x) { return x.c[1]; }
inline Vec3<> rate(const Vec3<Series>& x) { return now(derivative(x)); }
template <int Rows, int Cols>
Eigen::Matrix<double, Rows, Cols> rate(const Eigen::Matrix<Series, Rows, Cols>& x) {
  return now(derivative(x));
}
template <class Derived> auto rate(const Eigen::MatrixBase<Derived>& x) { return rate(x.eval()); }

/// x''(0).
inline Vec3<> second_rate(const Vec3<Series>& x) { return rate(derivative(x)); }

// --------------------------------------------------------------------- the paper's notation for vectors and matrices

/// Ad_C, Ad_R and Ad_r (eqs. Ad, AdRr).
template <class T> Matrix6<T> Ad(const SE3<T>& C) { return Ad_matrix(C); }
template <class T> Matrix6<T> Ad(const SO3<T>& R) { return Ad_matrix(R); }
template <class T> Matrix6<T> Ad(const Vec3<T>& r) { return Ad_matrix(r); }
inline Mat6 Ad(const Mat3& R) { return Ad_matrix(from_eigen<SO3<double>>(R)); }
inline Mat6 Ad(const Vec3d& r) { return Ad_matrix(from_eigen<Vec3<double>>(r)); }

/// ad_X, ad_ω and ad_v (eq. adse3).
inline Mat6 ad(const Vec6& X) { return ad_matrix(from_eigen<Screw<double>>(X)); }
inline Mat6 ad_w(const Vec3d& w) { return ad((Vec6() << w, Vec3d::Zero()).finished()); }
inline Mat6 ad_v(const Vec3d& v) { return ad((Vec6() << Vec3d::Zero(), v).finished()); }

/// x̃.
inline Mat3 tilde(const Vec3d& x) { return skew(from_eigen<Vec3<double>>(x)); }
inline Mat3 tilde(const Vec3<>& x) { return skew(x); }

/// The angular and the linear part of a six-vector.
inline Vec3d angular(const Vec6& X) { return X.head<3>(); }
inline Vec3d linear(const Vec6& X) { return X.tail<3>(); }
/// (ω; 0) (eq. Vw).
inline Vec6 angular_screw(const Vec6& X) { return (Vec6() << angular(X), Vec3d::Zero()).finished(); }

inline Mat3 to_matrix(const SO3<>& R) { return to_eigen(R); }
inline Vec3d to_vector(const Vec3<>& a) { return to_eigen(a); }

/// diag(A, B).
inline Mat6 block_diagonal(const Mat3& A, const Mat3& B) {
  Mat6 matrix = Mat6::Zero();
  matrix.topLeftCorner<3, 3>() = A, matrix.bottomRightCorner<3, 3>() = B;
  return matrix;
}
/// [[A, B], [C, D]].
inline Mat6 blocks(const Mat3& A, const Mat3& B, const Mat3& C, const Mat3& D) {
  return (Mat6() << A, B, C, D).finished();
}

// ----------------------------------------------------------------------------------------- twists by their definition

/// The twist of a frame with pose C(t), from the definitions of appendix A.
Vec6OfT twist_of(const PoseOfT& C, Representation representation);

}  // namespace axode::test::paper
