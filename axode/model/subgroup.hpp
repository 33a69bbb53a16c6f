#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "axode/lie/twist.hpp"

/// Joints as subgroups of SE(3). A new kind of joint needs a struct here, an enumerator of Subgroup and a
/// line in with_subgroup(); the recursions do not change.
///
/// The joint frame is fixed to the child, and its z-axis is the axis of the joint. Velocities are
/// left-trivialised: they are components in the child's joint frame, where the motion subspace S is constant.
/// Every struct has the following members:
///
///   nq, nv                       sizes of q and v; if nq > nv, q begins with a quaternion
///   angles                       number of angular velocities, which are before the linear ones
///   vector_coordinates           whether q' = v
///   neutral()                    coordinates of the identity
///   pose(B, q)                   the pose of the child's joint frame at q, which is B at q = neutral()
///   coordinates(D, near, q)      writes the q nearest to `near` with pose(I, q) = D, or with a pose near D
///   twist(v)                     S v in the joint frame
///   project(W)                   Sᵀ W for a wrench in the joint frame
///   column(k)                    the k-th column of S
///   column(C, k)                 Ad_C of the k-th column, where C is the pose of the joint frame
///   integrate(q, dv, out)        writes out = q ⊕ dv
///   difference(q0, q1, out)      writes the `out` with q0 ⊕ out = q1
///   rates(q, v, out)             writes the q' of v
///   velocities(q, dq, out)       writes the v of q' = dq; a change of the norm of a quaternion is ignored
namespace axode {

enum class Subgroup : unsigned char { revolute, prismatic, helical, spherical, planar, free };

namespace subgroup {

/// Writes the components x y z of a vector, or x y z w of a quaternion, to consecutive numbers.
template <class T> constexpr void put(const Vec3<T>& a, T* out) {
  out[0] = a.x;
  out[1] = a.y;
  out[2] = a.z;
}
template <class T> constexpr void put(const Quaternion<T>& a, T* out) {
  put(Vec3<T>{a.x, a.y, a.z}, out);
  out[3] = a.w;
}

/// Common base of the joints whose N velocities are the rates of their coordinates, v = q'.
template <class T, int N> struct VectorCoordinates {
  static constexpr int nq = N, nv = N;
  static constexpr bool vector_coordinates = true;
  static constexpr std::array<T, N> neutral() { return {}; }
  static constexpr void integrate(const T* q, const T* dv, T* out) {
    for (int k = 0; k < N; ++k) out[k] = q[k] + dv[k];
  }
  static constexpr void difference(const T* q0, const T* q1, T* out) {
    for (int k = 0; k < N; ++k) out[k] = q1[k] - q0[k];
  }
  static constexpr void rates(const T*, const T* v, T* out) {
    for (int k = 0; k < N; ++k) out[k] = v[k];
  }
  static constexpr void velocities(const T*, const T* dq, T* out) {
    for (int k = 0; k < N; ++k) out[k] = dq[k];
  }
};

/// The rotation B exp(e_z θ), computed from s = sin θ and c = cos θ.
template <class T> constexpr SO3<T> turn(const SO3<T>& B, const T& s, const T& c) {
  return {c * B.x + s * B.y, c * B.y - s * B.x, B.z};
}

/// The angle (rad, in [-π, π]) of the rotation about z that is nearest to R.
template <class T> T turn_about_z(const SO3<T>& R) { return atan2(R.x.y - R.y.x, R.x.x + R.y.y); }

/// The angle nearest to `to` among those that differ from `angle` by whole turns, rad.
template <class T> T nearest_turn(const T& angle, const T& to) {
  using std::round;
  const T whole = T(2 * std::numbers::pi);
  return angle + whole * round((to - angle) / whole);
}

/// Writes to q the quaternion of R, x y z w, of the two signs the one nearer to the quaternion `near`.
template <class T> void nearest_quaternion(const SO3<T>& R, const T* near, T* q) {
  const Quaternion<T> a = quaternion(R);
  const T side = a.x * near[0] + a.y * near[1] + a.z * near[2] + a.w * near[3] < T(0) ? T(-1) : T(1);
  q[0] = side * a.x;
  q[1] = side * a.y;
  q[2] = side * a.z;
  q[3] = side * a.w;
}

/// The k-th column of a rotation.
template <class T> constexpr const Vec3<T>& axis(const SO3<T>& R, int k) {
  return k == 0 ? R.x : k == 1 ? R.y : R.z;
}

/// Revolute joint: rotation about z by q rad.
template <class T> struct Revolute : VectorCoordinates<T, 1> {
  static constexpr int angles = 1;
  static constexpr SE3<T> pose(const SE3<T>& B, const T* q) { return {turn(B.R, sin(q[0]), cos(q[0])), B.r}; }
  static void coordinates(const SE3<T>& D, const T* near, T* q) {
    q[0] = nearest_turn(turn_about_z(D.R), near[0]);
  }
  static constexpr Twist<BodyFixed, T> twist(const T* v) { return {{T(0), T(0), v[0]}, {T(0), T(0), T(0)}}; }
  static constexpr std::array<T, 1> project(const Wrench<BodyFixed, T>& W) { return {W.m.z}; }
  static constexpr Screw<T> column(int) { return {{T(0), T(0), T(1)}, {T(0), T(0), T(0)}}; }
  static constexpr Screw<T> column(const SE3<T>& C, int) { return {C.R.z, cross(C.r, C.R.z)}; }
};

/// Prismatic joint: translation along z by q m.
template <class T> struct Prismatic : VectorCoordinates<T, 1> {
  static constexpr int angles = 0;
  static constexpr SE3<T> pose(const SE3<T>& B, const T* q) { return {B.R, B.r + q[0] * B.R.z}; }
  static void coordinates(const SE3<T>& D, const T*, T* q) { q[0] = D.r.z; }
  static constexpr Twist<BodyFixed, T> twist(const T* v) { return {{T(0), T(0), T(0)}, {T(0), T(0), v[0]}}; }
  static constexpr std::array<T, 1> project(const Wrench<BodyFixed, T>& W) { return {W.f.z}; }
  static constexpr Screw<T> column(int) { return {{T(0), T(0), T(0)}, {T(0), T(0), T(1)}}; }
  static constexpr Screw<T> column(const SE3<T>& C, int) { return {Vec3<T>{}, C.R.z}; }
};

/// Helical joint: rotation about z by q rad and translation along z by pitch q m.
template <class T> struct Helical : VectorCoordinates<T, 1> {
  static constexpr int angles = 1;
  T pitch;
  explicit constexpr Helical(const T& h) : pitch(h) {}
  constexpr SE3<T> pose(const SE3<T>& B, const T* q) const {
    return {turn(B.R, sin(q[0]), cos(q[0])), B.r + (pitch * q[0]) * B.R.z};
  }
  void coordinates(const SE3<T>& D, const T*, T* q) const {
    q[0] = nearest_turn(turn_about_z(D.R), D.r.z / pitch);
  }
  constexpr Twist<BodyFixed, T> twist(const T* v) const {
    return {{T(0), T(0), v[0]}, {T(0), T(0), pitch * v[0]}};
  }
  constexpr std::array<T, 1> project(const Wrench<BodyFixed, T>& W) const { return {W.m.z + pitch * W.f.z}; }
  constexpr Screw<T> column(int) const { return {{T(0), T(0), T(1)}, {T(0), T(0), pitch}}; }
  constexpr Screw<T> column(const SE3<T>& C, int) const { return {C.R.z, cross(C.r, C.R.z) + pitch * C.R.z}; }
};

/// Spherical joint: q = unit quaternion x y z w, v = angular velocity in the child's joint frame.
template <class T> struct Spherical {
  static constexpr int nq = 4, nv = 3, angles = 3;
  static constexpr bool vector_coordinates = false;
  static constexpr std::array<T, 4> neutral() { return {T(0), T(0), T(0), T(1)}; }
  static constexpr Quaternion<T> quaternion_of(const T* q) { return {q[0], q[1], q[2], q[3]}; }
  static constexpr SE3<T> pose(const SE3<T>& B, const T* q) {
    return {B.R * rotation(quaternion_of(q)), B.r};
  }
  static void coordinates(const SE3<T>& D, const T* near, T* q) { nearest_quaternion(D.R, near, q); }
  static constexpr Twist<BodyFixed, T> twist(const T* v) { return {{v[0], v[1], v[2]}, {T(0), T(0), T(0)}}; }
  static constexpr std::array<T, 3> project(const Wrench<BodyFixed, T>& W) { return {W.m.x, W.m.y, W.m.z}; }
  static constexpr Screw<T> column(int k) { return {{T(k == 0), T(k == 1), T(k == 2)}, {T(0), T(0), T(0)}}; }
  static constexpr Screw<T> column(const SE3<T>& C, int k) {
    const Vec3<T>& e = axis(C.R, k);
    return {e, cross(C.r, e)};
  }
  static constexpr void integrate(const T* q, const T* dv, T* out) {
    const Quaternion<T> a = quaternion_of(q) * exp_quaternion(Vec3<T>{dv[0], dv[1], dv[2]});
    put(a, out);
  }
  static constexpr void difference(const T* q0, const T* q1, T* out) {
    const Vec3<T> xi = log_quaternion(conjugate(quaternion_of(q0)) * quaternion_of(q1));
    put(xi, out);
  }
  static constexpr void rates(const T* q, const T* v, T* out) {
    const Quaternion<T> da = quaternion_of(q) * Quaternion<T>{v[0], v[1], v[2], T(0)};
    put(Quaternion<T>{T(0.5) * da.x, T(0.5) * da.y, T(0.5) * da.z, T(0.5) * da.w}, out);
  }
  static constexpr void velocities(const T* q, const T* dq, T* out) {
    const Quaternion<T> w = conjugate(quaternion_of(q)) * quaternion_of(dq);
    put(Vec3<T>{T(2) * w.x, T(2) * w.y, T(2) * w.z}, out);
  }
};

/// Planar joint: motion in the plane normal to the z-axis of the joint frame. q = (θ, x, y), v = (ω; v_x,
/// v_y) in the child's joint frame. difference() assumes that the rotation goes the shorter way round.
template <class T> struct Planar {
  static constexpr int nq = 3, nv = 3, angles = 1;
  static constexpr bool vector_coordinates = false;
  static constexpr std::array<T, 3> neutral() { return {}; }
  static constexpr SE3<T> pose(const SE3<T>& B, const T* q) {
    return {turn(B.R, sin(q[0]), cos(q[0])), B.r + q[1] * B.R.x + q[2] * B.R.y};
  }
  static void coordinates(const SE3<T>& D, const T* near, T* q) {
    q[0] = nearest_turn(turn_about_z(D.R), near[0]);
    q[1] = D.r.x;
    q[2] = D.r.y;
  }
  static constexpr Twist<BodyFixed, T> twist(const T* v) { return {{T(0), T(0), v[0]}, {v[1], v[2], T(0)}}; }
  static constexpr std::array<T, 3> project(const Wrench<BodyFixed, T>& W) { return {W.m.z, W.f.x, W.f.y}; }
  static constexpr Screw<T> column(int k) { return {{T(0), T(0), T(k == 0)}, {T(k == 1), T(k == 2), T(0)}}; }
  static constexpr Screw<T> column(const SE3<T>& C, int k) {
    return k == 0 ? Revolute<T>::column(C, 0) : Screw<T>{Vec3<T>{}, axis(C.R, k - 1)};
  }
  static constexpr void integrate(const T* q, const T* dv, T* out) {
    const SE3<T> C = exp(Screw<T>{{T(0), T(0), dv[0]}, {dv[1], dv[2], T(0)}});
    const T s = sin(q[0]), c = cos(q[0]), x = q[1] + c * C.r.x - s * C.r.y, y = q[2] + s * C.r.x + c * C.r.y;
    put(Vec3<T>{q[0] + dv[0], x, y}, out);
  }
  static constexpr void difference(const T* q0, const T* q1, T* out) {
    const T s = sin(q0[0]), c = cos(q0[0]), dx = q1[1] - q0[1], dy = q1[2] - q0[2], d = q1[0] - q0[0];
    const Vec3<T> w{T(0), T(0), atan2(sin(d), cos(d))};
    const Vec3<T> v = dexp_inv(w, Vec3<T>{c * dx + s * dy, c * dy - s * dx, T(0)});
    put(Vec3<T>{w.z, v.x, v.y}, out);
  }
  static constexpr void rates(const T* q, const T* v, T* out) {
    const T s = sin(q[0]), c = cos(q[0]), dx = c * v[1] - s * v[2], dy = s * v[1] + c * v[2];
    put(Vec3<T>{v[0], dx, dy}, out);
  }
  static constexpr void velocities(const T* q, const T* dq, T* out) {
    const T s = sin(q[0]), c = cos(q[0]), vx = c * dq[1] + s * dq[2], vy = c * dq[2] - s * dq[1];
    put(Vec3<T>{dq[0], vx, vy}, out);
  }
};

/// Free joint: q = (quaternion x y z w, position), v = body-fixed twist (angular; linear) of the child.
template <class T> struct Free {
  static constexpr int nq = 7, nv = 6, angles = 3;
  static constexpr bool vector_coordinates = false;
  static constexpr std::array<T, 7> neutral() { return {T(0), T(0), T(0), T(1), T(0), T(0), T(0)}; }
  static constexpr Quaternion<T> quaternion_of(const T* q) { return {q[0], q[1], q[2], q[3]}; }
  static constexpr Vec3<T> position_of(const T* q) { return {q[4], q[5], q[6]}; }
  static constexpr SE3<T> pose(const SE3<T>& B, const T* q) {
    return B * SE3<T>{rotation(quaternion_of(q)), position_of(q)};
  }
  static void coordinates(const SE3<T>& D, const T* near, T* q) {
    nearest_quaternion(D.R, near, q);
    q[4] = D.r.x;
    q[5] = D.r.y;
    q[6] = D.r.z;
  }
  static constexpr Twist<BodyFixed, T> twist(const T* v) { return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}; }
  static constexpr std::array<T, 6> project(const Wrench<BodyFixed, T>& W) {
    return {W.m.x, W.m.y, W.m.z, W.f.x, W.f.y, W.f.z};
  }
  static constexpr Screw<T> column(int k) {
    return {{T(k == 0), T(k == 1), T(k == 2)}, {T(k == 3), T(k == 4), T(k == 5)}};
  }
  static constexpr Screw<T> column(const SE3<T>& C, int k) {
    return k < 3 ? Spherical<T>::column(C, k) : Screw<T>{Vec3<T>{}, axis(C.R, k - 3)};
  }
  static constexpr void integrate(const T* q, const T* dv, T* out) {
    const Screw<T> X{{dv[0], dv[1], dv[2]}, {dv[3], dv[4], dv[5]}};
    const Quaternion<T> a = quaternion_of(q) * exp_quaternion(X.w);
    const Vec3<T> r = position_of(q) + rotation(quaternion_of(q)) * dexp(X.w, X.v);
    put(a, out);
    put(r, out + 4);
  }
  static constexpr void difference(const T* q0, const T* q1, T* out) {
    const Quaternion<T> inverse = conjugate(quaternion_of(q0));
    const Vec3<T> w = log_quaternion(inverse * quaternion_of(q1));
    const Vec3<T> v = dexp_inv(w, rotation(inverse) * (position_of(q1) - position_of(q0)));
    put(w, out);
    put(v, out + 3);
  }
  static constexpr void rates(const T* q, const T* v, T* out) {
    Spherical<T>::rates(q, v, out);
    const Vec3<T> dr = rotation(quaternion_of(q)) * Vec3<T>{v[3], v[4], v[5]};
    put(dr, out + 4);
  }
  static constexpr void velocities(const T* q, const T* dq, T* out) {
    Spherical<T>::velocities(q, dq, out);
    const Vec3<T> v = transpose(rotation(quaternion_of(q))) * position_of(dq);
    put(v, out + 3);
  }
};

}  // namespace subgroup

