#pragma once
#include <vector>

#include "axode/kinematics/path.hpp"

namespace axode {

/// The motion of a tree as power series in time, to any order. The spatial twists V_i of the bodies and the
/// joint screws J of body i satisfy, with the predecessor p of body i and the joint velocities v (Müller,
/// eqs. timeDerJs and Vsirec),
///
///     J' = [V_i, J],    V_i = V_p + J v.
///
/// Hence the coefficients of J(t) = Σ J_k t^k, V_i(t) = Σ V_{i,k} t^k and v(t) = Σ v_k t^k satisfy (D3.9)
///
///     V_{i,k} = V_{p,k} + Σ_{l<=k} J_l v_{k-l},    (k + 1) J_{k+1} = Σ_{l<=k} [V_{i,l}, J_{k-l}].
///
/// The cost is O(n k²) for n bodies and order k.
template <class T> class MotionSeries {
 public:
  MotionSeries(const Tree<T>& tree, int order)
      : order_(order),
        stride_(order + 1),
        V_((tree->n + 1) * stride_),
        J_(tree->n_screws * stride_),
        C_(tree->n + 1),
        v_(tree->nv * stride_) {}

  int order() const { return order_; }

  /// Computes the series of all twists V and joint screws J to `order`, from q and from the rates v, v', v'',
  /// ... (order + 1 rows of nv numbers).
  void run(const Tree<T>& tree, const T* q, const T* rates) noexcept { run<false>(tree, q, rates); }
  /// Computes the series of the twists V and joint screws J about the position that the origin of the root
  /// body (the first body on the path from the ground) has at t = 0. The axes are inertial.
  void run_about_roots(const Tree<T>& tree, const T* q, const T* rates) noexcept {
    run<true>(tree, q, rates);
  }

  /// The coefficients 0 to `order` of the time series of the spatial twist of body i and of joint screw s.
  const Screw<T>* twist(int i) const { return &V_[i * stride_]; }
  const Screw<T>* screw(int s) const { return &J_[s * stride_]; }
  /// The pose of body i's internal frame at t = 0.
  const SE3<T>& pose(int i) const { return C_[i]; }

 private:
  template <bool about_roots> void run(const Tree<T>& tree, const T* q, const T* rates) noexcept {
    T factorial(1);
    for (int k = 0; k <= order_; ++k) {
      if (k > 1) factorial = factorial * T(k);
      for (int c = 0; c < tree->nv; ++c) v_[c * stride_ + k] = rates[k * tree->nv + c] / factorial;
    }
    C_[0] = {};
    for (int k = 0; k <= order_; ++k) V_[k] = {};
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      C_[i] = C_[p] * joint_pose(tree, i, q);
      if (about_roots && p == 0) C_[i].r = {};
      int s = tree->first_screw[i];
      each_screw(tree, i, C_[i], [&](int, const Screw<T>& X) { J_[s++ * stride_] = X; });
      for (int k = 0; k <= order_; ++k) {
        Screw<T> V_k = V_[p * stride_ + k];
        for (s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
          const int c = tree->iv[i] + s - tree->first_screw[i];
          for (int l = 0; l <= k; ++l) V_k = V_k + v_[c * stride_ + k - l] * J_[s * stride_ + l];
        }
        V_[i * stride_ + k] = V_k;
        if (k == order_) break;
        for (s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
          Screw<T> J_next;
          for (int l = 0; l <= k; ++l) J_next = J_next + ad(V_[i * stride_ + l], J_[s * stride_ + k - l]);
          J_[s * stride_ + k + 1] = (T(1) / T(k + 1)) * J_next;
        }
      }
    }
  }

  int order_, stride_;
  std::vector<Screw<T>> V_, J_;
  std::vector<SE3<T>> C_;
  std::vector<T> v_;
};

/// The pose (R, r) of a place, a frame on a body, as power series in time: R' = ω̃ R and r' = v^s + ω × r
/// with the spatial twist (ω; v^s) of the body.
template <class T> class PoseSeries {
 public:
  explicit PoseSeries(int order) : r_(order + 2), R_(order + 2) {}

  void run(int order, const Screw<T>* V, const SE3<T>& C) noexcept {
    r_[0] = C.r;
    R_[0] = C.R;
    for (int k = 0; k <= order; ++k) {
      Vec3<T> r = V[k].v;
      SO3<T> R{{}, {}, {}};
      for (int l = 0; l <= k; ++l) {
        r += cross(V[l].w, r_[k - l]);
        const SO3<T>& Q = R_[k - l];
        R = {R.x + cross(V[l].w, Q.x), R.y + cross(V[l].w, Q.y), R.z + cross(V[l].w, Q.z)};
      }
      const T scale = T(1) / T(k + 1);
      r_[k + 1] = scale * r;
      R_[k + 1] = {scale * R.x, scale * R.y, scale * R.z};
    }
  }
  /// Coefficient k of the power series in time of the pose (R, r) of a frame on a body: axes(k) is that of
  /// the rotation R, and origin(k) that of the position r.
  const SO3<T>& axes(int k) const { return R_[k]; }
  const Vec3<T>& origin(int k) const { return r_[k]; }

  /// Converts a spatial screw (w; v), given by the coefficients X of its power series in time, to the
  /// representation Rep at the frame with the pose (R, r), and returns coefficient k of the result. The
  /// hybrid screw is (w; v + w × r), the body-fixed screw (Rᵀ w; Rᵀ (v + w × r)), and the mixed screw (Rᵀ w;
  /// v + w × r). In these formulas w, v, R and r are power series.
  template <class Rep> Screw<T> coefficient(const Screw<T>* X, int k) const noexcept {
    if constexpr (std::same_as<Rep, Spatial>) {
      return X[k];
    } else if constexpr (std::same_as<Rep, Hybrid>) {
      return {X[k].w, linear(X, k)};
    } else {
      Screw<T> Y;
      for (int l = 0; l <= k; ++l) Y.w += transpose(R_[k - l]) * X[l].w;
      if constexpr (std::same_as<Rep, Mixed>) {
        Y.v = linear(X, k);
      } else {
        for (int l = 0; l <= k; ++l) Y.v += transpose(R_[k - l]) * linear(X, l);
      }
      return Y;
    }
  }

 private:
  Vec3<T> linear(const Screw<T>* X, int k) const noexcept {
    Vec3<T> v = X[k].v;
    for (int l = 0; l <= k; ++l) v += cross(X[l].w, r_[k - l]);
    return v;
  }
  std::vector<Vec3<T>> r_;
  std::vector<SO3<T>> R_;
};

}  // namespace axode
