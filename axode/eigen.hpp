#pragma once
#include <Eigen/Core>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "axode/lie.hpp"

/// Conversion of the quantities of this library to vectors and matrices of Eigen, and back. Vectors of six
/// numbers have the angular part first; separate functions convert to the order of other libraries, which
/// have the linear part first. Nothing is normalised or projected.
namespace axode {

template <class T> using Vector6 = Eigen::Matrix<T, 6, 1>;
template <class T> using Matrix6 = Eigen::Matrix<T, 6, 6>;

// ------------------------------------------------------------------------------------ skew matrices

/// The skew matrix ã of a vector a: ã b = a × b.
template <class T> Eigen::Matrix3<T> skew(const Vec3<T>& a) {
  return Eigen::Matrix3<T>{{T(0), -a.z, a.y}, {a.z, T(0), -a.x}, {-a.y, a.x, T(0)}};
}
/// The 4×4 matrix X̂ = [[w̃, v], [0, 0]] of a screw X = (w; v).
template <class T> Eigen::Matrix4<T> hat(const Screw<T>& X) {
  return Eigen::Matrix4<T>{{T(0), -X.w.z, X.w.y, X.v.x},
                           {X.w.z, T(0), -X.w.x, X.v.y},
                           {-X.w.y, X.w.x, T(0), X.v.z},
                           {T(0), T(0), T(0), T(0)}};
}

// ---------------------------------------------------------------------------------------- to Eigen

template <class T> Eigen::Vector3<T> to_eigen(const Vec3<T>& a) { return {a.x, a.y, a.z}; }
template <class T> Eigen::Matrix3<T> to_eigen(const Sym3<T>& A) {
  return Eigen::Matrix3<T>{{A.xx, A.xy, A.xz}, {A.xy, A.yy, A.yz}, {A.xz, A.yz, A.zz}};
}
template <class T> Eigen::Matrix3<T> to_eigen(const SO3<T>& R) {
  return Eigen::Matrix3<T>{{R.x.x, R.y.x, R.z.x}, {R.x.y, R.y.y, R.z.y}, {R.x.z, R.y.z, R.z.z}};
}
/// The components of a quaternion in the order x y z w, as in Eigen::Quaternion::coeffs().
template <class T> Eigen::Vector4<T> to_eigen(const Quaternion<T>& a) { return {a.x, a.y, a.z, a.w}; }
/// The 4×4 matrix [[R, r], [0, 1]] of a pose.
template <class T> Eigen::Matrix4<T> to_eigen(const SE3<T>& C) {
  Eigen::Matrix4<T> matrix = Eigen::Matrix4<T>::Identity();
  matrix.template topLeftCorner<3, 3>() = to_eigen(C.R);
  matrix.template topRightCorner<3, 1>() = to_eigen(C.r);
  return matrix;
}
template <class T> Vector6<T> to_eigen(const Screw<T>& X) {
  return Vector6<T>{X.w.x, X.w.y, X.w.z, X.v.x, X.v.y, X.v.z};
}
/// The six components of a twist, twist rate, wrench or momentum, angular part first.
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind> Vector6<T> to_eigen(const Kind<Rep, T>& x) {
    const auto& [a, b] = x;
    return Vector6<T>{a.x, a.y, a.z, b.x, b.y, b.z};
  }
/// The 6×6 matrix M = [[Θ, h̃], [-h̃, m I]] of an inertia (Müller, eq. Mb).
template <class T> Matrix6<T> to_eigen(const Inertia<T>& M) {
  Matrix6<T> matrix;
  matrix << to_eigen(M.Theta), skew(M.h), -skew(M.h), M.m * Eigen::Matrix3<T>::Identity();
  return matrix;
}

// -------------------------------------------------------------------------------------- from Eigen

namespace detail {

/// Converts a matrix expression to an Eigen matrix with Rows × Cols entries; Cols may be Eigen::Dynamic.
/// Wrong sizes do not compile or, if they are known only at run time, throw std::invalid_argument.
template <int Rows, int Cols, class Derived>
Eigen::Matrix<typename Derived::Scalar, Rows, Cols> shaped(const Eigen::MatrixBase<Derived>& matrix) {
  constexpr auto fits = [](int size, int wanted) {
    return size == wanted || size == Eigen::Dynamic || wanted == Eigen::Dynamic;
  };
  static_assert(fits(Derived::RowsAtCompileTime, Rows) && fits(Derived::ColsAtCompileTime, Cols),
                "the Eigen matrix has another shape than the quantity read from it");
  if (matrix.rows() != Rows || (Cols != Eigen::Dynamic && matrix.cols() != Cols)) {
    const std::string wanted =
        std::to_string(Rows) + " x " + (Cols == Eigen::Dynamic ? "n" : std::to_string(Cols));
    throw std::invalid_argument("expected an Eigen matrix of shape " + wanted + ", got " +
                                std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()));
  }
  return matrix;
}

template <class Result> struct FromEigen;

template <class T> struct FromEigen<Vec3<T>> {
  static constexpr int rows = 3, cols = 1;
  static Vec3<T> read(const Eigen::Vector3<T>& a) { return {a[0], a[1], a[2]}; }
};
template <class T> struct FromEigen<Sym3<T>> {
  static constexpr int rows = 3, cols = 3;
  static Sym3<T> read(const Eigen::Matrix3<T>& A) {
    return {A(0, 0), A(1, 1), A(2, 2), A(0, 1), A(0, 2), A(1, 2)};
  }
};
template <class T> struct FromEigen<SO3<T>> {
  static constexpr int rows = 3, cols = 3;
  static SO3<T> read(const Eigen::Matrix3<T>& R) {
    return {FromEigen<Vec3<T>>::read(R.col(0)), FromEigen<Vec3<T>>::read(R.col(1)),
            FromEigen<Vec3<T>>::read(R.col(2))};
  }
};
template <class T> struct FromEigen<Quaternion<T>> {
  static constexpr int rows = 4, cols = 1;
  static Quaternion<T> read(const Eigen::Vector4<T>& a) { return {a[0], a[1], a[2], a[3]}; }
};
template <class T> struct FromEigen<SE3<T>> {
  static constexpr int rows = 4, cols = 4;
  static SE3<T> read(const Eigen::Matrix4<T>& C) {
    return {FromEigen<SO3<T>>::read(C.template topLeftCorner<3, 3>()),
            FromEigen<Vec3<T>>::read(C.template topRightCorner<3, 1>())};
  }
};
template <class T> struct FromEigen<Screw<T>> {
  static constexpr int rows = 6, cols = 1;
  static Screw<T> read(const Vector6<T>& x) { return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}; }
};
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind>
struct FromEigen<Kind<Rep, T>> {
  static constexpr int rows = 6, cols = 1;
  static Kind<Rep, T> read(const Vector6<T>& x) { return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}; }
};
template <class T> struct FromEigen<Inertia<T>> {
  static constexpr int rows = 6, cols = 6;
  static Inertia<T> read(const Matrix6<T>& M) {
    return {M(3, 3), {M(2, 4), M(0, 5), M(1, 3)}, FromEigen<Sym3<T>>::read(M.template topLeftCorner<3, 3>())};
  }
};

}  // namespace detail

