#pragma once
#include <algorithm>
#include <array>

#include "axode/kinematics/path.hpp"
#include "axode/model/model.hpp"

/// The force laws of springs, dampers and stops, for forces and their derivatives.
namespace axode {

/// The force of the spring and the stops on a joint of one velocity, the derivatives of this force by
/// position and velocity, and the energy.
template <class T> struct ElasticForce { T f, by_p, by_dp, energy; };
template <class T> ElasticForce<T> elastic_force(const Dof& dof, const T& p, const T& dp) noexcept {
  const T k = T(dof.stiffness), x = p - T(dof.rest);
  ElasticForce<T> out{-k * x, -k, T(0), T(0.5) * k * x * x};
  const T upper = T(dof.upper), lower = T(dof.lower);
  const T depth = p > upper ? p - upper : lower > p ? p - lower : T(0);  // negative at the lower limit
  const T k_stop = T(dof.stop_stiffness), d = depth < T(0) ? T(-dof.stop_damping) : T(dof.stop_damping);
  const T grip = T(1) + d * dp;
  if (!(grip < T(0))) {
    out.f -= k_stop * depth * grip;
    if (depth != T(0)) out.by_p -= k_stop * grip;
    out.by_dp -= k_stop * depth * d;
  }
  out.energy += T(0.5) * k_stop * depth * depth;
  return out;
}

/// The spring of a joint of several velocities at x = log(q): the force K x, and the rates x' = dexp_{-x}⁻¹
/// e_k that belong to the velocities of the joint.
template <class Joint, class T> struct ElasticLogarithm {
  using Entries = std::array<T, Joint::nv>;
  Entries x, Kx;
  std::array<Entries, Joint::nv> dx;

  ElasticLogarithm(const Joint& joint, const std::vector<Dof>& dof, const T* q) noexcept : joint_(joint) {
    joint.difference(joint.neutral().data(), q, x.data());
    for (int l = 0; l < joint.nv; ++l) Kx[l] = T(dof[l].stiffness) * x[l];
    const Twist<BodyFixed, T> X = joint.twist(x.data());
    minus_X_ = {-X.w, -X.v};
    for (int k = 0; k < joint.nv; ++k) dx[k] = components(dexp_inv(minus_X_, joint.column(k)));
  }
  T force(int k) const { return -product(Kx, dx[k]); }
  /// The derivative of force k along velocity j.
  T by_q(const std::vector<Dof>& dof, int k, int j) const {
    Entries K_dx;
    for (int l = 0; l < joint_.nv; ++l) K_dx[l] = T(dof[l].stiffness) * dx[j][l];
    const Twist<BodyFixed, T> dX = joint_.twist(dx[j].data());
    return -product(K_dx, dx[k]) -
           product(Kx, components(ddexp_inv(minus_X_, Screw<T>{-dX.w, -dX.v}, joint_.column(k))));
  }
  T energy() const { return T(0.5) * product(Kx, x); }

 private:
  Entries components(const Screw<T>& Z) const { return joint_.project(Wrench<BodyFixed, T>{Z.w, Z.v}); }
  static T product(const Entries& a, const Entries& b) {
    T sum(0);
    for (std::size_t l = 0; l < a.size(); ++l) sum += a[l] * b[l];
    return sum;
  }

  const Joint& joint_;
  Screw<T> minus_X_;
};

/// The line between the two ends of a spring. It is expressed in the internal frame of the body where the
/// paths from both ends to the ground meet, so that no digits are lost far from the inertial origin.
template <class T> struct SpringLine {
  std::array<Place<T>, 2> place;
  int meeting;
  std::array<SO3<T>, 2> R;
  Vec3<T> r, dr;  ///< vector from the first end to the second, and its rate
  T length;       ///< ‖r‖
  Vec3<T> u;      ///< r/‖r‖, or 0
  T rate{}, f{};  ///< rate of the length, and tension

  /// Calls columns(end, joint, velocity, column) for each column on the paths from the ends to the meeting
  /// body. Without v, which may be nullptr, the rates are 0.
  template <class F>
  SpringLine(const Springs::Line& line, const Tree<T>& tree, const T* q, const T* v,
             const F& columns) noexcept
      : place{place_of(line, 0), place_of(line, 1)},
        meeting(
            common_predecessor(tree, tree->frame_body[place[0].frame], tree->frame_body[place[1].frame])) {
    for (std::size_t e = 0; e < 2; ++e) {
      Vec3<T> moves{};
      const SE3<T> C = each_body_fixed_column(
          tree, q, place[e],
          [&](int i, int c, const Screw<T>& X) {
            if (v != nullptr) moves += v[c] * X.v;
            columns(e, i, c, X);
          },
          meeting);
      R[e] = C.R;
      r = e == 0 ? -C.r : r + C.r;
      dr = e == 0 ? -(C.R * moves) : dr + C.R * moves;
    }
    length = norm(r);
    if (length == T(0)) return;
    u = (T(1) / length) * r;
    rate = dot(u, dr);
    f = T(line.stiffness) * (length - T(line.rest)) + T(line.damping) * rate;
  }

  static T energy(const Springs::Line& line, const T& length) {
    const T x = length - T(line.rest);
    return T(0.5) * T(line.stiffness) * x * x;
  }

 private:
  static Place<T> place_of(const Springs::Line& line, std::size_t e) {
    return {line.ends[e].frame, cast<T>(line.ends[e].point)};
  }
};

}  // namespace axode
