#include "axode/derivatives/motion_derivatives.hpp"

#include "axode/kinematics/checked.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/kinematics/scratch.hpp"
#include "axode/lie/representation_change.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/scalar/dual.hpp"

namespace axode {
namespace {

/// Dual numbers with the derivative along one direction (dq, dv, da).
template <class T> using Dual1 = Dual<T, 1>;
template <class T> Vec3<Dual1<T>> with_derivative(const Vec3<T>& x, const Vec3<T>& dx) {
  return {{x.x, {dx.x}}, {x.y, {dx.y}}, {x.z, {dx.z}}};
}
/// The pose C exp(ε X) with its derivative by ε at ε = 0.
template <class T> SE3<Dual1<T>> displaced(const SE3<T>& C, const Twist<BodyFixed, T>& X) {
  const auto column = [&](const Vec3<T>& e, const Vec3<T>& axis) {
    return with_derivative(e, C.R * cross(X.w, axis));
  };
  return {{column(C.R.x, {1, 0, 0}), column(C.R.y, {0, 1, 0}), column(C.R.z, {0, 0, 1})},
          with_derivative(C.r, C.R * X.v)};
}
template <class Rep, class T> Twist<Rep, T> derivative(const Vec3<Dual1<T>>& w, const Vec3<Dual1<T>>& v) {
  return {{w.x.dx[0], w.y.dx[0], w.z.dx[0]}, {v.x.dx[0], v.y.dx[0], v.z.dx[0]}};
}

template <class T> using V6 = Twist<BodyFixed, T>;

/// The motion of a place (a frame on a body): its pose C, its body-fixed twist V, and the time derivative dV
/// of this twist.
template <class T> struct MovingPlace {
  SE3<T> C;
  V6<T> V, dV;

  /// Converts changes of the motion of a frame on a body to the representation Rep. X is the body-fixed
  /// displacement of its pose C, which becomes C exp(ε X^). by_V and by_dV are the changes of the body-fixed
  /// components of the twist V and of their time derivative V'.
  template <class Rep> MotionChange<Rep, T> in(const V6<T>& X, const V6<T>& by_V, const V6<T>& by_dV) const {
    if constexpr (std::same_as<Rep, BodyFixed>) {
      return {X, by_V, by_dV};
    } else {
      const SE3<Dual1<T>> C_d = displaced(C, X);
      const Twist<BodyFixed, Dual1<T>> V_d{with_derivative(V.w, by_V.w), with_derivative(V.v, by_V.v)};
      const TwistRate<BodyFixed, Dual1<T>> dV_d{with_derivative(dV.w, by_dV.w),
                                                with_derivative(dV.v, by_dV.v)};
      const auto V_rep = change<Rep>(C_d, V_d);
      const auto dV_rep = change<Rep>(C_d, V_d, dV_d);
      return {X, derivative<Rep, T>(V_rep.w, V_rep.v), derivative<Rep, T>(dV_rep.w, dV_rep.v)};
    }
  }
};

/// The motion of a place (a frame on a body) and of all bodies, in body-fixed components.
template <class T> struct MotionTo {
  const Tree<T>& tree;
  TreeMotion<BodyFixed, T> motion;
  const Place<T>& place;
  MovingPlace<T> at;

  MotionTo(const Tree<T>& tree_, Arena& arena, const T* q, const T* v, const T* a,
           const Place<T>& place_) noexcept
      : tree(tree_), motion(arena), place(place_) {
    motion.run(tree, q, v, a);
    at.C = in_body();
    const int body = tree->frame_body[place.frame];
    at.V = expressed_in(at.C, motion.bodies.V[body]);
    at.dV = expressed_in(at.C, motion.bodies.dV[body]);
    for (int i = body; i > 0; i = tree->parent[i]) at.C = motion.bodies.link[i].C_pi * at.C;
  }

  /// Calls f(c, J, V_q, dV_q, dV_v) for every joint screw J that moves the place (a frame on a body). J
  /// belongs to velocity c. V_q, dV_q and dV_v are the contributions of J to ∂V/∂q, ∂V'/∂q and ∂V'/∂v along
  /// the direction of velocity c, where V is the twist of the place. All are body-fixed twists. If coupled
  /// joints share velocity c, f is called for the screw of each of them, and the derivatives are the sums of
  /// these contributions.
  template <class F> void each_column(const F& f) const noexcept {
    const auto& [link, V, dV] = motion.bodies;
    SE3<T> E = in_body();  // the place in the internal frame of body i
    for (int i = tree->frame_body[place.frame]; i > 0; i = tree->parent[i]) {
      const V6<T> V_i = expressed_in(E, V[i]);
      const SE3<T> from_place = inverse(E);
      E = link[i].C_pi * E;
      // The base of the joint gains the velocity ψ = [V_p, J] and its rate.
      const V6<T> V_p = expressed_in(E, V[tree->parent[i]]), dV_p = expressed_in(E, dV[tree->parent[i]]);
      each_screw(tree, i, from_place, [&](int c, const Screw<T>& screw) {
        const V6<T> J{screw.w, screw.v}, psi = ad(V_p, J);
        f(c, J, psi, ad(dV_p, J) + ad(V_p, psi) + ad(psi, at.V), psi + ad(J, at.V - V_i));
      });
    }
  }

 private:
  SE3<T> in_body() const { return tree.frame_offset[place.frame] * place.offset; }
  template <class X> static V6<T> expressed_in(const SE3<T>& E, const X& of_body) {
    const Screw<T> Y = Ad_inv(E, Screw<T>{of_body.w, of_body.v});
    return {Y.w, Y.v};
  }
};

}  // namespace

template <RecursionRepresentation Rep, class T>
void motion_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                        const std::type_identity_t<Place<T>>& given,
                        const std::type_identity_t<MotionDerivatives<Rep, T>>& d) {
  Arena arena = checked<"motion_derivatives">(model, workspace, q, v, a, d.V_q, d.V_v, d.dV_q, d.dV_v);
  const Place<T> place = found(model, given);
  const MotionTo<T> motion(model.tree<T>(), arena, q.data(), v.data(), a.data(), place);
  for (const auto& columns : {d.V_q, d.V_v, d.dV_q, d.dV_v})
    std::fill(columns.begin(), columns.end(), Twist<Rep, T>{});
  const auto add = [](Twist<Rep, T>& to, const V6<T>& X) {
    to.w += X.w;
    to.v += X.v;
  };
  motion.each_column([&](int c, const V6<T>& J, const V6<T>& V_q, const V6<T>& dV_q, const V6<T>& dV_v) {
    add(d.V_q[c], V_q);
    add(d.V_v[c], J);
    add(d.dV_q[c], dV_q);
    add(d.dV_v[c], dV_v);
  });
  const auto body_fixed = [](const Twist<Rep, T>& x) { return V6<T>{x.w, x.v}; };
  for (std::size_t c = 0; c < d.V_q.size(); ++c) {
    const V6<T> J = body_fixed(d.V_v[c]);
    const auto by_q = motion.at.template in<Rep>(J, body_fixed(d.V_q[c]), body_fixed(d.dV_q[c])),
               by_v = motion.at.template in<Rep>({}, J, body_fixed(d.dV_v[c]));
    d.V_q[c] = by_q.V;
    d.dV_q[c] = by_q.dV;
    d.V_v[c] = by_v.V;
    d.dV_v[c] = by_v.dV;
  }
}