/// The quantity of type Result in an Eigen vector or matrix, e.g. from_eigen<SE3<double>>(matrix). Only the
/// shape is checked. Entries below the diagonal of symmetric matrices and the last row of a pose are ignored.
template <class Result, class Derived> Result from_eigen(const Eigen::MatrixBase<Derived>& matrix) {
  using From = detail::FromEigen<Result>;
  return From::read(detail::shaped<From::rows, From::cols>(matrix));
}
/// The vector a whose skew matrix ã is given. Only three entries of the matrix are read.
template <class Derived> Vec3<typename Derived::Scalar> from_skew(const Eigen::MatrixBase<Derived>& matrix) {
  const auto A = detail::shaped<3, 3>(matrix);
  return {A(2, 1), A(0, 2), A(1, 0)};
}
/// The screw X whose 4×4 matrix X̂ is given, see hat(). Only six entries of the matrix are read.
template <class Derived> Screw<typename Derived::Scalar> from_hat(const Eigen::MatrixBase<Derived>& matrix) {
  const auto A = detail::shaped<4, 4>(matrix);
  return {{A(2, 1), A(0, 2), A(1, 0)}, {A(0, 3), A(1, 3), A(2, 3)}};
}

// -------------------------------------------------------------------------------------------- spans

/// Eigen vectors whose entries lie one after the other in memory.
template <class Derived>
concept ContiguousVector =
    bool(Derived::IsVectorAtCompileTime) &&
    bool(Derived::Flags& Eigen::DirectAccessBit) && Derived::InnerStrideAtCompileTime == 1;

