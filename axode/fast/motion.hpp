#pragma once
#include "axode/fast/packed_store.hpp"

namespace axode {

/// Placeholder for a rate that is not computed. It is empty, so that nothing is stored or copied for it.
struct NoRate {};
template <class Rep, class T, bool rates>
using MotionResult = std::conditional_t<rates, TwistRate<Rep, T>, Twist<Rep, T>>;

/// Motion of all bodies in inertial axes, for all representations except BodyFixed: the poses in the inertial
/// frame, the angular velocities ω and the velocities r' of the origins and, if `rates`, ω' and the classical
/// accelerations r''. With the vector d from the origin of the predecessor p to that of body i, and with
/// (ω_J; v_J) = S v, (α_J; a_J) = S a in inertial axes for the joint screws S,
///   ω_i = ω_p + ω_J,   r'_i = r'_p + ω_p × d + v_J,
///   ω'_i = ω'_p + ω_p × ω_J + α_J,   r''_i = r''_p + ω'_p × d + ω_p × (ω_p × d) + (ω_p + ω_i) × v_J + a_J.
/// It takes 69 products and sums for a hinge, 114 with rates.
template <class T, bool rates, class G = typename FastGeometry<T>::type> struct FastMotion {
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  using Rate = std::conditional_t<rates, Vector, NoRate>;
  struct Body {
    Placed<G> at;
    Vector w, v;
    [[no_unique_address]] Rate dw, a;
  };
  JointAngles<T> angles;
  Body* body;

  explicit FastMotion(Arena& arena) : angles(arena), body(arena.per_body<Body>()) {}

  /// Computes the motion of all bodies; `a` is used only if `rates`.
  void run(const Tree<T>& tree, const T* q, const T* v, const T* a = nullptr) noexcept {
    angles.run(tree, q);
    Body last{{Matrix(SO3<T>{}), {}}, {}, {}, {}, {}};
    body[0] = last;
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      if (p != i - 1) last = body[p];
      const Placed<G> next = place<G>(tree, i, q, angles, last.at.R);
      const Factor w_p(last.w);
      carry(last, w_p, next);
      if (is_hinge(tree, i)) [[likely]] {
        const Vector& n = next.R.z;
        const T dq = v[tree->iv[i]];
        if constexpr (rates) last.dw += dq * cross(w_p, Factor(n)) + a[tree->iv[i]] * n;
        last.w += dq * n;
      } else {
        const Twist<BodyFixed, T> V = any_joint_twist(tree, i, v);
        const Vector w_J = next.R * Spread(Vector(V.w)), v_J = next.R * Spread(Vector(V.v));
        if constexpr (rates) {
          const Twist<BodyFixed, T> A = any_joint_twist(tree, i, a);
          last.dw += cross(w_p, Factor(w_J)) + next.R * Spread(Vector(A.w));
          last.a += cross(Factor(last.w + last.w + w_J), Factor(v_J)) + next.R * Spread(Vector(A.v));
        }
        last.w += w_J;
        last.v += v_J;
      }
      // The members are copied one by one, because GCC copies the whole struct in registers that are wider
      // than the stores before and have to wait for them.
      Body& b = body[i];
      b.at.R.x = last.at.R.x;
      b.at.R.y = last.at.R.y;
      b.at.R.z = last.at.R.z;
      b.at.r = last.at.r;
      b.w = last.w;
      b.v = last.v;
      b.dw = last.dw;
      b.a = last.a;
    }
  }

  /// Writes the twists of all frames or, if `rates`, their twist rates.
  template <class Rep> void write(const Tree<T>& tree, MotionResult<Rep, T, rates>* out) const noexcept {
    for (int f = 0; f < tree->n_frames(); ++f) {
      const auto [angular, linear] = of_frame<Rep>(tree->frame_body[f], tree.frame_offset[f]);
      store(angular, linear, numbers<T>(out + f));
    }
  }

 private:
  /// The twist or twist rate in Rep of a frame with pose F in the internal frame of body i.
  template <class Rep> std::pair<Vector, Vector> of_frame(int i, const SE3<T>& F) const noexcept {
    const Matrix& R = body[i].at.R;
    Body f = body[i];
    carry(f, Factor(f.w), {R, R * Spread(F.r)});
    Vector angular = f.w, linear = f.v;
    if constexpr (rates) {
      angular = f.dw;
      linear = f.a;
    }
    if constexpr (std::same_as<Rep, Spatial>) {
      linear += cross(Factor(f.at.r), Factor(angular));
      if constexpr (rates) linear += cross(Factor(f.v), Factor(f.w));
    }
    if constexpr (std::same_as<Rep, Mixed>) angular = transposed<G, T>(R, F.R) * Spread(angular);
    return {angular, linear};
  }
  /// Changes x from the motion of a frame to that of another frame that is fixed to the same body. x has the
  /// rotation of the frame, the position and velocity of its origin and, if `rates`, the acceleration of the
  /// origin and the angular acceleration of the body. w is the angular velocity of the body, to.R the
  /// rotation of the other frame, and to.r the vector from the origin of the first frame to that of the other
  /// one. All vectors are in inertial axes, and rotations are relative to these axes.
  static void carry(Body& x, const Factor& w, const Placed<G>& to) noexcept {
    const Factor d(to.r);
    const Vector w_d = cross(w, d);
    if constexpr (rates) x.a += cross(Factor(x.dw), d) + cross(w, Factor(w_d));
    x.v += w_d;
    x.at.R = to.R;
    x.at.r += to.r;
  }
};

