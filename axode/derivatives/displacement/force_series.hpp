#pragma once
#include "axode/kinematics/higher_order/motion_series.hpp"
#include "axode/recursion/inverse_dynamics.hpp"

namespace axode {

/// Computes the drive forces τ of a motion as power series in time, to any order k in O(n k²) for n bodies
/// ((D3.9) to (D3.11) of docs/derivations). All quantities of a body are in inertial axes about a fixed
/// point, where the root body of its branch (the body that is joined to the ground) has its origin at t = 0.
/// About a fixed point, the total wrench on a body is the time derivative of its momentum.
template <class T> class ForceSeries {
 public:
  /// `order` is the order of the series of τ.
  ForceSeries(const Tree<T>& tree, int order)
      : order_(order),
        stride_(order + 1),
        motion_(tree, order + 1),
        M_(static_cast<std::size_t>(order + 2)),
        place_(order + 1),
        W_(static_cast<std::size_t>((tree->n + 1) * stride_)),
        C_(static_cast<std::size_t>(tree->n + 1)),
        origin_(static_cast<std::size_t>(tree->n + 1)) {}

  int order() const { return order_; }

  /// Computes τ, τ', ... (order + 1 rows of nv numbers) from q and `rates`, which are v, v', v'', ... (order
  /// + 2 rows of nv numbers). `tau` and `rates` must not overlap.
  void run(const Tree<T>& tree, const T* q, const T* rates, const Loads<T>& loads, T* tau) noexcept {
    motion_.run_about_roots(tree, q, rates);
    for (int k = 0; k <= order_; ++k) W(0, k) = {};
    for (int i = 1; i <= tree->n; ++i) set_inertial(tree, i);
    if (!loads.wrenches.empty()) apply(tree, q, loads.wrenches);
    for (int i = tree->n; i > 0; --i)
      if (const int p = tree->parent[i]; p > 0)
        for (int k = 0; k <= order_; ++k) W(p, k) += W(i, k);
    T factorial(1);
    for (int k = 0; k <= order_; ++k) {
      if (k > 1) factorial = factorial * T(k);
      T* const tau_k = tau + static_cast<std::ptrdiff_t>(k) * tree->nv;
      const T* const a_k = rates + static_cast<std::ptrdiff_t>(k + 1) * tree->nv;
      const T* const v_k = a_k - tree->nv;
      for (int c = 0; c < tree->nv; ++c) {
        tau_k[c] = tree.armature[c] * a_k[c];
        if (loads.joint_losses) tau_k[c] += k == 0 ? joint_loss(tree, c, v_k[c]) : tree.damping[c] * v_k[c];
      }
      for (int i = 1; i <= tree->n; ++i)
        for (int s = tree->first_screw[i]; s < tree->first_screw[i + 1]; ++s) {
          T sum(0);
          for (int l = 0; l <= k; ++l) {
            const Screw<T>& J = motion_.screw(s)[l];
            const Wrench<Spatial, T>& F = W(i, k - l);
            sum += dot(J.w, F.m) + dot(J.v, F.f);
          }
          tau_k[tree->iv[i] + s - tree->first_screw[i]] += factorial * sum;
        }
    }
  }

 private:
  Wrench<Spatial, T>& W(int i, int k) { return W_[static_cast<std::size_t>(i * stride_ + k)]; }

  /// Computes the series of the wrench that the motion of body i under gravity requires.
  void set_inertial(const Tree<T>& tree, int i) noexcept {
    const auto V = [&](int k) {
      const Screw<T>& X = motion_.twist(i)[k];
      return Twist<Spatial, T>{X.w, X.v};
    };
    const auto at = [](int k) { return static_cast<std::size_t>(k); };
    M_[0] = transform(motion_.pose(i), tree.M[i]);
    for (int k = 0; k <= order_; ++k) {
      Inertia<T> rate{};
      for (int l = 0; l <= k; ++l) rate += inertia_rate(V(l), M_[at(k - l)]);
      const T scale = T(1) / T(k + 1);
      M_[at(k + 1)] = {T(0), scale * rate.h, scale * rate.Theta};
      Momentum<Spatial, T> Pi{};
      for (int l = 0; l <= k + 1; ++l) Pi += M_[at(l)] * V(k + 1 - l);
      const Vec3<T> weight = M_[at(k)].m * tree.g;
      W(i, k) = {T(k + 1) * Pi.l - cross(M_[at(k)].h, tree.g), T(k + 1) * Pi.p - weight};
    }
  }
  /// Subtracts the loads from the wrenches of their bodies. The representation of a load determines whether
  /// its moment and force turn with the body.
  void apply(const Tree<T>& tree, const T* q, std::span<const AppliedWrench<T>> wrenches) noexcept {
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      C_[static_cast<std::size_t>(i)] = C_[static_cast<std::size_t>(p)] * joint_pose(tree, i, q);
      origin_[static_cast<std::size_t>(i)] =
          p == 0 ? C_[static_cast<std::size_t>(i)].r : origin_[static_cast<std::size_t>(p)];
    }
    for (const AppliedWrench<T>& load : wrenches) {
      const int i = tree->frame_body[load.frame];
      if (i == 0) continue;
      if (load.representation == Representation::spatial) {
        W(i, 0) -= Wrench<Spatial, T>{load.m - cross(origin_[static_cast<std::size_t>(i)], load.f), load.f};
        continue;
      }
      const SE3<T> C = motion_.pose(i) * tree.frame_offset[load.frame];
      place_.run(order_, motion_.twist(i), C);
      const bool turns_m = load.representation != Representation::hybrid,
                 turns_f = load.representation == Representation::body;
      for (int k = 0; k <= order_; ++k) {
        const Vec3<T> none{};
        Vec3<T> m = turns_m ? place_.axes(k) * load.m : k == 0 ? load.m : none;
        const Vec3<T> f_k = turns_f ? place_.axes(k) * load.f : k == 0 ? load.f : none;
        for (int l = 0; l <= k; ++l) {
          const Vec3<T> f = turns_f ? place_.axes(k - l) * load.f : k == l ? load.f : none;
          m += cross(place_.origin(l), f);
        }
        W(i, k) -= Wrench<Spatial, T>{m, f_k};
      }
    }
  }

  int order_, stride_;
  MotionSeries<T> motion_;
  std::vector<Inertia<T>> M_;
  PoseSeries<T> place_;
  std::vector<Wrench<Spatial, T>> W_;
  std::vector<SE3<T>> C_;
  std::vector<Vec3<T>> origin_;
};

}  // namespace axode
