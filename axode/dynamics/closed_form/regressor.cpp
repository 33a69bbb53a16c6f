#include "axode/dynamics/closed_form/regressor.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/kinematics/path.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// The inertia of a body of which inertial parameter k is 1 and the others are 0, in the order of mass, first
/// moment (x y z) and rotational inertia (xx yy zz xy xz yz).
template <class T> Inertia<T> unit_inertia(int k) {
  const auto is = [&](int j) { return T(k == j); };
  return {is(0), {is(1), is(2), is(3)}, {is(4), is(5), is(6), is(7), is(8), is(9)}};
}

/// Calls f(i, V, V') for every body i. V is the body-fixed twist, and V' the body-fixed twist rate, of the
/// frame that the description of the mechanism gives to the body. `at` has the motion of the joint frames,
/// from which V and V' are converted; if it was computed with the acceleration -g of the ground, V' includes
/// gravity.
template <class T, class F> void each_body(const Tree<T>& tree, const PosesAndMotion<T>& at, F&& f) {
  for (int i = 1; i <= tree->n; ++i) {
    const Link<BodyFixed, T> user{tree.frame_offset[i]};
    f(i, user.down(at.motion.bodies.V[i]), user.down(at.motion.bodies.dV[i]));
  }
}

}  // namespace

template <class T>
void regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
               std::type_identity_t<std::span<T>> Y) {
  Arena arena = checked<"regressor">(model, workspace, q, v, a, Y);
  const Tree<T>& tree = model.tree<T>();
  const std::size_t width = 10 * static_cast<std::size_t>(tree->n);
  PosesAndMotion<T> at(arena);
  at.motion.run(tree, q.data(), v.data(), a.data(), -tree.g);
  at.C.run(tree, at.motion.joints.C_pi);
  for (T& y : Y) y = T(0);
  each_body(tree, at, [&](int i, const auto& V, const auto& dV) {
    std::array<Wrench<BodyFixed, T>, 10> W;
    for (int k = 0; k < 10; ++k) W[static_cast<std::size_t>(k)] = newton_euler(unit_inertia<T>(k), V, dV);
    const SE3<T> from_user = inverse(at.C[i] * tree.frame_offset[i]);
    for (int j = i; j > 0; j = tree->parent[j])
      each_screw(tree, j, from_user * at.C[j], [&](int c, const Screw<T>& X) {
        T* y = &Y[static_cast<std::size_t>(c) * width + 10 * static_cast<std::size_t>(i - 1)];
        for (std::size_t k = 0; k < 10; ++k) y[k] += W[k] | twist<BodyFixed>(X);
      });
  });
}

template <class T>
void kinetic_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                              std::type_identity_t<std::span<T>> y) {
  Arena arena = checked<"kinetic_energy_regressor">(model, workspace, q, v, y);
  const Tree<T>& tree = model.tree<T>();
  PosesAndMotion<T> at(arena);
  at.motion.run(tree, q.data(), v.data(), v.data());
  each_body(tree, at, [&](int i, const auto& V, const auto&) {
    for (int k = 0; k < 10; ++k)
      y[static_cast<std::size_t>(10 * (i - 1) + k)] = T(0.5) * ((unit_inertia<T>(k) * V) | V);
  });
}

template <class T>
void potential_energy_regressor(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> y) {
  Arena arena = checked<"potential_energy_regressor">(model, workspace, q, y);
  const Tree<T>& tree = model.tree<T>();
  const BodyPoses<T> C(arena, tree, q.data());
  for (int i = 1; i <= tree->n; ++i) {
    const SE3<T> C_user = C[i] * tree.frame_offset[i];
    const Vec3<T> g = transpose(C_user.R) * tree.g;
    const std::array<T, 10> own{-dot(tree.g, C_user.r), -g.x, -g.y, -g.z};
    for (std::size_t k = 0; k < 10; ++k) y[10 * static_cast<std::size_t>(i - 1) + k] = own[k];
  }
}

template AXODE_ENTRY decltype(regressor<AXODE_T>) regressor<AXODE_T>;
template AXODE_ENTRY decltype(kinetic_energy_regressor<AXODE_T>) kinetic_energy_regressor<AXODE_T>;
template AXODE_ENTRY decltype(potential_energy_regressor<AXODE_T>) potential_energy_regressor<AXODE_T>;

}  // namespace axode