/// Body-fixed twists of all bodies, (ω_i; v_i) = Ad_{C_ip} (ω_p; v_p) + S v with the predecessor p and the
/// joint screws S of body i and, if `rates`, their rates
///   V'_i = Ad_{C_ip} V'_p + S a + ad_V (S v).
/// It takes 61 products and sums for a hinge, 111 with rates.
template <class T, bool rates, class G = typename FastGeometry<T>::type> struct FastBodyFixedMotion {
  using Vector = typename G::Vector;
  using Factor = typename G::Factor;
  using Spread = typename G::Spread;
  using Matrix = typename G::Matrix;
  using Rate = std::conditional_t<rates, Vector, NoRate>;
  struct Body {
    Vector w, v;
    [[no_unique_address]] Rate dw, dv;
  };
  JointAngles<T> angles;
  Body* body;

  explicit FastBodyFixedMotion(Arena& arena) : angles(arena), body(arena.per_body<Body>()) {}

  /// Computes the motion of all bodies; `a` is used only if `rates`.
  void run(const Tree<T>& tree, const T* q, const T* v, const T* a = nullptr) noexcept {
    angles.run(tree, q);
    Body last{};
    body[0] = last;
    for (int i = 1; i <= tree->n; ++i) {
      const int p = tree->parent[i];
      if (p != i - 1) last = body[p];
      if (is_hinge(tree, i)) [[likely]] {
        const auto& body_i = constants<G, T>(tree, i);
        const T dq = v[tree->iv[i]];
        last = seen(last, body_i.rows(angles.sine[i - 1], angles.cosine[i - 1]), body_i.r_factor());
        if constexpr (rates) {
          last.dw = add_z(last.dw + cross_z(last.w, dq), a[tree->iv[i]]);
          last.dv += cross_z(last.v, dq);
        }
        last.w = add_z(last.w, dq);
      } else {
        const SE3<T> C = any_joint_pose(tree, i, q);
        const Twist<BodyFixed, T> V = any_joint_twist(tree, i, v);
        const Vector w_J(V.w), v_J(V.v);
        last = seen(last, Matrix(transpose(C.R)), Factor(Vector(C.r)));
        last.w += w_J;
        last.v += v_J;
        if constexpr (rates) {
          const Twist<BodyFixed, T> A = any_joint_twist(tree, i, a);
          last.dw += cross(Factor(last.w), Factor(w_J)) + Vector(A.w);
          last.dv += (cross(Factor(last.v), Factor(w_J)) + cross(Factor(last.w), Factor(v_J))) + Vector(A.v);
        }
      }
      Body& b = body[i];  // The members are copied one by one, as in FastMotion.
      b.w = last.w;
      b.v = last.v;
      b.dw = last.dw;
      b.dv = last.dv;
    }
  }

  /// Writes the body-fixed twists of all frames or, if `rates`, their twist rates.
  template <class Rep> void write(const Tree<T>& tree, MotionResult<Rep, T, rates>* out) const noexcept {
    static_assert(std::same_as<Rep, BodyFixed>);
    for (int f = 0; f < tree->n_frames(); ++f) {
      const SE3<T>& F = tree.frame_offset[f];
      const Body at = seen(body[tree->frame_body[f]], Matrix(transpose(F.R)), Factor(Vector(F.r)));
      if constexpr (rates)
        store(at.dw, at.dv, numbers<T>(out + f));
      else
        store(at.w, at.v, numbers<T>(out + f));
    }
  }

 private:
  /// The twist and the twist rate of a body in another body-fixed frame. Relative to the frame of `from`, the
  /// axes of this frame are rotated by R (Rt is Rᵀ), and its origin is at r.
  static Body seen(const Body& from, const Matrix& Rt, const Factor& r) noexcept {
    const auto of = [&](const Vector& w, const Vector& v) { return Rt * Spread(v + cross(Factor(w), r)); };
    Body out{Rt * Spread(from.w), of(from.w, from.v), from.dw, from.dv};
    if constexpr (rates) {
      out.dw = Rt * Spread(from.dw);
      out.dv = of(from.dw, from.dv);
    }
    return out;
  }
};

/// The kernel that computes the motion of all bodies fastest in representation Rep.
template <class Rep, class T, bool rates, class G = typename FastGeometry<T>::type>
using FastMotionIn = std::conditional_t<std::same_as<Rep, BodyFixed>, FastBodyFixedMotion<T, rates, G>,
                                        FastMotion<T, rates, G>>;

}  // namespace axode
