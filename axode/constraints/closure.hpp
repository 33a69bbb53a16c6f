#pragma once
#include <array>
#include <cmath>
#include <numbers>

#include "axode/lie/six.hpp"
#include "axode/model/loops.hpp"
#include "axode/model/subgroup.hpp"

/// Loop joints as subgroups of SE(3): what is left of a relative pose D when the motion that the joint allows is stripped
/// off it, D = g E, and how that closes.
///
/// S spans the subalgebra of the joint, T the wrenches with Tᵀ S = 0. The residual r = Tᵀ (log R_E; r_E) vanishes on the
/// whole subgroup, however far the joint has moved; Tᵀ log D does not (it jumps at half a turn).
namespace axode {

/// A screw or wrench by its six coordinates, angular before linear.
template <class T> using Six = std::array<T, 6>;
template <class T> constexpr Six<T> six(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x, a.y, a.z, b.x, b.y, b.z};
}

/// Which coordinates of a screw the joint leaves free, ω_x ω_y ω_z v_x v_y v_z; a helical one ω_z with v_z = pitch ω_z.
constexpr std::array<bool, 6> free_coordinates(LoopKind kind) {
  switch (kind) {
    case LoopKind::revolute:
    case LoopKind::helical: return {0, 0, 1, 0, 0, 0};
    case LoopKind::prismatic: return {0, 0, 0, 0, 0, 1};
    case LoopKind::cylindrical: return {0, 0, 1, 0, 0, 1};
    case LoopKind::spherical:
    case LoopKind::universal:
      return {1, 1, 1, 0, 0, 0};  // a universal joint is a spherical one with a row more
    case LoopKind::planar: return {0, 0, 1, 1, 1, 0};
    case LoopKind::translational: return {0, 0, 0, 1, 1, 1};
    default: return {};
  }
}

/// A joint that leaves a subgroup free.
template <class T> class Closure {
 public:
  Closure(LoopKind kind, const T& pitch)
      : kind_(kind), pitch_(kind == LoopKind::helical ? pitch : T(0)), free_(free_coordinates(kind)) {}

  /// f(k, W) for every wrench of T, in the frame of the joint.
  template <class F> void each_wrench(F&& f) const {
    int row = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      if (free_[k]) continue;
      Six<T> W{};
      W[k] = T(1);
      if (k == 5 && kind_ == LoopKind::helical) W[2] = -pitch_;
      f(row++, W);
    }
  }

  /// E of D = g E, with g in the subgroup and E near the identity where the joint is nearly closed.
  SE3<T> strip(const SE3<T>& D) const {
    using std::atan2, std::round;
    const SO3<T>& R = D.R;
    T theta(0);
    SO3<T> turn{};
    if (kind_ == LoopKind::spherical || kind_ == LoopKind::universal) {
      turn = R;
    } else if (free_[2]) {  // R is a twist about z and a swing
      theta = atan2(R.x.y - R.y.x, R.x.x + R.y.y);
      if (kind_ == LoopKind::helical) {  // the turn that is nearest to where the nut is
        const T whole = T(2 * std::numbers::pi);
        theta += whole * round((D.r.z / pitch_ - theta) / whole);
      }
      turn = subgroup::turn(SO3<T>{}, sin(theta), cos(theta));
    }
    const Vec3<T> shift{free_[3] ? D.r.x : T(0), free_[4] ? D.r.y : T(0),
                        kind_ == LoopKind::helical ? pitch_ * theta
                        : free_[5]                 ? D.r.z
                                                   : T(0)};
    const SO3<T> Rt = transpose(turn);
    return {Rt * R, Rt * (D.r - shift)};
  }

  /// The residual at D, up to six numbers.
  Six<T> residual(const SE3<T>& D) const {
    const SE3<T> E = strip(D);
    const bool turns_anyhow = free_[0];
    const Six<T> x = six(turns_anyhow ? Vec3<T>{} : log_SO3(E.R), E.r);
    Six<T> r{};
    each_wrench([&](int row, const Six<T>& W) { r[static_cast<std::size_t>(row)] = product(W, x); });
    return r;
  }

  /// f(k, P_k) for the rows of P, in the frame of the joint: r' = P X for X = D⁻¹ D', exactly. P = Tᵀ on the subgroup.
  ///
  /// P = Tᵀ (I - K (Nᵀ K)⁻¹ Nᵀ) B, with B = diag(dexp⁻¹_{-φ}, R_E), K = B Ad_E⁻¹ S and N the coordinates that strip
  /// makes 0.
  template <class F> void each_residual_row(const SE3<T>& D, F&& f) const {
    const SE3<T> E = strip(D);
    const Vec3<T> phi = log_SO3(E.R);
    std::array<Six<T>, 6> K{};
    std::array<std::size_t, 6> N{};
    std::size_t n = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      if (!free_[k]) continue;
      Screw<T> S{{T(k == 0), T(k == 1), T(k == 2)}, {T(k == 3), T(k == 4), T(k == 5)}};
      if (kind_ == LoopKind::helical) S.v.z = pitch_;
      const Screw<T> X = Ad_inv(E, S);
      K[n] = six(dexp_inv(-phi, X.w), E.R * X.v), N[n++] = k;
    }
    std::array<std::array<T, 3>, 3> NK{{{T(1)}, {T(0), T(1)}, {T(0), T(0), T(1)}}};  // its columns
    for (std::size_t b = 0; b < n; ++b)
      for (std::size_t a = 0; a < n; ++a) NK[b][a] = K[b][N[a]];
    const auto column = [&](std::size_t b) { return Vec3<T>{NK[b][0], NK[b][1], NK[b][2]}; };
    const Vec3<T> x = cross(column(1), column(2)), y = cross(column(2), column(0)),
                  z = cross(column(0), column(1));
    const T inverse_volume = T(1) / dot(column(0), x);
    each_wrench([&](int row, Six<T> W) {
      std::array<T, 3> WK{};
      for (std::size_t b = 0; b < n; ++b) WK[b] = product(W, K[b]);
      const Vec3<T> s = inverse_volume * (WK[0] * x + WK[1] * y + WK[2] * z);  // (Nᵀ K)⁻ᵀ Kᵀ W
      const std::array<T, 3> share{s.x, s.y, s.z};
      for (std::size_t a = 0; a < n; ++a) W[N[a]] -= share[a];
      const Vec3<T> m = dexp_inv(phi, Vec3<T>{W[0], W[1], W[2]});
      const Vec3<T> f_E = transpose(E.R) * Vec3<T>{W[3], W[4], W[5]};
      f(row, six(m, f_E));
    });
  }

 private:
  static T product(const Six<T>& a, const Six<T>& b) {
    T sum(0);
    for (std::size_t k = 0; k < 6; ++k) sum += a[k] * b[k];
    return sum;
  }

  LoopKind kind_;
  T pitch_;
  std::array<bool, 6> free_;
};

}  // namespace axode
