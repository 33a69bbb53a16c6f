#include "axode/dynamics/terms.hpp"

#include "axode/dynamics/check_loads.hpp"
#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionChoice Rep, class T>
void coriolis_vector(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                     std::type_identity_t<std::span<T>> Cv) {
  check_state(model, workspace, q, v);
  check_size("Cv", Cv.size(), static_cast<std::size_t>(model.nv()), "nv");
  Arena arena = workspace.arena(model.topology());
  ForcesAlone<Rep, T>(arena).run(model.tree<T>(), q.data(), v.data(), nullptr, {}, {}, Cv.data());
}

template <RecursionChoice Rep, class T>
void gravity_torques(const Model& model, Workspace<T>& workspace, Numbers<T> q,
                     std::type_identity_t<std::span<T>> g) {
  check_state(model, workspace, q);
  check_size("g", g.size(), static_cast<std::size_t>(model.nv()), "nv");
  Arena arena = workspace.arena(model.topology());
  const Tree<T>& tree = model.tree<T>();
  ForcesAlone<Rep, T>(arena).run(tree, q.data(), nullptr, nullptr, {}, tree.g, g.data());
}

template <RecursionChoice Rep, class T>
void generalized_loads(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                       const std::type_identity_t<Loads<T>>& loads, std::type_identity_t<std::span<T>> Q) {
  check_state(model, workspace, q, v);
  check_loads(model, loads);
  check_size("Q", Q.size(), static_cast<std::size_t>(model.nv()), "nv");
  Arena arena = workspace.arena(model.topology());
  ForcesAlone<Rep, T>(arena).run(model.tree<T>(), q.data(), nullptr, v.data(), loads, {}, Q.data());
  for (T& x : Q) x = -x;
}

template void coriolis_vector<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                         Numbers<AXODE_T>, std::span<AXODE_T>);
template void gravity_torques<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                         std::span<AXODE_T>);
template void generalized_loads<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>,
                                           Numbers<AXODE_T>, const Loads<AXODE_T>&, std::span<AXODE_T>);

}  // namespace axode