/// The entries of an Eigen vector as a span on its memory, for reading or for writing.
template <ContiguousVector Derived>
std::span<const typename Derived::Scalar> as_span(const Eigen::MatrixBase<Derived>& vector) {
  return {vector.derived().data(), static_cast<std::size_t>(vector.size())};
}
template <ContiguousVector Derived>
std::span<typename Derived::Scalar> as_span(Eigen::MatrixBase<Derived>& vector) {
  return {vector.derived().data(), static_cast<std::size_t>(vector.size())};
}
/// The entries of an Eigen matrix as a span, in the order in which the matrix stores them: column by column,
/// unless its type says RowMajor. A matrix with a column for each state fits the functions of
/// axode/batch.hpp. Results of this library that are matrices are stored row by row.
template <class Derived>
  requires(!Derived::IsVectorAtCompileTime)
std::span<const typename Derived::Scalar> as_span(const Eigen::PlainObjectBase<Derived>& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}
template <class Derived>
  requires(!Derived::IsVectorAtCompileTime)
std::span<typename Derived::Scalar> as_span(Eigen::PlainObjectBase<Derived>& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}
/// The numbers of a span as an Eigen vector on the same memory; nothing is copied.
template <class T, std::size_t Extent>
Eigen::Map<const Eigen::VectorX<T>> as_eigen(std::span<const T, Extent> entries) {
  return {entries.data(), static_cast<Eigen::Index>(entries.size())};
}
template <class T, std::size_t Extent>
  requires(!std::is_const_v<T>)
Eigen::Map<Eigen::VectorX<T>> as_eigen(std::span<T, Extent> entries) {
  return {entries.data(), static_cast<Eigen::Index>(entries.size())};
}

// ------------------------------------------------------------------------ orders of other libraries

/// A 6×n matrix with its first three rows, the angular half, and its last three, the linear half, exchanged.
template <class Derived> auto exchange_halves(const Eigen::MatrixBase<Derived>& matrix) {
  auto exchanged = detail::shaped<6, Derived::ColsAtCompileTime>(matrix);
  exchanged << matrix.template bottomRows<3>(), matrix.template topRows<3>();
  return exchanged;
}
/// The six components of a screw with the linear part first, as in Pinocchio and ROS messages.
template <class T> Vector6<T> linear_first(const Screw<T>& X) { return exchange_halves(to_eigen(X)); }
template <template <class, class> class Kind, class Rep, class T>
  requires is_screw_kind<Kind> Vector6<T> linear_first(const Kind<Rep, T>& x) {
    return exchange_halves(to_eigen(x));
  }
/// The inertia matrix [[m I, -h̃], [h̃, Θ]] for twists with the linear part first.
template <class T> Matrix6<T> linear_first(const Inertia<T>& M) {
  return exchange_halves(exchange_halves(to_eigen(M)).transpose());
}
/// The screw, twist, twist rate, wrench or momentum with the given components, linear part first.
template <class Result, class Derived>
Result from_linear_first(const Eigen::MatrixBase<Derived>& components) {
  return from_eigen<Result>(exchange_halves(detail::shaped<6, 1>(components)));
}
/// The components of a quaternion in the order w x y z of MuJoCo.
template <class T> Eigen::Vector4<T> scalar_first(const Quaternion<T>& a) { return {a.w, a.x, a.y, a.z}; }
/// The quaternion with these components, which are in the order w x y z.
template <class Derived>
Quaternion<typename Derived::Scalar> from_scalar_first(const Eigen::MatrixBase<Derived>& components) {
  const auto a = detail::shaped<4, 1>(components);
  return {a[1], a[2], a[3], a[0]};
}

// --------------------------------------------------------------------------- matrices of linear maps

