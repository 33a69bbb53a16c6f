#include "axode/dynamics/operational_space.hpp"

#include <algorithm>

#include "axode/dynamics/inverse_frame_inertia.hpp"
#include "axode/dynamics/mass_matrix/definite_inverse.hpp"
#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/kinematics/jacobian.hpp"
#include "axode/lie/six.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {
namespace {

/// Replaces the Jacobian J (nv columns) of a frame by the nv rows of M⁻¹ Jᵀ, where M is the mass matrix: for
/// each of the six rows of J as generalised forces, it computes the accelerations.
template <class Rep, class T>
Solvability respond(const Tree<T>& tree, FrameResponse<Rep, T>& at, const T* q, Twist<Rep, T>* columns) {
  const Solvability factorized = at.bodies.factorize(tree, q, tree.armature.data());
  Solvability verdict = factorized;
  for (int k = 0; k < 6; ++k) {
    for (int c = 0; c < tree->nv; ++c) at.x[c] = entry(columns[c], k);
    if (factorized.ok()) at.bodies.solve(tree, at.x);
    const Solvability row = solved(factorized, tree->nv, at.x);
    if (!row.ok()) verdict = row;
    for (int c = 0; c < tree->nv; ++c) entry(columns[c], k) = at.x[c];
  }
  return verdict;
}

}  // namespace

template <RecursionRepresentation Rep, class T>
Solvability impulse_response(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y) {
  Arena arena = checked<"impulse_response">(model, workspace, q, Y);
  jacobian<Rep>(model, workspace, q, place, Y);  // this call takes no memory of the workspace
  FrameResponse<Rep, T> at(arena);
  return respond(model.tree<T>(), at, q.data(), Y.data());
}

template <RecursionRepresentation Rep, class T>
Solvability inverse_operational_space_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                              const std::type_identity_t<Place<T>>& place,
                                              std::type_identity_t<std::span<T>> Lambda_inverse) {
  Arena arena = checked<"inverse_operational_space_inertia">(model, workspace, q, Lambda_inverse);
  const std::size_t nv = static_cast<std::size_t>(model.nv());
  FrameResponse<Rep, T> at(arena);
  const std::span<Twist<Rep, T>> J(at.J, nv), Y(at.Y, nv);
  jacobian<Rep>(model, workspace, q, place, J);  // this call takes no memory of the workspace
  std::copy(J.begin(), J.end(), Y.begin());
  const Solvability verdict = respond(model.tree<T>(), at, q.data(), Y.data());
  inverse_frame_inertia<Rep, T>(J, Y, Lambda_inverse.data());
  return solved(verdict, 36, Lambda_inverse.data());
}

template <RecursionRepresentation Rep, class T>
Solvability operational_space_inertia(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                      const std::type_identity_t<Place<T>>& place,
                                      std::type_identity_t<std::span<T>> Lambda) {
  checked<"operational_space_inertia">(model, workspace, q, Lambda);
  Solvability solvability = inverse_operational_space_inertia<Rep>(model, workspace, q, place, Lambda);
  const int directions = invert_definite(std::span<T, 36>(Lambda.data(), 36));
  if (solvability.ok()) solvability.directions = directions;
  return solvability;
}

template decltype(impulse_response<AXODE_REP, AXODE_T>) impulse_response<AXODE_REP, AXODE_T>;
template decltype(inverse_operational_space_inertia<AXODE_REP, AXODE_T>)
    inverse_operational_space_inertia<AXODE_REP, AXODE_T>;
template decltype(operational_space_inertia<AXODE_REP, AXODE_T>)
    operational_space_inertia<AXODE_REP, AXODE_T>;

}  // namespace axode
