#include "axode/derivatives/geometry_derivatives.hpp"

#include "axode/derivatives/displacement/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

template <class T> std::size_t parameters(const Model& model) {
  return static_cast<std::size_t>(model.n_bodies()) * 6;
}

/// Calls f(i, u, screw) for all geometric parameters that displace a place (a frame on a body). Parameter u
/// of body i displaces the joint of body i and its subtree along unit screw u of the frame that body i has
/// while its joint is at zero. `screw` is this screw, expressed in the frame of the place. O(d) on a path of
/// d bodies.
template <class T, class F>
void each_parameter(const Tree<T>& tree, const T* q, const Place<T>& place, const F& f) noexcept {
  SE3<T> E = tree.frame_offset[place.frame] * place.offset;  // the place in the internal frame of body i
  for (int i = tree->frame_body[place.frame]; i > 0; i = tree->parent[i]) {
    each_unit_screw(inverse(E) * frame_at_zero(tree, i, q), [&](int u, const Screw<T>& X) { f(i, u, X); });
    E = joint_pose(tree, i, q) * E;
  }
}

}  // namespace

template <class T>
void inverse_dynamics_geometry_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                           Numbers<T> v, Numbers<T> a,
                                           std::type_identity_t<std::span<T>> dtau,
                                           const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"inverse_dynamics_geometry_derivatives">(model, workspace, q, v, a, loads, dtau);
  GeometryDerivatives<T>(arena).run(model.tree<T>(), q.data(), v.data(), a.data(), loads, dtau.data());
}

template <class T>
Solvability forward_dynamics_geometry_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                                  Numbers<T> v, Numbers<T> tau,
                                                  std::type_identity_t<std::span<T>> da,
                                                  const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"forward_dynamics_geometry_derivatives">(model, workspace, q, v, tau, loads, da);
  const Solvability verdict = ForwardGeometryDerivatives<T>(arena).run(model.tree<T>(), q.data(), v.data(),
                                                                       tau.data(), loads, da.data());
  return solved(verdict, std::ssize(da), da.data());
}

template <class T>
void inverse_dynamics_geometry_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                                   Numbers<T> a, Numbers<T> w, std::type_identity_t<std::span<T>> gradient,
                                   const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"inverse_dynamics_geometry_vjp">(model, workspace, q, v, a, w, loads, gradient);
  const Tree<T>& tree = model.tree<T>();
  InverseDynamicsVjp<T> vjp(arena);
  vjp.run(tree, q.data(), v.data(), a.data(), w.data(), loads);
  vjp.each_parameter(tree, q.data(), v.data(), a.data(), w.data(), [&](int i, int u, const T& x) {
    gradient[static_cast<std::size_t>((i - 1) * 6 + u)] = x;
  });
}

template <class T>
Solvability forward_dynamics_geometry_vjp(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                          Numbers<T> v, Numbers<T> tau, Numbers<T> w,
                                          std::type_identity_t<std::span<T>> gradient,
                                          const std::type_identity_t<Loads<T>>& loads) {
  Arena arena = checked<"forward_dynamics_geometry_vjp">(model, workspace, q, v, tau, w, loads, gradient);
  const Tree<T>& tree = model.tree<T>();
  ForwardVjp<T> s(arena);
  const Solvability verdict = s.run(tree, q.data(), v.data(), tau.data(), w.data(), loads);
  if (verdict.ok())
    s.vjp.each_parameter(tree, q.data(), v.data(), s.forward.a, s.mu, [&](int i, int u, const T& x) {
      gradient[static_cast<std::size_t>((i - 1) * 6 + u)] = -x;
    });
  return solved(verdict, static_cast<std::ptrdiff_t>(gradient.size()), gradient.data());
}

template <class T>
void frame_geometry_jacobian(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& given,
                             std::type_identity_t<std::span<T>> J) {
  checked<"frame_geometry_jacobian">(model, workspace, q, J);
  const Place<T> place = found(model, given);
  const std::size_t columns = parameters<T>(model);
  std::fill(J.begin(), J.end(), T(0));
  each_parameter(model.tree<T>(), q.data(), place, [&](int i, int u, const Screw<T>& X) {
    for (int k = 0; k < 6; ++k)
      J[static_cast<std::size_t>(k) * columns + static_cast<std::size_t>((i - 1) * 6 + u)] =
          entry(Twist<BodyFixed, T>{X.w, X.v}, k);
  });
}

template <class T>
void jacobian_geometry_derivatives(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                   const std::type_identity_t<Place<T>>& given,
                                   std::type_identity_t<std::span<Twist<BodyFixed, T>>> dJ) {
  Arena arena = checked<"jacobian_geometry_derivatives">(model, workspace, q, dJ);
  const Place<T> place = found(model, given);
  const Tree<T>& tree = model.tree<T>();
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  std::fill(dJ.begin(), dJ.end(), Twist<BodyFixed, T>{});
  // A parameter displaces the place and the joint screws after it, and leaves the screws before it unchanged.
  CarryingScrews<T> screws(arena);
  screws.run(tree, q.data(), place);
  each_parameter(tree, q.data(), place, [&](int i, int u, const Screw<T>& X) {
    Twist<BodyFixed, T>* const to = dJ.data() + static_cast<std::size_t>((i - 1) * 6 + u) * nv;
    for (int k = screws.count - 1; k >= 0 && screws.column[k].j < i; --k)  // in the order from the ground
      to[screws.column[k].c] += ad(screws.column[k].J, Twist<BodyFixed, T>{X.w, X.v});
  });
}

template AXODE_ENTRY decltype(inverse_dynamics_geometry_derivatives<AXODE_T>)
    inverse_dynamics_geometry_derivatives<AXODE_T>;
template AXODE_ENTRY decltype(forward_dynamics_geometry_derivatives<AXODE_T>)
    forward_dynamics_geometry_derivatives<AXODE_T>;
template AXODE_ENTRY decltype(inverse_dynamics_geometry_vjp<AXODE_T>) inverse_dynamics_geometry_vjp<AXODE_T>;
template AXODE_ENTRY decltype(forward_dynamics_geometry_vjp<AXODE_T>) forward_dynamics_geometry_vjp<AXODE_T>;
template AXODE_ENTRY decltype(frame_geometry_jacobian<AXODE_T>) frame_geometry_jacobian<AXODE_T>;
template AXODE_ENTRY decltype(jacobian_geometry_derivatives<AXODE_T>) jacobian_geometry_derivatives<AXODE_T>;

}  // namespace axode
