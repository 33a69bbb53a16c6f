#include "axode/dynamics/momentum/body_momenta.hpp"

#include "axode/dynamics/scratch.hpp"
#include "axode/kinematics/checked.hpp"
#include "axode/recursion/instantiate.hpp"

namespace axode {

template <RecursionRepresentation Rep, class T>
void body_momenta(const Model& model, Workspace<T>& workspace, Numbers<T> q, Numbers<T> v,
                  std::type_identity_t<std::span<Momentum<Rep, T>>> Pi) {
  Arena arena = checked<"body_momenta">(model, workspace, q, v, Pi);
  const Tree<T>& tree = model.tree<T>();
  PosesAndMotion<T> at(arena);
  auto& [C, motion] = at;
  motion.run(tree, q.data(), v.data(), v.data());
  C.run(tree, motion.joints.C_pi);
  for (int i = 1; i <= tree->n; ++i) {
    const SE3<T>& offset = tree.frame_offset[i];
    const Twist<BodyFixed, T> V = Link<BodyFixed, T>{offset}.down(motion.bodies.V[i]);
    Pi[i - 1] = change<Rep>(C[i] * offset, transform(inverse(offset), tree.M[i]) * V);
  }
}

template decltype(body_momenta<AXODE_REP, AXODE_T>) body_momenta<AXODE_REP, AXODE_T>;

}  // namespace axode
