#include "axode/dynamics/mass_matrix/mass_matrix.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/fast/composite_bodies.hpp"
#include "axode/fast/forward_dynamics.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/composite_bodies.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionChoice Rep, class T>
void mass_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                 std::type_identity_t<std::span<T>> M) {
  Arena arena = checked<"mass_matrix">(model, workspace, q, M);
  const Tree<T>& tree = model.tree<T>();
  if constexpr (std::same_as<Rep, Fast>) {
    if (!tree->coupled_bodies.empty()) return mass_matrix<Hybrid>(model, workspace, q, M);
    FastCompositeBodies<T> bodies(arena);
    bodies.run(tree, q.data());
    bodies.write(tree, M.data());
  } else {
    CompositeBodies<Rep, T>(arena).run(tree, q.data(), tree.armature.data(), M.data());
  }
}

template <RecursionChoice Rep, class T>
Solvability inverse_mass_matrix(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                                std::type_identity_t<std::span<T>> M_inverse) {
  Arena arena = checked<"inverse_mass_matrix">(model, workspace, q, M_inverse);
  const Tree<T>& tree = model.tree<T>();
  const std::size_t nv = static_cast<std::size_t>(tree->nv);
  Solvability verdict;
  if constexpr (std::same_as<Rep, Fast>) {
    if (!FastInverse<T>(arena).run(tree, q.data(), M_inverse.data()))
      return inverse_mass_matrix<Hybrid>(model, workspace, q, M_inverse);
  } else {
    ArticulatedBodies<Rep, T> bodies(arena);
    verdict = bodies.factorize(tree, q.data(), tree.armature.data());
    for (T& x : M_inverse) x = T(0);
    for (std::size_t c = 0; c < nv && verdict.ok(); ++c) {
      M_inverse[c * nv + c] = T(1);
      bodies.solve(tree, M_inverse.data() + c * nv);
    }
  }
  return solved(verdict, static_cast<std::ptrdiff_t>(nv * nv), M_inverse.data());
}

template AXODE_ENTRY decltype(mass_matrix<AXODE_REP, AXODE_T>) mass_matrix<AXODE_REP, AXODE_T>;
template AXODE_ENTRY decltype(inverse_mass_matrix<AXODE_REP, AXODE_T>)
    inverse_mass_matrix<AXODE_REP, AXODE_T>;

}  // namespace axode