template <RecursionRepresentation Rep, class T>
MotionChange<Rep, T> motion_jvp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                Numbers<T> a, const std::type_identity_t<Place<T>>& given, Numbers<T> dq,
                                Numbers<T> dv, Numbers<T> da) {
  Arena arena = checked<"motion_jvp">(model, workspace, q, v, a, dq, dv, da);
  const Place<T> place = found(model, given);
  const MotionTo<T> motion(model.tree<T>(), arena, q.data(), v.data(), a.data(), place);
  V6<T> X{}, by_V{}, by_dV{};
  motion.each_column([&](int c, const V6<T>& J, const V6<T>& V_q, const V6<T>& dV_q, const V6<T>& dV_v) {
    X += dq[c] * J;
    by_V += dq[c] * V_q + dv[c] * J;
    by_dV += dq[c] * dV_q + dv[c] * dV_v + da[c] * J;
  });
  return motion.at.template in<Rep>(X, by_V, by_dV);
}

template <RecursionRepresentation Rep, class T>
void motion_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                const std::type_identity_t<Place<T>>& given,
                const std::type_identity_t<MotionWeights<Rep, T>>& w,
                const std::type_identity_t<MotionGradients<T>>& gradient) {
  check_state(model, workspace, q, v, a);
  const Place<T> place = found(model, given);
  check_results<T>(
      model, {{"gradient.q", gradient.q, 1}, {"gradient.v", gradient.v, 1}, {"gradient.a", gradient.a, 1}});
  for (const auto& part : {gradient.q, gradient.v, gradient.a}) {
    check_separate("gradient", part, "q", q);
    check_separate("gradient", part, "v", v);
    check_separate("gradient", part, "a", a);
  }
  Arena arena = workspace.arena(model.topology());
  const MotionTo<T> motion(model.tree<T>(), arena, q.data(), v.data(), a.data(), place);
  for (const auto& part : {gradient.q, gradient.v, gradient.a}) std::fill(part.begin(), part.end(), T(0));
  // The weights of body-fixed components follow from the images of unit changes under in().
  Wrench<BodyFixed, T> X{}, V{}, dV{};
  for (int k = 0; k < 6; ++k) {
    const Vec3<T> e{T(k % 3 == 0), T(k % 3 == 1), T(k % 3 == 2)};
    const V6<T> unit = k < 3 ? V6<T>{e, {}} : V6<T>{{}, e};
    const auto weight = [&](const MotionChange<Rep, T>& image) {
      return (w.X | image.X) + (w.V | image.V) + (w.dV | image.dV);
    };
    const auto add = [&](Wrench<BodyFixed, T>& to, const T& x) { (k < 3 ? to.m : to.f) += x * e; };
    add(X, weight(motion.at.template in<Rep>(unit, {}, {})));
    add(V, weight(motion.at.template in<Rep>({}, unit, {})));
    add(dV, weight(motion.at.template in<Rep>({}, {}, unit)));
  }
  motion.each_column([&](int c, const V6<T>& J, const V6<T>& V_q, const V6<T>& dV_q, const V6<T>& dV_v) {
    gradient.q[c] += (X | J) + (V | V_q) + (dV | dV_q);
    gradient.v[c] += (V | J) + (dV | dV_v);
    gradient.a[c] += dV | J;
  });
}

template decltype(motion_derivatives<AXODE_REP, AXODE_T>) motion_derivatives<AXODE_REP, AXODE_T>;
template decltype(motion_jvp<AXODE_REP, AXODE_T>) motion_jvp<AXODE_REP, AXODE_T>;
template decltype(motion_vjp<AXODE_REP, AXODE_T>) motion_vjp<AXODE_REP, AXODE_T>;

}  // namespace axode
