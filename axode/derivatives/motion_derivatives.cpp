#include "axode/derivatives/motion_derivatives.hpp"

#include "axode/kinematics/check_arguments.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/kinematics/scratch.hpp"
#include "axode/lie/representation_change.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/scalar/dual.hpp"

namespace axode {
namespace {

/// One direction.
template <class T> using Dual1 = Dual<T, 1>;
template <class T> Vec3<Dual1<T>> with_derivative(const Vec3<T>& x, const Vec3<T>& dx) {
  return {{x.x, {dx.x}}, {x.y, {dx.y}}, {x.z, {dx.z}}};
}
/// C exp(ε X).
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

}  // namespace

template <RecursionRepresentation Rep, class T>
void motion_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                        const std::type_identity_t<Place<T>>& given,
                        const std::type_identity_t<MotionDerivatives<Rep, T>>& d) {
  using V6 = Twist<BodyFixed, T>;
  check_state(model, workspace, q, v, a);
  const Place<T> place = found(model, given);
  check_results<Twist<Rep, T>>(
      model, {{"d.V_q", d.V_q, 1}, {"d.V_v", d.V_v, 1}, {"d.dV_q", d.dV_q, 1}, {"d.dV_v", d.dV_v, 1}});
  for (const auto& columns : {d.V_q, d.V_v, d.dV_q, d.dV_v}) check_separate("d", columns, "q", q);
  const Tree<T>& tree = model.tree<T>();
  Arena arena = workspace.arena(model.topology());
  const TreeMotion<BodyFixed, T> motion(arena);
  motion.run(tree, q.data(), v.data(), a.data());

  // Body-fixed, seen from the place: as if the ground under a joint had gained ψ = [V_p, X] and its rate.
  for (const auto& columns : {d.V_q, d.V_v, d.dV_q, d.dV_v})
    std::fill(columns.begin(), columns.end(), Twist<Rep, T>{});
  const auto add = [](Twist<Rep, T>& to, const V6& X) { to.w += X.w, to.v += X.v; };
  SE3<T> E = tree.frame_offset[place.frame] * place.offset;  // the place in the internal frame of body i
  const auto seen = [&](const auto& of_body) {
    const Screw<T> X = Ad_inv(E, Screw<T>{of_body.w, of_body.v});
    return V6{X.w, X.v};
  };
  const int body = tree->frame_body[place.frame];
  const V6 V = seen(motion.bodies.V[body]), dV = seen(motion.bodies.dV[body]);
  for (int i = body; i > 0; i = tree->parent[i]) {
    const V6 V_i = seen(motion.bodies.V[i]);
    const SE3<T> from_place = inverse(E);
    E = joint_pose(tree, i, q.data()) * E;
    const V6 V_p = seen(motion.bodies.V[tree->parent[i]]), dV_p = seen(motion.bodies.dV[tree->parent[i]]);
    each_screw(tree, i, from_place, [&](int c, const Screw<T>& screw) {
      const V6 X{screw.w, screw.v}, psi = ad(V_p, X);
      add(d.V_q[c], psi);
      add(d.V_v[c], X);
      add(d.dV_q[c], ad(dV_p, X) + ad(V_p, psi) + ad(psi, V));
      add(d.dV_v[c], psi + ad(X, V - V_i));
    });
  }
  if constexpr (std::same_as<Rep, BodyFixed>) return;

  const auto body_fixed = [](const Twist<Rep, T>& x) { return V6{x.w, x.v}; };
  for (std::size_t c = 0; c < d.V_q.size(); ++c) {
    const V6 V_q = body_fixed(d.V_q[c]), X = body_fixed(d.V_v[c]), dV_q = body_fixed(d.dV_q[c]),
             dV_v = body_fixed(d.dV_v[c]);
    const auto put = [&](const V6& moved, const V6& by_V, const V6& by_dV, Twist<Rep, T>& of_V,
                         Twist<Rep, T>& of_dV) {
      const SE3<Dual1<T>> C = displaced(E, moved);
      const Twist<BodyFixed, Dual1<T>> V_d{with_derivative(V.w, by_V.w), with_derivative(V.v, by_V.v)};
      const TwistRate<BodyFixed, Dual1<T>> dV_d{with_derivative(dV.w, by_dV.w),
                                                with_derivative(dV.v, by_dV.v)};
      const auto V_rep = change<Rep>(C, V_d);
      const auto dV_rep = change<Rep>(C, V_d, dV_d);
      of_V = derivative<Rep, T>(V_rep.w, V_rep.v), of_dV = derivative<Rep, T>(dV_rep.w, dV_rep.v);
    };
    put(X, V_q, dV_q, d.V_q[c], d.dV_q[c]);
    put({}, X, dV_v, d.V_v[c], d.dV_v[c]);
  }
}

template void motion_derivatives<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                            Numbers<AXODE_T>, Numbers<AXODE_T>, const Place<AXODE_T>&,
                                            const MotionDerivatives<AXODE_REP, AXODE_T>&);

}  // namespace axode