/// The 3×3 matrix of a linear map f on vectors; its columns are f of the unit vectors.
template <class T = double, class Map> Eigen::Matrix3<T> matrix3(const Map& f) {
  Eigen::Matrix3<T> matrix;
  matrix << to_eigen(f(Vec3<T>{T(1), T(0), T(0)})), to_eigen(f(Vec3<T>{T(0), T(1), T(0)})),
      to_eigen(f(Vec3<T>{T(0), T(0), T(1)}));
  return matrix;
}
/// The 6×6 matrix of a linear map f on screws; its columns are f of the unit screws.
template <class T = double, class Map> Matrix6<T> matrix6(const Map& f) {
  Matrix6<T> matrix;
  for (int k = 0; k < 6; ++k) matrix.col(k) = to_eigen(f(from_eigen<Screw<T>>(Vector6<T>::Unit(k))));
  return matrix;
}

/// The 6×6 matrix Ad_C = [[R, 0], [r̃ R, R]] of a pose C = (R, r) (Müller, eq. Ad).
template <class T> Matrix6<T> Ad_matrix(const SE3<T>& C) {
  return matrix6<T>([&](const Screw<T>& Z) { return Ad(C, Z); });
}
/// The 6×6 matrix Ad_R = diag(R, R) of a rotation R (Müller, eq. AdRr).
template <class T> Matrix6<T> Ad_matrix(const SO3<T>& R) {
  return matrix6<T>([&](const Screw<T>& Z) { return Ad(R, Z); });
}
/// The 6×6 matrix Ad_r = [[I, 0], [r̃, I]] of a translation r (Müller, eq. AdRr).
template <class T> Matrix6<T> Ad_matrix(const Vec3<T>& r) {
  return matrix6<T>([&](const Screw<T>& Z) { return Ad(r, Z); });
}
/// The 6×6 matrix ad_X = [[w̃, 0], [ṽ, w̃]] of a screw X = (w; v) (Müller, eq. adse3).
template <class T> Matrix6<T> ad_matrix(const Screw<T>& X) {
  return matrix6<T>([&](const Screw<T>& Z) { return ad(X, Z); });
}

/// The matrices of dexp, the right-trivialised differential of the exponential map, at ξ on SO(3) (3×3) or at
/// the screw X on SE(3) (6×6), and of its inverse dexp⁻¹. ddexp_matrix() and ddexp_inv_matrix() are their
/// derivatives when ξ moves along η, or X along U.
template <class T> Eigen::Matrix3<T> dexp_matrix(const Vec3<T>& xi) {
  return matrix3<T>([&](const Vec3<T>& z) { return dexp(xi, z); });
}
template <class T> Matrix6<T> dexp_matrix(const Screw<T>& X) {
  return matrix6<T>([&](const Screw<T>& Z) { return dexp(X, Z); });
}
template <class T> Eigen::Matrix3<T> dexp_inv_matrix(const Vec3<T>& xi) {
  return matrix3<T>([&](const Vec3<T>& z) { return dexp_inv(xi, z); });
}
template <class T> Matrix6<T> dexp_inv_matrix(const Screw<T>& X) {
  return matrix6<T>([&](const Screw<T>& Z) { return dexp_inv(X, Z); });
}
template <class T> Eigen::Matrix3<T> ddexp_matrix(const Vec3<T>& xi, const Vec3<T>& eta) {
  return matrix3<T>([&](const Vec3<T>& z) { return ddexp(xi, eta, z); });
}
template <class T> Matrix6<T> ddexp_matrix(const Screw<T>& X, const Screw<T>& U) {
  return matrix6<T>([&](const Screw<T>& Z) { return ddexp(X, U, Z); });
}
template <class T> Eigen::Matrix3<T> ddexp_inv_matrix(const Vec3<T>& xi, const Vec3<T>& eta) {
  return matrix3<T>([&](const Vec3<T>& z) { return ddexp_inv(xi, eta, z); });
}
template <class T> Matrix6<T> ddexp_inv_matrix(const Screw<T>& X, const Screw<T>& U) {
  return matrix6<T>([&](const Screw<T>& Z) { return ddexp_inv(X, U, Z); });
}

}  // namespace axode
