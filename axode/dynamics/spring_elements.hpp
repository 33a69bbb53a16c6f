#pragma once
#include <algorithm>
#include <array>

#include "axode/kinematics/path.hpp"
#include "axode/lie/six.hpp"
#include "axode/model/model.hpp"

/// Forces of springs, dampers and joint stops, with the derivatives of these forces.
namespace axode {

/// The force f of the spring and the stops on a joint of one velocity, its derivatives by the position p and
/// the velocity dp of the joint, and the elastic energy.
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

/// The spring of a joint with several velocities. x = log(q) is the logarithm of the joint's displacement
/// from its reference pose (coordinates 0, quaternion the identity). `Kx` is the diagonal stiffness matrix
/// times x, and dx[k] = dexp_{-x}⁻¹ e_k is the rate of x for a unit of velocity k.
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
  /// The derivative of force(k) when the joint moves along velocity j; `dof` has the stiffnesses.
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

/// The body at which the paths from two frames on bodies to the ground meet.
template <class T> int meeting_of(const Tree<T>& tree, const std::array<Place<T>, 2>& place) noexcept {
  return common_predecessor(tree, tree->frame_body[place[0].frame], tree->frame_body[place[1].frame]);
}

/// A straight segment of a spring, between two points on bodies. Vectors are in the joint frame of the body
/// `meeting`, where the paths from the two bodies to the ground meet.
template <class T> struct Segment {
  std::array<Place<T>, 2> place;
  int meeting;
  std::array<SO3<T>, 2> R;
  Vec3<T> r, dr;  ///< vector from the first end to the second, and its rate
  T length;       ///< ‖r‖
  Vec3<T> u;      ///< r/‖r‖, or 0
  T rate{};       ///< rate of the length

  /// Computes all members for the segment between two points; rates are 0 if v is null. Calls columns(e, i,
  /// c, X) for each end e (0 or 1) and each velocity c of the joints between this end and the body where the
  /// paths from both ends to the ground meet. i is the body of the joint, c the index of the velocity in v,
  /// and X the column of the body-fixed Jacobian of the end for this velocity.
  template <class F>
  Segment(const Spring::Path::Point* ends, const Tree<T>& tree, const T* q, const T* v,
          const F& columns) noexcept
      : place{place_of(ends[0]), place_of(ends[1])}, meeting(meeting_of(tree, place)) {
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
  }

 private:
  static Place<T> place_of(const Spring::Path::Point& p) { return {p.frame, cast<T>(p.point)}; }
};

/// Calls f(segment) for each Segment of the path of a spring.
template <class T, class F>
void each_segment(const Spring::Path& path, const Tree<T>& tree, const T* q, const T* v,
                  const F& f) noexcept {
  for (std::size_t k = 1; k < path.points.size(); ++k)
    f(Segment<T>(&path.points[k - 1], tree, q, v, [](std::size_t, int, int, const auto&) {}));
}

/// The coordinate x of a spring (m or rad) and its rate dx.
template <class T> struct SpringCoordinate { T x, dx; };

template <class T>
SpringCoordinate<T> coordinate_of(const Spring::Path& path, const Tree<T>& tree, const T* q,
                                  const T* v) noexcept {
  SpringCoordinate<T> sum{T(0), T(0)};
  each_segment(path, tree, q, v, [&](const Segment<T>& segment) {
    sum.x += segment.length;
    sum.dx += segment.rate;
  });
  return sum;
}

template <class T>
SpringCoordinate<T> coordinate_of(const Spring::JointSum& joints, const Tree<T>&, const T* q,
                                  const T* v) noexcept {
  SpringCoordinate<T> sum{T(joints.offset), T(0)};
  for (const Spring::JointSum::Term& term : joints.terms) {
    sum.x += T(term.factor) * q[term.coordinate];
    if (v != nullptr) sum.dx += T(term.factor) * v[term.velocity];
  }
  return sum;
}

/// The pose D and the twist V of the second frame of a spring relative to the first one; V is in the axes and
/// about the origin of the second frame.
template <class T> struct RelativePose {
  std::array<Place<T>, 2> place;
  int meeting;
  SE3<T> D;
  Screw<T> V;

  /// Computes the pose D and the twist V of the second frame of a spring relative to the first; V is 0 if v
  /// is null. Calls columns(e, i, c, X) for each frame (e = 0 or 1) and each velocity c of the joints between
  /// this frame and the body where the paths from both frames to the ground meet. i is the body of the joint,
  /// c the index of the velocity in v, and X the column of the body-fixed Jacobian of the frame for this
  /// velocity.
  template <class F>
  RelativePose(const std::array<Spring::End, 2>& ends, const Tree<T>& tree, const T* q, const T* v,
               const F& columns) noexcept
      : place{place_of(ends[0]), place_of(ends[1])}, meeting(meeting_of(tree, place)) {
    for (std::size_t e = 0; e < 2; ++e) {
      Screw<T> moves{};
      const SE3<T> C = each_body_fixed_column(
          tree, q, place[e],
          [&](int i, int c, const Screw<T>& X) {
            if (v != nullptr) moves = moves + v[c] * X;
            columns(e, i, c, X);
          },
          meeting);
      D = e == 0 ? inverse(C) : D * C;
      V = e == 0 ? moves : moves - Ad_inv(D, V);
    }
  }

 private:
  static Place<T> place_of(const Spring::End& end) { return {end.frame, cast<T>(end.pose)}; }
};

/// The wrench W = (moment; force) of a spring on its second frame, in the axes and about the origin of this
/// frame. If computed, K = -∂W/∂η is its derivative for displacements D → D exp(η), where D is the pose of
/// the second frame relative to the first, and C = -∂W/∂V its derivative by the relative twist V.
template <class T> struct SpringWrench {
  using Matrix = std::array<std::array<T, 6>, 6>;
  Six<T> W{};
  Matrix K{}, C{};
};
template <class T> T product(const Six<T>& a, const Six<T>& b) {
  T sum(0);
  for (std::size_t k = 0; k < 6; ++k) sum += a[k] * b[k];
  return sum;
}
template <class U, class T> Six<T> product(const std::array<std::array<U, 6>, 6>& A, const Six<T>& x) {
  Six<T> y{};
  for (std::size_t k = 0; k < 6; ++k)
    for (std::size_t l = 0; l < 6; ++l) y[k] += T(A[k][l]) * x[l];
  return y;
}
template <class T> Six<T> six(const Screw<T>& X) { return six(X.w, X.v); }
template <class T> Screw<T> unit_screw(std::size_t k) {
  Six<T> e{};
  e[k] = T(1);
  return {{e[0], e[1], e[2]}, {e[3], e[4], e[5]}};
}

/// The twist angle about the z-axis of a rotation R, from -π to π, with its first and second derivatives. It
/// is 2 atan2(z, w) for the unit quaternion (x, y, z, w) of R (D16.8): R is a rotation by this angle about z,
/// followed by a rotation about an axis normal to z. The gradient g and the derivatives of g are those for
/// displacements R → R exp(η) with rotation vectors η.
template <class T> struct TwistAngle {
  T angle;
  Vec3<T> g;

  explicit TwistAngle(const SO3<T>& R) noexcept : a_(quaternion(R)), square_(a_.w * a_.w + a_.z * a_.z) {
    angle = T(2) * atan2(a_.z, a_.w);
    g = (T(1) / square_) * numerator();
  }
  /// The derivative of the gradient g when the rotation is displaced along η, R → R exp(η).
  Vec3<T> gradient_along(const Vec3<T>& eta) const {
    const Vec3<T> v{a_.x, a_.y, a_.z}, e{T(0), T(0), T(1)};
    const T dw = T(-0.5) * dot(v, eta);
    const Vec3<T> dv = T(0.5) * (a_.w * eta + cross(v, eta));
    const Vec3<T> d = T(2) * a_.w * dw * e + dw * cross(e, v) + a_.w * cross(e, dv) + dv.z * v + v.z * dv;
    return (T(1) / square_) * (d - T(2) * (a_.w * dw + a_.z * dv.z) * g);
  }

 private:
  Vec3<T> numerator() const {
    const Vec3<T> v{a_.x, a_.y, a_.z}, e{T(0), T(0), T(1)};
    return a_.w * a_.w * e + a_.w * cross(e, v) + v.z * v;
  }
  Quaternion<T> a_;
  T square_;
};

/// Computes the wrench W of a torsion spring on the second of its two frames (D16.9). `at` has the pose D of
/// the second frame relative to the first, and the twist V of the second frame relative to the first. W and V
/// are in the axes and about the origin of the second frame. If `with_derivatives` is set, also computes K =
/// -∂W/∂η for displacements D → D exp(η), and C = -∂W/∂V.
template <class T>
SpringWrench<T> wrench_of(const Spring::Torsion&, const ForceLaw& law, const RelativePose<T>& at,
                          bool with_derivatives) noexcept {
  const TwistAngle<T> twist(at.D.R);
  const Tension<T> F = tension(law, twist.angle, dot(twist.g, at.V.w));
  SpringWrench<T> out;
  const Vec3<T> moment = -F.f * twist.g;
  out.W = six(moment, Vec3<T>{});
  if (!with_derivatives) return out;
  const Six<T> g = six(twist.g, Vec3<T>{});
  for (std::size_t l = 0; l < 3; ++l) {
    const Vec3<T> dg = twist.gradient_along(unit_screw<T>(l).w);
    const Six<T> G = six(dg, Vec3<T>{});
    const T by_eta = F.by_x * g[l] + F.by_dx * dot(dg, at.V.w);
    for (std::size_t k = 0; k < 3; ++k) {
      out.K[k][l] = g[k] * by_eta + F.f * G[k];
      out.C[k][l] = F.by_dx * g[k] * g[l];
    }
  }
  return out;
}

/// Computes the wrench W of a bushing on the second of its two frames (D16.10). `at` has the pose D of the
/// second frame relative to the first, and the twist V of the second frame relative to the first. W and V are
/// in the axes and about the origin of the second frame. If `with_derivatives` is set, also computes K =
/// -∂W/∂η for displacements D → D exp(η), and C = -∂W/∂V (D16.11).
template <class T>
SpringWrench<T> wrench_of(const Spring::Bushing& bushing, const ForceLaw&, const RelativePose<T>& at,
                          bool with_derivatives) noexcept {
  const Screw<T> minus_X = -log(inverse(cast<T>(bushing.rest)) * at.D);
  std::array<Six<T>, 6> P, KP, CP;  // P e_k, K P e_k and C P e_k for each unit screw
  for (std::size_t k = 0; k < 6; ++k) P[k] = six(dexp_inv(minus_X, unit_screw<T>(k)));
  const Six<T> V = six(at.V), dX = six(dexp_inv(minus_X, at.V));
  Six<T> y = product(bushing.K, six(-minus_X));
  const Six<T> damped = product(bushing.C, dX);
  for (std::size_t k = 0; k < 6; ++k) y[k] += damped[k];
  SpringWrench<T> out;
  for (std::size_t k = 0; k < 6; ++k) out.W[k] = -product(P[k], y);
  if (!with_derivatives) return out;
  for (std::size_t k = 0; k < 6; ++k) {
    KP[k] = product(bushing.K, P[k]);
    CP[k] = product(bushing.C, P[k]);
  }
  for (std::size_t l = 0; l < 6; ++l) {  // X moves along P e_l
    const Screw<T> minus_dX = -dexp_inv(minus_X, unit_screw<T>(l));
    std::array<Six<T>, 6> dP;
    Six<T> ddX{};
    for (std::size_t k = 0; k < 6; ++k) {
      dP[k] = six(ddexp_inv(minus_X, minus_dX, unit_screw<T>(k)));
      for (std::size_t m = 0; m < 6; ++m) ddX[m] += dP[k][m] * V[k];
    }
    for (std::size_t k = 0; k < 6; ++k) {
      out.K[k][l] = product(dP[k], y) + product(P[k], KP[l]) + product(CP[k], ddX);
      out.C[k][l] = product(P[k], CP[l]);
    }
  }
  return out;
}

/// The wrench of a spring on its first frame, in the axes and about the origin of this frame: the reaction to
/// its wrench W on the second frame, given in that frame. D is the pose of the second frame relative to the
/// first.
template <class T> Six<T> reaction(const SE3<T>& D, const Six<T>& W) noexcept {
  const Vec3<T> m = D.R * Vec3<T>{W[0], W[1], W[2]}, f = D.R * Vec3<T>{W[3], W[4], W[5]};
  return six(-(m + cross(D.r, f)), -f);
}

}  // namespace axode
