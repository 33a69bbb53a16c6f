#pragma once
#include <algorithm>
#include <array>

#include "axode/constraints/loops/loop_frames.hpp"
#include "axode/lie/six.hpp"
#include "axode/model/subgroup.hpp"

namespace axode::loops {

/// A loop joint whose free motions form a subgroup of SE(3). The subgroup is given by its free directions
/// among ω_x ω_y ω_z v_x v_y v_z in the frame of the joint and, for a helical joint, by the pitch in v_z =
/// pitch ω_z.
///
/// S spans the Lie algebra of the subgroup, and T the wrenches with Tᵀ S = 0. The pose of the joint frame on
/// the second body relative to that on the first is D = g E, with the motion g in the subgroup for which the
/// coordinates of (log R_E; r_E) in the free directions are 0, where R_E is the rotation and r_E the position
/// of E. The residual r = Tᵀ (log R_E; r_E) is 0 for all D in the subgroup.
struct SubgroupClosure {
  std::array<bool, 6> free{};
  double pitch = 0;  ///< m/rad, 0 unless the joint is helical

  constexpr int rows() const { return 6 - static_cast<int>(std::count(free.begin(), free.end(), true)); }
  constexpr int residuals() const { return rows(); }

  template <class T> void wrenches(const LoopFrames<T>& at, SpatialWrench<T>* W) const {
    for (int k = 0; k < 6; ++k) {
      if (is_free(k)) continue;
      const Vec3<T>& e = subgroup::axis(at.b.R, k % 3);
      *W = k < 3 ? SpatialWrench<T>{e, {}} : force_at(at.b.r, e);
      if (k == 5 && pitch != 0) W->m -= T(pitch) * e;
      ++W;
    }
  }
  /// Computes γ by (D6.8). The wrenches are fixed to the second body, so that W' = -ad_{V_j}ᵀ W.
  template <class T>
  void bias(const LoopFrames<T>&, const SpatialWrench<T>* W, const EndMotion<T>& m, T* gamma) const {
    const Screw<T> Psi = m.dV_j - m.dV_i + ad(m.V_j, m.V_i);
    for (int k = 0, n = rows(); k < n; ++k) gamma[k] = power(W[k], Psi);
  }

  /// Writes the relative pose of the two frames as D = g E and returns E. The motion g is in the subgroup
  /// that the joint allows, and is chosen so that the coordinates of (log R_E; r_E) in the free directions of
  /// the joint are 0, where R_E is the rotation and r_E the position of E. If the joint is nearly closed, E
  /// is near the identity (D6.1).
  template <class T> SE3<T> strip(const SE3<T>& D) const {
    T theta(0);
    SO3<T> turn{};
    if (free[0]) {
      turn = D.R;
    } else if (free[2]) {  // the rotation is a twist about z and a swing
      theta = subgroup::turn_about_z(D.R);
      if (pitch != 0) theta = subgroup::nearest_turn(theta, D.r.z / T(pitch));
      turn = subgroup::turn(SO3<T>{}, sin(theta), cos(theta));
    }
    const T along_z = free[5] ? D.r.z : T(pitch) * theta;
    const Vec3<T> shift{free[3] ? D.r.x : T(0), free[4] ? D.r.y : T(0), along_z};
    const SO3<T> Rt = transpose(turn);
    return {Rt * D.R, Rt * (D.r - shift)};
  }
  template <class T> void residual(const LoopFrames<T>& at, T* r) const {
    const SE3<T> E = strip(relative(at));
    const Vec3<T> phi = free[0] ? Vec3<T>{} : log_SO3(E.R);
    for (int k = 0; k < 6; ++k) {
      if (is_free(k)) continue;
      *r = entry(k < 3 ? phi : E.r, k % 3);
      if (k == 5 && pitch != 0) *r -= T(pitch) * phi.z;
      ++r;
    }
  }
  /// Computes the wrenches R with r' = Rᵀ (V_j - V_i) for the residual r of the joint and the twists V_i and
  /// V_j of its two bodies (D6.4). D = g E is the pose of the joint frame on the second body relative to that
  /// on the first, with a motion g that the joint allows. With φ = log R_E, and the rotation R_E and the
  /// position r_E of E, r is Tᵀ (φ; r_E). In the joint frame on the second body, V_j - V_i is X = D⁻¹ D', and
  /// r' = P X with
  ///   P = Tᵀ (I - K (Nᵀ K)⁻¹ Nᵀ) B
  /// and B = diag(dexp⁻¹_{-φ}, R_E), K = B Ad_E⁻¹ S. S spans the free screws of the joint, and T the wrenches
  /// reciprocal to S. The columns of N are unit vectors of those coordinates of (φ; r_E) that are 0 by the
  /// choice of g.
  template <class T> void residual_wrenches(const LoopFrames<T>& at, SpatialWrench<T>* R) const {
    const SE3<T> E = strip(relative(at));
    const Vec3<T> phi = log_SO3(E.R);
    std::array<Six<T>, 6> K{};
    std::array<std::size_t, 6> N{};
    std::size_t n = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      if (!free[k]) continue;
      Screw<T> S{{T(k == 0), T(k == 1), T(k == 2)}, {T(k == 3), T(k == 4), T(k == 5)}};
      if (pitch != 0) S.v.z = T(pitch);
      const Screw<T> X = Ad_inv(E, S);
      K[n] = six(dexp_inv(-phi, X.w), E.R * X.v);
      N[n] = k;
      ++n;
    }
    std::array<std::array<T, 3>, 3> NK{{{T(1)}, {T(0), T(1)}, {T(0), T(0), T(1)}}};  // columns of Nᵀ K
    for (std::size_t b = 0; b < n; ++b)
      for (std::size_t a = 0; a < n; ++a) NK[b][a] = K[b][N[a]];
    const auto column = [&](std::size_t b) { return Vec3<T>{NK[b][0], NK[b][1], NK[b][2]}; };
    const Vec3<T> x = cross(column(1), column(2)), y = cross(column(2), column(0)),
                  z = cross(column(0), column(1));
    const T inverse_volume = T(1) / dot(column(0), x);
    for (std::size_t k = 0; k < 6; ++k) {
      if (free[k]) continue;
      Six<T> W{};
      W[k] = T(1);
      if (k == 5) W[2] = T(-pitch);
      std::array<T, 3> WK{};
      for (std::size_t b = 0; b < n; ++b)
        for (std::size_t e = 0; e < 6; ++e) WK[b] += W[e] * K[b][e];
      const Vec3<T> s = inverse_volume * (WK[0] * x + WK[1] * y + WK[2] * z);  // (Nᵀ K)⁻ᵀ Kᵀ W
      const std::array<T, 3> share{s.x, s.y, s.z};
      for (std::size_t a = 0; a < n; ++a) W[N[a]] -= share[a];
      const Vec3<T> m = at.b.R * dexp_inv(phi, Vec3<T>{W[0], W[1], W[2]});
      const Vec3<T> f = at.b.R * (transpose(E.R) * Vec3<T>{W[3], W[4], W[5]});
      *R++ = {m + cross(at.b.r, f), f};
    }
  }

 private:
  constexpr bool is_free(int k) const { return free[static_cast<std::size_t>(k)]; }
  template <class T> static SE3<T> relative(const LoopFrames<T>& at) {
    const SO3<T> Rt = transpose(at.a.R);
    return {Rt * at.b.R, Rt * (at.b.r - at.a.r)};
  }
};

}  // namespace axode::loops
