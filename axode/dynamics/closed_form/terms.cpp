#include "axode/dynamics/closed_form/terms.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionChoice Rep, class T>
void coriolis_vector(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                     std::type_identity_t<std::span<T>> Cv) {
  Arena arena = checked<"coriolis_vector">(model, workspace, q, v, Cv);
  BiasForces<Rep, T>(arena).run(model.tree<T>(), q.data(), v.data(), nullptr, {}, {}, Cv.data());
}

template <RecursionChoice Rep, class T>
void gravity_torques(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                     std::type_identity_t<std::span<T>> g) {
  Arena arena = checked<"gravity_torques">(model, workspace, q, g);
  const Tree<T>& tree = model.tree<T>();
  BiasForces<Rep, T>(arena).run(tree, q.data(), nullptr, nullptr, {}, tree.g, g.data());
}

template <RecursionChoice Rep, class T>
void generalized_loads(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       const std::type_identity_t<Loads<T>>& loads, std::type_identity_t<std::span<T>> Q) {
  Arena arena = checked<"generalized_loads">(model, workspace, q, v, loads, Q);
  BiasForces<Rep, T>(arena).run(model.tree<T>(), q.data(), nullptr, v.data(), loads, {}, Q.data());
  for (T& x : Q) x = -x;
}

template AXODE_ENTRY decltype(coriolis_vector<AXODE_REP, AXODE_T>) coriolis_vector<AXODE_REP, AXODE_T>;
template AXODE_ENTRY decltype(gravity_torques<AXODE_REP, AXODE_T>) gravity_torques<AXODE_REP, AXODE_T>;
template AXODE_ENTRY decltype(generalized_loads<AXODE_REP, AXODE_T>) generalized_loads<AXODE_REP, AXODE_T>;

}  // namespace axode
