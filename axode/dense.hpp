#pragma once
#include <span>

#include "axode/dynamics.hpp"
#include "axode/eigen.hpp"
#include "axode/kinematics.hpp"

/// Functions of a state that return Eigen matrices and vectors. Arguments, units, errors and costs are those
/// of the functions of equal names that write into spans; each call allocates its result.
namespace axode {

template <class T> using Matrix6X = Eigen::Matrix<T, 6, Eigen::Dynamic>;

namespace detail {

/// The columns of a 6 × n matrix as a span of n twists, which shares the memory of the matrix.
template <class Rep, class T> std::span<Twist<Rep, T>> twists_of(Matrix6X<T>& matrix) {
  static_assert(sizeof(Twist<Rep, T>) == 6 * sizeof(T));
  return {reinterpret_cast<Twist<Rep, T>*>(matrix.data()), static_cast<std::size_t>(matrix.cols())};
}

/// Returns a rows × cols matrix that f fills: f(span) is called with a span on the entries, row by row.
template <class T, class F> Eigen::MatrixX<T> row_by_row(Eigen::Index rows, Eigen::Index cols, const F& f) {
  Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> matrix(rows, cols);
  f(std::span<T>(matrix.data(), static_cast<std::size_t>(matrix.size())));
  return matrix;
}

}  // namespace detail

/// The Jacobian J, 6 × nv, of a place, which is a frame on a body: J v are the six components of the twist of
/// this frame in the representation Rep, angular part first.
template <RecursionRepresentation Rep = BodyFixed, class T>
Matrix6X<T> jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                     const std::type_identity_t<Place<T>>& place) {
  Matrix6X<T> J(6, model.nv());
  jacobian<Rep>(model, workspace, q, place, detail::twists_of<Rep>(J));
  return J;
}
/// The Jacobians of k places, which are frames on bodies, one below the other: 6 k × nv.
template <RecursionRepresentation Rep = BodyFixed, class T>
Eigen::MatrixX<T> jacobians(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                            std::type_identity_t<std::span<const Place<T>>> places) {
  const Eigen::Index n = static_cast<Eigen::Index>(places.size()), nv = model.nv();
  Matrix6X<T> side_by_side(6, n * nv);
  jacobians<Rep>(model, workspace, q, places, detail::twists_of<Rep>(side_by_side));
  Eigen::MatrixX<T> all(6 * n, nv);
  for (Eigen::Index k = 0; k < n; ++k)
    all.template middleRows<6>(6 * k) = side_by_side.middleCols(k * nv, nv);
  return all;
}
/// The Jacobian, 6 × nv, of the motion of a place (a frame on a body) relative to another place, `base`, as
/// an observer at rest in `base` sees it.
template <RecursionRepresentation Rep = BodyFixed, class T>
Matrix6X<T> relative_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                              const std::type_identity_t<Place<T>>& place,
                              const std::type_identity_t<Place<T>>& base) {
  Matrix6X<T> J(6, model.nv());
  relative_jacobian<Rep>(model, workspace, q, place, base, detail::twists_of<Rep>(J));
  return J;
}

/// The drive forces tau by inverse dynamics, nv entries (N m for angles, N for lengths).
template <RecursionChoice Rep = Fast, class T>
Eigen::VectorX<T> inverse_dynamics(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                   Numbers<T> a, const std::type_identity_t<Loads<T>>& loads = {}) {
  Eigen::VectorX<T> tau(model.nv());
  inverse_dynamics<Rep>(model, workspace, q, v, a, as_span(tau), loads);
  return tau;
}
/// The mass matrix M(q), nv × nv.
template <RecursionChoice Rep = Fast, class T>
Eigen::MatrixX<T> mass_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q) {
  return detail::row_by_row<T>(model.nv(), model.nv(),
                               [&](std::span<T> M) { mass_matrix<Rep>(model, workspace, q, M); });
}
/// The regressor Y(q, v, a), nv × 10 n_bodies, with Y π = M a + C v + g for the inertial parameters π.
template <class T>
Eigen::MatrixX<T> regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                            Numbers<T> a) {
  return detail::row_by_row<T>(model.nv(), 10 * model.n_bodies(),
                               [&](std::span<T> Y) { regressor(model, workspace, q, v, a, Y); });
}

}  // namespace axode
