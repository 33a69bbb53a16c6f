#include "axode/constraints/constrained_operational_space.hpp"

#include <vector>

#include "axode/constraints/check_loops.hpp"
#include "axode/dynamics/inverse_frame_inertia.hpp"
#include "axode/dynamics/mass_matrix/definite_inverse.hpp"
#include "axode/kinematics/jacobian.hpp"
#include "axode/lie/six.hpp"
#include "axode/recursion/instantiate.hpp"
#include "axode/table/check_counts.hpp"

namespace axode {

template <RecursionRepresentation Rep, class T>
Solvability impulse_response(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                             const std::type_identity_t<Place<T>>& place,
                             std::type_identity_t<std::span<Twist<Rep, T>>> Y) {
  catalog::check_motions<"impulse_response">(model);
  LoopSystem<T>& system = checked(model, workspace, q);
  check_separate("Y", Y, "q", q);
  Workspace<T> tree(model);
  jacobian<Rep>(model, tree, q, place, Y);
  const Solvability factorized = system.factorize(q.data());
  Solvability verdict = factorized;
  std::vector<T> x(Y.size());
  for (int k = 0; k < 6; ++k) {
    for (std::size_t c = 0; c < x.size(); ++c) x[c] = entry(Y[c], k);
    if (factorized.ok()) system.force_response(x.data(), x.data());
    const Solvability row = solved(factorized, model.nv(), x.data());
    if (!row.ok()) verdict = row;
    for (std::size_t c = 0; c < x.size(); ++c) entry(Y[c], k) = x[c];
  }
  return verdict;
}

template <RecursionRepresentation Rep, class T>
Solvability inverse_operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                              const std::type_identity_t<Place<T>>& place,
                                              std::type_identity_t<std::span<T>> Lambda_inverse) {
  check_size("Lambda_inverse", Lambda_inverse.size(), 36, "6 * 6");
  std::vector<Twist<Rep, T>> J(static_cast<std::size_t>(model.nv())), Y(J.size());
  Workspace<T> tree(model);
  jacobian<Rep>(model, tree, q, place, J);
  const Solvability verdict = impulse_response<Rep>(model, workspace, q, place, Y);
  inverse_frame_inertia<Rep, T>(J, Y, Lambda_inverse.data());
  return solved(verdict, 36, Lambda_inverse.data());
}

template <RecursionRepresentation Rep, class T>
Solvability operational_space_inertia(const Model& model, LoopWorkspace<T>& workspace, Numbers<T> q,
                                      const std::type_identity_t<Place<T>>& place,
                                      std::type_identity_t<std::span<T>> Lambda) {
  check_size("Lambda", Lambda.size(), 36, "6 * 6");
  Solvability solvability = inverse_operational_space_inertia<Rep>(model, workspace, q, place, Lambda);
  const int directions = invert_definite(std::span<T, 36>(Lambda.data(), 36));
  if (solvability.ok()) solvability.directions = directions;
  return solvability;
}

template Solvability impulse_response<AXODE_REP>(const Model&, LoopWorkspace<AXODE_T>&, Numbers<AXODE_T>,
                                                 const Place<AXODE_T>&, std::span<Twist<AXODE_REP, AXODE_T>>);
template Solvability inverse_operational_space_inertia<AXODE_REP>(const Model&, LoopWorkspace<AXODE_T>&,
                                                                  Numbers<AXODE_T>, const Place<AXODE_T>&,
                                                                  std::span<AXODE_T>);
template Solvability operational_space_inertia<AXODE_REP>(const Model&, LoopWorkspace<AXODE_T>&,
                                                          Numbers<AXODE_T>, const Place<AXODE_T>&,
                                                          std::span<AXODE_T>);

}  // namespace axode
