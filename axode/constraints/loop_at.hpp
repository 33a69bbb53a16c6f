#pragma once
#include "axode/constraints/closure.hpp"
#include "axode/lie/twist.hpp"

namespace axode {

/// One loop at a state: its residual r, and the wrenches W that close it, with W λ on the second body and -W λ on the
/// first. They are all that statics and dynamics ask for:
///   A v = Wᵀ (V_j - V_i),   (A v)' = Wᵀ (V'_j - V'_i) + W'ᵀ (V_j - V_i),   r' = Rᵀ (V_j - V_i)
/// where R = W once the loop is closed. Numbers of rows are the same in all representations.
template <class T> class LoopAt {
 public:
  using W = Wrench<Spatial, T>;
  using Wrenches = std::array<W, 6>;

  /// With the frames of the loop on its two bodies, seen from a common point O in inertial axes.
  LoopAt(const Loop& loop, const SE3<T>& C_a, const SE3<T>& C_b)
      : loop_(loop), a_(C_a), b_(C_b), closure_(loop.kind, T(loop.pitch)), size_(T(loop.size)) {}

  Six<T> residual() const {
    if (loop_.kind == LoopKind::rod) return {norm(b_.r - a_.r) - size_};
    if (loop_.kind == LoopKind::rolling) return {dot(a_.R.z, contact().p - a_.r)};
    Six<T> r = closure_.residual(relative());
    if (loop_.kind == LoopKind::universal) r[3] = (size_ - dot(a_.R.z, b_.R.z)) / sine();
    return r;
  }

  Wrenches wrenches() const {
    Wrenches all{};
    if (loop_.kind == LoopKind::rod) {
      all[0] = force(b_.r, direction());
    } else if (loop_.kind == LoopKind::rolling) {
      const Contact at = contact();
      all[0] = force(at.p, a_.R.z), all[1] = force(at.p, a_.R.x), all[2] = force(at.p, a_.R.y);
    } else {
      closure_.each_wrench([&](int k, const Six<T>& W_b) { all[index(k)] = of_second(W_b); });
      if (loop_.kind == LoopKind::universal) all[3] = couple();
    }
    return all;
  }

  /// R; of rows that have a residual.
  Wrenches residual_wrenches() const {
    if (loop_.kind == LoopKind::rod || loop_.kind == LoopKind::rolling) return wrenches();
    Wrenches all{};
    closure_.each_residual_row(relative(), [&](int k, const Six<T>& P_k) { all[index(k)] = of_second(P_k); });
    if (loop_.kind == LoopKind::universal) all[3] = couple();
    return all;
  }

  /// γ = (A v)' where V' are the rates of the two twists without accelerations of the joints, or with them (A v)' itself;
  /// of wrenches().
  Six<T> bias(const Wrenches& all, const Twist<Spatial, T>& V_i, const Twist<Spatial, T>& V_j,
              const TwistRate<Spatial, T>& dV_i, const TwistRate<Spatial, T>& dV_j) const {
    const Screw<T> i{V_i.w, V_i.v}, j{V_j.w, V_j.v}, X = j - i;
    const Screw<T> dX{dV_j.w - dV_i.w, dV_j.v - dV_i.v};
    const auto power = [](const W& F, const Screw<T>& Z) { return dot(F.m, Z.w) + dot(F.f, Z.v); };
    Six<T> gamma{};
    if (loop_.kind == LoopKind::rod) {
      const Vec3<T> u = direction(), slip = velocity(j, b_.r) - velocity(i, a_.r);
      const Vec3<T> du = (T(1) / norm(b_.r - a_.r)) * (slip - dot(u, slip) * u);
      gamma[0] = power(all[0], dX) + dot(cross(velocity(j, b_.r), u), X.w) + power(force(b_.r, du), X);
    } else if (loop_.kind == LoopKind::rolling) {
      const Contact at = contact();
      const Vec3<T> dp = velocity_of_contact(i, j);
      const std::array<const Vec3<T>*, 3> axes{&a_.R.z, &a_.R.x, &a_.R.y};
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3<T>&e = *axes[k], de = cross(i.w, e);
        gamma[k] = power(all[k], dX) + power(W{cross(dp, e) + cross(at.p, de), de}, X);
      }
    } else {  // its wrenches rest in the second body: W' = -ad_{V_j}ᵀ W
      const Screw<T> Psi = dX + ad(j, i);
      for (std::size_t k = 0; k < 6; ++k) gamma[k] = power(all[k], Psi);
      if (loop_.kind == LoopKind::universal) {
        const Vec3<T>&x = a_.R.z, &y = b_.R.z;
        const Vec3<T> dm = cross(cross(i.w, x), y) + cross(x, cross(j.w, y));
        gamma[3] = power(all[3], dX) + dot(dm, X.w) / sine();
      }
    }
    return gamma;
  }

 private:
  /// Where a wheel or a sphere touches, p = c - ρ d, and for a wheel y, of which d is the direction.
  struct Contact {
    Vec3<T> d, p, y;
  };

  static std::size_t index(int k) { return static_cast<std::size_t>(k); }
  SE3<T> relative() const {
    const SO3<T> Rt = transpose(a_.R);
    return {Rt * b_.R, Rt * (b_.r - a_.r)};
  }
  static W force(const Vec3<T>& at, const Vec3<T>& f) { return {cross(at, f), f}; }
  static Vec3<T> velocity(const Screw<T>& V, const Vec3<T>& p) { return V.v + cross(V.w, p); }
  W of_second(const Six<T>& W_b) const {
    const Vec3<T> f = b_.R * Vec3<T>{W_b[3], W_b[4], W_b[5]};
    return {b_.R * Vec3<T>{W_b[0], W_b[1], W_b[2]} + cross(b_.r, f), f};
  }
  /// Of the angle between the axes of a universal joint.
  T sine() const { return sqrt(T(1) - size_ * size_); }
  W couple() const { return {(T(1) / sine()) * cross(a_.R.z, b_.R.z), {}}; }
  /// Of a rod.
  Vec3<T> direction() const {
    const Vec3<T> d = b_.r - a_.r;
    return (T(1) / norm(d)) * d;
  }

  Contact contact() const {
    const Vec3<T>& n = a_.R.z;
    if (!loop_.wheel) return {n, b_.r - size_ * n, n};
    const Vec3<T>& k = b_.R.z;
    const Vec3<T> y = n - dot(k, n) * k, d = (T(1) / norm(y)) * y;
    return {d, b_.r - size_ * d, y};
  }
  /// p' in the inertial frame: the place moves along the rim and along the plane.
  Vec3<T> velocity_of_contact(const Screw<T>& i, const Screw<T>& j) const {
    const Vec3<T>& n = a_.R.z;
    const Vec3<T> dn = cross(i.w, n), dc = velocity(j, b_.r);
    if (!loop_.wheel) return dc - size_ * dn;
    const Contact at = contact();
    const Vec3<T>& k = b_.R.z;
    const Vec3<T> dk = cross(j.w, k);
    const Vec3<T> dy = dn - dot(k, n) * dk - (dot(dk, n) + dot(k, dn)) * k;
    return dc - (size_ / norm(at.y)) * (dy - dot(at.d, dy) * at.d);
  }

  const Loop& loop_;
  SE3<T> a_, b_;
  Closure<T> closure_;
  T size_;
};

}  // namespace axode
