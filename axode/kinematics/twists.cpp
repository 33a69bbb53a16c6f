#include "axode/kinematics/twists.hpp"

#include "axode/fast/motion.hpp"
#include "axode/kinematics/check_arguments.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionRepresentation Rep, class T>
void twists(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
            std::type_identity_t<std::span<Twist<Rep, T>>> V) {
  check_state(model, workspace, q, v);
  check_size("V", V.size(), static_cast<std::size_t>(model.n_frames()), "n_frames");
  Arena arena = workspace.arena(model.topology());
  FastMotionIn<Rep, T, false> motion(arena);
  motion.run(model.tree<T>(), q.data(), v.data());
  motion.template write<Rep>(model.tree<T>(), V.data());
}

template <RecursionRepresentation Rep, class T>
void accelerations(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<TwistRate<Rep, T>>> dV) {
  check_state(model, workspace, q, v, a);
  check_size("dV", dV.size(), static_cast<std::size_t>(model.n_frames()), "n_frames");
  Arena arena = workspace.arena(model.topology());
  FastMotionIn<Rep, T, true> motion(arena);
  motion.run(model.tree<T>(), q.data(), v.data(), a.data());
  motion.template write<Rep>(model.tree<T>(), dV.data());
}

template void twists<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                std::span<Twist<AXODE_REP, AXODE_T>>);
template void accelerations<AXODE_REP>(const Model&, Workspace<AXODE_T>&, Numbers<AXODE_T>, Numbers<AXODE_T>,
                                       Numbers<AXODE_T>, std::span<TwistRate<AXODE_REP, AXODE_T>>);

}  // namespace axode
