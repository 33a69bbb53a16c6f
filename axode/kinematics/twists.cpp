#include "axode/kinematics/twists.hpp"

#include "axode/fast/motion.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionRepresentation Rep, class T>
void twists(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
            std::type_identity_t<std::span<Twist<Rep, T>>> V) {
  Arena arena = checked<"twists">(model, workspace, q, v, V);
  FastMotionIn<Rep, T, false> motion(arena);
  motion.run(model.tree<T>(), q.data(), v.data());
  motion.template write<Rep>(model.tree<T>(), V.data());
}

template <RecursionRepresentation Rep, class T>
void accelerations(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v, Numbers<T> a,
                   std::type_identity_t<std::span<TwistRate<Rep, T>>> dV) {
  Arena arena = checked<"accelerations">(model, workspace, q, v, a, dV);
  FastMotionIn<Rep, T, true> motion(arena);
  motion.run(model.tree<T>(), q.data(), v.data(), a.data());
  motion.template write<Rep>(model.tree<T>(), dV.data());
}

template AXODE_ENTRY decltype(twists<AXODE_REP, AXODE_T>) twists<AXODE_REP, AXODE_T>;
template AXODE_ENTRY decltype(accelerations<AXODE_REP, AXODE_T>) accelerations<AXODE_REP, AXODE_T>;

}  // namespace axode