/// Calls f with the struct of a subgroup and returns its result. Only helical joints use the pitch (m/rad).
template <class T, class F> constexpr decltype(auto) with_subgroup(Subgroup kind, const T& pitch, F&& f) {
  switch (kind) {
    case Subgroup::revolute: return f(subgroup::Revolute<T>{});
    case Subgroup::prismatic: return f(subgroup::Prismatic<T>{});
    case Subgroup::helical: return f(subgroup::Helical<T>{pitch});
    case Subgroup::spherical: return f(subgroup::Spherical<T>{});
    case Subgroup::planar: return f(subgroup::Planar<T>{});
    case Subgroup::free: break;
  }
  return f(subgroup::Free<T>{});
}

/// The directions among ω_x ω_y ω_z v_x v_y v_z that a joint leaves free; a helical joint has only ω_z.
constexpr std::array<bool, 6> free_directions(Subgroup kind) {
  std::array<bool, 6> free{};
  with_subgroup(kind, 1.0, [&](const auto& joint) {
    for (int k = 0; k < joint.nv; ++k) {
      const auto [w, v] = joint.column(k);
      const std::array<double, 6> S{w.x, w.y, w.z, v.x, v.y, v.z};
      free[static_cast<std::size_t>(std::find_if(S.begin(), S.end(), [](double x) { return x != 0; }) -
                                    S.begin())] = true;
    }
  });
  return free;
}

}  // namespace axode
